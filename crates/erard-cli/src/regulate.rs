//! What `regulate` is asked and answers: values with units, the table, and the report.

use std::fmt;
use std::time::Duration;

use erard_workshop::distances::Distances;
use erard_workshop::regulate::{Goal, Handwork, Kind, Regulated, Turned, known_screw, screw_unit, turns_text, unit};
use serde::Serialize;

use crate::units::Lengths;

/// A value as the reader's ruler shows it, to a hundredth of a millimetre.
pub(crate) fn shown_value(goal: Goal, value: f64, lengths: Lengths) -> String {
    match goal.kind() {
        Kind::Length => lengths.text(value * 1e3, 2),
        Kind::Speed | Kind::Share => {
            let (factor, unit) = unit(goal.kind());
            format!("{:.2} {unit}", value * factor)
        }
    }
}

/// How far a screw was turned and which way; where it has a thread, in turns, too.
pub(crate) fn turned_text(turned: &Turned, lengths: Lengths) -> String {
    let by = turned.setting[1] - turned.setting[0];
    let far = match screw_unit(&turned.action) {
        (factor, "mm") => lengths.signed(by * factor, 3),
        (factor, unit) => format!("{:+.3} {unit}", by * factor),
    };
    let turns = match known_screw(&turned.name).map(|known| known.work) {
        Some(Handwork::Thread(pitch_m)) => format!(", {}", turns_text(by / pitch_m)),
        _ => String::new(),
    };
    format!("{} {far} ({}{turns})", turned.name, turned.way)
}

/// Distances that are shown though nobody asked for them.
fn others(distances: &Distances) -> [(&'static str, Option<f64>); 2] {
    [("lost motion", distances.lost_motion_m), ("aftertouch", distances.aftertouch_m)]
}

/// The table.
pub(crate) struct Shown<'r>(pub &'r Regulated, pub Lengths);

impl fmt::Display for Shown<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "  goal             asked        before       after        screw              turned by")?;
        let number = |goal: Goal, value: Option<f64>| value.map_or("-".to_owned(), |v| shown_value(goal, v, self.1));
        for achieved in &self.0.achieved {
            let goal = achieved.goal;
            let start = format!(
                "  {:<15}  {:<11}  {:<11}  {:<11}",
                goal.name(),
                number(goal, Some(achieved.target)),
                number(goal, achieved.before),
                number(goal, achieved.after)
            );
            let mut screws = self.0.screws_of(goal).peekable();
            if screws.peek().is_none() {
                writeln!(f, "{start}  -")?;
            }
            for (n, turned) in screws.enumerate() {
                let start = if n == 0 { start.clone() } else { " ".repeat(start.chars().count()) };
                let text = turned_text(turned, self.1);
                let rest = text.strip_prefix(turned.name.as_str()).unwrap_or(&text);
                writeln!(f, "{start}  {:<17} {rest}", turned.name)?;
            }
        }
        let asked = |goal| self.0.achieved.iter().any(|a| a.goal == goal);
        let (before, after) = (&self.0.before, &self.0.after);
        let goals = Goal::ALL.into_iter().filter(|goal| !asked(*goal));
        let goals = goals.map(|goal| (goal.name(), goal, goal.of(before), goal.of(after)));
        let others = others(before).into_iter().zip(others(after));
        // They are lengths, as the blow is.
        let others = others.map(|((name, before), (_, after))| (name, Goal::Blow, before, after));
        for (name, goal, before, after) in goals.chain(others) {
            writeln!(f, "  {name:<15}  {:<11}  {:<11}  {}", "-", number(goal, before), number(goal, after))?;
        }
        Ok(())
    }
}

/// The report beside the new instrument file.
#[derive(Debug, Serialize)]
pub(crate) struct Report {
    input: String,
    output: String,
    elapsed_s: f64,
    double_strike_m_s: BeforeAndAfter,
    #[serde(flatten)]
    regulated: erard_workshop::regulate::Report,
}

/// The second blow of a soft note, m/s.
#[derive(Debug, Serialize)]
struct BeforeAndAfter {
    before: f64,
    after: f64,
}

impl Report {
    /// Of a regulated action that was read from `input` and is written to `output`, which took so long. `double_strike_m_s` is the second blow of a
    /// soft note before and after, m/s.
    pub(crate) fn new(
        regulated: &Regulated,
        double_strike_m_s: [f64; 2],
        input: &str,
        output: &str,
        elapsed: Duration,
    ) -> Self {
        let [before, after] = double_strike_m_s;
        Report {
            double_strike_m_s: BeforeAndAfter { before, after },
            input: input.into(),
            output: output.into(),
            elapsed_s: elapsed.as_secs_f64(),
            regulated: regulated.report(),
        }
    }

    /// A line for every goal that is not met.
    pub(crate) fn misses(&self) -> Vec<String> {
        let missed = self.regulated.goals.iter().filter(|goal| !goal.met);
        missed
            .map(|goal| {
                let nearest = goal.after.map_or("it does not happen".to_owned(), |after| {
                    format!("the nearest is {:.2} {}", after, goal.unit)
                });
                let why = goal.why_not.as_deref().unwrap_or_default();
                format!("{} {} {} is not met: {nearest} ({why})", goal.goal, goal.asked, goal.unit)
            })
            .collect()
    }
}

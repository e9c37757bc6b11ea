//! What `regulate` is asked and answers: values with units, the table, and the report.

use std::fmt;
use std::io::Write;
use std::time::Duration;

use erard_workshop::distances::Distances;
use erard_workshop::regulate::{
    Achieved, Goal, Handwork, Kind, Miss, Regulated, Turned, known_screw, screw_unit, turns_text, unit,
};
use serde::Serialize;

use crate::units::Lengths;

/// A value as the reader's ruler shows it, to a hundredth of a millimetre.
pub fn shown_value(goal: Goal, value: f64, lengths: Lengths) -> String {
    match goal.kind() {
        Kind::Length => lengths.text(value * 1e3, 2),
        Kind::Speed | Kind::Share => {
            let (factor, unit) = unit(goal.kind());
            format!("{:.2} {unit}", value * factor)
        }
    }
}

/// How far a screw was turned and which way; where it has a thread, in turns, too.
pub fn turned_text(turned: &Turned, lengths: Lengths) -> String {
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

/// The screws that were turned for a goal, as far as one alone is turned for it.
pub(crate) fn screws_of(regulated: &Regulated, goal: Goal) -> impl Iterator<Item = &Turned> {
    // A screw that could serve two goals served the first of them that was asked for.
    let asked = move |name: &str| {
        regulated.achieved.iter().map(|a| a.goal).find(|g| g.screws().iter().any(|(n, _)| *n == name))
    };
    regulated.turned.iter().filter(move |turned| asked(&turned.name) == Some(goal))
}

fn reason(achieved: &Achieved) -> Option<String> {
    Some(match achieved.miss.as_ref()? {
        Miss::EndOfRange(screws) => format!("at the end of its range: {}", screws.join(", ")),
        Miss::NoSetting(screws) => format!("no setting of {} gives it", screws.join(" or ")),
        Miss::Disturbed => "it cannot be met together with the other goals".into(),
    })
}

/// Distances that are shown though nobody asked for them.
fn others(distances: &Distances) -> [(&'static str, Option<f64>); 2] {
    [("lost motion", distances.lost_motion_m), ("aftertouch", distances.aftertouch_m)]
}

/// The table.
pub struct Shown<'r>(pub &'r Regulated, pub Lengths);

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
            let mut screws = screws_of(self.0, goal).peekable();
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
pub struct Report {
    instrument: String,
    input: String,
    output: String,
    rounds: u32,
    simulations: u32,
    elapsed_s: f64,
    unconverged_steps: u64,
    all_met: bool,
    goals: Vec<GoalReport>,
    screws: Vec<ScrewReport>,
    before: Vec<DistanceReport>,
    after: Vec<DistanceReport>,
}

#[derive(Debug, Serialize)]
struct GoalReport {
    goal: &'static str,
    unit: &'static str,
    asked: f64,
    before: Option<f64>,
    after: Option<f64>,
    met: bool,
    why_not: Option<String>,
    screws: Vec<String>,
}

#[derive(Debug, Serialize)]
struct ScrewReport {
    screw: String,
    unit: &'static str,
    from: f64,
    to: f64,
    turned_by: f64,
    /// In turns of its thread (estimated); `null` where it has none.
    turns: Option<f64>,
    way: &'static str,
}

#[derive(Debug, Serialize)]
struct DistanceReport {
    name: &'static str,
    unit: &'static str,
    value: Option<f64>,
}

impl Report {
    /// Of a regulated action that was read from `input` and is written to `output`, which took so long.
    pub fn new(regulated: &Regulated, input: &str, output: &str, elapsed: Duration) -> Self {
        let goals = regulated.achieved.iter().map(|a| {
            let (factor, unit) = unit(a.goal.kind());
            GoalReport {
                goal: a.goal.name(),
                unit,
                asked: a.target * factor,
                before: a.before.map(|v| v * factor),
                after: a.after.map(|v| v * factor),
                met: a.miss.is_none(),
                why_not: reason(a),
                screws: screws_of(regulated, a.goal).map(|turned| turned.name.clone()).collect(),
            }
        });
        let screws = regulated.turned.iter().map(|turned| {
            let (factor, unit) = screw_unit(&turned.action);
            let [from, to] = turned.setting.map(|s| (s * factor * 1e6).round() / 1e6);
            let turned_by = ((to - from) * 1e6).round() / 1e6;
            let turns = match known_screw(&turned.name).map(|known| known.work) {
                Some(Handwork::Thread(pitch_m)) => Some(turned_by / factor / pitch_m),
                _ => None,
            };
            ScrewReport { screw: turned.name.clone(), unit, from, to, turned_by, turns, way: turned.way }
        });
        Report {
            instrument: regulated.instrument.name.clone(),
            input: input.into(),
            output: output.into(),
            rounds: regulated.rounds,
            simulations: regulated.simulations,
            elapsed_s: elapsed.as_secs_f64(),
            unconverged_steps: regulated.after.unconverged_steps,
            all_met: regulated.all_met(),
            goals: goals.collect(),
            screws: screws.collect(),
            before: distances(&regulated.before),
            after: distances(&regulated.after),
        }
    }

    /// A line for every goal that is not met.
    pub fn misses(&self) -> Vec<String> {
        let missed = self.goals.iter().filter(|goal| !goal.met);
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

    /// Writes the JSON.
    ///
    /// # Errors
    /// Of the writer.
    pub fn write_json(&self, writer: &mut dyn Write) -> std::io::Result<()> {
        serde_json::to_writer_pretty(&mut *writer, self)?;
        writer.write_all(b"\n")
    }
}

fn distances(distances: &Distances) -> Vec<DistanceReport> {
    let goals = Goal::ALL.into_iter().map(|goal| {
        let (factor, unit) = unit(goal.kind());
        DistanceReport { name: goal.name(), unit, value: goal.of(distances).map(|v| v * factor) }
    });
    let others = others(distances).into_iter();
    goals
        .chain(others.map(|(name, value)| DistanceReport { name, unit: "mm", value: value.map(|v| v * 1e3) }))
        .collect()
}

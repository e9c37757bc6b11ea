//! Report of a regulation, in display units: for a file, a page, a notebook.

use erard::instrument::RewriteError;
use serde_json::{Value, json};

use super::{Achieved, Goal, Handwork, Miss, Regulated, Turned, known_screw, show, turns_text, unit};
use crate::distances::Distances;

impl Regulated {
    /// Returns the report.
    #[must_use]
    pub fn report(&self) -> Value {
        let goals = self.achieved.iter().map(|a| {
            let (factor, unit) = unit(a.goal);
            json!({
                "goal": a.goal.name(),
                "unit": unit,
                "asked": a.target * factor,
                "before": a.before.map(|v| v * factor),
                "after": a.after.map(|v| v * factor),
                "met": a.miss.is_none(),
                "why_not": a.reason(),
                "screws": self.screws_of(a.goal).map(|turned| turned.name.as_str()).collect::<Value>(),
            })
        });
        let screws = self.turned.iter().map(|turned| {
            let (factor, unit) = turned.action.shown_unit();
            // To a millionth of the unit, as in the file.
            let [from, to] = turned.setting.map(|s| (s * factor * 1e6).round() / 1e6);
            let by = ((to - from) * 1e6).round() / 1e6;
            let turns = match known_screw(&turned.name).map(|known| known.work) {
                Some(Handwork::Thread(pitch_m)) => Some(by / factor / pitch_m),
                _ => None,
            };
            json!({
                "screw": turned.name,
                "unit": unit,
                "from": from,
                "to": to,
                "turned_by": by,
                "turns": turns,
                "turns_text": turns.map(turns_text),
                "way": turned.way,
            })
        });
        json!({
            "instrument": self.instrument.name,
            "rounds": self.rounds,
            "simulations": self.simulations,
            "unconverged_steps": self.after.unconverged_steps,
            "all_met": self.all_met(),
            "goals": goals.collect::<Value>(),
            "screws": screws.collect::<Value>(),
            "before": distances(&self.before),
            "after": distances(&self.after),
        })
    }

    /// Screws turned for a goal.
    pub fn screws_of(&self, goal: Goal) -> impl Iterator<Item = &Turned> {
        // A screw of two goals served the first of them that was requested.
        let asked =
            |name: &str| self.achieved.iter().map(|a| a.goal).find(|g| g.screws().any(|(screw, _)| screw.name == name));
        self.turned.iter().filter(move |turned| asked(&turned.name) == Some(goal))
    }

    /// Returns `text`, the file that was regulated, with the new settings of its screws, each cited as regulated in
    /// simulation.
    ///
    /// # Errors
    /// See [`RewriteError`].
    pub fn rewrite(&self, text: &str) -> Result<String, RewriteError> {
        let goals: Vec<String> =
            self.achieved.iter().map(|a| format!("{} {}", a.goal.name(), show(a.goal, a.target))).collect();
        let title = format!(
            "Regulated in simulation ({} trials) for {}{}",
            self.simulations,
            goals.join(", "),
            if self.all_met() { "" } else { "; not all of it could be met" }
        );
        self.instrument.rewrite(text, &title, "turned until the simulated action met its goals")
    }
}

impl Achieved {
    /// Reason why the goal was missed.
    #[must_use]
    pub fn reason(&self) -> Option<String> {
        Some(match self.miss.as_ref()? {
            Miss::EndOfRange(screws) => format!("at the end of its range: {}", screws.join(", ")),
            Miss::NoSetting(screws) => format!("no setting of {} gives it", screws.join(" or ")),
            Miss::Disturbed => "it cannot be met together with the other goals".into(),
        })
    }
}

fn distances(distances: &Distances) -> Value {
    let one = |name: &str, unit: &str, value: Option<f64>| json!({"name": name, "unit": unit, "value": value});
    let goals = Goal::ALL.into_iter().map(|goal| {
        let (factor, unit) = unit(goal);
        one(goal.name(), unit, goal.of(distances).map(|v| v * factor))
    });
    let others = [("lost motion", distances.lost_motion_m), ("aftertouch", distances.aftertouch_m)];
    goals.chain(others.map(|(name, value)| one(name, "mm", value.map(|v| v * 1e3)))).collect()
}

//! What became of a regulation, in the units that people use: for a file, a page, a notebook.

use erard::instrument::RewriteError;
use serde::Serialize;

use super::{Achieved, Goal, Handwork, Miss, Regulated, Turned, known_screw, screw_unit, show, unit};
use crate::distances::Distances;

/// The report of a regulation: every value in the unit beside it.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Name of the instrument.
    pub instrument: String,
    /// Rounds of work.
    pub rounds: u32,
    /// Simulated trials.
    pub simulations: u32,
    /// Steps of the last measurement that reached an iteration limit.
    pub unconverged_steps: u64,
    /// Whether every goal is met.
    pub all_met: bool,
    /// The goals, in the order of work.
    pub goals: Vec<GoalReport>,
    /// The screws that were turned.
    pub screws: Vec<ScrewReport>,
    /// All distances before.
    pub before: Vec<DistanceReport>,
    /// And after.
    pub after: Vec<DistanceReport>,
}

/// What became of a goal; `None` (JSON `null`) is what does not happen.
#[derive(Debug, Clone, Serialize)]
pub struct GoalReport {
    /// Its name, e.g. `let-off`.
    pub goal: &'static str,
    /// mm, mm/s or %.
    pub unit: &'static str,
    /// What was asked for.
    pub asked: f64,
    /// What was there before.
    pub before: Option<f64>,
    /// What is there now.
    pub after: Option<f64>,
    /// Whether that is near enough.
    pub met: bool,
    /// Why it is not.
    pub why_not: Option<String>,
    /// The screws that were turned for it.
    pub screws: Vec<String>,
}

/// A screw that was turned.
#[derive(Debug, Clone, Serialize)]
pub struct ScrewReport {
    /// Its name.
    pub screw: String,
    /// mm, degrees or N mm.
    pub unit: &'static str,
    /// Its setting before.
    pub from: f64,
    /// And after.
    pub to: f64,
    /// The difference.
    pub turned_by: f64,
    /// In turns of its thread (estimated); `None` where it has none.
    pub turns: Option<f64>,
    /// Which way, in a word or two.
    pub way: &'static str,
}

/// A distance.
#[derive(Debug, Clone, Serialize)]
pub struct DistanceReport {
    /// Its name.
    pub name: &'static str,
    /// mm, mm/s or %.
    pub unit: &'static str,
    /// `None` where it does not happen.
    pub value: Option<f64>,
}

impl Regulated {
    /// The report.
    #[must_use]
    pub fn report(&self) -> Report {
        let goals = self.achieved.iter().map(|a| {
            let (factor, unit) = unit(a.goal.kind());
            GoalReport {
                goal: a.goal.name(),
                unit,
                asked: a.target * factor,
                before: a.before.map(|v| v * factor),
                after: a.after.map(|v| v * factor),
                met: a.miss.is_none(),
                why_not: reason(a),
                screws: self.screws_of(a.goal).map(|turned| turned.name.clone()).collect(),
            }
        });
        let screws = self.turned.iter().map(|turned| {
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
            instrument: self.instrument.name.clone(),
            rounds: self.rounds,
            simulations: self.simulations,
            unconverged_steps: self.after.unconverged_steps,
            all_met: self.all_met(),
            goals: goals.collect(),
            screws: screws.collect(),
            before: distances(&self.before),
            after: distances(&self.after),
        }
    }

    /// The screws that were turned for a goal, as far as one alone is turned for it.
    pub fn screws_of(&self, goal: Goal) -> impl Iterator<Item = &Turned> {
        // A screw that could serve two goals served the first of them that was asked for.
        let asked =
            |name: &str| self.achieved.iter().map(|a| a.goal).find(|g| g.screws().iter().any(|(n, _)| *n == name));
        self.turned.iter().filter(move |turned| asked(&turned.name) == Some(goal))
    }

    /// `text`, the file that was regulated, with the settings that its screws have now, each cited as regulated in simulation.
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

fn reason(achieved: &Achieved) -> Option<String> {
    Some(match achieved.miss.as_ref()? {
        Miss::EndOfRange(screws) => format!("at the end of its range: {}", screws.join(", ")),
        Miss::NoSetting(screws) => format!("no setting of {} gives it", screws.join(" or ")),
        Miss::Disturbed => "it cannot be met together with the other goals".into(),
    })
}

fn distances(distances: &Distances) -> Vec<DistanceReport> {
    let goals = Goal::ALL.into_iter().map(|goal| {
        let (factor, unit) = unit(goal.kind());
        DistanceReport { name: goal.name(), unit, value: goal.of(distances).map(|v| v * factor) }
    });
    let others = [("lost motion", distances.lost_motion_m), ("aftertouch", distances.aftertouch_m)].into_iter();
    let others = others.map(|(name, value)| DistanceReport { name, unit: "mm", value: value.map(|v| v * 1e3) });
    goals.chain(others).collect()
}

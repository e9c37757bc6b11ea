//! Arguments and results of `regulate`: values with units, the table, and the report.

use std::fmt;

use erard::parameter::Quantity;
use erard_workshop::digits::{rounds_to_zero, signed};
use erard_workshop::distances::Distances;
use erard_workshop::regulate::{Achieved, Goal, Handwork, Regulated, Turned, known_screw, turns_text, unit};
use erard_workshop::worklist::{GaveUp, Settled, usual_aftertouch_m};
use serde_json::{Value, json};

use crate::table::Table;
use crate::units::Lengths;

/// A value as the reader's ruler shows it, to a hundredth of a millimetre.
pub(crate) fn shown_value(goal: Goal, value: f64, lengths: Lengths) -> String {
    if goal.quantity() == Quantity::Length {
        return lengths.text(value * 1e3, 2);
    }
    let (factor, unit) = unit(goal);
    format!("{:.2} {unit}", value * factor)
}

/// How far a screw was turned and which way; where it has a thread, in turns, too.
pub(crate) fn turned_text(turned: &Turned, lengths: Lengths) -> String {
    let by = turned.setting[1] - turned.setting[0];
    let far = match turned.action.shown_unit() {
        (factor, "mm") => lengths.signed(by * factor, 3),
        (factor, unit) => format!("{} {unit}", signed(by * factor, 3)),
    };
    if rounds_to_zero(&far) {
        return format!("{} not turned", turned.name);
    }
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
        let number = |goal: Goal, value: Option<f64>| value.map_or("-".to_owned(), |v| shown_value(goal, v, self.1));
        let mut rows = Vec::new();
        for achieved in &self.0.achieved {
            let goal = achieved.goal;
            let mut start = vec![
                goal.name().to_owned(),
                number(goal, Some(achieved.target)),
                number(goal, achieved.before),
                number(goal, achieved.after),
            ];
            let mut screws = self.0.screws_of(goal).peekable();
            if screws.peek().is_none() {
                rows.push([start.clone(), vec!["-".to_owned(), String::new()]].concat());
            }
            for turned in screws {
                let text = turned_text(turned, self.1);
                let rest = text.strip_prefix(turned.name.as_str()).unwrap_or(&text).trim_start();
                let start = std::mem::replace(&mut start, vec![String::new(); 4]);
                rows.push([start, vec![turned.name.clone(), rest.to_owned()]].concat());
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
            let cells = ["-".to_owned(), number(goal, before), number(goal, after), String::new(), String::new()];
            rows.push([vec![name.to_owned()], cells.to_vec()].concat());
        }
        Table::of(["goal", "asked", "before", "after", "screw", "turned by"], rows).fmt(f)
    }
}

/// The report: what the workshop reports, and what of it a command knows.
pub(crate) fn report(regulated: &Regulated, double_strike_m_per_s: [f64; 2], input: &str, output: &str) -> Value {
    let [before, after] = double_strike_m_per_s;
    let mut report = json!({
        "input": input,
        "output": output,
        "double_strike_m_per_s": {"before": before, "after": after},
    });
    if let (Value::Object(own), Value::Object(more)) = (&mut report, regulated.report()) {
        own.extend(more);
    }
    report
}

/// What changed for the aftertouch, a line each, and an empty one.
pub(crate) fn settled_text(settled: &Settled, lengths: Lengths) -> Vec<String> {
    let line = |gave_up: &GaveUp| {
        let [asked, instead] = [gave_up.asked_m, gave_up.instead_m].map(|m| shown_value(gave_up.goal, m, lengths));
        format!("{} changed for the aftertouch: {instead} instead of {asked}.", gave_up.goal.name())
    };
    let mut lines: Vec<String> = settled.gave_up.iter().map(line).collect();
    if !lines.is_empty() {
        lines.push(String::new());
    }
    lines
}

/// Where the aftertouch is out of its usual range: that it is.
pub(crate) fn aftertouch_text(regulated: &Regulated, lengths: Lengths) -> String {
    let [low, high] = usual_aftertouch_m(&regulated.instrument).map(|m| lengths.text(m * 1e3, 1));
    match regulated.after.aftertouch_m {
        Some(m) => {
            format!("aftertouch {} is out of its usual range, {low} to {high}", lengths.text(m * 1e3, 1))
        }
        None => format!("there is no aftertouch; {low} to {high} is usual"),
    }
}

/// What changed for the aftertouch, in the report.
pub(crate) fn aftertouch_report(settled: &Settled) -> Value {
    let gave_up = settled.gave_up.iter().map(|gave_up| {
        json!({"goal": gave_up.goal.name(), "unit": "mm", "asked": gave_up.asked_m * 1e3, "instead": gave_up.instead_m * 1e3})
    });
    json!({
        "mm": settled.regulated.after.aftertouch_m.map(|m| m * 1e3),
        "usual_mm": usual_aftertouch_m(&settled.regulated.instrument).map(|m| m * 1e3),
        "met": settled.is_settled,
        "gave_up": gave_up.collect::<Value>(),
    })
}

/// What could not be met, a line each.
pub(crate) fn misses(regulated: &Regulated) -> Vec<String> {
    let missed = regulated.achieved.iter().filter(|achieved| achieved.miss.is_some());
    let line = |missed: &Achieved| {
        let (factor, unit) = unit(missed.goal);
        let nearest = missed
            .after
            .map_or("it does not happen".to_owned(), |after| format!("the nearest is {:.2} {unit}", after * factor));
        let (goal, asked, why) = (missed.goal.name(), missed.target * factor, missed.reason().unwrap_or_default());
        format!("{goal} {asked} {unit} is not met: {nearest} ({why})")
    };
    missed.map(line).collect()
}

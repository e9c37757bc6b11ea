//! Numbers of cases: printed, and as `summary.json`.

use std::fmt;

use erard_kinematics::{Agreement, Derived, Design, Spot};
use serde_json::{Value, json};

use super::shown::Shown;
use crate::table::Table;

/// Numbers of a design and its cases.
#[derive(Debug, Clone)]
pub(crate) struct Summary {
    /// `summary.json`; null if unknown or if the event did not happen.
    pub json: Value,
    /// Display names of the cases.
    labels: Vec<String>,
}

type Number = (&'static str, &'static str, fn(f64) -> String);

/// Printed rows: label, path in a case's numbers, and format.
const ROWS: [Number; 16] = [
    ("leverage at rest", "/leverage/start/leverage", ratio),
    ("  half-way to let-off", "/leverage/middle/leverage", ratio),
    ("  at let-off", "/leverage/let_off/leverage", ratio),
    ("key at let-off", "/leverage/let_off/key_mm", fine),
    ("capstan sliding, at most", "/capstan_sliding_mm", fine),
    ("  whole way", "/capstan_way_mm", fine),
    ("knuckle sliding, at most", "/knuckle_sliding_mm", fine),
    ("  whole way", "/knuckle_way_mm", fine),
    ("lever arms: key, front", "/lever_arms_mm/key_front", coarse),
    ("  key, capstan", "/lever_arms_mm/key_back", coarse),
    ("  whippen, heel", "/lever_arms_mm/whippen_heel", coarse),
    ("  whippen, jack", "/lever_arms_mm/whippen_jack", coarse),
    ("  hammer, knuckle", "/lever_arms_mm/hammer_knuckle", coarse),
    ("  hammer, head", "/lever_arms_mm/hammer_head", coarse),
    ("  product of the three ratios", "/lever_arm_product", ratio),
    ("largest residual", "/largest_residual", |x| format!("{x:.1e}")),
];

fn ratio(x: f64) -> String {
    format!("{x:.3}")
}

fn fine(mm: f64) -> String {
    format!("{mm:.2} mm")
}

fn coarse(mm: f64) -> String {
    format!("{mm:.1} mm")
}

/// Numbers of a case, lengths in mm: sliding between rest and let-off, largest and to and fro; the six classical lever
/// arms at rest; the largest residual of the closure equations over the largest length, of all poses.
fn case(shown: &Shown) -> Value {
    let (digest, arms) = (&shown.digest, &shown.digest.arms);
    // Sliding is defined up to let-off only.
    let mm = |metres: f64| digest.let_off.map(|_| metres * 1e3);
    let at = |spot: Spot| json!({"key_mm": spot.key_m * 1e3, "leverage": spot.leverage});
    json!({
        "case": shown.name,
        "leverage": {
            "start": at(digest.start),
            "middle": digest.middle.map(at),
            "let_off": digest.let_off.map(at),
        },
        "capstan_sliding_mm": mm(digest.capstan_sliding_m),
        "capstan_way_mm": mm(digest.capstan_way_m),
        "knuckle_sliding_mm": mm(digest.knuckle_sliding_m),
        "knuckle_way_mm": mm(digest.knuckle_way_m),
        "lever_arms_mm": {
            "key_front": arms.key_front * 1e3,
            "key_back": arms.key_back * 1e3,
            "whippen_heel": arms.whippen_heel * 1e3,
            "whippen_jack": arms.whippen_jack * 1e3,
            "hammer_knuckle": arms.hammer_knuckle * 1e3,
            "hammer_head": arms.hammer_head * 1e3,
        },
        "lever_arm_product": arms.product(),
        "largest_residual": shown.stroke.poses.iter().map(|pose| pose.residual).fold(0.0, f64::max),
        "stopped_at_key_mm": shown.stroke.stop.as_ref().map(|stop| stop.key * 1e3),
    })
}

impl Summary {
    /// Makes the summary of a design and its cases; `derived` and `dynamics` are an instrument's.
    pub(crate) fn new(
        design: &Design,
        regulated: bool,
        cases: &[Shown],
        derived: Option<&Derived>,
        dynamics: Option<&Agreement>,
    ) -> Self {
        let mm = |key: Option<&f64>| key.copied().unwrap_or(0.0) * 1e3;
        let dynamics = dynamics.map(|agreement| {
            json!({
                "largest_deviation": agreement.worst,
                "from_key_mm": mm(agreement.key_m.first()),
                "to_key_mm": mm(agreement.key_m.last()),
            })
        });
        let json = json!({
            "name": design.name,
            "kind": if derived.is_some() { "instrument" } else { "linkage" },
            "regulated": regulated,
            "let_off_is": design.let_off.as_ref().map(|let_off| let_off.what.as_str()),
            "cases": cases.iter().map(case).collect::<Value>(),
            "lengths_mm": derived.map(|derived| derived.lengths.lengths.to_array().map(|length| length * 1e3)),
            "contacts": derived.map(|derived| [&derived.capstan_zone, &derived.knuckle_zone]),
            "dynamics": dynamics,
            "notes": derived.map_or(&[][..], |derived| &derived.notes),
        });
        Summary { json, labels: cases.iter().map(|case| case.label.clone()).collect() }
    }
}

/// The rows that are printed first.
const FIRST: [Number; 4] = [
    ("leverage at rest", "/leverage/start/leverage", ratio),
    ("leverage at let-off", "/leverage/let_off/leverage", ratio),
    ("key at let-off", "/leverage/let_off/key_mm", fine),
    ("knuckle sliding, at most", "/knuckle_sliding_mm", fine),
];

impl Summary {
    /// The first lines: leverage, let-off and sliding, and how well a slow press agrees.
    pub(crate) fn headlines(&self, answer: &Value) -> Vec<String> {
        let mut lines = self.table(&FIRST).lines();
        lines.extend(agreement(answer));
        lines
    }

    fn table(&self, rows: &[Number]) -> Table<'static> {
        let is_one = self.labels.len() == 1;
        let heads = self.labels.iter().map(|label| if is_one { String::new() } else { label.clone() });
        let cases: Vec<&Value> = self.json["cases"].as_array().into_iter().flatten().collect();
        let rows = rows.iter().map(|(name, pointer, shown)| {
            let number = |case: &&Value| case.pointer(pointer).and_then(Value::as_f64);
            let cells = cases.iter().map(|case| number(case).map_or("-".to_owned(), shown));
            std::iter::once((*name).to_owned()).chain(cells).collect::<Vec<_>>()
        });
        Table::of([String::new()].into_iter().chain(heads).collect::<Vec<_>>(), rows.collect::<Vec<_>>())
    }
}

/// How well a slow press of the dynamic model agrees.
fn agreement(answer: &Value) -> Option<String> {
    let of = |key: &str| answer["dynamics"][key].as_f64();
    let (worst, from, to) = (of("largest_deviation")?, of("from_key_mm")?, of("to_key_mm")?);
    let within = format!("within {:.1} % from key {from:.1} to {to:.1} mm", worst * 100.0);
    Some(format!("  A slow press of the dynamic model has the same leverage {within}."))
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let json = &self.json;
        let is_one = self.labels.len() == 1;
        writeln!(f, "{}", self.table(&ROWS))?;
        writeln!(f, "  Let-off: {}.", json["let_off_is"].as_str().unwrap_or("not known"))?;
        if !is_one {
            let how = if json["regulated"] == true {
                "regulated: the hammer rests at the same height"
            } else {
                "not regulated: the hammer rests where the move puts it"
            };
            writeln!(f, "  Moved cases are {how}. Let-off is at the same height.")?;
            writeln!(f, "  Moves: negative is toward the player, or down.")?;
        }
        if let Some(lengths) = json["lengths_mm"].as_array() {
            let number = |mm: &Value| mm.as_f64().unwrap_or(f64::NAN);
            let names = lengths.iter().enumerate().map(|(i, mm)| format!("L{} {:.2}", i + 1, number(mm)));
            writeln!(f, "  Nearest lengths (mm): {}.", names.collect::<Vec<_>>().join(", "))?;
            writeln!(
                f,
                "    L7 to L9 are exact (centre of the knuckle); L2 to L4 assume that the capstan touches one point of the heel."
            )?;
        }
        if let Some(agreement) = agreement(json) {
            writeln!(f, "{agreement}")?;
        }
        for note in json["notes"].as_array().into_iter().flatten().filter_map(Value::as_str) {
            writeln!(f, "  Note: {note}.")?;
        }
        Ok(())
    }
}

//! The first lines of what `measure` answers, made of its JSON: what is out of range, and the values that a technician
//! asks for first.

use erard_workshop::measure::norms::lines;
use serde_json::Value;

use super::shown;
use crate::table::Table;
use crate::units::Lengths;

/// The values that are asked for first, by their keys in measure.json, with their names; a sentence for each group.
const FIRST: [&[(&str, &str)]; 4] = [
    &[
        ("down_weight_g", "Down-weight"),
        ("up_weight_g", "up-weight"),
        ("balance_weight_g", "balance weight"),
        ("friction_weight_g", "friction"),
    ],
    &[
        ("strike_weight_g", "Strike weight"),
        ("front_weight_g", "front weight"),
        ("strike_weight_ratio_weights", "leverage"),
        ("effective_inertia_kg", "inertia at the key"),
    ],
    &[
        ("dip_mm", "Dip"),
        ("blow_mm", "blow"),
        ("let_off_mm", "let-off"),
        ("drop_mm", "drop"),
        ("aftertouch_mm", "aftertouch"),
        ("check_mm", "check"),
    ],
    &[("repetition_rate_half_hz", "Repetition from half-way"), ("softest_force_N", "softest force that sounds")],
];

/// Those of several actions, side by side.
const SIDE_BY_SIDE: [&str; 7] = [
    "down_weight_g",
    "up_weight_g",
    "balance_weight_g",
    "friction_weight_g",
    "strike_weight_ratio_weights",
    "effective_inertia_kg",
    "aftertouch_mm",
];

/// More values out of range are counted instead.
const MOST_FLAGS: usize = 4;

/// One of the values, as text.
fn value(answer: &Value, key: &str, lengths: Lengths) -> String {
    let line = lines().find(|line| line.key == key);
    line.map_or_else(String::new, |line| shown(line, answer[key].as_f64(), lengths))
}

/// What is out of its usual range.
pub(crate) fn verdict(answer: &Value) -> Vec<String> {
    let flags: Vec<&str> =
        answer["flags"].as_array().into_iter().flatten().filter_map(|one| one["message"].as_str()).collect();
    match flags.len() {
        0 => vec!["Every value is in its usual range.".to_owned()],
        1..=MOST_FLAGS => std::iter::once("Out of the usual range:".to_owned())
            .chain(flags.iter().map(|flag| format!("  ! {flag}")))
            .collect(),
        count => {
            let names = flags.iter().map(|flag| flag.split(';').next().unwrap_or(flag));
            vec![format!("{count} values are out of their usual range: {}.", names.collect::<Vec<_>>().join(", "))]
        }
    }
}

/// The first lines for one action.
pub(crate) fn of_one(answer: &Value, lengths: Lengths) -> Vec<String> {
    let sentence = |group: &&[(&str, &str)]| {
        let one = |(key, name): &(&str, &str)| format!("{name} {}", value(answer, key, lengths));
        format!("{}.", group.iter().map(one).collect::<Vec<_>>().join(", "))
    };
    verdict(answer).into_iter().chain(FIRST.iter().map(sentence)).collect()
}

/// The first lines for several actions, side by side.
pub(crate) fn of_several(answer: &Value, labels: &[&str], lengths: Lengths) -> Vec<String> {
    let all: Vec<&Value> = answer["instruments"].as_array().into_iter().flatten().collect();
    let row = |(key, name): &(&str, &str)| {
        let cells = all.iter().map(|one| value(one, key, lengths));
        std::iter::once(name.to_lowercase()).chain(cells).collect::<Vec<_>>()
    };
    let rows = FIRST.iter().copied().flatten().filter(|(key, _)| SIDE_BY_SIDE.contains(key)).map(row);
    let out = all.iter().map(|one| one["flags"].as_array().map_or(0, Vec::len).to_string());
    let out = std::iter::once("out of range".to_owned()).chain(out).collect();
    let heads = [""].into_iter().chain(labels.iter().copied());
    Table::of(heads, rows.chain([out])).lines()
}

/// Heading of a line that stays out of its range, and of one that is read again, because the list cannot know it.
pub(crate) const STAYS_OUT: &str = "Stays out";
pub(crate) const READ_AGAIN: &str = "Read again";

/// The first lines of a technician's sheet: what is out, and what to do.
pub(crate) fn of_sheet(answer: &Value) -> Vec<String> {
    let mut lines = verdict(answer);
    let tasks: Vec<&Value> = answer["sheet"]["tasks"].as_array().into_iter().flatten().collect();
    if tasks.is_empty() {
        lines.push("To do: nothing.".to_owned());
    } else {
        lines.push("To do, in this order:".to_owned());
    }
    let text = |task: &Value, key: &str| task[key].as_str().unwrap_or_default().to_owned();
    lines.extend((1..).zip(tasks).map(|(at, task)| format!("  {at}. {}: {}", text(task, "what"), text(task, "by"))));
    for (name, heading) in [("read_again", READ_AGAIN), ("stays_out", STAYS_OUT)] {
        let left = answer["sheet"][name].as_array().into_iter().flatten();
        lines.extend(left.map(|left| format!("{heading}: {}", text(left, "why"))));
    }
    lines
}

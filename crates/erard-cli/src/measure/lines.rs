//! A line of the protocol sheet as text: its value and its usual range, lengths in the unit that was asked for.

use erard_workshop::measure::norms::Line;

use crate::units::Lengths;

/// A value with its unit, lengths as the ruler shows them.
pub(crate) fn shown(line: &Line, value: Option<f64>, lengths: Lengths) -> String {
    match value {
        Some(mm) if line.unit == "mm" => lengths.text(mm, line.decimals),
        value => line.text(value),
    }
}

/// The usual range, lengths as the ruler shows them.
pub(crate) fn usual(line: &Line, key: usize, lengths: Lengths) -> String {
    if line.unit != "mm" {
        return line.usual(key);
    }
    let number = |mm: f64| lengths.number(mm, line.decimals);
    match line.range(key) {
        [Some(low), Some(high)] => format!("{}-{}", number(low), number(high)),
        [Some(low), None] => format!("from {}", number(low)),
        [None, Some(high)] => format!("to {}", number(high)),
        [None, None] => String::new(),
    }
}

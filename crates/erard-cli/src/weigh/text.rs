//! The readings and the work list in a terminal.

use std::fmt::Write as _;

use erard_workshop::balance::MeasuredKey;

use super::Work;
use super::lists::{nothing_to_do, readings, remarks, sections, stays};
use super::table::checked_lines;
use crate::table::{Table, decimal};

/// What was weighed, what to do in which order, and what was checked.
pub(crate) fn text(work: &Work<'_>) -> String {
    let mut out = readings(work).to_string();
    let say = |out: &mut String, lines: Vec<String>| {
        for line in lines {
            let _ = writeln!(out, "  {line}");
        }
    };
    let _ = writeln!(out);
    say(&mut out, remarks(work));
    let sections = sections(work);
    if let Some(nothing) = nothing_to_do(work) {
        let _ = writeln!(out, "\n  {nothing}");
    }
    for (at, section) in sections.iter().enumerate() {
        let _ = writeln!(out, "\n  {}. {}:\n", at + 1, section.heading);
        let _ = write!(out, "{}", section.table(work, None));
    }
    let last: Vec<String> = stays(work).into_iter().chain(checked_lines(work)).collect();
    if !last.is_empty() {
        let _ = writeln!(out);
    }
    say(&mut out, last);
    out
}

/// The keys with work before and after the list, weighed on copies.
pub(crate) fn again_text(work: &Work<'_>, again: &[MeasuredKey]) -> String {
    let keys = &work.list.plan.keys;
    let worked = |key: usize| work.list.lines.iter().any(|line| line.key == key);
    let pairs = keys.iter().map(|key| &key.measured).zip(again).filter(|(before, _)| worked(before.key));
    let rows = pairs.map(|(before, after)| {
        let both = |of: &dyn Fn(&MeasuredKey) -> Option<f64>| {
            format!("{} to {}", decimal(of(before), 1), decimal(of(after), 1))
        };
        [
            before.key.to_string(),
            erard::keyboard::note_name(before.key),
            both(&|key| key.down_weight_g),
            both(&|key| key.up_weight_g),
            both(&MeasuredKey::balance_weight_g),
            both(&MeasuredKey::friction_weight_g),
        ]
    });
    Table::of(["key", "note", "D g", "U g", "BW g", "F g"], rows).to_string()
}

//! The sheets as a printed table, side by side, with what is usual and what is out of it.

use std::fmt::Write as _;

use erard_workshop::measure::Sheet;
use erard_workshop::measure::norms::{GROUPS, Line};

use super::Measured;
use super::{shown, usual};
use crate::units::Lengths;

/// Width of the labels.
const LABELS: usize = 36;
/// Stands behind a value that is out of the norm.
const OUT: &str = " !";

/// Characters, which are what columns are aligned by.
fn wide(text: &str) -> usize {
    text.chars().count()
}

fn cell(line: &Line, sheet: &Sheet, lengths: Lengths) -> String {
    let mark = if line.is_out(sheet) { OUT } else { "  " };
    format!("{}{mark}", shown(line, (line.value)(sheet), lengths))
}

/// What is usual, where it is the same for all of the sheets.
pub(crate) fn usual_of(line: &Line, measured: &[Measured], lengths: Lengths) -> String {
    let mut all = measured.iter().map(|one| usual(line, one.sheet.norms_for_key, lengths));
    let first = all.next().unwrap_or_default();
    if all.all(|other| other == first) { first } else { "by the key".to_owned() }
}

/// The table, the timing sheets and the red flags.
pub(crate) fn text(measured: &[Measured], lengths: Lengths) -> String {
    let mut out = String::new();
    let widths: Vec<usize> = measured
        .iter()
        .map(|one| {
            let cells = GROUPS.iter().flat_map(|group| group.lines).map(|line| wide(&cell(line, &one.sheet, lengths)));
            cells.fold(wide(&one.label) + 2, usize::max)
        })
        .collect();
    // Writing to a string does not fail.
    let mut row = |label: &str, cells: &mut dyn Iterator<Item = String>, usual: &str| {
        let mut text = format!("  {label:<LABELS$}");
        for (cell, width) in cells.zip(&widths) {
            let _ = write!(text, "{:indent$}{cell}", "", indent = width + 2 - wide(&cell));
        }
        let _ = writeln!(out, "{}", format!("{text}  {usual}").trim_end());
    };
    if measured.len() > 1 {
        row("", &mut measured.iter().map(|one| format!("{}  ", one.label)), "usual");
    }
    for group in &GROUPS {
        row(group.heading, &mut std::iter::empty(), "");
        for line in group.lines {
            // A damper that is not there has no lines.
            if measured.iter().all(|one| (line.value)(&one.sheet).is_none()) && line.norm().is_none() {
                continue;
            }
            let label = format!("  {}", line.label);
            row(
                &label,
                &mut measured.iter().map(|one| cell(line, &one.sheet, lengths)),
                &usual_of(line, measured, lengths),
            );
        }
    }
    for one in measured {
        let _ = writeln!(out);
        timing(&mut out, one, measured.len() > 1);
    }
    for one in measured {
        let whose = if measured.len() > 1 { format!(" ({})", one.label) } else { String::new() };
        let _ = writeln!(out);
        if one.sheet.flags.is_empty() {
            let _ = writeln!(out, "  Nothing is out of the norm{whose}.");
            continue;
        }
        let _ = writeln!(out, "  Red flags{whose}:");
        for flag in &one.sheet.flags {
            let _ = writeln!(out, "    ! {}", flag.message);
        }
    }
    out
}

fn timing(out: &mut String, one: &Measured, named: bool) {
    let whose = if named { format!(", {}", one.label) } else { String::new() };
    let _ = writeln!(out, "  Timing{whose} (ms after key start; built-in strokes, force driven)");
    let _ = writeln!(
        out,
        "    {:<11}{:>8}{:>9}{:>9}{:>9}{:>10}{:>16}{:>10}{:>6}",
        "", "peak", "let-off", "hammer", "bottom", "flight", "hammer before", "speed", "MIDI"
    );
    for row in &one.sheet.timing {
        let ms = |value: Option<f64>| value.map_or("-".to_owned(), |ms| format!("{:.1}", ms + 0.0));
        let _ = writeln!(
            out,
            "    {:<11}{:>8}{:>9}{:>9}{:>9}{:>10}{:>16}{:>10}{:>6}",
            format!("{} {}", row.nuance, row.touch),
            format!("{:.1} N", row.peak_force_N),
            ms(row.let_off_ms),
            ms(row.hammer_contact_ms),
            ms(row.key_bottom_ms),
            ms(row.free_flight_ms),
            ms(row.hammer_before_bottom_ms),
            row.hammer_speed_m_s.map_or("-".to_owned(), |speed| format!("{speed:.2} m/s")),
            row.midi_velocity.map_or("-".to_owned(), |velocity| velocity.to_string()),
        );
    }
}

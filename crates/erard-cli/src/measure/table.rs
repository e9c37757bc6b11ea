//! The sheets as a printed table, side by side, with the usual range and what is out of it.

use std::fmt::Write as _;

use erard_workshop::measure::Sheet;
use erard_workshop::measure::flight::Flight;
use erard_workshop::measure::norms::{GROUPS, Line, ratios_compared};

use super::Measured;
use super::{shown, usual};
use crate::table::{Table, decimal};
use crate::units::Lengths;

/// Stands behind a value that is out of the norm.
const OUT: &str = " !";

fn cell(line: &Line, sheet: &Sheet, lengths: Lengths) -> String {
    let mark = if line.is_out(sheet) { OUT } else { "  " };
    format!("{}{mark}", shown(line, (line.value)(sheet), lengths))
}

/// The usual range, where it is the same for all of the sheets.
pub(crate) fn usual_of(line: &Line, measured: &[Measured], lengths: Lengths) -> String {
    let mut all = measured.iter().map(|one| usual(line, one.sheet.norms_for_key, lengths));
    let first = all.next().unwrap_or_default();
    if all.all(|other| other == first) { first } else { "by the key".to_owned() }
}

/// The red flags, the table and the timing sheets.
pub(crate) fn text(measured: &[Measured], lengths: Lengths) -> String {
    let heads = measured.iter().map(|one| if measured.len() > 1 { one.label.as_str() } else { "" });
    let mut rows: Vec<Vec<String>> = Vec::new();
    for group in GROUPS.iter() {
        rows.push(vec![group.heading.to_owned()].into_iter().chain(vec![String::new(); measured.len() + 1]).collect());
        for line in group.page_lines() {
            if measured.iter().all(|one| (line.value)(&one.sheet).is_none()) && line.norm().is_none() {
                continue;
            }
            let cells = measured.iter().map(|one| cell(line, &one.sheet, lengths));
            let label = format!("  {}", line.label);
            rows.push([label].into_iter().chain(cells).chain([usual_of(line, measured, lengths)]).collect());
        }
    }
    let mut out = String::new();
    for one in measured {
        let whose = if measured.len() > 1 { format!(" ({})", one.label) } else { String::new() };
        if one.sheet.flags.is_empty() {
            let _ = writeln!(out, "  Every value is in its usual range{whose}.");
            continue;
        }
        let _ = writeln!(out, "  Out of the usual range{whose}:");
        for flag in &one.sheet.flags {
            let _ = writeln!(out, "    ! {}", flag.message);
        }
    }
    let _ =
        writeln!(out, "\n{}", Table::of([""].into_iter().chain(heads).chain(["usual"]), rows).to_string().trim_end());
    let whose = |one: &Measured| if measured.len() > 1 { format!(", {}", one.label) } else { String::new() };
    for one in measured {
        let Some(compared) = ratios_compared(&one.sheet) else { continue };
        let of = if measured.len() > 1 { format!("{}: ", one.label) } else { String::new() };
        let _ = writeln!(out, "\n  {of}{compared}");
    }
    for one in measured {
        let heading = format!("Timing{} (ms after key start; built-in touches, a hand of 200 g)", whose(one));
        let _ = writeln!(out, "\n  {heading}\n{}", timing(one));
    }
    for one in measured {
        let _ = writeln!(out, "\n  Free flight{} (along the string's normal)\n{}", whose(one), flight(one));
    }
    out
}

/// The timing sheet of one: milliseconds after key start.
pub(crate) fn timing(one: &Measured) -> Table<'static> {
    let heads = ["", "peak (N)", "last push", "hammer", "bottom", "flight", "hammer before", "speed (m/s)", "MIDI"];
    let rows = one.sheet.timing.iter().map(|row| {
        [
            format!("{} {}", row.nuance, row.touch),
            decimal(Some(row.peak_force_N), 1),
            decimal(row.let_off_ms, 1),
            decimal(row.hammer_contact_ms, 1),
            decimal(row.key_bottom_ms, 1),
            decimal(row.free_flight_ms, 1),
            decimal(row.hammer_before_bottom_ms, 1),
            decimal(row.hammer_speed_m_per_s, 2),
            decimal(row.midi_velocity.map(f64::from), 0),
        ]
    });
    Table::of(heads, rows)
}

/// The bench test of one, weight by weight.
pub(crate) fn bench(one: &Measured) -> Table<'static> {
    let rows = one
        .sheet
        .blocked
        .iter()
        .map(|row| [format!("{:.0}", row.weight_g), decimal(Some(row.front_mm), 2), decimal(row.back_mm, 2)]);
    Table::of(["weight (g)", "key front (mm)", "capstan (mm)"], rows)
}

/// The free flights of one, in mm and ms.
pub(crate) fn flight(one: &Measured) -> Table<'static> {
    let heads = [
        "",
        "speed (m/s)",
        "last push: mm",
        "last push: ms",
        "at speed (ms)",
        "largest speed: mm",
        "largest speed: ms",
        "at speed (ms)",
    ];
    let rows = one.sheet.timing.iter().map(|row| {
        let of = |flight: Option<Flight>| {
            let number = |of: fn(&Flight) -> f64| decimal(flight.as_ref().map(of), 2);
            [number(|f| f.way_mm), number(|f| f.time_ms), number(|f| f.at_constant_speed_ms)]
        };
        let flights = row.flights;
        let name = [format!("{} {}", row.nuance, row.touch), decimal(flights.map(|f| f.speed_m_per_s), 2)];
        let (push, largest) = (flights.and_then(|f| f.from_last_push), flights.map(|f| f.from_largest_speed));
        name.into_iter().chain(of(push)).chain(of(largest)).collect::<Vec<_>>()
    });
    Table::of(heads, rows)
}

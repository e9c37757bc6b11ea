//! The rows of a study: printed, and as columns of a file.

use erard::run::Events;
use erard_workshop::measure::norms::Line;
use erard_workshop::study::{Axis, Column, StudyRow, measured_title};

use crate::table::{Table, decimal, three};

/// Columns as they are written, with the reasons why rows failed.
pub(crate) fn table_of(columns: &[Column], rows: &[StudyRow]) -> Table<'static> {
    let one = |table: Table<'static>, (name, values): &Column| table.optional(name.clone(), values.iter().copied());
    columns.iter().fold(Table::default(), one).words("error", rows.iter().map(|row| row.error().unwrap_or_default()))
}

/// A column of the printed table: its heading and its cell.
type Shown = (&'static str, fn(&Events) -> Option<f64>);

const SHOWN: [Shown; 5] = [
    ("hammer m/s", Events::hammer_speed_m_per_s),
    ("at ms", |e| e.hammer_contact_s().map(|s| s * 1e3)),
    ("last push ms", |e| e.let_off_s.map(|s| s * 1e3)),
    ("bottom ms", |e| e.key_bottom_s.map(|s| s * 1e3)),
    ("check ms", |e| e.check_s.map(|s| s * 1e3)),
];

/// The table for people, at most so many rows of it, the first and the last among them.
pub(crate) fn shown(axes: &[Axis], measures: &[&Line], rows: &[StudyRow], most: usize) -> Table<'static> {
    let heads = axes.iter().map(Axis::column);
    let heads = heads.chain(SHOWN.iter().map(|(name, _)| (*name).to_owned())).chain(["impacts".to_owned()]);
    let heads = heads.chain(measures.iter().map(|line| measured_title(axes, line))).chain([String::new()]);
    let shown = most.min(rows.len()).max(1);
    let places = (0..shown).map(|k| k * rows.len().saturating_sub(1) / (shown - 1).max(1));
    let cells = places.filter_map(|place| rows.get(place)).map(|row| {
        let played = row.outcome.as_ref().ok();
        let mut cells: Vec<String> = row.values.iter().map(|value| ((value * 1e4).round() / 1e4).to_string()).collect();
        let event = |get: fn(&Events) -> Option<f64>| get(&played?.events);
        cells.extend(SHOWN.iter().map(|(_, get)| event(*get).map_or("-".to_owned(), three)));
        cells.push(played.map_or("-".to_owned(), |played| played.events.impacts.len().to_string()));
        let measured = |k: usize| *row.measured.as_ref().ok()?.get(k)?;
        cells.extend(measures.iter().enumerate().map(|(k, measure)| decimal(measured(k), measure.decimals)));
        cells.push(match (&row.outcome, &row.measured) {
            (Err(error), _) => format!("failed: {error}"),
            (_, Err(error)) => format!("not measured: {error}"),
            (Ok(played), _) if !played.warnings.is_empty() => "not trusted".to_owned(),
            // The jack still pushes when the hammer strikes: it blocks.
            (Ok(played), _) if played.events.let_off_s.is_none() && !played.events.impacts.is_empty() => {
                "not let off".to_owned()
            }
            _ => String::new(),
        });
        cells
    });
    Table::of(heads, cells)
}

//! The rows of a study: printed, and as columns of a file.

use erard::run::Events;
use erard::trust::worst_of_each;
use erard_workshop::measure::norms::Line;
use erard_workshop::study::{OUTCOMES, Played};

use super::Axis;
use crate::table::{Table, decimal, three};

/// One stroke of a study.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Row {
    /// The varied values as shown, one for each axis.
    pub values: Vec<f64>,
    /// The outcome, or why there is none.
    pub outcome: Result<Played, String>,
    /// The variant's measures, in the order asked for; or why there are none.
    pub measured: Result<Vec<Option<f64>>, String>,
}

impl Row {
    /// Whether it was played and nothing speaks against it.
    pub(crate) fn is_trusted(&self) -> bool {
        self.outcome.as_ref().is_ok_and(|played| played.warnings.is_empty())
    }
}

/// What speaks against the strokes of a study: of every kind and part how many strokes, and the worst of them as a
/// sentence.
pub(crate) fn doubts(rows: &[Row]) -> Vec<String> {
    let warnings = rows.iter().filter_map(|row| row.outcome.as_ref().ok()).flat_map(|played| &played.warnings);
    let each = worst_of_each(warnings).into_iter();
    each.map(|(count, worst)| format!("{count} of {} strokes; the worst: {worst}", rows.len())).collect()
}

/// The columns of the files.
pub(crate) fn columns(axes: &[Axis], measures: &[&Line], rows: &[Row]) -> Vec<Column> {
    let played = |row: &'_ Row, get: fn(&Played) -> Option<f64>| row.outcome.as_ref().ok().and_then(get);
    let flag = |is_it: bool| Some(f64::from(u8::from(is_it)));
    let varied = axes.iter().enumerate().map(|(i, axis)| {
        let values = rows.iter().map(|row| row.values.get(i).copied()).collect();
        (axis.column(), values)
    });
    let outcomes = OUTCOMES.iter().map(|(name, get)| {
        let values = rows.iter().map(|row| played(row, *get)).collect();
        ((*name).to_owned(), values)
    });
    let measured = measures.iter().enumerate().map(|(i, line)| {
        let values = rows.iter().map(|row| *row.measured.as_ref().ok()?.get(i)?).collect();
        (measured_title(axes, line), values)
    });
    let solution: [Column; 3] = [
        ("failed".to_owned(), rows.iter().map(|row| flag(row.outcome.is_err())).collect()),
        ("trusted".to_owned(), rows.iter().map(|row| flag(row.is_trusted())).collect()),
        ("energy_residual_relative".to_owned(), rows.iter().map(|row| played(row, |p| p.energy_residual)).collect()),
    ];
    varied.chain(outcomes).chain(measured).chain(solution).collect()
}

/// The title of a measured column: the line's key. A varied column may have that title already: `let_off_mm` is a screw
/// that is set and a distance that is measured. The measured one then begins with `measured_`.
fn measured_title(axes: &[Axis], line: &Line) -> String {
    let is_taken = axes.iter().any(|axis| axis.column() == line.key);
    if is_taken { format!("measured_{}", line.key) } else { line.key.to_owned() }
}

/// A column's name and its values.
pub(crate) type Column = (String, Vec<Option<f64>>);

/// Columns as they are written.
pub(crate) fn table_of(columns: &[Column]) -> Table<'static> {
    let one = |table: Table<'static>, (name, values): &Column| table.optional(name.clone(), values.iter().copied());
    columns.iter().fold(Table::default(), one)
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
pub(crate) fn shown(axes: &[Axis], measures: &[&Line], rows: &[Row], most: usize) -> Table<'static> {
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

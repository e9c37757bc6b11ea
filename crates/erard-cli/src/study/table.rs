//! The rows of a study: printed, and as columns of a file.

use erard::run::Events;
use erard_workshop::measure::norms::Line;
use erard_workshop::study::{Axis, Column, StudyRow, measured_title};

use crate::table::{Table, decimal, spaced, three};

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

/// Most values of the first axis down and of the second across.
const MOST_CROSSED: [usize; 2] = [6, 8];

/// The hammer speeds over two axes, or what was measured first: the values of the first axis down and those of the
/// second across, all of them or evenly spaced ones; `None` of other studies.
pub(crate) fn crossed(axes: &[Axis], measures: &[&Line], rows: &[StudyRow]) -> Option<Vec<String>> {
    let [down, across] = axes else { return None };
    let value = |x: f64| ((x * 1e4).round() / 1e4).to_string();
    let places = [0, 1].map(|at| spaced(axes[at].shown.len(), MOST_CROSSED[at]));
    let heads = [down.column()].into_iter().chain(places[1].iter().map(|at| value(across.shown[*at])));
    let cells = places[0].iter().map(|row| {
        let row = &rows[row * across.shown.len()..];
        let speed = |row: &StudyRow| Some(three(row.outcome.as_ref().ok()?.events.hammer_speed_m_per_s()?));
        let measured =
            |row: &StudyRow| Some(decimal(*row.measured.as_ref().ok()?.first()?, measures.first()?.decimals));
        let cell = |row: &StudyRow| if measures.is_empty() { speed(row) } else { measured(row) };
        let first = row.first().and_then(|row| row.values.first()).map_or_else(String::new, |x| value(*x));
        let speeds = places[1].iter().map(|at| row.get(*at).and_then(cell).unwrap_or_else(|| "-".to_owned()));
        [first].into_iter().chain(speeds).collect::<Vec<_>>()
    });
    let some = |axis: &Axis, shown: usize| match axis.shown.len() {
        all if all > shown => format!(", {shown} of {all}"),
        _ => String::new(),
    };
    let [down_some, across_some] = [some(down, places[0].len()), some(across, places[1].len())];
    let what = measures.first().map_or("hammer speed, m/s".to_owned(), |line| measured_title(axes, line));
    let title = format!("{what}; down: {}{down_some}; across: {}{across_some}", down.column(), across.column());
    Some([title].into_iter().chain(Table::of(heads, cells).lines()).collect())
}

/// The table for people, at most so many rows of it, the first and the last among them.
pub(crate) fn shown(axes: &[Axis], measures: &[&Line], rows: &[StudyRow], most: usize) -> Table<'static> {
    let heads = axes.iter().map(Axis::column);
    let heads = heads.chain(SHOWN.iter().map(|(name, _)| (*name).to_owned())).chain(["impacts".to_owned()]);
    let heads = heads.chain(measures.iter().map(|line| measured_title(axes, line))).chain([String::new()]);
    let cells = spaced(rows.len(), most).into_iter().map(|place| &rows[place]).map(|row| {
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

//! A recording as it was taken: the columns of a table in SI units, with their gaps.

use super::columns::{Column, Layout, PositionOf, Role};
use super::rows::Place;
use super::{ForceSeries, PositionSeries, ROLES, SHORTEST_STEP_S, SampleError, Series, SpeedSeries, StrokeError};

/// Most rows that are read: more than an hour at 1 kHz.
pub const MAX_ROWS: usize = 5_000_000;

/// A table with known columns and units. Everything is in SI units: s, N, m.
#[derive(Debug, Clone, PartialEq)]
pub struct Recording {
    /// The instants of the rows, s, increasing; two or more.
    pub time_s: Vec<f64>,
    /// Measured channels, in the order of [`super::ROLES`] without the time.
    pub channels: Vec<Channel>,
    /// Whose position was recorded, as far as its title says.
    pub position_of: PositionOf,
    /// Columns of the file, time first.
    pub layout: Layout,
    /// Format of the file.
    pub dialect: Dialect,
}

/// Format of a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dialect {
    /// Separator of cells; `None` for a file that is not text.
    pub separator: Option<char>,
    /// Whether numbers have a comma before their decimals.
    pub decimal_comma: bool,
    /// Number of lines above the header.
    pub skipped_rows: usize,
}

/// A measured quantity, one value for every row.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Role of the channel.
    pub role: Role,
    /// N or m; not a number where the cell is empty. Two or more are numbers.
    pub values: Vec<f64>,
}

/// Rows without a value between rows that have one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Gaps {
    /// Rows without a value, those before the first value and after the last included.
    pub rows: usize,
    /// The longest time from one value to the next where rows between them have none, s; 0 without such.
    pub longest_s: f64,
}

impl Recording {
    /// Makes a recording of columns that are numbers already, as from a Parquet file: one slice for each column of the
    /// layout, in its order and in the file's units; NaN is a gap.
    ///
    /// # Errors
    /// As of a text; the line of an error is the row, from 1.
    pub fn from_columns(layout: Layout, file: &str, columns: &[&[f64]]) -> Result<Self, Box<StrokeError>> {
        let mut builder = Builder::new(layout);
        let rows = columns.iter().map(|values| values.len()).min().unwrap_or(0);
        let mut place = Place { file: file.to_owned(), line: 0 };
        for row in 0..rows {
            place.line = row as u64 + 1;
            let mut cells = [None; ROLES.len()];
            for (cell, values) in cells.iter_mut().zip(columns) {
                *cell = Some(values[row]).filter(|value| !value.is_nan());
            }
            builder.push(&place, cells)?;
        }
        builder.finish(&Place { file: file.to_owned(), line: 0 }, Dialect::default())
    }

    /// The channel of a role, where there is one.
    pub fn channel(&self, role: Role) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.role == role)
    }

    /// The stroke as it was taken: interpolated over the gaps.
    ///
    /// # Errors
    /// Where a channel cannot be interpolated: of a recording that was read all can be.
    pub fn series(&self) -> Result<Series, SampleError> {
        let samples = |role| self.channel(role).map(|channel| channel.samples(&self.time_s));
        let path = |role| samples(role).map(|(times, values)| PositionSeries::new(times, values)).transpose();
        Ok(Series {
            force: samples(Role::Force).map(|(times, values)| ForceSeries::new(times, values)).transpose()?,
            position: path(Role::Position)?,
            hammer_head: path(Role::HammerHead)?,
            hammer_speed: samples(Role::HammerSpeed)
                .map(|(times, values)| SpeedSeries::new(times, values))
                .transpose()?,
        })
    }
}

impl Channel {
    /// Instants and values of the rows that have one, s and N or m.
    pub(crate) fn samples(&self, time_s: &[f64]) -> (Vec<f64>, Vec<f64>) {
        time_s.iter().zip(&self.values).filter(|(_, value)| !value.is_nan()).unzip()
    }

    /// Number of missing samples.
    pub fn gaps(&self, time_s: &[f64]) -> Gaps {
        let rows = self.values.iter().filter(|value| value.is_nan()).count();
        let there: Vec<usize> = (0..self.values.len()).filter(|&row| !self.values[row].is_nan()).collect();
        let across =
            there.windows(2).filter(|pair| pair[1] > pair[0] + 1).map(|pair| time_s[pair[1]] - time_s[pair[0]]);
        Gaps { rows, longest_s: across.fold(0.0, f64::max) }
    }
}

/// Takes rows one by one, checked.
pub(super) struct Builder {
    layout: Layout,
    time_s: Vec<f64>,
    values: Vec<Vec<f64>>,
    first_row: Option<Place>,
}

impl Builder {
    pub(super) fn new(layout: Layout) -> Self {
        let values = vec![Vec::new(); layout.columns.len() - 1];
        Builder { layout, time_s: Vec::new(), values, first_row: None }
    }

    /// The columns that every row's cells belong to.
    pub(super) fn columns(&self) -> &[Column] {
        &self.layout.columns
    }

    /// Takes a row: a cell for every column of the layout, in the file's units; `None` is an empty one. A row without
    /// any is left out.
    pub(super) fn push(&mut self, place: &Place, row: [Option<f64>; ROLES.len()]) -> Result<(), Box<StrokeError>> {
        if row.iter().all(Option::is_none) {
            return Ok(());
        }
        if self.time_s.len() == MAX_ROWS {
            let expected = format!("at most {MAX_ROWS} rows: cut the recording or sample it more coarsely");
            return Err(place.fault("", "too many rows", format!("more than {MAX_ROWS}"), expected));
        }
        for (column, cell) in self.layout.columns.iter().zip(row) {
            let value = match cell {
                Some(cell) => si(cell, column, place)?,
                None if column.role == Role::Time => {
                    let fault = ("not a number", "an empty cell", "a number such as 0.25");
                    return Err(place.fault(&column.title, fault.0, fault.1, fault.2));
                }
                None => f64::NAN,
            };
            match column.role {
                Role::Time => {
                    match self.time_s.last() {
                        None => self.first_row = Some(place.clone()),
                        Some(&previous) => check_order(previous, value, column, place)?,
                    }
                    self.time_s.push(value);
                }
                role => {
                    let index = self.layout.columns.iter().position(|c| c.role == role).unwrap_or(1) - 1;
                    self.values[index].push(value);
                }
            }
        }
        Ok(())
    }

    /// All rows are there.
    pub(super) fn finish(self, header: &Place, dialect: Dialect) -> Result<Recording, Box<StrokeError>> {
        if self.time_s.len() < 2 {
            let (place, message) = match self.first_row {
                None => (header.clone(), "a header and no rows"),
                Some(place) => (place, "one row is not a stroke"),
            };
            return Err(place.fault("", message, count(self.time_s.len(), "row"), "two rows or more"));
        }
        let columns = &self.layout.columns[1..];
        for (column, values) in columns.iter().zip(&self.values) {
            let there = values.iter().filter(|value| !value.is_nan()).count();
            if there < 2 {
                let expected = "two numbers or more in this column";
                return Err(header.fault(&column.title, "empty cells only", count(there, "number"), expected));
            }
        }
        let channels = columns.iter().zip(self.values).map(|(column, values)| Channel { role: column.role, values });
        let channels = channels.collect();
        Ok(Recording {
            time_s: self.time_s,
            channels,
            position_of: self.layout.position_of,
            layout: self.layout,
            dialect,
        })
    }
}

/// A cell's number in SI units, finite and of sane size.
fn si(cell: f64, column: &Column, place: &Place) -> Result<f64, Box<StrokeError>> {
    // A thousand of them to one: divided, 9 ms are the number that is written 0.009.
    let to_one = (1.0 / column.factor).round();
    let is_whole = column.factor < 1.0 && (to_one * column.factor - 1.0).abs() < 1e-15;
    let value = if is_whole { cell / to_one } else { cell * column.factor };
    let fault = |message: &str, expected: &str| Err(place.fault(&column.title, message, format!("`{cell}`"), expected));
    let (largest, hint) = column.role.largest();
    if !value.is_finite() {
        return fault("not a finite number", "a finite number");
    }
    if value.abs() > largest {
        return fault("too large to be true", hint);
    }
    Ok(value)
}

fn check_order(previous: f64, time: f64, column: &Column, place: &Place) -> Result<(), Box<StrokeError>> {
    if time - previous >= SHORTEST_STEP_S {
        return Ok(());
    }
    let message = if time < previous {
        "time goes backwards"
    } else if time == previous {
        "the same time twice"
    } else {
        "two times too close together"
    };
    let unit = if column.factor == 1.0 { "" } else { " s" };
    let expected = format!("more than {previous}{unit}, the time before it");
    Err(place.fault(&column.title, message, format!("{time}{unit}"), expected))
}

/// `1 row`, `2 rows`.
pub(super) fn count(number: usize, what: &str) -> String {
    format!("{number} {what}{}", if number == 1 { "" } else { "s" })
}

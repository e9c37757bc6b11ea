//! Reading recordings from text: a header, then one row per instant.
//!
//! Columns for the time and for force and/or position, and for the hammer where it was measured too, in any order and
//! in any unit that is known, among others that are ignored (a run's own `run.csv` is a stroke file too). Commas,
//! semicolons or tabulators separate them; numbers may have decimal commas where commas do not separate. Sampling may
//! be uneven, empty cells are gaps, lines that start with `#`, `%` or `//` are comments, and a row below the header may
//! state the units.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use super::ROLES;
use super::columns::{Column, Columns, Layout};
use super::recording::{Builder, Dialect, Recording, count};
use super::rows::{Place, Row, Rows, excerpt};
use super::{Role, Series, StrokeError};
use crate::files::shown;

/// How far a header is looked for that was asked for by its titles, rows.
const LOWEST_HEADER: usize = 200;

impl Series {
    /// Reads a stroke file from disk.
    ///
    /// # Errors
    /// The first thing that is wrong, with line and column; also when the file cannot be read.
    pub fn load(path: &Path) -> Result<Self, Box<StrokeError>> {
        Self::read_opened(File::open(path), &shown(path))
    }

    /// Reads a stroke file that has been opened, or says why it could not be; `file_name` appears in errors only.
    ///
    /// # Errors
    /// As [`Series::load`].
    pub(crate) fn read_opened(file: std::io::Result<impl Read>, file_name: &str) -> Result<Self, Box<StrokeError>> {
        interpolated(&Recording::read_opened(file, file_name, &Columns::default())?, file_name)
    }

    /// Reads the text of a stroke file; `file_name` appears in errors only.
    ///
    /// # Errors
    /// The first thing that is wrong, with line and column.
    pub fn parse(text: &str, file_name: &str) -> Result<Self, Box<StrokeError>> {
        Self::read(text.as_bytes(), file_name)
    }

    /// Reads a stroke file from any reader, a row at a time; `file_name` appears in errors only.
    ///
    /// # Errors
    /// The first thing that is wrong, with line and column.
    pub fn read(reader: impl Read, file_name: &str) -> Result<Self, Box<StrokeError>> {
        interpolated(&Recording::read(reader, file_name, &Columns::default())?, file_name)
    }
}

/// The rows are checked: what the interpolants could still refuse belongs to no line.
fn interpolated(recording: &Recording, file_name: &str) -> Result<Series, Box<StrokeError>> {
    let place = Place { file: file_name.to_owned(), line: 0 };
    recording.series().map_err(|error| place.whole_file(error.to_string(), ""))
}

impl Recording {
    /// Reads a recording that has been opened, or says why it could not be; `file_name` appears in errors only.
    ///
    /// # Errors
    /// The first thing that is wrong, with line and column.
    pub fn read_opened(
        file: std::io::Result<impl Read>,
        file_name: &str,
        columns: &Columns,
    ) -> Result<Self, Box<StrokeError>> {
        match file {
            Ok(file) => Self::read(file, file_name, columns),
            Err(error) => {
                Err(Place { file: file_name.to_owned(), line: 0 }.whole_file(format!("cannot be read: {error}"), ""))
            }
        }
    }

    /// Reads a recording from any reader, a row at a time; `file_name` appears in errors only.
    ///
    /// # Errors
    /// The first thing that is wrong, with line and column.
    pub fn read(reader: impl Read, file_name: &str, columns: &Columns) -> Result<Self, Box<StrokeError>> {
        let mut rows = Rows::new(reader, file_name);
        let mut header = Header::find(&mut rows, columns)?;
        let mut builder = None;
        let mut numbers = Numbers::default();
        if let Some(first) = header.first_row.take() {
            let mut begun = Builder::new(header.checked_layout()?);
            let place = header.place.clone();
            let cells = numbers.row(begun.columns(), &place, first.len(), &|index| &first[index])?;
            begun.push(&place, cells)?;
            builder = Some(begun);
        }
        while let Some(row) = rows.next()? {
            let builder = match &mut builder {
                Some(builder) => builder,
                None => {
                    // Units may stand in a row of their own.
                    let cells: Vec<&str> = (0..row.len()).map(|index| row.cell(index)).collect();
                    if header.layout.take_units(&cells) {
                        builder = Some(Builder::new(header.checked_layout()?));
                        continue;
                    }
                    builder.insert(Builder::new(header.checked_layout()?))
                }
            };
            if !fits(row, header.width) {
                let message = "this row does not fit the header";
                return Err(row.place.fault("", message, count(row.len(), "cell"), count(header.width, "cell")));
            }
            let cells = numbers.row(builder.columns(), row.place, row.len(), &|index| row.cell(index))?;
            builder.push(row.place, cells)?;
        }
        let builder = match builder {
            Some(builder) => builder,
            None => Builder::new(header.checked_layout()?),
        };
        let dialect = Dialect {
            separator: rows.separator.map(char::from),
            decimal_comma: numbers.mark == Some(','),
            skipped_rows: header.skipped,
        };
        builder.finish(&header.place, dialect)
    }
}

/// Whether a row has as many cells as the header; more may follow that are empty.
fn fits(row: Row<'_>, width: usize) -> bool {
    row.len() >= width && (width..row.len()).all(|index| row.cell(index).is_empty())
}

/// The header, and where it was found.
struct Header {
    layout: Layout,
    width: usize,
    place: Place,
    /// Rows above it that were passed over.
    skipped: usize,
    /// Without a header: the first row.
    first_row: Option<Vec<String>>,
}

impl Header {
    fn find<R: Read>(rows: &mut Rows<R>, columns: &Columns) -> Result<Self, Box<StrokeError>> {
        let mut first_fault = None;
        for skipped in 0..LOWEST_HEADER {
            let Some(row) = rows.next()? else { break };
            let titles: Vec<&str> = (0..row.len()).map(|index| row.cell(index)).collect();
            let place = row.place.clone();
            let separator = row.separator;
            let has_no_titles = columns.need_no_titles() && titles.iter().any(|cell| number(cell).is_some());
            if !columns.name_titles() || columns.are_among(&titles) {
                let layout = Layout::find(&titles, columns, &place)?;
                let width = width(&titles);
                let first_row = has_no_titles.then(|| titles.iter().map(|&cell| cell.to_owned()).collect());
                rows.separator = Some(separator);
                return Ok(Header { layout, width, place, skipped, first_row });
            }
            // The fault of the first such row is reported.
            if first_fault.is_none() {
                first_fault = Layout::find(&titles, columns, &place).err();
            }
        }
        let expected = "a header `time_s,force_N` or `time_s,position_m`";
        Err(first_fault.unwrap_or_else(|| rows.place().whole_file("the file is empty", expected)))
    }

    fn checked_layout(&self) -> Result<Layout, Box<StrokeError>> {
        self.layout.check_units(&self.place)?;
        Ok(self.layout.clone())
    }
}

/// Cells without the empty ones at the end.
fn width(titles: &[&str]) -> usize {
    titles.iter().rposition(|title| !title.is_empty()).map_or(titles.len(), |last| last + 1)
}

/// Reads cells as numbers, all with the same decimal mark.
#[derive(Default)]
struct Numbers {
    mark: Option<char>,
}

impl Numbers {
    /// The numbers of a row's cells; `None` is an empty one, or one that is NaN.
    fn row<'a>(
        &mut self,
        columns: &[Column],
        place: &Place,
        cells: usize,
        cell: &dyn Fn(usize) -> &'a str,
    ) -> Result<[Option<f64>; ROLES.len()], Box<StrokeError>> {
        let mut row = [None; ROLES.len()];
        for (column, into) in columns.iter().zip(&mut row) {
            let text = if column.index < cells { cell(column.index) } else { "" };
            if text.is_empty() {
                continue;
            }
            let fault =
                |message: &str, expected: &str| Err(place.fault(&column.title, message, excerpt(text), expected));
            let Some((value, mark)) = number(text) else {
                return fault("not a number", "a number such as 0.25");
            };
            // What NumPy and others write where nothing was sampled, as in Parquet; an instant is needed in every row.
            if value.is_nan() && column.role != Role::Time {
                continue;
            }
            if !value.is_finite() {
                return fault("not a finite number", "a finite number");
            }
            match (self.mark, mark) {
                (Some(before), Some(now)) if before != now => {
                    let expected = format!("`{before}` before the decimals, as above");
                    return fault("decimal commas and decimal points in one file", &expected);
                }
                (None, Some(now)) => self.mark = Some(now),
                _ => {}
            }
            *into = Some(value);
        }
        Ok(row)
    }
}

/// A number, with its decimal mark where it has one. One comma is a decimal one; thousands are not set apart.
fn number(text: &str) -> Option<(f64, Option<char>)> {
    if !text.contains(',') {
        return text.parse().ok().map(|value| (value, text.contains('.').then_some('.')));
    }
    if text.contains('.') || text.matches(',').count() > 1 {
        return None;
    }
    text.replace(',', ".").parse().ok().map(|value| (value, Some(',')))
}

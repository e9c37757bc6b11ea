//! Tables with a row for each key, as written by spreadsheets.

use erard::parameter::{Bare, Quantity};
use std::fmt;

use erard::keyboard::{KEYS, key_named};

use super::leads::Lead;

/// First error in a table: its place, what was found and what is expected.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MeasuredError {
    /// The file's name as the caller gave it.
    pub file: String,
    /// Line, from 1; 0 for the file as a whole.
    pub line: usize,
    /// Column; empty if the error belongs to none.
    pub column: String,
    /// Error, in words.
    pub message: String,
    /// Expected text.
    pub expected: String,
}

impl fmt::Display for MeasuredError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file)?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
        }
        if !self.column.is_empty() {
            write!(f, ": column `{}`", self.column)?;
        }
        write!(f, ": {}; expected {}", self.message, self.expected)
    }
}

impl std::error::Error for MeasuredError {}

impl MeasuredError {
    /// Makes errors of a file from line, column, error and expected text.
    pub(crate) fn in_file(file: &str) -> impl Fn(usize, &str, String, String) -> Self {
        |line, column, message, expected| MeasuredError {
            file: file.to_owned(),
            line,
            column: column.to_owned(),
            message,
            expected,
        }
    }
}

/// A table's rows, by key.
#[derive(Debug)]
pub(crate) struct KeyRows {
    /// The header's line, from 1.
    pub header_line: usize,
    /// Column names, in lower case with underscores.
    pub names: Vec<String>,
    /// The rows, in the order of the file.
    pub rows: Vec<KeyRow>,
}

/// Names of the columns that say which key a row is of.
const KEY_NAMES: [&str; 6] = ["key", "key_number", "number", "nr", "no", "n"];

/// A row.
#[derive(Debug)]
pub(crate) struct KeyRow {
    /// Line in the file, from 1.
    pub line: usize,
    /// The key, from 1.
    pub key: usize,
    /// Cells of the row, with decimal points.
    pub cells: Vec<String>,
    /// Leads of the column `leads`.
    pub leads: Vec<Lead>,
}

impl KeyRows {
    /// Returns the names of columns that are neither the key's nor the leads', nor known to the caller.
    pub(crate) fn unused(&self, is_known: impl Fn(&str) -> bool) -> Vec<String> {
        let is_own = |name: &str| KEY_NAMES.contains(&name) || ["note", "leads", ""].contains(&name);
        self.names.iter().filter(|name| !is_own(name) && !is_known(name)).cloned().collect()
    }

    /// Returns the index of the column with any of these names.
    ///
    /// # Errors
    /// A name that appears twice.
    pub(crate) fn column(&self, wanted: &[&str]) -> Result<Option<usize>, String> {
        let mut found = self.names.iter().enumerate().filter(|(_, name)| wanted.contains(&name.as_str()));
        let first = found.next().map(|(index, _)| index);
        found.next().map_or(Ok(first), |(_, name)| Err(name.clone()))
    }
}

/// Reads a table: a header that names `key` (1 to 88, or a note) or `note` (A0 to C8). Cells end at commas, or at
/// semicolons or tabs if the header has one, and then decimals may have commas. Lines that begin with `#` are comments.
/// `leads` are grams at millimetres in front of the balance pin, such as `14@165 14@147`. `header` is an example for
/// errors.
///
/// # Errors
/// The first error, with line and column.
pub(crate) fn rows_of_keys(text: &str, file: &str, header: &str) -> Result<KeyRows, MeasuredError> {
    let fault = MeasuredError::in_file(file);
    let text = text.trim_start_matches('\u{feff}');
    let mut lines = text
        .lines()
        .enumerate()
        .map(|(index, line)| (index + 1, line))
        .filter(|(_, line)| !line.trim().is_empty() && !line.trim_start().starts_with('#'));
    let expected_header = || format!("a header such as `{header}`");
    let Some((header_line, first)) = lines.next() else {
        return Err(fault(0, "", "the file is empty".into(), expected_header()));
    };
    let closed = |row: &str, line: usize| match row.matches('"').count() % 2 {
        0 => Ok(()),
        _ => Err(fault(line, "", "a quote is not closed on its line".into(), "`\"` at the end of a cell".into())),
    };
    closed(first, header_line)?;
    let separator = if first.contains('\t') {
        '\t'
    } else if first.contains(';') {
        ';'
    } else {
        ','
    };
    let names = first.split(separator).map(cell).map(|name| name.to_lowercase().replace([' ', '-'], "_")).collect();
    let mut table = KeyRows { header_line, names, rows: Vec::new() };
    let at = |wanted: &[&str]| {
        let twice = |name: String| fault(header_line, &name, "named twice".into(), "one column of each kind".into());
        table.column(wanted).map_err(twice)
    };
    let (key_at, note_at) = (at(&KEY_NAMES)?, at(&["note"])?);
    let leads_at = at(&["leads"])?;
    if key_at.is_none() && note_at.is_none() {
        return Err(fault(header_line, "", "no column says which key a row is of".into(), expected_header()));
    }
    let mut rows: Vec<KeyRow> = Vec::new();
    for (line, row) in lines {
        closed(row, line)?;
        let cells: Vec<&str> = row.split(separator).map(cell).collect();
        if cells.len() < table.names.len() {
            let message =
                format!("{} cells where the header has {}: the row is cut short", cells.len(), table.names.len());
            return Err(fault(line, "", message, "a cell for every column, empty where nothing was measured".into()));
        }
        if cells.len() > table.names.len() {
            let message = format!("{} cells where the header has {}", cells.len(), table.names.len());
            let expected = "a cell for every column; decimals with a point, or semicolons between cells".into();
            return Err(fault(line, "", message, expected));
        }
        let text_at = |index: Option<usize>| index.and_then(|index| cells.get(index)).copied().unwrap_or("");
        let key = key_of(text_at(key_at), text_at(note_at)).map_err(|(column, found)| {
            fault(
                line,
                column,
                format!("`{found}` is not a key"),
                format!("a number from 1 to {KEYS}, or a note from A0 to C8"),
            )
        })?;
        if let Some(other) = rows.iter().find(|known| known.key == key) {
            let message = format!("key {key} is already in line {}", other.line);
            return Err(fault(line, "", message, "every key once".into()));
        }
        let leads = leads(text_at(leads_at), separator).map_err(|found| {
            fault(line, "leads", format!("`{found}`"), "grams at millimetres, as in `14@165 14@147`".into())
        })?;
        let decimal = |cell: &str| if separator == ',' { cell.to_owned() } else { cell.replace(',', ".") };
        rows.push(KeyRow { line, key, cells: cells.into_iter().map(decimal).collect(), leads });
    }
    if rows.is_empty() {
        return Err(fault(0, "", "it names no key".into(), "a row for each key that was weighed".into()));
    }
    table.rows = rows;
    Ok(table)
}

fn cell(text: &str) -> &str {
    text.trim().trim_matches('"').trim()
}

/// Reads a weight in g, which is also the unit of a number without one.
pub(super) fn number(text: &str) -> Option<f64> {
    Quantity::Weight.read_in(text, "g").ok()
}

/// Reads a length in mm, which is also the unit of a number without one.
pub(super) fn length(text: &str) -> Option<f64> {
    Quantity::Length.read_in(text, "mm").ok()
}

/// Reads a number without a unit.
pub(super) fn ratio(text: &str) -> Option<f64> {
    Quantity::Number.read(text, Bare::Si).ok()
}

/// Returns the key by its number or note; else the column and text at fault.
fn key_of<'t>(number: &'t str, note: &'t str) -> Result<usize, (&'static str, &'t str)> {
    let (column, text) = if !number.is_empty() || note.is_empty() { ("key", number) } else { ("note", note) };
    key_named(text).ok_or((column, text))
}

fn leads(text: &str, separator: char) -> Result<Vec<Lead>, String> {
    let text = if separator == ',' { text.to_owned() } else { text.replace(',', ".") };
    text.split_whitespace().map(|one| Lead::read(one).ok_or_else(|| one.to_owned())).collect()
}

//! A table in lines of a terminal.

use std::fmt::{self, Write};

use super::Table;

/// The widest that a table is printed, characters; 80 wherever it can be.
pub(crate) const WIDEST: usize = 100;
/// The narrowest that a last column of words is wrapped to.
const NARROWEST: usize = 24;

/// A column as people see it.
pub(super) struct Shown<'t> {
    pub head: &'t str,
    pub cells: Vec<String>,
    /// Whether it is of numbers.
    pub right: bool,
    width: usize,
}

impl Table<'_> {
    pub(super) fn shown(&self) -> Vec<Shown<'_>> {
        let columns = self.columns.iter().map(|(name, cells)| {
            let cell = |row: usize| {
                let mut text = String::new();
                cells.write(row, &mut text);
                text
            };
            let cells: Vec<String> = (0..self.rows()).map(cell).collect();
            // A name of a note among weights stands at the right as they do; a sentence among numbers puts all of them
            // at the left.
            let (numbers, words): (Vec<&String>, Vec<&String>) =
                cells.iter().filter(|cell| !cell.is_empty() && *cell != "-").partition(|cell| is_number(cell));
            let widest = |cells: &[&String]| cells.iter().map(|cell| wide(cell)).max().unwrap_or(0);
            let right = numbers.len() > words.len() && widest(&words) <= widest(&numbers);
            Shown { head: name.as_ref(), cells, right, width: 0 }
        });
        let mut columns: Vec<Shown<'_>> = columns.collect();
        // A row of one word is a heading: it runs over the columns behind it.
        let alone =
            |row: usize| columns.len() > 1 && columns[1..].iter().all(|column| column.cells[row].trim().is_empty());
        let headings: Vec<bool> = (0..self.rows()).map(alone).collect();
        for column in &mut columns {
            let cells =
                column.cells.iter().zip(&headings).filter(|(_, heading)| !**heading).map(|(cell, _)| wide(cell));
            column.width = cells.fold(wide(column.head), usize::max);
        }
        columns
    }
}

/// Whether a cell begins as a number does, and is at most a number, a unit and a mark.
fn is_number(cell: &str) -> bool {
    let bare = cell.trim_start_matches(['+', '-', '<', '>', ' ']);
    let is_long = cell.contains('(') || cell.split_whitespace().count() > 3;
    bare.starts_with(|c: char| c.is_ascii_digit()) && !is_long
}

fn wide(text: &str) -> usize {
    text.chars().count()
}

/// Lines of two spaces, then columns two spaces apart; a head only where one is named. A last column of words that
/// would be beyond the edge is wrapped.
impl fmt::Display for Table<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = self.shown();
        let Some((last, others)) = columns.split_last() else { return Ok(()) };
        let before: usize = 2 + others.iter().map(|column| column.width + 2).sum::<usize>();
        let room = WIDEST.saturating_sub(before).max(NARROWEST);
        let mut line = |cell: &dyn Fn(&Shown<'_>) -> String| {
            let mut text = String::from("  ");
            for column in others {
                let (cell, width) = (cell(column), column.width);
                // Writing to a string does not fail.
                let _ = if column.right { write!(text, "{cell:>width$}  ") } else { write!(text, "{cell:<width$}  ") };
            }
            let cell = cell(last);
            if last.right {
                return writeln!(f, "{text}{cell:>0$}", last.width);
            }
            for (at, part) in wrapped(&cell, room).iter().enumerate() {
                let start = if at == 0 { text.clone() } else { " ".repeat(before) };
                writeln!(f, "{}", format!("{start}{part}").trim_end())?;
            }
            Ok(())
        };
        if columns.iter().any(|column| !column.head.is_empty()) {
            line(&|column| column.head.to_owned())?;
        }
        (0..self.rows()).try_for_each(|row| line(&|column| column.cells[row].clone()))
    }
}

/// Words in lines of at most so many characters, one line at least.
pub(crate) fn wrapped(text: &str, room: usize) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split(' ') {
        let line = lines.last_mut().filter(|line| line.is_empty() || wide(line) + 1 + wide(word) <= room);
        match line {
            Some(line) if line.is_empty() => line.push_str(word),
            Some(line) => *line += &format!(" {word}"),
            None => lines.push(word.to_owned()),
        }
    }
    lines
}

/// The shortest text that reads back as the same number.
pub(super) fn shortest(x: f64, text: &mut String) {
    // Writing to a string does not fail.
    let _ = if x != 0.0 && (x.abs() < 1e-4 || x.abs() >= 1e9) { write!(text, "{x:e}") } else { write!(text, "{x}") };
}

/// Three digits that count.
pub fn three(x: f64) -> String {
    let decimals = (2 - x.abs().max(1e-9).log10().floor() as i32).clamp(0, 3);
    format!("{x:.*}", decimals as usize)
}

/// A number with so many decimals; a dash where there is none.
pub(crate) fn decimal(value: Option<f64>, decimals: usize) -> String {
    // Adding zero turns -0 into 0.
    value.filter(|x| x.is_finite()).map_or("-".to_owned(), |x| format!("{:.decimals$}", x + 0.0))
}

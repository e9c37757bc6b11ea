//! A table in lines of a terminal.

use std::fmt::{self, Write};

use erard_workshop::digits::plain;

use super::Table;

/// The widest that a table is printed, characters; [`USUAL`] wherever it can be.
pub(crate) const MAX_WIDTH: usize = 100;
/// The width of text, and of tables that fit, characters: a terminal's.
pub(crate) const USUAL: usize = 80;
/// The narrowest that a column of words is wrapped to, so that a table is as wide as [`USUAL`], and as [`MAX_WIDTH`].
const NARROWEST: [(usize, usize); 4] = [(USUAL, 32), (USUAL, 22), (MAX_WIDTH, 24), (MAX_WIDTH, 12)];

/// A count with its noun, to which an s is added where there are several: `1 key`, `2 keys`.
pub(crate) fn many(count: usize, noun: &str) -> String {
    format!("{count} {noun}{}", if count == 1 { "" } else { "s" })
}

/// A column as people see it.
pub(super) struct Shown<'t> {
    pub head: &'t str,
    pub cells: Vec<String>,
    /// Whether it is of numbers.
    pub right: bool,
    /// Its widest cell, headings of rows left out.
    cell: usize,
    /// Its widest word, with the indent of its cell.
    word: usize,
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
            Shown { head: name.as_ref(), cells, right, cell: 0, word: 0 }
        });
        let mut columns: Vec<Shown<'_>> = columns.collect();
        let headings: Vec<bool> = (0..self.rows()).map(|row| is_heading(&columns, row)).collect();
        for column in &mut columns {
            let cells = column.cells.iter().zip(&headings).filter(|(_, heading)| !**heading);
            let cells = cells.map(|(cell, _)| (wide(cell), further(cell) + widest_word(cell)));
            (column.cell, column.word) = cells.fold((0, 0), |a, b| (a.0.max(b.0), a.1.max(b.1)));
        }
        columns
    }
}

/// Whether a row has one word only: it is a heading, and runs over the columns behind it.
pub(super) fn is_heading(columns: &[Shown<'_>], row: usize) -> bool {
    columns.len() > 1 && columns[1..].iter().all(|column| column.cells[row].trim().is_empty())
}

impl Shown<'_> {
    /// The width of its cells and its head as they are.
    fn natural(&self) -> usize {
        self.cell.max(wide(self.head))
    }

    /// The narrowest that it can be with its head wrapped.
    fn head_wrapped(&self) -> usize {
        widest_word(self.head).max(self.cell)
    }

    /// The narrowest that it can be with its words wrapped, too, but for `least` characters.
    fn words_wrapped(&self, least: usize) -> usize {
        let words = self.head_wrapped().min(least).max(self.word).max(widest_word(self.head));
        if self.right { self.head_wrapped() } else { words }
    }

    /// A cell or the head in lines of at most so many characters; what goes on begins two characters further in.
    fn lines(text: &str, width: usize) -> Vec<String> {
        if wide(text) <= width {
            return vec![text.to_owned()];
        }
        let (first, further) = (" ".repeat(indent(text)), " ".repeat(further(text)));
        let room = width.saturating_sub(further.len()).max(1);
        let parts = wrapped(text.trim_start(), room).into_iter().enumerate();
        parts.map(|(at, part)| format!("{}{part}", if at == 0 { &first } else { &further })).collect()
    }
}

/// Blanks before a cell's words.
fn indent(text: &str) -> usize {
    text.len() - text.trim_start().len()
}

/// Blanks before what goes on of a cell: two more, where there are any.
fn further(text: &str) -> usize {
    if indent(text) > 0 { indent(text) + 2 } else { 0 }
}

fn widest_word(text: &str) -> usize {
    text.split(' ').map(wide).max().unwrap_or(0)
}

/// The widths of columns: their natural ones in a table of at most [`USUAL`] characters; else heads are wrapped, then
/// words, the widest first.
fn widths(columns: &[Shown<'_>]) -> Vec<usize> {
    let total = |widths: &[usize]| 2 * widths.len() + widths.iter().sum::<usize>();
    let mut widths: Vec<usize> = Vec::new();
    for (room, least) in NARROWEST {
        widths = columns.iter().map(Shown::natural).collect();
        let floors: [Vec<usize>; 2] = [
            columns.iter().map(Shown::head_wrapped).collect(),
            columns.iter().map(|column| column.words_wrapped(least)).collect(),
        ];
        for floor in floors {
            while total(&widths) > room {
                let can = (0..widths.len()).filter(|&column| widths[column] > floor[column]);
                let Some(column) = can.max_by_key(|&column| widths[column]) else { break };
                widths[column] -= 1;
            }
        }
        if total(&widths) <= room {
            break;
        }
    }
    widths
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

/// Lines of two spaces, then columns two spaces apart; a head only if one is named. Heads and words wrap if the table
/// would be wider than a terminal.
impl fmt::Display for Table<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let columns = self.shown();
        let widths = widths(&columns);
        let mut row = |cells: Vec<Vec<String>>, is_head: bool| {
            let height = cells.iter().map(Vec::len).max().unwrap_or(0);
            for at in 0..height {
                let mut line = String::from("  ");
                for ((lines, &width), column) in cells.iter().zip(&widths).zip(&columns) {
                    // A head stands above its cells without a gap.
                    let above = if is_head { height - lines.len() } else { 0 };
                    let part = at.checked_sub(above).and_then(|at| lines.get(at)).map_or("", String::as_str);
                    // Writing to a string does not fail.
                    let _ =
                        if column.right { write!(line, "{part:>width$}  ") } else { write!(line, "{part:<width$}  ") };
                }
                writeln!(f, "{}", line.trim_end())?;
            }
            Ok(())
        };
        let lines = |text: &str, width: usize| Shown::lines(text, width);
        if columns.iter().any(|column| !column.head.is_empty()) {
            row(columns.iter().zip(&widths).map(|(column, &width)| lines(column.head, width)).collect(), true)?;
        }
        (0..self.rows()).try_for_each(|at| {
            if is_heading(&columns, at) {
                return row(vec![lines(&columns[0].cells[at], MAX_WIDTH - 2)], false);
            }
            row(columns.iter().zip(&widths).map(|(column, &width)| lines(&column.cells[at], width)).collect(), false)
        })
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

/// Three digits that count.
pub fn three(x: f64) -> String {
    let decimals = (2 - x.abs().max(1e-9).log10().floor() as i32).clamp(0, 3);
    format!("{x:.*}", decimals as usize)
}

/// A number with so many decimals; a dash where there is none.
pub(crate) fn decimal(value: Option<f64>, decimals: usize) -> String {
    value.filter(|x| x.is_finite()).map_or("-".to_owned(), |x| plain(x, decimals))
}

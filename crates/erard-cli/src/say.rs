//! Words for people: results on standard output, what goes wrong on standard error.
//!
//! Names and paths come from files and strangers. What could steer a terminal is shown by its code instead.

use std::io::{self, ErrorKind, IsTerminal, Write};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Mutex, PoisonError};

use erard::files::printable;

use crate::table::{USUAL, wrapped};

/// Whether words on standard output are left out.
static QUIET: AtomicBool = AtomicBool::new(false);
/// Whether the answer is wanted as JSON, in place of words.
static JSON: AtomicBool = AtomicBool::new(false);

/// The first thing that went wrong on standard output.
static FAULT: Mutex<Option<io::Error>> = Mutex::new(None);

/// Prints a line on standard output.
#[macro_export]
macro_rules! say {
    () => { $crate::say::line(String::new()) };
    ($($text:tt)*) => { $crate::say::line(format!($($text)*)) };
}

/// Prints a line on standard error.
#[macro_export]
macro_rules! tell {
    ($($text:tt)*) => { $crate::say::aside(format!($($text)*)) };
}

/// How this process tells its results: in words, as JSON, or not at all.
pub(crate) fn how(quiet: bool, json: bool) {
    QUIET.store(quiet, Relaxed);
    JSON.store(json, Relaxed);
}

/// Whether progress and words are left out.
pub(crate) fn is_quiet() -> bool {
    QUIET.load(Relaxed)
}

/// Whether the answer is wanted as JSON.
pub(crate) fn wants_json() -> bool {
    JSON.load(Relaxed)
}

/// Writes lines to standard output: sentences in the width of a terminal, rows of tables as they are; in colour what is
/// out of range, if a terminal shows it. `finish` reports what went wrong.
pub fn line(text: String) {
    if is_quiet() || wants_json() {
        return;
    }
    let is_coloured = shows_colour(&io::stdout());
    let lines: Vec<String> = folded(&printable(&text))
        .split('\n')
        .map(|line| if is_coloured { marked(line) } else { line.to_owned() })
        .collect();
    keep(writeln!(io::stdout(), "{}", lines.join("\n")));
}

/// Bytes on standard output as they are: a file, not words.
pub fn verbatim(text: &str) {
    keep(io::stdout().write_all(text.as_bytes()));
}

/// A line on standard error, folded if a terminal shows it: who searches a log finds a message in one line. Where even
/// that cannot be written, nobody is left to tell.
pub fn aside(text: String) {
    let mut text = printable(&text).into_owned();
    let stderr = io::stderr();
    // The excerpt of a file is a picture of its lines.
    if stderr.is_terminal() && !text.contains('\u{256d}') {
        text = folded(&text);
    }
    for (head, colour) in [("error:", RED), ("warning:", YELLOW)] {
        if let Some(rest) = text.strip_prefix(head)
            && shows_colour(&stderr)
        {
            text = format!("{colour}{head}{PLAIN}{rest}");
            break;
        }
    }
    let _ = writeln!(io::stderr(), "{text}");
}

const RED: &str = "\u{1b}[31m";
const YELLOW: &str = "\u{1b}[33m";
const PLAIN: &str = "\u{1b}[0m";

/// Whether colours belong there: on a terminal that has them, unless `NO_COLOR` says otherwise (no-color.org).
fn shows_colour(stream: &impl IsTerminal) -> bool {
    let is_set = |name: &str| std::env::var_os(name).is_some_and(|value| !value.is_empty());
    stream.is_terminal() && !is_set("NO_COLOR") && std::env::var_os("TERM").is_none_or(|term| term != "dumb")
}

/// Sentences folded to the width of a terminal, what goes on two characters further in. A line with a gap of two spaces
/// is a row of a table, and stays.
fn folded(text: &str) -> String {
    let fold = |line: &str| {
        let words = line.trim_start();
        if line.chars().count() <= USUAL || words.contains("  ") {
            return line.to_owned();
        }
        let indent = line.len() - words.len();
        let further = format!("\n{}", " ".repeat(indent + 2));
        format!("{}{}", &line[..indent], wrapped(words, USUAL.saturating_sub(indent + 2).max(20)).join(&further))
    };
    text.split('\n').map(fold).collect::<Vec<_>>().join("\n")
}

/// Cells of a row that are out of range, in red: those that end with the mark `!`, and the verdict `missed`.
fn marked(line: &str) -> String {
    let mut out = String::new();
    let mut rest = line;
    while !rest.is_empty() {
        let gap = rest.len() - rest.trim_start_matches(' ').len();
        let end = rest[gap..].find("  ").map_or(rest.len(), |end| gap + end);
        let cell = &rest[gap..end];
        out.push_str(&rest[..gap]);
        let is_out = cell == "!"
            || cell.ends_with(" !")
            || cell.starts_with("! ")
            || cell == "missed"
            || cell.starts_with("missed by");
        if is_out {
            out.push_str(&format!("{RED}{cell}{PLAIN}"));
        } else {
            out.push_str(cell);
        }
        rest = &rest[end..];
    }
    out
}

/// Keeps the first fault. A reader that has gone away, as in `erard check FILE | head -1`, has read enough: that is
/// none.
fn keep(result: io::Result<()>) {
    if let Err(error) = result
        && error.kind() != ErrorKind::BrokenPipe
    {
        FAULT.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }
}

/// Whether all that was said has arrived.
///
/// # Errors
/// The first fault of standard output.
pub(crate) fn finish() -> io::Result<()> {
    keep(io::stdout().flush());
    match FAULT.lock().unwrap_or_else(PoisonError::into_inner).take() {
        Some(source) => Err(source),
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::{folded, marked};

    #[test]
    fn sentences_are_folded_and_rows_are_not() {
        let sentence = format!("  {}", ["word"; 30].join(" "));
        let lines = folded(&sentence);
        assert!(lines.lines().all(|line| line.chars().count() <= 80) && lines.lines().count() == 2, "{lines}");
        assert!(lines.lines().nth(1).unwrap().starts_with("    word"), "{lines}");
        assert_eq!(lines.split_whitespace().count(), 30);
        let row = format!("  {}", ["word"; 30].join("  "));
        assert_eq!(folded(&row), row);
        assert_eq!(folded("a\n\nb\n"), "a\n\nb\n");
    }

    #[test]
    fn what_is_out_of_range_is_marked() {
        assert_eq!(
            marked("  down-weight D    55.9 g !  45.0-55.0"),
            "  down-weight D    \u{1b}[31m55.9 g !\u{1b}[0m  45.0-55.0"
        );
        assert_eq!(marked("  strings  58.0 g  !"), "  strings  58.0 g  \u{1b}[31m!\u{1b}[0m");
        assert_eq!(marked("    ! dip 11.3 mm"), "    \u{1b}[31m! dip 11.3 mm\u{1b}[0m");
        assert_eq!(marked("  up-weight U  24.7 g   20.0-25.0"), "  up-weight U  24.7 g   20.0-25.0");
    }
}

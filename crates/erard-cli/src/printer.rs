//! Words for people: results on standard output, what goes wrong on standard error.
//!
//! Names and paths come from files and strangers. What could steer a terminal is shown by its code instead.

use std::io::{self, ErrorKind, IsTerminal, Write};

use erard::files::printable;

use crate::table::{USUAL, wrapped};

/// How a program of this library reports its results.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, clap::Args)]
pub struct OutputMode {
    /// Print errors and warnings only; files are written as usual
    #[arg(long, global = true)]
    pub quiet: bool,
    /// Print the answer as JSON on standard output
    #[arg(long, global = true)]
    pub json: bool,
    /// Also print a BibTeX entry that cites the program as it made this answer: version, commit, command, digest
    #[arg(long, global = true, hide_short_help = true)]
    pub bibtex: bool,
    /// The rest of an answer after its first lines, too. A program whose answers have a rest has an option for it.
    #[arg(skip)]
    pub full: bool,
}

/// Prints a line on standard output.
#[macro_export]
macro_rules! print_line {
    ($session:expr) => { $session.printer.line(String::new()) };
    ($session:expr, $($text:tt)*) => { $session.printer.line(format!($($text)*)) };
}

/// Prints a line on standard error.
#[macro_export]
macro_rules! warn {
    ($session:expr, $($text:tt)*) => { $session.printer.aside(format!($($text)*)) };
}

/// Standard output and standard error of a session.
pub struct Printer {
    mode: OutputMode,
    out: Box<dyn Write>,
    is_coloured: bool,
    /// Whether lines belong to the rest of an answer.
    is_rest: bool,
    /// What the rest of the answer would add, where it was left out.
    left_out: Option<String>,
    /// The first thing that went wrong on standard output.
    fault: Option<io::Error>,
}

impl Printer {
    /// Prints on the standard streams of this process.
    pub(crate) fn standard(mode: OutputMode) -> Self {
        let out = io::stdout();
        let is_coloured = shows_colour(&out);
        Printer { mode, out: Box::new(out), is_coloured, is_rest: false, left_out: None, fault: None }
    }

    /// Prints nothing on standard output.
    #[cfg(test)]
    pub(crate) fn silent() -> Self {
        Printer {
            mode: OutputMode::default(),
            out: Box::new(io::sink()),
            is_coloured: false,
            is_rest: false,
            left_out: None,
            fault: None,
        }
    }

    /// Changes how results are reported.
    pub(crate) fn set_output_mode(&mut self, mode: OutputMode) {
        self.mode = mode;
    }

    /// Whether progress and words are left out.
    pub(crate) fn is_quiet(&self) -> bool {
        self.mode.quiet
    }

    /// Whether the answer is wanted as JSON.
    pub(crate) fn wants_json(&self) -> bool {
        self.mode.json
    }

    /// Whether a BibTeX entry is wanted beside the answer.
    pub(crate) fn wants_bibtex(&self) -> bool {
        self.mode.bibtex
    }

    /// Begins the rest of an answer: lines from here on are printed with `--full` only. `adds` says what they add.
    pub(crate) fn begin_rest(&mut self, adds: &str) {
        self.is_rest = true;
        if self.mode.full {
            self.line(String::new());
        } else {
            self.left_out = Some(adds.to_owned());
        }
    }

    /// Ends the rest of an answer.
    ///
    /// # Returns
    /// What it would have added, where it was left out.
    pub(crate) fn end_rest(&mut self) -> Option<String> {
        self.is_rest = false;
        self.left_out.take()
    }

    /// Whether the rest of an answer is printed, too.
    pub(crate) fn is_full(&self) -> bool {
        self.mode.full
    }

    /// Writes lines to standard output: sentences in the width of a terminal, rows of tables as they are; in colour
    /// what is out of range, if a terminal shows it. `finish` reports what went wrong.
    pub fn line(&mut self, text: String) {
        if self.is_quiet() || self.wants_json() || (self.is_rest && !self.mode.full) {
            return;
        }
        let lines: Vec<String> = folded(&printable(&text))
            .split('\n')
            .map(|line| if self.is_coloured { marked(line) } else { line.to_owned() })
            .collect();
        let written = writeln!(self.out, "{}", lines.join("\n"));
        self.keep(written);
    }

    /// Bytes on standard output as they are: a file, not words.
    pub(crate) fn verbatim(&mut self, text: &str) {
        let written = self.out.write_all(text.as_bytes());
        self.keep(written);
    }

    /// A line on standard error, folded if a terminal shows it.
    pub fn aside(&self, text: String) {
        aside(text);
    }

    /// Keeps the first fault. A reader that has gone away, as in `erard check FILE | head -1`, has read enough: that is
    /// none.
    fn keep(&mut self, result: io::Result<()>) {
        if let Err(error) = result
            && error.kind() != ErrorKind::BrokenPipe
        {
            self.fault.get_or_insert(error);
        }
    }

    /// Whether all that was printed has arrived.
    ///
    /// # Errors
    /// The first fault of standard output.
    pub(crate) fn finish(&mut self) -> io::Result<()> {
        let flushed = self.out.flush();
        self.keep(flushed);
        self.fault.take().map_or(Ok(()), Err)
    }
}

/// A line on standard error, folded if a terminal shows it: who searches a log finds a message in one line. Where even
/// that cannot be written, nobody is left to tell.
pub(crate) fn aside(text: String) {
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

//! A table's rows, one line at a time, with a bound on all that is held in memory.
//!
//! Own code rather than a CSV library: an error must name the right line, which libraries lose at blank lines and
//! comments, and a quote that is never closed must not swallow the rest of the file.

use std::io::{BufRead, BufReader, Read};
use std::ops::Range;

use super::StrokeError;

/// Most bytes that are read.
pub const MAX_BYTES: u64 = 1 << 30;
/// Longest line, bytes. Without a bound, a file that is not a table would end up in memory as one row.
const MAX_LINE_LENGTH: u64 = 1 << 16;
/// Longest excerpt that an error quotes, in characters.
const MAX_EXCERPT_LENGTH: usize = 60;

/// Beginnings of comments.
const COMMENTS: [&str; 3] = ["#", "%", "//"];

/// Reads rows: lines that are neither blank nor comments, split at commas, semicolons or tabulators. Line ends are LF
/// or CRLF.
pub(super) struct Rows<R> {
    reader: BufReader<R>,
    /// Separator of cells; until it is known, each row has its own.
    pub(super) separator: Option<u8>,
    bytes_left: u64,
    bytes: Vec<u8>,
    cells: Vec<Range<usize>>,
    place: Place,
}

/// Where a row stands, for errors.
#[derive(Debug, Clone)]
pub(super) struct Place {
    /// The file's name.
    pub file: String,
    /// The row's line, from 1.
    pub line: u64,
}

/// One row: cells without surrounding blanks and quotes.
#[derive(Clone, Copy)]
pub(super) struct Row<'r> {
    text: &'r str,
    cells: &'r [Range<usize>],
    /// Separator of cells.
    pub separator: u8,
    /// Place of the row in the file.
    pub place: &'r Place,
}

impl<'r> Row<'r> {
    /// The number of cells, one or more.
    pub(super) fn len(&self) -> usize {
        self.cells.len()
    }

    /// A cell; empty where the row has none.
    pub(super) fn cell(&self, index: usize) -> &'r str {
        self.cells.get(index).map_or("", |range| &self.text[range.clone()])
    }
}

impl<R: Read> Rows<R> {
    pub(super) fn new(reader: R, file: &str) -> Self {
        Self {
            reader: BufReader::with_capacity(1 << 16, reader),
            separator: None,
            bytes_left: MAX_BYTES,
            bytes: Vec::new(),
            cells: Vec::new(),
            place: Place { file: file.to_owned(), line: 0 },
        }
    }

    /// The next row, or `None` at the end of the file.
    pub(super) fn next(&mut self) -> Result<Option<Row<'_>>, Box<StrokeError>> {
        loop {
            self.bytes.clear();
            let limit = MAX_LINE_LENGTH.min(self.bytes_left) + 1;
            let count = (&mut self.reader)
                .take(limit)
                .read_until(b'\n', &mut self.bytes)
                .map_err(|error| self.place.whole_file(format!("cannot be read: {error}"), ""))?
                as u64;
            if count == 0 {
                return Ok(None);
            }
            self.place.line += 1;
            if count > self.bytes_left {
                return Err(self.place.whole_file(format!("larger than {} MiB", MAX_BYTES >> 20), ""));
            }
            if count > MAX_LINE_LENGTH {
                let message = format!("a line of more than {} KiB: this is not a table", MAX_LINE_LENGTH >> 10);
                return Err(self.place.fault("", message, "", ""));
            }
            self.bytes_left -= count;
            let line = self.bytes.trim_ascii_start();
            if !line.is_empty() && !COMMENTS.iter().any(|mark| line.starts_with(mark.as_bytes())) {
                break;
            }
        }
        let text = std::str::from_utf8(&self.bytes).map_err(|error| {
            let byte = self.bytes.get(error.valid_up_to()).copied().unwrap_or_default();
            self.place.fault("", "the file is not UTF-8", format!("the byte 0x{byte:02x}"), "text in UTF-8")
        })?;
        // Some programs begin their files with a byte order mark.
        let text = if self.place.line == 1 { text.trim_start_matches('\u{feff}') } else { text };
        let separator = self.separator.unwrap_or_else(|| separator(text));
        if !split(text, separator, &mut self.cells) {
            return Err(self.place.fault(
                "",
                "a quote is not closed on its line",
                excerpt(text),
                "`\"` at the end of a cell",
            ));
        }
        Ok(Some(Row { text, cells: &self.cells, separator, place: &self.place }))
    }

    /// The last row's place.
    pub(super) fn place(&self) -> &Place {
        &self.place
    }
}

/// Separator of the cells of a line: the most frequent one outside quotes; a semicolon or tab takes precedence over a
/// comma.
fn separator(text: &str) -> u8 {
    let mut counts = [(0, b','), (0, b';'), (0, b'\t')];
    let mut quoted = false;
    for byte in text.bytes() {
        quoted ^= byte == b'"';
        if let Some((count, _)) = counts.iter_mut().find(|(_, mark)| *mark == byte && !quoted) {
            *count += 1;
        }
    }
    // Of equals the last is taken.
    counts
        .into_iter()
        .max_by_key(|(count, _)| *count)
        .map_or(b',', |(count, mark)| if count == 0 { b',' } else { mark })
}

/// Splits a line at its separators, except those in quotes, and strips blanks and quotes; `false` when a quote stays
/// open.
fn split(text: &str, separator: u8, cells: &mut Vec<Range<usize>>) -> bool {
    cells.clear();
    let mut start = 0;
    let mut quoted = false;
    for (index, byte) in text.bytes().chain([separator]).enumerate() {
        match byte {
            byte if byte == separator && index == text.len() && quoted => return false,
            byte if byte == separator && !quoted => {
                let cell = text[start..index].trim();
                let cell = cell.strip_prefix('"').and_then(|cell| cell.strip_suffix('"')).unwrap_or(cell).trim();
                let offset = cell.as_ptr() as usize - text.as_ptr() as usize;
                cells.push(offset..offset + cell.len());
                start = index + 1;
            }
            b'"' => quoted = !quoted,
            _ => {}
        }
    }
    true
}

impl Place {
    /// A fault at this line.
    pub(super) fn fault(
        &self,
        column: &str,
        message: impl Into<String>,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> Box<StrokeError> {
        Box::new(StrokeError {
            file: self.file.clone(),
            line: self.line,
            column: column.to_owned(),
            message: message.into(),
            found: found.into(),
            expected: expected.into(),
        })
    }

    /// A fault of the file as a whole.
    pub(super) fn whole_file(&self, message: impl Into<String>, expected: &str) -> Box<StrokeError> {
        Place { file: self.file.clone(), line: 0 }.fault("", message, "", expected)
    }
}

/// One line, not too long, without control characters, in the quotes of an error message.
pub(super) fn excerpt(text: &str) -> String {
    let text = text.trim();
    let mut short: String = text.chars().filter(|c| !c.is_control()).take(MAX_EXCERPT_LENGTH).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    format!("`{short}`")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cells(text: &str) -> Option<Vec<&str>> {
        let mut ranges = Vec::new();
        split(text, separator(text), &mut ranges).then(|| ranges.into_iter().map(|range| &text[range]).collect())
    }

    #[test]
    fn lines_split_at_commas_outside_quotes() {
        assert_eq!(cells("a,b"), Some(vec!["a", "b"]));
        assert_eq!(cells(" a , \"b, c\" ,\r\n"), Some(vec!["a", "b, c", ""]));
        assert_eq!(cells(""), Some(vec![""]));
        assert_eq!(cells("\"\",\"é\""), Some(vec!["", "é"]));
        assert_eq!(cells("\"a\"\"b\",c"), Some(vec!["a\"\"b", "c"]));
        assert_eq!(cells("a,\"b"), None);
        assert_eq!(cells("\""), None);
        assert_eq!(cells("Time (s);\"F, raw\";0,5\n"), Some(vec!["Time (s)", "F, raw", "0,5"]));
        assert_eq!(cells("a\tb, c\td, e"), Some(vec!["a", "b, c", "d, e"]));
        assert_eq!(cells("a,b;c,d"), Some(vec!["a", "b;c", "d"]));
    }
}

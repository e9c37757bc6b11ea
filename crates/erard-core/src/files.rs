//! Files, and their names, with untrusted content.

use std::borrow::Cow;
use std::fmt;
use std::io::{self, Read};
use std::path::Path;

/// A path as messages show it: on one line, without control characters.
#[must_use]
pub fn shown(path: &Path) -> String {
    printable(&path.to_string_lossy()).replace('\n', "\\n").replace('\t', "\\t")
}

/// Text in which every character that would control a terminal or reverse the reading order is shown by its code. Line
/// ends and tabs stay.
#[must_use]
pub fn printable(text: &str) -> Cow<'_, str> {
    if !text.contains(steers) {
        return text.into();
    }
    let mut shown = String::with_capacity(text.len() + 16);
    for c in text.chars() {
        if steers(c) { shown.extend(c.escape_unicode()) } else { shown.push(c) }
    }
    shown.into()
}

/// Longest word of a message, in characters: no number, name or path that a person wrote is longer.
const MAX_WORD_LENGTH: usize = 1024;

/// A message in which overlong words are cut; their length is given.
#[must_use]
pub fn clipped(text: &str) -> Cow<'_, str> {
    let too_long = |word: &str| word.len() > MAX_WORD_LENGTH && word.chars().nth(MAX_WORD_LENGTH).is_some();
    if !text.split(char::is_whitespace).any(too_long) {
        return text.into();
    }
    let mut shown = String::new();
    for piece in text.split_inclusive(char::is_whitespace) {
        if too_long(piece) {
            shown.extend(piece.chars().take(40));
            shown.push_str(&format!("... ({} characters)", piece.trim_end().chars().count()));
            shown.extend(piece.chars().last().filter(|last| last.is_whitespace()));
        } else {
            shown.push_str(piece);
        }
    }
    shown.into()
}

/// Control characters, and the marks by which right-to-left text is embedded.
#[must_use]
pub fn steers(c: char) -> bool {
    (c.is_control() && !matches!(c, '\n' | '\t'))
        || matches!(c, '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

/// Writes the fault and, unless they are empty, the text found and the text expected.
pub(crate) fn write_fault(f: &mut fmt::Formatter<'_>, message: &str, found: &str, expected: &str) -> fmt::Result {
    match (found.is_empty(), expected.is_empty()) {
        (false, false) => write!(f, "{message} (found {found}, expected {expected})"),
        (false, true) => write!(f, "{message} (found {found})"),
        (true, false) => write!(f, "{message} (expected {expected})"),
        (true, true) => write!(f, "{message}"),
    }
}

/// The fault of a `format` that is not the one that is read, e.g. `erard-instrument/1`.
pub(crate) fn format_fault(found: &str, own: &str) -> String {
    let version = |text: &str| {
        let (kind, number) = text.rsplit_once('/')?;
        Some((kind.to_owned(), number.parse::<u32>().ok()?))
    };
    let is_later = version(found).zip(version(own)).is_some_and(|(found, own)| found.0 == own.0 && found.1 > own.1);
    let later = if is_later { ": a later version of Erard wrote it" } else { "" };
    format!("not a format that this version reads{later}")
}

/// Content of a reader; `None` if it has more than this many bytes. It reads no more bytes than that takes.
///
/// # Errors
/// An error of the reader.
pub(crate) fn read_at_most(reader: impl Read, bytes: usize) -> io::Result<Option<Vec<u8>>> {
    let mut held = Vec::new();
    reader.take(bytes as u64 + 1).read_to_end(&mut held)?;
    Ok((held.len() <= bytes).then_some(held))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_steers() {
        assert_eq!(printable("a\n\tb é"), "a\n\tb é");
        assert_eq!(printable("\u{1b}[31mred\u{202e}"), "\\u{1b}[31mred\\u{202e}");
        assert_eq!(shown(Path::new("a\nb\u{7}.toml")), "a\\nb\\u{7}.toml");
    }

    #[test]
    fn endless_words_are_cut() {
        let digits = "9".repeat(1_000_000);
        let cut = format!("{}... (1000000 characters)", "9".repeat(40));
        assert_eq!(clipped(&format!("found {digits} here")), format!("found {cut} here"));
        assert_eq!(clipped(&digits), cut);
        assert_eq!(clipped("short, \u{e9}  and\nplain"), "short, \u{e9}  and\nplain");
    }

    /// Only a higher number of the same kind is a later version's.
    #[test]
    fn a_later_format_is_called_so() {
        for (found, is_later) in [
            ("erard-x/2", true),
            ("erard-x/10", true),
            ("erard-x/1", false),
            ("erard-y/2", false),
            ("erard-x/two", false),
            ("x", false),
        ] {
            assert_eq!(format_fault(found, "erard-x/1").contains("a later version"), is_later, "{found}");
        }
    }

    #[test]
    fn endless_readers_end() {
        assert_eq!(read_at_most(&b"abc"[..], 3).unwrap(), Some(b"abc".to_vec()));
        assert_eq!(read_at_most(&b"abcd"[..], 3).unwrap(), None);
        assert_eq!(read_at_most(io::repeat(0), 1 << 20).unwrap(), None);
    }
}

//! Converts a byte range of a text to line, column and dotted path of the key.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use toml::de::{DeTable, DeValue};

use super::error::{Fault, FileError};

/// Longest excerpt of the file that an error quotes, in characters.
const MAX_EXCERPT_LENGTH: usize = 60;

/// Every key of a document with the spans of its name and of its value.
pub(crate) struct KeyMap {
    entries: Vec<(Range<usize>, Range<usize>, String)>,
    /// The entry whose name or value has exactly this span: of equal spans the last, which is the deepest.
    exact: HashMap<Range<usize>, usize>,
}

impl KeyMap {
    /// Reads the keys of `text`; a text that is not TOML has none.
    pub(crate) fn read(text: &str) -> Self {
        let mut entries = Vec::new();
        if let Ok(table) = DeTable::parse(text) {
            walk_table(table.get_ref(), "", &mut entries);
        }
        let spans =
            entries.iter().enumerate().flat_map(|(at, (name, value, _))| [name, value].map(|span| (span.clone(), at)));
        Self { exact: spans.collect(), entries }
    }

    /// Path of the narrowest key or value that contains `span`, or an empty string.
    pub(crate) fn key_at(&self, span: &Range<usize>) -> String {
        if let Some(&at) = self.exact.get(span) {
            return self.entries[at].2.clone();
        }
        let contains = |outer: &Range<usize>| outer.start <= span.start && span.end <= outer.end;
        self.entries
            .iter()
            .flat_map(|(name, value, path)| [(name, path), (value, path)])
            .filter(|(range, _)| contains(range))
            // Of equal spans the last is the deepest: children are entered after their parents.
            .rev()
            .min_by_key(|(range, _)| range.len())
            .map(|(_, path)| path.clone())
            .unwrap_or_default()
    }
}

fn walk_table(table: &DeTable<'_>, path: &str, entries: &mut Vec<(Range<usize>, Range<usize>, String)>) {
    for (name, value) in table {
        let path = if path.is_empty() { name.get_ref().to_string() } else { format!("{path}.{}", name.get_ref()) };
        entries.push((name.span(), value.span(), path.clone()));
        walk_value(value.get_ref(), &path, entries);
    }
}

fn walk_value(value: &DeValue<'_>, path: &str, entries: &mut Vec<(Range<usize>, Range<usize>, String)>) {
    match value {
        DeValue::Table(table) => walk_table(table, path, entries),
        DeValue::Array(array) => {
            for (index, element) in array.iter().enumerate() {
                // Numbers of a vector have the vector's path; each table of a list has a path of its own.
                let DeValue::Table(table) = element.get_ref() else {
                    continue;
                };
                let path = match table.get("name").map(|name| name.get_ref()) {
                    Some(DeValue::String(name)) if !name.is_empty() => format!("{path}.{name}"),
                    _ => format!("{path}[{}]", index + 1),
                };
                entries.push((element.span(), element.span(), path.clone()));
                walk_table(table, &path, entries);
            }
        }
        _ => {}
    }
}

/// Positions of a text's line breaks.
pub(crate) struct Lines {
    newlines: Vec<usize>,
}

impl Lines {
    /// Finds the line breaks of `text`.
    pub(crate) fn read(text: &str) -> Self {
        Self { newlines: text.match_indices('\n').map(|(at, _)| at).collect() }
    }

    /// The line of a byte, from 1.
    pub(crate) fn line_of(&self, byte: usize) -> usize {
        self.newlines.partition_point(|newline| *newline < byte) + 1
    }
}

/// Line and column (characters) of a byte of `text`, both from 1.
pub(crate) fn line_column(text: &str, byte: usize) -> (usize, usize) {
    let before = &text[..floor_char_boundary(text, byte)];
    let line_start = before.rfind('\n').map_or(0, |newline| newline + 1);
    (before.matches('\n').count() + 1, before[line_start..].chars().count() + 1)
}

/// Adds file, line and key to a fault.
pub fn dress(file: &str, text: &str, fault: Fault) -> Box<FileError> {
    let start = floor_char_boundary(text, fault.span.start);
    let end = floor_char_boundary(text, fault.span.end).max(start);
    let (line, column) = line_column(text, start);
    // A key that is missing at the top of the file has no place there, so it must not get the path of the first key.
    let is_whole_file = fault.child_key.is_some() && end == 0;
    let mut key = if is_whole_file { String::new() } else { KeyMap::read(text).key_at(&(start..end)) };
    if key.is_empty() && fault.child_key.is_none() {
        key = left_of_equals(text, start);
    }
    if let Some(child) = &fault.child_key
        && key.rsplit('.').next() != Some(child.as_str())
    {
        key = if key.is_empty() { child.clone() } else { format!("{key}.{child}") };
    }
    let found = fault.found.unwrap_or_else(|| excerpt(&text[start..end]));
    Box::new(FileError {
        file: file.to_owned(),
        line,
        column,
        key,
        message: fault.message,
        found,
        expected: fault.expected,
        span: start..end,
        text: Arc::from(text),
    })
}

/// Returns the key of a line that is not TOML: the text left of its `=`, or in the brackets of a table's header.
fn left_of_equals(text: &str, byte: usize) -> String {
    let start = text[..byte].rfind('\n').map_or(0, |newline| newline + 1);
    let line = text[start..].lines().next().unwrap_or_default();
    let name = match line.split_once('=') {
        Some((name, _)) => name.trim(),
        None if line.starts_with('[') => line.trim().trim_matches(['[', ']']),
        None => "",
    };
    if name.starts_with('#') || name.chars().count() > MAX_EXCERPT_LENGTH { String::new() } else { name.to_owned() }
}

/// Quotes a text on one line, cut to [`MAX_EXCERPT_LENGTH`] characters.
fn excerpt(text: &str) -> String {
    let mut words = text.split_whitespace().collect::<Vec<_>>().join(" ");
    if words.chars().count() > MAX_EXCERPT_LENGTH {
        words = words.chars().take(MAX_EXCERPT_LENGTH).collect::<String>() + "...";
    }
    if words.is_empty() { words } else { format!("`{words}`") }
}

/// The largest character boundary not after `byte`.
fn floor_char_boundary(text: &str, byte: usize) -> usize {
    let mut byte = byte.min(text.len());
    while !text.is_char_boundary(byte) {
        byte -= 1;
    }
    byte
}

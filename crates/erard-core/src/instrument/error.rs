//! Faults of an instrument file and their places in the text.

use std::ops::Range;
use std::sync::Arc;

/// A fault of an instrument file: its place, the text found and the text expected.
///
/// Every failure of [`Instrument::load`](super::Instrument::load) and [`Instrument::parse`](super::Instrument::parse) is
/// this type, so that a program can print it as one line (its `Display`) or underline `span` in `text`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct FileError {
    /// The file's name as the caller gave it.
    pub file: String,
    /// Line, counted from 1; 0 for a fault of the whole file, e.g. a file that is too large.
    pub line: usize,
    /// Column in characters, counted from 1; 0 with `line` 0.
    pub column: usize,
    /// Dotted path of the key, e.g. `body.jack.mass_g`: a table of a list appears by its name, or by its number if it
    /// has none. Empty when the fault belongs to no key.
    pub key: String,
    /// The fault, in a few words.
    pub message: String,
    /// Text found in the file; empty if there is none.
    pub found: String,
    /// Expected text; empty if `message` is complete.
    pub expected: String,
    /// Byte range of `text` to underline.
    pub span: Range<usize>,
    /// The file's text (with replacement characters where it is not UTF-8; empty when it could not be read).
    pub text: Arc<str>,
}

impl std::fmt::Display for FileError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.file)?;
        if self.line > 0 {
            write!(f, ":{}:{}", self.line, self.column)?;
        }
        write!(f, ": ")?;
        if !self.key.is_empty() {
            write!(f, "`{}`: ", self.key)?;
        }
        crate::files::write_fault(f, &self.message, &self.found, &self.expected)
    }
}

/// A fault whose place is a byte range of the text. [`FileError`] adds file, line and key.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Byte range of the text.
    pub span: Range<usize>,
    /// The fault.
    pub message: String,
    /// Text found; `None` takes the text under the span.
    pub found: Option<String>,
    /// Expected text.
    pub expected: String,
    /// Name of the key that is missing from the table at `span`, or that does not belong in it.
    pub child_key: Option<String>,
}

impl Fault {
    /// Creates a fault whose found text is the text under the span.
    pub fn at(span: Range<usize>, message: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { span, message: message.into(), found: None, expected: expected.into(), child_key: None }
    }

    /// Creates the fault of a required key that is missing from the table at `span`.
    pub(crate) fn missing(span: Range<usize>, key: &str, expected: impl Into<String>) -> Self {
        Self {
            span,
            message: format!("the key `{key}` is missing"),
            found: Some(String::new()),
            expected: expected.into(),
            child_key: Some(key.to_owned()),
        }
    }

    /// Replaces the message.
    pub(crate) fn message(mut self, message: impl Into<String>) -> Self {
        self.message = message.into();
        self
    }

    /// Replaces the text found; an empty one is not shown.
    pub(crate) fn found(mut self, found: impl Into<String>) -> Self {
        self.found = Some(found.into());
        self
    }
}

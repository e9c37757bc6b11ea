//! Faults of an instrument file, and where they are.

use std::ops::Range;
use std::sync::Arc;

/// The fault of an instrument file: its place, the text found and the text expected.
///
/// Every failure of [`Instrument::load`](super::Instrument::load) and [`Instrument::parse`](super::Instrument::parse) is
/// this type, so that a program can print it as one line (its `Display`) or underline `span` in `text`.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct FileError {
    /// The file's name as the caller gave it.
    pub file: String,
    /// Line, counted from 1; 0 when the file as a whole is meant (it cannot be read, it is too large).
    pub line: usize,
    /// Column in characters, counted from 1; 0 with `line` 0.
    pub column: usize,
    /// Dotted path of the key, tables of a list by their name where they have one: `body.jack.mass_g`. Empty when the
    /// fault belongs to no key.
    pub key: String,
    /// The fault, in a few words.
    pub message: String,
    /// Text found in the file; empty if there is none.
    pub found: String,
    /// Expected text; empty if `message` is complete.
    pub expected: String,
    /// Bytes of `text` to underline.
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

/// A fault that knows its place in the text only as a span; [`FileError`] is this plus file, line and key.
#[derive(Debug, Clone, PartialEq)]
pub struct Fault {
    /// Bytes of the text.
    pub span: Range<usize>,
    /// The fault.
    pub message: String,
    /// Text found; `None` takes the text under the span.
    pub found: Option<String>,
    /// Expected text.
    pub expected: String,
    /// Name of the key that is absent from the table at `span`, or that stands in it and should not.
    pub child_key: Option<String>,
}

impl Fault {
    /// A fault whose found text is what stands under the span.
    pub fn at(span: Range<usize>, message: impl Into<String>, expected: impl Into<String>) -> Self {
        Self { span, message: message.into(), found: None, expected: expected.into(), child_key: None }
    }

    /// A key that must stand in the table at `span` and does not.
    pub(crate) fn missing(span: Range<usize>, key: &str, expected: impl Into<String>) -> Self {
        Self {
            span,
            message: format!("the key `{key}` is missing"),
            found: Some(String::new()),
            expected: expected.into(),
            child_key: Some(key.to_owned()),
        }
    }

    /// The same fault in other words.
    pub(crate) fn message(mut self, message: impl Into<String>) -> Self {
        self.message = message.into();
        self
    }

    /// The same fault with another description of what was found; an empty one leaves it out.
    pub(crate) fn found(mut self, found: impl Into<String>) -> Self {
        self.found = Some(found.into());
        self
    }
}

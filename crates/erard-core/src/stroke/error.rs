//! Faults of a stroke file, and where they are.

/// The fault of a stroke file: its place, the text found and the text expected.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub struct StrokeError {
    /// The file's name as the caller gave it.
    pub file: String,
    /// Line, counted from 1; 0 when the file as a whole is meant.
    pub line: u64,
    /// Name of the column, e.g. `force_N`; empty when the fault belongs to no column.
    pub column: String,
    /// The fault, in a few words.
    pub message: String,
    /// Text found in the file; empty if there is none.
    pub found: String,
    /// Expected text; empty if `message` is complete.
    pub expected: String,
}

impl std::fmt::Display for StrokeError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.file)?;
        if self.line > 0 {
            write!(f, ":{}", self.line)?;
        }
        write!(f, ": ")?;
        if !self.column.is_empty() {
            write!(f, "column `{}`: ", self.column)?;
        }
        crate::files::write_fault(f, &self.message, &self.found, &self.expected)
    }
}

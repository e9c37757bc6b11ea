//! The fitted instrument as a file: the same text with new numbers.

use erard::instrument::{InstrumentFile, RewriteError, cited};
use erard::parameter::VaryError;
use thiserror::Error;

use super::FitResult;

/// Author of the new numbers in the file's list of sources, and the source's name there.
const AUTHOR: &str = "erard fit";
const SOURCE: &str = "fitted";

/// Why the fitted instrument cannot be written.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WriteError {
    /// The text cannot be changed.
    #[error(transparent)]
    Rewrite(#[from] RewriteError),
    /// The written file does not read back as the fitted instrument.
    #[error("the fitted instrument cannot be written: {0}")]
    Unlike(String),
}

impl FitResult {
    /// Returns `text`, the file of the fitted instrument, with the fitted values. Each is cited as fitted to these
    /// recordings, with its standard deviation in its note. The new text is checked by reading it again.
    ///
    /// # Errors
    /// See [`WriteError`].
    pub fn rewrite(&self, text: &str, recordings: &[&str]) -> Result<String, WriteError> {
        let file = InstrumentFile::parse(text, "instrument").map_err(|error| WriteError::Unlike(error.to_string()))?;
        let mut changes = Vec::new();
        let mut fitted = file.instrument.clone();
        for ((one, x), std) in self.parameters.iter().zip(&self.x).zip(&self.std) {
            let unlike =
                |error: VaryError| WriteError::Unlike(format!("{} cannot be varied by {x}: {error}", one.name));
            one.parameter.vary(&mut fitted, *x).map_err(unlike)?;
            let note = if std.is_nan() {
                "fitted: the recordings are too short for an error".to_owned()
            } else if one.parameter.is_factor() {
                format!("fitted: {x:.5} +- {std:.2} times the number before")
            } else {
                format!("fitted: turned by {x:.4e} +- {std:.1e} {}", one.unit())
            };
            changes.extend(
                one.parameter
                    .numbers(&file.instrument, *x, text)
                    .map_err(|error| unlike(error.into()))?
                    .into_iter()
                    .map(|(path, value)| (path, value, note.clone())),
            );
        }
        let title = format!("Fitted to {} ({} strokes played)", recordings.join(", "), self.evaluations);
        let new = cited(text, &changes, SOURCE, AUTHOR, &title)?;
        let read = InstrumentFile::parse(&new, "fitted").map_err(|error| WriteError::Unlike(error.to_string()))?;
        for one in &self.parameters {
            let value = |of: &erard::Instrument| {
                one.parameter.value(of).map_err(|error| WriteError::Unlike(format!("{}: {error}", one.name)))
            };
            let (wanted, found) = (value(&fitted)?, value(&read.instrument)?);
            if (wanted - found).abs() > 1e-9 * wanted.abs() + 1e-12 {
                return Err(WriteError::Unlike(format!("{} reads back as {found}, not {wanted}", one.name)));
            }
        }
        Ok(new)
    }
}

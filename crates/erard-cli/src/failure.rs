//! Failures of a command, each reported once and clearly on stderr.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use crate::excerpt::excerpt;
use crate::inputs::{clipped, shown};
use crate::{answer, say, signals, tell};
use erard::instrument::FileError;
use erard::one_dof::OneDofError;
use erard::run::SimulationError;
use erard::stroke::StrokeError;
use erard_workshop::compare::CompareError;
use erard_workshop::measure::MeasureError;
use erard_workshop::regulate::RegulateError;
use erard_workshop::worklist::WorklistError;

/// Why a command failed.
#[derive(Debug, thiserror::Error)]
pub enum Failure {
    /// An instrument file is wrong.
    #[error(transparent)]
    Instrument(#[from] Box<FileError>),
    /// A stroke file is wrong.
    #[error(transparent)]
    Stroke(#[from] Box<StrokeError>),
    /// A run cannot be made.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// No one-degree-of-freedom model follows.
    #[error(transparent)]
    OneDof(#[from] OneDofError),
    /// A comparison cannot be made.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// An action cannot be measured.
    #[error("{label}: {error}")]
    Measure {
        /// Name of the action.
        label: String,
        /// Why.
        error: MeasureError,
    },
    /// An action cannot be regulated.
    #[error(transparent)]
    Regulate(#[from] RegulateError),
    /// No list of work can be worked out.
    #[error(transparent)]
    Worklist(#[from] WorklistError),
    /// Goals that cannot be met; the nearest that can be has been written.
    #[error("{0}")]
    Unmet(String),
    /// A fit that is doubtful; it has been written.
    #[error("{0}")]
    Doubtful(String),
    /// Levers that do not reach as far as was asked; what they do reach has been written.
    #[error("{0}")]
    Reach(String),
    /// Arguments that do not fit together or name what is not there.
    #[error("{0}")]
    Usage(String),
    /// A file or folder cannot be written.
    #[error("{}: cannot be written: {source}", shown(path))]
    Write {
        /// Where.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Standard output cannot be written.
    #[error("standard output cannot be written: {0}")]
    Said(std::io::Error),
    /// Not the user's fault.
    #[error("{0}")]
    Internal(String),
}

/// What is written as records is records.
impl From<serde_json::Error> for Failure {
    fn from(error: serde_json::Error) -> Self {
        Failure::Internal(error.to_string())
    }
}

impl Failure {
    /// A file or folder that cannot be written.
    pub(crate) fn write(path: &Path, source: std::io::Error) -> Self {
        Failure::Write { path: path.to_path_buf(), source }
    }

    /// Prints the failure on stderr and gives the exit code: 2 for what the user can mend, 1
    /// otherwise: goals that were not met or a fit that is doubtful although everything went well, or a fault of the
    /// program.
    pub(crate) fn report(&self) -> ExitCode {
        signals::yield_to_the_end();
        let code = self.exit_code();
        let message = clipped(&self.to_string()).into_owned();
        tell!("error: {message}");
        // A command that failed although everything went well has answered.
        if say::wants_json() && !self.has_answered() {
            answer::print_error(&message, code);
        }
        if let Failure::Instrument(error) = self
            && let Some(excerpt) = excerpt(error)
        {
            tell!("{excerpt}");
        }
        ExitCode::from(code)
    }

    fn exit_code(&self) -> u8 {
        if self.has_answered() || matches!(self, Failure::Internal(_)) { 1 } else { 2 }
    }

    /// Whether all was done and written, and the failure is what came out.
    pub(crate) fn has_answered(&self) -> bool {
        matches!(self, Failure::Unmet(_) | Failure::Doubtful(_) | Failure::Reach(_))
    }
}

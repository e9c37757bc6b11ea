//! Failures of a command.

use std::path::{Path, PathBuf};

use crate::inputs::shown;
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
        error: Box<MeasureError>,
    },
    /// An action cannot be regulated.
    #[error(transparent)]
    Regulate(#[from] RegulateError),
    /// No list of work can be worked out.
    #[error(transparent)]
    Worklist(#[from] WorklistError),
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

    /// 2 for what the user can mend, 1 for a fault of the program.
    pub(crate) fn exit_code(&self) -> u8 {
        if matches!(self, Failure::Internal(_)) { 1 } else { 2 }
    }
}

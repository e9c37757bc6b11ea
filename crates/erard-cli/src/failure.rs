//! What can go wrong, said once and clearly on stderr.

use std::path::PathBuf;
use std::process::ExitCode;

use erard::instrument::FileError;
use erard::one_dof::OneDofError;
use erard::simulation::SimulationError;
use erard::stroke::StrokeError;
use erard_lab::compare::CompareError;
use erard_lab::reproduce::ReproduceError;
use erard_workshop::distances::DistanceError;
use erard_workshop::kinematics::DeriveError;
use erard_workshop::measure::MeasureError;
use erard_workshop::regulate::RegulateError;
use miette::{GraphicalReportHandler, GraphicalTheme, LabeledSpan, MietteDiagnostic, NamedSource, Report};

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
    /// Something cannot be reproduced.
    #[error(transparent)]
    Reproduce(#[from] ReproduceError),
    /// An instrument has no three levers.
    #[error(transparent)]
    Levers(#[from] DeriveError),
    /// An action cannot be measured.
    #[error("{label}: {error}")]
    Measure {
        /// Which.
        label: String,
        /// Why.
        error: MeasureError,
    },
    /// An action cannot be regulated.
    #[error(transparent)]
    Regulate(#[from] RegulateError),
    /// Goals that cannot be met; the nearest that can be has been written.
    #[error("{0}")]
    Unmet(String),
    /// Levers that do not reach as far as was asked; what they do reach has been written.
    #[error("{0}")]
    Reach(String),
    /// Arguments that do not fit together or name what is not there.
    #[error("{0}")]
    Usage(String),
    /// A file or folder cannot be written.
    #[error("{}: cannot be written: {source}", path.display())]
    Write {
        /// Where.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// Not the user's fault.
    #[error("{0}")]
    Internal(String),
}

impl Failure {
    /// Prints the failure on stderr and gives the exit code: 2 for what the user can mend, 130 for an
    /// interruption, 1 otherwise: goals that were not met although everything went well, or a fault of the program.
    pub fn report(&self) -> ExitCode {
        match self {
            Failure::Instrument(error) if !error.text.is_empty() => {
                eprintln!("error: {error}");
                eprintln!("{}", underlined(error));
            }
            _ => eprintln!("error: {self}"),
        }
        ExitCode::from(match self {
            Failure::Internal(_) | Failure::Unmet(_) => 1,
            Failure::Simulation(SimulationError::Interrupted)
            | Failure::Regulate(RegulateError::Measure(DistanceError::Interrupted))
            | Failure::Compare(CompareError::Simulation(SimulationError::Interrupted))
            | Failure::Reproduce(
                ReproduceError::Simulation(SimulationError::Interrupted)
                | ReproduceError::Compare(CompareError::Simulation(SimulationError::Interrupted)),
            ) => 130,
            Failure::Measure { error, .. } if error.is_interruption() => 130,
            _ => 2,
        })
    }
}

/// The wrong place in the file, underlined.
fn underlined(error: &FileError) -> String {
    let label = LabeledSpan::new_with_span(Some(error.message.clone()), error.span.clone());
    let mut diagnostic = MietteDiagnostic::new(error.message.clone()).with_label(label);
    if !error.expected.is_empty() {
        diagnostic = diagnostic.with_help(format!("expected {}", error.expected));
    }
    let report = Report::new(diagnostic).with_source_code(NamedSource::new(&error.file, error.text.to_string()));
    let mut out = String::new();
    let handler = GraphicalReportHandler::new_themed(GraphicalTheme::unicode_nocolor()).with_width(110);
    // A report that cannot be drawn is no reason to lose the message above it.
    let _ = handler.render_report(&mut out, report.as_ref());
    out
}

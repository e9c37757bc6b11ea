//! Fit of an instrument's parameters to recordings: least squares, and what the data determine.
//!
//! The recorded force or motion drives the model, and the other recorded columns are compared ([`Data`]). A
//! [`FitParameter`] varies within bounds. A [`Problem`] is the question: these parameters, these recordings. A
//! [`Simulator`] plays the recorded strokes at the solver's points, and a [`NoiseModel`] turns the readings into
//! residuals. [`fit()`] searches in stages: up to the impact, then all rows with coarse differences that smooth over
//! jumps, then with fine ones; and from other starts until two end at the same place. [`FitResult`] holds the
//! covariance (sensor noise, noise of the drive, misfit beyond both) and the directions that the data do not determine.
//!
//! The command `erard fit` and `erard.fit` in Python both use this code. A [`Solver`] minimises; Python can replace
//! [`TrustRegion`] by SciPy's.

mod candidate;
mod correlation;
mod data;
mod doubt;
mod doubts;
mod drive_noise;
mod impact;
mod jacobian;
mod meaning;
mod noise;
mod objective;
mod parameter;
mod plan;
mod problem;
mod readings;
mod result;
mod search;
mod simulator;
mod solver;
mod written;

pub use crate::dense::Columns;
pub use data::{COLUMNS, Data, misfit_unit};
pub use doubt::{Doubt, DoubtKind};
pub use jacobian::{DIFFERENCES, Jacobian, by_differences, by_gradient};
pub use noise::NoiseModel;
pub use parameter::{FitParameter, PerName, fit_parameters};
pub use plan::{MAX_EVALUATIONS, MAX_RESTARTS, Plan, Solution, Solver, TrustRegion};
pub use problem::{Problem, ResidualBlock};
pub use result::{FitResult, FittedChannel, Meaning};
pub use search::{fit, fit_by};
pub use simulator::{Channel, Progress, Simulator};
pub use solver::{LeastSquares, Loss};
pub use written::WriteError;

use crate::sensitivities::SensitivityError;
use erard::run::SimulationError;
use erard::stroke::DrivingError;
use thiserror::Error;

/// Reason why a fit is impossible.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum FitError {
    /// An argument is wrong.
    #[error("{argument}: {message}")]
    Argument {
        /// Argument: `parameters`, `bounds`, `start`, `columns`, `sigma`, `jacobian` or `recordings`.
        argument: &'static str,
        /// Text with found and expected values.
        message: String,
    },
    /// A recording cannot be fitted.
    #[error("{recording}: {message}")]
    Recording {
        /// Name of the recording.
        recording: String,
        /// Text with found and expected values.
        message: String,
    },
    /// A recording cannot drive the model as requested.
    #[error(transparent)]
    Driving(#[from] DrivingError),
    /// The instrument cannot be played at the start of the fit.
    #[error("the instrument cannot be played where the fit starts")]
    Unplayable,
    /// A setting of the steps, or an interruption.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// No derivatives are available.
    #[error(transparent)]
    Sensitivity(#[from] SensitivityError),
}

impl FitError {
    pub(crate) fn argument(argument: &'static str, message: impl Into<String>) -> Self {
        FitError::Argument { argument, message: message.into() }
    }

    /// Whether the caller asked to stop.
    pub fn is_interruption(&self) -> bool {
        use crate::cores::Ending;
        match self {
            FitError::Simulation(error) => error.is_interruption(),
            FitError::Sensitivity(error) => error.is_interruption(),
            _ => false,
        }
    }
}

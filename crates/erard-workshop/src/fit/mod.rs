//! Parameters of an instrument fitted to recordings: least squares, and what the data do and do not tell.
//!
//! Each recording drives the model by its force, or its motion, and what else was recorded is compared ([`Data`]). What
//! is free, and between which bounds, is a [`Free`] parameter; residuals and their Jacobian make a [`Problem`].
//! [`fit()`] solves it: first what leads to the impact, then all of it in differences that look past what jumps, then
//! finely, and from elsewhere again until two have ended alike. [`FitResult`] says what came of it: covariance (noise
//! of sensors and of what drives, misfit beyond both), and which directions nobody sees.
//!
//! The command `erard fit` and `erard.fit` in Python are both this code. A [`Solver`] minimises; Python can put SciPy's
//! in place of [`TrustRegion`].

mod candidate;
mod data;
mod doubt;
mod doubts;
mod drive_noise;
mod ends;
mod free;
mod impact;
mod jacobian;
mod meaning;
mod plan;
mod problem;
mod result;
mod solver;
mod svd;
mod written;

pub use plan::{Plan, Solution, Solver, TrustRegion, fit, fit_by};

pub use data::{COLUMNS, Data, misfit_unit};
pub use doubt::{Doubt, DoubtKind};
pub use free::{Asked, Free, free};
pub use jacobian::{DIFFERENCES, Jacobian};
pub use problem::{Channel, Problem};
pub use result::{FitResult, FittedChannel, Meaning};
pub use solver::{LeastSquares, Loss};
pub use svd::Columns;
pub use written::WriteError;

use crate::sensitivities::SensitivityError;
use erard::run::SimulationError;
use erard::stroke::DrivingError;
use thiserror::Error;

/// Why nothing can be fitted.
#[derive(Debug, Error)]
pub enum FitError {
    /// Something that was asked for is wrong.
    #[error("{argument}: {message}")]
    Asked {
        /// Name: `vary`, `bounds`, `start`, `columns`, `sigma`, `jacobian` or `recordings`.
        argument: &'static str,
        /// Found and expected text.
        message: String,
    },
    /// A recording cannot be fitted.
    #[error("{recording}: {message}")]
    Recording {
        /// Its name.
        recording: String,
        /// Found and expected text.
        message: String,
    },
    /// A recording cannot drive so.
    #[error(transparent)]
    Driving(#[from] DrivingError),
    /// Nothing can be played where the fit starts.
    #[error("the instrument cannot be played where the fit starts")]
    Unplayable,
    /// A setting of the steps, or an interruption.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// No derivatives.
    #[error(transparent)]
    Sensitivity(#[from] SensitivityError),
}

impl FitError {
    pub(crate) fn asked(argument: &'static str, message: impl Into<String>) -> Self {
        FitError::Asked { argument, message: message.into() }
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

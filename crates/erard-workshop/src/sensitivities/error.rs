//! Errors of derivatives.

use erard::gradient::GradientError;
use erard::run::SimulationError;
use thiserror::Error;

use crate::cores::Ending;
use crate::measure::MeasureError;

/// Reason why there are no derivatives.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SensitivityError {
    /// Differentiation failed.
    #[error(transparent)]
    Gradient(#[from] GradientError),
    /// The press could not be played.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// A derivative does not converge.
    #[error("{told}{}", if *more == 0 { String::new() } else { format!("; {more} more do not") })]
    Unconverged {
        /// Name and reason.
        told: String,
        /// Number of others that fail too.
        more: usize,
    },
    /// The key could not be weighed.
    #[error(transparent)]
    Measure(#[from] MeasureError),
}

impl Ending for SensitivityError {
    fn is_interruption(&self) -> bool {
        match self {
            SensitivityError::Gradient(error) => error.is_interruption(),
            SensitivityError::Simulation(error) => error.is_interruption(),
            SensitivityError::Measure(error) => error.is_interruption(),
            SensitivityError::Unconverged { .. } => false,
        }
    }
}

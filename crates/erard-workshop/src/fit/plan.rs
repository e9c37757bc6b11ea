//! Settings of a fit, and the solver that it uses.

use super::solver::{self, LeastSquares};
use super::{FitError, Jacobian, Loss, PerName};

/// Settings of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Starting values, in SI units; other parameters start as in the instrument.
    pub start: PerName<f64>,
    /// Loss function of the last steps.
    pub loss: Loss,
    /// Method for derivatives in the last steps and in the covariance.
    pub jacobian: Jacobian,
    /// Number of restarts elsewhere.
    pub restarts: usize,
    /// Largest number of evaluations per solution.
    pub max_evaluations: usize,
}

/// Most restarts of a fit.
pub const MAX_RESTARTS: u16 = 1000;
/// Most evaluations per solution of a fit.
pub const MAX_EVALUATIONS: u16 = 10_000;

impl Default for Plan {
    fn default() -> Self {
        Plan {
            start: Vec::new(),
            loss: Loss::Linear,
            jacobian: Jacobian::Differences,
            restarts: 5,
            max_evaluations: 50,
        }
    }
}

/// Result of a solver.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Point, in the solver's coordinates.
    pub point: Vec<f64>,
    /// Mean square of the residuals there.
    pub misfit: f64,
    /// Reason why it ended, in words.
    pub message: String,
}

/// Minimises sums of squares between bounds.
pub trait Solver {
    /// Starts at a point within the bounds and uses at most `max_evaluations` evaluations of the residuals.
    ///
    /// # Errors
    /// Errors of the problem; an interruption.
    fn solve(
        &mut self,
        problem: &mut dyn LeastSquares<Error = FitError>,
        from: &[f64],
        bounds: (&[f64], &[f64]),
        loss: Loss,
        max_evaluations: usize,
    ) -> Result<Solution, FitError>;
}

/// The solver of this crate: a reflective trust region.
#[derive(Debug, Clone, Copy, Default)]
pub struct TrustRegion;

impl Solver for TrustRegion {
    fn solve(
        &mut self,
        problem: &mut dyn LeastSquares<Error = FitError>,
        from: &[f64],
        bounds: (&[f64], &[f64]),
        loss: Loss,
        max_evaluations: usize,
    ) -> Result<Solution, FitError> {
        let found = solver::solve(problem, from, bounds, loss, max_evaluations)?;
        Ok(Solution::new(found.x, &found.residuals, found.ended.words().to_owned()))
    }
}

impl Solution {
    /// Makes a solution from a point, its residuals and the reason why the solver ended.
    pub fn new(point: Vec<f64>, residuals: &[f64], message: String) -> Self {
        let misfit = residuals.iter().map(|x| x * x).sum::<f64>() / residuals.len() as f64;
        Solution { point, misfit, message }
    }
}

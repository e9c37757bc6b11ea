//! Residuals and Jacobian as the solver minimises them.

use crate::dense::Columns;
use crate::sensitivities::SensitivityError;

use super::candidate::{Best, Candidate};
use super::correlation::Leftovers;
use super::drive_noise::DriveNoise;
use super::jacobian::{DIFFERENCES, Differences, by_differences, by_gradient, check_gradient, weigh};
use super::problem::Problem;
use super::simulator::Simulator;
use super::solver::LeastSquares;
use super::{FitError, Loss, NoiseModel};

/// Residual of a point that cannot be played: worse than any other.
const UNPLAYABLE: f64 = 1e6;

/// Residuals and Jacobian of a problem under a noise model. It keeps the best of all points played.
pub(super) struct Objective<'s, 'p> {
    pub simulator: &'s mut Simulator<'p>,
    pub noise: NoiseModel,
    pub best: Best,
    /// Weight of every row; `None` weighs all rows alike.
    weights: Option<Vec<f64>>,
    /// Whether the Jacobian of fine steps comes from the model's own derivatives.
    is_exact: bool,
}

impl<'s, 'p> Objective<'s, 'p> {
    /// Makes the objective of a simulator's problem. Points are compared by `loss`.
    pub(super) fn new(simulator: &'s mut Simulator<'p>, noise: NoiseModel, loss: Loss) -> Self {
        simulator.clear_cache();
        Objective { simulator, noise, best: Best::new(loss), weights: None, is_exact: false }
    }

    pub(super) fn problem(&self) -> &'p Problem {
        self.simulator.problem()
    }

    /// Whether the Jacobian of fine steps comes from the model's own derivatives.
    pub(super) fn is_exact(&self) -> bool {
        self.is_exact
    }

    /// Sets the weight of every row for the next stage; `None` weighs all rows alike.
    pub(super) fn set_weights(&mut self, weights: Option<Vec<f64>>) {
        self.weights = weights;
        self.simulator.clear_cache();
    }

    /// Weighted residuals at a point: fitted less measured, over the noise.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn residuals(&mut self, point: &[f64]) -> Result<Vec<f64>, FitError> {
        let mut residuals = self.unweighted(point)?;
        weigh(&mut residuals, self.weights.as_deref());
        Ok(residuals)
    }

    fn unweighted(&mut self, point: &[f64]) -> Result<Vec<f64>, FitError> {
        let problem = self.problem();
        let is_new = !self.simulator.holds(point);
        let mut residuals = self.noise.residuals(problem, point, self.simulator.readings(point)?);
        if is_new {
            self.best.update(problem, &self.noise, point, &residuals);
        }
        if residuals.iter().any(|x| !x.is_finite()) {
            residuals.fill(UNPLAYABLE);
        }
        Ok(residuals)
    }

    /// Whether a point can be played.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn is_playable(&mut self, point: &[f64]) -> Result<bool, FitError> {
        let residuals = self.unweighted(point)?;
        Ok(residuals.is_empty() || residuals.iter().any(|x| *x != UNPLAYABLE))
    }

    /// Returns the candidate at a point.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn candidate(&mut self, point: &[f64]) -> Result<Candidate, FitError> {
        let residuals = self.unweighted(point)?;
        Ok(self.best.rate(self.problem(), &self.noise, point, &residuals))
    }

    /// Returns the model's own derivatives if requested and the step is the usual one, else differences.
    ///
    /// # Errors
    /// An interruption; a model without derivatives.
    pub(super) fn jacobian(&mut self, point: &[f64], share: f64) -> Result<Columns, FitError> {
        if self.is_exact && share == DIFFERENCES[1] {
            return by_gradient(self.simulator, &self.noise, self.weights.as_deref(), point);
        }
        self.by_differences(point, share)
    }

    /// Returns the Jacobian by differences. All points played for it become candidates.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn by_differences(&mut self, point: &[f64], share: f64) -> Result<Columns, FitError> {
        let problem = self.problem();
        let played = Differences::play(self.simulator, point, share)?;
        let (noise, best) = (&self.noise, &mut self.best);
        let mut update = |point: &[f64], residuals: &[f64]| best.update(problem, noise, point, residuals);
        Ok(played.columns(problem, noise, self.weights.as_deref(), &mut update))
    }

    /// Returns the Jacobian by differences in half of the recordings' steps. These points do not become candidates.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn in_half_steps(&mut self, point: &[f64], share: f64) -> Result<Columns, FitError> {
        let (noise, weights) = (&self.noise, self.weights.as_deref());
        self.simulator.with_half_steps(|simulator| by_differences(simulator, noise, weights, point, share))
    }

    /// Uses the model's own derivatives in the last steps. Models without them are reported before the work begins.
    ///
    /// # Errors
    /// See [`FitError`].
    pub(super) fn use_gradient(&mut self, point: &[f64]) -> Result<(), FitError> {
        check_gradient(self.problem())?;
        match by_gradient(self.simulator, &self.noise, self.weights.as_deref(), point) {
            Err(FitError::Sensitivity(SensitivityError::Gradient(error))) if !error.is_interruption() => {
                return Err(FitError::argument("jacobian", format!("{error}; expected differences")));
            }
            Err(error) => return Err(error),
            Ok(_) => {}
        }
        self.is_exact = true;
        Ok(())
    }

    /// Standardised residuals and their derivatives at a point as if no row's noise depended on another's, from
    /// whitened ones.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn unwhitened(&mut self, point: &[f64], jacobian: &Columns) -> Result<(Vec<f64>, Columns), FitError> {
        let problem = self.problem();
        let (mut residuals, mut jacobian) = (self.unweighted(point)?, jacobian.clone());
        for column in jacobian.iter_mut().chain(std::iter::once(&mut residuals)) {
            self.noise.unwhiten(problem, column);
        }
        Ok((residuals, jacobian))
    }

    /// Estimates the correlation of the sensors' noise from the residuals at a point, their derivatives and the effect
    /// of a noisy drive. If it differs from the one before, it becomes the noise model's, and all points played so far
    /// are forgotten: their scores are those of other noise. Returns whether it does.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn correlate(
        &mut self,
        point: &[f64],
        jacobian: &Columns,
        drive: &DriveNoise,
    ) -> Result<bool, FitError> {
        let problem = self.problem();
        let (residuals, jacobian) = self.unwhitened(point, jacobian)?;
        if residuals.iter().any(|x| x.abs() >= UNPLAYABLE) {
            return Ok(false);
        }
        let is_free = |k: usize| {
            let block = &problem.blocks()[k];
            let is_given = self.noise.known_noise[k].is_some() && self.noise.uncertainty[k] == 0.0;
            let is_white = !is_given && problem.recording_of(block).is_noise_from_spectrum(block.column);
            self.noise.known_noise[k].is_none() || is_white
        };
        let channels = self.noise.channels(problem, is_free);
        let covariance = drive.covariance_columns();
        let left = Leftovers { channels: &channels, residuals: &residuals, jacobian: &jacobian, drive: &covariance };
        let found = left.estimate();
        let mut noise = self.noise.clone();
        if !noise.correlate(problem, &channels, &found) {
            return Ok(false);
        }
        let was_white = self.noise.correlation_time_s.iter().all(|time_s| *time_s == 0.0);
        if !noise.whitens && (was_white || !self.noise.whitens) {
            // Residuals and scores stay as they are.
            self.noise.correlation_time_s = noise.correlation_time_s;
            self.noise.whitens = false;
            return Ok(false);
        }
        self.noise = noise;
        self.best.forget();
        self.simulator.clear_cache();
        // The point is the first of those that are rated anew.
        self.unweighted(point)?;
        Ok(true)
    }

    /// Estimates the unknown noise of blocks from the residuals at a point. Returns whether it agrees with the estimate
    /// before.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn estimate_noise(&mut self, point: &[f64]) -> Result<bool, FitError> {
        if self.noise.is_known() {
            return Ok(true);
        }
        let residuals = self.residuals(point)?;
        let agrees = self.noise.estimate(self.problem(), &residuals, point.len());
        self.simulator.clear_cache();
        Ok(agrees)
    }
}

/// An objective with one difference step.
pub(super) struct WithStep<'a, 's, 'p>(pub &'a mut Objective<'s, 'p>, pub f64);

impl LeastSquares for WithStep<'_, '_, '_> {
    type Error = FitError;

    fn residuals(&mut self, x: &[f64]) -> Result<Vec<f64>, FitError> {
        self.0.residuals(x)
    }

    fn jacobian(&mut self, x: &[f64]) -> Result<Columns, FitError> {
        self.0.jacobian(x, self.1)
    }
}

//! Noise of sensors and drives, and residuals in its units.

use super::data::COLUMNS;
use super::problem::{Problem, ResidualBlock};
use super::readings::Readings;
use super::{FitError, PerName};

/// Estimates of noise that differ by less than this share agree.
const AGREEMENT: f64 = 0.02;

/// Noise of every block of residuals and of the drives, root mean square, N, m or m/s.
#[derive(Debug, Clone, PartialEq)]
pub struct NoiseModel {
    /// Noise of every block: known, or the present estimate.
    pub sigma: Vec<f64>,
    /// Known noise of every block, given or measured on the recording; `None` if it is estimated from the residuals.
    pub known_noise: Vec<Option<f64>>,
    /// Relative standard deviation of every block's known noise; 0 where the caller gave the noise.
    pub uncertainty: Vec<f64>,
    /// Noise of each recording's drive, where known.
    pub drive_sigma: Vec<Option<f64>>,
}

impl NoiseModel {
    /// Makes the noise model of a problem. `given` is the known noise of columns, including the driving one, N, m or
    /// m/s; other noise is that measured on the recordings.
    ///
    /// # Errors
    /// If `given` names a missing column, or a noise is not positive (for the driving column: is negative).
    pub fn new(problem: &Problem, given: &PerName<f64>) -> Result<Self, FitError> {
        let known = |column: &str| given.iter().find(|(own, _)| own == column).map(|(_, sigma)| *sigma);
        for (column, sigma) in given {
            let is_compared = problem.blocks().iter().any(|block| block.column == column);
            if !is_compared && !problem.recordings().iter().any(|one| one.driving == column) {
                return Err(FitError::argument(
                    "sigma",
                    format!("{column} is neither compared nor the drive; expected no noise (sigma) for it"),
                ));
            }
            if !(sigma.is_finite() && *sigma >= 0.0 && (*sigma > 0.0 || !is_compared)) {
                return Err(FitError::argument("sigma", format!("{column} is {sigma}; expected positive numbers")));
            }
        }
        let known_noise_of =
            |block: &ResidualBlock| known(block.column).or_else(|| problem.recording_of(block).noise(block.column));
        let known_noise: Vec<Option<f64>> = problem.blocks().iter().map(known_noise_of).collect();
        let usual = |column: &str| COLUMNS.iter().find(|(own, ..)| *own == column).map_or(1.0, |(.., sigma)| *sigma);
        let sigma: Vec<f64> = problem
            .blocks()
            .iter()
            .zip(&known_noise)
            .map(|(block, noise)| noise.unwrap_or_else(|| usual(block.column)))
            .collect();
        if let Some(at) = sigma.iter().position(|sigma| *sigma <= 0.0) {
            let column = problem.blocks()[at].column;
            return Err(FitError::argument(
                "sigma",
                format!("{column} shows no noise; expected its noise (sigma) to be given"),
            ));
        }
        let uncertainty = |block: &ResidualBlock| match known(block.column) {
            Some(_) => 0.0,
            None => problem.recording_of(block).noise_uncertainty(block.column),
        };
        Ok(NoiseModel {
            uncertainty: problem.blocks().iter().map(uncertainty).collect(),
            drive_sigma: problem
                .recordings()
                .iter()
                .map(|one| known(one.driving).or_else(|| one.noise(one.driving)))
                .collect(),
            sigma,
            known_noise,
        })
    }

    /// Whether the noise of every block is known.
    pub(super) fn is_known(&self) -> bool {
        self.known_noise.iter().all(Option::is_some)
    }

    /// Driving columns of unknown noise.
    pub(super) fn silent_drives(&self, problem: &Problem) -> Vec<&'static str> {
        let unknown = problem.recordings().iter().zip(&self.drive_sigma).filter(|(_, sigma)| sigma.is_none());
        let mut found: Vec<&'static str> = unknown.map(|(one, _)| one.driving).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Residuals at a point with these readings: fitted less measured, over the noise. Not finite if the point could
    /// not be played.
    pub(super) fn residuals(&self, problem: &Problem, point: &[f64], readings: &Readings) -> Vec<f64> {
        let mut residuals = Vec::with_capacity(problem.rows());
        for (k, curve) in problem.fitted(point, readings).iter().enumerate() {
            let block = &problem.blocks()[k];
            let measured = &problem.recording_of(block).measured[block.place];
            let own = curve.iter().zip(measured).map(|(fitted, measured)| (fitted - measured) / self.sigma[k]);
            residuals.extend(own);
        }
        residuals
    }

    /// Estimates the unknown noise of blocks from the residuals of a point with so many parameters. Returns whether it
    /// agrees with the estimate before.
    pub(super) fn estimate(&mut self, problem: &Problem, residuals: &[f64], parameters: usize) -> bool {
        let share = 1.0 - parameters as f64 / residuals.len() as f64;
        let before = self.sigma.clone();
        for (k, block) in problem.blocks().iter().enumerate() {
            let own = &residuals[block.rows.clone()];
            if self.known_noise[k].is_none() {
                let mean = own.iter().map(|x| x * x).sum::<f64>() / own.len() as f64;
                self.sigma[k] *= (mean / share).sqrt().max(1e-9);
            }
        }
        self.sigma.iter().zip(&before).all(|(now, before)| (now / before - 1.0).abs() < AGREEMENT)
    }
}

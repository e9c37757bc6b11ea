//! Noise of sensors and drives, and residuals in its units.

use super::correlation::{Correlated, NoisyRows, correlation, unwhiten, whiten};
use super::data::COLUMNS;
use super::problem::{Problem, ResidualBlock};
use super::readings::Readings;
use super::{FitError, PerName};

/// Fewest independent samples for every parameter and delay with which errors are given.
pub(super) const FEWEST_PER_PARAMETER: f64 = 10.0;
/// Residuals smaller than this share of a known noise do not show it, nor its correlation.
const SEEN: f64 = 0.3;
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
    /// Correlation time of every block's noise, s: its correlation falls as exp(-t / time). 0 for white noise, which is
    /// assumed until the residuals show more ([`super::fit()`]).
    pub correlation_time_s: Vec<f64>,
    /// Whether residuals are whitened by it. They are not if too few independent samples are left for errors: slow
    /// noise and a misfit are the same then, and to whiten would be to allow for any misfit that is slow.
    pub whitens: bool,
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
            correlation_time_s: vec![0.0; sigma.len()],
            whitens: true,
            sigma,
            known_noise,
        })
    }

    /// Correlation of a block's noise from sample to sample.
    pub(super) fn correlation(&self, problem: &Problem, block: usize) -> f64 {
        correlation(self.correlation_time_s[block], problem.recording_of(&problem.blocks()[block]).dt_s())
    }

    /// Whitens standardised residuals, or their derivatives, in place: what is left beyond the prediction from the
    /// sample before. White noise stays as it is, to the bit.
    pub(super) fn whiten(&self, problem: &Problem, rows: &mut [f64]) {
        for (k, block) in problem.blocks().iter().enumerate().filter(|_| self.whitens) {
            whiten(&mut rows[block.rows.clone()], self.correlation(problem, k));
        }
    }

    /// The inverse of [`NoiseModel::whiten`].
    pub(super) fn unwhiten(&self, problem: &Problem, rows: &mut [f64]) {
        for (k, block) in problem.blocks().iter().enumerate().filter(|_| self.whitens) {
            unwhiten(&mut rows[block.rows.clone()], self.correlation(problem, k));
        }
    }

    /// The channels as the estimate of their correlation takes them. `is_free` says whose noise is estimated.
    pub(super) fn channels(&self, problem: &Problem, is_free: impl Fn(usize) -> bool) -> Vec<NoisyRows> {
        let mut columns: Vec<&str> = Vec::new();
        let of = |(k, block): (usize, &ResidualBlock)| {
            let column = columns.iter().position(|own| *own == block.column).unwrap_or_else(|| {
                columns.push(block.column);
                columns.len() - 1
            });
            let dt_s = problem.recording_of(block).dt_s();
            NoisyRows { rows: block.rows.clone(), column, dt_s, is_free: is_free(k) }
        };
        problem.blocks().iter().enumerate().map(of).collect()
    }

    /// Takes over an estimate of the correlation. Noise that was read at the upper end of a spectrum as if it were
    /// white is no longer known. Returns whether anything changed by more than the estimate agrees with itself.
    pub(super) fn correlate(&mut self, problem: &Problem, channels: &[NoisyRows], found: &Correlated) -> bool {
        let before = self.correlation_time_s.clone();
        let is_there = |column: usize| {
            channels.iter().zip(&found.sizes).any(|(one, size)| one.column == column && (one.is_free || *size > SEEN))
        };
        for (k, channel) in channels.iter().enumerate() {
            let time_s = if is_there(channel.column) { found.times_s[channel.column] } else { 0.0 };
            self.correlation_time_s[k] = time_s;
            if time_s > 0.0 && channel.is_free {
                self.known_noise[k] = None;
                self.uncertainty[k] = 0.0;
                self.sigma[k] *= found.sizes[k];
            }
        }
        debug_assert_eq!(channels.len(), problem.blocks().len());
        self.whitens = self.is_enough(problem);
        self.correlation_time_s.iter().zip(&before).any(|(now, then)| (now - then).abs() > AGREEMENT * then)
    }

    /// Whether enough independent samples are left for the errors of all parameters and delays.
    pub(super) fn is_enough(&self, problem: &Problem) -> bool {
        let numbers = problem.parameters().len() + problem.delays();
        self.correlation_time_s.iter().all(|time_s| *time_s == 0.0)
            || self.independent_samples(problem) >= FEWEST_PER_PARAMETER * numbers as f64
    }

    /// Number of independent samples with as precise a mean as all compared ones.
    pub(super) fn independent_samples(&self, problem: &Problem) -> f64 {
        let of = |(k, block): (usize, &ResidualBlock)| {
            super::correlation::independent(block.rows.len(), self.correlation(problem, k))
        };
        problem.blocks().iter().enumerate().map(of).sum()
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

    /// Residuals at a point with these readings: fitted less measured, over the noise, whitened. Not finite if the
    /// point could not be played.
    pub(super) fn residuals(&self, problem: &Problem, point: &[f64], readings: &Readings) -> Vec<f64> {
        let mut residuals = Vec::with_capacity(problem.rows());
        for (k, curve) in problem.fitted(point, readings).iter().enumerate() {
            let block = &problem.blocks()[k];
            let measured = &problem.recording_of(block).measured[block.place];
            let own = curve.iter().zip(measured).map(|(fitted, measured)| (fitted - measured) / self.sigma[k]);
            residuals.extend(own);
        }
        self.whiten(problem, &mut residuals);
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

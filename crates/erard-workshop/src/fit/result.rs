//! Result of a fit: values, covariance, and what the data do not determine, in words.

use crate::dense::{Columns, dot, svd, times};

use super::candidate::{Candidate, best_of, within_tolerance};
use super::correlation::student_95;
use super::doubt::Doubt;
use super::drive_noise::{DISTURBED, DriveNoise};
use super::problem::ResidualBlock;
use super::simulator::Simulator;
use super::{FitError, FitParameter, NoiseModel};

/// A bench quantity set by a parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct Meaning {
    /// The parameter.
    pub name: String,
    /// Meaning of the parameter.
    pub explanation: &'static str,
    /// Quantity read on the bench.
    pub quantity: &'static str,
    /// Unit of the quantity.
    pub unit: &'static str,
    /// Value with the instrument before the fit.
    pub before: f64,
    /// Value with the fitted instrument.
    pub value: f64,
    /// Standard deviation of `value` due to the parameter's own.
    pub std: f64,
}

/// Result of a fit. Vectors follow the order of the `parameters`; those in the solver's coordinates end with the
/// delays, ms. Covariances are symmetric.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct FitResult {
    /// Fitted parameters.
    pub parameters: Vec<FitParameter>,
    /// End point, in the solver's coordinates.
    pub point: Vec<f64>,
    /// Reason why the solver ended, in words.
    pub message: String,
    /// Values, as in `parameters`: turns in m, rad or N m, factors of other parameters.
    pub x: Vec<f64>,
    /// Standard deviations of `x`, due to noise alone. NaN, like all covariances, if the recordings are too short for
    /// the correlation of their noise ([`FitResult::independent_samples`]).
    pub std: Vec<f64>,
    /// Half widths of the 95 % intervals of `x`: Student's, because the estimates of the noise and of its correlation
    /// scatter, and as wide as a model that bends needs. NaN if `std` is.
    pub half_width_95: Vec<f64>,
    /// Number of independent samples that have as precise a mean as the compared ones: fewer if noise is correlated.
    /// Errors need ten of them for every parameter and delay.
    pub independent_samples: f64,
    /// Covariance of `x`.
    pub cov: Columns,
    /// Fitted less measured, over the noise; not whitened.
    pub residuals: Vec<f64>,
    /// Number of residuals less number of parameters and delays.
    pub degrees_of_freedom: usize,
    /// Sum of squared whitened residuals over the degrees of freedom. See [`FitResult::chi2`] for its meaning.
    pub chi2_reduced: f64,
    /// Expected value if the model is true: 1 for the sensors' noise, plus the contribution of the drive's noise, which
    /// moves the model itself.
    pub chi2_expected: f64,
    /// Singular values of the Jacobian, with each parameter scaled by half the width of its bounds. Below 1, the data
    /// determine a direction no better than its bounds do.
    pub singular_values: Vec<f64>,
    /// Their right singular vectors, delays included.
    pub directions: Columns,
    /// Dependence of the Jacobian on the steps of its differences: the largest relative change of a column.
    pub jacobian_agreement: f64,
    /// Dependence of the Jacobian on the time step: the largest relative error of a column, from half the step.
    pub time_step_agreement: f64,
    /// Covariance of the point.
    pub solver_cov: Columns,
    /// Covariance of the point from the sensors' noise alone.
    pub sensors_cov: Columns,
    /// Noise of sensors and drives, with its estimates.
    pub noise: NoiseModel,
    /// Results of the channels, in the order of the residuals.
    pub channels: Vec<FittedChannel>,
    /// Number of attempts from different starts, and how many of them had as small a misfit as the best one.
    pub attempts: [usize; 2],
    /// Largest distance of any parameter of these ends from the result, in its standard deviations.
    pub apart: f64,
    /// Parameters with misleading names, as measured on the bench.
    pub meanings: Vec<Meaning>,
    /// Doubts, by kind.
    pub doubts: Vec<Doubt>,
    /// Driving columns of unknown noise.
    pub silent: Vec<&'static str>,
    /// Number of strokes played without derivatives.
    pub evaluations: u64,
    /// Number of strokes played with derivatives.
    pub differentiated: u64,
}

/// End of a search, from which the result is computed.
#[derive(Debug, Clone)]
pub(super) struct Conclusion {
    /// Best point.
    pub point: Vec<f64>,
    /// Reason why the solver ended, in words.
    pub message: String,
    /// Whitened residuals at the point, and these before they are whitened.
    pub residuals: Vec<f64>,
    pub unwhitened: Vec<f64>,
    /// Degrees of freedom of every parameter's variance.
    pub variance_freedom: Vec<f64>,
    /// Jacobian at the point.
    pub jacobian: Columns,
    /// Relative change of the Jacobian with its difference step, and its relative error due to the time step.
    pub jacobian_agreement: f64,
    pub time_step_agreement: f64,
    /// Ends of all attempts.
    pub ends: Vec<Candidate>,
    /// Root mean square residual of each block at the start, N, m or m/s.
    pub rms_at_start: Vec<f64>,
    /// Noise of sensors and drives.
    pub noise: NoiseModel,
}

/// Result of one channel: one measured quantity of one recording.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedChannel {
    /// Title: the column, and the recording if there are several.
    pub title: String,
    /// Root mean square noise of the channel, N, m or m/s: as given, as measured on the recording, or estimated from
    /// the residuals.
    pub noise: f64,
    /// Whether the noise was given or measured on the recording, so that misfit can be distinguished from it.
    pub noise_is_known: bool,
    /// Correlation time of the noise, s: its correlation falls as exp(-t / time); 0 for white noise.
    pub correlation_time_s: f64,
    /// Correlation of the noise from sample to sample.
    pub correlation: f64,
    /// Root mean square of fitted less measured at the start of the fit, N, m or m/s.
    pub rms_at_start: f64,
    /// Root mean square of fitted less measured at the result, N, m or m/s.
    pub rms: f64,
    /// Delay against the drive, s, positive if recorded late, and its standard deviation; `None` if not estimated.
    pub delay_s: Option<(f64, f64)>,
}

/// Singular values below this share of the largest are raised to it: the error of such a direction is large, not
/// infinite.
const UNSEEN: f64 = 1e-9;
/// Correlations beyond this are reported.
const CORRELATED: f64 = 0.5;
/// Largest number of parameters named per direction, and their smallest share of the largest component.
const MAX_NAMED: usize = 4;
const MIN_SHARE: f64 = 0.3;
/// An interval is enlarged by this factor at most.
const MOST_BENT: f64 = 2.0;

impl FitResult {
    /// Makes the result, without doubts and meanings, from the end of a search.
    pub(super) fn new(simulator: &Simulator<'_>, end: &Conclusion, drive_noise: &DriveNoise) -> Self {
        let Conclusion {
            point,
            message,
            residuals,
            unwhitened,
            variance_freedom,
            jacobian,
            jacobian_agreement,
            time_step_agreement,
            ends,
            rms_at_start,
            noise,
        } = end.clone();
        let problem = simulator.problem();
        let parameters = problem.parameters().to_vec();
        let (count, all) = (parameters.len(), point.len());
        let degrees_of_freedom = residuals.len().saturating_sub(all).max(1);
        let chi2_reduced = dot(&residuals, &residuals) / degrees_of_freedom as f64;
        let chi2_expected = drive_noise.explained(residuals.len());
        let widths: Vec<f64> =
            parameters.iter().map(FitParameter::width).chain(std::iter::repeat_n(1.0, problem.delays())).collect();
        let scaled: Columns =
            jacobian.iter().zip(&widths).map(|(column, by)| column.iter().map(|x| x * by).collect()).collect();
        let factors = svd(&scaled);
        let least = UNSEEN * factors.values[0].max(1e-300);
        let seen: Vec<f64> = factors.values.iter().map(|s| s.max(least)).collect();
        // Square root of the sensors' covariance: the right singular vectors over the singular values.
        let root: Columns =
            (0..all).map(|i| (0..all).map(|k| factors.directions[k][i] / seen[k] * widths[i]).collect()).collect();
        let left_vectors: Columns =
            (0..all).map(|k| times(&scaled, &factors.directions[k]).iter().map(|x| x / seen[k]).collect()).collect();
        let by_drive: Columns = drive_noise
            .whitened
            .iter()
            .map(|column| {
                let seen: Vec<f64> = left_vectors.iter().map(|own| dot(own, column)).collect();
                root.iter().map(|row| dot(row, &seen) / (DISTURBED as f64).sqrt()).collect()
            })
            .collect();
        // Misfit beyond the noise of sensors and drive enlarges all errors.
        let excess = (chi2_reduced / chi2_expected).max(1.0);
        let square = |of: &dyn Fn(usize, usize) -> f64| -> Columns {
            (0..all).map(|i| (0..all).map(|j| of(i, j)).collect()).collect()
        };
        let sensors_cov = square(&|i, j| dot(&root[i], &root[j]));
        let solver_cov = square(&|i, j| {
            excess * (sensors_cov[i][j] + by_drive.iter().map(|column| column[i] * column[j]).sum::<f64>())
        });
        let slopes: Vec<f64> = parameters.iter().zip(&point).map(|(one, p)| one.slope(*p)).collect();
        let cov: Columns =
            (0..count).map(|i| (0..count).map(|j| solver_cov[i][j] * slopes[i] * slopes[j]).collect()).collect();
        let [good, apart] = spread(&ends, &point, &solver_cov[..count]);
        let independent_samples = noise.independent_samples(problem);
        // Samples that depend on each other are too few for errors: the estimate of their correlation scatters too
        // much.
        let no_errors = !noise.is_enough(problem);
        let kept = |matrix: Columns| -> Columns {
            let shown = |x: f64| if no_errors { f64::NAN } else { x };
            matrix.into_iter().map(|row| row.into_iter().map(shown).collect()).collect()
        };
        let (cov, solver_cov, sensors_cov) = (kept(cov), kept(solver_cov), kept(sensors_cov));
        let delay_s = |channel: usize| {
            let std_s = || 1e-3 * solver_cov[count + channel][count + channel].sqrt();
            problem.has_delays().then(|| (problem.delay_s(&point, channel), std_s()))
        };
        let channel = |(k, block): (usize, &ResidualBlock)| {
            let own = &unwhitened[block.rows.clone()];
            FittedChannel {
                title: block.title.clone(),
                noise: noise.sigma[k],
                noise_is_known: noise.known_noise[k].is_some(),
                correlation_time_s: noise.correlation_time_s[k],
                correlation: noise.correlation(problem, k),
                rms_at_start: rms_at_start[k],
                rms: noise.sigma[k] * (dot(own, own) / own.len() as f64).sqrt(),
                delay_s: delay_s(k),
            }
        };
        let channels = problem.blocks().iter().enumerate().map(channel).collect();
        let std: Vec<f64> = (0..count).map(|i| cov[i][i].sqrt()).collect();
        FitResult {
            x: problem.from_solver(&point),
            half_width_95: std.iter().zip(&variance_freedom).map(|(std, n)| student_95(*n) * std).collect(),
            std,
            independent_samples,
            cov,
            degrees_of_freedom,
            chi2_reduced,
            chi2_expected,
            singular_values: factors.values,
            directions: factors.directions,
            jacobian_agreement,
            time_step_agreement,
            attempts: [ends.len(), good as usize],
            apart,
            channels,
            solver_cov,
            sensors_cov,
            meanings: Vec::new(),
            doubts: Vec::new(),
            silent: noise.silent_drives(problem),
            evaluations: simulator.evaluations(),
            differentiated: simulator.differentiated(),
            message,
            residuals: unwhitened,
            point,
            parameters,
            noise,
        }
    }

    /// Enlarges every interval up to where the recordings speak against its ends as much as against those of a straight
    /// model. A parameter's two ends, the others moved with it as their covariance says, are played: the sum of squares
    /// rises there by less than the Jacobian predicts if the model bends. An end that is out of bounds or cannot be
    /// played says nothing.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn bend(&mut self, simulator: &mut Simulator<'_>, end: &Conclusion) -> Result<(), FitError> {
        if !self.has_errors() {
            return Ok(());
        }
        let problem = simulator.problem();
        // Of every end its parameter, how far it is moved, and its point.
        let mut ends: Vec<(usize, Vec<f64>, Vec<f64>)> = Vec::with_capacity(2 * self.std.len());
        for (k, side) in (0..self.std.len()).flat_map(|k| [(k, -1.0), (k, 1.0)]) {
            let by = side * self.half_width_95[k] / self.std[k] / self.solver_cov[k][k].sqrt();
            let moved: Vec<f64> = self.solver_cov.iter().map(|row| by * row[k]).collect();
            let point: Vec<f64> = self.point.iter().zip(&moved).map(|(p, by)| p + by).collect();
            let mut within = point.clone();
            problem.clamp(&mut within);
            if within == point {
                ends.push((k, moved, point));
            }
        }
        let points: Vec<Vec<f64>> = ends.iter().map(|(.., point)| point.clone()).collect();
        let readings = simulator.play(&points)?;
        let straight_widths = self.half_width_95.clone();
        for ((k, moved, point), readings) in ends.iter().zip(&readings) {
            let played = self.noise.residuals(problem, point, readings);
            if played.iter().any(|x| !x.is_finite()) {
                continue;
            }
            let straight = times(&end.jacobian, moved);
            let predicted = dot(&straight, &straight);
            let rise =
                dot(&played, &played) - dot(&end.residuals, &end.residuals) - 2.0 * dot(&end.residuals, &straight);
            let bent = (predicted / rise.max(f64::MIN_POSITIVE)).sqrt().clamp(1.0, MOST_BENT);
            self.half_width_95[*k] = self.half_width_95[*k].max(bent * straight_widths[*k]);
        }
        self.evaluations = simulator.evaluations();
        Ok(())
    }

    /// Returns the reduced chi2 and its expected value for a true model. `None` if a channel's noise was estimated from
    /// its residuals, because chi2 is then 1 for any fit.
    pub fn chi2(&self) -> Option<(f64, f64)> {
        let is_known = self.channels.iter().all(|channel| channel.noise_is_known);
        is_known.then_some((self.chi2_reduced, self.chi2_expected))
    }

    /// Fitted values in SI units, with their standard deviations.
    pub fn values(&self) -> impl Iterator<Item = (&FitParameter, f64, f64)> + '_ {
        let all = self.parameters.iter().zip(self.x.iter().zip(&self.std));
        all.map(|(one, (x, std))| (one, one.si(*x), one.si_error(*x, *std)))
    }

    /// Whether the result has errors: NaN otherwise.
    pub fn has_errors(&self) -> bool {
        self.std.iter().all(|std| !std.is_nan())
    }

    /// Correlation of two parameters.
    pub(crate) fn correlation(&self, i: usize, j: usize) -> f64 {
        self.cov[i][j] / (self.std[i] * self.std[j])
    }

    /// Pairs of parameters with a correlation above one half, the largest first.
    pub fn correlated(&self) -> Vec<(usize, usize, f64)> {
        let count = self.parameters.len();
        let mut pairs: Vec<(usize, usize, f64)> =
            (0..count).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| (i, j, self.correlation(i, j))).collect();
        pairs.retain(|(.., r)| r.abs() > CORRELATED);
        pairs.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
        pairs
    }

    /// Returns the directions that the data determine no better than the bounds do, in words.
    pub fn unseen(&self) -> Vec<String> {
        let delays = self.channels.iter().filter(|channel| channel.delay_s.is_some());
        let names: Vec<String> = self
            .parameters
            .iter()
            .map(|one| one.name.clone())
            .chain(delays.map(|channel| format!("delay of {}", channel.title)))
            .collect();
        let describe = |(value, direction): (&f64, &Vec<f64>)| {
            let mut large: Vec<usize> = (0..direction.len()).collect();
            large.sort_by(|a, b| direction[*b].abs().total_cmp(&direction[*a].abs()));
            let most = direction[large[0]];
            large.retain(|k| direction[*k].abs() > MIN_SHARE * most.abs());
            let way = |k: &usize| if most.signum() * direction[*k] > 0.0 { "up" } else { "down" };
            let words: Vec<String> =
                large.iter().take(MAX_NAMED).map(|k| format!("{} {}", names[*k], way(k))).collect();
            let beyond = two_digits(1.0 / value.max(1e-12));
            format!("{}: the data leave {beyond} times what the bounds allow", words.join(", "))
        };
        self.singular_values.iter().zip(&self.directions).filter(|(value, _)| **value < 1.0).map(describe).collect()
    }
}

/// Number of ends with as small a misfit as the best one, and their largest distance from `point`, in standard
/// deviations.
fn spread(ends: &[Candidate], point: &[f64], cov: &[Vec<f64>]) -> [f64; 2] {
    let best = best_of(ends);
    let (mut good, mut apart) = (0.0, 0.0_f64);
    for end in within_tolerance(ends, best) {
        good += 1.0;
        for (k, row) in cov.iter().enumerate() {
            apart = apart.max((end.point[k] - point[k]).abs() / row[k].sqrt().max(f64::MIN_POSITIVE));
        }
    }
    [good, apart]
}

/// Formats a number with two significant digits.
fn two_digits(x: f64) -> String {
    if !(0.001..1e5).contains(&x.abs()) {
        return format!("{x:.1e}");
    }
    let decimals = (1 - x.abs().log10().floor() as i32).max(0) as usize;
    let rounded = format!("{x:.decimals$}");
    if decimals == 0 {
        let tens = 10_f64.powi((x.abs().log10().floor() as i32 - 1).max(0));
        return format!("{:.0}", (x / tens).round() * tens);
    }
    rounded
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_for_people() {
        for (x, shown) in [(1.234, "1.2"), (12.7, "13"), (3456.0, "3500"), (0.0456, "0.046"), (1e9, "1.0e9")] {
            assert_eq!(two_digits(x), shown);
        }
    }
}

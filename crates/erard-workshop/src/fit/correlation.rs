//! Correlation of the sensors' noise: its estimate from residuals, and what the estimate leaves unknown.
//!
//! The noise of a channel is a stationary process whose correlation falls as exp(-t / T) (an autoregression of the
//! first order). The correlation time T of a column, the same in all recordings, maximises the restricted likelihood
//! (Patterson and Thompson, Biometrika 58 (1971)): that of the residuals beyond what the parameters can absorb, without
//! which low frequencies that the parameters have explained would make T too short. The effect of a noisy drive is part
//! of the covariance (Henderson's equations), so that its slow residuals do not count as the sensors'. The parameters
//! are then those of generalised least squares, and their errors scatter with the estimate: a 95 % interval is that of
//! Student's distribution with the degrees of freedom of Satterthwaite, Biometrics Bulletin 2 (1946).

use std::ops::Range;

use crate::dense::{Cholesky, Columns, dot};

/// Correlation times that are tried, in sampling intervals: from the shortest that can be told from white noise, and up
/// to this share of the recording.
const SHORTEST: f64 = 0.25;
const LONGEST: f64 = 1.0;
/// Number of correlation times tried before the best is refined, and steps of its refinement.
const TRIED: usize = 16;
const REFINED: usize = 24;
/// Rounds over all columns.
const ROUNDS: usize = 3;
/// Step of differences by logarithms of correlation times and noise.
const STEP: f64 = 0.04;
/// Added to the scaled normal equations: parameters that the data do not determine do not make them singular.
const RIDGE: f64 = 1e-10;
/// Golden section.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Rows of one channel of one recording, as far as their noise is concerned.
#[derive(Debug, Clone)]
pub(super) struct NoisyRows {
    /// Range among all rows.
    pub rows: Range<usize>,
    /// Index of the column: noise of one column has one correlation time.
    pub column: usize,
    /// Sampling interval, s.
    pub dt_s: f64,
    /// Whether the size of the noise is estimated, too. The correlation time is that of the best size in any case:
    /// where the given noise is larger than what there is, small residuals are no sign of correlation.
    pub is_free: bool,
}

/// Correlation of samples `dt_s` apart under this correlation time; 0 of white noise.
pub(super) fn correlation(time_s: f64, dt_s: f64) -> f64 {
    if time_s > 0.0 { (-dt_s / time_s).exp() } else { 0.0 }
}

/// Makes unit white noise of unit noise with this correlation from sample to sample: what is left beyond the prediction
/// from the sample before, over its deviation.
pub(super) fn whiten(rows: &mut [f64], correlation: f64) {
    if correlation != 0.0 {
        let scale = (1.0 - correlation * correlation).sqrt().recip();
        for n in (1..rows.len()).rev() {
            rows[n] = (rows[n] - correlation * rows[n - 1]) * scale;
        }
    }
}

/// The inverse of [`whiten`].
pub(super) fn unwhiten(rows: &mut [f64], correlation: f64) {
    if correlation != 0.0 {
        let scale = (1.0 - correlation * correlation).sqrt();
        for n in 1..rows.len() {
            rows[n] = rows[n] * scale + correlation * rows[n - 1];
        }
    }
}

/// Number of independent samples with as precise a mean as so many with this correlation.
pub(super) fn independent(samples: usize, correlation: f64) -> f64 {
    (samples as f64 * (1.0 - correlation) / (1.0 + correlation)).max(1.0)
}

/// Number of independent samples with as precise a mean square as so many with this correlation.
pub(super) fn independent_squares(samples: usize, correlation: f64) -> f64 {
    let square = correlation * correlation;
    (samples as f64 * (1.0 - square) / (1.0 + square)).max(1.0)
}

/// Residuals over their noise, their derivatives by the parameters, and the effects of disturbed drives: what the
/// correlation is estimated from. All rows are neither whitened nor weighted.
#[derive(Debug)]
pub(super) struct Leftovers<'a> {
    pub channels: &'a [NoisyRows],
    pub residuals: &'a [f64],
    pub jacobian: &'a [Vec<f64>],
    /// Columns whose outer products add up to the covariance of the drive's effect.
    pub drive: &'a [Vec<f64>],
}

/// Correlation time of every column, s (0: white), and the noise of every channel over that assumed.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Correlated {
    pub times_s: Vec<f64>,
    pub sizes: Vec<f64>,
}

impl Leftovers<'_> {
    fn columns(&self) -> usize {
        self.channels.iter().map(|one| one.column + 1).max().unwrap_or(0)
    }

    fn whitened(&self, column: &[f64], found: &Correlated) -> Vec<f64> {
        let mut column = column.to_vec();
        for (k, one) in self.channels.iter().enumerate() {
            let own = &mut column[one.rows.clone()];
            whiten(own, correlation(found.times_s[one.column], one.dt_s));
            if found.sizes[k] != 1.0 {
                own.iter_mut().for_each(|x| *x /= found.sizes[k]);
            }
        }
        column
    }

    /// Sizes of the noise that fit these times.
    pub(super) fn sized(&self, times_s: Vec<f64>) -> Correlated {
        let unit = Correlated { times_s, sizes: vec![1.0; self.channels.len()] };
        let whitened = self.whitened(self.residuals, &unit);
        let share = 1.0 - self.jacobian.len() as f64 / self.residuals.len() as f64;
        let size = |one: &NoisyRows| {
            let own = &whitened[one.rows.clone()];
            (dot(own, own) / own.len() as f64 / share).sqrt().max(1e-9)
        };
        Correlated { sizes: self.channels.iter().map(size).collect(), ..unit }
    }

    /// Logarithm of the restricted likelihood, up to a constant.
    fn likelihood(&self, found: &Correlated) -> f64 {
        let mut value = 0.0;
        for (k, one) in self.channels.iter().enumerate() {
            let own = correlation(found.times_s[one.column], one.dt_s);
            let rows = one.rows.len() as f64;
            value -= rows * found.sizes[k].ln() + 0.5 * (rows - 1.0) * (1.0 - own * own).ln();
        }
        let residuals = self.whitened(self.residuals, found);
        let (parameters, count) = (self.jacobian.len(), self.jacobian.len() + self.drive.len());
        let all: Columns = self.jacobian.iter().chain(self.drive).map(|column| self.whitened(column, found)).collect();
        let mut normal = vec![0.0; count * count];
        for i in 0..count {
            for j in 0..=i {
                let product = dot(&all[i], &all[j]);
                (normal[i * count + j], normal[j * count + i]) = (product, product);
            }
            let own = normal[i * count + i];
            normal[i * count + i] += if i < parameters { RIDGE * own + f64::MIN_POSITIVE } else { 1.0 };
        }
        let Some(factor) = Cholesky::of(&normal, count) else { return f64::NEG_INFINITY };
        let seen: Vec<f64> = all.iter().map(|column| dot(column, &residuals)).collect();
        let explained = factor.forward(&seen);
        value - factor.log_determinant() - 0.5 * (dot(&residuals, &residuals) - dot(&explained, &explained))
    }

    /// Correlation times that maximise the restricted likelihood; 0 where the likelihood of white noise is smaller by
    /// less than half the logarithm of the number of samples (Schwarz's criterion).
    pub(super) fn estimate(&self) -> Correlated {
        let mut found = self.sized(vec![0.0; self.columns()]);
        let mut value = self.likelihood(&found);
        for _ in 0..ROUNDS {
            let before = found.times_s.clone();
            for column in 0..before.len() {
                let own: Vec<&NoisyRows> = self.channels.iter().filter(|one| one.column == column).collect();
                let with = |log: f64| {
                    let mut times_s = found.times_s.clone();
                    times_s[column] = log.exp();
                    let tried = self.sized(times_s);
                    (self.likelihood(&tried), tried)
                };
                let shortest = own.iter().map(|one| SHORTEST * one.dt_s).fold(f64::INFINITY, f64::min);
                let longest = own.iter().map(|one| LONGEST * one.dt_s * one.rows.len() as f64).fold(0.0, f64::max);
                let (low, step) = (shortest.ln(), (longest / shortest).ln() / (TRIED - 1) as f64);
                let tried = (0..TRIED).map(|n| low + step * n as f64).map(|log| (with(log).0, log));
                let (_, best) = tried.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or((0.0, low));
                let log = highest(&mut |log| with(log).0, best - step, (best + step).min(longest.ln()));
                let (correlated, tried) = with(log);
                let mut white = found.times_s.clone();
                white[column] = 0.0;
                let white = self.sized(white);
                let uncorrelated = self.likelihood(&white);
                let samples: usize = own.iter().map(|one| one.rows.len()).sum();
                (value, found) = if correlated - uncorrelated > 0.5 * (samples as f64).ln() {
                    (correlated, tried)
                } else {
                    (uncorrelated, white)
                };
            }
            let same = |(now, then): (&f64, &f64)| (now - then).abs() <= 0.02 * then;
            if found.times_s.iter().zip(&before).all(same) {
                break;
            }
        }
        debug_assert!(!value.is_nan());
        found
    }

    /// Degrees of freedom of every parameter's variance, as the estimates of correlation times and noise scatter;
    /// infinite if nothing was estimated.
    pub(super) fn degrees_of_freedom(&self, found: &Correlated) -> Vec<f64> {
        let numbers: Vec<Estimated> = (0..found.times_s.len())
            .filter(|column| found.times_s[*column] > 0.0)
            .map(Estimated::Time)
            .chain((0..self.channels.len()).map(Estimated::Size))
            .collect();
        let count = numbers.len();
        let is_known = |number: &Estimated| matches!(number, Estimated::Size(k) if !self.channels[*k].is_free);
        if numbers.iter().all(is_known) {
            return vec![f64::INFINITY; self.jacobian.len()];
        }
        let at = |moves: &[(usize, f64)]| {
            let mut other = found.clone();
            for (number, by) in moves {
                match numbers[*number] {
                    Estimated::Time(column) => other.times_s[column] *= by.exp(),
                    Estimated::Size(k) => other.sizes[k] *= by.exp(),
                }
            }
            other
        };
        let value = |moves: &[(usize, f64)]| self.likelihood(&at(moves));
        let middle = value(&[]);
        let mut information = vec![0.0; count * count];
        for i in 0..count {
            let own = (2.0 * middle - value(&[(i, STEP)]) - value(&[(i, -STEP)])) / (STEP * STEP);
            // Of a number that the data do not determine: uncertain by a factor of e.
            information[i * count + i] = own.max(1.0);
            for j in 0..i {
                let mixed = value(&[(i, STEP), (j, -STEP)]) + value(&[(i, -STEP), (j, STEP)])
                    - value(&[(i, STEP), (j, STEP)])
                    - value(&[(i, -STEP), (j, -STEP)]);
                let mixed = mixed / (4.0 * STEP * STEP);
                (information[i * count + j], information[j * count + i]) = (mixed, mixed);
            }
        }
        let factor = Cholesky::of(&information, count);
        let variances = |of: &Correlated| self.log_variances(of);
        let slopes: Columns = (0..count)
            .map(|i| {
                if is_known(&numbers[i]) {
                    return vec![0.0; self.jacobian.len()];
                }
                let (above, below) = (variances(&at(&[(i, STEP)])), variances(&at(&[(i, -STEP)])));
                above.iter().zip(below).map(|(above, below)| (above - below) / (2.0 * STEP)).collect()
            })
            .collect();
        let of = |k: usize| {
            let slope: Vec<f64> = slopes.iter().map(|own| own[k]).collect();
            let scatter = match &factor {
                Some(factor) => {
                    let seen = factor.forward(&slope);
                    dot(&seen, &seen)
                }
                None => slope.iter().enumerate().map(|(i, x)| x * x / information[i * count + i]).sum(),
            };
            2.0 / scatter.max(f64::MIN_POSITIVE)
        };
        (0..self.jacobian.len()).map(of).collect()
    }

    /// Logarithms of the parameters' variances by the sensors' noise.
    fn log_variances(&self, found: &Correlated) -> Vec<f64> {
        let all: Columns = self.jacobian.iter().map(|column| self.whitened(column, found)).collect();
        let count = all.len();
        let mut normal = vec![0.0; count * count];
        for i in 0..count {
            for j in 0..count {
                normal[i * count + j] = dot(&all[i], &all[j]);
            }
            normal[i * count + i] *= 1.0 + RIDGE;
            normal[i * count + i] += f64::MIN_POSITIVE;
        }
        let Some(factor) = Cholesky::of(&normal, count) else { return vec![0.0; count] };
        let variance = |k: usize| {
            let unit: Vec<f64> = (0..count).map(|i| f64::from(i == k)).collect();
            let seen = factor.forward(&unit);
            dot(&seen, &seen).ln()
        };
        (0..count).map(variance).collect()
    }
}

/// A number of the noise that was estimated: a column's correlation time, or a channel's size.
#[derive(Debug, Clone, Copy)]
enum Estimated {
    Time(usize),
    Size(usize),
}

/// Place of the highest value between two bounds, by golden section.
fn highest(of: &mut dyn FnMut(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let (mut a, mut b) = (high - GOLDEN * (high - low), low + GOLDEN * (high - low));
    let (mut at_a, mut at_b) = (of(a), of(b));
    for _ in 0..REFINED {
        if at_a > at_b {
            (high, b, at_b) = (b, a, at_a);
            a = high - GOLDEN * (high - low);
            at_a = of(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = low + GOLDEN * (high - low);
            at_b = of(b);
        }
    }
    0.5 * (low + high)
}

/// Half width of the 95 % interval of Student's distribution, in standard deviations: Fisher's expansion about the
/// normal distribution (Abramowitz and Stegun 26.7.5), right to 0.1 % from five degrees of freedom on.
pub(super) fn student_95(degrees_of_freedom: f64) -> f64 {
    let (x, n) = (1.959_963_984_540_054_f64, degrees_of_freedom.max(3.0));
    let g1 = (x.powi(3) + x) / 4.0;
    let g2 = (5.0 * x.powi(5) + 16.0 * x.powi(3) + 3.0 * x) / 96.0;
    let g3 = (3.0 * x.powi(7) + 19.0 * x.powi(5) + 17.0 * x.powi(3) - 15.0 * x) / 384.0;
    let g4 = (79.0 * x.powi(9) + 776.0 * x.powi(7) + 1482.0 * x.powi(5) - 1920.0 * x.powi(3) - 945.0 * x) / 92160.0;
    if n.is_finite() { x + (g1 + (g2 + (g3 + g4 / n) / n) / n) / n } else { x }
}

#[cfg(test)]
mod tests {
    use super::super::data::normal;
    use super::*;
    use fastrand::Rng;

    /// Student's tables.
    #[test]
    fn intervals_are_those_of_the_tables() {
        for (n, expected) in [(5.0, 2.5706), (10.0, 2.2281), (30.0, 2.0423), (120.0, 1.9799), (f64::INFINITY, 1.95996)]
        {
            assert!((student_95(n) / expected - 1.0).abs() < 1e-3, "{n}: {}", student_95(n));
        }
    }

    /// Whitening and its inverse are one another's; whitened noise has no correlation left.
    #[test]
    fn noise_is_whitened() {
        let mut rng = Rng::with_seed(1);
        let white: Vec<f64> = (0..20_000).map(|_| normal(&mut rng)).collect();
        let mut rows = white.clone();
        unwhiten(&mut rows, 0.9);
        let products: f64 = rows.windows(2).map(|pair| pair[0] * pair[1]).sum();
        assert!((products / dot(&rows, &rows) - 0.9).abs() < 0.01);
        assert!((dot(&rows, &rows) / 20_000.0 - 1.0).abs() < 0.1);
        whiten(&mut rows, 0.9);
        assert!(rows.iter().zip(&white).all(|(a, b)| (a - b).abs() < 1e-9));
    }

    /// Lines through correlated noise: the correlation time is found within its scatter, white noise stays white, and
    /// the intervals of the slope hold the truth in 95 % of 1000 drawings. For comparison, least squares with errors
    /// that count samples as independent hold it in half of them.
    #[test]
    fn intervals_of_a_line_hold() {
        let (rows, dt_s) = (496, 250e-6);
        let slope: Vec<f64> = (0..rows).map(|n| (n as f64 / rows as f64 * 9.0).sin()).collect();
        for (time_s, size_known) in [(0.0, true), (0.4e-3, true), (2.4e-3, true), (2.4e-3, false)] {
            let own = correlation(time_s, dt_s);
            let channels = [NoisyRows { rows: 0..rows, column: 0, dt_s, is_free: !size_known }];
            let (mut holds, mut white, mut log) = (0, 0, 0.0);
            for seed in 0..1000 {
                let mut rng = Rng::with_seed(seed);
                let mut residuals: Vec<f64> = (0..rows).map(|_| normal(&mut rng)).collect();
                unwhiten(&mut residuals, own);
                let jacobian = [slope.clone()];
                let left = Leftovers { channels: &channels, residuals: &residuals, jacobian: &jacobian, drive: &[] };
                let mut found = left.estimate();
                let freedom = left.degrees_of_freedom(&found)[0];
                if size_known {
                    found.sizes = vec![1.0];
                }
                white += usize::from(found.times_s[0] == 0.0);
                log += (found.times_s[0] / time_s.max(1e-9)).ln();
                let (j, r) = (left.whitened(&slope, &found), left.whitened(&residuals, &found));
                let (x, std) = (dot(&j, &r) / dot(&j, &j), dot(&j, &j).powf(-0.5));
                let half = student_95(freedom) * std;
                holds += usize::from(x.abs() < half);
            }
            // Three standard deviations of a binomial count are 2.1 %.
            assert!((929..=971).contains(&holds), "{time_s} {size_known}: {holds}");
            if time_s == 0.0 {
                // Noise that is given too large is no correlation.
                let mut rng = Rng::with_seed(1);
                let residuals: Vec<f64> = (0..rows).map(|_| 0.5 * normal(&mut rng)).collect();
                let jacobian = [slope.clone()];
                let left = Leftovers { channels: &channels, residuals: &residuals, jacobian: &jacobian, drive: &[] };
                assert_eq!(left.estimate().times_s, [0.0]);
                assert!(white > 960, "{white}");
            } else {
                assert!(white == 0 && (log / 1000.0).abs() < 0.1, "{time_s}: {white} {}", log / 1000.0);
            }
        }
    }
}

//! Error measures of a simulated series against a measured one.

use erard::recording::Fourier;

use super::RATE_HZ;

/// Edges of the frequency bands, Hz.
pub(crate) const BANDS_HZ: [f64; 5] = [0.0, 10.0, 50.0, 200.0, 1000.0];
/// Longest delay searched for, s.
const MAX_DELAY_S: f64 = 0.02;

/// Differences of one series from another; both in the same unit, on the common axis.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// Root mean square of the difference.
    pub rms: f64,
    /// Root mean square over the range of the measured series.
    pub rms_of_range: f64,
    /// Largest difference.
    pub largest: f64,
    /// Explained share of the measured variance: 1 - rms^2 / variance; negative if a constant would do better.
    pub explained: f64,
    /// Correlation coefficient without delay; 0 if one of them is constant.
    pub correlation: f64,
    /// Delay of the simulated series with the largest correlation, within 20 ms, s; positive if it is late.
    pub delay_s: f64,
    /// Contribution of the rest before the touch, which any model explains; `None` without a rest.
    pub rest: Option<Rest>,
    /// Errors by frequency band.
    pub bands: Vec<Band>,
}

/// Contribution of the rest before the touch to the variance.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rest {
    /// Share of the measured variance that belongs to samples at rest, by their distance from the overall mean.
    pub share: f64,
    /// Explained share of the measured variance without these samples.
    pub explained_without: f64,
}

/// Errors in one frequency band.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Band {
    /// Lower edge, Hz.
    pub from_hz: f64,
    /// Upper edge, Hz.
    pub to_hz: f64,
    /// Root mean square of the measured series in the band.
    pub measured_rms: f64,
    /// Root mean square of the difference in the band.
    pub error_rms: f64,
}

impl Errors {
    /// Compares two series of equal length, sampled at [`RATE_HZ`]; the first `resting` samples are before the touch.
    pub fn new(measured: &[f64], simulated: &[f64], resting: usize) -> Self {
        let difference: Vec<f64> = simulated.iter().zip(measured).map(|(s, m)| s - m).collect();
        let range = measured.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), &x| (a.min(x), b.max(x)));
        let rms = mean_square(&difference).sqrt();
        let variance = mean_square(&centred(measured));
        Errors {
            rms,
            rms_of_range: ratio(rms, range.1 - range.0),
            largest: difference.iter().fold(0.0, |a, &d| d.abs().max(a)),
            explained: 1.0 - ratio(rms * rms, variance),
            correlation: correlation(measured, simulated, 0),
            delay_s: delay(measured, simulated),
            rest: Rest::of(measured, simulated, resting),
            bands: bands(measured, simulated),
        }
    }
}

impl Rest {
    fn of(measured: &[f64], simulated: &[f64], resting: usize) -> Option<Self> {
        if resting == 0 || resting + 2 > measured.len() {
            return None;
        }
        let sum = |x: &[f64]| x.iter().map(|x| x * x).sum::<f64>();
        let all = centred(measured);
        let (moving, modelled) = (&measured[resting..], &simulated[resting..]);
        let missed: Vec<f64> = modelled.iter().zip(moving).map(|(s, m)| s - m).collect();
        Some(Rest {
            share: ratio(sum(&all[..resting]), sum(&all)),
            explained_without: 1.0 - ratio(mean_square(&missed), mean_square(&centred(moving))),
        })
    }
}

/// a/b, and zero for 0/0.
fn ratio(a: f64, b: f64) -> f64 {
    if a == 0.0 { 0.0 } else { a / b }
}

fn mean_square(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>() / x.len().max(1) as f64
}

fn centred(x: &[f64]) -> Vec<f64> {
    let mean = x.iter().sum::<f64>() / x.len().max(1) as f64;
    x.iter().map(|x| x - mean).collect()
}

/// Correlation coefficient of the measured series with the simulated one, taken `lag` samples later.
pub(super) fn correlation(measured: &[f64], simulated: &[f64], lag: isize) -> f64 {
    let n = measured.len() as isize;
    let (from, to) = ((-lag).max(0), (n - lag).min(n));
    if to - from < 2 {
        return 0.0;
    }
    let a = centred(&measured[from as usize..to as usize]);
    let b = centred(&simulated[(from + lag) as usize..(to + lag) as usize]);
    let product: f64 = a.iter().zip(&b).map(|(x, y)| x * y).sum::<f64>() / a.len() as f64;
    let scale = (mean_square(&a) * mean_square(&b)).sqrt();
    if scale > 0.0 { product / scale } else { 0.0 }
}

/// Lag of the largest correlation, refined by a parabola through its neighbours.
fn delay(measured: &[f64], simulated: &[f64]) -> f64 {
    let most = ((MAX_DELAY_S * RATE_HZ) as isize).min(measured.len() as isize / 4);
    let at = |lag| correlation(measured, simulated, lag);
    let best = (-most..=most).max_by(|&a, &b| at(a).total_cmp(&at(b))).unwrap_or(0);
    let (before, here, after) = (at(best - 1), at(best), at(best + 1));
    let bend = before - 2.0 * here + after;
    let refined = if bend < 0.0 { (0.5 * (before - after) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    (best as f64 + refined) / RATE_HZ
}

/// Root mean squares of series and difference in each band. By Parseval's theorem, the squares of all bands add up to
/// the mean square.
pub(super) fn bands(measured: &[f64], simulated: &[f64]) -> Vec<Band> {
    let difference: Vec<f64> = simulated.iter().zip(measured).map(|(s, m)| s - m).collect();
    let squares = |x: &[f64]| Fourier::of(x.len()).squares(x.iter().copied());
    let (m, d) = (squares(measured), squares(&difference));
    let n = measured.len();
    let power = |squares: &[f64], from: f64, to: f64| {
        let mut sum = 0.0;
        for (k, square) in squares.iter().enumerate().take(n / 2 + 1) {
            let f = k as f64 * RATE_HZ / n as f64;
            if f >= from && f < to {
                let twice = if k == 0 || 2 * k == n { 1.0 } else { 2.0 };
                sum += twice * square;
            }
        }
        sum.sqrt() / n as f64
    };
    BANDS_HZ
        .windows(2)
        .map(|edge| Band {
            from_hz: edge[0],
            to_hz: edge[1],
            measured_rms: power(&m, edge[0], edge[1]),
            error_rms: power(&d, edge[0], edge[1]),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    fn wave(hz: f64, amplitude: f64, late_s: f64) -> Vec<f64> {
        // One second has whole periods, so that the spectrum does not leak.
        (0..RATE_HZ as usize).map(|n| amplitude * (TAU * hz * (n as f64 / RATE_HZ - late_s)).sin()).collect()
    }

    /// A delayed copy of a 20 Hz wave: the delay is found to a tenth of a sample, and nothing else is wrong with it.
    #[test]
    fn a_delay_is_found() {
        let e = Errors::new(&wave(20.0, 1.0, 0.0), &wave(20.0, 1.0, 0.0031), 0);
        assert!((e.delay_s - 0.0031).abs() < 0.1 / RATE_HZ, "{}", e.delay_s);
        assert!((e.correlation - (TAU * 20.0 * 0.0031).cos()).abs() < 1e-9);
    }

    /// A 100 Hz error of amplitude 0.1 on a 5 Hz wave appears in its band only: rms 0.1/sqrt(2).
    #[test]
    fn an_error_stands_in_its_band() {
        let measured = wave(5.0, 1.0, 0.0);
        let simulated: Vec<f64> = measured.iter().zip(wave(100.0, 0.1, 0.0)).map(|(a, b)| a + b).collect();
        let e = Errors::new(&measured, &simulated, 0);
        let expected = 0.1 / 2.0_f64.sqrt();
        assert!((e.rms - expected).abs() < 1e-12);
        assert!((e.rms_of_range - expected / 2.0).abs() < 1e-12);
        assert!((e.explained - 0.99).abs() < 1e-9);
        for band in &e.bands {
            let here = band.from_hz <= 100.0 && 100.0 < band.to_hz;
            assert!((band.error_rms - if here { expected } else { 0.0 }).abs() < 1e-9, "{band:?}");
        }
        assert!((e.bands[0].measured_rms - 0.5_f64.sqrt()).abs() < 1e-9);
    }

    /// A rest of 0 and a step to 1: the rest has three quarters of the variance where it is a quarter of the time, and
    /// a model that is wrong elsewhere explains nothing without it.
    #[test]
    fn a_rest_has_its_share() {
        let measured: Vec<f64> =
            (0..4000).map(|n| if n < 1000 { 0.0 } else { 1.0 + 0.01 * f64::from(n % 2) }).collect();
        let simulated: Vec<f64> = (0..4000).map(|n| if n < 1000 { 0.0 } else { 1.005 }).collect();
        let e = Errors::new(&measured, &simulated, 1000);
        let rest = e.rest.unwrap();
        assert!((rest.share - 0.75).abs() < 1e-3 && e.explained > 0.999, "{e:?}");
        assert!(rest.explained_without.abs() < 1e-9, "{rest:?}");
        assert_eq!(Errors::new(&measured, &simulated, 0).rest, None);
    }

    /// The same series has no error; a constant has no correlation.
    #[test]
    fn ends_of_the_scale() {
        let a = wave(3.0, 2.0, 0.0);
        let e = Errors::new(&a, &a, 0);
        assert_eq!((e.rms, e.largest, e.explained), (0.0, 0.0, 1.0));
        assert!((e.correlation - 1.0).abs() < 1e-12);
        assert_eq!(Errors::new(&a, &vec![1.0; a.len()], 0).correlation, 0.0);
    }
}

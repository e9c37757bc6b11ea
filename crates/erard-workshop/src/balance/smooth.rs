//! Smooth curve through measured values over the keyboard, with gaps and outliers.
//!
//! Whittaker's smoother (E. T. Whittaker, Proc. Edinburgh Math. Soc. 41 (1922) 63-75; P. H. C. Eilers, Anal. Chem. 75
//! (2003) 3631): the curve z that minimises sum w (y - z)^2 + lambda sum (third differences of z)^2. It keeps parabolas
//! and bridges gaps by them. Weights are Tukey's, from the residuals of the last curve, so that one wrong hammer does
//! not bend its neighbours' target.

use erard::keyboard::KEYS;

/// A wave of this length in keys keeps half its height; shorter ones are removed, longer ones kept.
pub(crate) const HALF_GAIN_KEYS: f64 = 30.0;
/// Rounds of reweighting.
const ROUNDS: usize = 8;
/// Tukey's constant: residuals beyond this many standard deviations have no weight.
const TUKEY: f64 = 4.685;
/// Standard deviations per median absolute residual, for normal errors.
const PER_MEDIAN: f64 = 1.4826;
/// Smaller residuals are no outliers, g (or a hundredth of a ratio times ten): scales read to a tenth of a gram.
const FINEST: f64 = 0.1;

/// Returns a smooth curve over all keys, the first at index 0, through values of some of them; `None` if fewer than
/// four are known.
#[must_use]
pub fn smooth(values: &[Option<f64>; KEYS]) -> Option<[f64; KEYS]> {
    let known: Vec<usize> = (0..KEYS).filter(|&key| values[key].is_some_and(f64::is_finite)).collect();
    if known.len() < 4 {
        return None;
    }
    let y: [f64; KEYS] = std::array::from_fn(|key| values[key].filter(|y| y.is_finite()).unwrap_or(0.0));
    let mut weights = [0.0; KEYS];
    known.iter().for_each(|&key| weights[key] = 1.0);
    let mut curve = solve(&y, &weights);
    for _ in 0..ROUNDS {
        let residual = |key: usize| (y[key] - curve[key]).abs();
        let mut sorted: Vec<f64> = known.iter().map(|&key| residual(key)).collect();
        sorted.sort_by(f64::total_cmp);
        let width = TUKEY * (PER_MEDIAN * sorted[sorted.len() / 2]).max(FINEST);
        let mut new = [0.0; KEYS];
        for &key in &known {
            let share = residual(key) / width;
            new[key] = if share < 1.0 { (1.0 - share * share).powi(2) } else { 0.0 };
        }
        if new.iter().filter(|weight| **weight > 0.0).count() < 4 {
            break;
        }
        weights = new;
        curve = solve(&y, &weights);
    }
    Some(curve)
}

/// Solves (W + lambda D' D) z = W y, D the third differences: a band of seven diagonals, by Cholesky factors.
fn solve(y: &[f64; KEYS], weights: &[f64; KEYS]) -> [f64; KEYS] {
    const BAND: usize = 3;
    const THIRD: [f64; 4] = [-1.0, 3.0, -3.0, 1.0];
    // The gain at a wavelength of P keys is 1 / (1 + lambda (2 sin(pi / P))^6).
    let lambda = (2.0 * (std::f64::consts::PI / HALF_GAIN_KEYS).sin()).powi(-6);
    // Row i holds the diagonal and the BAND entries below it: a[i][k] is the entry (i + k, i).
    let mut a = [[0.0; BAND + 1]; KEYS];
    for (row, weight) in a.iter_mut().zip(weights) {
        row[0] = *weight;
    }
    for first in 0..KEYS - BAND {
        for i in 0..=BAND {
            for k in 0..=BAND - i {
                a[first + i][k] += lambda * THIRD[i] * THIRD[i + k];
            }
        }
    }
    for i in 0..KEYS {
        let diagonal = a[i][0];
        for k in 1..=BAND.min(KEYS - 1 - i) {
            let factor = a[i][k] / diagonal;
            for m in k..=BAND.min(KEYS - 1 - i) {
                let below = a[i][m];
                a[i + k][m - k] -= factor * below;
            }
        }
    }
    // L D L': forward, diagonal, backward.
    let mut z: [f64; KEYS] = std::array::from_fn(|key| weights[key] * y[key]);
    for i in 0..KEYS {
        for k in 1..=BAND.min(KEYS - 1 - i) {
            z[i + k] -= a[i][k] / a[i][0] * z[i];
        }
    }
    for i in (0..KEYS).rev() {
        let mut value = z[i];
        for k in 1..=BAND.min(KEYS - 1 - i) {
            value -= a[i][k] * z[i + k];
        }
        z[i] = value / a[i][0];
    }
    z
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parabola(key: usize) -> f64 {
        let x = key as f64;
        10.4 - 0.03 * x - 4e-4 * x * x
    }

    /// A parabola is reproduced, also with keys missing in the middle and at both ends.
    #[test]
    fn parabolas_stay() {
        let values = std::array::from_fn(|key| (key % 7 != 3 && key > 4 && key < 80).then(|| parabola(key)));
        let curve = smooth(&values).unwrap();
        for (key, value) in curve.iter().enumerate() {
            assert!((value - parabola(key)).abs() < 1e-6, "{key}: {value}");
        }
    }

    /// A wave of thirty keys keeps half its height, one of ten next to nothing: the smoother's frequency response in
    /// closed form.
    #[test]
    fn waves_keep_what_the_filter_says() {
        for (keys, gain) in [(30.0, 0.5), (10.0, 1.0 / (1.0 + (0.618_033_988_75_f64 / 0.209_056_926_5).powi(6)))] {
            let wave = |key: usize| (std::f64::consts::TAU * key as f64 / keys).sin() * 0.05;
            let values = std::array::from_fn(|key| Some(wave(key)));
            let curve = smooth(&values).unwrap();
            // Far from both ends, at the wave's crests.
            let crests = (30..58).filter(|&key| wave(key).abs() > 0.049);
            for key in crests {
                assert!((curve[key] / wave(key) - gain).abs() < 0.03, "{keys} {key}: {}", curve[key] / wave(key));
            }
        }
    }

    /// A hammer 3 g too heavy bends the curve at its neighbours by less than a hundredth of a gram.
    #[test]
    fn an_outlier_bends_nothing() {
        let mut values = std::array::from_fn(|key| Some(parabola(key)));
        values[40] = Some(parabola(40) + 3.0);
        let curve = smooth(&values).unwrap();
        assert!((curve[40] - parabola(40)).abs() < 0.01, "{}", curve[40] - parabola(40));
    }

    #[test]
    fn too_few_make_no_curve() {
        assert!(smooth(&std::array::from_fn(|key| (key < 3).then_some(1.0))).is_none());
    }
}

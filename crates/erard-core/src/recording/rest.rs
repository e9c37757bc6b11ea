//! The rest before the touch.

use super::noise::{deviation, mean, range};

/// Shortest rest that counts, s and samples.
const SHORTEST_S: f64 = 0.01;
const FEWEST: usize = 10;
/// The touch is there when a smoothed series has left its beginning by this share of its range.
const TOUCHED: f64 = 0.01;
/// Over how long it is smoothed, s.
const SMOOTHED_S: f64 = 0.001;
/// In a rest the halves differ by no more than this share of the range, or than their noise explains.
const STILL: f64 = 1e-3;

/// Number of samples at rest before the first motion; 0 without a rest.
pub(super) fn rest(time_s: &[f64], x: &[f64]) -> usize {
    let (low, high) = range(x);
    let range = high - low;
    let begun = time_s.partition_point(|t| t - time_s[0] < SHORTEST_S);
    if begun < FEWEST || begun >= x.len() || range <= 0.0 {
        return 0;
    }
    let (base, noise) = (mean(&x[..begun]), deviation(&x[..begun]));
    let per_sample_s = (time_s[begun] - time_s[0]) / begun as f64;
    let half = ((0.5 * SMOOTHED_S / per_sample_s) as usize).min(x.len() / 4);
    let sums: Vec<f64> = std::iter::once(0.0)
        .chain(x.iter().scan(0.0, |sum, x| {
            *sum += x - base;
            Some(*sum)
        }))
        .collect();
    let away = |n: usize| {
        let (from, to) = (n.saturating_sub(half), (n + half + 1).min(x.len()));
        ((sums[to] - sums[from]) / (to - from) as f64).abs()
    };
    let noise = 5.0 * noise / ((2 * half + 1) as f64).sqrt();
    let Some(touched) = (0..x.len()).find(|&n| away(n) > (TOUCHED * range).max(noise)) else { return 0 };
    // Back to where it began to move.
    let still = (0..touched).rev().find(|&n| away(n) <= (0.1 * TOUCHED * range).max(0.4 * noise)).map_or(0, |n| n + 1);
    let still = still.saturating_sub(half);
    if still < FEWEST || time_s[still - 1] - time_s[0] < SHORTEST_S - 1.5 * per_sample_s {
        return 0;
    }
    let (first, second) = x[..still].split_at(still / 2);
    let explained = 4.0 * deviation(first).min(deviation(second)) * (4.0 / still as f64).sqrt();
    if (mean(first) - mean(second)).abs() > explained.max(STILL * range) { 0 } else { still }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fastrand::Rng;

    fn series(rest_s: f64, offset: f64, noise: f64, rate_hz: f64) -> (Vec<f64>, Vec<f64>) {
        let mut rng = Rng::with_seed(3);
        let time: Vec<f64> = (0..(0.4 * rate_hz) as usize).map(|n| n as f64 / rate_hz).collect();
        let push = |t: f64| 2.5 * (1.0 - (std::f64::consts::PI * ((t - rest_s) / 0.03).clamp(0.0, 1.0)).cos());
        let x = time.iter().map(|&t| offset + push(t) + noise * (2.0 * rng.f64() - 1.0)).collect();
        (time, x)
    }

    /// It ends within a few milliseconds before the touch, never after the force has begun to rise by more than two in
    /// a hundred.
    #[test]
    fn it_ends_at_the_touch() {
        for (noise, rate_hz) in [(0.0, 20e3), (0.05, 20e3), (0.05, 2e3), (0.0, 1e3)] {
            let (time, x) = series(0.1, -0.3, noise, rate_hz);
            let end_s = rest(&time, &x) as f64 / rate_hz;
            assert!((0.09..0.104).contains(&end_s), "noise {noise}, {rate_hz} Hz: {end_s}");
            let offset = mean(&x[..rest(&time, &x)]);
            assert!((offset + 0.3).abs() < 0.006, "{offset}");
        }
    }

    /// A touch that begins with the recording, one that goes on all the time, and a constant have no rest before them.
    #[test]
    fn there_may_be_none() {
        for noise in [0.0, 0.02] {
            let (time, x) = series(0.0, 0.0, noise, 20e3);
            assert_eq!(rest(&time, &x), 0, "noise {noise}");
        }
        let time: Vec<f64> = (0..4000).map(|n| f64::from(n) * 1e-4).collect();
        assert_eq!(rest(&time, &vec![5.0; 4000]), 0);
        assert_eq!(rest(&time, &time.iter().map(|t| 3.0 * t).collect::<Vec<_>>()), 0);
        assert_eq!(rest(&[0.0, 1.0], &[0.0, 1.0]), 0);
    }
}

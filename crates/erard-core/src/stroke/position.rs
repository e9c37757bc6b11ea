//! Position between samples: a cubic spline that starts and ends at rest.

use std::borrow::Borrow;

use super::{Cursor, SampleError, check_samples};

/// Position over time, interpolated by the clamped cubic spline: twice continuously differentiable, with zero velocity
/// at both ends. Before the first sample and after the last one the driver holds still at that sample's position, so
/// that the velocity is continuous for all time (the acceleration jumps at the two ends only).
#[derive(Debug, Clone, PartialEq)]
pub struct PositionSeries {
    times_s: Vec<f64>,
    positions_m: Vec<f64>,
    /// Second derivatives at the samples, m/s2.
    curvatures: Vec<f64>,
}

impl PositionSeries {
    /// Interpolates samples: `times_s` increasing, `positions_m` positive downward, of the same length, two or more.
    ///
    /// # Errors
    /// When the samples are too few, not finite, or not increasing in time.
    pub fn new(times_s: Vec<f64>, positions_m: Vec<f64>) -> Result<Self, SampleError> {
        check_samples(&times_s, &positions_m)?;
        let curvatures = clamped_curvatures(&times_s, &positions_m);
        Ok(Self { times_s, positions_m, curvatures })
    }

    /// The motion as a function for a run with ascending instants: time in s to position in m and velocity in m/s.
    pub fn drive(&self) -> impl Fn(f64) -> [f64; 2] {
        Self::driven(self)
    }

    /// This function for a borrowed or shared series.
    pub(super) fn driven(series: impl Borrow<Self>) -> impl Fn(f64) -> [f64; 2] {
        Cursor::kept(move |t_s, cursor| {
            let (position, velocity, _) = series.borrow().at(t_s, cursor);
            [position, velocity]
        })
    }

    /// Position (m), velocity (m/s) and acceleration (m/s2) at `t_s`, all positive downward.
    ///
    /// No allocation; constant time when `t_s` moves little between calls with the same cursor.
    pub fn at(&self, t_s: f64, cursor: &mut Cursor) -> (f64, f64, f64) {
        let times = &self.times_s;
        let last = times.len() - 1;
        if t_s.is_nan() || t_s <= times[0] {
            return (self.positions_m[0], 0.0, 0.0);
        }
        if t_s >= times[last] {
            return (self.positions_m[last], 0.0, 0.0);
        }
        let i = cursor.seek(times, t_s);
        let h = times[i + 1] - times[i];
        let (y0, y1) = (self.positions_m[i], self.positions_m[i + 1]);
        let (m0, m1) = (self.curvatures[i], self.curvatures[i + 1]);
        // Distances to the two ends as fractions of the interval.
        let b = (t_s - times[i]) / h;
        let a = 1.0 - b;
        let position = a * y0 + b * y1 + ((a * a * a - a) * m0 + (b * b * b - b) * m1) * h * h / 6.0;
        let velocity = (y1 - y0) / h + ((3.0 * b * b - 1.0) * m1 - (3.0 * a * a - 1.0) * m0) * h / 6.0;
        (position, velocity, a * m0 + b * m1)
    }

    /// The sampled instants, s.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// The sampled positions, m, positive downward.
    pub fn positions_m(&self) -> &[f64] {
        &self.positions_m
    }
}

/// Second derivatives of the clamped spline with zero end slopes, from the usual tridiagonal system `h[i-1] m[i-1] + 2
/// (h[i-1] + h[i]) m[i] + h[i] m[i+1] = 6 (slope[i] - slope[i-1])`, at the ends with the slope 0 outside. The matrix is
/// diagonally dominant, so that elimination without pivoting is stable.
fn clamped_curvatures(times: &[f64], values: &[f64]) -> Vec<f64> {
    let n = times.len();
    let step = |i: usize| times[i + 1] - times[i];
    let slope = |i: usize| (values[i + 1] - values[i]) / step(i);
    // `curvatures` holds the right-hand side until back substitution; `upper` the eliminated upper diagonal.
    let mut curvatures = vec![0.0; n];
    let mut upper = vec![0.0; n];
    for i in 0..n {
        let (below, slope_below) = if i == 0 { (0.0, 0.0) } else { (step(i - 1), slope(i - 1)) };
        let (above, slope_above) = if i == n - 1 { (0.0, 0.0) } else { (step(i), slope(i)) };
        let (upper_below, rhs_below) = if i == 0 { (0.0, 0.0) } else { (upper[i - 1], curvatures[i - 1]) };
        let pivot = 2.0 * (below + above) - below * upper_below;
        upper[i] = above / pivot;
        curvatures[i] = (6.0 * (slope_above - slope_below) - below * rhs_below) / pivot;
    }
    for i in (0..n - 1).rev() {
        curvatures[i] -= upper[i] * curvatures[i + 1];
    }
    curvatures
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Deterministic uneven instants on [0, 1].
    fn uneven(n: usize) -> Vec<f64> {
        (0..n)
            .map(|i| i as f64 / (n - 1) as f64)
            .map(|s| s + 0.08 * (std::f64::consts::TAU * s).sin() + 0.02 * (4.0 * std::f64::consts::TAU * s).sin())
            .collect()
    }

    fn largest_error(series: &PositionSeries, exact: impl Fn(f64) -> [f64; 3]) -> [f64; 3] {
        let mut cursor = Cursor::default();
        let mut largest = [0.0_f64; 3];
        for i in 0..=5000 {
            let t = f64::from(i) / 5000.0;
            let (y, v, a) = series.at(t, &mut cursor);
            for (largest, (got, want)) in largest.iter_mut().zip([y, v, a].into_iter().zip(exact(t))) {
                *largest = largest.max((got - want).abs());
            }
        }
        largest
    }

    /// The spline is the only C2 piecewise cubic with these end slopes, so the smooth step 3 t^2 - 2 t^3, a single
    /// cubic with zero end slopes, comes back from any samples but for rounding (amplified by 1/h^2 in the
    /// acceleration).
    #[test]
    fn a_cubic_that_starts_and_ends_at_rest_is_reproduced() {
        for n in [2, 3, 7, 40] {
            let times = uneven(n);
            let series = PositionSeries::new(times.clone(), times.iter().map(|t| t * t * (3.0 - 2.0 * t)).collect());
            let series = series.expect("good samples");
            let [y, v, a] = largest_error(&series, |t| [t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t), 6.0 - 12.0 * t]);
            // At the very ends the driver holds still: the acceleration there is 0, not 6.
            assert!(y < 1e-14 && v < 1e-12, "{n}: {y:e} {v:e}");
            assert!((a - 6.0).abs() < 1e-9, "{n}: {a:e}");
        }
    }

    /// (1 - cos(2 pi t)) / 2 has zero end slopes: position converges with order 4, velocity with 3, acceleration with
    /// 2.
    #[test]
    fn a_sine_converges_with_order_four() {
        let exact = |t: f64| {
            let w = std::f64::consts::TAU;
            [0.5 * (1.0 - (w * t).cos()), 0.5 * w * (w * t).sin(), 0.5 * w * w * (w * t).cos()]
        };
        let error = |n: usize| {
            let times = uneven(n + 1);
            let values = times.iter().map(|&t| exact(t)[0]).collect();
            let series = PositionSeries::new(times, values).expect("good samples");
            let mut error = largest_error(&series, exact);
            // The acceleration at the held ends is 0 by design; look at the inside.
            let mut cursor = Cursor::default();
            error[2] = (1..5000)
                .map(|i| f64::from(i) / 5000.0)
                .map(|t| (series.at(t, &mut cursor).2 - exact(t)[2]).abs())
                .fold(0.0, f64::max);
            error
        };
        let (coarse, fine) = (error(40), error(80));
        for (derivative, order) in [(0, 4.0), (1, 3.0), (2, 2.0)] {
            let got = (coarse[derivative] / fine[derivative]).log2();
            assert!((got - order).abs() < 0.35, "derivative {derivative}: order {got}");
        }
    }

    #[test]
    fn velocity_is_continuous_everywhere_and_zero_outside() {
        let times = vec![0.1, 0.13, 0.2, 0.21, 0.5];
        let series = PositionSeries::new(times.clone(), vec![0.0, 0.002, 0.009, 0.0095, 0.001]).expect("good samples");
        let mut cursor = Cursor::default();
        for (i, &t) in times.iter().enumerate() {
            let (before, after) = (series.at(t - 1e-9, &mut cursor), series.at(t + 1e-9, &mut cursor));
            assert!((before.0 - after.0).abs() < 1e-8 && (before.1 - after.1).abs() < 1e-6, "{before:?} {after:?}");
            if (1..times.len() - 1).contains(&i) {
                assert!((before.2 - after.2).abs() < 1e-4, "acceleration too: {before:?} {after:?}");
            }
            assert!((series.at(t, &mut cursor).0 - series.positions_m()[i]).abs() < 1e-17);
        }
        assert_eq!(series.at(-1.0, &mut cursor), (0.0, 0.0, 0.0));
        assert_eq!(series.at(9.0, &mut cursor), (0.001, 0.0, 0.0));
        assert_eq!(series.at(f64::NAN, &mut cursor), (0.0, 0.0, 0.0));
    }

    #[test]
    fn the_cursor_changes_the_cost_but_not_the_values() {
        let times: Vec<f64> = (0..500).map(|i| f64::from(i) * 1e-3 + f64::from(i % 7) * 1e-5).collect();
        let values: Vec<f64> = times.iter().map(|t| (30.0 * t).sin()).collect();
        let series = PositionSeries::new(times, values).expect("good samples");
        let mut kept = Cursor::default();
        let forward = (0..6000).map(|i| f64::from(i) * 1e-4 - 0.05);
        let jumps = (0..6000).map(|i| f64::from(i * 7919 % 6000) * 1e-4 - 0.05);
        for t in forward.chain(jumps) {
            assert_eq!(series.at(t, &mut kept), series.at(t, &mut Cursor::default()), "{t}");
        }
        assert_eq!(series.at(0.2, &mut Cursor(usize::MAX)), series.at(0.2, &mut Cursor::default()));
    }

    #[test]
    fn samples_that_cannot_be_interpolated_are_refused() {
        let new = |times: &[f64], values: &[f64]| PositionSeries::new(times.to_vec(), values.to_vec()).err();
        assert_eq!(new(&[], &[]), Some(SampleError::TooFew));
        assert_eq!(new(&[0.0], &[0.0]), Some(SampleError::TooFew));
        assert_eq!(new(&[0.0, 1.0], &[0.0]), Some(SampleError::UnequalLengths));
        assert_eq!(new(&[0.0, f64::NAN], &[0.0, 1.0]), Some(SampleError::NotFinite(1)));
        assert_eq!(new(&[0.0, 1.0], &[f64::INFINITY, 1.0]), Some(SampleError::NotFinite(0)));
        assert_eq!(new(&[0.0, 0.0], &[0.0, 1.0]), Some(SampleError::NotIncreasing(1)));
        assert_eq!(new(&[0.0, 1.0, 0.5], &[0.0, 1.0, 2.0]), Some(SampleError::NotIncreasing(2)));
    }
}

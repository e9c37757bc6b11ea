//! Force between samples: a piecewise cubic without overshoot.

use std::borrow::Borrow;

use super::{Cursor, SampleError, check_samples};

/// Force over time, interpolated by monotone piecewise cubics (Fritsch and Carlson): continuous, with a continuous
/// slope, and between two samples never outside them, so that a series of pushes never pulls.
///
/// Before the first sample and after the last one the force holds that sample's value: a recording that ends with the
/// finger on the key leaves it there, one that ends at 0 N has let go.
#[derive(Debug, Clone, PartialEq)]
pub struct ForceSeries {
    times_s: Vec<f64>,
    forces_n: Vec<f64>,
    /// Slopes at the samples, N/s.
    slopes: Vec<f64>,
}

impl ForceSeries {
    /// Interpolates samples: `times_s` increasing, `forces_n` positive when pushing, of the same length, two or more.
    ///
    /// # Errors
    /// When the samples are too few, not finite, or not increasing in time.
    pub fn new(times_s: Vec<f64>, forces_n: Vec<f64>) -> Result<Self, SampleError> {
        check_samples(&times_s, &forces_n)?;
        let slopes = monotone_slopes(&times_s, &forces_n);
        Ok(Self { times_s, forces_n, slopes })
    }

    /// The smallest and the largest sample, N.
    pub(super) fn range_n(&self) -> [f64; 2] {
        self.forces_n.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], n| [least.min(*n), most.max(*n)])
    }

    /// The force as a function for a run with ascending instants: time in s to force in N.
    pub fn drive(&self) -> impl Fn(f64) -> f64 {
        Self::driven(self)
    }

    /// As [`ForceSeries::drive`], of a borrowed or shared series.
    pub(super) fn driven(series: impl Borrow<Self>) -> impl Fn(f64) -> f64 {
        Cursor::kept(move |t_s, cursor| series.borrow().at(t_s, cursor))
    }

    /// Force at `t_s`, N, pushing positive.
    ///
    /// No allocation; constant time when `t_s` moves little between calls with the same cursor.
    pub fn at(&self, t_s: f64, cursor: &mut Cursor) -> f64 {
        let times = &self.times_s;
        let last = times.len() - 1;
        if t_s.is_nan() || t_s <= times[0] {
            return self.forces_n[0];
        }
        if t_s >= times[last] {
            return self.forces_n[last];
        }
        let i = cursor.seek(times, t_s);
        let h = times[i + 1] - times[i];
        let s = (t_s - times[i]) / h;
        let (f0, f1) = (self.forces_n[i], self.forces_n[i + 1]);
        let (d0, d1) = (self.slopes[i] * h, self.slopes[i + 1] * h);
        let cubic = f0 + s * (d0 + s * (3.0 * (f1 - f0) - 2.0 * d0 - d1 + s * (d0 + d1 - 2.0 * (f1 - f0))));
        // Exact arithmetic would stay between the samples; rounding gets the last bit wrong.
        cubic.clamp(f0.min(f1), f0.max(f1))
    }

    /// The sampled instants, s.
    pub fn times_s(&self) -> &[f64] {
        &self.times_s
    }

    /// The sampled forces, N, pushing positive.
    pub fn forces_n(&self) -> &[f64] {
        &self.forces_n
    }

    /// The slopes at the samples, N/s: with the forces they are the cubic pieces (in Hermite's form) for a program that
    /// is not this one.
    pub fn slopes_n_per_s(&self) -> &[f64] {
        &self.slopes
    }
}

/// Slopes that keep every piece monotone: zero where the samples turn, else the weighted harmonic mean of the two
/// neighbouring slopes (Fritsch and Butland's choice within Fritsch and Carlson's region). Zero at both ends, where the
/// force goes on as a constant.
fn monotone_slopes(times: &[f64], values: &[f64]) -> Vec<f64> {
    let n = times.len();
    let step = |i: usize| times[i + 1] - times[i];
    let slope = |i: usize| (values[i + 1] - values[i]) / step(i);
    let mut slopes = vec![0.0; n];
    for (i, at_sample) in slopes.iter_mut().enumerate().take(n - 1).skip(1) {
        let (below, above) = (slope(i - 1), slope(i));
        if below * above > 0.0 {
            let (w_below, w_above) = (step(i - 1) + 2.0 * step(i), 2.0 * step(i - 1) + step(i));
            *at_sample = (w_below + w_above) / (w_above / below + w_below / above);
        }
    }
    slopes
}

#[cfg(test)]
mod tests {
    use super::*;

    fn force(times: &[f64], values: &[f64]) -> ForceSeries {
        ForceSeries::new(times.to_vec(), values.to_vec()).expect("good samples")
    }

    /// Between two samples the value stays between them and moves one way: with a sudden onset a spline would dip below
    /// zero, that is, pull.
    #[test]
    fn no_overshoot_and_monotone_between_samples() {
        let times: Vec<f64> = (0..60).map(|i| f64::from(i) * 1e-2 + f64::from(i % 5) * 1.7e-3).collect();
        // Steps, ramps, plateaus, spikes; a small generator in place of noise.
        let values: Vec<f64> =
            (0..60_u64).map(|i| (i * i * 7919 % 41) as f64 * f64::from(u8::from(i % 9 > 2))).collect();
        let series = force(&times, &values);
        let mut cursor = Cursor::default();
        for i in 0..times.len() - 1 {
            let (low, high) = (values[i].min(values[i + 1]), values[i].max(values[i + 1]));
            let rising = values[i + 1] >= values[i];
            let mut previous = values[i];
            for k in 0..=100 {
                let t = times[i] + (times[i + 1] - times[i]) * f64::from(k) / 100.0;
                let f = series.at(t, &mut cursor);
                assert!((low..=high).contains(&f), "{f} outside {low}..{high}");
                let slack = 1e-12 * high;
                assert!(if rising { f >= previous - slack } else { f <= previous + slack });
                previous = f;
            }
        }
    }

    #[test]
    fn samples_are_met_and_slopes_continuous() {
        let times = [0.0, 0.01, 0.015, 0.04, 0.1];
        let values = [0.0, 2.0, 9.0, 10.0, 3.0];
        let series = force(&times, &values);
        let mut cursor = Cursor::default();
        for (&t, &value) in times.iter().zip(&values) {
            assert_eq!(series.at(t, &mut cursor), value);
            let e = 1e-8;
            let f: [f64; 3] = [t - e, t, t + e].map(|t| series.at(t, &mut cursor));
            assert!(((f[2] - f[1]) - (f[1] - f[0])).abs() / e < 0.05, "the slope jumps at {t}");
        }
    }

    /// A monotone smooth function converges with order 3 or better away from turning points (order 2 at them, where the
    /// slope is set to zero). 1 - exp(-5 t) has no turning point; its first interval carries the flat end.
    #[test]
    fn a_monotone_function_converges() {
        let error = |n: u32| {
            let times: Vec<f64> = (0..=n).map(|i| f64::from(i) / f64::from(n)).collect();
            let values: Vec<f64> = times.iter().map(|t| 1.0 - (-5.0 * t).exp()).collect();
            let series = force(&times, &values);
            let mut cursor = Cursor::default();
            (0..=4000)
                .map(|i| 0.25 + 0.5 * f64::from(i) / 4000.0)
                .map(|t| (series.at(t, &mut cursor) - (1.0 - (-5.0 * t).exp())).abs())
                .fold(0.0, f64::max)
        };
        let order = (error(40) / error(80)).log2();
        assert!(order > 2.7, "order {order}");
    }

    #[test]
    fn the_ends_are_held() {
        let series = force(&[0.1, 0.2], &[1.0, 4.0]);
        let mut cursor = Cursor::default();
        assert_eq!(series.at(-5.0, &mut cursor), 1.0);
        assert_eq!(series.at(5.0, &mut cursor), 4.0);
        assert_eq!(series.at(f64::NAN, &mut cursor), 1.0);
        assert!((series.at(0.15, &mut cursor) - 2.5).abs() < 1e-12, "half way in the middle");
        assert_eq!(ForceSeries::new(vec![0.0], vec![0.0]), Err(SampleError::TooFew));
    }
}

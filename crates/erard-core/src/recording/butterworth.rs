//! Butterworth's low-pass, run forward and backward so that nothing is delayed.
//!
//! The analogue filter through the bilinear transform with its cutoff prewarped, as second-order sections (and one of
//! first order where the order is odd). Forward and backward the phase cancels and the gain is squared: one half (-6
//! dB) at the cutoff, for every order.

use std::f64::consts::PI;

/// A low-pass for a series sampled evenly.
#[derive(Debug, Clone, PartialEq)]
pub struct Butterworth {
    cutoff_hz: f64,
    rate_hz: f64,
    sections: Vec<Section>,
}

/// `y[n] = b0 x[n] + b1 x[n-1] + b2 x[n-2] - a1 y[n-1] - a2 y[n-2]`, with gain 1 at 0 Hz.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

/// Orders that make sense here.
pub const ORDERS: std::ops::RangeInclusive<usize> = 1..=10;

/// Periods of the cutoff by which a series is continued at its ends: what a filter of order 4 rings longer is below
/// 1e-6.
const PERIODS_BEYOND_THE_ENDS: f64 = 6.0;

impl Butterworth {
    /// A low-pass of an order (of one pass) for a series with a number of samples per second; `None` where the order is
    /// not one of [`ORDERS`] or the cutoff does not lie between zero and half the rate.
    pub fn low_pass(order: usize, cutoff_hz: f64, rate_hz: f64) -> Option<Self> {
        let is_sound = cutoff_hz > 0.0 && cutoff_hz < 0.5 * rate_hz && rate_hz.is_finite();
        if !(ORDERS.contains(&order) && is_sound) {
            return None;
        }
        let k = libm::tan(PI * cutoff_hz / rate_hz);
        let mut sections = Vec::new();
        if order % 2 == 1 {
            let b = k / (1.0 + k);
            sections.push(Section { b: [b, b, 0.0], a: [(k - 1.0) / (k + 1.0), 0.0] });
        }
        for pair in 0..order / 2 {
            // Half of the pair's 1/Q: the cosine of the pole's angle to the negative real axis.
            let zeta = libm::sin(PI * (2 * pair + 1) as f64 / (2 * order) as f64);
            let all = 1.0 + 2.0 * zeta * k + k * k;
            let b = k * k / all;
            sections.push(Section {
                b: [b, 2.0 * b, b],
                a: [2.0 * (k * k - 1.0) / all, (1.0 - 2.0 * zeta * k + k * k) / all],
            });
        }
        Some(Butterworth { cutoff_hz, rate_hz, sections })
    }

    /// The series forward and backward. At its ends it is continued by its own reflection in the end point, and begins
    /// as if it had always been so.
    pub fn forth_and_back(&self, x: &[f64]) -> Vec<f64> {
        let Some(last) = x.len().checked_sub(1).filter(|last| *last > 0) else { return x.to_vec() };
        let beyond = ((PERIODS_BEYOND_THE_ENDS * self.rate_hz / self.cutoff_hz).ceil() as usize).min(last);
        let before = (1..=beyond).rev().map(|n| 2.0 * x[0] - x[n]);
        let after = (1..=beyond).map(|n| 2.0 * x[last] - x[last - n]);
        let mut y: Vec<f64> = before.chain(x.iter().copied()).chain(after).collect();
        for _ in 0..2 {
            for section in &self.sections {
                section.run(&mut y);
            }
            y.reverse();
        }
        y.drain(beyond..beyond + x.len()).collect()
    }
}

impl Section {
    /// In place, from the steady state under the first value.
    fn run(&self, x: &mut [f64]) {
        let Section { b: [b0, b1, b2], a: [a1, a2] } = *self;
        let first = x.first().copied().unwrap_or(0.0);
        let (mut z1, mut z2) = ((1.0 - b0) * first, (b2 - a2) * first);
        for x in x {
            let y = b0 * *x + z1;
            z1 = b1 * *x - a1 * y + z2;
            z2 = b2 * *x - a2 * y;
            *x = y;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A short series that is nothing in particular.
    fn series() -> Vec<f64> {
        (0..40).map(|n| f64::from(n * n * 7919 % 41) / 10.0 + f64::from(n) / 5.0).collect()
    }

    /// Against SciPy 1.17.1:
    ///
    /// ```text
    /// from scipy.signal import butter, sosfiltfilt
    /// x = [(n * n * 7919 % 41) / 10 + n / 5 for n in range(40)]
    /// for order, cutoff in (4, 100), (3, 240): print(sosfiltfilt(butter(order, cutoff, fs=1000, output="sos"), x, padlen=min(39, -(-6000 // cutoff)))[::13])
    /// ```
    #[test]
    fn as_scipy_does() {
        for (order, cutoff, scipy) in [
            (4, 100.0, [5.009032384706291e-08, 5.082800806829899, 7.6329553111784865, 10.200090029799853]),
            (3, 240.0, [4.970863897030275e-07, 4.793378166857588, 8.424915655768395, 10.199999740467854]),
        ] {
            let y = Butterworth::low_pass(order, cutoff, 1000.0).unwrap().forth_and_back(&series());
            for (ours, theirs) in y.iter().step_by(13).zip(scipy) {
                assert!((ours - theirs).abs() < 1e-11, "{order}, {cutoff} Hz: {ours} {theirs}");
            }
        }
    }

    /// Waves of whole periods, far from the ends: 1 / (1 + (tan(pi f / r) / tan(pi c / r))^2n) of the amplitude, the
    /// analytic response of the squared filter, and no delay.
    #[test]
    fn the_analytic_response() {
        let (rate, cutoff) = (2000.0, 150.0);
        for order in [1, 2, 4, 5, 8] {
            let filter = Butterworth::low_pass(order, cutoff, rate).unwrap();
            for hz in [10.0, 75.0, 150.0, 225.0, 400.0] {
                let x: Vec<f64> = (0..8000).map(|n| (TAU * hz * f64::from(n) / rate).sin()).collect();
                let y = filter.forth_and_back(&x);
                let middle = 2000..6000;
                let share = 2.0 / middle.len() as f64 * middle.clone().map(|n| x[n] * y[n]).sum::<f64>();
                let late = middle.clone().map(|n| (TAU * hz * n as f64 / rate).cos() * y[n]).sum::<f64>();
                let exact = 1.0 / (1.0 + ((PI * hz / rate).tan() / (PI * cutoff / rate).tan()).powi(2 * order as i32));
                assert!((share - exact).abs() < 1e-9, "order {order}, {hz} Hz: {share} {exact}");
                assert!(late.abs() < 1e-6, "order {order}, {hz} Hz is delayed: {late}");
            }
        }
    }

    /// A constant and a straight line pass, ends included.
    #[test]
    fn lines_pass() {
        let line: Vec<f64> = (0..500).map(|n| 3.0 - 0.01 * f64::from(n)).collect();
        let y = Butterworth::low_pass(4, 30.0, 1000.0).unwrap().forth_and_back(&line);
        assert!(y.iter().zip(&line).all(|(y, x)| (y - x).abs() < 1e-6));
        assert_eq!(Butterworth::low_pass(4, 30.0, 1000.0).unwrap().forth_and_back(&[2.0]), [2.0]);
    }

    #[test]
    fn what_is_no_filter() {
        for (order, cutoff, rate) in
            [(0, 1.0, 10.0), (11, 1.0, 10.0), (4, 0.0, 10.0), (4, 5.0, 10.0), (4, f64::NAN, 10.0)]
        {
            assert_eq!(Butterworth::low_pass(order, cutoff, rate), None);
        }
    }
}

//! Time intervals of a step.

use crate::real::Real;

/// m/s; a zone so far apart that it would need a greater speed to touch within the step is left out. A faster one still
/// counts from the theta point on. 20 m/s is three times the fastest hammer.
const CLOSING_SPEED: f64 = 20.0;
/// 1/sqrt(3): the two-point Gauss nodes on [-1, 1].
const GAUSS_POINT: f64 = 0.577_350_269_189_625_8;

/// The step's lengths of time, s, and how near a zone must be to be looked at.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Timing<T> {
    /// h.
    pub step: T,
    /// theta h: from the step's start to the theta point.
    pub h_theta: T,
    pub theta: T,
    /// From the theta point to a Gauss point.
    pub node: T,
    /// Compression that can be gained within the step, m.
    pub reach: T,
}

impl<T: Real> Timing<T> {
    pub(crate) fn new(h: T, theta: T) -> Self {
        let node = (T::ONE - theta) * h * T::from_f64(GAUSS_POINT);
        Timing { step: h, h_theta: h * theta, theta, node, reach: node * T::from_f64(CLOSING_SPEED) }
    }
}

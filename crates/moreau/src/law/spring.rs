//! The spring k g^r under every contact law, and the force that a law makes of it within a step.

use crate::real::{Real, Scalar};

/// m; every felt pushes at a compression above this and at no other.
pub(crate) const ONSET: f64 = 0.0;
/// Longer than any distance, faster than any speed, larger than any force.
pub(crate) const FAR: f64 = 1e30;
/// What a divisor may not fall below.
pub(crate) const TINY: f64 = 1e-30;

/// The felt law's exponent. The usual ones are computed without `pow`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Exponent<T> {
    /// r = 2.
    Two,
    /// r = 2.5.
    TwoAndHalf,
    /// r = 3.
    Three,
    /// Any r >= 1.
    Other(T),
}

impl<T: Scalar> Exponent<T> {
    /// The variant for a given r.
    pub fn new(r: T) -> Self {
        match r.to_f64() {
            2.0 => Exponent::Two,
            2.5 => Exponent::TwoAndHalf,
            3.0 => Exponent::Three,
            _ => Exponent::Other(r),
        }
    }
}

impl<T> Exponent<T> {
    /// This spring with another type of number. The usual exponents are not numbers that could be varied.
    pub fn map<U>(self, f: impl FnOnce(T) -> U) -> Exponent<U> {
        match self {
            Exponent::Two => Exponent::Two,
            Exponent::TwoAndHalf => Exponent::TwoAndHalf,
            Exponent::Three => Exponent::Three,
            Exponent::Other(r) => Exponent::Other(f(r)),
        }
    }
}

impl<T: Real> Exponent<T> {
    /// r.
    pub(crate) fn value(&self) -> T {
        match self {
            Exponent::Two => T::from_f64(2.0),
            Exponent::TwoAndHalf => T::from_f64(2.5),
            Exponent::Three => T::from_f64(3.0),
            Exponent::Other(r) => *r,
        }
    }
}

/// k g^r.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Spring<T> {
    /// k, N/m^r.
    pub stiffness: T,
    /// r.
    pub exponent: Exponent<T>,
}

impl<T: Real> Spring<T> {
    /// k g^r and its first and second derivative in g; `compression` must not be negative.
    #[inline(always)]
    pub(crate) fn at(&self, compression: T) -> Elastic<T> {
        Elastic::of(self.stiffness, &self.exponent, compression)
    }

    /// The second derivative of k g^r in g, from k g^(r-1).
    #[inline(always)]
    pub(crate) fn bent(&self, kg: T, compression: T) -> T {
        bent(self.exponent.value(), kg, compression)
    }

    /// Energy stored at a compression g: k g^(r+1) / (r+1), J.
    pub(crate) fn stored(&self, compression: T) -> T {
        let r = self.exponent.value();
        let g = compression.max(T::ZERO);
        self.stiffness * g.powf(r + T::ONE) / (r + T::ONE)
    }
}

/// The second derivative of k g^r, from k g^(r-1): r < 2 bends without bound at first touch; a compression of a
/// nanometre is no touch.
#[inline(always)]
fn bent<T: Real>(r: T, kg: T, compression: T) -> T {
    r * (r - T::ONE) * kg / compression.max(T::from_f64(1e-9))
}

/// k g^r with its first and second derivative in g.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Elastic<T> {
    pub force: T,
    pub slope: T,
    pub curvature: T,
}

impl<T: Real> Elastic<T> {
    /// At a compression, which must not be negative.
    #[inline(always)]
    pub(crate) fn of(stiffness: T, exponent: &Exponent<T>, compression: T) -> Self {
        let c = T::from_f64;
        match *exponent {
            Exponent::Two => {
                let kg = stiffness * compression;
                Elastic { force: kg * compression, slope: c(2.0) * kg, curvature: c(2.0) * stiffness }
            }
            Exponent::TwoAndHalf => {
                let k_root = stiffness * compression.sqrt();
                let kg = k_root * compression;
                Elastic { force: kg * compression, slope: c(2.5) * kg, curvature: c(3.75) * k_root }
            }
            Exponent::Three => {
                let k_compression = stiffness * compression;
                let kg = k_compression * compression;
                Elastic { force: kg * compression, slope: c(3.0) * kg, curvature: c(6.0) * k_compression }
            }
            Exponent::Other(r) => {
                let kg = stiffness * compression.powf(r - T::ONE);
                Elastic { force: kg * compression, slope: r * kg, curvature: bent(r, kg, compression) }
            }
        }
    }

    /// The larger of each.
    #[inline(always)]
    pub(crate) fn max(&self, other: &Self) -> Self {
        Elastic {
            force: self.force.max(other.force),
            slope: self.slope.max(other.slope),
            curvature: self.curvature.max(other.curvature),
        }
    }
}

/// What a felt does during a step.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Pressed<T> {
    /// Mean force over the step, N.
    pub force: T,
    /// The part of it due to the loss, N.
    pub damping_force: T,
    /// theta h dF/d(rate), never negative: h dF/dv1 along the row, for the rate's own change is theta times that of v1.
    pub tangent: T,
    /// The rate, m/s, by which it would have to open faster before it pushes no more.
    pub opening: T,
}

/// How a felt's mean force bends away from its tangent.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Curvature<T> {
    /// Largest change of the force with the rate, to first and (what is not in the tangent) to second order.
    pub linear: T,
    pub quadratic: T,
    /// Smallest force of a touched Gauss point, N: how far the clamp at zero is.
    pub slack: T,
}

impl<T: Real> Pressed<T> {
    /// No force.
    pub(crate) fn nothing() -> Self {
        let z = T::ZERO;
        Pressed { force: z, damping_force: z, tangent: z, opening: z }
    }

    /// The other in some lanes.
    #[inline(always)]
    pub(crate) fn or(self, lanes: T::Mask, other: Self) -> Self {
        let choose = |a: T, b: T| T::select(lanes, b, a);
        Pressed {
            force: choose(self.force, other.force),
            damping_force: choose(self.damping_force, other.damping_force),
            tangent: choose(self.tangent, other.tangent),
            opening: choose(self.opening, other.opening),
        }
    }
}

impl<T: Real> Curvature<T> {
    /// That of no force.
    pub(crate) fn nothing() -> Self {
        Curvature { linear: T::ZERO, quadratic: T::ZERO, slack: T::ZERO }
    }

    /// The other in some lanes.
    #[inline(always)]
    pub(crate) fn or(self, lanes: T::Mask, other: Self) -> Self {
        let choose = |a: T, b: T| T::select(lanes, b, a);
        Curvature {
            linear: choose(self.linear, other.linear),
            quadratic: choose(self.quadratic, other.quadratic),
            slack: choose(self.slack, other.slack),
        }
    }
}

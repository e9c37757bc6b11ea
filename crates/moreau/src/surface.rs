//! Contact surfaces of external subsystems (e.g. a string), coupled implicitly to the step: the curve of a zone moves
//! under the felt's force.
//!
//! The caller simulates the subsystem. Before each step it gives the step three numbers ([`Surface`]): the present
//! displacement, the displacement at the step's end without contact force, and the compliance. The felt's force is then
//! one scalar unknown within the same implicit step ([`solve`]; README, "Compliant surfaces").

use crate::real::{Mask, Real};

/// Most iterations of the scalar equation. Newton's method takes four or five, and is given up after ten, for across a
/// kink it may go to and fro; bisection then halves the bracket.
const MAX_ROUNDS: u32 = 64;
const NEWTON: u32 = 10;

/// Largest number of zones whose surfaces may be coupled within a step.
pub const COUPLED: usize = 4;

/// Predicted motion of a compliant surface in the next step, along the zone's normal. Positive is away from the disc,
/// the direction in which the felt pushes it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Surface<T> {
    /// Displacement at the step's start, m.
    pub displacement: T,
    /// Displacement at the step's end without contact force, m.
    pub free: T,
    /// Compliance A, m/N: extra displacement at the step's end per newton that presses throughout the step; never
    /// negative.
    pub compliance: T,
}

/// Surface in the form that the step reads. All zero: it does not move.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Yielding<T> {
    /// Displacement without contact force at the theta point, m.
    pub offset: T,
    /// Mean velocity without contact force, m/s.
    pub drift: T,
    /// Mobility A/h, compliance over step: velocity that a newton adds, m/s per N.
    pub mobility: T,
    /// Whether other zones press the same subsystem. If so, the error of the force's linearisation is unknown.
    pub shared: bool,
}

/// Zones whose surfaces belong to one subsystem: a force on one displaces the others within the same step.
#[derive(Debug, Clone)]
pub(crate) struct Coupled<T> {
    /// Number of coupled surfaces; 0 or at least two.
    pub count: usize,
    pub zone: [usize; COUPLED],
    /// Mobility A/h between surfaces, m/s per N, symmetric, with a zero diagonal (each surface's own A/h is in
    /// [`Yielding`]).
    pub mobility: [[T; COUPLED]; COUPLED],
    /// Contribution of the other surfaces' forces to the drift of each, m/s.
    pub from_others: [T; COUPLED],
}

impl<T: Real> Coupled<T> {
    pub(crate) fn nothing() -> Self {
        let zero = T::ZERO;
        Coupled { count: 0, zone: [0; COUPLED], mobility: [[zero; COUPLED]; COUPLED], from_others: [zero; COUPLED] }
    }

    /// Returns the velocity that forces on the other surfaces add to one surface, m/s.
    pub(crate) fn others(&self, one: usize, forces: &[T; COUPLED]) -> T {
        let mut sum = T::ZERO;
        for other in 0..self.count {
            sum = sum.add_product(self.mobility[one][other], forces[other]);
        }
        sum
    }
}

impl<T: Real> Yielding<T> {
    pub(crate) fn still() -> Self {
        Yielding { offset: T::ZERO, drift: T::ZERO, mobility: T::ZERO, shared: false }
    }

    pub(crate) fn of(surface: &Surface<T>, h: T, h_theta: T) -> Self {
        let drift = (surface.free - surface.displacement) / h;
        Yielding {
            offset: surface.displacement + h_theta * drift,
            drift,
            mobility: surface.compliance / h,
            shared: false,
        }
    }
}

/// Solves F = P(F) for the felt's force F, where P, which decreases, is the felt's force if F displaces the surface.
/// `press` returns P and -dP/dF, both at least 0.
///
/// F - P(F) increases, so that there is one solution, between 0 and P(0). P is convex (a felt's law is), so that
/// Newton's method approaches the solution from 0 monotonically. If P has a kink, bisection takes over.
#[inline(always)]
pub(crate) fn solve<T: Real>(touched: T::Mask, press: impl Fn(T) -> [T; 2]) -> T {
    let (zero, half) = (T::ZERO, T::from_f64(0.5));
    let (mut low, mut high, mut force) = (zero, T::from_f64(1e30), zero);
    let mut open = touched;
    for n in 0..MAX_ROUNDS {
        let [found, slope] = press(force);
        let excess = found - force;
        low = T::select(zero.lt(excess), force, low);
        high = T::select(zero.lt(excess), high.min(found), force.min(high));
        let newton = force + excess / (T::ONE + slope);
        let inside = T::Mask::splat(n < NEWTON).and(low.le(newton)).and(newton.le(high));
        let next = T::select(inside, newton, half * (low + high));
        let close = (next - force).abs().le(T::from_f64(4.0) * T::EPSILON * next.abs());
        force = T::select(open, next, force);
        open = open.and(close.not());
        if !open.any() {
            break;
        }
    }
    T::only(touched, force)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against the closed form for a linear felt, F = k (g - a F): F = k g / (1 + k a); and a square one, from its
    /// quadratic equation.
    #[test]
    fn the_scalar_equation_is_solved() {
        for k in [1e-3_f64, 1.0, 1e6] {
            let linear = solve(true, |f: f64| [(k * (2.0 - 0.5 * f)).max(0.0), 0.5 * k]);
            assert!((linear - 2.0 * k / (1.0 + 0.5 * k)).abs() < 1e-14 * linear);
            let square = solve(true, |f: f64| {
                let g = (2.0 - 0.5 * f).max(0.0);
                [k * g * g, k * g]
            });
            // k (2 - F/2)^2 = F: with y = 2 - F/2, k y^2 + 2 y - 4 = 0.
            let y = 4.0 / (1.0 + (1.0 + 4.0 * k).sqrt());
            assert!((square - k * y * y).abs() < 1e-12 * square, "{k} {square} {}", k * y * y);
        }
        // Out of touch as soon as it is pressed: the kink is the solution's neighbour.
        let step = solve(true, |f: f64| if f < 1.0 { [3.0, 0.0] } else { [0.0, 0.0] });
        assert!((step - 1.0).abs() < 1e-14, "{step}");
        assert_eq!(solve(false, |_: f64| [1.0, 0.0]), 0.0);
    }
}

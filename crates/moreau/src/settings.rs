//! Settings of a step. Every setting states its unit, its usual value, and the effect of changing it.

use crate::osnsp::Solver;
use crate::real::{Real, Scalar};

/// Model of dry friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrictionLaw<T> {
    /// Set-valued Coulomb friction: |p| <= bound, with true stick. Use this one.
    SetValued,
    /// Regularised friction `tanh(u / width)`, for comparison only. It never sticks, so that held parts creep.
    Regularised {
        /// Width for pivots, rad/s. A smaller width is closer to the set-valued law, and stiffer.
        pivot_width: T,
        /// Width for sliding contacts, m/s.
        sliding_width: T,
    },
}

impl<T> FrictionLaw<T> {
    /// Whether it is the law for comparison.
    pub(crate) fn is_regularised(&self) -> bool {
        matches!(self, FrictionLaw::Regularised { .. })
    }
}

/// Settings of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings<T> {
    /// Step h, s. 50e-6 is usual for the piano. On smooth motion at theta = 1/2 the error falls with the square of the
    /// step.
    pub step: T,
    /// Parameter theta of the theta-method, in [1/2, 1]. 1/2 is of second order and adds no numerical damping; 1 is of
    /// first order and adds damping.
    pub theta: T,
    /// Convergence tolerance of Newton's method. A step has converged when its last Newton correction, or the error of
    /// the linearisation, is at most this times (1 rad/s + |velocity|) for every joint. Newton's method converges
    /// quadratically, so the remaining error is about the square of the correction. 1e-5 is usual; a larger tolerance
    /// loses second order.
    pub tolerance: T,
    /// Largest number of Newton iterations. Usual steps take one. After eight iterations the corrections are halved.
    pub newton_limit: u32,
    /// Tolerance of the one-step solver: it stops when no law's velocity changes by more than this (rad/s or m/s).
    pub solver_tolerance: T,
    /// Largest number of sweeps (or active sets) in one one-step problem.
    pub solver_limit: u32,
    /// Solver of the one-step problem.
    pub solver: Solver,
    /// Model of dry friction.
    pub friction: FrictionLaw<T>,
}

impl<T: Real> Settings<T> {
    /// Returns the usual settings at step `h` (s): theta = 1/2, set-valued friction, the active-set solver.
    pub fn new(h: T) -> Self {
        Settings {
            step: h,
            theta: T::from_f64(0.5),
            tolerance: T::from_f64(1e-5).max(T::from_f64(64.0) * T::EPSILON),
            newton_limit: 25,
            solver_tolerance: T::from_f64(1e-11).max(T::from_f64(8.0) * T::EPSILON),
            solver_limit: 2000,
            solver: Solver::ActiveSet,
            friction: FrictionLaw::SetValued,
        }
    }
}

impl<T: Scalar> Settings<T> {
    /// The value at the theta point of what runs linearly over a step.
    #[inline(always)]
    pub(crate) fn at_theta(&self, u: [f64; 2]) -> f64 {
        let theta = self.theta.to_f64();
        (1.0 - theta) * u[0] + theta * u[1]
    }
}

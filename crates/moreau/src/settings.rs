//! Settings of a step. Every tunable says its unit, its usual value and what breaks when it changes.

use crate::osnsp::Solver;
use crate::real::{Real, Scalar};

/// Model of dry friction.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum FrictionLaw<T> {
    /// The set-valued law, |p| <= bound with true stick: the model.
    SetValued,
    /// `tanh(u / width)`: kept for comparison only. It never sticks, so whatever it should hold creeps.
    Regularised {
        /// Width for pivots, rad/s. Smaller is nearer to the true law and stiffer.
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
    /// Step h, s. 50e-6 is usual for the piano; the error falls with its square on smooth motion at theta = 1/2.
    pub step: T,
    /// theta of the theta-method, in [1/2, 1]. 1/2 is of second order and loses no energy of its own; 1 is of first
    /// order and damps.
    pub theta: T,
    /// A step has converged when its last Newton correction, or what the linearisation left out, is at most this times
    /// (1 rad/s + |velocity|), for every joint. Newton converges quadratically, so what remains is about the square of
    /// it. 1e-5 is usual; looser loses the order.
    pub tolerance: T,
    /// Largest number of Newton iterations. Usual steps take one; beyond eight the corrections are halved.
    pub newton_limit: u32,
    /// The one-step solver stops when no velocity of a law changes by more than this (rad/s or m/s).
    pub solver_tolerance: T,
    /// Largest number of sweeps (or active sets) in one one-step problem.
    pub solver_limit: u32,
    /// Solver of the one-step problem.
    pub solver: Solver,
    /// Friction law.
    pub friction: FrictionLaw<T>,
}

impl<T: Real> Settings<T> {
    /// The usual settings at step `h`: theta = 1/2, set-valued friction, the active-set solver.
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

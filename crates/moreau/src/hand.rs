//! A hand that presses: a mass moved by muscle. The site's spring and damper are its fingertip.
//!
//! ```text
//! m dv/dt = K (x_t - x) + C (v_t - v) + F_m - F        muscle: toward a target, or with a force
//! F = max(0, k (x - y) + d (v - u))                    F: the fingertip's force; y, u: place and speed of the driven point
//! ```
//!
//! x is the world coordinate along the site's direction. Over a step of the theta method the first line is linear, so
//! that the hand's displacement can be eliminated exactly: with D = v1 - v0, M = m/h + theta C + theta^2 h K and the
//! load G without the fingertip,
//!
//! ```text
//! D = (G - F) / M,  x_theta = x_f - (theta^2 h / M) F,  v_theta = v_f - (theta / M) F
//! F = max(0, s k (x_f - y) + s d (v_f - u)),            s = 1 / (1 + theta (theta h k + d) / M)
//! ```
//!
//! So the driven point feels a fingertip that is softer by the factor s and follows the free motion of the hand (x_f,
//! v_f). The step solves hand and mechanism at once; the hand adds no unknown.

use crate::real::Real;
use crate::timing::Timing;

/// A hand and the action of its muscle during one step. Positions, velocities and forces are along the site's
/// direction; those of the muscle hold at t0 + theta h.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SiteHand<T> {
    /// Effective mass at the fingertip, kg; above zero.
    pub mass: T,
    /// Force of the muscle, N.
    pub force: T,
    /// Stiffness with which the muscle holds the hand at `position`, N/m; zero if it does not.
    pub stiffness: T,
    /// Damping of the muscle toward `velocity`, N s/m.
    pub damping: T,
    /// Target position of the muscle, m, world coordinate.
    pub position: T,
    /// Target velocity of the muscle, m/s.
    pub velocity: T,
}

/// A hand's equation of motion in one step.
pub(crate) struct Flight<T> {
    /// G, N.
    load: T,
    /// M, N s/m.
    inertia: T,
    /// x_f, m, and v_f, m/s.
    pub free: [T; 2],
}

impl<T: Real> SiteHand<T> {
    /// From a place and a velocity.
    #[inline(always)]
    pub(crate) fn flight(&self, [x, v]: [T; 2], timing: &Timing<T>) -> Flight<T> {
        let Timing { step: h, theta, h_theta, .. } = *timing;
        let SiteHand { mass, force, stiffness, damping, position, velocity } = *self;
        let load = force + stiffness * (position - x - h_theta * v) + damping * (velocity - v);
        let inertia = mass / h + theta * (damping + h_theta * stiffness);
        let free_velocity = v + theta * load / inertia;
        Flight { load, inertia, free: [x + h_theta * free_velocity, free_velocity] }
    }

    /// The hand in numbers of another type.
    pub(crate) fn map<U>(&self, to: impl Fn(T) -> U) -> SiteHand<U> {
        SiteHand::of_numbers(self.numbers().map(to))
    }

    /// Numbers in a fixed order.
    pub(crate) fn numbers(&self) -> [T; 6] {
        [self.mass, self.force, self.stiffness, self.damping, self.position, self.velocity]
    }
}

impl<T> SiteHand<T> {
    /// From [`SiteHand::numbers`].
    pub(crate) fn of_numbers([mass, force, stiffness, damping, position, velocity]: [T; 6]) -> Self {
        SiteHand { mass, force, stiffness, damping, position, velocity }
    }
}

impl<T: Real> Flight<T> {
    /// s: the part of the fingertip's stiffness and damping that the driven point feels.
    #[inline(always)]
    pub(crate) fn share(&self, stiffness: T, damping: T, timing: &Timing<T>) -> T {
        T::ONE / (T::ONE + timing.theta * (timing.h_theta * stiffness + damping) / self.inertia)
    }

    /// Place and velocity at the step's end, from those at its start, under the fingertip's force, N.
    #[inline(always)]
    pub(crate) fn end(&self, [x, v]: [T; 2], force: T, timing: &Timing<T>) -> [T; 2] {
        let change = (self.load - force) / self.inertia;
        [x + timing.step * (v + timing.theta * change), v + change]
    }
}

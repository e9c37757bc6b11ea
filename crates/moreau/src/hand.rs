//! A hand that presses: a mass moved by muscle. The site's spring and damper are the flesh of its fingertip.
//!
//! ```text
//! m dv/dt = K (x_t - x) + C (v_t - v) + F_m - F        muscle: toward a target, or with a force
//! F = max(0, k (x - y) + d (v - u))                    F: the finger's force; y, u: place and speed of the driven point
//! ```
//!
//! The finger is the flesh (k_f, d_f: the site's) in series with the joints: compliance s = 1/k_j, retardation time
//! tau = d_j/k_j. Nothing has mass between them. Under a force F(t) that changes slowly beside both retardation times,
//! joints and flesh shorten by F/k_j - d_j F'/k_j^2 and F/k_f - d_f F'/k_f^2: compliances add, and so do the losses
//! d/k^2. The finger is the one spring and damper that stores and loses the same:
//!
//! ```text
//! 1/k = 1/k_f + s,   d/k^2 = d_f/k_f^2 + s tau          k = k_f/(1 + k_f s),  d = (d_f + k_f^2 s tau)/(1 + k_f s)^2
//! ```
//!
//! It is exact if both retardation times are equal, and of first order in the rate of the force otherwise. Stiff joints
//! (s = 0) leave the flesh alone, to the bit.
//!
//! x is the world coordinate along the site's direction. Over a step of the theta method the first line is linear, so
//! that the hand's displacement can be eliminated exactly: with D = v1 - v0, M = m/h + theta C + theta^2 h K and the
//! load G without the finger,
//!
//! ```text
//! D = (G - F) / M,  x_theta = x_f - (theta^2 h / M) F,  v_theta = v_f - (theta / M) F
//! F = max(0, s k (x_f - y) + s d (v_f - u)),            s = 1 / (1 + theta (theta h k + d) / M)
//! ```
//!
//! So the driven point feels a finger that is softer by the factor s and follows the free motion of the hand (x_f,
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
    /// Compliance of the finger's joints, in series with the site's spring, m/N; zero if they are stiff.
    pub compliance: T,
    /// Retardation time of the joints, s: their damping over their stiffness.
    pub retardation: T,
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
        let SiteHand { mass, force, stiffness, damping, position, velocity, .. } = *self;
        let load = force + stiffness * (position - x - h_theta * v) + damping * (velocity - v);
        let inertia = mass / h + theta * (damping + h_theta * stiffness);
        let free_velocity = v + theta * load / inertia;
        Flight { load, inertia, free: [x + h_theta * free_velocity, free_velocity] }
    }

    /// Stiffness, N/m, and damping, N s/m, of flesh and joints in series, from those of the flesh.
    #[inline(always)]
    pub(crate) fn finger(&self, stiffness: T, damping: T) -> [T; 2] {
        let softer = T::ONE + stiffness * self.compliance;
        let lost = stiffness * stiffness * self.compliance * self.retardation;
        [stiffness / softer, (damping + lost) / (softer * softer)]
    }

    /// The hand in numbers of another type.
    pub(crate) fn map<U>(&self, to: impl Fn(T) -> U) -> SiteHand<U> {
        SiteHand::of_numbers(self.numbers().map(to))
    }

    /// Numbers in a fixed order.
    pub(crate) fn numbers(&self) -> [T; 8] {
        let SiteHand { mass, force, stiffness, damping, position, velocity, compliance, retardation } = *self;
        [mass, force, stiffness, damping, position, velocity, compliance, retardation]
    }
}

impl<T> SiteHand<T> {
    /// From [`SiteHand::numbers`].
    pub(crate) fn of_numbers(numbers: [T; 8]) -> Self {
        let [mass, force, stiffness, damping, position, velocity, compliance, retardation] = numbers;
        SiteHand { mass, force, stiffness, damping, position, velocity, compliance, retardation }
    }
}

impl<T: Real> Flight<T> {
    /// s: the part of the finger's stiffness and damping that the driven point feels.
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

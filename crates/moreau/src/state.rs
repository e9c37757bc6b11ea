//! Where a mechanism is now, and what drives it in a step.

use crate::broad_phase::BroadPhase;
use crate::model::Model;
use crate::real::Real;

/// Where a mechanism is: everything that the next step depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct State<T: Real, const B: usize, const Z: usize> {
    /// Absolute angles q, rad.
    pub angle: [T; B],
    /// Absolute angular velocities v, rad/s.
    pub velocity: [T; B],
    /// Velocity increment: the change of the velocities over the last step, rad/s. The next step's iteration starts from it.
    pub increment: [T; B],
    // The contact cache: what the set-valued laws did in the last step. It warm-starts the solver.
    /// Dry friction torque of each pivot over the last step, N m (counter-clockwise on the body).
    pub pivot_friction: [T; B],
    /// Coulomb force of each zone over the last step, N, on the disc along the tangent.
    pub tangential: [T; Z],
    /// Force of a rigid drive over the last step, N.
    pub rigid_force: T,
    /// What the felts remember ([`Loss`](crate::Loss)): the stretch of an elastoplastic one's spring, m^((r+1)/2); k z/(1 - eps) of a hereditary
    /// one, N; the dry part of a set-valued one's force over the last step, N. Zero for the others.
    pub memory: [T; Z],
    /// How far each pivot's dry friction and each zone's Coulomb friction has grown while it stuck, from 0 (kinetic) to 1 (static); zero where it
    /// does not grow ([`Dwell`](crate::Dwell)).
    pub pivot_rested: [T; B],
    /// See `pivot_rested`.
    pub rested: [T; Z],
    /// The sign with which each zone's Coulomb force was at its bound over the last step, or 0: the solver's first guess.
    pub(crate) side: [T; Z],
    /// The zones that may be touched.
    pub(crate) broad_phase: BroadPhase<T, B, Z>,
}

impl<T: Real, const B: usize, const Z: usize> State<T, B, Z> {
    /// At rest at the given absolute angles.
    pub fn at_rest(angle: [T; B]) -> Self {
        let z = T::ZERO;
        State {
            angle,
            velocity: [z; B],
            increment: [z; B],
            pivot_friction: [z; B],
            tangential: [z; Z],
            rigid_force: z,
            memory: [z; Z],
            pivot_rested: [z; B],
            rested: [z; Z],
            side: [z; Z],
            broad_phase: BroadPhase::none(),
        }
    }

    /// Drops from the contact cache the zones that a new broad phase leaves out.
    #[cold]
    #[inline(never)]
    pub(crate) fn forget_far(&mut self, model: &Model<T, B, Z>) {
        for &z in &model.sliding_zones[..model.sliding_count] {
            if !self.broad_phase.sliding().contains(&z) {
                (self.tangential[z], self.side[z]) = (T::ZERO, T::ZERO);
            }
        }
    }
}

/// What drives the mechanism at the model's [`Site`](crate::Site) during one step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Input<T> {
    /// Nothing.
    Free,
    /// A force, N, along the site's direction, at time t0 + theta h.
    Force(T),
    /// The driver's position (m, world coordinate along the site's direction) and velocity at t0 + theta h; the force comes
    /// from the site's spring and damper, which only push.
    Motion {
        /// m.
        position: T,
        /// m/s.
        velocity: T,
    },
    /// Velocity of the site along its direction at the step's end, m/s, imposed.
    Rigid {
        /// m/s.
        velocity: T,
    },
}

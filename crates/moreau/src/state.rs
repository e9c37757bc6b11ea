//! Where a mechanism is now, what drives it in a step, and the step's working memory.

use crate::contact::{Contact, Timing, Touch};
use crate::ease::Ease;
use crate::laws::Law;
use crate::osnsp::active_set::{Condensed, Guess};
use crate::osnsp::{Impulses, System};
use crate::pose::Pose;
use crate::survey::Survey;
use crate::vector::dot;
use crate::{Mask, Model, Real, Scalar, Settings};

/// Where a mechanism is: everything that the next step depends on.
#[derive(Debug, Clone, PartialEq)]
pub struct State<T: Real, const B: usize, const Z: usize> {
    /// Absolute angles q, rad.
    pub angle: [T; B],
    /// Absolute angular velocities v, rad/s.
    pub velocity: [T; B],
    /// Change of the velocities over the last step, rad/s: where the next step's iteration starts.
    pub trend: [T; B],
    /// Dry friction torque of each pivot over the last step, N m (counter-clockwise on the body); warm-starts the solver.
    pub pivot_friction: [T; B],
    /// Coulomb force of each zone over the last step, N, on the disc along the tangent.
    pub tangential: [T; Z],
    /// Force of a rigid drive over the last step, N.
    pub rigid_force: T,
    /// The sign with which each zone's Coulomb force was at its bound over the last step, or 0: the solver's first guess.
    pub(crate) side: [T; Z],
    /// The zones that may be touched.
    pub(crate) survey: Survey<T, B, Z>,
}

impl<T: Real, const B: usize, const Z: usize> State<T, B, Z> {
    /// At rest at the given absolute angles.
    pub fn at_rest(angle: [T; B]) -> Self {
        let z = T::ZERO;
        State {
            angle,
            velocity: [z; B],
            trend: [z; B],
            pivot_friction: [z; B],
            tangential: [z; Z],
            rigid_force: z,
            side: [z; Z],
            survey: Survey::none(),
        }
    }

    /// Zones that a new survey leaves out slide no more.
    #[cold]
    #[inline(never)]
    pub(crate) fn forget_far(&mut self, model: &Model<T, B, Z>) {
        for &z in &model.sliding_zones[..model.sliding_count] {
            if !self.survey.sliding().contains(&z) {
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

/// Working memory of a step. After a step it holds what acted during it, at the time t0 + theta h.
#[derive(Debug, Clone)]
pub struct Scratch<T: Real, const B: usize, const Z: usize, const N: usize> {
    /// The pose at which the last Newton iteration evaluated the forces.
    pub pose: Pose<T, B>,
    /// The zones there, as far as they are touched during the step.
    pub(crate) contacts: [Touch<T, B>; Z],
    /// The lanes in which they are, for the zones that were looked at; of others it says nothing (see `touched_in`).
    pub(crate) active: [T::Mask; Z],
    /// The zones that are touched in any lane, as they come.
    pub(crate) touched: [usize; Z],
    pub(crate) touched_count: usize,
    /// What the zones say about how far the linearisation holds.
    pub(crate) ease: Ease<T>,
    /// The last Newton correction of the relative velocities.
    pub(crate) change: [T; B],
    /// Absolute angular velocities at t0 + theta h, before the last Newton correction.
    pub(crate) velocity: [T; B],
    /// Relative ones.
    pub(crate) joint_velocity: [T; B],
    /// Force of the drive on the mechanism, N.
    pub drive_force: T,
    /// Force of an elastic drive before its clamp at zero, N, and h dF/d(site velocity).
    pub(crate) drive_pull: T,
    pub(crate) drive_tangent: T,
    pub(crate) slip_row: [[T; B]; Z],
    /// Of the zones that are looked at.
    pub(crate) has_slip_row: [T::Mask; Z],
    /// How fast each slip row turns, for steps that allow for it: the velocity of slip at the start along the last step's row, and the
    /// time from where that row was taken to the start, s. Zero: not known.
    pub(crate) slip_before: [T; Z],
    pub(crate) slip_span: T,
    /// What the slip row's turning until the step's end adds to each slip velocity, m/s, where the span is known.
    pub(crate) turn: [T; Z],
    /// Couplings of M(q_*) in absolute velocities, to the parent and to ancestors beyond it, and M w0.
    pub(crate) coupling: [T; B],
    pub(crate) deep_coupling: [[T; B]; B],
    pub(crate) momentum: [T; B],
    pub(crate) site_row: [T; B],
    pub(crate) system: System<T, B, N>,
    pub(crate) impulses: Impulses<T, B, N>,
    pub(crate) guess: Guess<T, B, N>,
    pub(crate) condensed: Condensed<T, B, N>,
    /// What the sliding laws stand for.
    pub(crate) laws: [Law; N],
    /// Torques of the pivots where their friction is regularised.
    pub(crate) pivot_friction: [T; B],
    /// Forces and sides of the sliding laws, kept from iteration to iteration.
    pub(crate) tangential: [T; Z],
    pub(crate) side: [T; Z],
    pub(crate) rigid_force: T,
}

impl<T: Real, const B: usize, const Z: usize, const N: usize> Scratch<T, B, Z, N> {
    /// Fresh working memory; results do not depend on what it held before.
    pub fn new() -> Self {
        let z = T::ZERO;
        Scratch {
            pose: Pose::new(),
            contacts: [Touch::apart(); Z],
            active: [T::Mask::splat(false); Z],
            touched: [0; Z],
            touched_count: 0,
            ease: Ease::new(),
            change: [z; B],
            velocity: [z; B],
            joint_velocity: [z; B],
            momentum: [z; B],
            drive_force: z,
            drive_pull: z,
            drive_tangent: z,
            slip_row: [[z; B]; Z],
            has_slip_row: [T::Mask::splat(false); Z],
            slip_before: [z; Z],
            slip_span: z,
            turn: [z; Z],
            coupling: [z; B],
            deep_coupling: [[z; B]; B],
            site_row: [z; B],
            system: System::new(),
            impulses: Impulses::new(),
            guess: Guess::new(),
            condensed: Condensed::new(),
            laws: [Law::Rigid; N],
            pivot_friction: [z; B],
            tangential: [z; Z],
            side: [z; Z],
            rigid_force: z,
        }
    }

    /// The lanes in which a zone was touched during the last step.
    pub(crate) fn touched_in(&self, zone: usize) -> T::Mask {
        let anywhere = self.touched[..self.touched_count].contains(&zone);
        if anywhere { self.active[zone] } else { T::Mask::splat(false) }
    }

    /// Slip velocities of a zone with friction before and after the last step, along its row, given the relative velocities, m/s; zero if
    /// it was not touched.
    pub(crate) fn slip(&self, model: &Model<T, B, Z>, zone: usize, joints: &[[T; B]; 2]) -> [T; 2] {
        if !(self.touched_in(zone).any() && model.forms[zone].slides) {
            return [T::ZERO; 2];
        }
        let [u0, u1] = joints.each_ref().map(|w| model.paths[zone].product(&self.slip_row[zone], w));
        let turn = T::only(T::ZERO.lt(self.slip_span), self.turn[zone]);
        [u0 - turn, u1 + turn]
    }

    /// A zone as it acted during the last step; `None` if it was not touched.
    pub fn contact(&self, model: &Model<T, B, Z>, settings: &Settings<T>, zone: usize) -> Option<Contact<T>> {
        let touched = self.touched_in(zone);
        if !touched.any() {
            return None;
        }
        let (form, path, timing) = (&model.forms[zone], &model.paths[zone], Timing::new(settings.step, settings.theta));
        Some(self.contacts[zone].contact(form, path, &self.pose, &self.change, &timing, touched))
    }
}

impl<T: Real, const B: usize, const Z: usize, const N: usize> Default for Scratch<T, B, Z, N> {
    fn default() -> Self {
        Self::new()
    }
}

impl<T: Scalar, const B: usize, const Z: usize> Model<T, B, Z> {
    /// World coordinate of the driven point along the site's direction, m; zero without a site.
    pub fn site_position(&self, angle: &[T; B]) -> T {
        self.site.as_ref().map_or(T::ZERO, |s| dot(s.direction, Pose::of(self, angle).point(s.body, s.point)))
    }
}

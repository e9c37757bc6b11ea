//! The broad phase: finds the zones that can be touched while the mechanism stays near a pose. A step skips all other
//! zones.
//!
//! A zone's compression changes by at most lever times angle for every supporting joint. So a zone with a clearance c
//! at the pose of the broad phase cannot be reached before the joints have turned by dq with sum lever |dq| >= c. This
//! is a strict bound: with or without a broad phase, a step gives the same bits.

use crate::felt::ONSET;
use crate::model::Model;
use crate::real::{Mask, Real};
use crate::timing::Timing;
use crate::workspace::Kinematics;

/// A zone that could be touched within so many steps at the present speeds is near: every step looks at it. A larger
/// number means fewer broad phases and more zones to look at.
const STEPS: f64 = 32.0;
/// m; a zone with less clearance is near even at rest.
const CLEARANCE: f64 = 5e-5;

/// The zones near contact around one pose: what a broad phase found.
#[derive(Debug, Clone, Copy)]
pub(crate) struct BroadPhase<T, const B: usize, const Z: usize> {
    /// Joint angles of its pose, rad.
    angle: [T; B],
    /// For every joint, the part of the tightest clearance that turning by a radian can use up.
    spent: [T; B],
    /// Smallest clearance that counted as none, m.
    reach: T,
    near: [usize; Z],
    near_count: usize,
    /// Those of them with Coulomb friction.
    sliding: [usize; Z],
    sliding_count: usize,
}

/// It says nothing of where the mechanism is, so it never distinguishes two states.
impl<T, const B: usize, const Z: usize> PartialEq for BroadPhase<T, B, Z> {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

impl<T: Real, const B: usize, const Z: usize> BroadPhase<T, B, Z> {
    /// None yet.
    pub(crate) fn none() -> Self {
        BroadPhase {
            angle: [T::ZERO; B],
            spent: [T::ZERO; B],
            reach: -T::ONE,
            near: [0; Z],
            near_count: 0,
            sliding: [0; Z],
            sliding_count: 0,
        }
    }

    /// The zones that may be touched.
    #[inline(always)]
    pub(crate) fn near(&self) -> &[usize] {
        &self.near[..self.near_count]
    }

    /// Those of them with Coulomb friction.
    #[inline(always)]
    pub(crate) fn sliding(&self) -> &[usize] {
        &self.sliding[..self.sliding_count]
    }

    /// Runs the broad phase again if the zones left out could now be closer than `reach` (m); returns whether it did.
    /// `joint`: the joints' angles.
    #[inline(always)]
    pub(crate) fn renew(
        &mut self,
        model: &Model<T, B, Z>,
        kinematics: &Kinematics<T, B>,
        joint: &[T; B],
        timing: &Timing<T>,
    ) -> bool {
        let mut spent = T::ZERO;
        for i in 0..B {
            spent = spent.add_product((joint[i] - self.angle[i]).abs(), self.spent[i]);
        }
        // The last thousandth is left to rounding.
        let holds = spent.lt(T::from_f64(0.999)).and(timing.reach.le(self.reach));
        let again = !holds.all();
        if again {
            self.take(model, kinematics, joint, timing);
        }
        again
    }

    #[inline(always)]
    fn take(&mut self, model: &Model<T, B, Z>, kinematics: &Kinematics<T, B>, joint: &[T; B], timing: &Timing<T>) {
        *self = BroadPhase { angle: *joint, reach: timing.reach, ..BroadPhase::none() };
        for z in 0..model.zone_count {
            let clearance = T::from_f64(ONSET)
                - model.compiled[z].compression(&kinematics.pose)
                - timing.reach
                - model.excursions[z];
            let mut speed = T::ZERO;
            for (k, j) in model.supports[z].joints() {
                speed = speed.add_product(model.supports[z].lever(k), kinematics.joint_velocity[j].abs());
            }
            let needed = T::from_f64(CLEARANCE) + T::from_f64(STEPS) * timing.step * speed;
            if needed.lt(clearance).all() {
                let inverse = T::ONE / clearance;
                for (k, j) in model.supports[z].joints() {
                    self.spent[j] = self.spent[j].max(model.supports[z].lever(k) * inverse);
                }
            } else {
                self.near[self.near_count] = z;
                self.near_count += 1;
                if model.compiled[z].slides {
                    self.sliding[self.sliding_count] = z;
                    self.sliding_count += 1;
                }
            }
        }
    }
}

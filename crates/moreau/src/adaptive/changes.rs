//! Changes of the set-valued laws within the two halves of an adaptive step, and the error that they cause.
//!
//! Within one inner step a law has one side: that of its velocity at the end. If it changes within the step, whole and
//! halves may have the same error, so that their difference does not show it. This hidden error is computed here from
//! the slopes of the velocities and the forces of the laws.

use super::{Controller, StepDoubling};
use crate::model::Model;
use crate::real::Scalar;
use crate::state::State;

/// The error of a law that lets go is a part of how much the halves' changes of velocity differ. With a load that grows
/// linearly (by j per second) and exceeds the bound after tau, a half of length k with tau < k/2 slides all along and
/// brings j k (k/2 - tau) instead of j (k - tau)^2/2: too little by j tau^2/2, at most j k^2/8, where the halves differ
/// by j k^2. With tau > k/2 it sticks all along, and what it loses, at most j k^2/8 again, is an eighth of the j k^2 of
/// the half after it.
const LETTING_GO: f64 = 0.125;
/// A step that aims at an instant ends this part earlier: the velocities' paths are not quite straight, and a step that
/// ends too late has the wrong side.
const EARLY: f64 = 0.05;

/// Changes of the laws' sides: of a pivot's rotation or a contact's slip, which goes one way, the other, or sticks.
pub(super) struct Changes<T, const B: usize> {
    /// Whether there are changes, including contacts with friction that began or ended.
    pub any: bool,
    /// Error of the velocities that whole and halves may share, so that their difference hides it, rad/s.
    pub hidden: [T; B],
    /// Instant of the first change, s after the step's start; `None` if unknown. In a step that ends before it, no law
    /// changes.
    pub instant: Option<T>,
}

/// One law in one half.
struct Law<T> {
    /// 0 or 1.
    half: usize,
    /// Side before and after: the sign of the velocity's way, 0 where it sticks.
    side: [T; 2],
    /// Velocity before and after.
    u: [T; 2],
    /// Change of the velocity in the half before, as much as a half lasts.
    slope: T,
    /// Mean force, and its bound.
    force: T,
    bound: T,
}

impl<T: Scalar, const B: usize> Changes<T, B> {
    /// No change.
    pub(crate) fn none() -> Self {
        Changes { any: false, hidden: [T::ZERO; B], instant: None }
    }

    /// `still`: velocities below it stick.
    pub(crate) fn find<const Z: usize, const N: usize>(
        model: &Model<T, B, Z>,
        still: T,
        controller: &Controller<T, Z>,
        start: &State<T, B, Z>,
        halves: &StepDoubling<T, B, Z, N>,
    ) -> Self {
        let k = halves.settings.step;
        let history = if T::ZERO < controller.last { k / controller.last } else { T::ZERO };
        let states = [start, &halves.middle, &halves.end];
        let w = states.map(|s| model.tree.relative(&s.velocity));
        let increment = model.tree.relative(&start.increment);
        let mut found = Found { reversed: [T::ZERO; 2], let_go: false, changed: false, instant: None };
        let mut hidden = [T::ZERO; B];
        for i in 0..B {
            if model.dry[i] <= T::ZERO {
                continue;
            }
            let mut held_back = T::ZERO;
            for half in 0..2 {
                let u = [w[half][i], w[half + 1][i]];
                let slope = if half == 0 { history * increment[i] } else { w[1][i] - w[0][i] };
                let force = states[half + 1].pivot_friction[i];
                // What sticks may have grown; what slips has the kinetic bound.
                let bound = model.dry[i];
                let law = Law { half, side: u.map(|u| sign(u, still)), u, slope, force, bound };
                held_back = held_back.max(found.look(&law));
            }
            if w[1][i] == T::ZERO && w[2][i] == T::ZERO {
                let force = [halves.middle.pivot_friction[i], halves.end.pivot_friction[i]];
                let gain = model.dwelling.pivot_gain[i];
                let bound = [&halves.middle, &halves.end].map(|s| model.dry[i] * (T::ONE + gain * s.pivot_rested[i]));
                held_back = held_back.max(found.about_to_let_go(force, bound));
            }
            hidden[i] = held_back * k / model.inertia[i];
        }
        let joints = halves.joints(model, start);
        // A dry felt's force jumps where dg/dt turns around.
        for &z in model.dry_zones() {
            let [a, b] = [0, 1].map(|half| {
                let row = &halves.workspace[half].contacts.states[z].row;
                let touched = halves.workspace[half].touched_in(z);
                let side = |w: &[T; B]| sign(model.supports[z].product(row, w), still);
                (touched, joints[half].each_ref().map(side))
            });
            found.changed |= (a.0 && a.1[0] != a.1[1]) || (b.0 && b.1[0] != b.1[1]) || a.0 != b.0;
        }
        for &z in &model.sliding_zones[..model.sliding_count] {
            let Some(mu) = model.zones[z].friction else { continue };
            let side = states.map(|s| s.side[z]);
            let touched = [
                side[0] != T::ZERO || start.tangential[z] != T::ZERO,
                halves.workspace[0].touched_in(z),
                halves.workspace[1].touched_in(z),
            ];
            let force = [halves.middle.tangential[z], halves.end.tangential[z]];
            let bound = [0, 1].map(|half| mu * halves.workspace[half].contacts.states[z].force);
            let mut held_back = T::ZERO;
            for half in 0..2 {
                found.changed |= touched[half] != touched[half + 1];
                if touched[half] && touched[half + 1] {
                    let u = halves.workspace[half].slip(model, z, &joints[half]);
                    let before = halves.workspace[0].slip(model, z, &joints[0]);
                    let slope = if half == 0 { k * controller.slip_rate[z] } else { before[1] - before[0] };
                    // The remembered side is the force's.
                    let side = [-side[half], -side[half + 1]];
                    held_back = held_back.max(found.look(&Law {
                        half,
                        side,
                        u,
                        slope,
                        force: force[half],
                        bound: bound[half],
                    }));
                }
            }
            if touched[1] && touched[2] && side[1] == T::ZERO && side[2] == T::ZERO {
                let gain = model.dwelling.zone_gain[z];
                let grown = [&halves.middle, &halves.end].map(|s| T::ONE + gain * s.rested[z]);
                let bound = [bound[0] * grown[0], bound[1] * grown[1]];
                held_back = held_back.max(found.about_to_let_go(force, bound));
            }
            if T::ZERO < held_back {
                for (n, j) in model.supports[z].joints() {
                    let speed = held_back * k * halves.workspace[1].contacts.slip_row[z][n].abs() / model.inertia[j];
                    hidden[j] = hidden[j].max(speed);
                }
            }
        }
        for i in 0..B {
            let first = halves.middle.velocity[i] - start.velocity[i];
            let second = halves.end.velocity[i] - halves.middle.velocity[i];
            let change = (second - first).abs();
            let before = (first - history * start.increment[i]).abs();
            hidden[i] = hidden[i].max(found.reversed[0] * before).max(found.reversed[1] * change);
            if found.let_go {
                hidden[i] = hidden[i].max(T::from_f64(LETTING_GO) * change);
            }
        }
        Changes { any: found.changed, hidden, instant: found.instant.map(|at| k * at) }
    }
}

fn sign<T: Scalar>(u: T, still: T) -> T {
    if u.abs() <= still {
        T::ZERO
    } else if T::ZERO < u {
        T::ONE
    } else {
        -T::ONE
    }
}

struct Found<T> {
    /// For each half the largest part of it during which a law that reverses was given the wrong side.
    reversed: [T; 2],
    let_go: bool,
    changed: bool,
    /// In halves after the start.
    instant: Option<T>,
}

impl<T: Scalar> Found<T> {
    /// Looks at a law in a half; returns the force that it wrongly held something back with, as a mean over the half.
    fn look(&mut self, law: &Law<T>) -> T {
        let [before, after] = law.side;
        let [u0, u1] = law.u;
        if before == after {
            return T::ZERO;
        }
        self.changed = true;
        if before == T::ZERO {
            self.let_go = true;
            return T::ZERO;
        }
        // Until it comes to rest it goes on as it did before; in this half its slope may be that of the wrong side.
        let goes_on = u0 * law.slope < T::ZERO;
        if after != T::ZERO {
            let part = if goes_on { u0.abs() / law.slope.abs() } else { u0.abs() / (u0.abs() + u1.abs()) }.min(T::ONE);
            self.reversed[law.half] = self.reversed[law.half].max(part);
            self.aim(law.half, part);
            return T::ZERO;
        }
        // What comes to stick does so exactly: the impulse is what brings it to rest. But an impulse may also hold for
        // a while what goes on the other way, as long as its mean is within the bound; over the rest of the half the
        // force was then beyond.
        let part = u0.abs() / law.slope.abs();
        if !goes_on || T::ONE <= part {
            return T::ZERO;
        }
        let rest = T::ONE - part;
        let sliding = -before * law.bound;
        let beyond = (law.force - part * sliding).abs() - rest * law.bound;
        // Where it rests until the end it is a matter of rounding.
        if beyond <= T::from_f64(1e-3) * law.bound {
            return T::ZERO;
        }
        self.aim(law.half, part);
        beyond
    }

    /// A law that sticks in both halves with these forces (their means) and bounds: where they run on in a straight
    /// line, it lets go before the end. Returns the force that it then holds back, as a mean over the second half.
    fn about_to_let_go(&mut self, force: [T; 2], bound: [T; 2]) -> T {
        let half = T::from_f64(0.5);
        let beyond = [0, 1].map(|k| force[k].abs() - bound[k]);
        let slope = beyond[1] - beyond[0];
        let now = beyond[1] + half * slope;
        if now <= T::ZERO || slope <= T::ZERO {
            return T::ZERO;
        }
        let rest = (now / slope).min(T::ONE);
        self.aim(1, T::ONE - rest);
        half * now * rest
    }

    fn aim(&mut self, half: usize, part: T) {
        let at = (T::from_f64(half as f64) + part) * T::from_f64(1.0 - EARLY);
        self.instant = Some(self.instant.map_or(at, |t| t.min(at)));
    }
}

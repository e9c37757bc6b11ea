//! Friction that grows while it sticks.
//!
//! A mechanism without such friction pays nothing for it. A law's bound is its kinetic bound times 1 + (ratio - 1) m.
//! While the law sticks, m grows as dm/dt = (1 - m)/tau; when it slips, m = 0: (C10) of the book. Sticking is exact:
//! nothing creeps. A step is first solved with the grown bounds, and again with the kinetic bounds of those laws that
//! slipped.

use crate::model::Model;
use crate::real::{Mask, Real, Scalar, cast};
use crate::settings::Settings;
use crate::state::State;
use crate::workspace::{LawSource, Workspace};

/// Prepares a step before its first iteration: no law has slipped.
#[cold]
#[inline(never)]
pub(crate) fn begin<T: Real, const B: usize, const Z: usize, const N: usize>(
    state: &State<T, B, Z>,
    workspace: &mut Workspace<T, B, Z, N>,
) {
    workspace.dwell.pivot = state.pivot_rested;
    workspace.dwell.zone = state.rested;
}

/// Raises the bounds of laws that stuck before the step.
#[cold]
#[inline(never)]
pub(crate) fn raise_bounds<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    workspace: &mut Workspace<T, B, Z, N>,
) {
    let Workspace { problem, dwell, .. } = workspace;
    let (system, gains) = (&mut problem.system, &model.dwelling);
    for i in 0..B {
        system.pivot_bound[i] = system.pivot_bound[i] * T::ONE.add_product(gains.pivot_gain[i], dwell.pivot[i]);
    }
    for k in 0..system.count {
        if let LawSource::Zone(z) = problem.sources[k] {
            let factor = T::ONE.add_product(gains.zone_gain[z], dwell.zone[z]);
            let law = &mut system.sliding[k];
            law.bound = law.bound * factor;
            law.slope = law.slope.map(|x| x * factor);
        }
    }
}

/// Resets the growth of the laws that slip at the velocities `next` of the solver. Returns the lanes with such a law,
/// in which the step must be solved again.
#[cold]
#[inline(never)]
pub(crate) fn slipped<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    next: &[T; B],
    workspace: &mut Workspace<T, B, Z, N>,
) -> T::Mask {
    let Workspace { problem, dwell, .. } = workspace;
    let mut again = T::Mask::splat(false);
    let mut look = |rested: &mut T, gain: T, u: T| {
        let slips = slips(u, settings).and(T::ZERO.lt(gain * *rested));
        *rested = T::select(slips, T::ZERO, *rested);
        again = again.or(slips);
    };
    for i in 0..B {
        look(&mut dwell.pivot[i], model.dwelling.pivot_gain[i], next[i]);
    }
    for k in 0..problem.system.count {
        if let LawSource::Zone(z) = problem.sources[k] {
            look(&mut dwell.zone[z], model.dwelling.zone_gain[z], problem.system.slip(k, next));
        }
    }
    again
}

/// Returns whether a law slips. The solvers' velocities of sticking laws are zero to their tolerance.
#[inline(always)]
fn slips<T: Real>(u: T, settings: &Settings<T>) -> T::Mask {
    (T::from_f64(4.0) * settings.solver_tolerance).lt(u.abs())
}

/// Lets the friction of sticking laws grow by one step, at the step's end with the velocities `w`, in the lanes in
/// which it ends.
#[cold]
#[inline(never)]
pub(crate) fn keep<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    lanes: T::Mask,
    w: &[T; B],
    state: &mut State<T, B, Z>,
    workspace: &Workspace<T, B, Z, N>,
) {
    let Workspace { problem, dwell, .. } = workspace;
    let gains = &model.dwelling;
    let longer = |rested: T, rate: T, sticks: T::Mask| {
        let left = T::join(|lane| cast(libm::exp(-(settings.step * rate).lane(lane).to_f64())));
        T::only(sticks, T::ONE - (T::ONE - rested) * left)
    };
    for i in 0..B {
        if T::ZERO.lt(gains.pivot_gain[i]).any() {
            let rested = longer(dwell.pivot[i], gains.pivot_rate[i], slips(w[i], settings).not());
            state.pivot_rested[i] = T::select(lanes, rested, state.pivot_rested[i]);
        }
    }
    // A contact that is open has no rest.
    let mut rested = [T::ZERO; Z];
    for k in 0..problem.system.count {
        if let LawSource::Zone(z) = problem.sources[k] {
            let pressed = T::ZERO.lt(workspace.contacts.states[z].force).and(workspace.contacts.active[z]);
            let sticks = slips(problem.system.slip(k, w), settings).not().and(pressed);
            rested[z] = longer(dwell.zone[z], gains.zone_rate[z], sticks);
        }
    }
    for &z in &model.sliding_zones[..model.sliding_count] {
        if T::ZERO.lt(gains.zone_gain[z]).any() {
            state.rested[z] = T::select(lanes, rested[z], state.rested[z]);
        }
    }
}

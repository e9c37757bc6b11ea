//! The set-valued part of a step: which laws are in force, and what became of them.

use crate::model::Model;
use crate::osnsp::Solver;
use crate::settings::Settings;
use crate::state::{Input, Scratch, State};
use crate::{Mask, Real};

/// What a sliding law of the one-step problem stands for.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Law {
    /// Coulomb friction of a zone.
    Zone(usize),
    /// The rigid drive.
    Rigid,
}

/// Before a step's first iteration: the pivots' forces as the last step left them. A pivot that turned goes on being opposed, unless the
/// predicted velocity `w` turns around: then it is expected to stick, as does one that stuck.
#[inline(always)]
pub(crate) fn begin<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    state: &State<T, B, Z>,
    w0: &[T; B],
    w: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) {
    scratch.rigid_force = state.rigid_force;
    if settings.solver == Solver::ProjectedGaussSeidel {
        for i in 0..B {
            scratch.impulses.pivot[i] = settings.step * state.pivot_friction[i];
        }
    }
    for i in 0..B {
        // Without dry friction a pivot never sticks: its bound is zero, and so is its impulse.
        let goes_on = settings.solver_tolerance.lt(w0[i].abs()).and(T::ZERO.lt(w0[i] * w[i]));
        let moves = goes_on.or(model.dry[i].le(T::ZERO));
        let against = T::select(T::ZERO.lt(w[i]), -T::ONE, T::ONE);
        scratch.guess.pivot[i] = T::only(moves, against);
    }
}

/// Completes the linearised step with the laws in force and a warm start: the last iteration's forces and sides, or before the first
/// one the last step's.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub(crate) fn one_step_problem<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &Input<T>,
    state: &State<T, B, Z>,
    again: bool,
    w0: &[T; B],
    w: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let h = settings.step;
    let Scratch { system, impulses, guess, laws, contacts, active, slip_row, site_row, .. } = scratch;
    let Scratch { tangential, side, rigid_force, slip_before, slip_span, turn, .. } = scratch;
    if settings.friction.is_regularised() {
        system.pivot_bound = [T::ZERO; B];
        impulses.pivot = [T::ZERO; B];
        guess.pivot = [T::ONE; B];
        system.count = 0;
        for &z in state.survey.sliding() {
            if !active[z].any() {
                tangential[z] = T::ZERO;
            }
            side[z] = T::ZERO;
        }
    } else {
        for i in 0..B {
            system.pivot_bound[i] = h * model.dry[i];
        }
        let mut n = 0;
        let allows_for_turning = T::ZERO.lt(*slip_span).any();
        for &z in state.survey.sliding() {
            let (contact, path, mu) = (&contacts[z], &model.paths[z], model.forms[z].friction);
            let (warm, warm_side) = if again { (tangential[z], side[z]) } else { (state.tangential[z], state.side[z]) };
            (tangential[z], side[z]) = (T::ZERO, T::ZERO);
            if allows_for_turning {
                turn[z] = T::ZERO;
            }
            let pressed = active[z].and(T::ZERO.lt(contact.force));
            if !pressed.any() || n >= N {
                continue;
            }
            laws[n] = Law::Zone(z);
            let law = &mut system.sliding[n];
            path.spread(&slip_row[z], T::ONE, &mut law.row);
            law.target = T::ZERO;
            if allows_for_turning {
                // The law speaks of the step's end, until where the row goes on turning as it did since the last step's.
                let pressed_before = T::ZERO.lt(warm.abs()).or(T::ZERO.lt(warm_side.abs()));
                let turned = path.product(&slip_row[z], w0) - slip_before[z];
                let rest = (T::ONE - settings.theta) * h / (*slip_span + settings.theta * h);
                turn[z] = T::only(pressed_before, rest * turned);
                law.target = -turn[z];
            }
            // The felt's force in this very step, mu (F + dF/dw (w1 - w)), times h.
            let gradient = mu * contact.tangent;
            law.bound = (mu * h * contact.force).sub_product(gradient, path.product(&contact.row, w));
            path.spread(&contact.row, gradient, &mut law.slope);
            law.rigid = false;
            guess.open[n] = pressed.not();
            impulses.sliding[n] = h * warm;
            guess.sliding[n] = warm_side;
            let fresh = warm.abs().le(T::ZERO).and(warm_side.abs().le(T::ZERO));
            if fresh.any() {
                // Touched for the first time: it slides as it arrives.
                let u = path.product(&slip_row[z], w0);
                let arrival = T::select(T::ZERO.lt(u), -T::ONE, T::ONE);
                guess.sliding[n] = T::select(fresh, arrival, warm_side);
            }
            if !pressed.all() {
                // In lanes that do not press there is no law: a bound of zero that no velocity changes. (A product: to store some
                // lanes only is far slower.)
                let share = T::only(pressed, T::ONE);
                let only = |x: T| x * share;
                law.row = law.row.map(only);
                law.slope = law.slope.map(only);
                law.bound = only(law.bound);
                impulses.sliding[n] = only(impulses.sliding[n]);
                guess.sliding[n] = only(guess.sliding[n]);
            }
            n += 1;
        }
        system.count = n;
    }
    let n = system.count;
    if let (Input::Rigid { velocity }, true, true) = (input, model.site.is_some(), n < N) {
        laws[n] = Law::Rigid;
        let law = &mut system.sliding[n];
        model.site_path.spread(site_row, T::ONE, &mut law.row);
        law.target = *velocity;
        law.rigid = true;
        impulses.sliding[n] = h * *rigid_force;
        guess.sliding[n] = T::ZERO;
        guess.open[n] = T::Mask::splat(false);
        system.count = n + 1;
    }
}

/// Stores the sliding laws' forces p/h and sides: the next warm start, and what the run reports.
#[inline(always)]
pub(crate) fn keep_forces<T: Real, const B: usize, const Z: usize, const N: usize>(
    settings: &Settings<T>,
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let inverse_h = T::ONE / settings.step;
    for k in 0..scratch.system.count {
        let f = scratch.impulses.sliding[k] * inverse_h;
        match scratch.laws[k] {
            Law::Zone(z) => {
                scratch.tangential[z] = f;
                scratch.side[z] = scratch.guess.sliding[k];
            }
            Law::Rigid => {
                scratch.rigid_force = f;
                scratch.drive_force = f;
            }
        }
    }
}

/// What a step that ends keeps of the laws, in the lanes in which it ends.
#[inline(always)]
pub(crate) fn end<T: Real, const B: usize, const Z: usize, const N: usize>(
    settings: &Settings<T>,
    lanes: T::Mask,
    state: &mut State<T, B, Z>,
    scratch: &Scratch<T, B, Z, N>,
) {
    let inverse_h = T::ONE / settings.step;
    if lanes.all() && !settings.friction.is_regularised() {
        // The usual case by itself: storing some lanes only is far slower than storing all.
        for i in 0..B {
            state.pivot_friction[i] = scratch.impulses.pivot[i] * inverse_h;
        }
        state.rigid_force = scratch.rigid_force;
        for &z in state.survey.sliding() {
            (state.tangential[z], state.side[z]) = (scratch.tangential[z], scratch.side[z]);
        }
        return;
    }
    let keep = |old: &mut T, new: T| *old = T::select(lanes, new, *old);
    for i in 0..B {
        let regularised = settings.friction.is_regularised();
        let force = if regularised { scratch.pivot_friction[i] } else { scratch.impulses.pivot[i] * inverse_h };
        keep(&mut state.pivot_friction[i], force);
    }
    keep(&mut state.rigid_force, scratch.rigid_force);
    for &z in state.survey.sliding() {
        keep(&mut state.tangential[z], scratch.tangential[z]);
        keep(&mut state.side[z], scratch.side[z]);
    }
}

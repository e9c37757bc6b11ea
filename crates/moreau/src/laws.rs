//! Set-valued part of a step: the active laws, and their forces and sides afterwards.

use crate::input::SiteInput;
use crate::law::MEMORY;
use crate::model::Model;
use crate::osnsp::Solver;
use crate::real::{Aside, Mask, Real};
use crate::settings::Settings;
use crate::state::State;
use crate::timing::Timing;
use crate::workspace::{Forces, LawSource, Problem, Turning, Workspace};
use crate::{dry_felts, dwell};

/// Guesses where the pivots stand, before a step's first iteration. A pivot that turned is expected to go on turning,
/// unless the predicted velocity `w` has the other sign: then it is expected to stick, as does one that stuck.
#[inline(always)]
pub(crate) fn warm_start_pivots<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    state: &State<T, B, Z>,
    w0: &[T; B],
    w: &[T; B],
    workspace: &mut Workspace<T, B, Z, N>,
) {
    workspace.forces.rigid_force = state.rigid_force;
    if settings.solver == Solver::ProjectedGaussSeidel {
        for i in 0..B {
            workspace.problem.impulses.pivot[i] = settings.step * state.pivot_friction[i];
        }
    }
    for i in 0..B {
        // Without dry friction a pivot never sticks: its bound is zero, and so is its impulse.
        let goes_on = settings.solver_tolerance.lt(w0[i].abs()).and(T::ZERO.lt(w0[i] * w[i]));
        let moves = goes_on.or(model.dry[i].le(T::ZERO));
        let against = T::select(T::ZERO.lt(w[i]), -T::ONE, T::ONE);
        workspace.problem.guess.pivot[i] = T::only(moves, against);
    }
}

/// Completes the linearised step with the laws in force and a warm start: the last iteration's forces and sides, or in
/// the first iteration the contact cache.
///
/// There is room for all laws: `step_lanes` takes no step where there is not.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub(crate) fn assemble_laws<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &SiteInput<T>,
    state: &State<T, B, Z>,
    first: bool,
    w0: &[T; B],
    w: &[T; B],
    workspace: &mut Workspace<T, B, Z, N>,
) {
    let h = settings.step;
    let Workspace { contacts, problem, turning, forces, .. } = &mut *workspace;
    let Problem { system, impulses, guess, sources, .. } = problem;
    let Turning { slip_before, span, turn } = turning;
    let Forces { tangential, side, .. } = forces;
    if settings.friction.is_regularised() {
        system.pivot_bound = [T::ZERO; B];
        impulses.pivot = [T::ZERO; B];
        guess.pivot = [T::ONE; B];
        system.count = 0;
        for &z in state.broad_phase.sliding() {
            if !contacts.active[z].any() {
                tangential[z] = T::ZERO;
            }
            side[z] = T::ZERO;
        }
    } else {
        for i in 0..B {
            system.pivot_bound[i] = h * model.dry[i];
        }
        let mut n = 0;
        let allows_for_turning = T::ZERO.lt(*span).any();
        for &z in state.broad_phase.sliding() {
            let (contact, support, mu) = (&contacts.states[z], &model.supports[z], model.compiled[z].friction);
            let slip_row = &contacts.slip_row[z];
            let (warm, warm_side) = if first { (state.tangential[z], state.side[z]) } else { (tangential[z], side[z]) };
            (tangential[z], side[z]) = (T::ZERO, T::ZERO);
            if allows_for_turning {
                turn[z] = T::ZERO;
            }
            let pressed = contacts.active[z].and(T::ZERO.lt(contact.force));
            if !pressed.any() || n >= N {
                continue;
            }
            sources[n] = LawSource::Zone(z);
            let law = &mut system.sliding[n];
            support.spread(slip_row, T::ONE, &mut law.row);
            law.target = T::ZERO;
            if allows_for_turning {
                // Stick must hold at the end of the step. The slip row is extrapolated to that instant: it is assumed
                // to keep turning at the rate since the last step.
                let pressed_before = T::ZERO.lt(warm.abs()).or(T::ZERO.lt(warm_side.abs()));
                let turned = support.product(slip_row, w0) - slip_before[z];
                let rest = (T::ONE - settings.theta) * h / (*span + settings.theta * h);
                turn[z] = T::only(pressed_before, rest * turned);
                law.target = -turn[z];
            }
            // The felt's force in this very step, mu (F + dF/dw (w1 - w)), times h.
            let gradient = mu * contact.tangent;
            law.bound = (mu * h * contact.force).sub_product(gradient, support.product(&contact.row, w));
            support.spread(&contact.row, gradient, &mut law.slope);
            law.rigid = false;
            guess.open[n] = pressed.not();
            impulses.sliding[n] = h * warm;
            guess.sliding[n] = warm_side;
            let fresh = warm.abs().le(T::ZERO).and(warm_side.abs().le(T::ZERO));
            if fresh.any() {
                // Touched for the first time: it slides as it arrives.
                let u = support.product(slip_row, w0);
                let arrival = T::select(T::ZERO.lt(u), -T::ONE, T::ONE);
                guess.sliding[n] = T::select(fresh, arrival, warm_side);
            }
            if !pressed.all() {
                // Lanes that do not press have no law: a bound of zero that no velocity changes. A product does it,
                // because storing only some lanes is far slower.
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
    if model.remembers && !settings.friction.is_regularised() {
        complete_laws(model, settings, first, w0, w, workspace);
    }
    let Workspace { drive, problem: Problem { system, impulses, guess, sources, .. }, forces, .. } = workspace;
    let n = system.count;
    if let (SiteInput::Rigid { velocity }, true, true) = (input, model.site.is_some(), n < N) {
        sources[n] = LawSource::Drive;
        let law = &mut system.sliding[n];
        model.site_support.spread(&drive.site_row, T::ONE, &mut law.row);
        law.target = *velocity;
        law.rigid = true;
        impulses.sliding[n] = h * forces.rigid_force;
        guess.sliding[n] = T::ZERO;
        guess.open[n] = T::Mask::splat(false);
        system.count = n + 1;
    }
}

/// What dry felts and friction that grows at rest add to the laws.
#[cold]
#[inline(never)]
fn complete_laws<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    first: bool,
    w0: &[T; B],
    w: &[T; B],
    workspace: &mut Workspace<T, B, Z, N>,
) {
    if model.dry_count > 0 {
        dry_felts::assemble(model, settings, first, w0, w, workspace);
    }
    if model.dwelling.count > 0 {
        dwell::raise_bounds(model, workspace);
    }
}

/// In which lanes dry felts or friction that had grown at rest are not yet what the solver, which gave the velocities
/// `next`, took them for.
#[cold]
#[inline(never)]
pub(crate) fn unsettled<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    w0: &[T; B],
    next: &[T; B],
    workspace: &mut Workspace<T, B, Z, N>,
) -> T::Mask {
    let mut again = T::Mask::splat(false);
    if model.dry_count > 0 {
        again = dry_felts::unsettled(model, settings, w0, next, workspace);
    }
    if model.dwelling.count > 0 {
        again = again.or(dwell::slipped(model, settings, next, workspace));
    }
    again
}

/// Stores the sliding laws' forces p/h and sides: the next iteration's warm start, and what the run reports.
#[inline(always)]
pub(crate) fn store_forces<T: Real, const B: usize, const Z: usize, const N: usize>(
    settings: &Settings<T>,
    workspace: &mut Workspace<T, B, Z, N>,
) {
    let inverse_h = T::ONE / settings.step;
    let Workspace { problem, forces, drive, dry, .. } = workspace;
    for k in 0..problem.system.count {
        let f = problem.impulses.sliding[k] * inverse_h;
        match problem.sources[k] {
            LawSource::Zone(z) => {
                forces.tangential[z] = f;
                forces.side[z] = problem.guess.sliding[k];
            }
            LawSource::Felt(z) => {
                dry.force[z] = T::select(dry.law[z], -f, dry.force[z]);
                dry.side[z] = problem.guess.sliding[k];
            }
            LawSource::Drive => {
                forces.rigid_force = f;
                drive.force = f;
            }
        }
    }
}

/// Hands the laws' forces and sides to the state's contact cache, in the lanes in which the step ends.
#[inline(always)]
pub(crate) fn keep_forces<T: Real, const B: usize, const Z: usize, const N: usize>(
    settings: &Settings<T>,
    lanes: T::Mask,
    state: &mut State<T, B, Z>,
    workspace: &Workspace<T, B, Z, N>,
) {
    let inverse_h = T::ONE / settings.step;
    if lanes.all() && !settings.friction.is_regularised() {
        // The usual case stands by itself: storing only some lanes is far slower than storing all.
        for i in 0..B {
            state.pivot_friction[i] = workspace.problem.impulses.pivot[i] * inverse_h;
        }
        state.rigid_force = workspace.forces.rigid_force;
        for &z in state.broad_phase.sliding() {
            (state.numbers.tangential[z], state.numbers.side[z]) =
                (workspace.forces.tangential[z], workspace.forces.side[z]);
        }
        return;
    }
    let keep = |old: &mut T, new: T| *old = T::select(lanes, new, *old);
    for i in 0..B {
        let regularised = settings.friction.is_regularised();
        let force = if regularised {
            workspace.forces.pivot_friction[i]
        } else {
            workspace.problem.impulses.pivot[i] * inverse_h
        };
        keep(&mut state.pivot_friction[i], force);
    }
    keep(&mut state.rigid_force, workspace.forces.rigid_force);
    for &z in state.broad_phase.sliding() {
        keep(&mut state.numbers.tangential[z], workspace.forces.tangential[z]);
        keep(&mut state.numbers.side[z], workspace.forces.side[z]);
    }
}

/// Hands to the state what felts and resting friction remember, in the lanes in which the step ends; `w`: the relative
/// velocities then.
#[cold]
#[inline(never)]
pub(crate) fn keep_memories<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    lanes: T::Mask,
    w: &[T; B],
    state: &mut State<T, B, Z>,
    workspace: &Workspace<T, B, Z, N>,
) {
    T::aside(KeepMemories { model, settings, lanes, w, state, workspace });
}

struct KeepMemories<'a, T: Real, const B: usize, const Z: usize, const N: usize> {
    model: &'a Model<T, B, Z>,
    settings: &'a Settings<T>,
    lanes: T::Mask,
    w: &'a [T; B],
    state: &'a mut State<T, B, Z>,
    workspace: &'a Workspace<T, B, Z, N>,
}

impl<T: Real, const B: usize, const Z: usize, const N: usize> Aside for KeepMemories<'_, T, B, Z, N> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let KeepMemories { model, settings, lanes, w, state, workspace } = self;
        if model.dwelling.count > 0 {
            dwell::keep(model, settings, lanes, w, state, workspace);
        }
        let timing = Timing::new(settings.step, settings.theta);
        let (all, mut next) = (&workspace.contacts.touched[..workspace.contacts.touched_count], 0);
        for &z in model.remembering_zones() {
            // Both lists ascend. Whatever its law, a felt that is not touched does not begin to remember.
            while all.get(next).is_some_and(|&other| other < z) {
                next += 1;
            }
            let is_near = all.get(next) == Some(&z);
            if !is_near && state.memory[z].iter().all(|x| x.is_zero()) {
                continue;
            }
            let compiled = &model.compiled[z];
            let touched = if is_near { workspace.contacts.active[z] } else { T::Mask::splat(false) };
            let memory = if compiled.dry {
                let mut memory = [T::ZERO; MEMORY];
                memory[0] = T::only(touched, workspace.dry.force[z]);
                memory
            } else {
                let contact = &workspace.contacts.states[z];
                contact.remembered(
                    compiled,
                    &model.supports[z],
                    &workspace.correction,
                    &timing,
                    touched,
                    &workspace.contacts.surfaces[z],
                )
            };
            for (kept, new) in state.memory[z].iter_mut().zip(memory) {
                *kept = T::select(lanes, new, *kept);
            }
        }
    }
}

/// Hands to the step what felts and resting friction remember.
#[cold]
#[inline(never)]
pub(crate) fn recall_memories<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    state: &State<T, B, Z>,
    workspace: &mut Workspace<T, B, Z, N>,
) {
    for &z in model.remembering_zones() {
        workspace.contacts.states[z].memory = state.memory[z];
    }
    dry_felts::begin(model, state, workspace);
    dwell::begin(state, workspace);
}

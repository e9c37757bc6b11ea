//! The inner step: one step of the Moreau-Jean theta scheme for a planar tree of hinged bodies with felts and dry
//! friction.
//!
//! # Equations
//!
//! The mechanism obeys the measure differential equation `M(q) dv + F(t, q, v) dt = di` [T12 eqs 2-4, T13 eq 3], [M88],
//! which is (T1) of the book (`book/src/model/time-stepping.md`).
//! A fixed step h takes (q0, v0) to (q1, v1) without locating events [J99]:
//!
//! ```text
//! M(q_*) (w1 - w0) = h Q(q_theta, w_theta, t_theta) + D(q_*) p           momentum over the step: (T2) of the book
//! w_theta = (1 - theta) w0 + theta w1                                    theta = 1/2: second order, no numerical damping
//! q_theta = q0 + theta h v_theta,   q1 = q0 + h v_theta                  v_theta: absolute, from w_theta
//! |p_i| <= h c_i  (pivots),   |p_j| <= h mu_j F_j  (sliding contacts)    each opposes its u = D^T w1; true stick at
//!                                                                        u = 0: (T3) of the book
//! ```
//!
//! Newton's method linearises the regular part to `A w1 = b + D p`, with A symmetric positive definite, (T4) of the
//! book:
//!
//! ```text
//! A = M + sum over zones of tangent G^T G + springs and dampers,         tangent = h theta (F_v + theta h F_g) >= 0
//! ```
//!
//! Every iteration solves the one-step problem, (T5) of the book, for (w1, p) exactly (`osnsp/`). An iteration is the
//! last one when its correction is small, or when the error of the linearisation is (`acceptance.rs`).
//!
//! # Symbols
//!
//! | symbol | meaning |
//! |---|---|
//! | q, v | absolute angles, rad, and angular velocities, rad/s ([`State`]) |
//! | w | joint velocities, `w_i = v_i - v_parent(i)`, rad/s |
//! | 0, 1, theta | the step's start, its end, and the point theta h after its start |
//! | q_* | the pose predicted at the theta point, where M and D are taken |
//! | M, Q | mass matrix; generalised forces of gravity, springs, viscous friction, felts and drive |
//! | p, D | impulses of the set-valued laws in the step, and the directions in which they act |
//! | g, dg/dt = G w, F(g, dg/dt) | a zone's compression (positive when pressed), its rate and row, and the felt's force; F_g, F_v: its derivatives |
//! | c, mu | dry torque of a pivot, N m; Coulomb's coefficient of a zone |
//!
//! # Where the parts are
//!
//! [`step_lanes`] begins and ends a step; `iterate` is one Newton iteration. Both call the stages in the order of the
//! table in this crate's README, which also has the derivations.
//!
//! # References
//!
//! - [T12] Thorin, Boutillon, Lozada, Merlhiot, *Simulation of a non-smooth dynamical model of the piano key*.
//! - [T13] Thorin, Boutillon, Merlhiot, Lozada, *A non-smooth simulation of the dynamics of the grand piano action*,
//!   Waves 2013.
//! - [M88] Moreau, *Unilateral contact and dry friction in finite freedom dynamics*, CISM Courses and Lectures 302,
//!   1988.
//! - [J99] Jean, *The non-smooth contact dynamics method*, Comput. Methods Appl. Mech. Engrg. 177 (1999) 235-257.

use crate::acceptance::linearisation_holds;
use crate::dry_felts;
use crate::forces::{joint_momentum, linearise, move_hand, regularised_friction};
use crate::input::SiteInput;
use crate::laws::{
    assemble_laws, keep_forces, keep_memories, recall_memories, store_forces, unsettled, warm_start_pivots,
};
use crate::model::Model;
use crate::narrow_phase::{add_felts, narrow_phase};
use crate::real::{Mask, Real, Scalar, opaque};
use crate::settings::{FrictionLaw, Settings};
use crate::state::State;
use crate::timing::Timing;
use crate::workspace::{Problem, Workspace};

/// Outcome of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepOutcome {
    /// The last Newton correction and the one-step problem met their tolerances.
    Converged,
    /// The iteration limit was reached; the state is the last (finite) iterate.
    IterationLimit,
    /// A number became infinite or NaN (or the input contained one), or the square of a velocity overflowed. The state
    /// was not changed.
    NonFinite,
    /// The model has more set-valued laws ([`Model::laws`]) than the workspace has room for (N). The state was not
    /// changed. [`Workspace::for_model`] detects this beforehand.
    TooManyLaws,
}

/// Report of a step: its outcome and its work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepReport {
    /// Outcome of the step.
    pub outcome: StepOutcome,
    /// Newton iterations.
    pub newton: u32,
    /// Solver iterations (sweeps or active sets), summed over the Newton iterations.
    pub solver: u32,
}

/// Beyond this many Newton iterations the corrections are halved. That ends a cycle between the two sides of a felt's
/// onset.
const DAMPED_AFTER: u32 = 8;

/// Bodies of the largest mechanism that is stepped often, a piano's action. For larger ones an iteration is compiled
/// once ([`Real::FIRST_APART`]).
const PIANO: usize = 9;

/// Advances `state` by one step h. Never allocates and never panics; the number of iterations is bounded.
///
/// `input` acts during the step; [`SiteInput`] states at which instant each of its numbers holds. `N` must be at least
/// [`Model::laws`].
// Inlined where it is called, it takes a tenth fewer instructions: the caller's arrays have known places. The compiler
// would decide that by size, and the step is near its limit.
#[inline(always)]
pub fn step<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &SiteInput<T>,
    state: &mut State<T, B, Z>,
    workspace: &mut Workspace<T, B, Z, N>,
) -> StepReport {
    if N < model.laws {
        return StepReport { outcome: StepOutcome::TooManyLaws, newton: 0, solver: 0 };
    }
    if !input.finite() {
        return StepReport { outcome: StepOutcome::NonFinite, newton: 0, solver: 0 };
    }
    let ended = step_lanes(model, settings, input, state, workspace);
    let outcome = match (ended.finite, ended.converged) {
        (false, _) => StepOutcome::NonFinite,
        (true, true) => StepOutcome::Converged,
        (true, false) => StepOutcome::IterationLimit,
    };
    StepReport { outcome, newton: ended.newton, solver: ended.solver }
}

/// Calls [`step()`] out of line, compiled once for each size. A call costs a few more instructions than the inlined
/// step, but each further call site saves a hundred kilobytes of code.
#[inline(never)]
pub fn step_out_of_line<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &SiteInput<T>,
    state: &mut State<T, B, Z>,
    workspace: &mut Workspace<T, B, Z, N>,
) -> StepReport {
    step(model, settings, input, state, workspace)
}

/// Outcome of a step in every lane.
#[derive(Debug, Clone, Copy)]
pub struct LanesReport<M> {
    /// Lanes with [`StepOutcome::Converged`].
    pub converged: M,
    /// Lanes without [`StepOutcome::NonFinite`].
    pub finite: M,
    /// Newton iterations until the last lane ended.
    pub newton: u32,
    /// Solver iterations (sweeps or active sets), summed over these Newton iterations.
    pub solver: u32,
}

/// Advances several mechanisms by one step, one in each lane. Every lane gets the result of [`step()`] alone, to
/// rounding. The mechanisms must have the same topology (parents, kinds of curves and felts); their numbers may differ.
///
/// `N` must be at least [`Model::laws`]: otherwise no state changes, and no lane is `converged` or `finite`. The input
/// of every lane must be finite ([`SiteInput::finite`]).
#[inline(always)]
pub fn step_lanes<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &SiteInput<T>,
    state: &mut State<T, B, Z>,
    workspace: &mut Workspace<T, B, Z, N>,
) -> LanesReport<T::Mask> {
    let no = T::Mask::splat(false);
    let mut report = LanesReport { converged: no, finite: T::Mask::splat(true), newton: 0, solver: 0 };
    if N < model.laws {
        return LanesReport { finite: no, ..report };
    }
    let w0 = model.tree.relative(&state.velocity);
    // The acceptance test knows the felts' curvature but not a regularised friction law's, whose stiffness also makes
    // increments alternate.
    let smooth = !settings.friction.is_regularised();
    let mut w = if smooth { extrapolate(model, settings, &w0, &state.increment) } else { w0 };
    warm_start_pivots(model, settings, state, &w0, &w, workspace);
    if model.remembers {
        recall_memories(model, state, workspace);
    }
    let mut done = no;
    let next = if const { !T::FIRST_APART || B > PIANO } {
        iterate_to_the_end(model, settings, input, state, workspace, &w0, &mut w, &mut done, &mut report, 0)
    } else {
        // The compiler hoists loop-invariant loads out of a loop and spills them to the stack. This loop usually runs
        // once, so that only costs time. The first iteration therefore stands outside the loop, and the others in a
        // function of their own.
        let first = match settings.newton_limit {
            0 => Next::End,
            _ => iterate(model, settings, input, state, workspace, &w0, &mut w, &mut done, &mut report, 0),
        };
        if first == Next::Again {
            let so_far = Iterate { w, done, report };
            let (next, all) = further_iterations(model, settings, input, state, workspace, w0, so_far);
            Iterate { w, done, report } = all;
            next
        } else {
            first
        }
    };
    if next == Next::Nothing {
        return report;
    }
    keep_forces(settings, done.not().and(report.finite), state, workspace);
    if model.remembers {
        keep_memories(model, settings, done.not().and(report.finite), &w, state, workspace);
    }
    if let SiteInput::Hand(hand) = input {
        let timing = Timing::new(settings.step, settings.theta);
        move_hand(&timing, hand, done.not().and(report.finite), &state.hand, &mut workspace.drive);
        for (place, end) in state.hand.iter_mut().zip(&workspace.drive.hand) {
            *place = T::select(report.finite, *end, *place);
        }
    }
    integrate(model, settings, &w, report.finite, state);
    report
}

/// Where Newton's method is after some iterations.
#[derive(Clone, Copy)]
struct Iterate<T: Real, const B: usize> {
    /// Relative velocities.
    w: [T; B],
    /// The lanes that have ended.
    done: T::Mask,
    report: LanesReport<T::Mask>,
}

/// All iterations but the first one. Seldom needed; what goes in and out goes by value, so that the first one can keep
/// it in registers.
#[cold]
#[inline(never)]
fn further_iterations<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &SiteInput<T>,
    state: &mut State<T, B, Z>,
    workspace: &mut Workspace<T, B, Z, N>,
    w0: [T; B],
    mut at: Iterate<T, B>,
) -> (Next, Iterate<T, B>) {
    let Iterate { w, done, report } = &mut at;
    let next = iterate_to_the_end(model, settings, input, state, workspace, &w0, w, done, report, 1);
    (next, at)
}

/// Newton iterations from a given one on, until all lanes have ended or the limit is reached.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn iterate_to_the_end<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &SiteInput<T>,
    state: &mut State<T, B, Z>,
    workspace: &mut Workspace<T, B, Z, N>,
    w0: &[T; B],
    w: &mut [T; B],
    done: &mut T::Mask,
    report: &mut LanesReport<T::Mask>,
    from: u32,
) -> Next {
    for iteration in from..settings.newton_limit {
        let (model, settings) = (opaque::<T, _>(model), opaque::<T, _>(settings));
        let workspace = opaque::<T, _>(&mut *workspace);
        let next = iterate(model, settings, input, state, workspace, w0, w, done, report, iteration);
        if next != Next::Again {
            return next;
        }
    }
    Next::Again
}

/// What follows a Newton iteration.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Next {
    /// One more.
    Again,
    /// The step's end.
    End,
    /// Nothing: no lane is finite.
    Nothing,
}

/// One Newton iteration, from the relative velocities `w` to the next ones: the stages of the README's table, in call
/// order. `done`: the lanes that have ended already.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn iterate<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &SiteInput<T>,
    state: &mut State<T, B, Z>,
    workspace: &mut Workspace<T, B, Z, N>,
    w0: &[T; B],
    w: &mut [T; B],
    done: &mut T::Mask,
    report: &mut LanesReport<T::Mask>,
    iteration: u32,
) -> Next {
    let first = iteration == 0;
    let timing = Timing::new(settings.step, settings.theta);
    let q_theta = theta_point(model, &state.angle, w0, w, &timing, workspace);
    let joint_angle = model.tree.relative(&q_theta);
    workspace.kinematics.pose.place(&model.tree, model.first_moments(), &q_theta);
    if first && state.broad_phase.renew(model, &workspace.kinematics, &joint_angle, &timing) {
        state.forget_far(model);
    }
    let near = state.broad_phase.near();
    narrow_phase(model, &timing, near, first, workspace);
    if first {
        // The first iterate is a prediction, so this is the predicted pose q_* at which M and D are taken.
        joint_momentum(model, &state.velocity, w0, workspace);
    }
    linearise(model, &timing, input, &state.hand, w, &joint_angle, workspace);
    add_felts(model, &timing, near, w, workspace);
    if let FrictionLaw::Regularised { pivot_width, sliding_width } = settings.friction {
        regularised_friction(model, &timing, near, [pivot_width, sliding_width], w, workspace);
        if model.dry_count > 0 {
            dry_felts::regularised(model, settings, sliding_width, w, workspace);
        }
    }
    assemble_laws(model, settings, input, state, first, w0, w, workspace);
    let (next, solved, sets) = solve(settings, workspace);
    store_forces(settings, workspace);
    report.newton = iteration + 1;
    report.solver += sets;

    let finite = usable(&next);
    report.finite = report.finite.and(finite.or(*done));
    if !report.finite.any() {
        return Next::Nothing;
    }
    for i in 0..B {
        workspace.correction[i] = next[i] - w[i];
    }
    let linear = linearisation_holds(model, settings, &timing, near, &next, workspace);
    let enough = if linear.all() { linear } else { linear.or(small(&workspace.correction, &next, settings.tolerance)) };
    let mut settled = enough.and(solved).and(finite).and(done.not());
    settled = settled.and(T::derivatives_settled(&workspace.correction, &next));
    if model.remembers && !settings.friction.is_regularised() {
        settled = settled.and(unsettled(model, settings, w0, &next, workspace).not());
    }
    report.converged = report.converged.or(settled);
    if settled.any() && !settled.or(*done).all() {
        // These lanes end here, and keep their forces while others go on.
        keep_forces(settings, settled, state, workspace);
        if model.remembers {
            keep_memories(model, settings, settled, &next, state, workspace);
        }
        if let SiteInput::Hand(hand) = input {
            move_hand(&timing, hand, settled, &state.hand, &mut workspace.drive);
        }
    }
    if settled.all() {
        *w = next;
        return Next::End;
    }
    let stopped = done.or(finite.not());
    let share = if iteration < DAMPED_AFTER { T::ONE } else { T::from_f64(0.5) };
    for i in 0..B {
        w[i] = T::select(settled, next[i], T::select(stopped, w[i], w[i] + share * workspace.correction[i]));
    }
    if settled.or(stopped).all() {
        return Next::End;
    }
    *done = done.or(settled).or(finite.not());
    Next::Again
}

/// Solves the one-step problem: the next relative velocities, the lanes in which the solver converged, and its sweeps
/// or active sets.
#[inline(always)]
fn solve<T: Real, const B: usize, const Z: usize, const N: usize>(
    settings: &Settings<T>,
    workspace: &mut Workspace<T, B, Z, N>,
) -> ([T; B], T::Mask, u32) {
    let (tolerance, limit) = (settings.solver_tolerance, settings.solver_limit);
    let Problem { system, impulses, guess, condensed, .. } = &mut workspace.problem;
    let mut next = [T::ZERO; B];
    let (solved, sets) = settings.solver.solve(system, impulses, guess, condensed, tolerance, limit, &mut next);
    (next, solved, sets)
}

/// The first iterate: the velocities plus the last step's increment. A joint that stands still is expected to stick.
#[inline(always)]
fn extrapolate<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    w0: &[T; B],
    increment: &[T; B],
) -> [T; B] {
    let mut w = *w0;
    let increment = model.tree.relative(increment);
    for i in 0..B {
        w[i] += T::only(settings.solver_tolerance.lt(w0[i].abs()), increment[i]);
    }
    w
}

/// w_theta = (1 - theta) w0 + theta w1 and, from it, q_theta = q0 + theta h v_theta.
#[inline(always)]
fn theta_point<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    q0: &[T; B],
    w0: &[T; B],
    w: &[T; B],
    timing: &Timing<T>,
    workspace: &mut Workspace<T, B, Z, N>,
) -> [T; B] {
    let (theta, kinematics) = (timing.theta, &mut workspace.kinematics);
    for i in 0..B {
        kinematics.joint_velocity[i] = ((T::ONE - theta) * w0[i]).add_product(theta, w[i]);
    }
    model.tree.absolute(&kinematics.joint_velocity, &mut kinematics.velocity);
    let mut q = *q0;
    for i in 0..B {
        q[i] = q[i].add_product(timing.h_theta, kinematics.velocity[i]);
    }
    q
}

/// Whether velocities are numbers whose squares do not overflow. What the step's end works out from them does not
/// overflow then.
#[inline(always)]
fn usable<T: Real, const B: usize>(w: &[T; B]) -> T::Mask {
    let mut sum = T::ZERO;
    for i in 0..B {
        sum = sum.add_product(w[i], w[i]);
    }
    sum.finite()
}

/// Whether all corrections are small against the tolerance.
#[inline(always)]
fn small<T: Real, const B: usize>(correction: &[T; B], next: &[T; B], tolerance: T) -> T::Mask {
    let mut small = T::Mask::splat(true);
    for i in 0..B {
        small = small.and(correction[i].abs().le(tolerance * (T::ONE + next[i].abs())));
    }
    small
}

/// q1 = q0 + h ((1 - theta) v0 + theta v1), in some lanes.
#[inline(always)]
fn integrate<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    w: &[T; B],
    lanes: T::Mask,
    state: &mut State<T, B, Z>,
) {
    let (h, theta, mut v) = (settings.step, settings.theta, *w);
    model.tree.absolute(w, &mut v);
    if lanes.all() {
        for i in 0..B {
            state.increment[i] = v[i] - state.velocity[i];
            let mean = state.velocity[i].add_product(theta, state.increment[i]);
            state.angle[i] = state.angle[i].add_product(h, mean);
            state.velocity[i] = v[i];
        }
        return;
    }
    let keep = |old: &mut T, new: T| *old = T::select(lanes, new, *old);
    for i in 0..B {
        let increment = v[i] - state.velocity[i];
        let mean = state.velocity[i].add_product(theta, increment);
        let angle = state.angle[i].add_product(h, mean);
        keep(&mut state.angle[i], angle);
        keep(&mut state.increment[i], increment);
        keep(&mut state.velocity[i], v[i]);
    }
}

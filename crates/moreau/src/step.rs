//! The inner step: one Moreau-Jean theta step. The equations stand in this crate's README, "The step".

use crate::contact::Timing;
use crate::forces::{joint_momentum, linearise, regularised_friction};
use crate::joints::{absolute, relative};
use crate::laws::{begin, end, keep_forces, one_step_problem};
use crate::model::Model;
use crate::real::opaque;
use crate::settings::{FrictionLaw, Settings};
use crate::state::{Input, Scratch, State};
use crate::zones::{add_zones, linear_enough, look_at_zones};
use crate::{Mask, Real, Scalar};

/// How a step ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The last Newton correction and the one-step problem met their tolerances.
    Converged,
    /// The iteration limit was reached; the last (finite) iterate was taken.
    IterationLimit,
    /// A number that is not finite arose (or came in with the input), or a velocity whose square is not; the state was left as it was.
    NonFinite,
}

/// What a step did: its outcome and its work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepReport {
    /// How it ended.
    pub outcome: Outcome,
    /// Newton iterations.
    pub newton: u32,
    /// Sweeps or active sets, summed over the Newton iterations.
    pub solver: u32,
}

/// Beyond this many Newton iterations the corrections are halved: a cycle between two sides of a felt's onset is then cut.
const DAMPED_AFTER: u32 = 8;

/// Advances `state` by one step h. Never allocates, never panics, takes a bounded number of iterations.
///
/// `input` holds during the step (see [`Input`] for the instants that its numbers belong to). `N` must be at least `B` plus the
/// number of zones with Coulomb friction plus one; further laws are left out.
pub fn step<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &Input<T>,
    state: &mut State<T, B, Z>,
    scratch: &mut Scratch<T, B, Z, N>,
) -> StepReport {
    let ended = step_lanes(model, settings, input, state, scratch);
    let outcome = match (ended.finite, ended.converged) {
        (false, _) => Outcome::NonFinite,
        (true, true) => Outcome::Converged,
        (true, false) => Outcome::IterationLimit,
    };
    StepReport { outcome, newton: ended.newton, solver: ended.solver }
}

/// How a step ended in every lane.
#[derive(Debug, Clone, Copy)]
pub struct LanesReport<M> {
    /// Where [`Outcome::Converged`].
    pub converged: M,
    /// Where not [`Outcome::NonFinite`].
    pub finite: M,
    /// Newton iterations, until the last lane was done.
    pub newton: u32,
    /// Sweeps or active sets likewise.
    pub solver: u32,
}

/// [`step()`] for several mechanisms at once, one in each lane: the same kernel, and the same numbers in every lane as if it were alone,
/// to rounding. The mechanisms must share their topology (what is hinged on what, which curves and exponents), not their numbers.
#[inline(always)]
pub fn step_lanes<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &Input<T>,
    state: &mut State<T, B, Z>,
    scratch: &mut Scratch<T, B, Z, N>,
) -> LanesReport<T::Mask> {
    let w0 = relative(model, &state.velocity);
    // The remainder knows the felts' curvature, not a regularised friction law's, whose stiffness also makes trends alternate.
    let smooth = !settings.friction.is_regularised();
    let mut w = if smooth { extrapolate(model, settings, &w0, &state.trend) } else { w0 };
    let no = T::Mask::splat(false);
    let mut report = LanesReport { converged: no, finite: T::Mask::splat(true), newton: 0, solver: 0 };
    begin(model, settings, state, &w0, &w, scratch);
    let mut done = no;
    // Out of what a loop runs through, and be it once, everything is taken that does not change, stored, and read again. So the first and
    // mostly only iteration stands by itself; in lanes, where the code would be too long twice, references are made opaque.
    let (alone, mut next) = (T::LANES == 1, Next::Again);
    if alone && 0 < settings.newton_limit {
        next = iterate(model, settings, input, state, scratch, &w0, &mut w, &mut done, &mut report, 0);
    }
    if next == Next::Again {
        for iteration in u32::from(alone)..settings.newton_limit {
            let (model, settings) = (opaque::<T, _>(model), opaque::<T, _>(settings));
            let scratch = opaque::<T, _>(&mut *scratch);
            next = iterate(model, settings, input, state, scratch, &w0, &mut w, &mut done, &mut report, iteration);
            if next != Next::Again {
                break;
            }
        }
    }
    if next == Next::Nothing {
        return report;
    }
    end(settings, done.not().and(report.finite), state, scratch);
    finish(model, settings, &w, report.finite, state);
    report
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

/// One Newton iteration, from the relative velocities `w` to the next ones. `done`: the lanes that go on no more.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn iterate<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &Input<T>,
    state: &mut State<T, B, Z>,
    scratch: &mut Scratch<T, B, Z, N>,
    w0: &[T; B],
    w: &mut [T; B],
    done: &mut T::Mask,
    report: &mut LanesReport<T::Mask>,
    iteration: u32,
) -> Next {
    let again = iteration > 0;
    let (h, theta) = (settings.step, settings.theta);
    let timing = Timing::new(h, theta);
    let q_theta = theta_point(model, &state.angle, w0, w, h, theta, scratch);
    let joint_angle = relative(model, &q_theta);
    scratch.pose.place(model, &q_theta);
    if !again && state.survey.renew(model, &scratch.pose, &joint_angle, &scratch.joint_velocity, &timing) {
        state.forget_far(model);
    }
    let near = state.survey.near();
    look_at_zones(model, &timing, near, again, scratch);
    if !again {
        // The first iterate is a prediction, so this is the predicted pose q_* at which M and D are taken.
        joint_momentum(model, &state.velocity, w0, scratch);
    }
    linearise(model, &timing, input, w, &joint_angle, scratch);
    add_zones(model, &timing, w, scratch);
    if let FrictionLaw::Regularised { pivot_width, sliding_width } = settings.friction {
        regularised_friction(model, &timing, near, [pivot_width, sliding_width], w, scratch);
    }
    one_step_problem(model, settings, input, state, again, w0, w, scratch);
    let mut next = [T::ZERO; B];
    let (solved, sets) = settings.solver.solve(settings, scratch, &mut next);
    keep_forces(settings, scratch);
    report.newton = iteration + 1;
    report.solver += sets;

    let finite = usable(&next);
    report.finite = report.finite.and(finite.or(*done));
    if !report.finite.any() {
        return Next::Nothing;
    }
    for i in 0..B {
        scratch.change[i] = next[i] - w[i];
    }
    let linear = linear_enough(model, settings, &timing, near, &next, scratch);
    let enough = if linear.all() { linear } else { linear.or(small(&scratch.change, &next, settings.tolerance)) };
    let settled = enough.and(solved).and(finite).and(done.not());
    report.converged = report.converged.or(settled);
    if settled.any() && !settled.or(*done).all() {
        // These lanes are done, and keep their forces while others go on.
        end(settings, settled, state, scratch);
    }
    if settled.all() {
        *w = next;
        return Next::End;
    }
    let stopped = done.or(finite.not());
    let share = if iteration < DAMPED_AFTER { T::ONE } else { T::from_f64(0.5) };
    for i in 0..B {
        w[i] = T::select(settled, next[i], T::select(stopped, w[i], w[i] + share * scratch.change[i]));
    }
    if settled.or(stopped).all() {
        return Next::End;
    }
    *done = done.or(settled).or(finite.not());
    Next::Again
}

/// The velocities if they go on changing as they did: the first iterate. What stands still is expected to stick.
#[inline(always)]
fn extrapolate<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    w0: &[T; B],
    trend: &[T; B],
) -> [T; B] {
    let mut w = *w0;
    let trend = relative(model, trend);
    for i in 0..B {
        w[i] += T::only(settings.solver_tolerance.lt(w0[i].abs()), trend[i]);
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
    h: T,
    theta: T,
    scratch: &mut Scratch<T, B, Z, N>,
) -> [T; B] {
    for i in 0..B {
        scratch.joint_velocity[i] = ((T::ONE - theta) * w0[i]).add_product(theta, w[i]);
    }
    absolute(model, &scratch.joint_velocity, &mut scratch.velocity);
    let mut q = *q0;
    for i in 0..B {
        q[i] = q[i].add_product(theta * h, scratch.velocity[i]);
    }
    q
}

/// Whether velocities are numbers whose squares do not overflow: what the step's end works out from them then does not either.
#[inline(always)]
fn usable<T: Real, const B: usize>(w: &[T; B]) -> T::Mask {
    let mut sum = T::ZERO;
    for i in 0..B {
        sum = sum.add_product(w[i], w[i]);
    }
    sum.finite()
}

/// Whether all changes of the velocities are small against the tolerance.
#[inline(always)]
fn small<T: Real, const B: usize>(change: &[T; B], next: &[T; B], tolerance: T) -> T::Mask {
    let mut small = T::Mask::splat(true);
    for i in 0..B {
        small = small.and(change[i].abs().le(tolerance * (T::ONE + next[i].abs())));
    }
    small
}

/// q1 = q0 + h ((1 - theta) v0 + theta v1) in some lanes.
#[inline(always)]
fn finish<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    w: &[T; B],
    lanes: T::Mask,
    state: &mut State<T, B, Z>,
) {
    let (h, theta, mut v) = (settings.step, settings.theta, *w);
    absolute(model, w, &mut v);
    if lanes.all() {
        for i in 0..B {
            state.trend[i] = v[i] - state.velocity[i];
            let mean = state.velocity[i].add_product(theta, state.trend[i]);
            state.angle[i] = state.angle[i].add_product(h, mean);
            state.velocity[i] = v[i];
        }
        return;
    }
    let keep = |old: &mut T, new: T| *old = T::select(lanes, new, *old);
    for i in 0..B {
        let change = v[i] - state.velocity[i];
        let mean = state.velocity[i].add_product(theta, change);
        let angle = state.angle[i].add_product(h, mean);
        keep(&mut state.angle[i], angle);
        keep(&mut state.trend[i], change);
        keep(&mut state.velocity[i], v[i]);
    }
}

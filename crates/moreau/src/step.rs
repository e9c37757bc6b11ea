//! The inner step: one Moreau-Jean theta step. The equations stand in this crate's README, "The step".

use crate::contact::Timing;
use crate::forces::{joint_momentum, linearise, regularised_friction};
use crate::joints::{absolute, relative};
use crate::laws::{begin, end, keep_forces, one_step_problem};
use crate::model::Model;
use crate::settings::{FrictionLaw, Settings};
use crate::state::{Input, Scratch, State};
use crate::zones::{add_zones, linear_enough};
use crate::{Real, Scalar};

/// How a step ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The last Newton correction and the one-step problem met their tolerances.
    Converged,
    /// The iteration limit was reached; the last (finite) iterate was taken.
    IterationLimit,
    /// A number that is not finite arose (or came in with the input); the state was left as it was.
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
    let (h, theta) = (settings.step, settings.theta);
    let timing = Timing::new(h, theta);
    let (q0, w0) = (state.angle, relative(model, &state.velocity));
    // The remainder knows the felts' curvature, not a regularised friction law's, whose stiffness also makes trends alternate.
    let smooth = settings.friction == FrictionLaw::SetValued;
    let mut w = if smooth { extrapolate(model, &w0, &state.trend) } else { w0 };
    let mut report = StepReport { outcome: Outcome::IterationLimit, newton: 0, solver: 0 };
    begin(model, settings, state, &w0, &w, scratch);

    for iteration in 0..settings.newton_limit {
        let q_theta = theta_point(model, &q0, &w0, &w, h, theta, scratch);
        scratch.pose.place(model, &q_theta);
        if iteration == 0 {
            // The first iterate is a prediction, so this is the predicted pose q_* at which M and D are taken.
            joint_momentum(model, &state.velocity, scratch);
            state.survey.renew(model, &scratch.pose, &q_theta, &scratch.joint_velocity, &timing);
        }
        let near = state.survey.near();
        linearise(model, &timing, input, &w, &q_theta, scratch);
        add_zones(model, &timing, near, iteration > 0, &w, scratch);
        if let FrictionLaw::Regularised { pivot_width, sliding_width } = settings.friction {
            regularised_friction(model, &timing, near, [pivot_width, sliding_width], &w, scratch);
        }
        one_step_problem(model, settings, input, &w0, &w, scratch);
        let mut next = [T::ZERO; B];
        let solved = settings.solver.solve(settings, scratch, &mut next);
        keep_forces(settings, scratch);
        report.newton = iteration + 1;
        report.solver += solved.iterations;

        let (change, small, finite) = correction(&w, &next, settings.tolerance);
        if !finite {
            report.outcome = Outcome::NonFinite;
            return report;
        }
        scratch.change = change;
        let settled = linear_enough(model, settings, &timing, near, &change, &next, scratch) || small;
        if settled && solved.converged {
            w = next;
            report.outcome = Outcome::Converged;
            break;
        }
        let share = if iteration < DAMPED_AFTER { T::ONE } else { T::from_f64(0.5) };
        for i in 0..B {
            w[i] += share * change[i];
        }
    }

    if !finish(model, input, &w0, &w, h, theta, state, scratch) {
        report.outcome = Outcome::NonFinite;
    }
    report
}

/// The velocities if they go on changing as they did: the first iterate. What sticks is expected to stick.
#[inline(always)]
fn extrapolate<T: Scalar, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    w0: &[T; B],
    trend: &[T; B],
) -> [T; B] {
    let mut w = *w0;
    let trend = relative(model, trend);
    for i in 0..B {
        w[i] += T::select(T::ZERO.lt(w0[i].abs()), trend[i], T::ZERO);
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
        scratch.joint_velocity[i] = (T::ONE - theta) * w0[i] + theta * w[i];
    }
    scratch.velocity = absolute(model, &scratch.joint_velocity);
    let mut q = *q0;
    for i in 0..B {
        q[i] += theta * h * scratch.velocity[i];
    }
    q
}

/// The change of the joints' velocities, whether all are small against the tolerance, and whether all are finite.
#[inline(always)]
fn correction<T: Scalar, const B: usize>(w: &[T; B], next: &[T; B], tolerance: T) -> ([T; B], bool, bool) {
    let (mut change, mut small, mut sum) = (*next, true, T::ZERO);
    for i in 0..B {
        change[i] -= w[i];
        small &= change[i].abs() <= tolerance * (T::ONE + next[i].abs());
        // Zero times what is not finite is not a number.
        sum += T::ZERO * next[i];
    }
    (change, small, sum == T::ZERO)
}

/// q1 = q0 + h ((1 - theta) v0 + theta v1); leaves the slips and the drive's speed to be read. False if not finite.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn finish<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    input: &Input<T>,
    w0: &[T; B],
    w: &[T; B],
    h: T,
    theta: T,
    state: &mut State<T, B, Z>,
    scratch: &mut Scratch<T, B, Z, N>,
) -> bool {
    let q0 = state.angle;
    theta_point(model, &q0, w0, w, h, theta, scratch);
    let (mut q, mut sum) = (q0, T::ZERO);
    for i in 0..B {
        q[i] += h * scratch.velocity[i];
        sum += T::ZERO * q[i];
    }
    if sum != T::ZERO {
        return false;
    }
    state.angle = q;
    let v = absolute(model, w);
    for i in 0..B {
        state.trend[i] = v[i] - state.velocity[i];
    }
    state.velocity = v;
    end(model, state, scratch);
    let driven = !matches!(input, Input::Free);
    scratch.drive_velocity =
        if driven { model.site_path.product(&scratch.site_row, &scratch.joint_velocity) } else { T::ZERO };
    for &z in &model.sliding_zones[..model.sliding_count] {
        if scratch.has_slip_row[z] {
            let (row, path) = (&scratch.slip_row[z], &model.paths[z]);
            scratch.slip[z] = [path.product(row, w0), path.product(row, w)];
        }
    }
    true
}

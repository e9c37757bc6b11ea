//! One Moreau-Jean theta step of rigid bodies. The equations stand in this crate's README, "Rigid contacts and joints".

use super::forces::regular_impulse;
use super::mixed::{Law, Mode, Solved};
use super::model::Model;
use super::projection::close_joints;
use super::rows::{contact_rows, joint_rows};
use super::state::{Placement, Scratch, Settings, State, Twist};
use crate::Scalar;

/// How a step ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Velocities, laws and joints met their tolerances.
    Converged,
    /// The same, but a contact that slipped at the start of the step stayed closed although Coulomb's law lets no finite force
    /// keep it so (Painleve): an impulse that does not shrink with h did. Other solutions may exist.
    Painleve,
    /// An iteration limit was reached; the last (finite) iterate was taken.
    IterationLimit,
    /// The one-step problem has no solution: all guesses were tried. The state was left as it was.
    NoSolution,
    /// A number that is not finite arose; the state was left as it was.
    NonFinite,
    /// The state has no room for the model's bodies or laws; it was left as it was.
    NoRoom,
}

/// What a step did: its outcome and its work.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepReport {
    /// How it ended.
    pub outcome: Outcome,
    /// Iterations on forces and rows.
    pub iterations: u32,
    /// Guesses in the one-step problems, summed.
    pub guesses: u32,
}

/// Advances `state` by one step h. Never allocates, never panics, takes a bounded number of iterations.
///
/// `loads` are forces (N) and moments about the centre of mass (N m) on the bodies at t0 + theta h; missing ones are zero.
pub fn step<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    settings: &Settings<T>,
    loads: &[[T; 3]],
    state: &mut State<T, B, N>,
    scratch: &mut Scratch<T, B, N>,
) -> StepReport {
    let mut report = StepReport { outcome: Outcome::IterationLimit, iterations: 0, guesses: 0 };
    if model.bodies.len() > B || model.laws() > N {
        report.outcome = Outcome::NoRoom;
        return report;
    }
    let (h, theta) = (settings.step, settings.theta);
    let (q0, v0) = (state.placement, state.velocity);
    let (mut mode, mut p) = (state.mode, state.impulse);
    let mut v = v0;
    let tolerance = settings.solver_tolerance * (T::ONE + largest(&v0));
    let mut slip = [T::ZERO; N];

    for iteration in 0..settings.iteration_limit {
        let v_theta = blend(&v0, &v, theta);
        let q_theta = moved(&q0, &v_theta, theta * h);
        let mut q1 = moved(&q0, &v_theta, h);
        close_joints(model, &mut q1, settings.position_tolerance);
        if iteration == 0 {
            // Which contacts are closed is decided once, at the predicted pose.
            laws(model, settings, &q0, &q_theta, &v0, tolerance, &mut slip, scratch);
        }
        place_rows(model, &q_theta, &q1, scratch);
        let free = regular_impulse(model, h, loads, &v0, &q_theta, &v_theta);
        one_step_problem(model, &v0, &free, scratch);
        let solved = loop {
            let (solved, guesses) = scratch.problem.solve(&mut mode, &mut p, tolerance, settings.solver_limit);
            report.guesses += guesses;
            if solved != Solved::Yes || !let_go(model, &mode, scratch) {
                break solved;
            }
        };
        report.iterations = iteration + 1;
        if solved == Solved::None {
            report.outcome = Outcome::NoSolution;
            return report;
        }
        let mut next = free;
        for i in 0..scratch.problem.count {
            scratch.rows[i].push(model, p[i], &mut next);
        }
        let (change, finite) = correction(&v, &next);
        if !finite {
            report.outcome = Outcome::NonFinite;
            return report;
        }
        v = next;
        if change <= settings.tolerance && solved == Solved::Yes {
            report.outcome = Outcome::Converged;
            break;
        }
    }

    let mut q1 = moved(&q0, &blend(&v0, &v, theta), h);
    let closed = close_joints(model, &mut q1, settings.position_tolerance);
    if !q1.iter().all(|q| q.at[0].finite() && q.at[1].finite() && q.angle.finite()) {
        report.outcome = Outcome::NonFinite;
        return report;
    }
    if report.outcome == Outcome::Converged {
        if !closed {
            report.outcome = Outcome::IterationLimit;
        } else if jammed(model, &slip, &mode, &p, tolerance, scratch) {
            report.outcome = Outcome::Painleve;
        }
    }
    *state = State { placement: q1, velocity: v, impulse: p, mode };
    report
}

fn largest<T: Scalar>(v: &[Twist<T>]) -> T {
    v.iter().flatten().fold(T::ZERO, |most, x| most.max(x.abs()))
}

/// (1 - theta) v0 + theta v1.
fn blend<T: Scalar, const B: usize>(v0: &[Twist<T>; B], v1: &[Twist<T>; B], theta: T) -> [Twist<T>; B] {
    core::array::from_fn(|i| core::array::from_fn(|k| (T::ONE - theta) * v0[i][k] + theta * v1[i][k]))
}

/// q + t v.
fn moved<T: Scalar, const B: usize>(q: &[Placement<T>; B], v: &[Twist<T>; B], t: T) -> [Placement<T>; B] {
    core::array::from_fn(|i| Placement {
        at: [q[i].at[0] + t * v[i][0], q[i].at[1] + t * v[i][1]],
        angle: q[i].angle + t * v[i][2],
    })
}

/// The laws in force in this step, with the restitution of contacts and what friction may bear; leaves the slips at its start.
#[allow(clippy::too_many_arguments)]
fn laws<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    settings: &Settings<T>,
    q0: &[Placement<T>; B],
    q_theta: &[Placement<T>; B],
    v0: &[Twist<T>; B],
    tolerance: T,
    slip: &mut [T; N],
    scratch: &mut Scratch<T, B, N>,
) {
    let problem = &mut scratch.problem;
    problem.count = model.laws();
    problem.law = [Law::Absent; N];
    for (j, joint) in model.joints.iter().enumerate() {
        problem.law[3 * j] = Law::Equality;
        problem.law[3 * j + 1] = Law::Equality;
        if joint.rate.is_some() {
            problem.law[3 * j + 2] = Law::Equality;
        } else if T::ZERO < joint.dry {
            problem.law[3 * j + 2] = Law::Relay(settings.step * joint.dry);
        }
    }
    // What stuck has a slip of zero but for the tolerances.
    let stuck = tolerance * T::from_f64(1e3);
    for (c, contact) in model.contacts.iter().enumerate() {
        let [n, t] = model.contact_laws(c);
        if contact_rows(contact, q_theta).distance <= settings.contact_tolerance {
            problem.law[n] = Law::Unilateral;
            slip[t] = contact_rows(contact, q0).tangential.velocity(v0) - contact.belt;
            let holds = slip[t].abs() <= stuck;
            let mu = if holds { contact.limit } else { contact.kinetic };
            if T::ZERO < mu {
                problem.law[t] = Law::Coulomb(n, mu);
            }
        }
    }
}

/// The rows of all laws at the theta point and at the step's end.
fn place_rows<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    q_theta: &[Placement<T>; B],
    q1: &[Placement<T>; B],
    scratch: &mut Scratch<T, B, N>,
) {
    for (rows, q) in [(&mut scratch.rows, q_theta), (&mut scratch.end_rows, q1)] {
        for (j, joint) in model.joints.iter().enumerate() {
            let at = joint_rows(joint, q);
            [rows[3 * j], rows[3 * j + 1]] = at.closed;
            rows[3 * j + 2] = at.free;
        }
        for (c, contact) in model.contacts.iter().enumerate() {
            let at = contact_rows(contact, q);
            let [n, t] = model.contact_laws(c);
            rows[n] = at.normal;
            rows[t] = at.tangential;
        }
    }
}

/// W and u_free: impulses act along the rows at the theta point, the laws speak of the velocities of the rows at the step's end. W is
/// therefore symmetric up to order h only; but redundant joints stay consistent, since what they ask for is asked at one pose.
fn one_step_problem<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    v0: &[Twist<T>; B],
    free: &[Twist<T>; B],
    scratch: &mut Scratch<T, B, N>,
) {
    let (rows, end_rows, problem) = (&scratch.rows, &scratch.end_rows, &mut scratch.problem);
    for i in 0..problem.count {
        if problem.law[i] == Law::Absent {
            continue;
        }
        problem.free[i] = end_rows[i].velocity(free);
        for j in 0..problem.count {
            let absent = problem.law[j] == Law::Absent;
            problem.delassus[i][j] = if absent { T::ZERO } else { end_rows[i].coupling(&rows[j], model) };
        }
    }
    for (j, joint) in model.joints.iter().enumerate() {
        if let Some(rate) = joint.rate {
            problem.free[3 * j + 2] -= rate;
        }
    }
    for (c, contact) in model.contacts.iter().enumerate() {
        let [n, t] = model.contact_laws(c);
        let approach = (-rows[n].velocity(v0)).max(T::ZERO);
        problem.free[n] -= contact.restitution * approach;
        problem.free[t] -= contact.belt;
    }
}

/// What stuck up to its static limit and now slips has kinetic friction; says whether there was such a contact.
fn let_go<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    mode: &[Mode; N],
    scratch: &mut Scratch<T, B, N>,
) -> bool {
    let mut any = false;
    for (c, contact) in model.contacts.iter().enumerate() {
        let [n, t] = model.contact_laws(c);
        if let Law::Coulomb(_, mu) = scratch.problem.law[t] {
            let slips = matches!(mode[t], Mode::Upper | Mode::Lower) && mode[n] == Mode::Hold;
            if slips && contact.kinetic < mu {
                scratch.problem.law[t] = Law::Coulomb(n, contact.kinetic);
                any = true;
            }
        }
    }
    any
}

/// The largest change relative to 1 + |velocity|, and whether all are finite.
fn correction<T: Scalar, const B: usize>(v: &[Twist<T>; B], next: &[Twist<T>; B]) -> (T, bool) {
    let (mut change, mut finite) = (T::ZERO, true);
    for (a, b) in v.iter().flatten().zip(next.iter().flatten()) {
        change = change.max((*b - *a).abs() / (T::ONE + b.abs()));
        finite &= b.finite();
    }
    (change, finite)
}

/// Whether a contact that slipped when the step began was kept closed where no finite force can do that.
fn jammed<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    slip: &[T; N],
    mode: &[Mode; N],
    p: &[T; N],
    tolerance: T,
    scratch: &Scratch<T, B, N>,
) -> bool {
    (0..model.contacts.len()).any(|c| {
        let [n, t] = model.contact_laws(c);
        match scratch.problem.law[t] {
            Law::Coulomb(_, mu) if slip[t].abs() > tolerance * T::from_f64(1e3) && p[n] > T::ZERO => {
                let factor = if slip[t] > T::ZERO { -mu } else { mu };
                let mobility = scratch.problem.slipping_mobility(n, t, factor, mode, tolerance);
                mobility <= T::ZERO
            }
            _ => false,
        }
    })
}

//! One Moreau-Jean theta step of rigid bodies. The equations are in this crate's README, "Rigid contacts and joints".

use super::forces::regular_impulse;
use super::impact::collide;
use super::laws::{contact_laws, friction_laws, joint_laws, let_go, one_step_problem, place_rows, start_velocities};
use super::mixed::{Law, Limits, Solved, SolvedBy};
use super::model::Model;
use super::painleve::jammed;
use super::placement::{Placement, Twist};
use super::projection::close_joints;
use super::state::{ImpactLaw, Settings, State};
use super::touch::touches;
use super::workspace::Workspace;
use moreau::Scalar;

/// Iterations after which impulses that are only nearly right are iterated upon no more.
const NEARLY: u32 = 4;

/// Outcome of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepOutcome {
    /// Velocities, laws and joints met their tolerances.
    Converged,
    /// As `Converged`, but Coulomb's law admits no finite force that keeps a slipping contact closed (Painleve). The
    /// contact slipped at the step's start, had not just closed, and was kept closed by an impulse that does not shrink
    /// with h. Other solutions may exist.
    Painleve,
    /// The sweeps ended before they met the tolerance. The impulses are admissible (no contact pulls, no friction
    /// exceeds its cone), but some velocity violates its law by the report's residual.
    Approximate,
    /// An iteration limit was reached; the state is the last (finite) iterate.
    IterationLimit,
    /// The one-step problem has no solution: all guesses were tried. The state was not changed.
    NoSolution,
    /// A number became infinite or NaN. The state was not changed.
    NonFinite,
    /// The state has too little room for the model's bodies or laws. It was not changed.
    NoRoom,
}

/// Report of a step: its outcome and its work.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StepReport<T> {
    /// Outcome of the step.
    pub outcome: StepOutcome,
    /// Number of iterations on forces and rows.
    pub iterations: u32,
    /// Guesses in the one-step problems, summed.
    pub guesses: u32,
    /// Sweeps in the one-step problems, summed.
    pub sweeps: u32,
    /// Solver of the last one-step problem.
    pub solver: SolvedBy,
    /// Largest violation of a law by the impulses, m/s or rad/s.
    pub residual: T,
    /// Work of the contact impulses in a step in which a contact closed, J, relative to the velocities of the surfaces;
    /// else zero. Negative: the impact lost energy. Positive: it created energy, which Newton's law does not exclude.
    pub impact_energy: T,
    /// Number of increments in which Stronge's law integrated an impact.
    pub impact_increments: u32,
    /// Whether Stronge's law completed the impact; if not, the rest was solved without restitution.
    pub impact_ended: bool,
}

/// Advances `state` by one step h. Never allocates and never panics; the number of iterations is bounded.
///
/// `loads`: forces (N) and moments about the centre of mass (N m) on the bodies at t0 + theta h. Missing ones are zero.
pub fn step<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    settings: &Settings<T>,
    loads: &[[T; 3]],
    state: &mut State<T, B, N>,
    workspace: &mut Workspace<T, B, N>,
) -> StepReport<T> {
    let mut report = StepReport {
        outcome: StepOutcome::IterationLimit,
        iterations: 0,
        guesses: 0,
        sweeps: 0,
        solver: SolvedBy::Guesses,
        residual: T::ZERO,
        impact_energy: T::ZERO,
        impact_increments: 0,
        impact_ended: true,
    };
    if model.bodies.len() > B || model.laws() > N {
        report.outcome = StepOutcome::NoRoom;
        return report;
    }
    let (h, theta) = (settings.step, settings.theta);
    let (q0, v0) = (state.placement, state.velocity);
    let (mut mode, mut p) = (state.mode, state.impulse);
    let mut v = v0;
    // Velocities from which the regular part of the step begins: v0, or those after an impact.
    let mut start = v0;
    let mut struck = [T::ZERO; N];
    let tolerance = settings.solver_tolerance * (T::ONE + largest(&v0));
    // What stuck, or did not close, has a velocity of zero but for the tolerances.
    let still = tolerance * T::from_f64(1e3);
    let limits = Limits { tolerance, guesses: settings.solver_limit, sweeps: settings.sweep_limit };
    let (mut slip, mut closing) = ([T::ZERO; N], [T::ZERO; N]);

    for iteration in 0..settings.iteration_limit {
        let v_theta = blend(&v0, &v, theta);
        let q_theta = moved(&q0, &v_theta, theta * h);
        let mut q1 = moved(&q0, &v_theta, h);
        close_joints(model, &mut q1, settings.position_tolerance, true);
        if iteration == 0 {
            // What touches what, and which contacts are closed, is decided once, at the predicted pose.
            touches(model, &q_theta, settings.contact_tolerance, &mut workspace.touch);
            joint_laws(model, settings, workspace);
            contact_laws(model, settings, &q_theta, workspace);
            start_velocities(model, &q0, &v0, workspace, &mut slip, &mut closing);
            let bounces = (0..model.points()).any(|c| {
                workspace.problem.law[model.contact_laws(c)[0]] != Law::Absent && T::ZERO < model.matter(c).restitution
            });
            if settings.impact_law == ImpactLaw::Stronge && bounces && closing.iter().any(|u| *u > still) {
                friction_laws(model, &slip, still, workspace);
                place_rows(model, &q0, &mut workspace.rows, &workspace.touch);
                let impact = collide(model, still, &mut start, &mut struck, workspace);
                report.impact_energy = impact.energy;
                report.impact_increments = impact.increments;
                report.impact_ended = impact.ended;
                let mut after = [T::ZERO; N];
                start_velocities(model, &q0, &start, workspace, &mut slip, &mut after);
            }
            friction_laws(model, &slip, still, workspace);
        }
        place_rows(model, &q_theta, &mut workspace.rows, &workspace.touch);
        place_rows(model, &q1, &mut workspace.end_rows, &workspace.touch);
        let mut free = regular_impulse(model, h, loads, &start, &q_theta, &v_theta);
        workspace.implicit.renew(model, h, theta, &q_theta, &v_theta);
        if workspace.implicit.present {
            // Newton's method: A (v1 - v) = M (free - v) + D p.
            let mut by: [Twist<T>; B] = core::array::from_fn(|i| core::array::from_fn(|k| free[i][k] - v[i][k]));
            momenta(model, &mut by);
            workspace.implicit.solve(model.bodies.len(), &mut by);
            for (free, (v, by)) in free.iter_mut().zip(v.iter().zip(&by)) {
                *free = core::array::from_fn(|k| v[k] + by[k]);
            }
        }
        one_step_problem(model, settings.impact_law, &v0, &free, workspace);
        let solution = loop {
            let Workspace { problem, reduced, .. } = &mut *workspace;
            let solution = problem.solve(&mut mode, &mut p, &limits, reduced);
            report.guesses += solution.guesses;
            report.sweeps += solution.sweeps;
            if solution.solved != Solved::Yes || !let_go(model, &mode, workspace) {
                break solution;
            }
        };
        (report.solver, report.residual) = (solution.by, solution.residual);
        report.iterations = iteration + 1;
        if solution.solved == Solved::None {
            report.outcome = StepOutcome::NoSolution;
            return report;
        }
        let mut next = free;
        push_all(model, &p, workspace, &mut next);
        let (change, finite) = correction(&v, &next);
        if !finite {
            report.outcome = StepOutcome::NonFinite;
            return report;
        }
        v = next;
        if solution.solved == Solved::Yes {
            if change <= settings.tolerance {
                report.outcome = StepOutcome::Converged;
                break;
            }
        } else if change <= settings.tolerance.max(solution.residual) || report.iterations >= NEARLY {
            report.outcome = StepOutcome::Approximate;
            break;
        }
    }

    let mut q1 = moved(&q0, &blend(&v0, &v, theta), h);
    let closed = close_joints(model, &mut q1, settings.position_tolerance, true);
    if !q1.iter().all(|q| q.at[0].finite() && q.at[1].finite() && q.angle.finite()) {
        report.outcome = StepOutcome::NonFinite;
        return report;
    }
    if !closed {
        report.outcome = StepOutcome::IterationLimit;
    } else if report.outcome == StepOutcome::Converged
        && jammed(model, &slip, &closing, &mode, &p, still, tolerance, &workspace.problem)
    {
        report.outcome = StepOutcome::Painleve;
    }
    if settings.impact_law == ImpactLaw::Newton && closing.iter().any(|u| *u > still) {
        report.impact_energy = contact_work(model, &v0, &v, &p, workspace);
    }
    for (p, struck) in p.iter_mut().zip(&struck) {
        *p += *struck;
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

/// Momenta of velocities.
fn momenta<T: Scalar, const B: usize>(model: &Model<'_, T>, v: &mut [Twist<T>; B]) {
    for (v, body) in v.iter_mut().zip(model.bodies) {
        for (x, m) in v.iter_mut().zip([body.mass, body.mass, body.inertia]) {
            *x = *x * m;
        }
    }
}

/// Adds what the laws' impulses change to velocities.
fn push_all<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    p: &[T; N],
    workspace: &Workspace<T, B, N>,
    v: &mut [Twist<T>; B],
) {
    if workspace.implicit.present {
        let mut by = [[T::ZERO; 3]; B];
        for i in 0..workspace.problem.count {
            workspace.rows[i].add(p[i], &mut by);
        }
        workspace.implicit.solve(model.bodies.len(), &mut by);
        for (v, by) in v.iter_mut().flatten().zip(by.iter().flatten()) {
            *v += *by;
        }
    } else {
        for i in 0..workspace.problem.count {
            workspace.rows[i].push(model, p[i], v);
        }
    }
}

/// Work of the contacts' impulses over the step, against the velocities of the surfaces.
fn contact_work<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    v0: &[Twist<T>; B],
    v1: &[Twist<T>; B],
    p: &[T; N],
    workspace: &Workspace<T, B, N>,
) -> T {
    let mut work = T::ZERO;
    for c in 0..model.points() {
        let [n, t] = model.contact_laws(c);
        if workspace.problem.law[n] != Law::Absent {
            for (i, belt) in [(n, T::ZERO), (t, model.matter(c).belt)] {
                let row = &workspace.rows[i];
                work += p[i] * (T::from_f64(0.5) * (row.velocity(v0) + row.velocity(v1)) - belt);
            }
        }
    }
    work
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

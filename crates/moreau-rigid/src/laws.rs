//! The laws of a step and their problem: which are in force, their rows, W and u_free.

use super::mixed::{Law, Mode};
use super::model::{JointKind, Model};
use super::placement::{Placement, Twist};
use super::rows::{Row, joint_rows};
use super::state::{ImpactLaw, Settings};
use super::touch::Touch;
use super::workspace::Workspace;
use moreau::Scalar;

/// The joints' laws in this step.
pub(super) fn joint_laws<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    settings: &Settings<T>,
    workspace: &mut Workspace<T, B, N>,
) {
    let problem = &mut workspace.problem;
    problem.count = model.laws();
    problem.law = [Law::Absent; N];
    for (j, joint) in model.joints.iter().enumerate() {
        problem.law[3 * j] = Law::Equality;
        if !matches!(joint.kind, JointKind::Slot { .. }) {
            problem.law[3 * j + 1] = Law::Equality;
        }
        if joint.rate.is_some() {
            problem.law[3 * j + 2] = Law::Equality;
        } else if T::ZERO < joint.dry {
            problem.law[3 * j + 2] = Law::Relay(settings.step * joint.dry);
        }
    }
}

/// Which contacts are closed at these placements.
pub(super) fn contact_laws<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    settings: &Settings<T>,
    q_theta: &[Placement<T>; B],
    workspace: &mut Workspace<T, B, N>,
) {
    for c in 0..model.points() {
        if workspace.touch[c].rows(q_theta).distance <= settings.contact_tolerance {
            workspace.problem.law[model.contact_laws(c)[0]] = Law::Unilateral;
        }
    }
}

/// Of the closed contacts at the start of the step: slips (at the tangential laws) and speeds of closing (at the normal
/// ones).
pub(super) fn start_velocities<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    q0: &[Placement<T>; B],
    v: &[Twist<T>; B],
    workspace: &Workspace<T, B, N>,
    slip: &mut [T; N],
    closing: &mut [T; N],
) {
    for c in 0..model.points() {
        let [n, t] = model.contact_laws(c);
        if workspace.problem.law[n] != Law::Absent {
            let rows = workspace.touch[c].rows(q0);
            slip[t] = rows.tangential.velocity(v) - model.matter(c).belt;
            closing[n] = -rows.normal.velocity(v);
        }
    }
}

/// Friction of the closed contacts: up to the limit for what sticks.
pub(super) fn friction_laws<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    slip: &[T; N],
    still: T,
    workspace: &mut Workspace<T, B, N>,
) {
    for c in 0..model.points() {
        let [n, t] = model.contact_laws(c);
        if workspace.problem.law[n] != Law::Absent {
            let matter = model.matter(c);
            let mu = if slip[t].abs() <= still { matter.limit } else { matter.kinetic };
            workspace.problem.law[t] = if T::ZERO < mu { Law::Coulomb(n, mu) } else { Law::Absent };
        }
    }
}

/// The rows of all laws at these placements.
pub(super) fn place_rows<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    q: &[Placement<T>; B],
    rows: &mut [Row<T>; N],
    touch: &[Touch<T>; N],
) {
    for (j, joint) in model.joints.iter().enumerate() {
        let at = joint_rows(joint, q);
        [rows[3 * j], rows[3 * j + 1]] = at.closed;
        rows[3 * j + 2] = at.free;
    }
    for c in 0..model.points() {
        let at = touch[c].rows(q);
        let [n, t] = model.contact_laws(c);
        rows[n] = at.normal;
        rows[t] = at.tangential;
    }
}

/// W and u_free: impulses act along the rows at the theta point, the laws speak of the velocities of the rows at the
/// step's end. W is therefore symmetric up to order h only; but redundant joints stay consistent, since what they ask
/// for is asked at one pose.
pub(super) fn one_step_problem<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    impact_law: ImpactLaw,
    v0: &[Twist<T>; B],
    free: &[Twist<T>; B],
    workspace: &mut Workspace<T, B, N>,
) {
    let Workspace { rows, end_rows, problem, implicit, .. } = workspace;
    for i in 0..problem.count {
        if problem.law[i] != Law::Absent {
            problem.free[i] = end_rows[i].velocity(free);
        }
    }
    for j in 0..problem.count {
        let absent = problem.law[j] == Law::Absent;
        let mut column = [[T::ZERO; 3]; B];
        if implicit.present && !absent {
            rows[j].add(T::ONE, &mut column);
            implicit.solve(model.bodies.len(), &mut column);
        }
        for i in 0..problem.count {
            if problem.law[i] != Law::Absent {
                problem.delassus[i][j] = if absent {
                    T::ZERO
                } else if implicit.present {
                    end_rows[i].velocity(&column)
                } else {
                    end_rows[i].coupling(&rows[j], model)
                };
            }
        }
    }
    for (j, joint) in model.joints.iter().enumerate() {
        if let Some(rate) = joint.rate {
            problem.free[3 * j + 2] -= rate;
        }
    }
    for c in 0..model.points() {
        let [n, t] = model.contact_laws(c);
        let matter = model.matter(c);
        if impact_law == ImpactLaw::Newton {
            let approach = (-rows[n].velocity(v0)).max(T::ZERO);
            problem.free[n] -= matter.restitution * approach;
        }
        problem.free[t] -= matter.belt;
    }
}

/// What stuck up to its static limit and now slips has kinetic friction; says whether there was such a contact.
pub(super) fn let_go<T: Scalar, const B: usize, const N: usize>(
    model: &Model<'_, T>,
    mode: &[Mode; N],
    workspace: &mut Workspace<T, B, N>,
) -> bool {
    let mut any = false;
    for c in 0..model.points() {
        let [n, t] = model.contact_laws(c);
        let contact = model.matter(c);
        if let Law::Coulomb(_, mu) = workspace.problem.law[t] {
            let slips = matches!(mode[t], Mode::Upper | Mode::Lower) && mode[n] == Mode::Hold;
            if slips && contact.kinetic < mu {
                workspace.problem.law[t] = Law::Coulomb(n, contact.kinetic);
                any = true;
            }
        }
    }
    any
}

//! The inner step: one Moreau-Jean theta step. The equations stand in this crate's README, "The step".

use crate::contact::Contact;
use crate::linear::product;
use crate::model::Model;
use crate::settings::{FrictionLaw, Settings};
use crate::state::{Input, Scratch, State};
use crate::vector::{cross, dot};
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

/// What a sliding law of the one-step problem stands for.
#[derive(Debug, Clone, Copy)]
enum Law {
    Zone(usize),
    Rigid,
}

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
    let (q0, v0) = (state.angle, state.velocity);
    let mut v = v0;
    let mut report = StepReport { outcome: Outcome::IterationLimit, newton: 0, solver: 0 };
    let mut laws = [Law::Rigid; N];
    scratch.has_slip_row = [false; Z];
    scratch.pivot_friction = state.pivot_friction;
    scratch.tangential = state.tangential;
    scratch.rigid_force = state.rigid_force;

    for iteration in 0..settings.newton_limit {
        let (q_theta, v_theta) = theta_point(&q0, &v0, &v, h, theta);
        scratch.velocity = v_theta;
        scratch.pose.place(model, &q_theta);
        scratch.pose.move_pivots(model, &v_theta);
        if iteration == 0 {
            // The first iterate is v = v0, so this is the predicted pose q_* at which M and D are taken.
            mass_matrix(model, scratch);
            site_row(model, scratch);
        }
        evaluate_contacts(model, settings, &v_theta, iteration > 0, scratch);
        let (a, residual) = linearise(model, settings, input, &v, &v0, &q_theta, scratch);
        one_step_problem(model, settings, input, &v, a, residual, scratch, &mut laws);
        let (tolerance, limit) = (settings.solver_tolerance, settings.solver_limit);
        let (relative, solved) = settings.solver.solve(&scratch.system, &mut scratch.impulses, tolerance, limit);
        report.solver += solved.iterations;
        let next = absolute(model, &relative);
        keep_forces(h, scratch, &laws);

        let mut correction = T::ZERO;
        let mut finite = true;
        for i in 0..B {
            correction = correction.max((next[i] - v[i]).abs() / (T::ONE + next[i].abs()));
            finite &= next[i].finite();
        }
        report.newton = iteration + 1;
        if !finite {
            report.outcome = Outcome::NonFinite;
            return report;
        }
        let damping = if iteration < DAMPED_AFTER { T::ONE } else { T::from_f64(0.5) };
        for i in 0..B {
            let full = next[i] - v[i];
            v[i] = if correction <= settings.tolerance { next[i] } else { v[i] + damping * full };
        }
        if correction <= settings.tolerance && solved.converged {
            report.outcome = Outcome::Converged;
            break;
        }
    }

    if !finish(model, input, &q0, &v0, &v, h, theta, state, scratch) {
        report.outcome = Outcome::NonFinite;
    }
    report
}

/// q and v at t0 + theta h: v_theta = (1 - theta) v0 + theta v1, q_theta = q0 + theta h v_theta.
#[inline(always)]
fn theta_point<T: Real, const B: usize>(q0: &[T; B], v0: &[T; B], v: &[T; B], h: T, theta: T) -> ([T; B], [T; B]) {
    let (mut q, mut w) = (*q0, *v0);
    for i in 0..B {
        w[i] = (T::ONE - theta) * v0[i] + theta * v[i];
        q[i] = q0[i] + theta * h * w[i];
    }
    (q, w)
}

/// M(q_*): constant diagonal, and for every body and ancestor (branch arm) . (first moment) (README, "Inertia").
#[inline(always)]
fn mass_matrix<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    scratch: &mut Scratch<T, B, Z, N>,
) {
    scratch.mass = [[T::ZERO; B]; B];
    for i in 0..B {
        scratch.mass[i][i] = model.inertia[i];
        let moment = scratch.pose.rotate(i, model.moment[i]);
        let mut branch = i;
        while model.parent[branch] < B {
            let ancestor = model.parent[branch];
            let coupling = dot(scratch.pose.arm[branch], moment);
            scratch.mass[i][ancestor] = coupling;
            scratch.mass[ancestor][i] = coupling;
            branch = ancestor;
        }
    }
}

/// The row that maps velocities to the site's speed along its direction, at q_*.
#[inline(always)]
fn site_row<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    scratch: &mut Scratch<T, B, Z, N>,
) {
    scratch.site_row = [T::ZERO; B];
    if let Some(site) = &model.site {
        let x = scratch.pose.point(site.body, site.point);
        let pose = &scratch.pose;
        pose.add_velocity_row(model, site.body, x, site.direction, T::ONE, &mut scratch.site_row);
    }
}

/// Geometry and felt of every zone during the step; slip rows of zones with friction once, where they first touch.
#[inline(always)]
fn evaluate_contacts<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    v_theta: &[T; B],
    again: bool,
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let Scratch { pose, contacts, slip_row, has_slip_row, .. } = scratch;
    for (z, zone) in model.zones[..model.zone_count].iter().enumerate() {
        let contact: &mut Contact<T, B> = &mut contacts[z];
        // Newton moves the pose by far less than a zone's reach; what was out of reach at the prediction stays so.
        if again && contact.out_of_reach {
            continue;
        }
        contact.evaluate(model, zone, pose, v_theta, settings.step, settings.theta);
        if contact.active && zone.friction.is_some() && !has_slip_row[z] {
            slip_row[z] = contact.slip_row(model, zone, pose);
            has_slip_row[z] = true;
        }
    }
}

/// A = M + h theta (-dQ/dv) + h^2 theta^2 (-dQ/dq), and the negative residual h Q - M (v - v0).
///
/// Terms of the gradient that could make A indefinite (gravity, centrifugal, geometric stiffness, an unloading felt) are
/// left out or clamped: they are of order h^2 and cost convergence speed, not accuracy.
#[inline(always)]
fn linearise<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &Input<T>,
    v: &[T; B],
    v0: &[T; B],
    q_theta: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) -> ([[T; B]; B], [T; B]) {
    let (h, theta) = (settings.step, settings.theta);
    let h_theta = h * theta;
    let mut a = scratch.mass;
    let mut force = [T::ZERO; B];
    let w = scratch.velocity;

    for i in 0..B {
        let moment = scratch.pose.rotate(i, model.moment[i]);
        force[i] -= model.gravity * moment[0];
        let mut branch = i;
        while model.parent[branch] < B {
            let ancestor = model.parent[branch];
            let c = cross(scratch.pose.arm[branch], moment);
            force[ancestor] += w[i] * w[i] * c;
            force[i] -= w[ancestor] * w[ancestor] * c;
            branch = ancestor;
        }
    }
    for i in 0..B {
        let parent = model.parent[i];
        let (mut angle, mut rate) = (q_theta[i], w[i]);
        if parent < B {
            angle -= q_theta[parent];
            rate -= w[parent];
        }
        let mut torque = model.spring_torque[i] - model.spring_stiffness[i] * angle - model.viscous[i] * rate;
        let mut tangent = h_theta * (model.viscous[i] + h_theta * model.spring_stiffness[i]);
        if let FrictionLaw::Regularised { pivot_width, .. } = settings.friction {
            let t = (rate / pivot_width).tanh();
            torque -= model.dry[i] * t;
            tangent += h_theta * model.dry[i] / pivot_width * (T::ONE - t * t);
        }
        force[i] += torque;
        a[i][i] += tangent;
        if parent < B {
            force[parent] -= torque;
            a[parent][parent] += tangent;
            a[i][parent] -= tangent;
            a[parent][i] -= tangent;
        }
    }
    for z in 0..model.zone_count {
        let contact = &scratch.contacts[z];
        if contact.active {
            add_term(&mut a, &mut force, &contact.row, contact.tangent, -contact.force);
            if let (FrictionLaw::Regularised { sliding_width, .. }, Some(mu)) =
                (settings.friction, model.zones[z].friction)
            {
                let row = &scratch.slip_row[z];
                let t = (product(row, &w) / sliding_width).tanh();
                let tangent = h_theta * mu * contact.force / sliding_width * (T::ONE - t * t);
                add_term(&mut a, &mut force, row, tangent, -mu * contact.force * t);
            }
        }
    }
    drive(model, input, h_theta, &mut a, &mut force, scratch);

    let mut residual = [T::ZERO; B];
    for i in 0..B {
        residual[i] = h * force[i];
        for j in 0..B {
            residual[i] -= scratch.mass[i][j] * (v[j] - v0[j]);
        }
    }
    (a, residual)
}

/// force += row f and A += tangent row row^T (lower triangle and its mirror).
#[inline(always)]
fn add_term<T: Real, const B: usize>(a: &mut [[T; B]; B], force: &mut [T; B], row: &[T; B], tangent: T, f: T) {
    for i in 0..B {
        force[i] += row[i] * f;
        let t = tangent * row[i];
        for j in 0..B {
            a[i][j] += t * row[j];
        }
    }
}

/// The driver's force at the site: given, or from its spring and damper, which only push.
#[inline(always)]
fn drive<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    input: &Input<T>,
    h_theta: T,
    a: &mut [[T; B]; B],
    force: &mut [T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) {
    scratch.drive_force = T::ZERO;
    let Some(site) = &model.site else { return };
    let (f, tangent) = match *input {
        Input::Free | Input::Rigid { .. } => return,
        Input::Force(f) => (f, T::ZERO),
        Input::Motion { position, velocity } => {
            let at = dot(site.direction, scratch.pose.point(site.body, site.point));
            let speed = product(&scratch.site_row, &scratch.velocity);
            let f = site.stiffness * (position - at) + site.damping * (velocity - speed);
            if f <= T::ZERO {
                return;
            }
            (f, h_theta * (site.damping + h_theta * site.stiffness))
        }
    };
    scratch.drive_force = f;
    add_term(a, force, &scratch.site_row, tangent, f);
}

/// The linearised step in relative velocities, with the laws in force and a warm start.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn one_step_problem<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &Input<T>,
    v: &[T; B],
    a: [[T; B]; B],
    residual: [T; B],
    scratch: &mut Scratch<T, B, Z, N>,
    laws: &mut [Law; N],
) {
    let h = settings.step;
    let Scratch { system, impulses, contacts, slip_row, site_row, pivot_friction, tangential, rigid_force, .. } =
        &mut *scratch;
    let mut b = residual;
    for i in 0..B {
        b[i] += product(&a[i], v);
    }
    system.a = a;
    system.b = row_in_joints(model, &b);
    for i in (0..B).rev() {
        let parent = model.parent[i];
        if parent < B {
            for j in 0..B {
                let t = system.a[i][j];
                system.a[parent][j] += t;
            }
            for j in 0..B {
                let t = system.a[j][i];
                system.a[j][parent] += t;
            }
        }
    }
    let set_valued = settings.friction == FrictionLaw::SetValued;
    for i in 0..B {
        system.pivot_bound[i] = if set_valued { h * model.dry[i] } else { T::ZERO };
        impulses.pivot[i] = h * pivot_friction[i];
    }
    let mut n = 0;
    if set_valued {
        for &z in &model.sliding_zones[..model.sliding_count] {
            let contact = &contacts[z];
            let Some(mu) = model.zones[z].friction else { continue };
            if !contact.active || contact.force <= T::ZERO || n >= N {
                continue;
            }
            laws[n] = Law::Zone(z);
            let law = &mut system.sliding[n];
            law.row = row_in_joints(model, &slip_row[z]);
            law.slope = row_in_joints(model, &contact.row);
            for s in &mut law.slope {
                *s = *s * (mu * contact.tangent);
            }
            law.bound = mu * (h * contact.force - contact.tangent * product(&contact.row, v));
            law.target = T::ZERO;
            law.rigid = false;
            impulses.sliding[n] = h * tangential[z];
            n += 1;
        }
    }
    if let (Input::Rigid { velocity }, true, true) = (input, model.site.is_some(), n < N) {
        laws[n] = Law::Rigid;
        let law = &mut system.sliding[n];
        law.row = row_in_joints(model, site_row);
        law.target = *velocity;
        law.rigid = true;
        impulses.sliding[n] = h * *rigid_force;
        n += 1;
    }
    system.count = n;
}

/// A row (or an impulse) in absolute velocities, taken to relative ones: a joint carries everything beyond it.
#[inline(always)]
fn row_in_joints<T: Real, const B: usize, const Z: usize>(model: &Model<T, B, Z>, row: &[T; B]) -> [T; B] {
    let mut out = *row;
    for i in (0..B).rev() {
        let parent = model.parent[i];
        if parent < B {
            let t = out[i];
            out[parent] += t;
        }
    }
    out
}

/// Absolute velocities from relative ones.
#[inline(always)]
fn absolute<T: Real, const B: usize, const Z: usize>(model: &Model<T, B, Z>, relative: &[T; B]) -> [T; B] {
    let mut v = *relative;
    for i in 0..B {
        let parent = model.parent[i];
        if parent < B {
            let t = v[parent];
            v[i] += t;
        }
    }
    v
}

/// Stores the laws' forces p/h: the next warm start, and what the run reports.
#[inline(always)]
fn keep_forces<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    h: T,
    scratch: &mut Scratch<T, B, Z, N>,
    laws: &[Law; N],
) {
    let inverse_h = T::ONE / h;
    for i in 0..B {
        scratch.pivot_friction[i] = scratch.impulses.pivot[i] * inverse_h;
    }
    scratch.tangential = [T::ZERO; Z];
    for k in 0..scratch.system.count {
        let f = scratch.impulses.sliding[k] * inverse_h;
        match laws[k] {
            Law::Zone(z) => scratch.tangential[z] = f,
            Law::Rigid => {
                scratch.rigid_force = f;
                scratch.drive_force = f;
            }
        }
    }
}

/// q1 = q0 + h ((1 - theta) v0 + theta v1); leaves the slips and the drive's speed to be read. False if not finite.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn finish<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    input: &Input<T>,
    q0: &[T; B],
    v0: &[T; B],
    v: &[T; B],
    h: T,
    theta: T,
    state: &mut State<T, B, Z>,
    scratch: &mut Scratch<T, B, Z, N>,
) -> bool {
    let (_, w) = theta_point(q0, v0, v, h, theta);
    let mut q = *q0;
    let mut finite = true;
    for i in 0..B {
        q[i] += h * w[i];
        finite &= q[i].finite();
    }
    if !finite {
        return false;
    }
    state.angle = q;
    state.velocity = *v;
    state.pivot_friction = scratch.pivot_friction;
    state.tangential = scratch.tangential;
    state.rigid_force = scratch.rigid_force;
    scratch.velocity = w;
    scratch.drive_velocity =
        if matches!(input, Input::Free) { T::ZERO } else { product(&scratch.site_row, &scratch.velocity) };
    for z in 0..model.zone_count {
        if scratch.has_slip_row[z] {
            scratch.slip[z] = [product(&scratch.slip_row[z], v0), product(&scratch.slip_row[z], v)];
        }
    }
    true
}

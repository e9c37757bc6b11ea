//! The regular part of a step: inertia and all forces that are functions of q, v and t, linearised.

use crate::joints::row_to_joints;
use crate::linear::product;
use crate::model::Model;
use crate::settings::{FrictionLaw, Settings};
use crate::state::{Input, Scratch};
use crate::vector::{cross, dot};
use crate::{Real, Scalar};

/// M(q_*) and M w0 in relative velocities, and the driven point's row, at the predicted pose.
///
/// In absolute velocities M has a constant diagonal and, for every body and ancestor, (branch arm) . (first moment) (README,
/// "Inertia").
#[inline(always)]
pub(crate) fn joint_momentum<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    w0: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let mut mass = [[T::ZERO; B]; B];
    for i in 0..B {
        mass[i][i] = model.inertia[i];
    }
    let hinged = &model.hinged[..model.hinged_count];
    for &i in hinged {
        let moment = scratch.pose.rotate(i, model.moment[i]);
        let mut branch = i;
        while model.parent[branch] < B {
            let ancestor = model.parent[branch];
            let coupling = dot(scratch.pose.arm[branch], moment);
            mass[i][ancestor] = coupling;
            mass[ancestor][i] = coupling;
            branch = ancestor;
        }
    }
    for &i in hinged.iter().rev() {
        let parent = model.parent[i];
        for j in 0..B {
            let t = mass[i][j];
            mass[parent][j] += t;
        }
        for j in 0..B {
            let t = mass[j][i];
            mass[j][parent] += t;
        }
    }
    for i in 0..B {
        scratch.momentum[i] = product(&mass[i], w0);
    }
    scratch.mass = mass;
    scratch.site_row = [T::ZERO; B];
    if let Some(site) = &model.site {
        let x = scratch.pose.point(site.body, site.point);
        scratch.site_row = scratch.pose.turning_row(&model.site_carried, x, site.direction);
    }
}

/// A w1 = b: the linearised step in relative velocities, without the set-valued laws.
///
/// A = M + h theta (-dQ/dw) + h^2 theta^2 (-dQ/dq), b = M w0 + h Q + (A - M) w. Terms of the gradient that could make A
/// indefinite (gravity, centrifugal, geometric stiffness, an unloading felt) are left out or clamped: they are of order h^2
/// and cost convergence speed, not accuracy.
#[inline(always)]
pub(crate) fn linearise<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &Input<T>,
    w: &[T; B],
    q_theta: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let h = settings.step;
    let h_theta = h * settings.theta;
    let weights = gravity_and_centrifugal(model, scratch);
    let driven = drive(model, input, h_theta, scratch);
    let a = &mut scratch.system.a;
    let b = &mut scratch.system.b;
    *a = scratch.mass;
    *b = scratch.momentum;
    for i in 0..B {
        b[i] += h * weights[i];
    }
    for i in 0..B {
        let parent = model.parent[i];
        let angle = if parent < B { q_theta[i] - q_theta[parent] } else { q_theta[i] };
        let rate = scratch.joint_velocity[i];
        let mut torque = model.spring_torque[i] - model.spring_stiffness[i] * angle - model.viscous[i] * rate;
        let mut tangent = h_theta * (model.viscous[i] + h_theta * model.spring_stiffness[i]);
        if let FrictionLaw::Regularised { pivot_width, .. } = settings.friction {
            let t = (rate / pivot_width).tanh();
            torque -= model.dry[i] * t;
            tangent += h_theta * model.dry[i] / pivot_width * (T::ONE - t * t);
            scratch.pivot_friction[i] = -model.dry[i] * t;
        }
        b[i] += h * torque + tangent * w[i];
        a[i][i] += tangent;
    }
    for z in 0..model.zone_count {
        let contact = &scratch.contacts[z];
        if contact.active {
            add_term(a, b, &contact.row, contact.tangent, -h * contact.force, w);
            if let (FrictionLaw::Regularised { sliding_width, .. }, Some(mu)) =
                (settings.friction, model.zones[z].friction)
            {
                let row = &scratch.slip_row[z];
                let t = (product(row, &scratch.joint_velocity) / sliding_width).tanh();
                let limit = mu * contact.force;
                let tangent = h_theta * limit / sliding_width * (T::ONE - t * t);
                scratch.tangential[z] = -limit * t;
                add_term(a, b, row, tangent, -h * limit * t, w);
            }
        }
    }
    if let Some((force, tangent)) = driven {
        scratch.drive_force = force;
        add_term(a, b, &scratch.site_row, tangent, h * force, w);
    }
}

/// Adds a force along a row (impulse p, tangent = -dp/d(row . w)): A += tangent row row^T, b += row (p + tangent row . w).
#[inline(always)]
fn add_term<T: Real, const B: usize>(a: &mut [[T; B]; B], b: &mut [T; B], row: &[T; B], tangent: T, p: T, w: &[T; B]) {
    let total = p + tangent * product(row, w);
    for i in 0..B {
        b[i] += row[i] * total;
        let t = tangent * row[i];
        for j in 0..B {
            a[i][j] += t * row[j];
        }
    }
}

/// Weight and centrifugal forces on the joints.
#[inline(always)]
fn gravity_and_centrifugal<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    scratch: &Scratch<T, B, Z, N>,
) -> [T; B] {
    let v = &scratch.velocity;
    let mut force = [T::ZERO; B];
    for i in 0..B {
        let moment = scratch.pose.rotate(i, model.moment[i]);
        force[i] -= model.gravity * moment[0];
        let mut branch = i;
        while model.parent[branch] < B {
            let ancestor = model.parent[branch];
            let c = cross(scratch.pose.arm[branch], moment);
            force[ancestor] += v[i] * v[i] * c;
            force[i] -= v[ancestor] * v[ancestor] * c;
            branch = ancestor;
        }
    }
    row_to_joints(model, &mut force);
    force
}

/// The driver's force at the site and its tangent: given, or from its spring and damper, which only push.
#[inline(always)]
fn drive<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    input: &Input<T>,
    h_theta: T,
    scratch: &mut Scratch<T, B, Z, N>,
) -> Option<(T, T)> {
    scratch.drive_force = T::ZERO;
    scratch.drive_pull = T::ZERO;
    scratch.drive_tangent = T::ZERO;
    let site = model.site.as_ref()?;
    match *input {
        Input::Free | Input::Rigid { .. } => None,
        Input::Force(force) => Some((force, T::ZERO)),
        Input::Motion { position, velocity } => {
            let at = dot(site.direction, scratch.pose.point(site.body, site.point));
            let speed = product(&scratch.site_row, &scratch.joint_velocity);
            let force = site.stiffness * (position - at) + site.damping * (velocity - speed);
            scratch.drive_pull = force;
            scratch.drive_tangent = h_theta * (site.damping + h_theta * site.stiffness);
            (force > T::ZERO).then_some((force, scratch.drive_tangent))
        }
    }
}

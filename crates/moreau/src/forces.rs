//! The regular part of a step: inertia and all forces that are functions of q, v and t, linearised.

use crate::contact::Timing;
use crate::joints::row_to_joints;
use crate::linear::Symmetric;
use crate::model::Model;
use crate::state::{Input, Scratch};
use crate::vector::{cross, dot};
use crate::{Mask, Real};

/// The couplings of M(q_*), M w0 in relative velocities, and the driven point's row, at the predicted pose.
///
/// In absolute velocities M has a constant diagonal and, for every body and ancestor, (branch arm) . (first moment) (README,
/// "Inertia").
#[inline(always)]
pub(crate) fn joint_momentum<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    v0: &[T; B],
    w0: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let Scratch { coupling, deep_coupling, momentum, pose, .. } = &mut *scratch;
    let (mut impulse, mut on_parent) = ([T::ZERO; B], [T::ZERO; B]);
    let (x, y) = (&pose.moment_x, &pose.moment_y);
    for i in 0..B {
        let c = (pose.arm_x[i] * x[i]).add_product(pose.arm_y[i], y[i]);
        coupling[i] = c;
        impulse[i] = (model.inertia[i] * v0[i]).add_product(c, v0[i] - w0[i]);
        on_parent[i] = c * v0[i];
    }
    if model.deep {
        beyond_parents(model, |i, ancestor, branch| {
            let c = dot(pose.arm(branch), [x[i], y[i]]);
            deep_coupling[i][ancestor] = c;
            impulse[i] += c * v0[ancestor];
            impulse[ancestor] += c * v0[i];
        });
    }
    row_to_joints(model, &mut impulse, &on_parent);
    *momentum = impulse;
    if let Some(site) = &model.site {
        let x = scratch.pose.point(site.body, site.point);
        scratch.pose.turning_row(&model.site_path, x, site.direction, &mut scratch.site_row);
    }
}

/// Calls `pair` with every body, each of its ancestors beyond its parent, and the ancestor's child on the way.
#[cold]
fn beyond_parents<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    mut pair: impl FnMut(usize, usize, usize),
) {
    for &i in &model.hinged[..model.hinged_count] {
        let mut branch = model.parent[i];
        while model.parent[branch] < B {
            pair(i, model.parent[branch], branch);
            branch = model.parent[branch];
        }
    }
}

/// The mass matrix of a tree of any depth in relative velocities: built in absolute ones, in which v is the sum of w over the joints that
/// carry a body, so that from the leaves on each row and column goes to its parent's, too.
#[cold]
fn deep_mass<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    coupling: &[T; B],
    deep_coupling: &[[T; B]; B],
) -> Symmetric<T, B> {
    let mut mass = [[T::ZERO; B]; B];
    for i in 0..B {
        mass[i][i] = model.inertia[i];
    }
    let mut couple = |i: usize, ancestor: usize, c: T| (mass[i][ancestor], mass[ancestor][i]) = (c, c);
    for &i in &model.hinged[..model.hinged_count] {
        couple(i, model.parent[i], coupling[i]);
    }
    beyond_parents(model, |i, ancestor, _| couple(i, ancestor, deep_coupling[i][ancestor]));
    for &i in model.hinged[..model.hinged_count].iter().rev() {
        let p = model.parent[i];
        for k in 0..B {
            let t = mass[i][k];
            mass[p][k] += t;
        }
        for row in &mut mass {
            let t = row[i];
            row[p] += t;
        }
    }
    Symmetric { diagonal: core::array::from_fn(|i| mass[i][i]), below: mass }
}

/// A w1 = b: the linearised step in relative velocities, without zones and set-valued laws.
///
/// A = M + h theta (-dQ/dw) + h^2 theta^2 (-dQ/dq), b = M w0 + h Q + (A - M) w. Terms of the gradient that could make A
/// indefinite (gravity, centrifugal, geometric stiffness, an unloading felt) are left out or clamped: they are of order h^2
/// and cost convergence speed, not accuracy.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub(crate) fn linearise<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    input: &Input<T>,
    w: &[T; B],
    joint_angle: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let (h, h_theta) = (timing.step, timing.h_theta);
    let weights = gravity_and_centrifugal(model, scratch);
    let driven = drive(model, input, h_theta, scratch);
    let Scratch { system, coupling, deep_coupling, momentum, joint_velocity, site_row, drive_force, .. } =
        &mut *scratch;
    let (a, b) = (&mut system.a, &mut system.b);
    let mut carried = [T::ZERO; B];
    let deep;
    let inertia = if model.deep {
        *a = deep_mass(model, coupling, deep_coupling);
        deep = a.diagonal;
        &deep
    } else {
        a.clear_below();
        // c (w_i + w_p) w_p.
        for &i in &model.hinged[..model.hinged_count] {
            a.below[i][model.parent[i]] = model.inertia[i] + coupling[i];
        }
        row_to_joints(model, &mut carried, coupling);
        &model.joint_inertia
    };
    for i in 0..B {
        let spring = model.spring_torque[i].sub_product(model.spring_stiffness[i], joint_angle[i]);
        let torque = (weights[i] + spring).sub_product(model.viscous[i], joint_velocity[i]);
        let tangent = h_theta * model.viscous[i].add_product(h_theta, model.spring_stiffness[i]);
        b[i] = momentum[i].add_product(h, torque).add_product(tangent, w[i]);
        a.diagonal[i] = inertia[i] + (tangent + carried[i] + carried[i]);
    }
    if let Some((force, tangent)) = driven {
        *drive_force = force;
        model.site_path.add_term(a, b, site_row, tangent, h * force, w);
    }
}

/// Adds dry friction regularised by tanh(u / width), and leaves its forces with the warm start.
#[cold]
#[inline(never)]
pub(crate) fn regularised_friction<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    near: &[usize],
    [pivot_width, sliding_width]: [T; 2],
    w: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let (h, h_theta) = (timing.step, timing.h_theta);
    let (a, b) = (&mut scratch.system.a, &mut scratch.system.b);
    for i in 0..B {
        let t = (scratch.joint_velocity[i] / pivot_width).tanh();
        let tangent = h_theta * model.dry[i] / pivot_width * (T::ONE - t * t);
        scratch.pivot_friction[i] = -model.dry[i] * t;
        b[i] += tangent * w[i] - h * model.dry[i] * t;
        a.diagonal[i] += tangent;
    }
    for &z in near {
        let contact = &scratch.contacts[z];
        if let (true, Some(mu)) = (scratch.active[z].any(), model.zones[z].friction) {
            let (row, path) = (&scratch.slip_row[z], &model.paths[z]);
            let t = (path.product(row, &scratch.joint_velocity) / sliding_width).tanh();
            let limit = mu * contact.force;
            let tangent = h_theta * limit / sliding_width * (T::ONE - t * t);
            scratch.tangential[z] = -limit * t;
            path.add_term(a, b, row, tangent, -h * limit * t, w);
        }
    }
}

/// Weight and centrifugal forces on the joints.
#[inline(always)]
fn gravity_and_centrifugal<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    scratch: &Scratch<T, B, Z, N>,
) -> [T; B] {
    let (v, w, pose) = (&scratch.velocity, &scratch.joint_velocity, &scratch.pose);
    let (mut force, mut on_parent) = ([T::ZERO; B], [T::ZERO; B]);
    let (x, y) = (&pose.moment_x, &pose.moment_y);
    for i in 0..B {
        let c = (pose.arm_x[i] * y[i]).sub_product(pose.arm_y[i], x[i]);
        // The parent's speed.
        let carrier = v[i] - w[i];
        force[i] = (-(model.gravity * x[i])).sub_product(carrier * carrier, c);
        on_parent[i] = v[i] * v[i] * c;
    }
    if model.deep {
        beyond_parents(model, |i, ancestor, branch| {
            let c = cross(pose.arm(branch), [x[i], y[i]]);
            force[ancestor] += v[i] * v[i] * c;
            force[i] -= v[ancestor] * v[ancestor] * c;
        });
    }
    row_to_joints(model, &mut force, &on_parent);
    force
}

/// The driver's force at the site and its tangent: given, or from its spring and damper, which only push.
#[inline(always)]
fn drive<T: Real, const B: usize, const Z: usize, const N: usize>(
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
            let speed = model.site_path.product(&scratch.site_row, &scratch.joint_velocity);
            let force = site.stiffness * (position - at) + site.damping * (velocity - speed);
            scratch.drive_pull = force;
            scratch.drive_tangent = h_theta * (site.damping + h_theta * site.stiffness);
            let pushes = T::ZERO.lt(force);
            let only = |x: T| T::only(pushes, x);
            pushes.any().then_some((only(force), only(scratch.drive_tangent)))
        }
    }
}

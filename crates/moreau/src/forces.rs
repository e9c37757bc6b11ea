//! The regular part of a step: inertia and all forces that are functions of q, v and t, linearised.

use crate::description::Site;
use crate::hand::SiteHand;
use crate::input::SiteInput;
use crate::linear::Symmetric;
use crate::model::Model;
use crate::real::{Mask, Real};
use crate::timing::Timing;
use crate::vector::{cross, dot};
use crate::workspace::{Drive, Inertia, Kinematics, Workspace};

/// The couplings of M(q_*), M w0 in relative velocities, and the driven point's row, at the predicted pose.
///
/// In absolute velocities M has a constant diagonal and, for every body and ancestor, (branch arm) . (first moment)
/// (README, "Inertia").
#[inline(always)]
pub(crate) fn joint_momentum<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    v0: &[T; B],
    w0: &[T; B],
    workspace: &mut Workspace<T, B, Z, N>,
) {
    let Workspace { kinematics: Kinematics { pose, .. }, inertia, drive, .. } = workspace;
    let Inertia { coupling, deep_coupling, momentum } = inertia;
    let (mut impulse, mut on_parent) = ([T::ZERO; B], [T::ZERO; B]);
    let (x, y) = (&pose.moment_x, &pose.moment_y);
    for i in 0..B {
        let c = (pose.arm_x[i] * x[i]).add_product(pose.arm_y[i], y[i]);
        coupling[i] = c;
        impulse[i] = (model.inertia[i] * v0[i]).add_product(c, v0[i] - w0[i]);
        on_parent[i] = c * v0[i];
    }
    if model.tree.is_deep() {
        model.tree.beyond_parents(|i, ancestor, branch| {
            let c = dot(pose.arm(branch), [x[i], y[i]]);
            deep_coupling[i][ancestor] = c;
            impulse[i] += c * v0[ancestor];
            impulse[ancestor] += c * v0[i];
        });
    }
    model.tree.row_to_joints(&mut impulse, &on_parent);
    *momentum = impulse;
    if let Some(site) = &model.site {
        let x = pose.point(site.body, site.point);
        pose.turning_row(&model.site_support, x, site.direction, &mut drive.site_row);
    }
}

/// The mass matrix of a tree of any depth in relative velocities; writes what is not zero.
///
/// It begins as the one in absolute velocities. There v is the sum of w over the joints that carry a body; so each row
/// and column is added to its parent's, from the leaves on. What stands in a row belongs to a body's ancestors alone:
/// bodies on different branches are not coupled.
#[inline(always)]
fn deep_mass<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    coupling: &[T; B],
    deep_coupling: &[[T; B]; B],
    mass: &mut Symmetric<T, B>,
) {
    let tree = &model.tree;
    mass.diagonal = model.inertia;
    for &i in tree.hinged() {
        mass.below[i][tree.parent[i]] = coupling[i];
    }
    tree.beyond_parents(|i, ancestor, _| mass.below[i][ancestor] = deep_coupling[i][ancestor]);
    for &i in tree.hinged().iter().rev() {
        let parent = tree.parent[i];
        let across = mass.below[i][parent];
        let mut sum = across + mass.diagonal[i];
        mass.diagonal[parent] = mass.diagonal[parent] + across + sum;
        mass.below[i][parent] = sum;
        let mut ancestor = tree.parent[parent];
        while ancestor < B {
            let coupled = mass.below[i][ancestor];
            mass.below[parent][ancestor] += coupled;
            // The row's own further entries: the body moves with every joint that carries it.
            sum += coupled;
            mass.below[i][ancestor] = sum;
            ancestor = tree.parent[ancestor];
        }
    }
}

/// A w1 = b: the linearised step in relative velocities, without zones and set-valued laws.
///
/// A = M + h theta (-dQ/dw) + h^2 theta^2 (-dQ/dq), b = M w0 + h Q + (A - M) w. Terms of the gradient that could make A
/// indefinite (gravity, centrifugal, geometric stiffness, an unloading felt) are left out or clamped: they are of order
/// h^2 and cost convergence speed, not accuracy.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
pub(crate) fn linearise<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    input: &SiteInput<T>,
    hand: &[T; 2],
    w: &[T; B],
    joint_angle: &[T; B],
    workspace: &mut Workspace<T, B, Z, N>,
) {
    let (h, h_theta) = (timing.step, timing.h_theta);
    let Workspace { kinematics, inertia: at_start, drive, problem, .. } = workspace;
    let weights = gravity_and_centrifugal(model, kinematics);
    let driven = drive_force(model, input, hand, timing, kinematics, drive);
    let Inertia { coupling, deep_coupling, momentum } = at_start;
    let (a, b) = (&mut problem.system.a, &mut problem.system.b);
    let mut carried = [T::ZERO; B];
    let deep;
    let inertia = if model.tree.is_deep() {
        a.clear_below();
        deep_mass(model, coupling, deep_coupling, a);
        deep = a.diagonal;
        &deep
    } else {
        a.clear_below();
        // c (w_i + w_p) w_p.
        for &i in model.tree.hinged() {
            a.below[i][model.tree.parent[i]] = model.inertia[i] + coupling[i];
        }
        model.tree.row_to_joints(&mut carried, coupling);
        &model.joint_inertia
    };
    for i in 0..B {
        let spring = model.spring_torque[i].sub_product(model.spring_stiffness[i], joint_angle[i]);
        let torque = (weights[i] + spring).sub_product(model.viscous[i], kinematics.joint_velocity[i]);
        let tangent = h_theta * model.viscous[i].add_product(h_theta, model.spring_stiffness[i]);
        b[i] = momentum[i].add_product(h, torque).add_product(tangent, w[i]);
        a.diagonal[i] = inertia[i] + (tangent + carried[i] + carried[i]);
    }
    if let Some((force, tangent)) = driven {
        drive.force = force;
        model.site_support.add_term(a, b, &drive.site_row, tangent, h * force, w);
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
    workspace: &mut Workspace<T, B, Z, N>,
) {
    let (h, h_theta) = (timing.step, timing.h_theta);
    let Workspace { kinematics, contacts, problem, forces, .. } = workspace;
    let (a, b) = (&mut problem.system.a, &mut problem.system.b);
    for i in 0..B {
        let t = (kinematics.joint_velocity[i] / pivot_width).tanh();
        let tangent = h_theta * model.dry[i] / pivot_width * (T::ONE - t * t);
        forces.pivot_friction[i] = -model.dry[i] * t;
        b[i] += tangent * w[i] - h * model.dry[i] * t;
        a.diagonal[i] += tangent;
    }
    for &z in near {
        let contact = &contacts.states[z];
        if let (true, Some(mu)) = (contacts.active[z].any(), model.zones[z].friction) {
            let (row, support) = (&contacts.slip_row[z], &model.supports[z]);
            let t = (support.product(row, &kinematics.joint_velocity) / sliding_width).tanh();
            let limit = mu * contact.force;
            let tangent = h_theta * limit / sliding_width * (T::ONE - t * t);
            forces.tangential[z] = -limit * t;
            support.add_term(a, b, row, tangent, -h * limit * t, w);
        }
    }
}

/// Weight and centrifugal forces on the joints.
#[inline(always)]
fn gravity_and_centrifugal<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    kinematics: &Kinematics<T, B>,
) -> [T; B] {
    let Kinematics { velocity: v, joint_velocity: w, pose } = kinematics;
    let (mut force, mut on_parent) = ([T::ZERO; B], [T::ZERO; B]);
    let (x, y) = (&pose.moment_x, &pose.moment_y);
    for i in 0..B {
        let c = (pose.arm_x[i] * y[i]).sub_product(pose.arm_y[i], x[i]);
        // The parent's speed.
        let carrier = v[i] - w[i];
        force[i] = (-(model.gravity * x[i])).sub_product(carrier * carrier, c);
        on_parent[i] = v[i] * v[i] * c;
    }
    if model.tree.is_deep() {
        model.tree.beyond_parents(|i, ancestor, branch| {
            let c = cross(pose.arm(branch), [x[i], y[i]]);
            force[ancestor] += v[i] * v[i] * c;
            force[i] -= v[ancestor] * v[ancestor] * c;
        });
    }
    model.tree.row_to_joints(&mut force, &on_parent);
    force
}

/// The driver's force at the site and its tangent: given, or from its spring and damper, which only push.
#[inline(always)]
pub(crate) fn drive_force<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    input: &SiteInput<T>,
    hand: &[T; 2],
    timing: &Timing<T>,
    kinematics: &Kinematics<T, B>,
    drive: &mut Drive<T, B>,
) -> Option<(T, T)> {
    (drive.force, drive.pull, drive.tangent) = (T::ZERO, T::ZERO, T::ZERO);
    let site = model.site.as_ref()?;
    match *input {
        SiteInput::Free | SiteInput::Rigid { .. } => None,
        SiteInput::Force(force) => Some((force, T::ZERO)),
        SiteInput::Motion { position, velocity } => {
            let fingertip = [site.stiffness, site.damping];
            elastic_force(model, site, [position, velocity], fingertip, timing, kinematics, drive)
        }
        SiteInput::Hand(ref by) => hand_force(model, site, by, hand, timing, kinematics, drive),
    }
}

/// The force of a spring and a damper that only push, and its tangent: from a driver's place and velocity.
#[inline(always)]
fn elastic_force<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    site: &Site<T>,
    [position, velocity]: [T; 2],
    [stiffness, damping]: [T; 2],
    timing: &Timing<T>,
    kinematics: &Kinematics<T, B>,
    drive: &mut Drive<T, B>,
) -> Option<(T, T)> {
    let at = dot(site.direction, kinematics.pose.point(site.body, site.point));
    let speed = model.site_support.product(&drive.site_row, &kinematics.joint_velocity);
    let force = stiffness * (position - at) + damping * (velocity - speed);
    drive.pull = force;
    drive.tangent = timing.h_theta * (damping + timing.h_theta * stiffness);
    // What is not a number must not pass for a finger that does not touch.
    let pushes = T::ZERO.lt(force).or(force.finite().not());
    let only = |x: T| T::only(pushes, x);
    pushes.any().then_some((only(force), only(drive.tangent)))
}

/// The same from a hand. Out of line, so that nothing else pays for it.
#[cold]
#[inline(never)]
fn hand_force<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    site: &Site<T>,
    by: &SiteHand<T>,
    hand: &[T; 2],
    timing: &Timing<T>,
    kinematics: &Kinematics<T, B>,
    drive: &mut Drive<T, B>,
) -> Option<(T, T)> {
    let flight = by.flight(*hand, timing);
    let [stiffness, damping] = by.finger(site.stiffness, site.damping);
    let share = flight.share(stiffness, damping, timing);
    let fingertip = [share * stiffness, share * damping];
    elastic_force(model, site, flight.free, fingertip, timing, kinematics, drive)
}

/// Moves a hand through the step, in the lanes in which it ends, by the fingertip's force that the last iteration has
/// found.
#[cold]
#[inline(never)]
pub(crate) fn move_hand<T: Real, const B: usize>(
    timing: &Timing<T>,
    by: &SiteHand<T>,
    lanes: T::Mask,
    hand: &[T; 2],
    drive: &mut Drive<T, B>,
) {
    let end = by.flight(*hand, timing).end(*hand, drive.force, timing);
    for k in 0..2 {
        drive.hand[k] = T::select(lanes, end[k], drive.hand[k]);
    }
}

//! All contact zones of a step.

use crate::contact::{Ease, Timing};
use crate::model::Model;
use crate::settings::Settings;
use crate::state::Scratch;
use crate::{Mask, Real};

/// Geometry and felt of the zones near contact during the step, and their part of A w1 = b; slip rows once, where a zone with
/// friction first touches.
#[inline(always)]
pub(crate) fn add_zones<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    near: &[usize],
    again: bool,
    w: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let Scratch { pose, contacts, active, slip_row, has_slip_row, joint_velocity, system, .. } = scratch;
    let mut ease = Ease::new();
    for &z in near {
        let (zone, path, contact) = (&model.zones[z], &model.paths[z], &mut contacts[z]);
        // Newton moves the pose by far less than a zone's reach; what was out of reach at the prediction stays so.
        let candidates = if again { contact.in_reach } else { T::Mask::splat(true) };
        let touched = contact.evaluate(zone, path, pose, joint_velocity, timing, candidates);
        active[z] = touched;
        if !contact.in_reach.any() {
            continue;
        }
        contact.ease(path, timing, touched, &mut ease);
        if touched.any() {
            let p = -(timing.step * contact.force);
            path.add_term(&mut system.a, &mut system.b, &contact.row, contact.tangent, p, w);
            let fresh = touched.and(has_slip_row[z].not());
            if zone.friction.is_some() && fresh.any() {
                contact.slip_row(zone, path, pose, fresh, &mut slip_row[z]);
                has_slip_row[z] = has_slip_row[z].or(touched);
            }
        }
    }
    scratch.ease = ease;
}

/// Whether the linearisation holds where `change` has taken the velocities, to `next`: for every joint, what the felts' curvature,
/// weight and centrifugal force may still bring about (what one more Newton iteration would remove) is below the tolerance.
///
/// A bound that is the same for all joints settles most steps; the others are looked at zone by zone.
#[inline(always)]
pub(crate) fn linear_enough<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    timing: &Timing<T>,
    near: &[usize],
    change: &[T; B],
    next: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) -> T::Mask {
    let h = timing.step;
    // The regularised law bends too sharply for an estimate.
    let mut holds = T::Mask::splat(!settings.friction.is_regularised());
    if T::ZERO.lt(scratch.drive_tangent).any() {
        let pushed = T::ZERO.lt(scratch.drive_pull);
        scratch.drive_pull -= scratch.drive_tangent * model.site_path.product(&scratch.site_row, change) / h;
        scratch.drive_force = scratch.drive_pull.max(T::ZERO);
        // The finger may have come or gone.
        let pushes = T::ZERO.lt(scratch.drive_pull);
        holds = holds.and(pushed.and(pushes).or(pushed.or(pushes).not()));
    }
    let (mut impulse, mut allowed, mut largest) = ([T::ZERO; B], [T::ZERO; B], T::ZERO);
    for i in 0..B {
        // Weight and centrifugal force, whose gradients the linearisation leaves out.
        let size = change[i].abs();
        let spin = T::from_f64(2.0) * scratch.velocity[i].abs() * model.whirl[i];
        impulse[i] = timing.h_theta * (h * model.weight[i] + spin) * size;
        allowed[i] = settings.tolerance * scratch.system.a[i][i] * (T::ONE + next[i].abs());
        largest = largest.max(size);
    }
    let x = timing.theta * largest;
    let ease = &scratch.ease;
    let bound = h * ease.square * x * x;
    let mut surely = (x * ease.linear).lt(ease.slack).and((x * ease.reach).lt(ease.clear));
    for i in 0..B {
        surely = surely.and((impulse[i] + bound).le(allowed[i]));
    }
    if !surely.or(holds.not()).all() {
        let closer = zone_by_zone(model, timing, near, change, scratch, impulse, &allowed);
        holds = holds.and(surely.or(closer));
    }
    holds
}

#[inline(always)]
fn zone_by_zone<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    near: &[usize],
    change: &[T; B],
    scratch: &Scratch<T, B, Z, N>,
    mut impulse: [T; B],
    allowed: &[T; B],
) -> T::Mask {
    for &z in near {
        let (zone, path, contact) = (&model.zones[z], &model.paths[z], &scratch.contacts[z]);
        if contact.in_reach.any() {
            let p = timing.step * contact.remainder(zone, path, change, timing, scratch.active[z]);
            for (k, j) in path.joints() {
                impulse[j] += p * contact.row[k].abs();
            }
        }
    }
    let mut holds = T::Mask::splat(true);
    for i in 0..B {
        holds = holds.and(impulse[i].le(allowed[i]));
    }
    holds
}

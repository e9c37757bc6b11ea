//! All contact zones of a step.

use crate::contact::Timing;
use crate::model::Model;
use crate::settings::{FrictionLaw, Settings};
use crate::state::Scratch;
use crate::{Mask, Scalar};

/// Geometry and felt of the zones near contact during the step, and their part of A w1 = b; slip rows once, where a zone with
/// friction first touches.
#[inline(always)]
pub(crate) fn add_zones<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    near: &[usize],
    again: bool,
    w: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let Scratch { pose, contacts, active, slip_row, has_slip_row, joint_velocity, system, .. } = scratch;
    for &z in near {
        let (zone, path, contact) = (&model.zones[z], &model.paths[z], &mut contacts[z]);
        // Newton moves the pose by far less than a zone's reach; what was out of reach at the prediction stays so.
        let candidates = if again { contact.in_reach } else { T::Mask::splat(true) };
        active[z] = contact.evaluate(zone, path, pose, joint_velocity, timing, candidates);
        if active[z].any() {
            path.add_term(
                &mut system.a,
                &mut system.b,
                &contact.row,
                contact.tangent,
                -(timing.step * contact.force),
                w,
            );
            if zone.friction.is_some() && !has_slip_row[z] {
                contact.slip_row(zone, path, pose, &mut slip_row[z]);
                has_slip_row[z] = true;
            }
        }
    }
}

/// Whether the linearisation holds where `change` has taken the velocities, to `next`: for every joint, what the felts' curvature,
/// weight and centrifugal force may still bring about (what one more Newton iteration would remove) is below the tolerance.
#[inline(always)]
pub(crate) fn linear_enough<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    timing: &Timing<T>,
    near: &[usize],
    change: &[T; B],
    next: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) -> bool {
    let h = settings.step;
    let mut impulse = [T::ZERO; B];
    for i in 0..B {
        // Weight and centrifugal force, whose gradients the linearisation leaves out.
        let spin = T::from_f64(2.0) * scratch.velocity[i].abs() * model.whirl[i];
        impulse[i] = timing.h_theta * (h * model.weight[i] + spin) * change[i].abs();
    }
    for &z in near {
        let (zone, path, contact) = (&model.zones[z], &model.paths[z], &mut scratch.contacts[z]);
        if !contact.in_reach.any() {
            continue;
        }
        let p = h * contact.remainder(zone, path, change, timing, scratch.active[z]);
        if T::ZERO < p {
            for (k, j) in path.joints() {
                impulse[j] += p * contact.row[k].abs();
            }
        }
    }
    let mut holds = true;
    if T::ZERO < scratch.drive_tangent {
        let before = T::ZERO < scratch.drive_pull;
        scratch.drive_pull -= scratch.drive_tangent * model.site_path.product(&scratch.site_row, change) / h;
        scratch.drive_force = scratch.drive_pull.max(T::ZERO);
        // The finger may have come or gone.
        holds = before == (T::ZERO < scratch.drive_pull);
    }
    // The regularised law bends too sharply for an estimate.
    holds &= settings.friction == FrictionLaw::SetValued;
    for i in 0..B {
        holds &= impulse[i] <= settings.tolerance * scratch.system.a[i][i] * (T::ONE + next[i].abs());
    }
    holds
}

//! Convergence test of Newton's method: a step has converged when the error of its linearisation is below the
//! tolerance.

use crate::model::Model;
use crate::real::{Mask, Real};
use crate::settings::Settings;
use crate::timing::Timing;
use crate::workspace::Workspace;

/// Returns whether the linearisation holds at the velocities `next` after the last correction. It does if, for every
/// joint, the neglected impulse (from the felts' curvature, weight and centrifugal force) would change the velocity by
/// less than the tolerance.
///
/// A quick bound ([`Margins::bound`](crate::curvature::Margins::bound)) decides most steps. The others are tested zone
/// by zone.
#[inline(always)]
pub(crate) fn linearisation_holds<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    timing: &Timing<T>,
    near: &[usize],
    next: &[T; B],
    workspace: &mut Workspace<T, B, Z, N>,
) -> T::Mask {
    // The regularised law bends too sharply for an estimate.
    let mut holds = T::Mask::splat(!settings.friction.is_regularised());
    if T::ZERO.lt(workspace.drive.tangent).any() {
        holds = holds.and(carry_drive_along(model, timing, workspace));
    }
    let mut largest = T::ZERO;
    for x in &workspace.correction {
        largest = largest.max(x.abs());
    }
    if !T::ZERO.lt(largest).any() {
        // At rest the prediction was right to the bit.
        return holds;
    }
    let (terms, mut surely) = workspace.contacts.margins.bound(&model.curvatures, timing, largest);
    for i in 0..B {
        let impulse = terms.add_to(by_inertia(model, timing, workspace, i), &model.curvatures, i);
        surely = surely.and(impulse.le(allowed(settings, next, workspace, i)));
    }
    if !surely.or(holds.not()).all() {
        holds = holds.and(surely.or(zone_by_zone(model, settings, timing, near, next, workspace)));
    }
    holds
}

/// Extrapolates an elastic drive's force with the correction. Returns the lanes in which the driver has neither begun
/// nor ceased to touch.
#[inline(always)]
fn carry_drive_along<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    workspace: &mut Workspace<T, B, Z, N>,
) -> T::Mask {
    let Workspace { drive, correction, .. } = workspace;
    let pushed = T::ZERO.lt(drive.pull);
    drive.pull -= drive.tangent * model.site_support.product(&drive.site_row, correction) / timing.step;
    drive.force = drive.pull.max(T::ZERO);
    let pushes = T::ZERO.lt(drive.pull);
    pushed.and(pushes).or(pushed.or(pushes).not())
}

/// Returns the impulse on joint i, N m s, by which weight and centrifugal force may change. The linearisation neglects
/// their gradients.
#[inline(always)]
fn by_inertia<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    workspace: &Workspace<T, B, Z, N>,
    i: usize,
) -> T {
    let spin = T::from_f64(2.0) * workspace.kinematics.velocity[i].abs() * model.centrifugal[i];
    timing.h_theta * spin.add_product(timing.step, model.weight[i]) * workspace.correction[i].abs()
}

/// Returns the impulse on joint i, N m s, that changes its velocity by the tolerance.
#[inline(always)]
fn allowed<T: Real, const B: usize, const Z: usize, const N: usize>(
    settings: &Settings<T>,
    next: &[T; B],
    workspace: &Workspace<T, B, Z, N>,
    i: usize,
) -> T {
    settings.tolerance * workspace.problem.system.a.diagonal[i] * (T::ONE + next[i].abs())
}

/// Exact test: the remainder of every zone.
#[inline(always)]
fn zone_by_zone<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    timing: &Timing<T>,
    near: &[usize],
    next: &[T; B],
    workspace: &Workspace<T, B, Z, N>,
) -> T::Mask {
    let mut impulse: [T; B] = core::array::from_fn(|i| by_inertia(model, timing, workspace, i));
    for &z in near {
        let (zone, support, contact) = (&model.compiled[z], &model.supports[z], &workspace.contacts.states[z]);
        if contact.in_reach.any() {
            let active = workspace.contacts.active[z];
            let p = timing.step
                * contact.remainder(
                    zone,
                    support,
                    &workspace.correction,
                    timing,
                    active,
                    &workspace.contacts.surfaces[z],
                );
            for (k, j) in support.joints() {
                impulse[j] = impulse[j].add_product(p, contact.row[k].abs());
            }
        }
    }
    let mut holds = T::Mask::splat(true);
    for i in 0..B {
        holds = holds.and(impulse[i].le(allowed(settings, next, workspace, i)));
    }
    holds
}

//! All contact zones of a step.

use crate::Scalar;
use crate::linear::product;
use crate::model::Model;
use crate::settings::{FrictionLaw, Settings};
use crate::state::Scratch;

/// Geometry and felt of every zone during the step; slip rows once, where a zone with friction first touches.
#[inline(always)]
pub(crate) fn evaluate_zones<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    again: bool,
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let Scratch { pose, contacts, slip_row, has_slip_row, joint_velocity, .. } = scratch;
    for (z, zone) in model.zones[..model.zone_count].iter().enumerate() {
        let contact = &mut contacts[z];
        // Newton moves the pose by far less than a zone's reach; what was out of reach at the prediction stays so.
        if again && contact.out_of_reach {
            continue;
        }
        contact.evaluate(zone, &model.carried[z], pose, joint_velocity, settings.step, settings.theta);
        if contact.active && zone.friction.is_some() && !has_slip_row[z] {
            slip_row[z] = contact.slip_row(&model.carried[z], pose);
            has_slip_row[z] = true;
        }
    }
}

/// Takes the zones' forces along to the step's final velocities (after [`remainder`] has seen the change), so that what can
/// be read afterwards is what acted.
#[inline(always)]
pub(crate) fn follow<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    change: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) {
    for (contact, zone) in scratch.contacts.iter_mut().zip(&model.zones[..model.zone_count]) {
        contact.follow(zone, settings.step, settings.theta);
    }
    if T::ZERO < scratch.drive_tangent {
        scratch.drive_force = pull_after(settings, change, scratch).max(T::ZERO);
    }
}

/// Force of an elastic drive before its clamp, after the velocities have changed.
#[inline(always)]
fn pull_after<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    settings: &Settings<T>,
    change: &[T; B],
    scratch: &Scratch<T, B, Z, N>,
) -> T {
    scratch.drive_pull - scratch.drive_tangent * product(&scratch.site_row, change) / settings.step
}

/// The largest velocity (relative to 1 rad/s + |velocity|) that the felts' curvature, and what the linearisation leaves out,
/// may still bring about after the iterate has changed by `change` to `next`: the error that one more Newton iteration would
/// remove.
#[inline(always)]
pub(crate) fn remainder<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    change: &[T; B],
    next: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) -> T {
    let (h, h_theta) = (settings.step, settings.step * settings.theta);
    let mut impulse = [T::ZERO; B];
    for i in 0..B {
        // Weight and centrifugal force, whose gradients the linearisation leaves out.
        let spin = T::from_f64(2.0) * scratch.velocity[i].abs() * model.whirl[i];
        impulse[i] = h_theta * (h * model.weight[i] + spin) * change[i].abs();
    }
    for (z, zone) in model.zones[..model.zone_count].iter().enumerate() {
        let contact = &mut scratch.contacts[z];
        let p = h * contact.remainder(zone, change, settings.step, settings.theta);
        if T::ZERO < p {
            for i in 0..B {
                impulse[i] += p * contact.row[i].abs();
            }
        }
    }
    if settings.friction != FrictionLaw::SetValued {
        // The regularised law bends too sharply for an estimate.
        return T::ONE / T::ZERO;
    }
    if T::ZERO < scratch.drive_tangent
        && (T::ZERO < scratch.drive_pull) != (T::ZERO < pull_after(settings, change, scratch))
    {
        // The finger has come or gone.
        return T::ONE / T::ZERO;
    }
    let mut largest = T::ZERO;
    for i in 0..B {
        largest = largest.max(impulse[i] / (scratch.system.a[i][i] * (T::ONE + next[i].abs())));
    }
    largest
}

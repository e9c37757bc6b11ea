//! All contact zones of a step.

use crate::contact::{Timing, Touch};
use crate::ease::Ease;
use crate::model::Model;
use crate::settings::Settings;
use crate::state::Scratch;
use crate::{Mask, Real};

/// Geometry of the zones near contact during the step: which are touched, and their rows; slip rows once, where a zone with friction first
/// touches. Before anything else that needs the pose: the rest of the linearisation does not wait for it.
#[inline(always)]
pub(crate) fn look_at_zones<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    near: &[usize],
    again: bool,
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let (mut ease, mut count) = (Ease::new(), 0);
    for &z in near {
        // A row's length is known to the compiler, so that it stays in registers.
        let touches = match model.paths[z].count() {
            1 => look_at::<T, B, Z, N, 1>(model, timing, z, again, &mut ease, scratch),
            2 => look_at::<T, B, Z, N, 2>(model, timing, z, again, &mut ease, scratch),
            3 => look_at::<T, B, Z, N, 3>(model, timing, z, again, &mut ease, scratch),
            _ => look_at::<T, B, Z, N, B>(model, timing, z, again, &mut ease, scratch),
        };
        scratch.touched[count] = z;
        count += usize::from(touches);
    }
    scratch.touched_count = count;
    scratch.ease = ease;
}

/// The felts of the touched zones, and their part of A w1 = b. In a pass of its own: the chains of operations of several zones then run side
/// by side.
#[inline(always)]
pub(crate) fn add_zones<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    w: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) {
    let Scratch { contacts, active, system, touched, touched_count, ease, .. } = &mut *scratch;
    for &z in &touched[..*touched_count] {
        let (path, contact) = (&model.paths[z], &mut contacts[z]);
        contact.press(&model.forms[z], timing, active[z], ease);
        path.add_term(&mut system.a, &mut system.b, &contact.row, contact.tangent, -(timing.step * contact.force), w);
    }
}

/// Looks at a zone whose row has K entries. Says whether it is touched.
#[inline(always)]
fn look_at<T: Real, const B: usize, const Z: usize, const N: usize, const K: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    z: usize,
    again: bool,
    ease: &mut Ease<T>,
    scratch: &mut Scratch<T, B, Z, N>,
) -> bool {
    let Scratch { pose, contacts, active, slip_row, has_slip_row, joint_velocity, .. } = scratch;
    let (form, path, contact) = (&model.forms[z], &model.paths[z], &mut contacts[z]);
    // Newton moves the pose by far less than a zone's reach; what was out of reach at the prediction stays so.
    let candidates = if again { contact.in_reach } else { T::Mask::splat(true) };
    let look = contact.evaluate::<K>(form, path, pose, joint_velocity, timing, candidates, ease);
    let touched = look.touched;
    active[z] = touched;
    if form.slides {
        let known = if again { has_slip_row[z] } else { T::Mask::splat(false) };
        let fresh = touched.and(known.not());
        if fresh.any() {
            Touch::slip_row(&look, form, path, pose, fresh, &mut slip_row[z]);
        }
        has_slip_row[z] = known.or(touched);
    }
    touched.any()
}

/// Whether the linearisation holds where the last change has taken the velocities, to `next`: for every joint, what the felts' curvature,
/// weight and centrifugal force may still bring about (what one more Newton iteration would remove) is below the tolerance.
///
/// A quick bound ([`Ease`]) settles most steps; the others are looked at zone by zone.
#[inline(always)]
pub(crate) fn linear_enough<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    timing: &Timing<T>,
    near: &[usize],
    next: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
) -> T::Mask {
    let h = timing.step;
    // The regularised law bends too sharply for an estimate.
    let mut holds = T::Mask::splat(!settings.friction.is_regularised());
    if T::ZERO.lt(scratch.drive_tangent).any() {
        let pushed = T::ZERO.lt(scratch.drive_pull);
        scratch.drive_pull -= scratch.drive_tangent * model.site_path.product(&scratch.site_row, &scratch.change) / h;
        scratch.drive_force = scratch.drive_pull.max(T::ZERO);
        // The finger may have come or gone.
        let pushes = T::ZERO.lt(scratch.drive_pull);
        holds = holds.and(pushed.and(pushes).or(pushed.or(pushes).not()));
    }
    let mut largest = T::ZERO;
    for x in &scratch.change {
        largest = largest.max(x.abs());
    }
    if !T::ZERO.lt(largest).any() {
        // At rest the prediction was right to the bit.
        return holds;
    }
    let (terms, mut surely) = scratch.ease.bound(&model.bending, timing, largest);
    for i in 0..B {
        let impulse = terms.add_to(carried(model, timing, scratch, i), &model.bending, i);
        surely = surely.and(impulse.le(allowed(settings, next, scratch, i)));
    }
    if !surely.or(holds.not()).all() {
        holds = holds.and(surely.or(zone_by_zone(model, settings, timing, near, next, scratch)));
    }
    holds
}

/// What a change of the velocities may bring about by weight and centrifugal force, whose gradients the linearisation leaves out: an
/// impulse on joint i, N m s.
#[inline(always)]
fn carried<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    scratch: &Scratch<T, B, Z, N>,
    i: usize,
) -> T {
    let spin = T::from_f64(2.0) * scratch.velocity[i].abs() * model.whirl[i];
    timing.h_theta * spin.add_product(timing.step, model.weight[i]) * scratch.change[i].abs()
}

/// The impulse on joint i, N m s, that changes its velocity by the tolerance.
#[inline(always)]
fn allowed<T: Real, const B: usize, const Z: usize, const N: usize>(
    settings: &Settings<T>,
    next: &[T; B],
    scratch: &Scratch<T, B, Z, N>,
    i: usize,
) -> T {
    settings.tolerance * scratch.system.a.diagonal[i] * (T::ONE + next[i].abs())
}

#[inline(always)]
fn zone_by_zone<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    timing: &Timing<T>,
    near: &[usize],
    next: &[T; B],
    scratch: &Scratch<T, B, Z, N>,
) -> T::Mask {
    let mut impulse: [T; B] = core::array::from_fn(|i| carried(model, timing, scratch, i));
    for &z in near {
        let (form, path, contact) = (&model.forms[z], &model.paths[z], &scratch.contacts[z]);
        if contact.in_reach.any() {
            let p = timing.step * contact.remainder(form, path, &scratch.change, timing, scratch.active[z]);
            for (k, j) in path.joints() {
                impulse[j] = impulse[j].add_product(p, contact.row[k].abs());
            }
        }
    }
    let mut holds = T::Mask::splat(true);
    for i in 0..B {
        holds = holds.and(impulse[i].le(allowed(settings, next, scratch, i)));
    }
    holds
}

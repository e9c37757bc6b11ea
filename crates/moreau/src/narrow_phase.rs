//! The narrow phase: finds the zones that are touched during the step, and evaluates their felts.

use crate::contact::{ANY_LENGTH, ContactState};
use crate::coupled::press_coupled;
use crate::curvature::Margins;
use crate::model::{Model, YIELDING};
use crate::real::{Mask, Real};
use crate::surface::Yielding;
use crate::timing::Timing;
use crate::workspace::{Contacts, Kinematics, Workspace};

/// Geometry of the zones near contact: which are touched during the step, and their rows. A zone with friction gets its
/// slip row when it first touches, once in a step.
///
/// It runs before anything else that needs the pose, because the rest of the linearisation does not wait for its
/// results.
#[inline(always)]
pub(crate) fn narrow_phase<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    near: &[usize],
    first: bool,
    workspace: &mut Workspace<T, B, Z, N>,
) {
    let Workspace { kinematics, contacts, .. } = workspace;
    let (mut margins, mut count) = (Margins::new(), 0);
    for &z in near {
        // The compiler knows a row's length in each case, so the row stays in registers.
        let touches = match model.look[z] {
            1 => examine::<T, B, Z, 1, false>(model, timing, z, first, &mut margins, kinematics, contacts),
            2 => examine::<T, B, Z, 2, false>(model, timing, z, first, &mut margins, kinematics, contacts),
            3 => examine::<T, B, Z, 3, false>(model, timing, z, first, &mut margins, kinematics, contacts),
            // Never in lanes (`lanes.rs`), which need not ask.
            YIELDING if const { T::LANES == 1 } => {
                // By value, so that the margins stay in registers where nothing yields.
                let (touches, seen) = examine_yielding(model, timing, z, first, margins, kinematics, contacts);
                margins = seen;
                touches
            }
            // Six bodies have hardly any longer row; written out, it leaves the others their registers.
            _ if const { B > 6 } => {
                examine::<T, B, Z, ANY_LENGTH, false>(model, timing, z, first, &mut margins, kinematics, contacts)
            }
            _ => examine::<T, B, Z, B, false>(model, timing, z, first, &mut margins, kinematics, contacts),
        };
        contacts.touched[count] = z;
        count += usize::from(touches);
    }
    contacts.touched_count = count;
    contacts.margins = margins;
}

/// Looks at a zone whose curve yields. A function of its own: a mechanism without such zones pays nothing for it.
#[cold]
#[inline(never)]
fn examine_yielding<T: Real, const B: usize, const Z: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    z: usize,
    first: bool,
    mut margins: Margins<T>,
    kinematics: &Kinematics<T, B>,
    contacts: &mut Contacts<T, B, Z>,
) -> (bool, Margins<T>) {
    let touches = examine::<T, B, Z, ANY_LENGTH, true>(model, timing, z, first, &mut margins, kinematics, contacts);
    (touches, margins)
}

/// Looks at a zone whose row has K entries, or [`ANY_LENGTH`]. Says whether it is touched.
#[inline(always)]
fn examine<T: Real, const B: usize, const Z: usize, const K: usize, const YIELDS: bool>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    z: usize,
    first: bool,
    margins: &mut Margins<T>,
    kinematics: &Kinematics<T, B>,
    contacts: &mut Contacts<T, B, Z>,
) -> bool {
    let Contacts { states, active, slip_row, has_slip_row, surfaces, .. } = contacts;
    let Kinematics { pose, joint_velocity, .. } = kinematics;
    let (zone, support, contact) = (&model.compiled[z], &model.supports[z], &mut states[z]);
    // Newton moves the pose by far less than a zone's reach. What was out of reach at the prediction stays so.
    let candidates = if first { T::Mask::splat(true) } else { contact.in_reach };
    let surface = if const { YIELDS } { surfaces[z] } else { Yielding::still() };
    let proximity =
        contact.evaluate::<K, YIELDS>(zone, support, pose, joint_velocity, timing, candidates, &surface, margins);
    let touched = proximity.touched;
    active[z] = touched;
    if zone.slides {
        let known = if first { T::Mask::splat(false) } else { has_slip_row[z] };
        let fresh = touched.and(known.not());
        if fresh.any() {
            ContactState::slip_row(&proximity, zone, support, pose, fresh, &mut slip_row[z]);
        }
        has_slip_row[z] = known.or(touched);
    }
    touched.any()
}

/// The felts of the touched zones, and their part of A w1 = b.
///
/// A pass of its own: the chains of operations of several zones then run side by side.
#[inline(always)]
pub(crate) fn add_felts<T: Real, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    timing: &Timing<T>,
    near: &[usize],
    w: &[T; B],
    workspace: &mut Workspace<T, B, Z, N>,
) {
    let Contacts { states, active, touched, touched_count, margins, surfaces, .. } = &mut workspace.contacts;
    let system = &mut workspace.problem.system;
    for &z in &touched[..*touched_count] {
        let (support, contact) = (&model.supports[z], &mut states[z]);
        contact.press(&model.compiled[z], timing, active[z], &surfaces[z], margins);
        let impulse = -(timing.step * contact.force);
        support.add_term(&mut system.a, &mut system.b, &contact.row, contact.tangent, impulse, w);
    }
    if const { T::LANES == 1 } && workspace.contacts.coupled.count > 1 {
        press_coupled(model, timing, near, w, &mut workspace.contacts, &mut workspace.problem.system);
    }
}

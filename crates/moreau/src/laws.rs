//! The set-valued part of a step: which laws are in force, and what became of them.

use crate::Scalar;
use crate::linear::product;
use crate::model::Model;
use crate::settings::{FrictionLaw, Settings};
use crate::state::{Input, Scratch};

/// What a sliding law of the one-step problem stands for.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Law {
    /// Coulomb friction of a zone.
    Zone(usize),
    /// The rigid drive.
    Rigid,
}

/// Completes the linearised step with the laws in force and a warm start.
#[inline(always)]
pub(crate) fn one_step_problem<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &Input<T>,
    w: &[T; B],
    scratch: &mut Scratch<T, B, Z, N>,
    laws: &mut [Law; N],
) {
    let h = settings.step;
    let Scratch { system, impulses, contacts, slip_row, site_row, pivot_friction, tangential, rigid_force, .. } =
        &mut *scratch;
    let set_valued = settings.friction == FrictionLaw::SetValued;
    for i in 0..B {
        system.pivot_bound[i] = if set_valued { h * model.dry[i] } else { T::ZERO };
        impulses.pivot[i] = if set_valued { h * pivot_friction[i] } else { T::ZERO };
    }
    let mut n = 0;
    let sliding = if set_valued { model.sliding_count } else { 0 };
    for &z in &model.sliding_zones[..sliding] {
        let contact = &contacts[z];
        let Some(mu) = model.zones[z].friction else { continue };
        if !contact.active || contact.force <= T::ZERO || n >= N {
            continue;
        }
        laws[n] = Law::Zone(z);
        let law = &mut system.sliding[n];
        law.row = slip_row[z];
        law.target = T::ZERO;
        // The felt's force in this very step, mu (F + dF/dw (w1 - w)), times h.
        let gradient = mu * contact.tangent;
        law.bound = mu * h * contact.force - gradient * product(&contact.row, w);
        for i in 0..B {
            law.slope[i] = gradient * contact.row[i];
        }
        law.rigid = false;
        impulses.sliding[n] = h * tangential[z];
        n += 1;
    }
    if let (Input::Rigid { velocity }, true, true) = (input, model.site.is_some(), n < N) {
        laws[n] = Law::Rigid;
        let law = &mut system.sliding[n];
        law.row = *site_row;
        law.target = *velocity;
        law.rigid = true;
        impulses.sliding[n] = h * *rigid_force;
        n += 1;
    }
    system.count = n;
    if set_valued {
        *tangential = [T::ZERO; Z];
    }
}

/// Stores the laws' forces p/h: the next warm start, and what the run reports.
#[inline(always)]
pub(crate) fn keep_forces<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    h: T,
    scratch: &mut Scratch<T, B, Z, N>,
    laws: &[Law; N],
) {
    let inverse_h = T::ONE / h;
    for i in 0..B {
        if T::ZERO < scratch.system.pivot_bound[i] {
            scratch.pivot_friction[i] = scratch.impulses.pivot[i] * inverse_h;
        }
    }
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

//! Bushings: pivots with compliant cloth.
//!
//! A pivot that can move a little in one direction is modelled as a pivot at the end of a long arm. The arm is a body
//! of its own, held by a spring, and hinged in line with the pivot on the body that carried the pivot before. So the
//! engine needs no new kind of joint. For the rigid geometry the arm is a piece of the body that carries it
//! ([`Instrument::locked`]).

use super::{Body, Instrument, Spring};
use crate::index::IndexError;

/// Length of the arm, m: long enough that the pivot's path is practically straight over the compression of a bushing.
const ARM_M: f64 = 0.3;
/// Mass of the pin at the arm's end, kg: small compared with every part of an action.
const PIN_KG: f64 = 1e-3;
/// Dry friction of the pin, N, which brings the arm to rest.
const DRY_N: f64 = 3e-3;

impl Instrument {
    /// Returns the name of a body's bushing, shared by its arm (a body) and its spring.
    #[must_use]
    pub(crate) fn bushing_name(&self, body: usize) -> String {
        format!("{}_bushing", self.bodies[body].name)
    }

    /// Returns the instrument with a bushing of the given stiffness, N/m, and damping, N s/m, at a body's pivot. The
    /// pivot can move at right angles to the x axis of the body that carries it (up and down on the ground). The
    /// bushing adds a body, right before this one, and a spring, the last.
    ///
    /// # Errors
    /// There is no such body.
    pub fn with_bushing(&self, body: usize, n_per_m: f64, n_s_per_m: f64) -> Result<Instrument, IndexError> {
        IndexError::check("body", body, self.bodies.len())?;
        Ok(self.with_bushing_at(body, n_per_m, n_s_per_m))
    }

    /// [`Instrument::with_bushing`] of a body that exists.
    pub(crate) fn with_bushing_at(&self, body: usize, n_per_m: f64, n_s_per_m: f64) -> Instrument {
        let mut other = self.fields.clone();
        let own = &self.bodies[body];
        let (name, square) = (self.bushing_name(body), ARM_M * ARM_M);
        let arm = Body {
            name: name.clone(),
            parent: own.parent,
            pivot_m: [own.pivot_m[0] - ARM_M, own.pivot_m[1]],
            angle_rad: own.parent.map_or(0.0, |parent| self.bodies[parent].angle_rad),
            mass_kg: PIN_KG,
            inertia_kg_m2: PIN_KG * square,
            center_of_mass_m: [ARM_M, 0.0],
            friction_torque_n_m: DRY_N * ARM_M,
            viscous_n_m_s: n_s_per_m * square,
            dwell: None,
            is_bend: true,
            turn_rad: None,
        };
        // The arm takes the body's index; the indices of the body and of all later ones grow by one.
        let moved = |index: &mut usize| *index += usize::from(*index >= body);
        other.bodies.insert(body, arm);
        other.bodies.iter_mut().skip(body + 1).filter_map(|b| b.parent.as_mut()).for_each(moved);
        (other.bodies[body + 1].parent, other.bodies[body + 1].pivot_m) = (Some(body), [ARM_M, 0.0]);
        other.springs.iter_mut().for_each(|spring| moved(&mut spring.body));
        for zone in &mut other.zones {
            [&mut zone.disc_body, &mut zone.curve_body].into_iter().flatten().for_each(moved);
        }
        [&mut other.roles.key, &mut other.roles.hammer].into_iter().flatten().for_each(moved);
        other.parts.iter_mut().filter_map(|part| part.body.as_mut()).for_each(moved);
        other.springs.push(Spring { name, body, torque_n_m: 0.0, stiffness_n_m_per_rad: n_per_m * square });
        Instrument { fields: other }
    }
}

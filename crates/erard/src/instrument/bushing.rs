//! Bushings: pivots with compliant cloth.
//!
//! A pivot that may move a little in one direction is a pivot at the end of a long arm: a body of its own, hinged in
//! line with the pivot on what that was hinged on, and held by a spring. The engine's tree of hinges then needs nothing
//! new. For the rigid geometry the arm is a piece of the body that it is hinged on ([`Instrument::locked`]).

use super::{Body, Instrument, Spring};

/// Length of the arm, m; so long that the pivot's path is straight over the compression of a bushing.
const ARM_M: f64 = 0.3;
/// Of what represents the pin, at the arm's end: small beside every part of an action.
const PIN_KG: f64 = 1e-3;
/// N; so that it comes to rest.
const DRY_N: f64 = 3e-3;

impl Instrument {
    /// The name of a body's bushing: a body and a spring.
    #[must_use]
    pub(crate) fn bushing_name(&self, body: usize) -> String {
        format!("{}_bushing", self.bodies[body].name)
    }

    /// The instrument with a bushing at a body's pivot, of a stiffness, N/m, and a damping, N s/m: the pivot may move
    /// across the x axis of what the body is hinged on (up and down, for the ground). The bushing is a body more, right
    /// before this one, and a spring more, the last.
    #[must_use]
    pub fn with_bushing(&self, body: usize, n_per_m: f64, n_s_per_m: f64) -> Instrument {
        let mut other = self.clone();
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
        // The arm takes the body's place; the body and all that follow move on by one.
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
        other
    }
}

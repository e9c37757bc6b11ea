//! The one-degree-of-freedom model [T12 fig. 3, T13 sec. 1]: the whole mechanism as inertia, constant moment and
//! friction on the key, with the key's own stops.
//!
//! It is an instrument with one body, so that every command that takes an instrument takes it too. Its numbers follow
//! from the full instrument by virtual power at rest: with the contacts named by `one_dof.transmits` closed, every body
//! turns at a fixed ratio r_i to the key, and
//!
//! - J = r . M r, c_v = sum c_v,i (r_i - r_parent)^2,
//! - c_d = sum c_d,i |r_i - r_parent| + sum mu_z N_z |s_z|, with the forces N_z of the contacts at rest and their slip
//!   s_z per unit of key velocity,
//! - alpha = power of gravity and springs per unit of key velocity. (O2) of the book.
//!
//! Bodies that those contacts do not reach (the damper, which the key picks up later) stay out of it.

use moreau::{Settings, gauss_jordan_pivoting};
use thiserror::Error;

use crate::instrument::{Body, DrawnPart, Instrument, InstrumentFields, MAX_BODIES, Roles, Screw, Spring, Zone};
use crate::mechanism::Mechanism;
use crate::player::equilibrium;
use crate::player::{Action, ActionError};

/// Why no one-degree-of-freedom model follows from an instrument.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum OneDofError {
    /// No key.
    #[error("the instrument has no `roles.key`; expected the body to which the action is reduced")]
    NoKey,
    /// The transmitting zones do not determine the bodies they reach.
    #[error(
        "the zones of `one_dof.transmits` ({zones}) do not determine how the bodies they reach ({bodies}) follow the key: there must be as many zones as bodies besides the key, and none may be redundant"
    )]
    Undetermined {
        /// Zone names.
        zones: String,
        /// Body names.
        bodies: String,
    },
    /// No equilibrium to linearise about.
    #[error(transparent)]
    Action(#[from] ActionError),
}

/// The reduced model and the data of its reduction.
#[derive(Debug, Clone)]
pub struct OneDof {
    /// The one-body instrument.
    pub instrument: Instrument,
    /// Velocity ratio of every body of the full instrument, its bends locked, to the key, at rest.
    pub ratios: Vec<f64>,
    /// Inertia about the key's pivot, kg m2.
    pub inertia_kg_m2: f64,
    /// Constant moment on the key, N m, counter-clockwise.
    pub moment_n_m: f64,
}

/// Derives the one-degree-of-freedom model of an instrument, its bends locked.
///
/// # Errors
/// See [`OneDofError`].
pub fn reduce(full: &Instrument) -> Result<OneDof, OneDofError> {
    let full = &full.locked();
    let key = full.roles.key.ok_or(OneDofError::NoKey)?;
    let settings = Settings::new(equilibrium::STEP_S);
    let action = Action::with(full, settings)?;
    let rest = action.mechanism();

    let rows: Vec<Vec<f64>> = full.roles.transmits.iter().map(|&z| rest.compression_row(z)).collect();
    let ratios = ratios(&rows, key, full.bodies.len()).ok_or_else(|| undetermined(full, &rows, key))?;

    let inertia = 2.0 * rest.energies_at(&ratios).kinetic;
    let mut moment = 0.0;
    let (mut dry, mut viscous) = (0.0, 0.0);
    for (i, body) in full.bodies.iter().enumerate() {
        let relative = ratios[i] - body.parent.map_or(0.0, |p| ratios[p]);
        dry += body.friction_torque_n_m * relative.abs();
        viscous += body.viscous_n_m_s * relative * relative;
        let rise = rest.velocity_row(i, body.center_of_mass_m, [0.0, 1.0]);
        let rise: f64 = rise.iter().zip(&ratios).map(|(a, r)| a * r).sum();
        if ratios[i] != 0.0 {
            moment -= full.gravity_m_per_s2 * body.mass_kg * rise;
        }
    }
    for spring in &full.springs {
        let parent = full.bodies[spring.body].parent;
        let relative = ratios[spring.body] - parent.map_or(0.0, |p| ratios[p]);
        let angles = rest.readout().angles;
        let drawn = full.bodies[spring.body].angle_rad - parent.map_or(0.0, |p| full.bodies[p].angle_rad);
        let turned = angles[spring.body] - parent.map_or(0.0, |p| angles[p]) - drawn;
        moment += (spring.torque_n_m - spring.stiffness_n_m_per_rad * turned) * relative;
    }

    for (z, zone) in full.zones.iter().enumerate() {
        let largest = zone.friction_coefficient * rest.normal_force(z);
        if largest > 0.0 {
            dry += largest * slip(full, rest, z, &ratios).abs();
        }
    }

    let body = Body {
        parent: None,
        mass_kg: 0.0,
        center_of_mass_m: [0.0, 0.0],
        inertia_kg_m2: inertia,
        friction_torque_n_m: dry,
        viscous_n_m_s: viscous,
        ..full.bodies[key].clone()
    };
    let stops: Vec<Zone> = full.roles.stops.iter().map(|&z| one_body_zone(&full.zones[z], key)).collect();
    let place = |zone: Option<usize>| zone.and_then(|z| full.roles.stops.iter().position(|&s| s == z));
    let fields = InstrumentFields {
        name: format!("{} (one degree of freedom)", full.name),
        gravity_m_per_s2: full.gravity_m_per_s2,
        bodies: vec![body],
        springs: vec![Spring { name: "whole action".into(), body: 0, torque_n_m: moment, stiffness_n_m_per_rad: 0.0 }],
        zones: stops,
        strings: Vec::new(),
        bridge_modes: Vec::new(),
        roles: Roles {
            key: Some(0),
            key_front_m: full.roles.key_front_m,
            is_sharp: full.roles.is_sharp,
            key_bottom: place(full.roles.key_bottom),
            ..Roles::default()
        },
        finger: full.finger,
        screws: Vec::<Screw>::new(),
        parts: full
            .parts
            .iter()
            .filter(|p| p.body.is_none_or(|b| b == key))
            .map(|p| DrawnPart { body: p.body.map(|_| 0), ..p.clone() })
            .collect(),
        origin: full.origin,
    };
    let instrument = Instrument { fields };
    Ok(OneDof { instrument, ratios, inertia_kg_m2: inertia, moment_n_m: moment })
}

/// Slip of a touching zone per unit of key velocity, m: of the disc over the curve, across the contact's normal.
fn slip(full: &Instrument, rest: &dyn Mechanism, zone: usize, ratios: &[f64]) -> f64 {
    let &Zone { disc_body, disc_center_m, curve_body, .. } = &full.zones[zone];
    let (center, at) = (rest.point(disc_body, disc_center_m), rest.contact_point(zone));
    let normal = [center[0] - at[0], center[1] - at[1]];
    let length = normal[0].hypot(normal[1]);
    let along = [-normal[1] / length, normal[0] / length];
    let placements = full.placements(rest.readout().angles);
    let speed = |body: Option<usize>| -> f64 {
        let row = body.map_or(Vec::new(), |body| rest.velocity_row(body, placements[body].from_world(at), along));
        row.iter().zip(ratios).map(|(a, r)| a * r).sum()
    };
    speed(disc_body) - speed(curve_body)
}

/// A stop of the key as a zone of the one-body instrument.
fn one_body_zone(zone: &Zone, key: usize) -> Zone {
    let body = |b: Option<usize>| b.filter(|&b| b == key).map(|_| 0);
    Zone { disc_body: body(zone.disc_body), curve_body: body(zone.curve_body), ..zone.clone() }
}

fn undetermined(full: &Instrument, rows: &[Vec<f64>], key: usize) -> OneDofError {
    let zones: Vec<&str> = full.roles.transmits.iter().map(|&z| full.zones[z].name.as_str()).collect();
    let bodies: Vec<&str> =
        reached(rows, key, full.bodies.len()).iter().map(|&b| full.bodies[b].name.as_str()).collect();
    OneDofError::Undetermined { zones: zones.join(", "), bodies: bodies.join(", ") }
}

/// Bodies other than the key that the rows touch.
fn reached(rows: &[Vec<f64>], key: usize, count: usize) -> Vec<usize> {
    (0..count).filter(|&b| b != key && rows.iter().any(|r| r[b] != 0.0)).collect()
}

/// Solves G r = 0 with r_key = 1 and zero for bodies that no row touches; `None` unless the solution is unique.
fn ratios(rows: &[Vec<f64>], key: usize, count: usize) -> Option<Vec<f64>> {
    let unknown = reached(rows, key, count);
    if rows.len() != unknown.len() {
        return None;
    }
    // Bodies that no row touches have the identity's rows.
    let mut a: [[f64; MAX_BODIES]; MAX_BODIES] = std::array::from_fn(|i| std::array::from_fn(|j| f64::from(i == j)));
    let mut right = [[0.0]; MAX_BODIES];
    for (k, row) in rows.iter().enumerate() {
        for (j, &body) in unknown.iter().enumerate() {
            a[k][j] = row[body];
        }
        right[k] = [-row[key]];
    }
    // Rows are lever arms in metres; a micrometre of arm is no transmission.
    if !gauss_jordan_pivoting(&mut a, &mut right, 1e-6) {
        return None;
    }
    let mut r = vec![0.0; count];
    r[key] = 1.0;
    for (&[ratio], &body) in right.iter().zip(&unknown) {
        r[body] = ratio;
    }
    Some(r)
}

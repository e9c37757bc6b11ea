//! From the instrument to the engine's model.

use moreau::{Body, Curve, Exponent, Felt, GROUND, Model, ModelError, Site, Spring, Zone};

use crate::instrument::{self, Instrument};

/// Assembles the model of an instrument, for any engine size that holds it.
///
/// # Errors
/// [`ModelError`] if the size is too small (the instrument itself has been validated).
pub fn assemble<const B: usize, const Z: usize>(instrument: &Instrument) -> Result<Model<f64, B, Z>, ModelError> {
    let ground = |body: Option<usize>| body.unwrap_or(GROUND);
    let bodies: Vec<Body<f64>> = instrument
        .bodies
        .iter()
        .map(|b| Body {
            parent: ground(b.parent),
            pivot: b.pivot_m,
            mass: b.mass_kg,
            inertia: b.inertia_kg_m2,
            center_of_mass: b.center_of_mass_m,
            dry: b.friction_torque_n_m,
            viscous: b.viscous_n_m_s,
        })
        .collect();
    let drawn = |body: usize| {
        let b = &instrument.bodies[body];
        b.angle_rad - b.parent.map_or(0.0, |p| instrument.bodies[p].angle_rad)
    };
    let springs: Vec<Spring<f64>> = instrument
        .springs
        .iter()
        .map(|s| Spring {
            body: s.body,
            torque: s.torque_n_m,
            stiffness: s.stiffness_n_m_per_rad,
            reference: drawn(s.body),
        })
        .collect();
    let zones: Vec<Zone<f64>> = instrument
        .zones
        .iter()
        .map(|z| Zone {
            disc_body: ground(z.disc_body),
            center: z.disc_center_m,
            radius: z.disc_radius_m,
            curve_body: ground(z.curve_body),
            curve: curve(&z.curve),
            felt: Felt {
                stiffness: z.felt.stiffness,
                exponent: Exponent::new(z.felt.exponent),
                damping: z.felt.damping,
            },
            friction: (z.friction_coefficient > 0.0).then_some(z.friction_coefficient),
        })
        .collect();
    let site = instrument.roles.key.map(|body| Site {
        body,
        point: instrument.roles.key_front_m,
        direction: [0.0, -1.0],
        stiffness: instrument.finger.stiffness_n_per_m,
        damping: instrument.finger.damping_n_s_per_m,
    });
    Model::new(&bodies, &springs, &zones, site, instrument.gravity_m_s2)
}

fn curve(curve: &instrument::Curve) -> Curve<f64> {
    match *curve {
        instrument::Curve::Line { point_m, normal } => Curve::Line { point: point_m, normal },
        instrument::Curve::Segment { from_m, to_m, rounding_m } => {
            let [x, y] = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
            let length = x.hypot(y);
            Curve::Segment { from: from_m, direction: [x / length, y / length], length, rounding: rounding_m }
        }
        instrument::Curve::Disc { center_m, radius_m } => Curve::Disc { center: center_m, radius: radius_m },
    }
}

/// The angles as drawn, one per body.
pub fn drawn_angles<const B: usize>(instrument: &Instrument) -> [f64; B] {
    core::array::from_fn(|i| instrument.bodies.get(i).map_or(0.0, |b| b.angle_rad))
}

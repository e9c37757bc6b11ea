//! From the instrument to the engine's model.

use moreau::{
    Body, ContactCurve, DescriptionPart, Dwell, Exponent, Felt, GROUND, Model, ModelError, Scalar, Site, Spring,
    Yields, Zone,
};
use moreau_kernels::{OwnedDescription, Probes};

use crate::grand::KEY_DOWN;
use crate::instrument::{self, Instrument};

/// Assembles the model of an instrument, for any engine size that holds it, in single or double precision.
///
/// # Errors
/// [`ModelError`] if the size is too small (the instrument itself has been validated).
pub fn assemble<T: Scalar, const B: usize, const Z: usize>(
    instrument: &Instrument,
) -> Result<Model<T, B, Z>, ModelError> {
    describe(instrument).model()
}

/// Probes observed after every step: the hammer's strike point and the string.
pub fn probes(instrument: &Instrument) -> Probes {
    let roles = &instrument.roles;
    Probes { point: roles.hammer.map(|hammer| (hammer, roles.hammer_strike_point_m)), zone: roles.string }
}

/// An instrument as the engine's mechanism, in single or double precision.
pub fn describe<T: Scalar>(instrument: &Instrument) -> OwnedDescription<T> {
    let (t, vector) = (T::from_f64, |v: [f64; 2]| v.map(T::from_f64));
    let ground = |body: Option<usize>| body.unwrap_or(GROUND);
    let bodies: Vec<Body<T>> = instrument
        .bodies
        .iter()
        .map(|b| Body {
            parent: ground(b.parent),
            pivot: vector(b.pivot_m),
            mass: t(b.mass_kg),
            inertia: t(b.inertia_kg_m2),
            center_of_mass: vector(b.center_of_mass_m),
            dry: t(b.friction_torque_n_m),
            viscous: t(b.viscous_n_m_s),
        })
        .collect();
    let drawn = |body: usize| {
        let b = &instrument.bodies[body];
        b.angle_rad - b.parent.map_or(0.0, |p| instrument.bodies[p].angle_rad)
    };
    let springs: Vec<Spring<T>> = instrument
        .springs
        .iter()
        .map(|s| Spring {
            body: s.body,
            torque: t(s.torque_n_m),
            stiffness: t(s.stiffness_n_m_per_rad),
            reference: t(drawn(s.body)),
        })
        .collect();
    let zones: Vec<Zone<T>> = instrument
        .zones
        .iter()
        .map(|z| Zone {
            disc_body: ground(z.disc_body),
            center: vector(z.disc_center_m),
            radius: t(z.disc_radius_m),
            curve_body: ground(z.curve_body),
            curve: curve(&z.curve),
            felt: felt(&z.felt),
            friction: (z.friction_coefficient > 0.0).then_some(t(z.friction_coefficient)),
        })
        .collect();
    let dwell = |part: DescriptionPart, dwell: Option<instrument::Dwell>| {
        dwell.map(|dwell| Dwell { part, ratio: t(dwell.ratio), time: t(dwell.time_s) })
    };
    let pivots = instrument.bodies.iter().enumerate().filter_map(|(i, b)| dwell(DescriptionPart::Body(i), b.dwell));
    let contacts =
        instrument.zones.iter().enumerate().filter_map(|(z, zone)| dwell(DescriptionPart::Zone(z), zone.dwell));
    let dwells = pivots.chain(contacts).collect();
    let yields = crate::strings::yielding_zones(instrument)
        .into_iter()
        .map(|(zone, excursion_m)| Yields { zone, excursion: t(excursion_m) })
        .collect();
    let site = instrument.roles.key.map(|body| Site {
        body,
        point: vector(instrument.roles.key_front_m),
        direction: KEY_DOWN.map(t),
        stiffness: t(instrument.finger.stiffness_n_per_m),
        damping: t(instrument.finger.damping_n_s_per_m),
    });
    let angles = instrument.bodies.iter().map(|b| t(b.angle_rad)).collect();
    let gravity = t(instrument.gravity_m_per_s2);
    OwnedDescription { bodies, springs, zones, dwells, yields, site, gravity, angles }
}

/// The engine's felt law.
pub fn felt<T: Scalar>(felt: &instrument::Felt) -> Felt<T> {
    let t = T::from_f64;
    Felt { stiffness: t(felt.stiffness), exponent: Exponent::new(t(felt.exponent)), loss: felt.loss.map(t) }
}

fn curve<T: Scalar>(curve: &instrument::Curve) -> ContactCurve<T> {
    let (t, vector) = (T::from_f64, |v: [f64; 2]| v.map(T::from_f64));
    match *curve {
        instrument::Curve::Line { point_m, normal } => {
            ContactCurve::Line { point: vector(point_m), normal: vector(normal) }
        }
        instrument::Curve::Segment { from_m, to_m, rounding_m } => {
            let [x, y] = [to_m[0] - from_m[0], to_m[1] - from_m[1]];
            let length = libm::hypot(x, y);
            ContactCurve::Segment {
                from: vector(from_m),
                direction: vector([x / length, y / length]),
                length: t(length),
                rounding: t(rounding_m),
            }
        }
        instrument::Curve::Disc { center_m, radius_m } => {
            ContactCurve::Disc { center: vector(center_m), radius: t(radius_m) }
        }
    }
}

/// The angles as drawn, one per body.
pub fn drawn_angles<T: Scalar, const B: usize>(instrument: &Instrument) -> [T; B] {
    core::array::from_fn(|i| instrument.bodies.get(i).map_or(T::ZERO, |b| T::from_f64(b.angle_rad)))
}

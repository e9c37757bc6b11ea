//! An instrument's mechanism as JSON: what another program needs to compute the same action.
//!
//! Units are SI (m, kg, s, N, rad); x toward the back of the piano, y up, angles counter-clockwise. Format
//! `erard-mechanism/2`:
//!
//! - `gravity_m_s2`: toward -y.
//! - `bodies`, parents before children. `parent`: index of the body it is hinged on, null for the ground. `pivot_m`: in
//!   the parent's frame. Each body's frame has its origin at the pivot; `center_of_mass_m` is in it, `inertia_kg_m2`
//!   about it. The pivot's torque on the body, against the rate relative to the parent: `dry_friction_N_m` times its
//!   set-valued sign plus `viscous_friction_N_m_s` times it. `rest_angle_rad`: the frame's absolute angle at rest, dry
//!   friction included.
//! - `springs`: torque on `body`, opposite on its parent: `torque_N_m - stiffness_N_m_per_rad (relative angle -
//!   reference_rad)`.
//! - `zones`: a disc (radius 0: a point) on one body against a curve on another (null: the ground). With d the distance
//!   from the disc's centre to the curve and n the curve's outward normal there, the compression is g = radius - d, and
//!   where g > 0 the felt pushes the disc along n with `max(0, k g^r + b g^2 dg/dt)`. Curves: `line` (`point_m`, unit
//!   `normal`), `segment` (all points within `rounding_m` of the straight piece from `from_m` to `to_m`), `disc`
//!   (`center_m`, `radius_m`). `friction_coefficient` mu: a tangential force of at most mu times the felt's, against
//!   the slip at the contact point.
//! - `finger`: the point that the finger pushes and the world direction of a positive force.
//! - `strike`: the striking body and the strike point in its frame; the world direction toward the string, of length 1,
//!   and the strike point's coordinate in it when the string is met. `radius_m`: its distance from the hammer's centre
//!   pin.
//! - `blow`: the mf stroke's force in cubic pieces (Hermite's form: forces and slopes at the samples; constant before
//!   and after them), the factors that it is played with, and how long. `hold`: a constant force under which the hammer
//!   is caught and held, and the instants between which its angle is compared.

use erard_core::instrument::{Body, Curve, Instrument, Spring, Zone};
use serde_json::{Value, json};

use super::play::{Action, HOLD_N, HOLD_S, SCALES};

/// The document.
pub fn mechanism<const B: usize, const Z: usize, const N: usize>(
    action: &Action<B, Z, N>,
) -> Result<String, Box<dyn std::error::Error>> {
    let Action { instrument, strike, stroke, .. } = action;
    let key = instrument.roles.key.ok_or_else(|| format!("{}: a blow needs the role key", instrument.name))?;
    let document = json!({
        "format": "erard-mechanism/2",
        "instrument": instrument.name,
        "gravity_m_s2": instrument.gravity_m_per_s2,
        "bodies": bodies(instrument, &action.rest),
        "springs": springs(instrument),
        "zones": zones(instrument),
        "finger": { "body": key, "point_m": instrument.roles.key_front_m, "direction": [0.0, -1.0] },
        "strike": {
            "body": strike.body,
            "point_m": strike.point_m,
            "direction": strike.direction,
            "meets_m": strike.meets_m,
            "radius_m": strike.radius_m,
        },
        "blow": {
            "until_s": action.press_s,
            "scales": SCALES,
            "times_s": stroke.times_s(),
            "forces_N": stroke.forces_n(),
            "slopes_N_per_s": stroke.slopes_n_per_s(),
        },
        "hold": { "force_N": HOLD_N, "from_s": HOLD_S[0], "until_s": HOLD_S[1] },
    });
    Ok(serde_json::to_string_pretty(&document)?)
}

fn bodies(instrument: &Instrument, rest: &[f64]) -> Vec<Value> {
    let body = |(b, angle): (&Body, &f64)| {
        json!({
            "name": b.name,
            "parent": b.parent,
            "pivot_m": b.pivot_m,
            "mass_kg": b.mass_kg,
            "inertia_kg_m2": b.inertia_kg_m2,
            "center_of_mass_m": b.center_of_mass_m,
            "dry_friction_N_m": b.friction_torque_n_m,
            "viscous_friction_N_m_s": b.viscous_n_m_s,
            "rest_angle_rad": angle,
        })
    };
    instrument.bodies.iter().zip(rest).map(body).collect()
}

fn springs(instrument: &Instrument) -> Vec<Value> {
    let drawn = |body: Option<usize>| body.map_or(0.0, |b| instrument.bodies[b].angle_rad);
    let spring = |s: &Spring| {
        json!({
            "name": s.name,
            "body": s.body,
            "torque_N_m": s.torque_n_m,
            "stiffness_N_m_per_rad": s.stiffness_n_m_per_rad,
            "reference_rad": drawn(Some(s.body)) - drawn(instrument.bodies[s.body].parent),
        })
    };
    instrument.springs.iter().map(spring).collect()
}

fn zones(instrument: &Instrument) -> Vec<Value> {
    let zone = |z: &Zone| {
        let curve = match z.curve {
            Curve::Line { point_m, normal } => json!({ "line": { "point_m": point_m, "normal": normal } }),
            Curve::Segment { from_m, to_m, rounding_m } => {
                json!({ "segment": { "from_m": from_m, "to_m": to_m, "rounding_m": rounding_m } })
            }
            Curve::Disc { center_m, radius_m } => json!({ "disc": { "center_m": center_m, "radius_m": radius_m } }),
        };
        let moreau::Loss::Quadratic(papers) = z.felt.loss else {
            eprintln!(
                "error: zone `{}`: its felt has another loss than the papers' (`damping_N_s_per_m3`), the only one that the \
                 other programs know",
                z.name
            );
            std::process::exit(2);
        };
        json!({
            "name": z.name,
            "disc": { "body": z.disc_body, "center_m": z.disc_center_m, "radius_m": z.disc_radius_m },
            "curve_body": z.curve_body,
            "curve": curve,
            "felt": {
                "stiffness_N_per_m_r": z.felt.stiffness,
                "exponent": z.felt.exponent,
                "damping_N_s_per_m3": papers.damping,
            },
            "friction_coefficient": z.friction_coefficient,
        })
    };
    instrument.zones.iter().map(zone).collect()
}

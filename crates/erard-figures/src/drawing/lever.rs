//! A key alone: the picture of the one-degree-of-freedom model, in which all the rest of the action is an inertia and a
//! moment on the key.

use super::fallback::circle;
use super::material::Finish;
use super::piece::{Carrier, Piece};
use erard::instrument::{Curve, Instrument, Vec2, Zone};

/// Density of the disc that represents the inertia, kg per m2 of its face: lead as thick as a key is wide.
const LEAD_KG_PER_M2: f64 = 11_340.0 * 0.0127;

/// Draws a key with its stops; `None` for what is more than a key, or stops that are no lines on the ground.
pub(super) fn draw(instrument: &Instrument) -> Option<Vec<Piece>> {
    let ([body], Some(0)) = (&instrument.bodies[..], instrument.roles.key) else { return None };
    let placed = instrument.drawn();
    let pin = placed[0];
    let mm = |p: Vec2| p.map(|c| 1e3 * c);
    let upright = |p: Vec2| mm([p[0] - pin.pivot_m[0], p[1] - pin.pivot_m[1]]);
    // Every stop: where the key meets it, and its level, relative to the pin.
    let stop = |zone: &Zone| {
        let Curve::Line { point_m, .. } = zone.curve else { return None };
        (zone.disc_body == Some(0) && zone.curve_body.is_none())
            .then(|| (upright(pin.to_world(zone.disc_center_m)), upright(point_m)))
    };
    let stops: Vec<(Vec2, Vec2)> = instrument.zones.iter().map(stop).collect::<Option<_>>()?;
    let press = upright(pin.to_world(instrument.roles.key_front_m));
    let front = stops.iter().map(|(at, _)| at[0]).fold(press[0], f64::min);
    let back = stops.iter().map(|(at, _)| at[0]).fold(0.6 * -front, f64::max);
    let (top, bottom) = (press[1], -22.0);
    let mut out = Vec::new();
    let world = |corner: &Vec2| [1e-3 * corner[0] + pin.pivot_m[0], 1e-3 * corner[1] + pin.pivot_m[1]];
    let mut piece = |name: &str, is_key: bool, finish, smooth, corners: &[Vec2]| {
        let carrier = if is_key { Carrier::Body(0) } else { Carrier::Ground };
        let to = |corner: &Vec2| if is_key { pin.from_world(world(corner)) } else { world(corner) };
        out.push(Piece { name: name.into(), carrier, finish, outline_m: corners.iter().map(to).collect(), smooth });
    };
    let block = |left: f64, low: f64, right: f64, high: f64| [[left, low], [right, low], [right, high], [left, high]];
    // A disc of lead about the pin has the inertia that the whole action is: J = pi/2 rho R^4.
    let radius = 1e3 * (2.0 * body.inertia_kg_m2 / (std::f64::consts::PI * LEAD_KG_PER_M2)).powf(0.25);
    piece("inertia of the whole action", true, Finish::Symbol, true, &circle([0.0, 0.0], radius));
    piece("inertia, mark", true, Finish::Metal, false, &block(-0.6, radius - 12.0, 0.6, radius - 2.0));
    piece("key frame", false, Finish::DarkWood, false, &block(front - 22.0, bottom - 12.0, back + 34.0, bottom));
    piece(
        "balance rail",
        false,
        Finish::DarkWood,
        false,
        &[[-26.0, bottom], [26.0, bottom], [15.0, -4.0], [-15.0, -4.0]],
    );
    piece("balance rail, punching", false, Finish::Cloth, false, &block(-9.5, -4.0, 9.5, 0.0));
    for (at, line) in &stops {
        let (name, high) = (if at[0] < 0.0 { "front punching" } else { "back rail cloth" }, line[1]);
        piece(
            "rail, of a stop",
            false,
            Finish::DarkWood,
            false,
            &block(at[0] - 24.0, bottom, at[0] + 24.0, high - 4.2),
        );
        piece(name, false, Finish::Cloth, false, &block(at[0] - 14.0, high - 4.2, at[0] + 14.0, high));
    }
    // The stick touches its stops with the corners of its underside.
    let mut under: Vec<Vec2> = stops.iter().map(|(at, _)| *at).collect();
    under.push([0.0, 0.0]);
    under.sort_by(|a, b| a[0].total_cmp(&b[0]));
    let mut stick = vec![[front - 5.0, top - 2.2], [front - 5.0, under[0][1] + 2.0]];
    stick.extend(under);
    stick.extend([[back + 12.0, stick[stick.len() - 1][1] + 1.0], [back + 12.0, top - 6.0], [back - 40.0, top - 2.2]]);
    piece("key", true, Finish::Wood, false, &stick);
    let (name, finish) = if instrument.roles.is_sharp { ("sharp", Finish::Ebony) } else { ("key, top", Finish::Ivory) };
    piece(name, true, finish, false, &block(front - 7.5, top - 2.2, front + 137.0, top));
    piece("balance rail, pin", false, Finish::Metal, false, &block(-1.9, -3.0, 1.9, top + 9.0));
    Some(out)
}

//! Parts of a grand action that are round, or vary in number or size with more than a place.

use super::chain::{Look, carried};
use super::parts::{Component, Parts};
use super::places::{Place, Places};
use crate::drawing::fallback::circle;
use crate::drawing::material::Finish;
use crate::drawing::piece::{Carrier, Piece};
use erard::instrument::{Instrument, Placement, Vec2};

/// What a picture is drawn from.
pub(super) struct Scene<'a> {
    pub instrument: &'a Instrument,
    pub parts: &'a Parts,
    pub places: &'a Places<'a>,
    pub drawn: &'a [Placement],
}

impl Scene<'_> {
    fn piece(&self, name: &str, on: Component, finish: Finish, smooth: bool, corners: &[Vec2]) -> Vec<Piece> {
        carried(self.instrument, self.parts, self.drawn, &Look { name, on, finish, smooth }, corners)
    }

    /// A circle about a point of a component, mm.
    fn round(&self, name: &str, on: Component, finish: Finish, center: Vec2, radius: f64) -> Vec<Piece> {
        self.piece(name, on, finish, true, &circle(center, radius))
    }
}

/// Strike weight of a shank alone (Stanwood 1995: 1.8 to 2.0 g), g: what is more is the head's.
const SHANK_G: f64 = 1.7;
/// The head that the outlines show, g.
const HEAD_G: f64 = 7.0;

/// The head's size against the one that the outlines show. Heads are as thick from bass to treble, so that their area
/// goes with their mass.
pub(super) fn head_scale(instrument: &Instrument, parts: &Parts) -> f64 {
    // Moments of the hammer's pieces about the first one's pin.
    let (mut moment, mut offset) = (0.0, 0.0);
    for (index, &body) in parts.hammer.iter().enumerate() {
        let body = &instrument.bodies[body];
        offset += if index > 0 { body.pivot_m[0] } else { 0.0 };
        moment += 1e3 * body.mass_kg * (offset + body.center_of_mass_m[0]);
    }
    let strike_g = moment / (offset + instrument.roles.hammer_strike_point_m[0]);
    ((strike_g - SHANK_G).max(0.0) / HEAD_G).sqrt().clamp(0.45, 1.5)
}

/// Mass of a lead, g, and how far two neighbours stand apart, mm.
const LEAD_G: f64 = 14.0;
const LEAD_SPACING: f64 = 17.0;
/// A key without leads: its mass, g, and its moment about the balance pin, g mm, for a key as long as the outlines
/// show.
const BARE_G: f64 = 112.0;
const BARE_G_MM: f64 = -1449.0;
const BARE_LENGTH: f64 = 490.0;

/// The leads that the key's mass and centre of mass speak of: an estimate, for no file says where they are.
pub(super) fn leads(scene: &Scene<'_>) -> Vec<Piece> {
    let find = |place| scene.places.find(place).map(|found| found.at);
    let (Some([front, _]), Some([back, under]), Some([_, top])) =
        (find(Place::KeyFront), find(Place::KeyBack), find(Place::KeyTop))
    else {
        return Vec::new();
    };
    let longer = (back - front) / BARE_LENGTH;
    let (mut mass, mut moment) = (0.0, 0.0);
    for &body in &scene.parts.key {
        let on = &scene.instrument.bodies[body];
        mass += 1e3 * on.mass_kg;
        moment += 1e3 * on.mass_kg * scene.places.seen(Some(body), on.center_of_mass_m, Component::Key)[0];
    }
    let leads_g = mass - BARE_G * longer;
    let count = (leads_g / LEAD_G).round().clamp(0.0, 8.0) as usize;
    if count == 0 {
        return Vec::new();
    }
    let middle = (moment - BARE_G_MM * longer * longer) / leads_g;
    let half = 0.5 * LEAD_SPACING * (count - 1) as f64;
    let middle = middle.clamp(front + 15.0 + half, (back - 15.0 - half).max(front + 15.0 + half));
    let height = 0.5 * (under.max(0.0) + top - 2.2);
    (0..count)
        .rev()
        .flat_map(|index| {
            let x = middle + LEAD_SPACING * index as f64 - half;
            scene.round("key lead", Component::Key, Finish::Lead, [x, height], 6.2)
        })
        .collect()
}

/// The capstan: a dome about its disc's centre, on a stem from the key.
pub(super) fn capstan(scene: &Scene<'_>) -> Vec<Piece> {
    let (Some(([x, y], radius)), Some(top)) =
        (scene.places.disc(scene.parts.capstan, Component::Key), scene.places.find(Place::CapstanTop))
    else {
        return Vec::new();
    };
    let half = 6.5_f64.min(0.9 * radius).max(1.5);
    let deepest = (top.at[1] - 2.2).min(y + radius - 3.0);
    let brim = y + (radius * radius - half * half).max(0.0).sqrt();
    let rim = (brim - 3.3).max(deepest + 0.5);
    let mut corners = vec![[x - 3.0, deepest], [x + 3.0, deepest], [x + 3.0, rim - 0.6], [x + half, rim]];
    let span = (half / radius.max(half)).asin();
    const ARC: u32 = 24;
    for step in 0..=ARC {
        let angle = span * (1.0 - 2.0 * f64::from(step) / f64::from(ARC));
        corners.push([x + radius.max(half) * angle.sin(), y + radius - radius.max(half) * (1.0 - angle.cos())]);
    }
    corners.extend([[x - half, rim], [x - 3.0, rim - 0.6]]);
    scene.piece("capstan", Component::Key, Finish::Metal, false, &corners)
}

/// The knuckle and its core.
pub(super) fn knuckle(scene: &Scene<'_>) -> Vec<Piece> {
    let Some((center, radius)) = scene.places.disc(scene.parts.jack_knuckle, Component::Hammer) else {
        return Vec::new();
    };
    let mut out = scene.round("knuckle", Component::Hammer, Finish::Leather, center, radius.max(0.8));
    if radius > 2.6 {
        out.extend(scene.round("knuckle, core", Component::Hammer, Finish::Cloth, center, radius - 2.1));
    }
    out
}

/// The tail's corner that the check catches.
pub(super) fn tail(scene: &Scene<'_>) -> Vec<Piece> {
    let tail = scene.parts.check.and_then(|check| scene.places.disc(check, Component::Hammer));
    let Some((center, radius)) = tail else { return Vec::new() };
    scene.round("hammer moulding, tail", Component::Hammer, Finish::Wood, center, radius.max(0.8))
}

/// From the underlever's block to the damper's head: the wire, guided by its rail, and the head with its felt on the
/// string.
pub(super) fn damper_head(scene: &Scene<'_>) -> Vec<Piece> {
    /// Where the wire is held, in the damper's frame, mm.
    const HELD: Vec2 = [-22.0, 12.0];
    /// Thickness of a string as drawn, mm.
    const STRING: f64 = 1.4;
    let (Some(damper), Some(string)) = (scene.parts.damper, scene.places.find(Place::StringLine)) else {
        return Vec::new();
    };
    let pin = scene.places.origin(Component::Damper);
    let [x, low] = [pin[0] + HELD[0], pin[1] + HELD[1]];
    let on_string = string.at[1] + STRING;
    let drawn_m = [1e-3 * x, 1e-3 * low];
    let point_m = scene.drawn[damper].from_world(drawn_m);
    let carrier = Carrier::Point { body: damper, point_m, drawn_m, is_guided: true };
    let piece = |name: &str, finish, corners: &[Vec2]| Piece {
        name: name.into(),
        carrier,
        finish,
        outline_m: corners.iter().map(|c| c.map(|c| 1e-3 * c)).collect(),
        smooth: true,
    };
    let rectangle = |left: f64, below: f64, right: f64, above: f64| {
        [
            [left, below],
            [left, below],
            [right, below],
            [right, below],
            [right, above],
            [right, above],
            [left, above],
            [left, above],
        ]
    };
    vec![
        piece("damper, wire", Finish::Metal, &rectangle(x - 0.9, low - 2.0, x + 0.9, on_string + 14.0)),
        piece("damper, felt", Finish::Felt, &rectangle(x - 21.0, on_string, x + 21.0, on_string + 7.0)),
        piece(
            "damper",
            Finish::DarkWood,
            &[
                [x - 21.5, on_string + 7.0],
                [x - 21.5, on_string + 7.0],
                [x + 21.5, on_string + 7.0],
                [x + 21.5, on_string + 7.0],
                [x + 21.5, on_string + 15.0],
                [x + 20.0, on_string + 18.0],
                [x + 16.0, on_string + 19.0],
                [x - 16.0, on_string + 19.0],
                [x - 20.0, on_string + 18.0],
                [x - 21.5, on_string + 15.0],
            ],
        ),
    ]
}

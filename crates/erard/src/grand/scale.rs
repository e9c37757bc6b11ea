//! Parts on the scale: as a technician lays them there, each on its own pin.

use super::Parts;
use crate::instrument::{Body, Instrument, Vec2};

/// Grams per kilogram.
const G_PER_KG: f64 = 1e3;

/// What the scale under the key's front end shows, g: the key on its balance pin, level as drawn. `front_m` is the distance of
/// the front from the pin, positive; a key that is heavier behind shows less than nothing.
#[must_use]
pub fn front_weight_g(instrument: &Instrument, parts: &Parts, front_m: f64) -> f64 {
    let key = &instrument.bodies[parts.key];
    -G_PER_KG * key.mass_kg * drawn_x(key, key.center_of_mass_m) / front_m
}

/// What the scale under the strike point's place shows, g: the hammer on its pin, its shank level.
#[must_use]
pub fn strike_weight_g(instrument: &Instrument, parts: &Parts) -> f64 {
    let hammer = &instrument.bodies[parts.hammer];
    // The hammer's own frame lies along the shank.
    G_PER_KG * hammer.mass_kg * hammer.center_of_mass_m[0] / instrument.roles.hammer_head_m[0]
}

/// Moment about its pin of a part's weight and the pin's dry friction, that slows the part down while it rises with its own x axis level (a
/// hammer's shank), N m.
#[must_use]
pub fn falling_moment_n_m(instrument: &Instrument, body: usize) -> f64 {
    let body = &instrument.bodies[body];
    body.mass_kg * instrument.gravity_m_s2 * body.center_of_mass_m[0] + body.friction_torque_n_m
}

/// What the scale under the capstan's place shows, g: the whippen with all that rides on it, on its pin, as drawn. `arm_m` is the distance
/// of that place from the pin along x, with its sign.
#[must_use]
pub fn whippen_weight_g(instrument: &Instrument, parts: &Parts, arm_m: f64) -> f64 {
    let bodies = &instrument.bodies;
    let mut moment = 0.0;
    for body in Parts::riders(instrument, parts.whippen) {
        let mut x = drawn_x(&bodies[body], bodies[body].center_of_mass_m);
        let mut at = body;
        while at != parts.whippen {
            let Some(parent) = bodies[at].parent else { break };
            x += drawn_x(&bodies[parent], bodies[at].pivot_m);
            at = parent;
        }
        moment += bodies[body].mass_kg * x;
    }
    G_PER_KG * moment / arm_m
}

/// How far a point of a body lies from its pivot along x, as drawn, m.
fn drawn_x(body: &Body, [x, y]: Vec2) -> f64 {
    let (s, c) = body.angle_rad.sin_cos();
    c * x - s * y
}

//! Weights of parts on a scale, as a technician measures them, each part on its own pin.

use super::{AnatomyError, Parts};
use crate::index::IndexError;
use crate::instrument::{Body, Instrument};

/// Grams per kilogram.
const G_PER_KG: f64 = 1e3;

fn body_of(instrument: &Instrument, body: usize) -> Result<&Body, IndexError> {
    IndexError::check("body", body, instrument.bodies.len())?;
    Ok(&instrument.bodies[body])
}

/// The front weight, g, which a scale under the key's front end shows: the key on its balance pin, level as drawn.
/// `front_m` is the distance of the front from the pin, positive; for a key that is heavier behind it is negative.
///
/// # Errors
/// [`AnatomyError::Foreign`]: the parts are not those of the instrument.
pub fn front_weight_g(instrument: &Instrument, parts: &Parts, front_m: f64) -> Result<f64, AnatomyError> {
    let key = body_of(instrument, parts.key)?;
    let [level_m, _] = instrument.drawn()[parts.key].direction_to_world(key.center_of_mass_m);
    Ok(-G_PER_KG * key.mass_kg * level_m / front_m)
}

/// The strike weight, g, which a scale under the strike point shows: the hammer on its pin, its shank level.
///
/// # Errors
/// [`AnatomyError::Foreign`]: the parts are not those of the instrument.
pub fn strike_weight_g(instrument: &Instrument, parts: &Parts) -> Result<f64, AnatomyError> {
    let hammer = body_of(instrument, parts.hammer)?;
    // The hammer's own frame lies along the shank.
    Ok(G_PER_KG * hammer.mass_kg * hammer.center_of_mass_m[0] / instrument.roles.hammer_strike_point_m[0])
}

/// Moment about its pin of a part's weight and the pin's dry friction, that slows the part down while it rises with its
/// own x axis level (a hammer's shank), N m.
///
/// # Errors
/// There is no such body.
pub fn falling_moment_n_m(instrument: &Instrument, body: usize) -> Result<f64, IndexError> {
    let body = body_of(instrument, body)?;
    Ok(body.mass_kg * instrument.gravity_m_per_s2 * body.center_of_mass_m[0] + body.friction_torque_n_m)
}

/// The weight of the whippen, g, which a scale under the capstan's place shows: the whippen with all that rides on it,
/// on its pin, as drawn. `arm_m` is the distance of that place from the pin along x, with its sign.
///
/// # Errors
/// [`AnatomyError::Foreign`]: the parts are not those of the instrument.
pub fn whippen_weight_g(instrument: &Instrument, parts: &Parts, arm_m: f64) -> Result<f64, AnatomyError> {
    body_of(instrument, parts.whippen)?;
    let drawn = instrument.drawn();
    let pin_m = drawn[parts.whippen].pivot_m[0];
    let moments = Parts::riders(instrument, parts.whippen).map(|body| {
        let own = &instrument.bodies[body];
        own.mass_kg * (drawn[body].to_world(own.center_of_mass_m)[0] - pin_m)
    });
    Ok(G_PER_KG * moments.sum::<f64>() / arm_m)
}

/// What springs between the whippen and its rail lift, g, at the capstan's place, with the torque that they have as
/// drawn; 0 without such springs, and without gravity. `arm_m` is the distance of that place from the whippen's pin
/// along x, with its sign.
///
/// # Errors
/// [`AnatomyError::Foreign`]: the parts are not those of the instrument.
pub fn whippen_assist_g(instrument: &Instrument, parts: &Parts, arm_m: f64) -> Result<f64, AnatomyError> {
    body_of(instrument, parts.whippen)?;
    let own = instrument.springs.iter().filter(|spring| spring.body == parts.whippen);
    let torque_n_m: f64 = own.map(|spring| spring.torque_n_m).sum();
    Ok(if torque_n_m == 0.0 || instrument.gravity_m_per_s2 <= 0.0 {
        0.0
    } else {
        G_PER_KG * torque_n_m / (instrument.gravity_m_per_s2 * arm_m)
    })
}

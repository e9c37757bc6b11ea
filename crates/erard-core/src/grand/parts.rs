//! Parts taken out of the action, or out of the key's reach, to weigh the rest.

use super::{Anatomy, AnatomyError};
use crate::index::IndexError;
use crate::instrument::{Instrument, Zone};

/// The parts that are weighed, and where let-off begins. Indices into
/// [`bodies`](crate::instrument::InstrumentFields::bodies) and [`zones`](crate::instrument::InstrumentFields::zones).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parts {
    /// The key.
    pub key: usize,
    /// The hammer.
    pub hammer: usize,
    /// The body on the ground that carries, or is, the jack.
    pub whippen: usize,
    /// Zones between jack or repetition lever and the ground: let-off button and drop screw. The first of them to touch
    /// begins let-off.
    pub let_off_stops: Vec<usize>,
    /// Zone in which the key lifts the damper, and the damper; `None` without a damper.
    pub damper: Option<(usize, usize)>,
}

impl Parts {
    /// Finds the parts of an instrument.
    ///
    /// # Errors
    /// The instrument is not a grand action.
    pub fn of(instrument: &Instrument) -> Result<Self, AnatomyError> {
        let anatomy = Anatomy::find(instrument)?;
        let rides_on_whippen = |body: usize| body != anatomy.whippen && carries(instrument, anatomy.whippen, body);
        let stops_a_rider = |(_, zone): &(usize, &Zone)| match (zone.disc_body, zone.curve_body) {
            (Some(body), None) | (None, Some(body)) => rides_on_whippen(body),
            _ => false,
        };
        Ok(Parts {
            key: anatomy.key,
            hammer: anatomy.hammer,
            whippen: anatomy.whippen,
            let_off_stops: instrument.zones.iter().enumerate().filter(stops_a_rider).map(|(zone, _)| zone).collect(),
            damper: anatomy.key_damper.zip(anatomy.damper),
        })
    }

    /// The bodies that move as one when a part is taken out of the action: itself and what is hinged on it.
    pub fn riders(instrument: &Instrument, part: usize) -> impl Iterator<Item = usize> + '_ {
        (0..instrument.bodies.len()).filter(move |&body| carries(instrument, part, body))
    }
}

fn carries(instrument: &Instrument, part: usize, mut body: usize) -> bool {
    while body != part {
        match instrument.bodies[body].parent {
            Some(parent) => body = parent,
            None => return false,
        }
    }
    true
}

/// The instrument under its sustaining pedal: the damper hangs out of the key's reach.
///
/// # Errors
/// [`AnatomyError::Foreign`]: the parts are not those of the instrument.
pub fn pedal_down(instrument: &Instrument, parts: &Parts) -> Result<Instrument, AnatomyError> {
    let mut lifted = instrument.clone();
    if let Some((zone, _)) = parts.damper {
        IndexError::check("zone", zone, instrument.zones.len())?;
        // A felt without stiffness or damping gives no force: the key passes as if nothing were there.
        lifted.fields.zones[zone].felt.remove();
        lifted.fields.zones[zone].friction_coefficient = 0.0;
    }
    Ok(lifted)
}

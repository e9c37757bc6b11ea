//! Who is who in an action, beyond what its roles say.

use super::MeasureError;
use crate::instrument::{Instrument, Zone};

/// The parts that a technician handles. Indices into [`Instrument::bodies`] and [`Instrument::zones`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parts {
    /// The key.
    pub key: usize,
    /// The hammer.
    pub hammer: usize,
    /// The body on the ground that carries, or is, what pushes the knuckle.
    pub whippen: usize,
    /// Jack and repetition lever: what pushes the knuckle.
    pub pushers: Vec<usize>,
    /// Where a pusher meets the ground: let-off button and drop screw. The first of them to touch begins let-off.
    pub let_off_stops: Vec<usize>,
    /// Where the key lifts the damper; `None` where there is none.
    pub damper_lift: Option<usize>,
}

fn lacking<T>(what: &str) -> Result<T, MeasureError> {
    Err(MeasureError::NotAnAction(what.to_owned()))
}

/// The zone's other body, if `body` is one of its two; `Some(None)` is the ground.
fn other_than(zone: &Zone, body: usize) -> Option<Option<usize>> {
    match (zone.disc_body, zone.curve_body) {
        (Some(disc), other) if disc == body => Some(other),
        (other, Some(curve)) if curve == body => Some(other),
        _ => None,
    }
}

impl Parts {
    /// Finds the parts of an instrument.
    ///
    /// # Errors
    /// When it names no key, hammer or knuckle, or nothing lets the hammer off.
    pub fn of(instrument: &Instrument) -> Result<Self, MeasureError> {
        let (roles, zones) = (&instrument.roles, &instrument.zones);
        let Some(key) = roles.key else { return lacking("`roles` names no key") };
        let Some(hammer) = roles.hammer else { return lacking("`roles` names no hammer") };
        let pushers: Vec<usize> =
            roles.knuckle.iter().filter_map(|&zone| other_than(&zones[zone], hammer).flatten()).collect();
        let Some(&first) = pushers.first() else {
            return lacking("`roles.knuckle` names nothing that pushes the hammer");
        };
        let whippen = root(instrument, first);
        if whippen == key || whippen == hammer {
            return lacking("the knuckle is pushed without a whippen");
        }
        let touching =
            |body: usize| zones.iter().enumerate().filter_map(move |(z, zone)| Some((z, other_than(zone, body)?)));
        let mut let_off_stops: Vec<usize> = pushers
            .iter()
            .flat_map(|&pusher| touching(pusher).filter(|(_, other)| other.is_none()).map(|(zone, _)| zone))
            .collect();
        let_off_stops.extend(roles.let_off.filter(|zone| !let_off_stops.contains(zone)));
        if let_off_stops.is_empty() {
            return lacking("nothing lets the hammer off: neither jack nor lever meets a stop on the ground");
        }
        // What else the key touches and the action does not need: it stands on the ground by itself.
        let damper_lift = touching(key)
            .find(|(_, other)| other.is_some_and(|body| body != hammer && root(instrument, body) != whippen))
            .map(|(zone, _)| zone);
        Ok(Parts { key, hammer, whippen, pushers, let_off_stops, damper_lift })
    }

    /// The bodies that move as one when a part is taken out of the action: itself and what is hinged on it.
    pub fn riders(instrument: &Instrument, part: usize) -> impl Iterator<Item = usize> + '_ {
        (0..instrument.bodies.len()).filter(move |&body| carries(instrument, part, body))
    }
}

fn root(instrument: &Instrument, mut body: usize) -> usize {
    while let Some(parent) = instrument.bodies[body].parent {
        body = parent;
    }
    body
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
#[must_use]
pub fn pedal_down(instrument: &Instrument, parts: &Parts) -> Instrument {
    let mut lifted = instrument.clone();
    if let Some(zone) = parts.damper_lift {
        // A felt without stiffness or damping gives no force: the key passes as if nothing were there.
        let felt = &mut lifted.zones[zone].felt;
        (felt.stiffness, felt.damping) = (0.0, 0.0);
        lifted.zones[zone].friction_coefficient = 0.0;
    }
    lifted
}

//! Finds the parts of a grand action, as a technician names them, among bodies and zones by their contacts, so that no
//! file has to name them.

use crate::index::IndexError;
use crate::instrument::{Instrument, Zone};

/// A part that a grand action needs for regulation is missing or misplaced.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AnatomyError {
    /// A role that nothing has.
    #[error("the instrument cannot be measured as a grand action: `roles` names no `{role}`")]
    NoRole {
        /// Its key in the instrument file.
        role: &'static str,
    },
    /// The let-off zone is on the ground on both sides.
    #[error("the instrument cannot be measured as a grand action: zone `{zone}` touches no body")]
    LetOffTouchesNothing {
        /// Name of the zone.
        zone: String,
    },
    /// The part that meets the let-off button does not push the knuckle.
    #[error(
        "the instrument cannot be measured as a grand action: `{body}` meets the let-off button, but no zone of `roles.knuckle` has it push the \
         hammer"
    )]
    JackPushesNothing {
        /// Name of the body.
        body: String,
    },
    /// An index of the parts is one of another instrument.
    #[error("the parts are those of another instrument: {0}")]
    Foreign(#[from] IndexError),
}

/// The parts of a grand action: indices of bodies and zones.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Anatomy {
    /// The key.
    pub key: usize,
    /// The body on the ground that carries, or is, the jack; of a whippen that bends, its first piece.
    pub whippen: usize,
    /// The hammer.
    pub hammer: usize,
    /// Strike point - string.
    pub string: usize,
    /// Jack toe - let-off button.
    pub button: usize,
    /// Jack top - knuckle.
    pub jack_knuckle: usize,
    /// Key front - punching.
    pub punching: usize,
    /// The jack.
    pub jack: usize,
    /// Hammer tail - back check.
    pub check: Option<usize>,
    /// Repetition lever - knuckle.
    pub lever_knuckle: Option<usize>,
    /// The damper: the body lifted by the key that is neither whippen nor hammer.
    pub damper: Option<usize>,
    /// Key end - damper.
    pub key_damper: Option<usize>,
}

impl Anatomy {
    /// Finds the parts: key, hammer, string, let-off, knuckle zones and key bottom by their roles; the jack is what
    /// meets the let-off button; the repetition lever is the other body that pushes the knuckle; the damper is the
    /// other body on the ground that the key touches besides whippen and hammer.
    ///
    /// # Errors
    /// A part that regulation needs is missing.
    pub fn find(instrument: &Instrument) -> Result<Self, AnatomyError> {
        let (roles, zones) = (&instrument.roles, &instrument.zones);
        let needed = |found: Option<usize>, role: &'static str| found.ok_or(AnatomyError::NoRole { role });
        let key = needed(roles.key, "key")?;
        let hammer = needed(roles.hammer, "hammer")?;
        let string = needed(roles.string, "string")?;
        let button = needed(roles.let_off, "let_off")?;
        let punching = needed(roles.key_bottom, "key_bottom")?;
        let Some(jack) = zones[button].disc_body.or(zones[button].curve_body) else {
            return Err(AnatomyError::LetOffTouchesNothing { zone: zones[button].name.clone() });
        };
        let pushers = || roles.knuckle.iter().map(|&zone| (zone, other_than(instrument, &zones[zone], hammer)));
        let Some((jack_knuckle, _)) = pushers().find(|(_, body)| *body == Some(jack)) else {
            return Err(AnatomyError::JackPushesNothing { body: instrument.bodies[jack].name.clone() });
        };
        let lever_knuckle = pushers().find(|(_, body)| body.is_some() && *body != Some(jack)).map(|(zone, _)| zone);
        let mut whippen = jack;
        while let Some(parent) = instrument.bodies[whippen].parent {
            whippen = parent;
        }
        let lifted =
            zones.iter().enumerate().filter(|(_, zone)| touches(instrument, zone, key)).find_map(|(index, zone)| {
                let other = other_than(instrument, zone, key)?;
                let is_part = |body| is_same_part(instrument, other, body);
                let stands_alone = !is_part(whippen) && !is_part(hammer) && instrument.bodies[other].parent.is_none();
                stands_alone.then_some((other, index))
            });
        Ok(Anatomy {
            key,
            whippen,
            hammer,
            string,
            button,
            jack_knuckle,
            punching,
            jack,
            check: roles.check,
            lever_knuckle,
            damper: lifted.map(|(damper, _)| damper),
            key_damper: lifted.map(|(_, zone)| zone),
        })
    }
}

/// Whether two bodies of the instrument are pieces of one part.
fn is_same_part(instrument: &Instrument, a: usize, b: usize) -> bool {
    instrument.first_piece_of(a) == instrument.first_piece_of(b)
}

/// Whether a side of the zone is a piece of a body's part.
fn touches(instrument: &Instrument, zone: &Zone, body: usize) -> bool {
    [zone.disc_body, zone.curve_body].into_iter().flatten().any(|side| is_same_part(instrument, side, body))
}

/// The side of a zone that is no piece of a body's part.
fn other_than(instrument: &Instrument, zone: &Zone, body: usize) -> Option<usize> {
    let is_piece = zone.disc_body.is_some_and(|side| is_same_part(instrument, side, body));
    if is_piece { zone.curve_body } else { zone.disc_body }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The grand's parts are found by who touches whom, and come out under the names that the file gives them.
    #[test]
    fn the_grand_has_all_its_parts() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        let a = Anatomy::find(&grand).unwrap();
        let zone = |z: Option<usize>| grand.zones[z.unwrap()].name.as_str();
        let body = |b: Option<usize>| grand.bodies[b.unwrap()].name.as_str();
        assert_eq!(zone(Some(a.jack_knuckle)), "jack_knuckle");
        assert_eq!(zone(a.lever_knuckle), "lever_knuckle");
        assert_eq!([body(Some(a.jack)), body(Some(a.hammer)), body(a.damper)], ["jack", "hammer", "damper"]);

        let mut without = grand.clone();
        without.edit(|fields| fields.roles.let_off = None).unwrap();
        assert!(Anatomy::find(&without).unwrap_err().to_string().contains("let_off"));
    }
}

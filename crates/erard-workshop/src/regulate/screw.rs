//! Known screws of a grand action, by their names in instrument files.

use erard::instrument::{Instrument, Screw, ScrewAction, Vec2};

use super::goal::Goal;

/// Work at the bench that corresponds to a screw of the file.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Handwork {
    /// A thread is turned, with this travel per turn, m.
    Thread(f64),
    /// Punchings or cloth are put under or taken out.
    Layers,
    /// A wire or a spring is bent.
    Bent,
    /// Height of the stack under the strings, which is not set at one key.
    Stack,
}

/// Threads of capstans and let-off screws, m a turn: about a 10-24 machine screw's 1.06 mm, which R. Nossaman uses as
/// damper capstans (Caut list, 23 March 2007). An estimate; D. Nereson calls most capstans' threads "fairly fine
/// machine threads" (Pianotech list, 28 February 2008).
pub const CAPSTAN_THREAD_M: f64 = 1.0e-3;
/// Threads of the small screws in whippens, hammer flanges and shanks, m a turn: an estimate, similar to 4-40 and 5-40
/// machine screws (0.64 mm).
pub const SMALL_THREAD_M: f64 = 0.65e-3;

/// A screw that `regulate` knows how to use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownScrew {
    /// Name in instrument files.
    pub name: &'static str,
    /// Part that a technician turns, bends or shims, by its name at the bench.
    pub part: &'static str,
    /// Quantity of the regulation that the screw sets, if it has another name.
    pub sets: Option<&'static str>,
    /// Direction of a technician's words for its turns; a file may count the other way.
    pub reference: Vec2,
    /// Plausible range counted from the drawn geometry, an estimate: the thread of a capstan or button, a stack of
    /// punchings, the bending of a wire, m or rad; of a spring in shares of its drawn torque.
    pub range: [f64; 2],
    /// The work at the bench.
    pub work: Handwork,
    /// Goals for which the screw is turned, each with its effect on the goal per m, rad or N m turned along
    /// `reference`: a first guess, corrected by the first turn. Sizes follow from lever arms (a hammer's head moves
    /// about ten times as far as its knuckle).
    pub goals: &'static [(Goal, f64)],
}

const UP: Vec2 = [0.0, 1.0];
const DOWN: Vec2 = [0.0, -1.0];
const TO_THE_BACK: Vec2 = [1.0, 0.0];
const TO_THE_PLAYER: Vec2 = [-1.0, 0.0];

/// All known screws. Of several screws for one goal the first is the usual one; the next takes over at the end of its
/// range.
pub const KNOWN_SCREWS: [KnownScrew; 12] = [
    KnownScrew {
        name: "jack_position",
        part: "jack screw",
        sets: None,
        reference: TO_THE_BACK,
        range: [-2e-3, 2e-3],
        work: Handwork::Thread(SMALL_THREAD_M),
        goals: &[(Goal::JackPosition, 1.8)],
    },
    KnownScrew {
        name: "lever_height",
        part: "repetition lever screw",
        sets: None,
        reference: DOWN,
        range: [-1e-3, 1e-3],
        work: Handwork::Thread(SMALL_THREAD_M),
        goals: &[(Goal::LeverHeight, 1.8)],
    },
    KnownScrew {
        name: "capstan_height",
        part: "capstan",
        sets: Some("blow"),
        reference: UP,
        range: [-4e-3, 4e-3],
        work: Handwork::Thread(CAPSTAN_THREAD_M),
        goals: &[(Goal::Blow, -12.0)],
    },
    KnownScrew {
        name: "string_height",
        part: "action height",
        sets: None,
        reference: UP,
        range: [-5e-3, 5e-3],
        work: Handwork::Stack,
        goals: &[(Goal::Blow, 1.0)],
    },
    KnownScrew {
        name: "let_off",
        part: "let-off button",
        sets: None,
        reference: UP,
        range: [-4e-3, 4e-3],
        work: Handwork::Thread(CAPSTAN_THREAD_M),
        goals: &[(Goal::LetOff, -7.0)],
    },
    KnownScrew {
        name: "drop",
        part: "drop screw",
        sets: None,
        reference: DOWN,
        range: [-4e-3, 4e-3],
        work: Handwork::Thread(SMALL_THREAD_M),
        goals: &[(Goal::Drop, 6.0)],
    },
    KnownScrew {
        name: "front_punching",
        part: "front punchings",
        sets: Some("dip"),
        reference: UP,
        range: [-3e-3, 3e-3],
        work: Handwork::Layers,
        goals: &[(Goal::Dip, -1.0)],
    },
    KnownScrew {
        name: "back_rail_cloth",
        part: "back rail cloth",
        sets: Some("key height"),
        reference: UP,
        range: [-2e-3, 2e-3],
        work: Handwork::Layers,
        goals: &[(Goal::Dip, -1.2)],
    },
    KnownScrew {
        name: "back_check",
        part: "back check",
        sets: None,
        reference: TO_THE_PLAYER,
        range: [-6e-3, 6e-3],
        work: Handwork::Bent,
        // The hammer rises to where the drop screw holds the lever: the rise depends on where it is checked.
        goals: &[(Goal::Check, -10.0), (Goal::RepetitionRise, -10.0)],
    },
    KnownScrew {
        name: "back_check_angle",
        part: "back check, angle",
        sets: None,
        reference: [0.0; 2],
        range: [-0.14, 0.14],
        work: Handwork::Bent,
        // The angle determines how far the key has come up when the hammer is let go, which matters little.
        goals: &[(Goal::RepetitionRise, 3e-3)],
    },
    KnownScrew {
        name: "repetition_spring",
        part: "repetition spring",
        sets: None,
        reference: [0.0; 2],
        range: [-0.8, 1.0],
        work: Handwork::Bent,
        goals: &[(Goal::RepetitionSpring, 25.0)],
    },
    KnownScrew {
        name: "damper_timing",
        part: "damper lift",
        sets: None,
        reference: UP,
        range: [-4e-3, 4e-3],
        work: Handwork::Thread(CAPSTAN_THREAD_M),
        goals: &[(Goal::DamperStart, -110.0)],
    },
];

/// Finds a screw by its name.
pub fn known_screw(name: &str) -> Option<&'static KnownScrew> {
    KNOWN_SCREWS.iter().find(|screw| screw.name == name)
}

impl Goal {
    /// Screws of the goal, the usual one first; the next takes over at the end of its range. Each with its effect on
    /// the goal ([`KnownScrew`]).
    pub(crate) fn screws(self) -> impl Iterator<Item = (&'static KnownScrew, f64)> + Clone {
        let effect = move |screw: &'static KnownScrew| screw.goals.iter().find(|(goal, _)| *goal == self);
        KNOWN_SCREWS.iter().filter_map(move |screw| Some((screw, effect(screw)?.1)))
    }
}

impl KnownScrew {
    /// +1 if a positive setting turns along the reference, -1 if the file counts the other way.
    pub(crate) fn sense(&self, screw: &Screw) -> f64 {
        match screw.action {
            ScrewAction::Disc { direction, .. } | ScrewAction::Curve { direction, .. } => {
                let along = direction[0] * self.reference[0] + direction[1] * self.reference[1];
                if along < 0.0 { -1.0 } else { 1.0 }
            }
            ScrewAction::Turn { .. } | ScrewAction::Spring { .. } => 1.0,
        }
    }

    /// Least and largest setting, m, rad or N m.
    pub fn limits(&self, instrument: &Instrument, screw: &Screw) -> [f64; 2] {
        let [from, to] = self.range;
        match screw.action {
            ScrewAction::Spring { spring } => {
                let drawn = instrument.springs[spring].torque_n_m.abs() - screw.setting;
                [from * drawn, to * drawn]
            }
            _ if self.sense(screw) > 0.0 => [from, to],
            _ => [-to, -from],
        }
    }
}

/// Direction of a turn, in words.
pub(crate) fn way(action: &ScrewAction, by: f64) -> &'static str {
    if by == 0.0 {
        return "not turned";
    }
    match *action {
        ScrewAction::Disc { direction, .. } | ScrewAction::Curve { direction, .. } => {
            let [x, y] = direction.map(|d| d * by);
            match (y.abs() >= x.abs(), if y.abs() >= x.abs() { y > 0.0 } else { x > 0.0 }) {
                (true, true) => "up",
                (true, false) => "down",
                (false, true) => "to the back",
                (false, false) => "to the player",
            }
        }
        ScrewAction::Turn { .. } if by > 0.0 => "top to the player",
        ScrewAction::Turn { .. } => "top to the back",
        ScrewAction::Spring { .. } if by > 0.0 => "tighter",
        ScrewAction::Spring { .. } => "looser",
    }
}

/// Formats a number of turns in eighths: `3/8 turn`, `1 1/4 turns`.
#[must_use]
pub fn turns_text(turns: f64) -> String {
    let eighths = (turns.abs() * 8.0).round();
    if !eighths.is_finite() || eighths < 1.0 {
        return "less than 1/8 turn".to_owned();
    }
    let (whole, rest) = ((eighths / 8.0).floor(), (eighths % 8.0) as usize);
    let part = ["", "1/8", "1/4", "3/8", "1/2", "5/8", "3/4", "7/8"][rest];
    let number = match (whole as u64, part) {
        (0, part) => part.to_owned(),
        (whole, "") => whole.to_string(),
        (whole, part) => format!("{whole} {part}"),
    };
    format!("{number} turn{}", if eighths > 8.0 { "s" } else { "" })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_are_read_in_eighths() {
        for (turns, text) in [
            (0.02, "less than 1/8 turn"),
            (0.13, "1/8 turn"),
            (-0.38, "3/8 turn"),
            (1.0, "1 turn"),
            (1.27, "1 1/4 turns"),
            (2.99, "3 turns"),
        ] {
            assert_eq!(turns_text(turns), text);
        }
    }
}

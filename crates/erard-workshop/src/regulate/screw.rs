//! Known screws of a grand action, by their names in instrument files.

use erard::instrument::{Instrument, Screw, ScrewAction, Vec2};
use erard::parameter::Quantity;

/// Range of a screw, counted from the drawn geometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// From the first to the second, m.
    Length(f64, f64),
    /// From the first to the second, rad.
    Angle(f64, f64),
    /// Shares of the spring's drawn torque.
    Torque(f64, f64),
}

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
    /// Direction of a technician's words for its turns; a file may count the other way.
    pub reference: Vec2,
    /// Plausible range, an estimate: the thread of a capstan or button, a stack of punchings, the bending of a wire,
    /// the range of a spring.
    pub range: Range,
    /// The work at the bench.
    pub work: Handwork,
}

const UP: Vec2 = [0.0, 1.0];
const DOWN: Vec2 = [0.0, -1.0];
const TO_THE_BACK: Vec2 = [1.0, 0.0];
const TO_THE_PLAYER: Vec2 = [-1.0, 0.0];

/// All known screws.
pub(crate) const KNOWN_SCREWS: [KnownScrew; 12] = [
    known("jack_position", TO_THE_BACK, Range::Length(-2e-3, 2e-3), Handwork::Thread(SMALL_THREAD_M)),
    known("lever_height", DOWN, Range::Length(-1e-3, 1e-3), Handwork::Thread(SMALL_THREAD_M)),
    known("capstan_height", UP, Range::Length(-4e-3, 4e-3), Handwork::Thread(CAPSTAN_THREAD_M)),
    known("string_height", UP, Range::Length(-5e-3, 5e-3), Handwork::Stack),
    known("let_off", UP, Range::Length(-4e-3, 4e-3), Handwork::Thread(CAPSTAN_THREAD_M)),
    known("drop", DOWN, Range::Length(-4e-3, 4e-3), Handwork::Thread(SMALL_THREAD_M)),
    known("front_punching", UP, Range::Length(-3e-3, 3e-3), Handwork::Layers),
    known("back_rail_cloth", UP, Range::Length(-2e-3, 2e-3), Handwork::Layers),
    known("back_check", TO_THE_PLAYER, Range::Length(-6e-3, 6e-3), Handwork::Bent),
    known("back_check_angle", [0.0; 2], Range::Angle(-0.14, 0.14), Handwork::Bent),
    known("repetition_spring", [0.0; 2], Range::Torque(-0.8, 1.0), Handwork::Bent),
    known("damper_timing", UP, Range::Length(-4e-3, 4e-3), Handwork::Thread(CAPSTAN_THREAD_M)),
];

const fn known(name: &'static str, reference: Vec2, range: Range, work: Handwork) -> KnownScrew {
    KnownScrew { name, reference, range, work }
}

/// Finds a screw by its name.
pub fn known_screw(name: &str) -> Option<&'static KnownScrew> {
    KNOWN_SCREWS.iter().find(|screw| screw.name == name)
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
        match self.range {
            Range::Length(from, to) | Range::Angle(from, to) if self.sense(screw) > 0.0 => [from, to],
            Range::Length(from, to) | Range::Angle(from, to) => [-to, -from],
            Range::Torque(from, to) => {
                let ScrewAction::Spring { spring } = screw.action else { return [0.0, 0.0] };
                let drawn = instrument.springs[spring].torque_n_m.abs() - screw.setting;
                [from * drawn, to * drawn]
            }
        }
    }
}

/// Rounds a setting as in files: 0.1 um, a ten-thousandth of a degree, 1 uN m.
pub(super) fn rounded(action: &ScrewAction, setting: f64) -> f64 {
    // Multiplied and divided as in reading the file, so that both give the same bits.
    match action.quantity() {
        Quantity::Length => ((setting * 1e7).round() / 1e4) / 1e3,
        Quantity::Angle => ((setting.to_degrees() * 1e4).round() / 1e4).to_radians(),
        _ => (setting * 1e6).round() / 1e6,
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

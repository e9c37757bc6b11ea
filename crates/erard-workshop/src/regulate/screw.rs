//! What can be turned: the screws of a grand action by the names that instrument files give them.

use erard::instrument::{Instrument, Screw, ScrewAction, Vec2};

/// How far a screw goes, counted from the drawn geometry.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Range {
    /// From so much to so much, m.
    Length(f64, f64),
    /// From so much to so much, rad.
    Angle(f64, f64),
    /// As shares of the spring's torque as drawn.
    Torque(f64, f64),
}

/// A screw that `regulate` knows how to use.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownScrew {
    /// Its name in instrument files.
    pub name: &'static str,
    /// The direction in which a technician's usual words turn it; a file may count the other way.
    pub reference: Vec2,
    /// How far it plausibly goes. These are estimates: the thread of a capstan or button, a stack of punchings, what a wire
    /// bends and what a spring takes.
    pub range: Range,
}

const UP: Vec2 = [0.0, 1.0];
const DOWN: Vec2 = [0.0, -1.0];
const TO_THE_BACK: Vec2 = [1.0, 0.0];
const TO_THE_PLAYER: Vec2 = [-1.0, 0.0];

/// All of them.
pub const KNOWN_SCREWS: [KnownScrew; 12] = [
    KnownScrew { name: "jack_position", reference: TO_THE_BACK, range: Range::Length(-2e-3, 2e-3) },
    KnownScrew { name: "lever_height", reference: DOWN, range: Range::Length(-1e-3, 1e-3) },
    KnownScrew { name: "capstan_height", reference: UP, range: Range::Length(-4e-3, 4e-3) },
    KnownScrew { name: "string_height", reference: UP, range: Range::Length(-5e-3, 5e-3) },
    KnownScrew { name: "let_off", reference: UP, range: Range::Length(-4e-3, 4e-3) },
    KnownScrew { name: "drop", reference: DOWN, range: Range::Length(-4e-3, 4e-3) },
    KnownScrew { name: "front_punching", reference: UP, range: Range::Length(-3e-3, 3e-3) },
    KnownScrew { name: "back_rail_cloth", reference: UP, range: Range::Length(-2e-3, 2e-3) },
    KnownScrew { name: "back_check", reference: TO_THE_PLAYER, range: Range::Length(-6e-3, 6e-3) },
    KnownScrew { name: "back_check_angle", reference: [0.0; 2], range: Range::Angle(-0.14, 0.14) },
    KnownScrew { name: "repetition_spring", reference: [0.0; 2], range: Range::Torque(-0.8, 1.0) },
    KnownScrew { name: "damper_timing", reference: UP, range: Range::Length(-4e-3, 4e-3) },
];

/// The screw of a name.
pub fn known_screw(name: &str) -> Option<&'static KnownScrew> {
    KNOWN_SCREWS.iter().find(|screw| screw.name == name)
}

impl KnownScrew {
    /// +1 where a positive setting turns the way of the reference, -1 where the file counts the other way.
    pub(super) fn sense(&self, screw: &Screw) -> f64 {
        match screw.action {
            ScrewAction::Disc { direction, .. } | ScrewAction::Curve { direction, .. } => {
                let along = direction[0] * self.reference[0] + direction[1] * self.reference[1];
                if along < 0.0 { -1.0 } else { 1.0 }
            }
            ScrewAction::Turn { .. } | ScrewAction::Spring { .. } => 1.0,
        }
    }

    /// The least and most setting, m, rad or N m.
    pub(super) fn limits(&self, instrument: &Instrument, screw: &Screw) -> [f64; 2] {
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

/// The setting that a file would hold: 0.1 um, a ten-thousandth of a degree, 1 uN m.
pub(super) fn rounded(action: &ScrewAction, setting: f64) -> f64 {
    // Multiplied and divided as reading the file does, so that both give the same bits.
    match action {
        ScrewAction::Disc { .. } | ScrewAction::Curve { .. } => ((setting * 1e7).round() / 1e4) / 1e3,
        ScrewAction::Turn { .. } => ((setting.to_degrees() * 1e4).round() / 1e4).to_radians(),
        ScrewAction::Spring { .. } => (setting * 1e6).round() / 1e6,
    }
}

/// Which way a screw has been turned, in words.
pub(super) fn way(action: &ScrewAction, by: f64) -> &'static str {
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

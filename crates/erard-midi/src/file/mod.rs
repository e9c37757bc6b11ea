//! Standard MIDI Files: a piece as notes of the piano's keys, in seconds, and back.

mod chunks;
mod pairing;
mod read;
mod remarks;
mod write;

use std::vec::Vec;

pub use read::{ReadError, read};
pub use remarks::Remarks;
pub use write::{WriteError, write};

use crate::Velocity;

/// A note of a piece.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Note {
    /// The key, from 1, the lowest A.
    pub key: usize,
    /// Instant at which the hammer should meet the string, s from the piece's first instant.
    pub start_s: f64,
    /// Instant at which the rising key should set its damper down, s.
    pub end_s: f64,
    /// The note-on's velocity, with the fractions of controller 88 where there are any.
    pub velocity: Velocity,
    /// The note-off's velocity; `None` where the file does not give it: note-ons of velocity 0, and note-offs of 0 or
    /// 64, which senders that measure no release use.
    pub release: Option<Velocity>,
}

/// Position of a pedal from an instant on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PedalChange {
    /// The instant, s.
    pub time_s: f64,
    /// The pedal's controller: [`SUSTAIN`](crate::message::SUSTAIN), [`SOSTENUTO`](crate::message::SOSTENUTO) or
    /// [`SOFT`](crate::message::SOFT).
    pub controller: u8,
    /// Position, 0 (up) to 127 (down).
    pub value: u8,
}

/// A piece for one piano: the notes of all tracks and channels.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Piece {
    /// The notes in the order of their beginnings, then of their keys. Notes of one key do not overlap.
    pub notes: Vec<Note>,
    /// The pedals in the order of time.
    pub pedals: Vec<PedalChange>,
    /// Parts of the file that were left out, merged or repaired.
    pub remarks: Remarks,
}

impl Piece {
    /// When the last note ends, s; 0 without a note.
    #[must_use]
    pub fn duration_s(&self) -> f64 {
        self.notes.iter().map(|note| note.end_s).fold(0.0, f64::max)
    }
}

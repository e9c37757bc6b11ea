//! A piece as a Standard MIDI File.

use std::vec::Vec;

use super::Piece;
use crate::{Message, Resolution, Velocity, note_of_key};

/// Ticks for a quarter note, of which there are two a second: a tick takes a twentieth of a millisecond.
const TICKS: u16 = 10_000;
/// A quarter note, us.
const QUARTER_US: u32 = 500_000;
/// Ticks a second.
const TICKS_PER_S: f64 = TICKS as f64 * 1e6 / QUARTER_US as f64;
/// The most ticks between two events of a file.
const MAX_TICKS: u64 = (1 << 28) - 1;

/// Why a piece cannot be written.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum WriteError {
    /// A note, from 0 in the order of the piece, is on no key, or its instants are not finite, begin before 0 or do not
    /// ascend.
    Note(usize),
    /// A pedal's change, likewise, has an instant that is not finite or before 0.
    Pedal(usize),
    /// The time without an event from this instant, s, on is too long for the file format.
    Silence(f64),
}

impl std::fmt::Display for WriteError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            WriteError::Note(i) => {
                write!(f, "note {}: expected a key of 1 to 88, and 0 <= start < end, both finite", i + 1)
            }
            WriteError::Pedal(i) => write!(f, "pedal {}: expected an instant of 0 s or more", i + 1),
            WriteError::Silence(from_s) => write!(f, "more than 3 h 43 min without an event from {from_s} s on"),
        }
    }
}

impl std::error::Error for WriteError {}

/// Writes a piece as a Standard MIDI File of format 0, on channel 1, in ticks of 1/20 ms. An unknown release is written
/// as 64. At one instant note-offs come first, then pedals, then note-ons.
///
/// # Errors
/// [`WriteError`].
pub fn write(piece: &Piece, resolution: Resolution) -> Result<Vec<u8>, WriteError> {
    let mut events: Vec<(u64, u8, Message)> = Vec::new();
    let tick = |time_s: f64| (time_s * TICKS_PER_S).round() as u64;
    let is_instant = |time_s: f64| time_s.is_finite() && time_s >= 0.0;
    for (i, note) in piece.notes.iter().enumerate() {
        let number = note_of_key(note.key)
            .filter(|_| is_instant(note.start_s) && is_instant(note.end_s) && note.start_s < note.end_s);
        let Some(number) = number else { return Err(WriteError::Note(i)) };
        events.push((tick(note.start_s), 2, Message::note_on(0, number, note.velocity, resolution)));
        let off = match note.release {
            Some(release) => Message::note_off(0, number, release, resolution),
            None => Message::note_off(0, number, Velocity::of_seven_bits(64), Resolution::SevenBits),
        };
        events.push((tick(note.end_s), 0, off));
    }
    for (i, pedal) in piece.pedals.iter().enumerate() {
        if !is_instant(pedal.time_s) {
            return Err(WriteError::Pedal(i));
        }
        events.push((tick(pedal.time_s), 1, Message::controller(0, pedal.controller, pedal.value)));
    }
    events.sort_by_key(|(tick, order, _)| (*tick, *order));
    let [_, high, middle, low] = QUARTER_US.to_be_bytes();
    let mut track = Vec::from([0, 0xFF, 0x51, 3, high, middle, low]);
    let (mut now, mut status) = (0, 0);
    for (tick, _, message) in events {
        if tick - now > MAX_TICKS {
            return Err(WriteError::Silence(now as f64 / TICKS_PER_S));
        }
        // A controller 88 and its note are three bytes each, the note at once.
        for (i, bytes) in message.bytes().chunks(3).enumerate() {
            delay(&mut track, if i == 0 { tick - now } else { 0 });
            track.extend(if bytes[0] == status { &bytes[1..] } else { bytes });
            status = bytes[0];
        }
        now = tick;
    }
    track.extend([0, 0xFF, 0x2F, 0]);
    let mut bytes = Vec::from(*b"MThd\0\0\0\x06\0\0\0\x01");
    bytes.extend(TICKS.to_be_bytes());
    bytes.extend(b"MTrk");
    bytes.extend((track.len() as u32).to_be_bytes());
    bytes.extend(track);
    Ok(bytes)
}

/// Appends a number of at most 28 bits, seven in a byte, the highest first.
fn delay(track: &mut Vec<u8>, ticks: u64) {
    for bits in [21, 14, 7] {
        if ticks >> bits > 0 {
            track.push((ticks >> bits) as u8 & 0x7F | 0x80);
        }
    }
    track.push(ticks as u8 & 0x7F);
}

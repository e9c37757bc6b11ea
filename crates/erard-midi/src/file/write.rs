//! A piece as a Standard MIDI File.

use std::vec::Vec;

use midly::num::{u4, u7, u15, u24, u28};
use midly::{Format, Header, MetaMessage, MidiMessage, Smf, Timing, TrackEvent, TrackEventKind};

use super::Piece;
use crate::message::HIGH_RESOLUTION;
use crate::{Resolution, Velocity, note_of_key};

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
    let mut events: Vec<(u64, u8, [Option<MidiMessage>; 2])> = Vec::new();
    let tick = |time_s: f64| (time_s * TICKS_PER_S).round() as u64;
    let is_instant = |time_s: f64| time_s.is_finite() && time_s >= 0.0;
    for (i, note) in piece.notes.iter().enumerate() {
        let number = note_of_key(note.key)
            .filter(|_| is_instant(note.start_s) && is_instant(note.end_s) && note.start_s < note.end_s);
        let Some(number) = number else { return Err(WriteError::Note(i)) };
        let key = u7::new(number);
        let (below, vel) = split(note.velocity, resolution);
        events.push((tick(note.start_s), 2, [below, Some(MidiMessage::NoteOn { key, vel })]));
        let (below, vel) = match note.release {
            Some(release) => split(release, resolution),
            None => (None, u7::new(64)),
        };
        events.push((tick(note.end_s), 0, [below, Some(MidiMessage::NoteOff { key, vel })]));
    }
    for (i, pedal) in piece.pedals.iter().enumerate() {
        if !is_instant(pedal.time_s) {
            return Err(WriteError::Pedal(i));
        }
        let (controller, value) = (u7::new(pedal.controller & 0x7F), u7::new(pedal.value & 0x7F));
        events.push((tick(pedal.time_s), 1, [None, Some(MidiMessage::Controller { controller, value })]));
    }
    events.sort_by_key(|(tick, order, _)| (*tick, *order));
    let mut track = Vec::from([TrackEvent {
        delta: u28::new(0),
        kind: TrackEventKind::Meta(MetaMessage::Tempo(u24::new(QUARTER_US))),
    }]);
    let mut now = 0;
    for (tick, _, messages) in events {
        for message in messages.into_iter().flatten() {
            if tick - now > MAX_TICKS {
                return Err(WriteError::Silence(now as f64 / TICKS_PER_S));
            }
            let delta = u28::new((tick - now) as u32);
            track.push(TrackEvent { delta, kind: TrackEventKind::Midi { channel: u4::new(0), message } });
            now = tick;
        }
    }
    track.push(TrackEvent { delta: u28::new(0), kind: TrackEventKind::Meta(MetaMessage::EndOfTrack) });
    let header = Header::new(Format::SingleTrack, Timing::Metrical(u15::new(TICKS)));
    let mut bytes = Vec::new();
    // Nothing that is written to a vector fails.
    let _: Result<(), _> = Smf { header, tracks: Vec::from([track]) }.write_std(&mut bytes);
    Ok(bytes)
}

/// A velocity as its controller 88, if it has one, and its message's seven bits.
fn split(velocity: Velocity, resolution: Resolution) -> (Option<MidiMessage>, u7) {
    match resolution {
        Resolution::SevenBits => (None, u7::new(velocity.seven_bits())),
        Resolution::FourteenBits => {
            let value = velocity.fourteen_bits();
            let below =
                MidiMessage::Controller { controller: u7::new(HIGH_RESOLUTION), value: u7::new((value & 0x7F) as u8) };
            (Some(below), u7::new((value >> 7) as u8))
        }
    }
}

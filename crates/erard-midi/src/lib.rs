//! From hammers to notes and back: the motion of a piano action as MIDI.
//!
//! - [`law`]: hammer speed, m/s, to velocity and back;
//! - [`message`]: the bytes of MIDI 1.0, with the seven additional bits of controller 88, and the packets of MIDI 2.0;
//! - [`notes`]: when a key's note begins and ends, and the pedals;
//! - [`file`](mod@file): Standard MIDI Files (feature `files`);
//! - `ports`: MIDI ports of the operating system (feature `ports`, off by default: on Linux it needs ALSA's headers).
//!
//! Everything except files and ports works without a heap and without the standard library, allocates nothing and does
//! not panic, so it serves control loops and microcontrollers. The crate contains no mechanics: it takes speeds and
//! instants from its caller.
//!
//! ```
//! use erard_midi::{Law, Message, Resolution, Velocity};
//!
//! let velocity = Law::GOEBL.velocity(2.0); // the hammer's speed at the string, m/s
//! assert_eq!(velocity.seven_bits(), 77);
//! let note_on = Message::note_on(0, 60, velocity, Resolution::SevenBits);
//! assert_eq!(note_on.bytes(), [0x90, 60, 77]);
//! ```

#![no_std]

#[cfg(feature = "files")]
extern crate std;

#[cfg(feature = "files")]
pub mod file;
pub mod law;
pub mod message;
pub mod notes;
#[cfg(feature = "ports")]
pub mod ports;
pub mod velocity;

pub use law::{Law, LawError, ReleaseLaw};
pub use message::{Message, Packet, Resolution};
pub use notes::{Crossing, Event, KeyNotes, Pedal};
pub use velocity::Velocity;

/// The note number of a key, which count from 1, the lowest A; `None` where there is no such key.
#[must_use]
pub const fn note_of_key(key: usize) -> Option<u8> {
    if 1 <= key && key <= KEYS { Some((key - 1) as u8 + LOWEST_NOTE) } else { None }
}

/// The key of a note number, from 1; `None` for a note that is not on the keyboard.
#[must_use]
pub const fn key_of_note(note: u8) -> Option<usize> {
    if LOWEST_NOTE <= note && note < LOWEST_NOTE + KEYS as u8 { Some((note - LOWEST_NOTE) as usize + 1) } else { None }
}

/// Keys of a piano.
pub const KEYS: usize = 88;
/// The note number of the lowest A.
pub const LOWEST_NOTE: u8 = 21;

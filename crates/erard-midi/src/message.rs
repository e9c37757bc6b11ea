//! The bytes of MIDI 1.0 and the packets of MIDI 2.0.

use crate::Velocity;

/// Resolution of a velocity in MIDI 1.0.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Resolution {
    /// Seven bits, which every device understands.
    SevenBits,
    /// Seven additional bits in a controller 88 before each note-on and note-off [MIDI Manufacturers Association,
    /// CA-031, *High Resolution Velocity Prefix*]. Twice as long on a cable. Some instruments use controller 88 for
    /// another purpose.
    FourteenBits,
}

/// The controller whose value is the seven bits below the next note's velocity.
pub const HIGH_RESOLUTION: u8 = 88;
/// The controller of the right pedal.
pub const SUSTAIN: u8 = 64;
/// The controller of the middle pedal.
pub const SOSTENUTO: u8 = 66;
/// The controller of the left pedal.
pub const SOFT: u8 = 67;
/// The controller that silences a channel at once, whatever its pedals are.
pub const ALL_SOUND_OFF: u8 = 120;
/// The controller that sets a channel's controllers to where they begin: pedals up.
pub const RESET_CONTROLLERS: u8 = 121;
/// The controller that lets a channel's keys up; so do the four above it, which choose modes of reception.
pub const ALL_NOTES_OFF: u8 = 123;

/// One or two messages of MIDI 1.0 that belong together: a note with the controller 88 before it, if it has one, so
/// that nothing comes between them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Message {
    bytes: [u8; 6],
    length: usize,
}

impl Message {
    /// A note-on. Channels count from 0 to 15, notes to 127: higher bits are cut off.
    #[must_use]
    pub fn note_on(channel: u8, note: u8, velocity: Velocity, resolution: Resolution) -> Self {
        Message::note(0x90, channel, note, velocity, resolution)
    }

    /// A note-off with the velocity of the release.
    #[must_use]
    pub fn note_off(channel: u8, note: u8, release: Velocity, resolution: Resolution) -> Self {
        Message::note(0x80, channel, note, release, resolution)
    }

    fn note(status: u8, channel: u8, note: u8, velocity: Velocity, resolution: Resolution) -> Self {
        let (status, note) = (status | channel & 0x0F, note & 0x7F);
        match resolution {
            Resolution::SevenBits => Message::of(&[status, note, velocity.seven_bits()]),
            Resolution::FourteenBits => {
                let value = velocity.fourteen_bits();
                let (upper, lower) = ((value >> 7) as u8, (value & 0x7F) as u8);
                Message::of(&[0xB0 | channel & 0x0F, HIGH_RESOLUTION, lower, status, note, upper])
            }
        }
    }

    /// A controller's value, 0 to 127.
    #[must_use]
    pub fn controller(channel: u8, controller: u8, value: u8) -> Self {
        Message::of(&[0xB0 | channel & 0x0F, controller & 0x7F, value & 0x7F])
    }

    /// At most six bytes.
    fn of(bytes: &[u8]) -> Self {
        let mut all = [0; 6];
        all[..bytes.len()].copy_from_slice(bytes);
        Message { bytes: all, length: bytes.len() }
    }

    /// The bytes, as they go over a cable: three or six.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes[..self.length]
    }

    /// Duration on a DIN cable, s: 31 250 bits a second, ten for a byte.
    #[must_use]
    pub fn on_a_cable_s(&self) -> f64 {
        self.length as f64 * 10.0 / 31_250.0
    }
}

/// A channel voice message of MIDI 2.0 as a Universal MIDI Packet of two words, the first one first. On a wire each
/// word goes with its highest byte first ([`Packet::bytes`]).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packet(pub [u32; 2]);

impl Packet {
    /// A note-on without an attribute. Groups and channels count from 0 to 15.
    #[must_use]
    pub fn note_on(group: u8, channel: u8, note: u8, velocity: Velocity) -> Self {
        Packet::voice(0x9, group, channel, [note, 0], u32::from(velocity.sixteen_bits()) << 16)
    }

    /// A note-off with the velocity of the release.
    #[must_use]
    pub fn note_off(group: u8, channel: u8, note: u8, release: Velocity) -> Self {
        Packet::voice(0x8, group, channel, [note, 0], u32::from(release.sixteen_bits()) << 16)
    }

    /// A controller's value in 32 bits.
    #[must_use]
    pub fn controller(group: u8, channel: u8, controller: u8, value: u32) -> Self {
        Packet::voice(0xB, group, channel, [controller, 0], value)
    }

    fn voice(opcode: u32, group: u8, channel: u8, index: [u8; 2], value: u32) -> Self {
        let [index, other] = index.map(|byte| u32::from(byte & 0x7F));
        let head = 0x4 << 28 | u32::from(group & 0x0F) << 24 | opcode << 20 | u32::from(channel & 0x0F) << 16;
        Packet([head | index << 8 | other, value])
    }

    /// The eight bytes, each word's highest first.
    #[must_use]
    pub fn bytes(&self) -> [u8; 8] {
        let ([a, b, c, d], [e, f, g, h]) = (self.0[0].to_be_bytes(), self.0[1].to_be_bytes());
        [a, b, c, d, e, f, g, h]
    }
}

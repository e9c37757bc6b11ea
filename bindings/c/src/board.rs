//! A board: keys with sensors, from readings to bytes of MIDI, in the caller's memory. This file is compiled for chips,
//! too (`bindings/firmware`): what differs there is `board_keys.rs`, the keys' actions. Boards of contacts and of
//! sensed hammers, which simulate nothing, are `board_contacts.rs` and `board_hammers.rs`.

use core::ffi::{c_char, c_void};
use core::ops::RangeInclusive;
use core::ptr::{NonNull, null_mut};

use erard_live::SensorKind;
use erard_live::board::Pedals;
use erard_live::converter::Stops;
use erard_live::sensing::{Scan, ScanClock, Sensor, Voice};
use erard_live::sensor::FixedLaw;
use erard_live::stops::Seen;
use erard_midi::message::{SOFT, SOSTENUTO, SUSTAIN};
use erard_midi::{KEYS, Law, Message, ReleaseLaw, Resolution};

use crate::board_keys::{BoardKey, Shared, make};
use crate::caller_struct::{CallerStruct, Place, given, given_nth};
use crate::outcome::ErardStatus;
use crate::status::{Fault, quick, tell, told};

/// ErardBoardSetup.kind: the sensors are under the keys of a real action, which move with their hammers. The motion of
/// each simulated key is prescribed (as by ERARD_INPUT_RIGID).
pub const ERARD_BOARD_ACTION: u32 = 0;
/// ErardBoardSetup.kind: the sensors are under switches or light keys without an action. A hand of 200 g with at most
/// 60 N follows their depth (as by ERARD_INPUT_HAND).
pub const ERARD_BOARD_LIGHT: u32 = 1;

/// ErardBoardSetup.sensor_law: travel in proportion to the reading.
pub const ERARD_SENSOR_LINEAR: u32 = 0;
/// ErardBoardSetup.sensor_law: a reflective optical sensor CNY-70 under the back of a key.
pub const ERARD_SENSOR_CNY70: u32 = 1;
/// ErardBoardSetup.sensor_law: a Hall sensor on the axis of a small magnet (`nearest_m`, `nearest_at_rest`).
pub const ERARD_SENSOR_HALL: u32 = 2;

/// ErardBoardSetup.velocity_law: 52 + 25 log2(v), v in m/s, the convention of the command.
pub const ERARD_VELOCITY_USUAL: u32 = 0;
/// ErardBoardSetup.velocity_law: `velocity_at_one` + `velocity_per_octave` log2(v), v in m/s.
pub const ERARD_VELOCITY_LOGARITHMIC: u32 = 1;
/// ErardBoardSetup.velocity_law: in proportion to the speed, 127 at `velocity_full_m_per_s`.
pub const ERARD_VELOCITY_LINEAR: u32 = 2;

/// Bytes of MIDI for which a call that plays keys needs room, for each key: eight messages.
pub const ERARD_BOARD_KEY_BYTES: usize = 48;

/// Bytes of a message.
const MESSAGE_BYTES: usize = 6;
/// Ranges: the sensed travel, m, and the length of a step, s.
pub(crate) const TRAVEL_M: [f64; 2] = [0.5e-3, 0.1];
const STEP_S: [f64; 2] = [1e-6, 1e-3];

/// What a board is made of. Zero is the usual choice of every field whose 0 says so.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErardBoardSetup {
    /// sizeof(ErardBoardSetup).
    pub struct_size: u32,
    /// The lowest key, from 1, the lowest A of a piano.
    pub first_key: u32,
    /// Number of keys, from the lowest on.
    pub key_count: u32,
    /// ERARD_BOARD_ACTION or ERARD_BOARD_LIGHT.
    pub kind: u32,
    /// ERARD_SENSOR_LINEAR, ERARD_SENSOR_CNY70 or ERARD_SENSOR_HALL; erard_board_sensor_table gives a law of your own.
    pub sensor_law: u32,
    /// Of a Hall sensor: 1 if sensor and magnet are nearest at the key's rest, 0 if at its bottom.
    pub nearest_at_rest: u32,
    /// ERARD_VELOCITY_USUAL, ERARD_VELOCITY_LOGARITHMIC or ERARD_VELOCITY_LINEAR; erard_board_velocity_table gives a
    /// law of your own.
    pub velocity_law: u32,
    /// Bits of a velocity: 7, or 14 with a controller 88 before each note; 0 is 7.
    pub velocity_bits: u32,
    /// MIDI channel, 0 to 15.
    pub channel: u32,
    /// 0.
    pub reserved: u32,
    /// Length of a step, s, 1 us to 1 ms. 0: 50 us; on a chip 250 us, in which every note is within one velocity of
    /// that in 50 us.
    pub step_s: f64,
    /// Travel of the sensed place between the key's two stops, m, 0.5 mm to 100 mm.
    pub travel_m: f64,
    /// Distance of the sensed place from the balance pin, m, on either side; 0: at the key's front.
    pub sensor_at_m: f64,
    /// Of a Hall sensor: distance from the magnet where they are nearest, m, 0.1 mm to 100 mm.
    pub nearest_m: f64,
    /// A reading that differs from the last accepted one by no more than this counts as equal, so that noise does not
    /// keep a resting key awake; 0: every change counts.
    pub still: f64,
    /// Velocity at 1 m/s, for ERARD_VELOCITY_LOGARITHMIC.
    pub velocity_at_one: f64,
    /// Velocities for twice the speed, positive, for ERARD_VELOCITY_LOGARITHMIC.
    pub velocity_per_octave: f64,
    /// The speed of velocity 127, m/s, positive, for ERARD_VELOCITY_LINEAR.
    pub velocity_full_m_per_s: f64,
    /// Upward speed of a key's front with which its note-off has velocity 64, m/s; 0: 0.2 m/s.
    pub release_m_per_s: f64,
}

impl Default for ErardBoardSetup {
    /// No keys; everything else usual.
    fn default() -> Self {
        Self::zeroed()
    }
}

// SAFETY: a `repr(C)` struct of ten u32 and nine f64: no padding, and every bit pattern is a value. `struct_size` is
// its first field.
unsafe impl CallerStruct for ErardBoardSetup {
    const FIRST_BYTES: usize = 112;
}

/// Readings at a key's two stops. In an array, set the size of the first element only: it holds for all.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErardStops {
    /// sizeof(ErardStops).
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// The reading at rest.
    pub rest: f64,
    /// The reading with the key held at its bottom. If both readings are 0, the key has no sensor: its readings are
    /// ignored.
    pub pressed: f64,
    /// Result of erard_board_calibrate: standard deviation of readings at rest, as a share of the range. Not read.
    pub noise: f64,
    /// Result of erard_board_calibrate: drift at rest from first to last reading, as a share of the range. Not read.
    pub drift: f64,
}

impl Default for ErardStops {
    /// No sensor.
    fn default() -> Self {
        Self::zeroed()
    }
}

// SAFETY: a `repr(C)` struct of two u32 and four f64: no padding, and every bit pattern is a value. `struct_size` is
// its first field.
unsafe impl CallerStruct for ErardStops {
    const FIRST_BYTES: usize = 40;
}

/// State of a board's key. Counts are of all readings since the board was made or reset.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErardBoardKey {
    /// sizeof(ErardBoardKey).
    pub struct_size: u32,
    /// 1 if its action is at a complete rest: it then takes no steps, whatever keys beside it do. Of contacts 1 if none
    /// is closed and no note sounds, of hammers 1 if no note sounds.
    pub asleep: u32,
    /// Keystrokes that were limited so that no hammer goes faster than 8 m/s.
    pub limited_strokes: u32,
    /// Motions from the rest by less than 0.5 mm, which are noise.
    pub flutters: u32,
    /// Times that the sensor stayed still between up and down for 10 s.
    pub stuck: u32,
    /// Times that the drift exceeded 15 % of the sensor's range, up to which it is followed.
    pub drifts_beyond: u32,
    /// Messages of the whole board that found no room: 0, but for actions that no piano has.
    pub lost_messages: u32,
    /// 0.
    pub reserved: u32,
    /// Readings deeper than the key goes.
    pub deep_readings: f64,
    /// Steps in which a number was not finite: the key stayed where it was.
    pub non_finite_steps: f64,
    /// The fastest hammer, m/s.
    pub fastest_hammer_m_per_s: f64,
    /// Present drift of the sensor's rest, as a share of its range.
    pub drift: f64,
    /// Contacts: changes that were bounces.
    pub bounces: u32,
    /// Contacts: times that the lowest one closed although none above it had closed since the last note.
    pub untimed_strokes: u32,
    /// Contacts: times that the key came to its lowest one too slowly to throw a hammer.
    pub slow_strokes: u32,
    /// Contacts: times that one closed after the one below it.
    pub swapped_contacts: u32,
    /// Contacts: times that they closed in less than half the time of the fastest press, as wires that touch do.
    pub fast_strokes: u32,
    /// Hammers: rises of 3 mm or more that turned before the string.
    pub lifts: u32,
    /// Hammers: the highest place of the head below its string, m.
    pub nearest_m: f64,
}

impl Default for ErardBoardKey {
    /// All numbers are 0.
    fn default() -> Self {
        Self::zeroed()
    }
}

// SAFETY: a `repr(C)` struct of eight u32, four f64, six u32 and an f64: no padding, and every bit pattern is a value.
// `struct_size` is its first field.
unsafe impl CallerStruct for ErardBoardKey {
    const FIRST_BYTES: usize = 64;
}

/// Keys with sensors, in memory of the caller. One thread at a time may use it. It must stay where it was made.
pub struct ErardBoard {
    pub(crate) voice: Voice<'static>,
    pub(crate) clock: ScanClock,
    pedals: Pedals,
    first_key: u32,
    lost_messages: u32,
    key_count: usize,
    /// Behind the board in the same memory. A program calls the methods of the kinds of boards that it makes only.
    keys: NonNull<dyn Keys>,
}

/// What the keys of a board sense.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Sensed {
    /// The travel of each key.
    Travel,
    /// So many contacts of each key.
    Contacts(usize),
    /// The travel of each hammer's head.
    Hammers,
}

/// Receives messages.
pub(crate) type Send<'a> = &'a mut dyn FnMut(Message);

/// The keys of a board, all of one kind.
pub(crate) trait Keys {
    fn sensed(&self) -> Sensed;

    /// Takes what all sensors read in a scan: the first of each key, and the second where there are two.
    fn scan(&mut self, scan: &Scan, readings: (&[f32], Option<&[f32]>), voice: &Voice<'_>, send: Send<'_>) {
        let _ = (scan, readings, voice, send);
    }

    /// Goes on to an instant, s, and takes the edge of a key's contact, both from 0: whether it has closed.
    fn edge(&mut self, time_s: f64, edge: Option<(usize, usize, bool)>, voice: &Voice<'_>, send: Send<'_>) {
        let _ = (time_s, edge, voice, send);
    }

    /// Lets all of them go at an instant, s.
    fn let_go(&mut self, time_s: f64, voice: &Voice<'_>, send: Send<'_>);

    /// Puts all of them back to where they were made; returns whether that was possible.
    fn reset(&mut self) -> bool;

    /// Changes the sensors' law.
    fn set_law(&mut self, law: FixedLaw) {
        let _ = law;
    }

    /// The state of a key, from 0; `None` for one that is not there.
    fn read(&self, index: usize) -> Option<ErardBoardKey>;
}

/// The keys of a kind and what they share, behind their board in the same memory.
pub(crate) struct List<S, K> {
    pub(crate) shared: S,
    /// Behind this list in the same memory; `None` for a key without a sensor.
    keys: *mut Option<K>,
    count: usize,
}

impl<S, K> List<S, K> {
    /// Where the list and its keys begin in a board's memory, bytes.
    const AT: usize = size_of::<ErardBoard>().next_multiple_of(align_of::<Self>());
    const KEYS_AT: usize = (Self::AT + size_of::<Self>()).next_multiple_of(align_of::<Option<K>>());
    /// The alignment of its memory, bytes.
    const ALIGNMENT: usize = larger(align_of::<ErardBoard>(), larger(align_of::<Self>(), align_of::<Option<K>>()));

    /// The number of bytes that a board of so many keys takes; 0 for no key or more than 88.
    pub(crate) fn bytes(key_count: u32) -> usize {
        let count = key_count as usize;
        if (1..=KEYS).contains(&count) { Self::KEYS_AT + count * size_of::<Option<K>>() } else { 0 }
    }

    /// What they share, and the keys.
    pub(crate) fn parts(&mut self) -> (&mut S, &mut [Option<K>]) {
        // SAFETY: `self.keys` is the place of `self.count` keys behind the list, all of which were written when the
        // board was made; they are borrowed as long as the list is.
        let keys = unsafe { core::slice::from_raw_parts_mut(self.keys, self.count) };
        (&mut self.shared, keys)
    }

    /// A key, from 0.
    pub(crate) fn key(&self, index: usize) -> Option<&K> {
        // SAFETY: `self.keys` is the place of `self.count` keys behind the list, all of which were written when the
        // board was made; they are borrowed as long as the list is.
        let keys = unsafe { core::slice::from_raw_parts(self.keys, self.count) };
        keys.get(index)?.as_ref()
    }
}

impl<S, K> Drop for List<S, K> {
    fn drop(&mut self) {
        // SAFETY: `self.keys` is the place of `self.count` keys, written when the board was made; none is used again.
        unsafe { core::ptr::drop_in_place(core::ptr::slice_from_raw_parts_mut(self.keys, self.count)) };
    }
}

const fn larger(one: usize, other: usize) -> usize {
    if one > other { one } else { other }
}

impl Keys for List<Shared, BoardKey> {
    fn sensed(&self) -> Sensed {
        Sensed::Travel
    }

    fn scan(&mut self, scan: &Scan, (readings, _): (&[f32], Option<&[f32]>), voice: &Voice<'_>, send: Send<'_>) {
        let (shared, keys) = self.parts();
        if let Some([ends_s, to_s]) = scan.gap {
            for key in keys.iter_mut().flatten() {
                key.let_go(shared, ends_s, voice, send);
                key.jump(to_s);
            }
        }
        for (key, reading) in keys.iter_mut().zip(readings) {
            if let Some(key) = key {
                key.take(shared, (scan.time_s, *reading), voice, send);
            }
        }
    }

    fn let_go(&mut self, time_s: f64, voice: &Voice<'_>, send: Send<'_>) {
        let (shared, keys) = self.parts();
        keys.iter_mut().flatten().for_each(|key| key.let_go(shared, time_s, voice, send));
    }

    fn reset(&mut self) -> bool {
        let (shared, keys) = self.parts();
        // All of them, whatever one answers.
        keys.iter_mut().flatten().map(|key| key.reset(shared)).filter(|is_reset| !is_reset).count() == 0
    }

    fn set_law(&mut self, law: FixedLaw) {
        self.parts().1.iter_mut().flatten().for_each(|key| key.set_law(law));
    }

    fn read(&self, index: usize) -> Option<ErardBoardKey> {
        let own = self.key(index)?;
        let (counts, (drift, beyond)) = (own.counts(), own.drift());
        Some(ErardBoardKey {
            asleep: u32::from(own.is_asleep()),
            limited_strokes: counts.fast_strokes,
            flutters: counts.flutters,
            stuck: counts.stuck,
            drifts_beyond: of_u64(beyond),
            deep_readings: counts.deep_samples as f64,
            non_finite_steps: counts.non_finite as f64,
            fastest_hammer_m_per_s: counts.fastest_m_per_s,
            drift,
            ..ErardBoardKey::default()
        })
    }
}

/// A count, as far as it goes.
pub(crate) fn of_u64(count: u64) -> u32 {
    u32::try_from(count).unwrap_or(u32::MAX)
}

/// What a board is asked for, checked.
pub(crate) struct Asked {
    /// Its keys, from 1.
    pub keys: RangeInclusive<usize>,
    /// Their sensors; stops and `front_per_sensed` are not known.
    pub sensor: Sensor,
    /// Length of a step, s; `None` for the usual one.
    pub step_s: Option<f64>,
    /// Distance of the sensed place from the balance pin, m; `None` at the key's front.
    pub sensor_at_m: Option<f64>,
}

/// The caller's room for bytes of MIDI.
pub(crate) struct Out {
    at: *mut u8,
    room: usize,
    used: usize,
    lost: u32,
}

impl Out {
    /// Writes a whole message, or none of it.
    pub(crate) fn put(&mut self, message: &Message) {
        let bytes = message.bytes();
        if self.room - self.used < bytes.len() {
            self.lost = self.lost.saturating_add(1);
            return;
        }
        // SAFETY: `self.at` is writable memory for `self.room` bytes, of which `self.used` are used and the message's
        // have room behind these; `bytes` lies elsewhere.
        unsafe { core::ptr::copy_nonoverlapping(bytes.as_ptr(), self.at.add(self.used), bytes.len()) };
        self.used += bytes.len();
    }
}

impl ErardBoard {
    /// Its keys, and its voice.
    pub(crate) fn parts(&mut self) -> (&mut dyn Keys, &Voice<'static>) {
        // SAFETY: `self.keys` is the list behind the board, which was written when it was made; it is borrowed as long
        // as the board is.
        (unsafe { self.keys.as_mut() }, &self.voice)
    }

    pub(crate) fn sensed(&self) -> Sensed {
        // SAFETY: `self.keys` is the list behind the board, which was written when it was made; it is borrowed as long
        // as the board is.
        unsafe { self.keys.as_ref() }.sensed()
    }

    /// The place of a key, from 0; `None` for one that is not the board's.
    pub(crate) fn index(&self, key: u32) -> Option<usize> {
        key.checked_sub(self.first_key).map(|index| index as usize).filter(|index| *index < self.key_count)
    }

    pub(crate) fn room(&self) -> usize {
        self.key_count * ERARD_BOARD_KEY_BYTES
    }

    fn scan(&mut self, time_s: f64, readings: (&[f32], Option<&[f32]>), out: &mut Out) -> ErardStatus {
        let Some(scan) = self.clock.take(time_s) else { return ErardStatus::Range };
        let (keys, voice) = self.parts();
        keys.scan(&scan, readings, voice, &mut |message| out.put(&message));
        ErardStatus::Ok
    }

    fn let_go(&mut self, out: &mut Out) {
        let now_s = self.clock.now_s();
        let (keys, voice) = self.parts();
        keys.let_go(now_s, voice, &mut |message| out.put(&message));
        for pedal in [SUSTAIN, SOSTENUTO, SOFT] {
            if let Some(message) = self.pedals.take(self.voice.channel, pedal, 0.0) {
                out.put(&message);
            }
        }
    }

    fn reset(&mut self) -> ErardStatus {
        (self.clock, self.pedals, self.lost_messages) = (ScanClock::default(), Pedals::up(), 0);
        if self.parts().0.reset() { ErardStatus::Ok } else { ErardStatus::Internal }
    }

    /// Takes a scan of a caller's readings, the second ones only from sensors of releases.
    ///
    /// # Safety
    /// `readings` are NULL or `count` readings each that do not change during the call. `midi` is NULL, or writable
    /// memory for `room` bytes; `length` is NULL, or writable memory for a size.
    pub(crate) unsafe fn take_scan(
        &mut self,
        time_s: f64,
        readings: [*const f32; 2],
        count: usize,
        (midi, room, length): (*mut u8, usize, *mut usize),
    ) -> ErardStatus {
        let [first, second] = readings;
        if first.is_null() {
            return ErardStatus::Null;
        }
        if count != self.key_count {
            return ErardStatus::Size;
        }
        // SAFETY: `first` is not NULL, and begins `count` readings, at most 88, that do not change during the call.
        let first = unsafe { core::slice::from_raw_parts(first, count) };
        // SAFETY: `second` is NULL, or begins `count` readings, at most 88, that do not change during the call.
        let second = (!second.is_null()).then(|| unsafe { core::slice::from_raw_parts(second, count) });
        let are_finite = |all: &[f32]| all.iter().all(|reading| reading.is_finite());
        if !time_s.is_finite() || !are_finite(first) || !second.is_none_or(are_finite) {
            return ErardStatus::NotFinite;
        }
        let needed = self.room();
        // SAFETY: `midi` is NULL, or writable memory for `room` bytes; `length` is NULL, or writable memory for a size.
        unsafe { self.play((midi, room, length), needed, |board, out| board.scan(time_s, (first, second), out)) }
    }

    /// Plays into the caller's room, and tells how much of it was used.
    ///
    /// # Safety
    /// `bytes` is NULL, or writable memory for `room` bytes; `length` is NULL, or writable memory for a size.
    pub(crate) unsafe fn play(
        &mut self,
        (bytes, room, length): (*mut u8, usize, *mut usize),
        needed: usize,
        play: impl FnOnce(&mut Self, &mut Out) -> ErardStatus,
    ) -> ErardStatus {
        if bytes.is_null() || length.is_null() {
            return ErardStatus::Null;
        }
        if room < needed {
            return ErardStatus::Size;
        }
        quick(|| {
            let mut out = Out { at: bytes, room, used: 0, lost: 0 };
            let status = play(self, &mut out);
            if status as i32 >= 0 {
                self.lost_messages = self.lost_messages.saturating_add(out.lost);
                // SAFETY: `length` is not NULL, and writable memory for a size, by the contract of this function.
                unsafe { *length = out.used };
            }
            status
        })
    }
}

/// A fault of a setup.
pub(crate) fn refused(status: ErardStatus, what: &'static str) -> Fault {
    Fault::of(status, &what)
}

/// Checks that a number is finite and lies in a range.
pub(crate) fn within(number: f64, [low, high]: [f64; 2], what: &'static str) -> Result<f64, Fault> {
    if !number.is_finite() {
        Err(refused(ErardStatus::NotFinite, what))
    } else if !(low..=high).contains(&number) {
        Err(refused(ErardStatus::Range, what))
    } else {
        Ok(number)
    }
}

impl ErardBoardSetup {
    /// The numbers of the keys; none outside a piano.
    pub(crate) fn keys(&self) -> Result<RangeInclusive<usize>, Fault> {
        let (first, count) = (self.first_key as usize, self.key_count as usize);
        if first == 0 || count == 0 || first > KEYS || count > KEYS + 1 - first {
            return Err(refused(ErardStatus::NoSuch, "first_key and key_count; expected keys from 1 to 88"));
        }
        Ok(first..=first + count - 1)
    }

    pub(crate) fn voice(&self) -> Result<Voice<'static>, Fault> {
        let channel = u8::try_from(self.channel).ok().filter(|channel| *channel < 16);
        let channel = channel.ok_or_else(|| refused(ErardStatus::Argument, "channel; expected 0 to 15"))?;
        let resolution = match self.velocity_bits {
            0 | 7 => Resolution::SevenBits,
            14 => Resolution::FourteenBits,
            _ => return Err(refused(ErardStatus::Argument, "velocity_bits; expected 7 or 14")),
        };
        let law = match self.velocity_law {
            ERARD_VELOCITY_USUAL => Law::GOEBL,
            ERARD_VELOCITY_LOGARITHMIC => Law::Logarithmic {
                at_one: within(self.velocity_at_one, [0.0, 127.0], "velocity_at_one; expected 0 to 127")?,
                per_octave: within(self.velocity_per_octave, [1.0, 127.0], "velocity_per_octave; expected 1 to 127")?,
            },
            ERARD_VELOCITY_LINEAR => Law::Linear {
                full_m_per_s: within(
                    self.velocity_full_m_per_s,
                    [0.1, 100.0],
                    "velocity_full_m_per_s; expected 0.1 to 100 m/s",
                )?,
            },
            _ => return Err(refused(ErardStatus::Argument, "velocity_law; expected an ERARD_VELOCITY_ number")),
        };
        let release = match self.release_m_per_s {
            0.0 => ReleaseLaw::USUAL,
            usual => ReleaseLaw {
                usual_m_per_s: within(usual, [1e-3, 10.0], "release_m_per_s; expected 0.001 to 10 m/s, or 0")?,
            },
        };
        Ok(Voice { channel, law, release, resolution })
    }

    /// The sensor of a key whose stops are not known.
    pub(crate) fn sensor(&self) -> Result<Sensor, Fault> {
        let kind = match self.kind {
            ERARD_BOARD_ACTION => SensorKind::Action,
            ERARD_BOARD_LIGHT => SensorKind::Light,
            _ => return Err(refused(ErardStatus::Argument, "kind; expected ERARD_BOARD_ACTION or ERARD_BOARD_LIGHT")),
        };
        let law = match self.sensor_law {
            ERARD_SENSOR_LINEAR => FixedLaw::Linear {},
            ERARD_SENSOR_CNY70 => FixedLaw::Cny70 {},
            ERARD_SENSOR_HALL => FixedLaw::Hall {
                nearest_mm: within(1e3 * self.nearest_m, [0.1, 100.0], "nearest_m; expected 0.0001 to 0.1 m")?,
                at_rest: self.nearest_at_rest != 0,
            },
            _ => return Err(refused(ErardStatus::Argument, "sensor_law; expected an ERARD_SENSOR_ number")),
        };
        let travel_m = within(self.travel_m, TRAVEL_M, "travel_m; expected 0.0005 to 0.1 m")?;
        let still = within(self.still, [0.0, f64::MAX], "still; expected a number of readings, not negative")?;
        Ok(Sensor { kind, law, stops: Stops { rest: 0.0, pressed: 1.0 }, still, travel_m, front_per_sensed: 1.0 })
    }

    /// Checks that fields are 0 which mean nothing for a kind of board.
    pub(crate) fn unused(fields: &[(bool, &'static str)]) -> Result<(), Fault> {
        let used = fields.iter().find(|(is_zero, _)| !is_zero);
        used.map_or(Ok(()), |(_, what)| Err(refused(ErardStatus::Argument, what)))
    }

    fn asked(&self) -> Result<Asked, Fault> {
        let step_s = match self.step_s {
            0.0 => None,
            step_s => Some(within(step_s, STEP_S, "step_s; expected 1e-6 to 1e-3 s, or 0")?),
        };
        let at = || within(self.sensor_at_m.abs(), [0.5e-3, 0.5], "sensor_at_m; expected 0.0005 to 0.5 m, or 0");
        let sensor_at_m = if self.sensor_at_m == 0.0 { None } else { Some(at()?) };
        Ok(Asked { keys: self.keys()?, sensor: self.sensor()?, step_s, sensor_at_m })
    }
}

/// The stops of one of the caller's keys; `None` for a key without a sensor.
pub(crate) unsafe fn stops_of(stops: *const ErardStops, index: usize) -> Result<Option<Stops>, Fault> {
    // SAFETY: `stops` is NULL, or an initialised array of more than `index` structs of the size that the first one
    // states.
    let own = unsafe { given_nth(stops, index) }.map_err(|status| refused(status, "the stops"))?;
    let ErardStops { rest, pressed, .. } = own;
    if !(rest.is_finite() && pressed.is_finite()) {
        return Err(refused(ErardStatus::NotFinite, "the readings at a key's stops"));
    }
    if rest == 0.0 && pressed == 0.0 {
        return Ok(None);
    }
    // As they are read.
    if rest as f32 == pressed as f32 || !(rest as f32).is_finite() || !(pressed as f32).is_finite() {
        return Err(refused(ErardStatus::Range, "the readings at a key's stops; expected two different numbers"));
    }
    Ok(Some(Stops { rest, pressed }))
}

/// Returns the number of bytes that a board of so many keys takes; 0 for no key or more than 88. Real time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn erard_board_bytes(key_count: u32) -> usize {
    List::<Shared, BoardKey>::bytes(key_count)
}

/// The alignment of every board's memory, bytes: that of no kind of keys is larger, which [`begin`] sees to.
const ALIGNMENT: usize = List::<Shared, BoardKey>::ALIGNMENT;

/// Returns the alignment of a board's memory, bytes: memory of malloc has it, and so has an array of double on every
/// usual machine. Real time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn erard_board_alignment() -> usize {
    ALIGNMENT
}

/// Makes a board in a caller's memory: `make` writes its keys, and returns what they share.
///
/// # Safety
/// `memory` is NULL, or writable memory of `bytes` bytes that nothing else uses as long as the board lasts. `make`
/// writes all keys of the setup, or fails.
pub(crate) unsafe fn begin<S, K>(
    (memory, bytes): (*mut c_void, usize),
    (setup, voice): (&ErardBoardSetup, Voice<'static>),
    make: impl FnOnce(*mut Option<K>) -> Result<S, Fault>,
) -> Result<*mut ErardBoard, Fault>
where
    List<S, K>: Keys + 'static,
{
    const { assert!(List::<S, K>::ALIGNMENT <= ALIGNMENT) };
    if memory.is_null() {
        return Err(refused(ErardStatus::Null, "the memory"));
    }
    if !memory.addr().is_multiple_of(ALIGNMENT) {
        return Err(refused(ErardStatus::Argument, "the memory; expected the alignment of erard_board_alignment"));
    }
    if bytes < List::<S, K>::bytes(setup.key_count) {
        return Err(refused(ErardStatus::Size, "the memory; expected as many bytes as a board of this kind takes"));
    }
    let memory: *mut u8 = memory.cast();
    // SAFETY: `memory` has room for board, list and keys, so that KEYS_AT and AT lie in it or at its end.
    let (keys, list) =
        unsafe { (memory.add(List::<S, K>::KEYS_AT).cast(), memory.add(List::<S, K>::AT).cast::<List<S, K>>()) };
    let (shared, count) = (make(keys)?, setup.key_count as usize);
    // SAFETY: `list` is aligned memory with room for a list, and not NULL.
    let list = unsafe {
        list.write(List { shared, keys, count });
        NonNull::new_unchecked(list)
    };
    let board = ErardBoard {
        voice,
        clock: ScanClock::default(),
        pedals: Pedals::up(),
        first_key: setup.first_key,
        lost_messages: 0,
        key_count: count,
        keys: list,
    };
    let place: *mut ErardBoard = memory.cast();
    // SAFETY: `place` is aligned memory with room for a board.
    unsafe { place.write(board) };
    Ok(place)
}

/// Makes a board in `memory` of `bytes` bytes (erard_board_bytes, erard_board_alignment), which stays the caller's
/// and must not move. `stops` has an element for each key of the setup. `keyboard` is the text of a keyboard file
/// (UTF-8, `length` bytes) whose base instrument is built in; NULL and 0 give the built-in concert grand, the only
/// one on a chip, where all keys have the action of its middle C. Each key is pressed some times to find its
/// limits, which takes a tenth of a second a key, on all cores; and its action takes memory, which erard_board_free
/// gives back. On a chip both are prepared. Returns the board, or NULL on failure: `status` (which may be NULL)
/// receives the reason, and erard_last_error describes it. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_new(
    memory: *mut c_void,
    bytes: usize,
    setup: *const ErardBoardSetup,
    stops: *const ErardStops,
    keyboard: *const c_char,
    length: usize,
    status: *mut ErardStatus,
) -> *mut ErardBoard {
    told(null_mut(), status, || {
        // SAFETY: `setup` is NULL, or an initialised ErardBoardSetup of the size that it states.
        let setup = unsafe { given(setup) }.map_err(|status| refused(status, "the setup"))?;
        let (voice, asked) = (setup.voice()?, setup.asked()?);
        let first = *asked.keys.start();
        // Checked before anything is written.
        for index in 0..setup.key_count as usize {
            // SAFETY: `stops` is NULL, or an initialised array of as many structs as the setup has keys.
            unsafe { stops_of(stops, index) }?;
        }
        let stops = |key: usize| {
            // SAFETY: `stops` is an initialised array of as many structs as the setup has keys, one of which is this.
            unsafe { stops_of(stops, key - first) }.unwrap_or_default()
        };
        let make = |keys: *mut Option<BoardKey>| {
            let mut put = |key: usize, made: Option<BoardKey>| {
                // SAFETY: `keys` is aligned memory with room for the keys of the setup, one of which is this.
                unsafe { keys.add(key - first).write(made) };
            };
            // SAFETY: `keyboard` is NULL, or `length` readable bytes that do not change during the call.
            unsafe { make(&asked, (keyboard, length), &stops, &mut put) }
        };
        // SAFETY: `memory` is NULL, or writable memory of `bytes` bytes that stays the board's; `make` writes all keys.
        unsafe { begin::<Shared, BoardKey>((memory, bytes), (&setup, voice), make) }
    })
}

/// Gives back what the function that made the board took beside the caller's memory, which may then be used otherwise.
/// NULL does nothing. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_free(board: *mut ErardBoard) {
    if !board.is_null() {
        quick(|| {
            // SAFETY: `board` is not NULL, comes from a function that makes boards, has not been freed, and is not used
            // again; so do its keys.
            unsafe {
                let keys = (*board).keys;
                core::ptr::drop_in_place(keys.as_ptr());
                core::ptr::drop_in_place(board);
            }
            ErardStatus::Ok
        });
    }
}

/// Gives the sensors of all keys a law of your own: `count` points, at least two, each the share of a reading's range
/// and the share of the travel, both from 0 to 1, ascending. The points are not copied: they must last as long as the
/// board, in flash, say. Call it before the first scan. Of hammers it is the law of their heads' sensors. Returns
/// ERARD_STATUS_ARGUMENT for points that do not rise from {0, 0} to {1, 1}, and for a board of contacts. Real time:
/// yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_sensor_table(
    board: *mut ErardBoard,
    points: *const [f64; 2],
    count: usize,
) -> ErardStatus {
    // SAFETY: `board` is NULL, or was made by this library, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    // SAFETY: `points` is NULL, or `count` points that do not change as long as the board is used.
    let points = match unsafe { lasting(points, count) } {
        Ok(points) => points,
        Err(status) => return status,
    };
    let law = FixedLaw::Table { points };
    if law.check().is_err() || matches!(board.sensed(), Sensed::Contacts(_)) {
        return ErardStatus::Argument;
    }
    board.parts().0.set_law(law);
    ErardStatus::Ok
}

/// Gives the board a velocity law of your own: `count` points, at least two, each a hammer speed, m/s, and a velocity,
/// 0 to 127, both ascending; straight lines between them in velocity and the logarithm of the speed. The points are not
/// copied: they must last as long as the board. Returns ERARD_STATUS_ARGUMENT for points that do not rise. Real time:
/// yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_velocity_table(
    board: *mut ErardBoard,
    points: *const [f64; 2],
    count: usize,
) -> ErardStatus {
    // SAFETY: `board` is NULL, or was made by this library, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    // SAFETY: `points` is NULL, or `count` points that do not change as long as the board is used.
    let points = match unsafe { lasting(points, count) } {
        Ok(points) => points,
        Err(status) => return status,
    };
    match Law::table(points) {
        Ok(law) => board.voice.law = law,
        Err(_) => return ErardStatus::Argument,
    }
    ErardStatus::Ok
}

/// The caller's points, which last.
///
/// # Safety
/// `points` is NULL, or `count` points that do not change as long as the board is used.
unsafe fn lasting(points: *const [f64; 2], count: usize) -> Result<&'static [[f64; 2]], ErardStatus> {
    if points.is_null() {
        return Err(ErardStatus::Null);
    }
    if count > isize::MAX as usize / size_of::<[f64; 2]>() {
        return Err(ErardStatus::Size);
    }
    // SAFETY: `points` is not NULL, and `count` points that do not change as long as they are used, no more than a
    // memory holds (the contract of this function).
    Ok(unsafe { core::slice::from_raw_parts(points, count) })
}

/// Takes the readings of all keys at an instant, s on the scanner's clock: `count` readings, one for each key of the
/// setup. Writes the resulting MIDI bytes, whole messages, to `midi`, which must have room for ERARD_BOARD_KEY_BYTES
/// for each key, and their number to `length`. A note-on is written once its hammer has met the string, a note-off once
/// the key, coming up, has set its damper down. After a gap of more than a second held notes end first, and nothing is
/// simulated for it. Of hammers they are the readings of their heads. Returns ERARD_STATUS_RANGE for an instant that is
/// not after the last one, ERARD_STATUS_NOT_FINITE for a reading that is no number, and ERARD_STATUS_ARGUMENT for a
/// board of contacts. Real time: yes; the work is that of the time since the last scan for the keys that move, and
/// nearly none for those at rest.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_scan(
    board: *mut ErardBoard,
    time_s: f64,
    readings: *const f32,
    count: usize,
    midi: *mut u8,
    room: usize,
    length: *mut usize,
) -> ErardStatus {
    // SAFETY: `board` is NULL, or was made by this library, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    if matches!(board.sensed(), Sensed::Contacts(_)) {
        return ErardStatus::Argument;
    }
    // SAFETY: `readings` is NULL, or `count` readings that do not change during the call. `midi` is NULL, or writable
    // memory for `room` bytes; `length` is NULL, or writable memory for a size.
    unsafe { board.take_scan(time_s, [readings, core::ptr::null()], count, (midi, room, length)) }
}

/// Takes the position of a pedal, 0 (up) to 1 (down), by its controller: 64 sustain, 66 sostenuto, 67 soft. Writes a
/// controller's message to `midi`, which must have room for three bytes, if its value has changed, and the number of
/// bytes to `length`. Returns ERARD_STATUS_ARGUMENT for another controller. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_pedal(
    board: *mut ErardBoard,
    controller: u32,
    down: f64,
    midi: *mut u8,
    room: usize,
    length: *mut usize,
) -> ErardStatus {
    // SAFETY: `board` is NULL, or was made by this library, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    if !down.is_finite() {
        return ErardStatus::NotFinite;
    }
    let known = |number: u32| [SUSTAIN, SOSTENUTO, SOFT].into_iter().find(|own| u32::from(*own) == number);
    let Some(controller) = known(controller) else { return ErardStatus::Argument };
    let play = |board: &mut ErardBoard, out: &mut Out| {
        if let Some(message) = board.pedals.take(board.voice.channel, controller, down) {
            out.put(&message);
        }
        ErardStatus::Ok
    };
    // SAFETY: `midi` is NULL, or writable memory for `room` bytes; `length` is NULL, or writable memory for a size.
    unsafe { board.play((midi, room, length), MESSAGE_BYTES / 2, play) }
}

/// Lets all keys go, whatever their sensors read, follows them to their rest, and lets the pedals up: no note is left.
/// For the end, or a scanner that has stalled. Writes to `midi` and `length` as erard_board_scan does. Real time: yes;
/// up to a second of every key that is not at rest is simulated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_let_go(
    board: *mut ErardBoard,
    midi: *mut u8,
    room: usize,
    length: *mut usize,
) -> ErardStatus {
    // SAFETY: `board` is NULL, or was made by this library, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    let play = |board: &mut ErardBoard, out: &mut Out| {
        board.let_go(out);
        ErardStatus::Ok
    };
    let needed = board.room();
    // SAFETY: `midi` is NULL, or writable memory for `room` bytes; `length` is NULL, or writable memory for a size.
    unsafe { board.play((midi, room, length), needed, play) }
}

/// Puts a board back to where it was made, its laws as they are: keys at rest, no drift, nothing counted, a new clock,
/// pedals up. Nothing is sent. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_reset(board: *mut ErardBoard) -> ErardStatus {
    // SAFETY: `board` is NULL, or was made by this library, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    quick(|| board.reset())
}

/// Writes the state of a key to `state`; `key` counts from 1, the lowest A of a piano. Returns ERARD_STATUS_NO_SUCH for
/// a key that is not one of the board's, or has no sensor. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_read(board: *mut ErardBoard, key: u32, state: *mut ErardBoardKey) -> ErardStatus {
    // SAFETY: `board` is NULL, or was made by this library, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    // SAFETY: `state` is NULL, or aligned and writable memory that begins with its size.
    let place = match unsafe { Place::new(state) } {
        Ok(Some(place)) => place,
        Ok(None) => return ErardStatus::Null,
        Err(status) => return status,
    };
    let lost_messages = board.lost_messages;
    let Some(now) = board.index(key).and_then(|index| board.parts().0.read(index)) else { return ErardStatus::NoSuch };
    let now = ErardBoardKey { lost_messages, ..now };
    // SAFETY: `place` is the caller's memory for one state, which nothing else uses during the call.
    unsafe { place.write(0, &now) };
    ErardStatus::Ok
}

/// Finds the stops of a key in `count` of its readings, `period_s` apart: the key was left at rest for half a second,
/// pressed to its bottom, held there, and let go, as often as you like, as for `erard calibrate`. Writes them to
/// `stops`. `key` is named in messages only. On failure returns ERARD_STATUS_ARGUMENT, and erard_last_error says why:
/// too few readings, a reading that never changes, a range too small for its noise, a key that was never held. Real
/// time: no, but nothing is allocated: a chip can call it, too (a second for ten seconds of readings).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_calibrate(
    key: u32,
    readings: *const f32,
    count: usize,
    period_s: f64,
    stops: *mut ErardStops,
) -> ErardStatus {
    tell(|| {
        if readings.is_null() {
            return Err(refused(ErardStatus::Null, "the readings"));
        }
        if count > isize::MAX as usize / size_of::<f32>() {
            return Err(refused(ErardStatus::Size, "the number of readings"));
        }
        within(period_s, [1e-6, 0.02], "period_s; expected 1e-6 to 0.02 s")?;
        // SAFETY: `stops` is NULL, or aligned and writable memory that begins with its size.
        let place = unsafe { Place::new(stops) }.map_err(|status| refused(status, "the stops"))?;
        let place = place.ok_or_else(|| refused(ErardStatus::Null, "the stops"))?;
        // SAFETY: `readings` is not NULL, and begins `count` readings, no more than a memory holds, that do not change
        // during the call.
        let readings = unsafe { core::slice::from_raw_parts(readings, count) };
        if !readings.iter().all(|reading| reading.is_finite()) {
            return Err(refused(ErardStatus::NotFinite, "a reading"));
        }
        let at = |index: usize| [index as f64 * period_s, f64::from(readings[index])];
        let found = Seen::of(key as usize, count, at).and_then(|seen| seen.found(seen.still()));
        let found = found.map_err(|fault| Fault::of(ErardStatus::Argument, &fault))?;
        let Stops { rest, pressed } = found.stops;
        let made = ErardStops { rest, pressed, noise: found.noise, drift: found.drift, ..ErardStops::default() };
        // SAFETY: `place` is the caller's memory for one struct, which nothing else uses during the call.
        unsafe { place.write(0, &made) };
        Ok(())
    })
}

//! A board: keys with sensors, from readings to bytes of MIDI, in the caller's memory. This file is compiled for chips,
//! too (`bindings/firmware`): what differs there is `board_keys.rs`, the keys' actions.

use core::ffi::{c_char, c_void};
use core::ops::RangeInclusive;
use core::ptr::null_mut;

use erard_live::SensorKind;
use erard_live::board::Pedals;
use erard_live::converter::Stops;
use erard_live::sensing::{ScanClock, Sensor, Voice};
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
const TRAVEL_M: [f64; 2] = [0.5e-3, 0.1];
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
    /// 1 if its action is at a complete rest: it then takes no steps, whatever keys beside it do.
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
}

impl Default for ErardBoardKey {
    /// All numbers are 0.
    fn default() -> Self {
        Self::zeroed()
    }
}

// SAFETY: a `repr(C)` struct of eight u32 and four f64: no padding, and every bit pattern is a value. `struct_size` is
// its first field.
unsafe impl CallerStruct for ErardBoardKey {
    const FIRST_BYTES: usize = 64;
}

// A smaller struct would break the rule that fields are only added.
const _: () = assert!(size_of::<ErardBoardSetup>() >= ErardBoardSetup::FIRST_BYTES);
const _: () = assert!(size_of::<ErardStops>() >= ErardStops::FIRST_BYTES);
const _: () = assert!(size_of::<ErardBoardKey>() >= ErardBoardKey::FIRST_BYTES);

/// Keys with sensors, in memory of the caller. One thread at a time may use it. It must stay where it was made.
pub struct ErardBoard {
    shared: Shared,
    voice: Voice<'static>,
    clock: ScanClock,
    pedals: Pedals,
    first_key: u32,
    lost_messages: u32,
    /// Behind the board in the same memory; `None` for a key without a sensor.
    keys: *mut Option<BoardKey>,
    key_count: usize,
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

/// Where the keys begin in a board's memory, bytes.
const KEYS_AT: usize = size_of::<ErardBoard>().next_multiple_of(align_of::<Option<BoardKey>>());
/// The alignment of its memory, bytes.
const ALIGNMENT: usize = if align_of::<ErardBoard>() > align_of::<Option<BoardKey>>() {
    align_of::<ErardBoard>()
} else {
    align_of::<Option<BoardKey>>()
};

/// The caller's room for bytes of MIDI.
struct Out {
    at: *mut u8,
    room: usize,
    used: usize,
    lost: u32,
}

impl Out {
    /// Writes a whole message, or none of it.
    fn put(&mut self, message: &Message) {
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
    /// Its parts, and its keys.
    fn parts(&mut self) -> (&mut Shared, &Voice<'static>, &mut [Option<BoardKey>]) {
        // SAFETY: `self.keys` is the place of `self.key_count` keys behind the board, all of which were written when it
        // was made; they are borrowed as long as the board is.
        let keys = unsafe { core::slice::from_raw_parts_mut(self.keys, self.key_count) };
        (&mut self.shared, &self.voice, keys)
    }

    fn room(&self) -> usize {
        self.key_count * ERARD_BOARD_KEY_BYTES
    }

    fn scan(&mut self, time_s: f64, readings: &[f32], out: &mut Out) -> ErardStatus {
        let Some(scan) = self.clock.take(time_s) else { return ErardStatus::Range };
        let (shared, voice, keys) = self.parts();
        if let Some([ends_s, to_s]) = scan.gap {
            for key in keys.iter_mut().flatten() {
                key.let_go(shared, ends_s, voice, &mut |message| out.put(&message));
                key.jump(to_s);
            }
        }
        for (key, reading) in keys.iter_mut().zip(readings) {
            if let Some(key) = key {
                key.take(shared, (scan.time_s, *reading), voice, &mut |message| out.put(&message));
            }
        }
        ErardStatus::Ok
    }

    fn let_go(&mut self, out: &mut Out) {
        let now_s = self.clock.now_s();
        let (shared, voice, keys) = self.parts();
        for key in keys.iter_mut().flatten() {
            key.let_go(shared, now_s, voice, &mut |message| out.put(&message));
        }
        for pedal in [SUSTAIN, SOSTENUTO, SOFT] {
            if let Some(message) = self.pedals.take(self.voice.channel, pedal, 0.0) {
                out.put(&message);
            }
        }
    }

    fn reset(&mut self) -> ErardStatus {
        (self.clock, self.pedals, self.lost_messages) = (ScanClock::default(), Pedals::up(), 0);
        let (shared, _, keys) = self.parts();
        let faults = keys.iter_mut().flatten().map(|key| key.reset(shared)).filter(|is_reset| !is_reset).count();
        if faults == 0 { ErardStatus::Ok } else { ErardStatus::Internal }
    }

    /// Plays into the caller's room, and tells how much of it was used.
    ///
    /// # Safety
    /// `bytes` is NULL, or writable memory for `room` bytes; `length` is NULL, or writable memory for a size.
    unsafe fn play(
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
fn refused(status: ErardStatus, what: &'static str) -> Fault {
    Fault::of(status, &what)
}

/// Checks that a number is finite and lies in a range.
fn within(number: f64, [low, high]: [f64; 2], what: &'static str) -> Result<f64, Fault> {
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
    fn keys(&self) -> Result<RangeInclusive<usize>, Fault> {
        let (first, count) = (self.first_key as usize, self.key_count as usize);
        if first == 0 || count == 0 || first > KEYS || count > KEYS + 1 - first {
            return Err(refused(ErardStatus::NoSuch, "first_key and key_count; expected keys from 1 to 88"));
        }
        Ok(first..=first + count - 1)
    }

    fn voice(&self) -> Result<Voice<'static>, Fault> {
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
    fn sensor(&self) -> Result<Sensor, Fault> {
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
unsafe fn stops_of(stops: *const ErardStops, index: usize) -> Result<Option<Stops>, Fault> {
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
    let count = key_count as usize;
    if (1..=KEYS).contains(&count) { KEYS_AT + count * size_of::<Option<BoardKey>>() } else { 0 }
}

/// Returns the alignment of a board's memory, bytes: memory of malloc has it, and so has an array of double on every
/// usual machine. Real time: yes.
#[unsafe(no_mangle)]
pub extern "C" fn erard_board_alignment() -> usize {
    ALIGNMENT
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
        if memory.is_null() {
            return Err(refused(ErardStatus::Null, "the memory"));
        }
        if !memory.addr().is_multiple_of(ALIGNMENT) {
            return Err(refused(ErardStatus::Argument, "the memory; expected the alignment of erard_board_alignment"));
        }
        if bytes < erard_board_bytes(setup.key_count) {
            return Err(refused(ErardStatus::Size, "the memory; expected the size of erard_board_bytes"));
        }
        // Checked before anything is written.
        for index in 0..setup.key_count as usize {
            // SAFETY: `stops` is NULL, or an initialised array of as many structs as the setup has keys.
            unsafe { stops_of(stops, index) }?;
        }
        // SAFETY: `memory` has room for the board and its keys, so that KEYS_AT lies in it or at its end.
        let keys: *mut Option<BoardKey> = unsafe { memory.cast::<u8>().add(KEYS_AT) }.cast();
        let stops = |key: usize| {
            // SAFETY: `stops` is an initialised array of as many structs as the setup has keys, one of which is this.
            unsafe { stops_of(stops, key - first) }.unwrap_or_default()
        };
        let mut put = |key: usize, made: Option<BoardKey>| {
            // SAFETY: `keys` is aligned memory with room for the keys of the setup, one of which is this.
            unsafe { keys.add(key - first).write(made) };
        };
        // SAFETY: `keyboard` is NULL, or `length` readable bytes that do not change during the call.
        let shared = unsafe { make(&asked, (keyboard, length), &stops, &mut put) }?;
        let board = ErardBoard {
            shared,
            voice,
            clock: ScanClock::default(),
            pedals: Pedals::up(),
            first_key: setup.first_key,
            lost_messages: 0,
            keys,
            key_count: setup.key_count as usize,
        };
        let place: *mut ErardBoard = memory.cast();
        // SAFETY: `place` is aligned memory with room for a board.
        unsafe { place.write(board) };
        Ok(place)
    })
}

/// Gives back what erard_board_new took beside the caller's memory, which may then be used otherwise. NULL does
/// nothing. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_free(board: *mut ErardBoard) {
    if !board.is_null() {
        quick(|| {
            // SAFETY: `board` is not NULL, comes from erard_board_new, has not been freed, and is not used again; so do
            // its keys.
            unsafe {
                let (keys, count) = ((*board).keys, (*board).key_count);
                core::ptr::drop_in_place(core::ptr::slice_from_raw_parts_mut(keys, count));
                core::ptr::drop_in_place(board);
            }
            ErardStatus::Ok
        });
    }
}

/// Gives the sensors of all keys a law of your own: `count` points, at least two, each the share of a reading's range
/// and the share of the travel, both from 0 to 1, ascending. The points are not copied: they must last as long as the
/// board, in flash, say. Call it before the first scan. Returns ERARD_STATUS_ARGUMENT for points that do not rise from
/// {0, 0} to {1, 1}. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_sensor_table(
    board: *mut ErardBoard,
    points: *const [f64; 2],
    count: usize,
) -> ErardStatus {
    // SAFETY: `board` is NULL, or comes from erard_board_new, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    // SAFETY: `points` is NULL, or `count` points that do not change as long as the board is used.
    let points = match unsafe { lasting(points, count) } {
        Ok(points) => points,
        Err(status) => return status,
    };
    let law = FixedLaw::Table { points };
    if law.check().is_err() {
        return ErardStatus::Argument;
    }
    let (_, _, keys) = board.parts();
    keys.iter_mut().flatten().for_each(|key| key.set_law(law));
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
    // SAFETY: `board` is NULL, or comes from erard_board_new, has not been freed, and no other call uses it meanwhile.
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
/// simulated for it. Returns ERARD_STATUS_RANGE for an instant that is not after the last one, and
/// ERARD_STATUS_NOT_FINITE for a reading that is no number. Real time: yes; the work is that of the time since the last
/// scan for the keys that move, and nearly none for those at rest.
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
    // SAFETY: `board` is NULL, or comes from erard_board_new, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    if readings.is_null() {
        return ErardStatus::Null;
    }
    if count != board.key_count {
        return ErardStatus::Size;
    }
    // SAFETY: `readings` is not NULL, and begins `count` readings, at most 88, that do not change during the call.
    let readings = unsafe { core::slice::from_raw_parts(readings, count) };
    if !time_s.is_finite() || !readings.iter().all(|reading| reading.is_finite()) {
        return ErardStatus::NotFinite;
    }
    let needed = board.room();
    // SAFETY: `midi` is NULL, or writable memory for `room` bytes; `length` is NULL, or writable memory for a size.
    unsafe { board.play((midi, room, length), needed, |board, out| board.scan(time_s, readings, out)) }
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
    // SAFETY: `board` is NULL, or comes from erard_board_new, has not been freed, and no other call uses it meanwhile.
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
    // SAFETY: `board` is NULL, or comes from erard_board_new, has not been freed, and no other call uses it meanwhile.
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
    // SAFETY: `board` is NULL, or comes from erard_board_new, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    quick(|| board.reset())
}

/// Writes the state of a key to `state`; `key` counts from 1, the lowest A of a piano. Returns ERARD_STATUS_NO_SUCH for
/// a key that is not one of the board's, or has no sensor. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_read(board: *mut ErardBoard, key: u32, state: *mut ErardBoardKey) -> ErardStatus {
    // SAFETY: `board` is NULL, or comes from erard_board_new, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    // SAFETY: `state` is NULL, or aligned and writable memory that begins with its size.
    let place = match unsafe { Place::new(state) } {
        Ok(Some(place)) => place,
        Ok(None) => return ErardStatus::Null,
        Err(status) => return status,
    };
    let (lost_messages, first) = (board.lost_messages, board.first_key);
    let (_, _, keys) = board.parts();
    let index = key.checked_sub(first).map(|index| index as usize);
    let Some(Some(own)) = index.and_then(|index| keys.get(index)) else { return ErardStatus::NoSuch };
    let (counts, (drift, beyond)) = (own.counts(), own.drift());
    let now = ErardBoardKey {
        asleep: u32::from(own.is_asleep()),
        limited_strokes: counts.fast_strokes,
        flutters: counts.flutters,
        stuck: counts.stuck,
        drifts_beyond: u32::try_from(beyond).unwrap_or(u32::MAX),
        lost_messages,
        deep_readings: counts.deep_samples as f64,
        non_finite_steps: counts.non_finite as f64,
        fastest_hammer_m_per_s: counts.fastest_m_per_s,
        drift,
        ..ErardBoardKey::default()
    };
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

//! Boards whose sensors read the shanks of hammers: readings to bytes of MIDI. Nothing is simulated while they play.
//! This file is compiled for chips, too (`bindings/firmware`).

use core::ffi::c_void;
use core::ptr::null_mut;

use erard_live::converter::{Converter, Stops};
use erard_live::hammers::{HammerKey, Release};
use erard_live::sensing::{Scan, Voice};
use erard_live::sensor::FixedLaw;
use erard_midi::note_of_key;

use crate::board::{
    ErardBoard, ErardBoardKey, ErardBoardSetup, ErardStops, Keys, List, Send, Sensed, TRAVEL_M, begin, of_u64, refused,
    stops_of, within,
};
use crate::caller_struct::{CallerStruct, given};
use crate::outcome::ErardStatus;
use crate::status::{Fault, told};

/// A second sensor of each hammer's key, at the key or the damper, which sees its release.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ErardRelease {
    /// sizeof(ErardRelease).
    pub struct_size: u32,
    /// 0.
    pub reserved: u32,
    /// Travel of the sensed place between its two stops, m, 0.5 mm to 100 mm, in proportion to the reading.
    pub travel_m: f64,
    /// Its travel at which, coming up, the damper lies on the string, m, within the travel.
    pub off_m: f64,
}

impl Default for ErardRelease {
    /// All numbers are 0.
    fn default() -> Self {
        Self::zeroed()
    }
}

// SAFETY: a `repr(C)` struct of two u32 and two f64: no padding, and every bit pattern is a value. `struct_size` is its
// first field.
unsafe impl CallerStruct for ErardRelease {
    const FIRST_BYTES: usize = 24;
}

impl ErardRelease {
    fn checked(&self) -> Result<Release, Fault> {
        let travel_m = within(self.travel_m, TRAVEL_M, "travel_m of the release; expected 0.0005 to 0.1 m")?;
        let off_m = within(self.off_m, [0.0, travel_m], "off_m; expected a part of the release's travel_m")?;
        if off_m == 0.0 || off_m == travel_m {
            return Err(refused(ErardStatus::Range, "off_m; expected a part of the release's travel_m"));
        }
        Ok(Release { travel_m, off_m })
    }
}

/// A hammer, and its note.
pub(crate) struct BoardHammer {
    note: u8,
    hammer: HammerKey<&'static [[f64; 2]]>,
}

/// The hammers of a board.
pub(crate) type HammerKeys = List<(), BoardHammer>;

impl Keys for HammerKeys {
    fn sensed(&self) -> Sensed {
        Sensed::Hammers
    }

    fn scan(&mut self, scan: &Scan, (heads, releases): (&[f32], Option<&[f32]>), voice: &Voice<'_>, send: Send<'_>) {
        if let Some([ends_s, _]) = scan.gap {
            self.let_go(ends_s, voice, send);
        }
        let (_, keys) = self.parts();
        for (index, own) in keys.iter_mut().enumerate() {
            let Some(BoardHammer { note, hammer }) = own else { continue };
            let mut give = |event| send(voice.message(*note, event));
            hammer.take(scan.time_s, f64::from(heads[index]), &mut give);
            if let Some(releases) = releases {
                hammer.take_release(scan.time_s, f64::from(releases[index]), &mut give);
            }
        }
    }

    fn let_go(&mut self, time_s: f64, voice: &Voice<'_>, send: Send<'_>) {
        for BoardHammer { note, hammer } in self.parts().1.iter_mut().flatten() {
            hammer.let_go(time_s, &mut |event| send(voice.message(*note, event)));
        }
    }

    fn reset(&mut self) -> bool {
        self.parts().1.iter_mut().flatten().for_each(|own| own.hammer.reset());
        true
    }

    fn set_law(&mut self, law: FixedLaw) {
        self.parts().1.iter_mut().flatten().for_each(|own| own.hammer.set_law(law));
    }

    fn read(&self, index: usize) -> Option<ErardBoardKey> {
        let BoardHammer { hammer, .. } = self.key(index)?;
        let (drift, beyond) = hammer.drift();
        Some(ErardBoardKey {
            asleep: u32::from(hammer.is_up()),
            drifts_beyond: of_u64(beyond),
            fastest_hammer_m_per_s: hammer.counts.fastest_m_per_s,
            drift,
            lifts: of_u64(hammer.counts.lifts),
            nearest_m: hammer.counts.nearest_m,
            ..ErardBoardKey::default()
        })
    }
}

/// Returns the number of bytes that a board of so many sensed hammers takes; 0 for none or more than 88. Real time:
/// yes.
#[unsafe(no_mangle)]
pub extern "C" fn erard_board_hammers_bytes(key_count: u32) -> usize {
    HammerKeys::bytes(key_count)
}

/// Makes a board whose sensors read the shanks of hammers, in `memory` of `bytes` bytes (erard_board_hammers_bytes,
/// erard_board_alignment), which stays the caller's and must not move. `setup.travel_m` is the way of a head on its arc
/// from its rest to its string; `kind`, `step_s`, `sensor_at_m` and `still` must be 0. `stops` has an element for each
/// key: its `rest` is the reading of the hammer at rest, its `pressed` that of the hammer held against its string.
/// `release` and `release_stops` describe the second sensors, whose stops are 0 for a key that has none; without them,
/// both NULL, a note ends when its head has fallen to a quarter of its way, with velocity 64. Nothing is simulated.
/// Returns the board, or NULL on failure: `status` (which may be NULL) receives the reason, and erard_last_error
/// describes it. Real time: no, but nothing is allocated.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_hammers_new(
    memory: *mut c_void,
    bytes: usize,
    setup: *const ErardBoardSetup,
    stops: *const ErardStops,
    release: *const ErardRelease,
    release_stops: *const ErardStops,
    status: *mut ErardStatus,
) -> *mut ErardBoard {
    told(null_mut(), status, || {
        // SAFETY: `setup` is NULL, or an initialised ErardBoardSetup of the size that it states.
        let setup = unsafe { given(setup) }.map_err(|status| refused(status, "the setup"))?;
        let (voice, keys) = (setup.voice()?, setup.keys()?);
        ErardBoardSetup::unused(&[
            (setup.kind == 0, "kind; expected 0 for hammers"),
            (setup.step_s == 0.0, "step_s; expected 0 for hammers"),
            (setup.sensor_at_m == 0.0, "sensor_at_m; expected 0 for hammers"),
            (setup.still == 0.0, "still; expected 0 for hammers"),
        ])?;
        let sensor = setup.sensor()?;
        let release = if release.is_null() {
            if !release_stops.is_null() {
                return Err(refused(ErardStatus::Null, "the release, whose stops are given"));
            }
            None
        } else {
            // SAFETY: `release` is not NULL, and an initialised ErardRelease of the size that it states.
            Some(unsafe { given(release) }.map_err(|status| refused(status, "the release"))?.checked()?)
        };
        // SAFETY: `stops` and `release_stops` are NULL, or initialised arrays of as many structs as the setup has keys.
        let of = |index: usize| unsafe {
            let second = if release.is_some() { stops_of(release_stops, index)? } else { None };
            Ok::<[Option<Stops>; 2], Fault>([stops_of(stops, index)?, second])
        };
        // Checked before anything is written.
        for index in 0..setup.key_count as usize {
            of(index)?;
        }
        let make = |place: *mut Option<BoardHammer>| {
            for (index, number) in keys.enumerate() {
                let [head, second] = of(index)?;
                let made = head.map(|head| {
                    let second = second.zip(release).map(|(stops, release)| {
                        (Converter::new(FixedLaw::Linear {}, stops, release.travel_m), release)
                    });
                    let head = Converter::new(sensor.law, head, sensor.travel_m);
                    BoardHammer { note: note_of_key(number).unwrap_or(0), hammer: HammerKey::new(head, second) }
                });
                // SAFETY: `place` is aligned memory with room for the keys of the setup, one of which is this.
                unsafe { place.add(index).write(made) };
            }
            Ok(())
        };
        // SAFETY: `memory` is NULL, or writable memory of `bytes` bytes that stays the board's; `make` writes all keys.
        unsafe { begin((memory, bytes), (&setup, voice), make) }
    })
}

/// Takes the readings of all hammers' heads and, unless `releases` is NULL, of the second sensors, at an instant, s on
/// the scanner's clock: `count` readings each, one for each key of the setup. Otherwise as erard_board_scan. A note-on
/// is written when the next reading would come after the impact. Returns ERARD_STATUS_ARGUMENT for a board of others
/// than hammers. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_board_scan_hammers(
    board: *mut ErardBoard,
    time_s: f64,
    heads: *const f32,
    releases: *const f32,
    count: usize,
    midi: *mut u8,
    room: usize,
    length: *mut usize,
) -> ErardStatus {
    // SAFETY: `board` is NULL, or was made by this library, has not been freed, and no other call uses it meanwhile.
    let Some(board) = (unsafe { board.as_mut() }) else { return ErardStatus::Null };
    if board.sensed() != Sensed::Hammers {
        return ErardStatus::Argument;
    }
    // SAFETY: `heads` and `releases` are NULL, or `count` readings each that do not change during the call. `midi` is
    // NULL, or writable memory for `room` bytes; `length` is NULL, or writable memory for a size.
    unsafe { board.take_scan(time_s, [heads, releases], count, (midi, room, length)) }
}

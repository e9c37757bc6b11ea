//! A keyboard: 88 actions; those at rest take no computing time.

use std::ffi::c_char;
use std::path::Path;
use std::ptr::null_mut;

use erard::instrument::utf8;
use erard::keyboard::{Keyboard, Keys, KeysError};
use erard::knocks::{KeyBed, Knock};
use erard::mechanism::{Halving, TellNumbers};
use erard::player::{MechanismState, SnapshotError};
use erard::run::Heard;
use erard::saved::{Lists, Writer};
use erard::strings::Strings;
use erard::{Action, IndexError, Input, Instrument};

use crate::action::moving;
use crate::caller_struct::{Place, given};
use crate::instrument::{builtin_keyboard, file_fault};
use crate::play::{settings, status_of};
use crate::reading::{ErardImpact, ErardInput, ErardReading};
use crate::status::{ErardStatus, Fault, quick, told};
use crate::text::{bytes, name};

/// A whole keyboard under the caller's control. It belongs to the caller until erard_keyboard_free. One thread at a
/// time may use it.
pub struct ErardKeyboard {
    pub(crate) keys: Keys,
    inputs: Vec<ErardInput>,
    impacts: Vec<(f64, f64, u32)>,
    /// What all keys knock on, where a soundboard is heard.
    bed: Option<KeyBed>,
    /// The keyboard's clock less that of its keys, s: a restored state brings its own time.
    offset_s: f64,
}

/// Largest number of steps that one call of erard_keyboard_step accepts.
pub const ERARD_MAX_STEPS: u32 = 1000000;

pub(crate) const MARK: [u8; 8] = *b"erardkbd";

/// Makes 88 keys at rest from the text of a keyboard file (UTF-8, `length` bytes) whose base instrument is built in.
/// NULL and 0 give the built-in concert grand. `step_s` is the step length, s, as for erard_action_new. Each key keeps
/// its input until you change it; at first it is ERARD_INPUT_FREE. Returns NULL on failure: `status` (which may be
/// NULL) receives the reason, and erard_last_error describes it. Real time: no (it takes about half a second).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_new(
    text: *const c_char,
    length: usize,
    step_s: f64,
    status: *mut ErardStatus,
) -> *mut ErardKeyboard {
    told(null_mut(), status, || {
        // SAFETY: `text` is NULL, or `length` readable bytes that do not change during the call.
        let keyboard = match unsafe { bytes(text, length) }? {
            None => builtin_keyboard("concert-grand")?,
            Some(bytes) => {
                let text = utf8(bytes, "keyboard").map_err(|error| file_fault(&error))?;
                Keyboard::parse(text, "keyboard", Path::new("")).map_err(|error| file_fault(&error))?
            }
        };
        at_rest(&keyboard, step_s)
    })
}

/// Makes 88 keys at rest from a built-in keyboard, by its name: `concert-grand`, or `concert-grand-strings` with modal
/// strings. `step_s` is the step length, s. Returns NULL on failure, with ERARD_STATUS_NO_SUCH for an unknown name;
/// otherwise as erard_keyboard_new. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_builtin(
    called: *const c_char,
    step_s: f64,
    status: *mut ErardStatus,
) -> *mut ErardKeyboard {
    told(null_mut(), status, || {
        // SAFETY: `called` is NULL, or a text that ends with a zero and does not change during the call.
        at_rest(&builtin_keyboard(unsafe { name(called, "the keyboard's name") }?)?, step_s)
    })
}

fn at_rest(keyboard: &Keyboard, step_s: f64) -> Result<*mut ErardKeyboard, Fault> {
    // Checked before 88 instruments are read.
    check_step(step_s)?;
    let instruments = keyboard.instruments().map_err(|error| file_fault(&error))?;
    Ok(Box::into_raw(Box::new(ErardKeyboard::new(&instruments, step_s)?)))
}

fn keys_fault(status: ErardStatus, error: &KeysError) -> Fault {
    Fault::new(status, error.to_string())
}

fn check_step(step_s: f64) -> Result<(), Fault> {
    Action::check_step(step_s).map_err(|error| keys_fault(ErardStatus::Range, &KeysError { key: 1, error }))
}

/// The status of a change of one key.
fn done(changed: Result<(), IndexError>) -> ErardStatus {
    if changed.is_ok() { ErardStatus::Ok } else { ErardStatus::NoSuch }
}

impl ErardKeyboard {
    /// Assembles the keys at rest.
    pub(crate) fn new(instruments: &[Instrument], step_s: f64) -> Result<Self, Fault> {
        check_step(step_s)?;
        let mut keys =
            Keys::at_rest(instruments, settings(step_s)).map_err(|error| keys_fault(ErardStatus::Model, &error))?;
        let (inputs, impacts) = (vec![ErardInput::default(); keys.count()], vec![(0.0, 0.0, 0); keys.count()]);
        let bed = (Heard::of(instruments) == Heard::Pressure).then(|| {
            keys.listen(instruments, &Knock::ALL);
            KeyBed::new(1.0 / step_s)
        });
        let offset_s = -keys.time_s();
        Ok(ErardKeyboard { keys, inputs, impacts, bed, offset_s })
    }

    /// Chooses the halving of steps. The clock stays where it is.
    pub(crate) fn halve(&mut self, halving: Halving) {
        let before_s = self.keys.time_s();
        self.keys.halve(halving);
        self.offset_s -= self.keys.time_s() - before_s;
    }

    /// Sets the input of a key, from 1, from the next step on.
    pub(crate) fn drive(&mut self, key: usize, input: &ErardInput) -> ErardStatus {
        self.take(key, input, |keys, checked| keys.drive(key, checked))
    }

    /// Imposes the motion of a key's front, from 1, in the next step.
    #[cfg(all(feature = "workshop", not(target_family = "wasm")))]
    pub(crate) fn impose(&mut self, key: usize, input: &ErardInput) -> ErardStatus {
        self.take(key, input, |keys, _| keys.impose(key, input.position_m, input.velocity_m_per_s))
    }

    /// Stores the input of a key, and passes it on.
    fn take(
        &mut self,
        key: usize,
        input: &ErardInput,
        hand_over: impl FnOnce(&mut Keys, Input) -> Result<(), IndexError>,
    ) -> ErardStatus {
        let Some(place) = key.checked_sub(1).and_then(|index| self.inputs.get_mut(index)) else {
            return ErardStatus::NoSuch;
        };
        match input.checked() {
            Err(status) => status,
            Ok(checked) => {
                *place = *input;
                done(hand_over(&mut self.keys, checked))
            }
        }
    }

    /// Takes one step of all awake keys; `put` receives its impacts.
    pub(crate) fn step(&mut self, put: &mut dyn FnMut(ErardImpact)) -> ErardStatus {
        let tick = self.keys.step();
        for one in self.keys.impacts() {
            let (time_s, speed_m_per_s) = (one.impact.time_s + self.offset_s, one.impact.hammer_speed_m_per_s);
            if let Some(last) = self.impacts.get_mut(one.key - 1) {
                *last = (time_s, speed_m_per_s, last.2.wrapping_add(1));
            }
            put(ErardImpact {
                key: one.key as u32,
                time_s,
                hammer_speed_m_per_s: speed_m_per_s,
                ..ErardImpact::default()
            });
        }
        if tick.non_finite > 0 {
            ErardStatus::NotFinite
        } else if tick.unconverged > 0 {
            ErardStatus::IterationLimit
        } else {
            ErardStatus::Ok
        }
    }

    /// Reading of a key, from 1; `None` if there is no such key.
    pub(crate) fn reading(&self, key: usize) -> Option<ErardReading> {
        let &(impact_time_s, hammer_speed_m_per_s, impact_count) = self.impacts.get(key.checked_sub(1)?)?;
        let now = self.keys.reading(key).ok()?;
        Some(ErardReading {
            time_s: self.keys.time_s() + self.offset_s,
            key_m: now.key_m,
            key_m_per_s: now.key_m_per_s,
            finger_force_n: now.finger_force_n,
            finger_force_mean_n: now.finger_force_n,
            hammer_rise_m: now.hammer_rise_m,
            hammer_rise_m_per_s: now.hammer_rise_m_per_s,
            string_n: now.string_n,
            hand_m: now.hand_m,
            hand_m_per_s: now.hand_m_per_s,
            impact_time_s,
            hammer_speed_m_per_s,
            impact_count,
            new_impact_count: 0,
            ..ErardReading::default()
        })
    }

    /// Force of a key's strings on the bridge, N; 0 without sounding strings.
    pub(crate) fn bridge_n(&self, key: usize) -> f64 {
        self.keys.strings(key).ok().flatten().map_or(0.0, Strings::bridge_n)
    }
}

/// Frees a keyboard. NULL does nothing. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_free(keyboard: *mut ErardKeyboard) {
    if !keyboard.is_null() {
        quick(|| {
            // SAFETY: `keyboard` is not NULL, comes from erard_keyboard_new or erard_keyboard_builtin, has not been
            // freed, and is not used again.
            drop(unsafe { Box::from_raw(keyboard) });
            ErardStatus::Ok
        });
    }
}

/// Returns the number of keys; 0 for NULL. Keys count from 1, the lowest A. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_key_count(keyboard: *const ErardKeyboard) -> u32 {
    // SAFETY: `keyboard` is NULL, or comes from erard_keyboard_new or erard_keyboard_builtin, has not been freed, and
    // no other call changes it meanwhile.
    unsafe { keyboard.as_ref() }.map_or(0, |keyboard| keyboard.keys.count() as u32)
}

/// Returns the number of keys that are awake, which are those that take computing time; 0 for NULL. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_awake_count(keyboard: *const ErardKeyboard) -> u32 {
    // SAFETY: `keyboard` is NULL, or comes from erard_keyboard_new or erard_keyboard_builtin, has not been freed, and
    // no other call changes it meanwhile.
    unsafe { keyboard.as_ref() }.map_or(0, |keyboard| keyboard.keys.awake() as u32)
}

/// Sets the input of a key from the next step on; `key` counts from 1. The position of ERARD_INPUT_MOTION stays
/// constant, whatever its velocity: set the input again whenever the position changes. Returns ERARD_STATUS_NO_SUCH if
/// there is no such key. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_drive(
    keyboard: *mut ErardKeyboard,
    key: u32,
    input: *const ErardInput,
) -> ErardStatus {
    // SAFETY: `keyboard` is NULL, or a keyboard that is not freed and in no other call; `input` is NULL, or an
    // initialised ErardInput.
    let (keyboard, input) = match unsafe { (keyboard.as_mut(), given(input)) } {
        (Some(keyboard), Ok(input)) => (keyboard, input),
        (Some(_), Err(status)) => return status,
        _ => return ErardStatus::Null,
    };
    quick(|| keyboard.drive(key as usize, &input))
}

/// Places the hand (ERARD_INPUT_HAND) on a key, as erard_action_place_hand does; `key` counts from 1. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_place_hand(
    keyboard: *mut ErardKeyboard,
    key: u32,
    position_m: f64,
    velocity_m_per_s: f64,
) -> ErardStatus {
    // SAFETY: `keyboard` is NULL, or comes from erard_keyboard_new or erard_keyboard_builtin, has not been freed, and
    // no other call uses it meanwhile.
    let Some(keyboard) = (unsafe { keyboard.as_mut() }) else { return ErardStatus::Null };
    if key == 0 || key as usize > keyboard.inputs.len() {
        return ErardStatus::NoSuch;
    }
    let [position_m, velocity_m_per_s] = match moving(position_m, velocity_m_per_s) {
        Ok(place) => place,
        Err(status) => return status,
    };
    quick(|| done(keyboard.keys.place_hand(key as usize, position_m, velocity_m_per_s)))
}

/// Sets the target lift of the sustain pedal's rail, m, under all keys that have one, as erard_action_set_pedal does.
/// Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_set_pedal(keyboard: *mut ErardKeyboard, lift_m: f64) -> ErardStatus {
    // SAFETY: `keyboard` is NULL, or comes from erard_keyboard_new or erard_keyboard_builtin, has not been freed, and
    // no other call uses it meanwhile.
    let Some(keyboard) = (unsafe { keyboard.as_mut() }) else { return ErardStatus::Null };
    if !lift_m.is_finite() {
        return ErardStatus::NotFinite;
    }
    quick(|| {
        keyboard.keys.set_pedal(lift_m);
        ErardStatus::Ok
    })
}

/// Writes the present force of a key's strings on the bridge, N, to `force_n`, as erard_action_bridge_force does; `key`
/// counts from 1. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_bridge_force(
    keyboard: *const ErardKeyboard,
    key: u32,
    force_n: *mut f64,
) -> ErardStatus {
    // SAFETY: `keyboard` is NULL, or a keyboard that is not freed and that no call changes; `force_n` is NULL, or
    // writable memory for a number.
    let (Some(keyboard), Some(force_n)) = (unsafe { keyboard.as_ref() }, unsafe { force_n.as_mut() }) else {
        return ErardStatus::Null;
    };
    if key == 0 || key as usize > keyboard.inputs.len() {
        return ErardStatus::NoSuch;
    }
    quick(|| {
        *force_n = keyboard.bridge_n(key as usize);
        ErardStatus::Ok
    })
}

/// Writes the present force of all keys' strings on the bridge, N, to `force_n`, including the load of the dampers at
/// rest; 0 without modal strings. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_total_bridge_force(
    keyboard: *const ErardKeyboard,
    force_n: *mut f64,
) -> ErardStatus {
    // SAFETY: `keyboard` is NULL, or a keyboard that is not freed and that no call changes; `force_n` is NULL, or
    // writable memory for a number.
    let (Some(keyboard), Some(force_n)) = (unsafe { keyboard.as_ref() }, unsafe { force_n.as_mut() }) else {
        return ErardStatus::Null;
    };
    quick(|| {
        *force_n = keyboard.keys.bridge_n();
        ErardStatus::Ok
    })
}

/// Writes what is heard of all keys after the last step to `pressure_pa[2]`, as erard_action_pressure does; they share
/// one key bed. Call it once after every step: each call ends a sample. Returns ERARD_STATUS_NO_SUCH where strings move
/// no soundboard. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_pressure(keyboard: *mut ErardKeyboard, pressure_pa: *mut f64) -> ErardStatus {
    // SAFETY: `keyboard` is NULL, or a keyboard that is not freed and in no other call; `pressure_pa` is NULL, or
    // writable memory for two numbers.
    let (Some(keyboard), Some(pressure_pa)) =
        (unsafe { keyboard.as_mut() }, unsafe { pressure_pa.cast::<[f64; 2]>().as_mut() })
    else {
        return ErardStatus::Null;
    };
    let Some(bed) = &mut keyboard.bed else { return ErardStatus::NoSuch };
    quick(|| {
        let [strings, bed] = [keyboard.keys.pressure_pa(), bed.hear(keyboard.keys.knocks_n())];
        *pressure_pa = [strings[0] + bed[0], strings[1] + bed[1]];
        ErardStatus::Ok
    })
}

/// Takes `steps` steps (1 to ERARD_MAX_STEPS) of all keys that are awake. Writes the impacts in the order of the steps
/// to `impacts`, at most `capacity` of them. `count` (which may be NULL) receives the number of impacts; those beyond
/// `capacity` are lost. If a key's numbers become infinite, that key stays as it was, the other keys continue, and the
/// call returns ERARD_STATUS_NOT_FINITE. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_step(
    keyboard: *mut ErardKeyboard,
    steps: u32,
    impacts: *mut ErardImpact,
    capacity: usize,
    count: *mut usize,
) -> ErardStatus {
    // SAFETY: `keyboard` is NULL, or comes from erard_keyboard_new or erard_keyboard_builtin, has not been freed, and
    // no other call uses it meanwhile.
    let Some(keyboard) = (unsafe { keyboard.as_mut() }) else { return ErardStatus::Null };
    if steps == 0 || steps > ERARD_MAX_STEPS {
        return ErardStatus::Range;
    }
    let place = if capacity == 0 {
        None
    } else {
        // SAFETY: `impacts` is NULL, or aligned and writable memory for `capacity` impacts, at least one, that begins
        // with their size.
        match unsafe { Place::new(impacts) } {
            Ok(Some(place)) => Some(place),
            Ok(None) => return ErardStatus::Null,
            Err(status) => return status,
        }
    };
    quick(|| {
        let (mut total, mut status) = (0_usize, ErardStatus::Ok);
        for _ in 0..steps {
            let one = keyboard.step(&mut |impact| {
                if let Some(place) = place.as_ref().filter(|_| total < capacity) {
                    // SAFETY: `place` has room for `capacity` impacts of the stated size, more than `total`.
                    unsafe { place.write(total, &impact) };
                }
                total += 1;
            });
            match one {
                ErardStatus::Ok => {}
                ErardStatus::IterationLimit if status != ErardStatus::Ok => {}
                worse => status = worse,
            }
        }
        // SAFETY: `count` is NULL, or aligned and writable memory for one size that nothing else uses during the call.
        if let Some(count) = unsafe { count.as_mut() } {
            *count = total;
        }
        status
    })
}

/// Writes the reading of a key after the last step to `reading`; `key` counts from 1. finger_force_mean_n is the force
/// of the last step; new_impact_count is 0. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_read(
    keyboard: *const ErardKeyboard,
    key: u32,
    reading: *mut ErardReading,
) -> ErardStatus {
    // SAFETY: `keyboard` is NULL, or a keyboard that is not freed and that no call changes; `reading` is NULL, or
    // writable memory for an ErardReading.
    let (keyboard, place) = match unsafe { (keyboard.as_ref(), Place::new(reading)) } {
        (Some(keyboard), Ok(Some(place))) => (keyboard, place),
        (Some(_), Err(status)) => return status,
        _ => return ErardStatus::Null,
    };
    quick(|| match keyboard.reading(key as usize) {
        Some(now) => {
            // SAFETY: `place` is the caller's memory for one ErardReading that nothing else uses during the call.
            unsafe { place.write(0, &now) };
            ErardStatus::Ok
        }
        None => ErardStatus::NoSuch,
    })
}

/// Writes the absolute angles of a key's bodies, rad, to `angles_rad`, in the order of the bodies in its instrument, as
/// erard_action_angles does for one action. `key` counts from 1; `count` is the room in `angles_rad`. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_angles(
    keyboard: *const ErardKeyboard,
    key: u32,
    angles_rad: *mut f64,
    count: usize,
) -> ErardStatus {
    // SAFETY: `keyboard` is NULL, or comes from erard_keyboard_new or erard_keyboard_builtin, has not been freed, and
    // no other call changes it meanwhile.
    let (Some(keyboard), false) = (unsafe { keyboard.as_ref() }, angles_rad.is_null()) else {
        return ErardStatus::Null;
    };
    quick(|| {
        let Ok(angles) = keyboard.keys.angles(key as usize) else { return ErardStatus::NoSuch };
        if count < angles.len() {
            return ErardStatus::Size;
        }
        // SAFETY: `angles_rad` is not NULL; it is aligned and has room for `count` numbers, no fewer than `angles`, as
        // checked above.
        unsafe { core::slice::from_raw_parts_mut(angles_rad, angles.len()) }.copy_from_slice(angles);
        ErardStatus::Ok
    })
}

/// Writes the keyboard's complete state, including inputs and time, to `bytes`, as erard_action_save does (about 220
/// kB). Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_save(
    keyboard: *const ErardKeyboard,
    bytes: *mut u8,
    size: *mut usize,
) -> ErardStatus {
    // SAFETY: `keyboard` is NULL, or a keyboard that is not freed and that no call changes; `size` is NULL, or a
    // writable, initialised size.
    let (Some(keyboard), Some(size)) = (unsafe { keyboard.as_ref() }, unsafe { size.as_mut() }) else {
        return ErardStatus::Null;
    };
    let needed = keyboard.save(&mut []);
    let room = core::mem::replace(size, needed);
    if bytes.is_null() {
        return ErardStatus::Ok;
    }
    if room < needed {
        return ErardStatus::Size;
    }
    // SAFETY: `bytes` is not NULL and, as `size` said, has room for at least `needed` bytes, which nothing else uses
    // during the call.
    let bytes = unsafe { core::slice::from_raw_parts_mut(bytes, needed) };
    quick(|| {
        keyboard.save(bytes);
        ErardStatus::Ok
    })
}

impl ErardKeyboard {
    /// Writes the complete state. Returns its number of bytes.
    fn save(&self, bytes: &mut [u8]) -> usize {
        let mut out = Writer::new(bytes, MARK);
        self.write(&mut out);
        out.seal()
    }

    /// Writes step length, time, and a group for each key.
    pub(crate) fn write(&self, out: &mut Writer<'_>) {
        let keys = &self.keys;
        out.number("step_s", keys.settings().step);
        out.number("time_s", keys.time_s() + self.offset_s);
        let each = self.inputs.iter().zip(&self.impacts).enumerate();
        for (index, (input, (time_s, speed_m_per_s, impact_count))) in each {
            out.group("key", |out| {
                // There are as many inputs as keys.
                if let Ok(state) = keys.mechanism_state(index + 1) {
                    state.write(out);
                }
                let _ = keys.save_strings(index + 1, &mut |name, numbers| out.list(name, numbers));
                out.number("input_kind", f64::from(input.kind));
                out.number("input_force_N", input.force_n);
                out.number("input_position_m", input.position_m);
                out.number("input_velocity_m_per_s", input.velocity_m_per_s);
                out.number("input_hand_mass_kg", input.hand_mass_kg);
                out.number("input_muscle_N_per_m", input.muscle_n_per_m);
                out.number("input_muscle_N_s_per_m", input.muscle_n_s_per_m);
                out.number("input_joints_m_per_N", input.joints_m_per_n);
                out.number("input_joints_s", input.joints_s);
                out.number("impact_time_s", *time_s);
                out.number("hammer_speed_m_per_s", *speed_m_per_s);
                out.number("impact_count", f64::from(*impact_count));
            });
        }
    }
}

/// Restores a saved state of the same keyboard with the same step length. Every key then continues with the same bits;
/// times agree to rounding. An error leaves the keyboard as it was. Forces read 0 until the next step. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_keyboard_restore(
    keyboard: *mut ErardKeyboard,
    bytes: *const u8,
    size: usize,
) -> ErardStatus {
    // SAFETY: `keyboard` is NULL, or comes from erard_keyboard_new or erard_keyboard_builtin, has not been freed, and
    // no other call uses it meanwhile.
    let (Some(keyboard), false) = (unsafe { keyboard.as_mut() }, bytes.is_null()) else { return ErardStatus::Null };
    if size > isize::MAX as usize {
        return ErardStatus::Saved;
    }
    // SAFETY: `bytes` is not NULL and begins `size` readable bytes, no more than an isize counts, that do not change
    // during the call.
    let bytes = unsafe { core::slice::from_raw_parts(bytes, size) };
    quick(|| Lists::read(bytes, MARK).map_or(ErardStatus::Saved, |lists| restore(keyboard, &lists)))
}

/// Restores the state from these lists.
pub(crate) fn restore(keyboard: &mut ErardKeyboard, lists: &Lists<'_>) -> ErardStatus {
    let step_s = keyboard.keys.settings().step;
    let other = lists.number("step_s").is_some_and(|saved_s| saved_s != step_s);
    if lists.groups("key").count() != keyboard.keys.count() || other {
        return ErardStatus::Foreign;
    }
    let time_s = lists.number("time_s").unwrap_or(0.0);
    if !time_s.is_finite() {
        return ErardStatus::Saved;
    }
    // The first pass only reads, the second changes.
    for write in [false, true] {
        for (index, key) in lists.groups("key").enumerate() {
            let number = |name| key.number(name).unwrap_or(0.0);
            let input = ErardInput {
                kind: number("input_kind") as u32,
                force_n: number("input_force_N"),
                position_m: number("input_position_m"),
                velocity_m_per_s: number("input_velocity_m_per_s"),
                hand_mass_kg: number("input_hand_mass_kg"),
                muscle_n_per_m: number("input_muscle_N_per_m"),
                muscle_n_s_per_m: number("input_muscle_N_s_per_m"),
                joints_m_per_n: number("input_joints_m_per_N"),
                joints_s: number("input_joints_s"),
                ..ErardInput::default()
            };
            let Ok(checked) = input.checked() else { return ErardStatus::Saved };
            let (state, strings) =
                (MechanismState::read(&key), |name: &str, number: &mut TellNumbers<'_>| key.each(name, number));
            let restored = if write {
                // Before the state, which contains the place of an imposed motion.
                let driven = keyboard.keys.drive(index + 1, checked).map_err(SnapshotError::from);
                driven.and_then(|()| keyboard.keys.restore_from(index + 1, &state, &strings))
            } else {
                keyboard.keys.restorable(index + 1, &state, &strings)
            };
            if let Err(error) = restored {
                return status_of(error);
            }
            if write {
                let impact = (number("impact_time_s"), number("hammer_speed_m_per_s"), number("impact_count") as u32);
                let places = keyboard.inputs.get_mut(index).zip(keyboard.impacts.get_mut(index));
                if let Some((last_input, last_impact)) = places {
                    (*last_input, *last_impact) = (input, impact);
                }
            }
        }
    }
    keyboard.offset_s = time_s - keyboard.keys.time_s();
    ErardStatus::Ok
}

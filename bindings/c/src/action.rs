//! One action: made, stepped, read, saved.

use std::ffi::{CString, c_char};
use std::ptr::null_mut;

use erard::knocks::{KeyBed, Knock, Knocks};
use erard::player::Fingertip;
use erard::run::Heard;
use erard::strings::{ShapeProbe, Strings};
use erard::{Action, Input, Instrument};

use crate::caller_struct::{Place, given};
use crate::instrument::{ErardInstrument, parse};
use crate::play::{Play, settings};
use crate::reading::{
    ERARD_MAX_FORCE_N, ERARD_MAX_POSITION_M, ERARD_MAX_SPEED_M_PER_S, ErardInput, ErardReading, within,
};
use crate::status::{ErardStatus, Fault, quick, told};

/// One action under the caller's control. It belongs to the caller until erard_action_free. Any thread may use it, one
/// at a time.
pub struct ErardAction {
    pub(crate) play: Play,
    bodies: Vec<CString>,
    zones: Vec<CString>,
    /// Sampling positions of a modal string, m from the striking point, and the probe of its shape there.
    string: Option<(Vec<f64>, ShapeProbe)>,
    /// What knocks on the key bed, and the bed; where a soundboard is heard.
    ear: Option<(Knocks, KeyBed)>,
}

impl ErardAction {
    pub(crate) fn new(instrument: &Instrument, step_s: f64) -> Result<Self, Fault> {
        let action = Action::with(instrument, settings(step_s)).map_err(|error| {
            let status =
                if matches!(error, erard::ActionError::Step { .. }) { ErardStatus::Range } else { ErardStatus::Model };
            Fault::new(status, error.to_string())
        })?;
        let string = action.strings().map(|strings| (strings.probe_places_m(), strings.shape_probe()));
        let name = |name: &String| CString::new(name.as_str()).unwrap_or_default();
        let is_heard = Heard::of(std::slice::from_ref(instrument)) == Heard::Pressure;
        Ok(ErardAction {
            ear: is_heard.then(|| (Knocks::of(instrument, &Knock::ALL), KeyBed::new(1.0 / step_s))),
            play: Play::new(action, instrument.zones.len()),
            bodies: instrument.bodies.iter().map(|body| name(&body.name)).collect(),
            zones: instrument.zones.iter().map(|zone| name(&zone.name)).collect(),
            string,
        })
    }

    /// The action is somewhere else now, which is not heard.
    fn forget_knocks(&mut self) {
        if let Some((_, bed)) = &mut self.ear {
            bed.forget();
        }
    }
}

/// Makes an action at rest, with nothing touching its key, from the text of an instrument file (UTF-8, `length` bytes;
/// no terminating zero is needed). NULL and 0 give the built-in concert grand. `step_s` is the step length, s, 1e-8 to
/// 1e-3: usually 50e-6, or 1/24000 with modal strings, near which steps are halved as often as needed. Returns NULL on
/// failure: `status` (which may be NULL) receives the reason, and erard_last_error describes it. Real time: no (it
/// reads, allocates, and simulates until the action rests).
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_new(
    text: *const c_char,
    length: usize,
    step_s: f64,
    status: *mut ErardStatus,
) -> *mut ErardAction {
    told(null_mut(), status, || {
        // SAFETY: `text` is NULL, or `length` readable bytes that do not change during the call.
        let (file, _) = unsafe { parse(text, length) }?;
        Ok(Box::into_raw(Box::new(ErardAction::new(&file.instrument, step_s)?)))
    })
}

/// Makes an action at rest from an instrument, which may be freed afterwards. `step_s` and failures are as for
/// erard_action_new. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_of_instrument(
    instrument: *const ErardInstrument,
    step_s: f64,
    status: *mut ErardStatus,
) -> *mut ErardAction {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no call changes it
        // meanwhile.
        let instrument = unsafe { instrument.as_ref() }.ok_or_else(|| Fault::null("the instrument"))?;
        Ok(Box::into_raw(Box::new(ErardAction::new(instrument.instrument(), step_s)?)))
    })
}

/// Frees an action. NULL does nothing. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_free(action: *mut ErardAction) {
    if !action.is_null() {
        // SAFETY: `action` is not NULL, comes from erard_action_new or erard_action_of_instrument, has not been freed,
        // and is not used again.
        quick(|| {
            drop(unsafe { Box::from_raw(action) });
            ErardStatus::Ok
        });
    }
}

/// Takes one step under a checked input; returns its error otherwise.
#[inline(always)]
unsafe fn step(action: *mut ErardAction, input: Result<Input, ErardStatus>, reading: *mut ErardReading) -> ErardStatus {
    // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed, and
    // no other call uses it meanwhile.
    let Some(action) = (unsafe { action.as_mut() }) else { return ErardStatus::Null };
    // SAFETY: `reading` is NULL, or aligned and writable memory for an ErardReading that begins with its size, by the
    // contract of this function.
    let place = match unsafe { Place::new(reading) } {
        Ok(place) => place,
        Err(status) => return status,
    };
    quick(|| {
        let status = input.map_or_else(|status| status, |input| action.play.step(input));
        if let Some(place) = place {
            // SAFETY: `place` is the caller's memory for one ErardReading that nothing else uses during the call.
            unsafe { place.write(0, &action.play.reading) };
        }
        status
    })
}

/// Limits of a fingertip of the caller's own, N/m and N s/m: below them steps of 50 us are stable on a key
/// ([`Fingertip`]).
const MAX_TIP_N_PER_M: f64 = 1e6;
const MAX_TIP_N_S_PER_M: f64 = 1e3;

fn positive_within(number: f64, limit: f64) -> Result<f64, ErardStatus> {
    within(number, limit).and_then(|number| if number < 0.0 { Err(ErardStatus::Range) } else { Ok(number) })
}

/// Checks a position and a velocity against the action's limits.
#[inline(always)]
pub(crate) fn moving(position_m: f64, velocity_m_per_s: f64) -> Result<[f64; 2], ErardStatus> {
    Ok([within(position_m, ERARD_MAX_POSITION_M)?, within(velocity_m_per_s, ERARD_MAX_SPEED_M_PER_S)?])
}

/// Takes one step under a force on the key front, N, down positive (admittance: force in, position out). `reading` may
/// be NULL. An error leaves the action as it was. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_step_force(
    action: *mut ErardAction,
    force_n: f64,
    reading: *mut ErardReading,
) -> ErardStatus {
    // SAFETY: `action` is NULL, or an action that is not freed and in no other call; `reading` is NULL, or writable
    // memory for an ErardReading.
    unsafe { step(action, within(force_n, ERARD_MAX_FORCE_N).map(Input::Force), reading) }
}

/// Takes one step under a device that is `position_m` below the key's rest and moves at `velocity_m_per_s`, down
/// positive, both in the middle of the step (impedance: position in, force out, as finger_force_n of the reading). The
/// fingertip of the instrument's file couples device and key: a spring and a damper that only push (virtual coupling).
/// `reading` may be NULL. An error leaves the action as it was. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_step_motion(
    action: *mut ErardAction,
    position_m: f64,
    velocity_m_per_s: f64,
    reading: *mut ErardReading,
) -> ErardStatus {
    let input = moving(position_m, velocity_m_per_s);
    // SAFETY: `action` is NULL, or an action that is not freed and in no other call; `reading` is NULL, or writable
    // memory for an ErardReading.
    unsafe {
        step(
            action,
            input.map(|[position_m, velocity_m_per_s]| Input::Motion { position_m, velocity_m_per_s }),
            reading,
        )
    }
}

/// Takes one step under a pointer of the caller's that is `position_m` below the key's rest and moves at
/// `velocity_m_per_s`, down positive, behind a fingertip of the caller's own, `stiffness_n_per_m` (0 to 1e6) and
/// `damping_n_s_per_m` (0 to 1e3), which only pushes. Its force is that of the key's last reading, held over the step,
/// so that the instrument stays as its file has it: the fingertip of a mouse or a story may be softer than the file's.
/// For a device with forces of its own erard_action_step_motion is better, whose coupling the step solves for.
/// `reading` may be NULL. An error leaves the action as it was. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_step_fingertip(
    action: *mut ErardAction,
    position_m: f64,
    velocity_m_per_s: f64,
    stiffness_n_per_m: f64,
    damping_n_s_per_m: f64,
    reading: *mut ErardReading,
) -> ErardStatus {
    // SAFETY: `action` is NULL, or an action that is not freed and that no other call changes.
    let Some(now) = (unsafe { action.as_ref() }).map(|action| action.play.reading) else { return ErardStatus::Null };
    let input = moving(position_m, velocity_m_per_s).and_then(|pointer| {
        let fingertip = Fingertip {
            stiffness_n_per_m: positive_within(stiffness_n_per_m, MAX_TIP_N_PER_M)?,
            damping_n_s_per_m: positive_within(damping_n_s_per_m, MAX_TIP_N_S_PER_M)?,
        };
        within(fingertip.force_n(pointer, [now.key_m, now.key_m_per_s]), ERARD_MAX_FORCE_N).map(Input::Force)
    });
    // SAFETY: `action` is NULL, or an action that is not freed and in no other call; `reading` is NULL, or writable
    // memory for an ErardReading.
    unsafe { step(action, input, reading) }
}

/// Takes one step with prescribed motion of the key front: its position, m below rest, and velocity, m/s, down
/// positive, at the end of the step. Use it for measured strokes, not in a loop with a device (README, "Closed loop").
/// `reading` may be NULL. An error leaves the action as it was. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_step_rigid(
    action: *mut ErardAction,
    position_m: f64,
    velocity_m_per_s: f64,
    reading: *mut ErardReading,
) -> ErardStatus {
    let input = moving(position_m, velocity_m_per_s);
    // SAFETY: `action` is NULL, or an action that is not freed and in no other call; `reading` is NULL, or writable
    // memory for an ErardReading.
    unsafe {
        step(action, input.map(|[position_m, velocity_m_per_s]| Input::Rigid { position_m, velocity_m_per_s }), reading)
    }
}

/// Takes one step with nothing touching the key. `reading` may be NULL. An error leaves the action as it was. Real
/// time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_step_free(action: *mut ErardAction, reading: *mut ErardReading) -> ErardStatus {
    // SAFETY: `action` is NULL, or an action that is not freed and in no other call; `reading` is NULL, or writable
    // memory for an ErardReading.
    unsafe { step(action, Ok(Input::Free), reading) }
}

/// Takes one step under an input of any kind, including a hand. `reading` may be NULL. An error leaves the action as it
/// was. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_step_input(
    action: *mut ErardAction,
    input: *const ErardInput,
    reading: *mut ErardReading,
) -> ErardStatus {
    // SAFETY: `input` is NULL, or an aligned, initialised ErardInput that does not change during the call.
    let input = match unsafe { given(input) } {
        Ok(input) => input,
        Err(status) => return status,
    };
    // SAFETY: `action` is NULL, or an action that is not freed and in no other call; `reading` is NULL, or writable
    // memory for an ErardReading.
    unsafe { step(action, input.checked(), reading) }
}

/// Places the hand (ERARD_INPUT_HAND): `position_m` is m below the key front's rest, `velocity_m_per_s` m/s, down
/// positive. In a new action the hand is at the key front's rest. Only steps with ERARD_INPUT_HAND move it. Real time:
/// yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_place_hand(
    action: *mut ErardAction,
    position_m: f64,
    velocity_m_per_s: f64,
) -> ErardStatus {
    // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed, and
    // no other call uses it meanwhile.
    let Some(action) = (unsafe { action.as_mut() }) else { return ErardStatus::Null };
    let [position_m, velocity_m_per_s] = match moving(position_m, velocity_m_per_s) {
        Ok(place) => place,
        Err(status) => return status,
    };
    quick(|| {
        action.play.place_hand(position_m, velocity_m_per_s);
        ErardStatus::Ok
    })
}

/// Takes as many steps as fit into `dt_s` (s, 0 to ERARD_MAX_ADVANCE_S), for a device that is slower than the steps.
/// The remaining time is added to the next call, so periods of any length do not drift. The input is that at the
/// beginning of `dt_s`: a force is held, a position continues at its velocity. Render finger_force_mean_n of the
/// reading: held over `dt_s`, it has the same impulse as the steps. If a step fails, the action is left as it was
/// before the call. Real time: yes; the call takes as long as its steps.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_advance(
    action: *mut ErardAction,
    dt_s: f64,
    input: *const ErardInput,
    reading: *mut ErardReading,
) -> ErardStatus {
    // SAFETY: `action` is NULL, or an action that is not freed and in no other call.
    let Some(action) = (unsafe { action.as_mut() }) else { return ErardStatus::Null };
    // SAFETY: `input` is NULL, or an initialised ErardInput that does not change during the call; `reading` is NULL, or
    // writable memory for an ErardReading that begins with its size.
    let (input, place) = match unsafe { (given(input), Place::new(reading)) } {
        (Ok(input), Ok(place)) => (input, place),
        (Err(status), _) | (_, Err(status)) => return status,
    };
    quick(|| {
        let status = action.play.advance(dt_s, &input);
        if let Some(place) = place {
            // SAFETY: `place` is the caller's memory for one ErardReading that nothing else uses during the call.
            unsafe { place.write(0, &action.play.reading) };
        }
        status
    })
}

/// Writes the present reading of the action to `reading`; after a step, it is the reading that the step wrote. Real
/// time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_read(action: *const ErardAction, reading: *mut ErardReading) -> ErardStatus {
    // SAFETY: `action` is NULL, or an action that is not freed and that no call changes; `reading` is NULL, or writable
    // memory for an ErardReading.
    let (action, place) = match unsafe { (action.as_ref(), Place::new(reading)) } {
        (Some(action), Ok(Some(place))) => (action, place),
        (Some(_), Err(status)) => return status,
        _ => return ErardStatus::Null,
    };
    // SAFETY: `place` is the caller's memory for one ErardReading that nothing else uses during the call.
    unsafe { place.write(0, &action.play.reading) };
    ErardStatus::Ok
}

/// Returns the action to its state when it was made: at rest, at 0 s, with no impact counted. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_reset(action: *mut ErardAction) -> ErardStatus {
    // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed, and
    // no other call uses it meanwhile.
    let Some(action) = (unsafe { action.as_mut() }) else { return ErardStatus::Null };
    quick(|| {
        action.forget_knocks();
        action.play.reset()
    })
}

/// Writes the action's complete state to `bytes`. A restored action continues with the same bits. `size` holds the room
/// in `bytes` and receives the number of bytes needed: about 2.8 kB, and 16 bytes more for each mode of modal strings.
/// Actions with rigid strings all need the same size. If the room is too small, nothing is written and the call returns
/// ERARD_STATUS_SIZE. If `bytes` is NULL, only the size is reported. The state is a set of named lists of numbers: an
/// earlier library skips the lists that a later one adds, and a later one does without those that an earlier one lacks.
/// The bytes are the same on every machine. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_save(
    action: *const ErardAction,
    bytes: *mut u8,
    size: *mut usize,
) -> ErardStatus {
    // SAFETY: `action` is NULL, or an action that is not freed and that no call changes; `size` is NULL, or a writable,
    // initialised size.
    let (Some(action), Some(size)) = (unsafe { action.as_ref() }, unsafe { size.as_mut() }) else {
        return ErardStatus::Null;
    };
    let needed = action.play.saved_bytes();
    let room = core::mem::replace(size, needed);
    if bytes.is_null() {
        return ErardStatus::Ok;
    }
    if room < needed {
        return ErardStatus::Size;
    }
    quick(|| {
        // SAFETY: `bytes` is not NULL and, as `size` said, has room for at least `needed` bytes, which nothing else
        // uses during the call.
        action.play.save(unsafe { core::slice::from_raw_parts_mut(bytes, needed) });
        ErardStatus::Ok
    })
}

/// Sets the target lift of the sustain pedal's rail, m, 0 to 0.010; values outside are clamped. The rail moves there at
/// no more than 0.5 m/s. Without modal strings or without a rail, the call does nothing. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_set_pedal(action: *mut ErardAction, lift_m: f64) -> ErardStatus {
    // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed, and
    // no other call uses it meanwhile.
    let Some(action) = (unsafe { action.as_mut() }) else { return ErardStatus::Null };
    if !lift_m.is_finite() {
        return ErardStatus::NotFinite;
    }
    quick(|| {
        action.play.action.set_pedal(lift_m);
        ErardStatus::Ok
    })
}

/// Writes the present force of the strings on the bridge, N, to `force_n`, positive in the direction in which the
/// hammer pushes the strings; 0 without modal strings. `erard press --wav` writes this force less its value at rest as
/// sound. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_bridge_force(action: *const ErardAction, force_n: *mut f64) -> ErardStatus {
    // SAFETY: `action` is NULL, or an action that is not freed and that no call changes; `force_n` is NULL, or writable
    // memory for a number.
    let (Some(action), Some(force_n)) = (unsafe { action.as_ref() }, unsafe { force_n.as_mut() }) else {
        return ErardStatus::Null;
    };
    quick(|| {
        *force_n = action.play.action.strings().map_or(0.0, Strings::bridge_n);
        ErardStatus::Ok
    })
}

/// Writes what is heard of an action after its last step to `pressure_pa[2]`: the sound pressure at two places 1 m
/// before the soundboard and half a metre apart, Pa; of the strings, and of the knocks of key, rails and damper on the
/// key bed. An estimate, without a room; `erard press --wav` writes it. Call it once after every step: each call ends a
/// sample. Returns ERARD_STATUS_NO_SUCH where strings move no soundboard. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_pressure(action: *mut ErardAction, pressure_pa: *mut f64) -> ErardStatus {
    // SAFETY: `action` is NULL, or an action that is not freed and in no other call; `pressure_pa` is NULL, or writable
    // memory for two numbers.
    let (Some(action), Some(pressure_pa)) =
        (unsafe { action.as_mut() }, unsafe { pressure_pa.cast::<[f64; 2]>().as_mut() })
    else {
        return ErardStatus::Null;
    };
    let (Some((knocks, bed)), Some(strings)) = (&mut action.ear, action.play.action.strings()) else {
        return ErardStatus::NoSuch;
    };
    quick(|| {
        let mechanism = action.play.action.mechanism();
        let [strings, bed] =
            [strings.pressure_pa().unwrap_or_default(), bed.hear(knocks.force_n(|zone| mechanism.normal_force(zone)))];
        *pressure_pa = [strings[0] + bed[0], strings[1] + bed[1]];
        ErardStatus::Ok
    })
}

/// Writes the positions at which erard_action_string_shape samples the middle string to `places_m` (which may be NULL),
/// at most `count` of them: m from the striking point, positive away from the string's nearer end. Returns the number
/// of positions; 0 without modal strings and for NULL. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_string_places(
    action: *const ErardAction,
    places_m: *mut f64,
    count: usize,
) -> usize {
    // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed, and
    // no other call changes it meanwhile.
    let Some((places, _)) = (unsafe { action.as_ref() }).and_then(|action| action.string.as_ref()) else { return 0 };
    if !places_m.is_null() {
        let many = count.min(places.len());
        // SAFETY: `places_m` is not NULL; it is aligned and has room for `count` numbers, of which `many` are written.
        unsafe { core::slice::from_raw_parts_mut(places_m, many) }.copy_from_slice(&places[..many]);
    }
    places.len()
}

/// Writes the displacement of the middle string from its rest at each position of erard_action_string_places, m,
/// positive away from the hammer. `count` is the room in `shape_m`, at least the number of positions, else the call
/// returns ERARD_STATUS_SIZE. Without modal strings, the call writes nothing. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_string_shape(
    action: *const ErardAction,
    shape_m: *mut f32,
    count: usize,
) -> ErardStatus {
    // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed, and
    // no other call changes it meanwhile.
    let (Some(action), false) = (unsafe { action.as_ref() }, shape_m.is_null()) else { return ErardStatus::Null };
    let Some((places, seen)) = &action.string else { return ErardStatus::Ok };
    if count < places.len() {
        return ErardStatus::Size;
    }
    // SAFETY: `shape_m` is not NULL; it is aligned and has room for `count` numbers, no fewer than `places`, as checked
    // above.
    let shape = unsafe { core::slice::from_raw_parts_mut(shape_m, places.len()) };
    quick(|| {
        if let Some(strings) = action.play.action.strings() {
            seen.read(strings, shape);
        }
        ErardStatus::Ok
    })
}

/// Restores a saved state. The instrument must have the same numbers (name, notes and order in the file may differ) and
/// the action the same step length. The action then continues with the same bits, and its reading is the saved one. An
/// error (ERARD_STATUS_SAVED, ERARD_STATUS_FOREIGN or ERARD_STATUS_NOT_FINITE) leaves the action as it was. Real time:
/// yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_restore(action: *mut ErardAction, bytes: *const u8, size: usize) -> ErardStatus {
    // SAFETY: `action` is NULL, or an action that is not freed and in no other call; `bytes` is NULL, or `size`
    // readable bytes.
    let (Some(action), false) = (unsafe { action.as_mut() }, bytes.is_null()) else { return ErardStatus::Null };
    if size > isize::MAX as usize {
        return ErardStatus::Saved;
    }
    quick(|| {
        action.forget_knocks();
        action.play.restore(unsafe { core::slice::from_raw_parts(bytes, size) })
    })
}

/// Returns the number of bodies of an action; 0 for NULL. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_body_count(action: *const ErardAction) -> usize {
    // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed, and
    // no other call changes it meanwhile.
    unsafe { action.as_ref() }.map_or(0, |action| action.bodies.len())
}

/// Returns the number of contact zones of an action; 0 for NULL. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_zone_count(action: *const ErardAction) -> usize {
    // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed, and
    // no other call changes it meanwhile.
    unsafe { action.as_ref() }.map_or(0, |action| action.zones.len())
}

/// Returns the name of a body as the instrument file gives it; `body` counts from 0. Returns NULL if there is no such
/// body. The text belongs to the action and is valid as long as the action. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_body_name(action: *const ErardAction, body: usize) -> *const c_char {
    // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed, and
    // no other call changes it meanwhile.
    let action = unsafe { action.as_ref() };
    action.and_then(|action| action.bodies.get(body)).map_or(core::ptr::null(), |name| name.as_ptr())
}

/// Returns the name of a contact zone; `zone` counts from 0. Otherwise as erard_action_body_name. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_zone_name(action: *const ErardAction, zone: usize) -> *const c_char {
    // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed, and
    // no other call changes it meanwhile.
    let action = unsafe { action.as_ref() };
    action.and_then(|action| action.zones.get(zone)).map_or(core::ptr::null(), |name| name.as_ptr())
}

unsafe fn fill(
    action: *const ErardAction,
    out: *mut f64,
    count: usize,
    wanted: impl Fn(&ErardAction) -> usize,
    write: impl Fn(&ErardAction, &mut [f64]),
) -> ErardStatus {
    // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed, and
    // no other call changes it meanwhile.
    let (Some(action), false) = (unsafe { action.as_ref() }, out.is_null()) else { return ErardStatus::Null };
    let wanted = wanted(action);
    if count < wanted {
        return ErardStatus::Size;
    }
    // SAFETY: `out` is not NULL; it is aligned and has room for `count` numbers, no fewer than `wanted`, as checked
    // above.
    let out = unsafe { core::slice::from_raw_parts_mut(out, wanted) };
    quick(|| {
        write(action, out);
        ErardStatus::Ok
    })
}

/// Writes the absolute angles of all bodies, rad, to `angles_rad`: positive counter-clockwise, seen with the player on
/// the left. `count` is the room in `angles_rad`, at least erard_action_body_count, else the call returns
/// ERARD_STATUS_SIZE. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_angles(
    action: *const ErardAction,
    angles_rad: *mut f64,
    count: usize,
) -> ErardStatus {
    let write = |action: &ErardAction, out: &mut [f64]| {
        out.iter_mut().zip(action.play.action.angles()).for_each(|(place, angle)| *place = *angle);
    };
    // SAFETY: `action` is NULL, or an action that is not freed and that no call changes; `angles_rad` is NULL, or
    // aligned room for `count` numbers.
    unsafe { fill(action, angles_rad, count, |action| action.bodies.len(), write) }
}

/// Writes the absolute angular velocities of all bodies, rad/s, to `velocities_rad_per_s`. Sign and `count` are as for
/// erard_action_angles. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_velocities(
    action: *const ErardAction,
    velocities_rad_per_s: *mut f64,
    count: usize,
) -> ErardStatus {
    let write = |action: &ErardAction, out: &mut [f64]| {
        out.iter_mut().zip(action.play.action.velocities()).for_each(|(place, rate)| *place = *rate);
    };
    // SAFETY: `action` is NULL, or an action that is not freed and that no call changes; `velocities_rad_per_s` is
    // NULL, or aligned room for `count` numbers.
    unsafe { fill(action, velocities_rad_per_s, count, |action| action.bodies.len(), write) }
}

/// Writes the normal forces of all contact zones in the last step, N, never negative, to `forces_n`. `count` is the
/// room in `forces_n`, at least erard_action_zone_count, else the call returns ERARD_STATUS_SIZE. After a restore or a
/// reset the forces are 0 until the next step. Real time: yes.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_contact_forces(
    action: *const ErardAction,
    forces_n: *mut f64,
    count: usize,
) -> ErardStatus {
    // SAFETY: `action` is NULL, or an action that is not freed and that no call changes; `forces_n` is NULL, or aligned
    // room for `count` numbers.
    unsafe { fill(action, forces_n, count, |action| action.zones.len(), |action, out| action.play.contacts(out)) }
}

//! Strokes: built in, or recorded; played on an action as by `erard press`.

use std::ffi::c_char;
use std::ptr::null_mut;

use erard::Input;
use erard::level;
use erard::player::Hand;
use erard::recording::{Preparation, prepare};
use erard::run::{Setup, simulate};
use erard::stroke::{Columns, DrivingError, Layout, Recording, Stroke, Touch};
use serde_json::{Value, json};

use crate::action::ErardAction;
use crate::caller_struct::Place;
use crate::instrument::{ErardInstrument, given};
use crate::play::settings;
use crate::reading::{ERARD_MAX_FORCE_N, ERARD_MAX_POSITION_M, ERARD_MAX_SPEED_M_PER_S, ErardReading, within};
use crate::status::{ErardStatus, Fault, ended, tell, told};
use crate::text::{bytes, give, name};

/// A stroke over time, which drives actions of one instrument step by step. It belongs to the caller until
/// erard_stroke_free. One thread at a time may use it.
pub struct ErardStroke {
    drive: Box<dyn Fn(f64) -> Input + Send>,
    hand: Option<Hand>,
    start_s: f64,
    duration_s: f64,
    steps: u64,
    told: String,
}

impl ErardStroke {
    fn new(stroke: Stroke, told: String, instrument: &ErardInstrument) -> Result<Self, Fault> {
        let (start_s, duration_s) = (stroke.start_s, stroke.duration_s);
        let drive = stroke.inputs(&instrument.instrument().finger).map_err(|error| undriven(&error))?;
        Ok(ErardStroke { drive, hand: stroke.hand(), start_s, duration_s, steps: 0, told })
    }
}

fn undriven(error: &DrivingError) -> Fault {
    Fault::new(ErardStatus::File, error.to_string())
}

/// Makes a built-in touch for an instrument: `nuance` is "pp", "p", "mf", "f" or "ff" (hammer speeds at the string of
/// 0.5, 0.79, 1.99, 3.15 and 5 m/s); `struck` is 0 for a pressed touch, 1 for a struck one. A hand of 200 g plays it,
/// with a force that is adjusted to this instrument; another action is played by the same hand with the same force.
/// Returns NULL on failure: ERARD_STATUS_NO_SUCH for an unknown nuance; ERARD_STATUS_ARGUMENT if no such hand reaches
/// the hammer speed, and erard_last_error says which speed it reaches. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_stroke_builtin(
    instrument: *const ErardInstrument,
    nuance: *const c_char,
    struck: u32,
    status: *mut ErardStatus,
) -> *mut ErardStroke {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or one of this library that is not freed and that no call changes; `nuance` is
        // NULL, or a text that ends with a zero.
        let (instrument, nuance) = (unsafe { given(instrument) }?, unsafe { name(nuance, "the stroke's name") }?);
        let touch = if struck == 0 { Touch::Pressed } else { Touch::Struck };
        let speed_m_per_s = level::named(nuance).ok_or_else(|| {
            let known = level::LEVELS.map(|(name, _)| name).join(", ");
            Fault::new(ErardStatus::NoSuch, format!("there is no built-in stroke `{nuance}`; expected one of {known}"))
        })?;
        let kind = level::HandKind::new(touch, level::MASS_KG);
        let found = level::Reference::new(instrument.instrument(), &mut |_| true)
            .and_then(|mut reference| reference.solve(kind, speed_m_per_s, &mut |_| true))
            .map_err(|error| Fault::new(ErardStatus::Argument, error.to_string()))?;
        let stroke = Stroke::by_hand(format!("{nuance}, {}", touch.name()), found.whole(), level::DURATION_S);
        Ok(Box::into_raw(Box::new(ErardStroke::new(stroke, String::new(), instrument)?)))
    })
}

/// Makes a stroke for an instrument from a recording, the text of a CSV file (UTF-8, `length` bytes) with a column for
/// the time and one for force or position. Its force drives the key if there is one, else its position. The recording
/// is prepared as `erard press` does without options: the rest before the touch gives the zero, and each channel is
/// filtered by its own noise; erard_stroke_remarks lists the changes. Returns NULL on failure; erard_last_error says
/// what is wrong, with line and column. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_stroke_new(
    instrument: *const ErardInstrument,
    text: *const c_char,
    length: usize,
    status: *mut ErardStatus,
) -> *mut ErardStroke {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no call changes it
        // meanwhile.
        let instrument = unsafe { given(instrument) }?;
        // SAFETY: `text` is NULL, or `length` readable bytes that do not change during the call.
        let text = unsafe { bytes(text, length) }?.ok_or_else(|| Fault::null("the text"))?;
        let wrong = |error: &dyn std::fmt::Display| Fault::new(ErardStatus::File, error.to_string());
        let recording = Recording::read(text, "recording", &Columns::default()).map_err(|error| wrong(&error))?;
        let prepared = prepare(&recording, &Preparation::default()).map_err(|error| wrong(&error))?;
        let recorded = Stroke::recorded("recording".into(), prepared.series, recording.position_of, None);
        let (stroke, note) = recorded.map_err(|error| undriven(&error))?;
        let lines = prepared.report.told().into_iter().chain(note.map(|note| format!("warning: {note}")));
        let lines: Vec<String> = lines.collect();
        Ok(Box::into_raw(Box::new(ErardStroke::new(stroke, lines.join("\n"), instrument)?)))
    })
}

/// Returns the changes and remarks from preparing a recorded stroke, one in each line; empty for a built-in stroke.
/// Free the text with erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_stroke_remarks(
    stroke: *const ErardStroke,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `stroke` is NULL, or comes from erard_stroke_new or erard_stroke_builtin, has not been freed, and no
        // other call changes it meanwhile.
        let stroke = unsafe { stroke.as_ref() }.ok_or_else(|| Fault::null("the stroke"))?;
        give(stroke.told.clone(), length)
    })
}

/// Finds the columns of a recording by their titles and returns them as JSON: an array of "role" ("time", "force",
/// "position", "hammer"), "index" (from 0) and "title", time first. `titles` is a JSON array of all titles. Use it to
/// pass on columns of tables that are not text as CSV. Returns NULL on failure. Free the text with erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_recording_columns(
    titles: *const c_char,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `titles` is NULL, or a text that ends with a zero and does not change during the call.
        let titles: Vec<String> = serde_json::from_str(unsafe { name(titles, "the titles") }?)
            .map_err(|error| Fault::new(ErardStatus::Argument, format!("the titles are not a JSON array: {error}")))?;
        let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
        let layout = Layout::of(&titles, &Columns::default(), "recording")
            .map_err(|error| Fault::new(ErardStatus::File, error.to_string()))?;
        let columns = layout
            .columns
            .iter()
            .map(|column| json!({ "role": column.role.name(), "index": column.index, "title": column.title }));
        give(Value::Array(columns.collect()).to_string(), length)
    })
}

/// Frees a stroke. NULL does nothing. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_stroke_free(stroke: *mut ErardStroke) {
    // SAFETY: `stroke` is NULL, or comes from erard_stroke_new or erard_stroke_builtin, has not been freed, and is not
    // used again.
    unsafe { ended(stroke) }
}

/// Returns the duration of a stroke, s, including the time in which `erard press` lets the action swing out after it; 0
/// for NULL. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_stroke_duration(stroke: *const ErardStroke) -> f64 {
    // SAFETY: `stroke` is NULL, or comes from erard_stroke_new or erard_stroke_builtin, has not been freed, and no
    // other call changes it meanwhile.
    unsafe { stroke.as_ref() }.map_or(0.0, |stroke| stroke.duration_s)
}

/// Plays a stroke on an instrument from rest in steps of `step_s` (s, as for erard_action_new) and returns the text of
/// the run.csv that `erard press` writes with the same step: titles, then a row for each step. The stroke stays where
/// it is. Returns NULL on failure; erard_last_error says what is wrong. Free the text with erard_text_free. Real time:
/// no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_stroke_run_csv(
    instrument: *const ErardInstrument,
    stroke: *const ErardStroke,
    step_s: f64,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no call changes it
        // meanwhile.
        let instrument = unsafe { given(instrument) }?;
        // SAFETY: `stroke` is NULL, or comes from erard_stroke_new or erard_stroke_builtin, has not been freed, and no
        // other call changes it meanwhile.
        let stroke = unsafe { stroke.as_ref() }.ok_or_else(|| Fault::null("the stroke"))?;
        let setup = Setup {
            settings: settings(step_s),
            start_s: stroke.start_s,
            hand: stroke.hand,
            ..Setup::new(stroke.duration_s)
        };
        let run = simulate(instrument.instrument(), &|t| (stroke.drive)(t), &setup, &mut |_| true)
            .map_err(|error| Fault::new(ErardStatus::Model, error.to_string()))?;
        give(run.csv(), length)
    })
}

/// Sets a stroke back to its beginning. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_stroke_rewind(stroke: *mut ErardStroke) -> ErardStatus {
    tell(|| {
        // SAFETY: `stroke` is NULL, or comes from erard_stroke_new or erard_stroke_builtin, has not been freed, and no
        // other call uses it meanwhile.
        unsafe { stroke.as_mut() }.ok_or_else(|| Fault::null("the stroke"))?.steps = 0;
        Ok(())
    })
}

/// Takes one step of an action under the stroke's next input. From an action at rest, the positions and angles have the
/// same bits as those of `erard press`; the forces are this step's, where a row of `erard press` has the mean of the
/// steps before and after it. `reading` may be NULL. An error leaves action and stroke as they were. Real time: no.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_action_step_stroke(
    action: *mut ErardAction,
    stroke: *mut ErardStroke,
    reading: *mut ErardReading,
) -> ErardStatus {
    let mut ended = ErardStatus::Ok;
    let failed = tell(|| {
        // SAFETY: `action` is NULL, or comes from erard_action_new or erard_action_of_instrument, has not been freed,
        // and no other call uses it meanwhile.
        let action = unsafe { action.as_mut() }.ok_or_else(|| Fault::null("the action"))?;
        // SAFETY: `stroke` is NULL, or comes from erard_stroke_new or erard_stroke_builtin, has not been freed, and no
        // other call uses it meanwhile.
        let stroke = unsafe { stroke.as_mut() }.ok_or_else(|| Fault::null("the stroke"))?;
        // SAFETY: `reading` is NULL, or aligned and writable memory for one ErardReading that begins with its size and
        // that nothing else uses during the call.
        let place = unsafe { Place::new(reading) }
            .map_err(|status| Fault::new(status, "the reading: set struct_size to sizeof(ErardReading)"))?;
        let settings = *action.play.action.settings();
        if let Some(Hand { start_m, start_m_per_s, .. }) = stroke.hand.filter(|_| stroke.steps == 0) {
            action.play.place_hand(start_m, start_m_per_s);
        }
        let begins_s = stroke.start_s + stroke.steps as f64 * settings.step;
        let now = (stroke.drive)(begins_s + settings.theta * settings.step);
        let input = match (stroke.hand, now) {
            (Some(hand), muscle) => hand.input(&muscle).unwrap_or(muscle),
            // The values of an imposed motion belong to the step's end.
            (None, Input::Rigid { .. }) => (stroke.drive)(begins_s + settings.step),
            (None, other) => other,
        };
        ended = match allowed(&input) {
            Ok(()) => action.play.step(input),
            Err(status) => status,
        };
        stroke.steps += u64::from(ended as i32 >= 0);
        if let Some(place) = place {
            // SAFETY: `place` is the caller's memory for one ErardReading that nothing else uses during the call.
            unsafe { place.write(0, &action.play.reading) };
        }
        if (ended as i32) < 0 {
            return Err(Fault::new(ended, format!("the stroke cannot be played at {begins_s:.6} s")));
        }
        Ok(())
    });
    if (failed as i32) < 0 { failed } else { ended }
}

/// Checks a recording's input against the limits of every other input.
fn allowed(input: &Input) -> Result<(), ErardStatus> {
    match *input {
        Input::Force(force_n) => within(force_n, ERARD_MAX_FORCE_N).map(|_| ()),
        Input::Motion { position_m, velocity_m_per_s } | Input::Rigid { position_m, velocity_m_per_s } => {
            within(position_m, ERARD_MAX_POSITION_M)?;
            within(velocity_m_per_s, ERARD_MAX_SPEED_M_PER_S).map(|_| ())
        }
        _ => Ok(()),
    }
}

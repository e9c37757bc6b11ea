//! Drawing of an action and the technician's sheet, for a page beside the moving action.

use std::borrow::Cow;
use std::cell::Cell;
use std::ffi::{c_char, c_void};
use std::ptr::null_mut;

use erard::instrument::{Instrument, InstrumentFile, KeyError};
use erard::keyboard::KEYS;
use erard::parameter::canonical_name;
use erard::parameter::{ChangeError, ParameterChange, varied_text};
use erard_figures::drawing::{PoseOptions, pose_picture};
use erard_figures::page::scene;
use erard_workshop::diagnose::{self, Typed, diagnose};
use erard_workshop::dials::{DialError, dials, typed_value, with_dials};
use erard_workshop::distances::Protocol;
use erard_workshop::measure::norms::{GROUPS, Line, MIDDLE_C, lines};
use erard_workshop::measure::{MeasureError, measure, measure_some};
use erard_workshop::regulate::{Goal, Specification, Status, needed, parse_value, regulate, regulate_following};
use erard_workshop::test_press::test_press;
use serde_json::{Map, Value, json};

use crate::instrument::{ErardInstrument, boxed, file_fault, given};
use crate::status::{ErardStatus, Fault, tell, told};
use crate::text::{give, name};

/// Progress function, called repeatedly during long work with the share done, 0 to 1 (NaN where the share is not
/// known), and the caller's own pointer. If it returns 0, the work stops with ERARD_STATUS_INTERRUPTED.
pub type ErardProgress = Option<unsafe extern "C" fn(share: f64, user: *mut c_void) -> i32>;

/// Changes one quantity by its common name, as the command's option `--vary` does. `called` is "body.hammer.mass" (a
/// body's mass and, in proportion, its inertia), "let_off", "zone.check.friction", or the path of a parameter. `change`
/// is "8.7 g" (a value), "+0.8 g" or "-0.2 mm" (a difference), "x1.5" (a factor) or "=-0.2 mm" (a value with a sign). A
/// number without a unit is in SI units, or in the unit at the end of a path; it is never a factor. The new values are
/// written into the file's text, to ten digits, and the text is read anew. Errors: ERARD_STATUS_NO_SUCH (unknown name,
/// or one that does nothing in this instrument), ERARD_STATUS_ARGUMENT (the change cannot be read), ERARD_STATUS_RANGE
/// (the change is too large) and ERARD_STATUS_FILE (the file may not have this value); erard_last_error says what is
/// expected. An error leaves the instrument as it was. Actions made from it earlier do not change.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_vary(
    instrument: *mut ErardInstrument,
    called: *const c_char,
    change: *const c_char,
) -> ErardStatus {
    // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no other call uses it
    // meanwhile; `called` and `change` are NULL, or texts that end with a zero and do not change during the call.
    tell(|| unsafe { vary(instrument, called, change, ParameterChange::Text) })
}

/// Changes one quantity as erard_instrument_vary does, for a field in which a person types: a number without a unit is
/// in the unit in which technicians read the quantity (mm, g, degrees, N mm; else in SI units, or in the unit at the
/// end of a path), as in the command's option `--vary`. Errors are those of erard_instrument_vary.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_vary_field(
    instrument: *mut ErardInstrument,
    called: *const c_char,
    change: *const c_char,
) -> ErardStatus {
    // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no other call uses it
    // meanwhile; `called` and `change` are NULL, or texts that end with a zero and do not change during the call.
    tell(|| unsafe { vary(instrument, called, change, ParameterChange::Field) })
}

unsafe fn vary(
    instrument: *mut ErardInstrument,
    called: *const c_char,
    change: *const c_char,
    wanted: fn(String) -> ParameterChange,
) -> Result<(), Fault> {
    // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no other call uses it
    // meanwhile.
    let instrument = unsafe { instrument.as_mut() }.ok_or_else(|| Fault::null("the instrument"))?;
    // SAFETY: `called` and `change` are NULL, or texts that end with a zero and do not change during the call.
    let (called, change) = unsafe { (name(called, "what is varied")?, name(change, "the change")?) };
    let text = varied_text(&instrument.text, "instrument", called, &wanted(change.to_owned()));
    let text = text.map_err(|error| change_fault(&error))?;
    instrument.file = InstrumentFile::parse(&text, "instrument").map_err(|error| file_fault(&error))?;
    instrument.text = text;
    Ok(())
}

fn change_fault(error: &ChangeError) -> Fault {
    let status = match error {
        ChangeError::Unknown(_) | ChangeError::Idle(_) => ErardStatus::NoSuch,
        ChangeError::Value { .. } => ErardStatus::Argument,
        ChangeError::Range { .. } => ErardStatus::Range,
        ChangeError::File(_) => ErardStatus::File,
        _ => ErardStatus::Argument,
    };
    Fault::new(status, error.to_string())
}

/// Returns a drawing of the instrument in one pose as SVG, as the command draws it. `angles_rad` holds `count` absolute
/// angles of its bodies, rad, as erard_action_angles writes them; NULL and 0 draw the pose of its file. `size_px` is
/// the longer side, 16 to 16384 px. `labels` is 1 to name the parts. Elements of a moving part have the attribute
/// `data-body`, the body's number. Returns NULL on failure. Free the text with erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_draw(
    instrument: *const ErardInstrument,
    angles_rad: *const f64,
    count: usize,
    size_px: f64,
    labels: u32,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no call changes it
        // meanwhile.
        let instrument = unsafe { given(instrument) }?.instrument();
        let bodies = instrument.bodies.len();
        let angles: &[f64] = if angles_rad.is_null() {
            &[]
        } else if count < bodies {
            return Err(Fault::new(ErardStatus::Size, format!("{count} angles for {bodies} bodies")));
        } else {
            // SAFETY: `angles_rad` is not NULL; it is aligned and begins `count` numbers, no fewer than `bodies`, that
            // do not change during the call.
            unsafe { core::slice::from_raw_parts(angles_rad, bodies) }
        };
        if angles.iter().any(|angle| !angle.is_finite()) {
            return Err(Fault::new(ErardStatus::NotFinite, "an angle is not finite"));
        }
        if !(16.0..=16384.0).contains(&size_px) {
            return Err(Fault::new(ErardStatus::Range, format!("a picture of {size_px} px; expected 16 to 16384")));
        }
        let options = PoseOptions { size_px, labels: labels != 0, ..PoseOptions::default() };
        give(pose_picture(instrument, angles, &options).svg(), length)
    })
}

/// Measures an instrument as a technician does, from where it rests after a moderate blow, and returns JSON. If
/// `wanted` is NULL, the JSON is the whole sheet, as `erard measure --json` writes it for an instrument. Otherwise
/// `wanted` names lines of the sheet, separated by commas ("down_weight_g,dip_mm"); the JSON is an object of their
/// values, and only these are measured. `key` is the piano key whose usual ranges hold, 1 to 88 (erard_key_number reads
/// notes); 0 is the instrument's own, or C4 where it does not know its key. `progress` may be NULL; with `wanted` its
/// share is NaN. Takes tenths of a second to seconds. Returns NULL on failure, with ERARD_STATUS_NO_SUCH for an unknown
/// line or key and ERARD_STATUS_ARGUMENT for a key other than the instrument's own. Free the text with erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_measure(
    instrument: *const ErardInstrument,
    key: u32,
    wanted: *const c_char,
    progress: ErardProgress,
    user: *mut c_void,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no call changes it
        // meanwhile.
        let own = unsafe { given(instrument) }?.instrument();
        let of_key = of_key(own, key)?;
        let instrument: &Instrument = &of_key;
        let tell = |share: f64| going(progress, user, share);
        if wanted.is_null() {
            let sheet = measure(instrument, &mut |share| tell(share)).map_err(|error| not_measured(&error))?;
            let text =
                serde_json::to_string(&sheet).map_err(|error| Fault::new(ErardStatus::Internal, error.to_string()))?;
            return give(text, length);
        }
        // SAFETY: `wanted` is NULL, or a text that ends with a zero and does not change during the call.
        let wanted = named(unsafe { name(wanted, "the list of lines") }?)?;
        let values =
            measure_some(instrument, &wanted, &mut |_| tell(f64::NAN)).map_err(|error| not_measured(&error))?;
        let all: Map<String, Value> =
            wanted.iter().zip(values).map(|(line, value)| (line.key.to_owned(), value.into())).collect();
        give(Value::Object(all).to_string(), length)
    })
}

/// The instrument as that of a key; 0 leaves it as it is.
fn of_key(own: &Instrument, key: u32) -> Result<Cow<'_, Instrument>, Fault> {
    if key == 0 {
        return Ok(Cow::Borrowed(own));
    }
    let mut instrument = own.clone();
    instrument.set_key(key as usize).map_err(|error| {
        let status = match error {
            KeyError::Unknown(_) => ErardStatus::NoSuch,
            _ => ErardStatus::Argument,
        };
        Fault::new(status, error.to_string())
    })?;
    Ok(Cow::Owned(instrument))
}

/// Whether to go on.
pub(crate) fn going(progress: ErardProgress, user: *mut c_void, share: f64) -> bool {
    // SAFETY: `progress` is the caller's function of this type, and `user` the pointer that it takes.
    progress.is_none_or(|told| unsafe { told(share, user) } != 0)
}

/// Returns the lines of the sheet with these names.
fn named(list: &str) -> Result<Vec<&'static Line>, Fault> {
    let each = list.split(',').map(str::trim).map(|key| {
        lines().find(|line| line.key == canonical_name(key)).ok_or_else(|| {
            let known = lines().map(|line| line.key).collect::<Vec<_>>().join(", ");
            Fault::new(ErardStatus::NoSuch, format!("the sheet has no line `{key}`; it has {known}"))
        })
    });
    each.collect()
}

fn not_measured(error: &MeasureError) -> Fault {
    let status = if error.is_interruption() { ErardStatus::Interrupted } else { ErardStatus::Model };
    Fault::new(status, error.to_string())
}

/// Turns an instrument's screws until its action meets goals and returns JSON: the outcome of every goal, the screws
/// that were turned, all distances before and after (the fields of the report that `erard regulate` writes), and
/// "file", the text of the instrument file with its new settings. The instrument itself does not change. If `goals` is
/// NULL, what is out of its usual range is set to the trade's norm, and all else stays as it is. Otherwise it is a JSON
/// object of goals by name, with values in mm (`repetition spring` in mm/s, `damper start` in %) or texts with units:
/// {"let-off": 1.5, "blow": "1.8in"}. `progress` may be NULL. Takes seconds. Returns NULL on failure. Free the text
/// with erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_regulate(
    instrument: *const ErardInstrument,
    goals: *const c_char,
    progress: ErardProgress,
    user: *mut c_void,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or one of this library that is not freed and that no call changes; `goals` is
        // NULL, or a text that ends with a zero.
        let own = unsafe { given(instrument) }?;
        let goals = if goals.is_null() { None } else { Some(asked(unsafe { name(goals, "the goals") }?)?) };
        let stopped = Cell::new(false);
        let (protocol, action) = (Protocol::default(), own.instrument());
        let mut tell = |now: &Status| {
            let on = going(progress, user, now.share);
            stopped.set(stopped.get() || !on);
            on
        };
        let regulated = match goals {
            Some(goals) => regulate(action, &goals, &protocol, &mut tell),
            None => needed(action, &protocol, &mut tell)
                .and_then(|goals| regulate_following(action, &goals, &protocol, &mut tell)),
        };
        let regulated = regulated.map_err(|error| {
            let status = if stopped.get() { ErardStatus::Interrupted } else { ErardStatus::Model };
            Fault::new(status, error.to_string())
        })?;
        let inside = |error: &dyn std::fmt::Display| Fault::new(ErardStatus::Internal, error.to_string());
        let file = regulated.rewrite(&own.text).map_err(|error| inside(&error))?;
        let mut report = regulated.report();
        report["file"] = file.into();
        give(report.to_string(), length)
    })
}

/// Reads the goals.
fn asked(goals: &str) -> Result<Specification, Fault> {
    let wrong = |text: String| Fault::new(ErardStatus::Argument, text);
    let value: Value =
        serde_json::from_str(goals).map_err(|error| wrong(format!("the goals are not JSON: {error}")))?;
    let Value::Object(goals) = value else {
        return Err(wrong("the goals are not a JSON object, such as {\"let-off\": 1.5}".into()));
    };
    let each = goals.into_iter().map(|(name, value)| {
        let goal = Goal::named(&name).ok_or_else(|| {
            let known = Goal::ALL.map(Goal::name).join(", ");
            wrong(format!("there is no goal `{name}`; expected one of {known}"))
        })?;
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let target =
            parse_value(goal, &text).map_err(|expected| wrong(format!("{name}: {text}; expected {expected}")))?;
        Ok((goal, target))
    });
    each.collect()
}

/// Returns a drawing of an instrument as JSON, for a page that animates it. "shapes" and "gradients" are SVG for a g
/// and a defs element; moving elements have the attribute `data-body`, those on the pedal's rail `data-rail`. "bodies"
/// have their hinges, drawn angles and masses; "zones" the direction of their arrows. "press", "pedal" (whether there
/// is one), "string" (its striking point and height; null for a rigid string), "labels", "views" and the scale of the
/// arrows follow. Lengths are mm of the picture. Returns NULL on failure. Free the text with erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_drawing_json(
    instrument: *const ErardInstrument,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no call changes it
        // meanwhile.
        let instrument = unsafe { given(instrument) }?.instrument();
        give(scene(instrument).to_string(), length)
    })
}

/// Returns the lines of the protocol sheet as JSON: groups of "heading" and "lines". Each line has "key" (its name in
/// erard_instrument_measure), "label", "unit", "decimals", and its norm at a piano key, 1 to 88: "usual" ([low, high];
/// null where open) and "source". Returns NULL if there is no such piano key. Free the text with erard_text_free.
#[unsafe(no_mangle)]
pub extern "C" fn erard_sheet_lines(key: u32, length: *mut usize, status: *mut ErardStatus) -> *mut c_char {
    told(null_mut(), status, || {
        let key = known_key(key)?;
        let groups = GROUPS.iter().map(|group| {
            let lines = group.page_lines().map(|line| {
                json!({
                    "key": line.key,
                    "label": line.label.trim_start(),
                    "unit": line.unit,
                    "decimals": line.decimals,
                    "usual": line.range(key),
                    "source": line.norm().map(|norm| &norm.source),
                })
            });
            json!({ "heading": group.heading, "lines": lines.collect::<Vec<_>>() })
        });
        give(Value::Array(groups.collect()).to_string(), length)
    })
}

/// Diagnoses a key of a real piano from its measured readings and returns JSON, as `erard diagnose` writes it to
/// diagnosis.json: readings, causes, remedies and what to measure next. `readings` is a JSON object: "key" (1 to 88, or
/// a note; without it C4 is assumed and "is_key_assumed" is true), "leads" ("14@165, 14@147"), and readings by the
/// names of erard_diagnose_quantities, as numbers (in the unit at the end of the name) or as texts with units.
/// "balance_weight_g" and "friction_weight_g" may replace down-weight and up-weight. Takes up to seconds. Returns NULL
/// on failure; erard_last_error lists all errors in the readings. Free the text with erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_diagnose(
    readings: *const c_char,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `readings` is NULL, or a text that ends with a zero and does not change during the call.
        let typed = Typed::read(unsafe { name(readings, "the readings") }?).map_err(|faults| {
            let each: Vec<String> = faults.iter().map(ToString::to_string).collect();
            Fault::new(ErardStatus::Argument, each.join("; "))
        })?;
        let found = diagnose(&typed.known, typed.key.unwrap_or(MIDDLE_C));
        give(diagnose::answer(&[found], None, typed.key.is_none()).to_string(), length)
    })
}

/// Returns all errors in readings for erard_diagnose as JSON: an array of "name" (the reading's name, "key" or "leads";
/// empty if the error belongs to none of them), "found" and "expected". The array is empty if the readings are valid.
/// Free the text with erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_diagnose_check(
    readings: *const c_char,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `readings` is NULL, or a text that ends with a zero and does not change during the call.
        let faults = Typed::read(unsafe { name(readings, "the readings") }?).err().unwrap_or_default();
        give(diagnose::faults(&faults).to_string(), length)
    })
}

/// Returns the quantities that can be measured on a real piano's key as JSON: an array of "name" (for erard_diagnose),
/// "label", "unit", "decimals", "limits", "precision", "usual" ([low, high] at that key, 1 to 88; null where open or
/// not applicable to this key) and "how" to measure it. Returns NULL if there is no such key. Free the text with
/// erard_text_free.
#[unsafe(no_mangle)]
pub extern "C" fn erard_diagnose_quantities(key: u32, length: *mut usize, status: *mut ErardStatus) -> *mut c_char {
    told(null_mut(), status, || give(diagnose::form(known_key(key)?).to_string(), length))
}

/// Checks that a key exists.
fn known_key(key: u32) -> Result<usize, Fault> {
    let key = key as usize;
    if (1..=KEYS).contains(&key) {
        Ok(key)
    } else {
        Err(Fault::new(ErardStatus::NoSuch, format!("there is no key {key}; expected 1 to {KEYS}")))
    }
}

/// Returns the screws and parameters of an instrument that can be changed, called dials, as JSON: an array of "name",
/// "label", "note", "group", "unit", "decimals", "value", "from" and "to". Returns NULL on failure. Free the text with
/// erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_dials(
    instrument: *const ErardInstrument,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no call changes it
        // meanwhile.
        let own = unsafe { given(instrument) }?;
        let text = serde_json::to_string(&dials(&own.file));
        give(text.map_err(|error| Fault::new(ErardStatus::Internal, error.to_string()))?, length)
    })
}

/// Reads what a person types into a dial's field, and writes the dial's new value, in the dial's unit, to `value`:
/// "0.3", "0.3 mm", "1/64in" (the value), "+0.5", "-0.2 mm" (a difference from this instrument's value), "x1.05" (a
/// factor of it) or "=-0.2" (a value with a sign). A number without a unit is in the dial's unit. Errors:
/// ERARD_STATUS_NO_SUCH (there is no such dial), ERARD_STATUS_ARGUMENT (the text cannot be read) and ERARD_STATUS_RANGE
/// (the value is out of the dial's range); erard_last_error says what is expected.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_dial_typed(
    instrument: *const ErardInstrument,
    dial: *const c_char,
    typed: *const c_char,
    value: *mut f64,
) -> ErardStatus {
    tell(|| {
        // SAFETY: `instrument` is NULL, or one of this library that is not freed and that no call changes; `dial` and
        // `typed` are NULL, or texts that end with a zero.
        let (own, dial, typed) =
            unsafe { (given(instrument)?, name(dial, "the dial's name")?, name(typed, "the typed text")?) };
        // SAFETY: `value` is NULL, or aligned and writable memory for one number that nothing else uses during the
        // call.
        let place = unsafe { value.as_mut() }.ok_or_else(|| Fault::null("the value"))?;
        *place = typed_value(&own.file, dial, typed).map_err(|error| {
            let status = match error {
                DialError::Unknown(_) => ErardStatus::NoSuch,
                DialError::Range(_) => ErardStatus::Range,
                _ => ErardStatus::Argument,
            };
            Fault::new(status, error.to_string())
        })?;
        Ok(())
    })
}

/// Returns a new instrument with dials set to new values. `turns` is a JSON object of dial names and values, e.g.
/// {"let_off": -0.5, "hammer": 9.5}. All dials are set relative to this instrument, which does not change. Returns NULL
/// on failure, such as a value out of range or one that the file may not have. The new instrument belongs to the caller
/// until erard_instrument_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_with_dials(
    instrument: *const ErardInstrument,
    turns: *const c_char,
    status: *mut ErardStatus,
) -> *mut ErardInstrument {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or one of this library that is not freed and that no call changes; `turns` is
        // NULL, or a text that ends with a zero.
        let (own, turns) = (unsafe { given(instrument) }?, unsafe { name(turns, "the turns") }?);
        let wrong = |text: String| Fault::new(ErardStatus::Argument, text);
        let turns: Map<String, Value> =
            serde_json::from_str(turns).map_err(|error| wrong(format!("the turns are not a JSON object: {error}")))?;
        let wanted: Result<Vec<(String, f64)>, Fault> = turns
            .into_iter()
            .map(|(name, value)| {
                let number = value.as_f64().ok_or_else(|| wrong(format!("{name}: {value}; expected a number")))?;
                Ok((name, number))
            })
            .collect();
        let text = with_dials(&own.file, &own.text, &wanted?).map_err(wrong)?;
        let file = InstrumentFile::parse(&text, "instrument").map_err(|error| file_fault(&error))?;
        Ok(boxed(file, text))
    })
}

/// Presses an instrument once, mezzo forte, and reports as JSON whether it plays: "hammer_speed_m_per_s" (null if the
/// hammer does not reach the string) and "warnings", sentences about results that cannot be trusted and parts that do
/// not work. Takes a tenth of a second. Returns NULL on failure. Free the text with erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_test_press(
    instrument: *const ErardInstrument,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no call changes it
        // meanwhile.
        let instrument = unsafe { given(instrument) }?.instrument();
        let tried =
            test_press(instrument, &mut |_| true).map_err(|error| Fault::new(ErardStatus::Model, error.to_string()))?;
        let warnings: Vec<&str> = tried.warnings.iter().map(|warning| warning.what.as_str()).collect();
        give(json!({ "hammer_speed_m_per_s": tried.hammer_speed_m_per_s, "warnings": warnings }).to_string(), length)
    })
}

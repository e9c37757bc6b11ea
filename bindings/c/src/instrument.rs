//! Instruments: read, checked, their numbers read and changed.

use std::ffi::c_char;
use std::ptr::null_mut;

use erard::Instrument;
use erard::instrument::{FileError, InstrumentFile, utf8, with_numbers};
use erard::key::{KEYS, UnknownKey, key_named};
use erard::keyboard::{Keyboard, is_keyboard};
use serde_json::{Value, json};

use crate::status::{ErardStatus, Fault, ended, tell, told};
use crate::text::{bytes, give, name};

/// An instrument, with the text of the file that it was read from. It belongs to the caller until
/// erard_instrument_free. Only erard_instrument_set and erard_instrument_vary change it; several threads may read it at
/// once.
pub struct ErardInstrument {
    pub(crate) file: InstrumentFile,
    pub(crate) text: String,
}

impl ErardInstrument {
    pub(crate) fn instrument(&self) -> &Instrument {
        &self.file.instrument
    }
}

/// Converts an error of a file to a fault.
pub(crate) fn file_fault(error: &FileError) -> Fault {
    Fault::new(ErardStatus::File, error.to_string())
}

/// Describes an error of a file for a program: its place, its key, what was found and what is expected.
fn as_json(error: &FileError) -> Value {
    json!({
        "line": error.line,
        "column": error.column,
        "key": error.key,
        "message": error.message,
        "found": error.found,
        "expected": error.expected,
        "begin": error.span.start,
        "end": error.span.end,
        "text": error.to_string(),
    })
}

/// Reads the file in a caller's text; NULL gives the built-in concert grand.
pub(crate) unsafe fn parse(text: *const c_char, length: usize) -> Result<(InstrumentFile, String), Fault> {
    // SAFETY: `text` is NULL, or `length` readable bytes that do not change during the call.
    let text = match unsafe { bytes(text, length) }? {
        None => builtin("concert-grand")?,
        Some(bytes) => utf8(bytes, "instrument").map_err(|error| file_fault(&error))?,
    };
    let file = InstrumentFile::parse(text, "instrument").map_err(|error| file_fault(&error))?;
    Ok((file, text.to_owned()))
}

fn builtin(name: &str) -> Result<&'static str, Fault> {
    Instrument::builtin_text(name).ok_or_else(|| {
        let known = Instrument::builtin_names().collect::<Vec<_>>().join(", ");
        Fault::new(ErardStatus::NoSuch, format!("there is no built-in instrument `{name}`; expected one of {known}"))
    })
}

pub(crate) fn boxed(file: InstrumentFile, text: String) -> *mut ErardInstrument {
    Box::into_raw(Box::new(ErardInstrument { file, text }))
}

/// Reads an instrument from the text of its file (UTF-8, `length` bytes). NULL and 0 give the built-in concert grand.
/// Returns NULL on failure: `status` (which may be NULL) receives the reason, and erard_last_error describes it;
/// erard_file_check reports the error as JSON. Real time: no, like all functions of instruments.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_new(
    text: *const c_char,
    length: usize,
    status: *mut ErardStatus,
) -> *mut ErardInstrument {
    told(null_mut(), status, || {
        // SAFETY: `text` is NULL, or `length` readable bytes that do not change during the call.
        let (file, text) = unsafe { parse(text, length) }?;
        Ok(boxed(file, text))
    })
}

/// Reads a built-in instrument by its name, e.g. "heavy-touch"; erard_builtin_names lists the names. Returns NULL on
/// failure, with ERARD_STATUS_NO_SUCH for an unknown name.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_builtin(
    called: *const c_char,
    status: *mut ErardStatus,
) -> *mut ErardInstrument {
    told(null_mut(), status, || {
        // SAFETY: `called` is NULL, or a text that ends with a zero and does not change during the call.
        let text = builtin(unsafe { name(called, "the instrument's name") }?)?;
        let file = InstrumentFile::parse(text, "instrument").map_err(|error| file_fault(&error))?;
        Ok(boxed(file, text.to_owned()))
    })
}

/// Reads the instrument of a key, 1 to 88, of the built-in keyboard `concert-grand`. Returns NULL on failure, with
/// ERARD_STATUS_NO_SUCH if there is no such key.
#[unsafe(no_mangle)]
pub extern "C" fn erard_instrument_of_key(key: u32, status: *mut ErardStatus) -> *mut ErardInstrument {
    told(null_mut(), status, || of_key("concert-grand", key))
}

/// Reads the instrument of a key, 1 to 88, of a built-in keyboard by the keyboard's name, e.g. "concert-grand-strings";
/// erard_builtin_names lists the names. Returns NULL on failure, with ERARD_STATUS_NO_SUCH if there is no such keyboard
/// or key.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_of_keyboard(
    called: *const c_char,
    key: u32,
    status: *mut ErardStatus,
) -> *mut ErardInstrument {
    // SAFETY: `called` is NULL, or a text that ends with a zero and does not change during the call.
    told(null_mut(), status, || of_key(unsafe { name(called, "the keyboard's name") }?, key))
}

/// Returns the number of a piano's key, 1 to 88, from its note or its number as text: "C4", "c#4", "Db4", "40". Returns
/// 0 on failure, with ERARD_STATUS_NO_SUCH for a text that names none of the 88.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_key_number(called: *const c_char, status: *mut ErardStatus) -> u32 {
    told(0, status, || {
        // SAFETY: `called` is NULL, or a text that ends with a zero and does not change during the call.
        let text = unsafe { name(called, "the key's name") }?;
        let found = key_named(text).and_then(|key| u32::try_from(key).ok());
        found.ok_or_else(|| {
            let unknown = UnknownKey { found: text.to_owned() };
            Fault::new(ErardStatus::NoSuch, unknown.to_string())
        })
    })
}

fn of_key(name: &str, key: u32) -> Result<*mut ErardInstrument, Fault> {
    let key = key as usize;
    if !(1..=KEYS).contains(&key) {
        return Err(Fault::new(ErardStatus::NoSuch, format!("there is no key {key}; expected 1 to {KEYS}")));
    }
    let keyboard = builtin_keyboard(name)?;
    let file = keyboard.key_file(key).map_err(|error| file_fault(&error))?;
    Ok(boxed(file, keyboard.key_text(key)))
}

/// Reads a built-in keyboard.
pub(crate) fn builtin_keyboard(name: &str) -> Result<Keyboard, Fault> {
    Keyboard::builtin(name).map_err(|error| Fault::new(ErardStatus::NoSuch, error.to_string()))
}

/// Frees an instrument. NULL does nothing. Actions that were made from it remain valid.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_free(instrument: *mut ErardInstrument) {
    // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and is not used again.
    unsafe { ended(instrument) }
}

/// Returns the instrument at the caller's pointer.
pub(crate) unsafe fn given<'a>(instrument: *const ErardInstrument) -> Result<&'a ErardInstrument, Fault> {
    // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no call changes it meanwhile.
    unsafe { instrument.as_ref() }.ok_or_else(|| Fault::null("the instrument"))
}

/// Returns the present text of the instrument's file. `length` (which may be NULL) receives its number of bytes.
/// Returns NULL on failure. Free the text with erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_text(
    instrument: *const ErardInstrument,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no call changes it meanwhile.
    told(null_mut(), status, || give(unsafe { given(instrument) }?.text.clone(), length))
}

/// Writes one parameter of the file to `value`, in the file's own unit. `path` is its dotted path, with entries of a
/// list by their name: "body.hammer.mass_g", "zone.string.felt.exponent", "screw.let_off.setting_mm". `which` is 0, or
/// 0 or 1 for a coordinate. Returns ERARD_STATUS_NO_SUCH if there is no such parameter.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_get(
    instrument: *const ErardInstrument,
    path: *const c_char,
    which: usize,
    value: *mut f64,
) -> ErardStatus {
    tell(|| {
        // SAFETY: `instrument` is NULL, or one of this library that is not freed and that no call changes; `path` is
        // NULL, or a text that ends with a zero.
        let (instrument, path) = (unsafe { given(instrument) }?, unsafe { name(path, "the number's path") }?);
        // SAFETY: `value` is NULL, or aligned and writable memory for one number that nothing else uses during the
        // call.
        let place = unsafe { value.as_mut() }.ok_or_else(|| Fault::null("the value"))?;
        let number = instrument.file.provenance.numbers.iter().find(|number| number.key == path);
        *place = number.and_then(|number| number.values.get(which)).copied().ok_or_else(|| no_number(path, which))?;
        Ok(())
    })
}

fn no_number(path: &str, which: usize) -> Fault {
    Fault::new(ErardStatus::NoSuch, format!("the instrument has no number {which} at `{path}`"))
}

/// Changes one parameter of the file, in the file's own unit; `path` and `which` are as for erard_instrument_get. The
/// changed text is read anew. An error, such as ERARD_STATUS_FILE for a value that the file may not have, leaves the
/// instrument as it was. Actions made from it earlier do not change.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_set(
    instrument: *mut ErardInstrument,
    path: *const c_char,
    which: usize,
    value: f64,
) -> ErardStatus {
    tell(|| {
        // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no other call uses it
        // meanwhile.
        let instrument = unsafe { instrument.as_mut() }.ok_or_else(|| Fault::null("the instrument"))?;
        // SAFETY: `path` is NULL, or a text that ends with a zero and does not change during the call.
        let path = unsafe { name(path, "the number's path") }?;
        if !value.is_finite() {
            return Err(Fault::new(ErardStatus::NotFinite, format!("`{path}` cannot be {value}")));
        }
        let text = with_numbers(&instrument.text, &[(path, which, value)]).ok_or_else(|| no_number(path, which))?;
        instrument.file = InstrumentFile::parse(&text, "instrument").map_err(|error| file_fault(&error))?;
        instrument.text = text;
        Ok(())
    })
}

/// Returns the instrument as JSON: name, key (1 to 88) and sample (null where not known), description, gravity_m_s2,
/// bodies, zones and screws by name, and its parameters with path, values, line and source. Returns NULL on failure.
/// Free the text with erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_instrument_json(
    instrument: *const ErardInstrument,
    length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `instrument` is NULL, or comes from this library, has not been freed, and no call changes it
        // meanwhile.
        let file = &unsafe { given(instrument) }?.file;
        give(described(file).to_string(), length)
    })
}

fn described(file: &InstrumentFile) -> Value {
    let i = &file.instrument;
    let body = |body: Option<usize>| body.map(|body| i.bodies[body].name.as_str());
    let bodies = i.bodies.iter().map(|b| json!({ "name": b.name, "hinged_on": body(b.parent), "is_bend": b.is_bend }));
    let zones = i
        .zones
        .iter()
        .map(|z| json!({ "name": z.name, "label": z.label, "disc": body(z.disc_body), "curve": body(z.curve_body) }));
    let screws = i.screws.iter().map(|s| json!({ "name": s.name, "label": s.label, "setting": s.setting }));
    let numbers = file.provenance.numbers.iter().map(|number| {
        let cited = number.citation.as_ref();
        json!({
            "path": number.key,
            "line": number.line,
            "values": number.values,
            "source": cited.map(|c| &c.source),
            "certainty": cited.map(|c| c.certainty),
            "note": cited.and_then(|c| c.note.as_ref()),
        })
    });
    json!({
        "name": i.name,
        "key": i.key(),
        "sample": i.sample(),
        "description": file.description,
        "gravity_m_s2": i.gravity_m_per_s2,
        "bodies": bodies.collect::<Vec<_>>(),
        "zones": zones.collect::<Vec<_>>(),
        "screws": screws.collect::<Vec<_>>(),
        "numbers": numbers.collect::<Vec<_>>(),
    })
}

/// Checks the text of an instrument or keyboard file (`length` bytes) and returns the result as JSON: {"kind", "sound",
/// "name", "errors"}. Each error has "line" and "column" (from 1), "key", "message", "found", "expected", its bytes
/// from "begin" up to "end" (exclusive), and "text", which says all of it in one line. The reader stops at the first
/// error. Text that is not UTF-8 is reported as an error, too. Returns NULL on failure, such as a NULL text. Free the
/// JSON with erard_text_free.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn erard_file_check(
    text: *const c_char,
    length: usize,
    json_length: *mut usize,
    status: *mut ErardStatus,
) -> *mut c_char {
    told(null_mut(), status, || {
        // SAFETY: `text` is NULL, or `length` readable bytes that do not change during the call.
        let bytes = unsafe { bytes(text, length) }?.ok_or_else(|| Fault::null("the text"))?;
        let is_a_keyboard = is_keyboard(&String::from_utf8_lossy(bytes));
        let read = utf8(bytes, "file").and_then(|text| {
            if is_a_keyboard {
                let keyboard = Keyboard::parse(text, "file", std::path::Path::new(""))?;
                keyboard.instruments()?;
                Ok(keyboard.name)
            } else {
                InstrumentFile::parse(text, "file").map(|file| file.instrument.name.clone())
            }
        });
        let (name, errors) = match &read {
            Ok(name) => (Some(name), vec![]),
            Err(error) => (None, vec![as_json(error)]),
        };
        let kind = if is_a_keyboard { "keyboard" } else { "instrument" };
        give(json!({ "kind": kind, "sound": read.is_ok(), "name": name, "errors": errors }).to_string(), json_length)
    })
}

/// Returns the names of the built-in instruments and keyboards as JSON: {"instruments": [...], "keyboards": [...]}.
/// Free the text with erard_text_free.
#[unsafe(no_mangle)]
pub extern "C" fn erard_builtin_names(length: *mut usize, status: *mut ErardStatus) -> *mut c_char {
    told(null_mut(), status, || {
        let (instruments, keyboards): (Vec<_>, Vec<_>) =
            (Instrument::builtin_names().collect(), Keyboard::builtin_names().collect());
        give(json!({ "instruments": instruments, "keyboards": keyboards }).to_string(), length)
    })
}

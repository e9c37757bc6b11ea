//! FMI 2.0 for co-simulation. The standard names and describes these functions; the comments here describe what is
//! particular to this unit.
//!
//! The instrument, or the keyboard with its base instrument, is in the archive's `resources`. The instrument's numbers
//! are parameters: set before the end of initialisation, they are written into the text, which is then read again. A
//! communication step takes all steps of the simulation that end within it, counted from the start, so that
//! communication steps of any length do not drift. `component` is an instance of the unit, `played` the action or
//! keyboard that it plays.

mod component;
mod played;

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::ptr::null_mut;

use erard::saved::Lists;
use erard_workshop::fmu::{INSTRUMENT, KEYBOARD, Unit};

use component::{Component, SavedState};

/// fmi2Status.
const OK: c_int = 0;
const WARNING: c_int = 1;
const DISCARD: c_int = 2;
const ERROR: c_int = 3;

/// fmi2CallbackLogger; NULL for none.
type Logger = Option<unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...)>;

/// fmi2CallbackFunctions.
#[repr(C)]
pub(crate) struct Callbacks {
    logger: Logger,
    allocate: *const c_void,
    free: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

type Done = Result<c_int, String>;

/// Runs a function of the standard; errors go to the logger.
unsafe fn done(component: *mut Component, work: impl FnOnce(&mut Component) -> Done) -> c_int {
    // SAFETY: `component` is NULL, or comes from `fmi2Instantiate`, has not been freed, and no other call uses it
    // meanwhile.
    let Some(component) = (unsafe { component.as_mut() }) else { return ERROR };
    let result =
        catch_unwind(AssertUnwindSafe(|| work(component))).unwrap_or_else(|_| Err("a fault of the library".into()));
    result.unwrap_or_else(|text| {
        component.log(ERROR, &text);
        ERROR
    })
}

fn log(logger: Logger, environment: *mut c_void, name: &CStr, status: c_int, text: &str) {
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    if let Some(logger) = logger {
        // SAFETY: `logger` is the importer's function of this type, which the standard lets the unit call at any time
        // with `environment`. The text is an argument, not the format.
        unsafe {
            logger(environment, name.as_ptr(), status, c"logStatusError".as_ptr(), c"%s".as_ptr(), text.as_ptr());
        }
    }
}

/// Returns the path of the archive's resources.
fn resources(location: &str) -> Result<std::path::PathBuf, String> {
    let path = location
        .strip_prefix("file:")
        .ok_or_else(|| format!("{location}: expected a location that begins with file:"))?;
    let path = path.strip_prefix("//").map_or(path, |rest| rest.strip_prefix("localhost").unwrap_or(rest));
    let mut bytes = Vec::new();
    let mut rest = path.as_bytes();
    while let Some((&first, more)) = rest.split_first() {
        let code = more.get(..2).and_then(|hex| std::str::from_utf8(hex).ok());
        match code.filter(|_| first == b'%').and_then(|hex| u8::from_str_radix(hex, 16).ok()) {
            Some(byte) => {
                bytes.push(byte);
                rest = &more[2..];
            }
            None => {
                bytes.push(first);
                rest = more;
            }
        }
    }
    let path = String::from_utf8(bytes).map_err(|_| format!("{location} is not UTF-8"))?;
    // file:///C:/... is C:/...
    let drive = path.as_bytes();
    let has_drive = drive.len() > 2 && drive[0] == b'/' && drive[1].is_ascii_alphabetic() && drive[2] == b':';
    Ok(if has_drive { path[1..].into() } else { path.into() })
}

/// Reads the unit in these resources.
fn unit(folder: &Path) -> Result<Unit, String> {
    let read = |path: &str| {
        let path = folder.join(path.trim_start_matches("resources/"));
        std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))
    };
    let instrument = read(INSTRUMENT)?;
    let keyboard = folder.join(KEYBOARD.trim_start_matches("resources/"));
    let unit = if keyboard.exists() {
        Unit::of_keyboard(&read(KEYBOARD)?, &instrument)
    } else {
        Unit::of_instrument(&instrument)
    };
    unit.map_err(|error| error.to_string())
}

unsafe fn words<'a>(text: *const c_char) -> &'a str {
    // SAFETY: `text` is not NULL, and the standard has it end with a zero and stay as it is during the call.
    if text.is_null() { "" } else { unsafe { CStr::from_ptr(text) }.to_str().unwrap_or_default() }
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetTypesPlatform() -> *const c_char {
    c"default".as_ptr()
}

#[unsafe(no_mangle)]
extern "C" fn fmi2GetVersion() -> *const c_char {
    c"2.0".as_ptr()
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2Instantiate(
    name: *const c_char,
    kind: c_int,
    own_guid: *const c_char,
    location: *const c_char,
    callbacks: *const Callbacks,
    _visible: c_int,
    _logging: c_int,
) -> *mut Component {
    // SAFETY: `name`, `own_guid` and `location` are NULL, or texts that end with a zero; `callbacks` is NULL, or the
    // standard's structure, valid during the call.
    let (name, own_guid, location) = unsafe { (words(name), words(own_guid), words(location)) };
    let (logger, environment) =
        unsafe { callbacks.as_ref() }.map_or((None, null_mut()), |own| (own.logger, own.environment));
    let instance = CString::new(name).unwrap_or_default();
    let made = catch_unwind(|| {
        // fmi2CoSimulation.
        if kind != 1 {
            return Err("this unit is for co-simulation".to_owned());
        }
        let unit = unit(&resources(location)?)?;
        if unit.guid() != own_guid {
            return Err(format!("the guid {own_guid} is not that of this unit's files and library, {}", unit.guid()));
        }
        Ok(unit)
    });
    match made.unwrap_or_else(|_| Err("a fault of the library".to_owned())) {
        Ok(unit) => Box::into_raw(Box::new(Component::new(unit, instance, logger, environment))),
        Err(text) => {
            log(logger, environment, &instance, ERROR, &text);
            null_mut()
        }
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2FreeInstance(component: *mut Component) {
    if !component.is_null() {
        let _ = catch_unwind(AssertUnwindSafe(|| {
            // SAFETY: `component` is not NULL, comes from `fmi2Instantiate`, has not been freed, and is not used again.
            drop(unsafe { Box::from_raw(component) });
        }));
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetupExperiment(
    component: *mut Component,
    _tolerance_defined: c_int,
    _tolerance: f64,
    start_s: f64,
    _stop_defined: c_int,
    _stop_s: f64,
) -> c_int {
    unsafe {
        done(component, |c| {
            if !start_s.is_finite() {
                return Err(format!("the start time cannot be {start_s}"));
            }
            c.begin_at(start_s);
            Ok(OK)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2EnterInitializationMode(component: *mut Component) -> c_int {
    unsafe { done(component, |_| Ok(OK)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2ExitInitializationMode(component: *mut Component) -> c_int {
    unsafe { done(component, |c| c.begin().map(|()| OK)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2Terminate(component: *mut Component) -> c_int {
    unsafe { done(component, |_| Ok(OK)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2Reset(component: *mut Component) -> c_int {
    unsafe {
        done(component, |c| {
            c.reset();
            Ok(OK)
        })
    }
}

/// The caller's list; empty for NULL or a length of 0.
unsafe fn list<'a, T>(first: *const T, count: usize) -> &'a [T] {
    // SAFETY: `first` is not NULL; it is aligned and begins `count` initialised values that do not change during the
    // call.
    if first.is_null() { &[] } else { unsafe { std::slice::from_raw_parts(first, count) } }
}

unsafe fn get<T>(
    component: *mut Component,
    references: *const u32,
    count: usize,
    values: *mut T,
    is_integer: bool,
    of: impl Fn(f64) -> T,
) -> c_int {
    unsafe {
        done(component, |c| {
            if count > 0 && (references.is_null() || values.is_null()) {
                return Err("a list is NULL".into());
            }
            for (n, reference) in list(references, count).iter().enumerate() {
                let index = c.variable(*reference, is_integer)?;
                values.add(n).write(of(c.get(index)));
            }
            Ok(OK)
        })
    }
}

unsafe fn set<T: Copy>(
    component: *mut Component,
    references: *const u32,
    count: usize,
    values: *const T,
    is_integer: bool,
    of: impl Fn(T) -> f64,
) -> c_int {
    unsafe {
        done(component, |c| {
            if count > 0 && (references.is_null() || values.is_null()) {
                return Err("a list is NULL".into());
            }
            for (reference, value) in list(references, count).iter().zip(list(values, count)) {
                let index = c.variable(*reference, is_integer)?;
                c.set(index, of(*value))?;
            }
            Ok(OK)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetReal(c: *mut Component, references: *const u32, count: usize, values: *mut f64) -> c_int {
    unsafe { get(c, references, count, values, false, |value| value) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetReal(c: *mut Component, references: *const u32, count: usize, values: *const f64) -> c_int {
    unsafe { set(c, references, count, values, false, |value| value) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetInteger(
    c: *mut Component,
    references: *const u32,
    count: usize,
    values: *mut c_int,
) -> c_int {
    unsafe { get(c, references, count, values, true, |value| value as c_int) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetInteger(
    c: *mut Component,
    references: *const u32,
    count: usize,
    values: *const c_int,
) -> c_int {
    unsafe { set(c, references, count, values, true, f64::from) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2DoStep(
    component: *mut Component,
    now_s: f64,
    length_s: f64,
    _no_state_before: c_int,
) -> c_int {
    unsafe { done(component, |c| c.step(now_s, length_s)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2GetFMUstate(component: *mut Component, state: *mut *mut SavedState) -> c_int {
    unsafe {
        done(component, |c| {
            let place = state.as_mut().ok_or("the state's place is NULL")?;
            let saved = Box::new(c.save()?);
            if !place.is_null() {
                drop(Box::from_raw(*place));
            }
            *place = Box::into_raw(saved);
            Ok(OK)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SetFMUstate(component: *mut Component, state: *const SavedState) -> c_int {
    unsafe { done(component, |c| c.restore(state.as_ref().ok_or("the state is NULL")?).map(|()| OK)) }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2FreeFMUstate(component: *mut Component, state: *mut *mut SavedState) -> c_int {
    unsafe {
        done(component, |_| {
            if let Some(place) = state.as_mut()
                && !place.is_null()
            {
                drop(Box::from_raw(*place));
                *place = null_mut();
            }
            Ok(OK)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SerializedFMUstateSize(
    component: *mut Component,
    _state: *const c_void,
    size: *mut usize,
) -> c_int {
    unsafe {
        done(component, |c| {
            *size.as_mut().ok_or("the size's place is NULL")? = c.state_bytes()?;
            Ok(OK)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2SerializeFMUstate(
    component: *mut Component,
    state: *const SavedState,
    bytes: *mut u8,
    size: usize,
) -> c_int {
    unsafe {
        done(component, |_| {
            let state = state.as_ref().ok_or("the state is NULL")?;
            if bytes.is_null() || size < state.len() {
                return Err(format!("a state takes {} bytes; there are {size}", state.len()));
            }
            std::ptr::copy_nonoverlapping(state.as_ptr(), bytes, state.len());
            Ok(OK)
        })
    }
}

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2DeSerializeFMUstate(
    component: *mut Component,
    bytes: *const u8,
    size: usize,
    state: *mut *mut SavedState,
) -> c_int {
    unsafe {
        done(component, |c| {
            let place = state.as_mut().ok_or("the state's place is NULL")?;
            let saved: SavedState = list(bytes, size).to_vec();
            Lists::read(&saved, c.mark()).map_err(|error| error.to_string())?;
            if !place.is_null() {
                drop(Box::from_raw(*place));
            }
            *place = Box::into_raw(Box::new(saved));
            Ok(OK)
        })
    }
}

/// Functions that this unit does not have, with the types of their arguments.
macro_rules! without {
    ($($name:ident($($argument:ty),*) -> $status:expr;)*) => {$(
        #[unsafe(no_mangle)]
        unsafe extern "C" fn $name(component: *mut Component $(, _: $argument)*) -> c_int {
            unsafe { done(component, |_| $status) }
        }
    )*};
}

fn none<T>(what: &str) -> Result<T, String> {
    Err(format!("this unit has no {what}"))
}

without! {
    fmi2SetDebugLogging(c_int, usize, *const *const c_char) -> Ok(OK);
    fmi2GetBoolean(*const u32, usize, *mut c_int) -> none("booleans");
    fmi2SetBoolean(*const u32, usize, *const c_int) -> none("booleans");
    fmi2GetString(*const u32, usize, *mut *const c_char) -> none("texts");
    fmi2SetString(*const u32, usize, *const *const c_char) -> none("texts");
    fmi2GetDirectionalDerivative(*const u32, usize, *const u32, usize, *const f64, *mut f64) -> none("directional derivatives");
    fmi2SetRealInputDerivatives(*const u32, usize, *const c_int, *const f64) -> none("derivatives of inputs");
    fmi2GetRealOutputDerivatives(*const u32, usize, *const c_int, *mut f64) -> none("derivatives of outputs");
    fmi2CancelStep() -> none("steps that go on by themselves");
    fmi2GetStatus(c_int, *mut c_int) -> Ok(DISCARD);
    fmi2GetRealStatus(c_int, *mut f64) -> Ok(DISCARD);
    fmi2GetIntegerStatus(c_int, *mut c_int) -> Ok(DISCARD);
    fmi2GetBooleanStatus(c_int, *mut c_int) -> Ok(DISCARD);
    fmi2GetStringStatus(c_int, *mut *const c_char) -> Ok(DISCARD);
}

//! FMI 2.0 for co-simulation. The standard names these functions and says what each does; what is particular to this
//! unit stands here.
//!
//! The instrument is the text in the archive's `resources`. Its numbers are parameters: set before the end of
//! initialisation, they are put into the text, which is then read anew. A communication step is as many steps of the
//! simulation as end within it, counted from the start, so that communication steps of any length do not drift.

use std::ffi::{CStr, CString, c_char, c_int, c_void};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::ptr::null_mut;

use erard::Instrument;
use erard::instrument::{InstrumentFile, with_numbers};
use erard::player::SNAPSHOT_MARK;
use erard::saved::{Lists, Writer};
use erard::strings::Strings;
use erard_workshop::fmu::{INSTRUMENT, Role, Variable, guid, variables};
use erard_workshop::study::Parameter;

use crate::action::ErardAction;
use crate::reading::{ERARD_FORCE, ERARD_FREE, ERARD_HAND, ERARD_MOTION, ERARD_RIGID, ErardInput, ErardReading};
use crate::status::ErardStatus;

/// fmi2Status.
const OK: c_int = 0;
const WARNING: c_int = 1;
const DISCARD: c_int = 2;
const ERROR: c_int = 3;

/// fmi2CallbackFunctions.
#[repr(C)]
pub(crate) struct Callbacks {
    logger: Option<unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...)>,
    allocate: *const c_void,
    free: *const c_void,
    step_finished: *const c_void,
    environment: *mut c_void,
}

/// An instance of the unit.
pub(crate) struct Component {
    name: CString,
    logger: Option<unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...)>,
    environment: *mut c_void,
    text: String,
    file: InstrumentFile,
    variables: Vec<Variable>,
    /// The parameters as they are set, by their places among the variables.
    values: Vec<f64>,
    /// There from the end of initialisation.
    action: Option<ErardAction>,
    /// Force, position, velocity, and the pedal's lift.
    inputs: [f64; 4],
    start_s: f64,
    /// Steps taken since then.
    steps: u64,
}

/// A saved state: the action, the inputs, the start and the steps.
type SavedState = Vec<u8>;
/// What the names of the inputs are in it.
const INPUTS: &str = "fmu_inputs";

type Done = Result<c_int, String>;

/// Does what the standard asks for; errors go to the logger.
unsafe fn done(component: *mut Component, work: impl FnOnce(&mut Component) -> Done) -> c_int {
    // SAFETY: the importer's promise: an instance, or NULL.
    let Some(component) = (unsafe { component.as_mut() }) else { return ERROR };
    let result =
        catch_unwind(AssertUnwindSafe(|| work(component))).unwrap_or_else(|_| Err("a fault of the library".into()));
    result.unwrap_or_else(|text| {
        component.log(ERROR, &text);
        ERROR
    })
}

fn log(
    logger: Option<unsafe extern "C" fn(*mut c_void, *const c_char, c_int, *const c_char, *const c_char, ...)>,
    environment: *mut c_void,
    name: &CStr,
    status: c_int,
    text: &str,
) {
    let text = CString::new(text.replace('\0', " ")).unwrap_or_default();
    if let Some(logger) = logger {
        // SAFETY: the importer's promise: a logger as the standard describes it. The text is an argument, not the
        // format.
        unsafe {
            logger(environment, name.as_ptr(), status, c"logStatusError".as_ptr(), c"%s".as_ptr(), text.as_ptr());
        }
    }
}

impl Component {
    fn log(&self, status: c_int, text: &str) {
        log(self.logger, self.environment, &self.name, status, text);
    }

    fn variable(&self, reference: u32, is_integer: bool) -> Result<usize, String> {
        let found = self.variables.iter().position(|v| v.reference == reference && v.is_integer() == is_integer);
        found.ok_or_else(|| format!("there is no variable of value reference {reference}"))
    }

    fn reading(&self) -> ErardReading {
        self.action.as_ref().map(|action| action.play.reading).unwrap_or_default()
    }

    fn get(&self, index: usize) -> f64 {
        let r = self.reading();
        match self.variables[index].role {
            Role::Force => self.inputs[0],
            Role::Position => self.inputs[1],
            Role::Velocity => self.inputs[2],
            Role::Pedal => self.inputs[3],
            Role::Drive
            | Role::Step
            | Role::HandMass
            | Role::MuscleStiffness
            | Role::MuscleDamping
            | Role::Mass(_)
            | Role::Number(..) => self.values[index],
            Role::Reading(n) => [
                r.key_m,
                r.key_m_per_s,
                r.finger_n,
                r.hammer_m,
                r.hammer_m_per_s,
                r.string_n,
                if r.impact_count > 0 { self.start_s + r.impact_time_s } else { 0.0 },
                r.hammer_speed_m_per_s,
                self.action.as_ref().and_then(|one| one.play.action.strings()).map_or(0.0, Strings::bridge_n),
                r.hand_m,
                r.hand_m_per_s,
            ][n],
            Role::Impacts => f64::from(r.impact_count),
            Role::Contact(zone) => self.action.as_ref().map_or(0.0, |action| action.play.action.contact_force(zone)),
        }
    }

    fn set(&mut self, index: usize, value: f64) -> Result<(), String> {
        let variable = &self.variables[index];
        let Variable { name, role, .. } = variable;
        if !value.is_finite() {
            return Err(format!("`{name}` cannot be {value}"));
        }
        match role {
            Role::Force => self.inputs[0] = value,
            Role::Position => self.inputs[1] = value,
            Role::Velocity => self.inputs[2] = value,
            Role::Pedal => self.inputs[3] = value,
            _ if variable.is_parameter() && self.action.is_none() => self.values[index] = value,
            _ if variable.is_parameter() => {
                return Err(format!("`{name}` is a parameter: it can be set before the end of initialisation only"));
            }
            _ => return Err(format!("`{name}` is an output: it cannot be set")),
        }
        Ok(())
    }

    fn value(&self, role: Role) -> f64 {
        self.variables.iter().zip(&self.values).find(|(v, _)| v.role == role).map_or(0.0, |(_, value)| *value)
    }

    /// What drives the key now.
    fn input(&self) -> Result<ErardInput, String> {
        let kind = match self.value(Role::Drive) {
            0.0 => ERARD_FREE,
            1.0 => ERARD_FORCE,
            2.0 => ERARD_MOTION,
            3.0 => ERARD_RIGID,
            4.0 => ERARD_HAND,
            other => return Err(format!("`drive` is {other}; expected 0, 1, 2, 3 or 4")),
        };
        let [force_n, position_m, velocity_m_per_s, _] = self.inputs;
        Ok(ErardInput {
            kind,
            reserved: 0,
            force_n,
            position_m,
            velocity_m_per_s,
            hand_mass_kg: self.value(Role::HandMass),
            muscle_n_per_m: self.value(Role::MuscleStiffness),
            muscle_n_s_per_m: self.value(Role::MuscleDamping),
        })
    }

    /// The instrument with its parameters, at rest.
    fn begin(&mut self) -> Result<(), String> {
        self.input()?;
        let changes: Vec<(&str, usize, f64)> = self
            .changed()
            .filter_map(|(variable, value)| match variable.role {
                Role::Number(number, place) => Some((self.file.provenance.numbers[number].key.as_str(), place, value)),
                _ => None,
            })
            .collect();
        let mut instrument = if changes.is_empty() {
            self.file.instrument.clone()
        } else {
            let text = with_numbers(&self.text, &changes).ok_or("a parameter has no place in the instrument's text")?;
            InstrumentFile::parse(&text, INSTRUMENT).map_err(|error| error.to_string())?.instrument
        };
        self.put_masses(&mut instrument, &changes)?;
        let action = ErardAction::new(&instrument, self.value(Role::Step)).map_err(|fault| fault.text)?;
        (self.action, self.steps) = (Some(action), 0);
        Ok(())
    }

    /// The variables that have been set to another value than their first.
    fn changed(&self) -> impl Iterator<Item = (&Variable, f64)> {
        let all = self.variables.iter().zip(self.values.iter().copied());
        all.filter(|(variable, value)| variable.start != Some(*value))
    }

    /// Sets bodies' masses together with their inertias. A body whose own numbers are changed as well is refused: two
    /// parameters would say what it weighs.
    fn put_masses(&self, instrument: &mut Instrument, changes: &[(&str, usize, f64)]) -> Result<(), String> {
        for (variable, mass_kg) in self.changed() {
            let Role::Mass(body) = variable.role else { continue };
            let Variable { name, .. } = variable;
            let own = [format!("{name}_g"), name.replace(".mass", ".inertia_kg_m2")];
            if let Some((path, ..)) = changes.iter().find(|(path, ..)| own.iter().any(|own| own == path)) {
                return Err(format!(
                    "`{name}` and `{path}` are both set: set the mass with its inertia, or each by itself"
                ));
            }
            let parameter = Parameter::Mass(body);
            let (factor, [least, most]) = (mass_kg / parameter.value(instrument), parameter.range());
            if !(least..=most).contains(&factor) || !parameter.vary(instrument, factor) {
                let drawn_kg = parameter.value(instrument);
                return Err(format!("`{name}` is {mass_kg} kg; expected {least} to {most} times {drawn_kg} kg"));
            }
        }
        Ok(())
    }

    /// How many bytes a state takes.
    fn state_bytes(&self) -> Result<usize, String> {
        self.write(&mut [])
    }

    fn write(&self, bytes: &mut [u8]) -> Result<usize, String> {
        let action = self.action.as_ref().ok_or("there is no state before the end of initialisation")?;
        let mut out = Writer::new(bytes, SNAPSHOT_MARK);
        action.play.write(&mut out);
        out.list(INPUTS, &mut self.inputs.iter().copied());
        out.number("fmu_start_s", self.start_s);
        out.word("fmu_steps", self.steps);
        Ok(out.seal())
    }

    fn save(&self) -> Result<SavedState, String> {
        let mut state = vec![0; self.state_bytes()?];
        self.write(&mut state)?;
        Ok(state)
    }

    fn restore(&mut self, state: &SavedState) -> Result<(), String> {
        let action = self.action.as_mut().ok_or("a state can be set after the end of initialisation only")?;
        let lists = Lists::read(state, SNAPSHOT_MARK).map_err(|error| error.to_string())?;
        let status = action.play.read(&lists);
        if status != ErardStatus::Ok {
            return Err(format!("the state belongs to another instance: {status:?}"));
        }
        self.inputs = [0.0; 4];
        lists.fill(INPUTS, &mut self.inputs);
        self.start_s = lists.number("fmu_start_s").unwrap_or(0.0);
        self.steps = lists.word("fmu_steps").unwrap_or(0);
        Ok(())
    }
}

/// The path of the archive's resources.
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

unsafe fn words<'a>(text: *const c_char) -> &'a str {
    // SAFETY: the importer's promise: NULL, or a text that ends with a zero.
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
    // SAFETY: the importer's promises.
    let (name, own_guid, location) = unsafe { (words(name), words(own_guid), words(location)) };
    let (logger, environment) =
        unsafe { callbacks.as_ref() }.map_or((None, null_mut()), |own| (own.logger, own.environment));
    let instance = CString::new(name).unwrap_or_default();
    let made = catch_unwind(|| {
        // fmi2CoSimulation.
        if kind != 1 {
            return Err("this unit is for co-simulation".to_owned());
        }
        let path = resources(location)?.join("instrument.toml");
        let text = std::fs::read_to_string(&path).map_err(|error| format!("{}: {error}", path.display()))?;
        if guid(&text) != own_guid {
            return Err(format!(
                "the guid {own_guid} is not that of this unit's instrument and library, {}",
                guid(&text)
            ));
        }
        let file = InstrumentFile::parse(&text, INSTRUMENT).map_err(|error| error.to_string())?;
        let variables = variables(&file, &text);
        Ok((text, file, variables))
    });
    match made.unwrap_or_else(|_| Err("a fault of the library".to_owned())) {
        Ok((text, file, variables)) => Box::into_raw(Box::new(Component {
            name: instance,
            logger,
            environment,
            text,
            file,
            values: variables.iter().map(|variable| variable.start.unwrap_or(0.0)).collect(),
            variables,
            action: None,
            inputs: [0.0; 4],
            start_s: 0.0,
            steps: 0,
        })),
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
            // SAFETY: the importer's promise: it comes from `fmi2Instantiate`.
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
            c.start_s = start_s;
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
            (c.action, c.inputs, c.start_s, c.steps) = (None, [0.0; 4], 0.0, 0);
            c.values = c.variables.iter().map(|variable| variable.start.unwrap_or(0.0)).collect();
            Ok(OK)
        })
    }
}

/// The caller's list; empty for NULL or a length of 0.
unsafe fn list<'a, T>(first: *const T, count: usize) -> &'a [T] {
    // SAFETY: the importer's promise: so many.
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

/// Most steps of the simulation in one communication step.
const MOST_STEPS: u64 = 10_000_000;

#[unsafe(no_mangle)]
unsafe extern "C" fn fmi2DoStep(
    component: *mut Component,
    now_s: f64,
    length_s: f64,
    _no_state_before: c_int,
) -> c_int {
    unsafe {
        done(component, |c| {
            let input = c.input()?;
            let step_s = c.value(Role::Step);
            let Component { action: Some(action), start_s, steps, inputs, .. } = c else {
                return Err("a step before the end of initialisation".into());
            };
            action.play.action.set_pedal(inputs[3]);
            let until = (now_s + length_s - *start_s) / step_s;
            if !(length_s >= 0.0 && until.is_finite() && until > -0.5 && until - *steps as f64 <= MOST_STEPS as f64) {
                return Err(format!("a communication step of {length_s} s at {now_s} s"));
            }
            // Whole steps, counted from the start.
            let until = until.round() as u64;
            let mut worst = OK;
            while *steps < until {
                // What moves goes on moving within the communication step; the step receives where a finger is in its
                // middle, and where an imposed key front is at its end.
                let share = if input.kind == ERARD_RIGID { 1.0 } else { 0.5 };
                let later_s = (*start_s + (*steps as f64 + share) * step_s - now_s).max(0.0);
                let position_m = input.position_m + input.velocity_m_per_s * later_s;
                let step = ErardInput { position_m, ..input }.checked();
                match step.map_or_else(|status| status, |input| action.play.step(input)) {
                    ErardStatus::Ok => {}
                    ErardStatus::IterationLimit => worst = WARNING,
                    ErardStatus::NotFinite => {
                        c.log(DISCARD, "a number became infinite");
                        return Ok(DISCARD);
                    }
                    status => return Err(format!("a step could not be taken: {status:?}; inputs are {input:?}")),
                }
                *steps += 1;
            }
            Ok(worst)
        })
    }
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
        done(component, |_| {
            let place = state.as_mut().ok_or("the state's place is NULL")?;
            let saved: SavedState = list(bytes, size).to_vec();
            Lists::read(&saved, SNAPSHOT_MARK).map_err(|error| error.to_string())?;
            if !place.is_null() {
                drop(Box::from_raw(*place));
            }
            *place = Box::into_raw(Box::new(saved));
            Ok(OK)
        })
    }
}

/// What this unit does not have, by the names of its arguments' types.
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

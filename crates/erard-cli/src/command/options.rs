//! Options that several commands share.

use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use clap::{Args, ValueEnum};
use erard::instrument::{Finger, Instrument, utf8};
use erard::keyboard::{KEYS, Keyboard, is_keyboard};
use erard::one_dof;
use erard::player::{self, Input};
use erard::simulation::{Setup, SimulationError};
use erard::stroke::{ForceSeries, PositionOf, PositionSeries, Series, Touch};
use moreau::{FrictionLaw, Settings, Solver};

use crate::failure::Failure;
use crate::identity;
use crate::inputs;
use crate::recordings::{Ready, RecordingOptions, told};
use crate::tell;

/// Which instrument.
#[derive(Debug, Args)]
pub struct InstrumentOption {
    /// Instrument: a TOML file, or the name of a built-in one; or a key of a keyboard, as in concert-grand:key=88
    #[arg(long, value_name = "FILE-OR-NAME", default_value = "concert-grand")]
    instrument: String,
    /// Which model of it
    #[arg(long, value_enum, default_value_t = Model::Action)]
    pub model: Model,
}

/// Which model of an instrument.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Model {
    /// All bodies and zones of the file
    Action,
    /// One degree of freedom: the whole action as inertia and constant moment on the key
    OneDof,
}

impl Model {
    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Model::Action => "action",
            Model::OneDof => "one-dof",
        }
    }
}

impl InstrumentOption {
    /// Loads the instrument, reduced to the model that was asked for.
    pub fn load(&self) -> Result<Instrument, Failure> {
        let full = load_instrument(&self.instrument)?;
        Ok(match self.model {
            Model::Action => full,
            Model::OneDof => one_dof::reduce(&full)?.instrument,
        })
    }
}

/// An instrument by file or by name; after either, `:key=N` is key N of a keyboard.
pub fn load_instrument(asked: &str) -> Result<Instrument, Failure> {
    if let Some(one) = KeyboardKey::asked(asked)? {
        return one.instrument();
    }
    match instrument_path(asked) {
        Some(path) => Ok(load_file(path)?.0),
        None => Ok(builtin_instrument(asked)?.0),
    }
}

/// An instrument and the text that it was read from.
fn load_file(path: &Path) -> Result<(Instrument, String), Failure> {
    let (name, bytes) = inputs::bytes(path)?;
    let text = utf8(&bytes, &name)?;
    if is_keyboard(text) {
        return Err(Failure::Usage(format!("{name}: this is a keyboard; name one of its keys, as in {name}{KEY}40")));
    }
    let instrument = Instrument::parse(text, &name)?;
    identity::used("instrument", &instrument.name, Some(&name), &bytes);
    Ok((instrument, text.to_owned()))
}

/// The same, with the text it was read from.
pub fn load_instrument_and_text(asked: &str) -> Result<(Instrument, String), Failure> {
    if let Some(one) = KeyboardKey::asked(asked)? {
        return Ok((one.instrument()?, one.text()?));
    }
    let Some(path) = instrument_path(asked) else {
        let (instrument, text) = builtin_instrument(asked)?;
        return Ok((instrument, text.to_owned()));
    };
    load_file(path)
}

/// The path of an instrument file; `None` where a name is meant.
pub fn instrument_path(asked: &str) -> Option<&Path> {
    if asked.contains(KEY) {
        return None;
    }
    let path = Path::new(asked);
    (path.exists() || path.extension().is_some() || path.components().count() > 1).then_some(path)
}

fn builtin_instrument(name: &str) -> Result<(Instrument, &'static str), Failure> {
    let found = Instrument::builtin(name).ok().zip(Instrument::builtin_text(name)).ok_or_else(|| {
        let names: Vec<&str> = Instrument::builtin_names().collect();
        Failure::Usage(format!("there is no file and no built-in instrument `{name}` (built in: {})", names.join(", ")))
    })?;
    identity::used("instrument", &found.0.name, None, found.1.as_bytes());
    Ok(found)
}

/// What stands between a keyboard and the number of a key.
const KEY: &str = ":key=";

/// A key of a keyboard.
#[derive(Debug)]
pub struct KeyboardKey {
    /// The keyboard.
    pub keyboard: Keyboard,
    /// The key, from 1.
    pub key: usize,
}

impl KeyboardKey {
    /// What is asked for in the place of an instrument, as in `concert-grand:key=88`; `None` where that is no key of a keyboard.
    fn asked(asked: &str) -> Result<Option<Self>, Failure> {
        let Some((keyboard, key)) = asked.rsplit_once(KEY) else { return Ok(None) };
        let number = key.parse().ok().filter(|key| (1..=KEYS).contains(key));
        let key = number
            .ok_or_else(|| Failure::Usage(format!("{asked}: `{key}` is no key; expected a number from 1 to {KEYS}")))?;
        Ok(Some(KeyboardKey { keyboard: load_keyboard(keyboard)?, key }))
    }

    /// Its instrument.
    fn instrument(&self) -> Result<Instrument, Failure> {
        let instrument = self.keyboard.key(self.key)?;
        let text = self.keyboard.key_text(self.key);
        identity::used("instrument", &format!("{}, key {}", instrument.name, self.key), None, text.as_bytes());
        Ok(instrument)
    }

    /// The text of its instrument file, which is sound.
    pub fn text(&self) -> Result<String, Failure> {
        self.keyboard.key(self.key)?;
        Ok(self.keyboard.key_text(self.key))
    }
}

/// A keyboard by file or by name.
pub fn load_keyboard(file_or_name: &str) -> Result<Keyboard, Failure> {
    if let Some(path) = instrument_path(file_or_name) {
        let (name, bytes) = inputs::bytes(path)?;
        let keyboard = Keyboard::parse_bytes(&bytes, &name, path.parent().unwrap_or(Path::new("")))?;
        keyboard.base_path().into_iter().for_each(inputs::remember);
        identity::used("keyboard", &keyboard.name, Some(&name), &bytes);
        return Ok(keyboard);
    }
    let keyboard = Keyboard::builtin(file_or_name).ok_or_else(|| {
        let names: Vec<&str> = Keyboard::builtin_names().collect();
        let names = names.join(", ");
        Failure::Usage(format!("there is no file and no built-in keyboard `{file_or_name}` (built in: {names})"))
    })?;
    identity::used(
        "keyboard",
        &keyboard.name,
        None,
        Keyboard::builtin_text(file_or_name).unwrap_or_default().as_bytes(),
    );
    Ok(keyboard)
}

/// What the player does.
#[derive(Debug, Args)]
pub struct StrokeOptions {
    /// Stroke file: CSV or Parquet with columns for the time and for force and/or position (down is positive), as `time_s`, `force_N` or
    /// `Force (gf)`, `position_m` or `Travel [mm]`; a run's own run.csv is one
    #[arg(value_name = "STROKE.csv", conflicts_with_all = ["stroke", "force_step"])]
    file: Option<PathBuf>,
    /// Built-in stroke
    #[arg(long, value_name = "pp|p|mf|f|ff", value_parser = ["pp", "p", "mf", "f", "ff"], conflicts_with = "force_step")]
    stroke: Option<String>,
    /// How the finger meets the key in a built-in stroke
    #[arg(long, value_enum, default_value_t = TouchName::Pressed)]
    touch: TouchName,
    /// A constant force from the start on, N
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    force_step: Option<f64>,
    /// What is prescribed: the finger's force, the motion of a soft finger, or the key's own motion. Default: force where
    /// the stroke has one, else the motion of whatever was recorded (see --position): rigid for a key's, motion for a fingertip's
    #[arg(long, value_enum)]
    drive: Option<DriveName>,
    #[command(flatten)]
    recording: RecordingOptions,
}

/// How the finger meets the key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum TouchName {
    /// The finger rests on the key and presses
    Pressed,
    /// The finger falls onto the key
    Struck,
}

/// What is prescribed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum DriveName {
    /// The force on the key
    Force,
    /// The motion of a soft finger that can only push
    Motion,
    /// The motion of the key itself
    Rigid,
}

impl DriveName {
    /// Its name in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            DriveName::Force => "force",
            DriveName::Motion => "motion",
            DriveName::Rigid => "rigid",
        }
    }
}

/// Duration of a run under a constant force, s.
const FORCE_STEP_DURATION_S: f64 = 0.6;
/// How long a run goes on after the end of a stroke file, s: the key comes home and the hammer falls to rest.
const AFTERWARDS_S: f64 = 0.3;

/// A stroke, ready to drive.
#[derive(Debug)]
pub struct Stroke {
    /// What it is called in titles.
    pub title: String,
    /// What it prescribes.
    pub drive: DriveName,
    /// First instant, s.
    pub start_s: f64,
    /// Duration to run unless told otherwise, s.
    pub duration_s: f64,
    series: Option<Series>,
    position_of: PositionOf,
    /// The position that drives a key under this finger.
    worked_out: Mutex<Option<(Finger, Arc<PositionSeries>)>>,
    force_n: f64,
}

impl StrokeOptions {
    /// A constant force that is given otherwise: any stroke that is asked for contradicts it.
    pub fn load_constant(&self) -> Result<Stroke, Failure> {
        if self.file.is_some() || self.stroke.is_some() || self.drive.is_some_and(|d| d != DriveName::Force) {
            return Err(Failure::Usage("--vary force plays constant forces; it goes with no other stroke".into()));
        }
        Ok(Stroke::constant("constant forces".into(), 0.0))
    }

    /// Reads the stroke.
    pub fn load(&self) -> Result<Stroke, Failure> {
        if let Some(force_n) = self.force_step {
            if !(0.0..=erard::stroke::MAX_FORCE_N).contains(&force_n) {
                let why = if force_n < 0.0 { ": a finger pushes the key down, and cannot pull it up" } else { "" };
                return Err(Failure::Usage(format!(
                    "--force-step {force_n}: expected a number from 0 to {} N{why}",
                    erard::stroke::MAX_FORCE_N
                )));
            }
            identity::used_without_file("stroke", &format!("a constant force of {force_n} N"));
            if self.drive.is_some_and(|d| d != DriveName::Force) {
                return Err(Failure::Usage("--force-step prescribes a force; it has no motion to drive with".into()));
            }
            return Ok(Stroke::constant(format!("{force_n} N"), force_n));
        }
        if self.file.is_none() && self.recording.are_given() {
            return Err(Failure::Usage(
                "--columns, --position, --zero, --invert, --delay, --low-pass and --order belong to a stroke file"
                    .into(),
            ));
        }
        // What was done and noticed, told when nothing is wrong.
        let mut notes = Vec::new();
        let (series, title, position_of, after) = match &self.file {
            Some(path) => {
                let Ready { name, prepared, position_of, .. } = self.recording.load(path)?;
                notes = told(&prepared.report);
                (prepared.series, name, position_of, AFTERWARDS_S)
            }
            None => {
                let nuance = self.stroke.as_deref().unwrap_or("mf");
                let touch = match self.touch {
                    TouchName::Pressed => Touch::Pressed,
                    TouchName::Struck => Touch::Struck,
                };
                let name = if touch == Touch::Struck { "struck" } else { "pressed" };
                let series = Series::builtin(nuance, touch)
                    .ok_or_else(|| Failure::Internal(format!("the built-in stroke {nuance} {name} cannot be read")))?;
                let text = Series::builtin_text(nuance, touch).unwrap_or_default();
                identity::used("stroke", &format!("{nuance}, {name}"), None, text.as_bytes());
                (series, format!("{nuance}, {name}"), PositionOf::Key, 0.2)
            }
        };
        let own = if position_of == PositionOf::Key { DriveName::Rigid } else { DriveName::Motion };
        let drive = self.drive.unwrap_or(if series.force.is_some() { DriveName::Force } else { own });
        let (missing, column) = match drive {
            DriveName::Force => (series.force.is_none(), "force_N"),
            DriveName::Motion | DriveName::Rigid => (series.position.is_none(), "position_m"),
        };
        if missing {
            return Err(Failure::Usage(format!(
                "{title}: --drive {} needs a column `{column}`, and the file has none",
                drive.name()
            )));
        }
        match (drive, position_of) {
            (DriveName::Motion, PositionOf::Key) if series.force.is_none() => notes.push(
                "no force was recorded, so that the fingertip's position is not known: the key's stands for it (--position fingertip if it is \
                 the fingertip's; --drive rigid plays the key's)"
                    .into(),
            ),
            (DriveName::Rigid, PositionOf::Fingertip) if series.force.is_none() => {
                return Err(Failure::Usage(format!(
                    "{title}: --drive rigid needs the key's position; the fingertip's gives it where a column `force_N` is there too"
                )));
            }
            _ => {}
        }
        for note in notes {
            tell!("{title}: {note}");
        }
        let duration_s = series.end_s() - series.start_s() + after;
        let start_s = series.start_s();
        let worked_out = Mutex::default();
        Ok(Stroke { title, drive, start_s, duration_s, series: Some(series), position_of, worked_out, force_n: 0.0 })
    }
}

impl Stroke {
    /// A constant force from the start on, N.
    fn constant(title: String, force_n: f64) -> Self {
        Stroke {
            title,
            drive: DriveName::Force,
            start_s: 0.0,
            duration_s: FORCE_STEP_DURATION_S,
            series: None,
            position_of: PositionOf::Key,
            worked_out: Mutex::default(),
            force_n,
        }
    }

    /// What drives the key of an instrument over time, s from the stroke's start: a fingertip is as soft as the instrument says.
    pub fn inputs(&self, instrument: &Instrument) -> Result<Box<dyn Fn(f64) -> Input + Send + '_>, Failure> {
        let wanted = match self.drive {
            DriveName::Force => {
                let force = self.series.as_ref().and_then(|s| s.force.as_ref()).map(ForceSeries::drive);
                return Ok(Box::new(move |t| Input::Force(force.as_ref().map_or(self.force_n, |force| force(t)))));
            }
            DriveName::Motion => PositionOf::Fingertip,
            DriveName::Rigid => PositionOf::Key,
        };
        let position = self.position(wanted, &instrument.finger)?.shared_drive();
        Ok(match self.drive {
            DriveName::Motion => Box::new(player::motion(position)),
            _ => Box::new(player::rigid(position)),
        })
    }

    /// The position of key or fingertip, worked out once for all strokes with the same finger; what was recorded where the other is not known.
    fn position(&self, wanted: PositionOf, finger: &Finger) -> Result<Arc<PositionSeries>, Failure> {
        let mut worked_out = self.worked_out.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, position)) = worked_out.as_ref().filter(|(of, _)| of == finger) {
            return Ok(Arc::clone(position));
        }
        let series = self.series.as_ref().ok_or_else(|| Failure::Internal("a motion without a stroke".into()))?;
        let other = series
            .position_of(wanted, self.position_of, finger)
            .map_err(|error| Failure::Usage(format!("{}: key and fingertip: {error}", self.title)))?;
        let position = other.or_else(|| series.position.clone());
        let position = Arc::new(position.ok_or_else(|| Failure::Internal("a stroke without a position".into()))?);
        *worked_out = Some((*finger, Arc::clone(&position)));
        Ok(position)
    }
}

/// How to step.
#[derive(Debug, Args)]
pub struct StepOptions {
    /// Step, s
    #[arg(long, value_name = "SECONDS", default_value_t = 50e-6, allow_negative_numbers = true)]
    dt: f64,
    /// Theta of the time-stepping scheme, 0.5 (second order) to 1 (damped)
    #[arg(long, value_name = "T", default_value_t = 0.5, allow_negative_numbers = true)]
    theta: f64,
    /// Solver of the one-step problem
    #[arg(long, value_enum, default_value_t = SolverName::ActiveSet)]
    solver: SolverName,
    /// Friction law: the true one, or the regularised one that is kept for comparison
    #[arg(long, value_enum, default_value_t = FrictionName::SetValued)]
    friction: FrictionName,
    /// Width of the regularised law at the pivots, rad/s (at sliding contacts a tenth of it, m/s)
    #[arg(long, value_name = "RAD/S", default_value_t = 0.1, allow_negative_numbers = true)]
    friction_width: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum SolverName {
    /// Active set on the velocities
    ActiveSet,
    /// The papers' projected Gauss-Seidel
    ProjectedGaussSeidel,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum FrictionName {
    /// Set-valued: holds at rest
    SetValued,
    /// Regularised by tanh: creeps
    Tanh,
}

/// Checks a setup whose numbers came from the command line, so that an error names the option.
pub fn check(setup: &Setup) -> Result<(), Failure> {
    let Err(error) = setup.check() else { return Ok(()) };
    let option = match error {
        SimulationError::Step { .. } => "--dt",
        SimulationError::Theta { .. } => "--theta",
        SimulationError::Tolerance { .. } => "--tolerance",
        SimulationError::Duration { .. } => "--duration",
        SimulationError::Rows { .. } => "--record-every",
        _ => return Err(error.into()),
    };
    Err(Failure::Usage(format!("{option}: {error}")))
}

impl StepOptions {
    /// The engine's settings.
    pub fn settings(&self) -> Result<Settings<f64>, Failure> {
        let width = self.friction_width;
        if !(width.is_finite() && width > 0.0) {
            return Err(Failure::Usage(format!("--friction-width {width}: expected a positive number of rad/s")));
        }
        Ok(Settings {
            theta: self.theta,
            solver: match self.solver {
                SolverName::ActiveSet => Solver::ActiveSet,
                SolverName::ProjectedGaussSeidel => Solver::ProjectedGaussSeidel,
            },
            friction: match self.friction {
                FrictionName::SetValued => FrictionLaw::SetValued,
                FrictionName::Tanh => FrictionLaw::Regularised { pivot_width: width, sliding_width: 0.1 * width },
            },
            ..Settings::new(self.dt)
        })
    }

    /// The solver's name in files and on the command line.
    pub fn solver_name(&self) -> &'static str {
        match self.solver {
            SolverName::ActiveSet => "active-set",
            SolverName::ProjectedGaussSeidel => "projected-gauss-seidel",
        }
    }
}

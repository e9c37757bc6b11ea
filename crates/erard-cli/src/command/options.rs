//! Options that several commands share.

use std::path::{Path, PathBuf};

use clap::{Args, ValueEnum};
use erard::instrument::{Instrument, utf8};
use erard::keyboard::{KEYS, Keyboard, is_keyboard};
use erard::one_dof;
use erard::player::{self, Input};
use erard::simulation::{Setup, SimulationError};
use erard::stroke::{ForceSeries, PositionSeries, Series, Touch};
use moreau::{FrictionLaw, Settings, Solver};

use crate::failure::Failure;
use crate::inputs;

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

/// One instrument, or two to be laid beside each other.
#[derive(Debug, Args)]
pub struct InstrumentsOption {
    /// Instrument: a TOML file, or the name of a built-in one; or a key of a keyboard, as in concert-grand:key=88. Given twice, both are
    /// played and shown on one page
    #[arg(long = "instrument", value_name = "FILE-OR-NAME", default_value = "concert-grand")]
    instruments: Vec<String>,
    /// Which model of it
    #[arg(long, value_enum, default_value_t = Model::Action)]
    pub model: Model,
}

impl InstrumentsOption {
    /// Loads the instrument, or both, reduced to the model that was asked for.
    pub fn load(&self) -> Result<Vec<Instrument>, Failure> {
        if self.instruments.len() > 2 {
            return Err(Failure::Usage(format!(
                "--instrument is given {} times; expected one instrument, or two to be laid beside each other",
                self.instruments.len()
            )));
        }
        let one = |name: &String| InstrumentOption { instrument: name.clone(), model: self.model }.load();
        self.instruments.iter().map(one).collect()
    }
}

/// An instrument by file or by name; after either, `:key=N` is key N of a keyboard.
pub fn load_instrument(asked: &str) -> Result<Instrument, Failure> {
    if let Some(one) = KeyboardKey::asked(asked)? {
        return Ok(one.keyboard.key(one.key)?);
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
    Ok((Instrument::parse(text, &name)?, text.to_owned()))
}

/// The same, with the text it was read from.
pub fn load_instrument_and_text(asked: &str) -> Result<(Instrument, String), Failure> {
    if let Some(one) = KeyboardKey::asked(asked)? {
        return Ok((one.keyboard.key(one.key)?, one.text()?));
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
    Instrument::builtin(name).ok().zip(Instrument::builtin_text(name)).ok_or_else(|| {
        let names: Vec<&str> = Instrument::builtin_names().collect();
        Failure::Usage(format!("there is no file and no built-in instrument `{name}` (built in: {})", names.join(", ")))
    })
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
        return Ok(keyboard);
    }
    Keyboard::builtin(file_or_name).ok_or_else(|| {
        let names: Vec<&str> = Keyboard::builtin_names().collect();
        let names = names.join(", ");
        Failure::Usage(format!("there is no file and no built-in keyboard `{file_or_name}` (built in: {names})"))
    })
}

/// What the player does.
#[derive(Debug, Args)]
pub struct StrokeOptions {
    /// Stroke file: CSV with a header, column `time_s` and `force_N` and/or `position_m` (down is positive)
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
    /// the stroke has one, else motion
    #[arg(long, value_enum)]
    drive: Option<DriveName>,
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
    force_n: f64,
}

impl StrokeOptions {
    /// The same touch and drive with another stroke: `pp` to `ff`, a constant force such as `3N`, or a file.
    pub fn with(&self, other: &str) -> Self {
        let force = other.strip_suffix('N').and_then(|number| number.trim_end().parse().ok());
        let is_builtin = ["pp", "p", "mf", "f", "ff"].contains(&other);
        StrokeOptions {
            file: (force.is_none() && !is_builtin).then(|| PathBuf::from(other)),
            stroke: is_builtin.then(|| other.to_owned()),
            touch: self.touch,
            force_step: force,
            drive: self.drive,
        }
    }

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
            if !(force_n.is_finite() && force_n.abs() <= erard::stroke::MAX_FORCE_N) {
                return Err(Failure::Usage(format!(
                    "--force-step {force_n}: expected a number of at most {} N",
                    erard::stroke::MAX_FORCE_N
                )));
            }
            if self.drive.is_some_and(|d| d != DriveName::Force) {
                return Err(Failure::Usage("--force-step prescribes a force; it has no motion to drive with".into()));
            }
            return Ok(Stroke::constant(format!("{force_n} N"), force_n));
        }
        let (series, title, after) = match &self.file {
            Some(path) => {
                let name = inputs::shown(path);
                (Series::read_opened(inputs::open(path), &name)?, name, AFTERWARDS_S)
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
                (series, format!("{nuance}, {name}"), 0.2)
            }
        };
        let drive = self.drive.unwrap_or(if series.force.is_some() { DriveName::Force } else { DriveName::Motion });
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
        let duration_s = series.end_s() - series.start_s() + after;
        Ok(Stroke { title, drive, start_s: series.start_s(), duration_s, series: Some(series), force_n: 0.0 })
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
            force_n,
        }
    }

    /// What drives the key over time, s from the stroke's start.
    pub fn inputs(&self) -> Box<dyn Fn(f64) -> Input + Send + '_> {
        let force = self.series.as_ref().and_then(|s| s.force.as_ref()).map(ForceSeries::drive);
        let position = self.series.as_ref().and_then(|s| s.position.as_ref()).map(PositionSeries::drive);
        match (self.drive, position) {
            (DriveName::Motion, Some(position)) => Box::new(player::motion(position)),
            (DriveName::Rigid, Some(position)) => Box::new(player::rigid(position)),
            _ => Box::new(move |t| Input::Force(force.as_ref().map_or(self.force_n, |force| force(t)))),
        }
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

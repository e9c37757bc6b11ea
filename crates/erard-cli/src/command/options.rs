//! Options that several commands share.

use std::path::{Path, PathBuf};

use clap::Args;
use erard::instrument::{Instrument, InstrumentFile};
use erard::instrument_spec::InstrumentSpec;
use erard::key::{self, key_named};
use erard::level::LevelError;
use erard::parameter::{Bare, Quantity, canonical_name};
use erard::player::RestKind;
use erard::run::{Setup, SimulationError};
pub(crate) use erard::stroke::Stroke;
use erard::stroke::{Columns, DrivingError, Prescribed, Series, constant_force_fault};
use erard_workshop::compare::{PathNoise, Which};
use erard_workshop::measure::norms::{Line, lines};
use erard_workshop::worklist::Priority;
use moreau::{FrictionLaw, Settings, Solver};

use super::hand::HandOptions;
use crate::failure::Failure;
use crate::instruments::{LoadedInstrument, load_file, load_instrument};
use crate::names::{Name, one_of};
use crate::number::number;
use crate::recordings::{Ready, RecordingOptions};
use crate::session::Session;
use crate::suggest::{german, near, quoted, what_it_is};
use crate::warn;
use erard_figures::drawing::ChangedNote;

/// A key by number or note.
pub(super) fn key(text: &str) -> Result<usize, String> {
    key_named(text).ok_or_else(|| {
        let meant = german(text).map_or_else(String::new, |note| format!("; the German {text} is {note} here"));
        format!("expected {}{meant}", key::EXPECTED)
    })
}

/// What stays where two lines cannot both come right.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum Stays {
    /// The dip; the blow changes.
    Dip,
    /// The aftertouch; the dip changes within its range, then the blow.
    Aftertouch,
}

impl From<Stays> for Priority {
    fn from(stays: Stays) -> Self {
        match stays {
            Stays::Dip => Priority::Dip,
            Stays::Aftertouch => Priority::Aftertouch,
        }
    }
}

/// How the action comes to rest before it is measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub(crate) enum RestBefore {
    /// Played once, a moderate blow, and released: what a technician reads
    AsPlayed,
    /// Settled from the angles in the instrument file, where `erard press` starts
    AsDrawn,
}

impl From<RestBefore> for RestKind {
    fn from(asked: RestBefore) -> Self {
        match asked {
            RestBefore::AsPlayed => RestKind::AsPlayed,
            RestBefore::AsDrawn => RestKind::AsDrawn,
        }
    }
}

/// Which instrument.
#[derive(Debug, Args)]
pub(crate) struct InstrumentOption {
    /// Instrument: a TOML file, a built-in name, or one key of a keyboard (concert-grand:key=88). `:sample=17` at the
    /// end takes a random grand within the spreads of the file
    #[arg(long, value_name = "FILE-OR-NAME", default_value = "concert-grand")]
    instrument: InstrumentSpec,
    /// Model of the instrument
    #[arg(long, value_parser = one_of(&MODELS), default_value = "action")]
    pub model: Which,
}

/// The models of an instrument.
pub(crate) const MODELS: [Name<Which>; 2] = [
    (Which::Action.name(), "All bodies and contact zones of the file", Which::Action),
    (
        Which::OneDof.name(),
        "One degree of freedom: the action reduced to an inertia and a constant moment on the key",
        Which::OneDof,
    ),
];

impl InstrumentOption {
    /// What was asked for.
    pub(crate) fn asked(&self) -> &InstrumentSpec {
        &self.instrument
    }

    /// Loads the instrument, reduced to the model that was asked for, with what its pictures mark as changed.
    pub(crate) fn load_with_notes(&self, session: &mut Session) -> Result<LoadedInstrument, Failure> {
        let Some(path) = self.instrument.path() else {
            let whole = load_instrument(session, &self.instrument)?;
            return Ok(LoadedInstrument { instrument: self.reduced(whole.clone())?, changed: Vec::new(), whole });
        };
        let InstrumentFile { instrument: whole, provenance, .. } = load_file(session, path)?.0;
        let instrument = self.reduced(whole.clone())?;
        let changed = ChangedNote::all(&instrument, &provenance.outlived_notes());
        Ok(LoadedInstrument { instrument, changed, whole })
    }

    /// A full instrument, reduced to the model that was asked for.
    pub(crate) fn reduced(&self, full: Instrument) -> Result<Instrument, Failure> {
        Ok(self.model.of(full)?)
    }
}

/// One instrument, or two to be laid beside each other.
#[derive(Debug, Args)]
pub(crate) struct InstrumentsOption {
    /// Instrument: a TOML file, a built-in name, or one key of a keyboard (concert-grand:key=88). Give it twice to show
    /// two instruments on one page
    #[arg(long = "instrument", value_name = "FILE-OR-NAME", default_value = "concert-grand")]
    instruments: Vec<InstrumentSpec>,
    /// Model of the instrument
    #[arg(long, value_parser = one_of(&MODELS), default_value = "action")]
    pub model: Which,
}

impl InstrumentsOption {
    /// The first that was asked for.
    pub(crate) fn first(&self) -> Option<&InstrumentSpec> {
        self.instruments.first()
    }

    /// Loads the instrument, or both, reduced to the model that was asked for.
    pub(crate) fn load(&self, session: &mut Session) -> Result<Vec<LoadedInstrument>, Failure> {
        if self.instruments.len() > 2 {
            return Err(Failure::Usage(format!(
                "--instrument is given {} times; expected once, or twice to compare two",
                self.instruments.len()
            )));
        }
        let one = |asked: &InstrumentSpec| {
            InstrumentOption { instrument: asked.clone(), model: self.model }.load_with_notes(session)
        };
        self.instruments.iter().map(one).collect()
    }
}

/// The lines of the protocol sheet by their keys in measure.json; `option` is who asks.
pub(crate) fn measured_lines(option: &str, keys: &[String]) -> Result<Vec<&'static Line>, Failure> {
    let find = |key: &String| {
        lines().find(|line| line.key == canonical_name(key)).ok_or_else(|| {
            let known: Vec<&str> = lines().map(|line| line.key).collect();
            let near = near(key, known.iter().copied());
            Failure::Usage(if near.is_empty() {
                format!("{option} {key}: unknown quantity; expected one of {}", known.join(", "))
            } else {
                format!(
                    "{option} {key}: unknown quantity; did you mean {}? The measure.json of `erard measure` has all",
                    quoted(&near)
                )
            })
        })
    };
    keys.iter().map(find).collect()
}

/// What the player does.
#[derive(Debug, Clone, Args)]
pub(crate) struct StrokeOptions {
    /// Stroke file, CSV or Parquet: a time column and a force or position column or both, with the unit in the title
    /// (`time_s`, `Force (gf)`, `Travel [mm]`). Down is positive. The run.csv of a run is a stroke file
    #[arg(value_name = "STROKE.csv", conflicts_with_all = ["stroke", "force_step"])]
    file: Option<PathBuf>,
    #[command(flatten)]
    hand: HandOptions,
    /// Constant force on the key front, N
    #[arg(long, value_name = "N", value_parser = number(Quantity::Force, "N"), allow_hyphen_values = true)]
    force_step: Option<f64>,
    /// What drives the key. Default: the force if the stroke has one; else `rigid` for a recorded key position and
    /// `motion` for a recorded fingertip position (see --position). With --stroke it plays the stored force curve of
    /// that level (see `erard list`) instead of a hand
    #[arg(long, value_parser = one_of(&DRIVES), conflicts_with = "hammer_speed")]
    drive: Option<Prescribed>,
    #[command(flatten)]
    recording: RecordingOptions,
    /// The option that gave the constant force, for messages
    #[arg(skip = "--force-step")]
    force_option: &'static str,
}

/// Refuses the name of something else in the place of a stroke file.
fn refuse_name(path: &Path) -> Result<(), Failure> {
    let name = path.to_string_lossy();
    match what_it_is(&name).filter(|_| !path.exists()) {
        Some(other) => Err(Failure::Usage(format!("{name}: there is no such stroke file; {other}"))),
        None => Ok(()),
    }
}

/// What is prescribed.
pub(crate) const DRIVES: [Name<Prescribed>; 3] = [
    (Prescribed::Force.name(), "Force on the key", Prescribed::Force),
    (Prescribed::Motion.name(), "Motion of a soft fingertip, which can only push", Prescribed::Motion),
    (Prescribed::Rigid.name(), "Motion of the key itself", Prescribed::Rigid),
];

impl StrokeOptions {
    /// The same touch and drive with another stroke: `pp` to `ff`, a constant force such as `3N`, or a file.
    /// Of a file, `columns` are the titles, where they are given.
    pub(crate) fn with(&self, other: &str, columns: Option<&Columns>) -> Self {
        // A number without a unit may be the name of a file.
        let force = Quantity::Force.read(other, Bare::Refused).ok();
        let is_builtin = ["pp", "p", "mf", "f", "ff"].contains(&other);
        let is_file = force.is_none() && !is_builtin;
        StrokeOptions {
            file: is_file.then(|| PathBuf::from(other)),
            hand: self.hand.with(is_builtin.then(|| other.to_owned())),
            force_step: force,
            drive: self.drive,
            // They are a file's.
            recording: if is_file { self.recording.with_columns(columns) } else { RecordingOptions::none() },
            force_option: "--against",
        }
    }

    /// The first of two strokes: what is said of recordings belongs to the other where that alone is a file.
    pub(crate) fn beside(&self, other: &Self) -> Self {
        let own = self.file.is_some() || other.file.is_none();
        let recording = if own { self.recording.clone() } else { RecordingOptions::none() };
        StrokeOptions { file: self.file.clone(), hand: self.hand.clone(), recording, ..*self }
    }

    /// Whether a constant force was asked for.
    pub(crate) fn is_constant(&self) -> bool {
        self.force_step.is_some()
    }

    /// A constant force, and nothing else.
    pub(crate) fn load_constant(&self) -> Result<Stroke, Failure> {
        let is_level = self.hand.stroke.is_some() || self.hand.hammer_speed.is_some();
        if self.file.is_some() || is_level || self.drive.is_some_and(|d| d != Prescribed::Force) {
            return Err(Failure::Usage(
                "--vary force plays constant forces; remove the stroke (file, --stroke or --hammer-speed)".into(),
            ));
        }
        self.through(Stroke::constant("constant forces".into(), 0.0))
    }

    /// Whether a hand plays a built-in touch.
    pub(crate) fn is_touch(&self) -> bool {
        self.file.is_none() && self.force_step.is_none() && self.drive.is_none()
    }

    /// The hand that plays the built-in touch on an instrument, before a progress of the caller's.
    pub(crate) fn touch_on(
        &self,
        instrument: &Instrument,
        progress: &mut erard::Progress<'_>,
    ) -> Result<Stroke, LevelError> {
        self.hand.touch_with(instrument, progress)
    }

    /// A stroke through the hand that was asked for.
    fn through(&self, stroke: Stroke) -> Result<Stroke, Failure> {
        Ok(match self.hand.between()? {
            Some(hand) => stroke.through(hand),
            None => stroke,
        })
    }

    /// Reads the stroke, or finds the hand whose level the reference has: the instrument that all are compared with.
    pub(crate) fn load(&self, session: &mut Session, reference: &Instrument) -> Result<Stroke, Failure> {
        self.load_with_noise(session, reference).map(|(stroke, _)| stroke)
    }

    /// The same with the noise of its recorded position, and until when the recording rests, s, where it has both.
    pub(crate) fn load_with_noise(
        &self,
        session: &mut Session,
        reference: &Instrument,
    ) -> Result<(Stroke, Option<(PathNoise, f64)>), Failure> {
        let mut noise = None;
        let stroke = self.loaded(session, reference, &mut noise)?;
        Ok((stroke, noise))
    }

    fn loaded(
        &self,
        session: &mut Session,
        reference: &Instrument,
        noise: &mut Option<(PathNoise, f64)>,
    ) -> Result<Stroke, Failure> {
        if let Some(file) = &self.file {
            self.hand.refuse_mass_as(file)?;
        }
        if let Some(force_n) = self.force_step {
            if let Some(fault) = constant_force_fault(force_n) {
                return Err(Failure::Usage(format!("{} {force_n}: {fault}", self.force_option)));
            }
            session.provenance.used_without_file("stroke", &format!("a constant force of {force_n} N"));
            if self.drive.is_some_and(|d| d != Prescribed::Force) {
                return Err(Failure::Usage(format!(
                    "{} {force_n} needs --drive force: a constant force has no motion. Leave --drive out, or give a stroke file with a position",
                    self.force_option
                )));
            }
            // A weight typed in grams has more digits than anybody reads.
            let shown_n = if force_n < 0.1 { force_n } else { (1e3 * force_n).round() / 1e3 };
            return self.through(Stroke::constant(format!("{shown_n} N"), force_n));
        }
        if self.file.is_none() && self.recording.are_given() {
            return Err(Failure::Usage(
                "--columns, --position, --zero, --invert, --delay, --low-pass and --order need a stroke file; none is given"
                    .into(),
            ));
        }
        if self.is_touch() {
            return self.hand.touch(session, reference);
        }
        // What was done and noticed, told when nothing is wrong.
        let mut notes = Vec::new();
        let (stroke, note) = match &self.file {
            Some(path) => {
                refuse_name(path)?;
                let Ready { name, prepared, position_of, .. } = self.recording.load(session, path)?;
                notes = prepared.report.told();
                session.provenance.prepared(&name, prepared.report.json());
                *noise = PathNoise::of(&prepared.report).zip(prepared.report.rest_until_s());
                Stroke::recorded(name, prepared.series, position_of, self.drive)
            }
            None => {
                let nuance = self.hand.stroke.as_deref().unwrap_or("mf");
                let touch = self.hand.touch;
                let (text, name) = (Series::builtin_text(nuance, touch).unwrap_or_default(), touch.name());
                session.provenance.used("stroke", &format!("{nuance}, {name}"), None, text.as_bytes());
                Stroke::curve(nuance, touch, self.drive)
                    .ok_or_else(|| Failure::Internal(format!("the force curve {nuance} {name} cannot be read")))?
            }
        }?;
        for note in notes.into_iter().chain(note.map(str::to_owned)) {
            warn!(session, "{}: {note}", stroke.title);
        }
        self.through(stroke)
    }
}

impl From<DrivingError> for Failure {
    fn from(error: DrivingError) -> Self {
        Failure::Usage(match error {
            DrivingError::Missing { title, drive } => {
                format!(
                    "{title}: --drive {} needs a column `{}`; the file has none. Leave --drive out, or name the column with --columns",
                    drive.name(),
                    drive.column()
                )
            }
            DrivingError::NoKeyPosition { title } => format!(
                "{title}: --drive rigid needs the key's position; found the fingertip's and no force. Use --drive motion, or add a column `force_N`"
            ),
            error => error.to_string(),
        })
    }
}

/// How to step.
#[derive(Debug, Args)]
pub(crate) struct StepOptions {
    /// Time step, s. `usual` is 0.00005, or 1/24000 with modal strings. While the hammer is near modal strings the step
    /// is halved as often as necessary
    #[arg(long, value_name = "SECONDS", default_value = USUAL, value_parser = step, allow_hyphen_values = true)]
    dt: Step,
    /// Theta of the time-stepping scheme, from 0.5 (second order) to 1 (damped)
    #[arg(long, value_name = "T", default_value_t = 0.5, value_parser = number(Quantity::Number, ""), allow_hyphen_values = true)]
    theta: f64,
    /// Solver of the one-step problem
    #[arg(long, value_parser = one_of(&SOLVERS), default_value = "active-set")]
    solver: Solver,
    /// Friction law
    #[arg(long, value_parser = one_of(&FRICTIONS), default_value = "set-valued")]
    friction: Friction,
    /// Width of the regularised law: this at pivots, rad/s, and a tenth of it at sliding contacts, m/s
    #[arg(long, value_name = "RAD/S", default_value_t = 0.1, value_parser = number(Quantity::AngularSpeed, "rad/s"), allow_hyphen_values = true)]
    friction_width: f64,
}

/// The word for an instrument's usual step.
const USUAL: &str = "usual";

/// A step, s; none: the instrument's usual one.
#[derive(Debug, Clone, Copy)]
struct Step(Option<f64>);

fn step(text: &str) -> Result<Step, String> {
    if text == USUAL {
        return Ok(Step(None));
    }
    let step_s = number(Quantity::Time, "s")(text);
    step_s.map(|step_s| Step(Some(step_s))).map_err(|error| format!("{error}; or `{USUAL}`"))
}

const SOLVERS: [Name<Solver>; 2] = [
    ("active-set", "Active set on the velocities", Solver::ActiveSet),
    ("projected-gauss-seidel", "Projected Gauss-Seidel, as in the papers", Solver::ProjectedGaussSeidel),
];

/// A law of friction, of the regularised one's width at the pivots, rad/s.
type Friction = fn(f64) -> FrictionLaw<f64>;

const FRICTIONS: [Name<Friction>; 2] = [
    ("set-valued", "Coulomb friction that holds parts at rest", |_| FrictionLaw::SetValued),
    ("tanh", "Regularised by tanh, for comparison: parts creep", |width| FrictionLaw::Regularised {
        pivot_width: width,
        sliding_width: 0.1 * width,
    }),
];

/// Checks a setup whose numbers came from the command line, so that an error names the option.
pub(crate) fn check(setup: &Setup) -> Result<(), Failure> {
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
    /// The engine's settings for an instrument.
    pub(crate) fn settings(&self, instrument: &Instrument) -> Result<Settings<f64>, Failure> {
        let width = self.friction_width;
        if !(width.is_finite() && width > 0.0) {
            return Err(Failure::Usage(format!("--friction-width {width}: expected a positive number of rad/s")));
        }
        Ok(Settings {
            theta: self.theta,
            solver: self.solver,
            friction: (self.friction)(width),
            ..Settings::new(self.dt.0.unwrap_or_else(|| instrument.usual_step_s()))
        })
    }

    /// The solver's name in files and on the command line.
    pub(crate) fn solver_name(&self) -> &'static str {
        SOLVERS.iter().find(|(_, _, solver)| *solver == self.solver).expect("one of them was taken").0
    }
}

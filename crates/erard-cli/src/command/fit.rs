//! `erard fit`.

use std::path::PathBuf;

use clap::Args;
use erard::instrument::{Instrument, InstrumentFile};
use erard::instrument_spec::InstrumentSpec;
use erard::parameter::{Bare, Quantity, canonical_name};
use erard::run::Setup;
use erard::stroke::{Prescribed, Recording, Role};
use erard_figures::figure::figure_picture;
use erard_workshop::cores;
use erard_workshop::fit::{
    Data, FitError, FitResult, Jacobian, Loss, MAX_EVALUATIONS, MAX_RESTARTS, NoiseModel, PerName, Plan, Problem,
    Simulator, fit_parameters,
};

use super::options::{DRIVES, StepOptions, check};
use super::out::OutOptions;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::fit::{bounds, column, figure, headlines, lines, report, table, value};
use crate::instruments::load_instrument_and_text;
use crate::names::{Name, one_of};
use crate::number::{number, whole};
use crate::print_line;
use crate::recordings::RecordingOptions;
use crate::session::Session;

/// Text below the options.
const AFTER: &str = include_str!("help/fit.txt");

/// Fits parameters of an instrument to recordings, with error bars, and names those that the recordings do not
/// determine.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Fit {
    /// Instrument at which the fit starts: a TOML file, or a built-in name
    #[arg(value_name = "INSTRUMENT")]
    instrument: InstrumentSpec,
    /// Recordings, CSV or Parquet: a time column, a force or position column or both, and the hammer if measured. Down
    /// is positive
    #[arg(value_name = "RECORDING.csv", required = true)]
    recordings: Vec<PathBuf>,
    /// Names of the screws and parameters to fit, with commas
    #[arg(long, value_name = "NAME,NAME,..", value_delimiter = ',', required = true)]
    parameters: Vec<String>,
    /// Bounds of a parameter: values (`body.hammer.mass=9g..12g`), changes with a sign (`let_off=-1mm..1mm`, from the
    /// screw's setting) or factors (`body.hammer.mass=x0.9..1.2`); a bare number is in mm, deg, g or N mm; can be
    /// repeated
    #[arg(long, value_name = "NAME=LOW..HIGH", allow_hyphen_values = true)]
    bounds: Vec<String>,
    /// Starting value of a parameter, e.g. `body.hammer.mass=10g` or `body.hammer.mass=x1.1`; a bare number is in mm,
    /// deg, g or N mm; can be repeated [default: the instrument as it is]
    #[arg(long, value_name = "NAME=VALUE", allow_hyphen_values = true)]
    start: Vec<String>,
    /// Channel that drives the model [default: force if there is one, else the recorded motion]
    #[arg(long, value_parser = one_of(&DRIVES))]
    drive: Option<Prescribed>,
    /// Channels to compare, of force, position, hammer, hammer_speed [default: all but the one that drives]
    #[arg(long, value_name = "CHANNEL,..", value_delimiter = ',', value_parser = channel)]
    compare: Vec<Role>,
    /// Noise of a channel, root mean square, e.g. force=0.02N,position=10um, or in N, m or m/s; also for the channel
    /// that drives [default: estimated from the recording's rest or spectrum]
    #[arg(long, value_name = "CHANNEL=NOISE,..", value_delimiter = ',', value_parser = noise)]
    sigma: Vec<(Role, f64)>,
    /// Estimate the delay of each channel behind the one that drives
    #[arg(long)]
    delays: bool,
    /// Loss function of the residuals. All but `linear` give outliers less weight
    #[arg(long, value_parser = one_of(&LOSSES), default_value = "linear")]
    loss: Loss,
    /// How derivatives of the last iterations and of the error bars are computed
    #[arg(long, value_parser = one_of(&JACOBIANS), default_value = "differences")]
    jacobian: Jacobian,
    /// Largest number of further starts
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = whole::<u16>(0, MAX_RESTARTS.into()))]
    restarts: u16,
    /// Largest number of evaluations from one start
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = whole::<u16>(1, MAX_EVALUATIONS.into()))]
    max_evaluations: u16,
    /// Fit only the first S seconds of every recording. Do not go much beyond the impact: there a tiny change of a
    /// parameter moves the check by milliseconds, and error bars become too small
    #[arg(long, value_name = "S", value_parser = number(Quantity::Time, "s"), allow_hyphen_values = true)]
    duration: Option<f64>,
    /// Write numbers only, no figures
    #[arg(long)]
    no_pictures: bool,
    #[command(flatten)]
    recording: RecordingOptions,
    #[command(flatten)]
    step: StepOptions,
    #[command(flatten)]
    out: OutOptions,
}

const LOSSES: [Name<Loss>; 4] = [
    ("linear", "Square of the residual", Loss::Linear),
    ("soft_l1", "2 (sqrt(1 + z) - 1), where z is the square", Loss::SoftL1),
    ("huber", "Square up to the noise, linear beyond", Loss::Huber),
    ("cauchy", "ln(1 + z), where z is the square", Loss::Cauchy),
];

const JACOBIANS: [Name<Jacobian>; 2] = [
    ("differences", "Central differences", Jacobian::Differences),
    ("gradient", "The model's own derivatives: no step size, but slower", Jacobian::Gradient),
];

fn channel(text: &str) -> Result<Role, String> {
    let known = [Role::Force, Role::Position, Role::HammerHead, Role::HammerSpeed];
    let role = known.into_iter().find(|role| role.name() == text.trim());
    role.ok_or_else(|| "expected force, position, hammer or hammer_speed".to_owned())
}

fn noise(text: &str) -> Result<(Role, f64), String> {
    let expected = || {
        "expected a channel and its noise, as in force=0.02N, position=10um, hammer=0.05mm or hammer_speed=20mm/s"
            .to_owned()
    };
    let (name, size) = text.split_once('=').ok_or_else(expected)?;
    let role = channel(name)?;
    let noise = role.quantity().read(size, Bare::Si).map_err(|error| format!("{error}; {}", expected()))?;
    if noise < 0.0 {
        return Err(expected());
    }
    Ok((role, noise))
}

impl Fit {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let (instrument, text) = load_instrument_and_text(session, &self.instrument)?;
        let settings = self.step.settings(&instrument)?;
        check(&Setup { settings, ..Setup::new(1.0) })?;
        let file = InstrumentFile::parse(&text, &self.instrument.to_string())?;
        let vary: Vec<String> = self.parameters.iter().map(|name| canonical_name(name)).collect();
        let bounds = self.bounds(&instrument)?;
        let parameters = fit_parameters(&file, &vary, &bounds).map_err(failure)?;
        let start = self.start(&instrument)?;
        let data = self.data(session, settings)?;
        let sigma: PerName<f64> = self.sigma.iter().map(|(role, sigma)| (column(*role).to_owned(), *sigma)).collect();
        let problem = Problem::new(&instrument, parameters, data, self.delays).map_err(failure)?;
        let noise = NoiseModel::new(&problem, &sigma).map_err(failure)?;
        let plan = Plan {
            start,
            loss: self.loss,
            jacobian: self.jacobian,
            restarts: self.restarts.into(),
            max_evaluations: self.max_evaluations.into(),
        };
        let mut names = vec!["fit.json", "fitted.toml", "fit.csv"];
        if !self.no_pictures {
            names.extend(["fit.svg", "fit.png"]);
        }
        let mut output = self.out.prepare(session, "fit", &names)?;
        let mut progress = session.counting_progress("fitting");
        let counted = Box::new(move |strokes| progress.counted(|| format!("fitting: {strokes} strokes")));
        let mut simulator = Simulator::new(&problem, cores::count(), counted);
        let found = erard_workshop::fit::fit(&mut simulator, &noise, &plan).map_err(failure)?;
        let channels = simulator.curves(&found.noise, &found.point).map_err(failure)?;
        // Ends the progress bar.
        drop(simulator);

        let recordings: Vec<&str> = problem.recordings().iter().map(|one| one.name.as_str()).collect();
        let fitted = found.rewrite(&text, &recordings).map_err(|error| Failure::Internal(error.to_string()))?;
        let report = report(&found, &problem, &instrument.name);
        output.json(session, "fit.json", &report)?;
        output.text(session, "fitted.toml", &fitted)?;
        output.table(session, "fit.csv", &table(&channels, problem.recordings().len()))?;
        if !self.no_pictures {
            let picture = figure_picture(&figure(&channels, &recordings, &instrument.name));
            output.figure(session, "fit", &picture)?;
        }
        let written = output.commit(session)?;

        let answer = Answer::of(&report)?;
        print_line!(session, "{} fitted to {}", instrument.name, recordings.join(", "));
        let adds = "the start and the bounds of each parameter, what the numbers mean, correlations and residuals";
        answer.begin(session, |_| headlines(&found), adds);
        for line in lines(&found, &problem) {
            print_line!(session, "{line}");
        }
        print_line!(session);
        Ok(answer.end(session, &written).short_of(doubtful(&found)))
    }

    /// What was recorded, ready to be fitted.
    fn data(&self, session: &mut Session, settings: moreau::Settings<f64>) -> Result<Vec<Data>, Failure> {
        let preparation = self.recording.preparation();
        let how = Setup { settings, ..Setup::new(1.0) };
        let columns: Vec<String> = self.compare.iter().map(|role| column(*role).to_owned()).collect();
        let columns = (!columns.is_empty()).then_some(columns);
        let drive = self.drive;
        let mut all = Vec::new();
        for path in &self.recordings {
            let (name, mut recording, position_of) = self.recording.read(session, path)?;
            self.truncate(&mut recording)?;
            let data = Data::new(&name, &recording, position_of, &preparation, drive, columns.as_deref(), &how);
            let data = data.map_err(failure)?;
            if let Some(why) = data.cannot_begin() {
                return Err(Failure::Usage(format!("{name}: {why}")));
            }
            all.push(data);
        }
        Ok(all)
    }

    /// Shortens a recording to the requested duration.
    fn truncate(&self, recording: &mut Recording) -> Result<(), Failure> {
        let Some(s) = self.duration else { return Ok(()) };
        let rows = recording.time_s.partition_point(|t| *t <= recording.time_s[0] + s);
        if !s.is_finite() || rows < 2 {
            return Err(Failure::Usage(format!(
                "--duration {s}: shorter than two rows of the recording; expected a longer time"
            )));
        }
        recording.time_s.truncate(rows);
        recording.channels.iter_mut().for_each(|channel| channel.values.truncate(rows));
        // A channel that comes in later has nothing left.
        recording.channels.retain(|channel| channel.values.iter().filter(|value| !value.is_nan()).count() > 1);
        Ok(())
    }

    fn bounds(&self, instrument: &Instrument) -> Result<PerName<[f64; 2]>, Failure> {
        let one = |given: &String| {
            let expected =
                "expected a name and two increasing numbers, as in `let_off=-1mm..1mm` or `body.hammer.mass=x0.9..1.2`";
            let wrong = || Failure::Usage(format!("--bounds {given}: {expected}"));
            let (name, range) = given.split_once('=').ok_or_else(wrong)?;
            let ends = bounds(instrument, name, range);
            let ends = ends.map_err(|why| Failure::Usage(format!("--bounds {given}: {why}")))?;
            Ok((canonical_name(name), ends))
        };
        self.named_once("--bounds", self.bounds.iter().map(one).collect::<Result<_, Failure>>()?)
    }

    fn start(&self, instrument: &Instrument) -> Result<PerName<f64>, Failure> {
        let one = |given: &String| {
            let wrong = || {
                Failure::Usage(format!("--start {given}: expected a name and a number, as in `body.hammer.mass=x1.1`"))
            };
            let (name, number) = given.split_once('=').ok_or_else(wrong)?;
            let number =
                value(instrument, name, number).map_err(|why| Failure::Usage(format!("--start {given}: {why}")))?;
            Ok((canonical_name(name), number))
        };
        self.named_once("--start", self.start.iter().map(one).collect::<Result<_, Failure>>()?)
    }

    fn named_once<T>(&self, option: &str, all: PerName<T>) -> Result<PerName<T>, Failure> {
        match (1..all.len()).find(|at| all[..*at].iter().any(|(name, _)| *name == all[*at].0)) {
            Some(at) => Err(Failure::Usage(format!("{option}: `{}` is given twice", all[at].0))),
            None => Ok(all),
        }
    }
}

/// Nothing, or that there are doubts, with their kinds.
fn doubtful(found: &FitResult) -> Option<String> {
    let mut kinds: Vec<&str> = found.doubts.iter().map(|doubt| doubt.kind.name()).collect();
    kinds.dedup();
    match found.doubts.len() {
        0 => None,
        1 => Some(format!("the fit is doubtful ({}); all files were written", kinds[0])),
        n => Some(format!("the fit is doubtful for {n} reasons ({}); all files were written", kinds.join(", "))),
    }
}

/// What is wrong with what was asked for names the option.
fn failure(error: FitError) -> Failure {
    match error {
        FitError::Argument { argument, message } => {
            let option = match argument {
                "columns" => "compare",
                other => other,
            };
            Failure::Usage(format!("--{option}: {message}"))
        }
        FitError::Simulation(error) => error.into(),
        error => Failure::Usage(error.to_string()),
    }
}

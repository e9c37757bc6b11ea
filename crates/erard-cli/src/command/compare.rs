//! `erard compare`.

use std::borrow::Cow;
use std::path::PathBuf;

use clap::Args;
use erard::instrument_spec::InstrumentSpec;
use erard::parameter::Quantity;
use erard::run::Setup;
use erard::stroke::{Prescribed, Series};
use erard_workshop::compare::{Choice, Comparison, DRIVES, MAX_DURATION_S, Which, compare_chosen, way_up_ends_s};

use super::options::{self, MODELS, StepOptions, check};
use super::out::OutOptions;
use crate::answer::Answer;
use crate::compare::{headlines, print_table, report};
use crate::failure::Failure;
use crate::inputs::shown;
use crate::instruments::load_instrument;
use crate::names::one_of;
use crate::number::number;
use crate::print_line;
use crate::recordings::{Ready, RecordingOptions};
use crate::session::Session;
use crate::table::Table;
use erard_figures::figure::{Dash, Figure, Panel, Trace, Window, figure_picture};

/// Compares a recording with the models: one run for each drive and model, and its errors.
#[derive(Debug, Args)]
pub(crate) struct Compare {
    /// Recording, CSV or Parquet: a time column, a force or position column or both, and the hammer if measured, with
    /// the unit in the title (`time_s`, `Force (gf)`, `Travel [mm]`, `hammer_rise_m`). Down is positive
    #[arg(value_name = "MEASURED.csv")]
    file: PathBuf,
    #[command(flatten)]
    recording: RecordingOptions,
    /// Drives to try [default: all that the recording allows]
    #[arg(long, value_parser = one_of(&options::DRIVES), value_name = "DRIVES", value_delimiter = ',')]
    drive: Vec<Prescribed>,
    /// Models to run [default: both]
    #[arg(long, value_parser = one_of(&MODELS), value_name = "MODELS", value_delimiter = ',')]
    model: Vec<Which>,
    /// Write numbers only, no figures
    #[arg(long)]
    no_pictures: bool,
    /// Instrument: a TOML file, or a built-in name
    #[arg(long, value_name = "FILE-OR-NAME", default_value = "concert-grand")]
    instrument: InstrumentSpec,
    #[command(flatten)]
    step: StepOptions,
    /// Compare only the first S seconds
    #[arg(long, value_name = "S", value_parser = number(Quantity::Time, "s"), allow_hyphen_values = true)]
    duration: Option<f64>,
    /// Compare only until the hammer is highest, or, if the hammer was not recorded, until the key is down
    #[arg(long)]
    way_up: bool,
    #[command(flatten)]
    out: OutOptions,
}

impl Compare {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let Ready { name: title, prepared, position_of, .. } = self.recording.load(session, &self.file)?;
        let series = self.begun(prepared.series)?;
        let instrument = load_instrument(session, &self.instrument)?;
        let settings = self.step.settings(&instrument)?;
        let setup = Setup { settings, ..Setup::new(1.0) };
        check(&setup)?;
        let choice = Choice { position_of, ..self.choice() }.limited_by(&prepared.report);
        let mut names = vec!["compare.csv", "compare.json"];
        if !self.no_pictures {
            names.extend(["compare.svg", "compare.png"]);
        }
        let mut output = self.out.prepare(session, "compare", &names)?;
        let mut progress = session.progress("comparing");
        let comparison = compare_chosen(&instrument, &series, &choice, &setup, &mut |share| progress.tell(share))?;
        drop(progress);

        output.table(session, "compare.csv", &table(&comparison))?;
        let report = report(&comparison, &prepared.report, &title, &instrument.name);
        output.json(session, "compare.json", &report)?;
        if !self.no_pictures {
            let picture = figure_picture(&figure(&comparison, &title, &instrument.name));
            output.figure(session, "compare", &picture)?;
        }
        let written = output.commit(session)?;

        print_line!(session, "{title} compared with {}", instrument.name);
        let answer = Answer::of(&report)?;
        let adds = "errors by frequency, and how the recording was prepared";
        answer.begin(session, |answer| headlines(&comparison, answer), adds);
        let (verdicts, rests) = (comparison.verdicts(), comparison.rests());
        for line in verdicts.iter().chain(&comparison.force_uncertainties()).chain(&rests).chain(&comparison.notes) {
            print_line!(session, "{line}");
        }
        for warning in comparison.warnings() {
            print_line!(session, "warning: {warning}");
        }
        print_line!(session);
        print_table(session, &comparison);
        print_line!(session, "  how the recording was prepared");
        for line in prepared.report.told() {
            print_line!(session, "  {line}");
        }
        print_line!(session);
        Ok(answer.end(session, &written))
    }

    /// Drives and models that were asked for.
    fn choice(&self) -> Choice {
        let mut choice = Choice::default();
        if !self.drive.is_empty() {
            choice.drives.retain(|driven| self.drive.contains(driven));
        }
        if !self.model.is_empty() {
            choice.models.retain(|which| self.model.contains(which));
        }
        choice
    }
}

impl Compare {
    /// As much of a series as was asked for, and can be compared.
    fn begun(&self, series: Series) -> Result<Series, Failure> {
        let lasts_s = series.end_s() - series.start_s();
        let series = match self.duration {
            None => series,
            Some(s) if s > 0.0 && s.is_finite() => {
                series.first(s).map_err(|error| Failure::Usage(format!("--duration {s}: {error}")))?
            }
            Some(s) => return Err(Failure::Usage(format!("--duration {s}: expected a positive number of seconds"))),
        };
        let series = if self.way_up { self.way_up(&series)? } else { series };
        if series.end_s() - series.start_s() > MAX_DURATION_S {
            return Err(Failure::Usage(format!(
                "{}: lasts {lasts_s} s; expected at most {MAX_DURATION_S} s. Compare its beginning with --duration {MAX_DURATION_S}",
                shown(&self.file)
            )));
        }
        Ok(series)
    }

    /// As much of it as is the way up.
    fn way_up(&self, series: &Series) -> Result<Series, Failure> {
        let refused = |why: &str| Failure::Usage(format!("--way-up: {}: {why}", shown(&self.file)));
        let end_s = way_up_ends_s(series)
            .ok_or_else(|| refused("the hammer and the key do not move; --way-up needs a stroke with motion"))?;
        series.first(end_s - series.start_s()).map_err(|error| refused(&error.to_string()))
    }
}

fn table(c: &Comparison) -> Table<'_> {
    let measured = [
        ("measured_force_N", &c.measured_force_n),
        ("measured_position_m", &c.measured_position_m),
        ("measured_hammer_rise_m", &c.measured_hammer_rise_m),
    ];
    let mut table = Table::default().numbers("time_s", &c.time_s);
    for (name, values) in measured {
        table = if let Some(values) = values { table.numbers(name, values) } else { table };
    }
    for t in &c.trials {
        let stem = format!("{}_{}", t.driven.name(), t.which.name().replace('-', "_"));
        table = table.numbers(format!("{stem}_force_N"), &t.force_n).numbers(format!("{stem}_key_m"), &t.key_m);
        if !t.hammer_rise_m.is_empty() {
            table = table.numbers(format!("{stem}_hammer_rise_m"), &t.hammer_rise_m);
        }
    }
    table
}

/// Part of a simulated curve's values, at each end of their range, that may leave the frame: a spike sets no axis.
const SPIKES: f64 = 0.01;

/// The range of what was measured, and of what was simulated but for its spikes, and half as much again on both sides.
fn widened(simulated: Option<&Trace>, measured: Option<&Trace>) -> Option<(f64, f64)> {
    let simulated = simulated.map(|curve| {
        let mut sorted: Vec<f64> = curve.y.to_vec();
        sorted.sort_unstable_by(f64::total_cmp);
        let cut = (SPIKES * sorted.len() as f64) as usize;
        (sorted[cut], sorted[sorted.len() - 1 - cut])
    });
    let measured = measured.map(|curve| {
        let end = |first: f64, pick: fn(f64, f64) -> f64| curve.y.iter().copied().fold(first, pick);
        (end(f64::INFINITY, f64::min), end(f64::NEG_INFINITY, f64::max))
    });
    let (low, high) = simulated.into_iter().chain(measured).reduce(|(a, b), (c, d)| (a.min(c), b.max(d)))?;
    let margin = (0.5 * (high - low)).max(1e-6);
    Some((low - margin, high + margin))
}

/// The action in orange, one degree of freedom in blue dashes, and dotted in black over them what was measured, so that
/// all of it is seen.
fn figure<'a>(c: &'a Comparison, title: &str, instrument: &str) -> Figure<'a> {
    let curve = |label: &str, y: Cow<'a, [f64]>, colour, dash| Trace::new(label, &c.time_s, y, colour, dash);
    let in_mm = |y: &[f64]| Cow::Owned(y.iter().map(|y| y * 1e3).collect::<Vec<f64>>());
    let mut panels = Vec::new();
    for driven in DRIVES {
        let (action, one_dof) = (c.trial(driven, Which::Action), c.trial(driven, Which::OneDof));
        if action.is_none() && one_dof.is_none() {
            continue;
        }
        let (quantity, unit) = if driven == Prescribed::Force { ("position", "mm") } else { ("force", "N") };
        let quantity = format!("{quantity}, {}", driven.driven());
        let shown = |y: &'a [f64]| if driven == Prescribed::Force { in_mm(y) } else { Cow::Borrowed(y) };
        let measured = c.measured(driven).map(|y| shown(y));
        let measured = measured.map(|measured| curve("measured", measured, 6, Dash::Dotted));
        let action = action.map(|trial| curve("action", shown(trial.simulated()), 1, Dash::Solid));
        let one_dof = one_dof.map(|trial| curve("one degree of freedom", shown(trial.simulated()), 0, Dash::Dashed));
        // Where the simple model is far off it may leave the frame, so that the others can be read.
        let range = widened(action.as_ref(), measured.as_ref());
        let curves = one_dof.into_iter().chain(action).chain(measured).collect();
        panels.push(Panel { y_range: range, ..Panel::new(quantity, unit, 260.0, curves) });
    }
    if let Some(measured) = &c.measured_hammer_rise_m {
        let mut curves = Vec::new();
        for (n, trial) in c.trials.iter().filter(|t| !t.hammer_rise_m.is_empty()).enumerate() {
            curves.push(curve(
                &format!("action, {}", trial.driven.driven()),
                in_mm(&trial.hammer_rise_m),
                1 + n,
                Dash::Solid,
            ));
        }
        curves.push(curve("measured", in_mm(measured), 6, Dash::Dotted));
        panels.push(Panel::new("hammer", "mm", 260.0, curves));
    }
    let window = Window::whole(c.time_s[0], c.time_s[c.time_s.len() - 1]);
    Figure::over_time(title.into(), format!("beside {instrument}"), vec![window], panels)
}

//! `erard study`.

use clap::Args;
use erard::instrument::Instrument;
use erard::player::Input;
use erard::simulation::Setup;
use erard_workshop::study::{Job, JobResult, Stroke as JobStroke, Workers, play_all};

use super::options::{InstrumentOption, StepOptions, Stroke, StrokeOptions, check};
use super::out::OutOptions;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::progress::Progress;
use crate::report::chart_svg;
use crate::say;
use crate::study::{Axis, Row, Target, chart, columns, lines};
use crate::table;
use erard_figures::figure::png_from_svg;

/// What stands below the options.
const AFTER: &str = "\
Screws are turned from where the file has them (mm, degrees or N mm); `body.hammer.mass`, `body.key.friction`,
`spring.repetition.torque`, `zone.string.stiffness`, `zone.check.damping` and `zone.check.friction` are multiplied by the values;
`force` is a constant force from the start on. A name that does not exist is answered with all that do. Of several --vary
every combination is played, the last one fastest.

Strokes that are alike but for numbers are simulated side by side in the lanes of the processor's vectors, and on all its
cores; each comes out as `press` would compute it. Writes study.csv and study.parquet (what was varied, then instants in
s, the hammer's speed in m/s, and whether the stroke failed), and study.svg and study.png where there are at most six curves.";

/// Plays a stroke on many variants of an instrument: a parameter study.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub struct Study {
    /// What is varied, from where to where and in how many values, or values with commas; may be repeated
    #[arg(long, value_name = "NAME=FROM..TO:COUNT", required = true, allow_hyphen_values = true)]
    vary: Vec<String>,
    #[command(flatten)]
    stroke: StrokeOptions,
    #[command(flatten)]
    instrument: InstrumentOption,
    #[command(flatten)]
    step: StepOptions,
    /// Simulated time of every stroke, s [default: the stroke's, and a little more]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Compute in single precision: twice as many strokes side by side, hammer speeds right to some 1e-4
    #[arg(long)]
    single: bool,
    #[command(flatten)]
    out: OutOptions,
}

/// Most strokes: their rows are held in memory.
const MOST: usize = 2_000_000;
/// Strokes that are played at a time: their instruments are held in memory.
const PORTION: usize = 4096;
/// Rows of the printed table.
const SHOWN: usize = 15;

impl Study {
    /// Runs the command.
    pub fn run(&self) -> Result<(), Failure> {
        let settings = self.step.settings()?;
        let instrument = self.instrument.load()?;
        let axes = self.axes(&instrument)?;
        let forces = axes.iter().any(|axis| axis.target == Target::Force);
        let stroke = if forces { self.stroke.load_constant()? } else { self.stroke.load()? };
        let duration_s = self.duration.unwrap_or(stroke.duration_s);
        let setup =
            Setup { settings, start_s: stroke.start_s, duration_s, record_every: None, tolerance: None, ledger: true };
        check(&setup)?;
        let mut output = self.out.prepare("study", &["study.csv", "study.parquet"])?;
        let workers = if self.single { Workers::all_single() } else { Workers::all() };
        let rows = play(&instrument, &axes, &stroke, &setup, workers)?;

        let columns = columns(&axes, &rows);
        output.stage("study.csv", |w| table::write_optional_csv(&columns, w))?;
        output.stage("study.parquet", |w| table::write_optional_parquet("study", &columns, w))?;
        let mut written = vec!["study.csv", "study.parquet"];
        let title = format!("{} - {} ({} driven)", instrument.name, stroke.title, stroke.drive.name());
        if let Some(chart) = chart(&title, &axes, &rows) {
            let svg = chart_svg(&chart, "study");
            let png = png_from_svg(&svg, 2.0).map_err(|error| Failure::Internal(error.to_string()))?;
            output.stage("study.svg", |w| w.write_all(svg.as_bytes()))?;
            output.stage("study.png", |w| w.write_all(&png))?;
            written.extend(["study.svg", "study.png"]);
        }
        output.commit()?;

        say!("{title}");
        say!();
        for line in lines(&axes, &rows, SHOWN) {
            say!("{line}");
        }
        let failed = rows.iter().filter(|row| row.outcome.is_err()).count();
        say!();
        say!("{} strokes; {failed} failed", rows.len());
        say!("Written to {}: {}", shown(self.out.folder()), written.join(", "));
        Ok(())
    }

    fn axes(&self, instrument: &Instrument) -> Result<Vec<Axis>, Failure> {
        let axes: Vec<Axis> = self
            .vary
            .iter()
            .map(|text| Axis::parse(text, instrument))
            .collect::<Result<_, _>>()
            .map_err(Failure::Usage)?;
        for (i, axis) in axes.iter().enumerate() {
            if axes[..i].iter().any(|other| other.name == axis.name) {
                return Err(Failure::Usage(format!("`{}` is varied twice", axis.name)));
            }
        }
        let strokes = axes.iter().try_fold(1_usize, |product, axis| product.checked_mul(axis.shown.len()));
        if strokes.is_none_or(|strokes| strokes > MOST) {
            return Err(Failure::Usage(format!("more than {MOST} strokes; give fewer values")));
        }
        Ok(axes)
    }
}

/// Plays every combination, in portions.
fn play(
    instrument: &Instrument,
    axes: &[Axis],
    stroke: &Stroke,
    setup: &Setup,
    workers: Workers,
) -> Result<Vec<Row>, Failure> {
    let count: usize = axes.iter().map(|axis| axis.shown.len()).product();
    let mut progress = Progress::new("playing");
    let mut rows = Vec::with_capacity(count);
    while rows.len() < count {
        let from = rows.len();
        let portion: Vec<Vec<usize>> = (from..count.min(from + PORTION)).map(|k| combination(axes, k)).collect();
        let outcomes = play_portion(instrument, axes, &portion, stroke, setup, workers, &mut |share| {
            progress.tell((from as f64 + share * portion.len() as f64) / count as f64)
        })?;
        rows.extend(portion.iter().zip(outcomes).map(|(indices, outcome)| Row {
            values: axes.iter().zip(indices).map(|(axis, &i)| axis.shown[i]).collect(),
            outcome,
        }));
    }
    Ok(rows)
}

/// The index of each axis' value in the k-th combination, the last axis fastest.
fn combination(axes: &[Axis], mut k: usize) -> Vec<usize> {
    let mut indices: Vec<usize> = axes
        .iter()
        .rev()
        .map(|axis| {
            let index = k % axis.shown.len();
            k /= axis.shown.len();
            index
        })
        .collect();
    indices.reverse();
    indices
}

fn play_portion(
    instrument: &Instrument,
    axes: &[Axis],
    portion: &[Vec<usize>],
    stroke: &Stroke,
    setup: &Setup,
    workers: Workers,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Vec<Result<erard_workshop::study::Played, String>>, Failure> {
    // Outlines are for drawings.
    let plain = Instrument { parts: Vec::new(), ..instrument.clone() };
    let mut instruments: Vec<Instrument> = Vec::new();
    let mut varied: Vec<Vec<usize>> = Vec::new();
    // Where each stroke's job is, or what cannot be varied so.
    let mut places = Vec::with_capacity(portion.len());
    let mut jobs = Vec::with_capacity(portion.len());
    for indices in portion {
        let mut force_n = None;
        let mut own = Vec::new();
        for (axis, &index) in axes.iter().zip(indices) {
            match axis.target {
                Target::Force => force_n = Some(axis.si(index)),
                Target::Parameter(_) => own.push(index),
            }
        }
        // Strokes on the same variant share it.
        if varied.last() != Some(&own) {
            match variant(&plain, axes, indices) {
                Ok(instrument) => instruments.push(instrument),
                Err(why) => {
                    places.push(Err(why));
                    continue;
                }
            }
            varied.push(own);
        }
        places.push(Ok(jobs.len()));
        jobs.push(Job { instrument: instruments.len() - 1, stroke: job_stroke(stroke, force_n, instrument)? });
    }
    let mut results: Vec<Option<JobResult>> =
        play_all(&instruments, jobs, setup, workers, progress)?.into_iter().map(Some).collect();
    let outcome = |place: Result<usize, String>| {
        let result = results[place?].take();
        result.ok_or_else(|| "no result".to_owned())?.map_err(|error| error.to_string())
    };
    Ok(places.into_iter().map(outcome).collect())
}

/// The instrument with one combination of values.
fn variant(instrument: &Instrument, axes: &[Axis], indices: &[usize]) -> Result<Instrument, String> {
    let mut varied = instrument.clone();
    for (axis, &index) in axes.iter().zip(indices) {
        if let Target::Parameter(parameter) = &axis.target
            && !parameter.vary(&mut varied, axis.si(index))
        {
            return Err(format!("{} cannot be varied by {} {}", axis.name, axis.shown[index], axis.unit));
        }
    }
    Ok(varied)
}

fn job_stroke<'a>(stroke: &'a Stroke, force_n: Option<f64>, instrument: &Instrument) -> Result<JobStroke<'a>, Failure> {
    match force_n {
        Some(force_n) => Ok(Box::new(move |_| Input::Force(force_n))),
        None => stroke.inputs(instrument),
    }
}

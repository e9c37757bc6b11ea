//! `erard press`.

use std::time::Instant;

use clap::Args;
use erard::instrument::Instrument;
use erard::run::Run;
use erard::simulation::{Setup, simulate};

use super::options::{InstrumentOption, StepOptions, Stroke, StrokeOptions, check};
use super::out::OutOptions;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::progress::Progress;
use crate::say;
use crate::summary::Summary;
use crate::table;
use erard_figures::figure::{png_from_svg, run_svg};
use erard_figures::page::page_html;

/// Simulates one key press and shows what happened.
#[derive(Debug, Args)]
pub struct Press {
    #[command(flatten)]
    stroke: StrokeOptions,
    #[command(flatten)]
    instrument: InstrumentOption,
    #[command(flatten)]
    step: StepOptions,
    /// Simulated time, s [default: the stroke's, and a little more]
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<f64>,
    /// Keep a row every so many steps [default: every step, in long runs fewer]
    #[arg(long, value_name = "STEPS", value_parser = steps, allow_negative_numbers = true)]
    record_every: Option<u64>,
    /// Control the error: steps between two rows are as long as the error of each may be, relative to 1 rad/s + |velocity|, 1e-9 to 0.1
    /// [default: all steps are as long as --dt says]
    #[arg(long, value_name = "ERROR", allow_negative_numbers = true)]
    tolerance: Option<f64>,
    #[command(flatten)]
    out: OutOptions,
}

/// A number of steps.
fn steps(text: &str) -> Result<u64, String> {
    text.parse().ok().filter(|steps| *steps > 0).ok_or_else(|| "expected a whole number of steps, from 1".to_owned())
}

impl Press {
    /// Runs the command.
    pub fn run(&self) -> Result<(), Failure> {
        let settings = self.step.settings()?;
        let stroke = self.stroke.load()?;
        let instrument = self.instrument.load()?;
        let setup = Setup {
            settings,
            start_s: stroke.start_s,
            duration_s: self.duration.unwrap_or(stroke.duration_s),
            record_every: self.record_every,
            tolerance: self.tolerance,
            ledger: true,
        };
        check(&setup)?;
        let mut output =
            self.out.prepare("press", &["run.csv", "run.parquet", "summary.json", "run.svg", "run.png", "run.html"])?;
        let started = Instant::now();
        let run = play(&instrument, &stroke, &setup)?;
        let elapsed_s = started.elapsed().as_secs_f64();
        let names = [self.instrument.model.name(), stroke.drive.name(), self.step.solver_name()];
        let summary = Summary::new(&run, &setup, names, elapsed_s);

        let svg = run_svg(&run);
        let png = png_from_svg(&svg, 2.0).map_err(|e| Failure::Internal(e.to_string()))?;
        let page = page_html(&instrument, &run, &summary.lines());
        output.stage("run.csv", |w| table::write_csv(&run, w))?;
        output.stage("run.parquet", |w| table::write_parquet(&run, w))?;
        output.stage("summary.json", |w| summary.write_json(w))?;
        output.stage("run.svg", |w| w.write_all(svg.as_bytes()))?;
        output.stage("run.png", |w| w.write_all(&png))?;
        output.stage("run.html", |w| w.write_all(page.as_bytes()))?;
        let written = output.commit()?;

        say!("{} - {} ({} driven)", run.instrument, stroke.title, stroke.drive.name());
        say!();
        say!("{summary}");
        let names: Vec<String> =
            written.iter().filter_map(|p| p.file_name()).map(|n| n.to_string_lossy().into_owned()).collect();
        say!("Written to {}: {}", shown(self.out.folder()), names.join(", "));
        Ok(())
    }
}

/// Simulates a stroke on an instrument, with progress on stderr.
pub fn play(instrument: &Instrument, stroke: &Stroke, setup: &Setup) -> Result<Run, Failure> {
    let mut progress = Progress::new("simulating");
    let mut tell = |share: f64| {
        progress.say(if share > 0.0 { "simulating" } else { "coming to rest" });
        progress.tell(share)
    };
    Ok(simulate(instrument, stroke.inputs(instrument)?.as_ref(), setup, &mut tell)?)
}

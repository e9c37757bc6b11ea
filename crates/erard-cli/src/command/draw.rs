//! `erard draw`.

use std::path::PathBuf;

use clap::Args;
use erard::simulation::Setup;
use moreau::Settings;

use super::options::{InstrumentOption, StrokeOptions};
use super::press::play;
use crate::drawing::{PoseOptions, angles_at, forces_at, pose_svg};
use crate::failure::Failure;
use crate::figure::png_from_svg;
use crate::output::Output;
use crate::say;

/// Draws the action in one pose, as SVG and PNG.
#[derive(Debug, Args)]
pub struct Draw {
    #[command(flatten)]
    stroke: StrokeOptions,
    #[command(flatten)]
    instrument: InstrumentOption,
    /// Instant of the stroke to draw, ms after its start; 0 is rest
    #[arg(long, value_name = "MILLISECONDS", default_value_t = 0.0, allow_negative_numbers = true)]
    at: f64,
    /// Name the main parts
    #[arg(long)]
    labels: bool,
    /// Show contact forces as arrows
    #[arg(long)]
    forces: bool,
    /// Output folder
    #[arg(long, value_name = "DIR", default_value = "erard-out")]
    out: PathBuf,
}

/// Step of the run that leads to the pose, s.
const STEP_S: f64 = 50e-6;
/// Farthest instant that is drawn, ms.
const LATEST_MS: f64 = 600_000.0;

impl Draw {
    /// Runs the command.
    pub fn run(&self) -> Result<(), Failure> {
        if !(0.0..=LATEST_MS).contains(&self.at) {
            return Err(Failure::Usage(format!("--at {}: expected 0 to {LATEST_MS} ms", self.at)));
        }
        let stroke = self.stroke.load()?;
        let instrument = self.instrument.load()?;
        let setup = Setup {
            settings: Settings::new(STEP_S),
            start_s: stroke.start_s,
            duration_s: (self.at * 1e-3).max(STEP_S),
            record_every: None,
        };
        let mut output = Output::prepare(&self.out)?;
        let run = play(&instrument, &stroke, &setup)?;
        let row = if self.at > 0.0 { run.time_s.len() - 1 } else { 0 };
        let options = PoseOptions {
            labels: self.labels,
            forces: if self.forces { forces_at(&instrument, &run, row) } else { Vec::new() },
            caption: Some(if row == 0 {
                format!("{}, at rest", run.instrument)
            } else {
                format!("{}, {}, {:.1} ms", run.instrument, stroke.title, self.at)
            }),
            ..PoseOptions::default()
        };
        let svg = pose_svg(&instrument, &angles_at(&run, row), &options);
        let png = png_from_svg(&svg, 1.0).map_err(|e| Failure::Internal(e.to_string()))?;
        output.stage("action.svg", |w| w.write_all(svg.as_bytes()))?;
        output.stage("action.png", |w| w.write_all(&png))?;
        for path in output.commit()? {
            say!("{}", path.display());
        }
        Ok(())
    }
}

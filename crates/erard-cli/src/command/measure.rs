//! `erard measure`.

use clap::Args;
use erard::instrument::Instrument;
use erard::player;
use erard::simulation::{Setup, simulate};
use erard_workshop::measure::{Sheet, measure};
use moreau::Settings;

use super::options::load_instrument;
use super::out::OutOptions;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::measure::figures::{Drawn, figures};
use crate::measure::{Measured, doubts, page, table};
use crate::progress::Progress;
use crate::say;
use crate::tell;
use erard_figures::drawing::{PoseOptions, angles_at, pose_svg};
use erard_figures::figure::png_from_svg;

/// What stands below the options.
const AFTER: &str = "\
Weights are found twice, by trial with weights and from a slow loop; the strike-weight ratio by the equation of balance and
by the geometry. Writes measure.json (of several instruments: a list), measure.html, and as SVG and PNG hysteresis, inertia,
range, timing and a drawing of each action at rest.";

/// Measures an action as a technician does: weights, ratios, regulation, inertia, timing, repetition.
///
/// Several instruments stand side by side.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub struct Measure {
    /// Instruments: TOML files, names of built-in ones, or keys of a keyboard (concert-grand:key=88) [default: concert-grand]
    #[arg(value_name = "INSTRUMENT")]
    instruments: Vec<String>,
    /// One more instrument; may be repeated
    #[arg(long = "instrument", value_name = "FILE-OR-NAME")]
    more: Vec<String>,
    #[command(flatten)]
    out: OutOptions,
}

/// Most instruments side by side: more columns than a page is wide.
const MOST: usize = 12;

impl Measure {
    /// Runs the command.
    pub fn run(&self) -> Result<(), Failure> {
        let named = self.load()?;
        let mut output = self.out.prepare("measure", &["measure.json", "measure.html"])?;
        let mut progress = Progress::new("measuring");
        let count = named.len() as f64;
        let mut measured = Vec::new();
        for (index, (label, instrument)) in named.into_iter().enumerate() {
            let mut tell = |share: f64| progress.tell((index as f64 + share) / count);
            let sheet =
                measure(&instrument, &mut tell).map_err(|error| Failure::Measure { label: label.clone(), error })?;
            measured.push(Measured { label, instrument, sheet });
        }
        drop(progress);

        let drawings = drawings(&measured)?;
        let figures = figures(&measured);
        for drawn in drawings.iter().chain(&figures) {
            let png = png_from_svg(&drawn.svg, 2.0).map_err(|error| Failure::Internal(error.to_string()))?;
            output.stage(&format!("{}.svg", drawn.name), |w| w.write_all(drawn.svg.as_bytes()))?;
            output.stage(&format!("{}.png", drawn.name), |w| w.write_all(&png))?;
        }
        let sheets: Vec<&Sheet> = measured.iter().map(|one| &one.sheet).collect();
        output.stage("measure.json", |w| {
            match sheets[..] {
                [one] => serde_json::to_writer_pretty(&mut *w, one)?,
                _ => serde_json::to_writer_pretty(&mut *w, &sheets)?,
            }
            w.write_all(b"\n")
        })?;
        let page = page::html(&measured, &drawings, &figures);
        output.stage("measure.html", |w| w.write_all(page.as_bytes()))?;
        let written = output.commit()?;

        match &measured[..] {
            [one] => say!("{} - protocol sheet", one.label),
            _ => say!("Protocol sheets side by side"),
        }
        say!();
        say!("{}", table::text(&measured).trim_end_matches('\n'));
        say!();
        for one in &measured {
            for doubt in doubts(&one.sheet) {
                tell!("warning: {}: not to be trusted: {doubt}", one.label);
            }
        }
        let names: Vec<String> =
            written.iter().filter_map(|p| p.file_name()).map(|n| n.to_string_lossy().into_owned()).collect();
        say!("Written to {}: {}", shown(self.out.folder()), names.join(", "));
        Ok(())
    }

    /// All instruments, read before anything is measured, by labels that tell them apart.
    fn load(&self) -> Result<Vec<(String, Instrument)>, Failure> {
        let mut asked: Vec<&str> = self.instruments.iter().chain(&self.more).map(String::as_str).collect();
        if asked.is_empty() {
            asked.push("concert-grand");
        }
        if asked.len() > MOST {
            return Err(Failure::Usage(format!("{} instruments: expected {MOST} at most side by side", asked.len())));
        }
        let instruments = asked.iter().map(|name| load_instrument(name)).collect::<Result<Vec<_>, _>>()?;
        let shared = |name: &str| instruments.iter().filter(|other| other.name == name).count() > 1;
        let label = |asked: &str, instrument: &Instrument| {
            if shared(&instrument.name) { asked.to_owned() } else { instrument.name.clone() }
        };
        let labels: Vec<String> = asked.iter().zip(&instruments).map(|(asked, one)| label(asked, one)).collect();
        Ok(labels.into_iter().zip(instruments).collect())
    }
}

/// A drawing of each action at rest.
fn drawings(measured: &[Measured]) -> Result<Vec<Drawn>, Failure> {
    const STEP_S: f64 = 50e-6;
    let setup = Setup {
        settings: Settings::new(STEP_S),
        start_s: 0.0,
        duration_s: STEP_S,
        record_every: None,
        tolerance: None,
        ledger: true,
    };
    let mut drawings = Vec::new();
    for (index, one) in measured.iter().enumerate() {
        let run = simulate(&one.instrument, &|_| player::Input::Free, &setup, &mut |_| true)?;
        let caption = format!("{}, at rest", one.label);
        let options = PoseOptions { caption: Some(caption.clone()), ..PoseOptions::default() };
        let svg = pose_svg(&one.instrument, &angles_at(&run, 0), &options);
        let name = if measured.len() > 1 { format!("action-{}", index + 1) } else { "action".to_owned() };
        drawings.push(Drawn { name, alt: caption, svg });
    }
    Ok(drawings)
}

//! `erard compare`.

use std::borrow::Cow;
use std::io::Write;
use std::path::PathBuf;

use clap::Args;
use erard::simulation::Setup;
use erard::stroke::Series;
use erard_lab::compare::{Comparison, DRIVES, Driven, Errors, LONGEST_S, Trial, Which, compare};
use serde::Serialize;

use super::options::{StepOptions, check, load_instrument};
use super::out::OutOptions;
use crate::failure::Failure;
use crate::inputs::{self, shown};
use crate::progress::Progress;
use crate::say;
use erard_figures::figure::{Dash, Figure, Layout, PALETTE, Panel, Scale, Trace, Window, figure_svg, png_from_svg};

/// Holds a measured stroke against the models: what drives it, what comes out, what is missed.
#[derive(Debug, Args)]
pub struct Compare {
    /// Measured series: CSV with `time_s` and `force_N` and/or `position_m` (down is positive), `hammer_head_m` if it was measured too
    #[arg(value_name = "MEASURED.csv")]
    file: PathBuf,
    /// Instrument: a TOML file, or the name of a built-in one
    #[arg(long, value_name = "FILE-OR-NAME", default_value = "concert-grand")]
    instrument: String,
    #[command(flatten)]
    step: StepOptions,
    /// Compare only the first S seconds
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    duration: Option<f64>,
    #[command(flatten)]
    out: OutOptions,
}

impl Compare {
    /// Runs the command.
    pub fn run(&self) -> Result<(), Failure> {
        let settings = self.step.settings()?;
        let title = shown(&self.file);
        let series = Series::read_opened(inputs::open(&self.file), &title)?;
        let series = self.begun(series)?;
        let instrument = load_instrument(&self.instrument)?;
        let setup =
            Setup { settings, start_s: 0.0, duration_s: 1.0, record_every: None, tolerance: None, ledger: true };
        check(&setup)?;
        let mut output = self.out.prepare("compare", &["compare.csv", "compare.json", "compare.svg", "compare.png"])?;
        let mut progress = Progress::new("comparing");
        let comparison = compare(&instrument, &series, &setup, &mut |share| progress.tell(share))?;
        drop(progress);

        let svg = figure_svg(&figure(&comparison, &title, &instrument.name));
        let png = png_from_svg(&svg, 2.0).map_err(|e| Failure::Internal(e.to_string()))?;
        output.stage("compare.csv", |w| write_csv(&comparison, w))?;
        output.stage("compare.json", |w| {
            serde_json::to_writer_pretty(&mut *w, &Report::new(&comparison, &title, &instrument.name))?;
            w.write_all(b"\n")
        })?;
        output.stage("compare.svg", |w| w.write_all(svg.as_bytes()))?;
        output.stage("compare.png", |w| w.write_all(&png))?;
        output.commit()?;

        say!("{title} beside {}", instrument.name);
        say!();
        print_table(&comparison);
        for verdict in comparison.verdicts() {
            say!("{verdict}");
        }
        say!();
        say!("Written to {}: compare.csv, compare.json, compare.svg, compare.png", shown(self.out.folder()));
        Ok(())
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
        if series.end_s() - series.start_s() > LONGEST_S {
            return Err(Failure::Usage(format!(
                "{}: lasts {lasts_s} s; at most {LONGEST_S} s are compared: --duration {LONGEST_S} compares its first",
                shown(&self.file)
            )));
        }
        Ok(series)
    }
}

/// One quantity of a trial, held against what was measured.
struct Finding<'a> {
    trial: &'a Trial,
    quantity: &'static str,
    /// SI unit.
    unit: &'static str,
    /// Factor to the unit that is shown, and that unit.
    shown: (f64, &'static str),
    errors: Option<&'a Errors>,
}

/// What came out of every trial, and the hammer where it was measured.
fn findings(c: &Comparison) -> Vec<Finding<'_>> {
    let mut findings = Vec::new();
    for trial in &c.trials {
        let length = ("m", (1e3, "mm"));
        let (quantity, (unit, shown)) = match trial.driven {
            Driven::ByForce => ("position", length),
            Driven::ByMotion | Driven::Rigidly => ("force", ("N", (1.0, "N"))),
        };
        findings.push(Finding { trial, quantity, unit, shown, errors: trial.errors.as_ref() });
        if let Some(errors) = &trial.hammer_errors {
            let (unit, shown) = length;
            findings.push(Finding { trial, quantity: "hammer", unit, shown, errors: Some(errors) });
        }
    }
    findings
}

fn print_table(comparison: &Comparison) {
    let findings = findings(comparison);
    say!("  drive   model     of         rms          of range   largest      explained  correlation  delay");
    for Finding { trial, quantity, shown: (factor, unit), errors, .. } in &findings {
        let start = format!("  {:<7} {:<9} {quantity:<9}", trial.driven.name(), trial.which.name());
        match errors {
            Some(e) => say!(
                "{start}  {:>7.4} {unit:<3}  {:>7.2} %  {:>7.4} {unit:<3}  {:>7.2} %  {:>10.5}  {:>6.2} ms",
                e.rms * factor,
                e.rms_of_range * 100.0,
                e.largest * factor,
                e.explained * 100.0,
                e.correlation,
                e.delay_s * 1e3
            ),
            None => say!("{start}  not measured"),
        }
    }
    say!();
    if findings.iter().any(|f| f.errors.is_some()) {
        say!("  error by frequency (rms; in brackets, of what was measured in the band)");
        for Finding { trial, quantity, shown: (factor, unit), errors, .. } in &findings {
            let Some(errors) = errors else { continue };
            let mut line = format!("  {:<7} {:<9} {quantity:<9}", trial.driven.name(), trial.which.name());
            for band in &errors.bands {
                let share = 100.0 * band.error_rms / band.measured_rms.max(f64::MIN_POSITIVE);
                // A band in which next to nothing was measured has no share worth reading.
                let share = if share < 1e3 { format!("{share:.1} %") } else { "> 1000 %".to_owned() };
                let error = band.error_rms * factor;
                line += &format!("  {:.0}-{:.0} Hz {error:.4} {unit} ({share})", band.from_hz, band.to_hz);
            }
            say!("{line}");
        }
        say!();
    }
}

fn write_csv(c: &Comparison, writer: &mut dyn Write) -> std::io::Result<()> {
    let mut columns: Vec<(String, &[f64])> = vec![("time_s".into(), &c.time_s)];
    if let Some(force) = &c.measured_force_n {
        columns.push(("measured_force_N".into(), force));
    }
    if let Some(position) = &c.measured_position_m {
        columns.push(("measured_position_m".into(), position));
    }
    if let Some(hammer) = &c.measured_hammer_m {
        columns.push(("measured_hammer_head_m".into(), hammer));
    }
    for t in &c.trials {
        let stem = format!("{}_{}", t.driven.name(), t.which.name().replace('-', "_"));
        columns.push((format!("{stem}_force_N"), &t.force_n));
        columns.push((format!("{stem}_key_m"), &t.key_m));
        if !t.hammer_m.is_empty() {
            columns.push((format!("{stem}_hammer_head_m"), &t.hammer_m));
        }
    }
    crate::table::write_columns(&columns, c.time_s.len(), writer)
}

#[derive(Serialize)]
struct Report {
    measured: String,
    instrument: String,
    verdicts: Vec<String>,
    findings: Vec<FindingReport>,
}

#[derive(Serialize)]
struct FindingReport {
    drive: &'static str,
    model: &'static str,
    quantity: &'static str,
    unit: &'static str,
    errors: Option<ErrorsReport>,
}

#[derive(Serialize)]
struct ErrorsReport {
    rms: f64,
    rms_of_range: f64,
    largest: f64,
    explained: f64,
    correlation: f64,
    delay_s: f64,
    bands: Vec<BandReport>,
}

#[derive(Serialize)]
#[allow(non_snake_case)]
struct BandReport {
    from_Hz: f64,
    to_Hz: f64,
    measured_rms: f64,
    error_rms: f64,
}

impl Report {
    fn new(c: &Comparison, measured: &str, instrument: &str) -> Self {
        Report {
            measured: measured.into(),
            instrument: instrument.into(),
            verdicts: c.verdicts(),
            findings: findings(c).iter().map(FindingReport::new).collect(),
        }
    }
}

impl FindingReport {
    fn new(f: &Finding) -> Self {
        let errors = f.errors.map(|e| ErrorsReport {
            rms: e.rms,
            rms_of_range: e.rms_of_range,
            largest: e.largest,
            explained: e.explained,
            correlation: e.correlation,
            delay_s: e.delay_s,
            bands: e
                .bands
                .iter()
                .map(|b| BandReport {
                    from_Hz: b.from_hz,
                    to_Hz: b.to_hz,
                    measured_rms: b.measured_rms,
                    error_rms: b.error_rms,
                })
                .collect(),
        });
        let (drive, model) = (f.trial.driven.name(), f.trial.which.name());
        FindingReport { drive, model, quantity: f.quantity, unit: f.unit, errors }
    }
}

/// The range of some curves and half as much again on both sides.
fn widened(curves: &[Trace]) -> (f64, f64) {
    let values = || curves.iter().flat_map(|c| c.y.iter().copied());
    let (low, high) = (values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max));
    let margin = (0.5 * (high - low)).max(1e-6);
    (low - margin, high + margin)
}

/// Measured in black, the action in orange, one degree of freedom in blue.
fn figure<'a>(c: &'a Comparison, title: &str, instrument: &str) -> Figure<'a> {
    let curve =
        |label: &str, y: Cow<'a, [f64]>, colour, dash| Trace { label: label.into(), x: &c.time_s, y, colour, dash };
    let in_mm = |y: &[f64]| Cow::Owned(y.iter().map(|y| y * 1e3).collect::<Vec<f64>>());
    let mut panels = Vec::new();
    for driven in DRIVES {
        let (Some(action), Some(one_dof)) = (c.trial(driven, Which::Action), c.trial(driven, Which::OneDof)) else {
            continue;
        };
        let mut curves = Vec::new();
        let (quantity, unit) = match driven {
            Driven::ByForce => ("position, force driven", "mm"),
            Driven::ByMotion => ("force, motion driven", "N"),
            Driven::Rigidly => ("force, rigidly driven", "N"),
        };
        let shown = |t: &'a Trial| match driven {
            Driven::ByForce => in_mm(&t.key_m),
            Driven::ByMotion | Driven::Rigidly => Cow::Borrowed(&t.force_n[..]),
        };
        let measured = match driven {
            Driven::ByForce => c.measured_position_m.as_ref().map(|m| in_mm(m)),
            Driven::ByMotion | Driven::Rigidly => c.measured_force_n.as_ref().map(|m| Cow::Borrowed(&m[..])),
        };
        if let Some(measured) = measured {
            curves.push(curve("measured", measured, PALETTE[6], Dash::Solid));
        }
        curves.push(curve("action", shown(action), PALETTE[1], Dash::Solid));
        // Where the simple model is far off it may leave the frame, so that the others can be read.
        let y_range = Some(widened(&curves));
        curves.push(curve("one degree of freedom", shown(one_dof), PALETTE[0], Dash::Dashed));
        panels.push(Panel {
            quantity: quantity.into(),
            unit,
            height_px: 260.0,
            layout: Layout::Together,
            y_range,
            curves,
        });
    }
    if let Some(measured) = &c.measured_hammer_m {
        let mut curves = vec![curve("measured", in_mm(measured), PALETTE[6], Dash::Solid)];
        for (n, trial) in c.trials.iter().filter(|t| !t.hammer_m.is_empty()).enumerate() {
            let how = if trial.driven == Driven::Rigidly { "rigidly" } else { trial.driven.name() };
            let (label, colour) = (format!("action, {how} driven"), PALETTE[1 + n]);
            curves.push(curve(&label, in_mm(&trial.hammer_m), colour, Dash::Solid));
        }
        panels.push(Panel {
            quantity: "hammer".into(),
            unit: "mm",
            height_px: 260.0,
            layout: Layout::Together,
            y_range: None,
            curves,
        });
    }
    Figure {
        title: title.into(),
        subtitle: format!("beside {instrument}"),
        width_px: 1180.0,
        x_label: "time (ms)".into(),
        x_unit: 1e3,
        x_scale: Scale::Linear,
        windows: vec![Window {
            from: c.time_s[0],
            to: c.time_s[c.time_s.len() - 1],
            weight: 1.0,
            heading: String::new(),
            names_markers: true,
        }],
        panels,
        markers: Vec::new(),
    }
}

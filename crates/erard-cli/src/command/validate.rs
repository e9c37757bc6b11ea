//! `erard validate`.

use clap::Args;
use erard_lab::validate::{PressedBlow, Published, Row, Validation, Verdict, validate};
use serde::Serialize;
use std::io::Write;

use super::options::load_instrument;
use super::out::OutOptions;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::progress::Progress;
use crate::say;
use crate::table::three;
use erard_figures::figure::{
    Dash, Figure, Layout, Marker, PALETTE, Panel, Scale, Trace, Window, figure_svg, png_from_svg,
};

/// What stands below the options.
const AFTER: &str = "\
A row is met where the simulated value lies in the published range; where a source gives one number, the range around it is
ours, and the table (validation/published.toml) says so. Misses are shown as misses, with the likely reason. Writes
validate.json, validate.csv, and the order of events against loudness as SVG and PNG.";

/// Holds an instrument against what has been measured on real pianos.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub struct Validate {
    /// Instrument: a TOML file, or the name of a built-in one
    #[arg(long, value_name = "FILE-OR-NAME", default_value = "concert-grand")]
    instrument: String,
    /// End with code 1 when a row is missed
    #[arg(long)]
    fail_on_miss: bool,
    #[command(flatten)]
    out: OutOptions,
}

impl Validate {
    /// Runs the command.
    pub fn run(&self) -> Result<(), Failure> {
        let instrument = load_instrument(&self.instrument)?;
        let published = Published::builtin();
        let mut output = self
            .out
            .prepare("validate", &["validate.json", "validate.csv", "order-of-events.svg", "order-of-events.png"])?;
        let mut progress = Progress::new("validating");
        let validation = validate(&instrument, &published, &mut |share| progress.tell(share))
            .map_err(|error| Failure::Measure { label: self.instrument.clone(), error })?;
        drop(progress);

        let svg = order_svg(&validation, &published);
        let png = png_from_svg(&svg, 2.0).map_err(|error| Failure::Internal(error.to_string()))?;
        let report = Report::new(&validation, &published);
        output.stage("validate.json", |w| {
            serde_json::to_writer_pretty(&mut *w, &report)?;
            w.write_all(b"\n")
        })?;
        output.stage("validate.csv", |w| write_csv(&report.rows, w))?;
        output.stage("order-of-events.svg", |w| w.write_all(svg.as_bytes()))?;
        output.stage("order-of-events.png", |w| w.write_all(&png))?;
        output.commit()?;

        say!("{} beside measured pianos", validation.instrument);
        say!();
        print_table(&report.rows);
        say!(
            "{} of {} rows met, {} missed, {} that the model cannot speak to",
            report.met,
            report.rows.len(),
            report.missed,
            report.silent
        );
        say!();
        say!(
            "Written to {}: validate.json, validate.csv, order-of-events.svg, order-of-events.png",
            shown(self.out.folder())
        );
        match report.missed {
            missed if missed > 0 && self.fail_on_miss => {
                let names: Vec<&str> = report
                    .rows
                    .iter()
                    .filter(|row| [MISSED, ABSENT].contains(&row.verdict))
                    .map(|row| row.name)
                    .collect();
                Err(Failure::Unmet(format!("{missed} rows are missed: {}", names.join(", "))))
            }
            _ => Ok(()),
        }
    }
}

/// A row of the table with its verdict, as it is written and printed.
#[derive(Debug, Serialize)]
struct RowReport<'a> {
    name: &'a str,
    quantity: &'a str,
    unit: &'a str,
    published: String,
    at_least: Option<f64>,
    at_most: Option<f64>,
    simulated: Option<f64>,
    verdict: &'static str,
    missed_by: Option<f64>,
    source: &'a str,
    source_title: &'a str,
    certainty: erard::instrument::Certainty,
    how: &'a str,
    likely_reason: Option<&'a str>,
}

#[derive(Debug, Serialize)]
#[allow(non_snake_case)]
struct BlowReport {
    force_N: f64,
    key_stroke_ms: Option<f64>,
    hammer_before_key_bottom_ms: Option<f64>,
    hammer_speed_m_s: Option<f64>,
    key_speed_m_s: f64,
    string_contact_ms: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Report<'a> {
    instrument: &'a str,
    met: usize,
    missed: usize,
    silent: usize,
    rows: Vec<RowReport<'a>>,
    blows: Vec<BlowReport>,
}

impl<'a> Report<'a> {
    fn new(validation: &'a Validation, published: &'a Published) -> Self {
        let rows: Vec<RowReport<'a>> = published
            .rows
            .iter()
            .zip(&validation.verdicts)
            .map(|(row, verdict)| RowReport::new(row, *verdict, published))
            .collect();
        let count = |verdicts: &[&str]| rows.iter().filter(|row| verdicts.contains(&row.verdict)).count();
        let ms = |s: Option<f64>| s.map(|s| s * 1e3);
        let blow = |b: &PressedBlow| BlowReport {
            force_N: b.force_n,
            key_stroke_ms: ms(b.key_stroke_s),
            hammer_before_key_bottom_ms: ms(b.hammer_ahead_s),
            hammer_speed_m_s: b.hammer_speed_m_s,
            key_speed_m_s: b.key_speed_m_s,
            string_contact_ms: ms(b.contact_s),
        };
        Report {
            instrument: &validation.instrument,
            met: count(&[MET]),
            missed: count(&[MISSED, ABSENT]),
            silent: count(&[SILENT]),
            blows: validation.blows.iter().map(blow).collect(),
            rows,
        }
    }
}

const MET: &str = "met";
const MISSED: &str = "missed";
const ABSENT: &str = "did not happen";
const SILENT: &str = "cannot speak to it";

impl<'a> RowReport<'a> {
    fn new(row: &'a Row, verdict: Verdict, published: &'a Published) -> Self {
        let (verdict, simulated, missed_by) = match verdict {
            Verdict::Met { simulated } => (MET, Some(simulated), None),
            Verdict::Missed { simulated, by } => (MISSED, Some(simulated), Some(by)),
            Verdict::Absent => (ABSENT, None, None),
            Verdict::Silent => (SILENT, None, None),
        };
        RowReport {
            name: &row.name,
            quantity: &row.quantity,
            unit: &row.unit,
            published: row.range(),
            at_least: row.at_least,
            at_most: row.at_most,
            simulated,
            verdict,
            missed_by,
            source: &row.source,
            source_title: published.sources.get(&row.source).map_or("", |source| &source.title),
            certainty: row.certainty,
            how: &row.how,
            likely_reason: if verdict == MET { None } else { row.if_missed.as_deref() },
        }
    }

    /// The range that counts, with its unit.
    fn counts(&self) -> String {
        let range = match (self.at_least, self.at_most) {
            (Some(low), Some(high)) => format!("{low} to {high}"),
            (Some(low), None) => format!("from {low}"),
            (None, Some(high)) => format!("to {high}"),
            (None, None) => return String::new(),
        };
        format!("{range} {}", self.unit).trim_end().to_owned()
    }
}

fn print_table(rows: &[RowReport]) {
    say!("  {:<46} {:>17} {:>19} {:>10}  verdict", "", "published", "counts as met", "simulated");
    for row in rows {
        let simulated = row.simulated.map_or_else(|| "-".to_owned(), three);
        let by = row.missed_by.map_or_else(String::new, |by| {
            format!(" by {} {}", three(by.abs()), row.unit).trim_end().to_owned()
                + if by < 0.0 { " (too low)" } else { " (too high)" }
        });
        say!(
            "  {:<46} {:>17} {:>19} {:>10}  {}{by}",
            row.quantity,
            row.published,
            row.counts(),
            simulated,
            row.verdict
        );
    }
    say!();
    for row in rows.iter().filter(|row| row.verdict != MET) {
        say!("  {}: {}", row.quantity, row.likely_reason.unwrap_or("no reason is known"));
    }
    say!();
}

fn write_csv(rows: &[RowReport], writer: &mut dyn Write) -> std::io::Result<()> {
    let mut csv = csv::Writer::from_writer(writer);
    for row in rows {
        csv.serialize(row)?;
    }
    csv.flush()
}

/// Hammer speeds that the figure names, m/s, and their marks: equal ratios from pp, 0.5, to ff, 5.
const MARKS: [(f64, &str); 6] = [(0.5, "pp"), (0.79, "p"), (1.26, "mp"), (1.99, "mf"), (3.15, "f"), (5.0, "ff")];

/// Half the width of a bar, m/s.
const BAR_M_S: f64 = 0.12;

/// A published value with its range, drawn as a bar at a hammer speed.
struct Bar {
    x: [f64; 2],
    y: [f64; 2],
    range: [[f64; 2]; 2],
}

/// The order of events against loudness: simulated blows, and the published points as bars.
fn order_svg(validation: &Validation, published: &Published) -> String {
    let heard: Vec<&PressedBlow> = validation.blows.iter().filter(|b| b.hammer_speed_m_s.is_some()).collect();
    let series = |get: fn(&PressedBlow) -> Option<f64>| -> (Vec<f64>, Vec<f64>) {
        heard.iter().filter_map(|b| Some((b.hammer_speed_m_s?, get(b)? * 1e3))).unzip()
    };
    let (ahead_x, ahead) = series(|b| b.hammer_ahead_s);
    let (stroke_x, stroke) = series(|b| b.key_stroke_s);
    // Where a row's published number stands: at the hammer speed of the simulated blow that it was compared with.
    let bar = |name: &str, speed: Option<f64>| -> Option<Bar> {
        let row = published.rows.iter().find(|row| row.name == name)?;
        let v = speed?;
        let (number, low, high) = (row.number?, row.at_least?, row.at_most?);
        Some(Bar { x: [v - BAR_M_S, v + BAR_M_S], y: [number, number], range: [[v, v], [low, high]] })
    };
    let speed_near = |force: f64| {
        let nearest =
            heard.iter().min_by(|a, b| (a.force_n / force).ln().abs().total_cmp(&(b.force_n / force).ln().abs()));
        nearest.and_then(|b| b.hammer_speed_m_s)
    };
    let f_speed = heard.iter().find(|b| b.key_stroke_s.is_some_and(|t| t <= 0.025)).and_then(|b| b.hammer_speed_m_s);
    let orders: Vec<Bar> = [
        bar("hammer_ahead_softest", heard.first().and_then(|b| b.hammer_speed_m_s)),
        bar("hammer_ahead_p", speed_near(0.8)),
        bar("hammer_ahead_f", f_speed),
        bar("hammer_ahead_loudest", heard.last().and_then(|b| b.hammer_speed_m_s)),
    ]
    .into_iter()
    .flatten()
    .collect();
    let strokes: Vec<Bar> = [
        bar("key_stroke_at_0_8_N", speed_near(0.8)),
        bar("key_stroke_f", Some(3.15)),
        bar("key_stroke_at_15_N", speed_near(15.0)),
    ]
    .into_iter()
    .flatten()
    .collect();
    let figure = Figure {
        title: format!("{}: order of events against loudness", validation.instrument),
        subtitle: "constant forces; bars: published, with the range that counts as met".into(),
        width_px: 860.0,
        x_label: "hammer speed at the string (m/s)".into(),
        x_unit: 1.0,
        x_scale: Scale::Linear,
        windows: vec![Window {
            from: 0.0,
            to: ahead_x.last().copied().unwrap_or(7.0) * 1.08,
            weight: 1.0,
            heading: String::new(),
            names_markers: true,
        }],
        panels: vec![
            panel("hammer before key bottom", 280.0, &ahead_x, &ahead, &orders, true),
            panel("key start to key bottom", 180.0, &stroke_x, &stroke, &strokes, false),
        ],
        markers: MARKS.iter().map(|(x, label)| Marker { x: *x, label: (*label).into() }).collect(),
    };
    figure_svg(&figure)
}

/// Abscissae of the line at zero.
const EVERYWHERE: [f64; 2] = [0.0, 100.0];

fn panel<'a>(quantity: &str, height_px: f64, x: &'a [f64], y: &'a [f64], bars: &'a [Bar], zero: bool) -> Panel<'a> {
    let curve = |label: &str, x: &'a [f64], y: &'a [f64], colour, dash| Trace {
        label: label.into(),
        x,
        y: y.into(),
        colour,
        dash,
    };
    let mut curves = vec![curve("simulated", x, y, PALETTE[0], Dash::Solid)];
    for (index, bar) in bars.iter().enumerate() {
        curves.push(curve(if index == 0 { "published" } else { "" }, &bar.x, &bar.y, PALETTE[1], Dash::Solid));
        curves.push(curve(
            if index == 0 { "counts as met" } else { "" },
            &bar.range[0],
            &bar.range[1],
            PALETTE[5],
            Dash::Solid,
        ));
    }
    if zero {
        curves.push(curve("together", &EVERYWHERE, &[0.0; 2], PALETTE[6], Dash::Dotted));
    }
    Panel { quantity: quantity.into(), unit: "ms", height_px, layout: Layout::Together, y_range: None, curves }
}

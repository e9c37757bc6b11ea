//! [T12] figure 3: p and f, force-driven and motion-driven, six bodies beside one degree of freedom.

use moreau::Settings;

use super::blow::{Play, tell};
use super::{Chart, ChartCurve, ChartPanel, Claim, Mark, Progress, ReproduceError, Section, Table};
use crate::compare::{Comparison, Driven, Errors, Trial, Which, compare};
use crate::instrument::Instrument;
use crate::simulation::Setup;
use crate::stroke::{ForceSeries, PositionSeries, Series, Touch};

/// Step of the reference runs, s; the models run at 50 us.
const REFERENCE_STEP_S: f64 = 6.25e-6;
/// Sampling of the reference series, s.
const SAMPLE_S: f64 = 0.5e-3;
/// Sensor noise added to them, uniform with this root mean square: a load cell's, N, and a laser vibrometer's, m. Both assumed.
const FORCE_NOISE_N: f64 = 0.01;
const POSITION_NOISE_M: f64 = 0.02e-6;
/// s.
const DURATION_S: f64 = 0.35;

/// A deterministic generator (xorshift64*), uniform with unit variance.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let unit = (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 53) as f64;
        (2.0 * unit - 1.0) * 3.0_f64.sqrt()
    }
}

/// A stroke as sensors would have seen it on the six-body model, run with a finer step, and when the key landed, s.
fn reference(instrument: &Instrument, nuance: &'static str) -> Result<(Series, f64), ReproduceError> {
    let every = (SAMPLE_S / REFERENCE_STEP_S).round() as u64;
    let run =
        Play::Stroke(nuance, Touch::Pressed).run(instrument, Settings::new(REFERENCE_STEP_S), DURATION_S, every)?;
    let mut noise = Noise(0x9E37_79B9_7F4A_7C15);
    let force = run.force_n.iter().map(|f| (f + FORCE_NOISE_N * noise.next()).max(0.0)).collect();
    let position = run.key_m.iter().map(|y| y + POSITION_NOISE_M * noise.next()).collect();
    let bad = |e| ReproduceError::Instrument(format!("the reference run gives no series: {e}"));
    let landed = run.events.key_bottom_s.ok_or_else(|| ReproduceError::Instrument("the key does not land".into()))?;
    let series = Series {
        force: Some(ForceSeries::new(run.time_s.clone(), force).map_err(bad)?),
        position: Some(PositionSeries::new(run.time_s, position).map_err(bad)?),
    };
    Ok((series, landed))
}

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let mut section = Section {
        text: vec![
            format!(
                "The measured series of [T12] are not published. A run of the six-body model with a step of {} us, sampled every {} ms, with \
                 sensor noise of {FORCE_NOISE_N} N and {} um added, stands in for them, here and in every figure below. That the six-body \
                 model comes near it is therefore a check of the procedure, of noise and of the step, not of the model; what the \
                 one-degree-of-freedom model misses is the papers' point and does not depend on that.",
                REFERENCE_STEP_S * 1e6,
                SAMPLE_S * 1e3,
                POSITION_NOISE_M * 1e6
            ),
            "Motion-driven means here that the key's own measured motion is imposed on the key, and the force that this takes comes out. The \
             way down ends where the reference's key lands."
                .into(),
        ],
        ..Section::default()
    };
    let mut table = Table::new(
        "What each model misses of the reference",
        &[
            "nuance",
            "drive",
            "model",
            "over",
            "rms",
            "of range",
            "largest",
            "explained",
            "10-50 Hz missed",
            "50-200 Hz missed",
        ],
    );
    for (index, nuance) in ["p", "f"].into_iter().enumerate() {
        let half = 0.5 * index as f64;
        tell(progress, half)?;
        let (series, landed) = reference(instrument, nuance)?;
        let setup = Setup { settings: Settings::new(50e-6), start_s: 0.0, duration_s: DURATION_S, record_every: None };
        let c = compare(instrument, &series, &setup, &mut |share| progress(half + 0.5 * share))?;
        section.charts.push(chart(&c, nuance));
        let way_down = c.time_s.partition_point(|t| *t < landed);
        for driven in [Driven::ByForce, Driven::Rigidly] {
            // Of the whole stroke and of the way down; six bodies, one degree of freedom.
            let mut explained = [[f64::NAN; 2]; 2];
            for (k, which) in [Which::Action, Which::OneDof].into_iter().enumerate() {
                let Some(trial) = c.trial(driven, which) else { continue };
                for (part, rows) in [c.time_s.len(), way_down].into_iter().enumerate() {
                    let Some(e) = errors(&c, trial, rows) else { continue };
                    explained[part][k] = e.explained;
                    table.row(cells(nuance, trial, &e, part == 0));
                }
            }
            claims(nuance, driven, &explained, &mut section);
        }
    }
    section.tables.push(table);
    Ok(section)
}

/// What a trial misses of the reference over its first rows.
fn errors(c: &Comparison, trial: &Trial, rows: usize) -> Option<Errors> {
    let (measured, ours) = match trial.driven {
        Driven::ByForce => (c.measured_position_m.as_ref()?, &trial.key_m),
        _ => (c.measured_force_n.as_ref()?, &trial.force_n),
    };
    Some(Errors::new(&measured[..rows], &ours[..rows]))
}

fn cells(nuance: &str, trial: &Trial, e: &Errors, whole: bool) -> Vec<String> {
    let (factor, unit) = if trial.driven == Driven::ByForce { (1e3, "mm") } else { (1.0, "N") };
    let band = |i: usize| format!("{:.0} %", 100.0 * e.bands[i].error_rms / e.bands[i].measured_rms);
    vec![
        nuance.into(),
        drive_name(trial.driven).into(),
        if trial.which == Which::Action { "six bodies".into() } else { "one degree of freedom".into() },
        if whole { "whole stroke".into() } else { "way down".into() },
        format!("{:.4} {unit}", e.rms * factor),
        format!("{:.2} %", 100.0 * e.rms_of_range),
        format!("{:.3} {unit}", e.largest * factor),
        format!("{:.2} %", 100.0 * e.explained),
        band(1),
        band(2),
    ]
}

fn claims(nuance: &str, driven: Driven, explained: &[[f64; 2]; 2], section: &mut Section) {
    let told =
        |e: &[f64; 2]| format!("six bodies explain {:.2} %, one degree of freedom {:.2} %", 100.0 * e[0], 100.0 * e[1]);
    let [whole, down] = explained;
    if driven == Driven::ByForce {
        for (part, e) in [("on the way down", down), ("over the whole stroke, key bottom and after included", whole)] {
            section.claims.push(Claim::new(
                "[T12] fig. 3, left",
                format!("{nuance}, force-driven, {part}: both models follow the key's position closely (more than 95 % of its variance)"),
                format!("of the position's variance {}", told(e)),
                e.iter().all(|e| *e > 0.95),
            ));
        }
    } else {
        section.claims.push(Claim::new(
            "[T12] fig. 3, right",
            format!(
                "{nuance}, motion-driven: one degree of freedom misses the force's structure (less than 80 % of its variance), the whole \
                 mechanism has it (more than 90 %)"
            ),
            format!("of the force's variance {}; on the way down alone {}", told(whole), told(down)),
            [whole, down].iter().all(|e| e[0] > 0.9 && e[1] < 0.8),
        ));
    }
}

fn drive_name(driven: Driven) -> &'static str {
    match driven {
        Driven::ByForce => "force",
        Driven::ByMotion => "motion of a soft finger",
        Driven::Rigidly => "motion",
    }
}

/// Two of the four panels: the position that a force gives, the force that a motion takes.
fn chart(c: &Comparison, nuance: &str) -> Chart {
    let time: Vec<f64> = c.time_s.iter().map(|t| t * 1e3).collect();
    let curve =
        |label: &str, y: Vec<f64>, colour, mark| ChartCurve { label: label.into(), x: time.clone(), y, colour, mark };
    let mut panels = Vec::new();
    for driven in [Driven::ByForce, Driven::Rigidly] {
        let by_force = driven == Driven::ByForce;
        let scaled = |y: &[f64]| y.iter().map(|y| if by_force { y * 1e3 } else { *y }).collect::<Vec<f64>>();
        let reference = if by_force { &c.measured_position_m } else { &c.measured_force_n };
        let mut curves = Vec::new();
        if let Some(reference) = reference {
            curves.push(curve("reference (stand-in)", scaled(reference), 6, Mark::Line));
        }
        for (which, label, colour, mark) in
            [(Which::Action, "six bodies", 1, Mark::Dashed), (Which::OneDof, "one degree of freedom", 0, Mark::Line)]
        {
            if let Some(trial) = c.trial(driven, which) {
                let series = if by_force { &trial.key_m } else { &trial.force_n };
                curves.push(curve(label, scaled(series), colour, mark));
            }
        }
        let y_label = if by_force { "force-driven: key (mm)" } else { "motion-driven: force (N)" };
        // One degree of freedom goes far outside, and would flatten everything else.
        let y_range = (!by_force).then(|| reference.as_ref().map(|r| range(r))).flatten();
        panels.push(ChartPanel { y_label: y_label.into(), y_log: false, y_range, curves });
    }
    Chart {
        title: format!("{nuance}: what comes out when the force, and when the motion, is given"),
        caption: "Reference: a run of the six-body model with a finer step and added sensor noise, in place of the unpublished measurement. \
                  What leaves the lower panel stands in the table"
            .into(),
        x_label: "time (ms)".into(),
        x_log: false,
        panels,
    }
}

/// The range of a series, and as much again on either side.
fn range(y: &[f64]) -> (f64, f64) {
    let (low, high) = y.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(*y), b.max(*y)));
    (low - (high - low), high + (high - low))
}

//! [T12] figure 3: p and f, force-driven and motion-driven, six bodies beside one degree of freedom.

use moreau::Settings;

use super::blow::{Play, tell};
use super::{Chart, ChartCurve, ChartPanel, Claim, Mark, Progress, ReproduceError, Section, Table};
use crate::compare::{Comparison, Driven, Which, compare};
use crate::instrument::Instrument;
use crate::simulation::Setup;
use crate::stroke::{ForceSeries, PositionSeries, Series, Touch};

/// Step of the reference runs, s; the models run at 50 us.
const REFERENCE_STEP_S: f64 = 6.25e-6;
/// Sampling of the reference series, s.
const SAMPLE_S: f64 = 1e-3;
/// Sensor noise added to them, uniform with this root mean square: a load cell's, N, and a displacement sensor's, m.
const FORCE_NOISE_N: f64 = 0.01;
const POSITION_NOISE_M: f64 = 0.2e-6;
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

/// A stroke as sensors would have seen it on the six-body model, run with a finer step.
fn reference(instrument: &Instrument, nuance: &'static str) -> Result<Series, ReproduceError> {
    let every = (SAMPLE_S / REFERENCE_STEP_S).round() as u64;
    let run =
        Play::Stroke(nuance, Touch::Pressed).run(instrument, Settings::new(REFERENCE_STEP_S), DURATION_S, every)?;
    let mut noise = Noise(0x9E37_79B9_7F4A_7C15);
    let force = run.force_n.iter().map(|f| (f + FORCE_NOISE_N * noise.next()).max(0.0)).collect();
    let position = run.key_m.iter().map(|y| y + POSITION_NOISE_M * noise.next()).collect();
    let bad = |e| ReproduceError::Instrument(format!("the reference run gives no series: {e}"));
    Ok(Series {
        force: Some(ForceSeries::new(run.time_s.clone(), force).map_err(bad)?),
        position: Some(PositionSeries::new(run.time_s, position).map_err(bad)?),
    })
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
            "Motion-driven means here that the key's own measured motion is imposed on the key, and the force that this takes comes out."
                .into(),
        ],
        ..Section::default()
    };
    let mut table = Table::new(
        "What each model misses of the reference",
        &["nuance", "drive", "model", "of", "rms", "of range", "largest", "explained", "10-50 Hz missed", "50-200 Hz missed"],
    );
    for (index, nuance) in ["p", "f"].into_iter().enumerate() {
        let half = 0.5 * index as f64;
        tell(progress, half)?;
        let series = reference(instrument, nuance)?;
        let setup = Setup { settings: Settings::new(50e-6), start_s: 0.0, duration_s: DURATION_S, record_every: None };
        let c = compare(instrument, &series, &setup, &mut |share| progress(half + 0.5 * share))?;
        section.charts.push(chart(&c, nuance));
        for driven in [Driven::ByForce, Driven::Rigidly] {
            let mut explained = [f64::NAN; 2];
            let (what, factor, unit) = match driven {
                Driven::ByForce => ("position", 1e3, "mm"),
                _ => ("force", 1.0, "N"),
            };
            for (k, which) in [Which::Action, Which::OneDof].into_iter().enumerate() {
                let Some(e) = c.trial(driven, which).and_then(|t| t.errors.as_ref()) else { continue };
                explained[k] = e.explained;
                let band = |i: usize| format!("{:.0} %", 100.0 * e.bands[i].error_rms / e.bands[i].measured_rms);
                table.row([
                    nuance.into(),
                    drive_name(driven).into(),
                    if k == 0 { "six bodies".into() } else { "one degree of freedom".into() },
                    what.into(),
                    format!("{:.4} {unit}", e.rms * factor),
                    format!("{:.2} %", 100.0 * e.rms_of_range),
                    format!("{:.3} {unit}", e.largest * factor),
                    format!("{:.2} %", 100.0 * e.explained),
                    band(1),
                    band(2),
                ]);
            }
            let measured = format!(
                "of the {what}'s variance six bodies explain {:.2} %, one degree of freedom {:.2} %",
                100.0 * explained[0],
                100.0 * explained[1]
            );
            section.claims.push(match driven {
                Driven::ByForce => Claim::new(
                    "[T12] fig. 3, left",
                    format!("{nuance}, force-driven: both models follow the key's position closely (more than 95 % of its variance)"),
                    measured,
                    explained.iter().all(|e| *e > 0.95),
                ),
                _ => Claim::new(
                    "[T12] fig. 3, right",
                    format!(
                        "{nuance}, motion-driven: one degree of freedom misses the force's structure (less than 80 % of its variance), the \
                         whole mechanism has it (more than 90 %)"
                    ),
                    measured,
                    explained[0] > 0.9 && explained[1] < 0.8,
                ),
            });
        }
    }
    section.tables.push(table);
    Ok(section)
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
    let curve = |label: &str, y: Vec<f64>, colour, mark| ChartCurve { label: label.into(), x: time.clone(), y, colour, mark };
    let mut panels = Vec::new();
    for driven in [Driven::ByForce, Driven::Rigidly] {
        let by_force = driven == Driven::ByForce;
        let scaled = |y: &[f64]| y.iter().map(|y| if by_force { y * 1e3 } else { *y }).collect::<Vec<f64>>();
        let reference = if by_force { &c.measured_position_m } else { &c.measured_force_n };
        let mut curves = Vec::new();
        if let Some(reference) = reference {
            curves.push(curve("reference (stand-in)", scaled(reference), 6, Mark::Line));
        }
        for (which, label, colour, mark) in [
            (Which::Action, "six bodies", 1, Mark::Dashed),
            (Which::OneDof, "one degree of freedom", 0, Mark::Line),
        ] {
            if let Some(trial) = c.trial(driven, which) {
                let series = if by_force { &trial.key_m } else { &trial.force_n };
                curves.push(curve(label, scaled(series), colour, mark));
            }
        }
        let y_label = if by_force { "force-driven: key (mm)" } else { "motion-driven: force (N)" };
        panels.push(ChartPanel { y_label: y_label.into(), y_log: false, curves });
    }
    Chart {
        title: format!("{nuance}: what comes out when the force, and when the motion, is given"),
        caption: "Reference: a run of the six-body model with a finer step and added sensor noise, in place of the unpublished measurement"
            .into(),
        x_label: "time (ms)".into(),
        x_log: false,
        panels,
    }
}

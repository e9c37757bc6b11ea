//! Work and precision of set-valued and of regularised friction.

use moreau::{FrictionLaw, Settings};

use super::impact::{Play, Rung, halvings, impact, ladder, order, regularised, tell};
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard::stroke::Touch;

/// Widths of the regularised law at the pivots, rad/s.
pub(super) const WIDTHS: [f64; 3] = [0.1, 0.01, 0.001];
/// First step, s, and number of steps, each half of the one before; divisor of the smallest for the reference.
const LADDER: (f64, i32) = (400e-6, 8);
const REFERENCE: f64 = 16.0;
/// Stroke played, and its end, s.
const PLAY: Play = Play::Stroke("mf", Touch::Pressed);
const UNTIL_S: f64 = 0.06;
/// Precision whose price is computed.
const WANTED: f64 = 1e-3;

/// A law with its ladder of steps, errors against the set-valued law's finest run, and its own limit.
struct Law {
    label: String,
    rungs: Vec<Rung>,
    own_order: f64,
    off: f64,
}

fn climb(
    instrument: &Instrument,
    label: String,
    friction: FrictionLaw<f64>,
    truth: Option<&super::impact::FirstImpact>,
    progress: &mut Progress,
) -> Result<(Law, super::impact::FirstImpact), ReproduceError> {
    let steps = halvings(LADDER.0, LADDER.1);
    let settings = Settings { friction, ..Settings::new(LADDER.0) };
    let finest = Settings { step: steps[steps.len() - 1] / REFERENCE, ..settings };
    let limit = impact(instrument, PLAY, finest, UNTIL_S)?;
    tell(progress, 0.3)?;
    let own = ladder(instrument, PLAY, settings, &steps, &limit, UNTIL_S, &mut |s| progress(0.3 + 0.35 * s))?;
    let exact = truth.copied().unwrap_or(limit);
    let rungs = match truth {
        None => own.clone(),
        Some(exact) => ladder(instrument, PLAY, settings, &steps, exact, UNTIL_S, &mut |s| progress(0.65 + 0.35 * s))?,
    };
    let off = (limit.speed / exact.speed - 1.0).abs();
    Ok((Law { label, rungs, own_order: order(&own, |r| r.speed), off }, limit))
}

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let laws_in_all = 1.0 + WIDTHS.len() as f64;
    let mut laws = Vec::new();
    let (first, truth) =
        climb(instrument, "set-valued".into(), FrictionLaw::SetValued, None, &mut |s| progress(s / laws_in_all))?;
    laws.push(first);
    for (i, width) in WIDTHS.into_iter().enumerate() {
        let from = (i as f64 + 1.0) / laws_in_all;
        let label = format!("tanh, {width} rad/s");
        let (law, _) =
            climb(instrument, label, regularised(width), Some(&truth), &mut |s| progress(from + s / laws_in_all))?;
        laws.push(law);
    }
    let mut section = Section {
        text: vec![format!(
            "Hammer speed of {} for steps from {} to {} us, theta 1/2, against the set-valued law with a {REFERENCE:.0} times smaller step; root \
             mean squares over eight phases (see `scheme-order`). The regularised law is tanh(u / width), at sliding contacts with a tenth of \
             the width in m/s. Work is counted in Newton iterations, which are the same on every machine; seconds stand in the table.",
            PLAY.label(),
            LADDER.0 * 1e6,
            LADDER.0 * 1e6 * 0.5_f64.powi(LADDER.1 - 1)
        )],
        ..Section::default()
    };
    claims(&laws, &mut section);
    let colours = [1, 2, 3, 5];
    section.charts.push(Chart {
        title: "Work and precision".into(),
        caption:
            "Error of the hammer speed over the work of the run; along each curve the step is halved from point to point"
                .into(),
        x_label: "Newton iterations of the run".into(),
        x_log: true,
        panels: vec![ChartPanel {
            y_label: "hammer speed, relative error".into(),
            y_log: true,
            y_range: None,
            curves: laws
                .iter()
                .zip(colours)
                .map(|(law, colour)| ChartCurve {
                    label: law.label.clone(),
                    x: law.rungs.iter().map(|r| r.impact.newton).collect(),
                    y: law.rungs.iter().map(|r| r.speed).collect(),
                    colour,
                    mark: Dash::Points,
                })
                .collect(),
        }],
    });
    let mut table = Table::new(
        "Work and precision, with seconds on the clock of this machine, this time",
        &["friction", "step, us", "error", "Newton iterations", "unconverged steps", "seconds per second"],
    );
    table.clock = true;
    for law in &laws {
        for r in &law.rungs {
            table.row([
                law.label.clone(),
                format!("{:.3}", r.step * 1e6),
                format!("{:.1e}", r.speed),
                format!("{}", r.impact.newton),
                format!("{} of {}", r.impact.unconverged, r.impact.steps),
                format!("{:.3}", r.impact.of_real_time),
            ]);
        }
    }
    section.tables.push(table);
    Ok(section)
}

fn claims(laws: &[Law], section: &mut Section) {
    let truth = &laws[0];
    let last = |law: &Law| law.rungs.last().map_or(f64::NAN, |r| r.speed);
    section.claims.push(Claim::new(
        "[T12]",
        "the non-smooth scheme converges as the step shrinks",
        format!("order {:.2}; error {:.1e} at the smallest step", truth.own_order, last(truth)),
        truth.own_order > 0.87,
    ));
    for law in &laws[1..] {
        section.claims.push(Claim::new(
            "[T12]",
            format!("{}: at a fixed width the regularised law does not converge to that motion, however small the step", law.label),
            format!(
                "it tends to a hammer speed {:.1e} away (to that limit with order {:.2}); error at the smallest step {:.1e}, {:.0} times the \
                 set-valued law's",
                law.off,
                law.own_order,
                last(law),
                last(law) / last(truth)
            ),
            last(law) > 10.0 * last(truth),
        ));
    }
    let price = |law: &Law| law.rungs.iter().find(|r| r.speed <= WANTED).map(|r| r.impact.newton);
    let told: Vec<String> = laws
        .iter()
        .map(|law| format!("{}: {}", law.label, price(law).map_or("not reached".into(), |n| format!("{n} iterations"))))
        .collect();
    let cheapest = laws[1..].iter().filter_map(price).fold(f64::INFINITY, f64::min);
    section.claims.push(Claim::new(
        "[T13]",
        format!("a hammer speed right to {WANTED:e} costs less with the set-valued law than with a regularised one"),
        told.join("; "),
        price(truth).is_some_and(|n| n < cheapest),
    ));
}

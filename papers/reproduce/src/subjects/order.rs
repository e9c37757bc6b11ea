//! Order of convergence: on smooth motion (the textbook problems), across impacts and across stick-slip (a whole note).

use moreau::Settings;

use super::impact::{Play, Rung, halvings, impact, ladder, order, tell};
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard::stroke::Touch;

/// First step, s, and number of steps, each half of the one before.
const LADDER: (f64, i32) = (200e-6, 6);
/// Divisor of the smallest step for the reference.
const REFERENCE: f64 = 32.0;

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let cases = [(Play::Stroke("mf", Touch::Pressed), 0.06), (Play::Force(8.0), 0.03)];
    let mut section = Section {
        text: vec![
            format!(
                "Hammer speed and contact instant of a note, in which the key lands, felts open and close and frictions stick and \
                 slip, against a run with a {REFERENCE:.0} times smaller step than the smallest. An error depends on the \
                 phases at which the steps meet the contacts; shown is the root mean square over eight steps from h to h - 7/64 h."
            ),
            "Smooth motion (a double pendulum, orders 2 and 1) and single impacts and reversals stand in the textbook problems: \
             `erard-reproduce --only conformance`."
                .into(),
        ],
        ..Section::default()
    };
    let (mut speed_curves, mut contact_curves) = (Vec::new(), Vec::new());
    let mut table = Table::new(
        "Errors at each step",
        &[
            "played",
            "theta",
            "step, us",
            "speed, relative",
            "ratio",
            "instant, us",
            "ratio",
            "Newton iterations per step",
        ],
    );
    let steps = halvings(LADDER.0, LADDER.1);
    for (index, (play, until)) in cases.into_iter().enumerate() {
        for (turn, theta) in [0.5, 1.0].into_iter().enumerate() {
            let part = (2 * index + turn) as f64;
            tell(progress, part / 4.0)?;
            let settings = Settings { theta, ..Settings::new(LADDER.0) };
            let finest = steps[steps.len() - 1] / REFERENCE;
            let exact = impact(instrument, play, Settings { step: finest, ..settings }, until)?;
            let rungs =
                ladder(instrument, play, settings, &steps, &exact, until, &mut |share| progress((part + share) / 4.0))?;
            let label = format!("{}, theta {theta}", play.label());
            for (i, r) in rungs.iter().enumerate() {
                let ratio = |f: fn(&Rung) -> f64| {
                    i.checked_sub(1).map_or(String::new(), |before| format!("{:.2}", f(&rungs[before]) / f(r)))
                };
                table.row([
                    play.label(),
                    format!("{theta}"),
                    format!("{:.3}", r.step * 1e6),
                    format!("{:.2e}", r.speed),
                    ratio(|r| r.speed),
                    format!("{:.4}", r.contact * 1e6),
                    ratio(|r| r.contact),
                    format!("{:.3}", r.impact.newton / r.impact.steps as f64),
                ]);
            }
            let (speed, contact) = (order(&rungs, |r| r.speed), order(&rungs, |r| r.contact));
            let holds = if theta == 0.5 { speed > 0.87 && contact > 0.87 } else { speed > 0.8 && contact > 0.8 };
            section.claims.push(Claim::new(
                "[T12]",
                format!("{label}: halving the step halves the error at least, across impacts and stick-slip"),
                format!("order {speed:.2} of the hammer speed, {contact:.2} of its instant"),
                holds,
            ));
            let curve = |error: fn(&Rung) -> f64| ChartCurve {
                label: label.clone(),
                x: rungs.iter().map(|r| r.step * 1e6).collect(),
                y: rungs.iter().map(error).collect(),
                colour: 1 + 2 * index + turn,
                mark: Dash::Points,
            };
            speed_curves.push(curve(|r| r.speed));
            contact_curves.push(curve(|r| r.contact * 1e6));
        }
    }
    for (slope, power) in [("order 1", 1.0), ("order 2", 2.0)] {
        let line = |top: f64| ChartCurve {
            label: slope.into(),
            x: steps.iter().map(|h| h * 1e6).collect(),
            y: steps.iter().map(|h| top * (h / steps[0]).powf(power)).collect(),
            colour: 6,
            mark: if power == 1.0 { Dash::Dotted } else { Dash::Dashed },
        };
        let top = |curves: &[ChartCurve]| curves.iter().map(|c| c.y[0]).fold(0.0, f64::max) * 2.0;
        speed_curves.push(line(top(&speed_curves[..4])));
        contact_curves.push(line(top(&contact_curves[..4])));
    }
    section.charts.push(Chart {
        title: "Errors of an impact over the step".into(),
        caption: "Root mean square over eight phases, against the run with the finest step".into(),
        x_label: "step (us)".into(),
        x_log: true,
        panels: vec![
            ChartPanel { y_label: "hammer speed, relative".into(), y_log: true, y_range: None, curves: speed_curves },
            ChartPanel { y_label: "contact instant (us)".into(), y_log: true, y_range: None, curves: contact_curves },
        ],
    });
    section.tables.push(table);
    Ok(section)
}

//! The energy balance of whole notes.

use moreau::Settings;

use super::impact::{Play, tell};
use super::{Chart, ChartCurve, ChartPanel, Claim, Dash, Progress, ReproduceError, Section, Table};
use erard::instrument::Instrument;
use erard::stroke::{NUANCES, Touch};

/// Steps, s.
const STEPS: [f64; 4] = [200e-6, 100e-6, 50e-6, 25e-6];

pub(super) fn section(instrument: &Instrument, progress: &mut Progress) -> Result<Section, ReproduceError> {
    let plays: Vec<Play> =
        NUANCES.into_iter().flat_map(|n| [Play::Stroke(n, Touch::Pressed), Play::Stroke(n, Touch::Struck)]).collect();
    let mut section = Section {
        text: vec![
            "For every run the ledger holds what is stored (motion, gravity, springs, felts), the drive's work and every loss apart. \
             What it does not explain is the residual, here relative to the work put in, one second of each stroke."
                .into(),
        ],
        ..Section::default()
    };
    let mut table = Table::new(
        "Where the work of a stroke goes at 50 us, theta 1/2, mJ",
        &[
            "stroke",
            "work put in",
            "pivots, dry",
            "pivots, viscous",
            "felts",
            "Coulomb",
            "stored at the end",
            "residual",
        ],
    );
    let mut smallest = f64::INFINITY;
    let mut worst = [0.0_f64; STEPS.len()];
    for (i, play) in plays.iter().enumerate() {
        for (k, step) in STEPS.into_iter().enumerate() {
            tell(progress, (i * STEPS.len() + k) as f64 / (plays.len() * STEPS.len()) as f64)?;
            let run = play.run(instrument, Settings::new(step), 1.0, u64::MAX)?;
            let Some(l) = &run.ledger else { continue };
            smallest = smallest.min(l.smallest_term);
            worst[k] = worst[k].max(l.residual_relative());
            if step == 50e-6 {
                let mj = |x: f64| format!("{:.4}", x * 1e3);
                table.row([
                    play.label(),
                    mj(l.drive_work_in),
                    mj(l.pivot_dry),
                    mj(l.pivot_viscous),
                    mj(l.felt_damping),
                    mj(l.coulomb),
                    mj(l.now.total() - l.start.total()),
                    format!("{:.1e}", l.residual_relative()),
                ]);
            }
        }
    }
    section.tables.push(table);
    section.claims.push(Claim::new(
        "this program",
        "the energy balance closes: less than 1e-3 of the work is unexplained at the usual step of 50 us",
        format!("largest residual {:.1e} over ten strokes", worst[2]),
        worst[2] < 1e-3,
    ));
    section.claims.push(Claim::new(
        "this program",
        "friction and felts never give energy: every loss of every step is at least zero",
        format!("smallest loss of any law in any step: {smallest} J"),
        smallest >= 0.0,
    ));
    section.charts.push(Chart {
        title: "Largest energy residual over the step".into(),
        caption: "Of ten strokes, relative to the work put in, theta 1/2".into(),
        x_label: "step (us)".into(),
        x_log: true,
        panels: vec![ChartPanel {
            y_label: "residual".into(),
            y_log: true,
            y_range: None,
            curves: vec![
                ChartCurve {
                    label: "largest residual".into(),
                    x: STEPS.iter().map(|h| h * 1e6).collect(),
                    y: worst.to_vec(),
                    colour: 1,
                    mark: Dash::Points,
                },
                ChartCurve {
                    label: "order 2".into(),
                    x: STEPS.iter().map(|h| h * 1e6).collect(),
                    y: STEPS.iter().map(|h| worst[0] * (h / STEPS[0]).powi(2)).collect(),
                    colour: 6,
                    mark: Dash::Dashed,
                },
            ],
        }],
    });
    Ok(section)
}

//! The figures: what pins carry, and losses one upon the other.

use erard::player::{LossRecorder, PinSeries};
use erard::run::Run;
use erard_figures::Picture;
use erard_figures::figure::{Dash, Layout, PALETTE, Panel, Trace, figure_picture, over_run};

use super::LossReport;

/// Losses with an area of their own; the others share one.
const OWN: usize = PALETTE.len() - 1;

/// Accelerations and both components of every pin's reaction over time.
pub(crate) fn reactions_picture(run: &Run, title: &str, pins: &[PinSeries]) -> Picture {
    // More bodies than colours: broken lines tell them apart.
    let dash = |index: usize| [Dash::Solid, Dash::Dashed, Dash::Dotted][index / PALETTE.len() % 3];
    let panel = |quantity: &str, unit, of: &dyn Fn(&PinSeries) -> Vec<f64>| {
        let curve = |(index, pin): (usize, &PinSeries)| Trace::new(&pin.name, &run.time_s, of(pin), index, dash(index));
        Panel::new(quantity, unit, 190.0, pins.iter().enumerate().map(curve).collect())
    };
    let panels = vec![
        panel("pin, to the back", "N", &|pin| pin.pin_x_n.clone()),
        panel("pin, up", "N", &|pin| pin.pin_y_n.clone()),
        panel("acceleration", "krad/s²", &|pin| pin.acceleration_rad_per_s2.iter().map(|a| a * 1e-3).collect()),
    ];
    let what = "force of each pin on its body, and angular acceleration of the body, counter-clockwise".into();
    figure_picture(&over_run(run, format!("{title}: what the pins carry"), what, panels))
}

/// Losses of pins, contacts and strings over time, one upon the other.
pub(crate) fn losses_picture(run: &Run, title: &str, recorded: &LossRecorder, report: &LossReport) -> Picture {
    let parts = recorded.pin_rows().iter().chain(recorded.contact_rows()).chain(recorded.string_rows());
    let rows: Vec<&[f64]> = parts.map(Vec::as_slice).collect();
    let mj = |places: &[usize]| -> Vec<f64> {
        (0..run.time_s.len())
            .map(|row| places.iter().filter_map(|&place| rows.get(place)?.get(row)).sum::<f64>() * 1e3)
            .collect()
    };
    let share = |share: f64| format!("{:.0} %", 100.0 * share);
    let mut curves = Vec::new();
    for (index, loss) in report.losses.iter().take(OWN).enumerate() {
        let label = format!("{}: {}", short(&loss.label), share(loss.share));
        curves.push(Trace::new(label, &run.time_s, mj(&[loss.place]), index, Dash::Solid));
    }
    let others: Vec<usize> = report.losses.iter().skip(OWN).map(|loss| loss.place).collect();
    let rest: f64 = report.losses.iter().skip(OWN).map(|loss| loss.share).sum();
    let label = format!("all others: {}", share(rest));
    let others = Trace::new(label, &run.time_s, mj(&others), OWN, Dash::Solid);
    curves.push(Trace { colour: "#d4d4d4", ..others });
    let panel = Panel { layout: Layout::Stacked, ..Panel::new("lost so far", "mJ", 420.0, curves) };
    let what = format!("{:.2} mJ in all, by pin and by contact, one upon the other", report.total_J * 1e3);
    figure_picture(&over_run(run, format!("{title}: where the energy goes"), what, vec![panel]))
}

/// As long as the legend is wide.
fn short(label: &str) -> String {
    const FIT: usize = 22;
    let mut text: String = label.chars().take(FIT).collect();
    if label.chars().count() > FIT {
        text.pop();
        text.push('…');
    }
    text
}

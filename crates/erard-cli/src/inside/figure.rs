//! The figures: what pins carry, and losses one upon the other.

use std::borrow::Cow;

use erard::player::{LossRecorder, PinSeries};
use erard::run::Run;
use erard_figures::figure::{
    Dash, Figure, Layout, Marker, PALETTE, Panel, Scale, Trace, figure_svg, instants, windows,
};

use super::LossReport;

/// Losses with an area of their own; the others share one.
const OWN: usize = PALETTE.len() - 1;

fn figure<'a>(run: &Run, title: String, subtitle: String, panels: Vec<Panel<'a>>) -> Figure<'a> {
    let markers = instants(&run.events).into_iter();
    Figure {
        title,
        subtitle,
        width_px: 1180.0,
        x_label: "time (ms)".into(),
        x_unit: 1e3,
        x_scale: Scale::Linear,
        windows: windows(run),
        panels,
        markers: markers.map(|(name, x)| Marker { x, label: format!("{name} {:.1}", x * 1e3) }).collect(),
    }
}

/// Accelerations and both components of every pin's reaction over time.
pub fn reactions_svg(run: &Run, title: &str, pins: &[PinSeries]) -> String {
    // More bodies than colours: broken lines tell them apart.
    let dash = |index: usize| [Dash::Solid, Dash::Dashed, Dash::Dotted][index / PALETTE.len() % 3];
    let panel = |quantity: &str, unit, of: &dyn Fn(&PinSeries) -> Vec<f64>| Panel {
        quantity: quantity.into(),
        unit,
        height_px: 190.0,
        layout: Layout::Together,
        y_range: None,
        curves: pins
            .iter()
            .enumerate()
            .map(|(index, pin)| Trace {
                label: pin.name.clone(),
                x: &run.time_s,
                y: Cow::Owned(of(pin)),
                colour: PALETTE[index % PALETTE.len()],
                dash: dash(index),
            })
            .collect(),
    };
    let panels = vec![
        panel("pin, to the back", "N", &|pin| pin.pin_x_n.clone()),
        panel("pin, up", "N", &|pin| pin.pin_y_n.clone()),
        panel("acceleration", "krad/s²", &|pin| pin.acceleration_rad_s2.iter().map(|a| a * 1e-3).collect()),
    ];
    let what = "force of each pin on its body, and angular acceleration of the body, counter-clockwise".into();
    figure_svg(&figure(run, format!("{title}: what the pins carry"), what, panels))
}

/// Losses of pins, contacts and strings over time, one upon the other.
pub fn losses_svg(run: &Run, title: &str, recorded: &LossRecorder, report: &LossReport) -> String {
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
        curves.push(Trace {
            label: format!("{}: {}", short(&loss.label), share(loss.share)),
            x: &run.time_s,
            y: Cow::Owned(mj(&[loss.place])),
            colour: PALETTE[index],
            dash: Dash::Solid,
        });
    }
    let others: Vec<usize> = report.losses.iter().skip(OWN).map(|loss| loss.place).collect();
    let rest: f64 = report.losses.iter().skip(OWN).map(|loss| loss.share).sum();
    curves.push(Trace {
        label: format!("all others: {}", share(rest)),
        x: &run.time_s,
        y: Cow::Owned(mj(&others)),
        colour: "#d4d4d4",
        dash: Dash::Solid,
    });
    let panels = vec![Panel {
        quantity: "lost so far".into(),
        unit: "mJ",
        height_px: 420.0,
        layout: Layout::Stacked,
        y_range: None,
        curves,
    }];
    let what = format!("{:.2} mJ in all, by pin and by contact, one upon the other", report.total_J * 1e3);
    figure_svg(&figure(run, format!("{title}: where the energy goes"), what, panels))
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

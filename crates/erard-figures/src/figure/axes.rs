//! A panel's axes, curves and legend.

use super::ticks::{range, tick_label, ticks};
use super::{Area, Dash, Figure, LEFT, Panel, Trace, Window, decimate};
use crate::svg::{escape, number};
use std::fmt::Write;

/// The abscissa's grid, and below the last panel its numbers.
pub(super) fn abscissa(out: &mut String, figure: &Figure, window: &Window, area: Area, numbers: bool) {
    let shown = (window.from * figure.x_unit, window.to * figure.x_unit);
    let marks = ticks(shown, ((area.width / 64.0) as usize).max(2));
    let step = if marks.len() > 1 { marks[1] - marks[0] } else { 1.0 };
    for tick in marks {
        let x = area.left + (tick - shown.0) / (shown.1 - shown.0) * area.width;
        line(out, "grid", [x, area.top], [x, area.bottom()]);
        if numbers {
            line(out, "tick", [x, area.bottom()], [x, area.bottom() + 4.0]);
            let _ = write!(
                out,
                "<text class=\"ink\" x=\"{}\" y=\"{}\" text-anchor=\"middle\" font-size=\"11\">{}</text>",
                number(x),
                number(area.bottom() + 16.0),
                tick_label(tick, step)
            );
        }
    }
}

/// Curves over one linear axis.
pub(super) fn together(
    out: &mut String,
    figure: &Figure,
    panel: &Panel,
    window: &Window,
    area: Area,
    numbers: bool,
    clip: &str,
) {
    let (low, high) = panel.y_range.unwrap_or_else(|| fitted(figure, panel));
    let y_of = |value: f64| area.bottom() - (value - low) / (high - low) * area.height;
    let marks = ticks((low, high), ((area.height / 24.0) as usize).clamp(2, 8));
    let step = if marks.len() > 1 { marks[1] - marks[0] } else { 1.0 };
    for tick in marks {
        let y = y_of(tick);
        line(out, "grid", [area.left, y], [area.right(), y]);
        if numbers {
            line(out, "tick", [area.left - 4.0, y], [area.left, y]);
            let _ = write!(
                out,
                "<text class=\"ink\" x=\"{}\" y=\"{}\" text-anchor=\"end\" font-size=\"11\">{}</text>",
                number(area.left - 7.0),
                number(y + 4.0),
                tick_label(tick, step)
            );
        }
    }
    let _ = write!(out, "<g clip-path=\"url(#{clip})\">");
    for curve in &panel.curves {
        for run in thinned(curve, window, area) {
            let _ = write!(
                out,
                "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" stroke-linejoin=\"round\"{} points=\"",
                curve.colour,
                dashes(curve.dash)
            );
            for (index, (x, value)) in run.into_iter().enumerate() {
                let gap = if index == 0 { "" } else { " " };
                let _ = write!(out, "{gap}{},{}", short(x), short(y_of(value)));
            }
            out.push_str("\"/>");
        }
    }
    out.push_str("</g>");
}

/// The range of everything that any window shows, so that windows share their ordinate.
fn fitted(figure: &Figure, panel: &Panel) -> (f64, f64) {
    let shown = |x: f64| figure.windows.iter().any(|window| (window.from..=window.to).contains(&x));
    range(panel.curves.iter().flat_map(|curve| {
        let pairs = curve.x.iter().zip(curve.y.iter());
        pairs.filter(|(x, _)| shown(**x)).map(|(_, y)| *y)
    }))
}

/// A curve's points within a window, its abscissae already in pixels.
pub(super) fn thinned(curve: &Trace, window: &Window, area: Area) -> Vec<Vec<(f64, f64)>> {
    let ends = (window.from, window.to);
    let mut runs = decimate(curve.x, &curve.y, ends, (1.5 * area.width) as usize);
    for point in runs.iter_mut().flatten() {
        point.0 = area.left + (point.0 - window.from) / (window.to - window.from) * area.width;
    }
    runs
}

/// A coordinate to a tenth of a pixel and never absurdly far outside: enough for print, and files stay small.
pub(super) fn short(value: f64) -> String {
    number((value.clamp(-1e5, 1e5) * 10.0).round() / 10.0)
}

/// The panel's quantity, turned to run along the ordinate.
pub(super) fn panel_name(out: &mut String, panel: &Panel, top: f64) {
    let (x, y) = (LEFT - 56.0, top + 0.5 * panel.height_px);
    let _ = write!(
        out,
        "<text class=\"ink\" x=\"{x}\" y=\"{y}\" text-anchor=\"middle\" transform=\"rotate(-90 {x} {y})\">{}</text>",
        escape(&format!("{} ({})", panel.quantity, panel.unit)),
        x = number(x),
        y = number(y),
    );
}

/// Names of the curves beside the panel.
pub(super) fn legend(out: &mut String, panel: &Panel, left: f64, top: f64) {
    // A curve without a name goes with the one before it.
    for (index, curve) in panel.curves.iter().filter(|curve| !curve.label.is_empty()).enumerate() {
        let y = top + 12.0 + 17.0 * index as f64;
        let _ = write!(
            out,
            "<line x1=\"{}\" y1=\"{y}\" x2=\"{}\" y2=\"{y}\" stroke=\"{}\" stroke-width=\"2\"{}/>\
             <text class=\"ink\" x=\"{}\" y=\"{}\">{}</text>",
            number(left),
            number(left + 22.0),
            curve.colour,
            dashes(curve.dash),
            number(left + 28.0),
            number(y + 4.0),
            escape(&curve.label),
            y = number(y),
        );
    }
}

pub(super) fn line(out: &mut String, class: &str, from: [f64; 2], to: [f64; 2]) {
    let _ = write!(
        out,
        "<line class=\"{class}\" x1=\"{}\" y1=\"{}\" x2=\"{}\" y2=\"{}\"/>",
        number(from[0]),
        number(from[1]),
        number(to[0]),
        number(to[1])
    );
}

fn dashes(dash: Dash) -> &'static str {
    match dash {
        Dash::Solid => "",
        Dash::Dashed => " stroke-dasharray=\"6 3\"",
        Dash::Dotted => " stroke-dasharray=\"1.5 2.5\"",
    }
}

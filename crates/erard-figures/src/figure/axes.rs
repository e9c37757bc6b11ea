//! A panel's axes, curves and legend.

use super::axis::{Axis, Scale};
use super::{Area, Dash, Figure, LEFT, Layout, Panel, Trace, Window, decimate};
use crate::svg::{number, text};
use std::borrow::Cow;
use std::fmt::Write;

/// The abscissa's grid, and below the last panel its numbers.
pub(super) fn abscissa(out: &mut String, figure: &Figure, window: &Window, area: Area, numbers: bool) {
    let axis = Axis::between(figure.x_scale, (window.from * figure.x_unit, window.to * figure.x_unit));
    for (share, label) in axis.ticks(((area.width / 64.0) as usize).max(2)) {
        let x = area.left + share * area.width;
        line(out, "grid", [x, area.top], [x, area.bottom()]);
        if numbers {
            line(out, "tick", [x, area.bottom()], [x, area.bottom() + 4.0]);
            text(out, "ink", [x, area.bottom() + 16.0], " text-anchor=\"middle\" font-size=\"11\"", &label);
        }
    }
}

/// Curves over one axis.
pub(super) fn together(
    out: &mut String,
    figure: &Figure,
    panel: &Panel,
    window: &Window,
    area: Area,
    numbers: bool,
    clip: &str,
) {
    let upon_each_other;
    let is_stacked = panel.layout == Layout::Stacked;
    let panel = if is_stacked {
        upon_each_other = stacked(panel);
        &upon_each_other
    } else {
        panel
    };
    let scale = if panel.layout == Layout::Logarithmic { Scale::Logarithmic } else { Scale::Linear };
    let axis = match panel.y_range {
        Some(ends) => Axis::between(scale, ends),
        None => Axis::around(scale, shown(figure, panel)),
    };
    let y_of = |value: f64| area.bottom() - axis.share(axis.measure(value)) * area.height;
    for (share, label) in axis.ticks(((area.height / 24.0) as usize).clamp(2, 8)) {
        let y = area.bottom() - share * area.height;
        line(out, "grid", [area.left, y], [area.right(), y]);
        if numbers {
            line(out, "tick", [area.left - 4.0, y], [area.left, y]);
            text(out, "ink", [area.left - 7.0, y + 4.0], " text-anchor=\"end\" font-size=\"11\"", &label);
        }
    }
    let _ = write!(out, "<g clip-path=\"url(#{clip})\">");
    // From the highest down: each covers what lies below it.
    for curve in panel.curves.iter().rev().filter(|_| is_stacked) {
        for run in thinned(figure, curve, window, area) {
            let run: Vec<(f64, f64)> = run.into_iter().map(|(x, value)| (x, y_of(value))).collect();
            filled(out, curve.colour, &run, y_of(0.0));
        }
    }
    for (index, curve) in panel.curves.iter().enumerate().filter(|_| !is_stacked) {
        for run in thinned(figure, curve, window, area) {
            let run: Vec<(f64, f64)> = run.into_iter().map(|(x, value)| (x, y_of(value))).collect();
            // A logarithm may be infinite where the value is not.
            for run in run.split(|(_, y)| !y.is_finite()).filter(|run| !run.is_empty()) {
                if curve.dash != Dash::Alone {
                    polyline(out, curve, run);
                }
                if matches!(curve.dash, Dash::Points | Dash::Alone) {
                    let inside = |(x, y): &&(f64, f64)| {
                        (area.left..=area.right()).contains(x) && (area.top..=area.bottom()).contains(y)
                    };
                    run.iter().filter(inside).for_each(|(x, y)| point(out, index, *x, *y, curve.colour));
                }
            }
        }
    }
    out.push_str("</g>");
}

/// The panel with each curve upon the sum of those before it, from zero.
fn stacked<'a>(panel: &Panel<'a>) -> Panel<'a> {
    let mut sum: Vec<f64> = Vec::new();
    let curves = panel.curves.iter().map(|curve| {
        sum.resize(sum.len().max(curve.y.len()), 0.0);
        sum.iter_mut().zip(curve.y.iter()).for_each(|(sum, y)| *sum += y);
        Trace { y: Cow::Owned(sum.clone()), ..curve.clone() }
    });
    let curves: Vec<Trace<'a>> = curves.collect();
    let highest = sum.iter().copied().filter(|y| y.is_finite()).fold(0.0, f64::max);
    let y_range = panel.y_range.or(Some((0.0, if highest > 0.0 { 1.05 * highest } else { 1.0 })));
    Panel { y_range, curves, ..panel.clone() }
}

/// The space between a curve and a level.
fn filled(out: &mut String, colour: &str, run: &[(f64, f64)], level: f64) {
    let ([first, ..], [.., last]) = (run, run) else { return };
    let _ = write!(
        out,
        "<polygon fill=\"{colour}\" stroke=\"#fff\" stroke-width=\".6\" points=\"{},{}",
        short(first.0),
        short(level)
    );
    for (x, y) in run {
        let _ = write!(out, " {},{}", short(*x), short(*y));
    }
    let _ = write!(out, " {},{}\"/>", short(last.0), short(level));
}

fn polyline(out: &mut String, curve: &Trace, run: &[(f64, f64)]) {
    let _ = write!(
        out,
        "<polyline fill=\"none\" stroke=\"{}\" stroke-width=\"1.5\" stroke-linejoin=\"round\"{} points=\"",
        curve.colour,
        dashes(curve.dash)
    );
    for (index, (x, y)) in run.iter().enumerate() {
        let gap = if index == 0 { "" } else { " " };
        let _ = write!(out, "{gap}{},{}", short(*x), short(*y));
    }
    out.push_str("\"/>");
}

/// A point; its shape tells curves apart in grey print too.
fn point(out: &mut String, index: usize, x: f64, y: f64, colour: &str) {
    let _ = match index % 4 {
        0 => write!(out, "<circle cx=\"{}\" cy=\"{}\" r=\"3\" fill=\"{colour}\"/>", short(x), short(y)),
        shape => {
            let corners: &[(f64, f64)] = match shape {
                1 => &[(-2.8, -2.8), (2.8, -2.8), (2.8, 2.8), (-2.8, 2.8)],
                2 => &[(0.0, -3.8), (3.6, 2.8), (-3.6, 2.8)],
                _ => &[(0.0, -4.0), (3.4, 0.0), (0.0, 4.0), (-3.4, 0.0)],
            };
            let points: Vec<String> =
                corners.iter().map(|(dx, dy)| format!("{},{}", short(x + dx), short(y + dy))).collect();
            write!(out, "<polygon points=\"{}\" fill=\"{colour}\"/>", points.join(" "))
        }
    };
}

/// The ordinates that any window shows, so that windows share their axis.
fn shown(figure: &Figure, panel: &Panel) -> impl Iterator<Item = f64> {
    let shown = |x: f64| figure.windows.iter().any(|window| (window.from..=window.to).contains(&x));
    panel.curves.iter().flat_map(move |curve| {
        let pairs = curve.x.iter().zip(curve.y.iter());
        pairs.filter(move |(x, _)| shown(**x)).map(|(_, y)| *y)
    })
}

/// A curve's points within a window, its abscissae already in pixels.
pub(super) fn thinned(figure: &Figure, curve: &Trace, window: &Window, area: Area) -> Vec<Vec<(f64, f64)>> {
    let axis = Axis::between(figure.x_scale, (window.from, window.to));
    let x: Cow<[f64]> = match figure.x_scale {
        Scale::Linear => Cow::Borrowed(curve.x),
        Scale::Logarithmic => curve.x.iter().map(|x| axis.measure(*x)).collect(),
    };
    let mut runs = if x.is_sorted() {
        decimate(&x, &curve.y, (axis.low, axis.high), (1.5 * area.width) as usize)
    } else {
        // Only what ascends can be thinned; a loop (force over compression) or a falling row is drawn as it is.
        let all: Vec<(f64, f64)> = x.iter().copied().zip(curve.y.iter().copied()).collect();
        all.split(|(x, y)| !(x.is_finite() && y.is_finite())).filter(|run| !run.is_empty()).map(<[_]>::to_vec).collect()
    };
    for point in runs.iter_mut().flatten() {
        point.0 = area.left + axis.share(point.0) * area.width;
    }
    runs
}

/// A coordinate to a tenth of a pixel and never absurdly far outside: enough for print, and files stay small.
pub(super) fn short(value: f64) -> String {
    number((value.clamp(-1e5, 1e5) * 10.0).round() / 10.0)
}

/// The panel's quantity, turned to run along the ordinate.
pub(super) fn panel_name(out: &mut String, panel: &Panel, top: f64) {
    let (x, y) = (LEFT - 56.0, top + 0.5 * panel.height());
    // A logarithmic axis says so: its numbers alone are easily misread.
    let scale = match panel.layout {
        Layout::Together | Layout::Stacked => "",
        Layout::Logarithmic | Layout::Lanes { .. } => "log",
    };
    let details: Vec<&str> = [panel.unit, scale].into_iter().filter(|detail| !detail.is_empty()).collect();
    let name = match details[..] {
        [] => panel.quantity.clone(),
        _ => format!("{} ({})", panel.quantity, details.join(", ")),
    };
    let turned = format!(" text-anchor=\"middle\" transform=\"rotate(-90 {} {})\"", number(x), number(y));
    text(out, "ink", [x, y], &turned, &name);
}

/// Between the legend's first entry and the panel's top, and from entry to entry, px.
const LEGEND_TOP: f64 = 12.0;
const LEGEND_PITCH: f64 = 17.0;

/// What a panel's legend needs, px.
pub(super) fn legend_height(panel: &Panel) -> f64 {
    let entries = panel.curves.iter().filter(|curve| !curve.label.is_empty()).count();
    if entries == 0 { 0.0 } else { LEGEND_TOP + LEGEND_PITCH * (entries - 1) as f64 + 6.0 }
}

/// Names of the curves beside the panel.
pub(super) fn legend(out: &mut String, panel: &Panel, left: f64, top: f64) {
    // A curve without a name goes with the one before it.
    for (index, curve) in panel.curves.iter().filter(|curve| !curve.label.is_empty()).enumerate() {
        let y = top + LEGEND_TOP + LEGEND_PITCH * index as f64;
        if curve.dash != Dash::Alone {
            let _ = write!(
                out,
                "<line x1=\"{}\" y1=\"{y}\" x2=\"{}\" y2=\"{y}\" stroke=\"{}\" stroke-width=\"2\"{}/>",
                number(left),
                number(left + 22.0),
                curve.colour,
                dashes(curve.dash),
                y = number(y),
            );
        }
        text(out, "ink", [left + 28.0, y + 4.0], "", &curve.label);
        if matches!(curve.dash, Dash::Points | Dash::Alone) {
            point(out, index, left + 11.0, y, curve.colour);
        }
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
        Dash::Solid | Dash::Points | Dash::Alone => "",
        Dash::Dashed => " stroke-dasharray=\"6 3\"",
        Dash::Dotted => " stroke-dasharray=\"1.5 2.5\"",
    }
}

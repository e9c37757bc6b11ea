//! A panel's axes, curves and legend.

use super::axis::{Axis, Scale};
use super::{Area, Dash, Figure, LEFT, Layout, Panel, Trace, Window, decimate};
use crate::picture::{Anchor, Clip, Geometry, Group, Look, Node, Paint, Shape, Words};
use std::borrow::Cow;

/// The abscissa's grid, and below the last panel its numbers.
pub(super) fn abscissa(out: &mut Vec<Node>, figure: &Figure, window: &Window, area: Area, numbers: bool) {
    let axis = Axis::between(figure.x_scale, (window.from * figure.x_unit, window.to * figure.x_unit));
    for (share, label) in axis.ticks(((area.width / 64.0) as usize).max(2)) {
        let x = area.left + share * area.width;
        line(out, "grid", [x, area.top], [x, area.bottom()]);
        if numbers {
            line(out, "tick", [x, area.bottom()], [x, area.bottom() + 4.0]);
            let looks = [Look::Anchor(Anchor::Middle), Look::FontSize(11.0)];
            out.push(Words::node("ink", [x, area.bottom() + 16.0], looks, &label));
        }
    }
}

/// Curves over one axis.
pub(super) fn together(
    out: &mut Vec<Node>,
    figure: &Figure,
    panel: &Panel,
    window: &Window,
    area: Area,
    numbers: bool,
    clip: &Clip,
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
            let looks = [Look::Anchor(Anchor::End), Look::FontSize(11.0)];
            out.push(Words::node("ink", [area.left - 7.0, y + 4.0], looks, &label));
        }
    }
    let mut drawn = Vec::new();
    // From the highest down: each covers what lies below it.
    for curve in panel.curves.iter().rev().filter(|_| is_stacked) {
        for run in thinned(figure, curve, window, area) {
            let run: Vec<(f64, f64)> = run.into_iter().map(|(x, value)| (x, y_of(value))).collect();
            filled(&mut drawn, curve.colour, &run, y_of(0.0));
        }
    }
    for (index, curve) in panel.curves.iter().enumerate().filter(|_| !is_stacked) {
        for run in thinned(figure, curve, window, area) {
            let run: Vec<(f64, f64)> = run.into_iter().map(|(x, value)| (x, y_of(value))).collect();
            // A logarithm may be infinite where the value is not.
            for run in run.split(|(_, y)| !y.is_finite()).filter(|run| !run.is_empty()) {
                if curve.dash != Dash::Alone {
                    polyline(&mut drawn, curve, run);
                }
                if matches!(curve.dash, Dash::Points | Dash::Alone) {
                    let inside = |(x, y): &&(f64, f64)| {
                        (area.left..=area.right()).contains(x) && (area.top..=area.bottom()).contains(y)
                    };
                    run.iter().filter(inside).for_each(|(x, y)| drawn.push(point(index, *x, *y, curve.colour)));
                }
            }
        }
    }
    out.push(Node::Group(Group { clip: Some(clip.clone()), nodes: drawn, ..Group::default() }));
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
fn filled(out: &mut Vec<Node>, of: &'static str, run: &[(f64, f64)], level: f64) {
    let ([first, ..], [.., last]) = (run, run) else { return };
    let around = [(first.0, level)].into_iter().chain(run.iter().copied()).chain([(last.0, level)]);
    let points = around.map(|(x, y)| [short(x), short(y)]).collect();
    let looks = vec![Look::Fill(Paint::Colour(of)), Look::Stroke(Paint::Colour("#fff")), Look::StrokeWidth(0.6)];
    out.push(Shape::looking(looks, Geometry::Polygon(points)));
}

fn polyline(out: &mut Vec<Node>, curve: &Trace, run: &[(f64, f64)]) {
    let mut looks = vec![
        Look::Fill(Paint::None),
        Look::Stroke(Paint::Colour(curve.colour)),
        Look::StrokeWidth(1.5),
        Look::RoundJoins,
    ];
    looks.extend(dashes(curve.dash));
    out.push(Shape::looking(looks, Geometry::Polyline(run.iter().map(|(x, y)| [short(*x), short(*y)]).collect())));
}

/// A point; its shape tells curves apart in grey print too.
fn point(index: usize, x: f64, y: f64, of: &'static str) -> Node {
    let geometry = match index % 4 {
        0 => Geometry::Circle(Some([short(x), short(y)]), 3.0),
        shape => {
            let corners: &[(f64, f64)] = match shape {
                1 => &[(-2.8, -2.8), (2.8, -2.8), (2.8, 2.8), (-2.8, 2.8)],
                2 => &[(0.0, -3.8), (3.6, 2.8), (-3.6, 2.8)],
                _ => &[(0.0, -4.0), (3.4, 0.0), (0.0, 4.0), (-3.4, 0.0)],
            };
            Geometry::Polygon(corners.iter().map(|(dx, dy)| [short(x + dx), short(y + dy)]).collect())
        }
    };
    Shape::with(geometry, vec![Look::Fill(Paint::Colour(of))])
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
pub(super) fn short(value: f64) -> f64 {
    (value.clamp(-1e5, 1e5) * 10.0).round() / 10.0
}

/// The panel's quantity, turned to run along the ordinate.
pub(super) fn panel_name(out: &mut Vec<Node>, panel: &Panel, top: f64) {
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
    out.push(Words::upwards("ink", [x, y], [Look::Anchor(Anchor::Middle)], &name));
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
pub(super) fn legend(out: &mut Vec<Node>, panel: &Panel, left: f64, top: f64) {
    // A curve without a name goes with the one before it.
    for (index, curve) in panel.curves.iter().filter(|curve| !curve.label.is_empty()).enumerate() {
        let y = top + LEGEND_TOP + LEGEND_PITCH * index as f64;
        if curve.dash != Dash::Alone {
            let mut looks = vec![Look::Stroke(Paint::Colour(curve.colour)), Look::StrokeWidth(2.0)];
            looks.extend(dashes(curve.dash));
            out.push(Shape::with(Geometry::Line([[left, y], [left + 22.0, y]]), looks));
        }
        out.push(Words::node("ink", [left + 28.0, y + 4.0], [], &curve.label));
        if matches!(curve.dash, Dash::Points | Dash::Alone) {
            out.push(point(index, left + 11.0, y, curve.colour));
        }
    }
}

pub(super) fn line(out: &mut Vec<Node>, class: &'static str, from: [f64; 2], to: [f64; 2]) {
    out.push(Shape::of_class(class, Geometry::Line([from, to])));
}

fn dashes(dash: Dash) -> Option<Look> {
    match dash {
        Dash::Solid | Dash::Points | Dash::Alone => None,
        Dash::Dashed => Some(Look::Dashes([6.0, 3.0])),
        Dash::Dotted => Some(Look::Dashes([1.5, 2.5])),
    }
}

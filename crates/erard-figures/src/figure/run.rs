//! The figure of one run: force, key, hammer, angles and contact forces over time.

use super::ticks::range;
use super::{Dash, Figure, Layout, Marker, Panel, Trace, Window, figure_picture};
use crate::picture::Picture;
use erard::run::{Events, Run};
use std::borrow::Cow;

/// Contact forces below this are drawn as nothing, N: a fiftieth of what a key weighs.
pub(super) const FORCE_FLOOR: f64 = 0.01;

/// The run's figure as a picture. `stroke` is what was played, for the headline.
pub fn run_picture(run: &Run, stroke: &str) -> Picture {
    figure_picture(&run_figure(run, stroke))
}

/// The run's figure: the whole run and, where the impact takes only a small part of it, the impact beside it.
pub(crate) fn run_figure<'a>(run: &'a Run, stroke: &str) -> Figure<'a> {
    let mut panels = vec![
        panel(run, ("force", "N"), 110.0, [("finger on key", Cow::Borrowed(&run.force_n[..]))]),
        panel(run, ("key", "mm"), 110.0, [("key front, down", scaled(&run.key_m, 1e3))]),
    ];
    if !run.hammer_rise_m.is_empty() {
        let head = scaled(&run.hammer_rise_m, 1e3);
        panels.push(panel(run, ("hammer", "mm"), 130.0, [("strike point, up", head)]));
    }
    let angles = angles(run);
    if !angles.is_empty() {
        panels.push(panel(run, ("angle", "°"), 130.0, angles));
    }
    if !run.lifts.is_empty() {
        let lifts = run.lifts.iter().map(|lift| (part(&lift.name), scaled(&lift.lift_m, 1e3)));
        panels.push(panel(run, ("lift", "mm"), 90.0, lifts.collect::<Vec<_>>()));
    }
    if let Some(strings) = &run.strings {
        let under = scaled(&strings.displacement_m, 1e3);
        panels.push(panel(run, ("string", "mm"), 110.0, [("under the hammer, up", under)]));
        let bridge = Cow::Borrowed(&strings.bridge_n[..]);
        panels.push(panel(run, ("bridge", "N"), 110.0, [("strings on bridge, up", bridge)]));
    }
    if let Some(forces) = contact_forces(run) {
        panels.push(forces);
    }
    let speed = run.events.hammer_speed_m_per_s().filter(|speed| speed.is_finite());
    let title = if stroke.is_empty() { run.instrument.clone() } else { format!("{}: {stroke}", run.instrument) };
    let subtitle = speed.map_or(String::new(), |speed| format!("hammer at the string: {speed:.2} m/s"));
    over_run(run, title, subtitle, panels)
}

/// Panels over a run's time, with its events.
pub fn over_run<'a>(run: &Run, title: String, subtitle: String, panels: Vec<Panel<'a>>) -> Figure<'a> {
    let markers = instants(&run.events).into_iter();
    Figure {
        markers: markers.map(|(name, x)| Marker { x, label: format!("{name} {:.1}", x * 1e3) }).collect(),
        ..Figure::over_time(title, subtitle, windows(run), panels)
    }
}

/// Everything worth a mark: the events of the first impact, and every further impact on the string.
pub fn instants(happened: &Events) -> Vec<(String, f64)> {
    let first = events(happened).into_iter().map(|(name, instant)| (name.to_owned(), instant));
    let more = happened.impacts.iter().enumerate().skip(1).filter(|(_, strike)| strike.time_s.is_finite());
    first.chain(more.map(|(index, strike)| (format!("impact {}", index + 1), strike.time_s))).collect()
}

/// The events of the first impact that happened, by the names that all figures and the page use.
pub fn events(events: &Events) -> Vec<(&'static str, f64)> {
    [
        ("key start", events.key_start_s),
        ("toe contact", events.toe_contact_s),
        ("last push", events.let_off_s),
        ("hammer contact", events.hammer_contact_s()),
        ("key bottom", events.key_bottom_s),
        ("check", events.check_s),
    ]
    .into_iter()
    .filter_map(|(name, instant)| Some((name, instant.filter(|x| x.is_finite())?)))
    .collect()
}

/// The whole run and, where it takes only a small part of it, the first impact.
pub(crate) fn windows(run: &Run) -> Vec<Window> {
    let end = run.time_s.last().copied().filter(|t| *t > 0.0 && t.is_finite()).unwrap_or(1.0);
    let begin = run.time_s.first().copied().filter(|t| *t < end).unwrap_or(0.0);
    let whole = Window::whole(begin, end);
    let instants = events(&run.events);
    let first = instants.iter().map(|(_, x)| *x).fold(f64::INFINITY, f64::min);
    let last = instants.iter().map(|(_, x)| *x).fold(f64::NEG_INFINITY, f64::max);
    let margin = (0.35 * (last - first)).max(5e-3);
    let around = (begin.max(first - 0.4 * margin), end.min(last + margin));
    if instants.len() < 2 || around.1 - around.0 > 0.5 * (end - begin) {
        return vec![whole];
    }
    vec![
        Window { heading: "the whole run".into(), names_markers: false, ..whole },
        Window { from: around.0, to: around.1, weight: 1.6, heading: "around the impact".into(), names_markers: true },
    ]
}

/// Angles against the start, of the bodies that the other panels do not show: neither the key, of one part or two that
/// bend, nor the pin from which it lifts, nor the hammer. Without roles in a [`Run`], the bodies are identified by
/// name; a mechanism without these names shows them all.
fn angles(run: &Run) -> Vec<(&str, Cow<'_, [f64]>)> {
    run.bodies
        .iter()
        .filter(|body| !["key", "key_back", "hammer"].contains(&body.name.as_str()))
        .filter(|body| run.lifts.iter().all(|lift| lift.pin != body.name))
        .map(|body| {
            let start = body.angle_rad.first().copied().unwrap_or(0.0);
            let turned = body.angle_rad.iter().map(|angle| (angle - start).to_degrees());
            (part(&body.name), Cow::Owned(turned.collect()))
        })
        .collect()
}

/// What a technician calls a part.
fn part(name: &str) -> &str {
    match name {
        "lever" => "repetition lever",
        "key_back" => "key at the balance rail, up",
        "shank" => "hammer shank",
        other => other,
    }
}

fn contact_forces(run: &Run) -> Option<Panel<'_>> {
    // A zone that never touched has nothing to show, but its empty lane says so: all are kept.
    let peak = run
        .zones
        .iter()
        .flat_map(|zone| zone.normal_n.iter().copied())
        .filter(|force| force.is_finite())
        .fold(1.0, f64::max);
    let curves: Vec<Trace> = run
        .zones
        .iter()
        .enumerate()
        .map(|(index, zone)| Trace::new(&zone.label, &run.time_s, &zone.normal_n, index, Dash::Solid))
        .collect();
    (!curves.is_empty()).then(|| Panel {
        layout: Layout::Lanes { floor: FORCE_FLOOR, ceiling: 1.5 * peak.max(10.0) },
        ..Panel::new("contact forces", "N", 34.0 * curves.len() as f64, curves)
    })
}

fn panel<'a>(
    run: &'a Run,
    (quantity, unit): (&str, &'static str),
    height_px: f64,
    curves: impl IntoIterator<Item = (&'a str, Cow<'a, [f64]>)>,
) -> Panel<'a> {
    let curves: Vec<(&str, Cow<[f64]>)> = curves.into_iter().collect();
    // all of these quantities start from nothing, and a curve is misread on an axis without its zero
    let values = curves.iter().flat_map(|(_, y)| y.iter().copied());
    let (low, high) = range(values.chain([0.0]));
    let dashes = [Dash::Solid, Dash::Dashed, Dash::Solid, Dash::Dotted];
    let curves = curves.into_iter().enumerate();
    let curves =
        curves.map(|(index, (label, y))| Trace::new(label, &run.time_s, y, index, dashes[index % dashes.len()]));
    Panel::new(quantity, unit, height_px, curves.collect()).within(low, high)
}

pub(super) fn scaled(values: &[f64], factor: f64) -> Cow<'_, [f64]> {
    Cow::Owned(values.iter().map(|value| value * factor).collect())
}

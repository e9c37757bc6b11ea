//! Figures: sliding at both contacts, leverage, and leverage compared with a slow press of the dynamic model.

use erard_kinematics::three_lever::StrokePose;
use erard_kinematics::{Agreement, Design, SlowPress};

use super::shown::Shown;
use erard_figures::Picture;
use erard_figures::figure::{Dash, Figure, Marker, Panel, Trace, figure_picture, padded_range};

/// Largest deviation that counts as agreement.
const AGREED: f64 = 0.02;

/// Line styles of cases, distinguishable without colours.
const DASHES: [Dash; 3] = [Dash::Solid, Dash::Dashed, Dash::Dotted];

/// Key travel of all poses of all cases, m.
fn keys(cases: &[Shown]) -> Vec<Vec<f64>> {
    cases.iter().map(|shown| shown.stroke.poses.iter().map(|pose| pose.key).collect()).collect()
}

/// Markers at each case's let-off, if it has one; `name` is their label.
fn let_offs(name: &str, cases: &[Shown]) -> Vec<Marker> {
    let at = |shown: &Shown| {
        let x = shown.case.let_off_key_m?;
        let whose = if cases.len() == 1 { String::new() } else { format!(", {}", shown.label) };
        Some(Marker { x, label: format!("{name} {:.1}{whose}", x * 1e3) })
    };
    cases.iter().filter_map(at).collect()
}

fn let_off_name(design: &Design) -> &'static str {
    design.let_off.as_ref().map_or("let-off", |let_off| let_off.name)
}

fn figure<'a>(
    design: &Design,
    quantity: &str,
    subtitle: &str,
    range: (f64, f64),
    panels: Vec<Panel<'a>>,
    cases: &[Shown],
) -> Figure<'a> {
    let title = format!("{}: {quantity}", design.name);
    Figure {
        x_unit: 1e3,
        markers: let_offs(let_off_name(design), cases),
        ..Figure::over("key front, down (mm)", range, title, subtitle.into(), panels)
    }
}

fn curves<'a>(cases: &[Shown], keys: &'a [Vec<f64>], value: impl Fn(&StrokePose) -> f64) -> Vec<Trace<'a>> {
    let each = cases.iter().zip(keys).enumerate();
    each.map(|(index, (shown, x))| {
        let y: Vec<f64> = shown.stroke.poses.iter().map(&value).collect();
        Trace::new(&shown.label, x, y, index, DASHES[index % DASHES.len()])
    })
    .collect()
}

/// Sliding at capstan and knuckle over the key's travel, on the same scale.
pub(crate) fn sliding_picture(design: &Design, cases: &[Shown], range: (f64, f64)) -> Picture {
    let keys = keys(cases);
    let panel = |contact: &str, sliding: fn(&StrokePose) -> f64| {
        Panel::new(contact, "mm", 190.0, curves(cases, &keys, |pose| sliding(pose) * 1e3))
    };
    let mut panels = vec![panel("capstan", |pose| pose.capstan_sliding), panel("knuckle", |pose| pose.knuckle_sliding)];
    let all = panels.iter().flat_map(|panel| panel.curves.iter().flat_map(|curve| curve.y.iter().copied()));
    let y_range = Some(padded_range(all.chain([0.0])));
    for panel in &mut panels {
        panel.y_range = y_range;
    }
    let subtitle = "how far the parts have slid along each other since rest; both panels on one scale";
    figure_picture(&figure(design, "sliding at the contacts", subtitle, range, panels, cases))
}

/// End of the axis of all leverages, which begins at 0, so that figures from different files can be compared.
fn room_above(highest: f64) -> f64 {
    1.25 * highest
}

/// Leverage over the key's travel.
pub(crate) fn leverage_picture(design: &Design, cases: &[Shown], range: (f64, f64)) -> Picture {
    let keys = keys(cases);
    let curves = curves(cases, &keys, |pose| pose.leverage);
    let highest = curves.iter().flat_map(|curve| curve.y.iter().copied()).filter(|y| y.is_finite()).fold(1.0, f64::max);
    let panel = Panel::new("leverage", "mm per mm", 330.0, curves).within(0.0, room_above(highest));
    let subtitle = "speed of the hammer head, upward, over speed of the key front";
    figure_picture(&figure(design, "leverage", subtitle, range, vec![panel], cases))
}

/// Leverage by geometry and in a slow press, and their difference.
pub(crate) fn dynamics_picture(
    design: &Design,
    unmoved: &Shown,
    press: &SlowPress,
    agreement: Option<&Agreement>,
) -> Picture {
    const EVERY_M: f64 = 2e-5;
    let end = press.key_m.last().copied().unwrap_or(0.0).max(EVERY_M);
    let grid: Vec<f64> = (0..=(end / EVERY_M) as usize).map(|i| i as f64 * EVERY_M).collect();
    let pressed: Vec<f64> = grid.iter().map(|&key| press.leverage(key).unwrap_or(f64::NAN)).collect();
    // Beyond let-off the jack turns, and three levers do not describe it.
    let let_off = unmoved.case.let_off_key_m.unwrap_or(end);
    let poses = unmoved.case.stroke(0.0, let_off.min(end), 200).poses;
    let (keys, leverage): (Vec<f64>, Vec<f64>) = poses.iter().map(|pose| (pose.key, pose.leverage)).unzip();
    let highest = leverage.iter().copied().fold(1.0, f64::max);
    let curves = vec![
        Trace::new("geometry", &keys, leverage, 0, Dash::Solid),
        Trace::new("slow press, 8 s", &grid, pressed, 1, Dash::Dashed),
    ];
    let mut panels = vec![Panel::new("leverage", "mm per mm", 260.0, curves).within(0.0, room_above(highest))];
    let limits = [0.0, end];
    let mut subtitle = "the same instrument file, by its geometry and by its dynamics".to_owned();
    let mut taken_up = None;
    if let Some(agreement) = agreement {
        let percent: Vec<f64> = agreement.deviation.iter().map(|value| value * 100.0).collect();
        let curves = vec![
            Trace::new("slow press / geometry − 1", &agreement.key_m, percent, 1, Dash::Solid),
            Trace::new("± 2 %", &limits, vec![100.0 * AGREED; 2], 6, Dash::Dotted),
            Trace::new("", &limits, vec![-100.0 * AGREED; 2], 6, Dash::Dotted),
        ];
        let panel = Panel::new("deviation", "%", 130.0, curves);
        panels.push(panel.within(-1.6 * AGREED * 100.0, 1.6 * AGREED * 100.0));
        subtitle = format!("{subtitle}; largest deviation {:.2} %", agreement.worst * 100.0);
        taken_up = press.taken_up_key_m().map(|x| Marker { x, label: format!("play taken up {:.1}", x * 1e3) });
    }
    let unmoved = std::slice::from_ref(unmoved);
    let mut figure = figure(design, "leverage, geometry and dynamics", &subtitle, (0.0, end), panels, unmoved);
    figure.markers.extend(taken_up);
    figure_picture(&figure)
}

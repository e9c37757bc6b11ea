//! The figures: sliding at both contacts, leverage, and leverage beside a slow press of the dynamic model.

use std::borrow::Cow;

use erard_workshop::kinematics::{Agreement, Design, SlowPress};
use moreau_linkage::three_lever::StrokePose;

use super::Shown;
use erard_figures::figure::{
    Dash, Figure, Layout, Marker, PALETTE, Panel, Scale, Trace, Window, figure_svg, padded_range,
};

/// Width of a figure, px: a page's text is as wide.
const WIDTH_PX: f64 = 860.0;
/// A deviation that is still called agreement.
const AGREED: f64 = 0.02;

/// A case's line: cases are told apart without colours too.
fn style(index: usize) -> (&'static str, Dash) {
    const DASHES: [Dash; 3] = [Dash::Solid, Dash::Dashed, Dash::Dotted];
    (PALETTE[index % PALETTE.len()], DASHES[index % DASHES.len()])
}

/// The key's travel, m, of all poses of all cases.
fn keys(cases: &[Shown]) -> Vec<Vec<f64>> {
    cases.iter().map(|shown| shown.stroke.poses.iter().map(|pose| pose.key).collect()).collect()
}

fn window(from: f64, to: f64) -> Window {
    Window { from, to, weight: 1.0, heading: String::new(), names_markers: true }
}

/// A marker at each case's let-off, where it is within the figure; `name` is what it is called.
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
    (from, to): (f64, f64),
    panels: Vec<Panel<'a>>,
    cases: &[Shown],
) -> Figure<'a> {
    Figure {
        title: format!("{}: {quantity}", design.name),
        subtitle: subtitle.into(),
        width_px: WIDTH_PX,
        x_label: "key front, down (mm)".into(),
        x_unit: 1e3,
        x_scale: Scale::Linear,
        windows: vec![window(from, to)],
        panels,
        markers: let_offs(let_off_name(design), cases),
    }
}

fn curves<'a>(cases: &[Shown], keys: &'a [Vec<f64>], value: impl Fn(&StrokePose) -> f64) -> Vec<Trace<'a>> {
    let each = cases.iter().zip(keys).enumerate();
    each.map(|(index, (shown, x))| {
        let (colour, dash) = style(index);
        let y = Cow::Owned(shown.stroke.poses.iter().map(&value).collect());
        Trace { label: shown.label.clone(), x, y, colour, dash }
    })
    .collect()
}

/// Sliding at capstan and knuckle over the key's travel, on the same scale.
pub fn sliding_svg(design: &Design, cases: &[Shown], range: (f64, f64)) -> String {
    let keys = keys(cases);
    let panel = |contact: &str, sliding: fn(&StrokePose) -> f64| Panel {
        quantity: contact.into(),
        unit: "mm",
        height_px: 190.0,
        layout: Layout::Together,
        y_range: None,
        curves: curves(cases, &keys, |pose| sliding(pose) * 1e3),
    };
    let mut panels = vec![panel("capstan", |pose| pose.capstan_sliding), panel("knuckle", |pose| pose.knuckle_sliding)];
    let all = panels.iter().flat_map(|panel| panel.curves.iter().flat_map(|curve| curve.y.iter().copied()));
    let y_range = Some(padded_range(all.chain([0.0])));
    for panel in &mut panels {
        panel.y_range = y_range;
    }
    let subtitle = "how far the parts have slid along each other since rest; both panels on one scale";
    figure_svg(&figure(design, "sliding at the contacts", subtitle, range, panels, cases))
}

/// The axis of all leverages: from nothing, so that figures of one file and of several can be laid beside each other.
fn from_nothing(highest: f64) -> (f64, f64) {
    (0.0, 1.25 * highest)
}

/// Leverage over the key's travel.
pub fn leverage_svg(design: &Design, cases: &[Shown], range: (f64, f64)) -> String {
    let keys = keys(cases);
    let curves = curves(cases, &keys, |pose| pose.leverage);
    let highest = curves.iter().flat_map(|curve| curve.y.iter().copied()).filter(|y| y.is_finite()).fold(1.0, f64::max);
    let panel = Panel {
        quantity: "leverage".into(),
        unit: "mm per mm",
        height_px: 330.0,
        layout: Layout::Together,
        y_range: Some(from_nothing(highest)),
        curves,
    };
    let subtitle = "speed of the hammer head, upward, over speed of the key front";
    figure_svg(&figure(design, "leverage", subtitle, range, vec![panel], cases))
}

/// The leverage of the geometry beside that of a slow press, and how far they differ.
pub fn dynamics_svg(design: &Design, unmoved: &Shown, press: &SlowPress, agreement: Option<&Agreement>) -> String {
    const EVERY_M: f64 = 2e-5;
    let end = press.key_m.last().copied().unwrap_or(0.0).max(EVERY_M);
    let grid: Vec<f64> = (0..=(end / EVERY_M) as usize).map(|i| i as f64 * EVERY_M).collect();
    let pressed: Vec<f64> = grid.iter().map(|&key| press.leverage(key).unwrap_or(f64::NAN)).collect();
    // Beyond let-off the jack turns, and three levers say nothing.
    let let_off = unmoved.case.let_off_key_m.unwrap_or(end);
    let poses = unmoved.case.stroke(0.0, let_off.min(end), 200).poses;
    let (keys, leverage): (Vec<f64>, Vec<f64>) = poses.iter().map(|pose| (pose.key, pose.leverage)).unzip();
    let highest = leverage.iter().copied().fold(1.0, f64::max);
    let curve = |label: &str, x, y, index: usize, dash| Trace {
        label: label.into(),
        x,
        y: Cow::Owned(y),
        colour: PALETTE[index],
        dash,
    };
    let mut panels = vec![Panel {
        quantity: "leverage".into(),
        unit: "mm per mm",
        height_px: 260.0,
        layout: Layout::Together,
        y_range: Some(from_nothing(highest)),
        curves: vec![
            curve("geometry", &keys, leverage, 0, Dash::Solid),
            curve("slow press, 8 s", &grid, pressed, 1, Dash::Dashed),
        ],
    }];
    let limits = [0.0, end];
    let mut subtitle = "the same instrument file, by its geometry and by its dynamics".to_owned();
    let mut markers = let_offs(let_off_name(design), std::slice::from_ref(unmoved));
    if let Some(agreement) = agreement {
        let percent = |values: &[f64]| values.iter().map(|value| value * 100.0).collect();
        panels.push(Panel {
            quantity: "deviation".into(),
            unit: "%",
            height_px: 130.0,
            layout: Layout::Together,
            y_range: Some((-1.6 * AGREED * 100.0, 1.6 * AGREED * 100.0)),
            curves: vec![
                curve("slow press / geometry − 1", &agreement.key_m, percent(&agreement.deviation), 1, Dash::Solid),
                curve("± 2 %", &limits, vec![100.0 * AGREED; 2], 6, Dash::Dotted),
                curve("", &limits, vec![-100.0 * AGREED; 2], 6, Dash::Dotted),
            ],
        });
        subtitle = format!("{subtitle}; largest deviation {:.2} %", agreement.worst * 100.0);
        if let Some(key) = press.taken_up_key_m() {
            markers.push(Marker { x: key, label: format!("play taken up {:.1}", key * 1e3) });
        }
    }
    figure_svg(&Figure {
        title: format!("{}: leverage, geometry and dynamics", design.name),
        subtitle,
        width_px: WIDTH_PX,
        x_label: "key front, down (mm)".into(),
        x_unit: 1e3,
        x_scale: Scale::Linear,
        windows: vec![window(0.0, end)],
        panels,
        markers,
    })
}

//! Measured and fitted, and what is left over.

use std::borrow::Cow;

use erard_figures::figure::{Dash, Figure, Layout, PALETTE, Panel, Scale, Trace, Window};
use erard_workshop::fit::Channel;

/// For every channel what was measured (dotted, black) over what was fitted, and below what is left over in units of the noise, with two of these on both sides.
pub fn figure<'a>(channels: &'a [Channel], recordings: &[&str], instrument: &str) -> Figure<'a> {
    let mut panels = Vec::new();
    for channel in channels {
        let (by, unit, quantity) = match channel.column {
            "force_N" => (1.0, "N", "force"),
            "key_m" => (1e3, "mm", "key"),
            _ => (1e3, "mm", "hammer"),
        };
        let which =
            if recordings.len() > 1 { format!("{quantity}, {}", channel.recording + 1) } else { quantity.to_owned() };
        let curve = |label: &str, y: Vec<f64>, colour, dash| Trace {
            label: label.into(),
            x: &channel.time_s,
            y: Cow::Owned(y),
            colour,
            dash,
        };
        let shown = |y: &[f64]| y.iter().map(|y| y * by).collect::<Vec<f64>>();
        panels.push(Panel {
            quantity: which.clone(),
            unit,
            height_px: 170.0,
            layout: Layout::Together,
            y_range: None,
            curves: vec![
                curve("fitted", shown(&channel.fitted), PALETTE[1], Dash::Solid),
                curve("measured", shown(&channel.measured), PALETTE[6], Dash::Dotted),
            ],
        });
        let left: Vec<f64> =
            channel.fitted.iter().zip(&channel.measured).map(|(f, m)| (f - m) / channel.sigma).collect();
        let largest = left.iter().fold(4.0_f64, |most, x| most.max(x.abs()));
        let level = |y: f64| vec![y; left.len()];
        panels.push(Panel {
            quantity: "left over / noise".into(),
            unit: "",
            height_px: 90.0,
            layout: Layout::Together,
            y_range: Some((-1.05 * largest, 1.05 * largest)),
            curves: vec![
                curve("left over", left.clone(), PALETTE[0], Dash::Solid),
                curve("twice the noise", level(2.0), PALETTE[14], Dash::Dashed),
                curve("", level(-2.0), PALETTE[14], Dash::Dashed),
            ],
        });
    }
    let ends = |pick: fn(f64, f64) -> f64, from: f64| {
        channels.iter().flat_map(|c| c.time_s.first().into_iter().chain(c.time_s.last())).fold(from, |a, t| pick(a, *t))
    };
    Figure {
        title: format!("{instrument}, fitted"),
        subtitle: format!("to {}", recordings.join(", ")),
        width_px: 1180.0,
        x_label: "time (ms)".into(),
        x_unit: 1e3,
        x_scale: Scale::Linear,
        windows: vec![Window {
            from: ends(f64::min, f64::INFINITY),
            to: ends(f64::max, f64::NEG_INFINITY),
            weight: 1.0,
            heading: String::new(),
            names_markers: false,
        }],
        panels,
        markers: Vec::new(),
    }
}

//! Measured and fitted, and what is left over.

use erard_figures::figure::{Dash, Figure, Panel, Trace, Window};
use erard_workshop::fit::Channel;

/// For every channel what was measured (dotted, black) over what was fitted, and below what is left over in units of
/// the noise, with two of these on both sides.
pub(crate) fn figure<'a>(channels: &'a [Channel], recordings: &[&str], instrument: &str) -> Figure<'a> {
    let mut panels = Vec::new();
    for channel in channels {
        let (by, unit, quantity) = match channel.column {
            "force_N" => (1.0, "N", "force"),
            "key_m" => (1e3, "mm", "key"),
            "hammer_rise_m_per_s" => (1.0, "m/s", "hammer speed"),
            _ => (1e3, "mm", "hammer"),
        };
        let which =
            if recordings.len() > 1 { format!("{quantity}, {}", channel.recording + 1) } else { quantity.to_owned() };
        let curve = |label: &str, y: Vec<f64>, colour, dash| Trace::new(label, &channel.time_s, y, colour, dash);
        let shown = |y: &[f64]| y.iter().map(|y| y * by).collect::<Vec<f64>>();
        let both = vec![
            curve("fitted", shown(&channel.fitted), 1, Dash::Solid),
            curve("measured", shown(&channel.measured), 6, Dash::Dotted),
        ];
        panels.push(Panel::new(which, unit, 170.0, both));
        let residuals: Vec<f64> =
            channel.fitted.iter().zip(&channel.measured).map(|(f, m)| (f - m) / channel.sigma).collect();
        let largest = residuals.iter().fold(4.0_f64, |most, x| most.max(x.abs()));
        let level = |y: f64| vec![y; residuals.len()];
        let over = vec![
            curve("left over", residuals.clone(), 0, Dash::Solid),
            curve("twice the noise", level(2.0), 14, Dash::Dashed),
            curve("", level(-2.0), 14, Dash::Dashed),
        ];
        let panel = Panel::new("left over / noise", "", 90.0, over);
        panels.push(panel.within(-1.05 * largest, 1.05 * largest));
    }
    let ends = |pick: fn(f64, f64) -> f64, from: f64| {
        channels.iter().flat_map(|c| c.time_s.first().into_iter().chain(c.time_s.last())).fold(from, |a, t| pick(a, *t))
    };
    let window = Window::whole(ends(f64::min, f64::INFINITY), ends(f64::max, f64::NEG_INFINITY));
    let subtitle = format!("to {}", recordings.join(", "));
    Figure::over_time(format!("{instrument}, fitted"), subtitle, vec![window], panels)
}

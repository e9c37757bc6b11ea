//! A run as the page's script reads it: one JSON object, long series in base64.

use super::frames;
use crate::drawing::{self, ARROW, MM};
use crate::figure::{self, Dash, Layout, Panel};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use erard::instrument::Instrument;
use erard::run::{Run, ZoneSeries};
use serde_json::{Value, json};

/// The run, thinned to frames, with what the script needs to place bodies and arrows.
pub(crate) fn data(instrument: &Instrument, run: &Run, close_up: Option<[f64; 4]>, whole: [f64; 4]) -> Value {
    let instants = figure::instants(&run.events);
    let times: Vec<f64> = instants.iter().map(|(_, time)| *time).collect();
    let rows = frames::choose(run, &times, frames::MOST);
    let at = |series: &[f64]| {
        let picked: Vec<f64> = rows.iter().map(|row| series.get(*row).copied().unwrap_or(f64::NAN)).collect();
        floats(picked.into_iter())
    };
    let angles: Vec<String> = (0..instrument.bodies.len())
        .map(|body| match run.bodies.get(body) {
            Some(series) => at(&series.angle_rad),
            None => at(&vec![instrument.bodies[body].angle_rad; run.time_s.len()]),
        })
        .collect();
    let bodies: Vec<Value> = instrument
        .bodies
        .iter()
        .zip(&angles)
        .map(|(body, angle)| json!({"parent": body.parent, "pivot": body.pivot_m.map(|c| c * MM), "angle": angle}))
        .collect();
    let zones: Vec<Value> = run
        .zones
        .iter()
        .enumerate()
        .map(|(index, zone)| {
            let sign = if index < instrument.zones.len() { drawing::arrow_sign(instrument, index) } else { 1.0 };
            contacts(zone, &rows, sign)
        })
        .collect();
    let figure = figure::run_figure(run);
    let panels: Vec<Value> = figure.panels.iter().map(|panel| panel_value(panel, &at)).collect();
    json!({
        "time": at(&run.time_s),
        "bodies": bodies,
        "zones": zones,
        "panels": panels,
        "events": instants.iter().map(|(name, time)| json!([name, time])).collect::<Vec<_>>(),
        "windows": figure.windows.iter().map(|window| [window.from, window.to]).collect::<Vec<_>>(),
        "arrow": {
            "base": ARROW.base_mm,
            "decade": ARROW.per_decade_mm,
            "knee": ARROW.knee_n,
            "drawn": ARROW.smallest_drawn_n,
            "labelled": ARROW.smallest_labelled_n,
        },
        "views": {"whole": whole, "close": close_up},
        "rows": run.time_s.len(),
    })
}

fn panel_value(panel: &Panel, at: &dyn Fn(&[f64]) -> String) -> Value {
    let curves: Vec<Value> = panel
        .curves
        .iter()
        .enumerate()
        .map(|(index, curve)| {
            let dash: &[f64] = match curve.dash {
                Dash::Solid | Dash::Points => &[],
                Dash::Dashed => &[6.0, 3.0],
                Dash::Dotted => &[1.5, 2.5],
            };
            // lanes show the zones' forces, which are there already
            let source = match panel.layout {
                Layout::Together | Layout::Logarithmic | Layout::Stacked => json!({"y": at(&curve.y)}),
                Layout::Lanes { .. } => json!({"zone": index}),
            };
            json!({"label": curve.label, "colour": curve.colour, "dash": dash, "source": source})
        })
        .collect();
    let lanes = match panel.layout {
        Layout::Together | Layout::Logarithmic | Layout::Stacked => Value::Null,
        Layout::Lanes { floor, ceiling } => json!([floor, ceiling]),
    };
    json!({"quantity": panel.quantity, "unit": panel.unit, "range": panel.y_range, "lanes": lanes, "curves": curves})
}

/// A zone's contact, only where it pushes: `spans` are `[first frame, frames]`, and for every frame within them stand
/// force, point (mm) and the direction of the arrow, one span after the other.
fn contacts(zone: &ZoneSeries, rows: &[usize], sign: f64) -> Value {
    let mut spans: Vec<[usize; 2]> = Vec::new();
    let mut values: Vec<f64> = Vec::new();
    for (frame, row) in rows.iter().enumerate() {
        let force = zone.normal_n.get(*row).copied().unwrap_or(0.0);
        let Some(contact) = zone.contact.get(*row).filter(|_| force > 0.0 && force.is_finite()) else {
            continue;
        };
        match spans.last_mut() {
            Some(span) if span[0] + span[1] == frame => span[1] += 1,
            _ => spans.push([frame, 1]),
        }
        let [x, y, nx, ny] = contact.map(f64::from);
        values.extend([force, x * MM, y * MM, (sign * ny).atan2(sign * nx)]);
    }
    json!({"label": zone.label, "spans": spans, "values": floats(values.into_iter())})
}

/// The values as little-endian `f32`, in base64. What is not finite becomes 0: the page draws numbers only.
fn floats(values: impl Iterator<Item = f64>) -> String {
    let mut bytes = Vec::with_capacity(4 * values.size_hint().0);
    for value in values {
        let value = if value.is_finite() { value as f32 } else { 0.0 };
        bytes.extend_from_slice(&value.to_le_bytes());
    }
    STANDARD.encode(&bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn floats_are_little_endian_and_finite() {
        assert_eq!(floats([1.0, f64::NAN].into_iter()), STANDARD.encode([0, 0, 0x80, 0x3f, 0, 0, 0, 0]));
    }
}

//! Runs as the page's script reads it: one JSON object, long series in base64.

use super::scene::{self, Sides};
use super::{Shown, Views, frames};
use crate::drawing::{Drawing, MM};
use crate::figure::{self, Dash, Figure, Layout, Panel};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use erard::instrument::Instrument;
use erard::run::{Run, ZoneSeries};
use serde_json::{Value, json};

/// The runs, thinned to common frames, with what the script needs to place bodies and arrows.
pub(crate) fn data(shown: &[Shown<'_>], drawings: &[Drawing], figure: &Figure<'_>, views: Views) -> Value {
    let instants: Vec<Vec<(String, f64)>> = shown.iter().map(|one| figure::instants(&one.run.events)).collect();
    let most = frames::MAX_FRAMES / shown.len();
    let mut time_s: Vec<f64> = shown
        .iter()
        .zip(&instants)
        .flat_map(|(one, instants)| {
            let times: Vec<f64> = instants.iter().map(|(_, time)| *time).collect();
            frames::choose(one.run, &times, most).into_iter().map(|row| one.run.time_s[row])
        })
        .collect();
    time_s.sort_by(f64::total_cmp);
    time_s.dedup();
    let actions: Vec<Value> = shown
        .iter()
        .zip(drawings)
        .map(|(one, drawing)| action(one, drawing, &Frames::new(&one.run.time_s, &time_s)))
        .collect();
    let lanes = match shown {
        [first, second] => figure::paired_zones([first.run, second.run]),
        _ => shown.first().map_or(Vec::new(), |one| (0..one.run.zones.len()).map(|zone| (0, zone)).collect()),
    };
    let panels: Vec<Value> = figure.panels.iter().map(|panel| panel_value(panel, shown, &lanes, &time_s)).collect();
    let events: Vec<Value> = instants
        .iter()
        .enumerate()
        .flat_map(|(action, list)| list.iter().map(move |(name, time)| json!([name, time, action])))
        .collect();
    json!({
        "time": floats(time_s.iter().copied()),
        "actions": actions,
        "panels": panels,
        "events": events,
        "windows": figure.windows.iter().map(|window| [window.from, window.to]).collect::<Vec<_>>(),
        "arrow": scene::arrow(),
        "views": scene::views_value(views),
        "rows": shown.iter().map(|one| one.run.time_s.len()).max(),
    })
}

/// Where the page's frames lie among the rows of a series: the row before, and the share of the way to the next.
struct Frames(Vec<(usize, f64)>);

impl Frames {
    fn new(rows_s: &[f64], time_s: &[f64]) -> Self {
        let mut row = 0;
        let at = |time: &f64| {
            while row + 1 < rows_s.len() && rows_s[row + 1] <= *time {
                row += 1;
            }
            let (from, to) = (rows_s.get(row).copied().unwrap_or(0.0), rows_s.get(row + 1).copied());
            let share = to.map_or(0.0, |to| ((time - from) / (to - from)).clamp(0.0, 1.0));
            (row, if share.is_finite() { share } else { 0.0 })
        };
        Frames(time_s.iter().map(at).collect())
    }

    /// A series at the frames, straight between its rows; the last value after its end.
    fn of(&self, series: &[f64]) -> String {
        let value = |&(row, share): &(usize, f64)| {
            let from = series.get(row).copied().unwrap_or(f64::NAN);
            if share == 0.0 { from } else { from + share * (series.get(row + 1).copied().unwrap_or(from) - from) }
        };
        floats(self.0.iter().map(value))
    }
}

/// One action: how it moves, what pushes it, what its parts are called.
fn action(shown: &Shown<'_>, drawing: &Drawing, frames: &Frames) -> Value {
    let Shown { instrument, run, .. } = *shown;
    let bodies: Vec<Value> = instrument
        .bodies
        .iter()
        .enumerate()
        .map(|(index, body)| {
            let still = vec![body.angle_rad; run.time_s.len()];
            let angle = frames.of(run.bodies.get(index).map_or(&still, |series| &series.angle_rad));
            let mut hinge = scene::hinge(instrument, index);
            hinge["angle"] = angle.into();
            hinge
        })
        .collect();
    let zones: Vec<Value> = run
        .zones
        .iter()
        .enumerate()
        .map(|(index, zone)| {
            let sides = scene::sides(instrument, drawing, index);
            contacts(zone, frames, &sides)
        })
        .collect();
    let pins: Vec<Value> = shown
        .pins
        .iter()
        .enumerate()
        .filter(|(body, _)| *body < bodies.len() && !drawing.unseen.contains(body))
        .map(|(body, pin)| {
            json!({"body": body, "label": pin.name, "x": frames.of(&pin.pin_x_n), "y": frames.of(&pin.pin_y_n)})
        })
        .collect();
    json!({
        "name": shown.name,
        "bodies": bodies,
        "zones": zones,
        "force": frames.of(&run.force_n),
        "press": scene::press(instrument),
        "pins": pins,
        "string": string(instrument, run, frames),
        "labels": scene::labels(instrument, drawing),
    })
}

/// Times by which a string's displacement may be exaggerated.
const TIMES: [f64; 7] = [1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0];
/// How far it then swings in the picture at most, mm.
const SWING_MM: f64 = 12.0;

/// The string as it swings, where it yields: places and rest in picture millimetres, displacements in mm, place by
/// place in every frame, and by how much the picture exaggerates them; the lift of the pedal's rail in every frame, mm,
/// where it is lifted.
fn string(instrument: &Instrument, run: &Run, frames: &Frames) -> Option<Value> {
    let series = run.strings.as_ref()?;
    let [strike_m, height_m] = scene::string_at(instrument)?;
    let count = series.places_m.len();
    let largest_mm = MM * series.shape_m.iter().fold(0.0, |most: f32, m| most.max(m.abs())) as f64;
    let times = TIMES.into_iter().rev().find(|times| times * largest_mm <= SWING_MM).unwrap_or(1.0);
    let at = |row: usize, place: usize| f64::from(series.shape_m.get(row * count + place).copied().unwrap_or(0.0));
    let last = (series.shape_m.len() / count.max(1)).saturating_sub(1);
    let shape = frames.0.iter().flat_map(|&(row, share)| {
        let next = (row + 1).min(last);
        (0..count).map(move |place| MM * (at(row, place) + share * (at(next, place) - at(row, place))))
    });
    let lift = |row: usize| series.pedal_m.get(row).copied().unwrap_or(0.0);
    let lifts = frames.0.iter().map(|&(row, share)| MM * (lift(row) + share * (lift((row + 1).min(last)) - lift(row))));
    let is_lifted = series.pedal_m.iter().any(|lift_m| *lift_m != 0.0);
    Some(json!({
        "pedal": is_lifted.then(|| floats(lifts)),
        "x": series.places_m.iter().map(|place_m| (strike_m + place_m) * MM).collect::<Vec<_>>(),
        "y": height_m * MM,
        "shape": floats(shape),
        "times": times,
    }))
}

fn panel_value(panel: &Panel, shown: &[Shown<'_>], lanes: &[(usize, usize)], time_s: &[f64]) -> Value {
    let curves: Vec<Value> = panel
        .curves
        .iter()
        .enumerate()
        .map(|(index, curve)| {
            let dash: &[f64] = match curve.dash {
                Dash::Solid | Dash::Points | Dash::Alone => &[],
                Dash::Dashed => &[6.0, 3.0],
                Dash::Dotted => &[1.5, 2.5],
            };
            // lanes show the zones' forces, which are there already
            let source = match panel.layout {
                Layout::Together | Layout::Logarithmic | Layout::Stacked => {
                    json!({"y": Frames::new(curve.x, time_s).of(&curve.y)})
                }
                Layout::Lanes { .. } => {
                    let (action, zone) = lanes.get(index).copied().unwrap_or_default();
                    json!({"action": action, "zone": zone})
                }
            };
            // A list of contacts tells the second action's by its name.
            let label = match (panel.layout, lanes.get(index)) {
                (Layout::Lanes { .. }, Some(&(1, zone))) => {
                    format!("{}, {}", shown[1].run.zones[zone].label, shown[1].name)
                }
                _ => curve.label.clone(),
            };
            // The second action's lane lies right below the first's, under one label.
            let joins = index > 0 && matches!(lanes.get(index), Some((1, _))) && {
                let of = |at: usize| lanes.get(at).map(|&(action, zone)| shown[action].run.zones[zone].label.as_str());
                of(index) == of(index - 1)
            };
            json!({"label": label, "colour": curve.colour, "dash": dash, "source": source, "joins": joins})
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
fn contacts(zone: &ZoneSeries, frames: &Frames, sides: &Sides) -> Value {
    let Sides { sign, unseen, disc, curve } = *sides;
    let mut spans: Vec<[usize; 2]> = Vec::new();
    let mut values: Vec<f64> = Vec::new();
    for (frame, &(row, share)) in frames.0.iter().enumerate() {
        let force_at = |row: usize| zone.normal_n.get(row).copied().filter(|force| force.is_finite()).unwrap_or(0.0);
        let force =
            if share == 0.0 { force_at(row) } else { force_at(row) + share * (force_at(row + 1) - force_at(row)) };
        // Only a row that pushes knows the place.
        let place = if force_at(row) > 0.0 { row } else { row + 1 };
        let Some(contact) = zone.contact.get(place).filter(|_| force > 0.0) else {
            continue;
        };
        match spans.last_mut() {
            Some(span) if span[0] + span[1] == frame => span[1] += 1,
            _ => spans.push([frame, 1]),
        }
        let [x, y, nx, ny] = contact.map(f64::from);
        values.extend([force, x * MM, y * MM, (sign * ny).atan2(sign * nx)]);
    }
    json!({
        "label": zone.label,
        "spans": spans,
        "values": floats(values.into_iter()),
        "sign": sign,
        "unseen": unseen,
        "disc": disc,
        "curve": curve,
    })
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

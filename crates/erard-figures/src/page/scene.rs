//! The data with which a page's script moves the picture of an instrument: shapes, hinges, names, which way arrows
//! point. No run is needed: a page that plays live asks for the same as one that shows what was played.

use serde_json::{Value, json};

use super::{Views, close_up};
use crate::drawing::{self, ARROW, Drawing, GRADIENTS, MM, shapes};
use crate::picture::{gradients, nodes};
use erard::instrument::{Curve, Instrument};

/// The instrument as drawn: `shapes` and `gradients` are SVG (for `<g>` and `<defs>`), lengths are millimetres of the
/// picture (y up; SVG's is down), angles rad.
#[must_use]
pub fn scene(instrument: &Instrument) -> Value {
    let drawing = drawing::drawing(instrument);
    let placed = instrument.drawn();
    let views = Views {
        whole: drawing::view(instrument, &drawing.pieces, &placed),
        close: close_up(instrument, &drawing.pieces, &placed),
    };
    let bodies: Vec<Value> = (0..instrument.bodies.len())
        .map(|index| {
            let body = &instrument.bodies[index];
            let mut hinge = hinge(instrument, index);
            hinge["name"] = body.name.clone().into();
            hinge["angle"] = body.angle_rad.into();
            hinge["mass_g"] = (1e3 * body.mass_kg).into();
            hinge
        })
        .collect();
    let zones: Vec<Value> = (0..instrument.zones.len())
        .map(|zone| {
            let Sides { sign, unseen, disc, curve } = sides(instrument, &drawing, zone);
            let known = &instrument.zones[zone];
            json!({
                "name": known.name,
                "label": known.label,
                "sign": sign,
                "unseen": unseen,
                "disc": disc,
                "curve": curve,
            })
        })
        .collect();
    json!({
        "name": instrument.name,
        "shapes": nodes(&shapes(&drawing, &placed)),
        "gradients": gradients(GRADIENTS),
        "bodies": bodies,
        "zones": zones,
        "press": press(instrument),
        "string": string(instrument),
        "pedal": instrument.roles.pedal.is_some() && instrument.has_yielding_strings(),
        "labels": labels(instrument, &drawing),
        "arrow": arrow(),
        "views": views_value(views),
    })
}

/// What a body is hinged on, and where.
pub(super) fn hinge(instrument: &Instrument, body: usize) -> Value {
    let body = &instrument.bodies[body];
    json!({"parent": body.parent, "pivot": body.pivot_m.map(|c| c * MM)})
}

/// How a zone's force is drawn.
pub(super) struct Sides {
    /// Sign of its arrow against the normal.
    pub sign: f64,
    /// Whether one of its sides is not in the picture.
    pub unseen: bool,
    /// The bodies on its two sides; `None` is the ground.
    pub disc: Option<usize>,
    pub curve: Option<usize>,
}

pub(super) fn sides(instrument: &Instrument, drawing: &Drawing, zone: usize) -> Sides {
    let is_unseen = |body: Option<usize>| body.is_some_and(|body| drawing.unseen.contains(&body));
    let known = instrument.zones.get(zone);
    Sides {
        sign: known.map_or(1.0, |_| drawing::arrow_sign(instrument, zone)),
        unseen: known.is_some_and(|zone| is_unseen(zone.disc_body) || is_unseen(zone.curve_body)),
        disc: known.and_then(|zone| zone.disc_body),
        curve: known.and_then(|zone| zone.curve_body),
    }
}

/// Where a modal string is struck and how high it lies.
fn string(instrument: &Instrument) -> Option<Value> {
    instrument.has_yielding_strings().then(|| string_at(instrument)).flatten().map(|at| json!(at.map(|c| c * MM)))
}

/// Where the string is struck, m, in the world.
pub(super) fn string_at(instrument: &Instrument) -> Option<[f64; 2]> {
    match instrument.zones.get(instrument.roles.string?)?.curve {
        Curve::Line { point_m, .. } => Some(point_m),
        _ => None,
    }
}

/// Where the finger presses.
pub(super) fn press(instrument: &Instrument) -> Option<Value> {
    instrument.roles.key.map(|body| json!({"body": body, "point": instrument.roles.key_front_m.map(|c| c * MM)}))
}

/// Names of parts, each with the number of its outline among those that are written, and a point of it.
pub(super) fn labels(instrument: &Instrument, drawing: &Drawing) -> Vec<Value> {
    // An outline that encloses nothing is not written into the picture.
    let written: Vec<usize> =
        (0..drawing.pieces.len()).filter(|&piece| !drawing::path(&drawing.pieces[piece]).is_empty()).collect();
    drawing::named_points(instrument, &drawing.pieces)
        .into_iter()
        .filter_map(|(piece, point_m)| {
            let at = written.iter().position(|&index| index == piece)?;
            Some(json!({"text": drawing.pieces[piece].name, "piece": at, "at": point_m.map(|c| c * MM)}))
        })
        .collect()
}

/// How long arrows are.
pub(super) fn arrow() -> Value {
    json!({
        "base": ARROW.base_mm,
        "decade": ARROW.per_decade_mm,
        "knee": ARROW.knee_n,
        "drawn": ARROW.smallest_drawn_n,
        "labelled": ARROW.smallest_labelled_n,
    })
}

pub(super) fn views_value(views: Views) -> Value {
    json!({"whole": views.whole, "close": views.close})
}

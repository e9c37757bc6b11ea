//! A grand action drawn from its own geometry: every outline hangs on the pivots, felts and screws that it depicts, so that what is moved in
//! the file, by a screw or by a keyboard's grading moves in the picture.
//!
//! `shapes` is the drawing: for every outline its corners as offsets from places of the geometry. `places` finds those places in an
//! instrument. `made` draws what is round or varies in number. The offsets are a concert grand's, drawn by hand in the style of an action
//! of the early twentieth century, to no particular maker's drawing; they give the wood its looks, and what touches its exact place comes from the
//! instrument.

mod chain;
mod made;
mod parts;
mod places;
mod shapes;

use super::pose::{drawn_angles, placements};
use super::{Drawing, fallback};
use chain::Look;
use erard::instrument::{Instrument, Vec2};
use made::Scene;
use parts::Parts;
use places::Places;

/// Whether a zone is a damper's felt on a string.
fn is_on_a_string(instrument: &Instrument, zone: usize) -> bool {
    instrument.strings.iter().filter_map(|string| string.damper).any(|damper| damper.zone == zone)
}

/// Whether the drawing of a grand action has an outline of this name, in whatever instrument.
pub(super) fn draws(name: &str) -> bool {
    const MADE: [&str; 8] =
        ["capstan", "key, top", "key lead", "knuckle", "knuckle, core", "damper lever, wire", "damper", "sharp"];
    let is_shape = |entry: &shapes::Entry| matches!(entry, shapes::Entry::Shape(shape) if shape.name == name);
    MADE.contains(&name) || shapes::DRAWING.iter().any(is_shape)
}

/// Draws a grand action; `None` where the instrument is none.
pub(super) fn draw(instrument: &Instrument) -> Option<Drawing> {
    let drawn = placements(instrument, &drawn_angles(instrument));
    let parts = Parts::of(instrument, &drawn)?;
    let places = Places::new(instrument, &parts, &drawn);
    let scene = Scene { instrument, parts: &parts, places: &places, drawn: &drawn };
    let mut pieces = Vec::new();
    for entry in shapes::DRAWING {
        match entry {
            shapes::Entry::Shape(shape) => {
                let corners: Option<Vec<Vec2>> = shape
                    .corners
                    .iter()
                    .flat_map(|(place, offsets)| offsets.iter().map(|offset| (*place, *offset)))
                    .map(|(place, offset)| Some(places.find(place)?.offset(offset)))
                    .collect();
                if let Some(corners) = corners {
                    let look = Look { name: shape.name, on: shape.on, finish: shape.finish, smooth: shape.smooth };
                    pieces.extend(chain::carried(instrument, &parts, &drawn, &look, &corners));
                }
            }
            shapes::Entry::Made(make) => pieces.extend(make(&scene)),
        }
    }
    // What this drawing knows nothing of is shown by its contact curves. Every string has a zone of its own with the one damper that is drawn.
    for (index, zone) in instrument.zones.iter().enumerate() {
        let is_seen = |body: Option<usize>| body.is_none_or(|body| !parts.unseen.contains(&body));
        let is_shown = parts.shown_zones().contains(&Some(index)) || is_on_a_string(instrument, index);
        if !is_shown && is_seen(zone.disc_body) && is_seen(zone.curve_body) {
            pieces.extend(fallback::sides(zone));
        }
    }
    let is_pin = |body: &usize| {
        let is_bend = |chain: &[usize], pin: usize| chain.contains(body) && *body != pin;
        !is_bend(&parts.key, parts.key_pin) && !is_bend(&parts.hammer, parts.hammer[0]) && !parts.unseen.contains(body)
    };
    let pins = (0..instrument.bodies.len()).filter(is_pin).collect();
    Some(Drawing { pieces, pins, unseen: parts.unseen })
}

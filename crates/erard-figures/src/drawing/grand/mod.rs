//! A grand action drawn from its own geometry: every outline hangs on the pivots, felts and screws that it depicts, so
//! that what is moved in the file, by a screw or by a keyboard's grading moves in the picture.
//!
//! `assets/grand-outlines.toml`, read by `outlines`, is the drawing: for every outline its corners as offsets from
//! places of the geometry. `places` finds those places in an instrument. `made` draws what is round or varies in
//! number. The offsets are a concert grand's, drawn by hand in the style of an action of the early twentieth century,
//! to no particular maker's drawing; they give the wood its looks, and what touches its exact place comes from the
//! instrument.

mod chain;
mod made;
mod outlines;
mod parts;
mod places;

use super::{Drawing, fallback};
use chain::Look;
use erard::instrument::{Instrument, Vec2};
use made::Scene;
use outlines::{Entry, Made, drawing};
use parts::Parts;
use places::Places;

/// Whether a zone is a damper's felt on a string.
fn is_on_a_string(instrument: &Instrument, zone: usize) -> bool {
    instrument.strings.iter().filter_map(|string| string.damper).any(|damper| damper.zone == zone)
}

/// Whether the drawing of a grand action has an outline of this name, in whatever instrument.
pub(super) fn draws(name: &str) -> bool {
    const MADE: [&str; 6] = ["capstan", "key lead", "knuckle", "knuckle, core", "damper lever, wire", "damper"];
    let is_outline = |entry: &Entry| matches!(entry, Entry::Outline(outline) if outline.name == name);
    MADE.contains(&name) || drawing().iter().any(is_outline)
}

/// Draws a grand action; `None` where the instrument is none.
pub(super) fn draw(instrument: &Instrument) -> Option<Drawing> {
    let drawn = instrument.drawn();
    let parts = Parts::of(instrument, &drawn)?;
    let places = Places::new(instrument, &parts, &drawn);
    let scene = Scene { instrument, parts: &parts, places: &places, drawn: &drawn };
    let mut pieces = Vec::new();
    for entry in drawing() {
        match entry {
            Entry::Outline(shape) if shape.of_sharps.is_some_and(|it| it != instrument.roles.is_sharp) => {}
            Entry::Outline(shape) => {
                let corners: Option<Vec<Vec2>> = shape
                    .corners
                    .iter()
                    .flat_map(|corners| corners.by.iter().map(|offset| (corners.at, *offset)))
                    .map(|(place, offset)| Some(places.find(place)?.offset(offset)))
                    .collect();
                if let Some(corners) = corners {
                    let look = Look { name: &shape.name, on: shape.on, finish: shape.finish, smooth: !shape.sharp };
                    pieces.extend(chain::carried(instrument, &parts, &drawn, &look, &corners));
                }
            }
            Entry::Made { made } => pieces.extend(match made {
                Made::Capstan => made::capstan(&scene),
                Made::DamperHead => made::damper_head(&scene),
                Made::Knuckle => made::knuckle(&scene),
                Made::Leads => made::leads(&scene),
                Made::Tail => made::tail(&scene),
            }),
        }
    }
    // What this drawing knows nothing of is shown by its contact curves. Every string has a zone of its own with the
    // one damper that is drawn.
    for (index, zone) in instrument.zones.iter().enumerate() {
        let is_seen = |body: Option<usize>| body.is_none_or(|body| !parts.unseen.contains(&body));
        let is_shown = parts.shown_zones().contains(&Some(index)) || is_on_a_string(instrument, index);
        if !is_shown && is_seen(zone.disc_body) && is_seen(zone.curve_body) {
            pieces.extend(fallback::sides(zone));
        }
    }
    let is_pin = |body: &usize| {
        let is_bend = |chain: &[usize], pin: usize| chain.contains(body) && *body != pin;
        let is_device = instrument.is_arm(*body) || parts.unseen.contains(body);
        !is_bend(&parts.key, parts.key_pin) && !is_bend(&parts.hammer, parts.hammer[0]) && !is_device
    };
    let pins = (0..instrument.bodies.len()).filter(is_pin).collect();
    Some(Drawing { pieces, pins, unseen: parts.unseen })
}

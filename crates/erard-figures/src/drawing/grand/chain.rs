//! From a component's outline to pieces that bodies carry. A component that bends is a chain of bodies: its outline is
//! cut where they are hinged, so that it is drawn bent.

use super::parts::{Component, Parts};
use crate::drawing::material::Finish;
use crate::drawing::piece::{Carrier, Piece};
use erard::instrument::{Instrument, Placement, Vec2};

/// An outline before anything carries it.
pub(super) struct Look<'a> {
    pub name: &'a str,
    pub on: Component,
    pub finish: Finish,
    pub smooth: bool,
}

/// The pieces of an outline whose corners, mm, are given in its component's frame.
pub(super) fn carried(
    instrument: &Instrument,
    parts: &Parts,
    drawn: &[Placement],
    look: &Look<'_>,
    corners: &[Vec2],
) -> Vec<Piece> {
    let frame = parts.frame(look.on, drawn);
    let piece = |carrier: Carrier, corners: &[Vec2]| {
        let in_carrier = |corner: &Vec2| {
            let world = frame.to_world(corner.map(|c| 1e-3 * c));
            carrier.body().map_or(world, |body| drawn[body].from_world(world))
        };
        let outline_m = corners.iter().map(in_carrier).collect();
        Piece { name: look.name.to_owned(), carrier, finish: look.finish, outline_m, smooth: look.smooth }
    };
    let bodies = parts.bodies(look.on);
    match bodies {
        [] if look.on == Component::PedalRail => vec![piece(Carrier::Rail, corners)],
        [] => vec![piece(Carrier::Ground, corners)],
        [body] => vec![piece(Carrier::Body(*body), corners)],
        _ => {
            let bends = bends(instrument, bodies, &frame, drawn);
            let mut cuts: Vec<f64> = bends.iter().map(|bend| bend.x).collect();
            cuts.sort_by(f64::total_cmp);
            let mut out: Vec<Piece> = Vec::new();
            let mut from = f64::NEG_INFINITY;
            for to in cuts.into_iter().chain([f64::INFINITY]) {
                let slab = above(&above(corners, from, 1.0), -to, -1.0);
                if slab.len() >= 3 && to > from {
                    let middle = slab.iter().map(|corner| corner[0]).sum::<f64>() / slab.len() as f64;
                    out.push(piece(Carrier::Body(body_at(bodies[0], &bends, middle)), &slab));
                }
                from = to;
            }
            out
        }
    }
}

/// A hinge within a component.
struct Bend {
    parent: usize,
    child: usize,
    /// Where along the component, mm.
    x: f64,
    /// Whether the child lies at greater x than the hinge.
    is_child_after: bool,
}

/// The hinges at which a component bends, between two of its bodies. A body on which nothing is (a device of the
/// mechanics) is no piece of the wood.
fn bends(instrument: &Instrument, bodies: &[usize], frame: &Placement, drawn: &[Placement]) -> Vec<Bend> {
    let x_of = |world: Vec2| 1e3 * frame.from_world(world)[0];
    bodies
        .iter()
        .filter_map(|&child| {
            let parent = instrument.bodies[child].parent.filter(|parent| bodies.contains(parent))?;
            let x = x_of(drawn[child].pivot_m);
            let on_child = points(instrument, child);
            let mean = on_child.iter().map(|p| x_of(drawn[child].to_world(*p))).sum::<f64>() / on_child.len() as f64;
            (!on_child.is_empty()).then_some(Bend { parent, child, x, is_child_after: mean > x })
        })
        .collect()
}

/// The body that holds what lies at `x` along a component.
fn body_at(root: usize, bends: &[Bend], x: f64) -> usize {
    let mut body = root;
    let onward = |body: usize| {
        let next = |bend: &&Bend| bend.parent == body && (x > bend.x) == bend.is_child_after;
        bends.iter().find(next).map(|bend| bend.child)
    };
    while let Some(next) = onward(body) {
        body = next;
    }
    body
}

/// The points of a body where something touches it.
fn points(instrument: &Instrument, body: usize) -> Vec<Vec2> {
    use erard::instrument::Curve;
    let mut out = Vec::new();
    for zone in &instrument.zones {
        if zone.disc_body == Some(body) {
            out.push(zone.disc_center_m);
        }
        if zone.curve_body == Some(body) {
            out.push(match zone.curve {
                Curve::Line { point_m, .. } => point_m,
                Curve::Segment { from_m, .. } => from_m,
                Curve::Disc { center_m, .. } => center_m,
            });
        }
    }
    out
}

/// The part of a polygon where `sign * x >= least`. New corners are written twice, so that they stay sharp.
fn above(corners: &[Vec2], least: f64, sign: f64) -> Vec<Vec2> {
    if least == f64::NEG_INFINITY {
        return corners.to_vec();
    }
    let is_in = |corner: Vec2| sign * corner[0] >= least;
    let mut out = Vec::new();
    for (index, &a) in corners.iter().enumerate() {
        let b = corners[(index + 1) % corners.len()];
        if is_in(a) {
            out.push(a);
        }
        if is_in(a) != is_in(b) {
            let x = sign * least;
            let share = (x - a[0]) / (b[0] - a[0]);
            out.extend([[x, a[1] + share * (b[1] - a[1])]; 2]);
        }
    }
    out
}

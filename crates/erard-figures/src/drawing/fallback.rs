//! Something decent to look at for an instrument that is no grand action and whose file draws no parts: a rod from
//! every pivot to whatever the body touches or carries, and the contact curves themselves.

use super::material::Finish;
use super::piece::{Carrier, Piece};
use erard::instrument::{Curve, Instrument, Vec2, Zone};

/// Half the width of a rod, m.
const ROD: f64 = 2.5e-3;
/// Half the length that an endless line is drawn with, m.
const LINE: f64 = 10e-3;
/// Depth of the slab below a line, m.
const SLAB: f64 = 2.5e-3;
/// A disc of radius 0 is a point, and is drawn this large, m.
const POINT: f64 = 0.8e-3;

/// Pieces made up from bodies and zones.
pub(crate) fn pieces(instrument: &Instrument) -> Vec<Piece> {
    let mut out = Vec::new();
    for (index, body) in instrument.bodies.iter().enumerate() {
        for reach in reaches(instrument, index) {
            if reach[0].hypot(reach[1]) > ROD {
                // without a comma, so that the body is labelled
                let rod = capsule([0.0, 0.0], reach, ROD);
                out.push(piece(&body.name.replace(',', " "), Some(index), Finish::Wood, rod));
            }
        }
    }
    out.extend(instrument.zones.iter().flat_map(sides));
    out
}

/// Both sides of a zone: its contact curves.
pub(super) fn sides(zone: &Zone) -> [Piece; 2] {
    let (outline, finish) = match zone.curve {
        Curve::Line { point_m, normal } => (slab(point_m, normal), Finish::Cloth),
        Curve::Segment { from_m, to_m, rounding_m } => (capsule(from_m, to_m, rounding_m.max(POINT)), Finish::Leather),
        Curve::Disc { center_m, radius_m } => (circle(center_m, radius_m.max(POINT)), Finish::Leather),
    };
    let name = format!("{}, made up", zone.name);
    let disc = circle(zone.disc_center_m, zone.disc_radius_m.max(POINT));
    [piece(&name, zone.curve_body, finish, outline), piece(&name, zone.disc_body, Finish::Felt, disc)]
}

/// The points of a body worth a rod: its children's pivots and its contacts.
fn reaches(instrument: &Instrument, body: usize) -> Vec<Vec2> {
    let children = instrument.bodies.iter().filter(|child| child.parent == Some(body));
    let mut out: Vec<Vec2> = children.map(|child| child.pivot_m).collect();
    for zone in &instrument.zones {
        if zone.disc_body == Some(body) {
            out.push(zone.disc_center_m);
        }
        if zone.curve_body == Some(body) {
            out.push(match zone.curve {
                Curve::Line { point_m, normal } => below(point_m, normal, SLAB),
                Curve::Segment { from_m, to_m, .. } => [0.5 * (from_m[0] + to_m[0]), 0.5 * (from_m[1] + to_m[1])],
                Curve::Disc { center_m, .. } => center_m,
            });
        }
    }
    out
}

fn piece(name: &str, body: Option<usize>, finish: Finish, outline_m: Vec<Vec2>) -> Piece {
    Piece {
        name: name.to_owned(),
        carrier: body.map_or(Carrier::Ground, Carrier::Body),
        finish,
        outline_m,
        smooth: true,
    }
}

fn below(point: Vec2, normal: Vec2, depth: f64) -> Vec2 {
    [point[0] - depth * normal[0], point[1] - depth * normal[1]]
}

/// A slab whose upper face is the line.
fn slab(point: Vec2, normal: Vec2) -> Vec<Vec2> {
    let tangent = [normal[1] * LINE, -normal[0] * LINE];
    let deep = below(point, normal, SLAB);
    let ends = [
        [point[0] - tangent[0], point[1] - tangent[1]],
        [point[0] + tangent[0], point[1] + tangent[1]],
        [deep[0] + tangent[0], deep[1] + tangent[1]],
        [deep[0] - tangent[0], deep[1] - tangent[1]],
    ];
    // every corner twice: sharp
    ends.iter().flat_map(|end| [*end, *end]).collect()
}

/// A polygon that a smooth outline turns into a circle: its edges' midpoints lie on the circle.
pub(super) fn circle(center: Vec2, radius: f64) -> Vec<Vec2> {
    capsule(center, center, radius)
}

/// The points within `radius` of the segment.
pub(super) fn capsule(from: Vec2, to: Vec2, radius: f64) -> Vec<Vec2> {
    const HALF: usize = 6;
    let step = std::f64::consts::PI / HALF as f64;
    let corner = radius / (0.5 * step).cos();
    let heading = (to[1] - from[1]).atan2(to[0] - from[0]);
    let mut out = Vec::with_capacity(2 * HALF);
    for (end, turn) in [(to, heading), (from, heading + std::f64::consts::PI)] {
        for index in 0..HALF {
            let angle = turn + (index as f64 + 0.5 - 0.5 * HALF as f64) * step;
            out.push([end[0] + corner * angle.cos(), end[1] + corner * angle.sin()]);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::fixture::two_levers;

    #[test]
    fn every_body_and_zone_gets_a_shape() {
        let instrument = two_levers();
        let made_up = pieces(&instrument);
        for body in 0..instrument.bodies.len() {
            assert!(made_up.iter().any(|piece| piece.carrier == Carrier::Body(body)));
        }
        assert!(made_up.iter().any(|piece| piece.carrier == Carrier::Ground));
        assert!(made_up.iter().flat_map(|piece| &piece.outline_m).flatten().all(|c| c.is_finite()));
    }

    /// Midpoints of a circle's polygon lie on the circle, which is what the smooth outline passes through.
    #[test]
    fn a_circle_has_its_radius() {
        let outline = circle([1.0, 2.0], 0.5);
        for (index, a) in outline.iter().enumerate() {
            let b = outline[(index + 1) % outline.len()];
            let middle = [0.5 * (a[0] + b[0]) - 1.0, 0.5 * (a[1] + b[1]) - 2.0];
            assert!((middle[0].hypot(middle[1]) - 0.5).abs() < 1e-12);
        }
    }
}

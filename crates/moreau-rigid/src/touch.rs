//! Contact detection: finds the corner, edge or disc in contact, and its Jacobian rows.
//!
//! The pair is chosen once per step, at the predicted pose, and kept for the step: its rows are then smooth functions
//! of the pose.

use super::contact::{Contact, PolygonContact, Surface};
use super::model::Model;
use super::placement::{Placement, placed};
use super::rows::Row;
use moreau::Scalar;
use moreau::vector::{Vector, add, dot, scale, sub};

/// A pair that touches or may touch, in the frames of its carriers.
#[derive(Debug, Clone, Copy)]
pub(super) enum Touch<T> {
    /// Nothing is near.
    None,
    /// A disc (or a corner) on one body, the half-plane behind a line on another.
    Line { disc_body: usize, center: Vector<T>, radius: T, carrier: usize, point: Vector<T>, normal: Vector<T> },
    /// Two discs (or corners).
    Disc { disc_body: usize, center: Vector<T>, radius: T, carrier: usize, other: Vector<T>, rim: T },
}

/// Rows and distance of a pair.
pub(super) struct ContactRows<T> {
    /// Places of the rows, and the surface's outward normal; in the world.
    pub place: [Vector<T>; 2],
    /// Distance, m, positive apart.
    pub distance: T,
    /// Its rate.
    pub normal: Row<T>,
    /// Velocity of the disc's material along t = (n_y, -n_x), against the surface's carrier.
    pub tangential: Row<T>,
}

impl<T: Scalar> Touch<T> {
    /// The pair at these placements.
    pub(crate) fn rows(&self, places: &[Placement<T>]) -> ContactRows<T> {
        let (disc_body, carrier, at, normal, distance) = match *self {
            Touch::None => {
                let (distance, place) = (T::ONE / T::ZERO, [[T::ZERO; 2]; 2]);
                return ContactRows { place, distance, normal: Row::none(), tangential: Row::none() };
            }
            Touch::Line { disc_body, center, radius, carrier: body, point, normal } => {
                let carrier = placed(places, body);
                let center = placed(places, disc_body).point(center);
                let n = carrier.turn(normal);
                let distance = dot(n, sub(center, carrier.point(point))) - radius;
                // A corner's rows stand on the line: corners of one block over one line then have the same slip, to the
                // bit of what they are above it. Else sticking corners would ask for two slips that are nearly the
                // same, at the price of any impulse.
                let down = if radius == T::ZERO { distance } else { radius };
                (disc_body, body, sub(center, scale(n, down)), n, distance)
            }
            Touch::Disc { disc_body, center, radius, carrier: body, other, rim } => {
                let center = placed(places, disc_body).point(center);
                let line = sub(center, placed(places, body).point(other));
                let length = dot(line, line).sqrt();
                // Two discs on one centre have no direction; any will do.
                let n = if T::ZERO < length { scale(line, T::ONE / length) } else { [T::ZERO, T::ONE] };
                (disc_body, body, sub(center, scale(n, radius)), n, length - rim - radius)
            }
        };
        let row = |d: Vector<T>| Row::relative(places, carrier, disc_body, at, d);
        ContactRows { place: [at, normal], distance, normal: row(normal), tangential: row([normal[1], -normal[0]]) }
    }
}

/// Outward unit normal of the edge from a to b, and its length. Outward is on the right.
fn edge<T: Scalar>(a: Vector<T>, b: Vector<T>) -> (Vector<T>, T) {
    let way = sub(b, a);
    let length = dot(way, way).sqrt();
    ([way[1] / length, -(way[0] / length)], length)
}

/// What the disc of a contact meets at these placements.
pub(super) fn disc_touch<T: Scalar>(contact: &Contact<'_, T>, places: &[Placement<T>]) -> Touch<T> {
    let Contact { disc_body, center, radius, surface_body: carrier, .. } = *contact;
    let line = |point, normal| Touch::Line { disc_body, center, radius, carrier, point, normal };
    let corner = |other, rim| Touch::Disc { disc_body, center, radius, carrier, other, rim };
    // The disc's centre in the surface's frame.
    let seen = || placed(places, carrier).seen(placed(places, disc_body).point(center));
    match contact.surface {
        Surface::Line { point, normal } => line(point, normal),
        Surface::Disc { center: other, radius: rim } => corner(other, rim),
        Surface::Segment { from, to, depth } => {
            let c = sub(seen(), from);
            let (normal, length) = edge(from, to);
            let along = -(normal[1] * c[0]) + normal[0] * c[1];
            if along < T::ZERO {
                corner(from, T::ZERO)
            } else if along > length {
                corner(to, T::ZERO)
            } else if dot(normal, c) < -depth {
                Touch::None
            } else {
                line(from, normal)
            }
        }
        Surface::Polygon { corners } => {
            let c = seen();
            let (i, _) = farthest(corners, |a, n| dot(n, sub(c, a)));
            let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
            let (normal, length) = edge(a, b);
            // Of a point outside, the nearest place is on this edge, or a corner if the edge ends before it; inside, it
            // is on this edge.
            let along = -(normal[1] * (c[0] - a[0])) + normal[0] * (c[1] - a[1]);
            let outside = dot(normal, sub(c, a)) > T::ZERO;
            if outside && !(along >= T::ZERO && along <= length) {
                let far = |p: Vector<T>| dot(sub(c, p), sub(c, p));
                let nearest = corners.iter().fold(a, |best, &p| if far(p) < far(best) { p } else { best });
                corner(nearest, T::ZERO)
            } else {
                line(a, normal)
            }
        }
    }
}

/// The edge of a polygon at which `height(corner, normal)` is largest, and that height.
fn farthest<T: Scalar>(corners: &[Vector<T>], height: impl Fn(Vector<T>, Vector<T>) -> T) -> (usize, T) {
    let mut best = (0, -(T::ONE / T::ZERO));
    for i in 0..corners.len() {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        let h = height(a, edge(a, b).0);
        if h > best.1 {
            best = (i, h);
        }
    }
    best
}

/// A placement with its rotation worked out.
#[derive(Clone, Copy)]
struct Frame<T> {
    at: Vector<T>,
    sin: T,
    cos: T,
}

impl<T: Scalar> Frame<T> {
    fn new(place: Placement<T>) -> Self {
        let (sin, cos) = place.angle.sin_cos_any();
        Frame { at: place.at, sin, cos }
    }

    fn out(&self, p: Vector<T>) -> Vector<T> {
        add(self.at, self.turn(p))
    }

    fn turn(&self, v: Vector<T>) -> Vector<T> {
        [self.cos * v[0] - self.sin * v[1], self.sin * v[0] + self.cos * v[1]]
    }
}

/// One of the two polygons, where it is.
#[derive(Clone, Copy)]
struct Placed<'m, T> {
    body: usize,
    corners: &'m [Vector<T>],
    frame: Frame<T>,
}

impl<T: Scalar> Placed<'_, T> {
    fn corner(&self, i: usize) -> Vector<T> {
        self.frame.out(self.corners[i % self.corners.len()])
    }

    /// Outward normal of edge i, in the body's frame.
    fn normal(&self, i: usize) -> Vector<T> {
        edge(self.corners[i], self.corners[(i + 1) % self.corners.len()]).0
    }

    /// Radius of a circle about the frame's origin that holds the polygon.
    fn reach(&self) -> T {
        self.corners.iter().fold(T::ZERO, |most, c| most.max(dot(*c, *c))).sqrt()
    }

    /// The lowest corner of the other polygon over a line with this normal, and its height.
    fn lowest(&self, point: Vector<T>, normal: Vector<T>) -> (usize, T) {
        let mut best = (0, T::ONE / T::ZERO);
        for k in 0..self.corners.len() {
            let h = dot(normal, sub(self.corner(k), point));
            if h < best.1 {
                best = (k, h);
            }
        }
        best
    }

    /// A point of the other polygon against edge i of this one.
    fn meets(&self, i: usize, other: &Self, point: Vector<T>) -> Touch<T> {
        Touch::Line {
            disc_body: other.body,
            center: point,
            radius: T::ZERO,
            carrier: self.body,
            point: self.corners[i],
            normal: self.normal(i),
        }
    }
}

/// Where two polygons touch at these placements: up to two points. Polygons further apart than `margin` do not.
///
/// The edge that separates the polygons most (or is least deep in the other) is the reference. The other polygon's edge
/// that faces it is cut off where the reference ends; what is left of it ends at the two points.
pub(super) fn polygon_touch<T: Scalar>(
    pair: &PolygonContact<'_, T>,
    places: &[Placement<T>],
    margin: T,
) -> [Touch<T>; 2] {
    let none = [Touch::None; 2];
    let at = |body, corners| Placed { body, corners, frame: Frame::new(placed(places, body)) };
    let (first, second) = (at(pair.first, pair.first_corners), at(pair.second, pair.second_corners));
    let apart = sub(first.frame.at, second.frame.at);
    let reach = first.reach() + second.reach() + margin;
    if dot(apart, apart) > reach * reach {
        return none;
    }
    let separation = |a: &Placed<'_, T>, b: &Placed<'_, T>| {
        farthest(a.corners, |corner, normal| b.lowest(a.frame.out(corner), a.frame.turn(normal)).1)
    };
    let (of_second, of_first) = (separation(&second, &first), separation(&first, &second));
    if of_second.1.max(of_first.1) > margin {
        return none;
    }
    let (reference, other, i, turned) =
        if of_first.1 > of_second.1 { (first, second, of_first.0, true) } else { (second, first, of_second.0, false) };
    let n = reference.frame.turn(reference.normal(i));
    let along = [-n[1], n[0]];
    let start = reference.corner(i);
    let length = dot(along, sub(reference.corner(i + 1), start));
    let (facing, _) = farthest(other.corners, |_, normal| -dot(n, other.frame.turn(normal)));
    // The facing edge runs against the reference: its end is low, its beginning high.
    let (to, from) = (other.corner(facing + 1), other.corner(facing));
    let (low, high) = (dot(along, sub(to, start)), dot(along, sub(from, start)));
    let [near, far] = if low > length || high < T::ZERO || low >= high {
        // Corner over corner: only what is deepest.
        [reference.meets(i, &other, other.corners[other.lowest(start, n).0]), Touch::None]
    } else {
        let [a, b] = [facing + 1, facing].map(|k| other.corners[k % other.corners.len()]);
        let cut = |at: T| {
            let part = (at - low) / (high - low);
            [a[0] + part * (b[0] - a[0]), a[1] + part * (b[1] - a[1])]
        };
        [
            reference.meets(i, &other, if low >= T::ZERO { a } else { cut(T::ZERO) }),
            reference.meets(i, &other, if high <= length { b } else { cut(length) }),
        ]
    };
    // Along t = (n_y, -n_x) of the second polygon's normal: against `along` of the second, with `along` of the first.
    if turned { [near, far] } else { [far, near] }
}

/// Point at which two surfaces touch, or would touch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ContactPoint<T> {
    /// Position in the world, m.
    pub at: Vector<T>,
    /// Outward unit normal in the world: of the line, disc, plate or polygon that is touched; for two polygons, of the
    /// one whose edge is touched.
    pub normal: Vector<T>,
    /// Distance, m; positive when the surfaces are separate.
    pub distance: T,
}

impl<T: Scalar> Model<'_, T> {
    /// Where two polygons touch at these placements, in the order of [`Model::polygon_laws`]; nothing if they are
    /// further apart than `margin`.
    pub(crate) fn polygon_points(
        &self,
        places: &[Placement<T>],
        contact: usize,
        margin: T,
    ) -> [Option<ContactPoint<T>>; 2] {
        match self.polygons.get(contact).filter(|_| places.len() >= self.bodies.len()) {
            Some(pair) => polygon_touch(pair, places, margin).map(|touch| point_of(&touch, places)),
            None => [None; 2],
        }
    }
}

fn point_of<T: Scalar>(touch: &Touch<T>, places: &[Placement<T>]) -> Option<ContactPoint<T>> {
    let rows = touch.rows(places);
    let [at, normal] = rows.place;
    (!matches!(touch, Touch::None)).then_some(ContactPoint { at, normal, distance: rows.distance })
}

/// All pairs of a model at these placements, point by point.
pub(super) fn touches<T: Scalar, const N: usize>(
    model: &Model<'_, T>,
    places: &[Placement<T>],
    margin: T,
    found: &mut [Touch<T>; N],
) {
    for (touch, contact) in found.iter_mut().zip(model.contacts) {
        *touch = disc_touch(contact, places);
    }
    let from = model.contacts.len();
    for (i, pair) in model.polygons.iter().enumerate() {
        let points = polygon_touch(pair, places, margin);
        for (k, point) in points.into_iter().enumerate() {
            if let Some(touch) = found.get_mut(from + 2 * i + k) {
                *touch = point;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    extern crate std;

    use std::vec::Vec;

    use super::*;
    use moreau::GROUND;

    fn block(half: [f64; 2]) -> [Vector<f64>; 4] {
        let [x, y] = half;
        [[-x, -y], [x, -y], [x, y], [-x, y]]
    }

    fn place(x: f64, y: f64, angle: f64) -> Placement<f64> {
        Placement { at: [x, y], angle }
    }

    /// Distances and places of the points of a block (0.2 x 0.1) over a slab that is `wide`, both about their own
    /// middles.
    fn points(wide: f64, at: Placement<f64>) -> Vec<(f64, f64)> {
        let (upper, lower) = (block([0.1, 0.05]), block([wide, 0.05]));
        let pair = PolygonContact {
            first: 0,
            first_corners: &upper,
            second: GROUND,
            second_corners: &lower,
            restitution: 0.0,
            kinetic: 0.0,
            limit: 0.0,
        };
        let places = [at];
        let found = polygon_touch(&pair, &places, 1e-9);
        found
            .iter()
            .filter(|t| !matches!(t, Touch::None))
            .map(|t| {
                let rows = t.rows(&places);
                // A turn of the block about its middle lifts the point by its lever.
                (rows.distance, rows.normal.velocity(&[[0.0, 0.0, 1.0]]))
            })
            .collect()
    }

    fn near(found: &[(f64, f64)], expected: &[(f64, f64)]) {
        assert_eq!(found.len(), expected.len(), "{found:?}");
        for (a, b) in found.iter().zip(expected) {
            assert!((a.0 - b.0).abs() < 1e-12 && (a.1 - b.1).abs() < 1e-12, "{found:?} {expected:?}");
        }
    }

    /// On a wide slab the block's corners touch; over its edge the slab's corner and the block's; on a narrow one the
    /// slab's corners. The points are in the order of t = (1, 0).
    #[test]
    fn common_parts_of_edges() {
        near(&points(1.0, place(0.0, 0.1, 0.0)), &[(0.0, -0.1), (0.0, 0.1)]);
        near(&points(0.15, place(0.1, 0.1, 0.0)), &[(0.0, -0.1), (0.0, 0.05)]);
        near(&points(0.05, place(0.02, 0.1, 0.0)), &[(0.0, -0.07), (0.0, 0.03)]);
        near(&points(0.05, place(10.0, 0.1, 0.0)), &[]);
        near(&points(0.05, place(0.2, 0.1, 0.0)), &[]);
    }

    /// Tilted, one corner touches and the other stands over the slab by the sine.
    #[test]
    fn a_tilted_block_touches_with_one_corner() {
        let angle = 0.1_f64;
        let (s, c) = angle.sin_cos();
        let height = 0.05 + 0.1 * s + 0.05 * c;
        near(&points(1.0, place(0.0, height, angle)), &[(0.0, -0.1 * c + 0.05 * s), (0.2 * s, 0.1 * c + 0.05 * s)]);
    }

    /// A disc against a plate: over it, past its end, below it; and against a polygon: over an edge and over a corner.
    #[test]
    fn finite_surfaces_end() {
        let corners = block([0.5, 0.5]);
        let contact = |surface, radius| Contact {
            disc_body: 0,
            center: [0.0; 2],
            radius,
            surface_body: GROUND,
            surface,
            restitution: 0.0,
            kinetic: 0.0,
            limit: 0.0,
            belt: 0.0,
        };
        let plate = Surface::Segment { from: [0.5, 0.0], to: [-0.5, 0.0], depth: 0.1 };
        let polygon = Surface::Polygon { corners: &corners };
        for (surface, radius, x, y, expected) in [
            (plate, 0.1, 0.2, 0.3, 0.2),
            (plate, 0.1, 0.8, 0.4, 0.4),
            (plate, 0.0, 0.2, -0.05, -0.05),
            (plate, 0.0, 0.2, -0.2, f64::INFINITY),
            (polygon, 0.1, 0.2, 0.9, 0.3),
            (polygon, 0.1, 0.8, 0.9, 0.4),
            (polygon, 0.0, 0.1, 0.45, -0.05),
            (polygon, 0.0, 10.0, 0.5, 9.5),
        ] {
            let places = [place(x, y, 0.0)];
            let found = disc_touch(&contact(surface, radius), &places).rows(&places).distance;
            assert!(found == expected || (found - expected).abs() < 1e-12, "{surface:?} at {x}, {y}: {found}");
        }
    }
}

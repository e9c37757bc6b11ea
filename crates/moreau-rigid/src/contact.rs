//! Rigid contacts: discs against lines, discs, plates and polygons, and polygons against each other.

use super::model::{finite, unit};
use moreau::Scalar;
use moreau::vector::{Vector, cross, dot, sub};

/// Surface that a contact's disc touches, in the frame of the body that carries it.
#[derive(Debug, Clone, Copy)]
pub enum Surface<'m, T> {
    /// Half-plane behind an infinite line. A disc touches it even beside the body that carries the line.
    Line {
        /// A point of the line, m.
        point: Vector<T>,
        /// Outward unit normal.
        normal: Vector<T>,
    },
    /// A disc.
    Disc {
        /// Centre, m.
        center: Vector<T>,
        /// Radius, m.
        radius: T,
    },
    /// Plate of finite length. Beyond its ends a disc touches the end point; a point touches nothing.
    Segment {
        /// Start of the plate, m.
        from: Vector<T>,
        /// End of the plate, m. The outward side is on the right of the way from `from` to `to`, as for the edges of a
        /// polygon.
        to: Vector<T>,
        /// Thickness, m. A disc deeper than this behind the line is beyond the plate and not in contact.
        depth: T,
    },
    /// Convex polygon.
    Polygon {
        /// Corners, m, counter-clockwise, at least three.
        corners: &'m [Vector<T>],
    },
}

/// Rigid unilateral contact: a disc (radius 0: a point) of one body against a surface of another.
#[derive(Debug, Clone, Copy)]
pub struct Contact<'m, T> {
    /// Carrier of the disc, or [`GROUND`](moreau::GROUND).
    pub disc_body: usize,
    /// Disc centre in its carrier's frame, m.
    pub center: Vector<T>,
    /// Disc radius, m.
    pub radius: T,
    /// Carrier of the surface, or [`GROUND`](moreau::GROUND).
    pub surface_body: usize,
    /// Surface that the disc touches.
    pub surface: Surface<'m, T>,
    /// Coefficient of restitution, 0 to 1; [`super::ImpactLaw`] defines its meaning.
    pub restitution: T,
    /// Coulomb friction coefficient while slipping.
    pub kinetic: T,
    /// Static friction coefficient, up to which the contact sticks; at least the kinetic one.
    pub limit: T,
    /// Speed of the surface in its own frame (a belt), m/s, positive along t = (n_y, -n_x), where n is the surface's
    /// outward normal.
    pub belt: T,
}

/// Rigid unilateral contact of two convex polygons. It has up to two contact points, each a corner of one polygon
/// against an edge of the other.
#[derive(Debug, Clone, Copy)]
pub struct PolygonContact<'m, T> {
    /// Carrier of the first polygon, or [`GROUND`](moreau::GROUND).
    pub first: usize,
    /// Corners of the first polygon in its carrier's frame, m, counter-clockwise, at least three.
    pub first_corners: &'m [Vector<T>],
    /// Carrier of the second polygon, or [`GROUND`](moreau::GROUND).
    pub second: usize,
    /// Corners of the second polygon in its carrier's frame, m, counter-clockwise, at least three.
    pub second_corners: &'m [Vector<T>],
    /// Coefficient of restitution, 0 to 1; [`super::ImpactLaw`] defines its meaning.
    pub restitution: T,
    /// Coulomb friction coefficient while slipping.
    pub kinetic: T,
    /// Static friction coefficient, up to which the contact sticks; at least the kinetic one.
    pub limit: T,
}

/// What the laws of a contact point are made of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Matter<T> {
    pub restitution: T,
    pub kinetic: T,
    pub limit: T,
    pub belt: T,
}

impl<T: Scalar> Matter<T> {
    fn is_sound(&self) -> bool {
        finite(&[self.restitution, self.kinetic, self.limit, self.belt])
            && self.restitution >= T::ZERO
            && self.restitution <= T::ONE
            && self.kinetic >= T::ZERO
            && self.limit >= self.kinetic
    }
}

impl<T: Scalar> Contact<'_, T> {
    pub(super) fn matter(&self) -> Matter<T> {
        let Contact { restitution, kinetic, limit, belt, .. } = *self;
        Matter { restitution, kinetic, limit, belt }
    }

    pub(super) fn is_sound(&self) -> bool {
        let surface = match self.surface {
            Surface::Line { point, normal } => finite(&point) && unit(normal),
            Surface::Disc { center, radius } => finite(&center) && radius.finite() && radius >= T::ZERO,
            Surface::Segment { from, to, depth } => {
                let way = sub(to, from);
                finite(&from) && finite(&to) && dot(way, way) > T::ZERO && depth.finite() && depth > T::ZERO
            }
            Surface::Polygon { corners } => convex(corners),
        };
        surface
            && finite(&[self.center[0], self.center[1], self.radius])
            && self.radius >= T::ZERO
            && self.matter().is_sound()
    }
}

impl<T: Scalar> PolygonContact<'_, T> {
    pub(super) fn matter(&self) -> Matter<T> {
        let PolygonContact { restitution, kinetic, limit, .. } = *self;
        Matter { restitution, kinetic, limit, belt: T::ZERO }
    }

    pub(super) fn is_sound(&self) -> bool {
        convex(self.first_corners) && convex(self.second_corners) && self.matter().is_sound()
    }
}

/// Whether every corner but an edge's own lies on the left of that edge: convex, counter-clockwise, once around.
fn convex<T: Scalar>(corners: &[Vector<T>]) -> bool {
    let n = corners.len();
    n >= 3
        && corners.iter().all(|c| finite(c))
        && (0..n).all(|i| {
            let (a, b) = (corners[i], corners[(i + 1) % n]);
            (0..n).all(|k| k == i || k == (i + 1) % n || cross(sub(b, a), sub(corners[k], a)) > T::ZERO)
        })
}

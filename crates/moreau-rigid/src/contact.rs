//! Contacts: discs against lines, discs, plates and polygons, and polygons against each other.

use super::model::{finite, unit};
use moreau::Scalar;
use moreau::vector::{Vector, cross, dot, sub};

/// The surface that a contact's disc meets, in its carrier's frame.
#[derive(Debug, Clone, Copy)]
pub enum Surface<'m, T> {
    /// The half-plane behind a line, which has no ends: whatever is beside a body that carries one rests on it too.
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
    /// A plate that ends: beyond its ends a disc meets the end's point, a point meets nothing.
    Segment {
        /// Where it begins, m.
        from: Vector<T>,
        /// Where it ends, m. Outward is on the right of the way from `from` to `to`, as for the edges of a polygon.
        to: Vector<T>,
        /// Thickness, m: what is deeper behind the line is past the plate and not touched.
        depth: T,
    },
    /// A convex polygon.
    Polygon {
        /// Its corners, m, counter-clockwise, three at least.
        corners: &'m [Vector<T>],
    },
}

/// A rigid unilateral contact: a disc (radius 0: a point) of one body against a surface of another.
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
    /// The surface.
    pub surface: Surface<'m, T>,
    /// Coefficient of restitution, 0 to 1, of the law that [`super::ImpactLaw`] names.
    pub restitution: T,
    /// Coulomb friction coefficient while slipping.
    pub kinetic: T,
    /// Friction coefficient up to which it sticks; at least the kinetic one.
    pub limit: T,
    /// Speed of the surface in its own frame (a belt), m/s, along t = (n_y, -n_x) with n the surface's outward normal.
    pub belt: T,
}

/// A rigid unilateral contact of two convex polygons. It closes at up to two points, each a corner of one against an
/// edge of the other.
#[derive(Debug, Clone, Copy)]
pub struct PolygonContact<'m, T> {
    /// Carrier of the first polygon, or [`GROUND`](moreau::GROUND).
    pub first: usize,
    /// Its corners in its carrier's frame, m, counter-clockwise, three at least.
    pub first_corners: &'m [Vector<T>],
    /// Carrier of the second polygon, or [`GROUND`](moreau::GROUND).
    pub second: usize,
    /// Its corners, likewise.
    pub second_corners: &'m [Vector<T>],
    /// Coefficient of restitution, 0 to 1, of the law that [`super::ImpactLaw`] names.
    pub restitution: T,
    /// Coulomb friction coefficient while slipping.
    pub kinetic: T,
    /// Friction coefficient up to which it sticks; at least the kinetic one.
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

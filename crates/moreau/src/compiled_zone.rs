//! A contact zone in the form that the step reads: constants are precomputed, and numbers that are read together are
//! stored together.

use crate::description::{ContactCurve, Zone};
use crate::felt::FeltLaw;
use crate::pose::Pose;
use crate::real::Real;
use crate::support::Support;
use crate::vector::{Vector, add, dot, scale, sub};

/// Shape from which distances are measured.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Core {
    /// A line; `axis` is its outward unit normal.
    Line,
    /// A segment from `from` along the unit vector `axis`.
    Segment,
    /// The point `from`.
    Point,
}

/// A disc against a curve: compression = `level` - distance of the disc's centre from the curve's core (for a line,
/// from its carrier's pivot along the normal).
#[derive(Debug, Clone, Copy)]
pub(crate) struct CompiledZone<T> {
    disc_body: usize,
    curve_body: usize,
    core: Core,
    /// Whether there is Coulomb friction.
    pub slides: bool,
    /// Coefficient of Coulomb friction, or 0.
    pub friction: T,
    /// Whether its felt has a set-valued loss.
    pub dry: bool,
    /// Loss factor eta of this felt, or 0.
    pub eta: T,
    center: Vector<T>,
    axis: Vector<T>,
    level: T,
    pub felt: FeltLaw<T>,
    from: Vector<T>,
    length: T,
    /// Radius of the disc, from its centre to the contact point of the uncompressed felt.
    radius: T,
}

impl<T: Real> CompiledZone<T> {
    pub(crate) fn of(zone: &Zone<T>) -> Self {
        let o = [T::ZERO; 2];
        let (core, axis, from, length, size) = match zone.curve {
            ContactCurve::Line { point, normal } => (Core::Line, normal, o, T::ZERO, dot(point, normal)),
            ContactCurve::Segment { from, direction, length, rounding } => {
                (Core::Segment, direction, from, length, rounding)
            }
            ContactCurve::Disc { center, radius } => (Core::Point, o, center, T::ZERO, radius),
        };
        CompiledZone {
            disc_body: zone.disc_body,
            curve_body: zone.curve_body,
            core,
            slides: zone.friction.is_some(),
            friction: zone.friction.unwrap_or(T::ZERO),
            dry: zone.felt.dry().is_some(),
            eta: zone.felt.dry().unwrap_or(T::ZERO),
            center: zone.center,
            axis,
            level: zone.radius + size,
            felt: FeltLaw::of(&zone.felt),
            from,
            length,
            radius: zone.radius,
        }
    }

    /// Sets the zone's curve to be compliant.
    pub(crate) fn set_yielding(&mut self) {
        self.felt.set_yielding();
    }

    /// The disc's centre in the world.
    #[inline(always)]
    pub(crate) fn center<const B: usize>(&self, pose: &Pose<T, B>) -> Vector<T> {
        pose.point(self.disc_body, self.center)
    }

    /// Compression at a pose (negative apart), given the disc's centre, and the curve's outward unit normal there.
    #[inline(always)]
    pub(crate) fn compression_and_normal<const B: usize>(
        &self,
        pose: &Pose<T, B>,
        center: Vector<T>,
    ) -> (T, Vector<T>) {
        match self.core {
            Core::Line if self.curve_body >= B => (self.level - dot(center, self.axis), self.axis),
            Core::Line => {
                let n = pose.rotate(self.curve_body, self.axis);
                (self.level - dot(sub(center, pose.pivot(self.curve_body)), n), n)
            }
            Core::Segment => {
                let t = pose.rotate(self.curve_body, self.axis);
                let from = pose.point(self.curve_body, self.from);
                let along = dot(sub(center, from), t).max(T::ZERO).min(self.length);
                let (d, n) = length_and_direction(sub(center, add(from, scale(t, along))), [-t[1], t[0]]);
                (self.level - d, n)
            }
            Core::Point => {
                let other = pose.point(self.curve_body, self.from);
                let (d, n) = length_and_direction(sub(center, other), [T::ZERO, T::ONE]);
                (self.level - d, n)
            }
        }
    }

    /// Compression at a pose (negative apart), without forces.
    #[inline(always)]
    pub(crate) fn compression<const B: usize>(&self, pose: &Pose<T, B>) -> T {
        self.compression_and_normal(pose, self.center(pose)).0
    }

    /// The row G at a pose in relative velocities, with an entry for every joint: dg/dt = G w, with G = -n .
    /// (v_disc(c) - v_curve(c)), exact although the contact point moves.
    pub(crate) fn compression_row<const B: usize>(&self, support: &Support<T, B>, pose: &Pose<T, B>) -> [T; B] {
        let center = self.center(pose);
        let (_, normal) = self.compression_and_normal(pose, center);
        let mut row = [T::ZERO; B];
        pose.turning_row(support, center, normal, &mut row);
        let mut dense = [T::ZERO; B];
        support.spread(&row, T::ONE, &mut dense);
        dense
    }

    /// The contact point, on the curve.
    #[inline(always)]
    pub(crate) fn contact_point<const B: usize>(
        &self,
        pose: &Pose<T, B>,
        compression: T,
        normal: Vector<T>,
    ) -> Vector<T> {
        sub(self.center(pose), scale(normal, self.radius - compression))
    }
}

/// |a| and a/|a|; `fallback` (a unit vector) where a vanishes, so that no division by zero can start a NaN.
#[inline(always)]
fn length_and_direction<T: Real>(a: Vector<T>, fallback: Vector<T>) -> (T, Vector<T>) {
    let squared = dot(a, a);
    let usable = T::from_f64(1e-30).lt(squared);
    let length = T::select(usable, squared, T::ONE).sqrt();
    let inverse = T::ONE / length;
    let n = [T::select(usable, a[0] * inverse, fallback[0]), T::select(usable, a[1] * inverse, fallback[1])];
    (T::only(usable, length), n)
}

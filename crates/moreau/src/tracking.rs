//! Points and zones that a caller follows from step to step without computing the pose of the whole mechanism.

use crate::model::Model;
use crate::pose::Pose;
use crate::real::{Scalar, sin_cos};
use crate::vector::Vector;

/// Point of a body whose position is computed from the bodies that carry it and no others. For a body hinged on the
/// ground the result is bit-identical to [`Pose::point`].
#[derive(Debug, Clone, Copy)]
pub struct TrackedPoint<T, const B: usize> {
    /// From the body next to the ground to the one that has the point: each with the place of what follows in its
    /// frame, m.
    links: [(usize, Vector<T>); B],
    count: usize,
    /// The first body's pivot, or the point itself where it belongs to the ground, m.
    root: Vector<T>,
}

impl<T: Scalar, const B: usize> TrackedPoint<T, B> {
    /// Returns a tracked point of a body (m, in the body's frame). Any body index from `B` on is the ground.
    pub fn of<const Z: usize>(model: &Model<T, B, Z>, body: usize, point: Vector<T>) -> Self {
        let mut tracked = TrackedPoint { links: [(0, [T::ZERO; 2]); B], count: 0, root: point };
        let mut carrier = body;
        while carrier < B {
            for k in (0..tracked.count).rev() {
                tracked.links[k + 1] = tracked.links[k];
            }
            tracked.links[0] = (carrier, tracked.root);
            tracked.count += 1;
            tracked.root = model.tree.pivot[carrier];
            carrier = model.parent(carrier);
        }
        tracked
    }

    /// Returns the point's position, m, and velocity, m/s, in the world, given absolute angles, rad, and angular
    /// velocities, rad/s.
    #[inline(always)]
    pub fn motion(&self, angle: &[T; B], velocity: &[T; B]) -> [Vector<T>; 2] {
        let mut moving = [self.root, [T::ZERO; 2]];
        for &(body, arm) in &self.links[..self.count] {
            let (mut s, mut c) = ([T::ZERO], [T::ZERO]);
            sin_cos(&[angle[body]], &mut s, &mut c);
            carry(&mut moving, arm, s[0], c[0], velocity[body]);
        }
        moving
    }

    /// Returns [`TrackedPoint::motion`] of two points, bit-identical; faster, because the sines and cosines of both are
    /// computed side by side.
    #[inline(always)]
    pub fn motions(points: [&Self; 2], angle: &[T; B], velocity: &[T; B]) -> [[Vector<T>; 2]; 2] {
        let mut moving = points.map(|p| [p.root, [T::ZERO; 2]]);
        for k in 0..points[0].count.max(points[1].count).min(B) {
            let links = points.map(|p| p.links[k]);
            let (mut s, mut c) = ([T::ZERO; 2], [T::ZERO; 2]);
            sin_cos(&links.map(|(body, _)| angle[body]), &mut s, &mut c);
            for i in 0..2 {
                let (body, arm) = links[i];
                if k < points[i].count {
                    carry(&mut moving[i], arm, s[i], c[i], velocity[body]);
                }
            }
        }
        moving
    }
}

/// From a pivot (place, m, and velocity, m/s) to the end of a body's arm.
#[inline(always)]
fn carry<T: Scalar>([x, v]: &mut [Vector<T>; 2], arm: Vector<T>, s: T, c: T, rate: T) {
    let pivot = *x;
    x[0] += (c * arm[0]).sub_product(s, arm[1]);
    x[1] += (s * arm[0]).add_product(c, arm[1]);
    v[0] += (pivot[1] - x[1]) * rate;
    v[1] += (x[0] - pivot[0]) * rate;
}

/// Bound on how far the joints may turn before an open zone can touch.
///
/// A zone's compression changes by at most its longest lever times the angle, for every joint that it depends on. So a
/// zone that is open by c stays open while sum lever |dq| < c. This is a strict bound, not an estimate.
#[derive(Debug, Clone, Copy)]
pub struct Clearance<T, const B: usize> {
    zone: usize,
    /// Absolute angles at which the zone was looked at, rad.
    angle: [T; B],
    /// How far it was open there, m.
    open: T,
}

impl<T: Scalar, const B: usize> Clearance<T, B> {
    /// Returns the clearance of a zone at absolute angles, rad, and its compression, m. The clearance is `None` if the
    /// zone touches.
    pub fn of<const Z: usize>(model: &Model<T, B, Z>, zone: usize, angle: &[T; B]) -> (Option<Self>, T) {
        let compression = Pose::of(model, angle).compression(model, zone);
        ((compression < T::ZERO).then_some(Clearance { zone, angle: *angle, open: -compression }), compression)
    }

    /// Returns whether the zone is certainly still open at absolute angles, rad.
    #[inline(always)]
    pub fn holds<const Z: usize>(&self, model: &Model<T, B, Z>, angle: &[T; B]) -> bool {
        let support = &model.supports[self.zone];
        let mut closer = T::ZERO;
        for (k, j) in support.joints() {
            let mut turned = angle[j] - self.angle[j];
            let parent = model.parent(j);
            if parent < B {
                turned -= angle[parent] - self.angle[parent];
            }
            closer += support.lever(k) * turned.abs();
        }
        // The last thousandth is left to rounding.
        closer < T::from_f64(0.999) * self.open
    }
}

//! Kinematics of a model at a given pose: compressions, Jacobian rows, the driven point.

use crate::description::GROUND;
use crate::model::Model;
use crate::pose::Pose;
use crate::real::Scalar;
use crate::support::Support;
use crate::vector::{Vector, dot};

impl<T: Scalar, const B: usize> Pose<T, B> {
    /// Returns the pose of a model at given absolute angles, rad.
    pub fn of<const Z: usize>(model: &Model<T, B, Z>, angle: &[T; B]) -> Self {
        let mut pose = Pose::new();
        pose.place(&model.tree, model.first_moments(), angle);
        pose
    }

    /// Returns the Jacobian row, m, that maps absolute angular velocities to `n . velocity` of a point. The point is
    /// given in a body's frame, m. The row is zero for the ground or an index without a body.
    pub fn velocity_row<const Z: usize>(
        &self,
        model: &Model<T, B, Z>,
        body: usize,
        point: Vector<T>,
        n: Vector<T>,
    ) -> [T; B] {
        let support = Support::of_point(&model.tree, body, point);
        let mut row = [T::ZERO; B];
        self.turning_row(&support, self.point(body, point), n, &mut row);
        let mut dense = [T::ZERO; B];
        support.spread(&row, T::ONE, &mut dense);
        model.tree.row_to_angles(&mut dense);
        dense
    }

    /// Returns the compression of a zone at this pose, m; negative when it is open.
    pub fn compression<const Z: usize>(&self, model: &Model<T, B, Z>, zone: usize) -> T {
        model.compiled[zone].compression(self)
    }

    /// Returns the Jacobian row G of a zone's compression for absolute angular velocities, m: dg/dt = G v. The row is
    /// valid whether or not the zone touches.
    pub fn compression_row<const Z: usize>(&self, model: &Model<T, B, Z>, zone: usize) -> [T; B] {
        let mut row = model.compiled[zone].compression_row(&model.supports[zone], self);
        model.tree.row_to_angles(&mut row);
        row
    }

    /// Returns the contact point of a zone on its curve, m, in the world; if the zone is open, the point where it would
    /// touch.
    pub fn contact_point<const Z: usize>(&self, model: &Model<T, B, Z>, zone: usize) -> Vector<T> {
        let zone = &model.compiled[zone];
        let (compression, normal) = zone.compression_and_normal(self, zone.center(self));
        zone.contact_point(self, compression, normal)
    }
}

impl<T: Scalar, const B: usize, const Z: usize> Model<T, B, Z> {
    /// Returns the world coordinate of the driven point along the site's direction, m; zero without a site.
    pub fn site_position(&self, angle: &[T; B]) -> T {
        self.site.as_ref().map_or(T::ZERO, |s| dot(s.direction, Pose::of(self, angle).point(s.body, s.point)))
    }
}

const _: () = assert!(GROUND > 1 << 16, "the ground's index lies beyond any body's");

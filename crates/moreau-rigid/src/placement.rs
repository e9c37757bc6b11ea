//! Position and velocity of one body.

use moreau::vector::{Vector, add, sub};
use moreau::{GROUND, Scalar};

/// Position of a body: its centre of mass and its angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement<T> {
    /// Centre of mass in the world, m.
    pub at: Vector<T>,
    /// Absolute angle, rad, counter-clockwise.
    pub angle: T,
}

impl<T: Scalar> Placement<T> {
    /// A vector of the body's frame, in the world.
    pub(super) fn turn(&self, v: Vector<T>) -> Vector<T> {
        let (s, c) = self.angle.sin_cos_any();
        [c * v[0] - s * v[1], s * v[0] + c * v[1]]
    }

    /// A point of the body's frame, in the world.
    pub(crate) fn point(&self, point: Vector<T>) -> Vector<T> {
        add(self.at, self.turn(point))
    }

    /// A point of the world, in the body's frame.
    pub(super) fn seen(&self, point: Vector<T>) -> Vector<T> {
        let (s, c) = self.angle.sin_cos_any();
        let [x, y] = sub(point, self.at);
        [c * x + s * y, c * y - s * x]
    }

    pub(super) fn origin() -> Self {
        Placement { at: [T::ZERO; 2], angle: T::ZERO }
    }
}

/// The placement of a body or of the ground.
pub(super) fn placed<T: Scalar>(places: &[Placement<T>], body: usize) -> Placement<T> {
    if body == GROUND { Placement::origin() } else { places[body] }
}

/// Velocity of a body: of its centre of mass, m/s, and its angular velocity, rad/s.
pub type Twist<T> = [T; 3];

//! Places the bodies of an instrument from their absolute angles: the kinematics of its tree of hinges.

use moreau::vector::{add, sub};

use super::{Instrument, Vec2};

/// Placement of a frame in another one: of a body in the world, or of a piece in its part. The point x of the frame
/// lies at `pivot_m` + R(`angle_rad`) x in the other one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The frame's origin, m: a body's pivot.
    pub pivot_m: Vec2,
    /// Angle, rad, counter-clockwise positive: a body's absolute angle.
    pub angle_rad: f64,
}

impl Placement {
    /// Placement of the world's own frame, for points of the ground.
    pub const GROUND: Self = Self { pivot_m: [0.0; 2], angle_rad: 0.0 };

    /// Converts a direction from this frame to the world.
    #[must_use]
    pub fn direction_to_world(&self, direction: Vec2) -> Vec2 {
        if self.angle_rad == 0.0 { direction } else { turned_by(direction, self.angle_rad) }
    }

    /// Converts a point, m, from this frame to the world.
    #[must_use]
    pub fn to_world(&self, point_m: Vec2) -> Vec2 {
        add(self.pivot_m, self.direction_to_world(point_m))
    }

    /// Converts a direction from the world to this frame.
    #[must_use]
    pub fn direction_from_world(&self, direction: Vec2) -> Vec2 {
        turned_by(direction, -self.angle_rad)
    }

    /// Converts a point, m, from the world to this frame.
    #[must_use]
    pub fn from_world(&self, world_m: Vec2) -> Vec2 {
        self.direction_from_world(sub(world_m, self.pivot_m))
    }
}

/// A direction turned counter-clockwise by an angle, rad.
pub(super) fn turned_by([x, y]: Vec2, angle_rad: f64) -> Vec2 {
    let (sin, cos) = libm::sincos(angle_rad);
    [cos * x - sin * y, sin * x + cos * y]
}

impl Instrument {
    /// Returns the absolute angles of the bodies as drawn, rad.
    #[must_use]
    pub fn drawn_angles(&self) -> Vec<f64> {
        self.bodies.iter().map(|body| body.angle_rad).collect()
    }

    /// Places all bodies at absolute angles, rad. A missing or non-finite angle falls back to the one the body was
    /// drawn with, so that a picture can still be made of a run that went wrong.
    #[must_use]
    pub fn placements(&self, angles_rad: &[f64]) -> Vec<Placement> {
        let mut placed = Vec::with_capacity(self.bodies.len());
        self.place(angles_rad, &mut placed);
        placed
    }

    /// Writes [`Instrument::placements`] to a list. It does not allocate if the list was filled before.
    pub(crate) fn place(&self, angles_rad: &[f64], placed: &mut Vec<Placement>) {
        placed.clear();
        for (index, body) in self.bodies.iter().enumerate() {
            let angle_rad = angles_rad.get(index).copied().filter(|angle| angle.is_finite()).unwrap_or(body.angle_rad);
            let carrier = body.parent.map_or(Placement::GROUND, |parent| placed[parent]);
            placed.push(Placement { pivot_m: carrier.to_world(body.pivot_m), angle_rad });
        }
    }

    /// Places all bodies as drawn.
    #[must_use]
    pub fn drawn(&self) -> Vec<Placement> {
        self.placements(&[])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    /// A child hinged at the tip of a quarter-turned parent sits where the tip went, and its own angle is absolute.
    #[test]
    fn a_child_rides_on_its_parent() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        let child = grand.bodies.iter().position(|body| body.parent.is_some()).unwrap();
        let parent = grand.bodies[child].parent.unwrap();
        let mut angles = grand.drawn_angles();
        (angles[parent], angles[child]) = (FRAC_PI_2, 0.0);
        let placed = grand.placements(&angles);
        let ([x, y], [px, py]) = (grand.bodies[child].pivot_m, placed[parent].pivot_m);
        let tip = placed[child].pivot_m;
        assert!((tip[0] - (px - y)).abs() < 1e-15 && (tip[1] - (py + x)).abs() < 1e-15, "{tip:?}");
        let end = placed[child].to_world([0.05, 0.0]);
        assert!((end[0] - tip[0] - 0.05).abs() < 1e-15 && (end[1] - tip[1]).abs() < 1e-15, "{end:?}");
        let back = placed[parent].from_world(tip);
        assert!((back[0] - x).abs() < 1e-15 && (back[1] - y).abs() < 1e-15, "{back:?}");
    }

    #[test]
    fn angles_that_are_missing_or_not_numbers_fall_back_to_the_drawing() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        assert_eq!(grand.placements(&grand.drawn_angles()), grand.drawn());
        assert_eq!(grand.placements(&[f64::NAN, f64::INFINITY]), grand.drawn());
    }
}

//! Where every body is, for a given set of absolute angles.

use erard::instrument::{Instrument, Vec2};

/// A body's frame in the world.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Placement {
    /// The pivot, which is the frame's origin, m.
    pub pivot_m: Vec2,
    /// Absolute angle, rad, counter-clockwise.
    pub angle_rad: f64,
}

impl Placement {
    /// The world's own frame, for what the ground carries.
    pub const GROUND: Self = Self { pivot_m: [0.0, 0.0], angle_rad: 0.0 };

    /// A point of the world, seen from the body.
    pub fn from_world(&self, world_m: Vec2) -> Vec2 {
        let (sin, cos) = self.angle_rad.sin_cos();
        let [x, y] = [world_m[0] - self.pivot_m[0], world_m[1] - self.pivot_m[1]];
        [cos * x + sin * y, cos * y - sin * x]
    }

    /// A point of the body, seen in the world.
    pub fn to_world(&self, point_m: Vec2) -> Vec2 {
        let (sin, cos) = self.angle_rad.sin_cos();
        [self.pivot_m[0] + cos * point_m[0] - sin * point_m[1], self.pivot_m[1] + sin * point_m[0] + cos * point_m[1]]
    }
}

/// The frames of all bodies. A missing or non-finite angle falls back to the one the body was drawn with, so that a
/// picture can still be made of a run that went wrong.
pub fn placements(instrument: &Instrument, angles_rad: &[f64]) -> Vec<Placement> {
    let mut placed: Vec<Placement> = Vec::with_capacity(instrument.bodies.len());
    for (index, body) in instrument.bodies.iter().enumerate() {
        let angle_rad = angles_rad.get(index).copied().filter(|angle| angle.is_finite()).unwrap_or(body.angle_rad);
        let carrier = body.parent.map_or(Placement::GROUND, |parent| placed[parent]);
        placed.push(Placement { pivot_m: carrier.to_world(body.pivot_m), angle_rad });
    }
    placed
}

/// The angles that the instrument is drawn with.
pub fn drawn_angles(instrument: &Instrument) -> Vec<f64> {
    instrument.bodies.iter().map(|body| body.angle_rad).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::drawing::fixture::two_levers;
    use std::f64::consts::FRAC_PI_2;

    /// A child hinged at the tip of a quarter-turned parent sits where the tip went, and its own angle is absolute.
    #[test]
    fn a_child_rides_on_its_parent() {
        let instrument = two_levers();
        let placed = placements(&instrument, &[FRAC_PI_2, 0.0]);
        let tip = placed[1].pivot_m;
        assert!((tip[0] - 0.01).abs() < 1e-15 && (tip[1] - 0.12).abs() < 1e-15, "{tip:?}");
        let end = placed[1].to_world([0.05, 0.0]);
        assert!((end[0] - 0.06).abs() < 1e-15 && (end[1] - 0.12).abs() < 1e-15, "{end:?}");
    }

    #[test]
    fn angles_that_are_missing_or_not_numbers_fall_back_to_the_drawing() {
        let instrument = two_levers();
        let drawn = placements(&instrument, &drawn_angles(&instrument));
        assert_eq!(placements(&instrument, &[]), drawn);
        assert_eq!(placements(&instrument, &[f64::NAN, f64::INFINITY]), drawn);
    }
}

//! What can be seen of a mechanism from outside: where its points are, how fast they move, how near its zones are.

use moreau::{GROUND, Model, Pose};

use crate::grand::rise_m;
use crate::instrument::Instrument;

/// What can be seen of a mechanism. Indices follow the instrument's bodies and zones.
pub trait Visible {
    /// World coordinate of the driven point along the drive's direction (down), m.
    fn site_position(&self) -> f64;
    /// Compression of a zone now, m.
    fn gap(&self, zone: usize) -> f64;
    /// Speed of a point of a body now, m/s.
    fn point_speed(&self, body: usize, point: [f64; 2]) -> f64;
    /// A point of a body in the world now, m.
    fn point(&self, body: Option<usize>, point: [f64; 2]) -> [f64; 2];
}

/// Height of the hammer's strike point, m; zero where there is no hammer.
pub fn head_height(instrument: &Instrument, seen: &dyn Visible) -> f64 {
    instrument.roles.hammer.map_or(0.0, |h| rise_m(seen.point(Some(h), instrument.roles.hammer_head_m)))
}

/// A model in one pose, moving.
pub struct Sight<'a, const B: usize, const Z: usize> {
    /// What it is.
    pub model: &'a Model<f64, B, Z>,
    /// Where its bodies are.
    pub pose: &'a Pose<f64, B>,
    /// Absolute angular velocities, rad/s.
    pub velocity: &'a [f64; B],
}

impl<const B: usize, const Z: usize> Visible for Sight<'_, B, Z> {
    fn site_position(&self) -> f64 {
        self.model.site().map_or(0.0, |s| {
            let x = self.pose.point(s.body, s.point);
            s.direction[0] * x[0] + s.direction[1] * x[1]
        })
    }

    fn gap(&self, zone: usize) -> f64 {
        self.pose.gap(self.model, zone)
    }

    fn point_speed(&self, body: usize, point: [f64; 2]) -> f64 {
        let along = |n| {
            let row = self.pose.velocity_row(self.model, body, point, n);
            row.iter().zip(self.velocity).map(|(r, v)| r * v).sum::<f64>()
        };
        libm::hypot(along([1.0, 0.0]), along([0.0, 1.0]))
    }

    fn point(&self, body: Option<usize>, point: [f64; 2]) -> [f64; 2] {
        self.pose.point(body.unwrap_or(GROUND), point)
    }
}

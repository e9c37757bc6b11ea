//! Rules for grand actions only, which would differ in an upright: the directions of key and hammer, the names of
//! parts, and the pose of parts on a scale.
//!
//! All other code uses only bodies, zones and their roles. Measurements get from here the upward direction, the
//! whippen, and the pose with a level shank.

mod anatomy;
mod parts;
mod scale;

pub use anatomy::{Anatomy, AnatomyError};
pub use parts::{Parts, pedal_down};
pub use scale::{falling_moment_n_m, front_weight_g, strike_weight_g, whippen_assist_g, whippen_weight_g};

use crate::instrument::Vec2;

/// Direction of the pressed key front in the world: down.
pub const KEY_DOWN: Vec2 = [0.0, -1.0];

/// Height of a point in the world, m: the coordinate along which hammer and damper rise.
#[must_use]
pub fn rise_m(point_m: Vec2) -> f64 {
    point_m[1]
}

//! Rules that hold for a grand only, and would be different in an upright: which way key and hammer go, which part is
//! which, and how parts lie when they are weighed.
//!
//! All else takes an instrument as it comes: bodies, zones and their roles. Who measures an action asks here where up
//! is, what is the whippen and what the shank's level pose.

mod anatomy;
mod parts;
mod scale;

pub use anatomy::{Anatomy, AnatomyError};
pub use parts::{Parts, pedal_down};
pub use scale::{falling_moment_n_m, front_weight_g, strike_weight_g, whippen_weight_g};

use crate::instrument::Vec2;

/// Direction of the pressed key front in the world: down.
pub const KEY_DOWN: Vec2 = [0.0, -1.0];

/// Height of a point in the world, m: the coordinate along which hammer and damper rise.
#[must_use]
pub fn rise_m(point_m: Vec2) -> f64 {
    point_m[1]
}

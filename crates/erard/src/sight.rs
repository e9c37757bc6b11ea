//! What can be seen of a mechanism from outside.

pub use moreau_sizes::{Meeting, Visible};

use crate::grand::rise_m;
use crate::instrument::Instrument;

/// Height of the hammer's strike point, m; zero where there is no hammer.
pub fn head_height(instrument: &Instrument, seen: &dyn Visible) -> f64 {
    instrument.roles.hammer.map_or(0.0, |h| rise_m(seen.point(Some(h), instrument.roles.hammer_head_m)))
}

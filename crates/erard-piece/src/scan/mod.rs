//! Readings of sensors under the keys or at the hammers, or of contacts, while a piece or a case is played, together
//! with the ground truth: for builders who derive notes from sensors.
//!
//! - [`Sensor`], [`Scans`]: bits, rate and noise of a sensor; the readings of all keys, sample by sample;
//! - [`Case`], [`play_cases`]: motions of a finger that mislead simple algorithms, played on simulated actions;
//! - [`Truth`]: when and how fast every hammer met its string, and when each key set its damper down. It comes from the
//!   simulated actions alone: where no string was struck, there is no note.

mod cases;
mod finger;
mod sensor;
mod truth;

pub use cases::{Case, play_cases};
pub use sensor::{MAX_RATE_HZ, Reading, Scans, Sensor, Shank, stops};
pub use truth::{Strike, Truth, Window};

//! The distances that a technician regulates, measured in simulation as he measures them on a piano.
//!
//! `anatomy` finds out which body and zone is which, `bench` holds the action and the finger that presses it, and
//! `distances` is what is measured, with the trade's convention for each.

mod anatomy;
mod bench;
mod distances;

pub(crate) use anatomy::Anatomy;
pub use anatomy::AnatomyError;
pub use distances::{Distances, MOVED_M, MeasureError, Protocol, Trial, measure};

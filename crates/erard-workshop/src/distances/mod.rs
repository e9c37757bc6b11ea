//! The distances that a technician regulates, measured in simulation as he measures them on a piano.
//!
//! `anatomy` finds out which body and zone is which, `fixture` holds the action and the finger that presses it, and
//! `measure` is what is measured, with the trade's convention for each.

mod anatomy;
mod fixture;
mod measure;

pub(crate) use anatomy::Anatomy;
pub use anatomy::AnatomyError;
pub use measure::{DistanceError, Distances, MOVED_M, Protocol, Trial, measure};

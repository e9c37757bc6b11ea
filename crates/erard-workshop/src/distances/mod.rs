//! Distances that a technician regulates, measured in simulation as on a piano.
//!
//! `fixture` holds the action and the finger that presses it, `measure` the distances by the trade's conventions.

mod fixture;
mod measure;

pub use fixture::DistanceError;
pub use measure::{Distances, Protocol, measure};

pub(crate) use measure::Trial;

//! The distances that a technician regulates, measured in simulation as he measures them on a piano.
//!
//! `fixture` holds the action and the finger that presses it, and
//! `measure` is what is measured, with the trade's convention for each.

mod fixture;
mod measure;

pub use measure::{DistanceError, Distances, Protocol, measure};

pub(crate) use measure::Trial;

//! The laboratory: what shows that the simulation is right, and how fast it is.
//!
//! Measured strokes beside the models ([`compare`]), published measurements ([`validate`]), the papers' claims ([`reproduce`]) and
//! what benchmarks time ([`benchmarks`]).

pub mod benchmarks;
pub mod compare;
pub mod reproduce;
pub mod validate;

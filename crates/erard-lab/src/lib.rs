//! The laboratory: what shows that the simulation is right, and how fast it is.
//!
//! Recordings made ready ([`recording`]), beside the models ([`compare`]) and fitted by them ([`fit`]), published measurements ([`validate`]), the papers' claims ([`reproduce`]) and
//! what benchmarks time ([`benchmarks`]).

pub mod benchmarks;
pub mod compare;
pub mod fit;
pub mod recording;
pub mod reproduce;
mod struck;
pub mod validate;

//! Planar non-smooth multibody dynamics: trees of hinged rigid bodies, felts between them, dry friction as a set-valued
//! law, and Moreau-Jean time-stepping. Named after Jean Jacques Moreau.
//!
//! The inner step is [`step()`] in `step.rs`; the equations it implements are in this crate's `README.md` beside it.
//!
//! Three types, not one: the immutable [`Model`] (what the mechanism is), the mutable [`State`] (where it is now) and the
//! [`Scratch`] (what a step needs and what it leaves to be read: forces, impulses, contact points).
//!
//! No standard library, no heap, no unsafe code, no panic in a step: the crate can live in firmware. It is generic over the
//! scalar ([`Real`]) and over its sizes: `B` bodies, `Z` zones, `N` set-valued laws.
//!
//! Units are the caller's, as long as they are consistent; the project uses SI. Angles are counter-clockwise.
#![no_std]
// Kernels index several arrays by one body number; iterators over one of them hide that.
#![allow(clippy::needless_range_loop)]

mod adaptive;
mod batch;
mod contact;
mod ease;
mod forces;
mod form;
mod joints;
mod laws;
mod ledger;
mod linear;
mod model;
pub mod osnsp;
mod path;
mod pose;
mod real;
mod repose;
pub mod rigid;
mod settings;
mod state;
mod step;
mod survey;
mod vector;
mod zones;

pub use adaptive::{Accuracy, ControlledStep, Controller, Halves, controlled_step};
pub use contact::Contact;
pub use ledger::{Energies, Ledger};
pub use model::{Body, Curve, Exponent, Felt, GROUND, Model, ModelError, Site, Spring, Zone};
pub use osnsp::Solver;
pub use pose::Pose;
pub use real::{COSINE, Mask, Real, SINE, Scalar};
pub use repose::Repose;
pub use settings::{FrictionLaw, Settings};
pub use state::{Input, Scratch, State};
pub use step::{LanesReport, Outcome, StepReport, step, step_lanes};
pub use vector::Vector;

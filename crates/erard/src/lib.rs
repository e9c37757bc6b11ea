//! The grand piano action, simulated.
//!
//! Data flows one way: instrument file and stroke -> assembled mechanism -> steps -> run (series and events).

pub mod assembly;
pub mod equilibrium;
pub mod events;
pub mod files;
pub mod grand;
pub mod instrument;
pub mod keyboard;
pub mod mechanism;
pub mod one_dof;
pub mod player;
pub mod run;
pub mod sight;
pub mod simulation;
pub mod stroke;

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

pub use instrument::Instrument;
pub use moreau::{Outcome, Settings};
pub use player::{Action, ActionError, Drive, Input, Reading, Snapshot};

//! Simulation of the grand piano action: computes the motion and the forces of the mechanism from a force or a position
//! of the finger. This crate promises nothing: any release may change what it contains. Use the crate `erard`.
//!
//! ```
//! use erard_core::{Action, Input, Instrument};
//!
//! let grand = Instrument::builtin("concert-grand")?;
//! let mut action = Action::new(&grand)?;              // at rest, 50 us a step; Action::with(&grand, settings) for others
//! let reading = action.step(Input::Force(4.5));       // owned, no allocation, no ledger
//! println!("{} {}", reading.key_m, reading.hammer_rise_m_per_s);
//! # assert!(reading.key_m > 0.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! Data flows one way: instrument file and stroke -> the player ([`Action`], [`keyboard::Keys`]) -> readings, observers
//! ([`player::Recorder`], [`player::LedgerBook`], [`events::EventDetector`]) -> runs ([`press`], [`simulate`]).
//!
//! The loop over the steps of a run is `RunLoop::fixed` (`run/run_loop.rs`); each step solves the equations at the top
//! of [`moreau::step()`].
//!
//! SI units; key and finger positive downward, the hammer upward. Nothing here uses a clock or starts a thread.

pub mod assembly;
pub mod damper;
pub mod events;
pub mod files;
mod fnv1a;
pub mod gradient;
pub mod grand;
pub mod identity;
mod index;
pub mod instrument;
pub mod instrument_spec;
pub mod key;
pub mod keyboard;
pub mod knocks;
pub mod level;
pub mod mechanism;
pub mod one_dof;
pub mod parameter;
pub mod player;
mod progress;
mod radiation;
#[cfg(feature = "recordings")]
pub mod recording;
pub mod run;
pub mod saved;
pub mod strings;
pub mod stroke;
pub mod trust;
mod units;

pub use index::IndexError;
pub use instrument::Instrument;
pub use mechanism::Impact;
pub use moreau::{FrictionLaw, Settings, Solver, StepOutcome};
pub use player::{Action, ActionError, Drive, Hand, Input, Reading, Snapshot, SnapshotError};
pub use progress::Progress;
pub use run::{Events, Run, Setup, SimulationError, press, simulate, simulate_observed};

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

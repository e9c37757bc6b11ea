//! The grand piano action, simulated.

pub use erard_core::keyboard::{Keyboard, Keys};
pub use erard_core::{
    Action, ActionError, Events, FrictionLaw, Hand, Impact, IndexError, Input, Instrument, Progress, Reading, Run,
    Settings, Setup, SimulationError, Snapshot, SnapshotError, Solver, StepOutcome, press,
};

/// The examples of the README are tests.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;

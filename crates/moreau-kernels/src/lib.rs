//! The engine in compiled form: mechanisms of any size behind one dynamic call per step.
//!
//! `moreau` is generic over its sizes, so that its loops are unrolled. Only this crate compiles its step for
//! piano-sized mechanisms; crates that depend on this one compile no kernel. An [`OwnedDescription`] lists the parts of
//! a mechanism. The mechanism runs in the smallest size that holds it ([`Size`]), as one of these:
//!
//! - [`Mechanism`]: one mechanism with its own working memory;
//! - [`Bank`]: many mechanisms, stepped one after the other, that sleep while nothing changes;
//! - [`SideBySide`]: several mechanisms of one topology in the processor's vector lanes (on [`Group`], which has a
//!   fixed size);
//! - [`Tangents`]: one mechanism with the derivatives of its motion.
//!
//! The first three share the code of their outputs ([`Probes`], [`StepOutput`], [`Impact`]).

mod bank;
mod controlled;
mod description;
mod engine;
mod impact;
mod lanes;
mod mechanism;
mod observation;
mod side_by_side;
mod size;
mod surfaces;
mod tangents;

pub use bank::{Bank, Tick, bank};
pub use controlled::InputDuring;
pub use description::{OwnedDescription, Probes};
pub use impact::Impact;
pub use lanes::{Group, Lanes};
pub use mechanism::{
    Mechanism, Readout, Saved, StatePart, StepOutput, Stepping, mechanism, open_ledger, update_energies,
};
pub use moreau::impact_in_flight;
pub use observation::{LaneObserver, Observation, lane_observer};
pub use side_by_side::{SideBySide, side_by_side};
pub use size::{EveryBody, Size, WorkspaceOfSix};
pub use surfaces::{Halving, Parts, Surfaces, TellNumbers};
pub use tangents::{DIRECTIONS, Number, Tangents, tangents};

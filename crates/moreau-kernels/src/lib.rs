//! The engine, compiled: mechanisms of any size behind one dynamic call per step.
//!
//! `moreau` is generic over its sizes, so that its loops are unrolled. This crate is the only one that instantiates its step for
//! piano-sized mechanisms: whoever depends on it compiles no kernel. A [`OwnedDescription`] says what the mechanism is; it runs in the smallest
//! size that holds it ([`Size`]), as
//!
//! - [`Mechanism`]: one, with its own working memory;
//! - [`Bank`]: many that are stepped one after the other and sleep while nothing changes;
//! - [`SideBySide`]: several of one topology in the processor's vector lanes (on [`Group`], which has a fixed size);
//! - [`Tangents`]: one, with the derivatives of its motion.
//!
//! The first three look at what happens through the same code ([`Marks`], [`Meeting`]).

mod bank;
mod description;
mod engine;
mod flight;
mod lanes;
mod mechanism;
mod placed;
mod side_by_side;
mod size;
mod surfaces;
mod tangents;

pub use bank::{Bank, Tick, bank};
pub use description::{Marks, OwnedDescription};
pub use flight::{Meeting, met_in_flight};
pub use lanes::{Group, Lanes};
pub use mechanism::{InputDuring, Mechanism, Saved, View, mechanism};
pub use placed::{Placed, Visible, placed};
pub use side_by_side::{SideBySide, side_by_side};
pub use size::{EveryBody, Size};
pub use surfaces::{Surfaces, TellNumbers};
pub use tangents::{DIRECTIONS, Number, Tangents, tangents};

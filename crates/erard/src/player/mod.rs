//! The player: an action that is stepped from outside, and the one loop over steps that every run is.

mod action;
pub(crate) mod hand;
mod hand_stroke;
mod input;
mod inside;
mod ledger;
mod losses;
mod motion;
mod reactions;
mod recorder;
#[doc(hidden)] // for `erard-workshop`, which plays strokes in lanes by the same rules as a run
pub mod run_loop;
mod snapshot;

pub use action::{Action, ActionError, PlayError, Reading};
pub use hand::{Hand, HandError};
pub use hand_stroke::{HandStroke, Muscle, least_jerk, press_by_hand};
pub use input::{Drive, Input, force, motion, rigid};
pub use inside::Inside;
pub use ledger::LedgerBook;
pub use losses::{ContactLoss, Loss, LossRecorder, Losses, PinLoss};
pub use reactions::{PinSeries, ReactionRecorder, Reactions};
pub use recorder::{Recorded, Recorder};
pub use run_loop::Observer;
pub use snapshot::{BYTES as SNAPSHOT_BYTES, MechanismState, Snapshot, SnapshotError, VERSION as SNAPSHOT_VERSION};

//! The player: an action that is stepped from outside, and the one loop over steps that every run is.

mod action;
#[doc(hidden)] // for `erard-workshop`, which plays strokes in lanes by the same rules as a run
pub mod course;
mod gesture;
pub(crate) mod hand;
mod input;
mod inside;
mod ledger;
mod losses;
mod motion;
mod reactions;
mod recorder;
pub(crate) mod snapshot;

pub use action::{Action, ActionError, PlayError, Reading};
pub use course::Observer;
pub use gesture::{Gesture, Muscle, least_jerk, press_by_hand};
pub use hand::{Hand, HandError};
pub use input::{Drive, Input, force, motion, rigid};
pub use inside::Inside;
pub use ledger::LedgerBook;
pub use losses::{ContactLoss, Loss, LossRecorder, Losses, PinLoss};
pub use reactions::{PinSeries, ReactionRecorder, Reactions};
pub use recorder::{Recorded, Recorder};
pub use snapshot::{MARK as SNAPSHOT_MARK, MechanismState, Snapshot, SnapshotError};

//! The player: an action that is stepped from outside, its rest, and the observers of its steps.

mod action;
pub mod equilibrium;
mod hand;
mod input;
mod inside;
mod ledger;
mod losses;
mod motion;
mod observer;
mod reactions;
mod recorder;
#[doc(hidden)] // for `erard-workshop`, which plays strokes in lanes by the same rules as a run
pub mod rest;
mod rest_pose;
pub(crate) mod snapshot;
mod work;

pub use action::{Action, ActionError, PlayError, Reading};
pub use hand::{Hand, HandError, HandInput, Joints};
pub use input::{
    Drive, Fingertip, Input, InputRange, MAX_FORCE_N, MAX_POSITION_M, MAX_SPEED_M_PER_S, check, force, motion, rigid,
};
pub use inside::Inside;
pub use ledger::LedgerBook;
pub use losses::{ContactLoss, Loss, LossRecorder, Losses, PinLoss};
pub use observer::Observer;
pub use reactions::{PinSeries, ReactionRecorder, Reactions};
pub use recorder::{BodySeries, Recorded, Recorder, StringSeries, ZoneSeries};
pub use rest_pose::{AtRest, BLOW_N, HELD_S, LET_UP_S, RestKind, RestPose};
pub use snapshot::{MARK as SNAPSHOT_MARK, MechanismState, Snapshot, SnapshotError, StepSettings};
pub use work::{ControlWork, Work};

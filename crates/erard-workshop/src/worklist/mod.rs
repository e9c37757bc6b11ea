//! Work list of a key, worked out line by line, each after the ones before it.
//!
//! `readings` is what a technician reads off the key, `hand` what a hand does to it and in which steps, `twin` a model
//! adjusted to the readings, `weights` the balance weight for a friction weight, `list` the lines and what stays out,
//! `planner` the copy on which they are worked out, `plan` the order of work, `aims` the targets of the screws' lines,
//! `leads` the choice of leads, `finish` the list as it is carried out, `written` the file with the work done, and
//! `settle` a regulation that ends with the aftertouch in its range. For all weighed keys, `keyboard` is the list by
//! operation, and `keyboard_copy` carries it out on copies. A line is tried on a simulated copy before the next is
//! worked out; its effect on the copy's readings is what is expected on the piano.

mod aims;
mod finish;
mod hand;
mod keyboard;
mod keyboard_copy;
mod leads;
mod list;
mod plan;
mod planner;
mod readings;
mod settle;
mod twin;
mod weights;
mod written;

pub use hand::Work;
pub use keyboard::{
    AimFrom, KeyLine, KeyboardGoal, KeyboardList, Leverage, Operation, SECTION_ENDS, Weights, keyboard_list,
};
pub use keyboard_copy::carry_out;
pub use list::{Item, Left, Why, Worklist};
pub use plan::worklist;
pub use planner::Priority;
pub use readings::{ReadingQuantity, Readings};
pub use settle::{GaveUp, Settled, is_usual_aftertouch, regulate_to_aftertouch, usual_aftertouch_m};
pub use twin::twin;

use thiserror::Error;

use crate::measure::MeasureError;
use crate::regulate::RegulateError;

/// Reason why no list could be worked out.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum WorklistError {
    /// The screws could not be tried.
    #[error(transparent)]
    Regulate(#[from] RegulateError),
    /// The copy could not be measured.
    #[error(transparent)]
    Measure(#[from] MeasureError),
}

/// Result of work on a list.
pub(crate) type WorklistResult<T> = Result<T, WorklistError>;

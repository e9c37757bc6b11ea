//! The to-do list of a key, worked out line by line, each after the ones before it.
//!
//! `readings` is what a technician reads off the key, `hand` what a hand does to it and how finely, `twin` a model that
//! has been brought to the readings, `weights` which balance weight goes with a friction weight, `plan` the order of
//! work, `aims` what the screws' lines are to come to, `leads` which leads, `written` the file on which it has been
//! done, and `settle` a regulation that ends with the aftertouch in its range. Over all keys that were weighed,
//! `keyboard` is the list by operation, and `keyboard_copy` carries it out on copies. A line is tried on a simulated
//! copy before the next is worked out; what it changes of the copy's readings is what it is expected to change of the
//! piano's.

mod aims;
mod hand;
mod keyboard;
mod keyboard_copy;
mod leads;
mod plan;
mod readings;
mod settle;
mod twin;
mod weights;
mod written;

pub use hand::Work;
pub use keyboard::{AimFrom, KeyLine, KeyboardGoal, KeyboardList, Operation, SECTION_ENDS, Weights, keyboard_list};
pub use keyboard_copy::carry_out;
pub use plan::{Item, Left, Priority, Why, Worklist, worklist};
pub use readings::{Quantity, Readings};
pub use settle::{GaveUp, Settled, is_usual_aftertouch, regulate_to_aftertouch, usual_aftertouch_m};
pub use twin::twin;

use thiserror::Error;

use crate::measure::MeasureError;
use crate::regulate::RegulateError;

/// Why no list could be worked out.
#[derive(Debug, Error)]
pub enum WorklistError {
    /// The screws could not be tried.
    #[error(transparent)]
    Regulate(#[from] RegulateError),
    /// The copy could not be measured.
    #[error(transparent)]
    Measure(#[from] MeasureError),
}

/// What working on a list gives.
pub(crate) type Worked<T> = Result<T, WorklistError>;

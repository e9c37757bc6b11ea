//! Regulation: turns an action's own screws until it meets a specification, as a technician does.
//!
//! `goal` holds the possible targets, `screw` the known screws, `workshop` the action with its screws and measurements,
//! `search` the search for one screw's setting, and `rounds` the order of work, repeated until no goal is disturbed by
//! another; `follow` adds the screws that must follow.

mod follow;
mod goal;
mod report;
mod rounds;
mod screw;
mod search;
mod value;
mod workshop;

pub use follow::{disturbed, needed, regulate_following};

pub use goal::{Goal, Specification};
pub use rounds::{Achieved, Miss, Regulated, Status, Turned, regulate};
pub(crate) use screw::way;
pub use screw::{CAPSTAN_THREAD_M, Handwork, KNOWN_SCREWS, KnownScrew, SMALL_THREAD_M, known_screw, turns_text};
pub use value::{parse_value, show, unit};

use thiserror::Error;

use crate::distances::DistanceError;

/// Reason why an action could not be regulated.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum RegulateError {
    /// A goal needs a screw that the instrument does not have.
    #[error("the instrument has no screw for {goal}: it needs one called {needs}")]
    NoScrew {
        /// Requested goal.
        goal: &'static str,
        /// Screws that could reach it.
        needs: String,
    },
    /// The distances could not be measured.
    #[error(transparent)]
    Measure(#[from] DistanceError),
}

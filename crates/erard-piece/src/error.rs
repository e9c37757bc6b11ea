//! Why a piece cannot be performed.

use std::io;

use erard::damper::KeyDamperError;
use erard::player::{ActionError, HandError, SnapshotError};
use erard::run::SimulationError;
use erard_workshop::cores::Ending;
use thiserror::Error;

/// Why a piece cannot be performed.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum PerformError {
    /// A key cannot be played.
    #[error("key {key}: {error}")]
    Action {
        /// Number of the key, from 1.
        key: usize,
        /// Reason.
        error: ActionError,
    },
    /// Where a key sets its damper down cannot be found.
    #[error(transparent)]
    Damper(#[from] KeyDamperError),
    /// The score has notes on a key for which there is no instrument.
    #[error("key {key}: there is no instrument for it; expected one for each key of the score")]
    NoInstrument {
        /// Number of the key, from 1.
        key: usize,
    },
    /// A number became infinite.
    #[error("at {time_s:.6} s a number became infinite")]
    NotFinite {
        /// s.
        time_s: f64,
    },
    /// A bug: a state that belongs to another key.
    #[error(transparent)]
    Snapshot(#[from] SnapshotError),
    /// A bug: an impossible hand.
    #[error(transparent)]
    Hand(#[from] HandError),
    /// A bug: a note that was not tried.
    #[error("a note was not tried")]
    Nothing,
    /// The sink refuses rows or sound.
    #[error("rows and sound cannot be written: {0}")]
    Sink(#[from] io::Error),
    /// The caller asked to stop, or work for all keys failed.
    #[error(transparent)]
    Work(#[from] SimulationError),
}

impl PerformError {
    pub(crate) fn interrupted() -> Self {
        PerformError::Work(SimulationError::Interrupted)
    }
}

impl Ending for PerformError {
    fn is_interruption(&self) -> bool {
        matches!(self, PerformError::Work(SimulationError::Interrupted))
    }
}

//! Why keys cannot be played.

use erard::damper::KeyDamperError;
use erard::player::ActionError;
use erard::run::SimulationError;
use erard_workshop::cores::Ending;

/// Why keys cannot be played from a stream.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// The work was interrupted, or failed on a core.
    #[error(transparent)]
    Work(#[from] SimulationError),
    /// A key cannot be assembled.
    #[error("key {key}: {error}")]
    Action {
        /// The key, from 1.
        key: usize,
        /// Reason.
        error: ActionError,
    },
    /// Where a key sets its damper down cannot be found.
    #[error(transparent)]
    Damper(#[from] KeyDamperError),
    /// No press brings the key's hammer to its string.
    #[error("key {key}: no press throws the hammer to a string; expected an action with key, hammer and string")]
    Silent {
        /// The key, from 1.
        key: usize,
    },
    /// The keyboard does not have the keys of a piano.
    #[error("{found} keys; expected 1 to 88")]
    Count {
        /// Number of keys.
        found: usize,
    },
}

impl Ending for LiveError {
    fn is_interruption(&self) -> bool {
        matches!(self, LiveError::Work(error) if error.is_interruption())
    }
}

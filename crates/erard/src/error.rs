//! One error for everything that this crate does.

use erard_core::instrument::{FileError, InvalidInstrument, UnknownInstrument};
use erard_core::instrument_spec::InstrumentSpecError;
use erard_core::key::UnknownKey;
use erard_core::keyboard::{KeysError, UnknownKeyboard};
use erard_core::level::LevelError;
use erard_core::parameter::{ChangeError, NameError, VaryError};
use erard_core::player::equilibrium::EquilibriumError;
use erard_core::player::{HandError, PlayError};
use erard_core::strings::PedalError;
use erard_core::stroke::{DrivingError, SampleError, StrokeError};
use erard_core::{ActionError, IndexError, SimulationError, SnapshotError};

/// Whatever can go wrong: every error of this crate converts into it. Its text is the inner error's.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// There is no such built-in instrument.
    #[error(transparent)]
    Instrument(#[from] UnknownInstrument),
    /// There is no such built-in keyboard.
    #[error(transparent)]
    Keyboard(#[from] UnknownKeyboard),
    /// A text names no instrument, key or sample.
    #[error(transparent)]
    Spec(#[from] InstrumentSpecError),
    /// A text names no key.
    #[error(transparent)]
    Key(#[from] UnknownKey),
    /// A file of an instrument or a keyboard cannot be read.
    #[error(transparent)]
    File(#[from] Box<FileError>),
    /// An instrument that was put together is not sound.
    #[error(transparent)]
    Invalid(#[from] InvalidInstrument),
    /// A number of an instrument cannot be changed so.
    #[error(transparent)]
    Change(#[from] ChangeError),
    /// A name is no parameter of the instrument.
    #[error(transparent)]
    Name(#[from] NameError),
    /// A parameter cannot have this value.
    #[error(transparent)]
    Vary(#[from] VaryError),
    /// An index of a part does not exist.
    #[error(transparent)]
    Index(#[from] IndexError),
    /// An action cannot be assembled, or does not come to rest.
    #[error(transparent)]
    Action(#[from] ActionError),
    /// The keys of a keyboard cannot be assembled.
    #[error(transparent)]
    Keys(#[from] KeysError),
    /// A saved state cannot be continued.
    #[error(transparent)]
    Snapshot(#[from] SnapshotError),
    /// A sequence of steps ended before its inputs did.
    #[error(transparent)]
    Play(#[from] PlayError),
    /// A hand has a number out of range, or cannot follow its stroke.
    #[error(transparent)]
    Hand(#[from] HandError),
    /// A text describes no motion of the pedal.
    #[error(transparent)]
    Pedal(#[from] PedalError),
    /// A stroke file cannot be read.
    #[error(transparent)]
    StrokeFile(#[from] Box<StrokeError>),
    /// Samples do not form a series.
    #[error(transparent)]
    Samples(#[from] SampleError),
    /// A recording cannot drive so.
    #[error(transparent)]
    Driving(#[from] DrivingError),
    /// No hand reaches a hammer speed.
    #[error(transparent)]
    Level(#[from] LevelError),
    /// A run could not be made.
    #[error(transparent)]
    Run(#[from] SimulationError),
    /// A [`Press`](crate::Press) lacks something or contradicts itself.
    #[error("press: {fault}; expected {expected}")]
    Press {
        /// What is missing or contradictory.
        fault: String,
        /// What would do.
        expected: String,
    },
}

impl Error {
    /// Whether the work ended because the caller asked for it.
    #[must_use]
    pub fn is_interruption(&self) -> bool {
        let while_it_settled =
            |error: &ActionError| matches!(error, ActionError::Equilibrium(EquilibriumError::Interrupted));
        match self {
            Error::Run(SimulationError::Interrupted | SimulationError::Equilibrium(EquilibriumError::Interrupted))
            | Error::Level(LevelError::Interrupted)
            | Error::Play(PlayError::Interrupted) => true,
            Error::Action(error) | Error::Level(LevelError::Action(error)) | Error::Keys(KeysError { error, .. }) => {
                while_it_settled(error)
            }
            _ => false,
        }
    }
}

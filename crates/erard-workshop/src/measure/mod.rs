//! The technician's measurements: weights on the key, parts on the scale, force over travel, inertia, timing,
//! repetition.
//!
//! Everything is measured in simulation as on a piano. A quantity that also follows from the masses and the geometry of
//! the instrument file is given both ways.
//!
//! Grams are forces here, as in the trade: a force over the instrument's gravity. Key travel is that of the key front
//! from its rest, down positive.

pub mod blocked;
mod entries;
pub mod flex;
pub mod flight;
pub mod inertia;
pub(crate) mod levers;
pub mod norms;
pub mod range;
pub mod repetition;
mod sheet;
mod slow_loop;
mod timing;
mod trial;
pub mod usual;
pub mod weights;

pub use entries::{Flag, InertiaNumbers, LoopNumbers, Sheet, TimingRow, TouchNumbers};
pub use sheet::{measure, measure_some};
pub use slow_loop::{SlowLoop, SlowWay, slow_loop};

use erard::IndexError;
use thiserror::Error;

use crate::cores::Ending;
use crate::distances;
use erard::grand::AnatomyError;
use erard::instrument::InvalidInstrument;
use erard::player::equilibrium::EquilibriumError;
use erard::player::{ActionError, PlayError};
use erard::run::SimulationError;

/// Why an instrument cannot be measured.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum MeasureError {
    /// The instrument has nothing to measure.
    #[error("cannot be measured as a piano action: {0}")]
    NotAnAction(#[from] NotAnAction),
    /// The instrument is no grand action.
    #[error(transparent)]
    Anatomy(#[from] AnatomyError),
    /// A part is one of another instrument.
    #[error(transparent)]
    Index(#[from] IndexError),
    /// There is no equilibrium.
    #[error(transparent)]
    Equilibrium(#[from] EquilibriumError),
    /// The action cannot be assembled, or has no equilibrium.
    #[error(transparent)]
    Action(#[from] ActionError),
    /// A run failed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The distances cannot be measured.
    #[error(transparent)]
    Distances(#[from] distances::DistanceError),
    /// A change of the instrument is not possible.
    #[error("the instrument cannot be changed: {0}")]
    Invalid(#[from] InvalidInstrument),
    /// A measurement ended without a result or an error: its thread died.
    #[error("a measurement ended without a result")]
    Lost,
}

/// Reason why an instrument cannot be measured as a piano action.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum NotAnAction {
    /// `roles.key_bottom` is missing.
    #[error("`roles` names no key bottom")]
    NoKeyBottom,
    /// A firm press does not end at a key bottom.
    #[error("the firmly pressed key reaches no key bottom")]
    Bottomless,
    /// The key's free travel ends at once.
    #[error("the slowly pressed key travels {:.1} mm before let-off, string or key bottom; expected more", way_m * 1e3)]
    NoFreeWay {
        /// Travel of the key, m.
        way_m: f64,
    },
    /// The key's free travel has no end.
    #[error("the slowly pressed key travels {} mm without let-off, string contact or key bottom", depth_m * 1e3)]
    NoLetOff {
        /// Depth to which the key was pressed, m.
        depth_m: f64,
    },
    /// The instrument's gravity is zero.
    #[error("gravity is zero, so nothing has weight")]
    Weightless,
    /// Key and whippen do not touch.
    #[error("there is no contact zone between key and whippen")]
    NoCapstan,
    /// The key front lies behind the balance pin.
    #[error("the finger presses the key behind its pivot; expected a point in front of it")]
    FingerBehindPivot,
    /// The three levers separate before let-off.
    #[error("its levers do not reach let-off")]
    ShortLevers,
}

impl MeasureError {
    /// Whether the caller asked to stop.
    #[must_use]
    pub fn is_interruption(&self) -> bool {
        matches!(
            self,
            MeasureError::Simulation(SimulationError::Interrupted)
                | MeasureError::Equilibrium(EquilibriumError::Interrupted)
                | MeasureError::Action(ActionError::Equilibrium(EquilibriumError::Interrupted))
                | MeasureError::Distances(distances::DistanceError::Interrupted)
        )
    }
}

impl From<PlayError> for MeasureError {
    fn from(error: PlayError) -> Self {
        SimulationError::from(error).into()
    }
}

impl Ending for MeasureError {
    fn is_interruption(&self) -> bool {
        MeasureError::is_interruption(self)
    }
}

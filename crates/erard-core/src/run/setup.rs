//! Settings of a run, and errors.

use moreau::{ModelError, Settings};
use thiserror::Error;

use crate::index::IndexError;
use crate::instrument::Instrument;
use crate::mechanism::{Halving, MAX_STEP_S, SMALLEST_STEP_S};
use crate::player::equilibrium::{self, EquilibriumError, UNSOLVED_STEPS};
use crate::player::{ActionError, Drive, Hand, HandError, Input, PlayError, SnapshotError};
use crate::strings::Pedal;
use crate::trust::{Warning, WarningKind};

/// Most rows that a run keeps by default; longer runs keep every n-th step.
pub const MAX_ROWS: u64 = 200_000;
/// Most rows that a run keeps on request. The concert grand's hold some 500 bytes each.
pub const MAX_ROWS_ASKED: u64 = 1_000_000;
/// Tolerances that an error-controlled run accepts: below, rounding is seen as error; above, the largest step limits
/// the error.
pub const TOLERANCES: [f64; 2] = [1e-9, 1e-1];
/// Longest run, s: more than eleven days.
pub(super) const MAX_DURATION_S: f64 = 1e6;
/// Settings of a run.
#[derive(Debug, Clone, Copy)]
pub struct Setup {
    /// The engine's settings.
    pub settings: Settings<f64>,
    /// The instant at which the run starts, on the stroke's own clock, s.
    pub start_s: f64,
    /// Simulated time, s.
    pub duration_s: f64,
    /// Number of steps per row; `None`: one, or as many as are needed not to exceed [`MAX_ROWS`].
    pub record_every: Option<u64>,
    /// Error that a step may have (see [`moreau::Accuracy::tolerance`]); `None`: all steps are as long as the settings
    /// say. With a tolerance, rows stand where they would without, and steps between two of them are as long as their
    /// error allows.
    pub tolerance: Option<f64>,
    /// Number of halvings of a step while the hammer is near modal strings. Rows stay on the settings' grid.
    pub halving: Halving,
    /// Whether the energy balance is kept.
    pub ledger: bool,
    /// Motion of the sustain pedal, on the stroke's own clock.
    pub pedal: Pedal,
    /// The hand between stroke and key: the stroke's force is its muscle's, or its muscle follows the stroke's motion.
    /// `None`: the stroke drives the key.
    pub hand: Option<Hand>,
}

/// Why a run could not be made.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SimulationError {
    /// The step is out of range.
    #[error("the step is {found} s; expected a number from {SMALLEST_STEP_S:e} to {MAX_STEP_S:e} s")]
    Step {
        /// s.
        found: f64,
    },
    /// Theta is out of range.
    #[error("theta is {found}; expected a number from 0.5 (second order) to 1 (damped)")]
    Theta {
        /// Dimensionless.
        found: f64,
    },
    /// The tolerance is out of range.
    #[error("the tolerance is {found}; expected a number from {:e} to {:e}", TOLERANCES[0], TOLERANCES[1])]
    Tolerance {
        /// Dimensionless.
        found: f64,
    },
    /// The duration is out of range.
    #[error("the duration is {found} s; expected a positive number of at most {longest} s")]
    Duration {
        /// s.
        found: f64,
        /// s.
        longest: f64,
    },
    /// More rows than can be held.
    #[error(
        "a row every {every} steps makes {found} rows; expected a row every {least} steps or more, for at most {MAX_ROWS_ASKED} rows"
    )]
    Rows {
        /// Steps from row to row.
        every: u64,
        /// Number of rows.
        found: u64,
        /// Steps from row to row that would do.
        least: u64,
    },
    /// The start is out of range.
    #[error("the stroke starts at {found} s; expected a number below 1e9 s")]
    Start {
        /// s.
        found: f64,
    },
    /// A number overflowed.
    #[error(
        "at {time_s:.6} s a number became infinite. Look for a stiffness, mass or drive that is far off, or try a smaller step"
    )]
    NonFinite {
        /// s.
        time_s: f64,
    },
    /// The instrument has no key to drive.
    #[error("the instrument has no `roles.key`; expected the body to press")]
    NoKey,
    /// The hand cannot press in this way.
    #[error(transparent)]
    Hand(#[from] HandError),
    /// Strings need fixed steps.
    #[error(
        "adaptive stepping is not supported with modal strings: remove the tolerance, or set `rigid_string = true` in [roles]"
    )]
    StringsControlled,
    /// The instrument has no rail for a pedal.
    #[error(
        "a pedal needs a damper rail (`roles.pedal`) and modal strings; the instrument lacks one of them. `concert-grand-strings` has both"
    )]
    NoPedal,
    /// No rest to start from.
    #[error(transparent)]
    Equilibrium(#[from] EquilibriumError),
    /// A saved state that is not the instrument's.
    #[error(transparent)]
    State(#[from] SnapshotError),
    /// Not assembled.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// A job names an instrument that does not exist.
    #[error(transparent)]
    Index(#[from] IndexError),
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl SimulationError {
    /// An interruption stays an interruption, wherever it occurs.
    pub(crate) fn settling(error: EquilibriumError) -> Self {
        match error {
            EquilibriumError::Interrupted => SimulationError::Interrupted,
            error => error.into(),
        }
    }
}

impl From<ActionError> for SimulationError {
    fn from(error: ActionError) -> Self {
        match error {
            ActionError::Step { found } => SimulationError::Step { found },
            ActionError::Model(error) => error.into(),
            ActionError::Equilibrium(error) => SimulationError::settling(error),
        }
    }
}

impl Setup {
    /// A run of a duration, s, from the stroke's start at 0: steps of 50 us with the usual settings, every step a row
    /// (or every n-th, not to exceed [`MAX_ROWS`]), with the ledger.
    pub fn new(duration_s: f64) -> Self {
        let settings = Settings::new(equilibrium::STEP_S);
        Setup {
            settings,
            start_s: 0.0,
            duration_s,
            record_every: None,
            tolerance: None,
            halving: Halving::Auto,
            ledger: true,
            pedal: Pedal::default(),
            hand: None,
        }
    }

    /// [`Setup::new`] with the usual steps of an instrument ([`Instrument::usual_step_s`]).
    pub fn of(instrument: &Instrument, duration_s: f64) -> Self {
        Setup { settings: Settings::new(instrument.usual_step_s()), ..Setup::new(duration_s) }
    }

    /// The drive of the key under a stroke: the stroke, or the hand that it moves. A run ends as from a number that is
    /// not finite where the stroke later imposes the key's motion, which no hand can.
    ///
    /// # Errors
    /// [`HandError::Stroke`] if it begins so.
    pub fn driven<'a>(&self, stroke: &'a Drive<'a>) -> Result<impl Fn(f64) -> Input + 'a, HandError> {
        let hand = self.hand;
        if let Some(hand) = hand {
            hand.input(&stroke(self.start_s))?;
        }
        Ok(move |t: f64| {
            let input = stroke(t);
            hand.map_or(input, |hand| hand.input(&input).unwrap_or(Input::Force(f64::NAN)))
        })
    }

    /// Checks the numbers, and returns the number of steps.
    ///
    /// # Errors
    /// See [`SimulationError`].
    pub fn check(&self) -> Result<u64, SimulationError> {
        let Settings { step, theta, .. } = self.settings;
        if !(SMALLEST_STEP_S..=MAX_STEP_S).contains(&step) {
            return Err(SimulationError::Step { found: step });
        }
        if !(0.5..=1.0).contains(&theta) {
            return Err(SimulationError::Theta { found: theta });
        }
        if let Some(found) = self.tolerance
            && !(TOLERANCES[0]..=TOLERANCES[1]).contains(&found)
        {
            return Err(SimulationError::Tolerance { found });
        }
        if !(-1e9..=1e9).contains(&self.start_s) {
            return Err(SimulationError::Start { found: self.start_s });
        }
        if let Some(hand) = &self.hand {
            hand.check()?;
        }
        let longest = MAX_DURATION_S;
        if !(self.duration_s > 0.0 && self.duration_s <= longest) {
            return Err(SimulationError::Duration { found: self.duration_s, longest });
        }
        let steps = (self.duration_s / step).round().max(1.0) as u64;
        if let Some(every) = self.record_every.map(|every| every.max(1))
            && steps / every > MAX_ROWS_ASKED
        {
            let least = steps.div_ceil(MAX_ROWS_ASKED);
            return Err(SimulationError::Rows { every, found: steps / every, least });
        }
        Ok(steps)
    }
}

impl From<PlayError> for SimulationError {
    fn from(error: PlayError) -> Self {
        match error {
            PlayError::Interrupted => SimulationError::Interrupted,
            PlayError::NonFinite { time_s } => SimulationError::NonFinite { time_s },
        }
    }
}

impl SimulationError {
    /// The warning that this error is where the run is one of many and the others go on; `None` for an error that this
    /// instrument did not cause.
    #[must_use]
    pub fn warning(&self) -> Option<Warning> {
        let warning = |kind, part, value, unit, time_s| {
            Some(Warning { kind, what: self.to_string(), part, value, bound: 0.0, unit, time_s })
        };
        match self {
            SimulationError::Equilibrium(EquilibriumError::NoRest { body, speed, .. }) => {
                warning(WarningKind::NoRest, Some(body.clone()), *speed, "rad/s", None)
            }
            SimulationError::Equilibrium(EquilibriumError::Unsolved { time_s, .. }) => {
                warning(WarningKind::UnconvergedSteps, None, f64::from(UNSOLVED_STEPS), "steps", Some(*time_s))
            }
            SimulationError::Equilibrium(EquilibriumError::NonFinite) => {
                warning(WarningKind::NonFinite, None, f64::INFINITY, "", None)
            }
            SimulationError::NonFinite { time_s } => {
                warning(WarningKind::NonFinite, None, f64::INFINITY, "", Some(*time_s))
            }
            _ => None,
        }
    }
}

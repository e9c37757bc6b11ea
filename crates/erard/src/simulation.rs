//! One key press: from rest, driven, to the end of its duration.

use moreau::{ModelError, Settings};
use thiserror::Error;

use crate::equilibrium::EquilibriumError;
use crate::instrument::Instrument;
use crate::player::hand::MovingHand;
use crate::player::run_loop::RunLoop;
use crate::player::{Action, ActionError, Drive, Hand, HandError, Input, Observer};
use crate::run::Run;
use crate::strings::Pedal;

/// Smallest step that a run accepts, s: below it the rounding of a position sum exceeds what the step improves.
pub const SMALLEST_STEP_S: f64 = 1e-8;
/// Largest step that a run accepts, s: a fortissimo blow lasts two of them.
pub const LARGEST_STEP_S: f64 = 1e-3;
/// Most rows that a run keeps unless told otherwise; longer runs keep every n-th step.
pub const MOST_ROWS: u64 = 200_000;
/// Most rows that a run keeps when told how many. The concert grand's hold some 500 bytes each.
pub const MOST_ROWS_ASKED: u64 = 1_000_000;
/// Tolerances that an error-controlled run accepts: below, rounding is seen as error; above, the largest step limits the error.
pub const TOLERANCES: [f64; 2] = [1e-9, 1e-1];
/// How to run.
#[derive(Debug, Clone, Copy)]
pub struct Setup {
    /// The engine's settings.
    pub settings: Settings<f64>,
    /// The instant at which the run starts, on the stroke's own clock, s.
    pub start_s: f64,
    /// Simulated time, s.
    pub duration_s: f64,
    /// Keep a row every so many steps; `None`: every step, or so many that [`MOST_ROWS`] are not exceeded.
    pub record_every: Option<u64>,
    /// Error that a step may have (see [`moreau::Accuracy::tolerance`]); `None`: all steps are as long as the settings say. With a tolerance,
    /// rows stand where they would without, and steps between two of them are as long as their error allows.
    pub tolerance: Option<f64>,
    /// Whether the energy ledger is kept.
    pub ledger: bool,
    /// How the sustain pedal is moved, on the stroke's own clock.
    pub pedal: Pedal,
}

/// Why a run could not be made.
#[derive(Debug, Error)]
pub enum SimulationError {
    /// The step is out of range.
    #[error("the step is {found} s; expected a number from {SMALLEST_STEP_S:e} to {LARGEST_STEP_S:e} s")]
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
    #[error("the duration is {found} s; expected a positive number of at most {longest} s (2^40 steps)")]
    Duration {
        /// s.
        found: f64,
        /// s.
        longest: f64,
    },
    /// More rows than can be held.
    #[error(
        "a row every {every} steps makes {found} rows; expected a number of steps from {least}, for at most {MOST_ROWS_ASKED} rows"
    )]
    Rows {
        /// Steps from row to row.
        every: u64,
        /// How many rows that makes.
        found: u64,
        /// Steps from row to row that would do.
        least: u64,
    },
    /// The start is no sane instant.
    #[error("the stroke starts at {found} s; expected a number below 1e9 s")]
    Start {
        /// s.
        found: f64,
    },
    /// A number overflowed.
    #[error(
        "at {time_s:.6} s a number became infinite; a smaller step may help, but a stiffness, mass or drive must be far off"
    )]
    NonFinite {
        /// s.
        time_s: f64,
    },
    /// The instrument has no key to drive.
    #[error("the instrument names no key (`roles.key`), so that nothing can be driven")]
    NoKey,
    /// A hand that cannot press so.
    #[error(transparent)]
    Hand(#[from] HandError),
    /// Strings take steps of one length.
    #[error(
        "strings that yield take steps of one length; expected no tolerance, or a rigid string (`rigid_string = true` in [roles])"
    )]
    StringsControlled,
    /// There is nothing that a pedal could lift.
    #[error(
        "the instrument has no rail for a pedal to lift (`roles.pedal`), or its strings are rigid (`concert-grand-strings` has both)"
    )]
    NoPedal,
    /// A hand takes steps of one length.
    #[error("a hand presses in steps of one length; expected no tolerance")]
    HandControlled,
    /// No rest to start from.
    #[error(transparent)]
    Equilibrium(#[from] EquilibriumError),
    /// Not assembled.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl SimulationError {
    /// An interruption is one, wherever it is heard.
    fn settling(error: EquilibriumError) -> Self {
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
    /// A run of so many seconds from the stroke's start at 0: steps of 50 us with the usual settings, every step a row (or so many that
    /// [`MOST_ROWS`] are not exceeded), with the ledger.
    pub fn new(duration_s: f64) -> Self {
        let settings = Settings::new(crate::equilibrium::STEP_S);
        Setup {
            settings,
            start_s: 0.0,
            duration_s,
            record_every: None,
            tolerance: None,
            ledger: true,
            pedal: Pedal::default(),
        }
    }

    /// Checks the numbers, and says how many steps they make.
    ///
    /// # Errors
    /// See [`SimulationError`].
    pub fn check(&self) -> Result<u64, SimulationError> {
        let Settings { step, theta, .. } = self.settings;
        if !(SMALLEST_STEP_S..=LARGEST_STEP_S).contains(&step) {
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
        let longest = step * (1u64 << 40) as f64;
        if !(self.duration_s > 0.0 && self.duration_s <= longest) {
            return Err(SimulationError::Duration { found: self.duration_s, longest });
        }
        let steps = (self.duration_s / step).round().max(1.0) as u64;
        if let Some(every) = self.record_every.map(|every| every.max(1))
            && steps / every > MOST_ROWS_ASKED
        {
            let least = steps.div_ceil(MOST_ROWS_ASKED);
            return Err(SimulationError::Rows { every, found: steps / every, least });
        }
        Ok(steps)
    }
}

/// [`simulate`] for who does not want to be told how far it is.
///
/// # Errors
/// See [`SimulationError`].
pub fn press(instrument: &Instrument, drive: &Drive<'_>, setup: &Setup) -> Result<Run, SimulationError> {
    simulate(instrument, drive, setup, &mut |_| true)
}

/// Simulates one press. `progress` is told the share done now and then, and ends the run by returning false.
///
/// The mechanism starts in equilibrium, friction included: undriven for a force, under the finger's first position for a
/// motion.
///
/// # Errors
/// See [`SimulationError`]. Steps that do not converge are no error: they are counted in the run's [`crate::run::Work`].
pub fn simulate(
    instrument: &Instrument,
    drive: &Drive<'_>,
    setup: &Setup,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Run, SimulationError> {
    simulate_before(instrument, drive, setup, None, progress)
}

/// [`simulate`] before the eyes of an observer of its own.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_observed(
    instrument: &Instrument,
    drive: &Drive<'_>,
    setup: &Setup,
    observer: &mut dyn Observer,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Run, SimulationError> {
    simulate_before(instrument, drive, setup, Some(observer), progress)
}

fn simulate_before<'a>(
    instrument: &Instrument,
    drive: &'a Drive<'a>,
    setup: &'a Setup,
    observer: Option<&'a mut (dyn Observer + 'a)>,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Run, SimulationError> {
    let steps = setup.check()?;
    if instrument.roles.key.is_none() && drive(setup.start_s) != Input::Free {
        return Err(SimulationError::NoKey);
    }
    if setup.tolerance.is_some() && instrument.has_yielding_strings() {
        return Err(SimulationError::StringsControlled);
    }
    let mut action = Action::asking(instrument, setup.settings, &mut || progress(0.0))?;
    put_pedal(&mut action, instrument, setup, &mut || progress(0.0))?;
    if let Input::Motion { position_m, .. } | Input::Rigid { position_m, .. } = drive(setup.start_s)
        && position_m > 0.0
    {
        let finger = Input::Motion { position_m, velocity_m_s: 0.0 };
        action.settle(instrument, finger, &mut || progress(0.0)).map_err(SimulationError::settling)?;
    }

    let mut run = RunLoop::new(instrument, drive, setup, steps, action, observer);
    match setup.tolerance {
        None => run.fixed(progress)?,
        Some(tolerance) => run.adaptive(tolerance, progress)?,
    }
    progress(1.0);
    Ok(run.finish(instrument))
}

/// The pedal where it is at the start, and the action at rest over it.
fn put_pedal(
    action: &mut Action,
    instrument: &Instrument,
    setup: &Setup,
    going: &mut dyn FnMut() -> bool,
) -> Result<(), SimulationError> {
    if !setup.pedal.is_used() {
        return Ok(());
    }
    if action.strings().and_then(|strings| strings.pedal_m()).is_none() {
        return Err(SimulationError::NoPedal);
    }
    let lift_m = setup.pedal.lift_m(setup.start_s);
    if lift_m > 0.0 {
        action.set_pedal(lift_m);
        action.settle(instrument, Input::Free, going).map_err(SimulationError::settling)?;
    }
    Ok(())
}

/// [`simulate`] with a hand between stroke and key: the stroke's force is its muscle's, or its motion is where muscle drives it.
///
/// # Errors
/// See [`SimulationError`].
pub fn simulate_hand(
    instrument: &Instrument,
    hand: &Hand,
    stroke: &Drive<'_>,
    setup: &Setup,
    progress: &mut dyn FnMut(f64) -> bool,
) -> Result<Run, SimulationError> {
    let steps = setup.check()?;
    if instrument.roles.key.is_none() {
        return Err(SimulationError::NoKey);
    }
    if setup.tolerance.is_some() {
        return Err(SimulationError::HandControlled);
    }
    let hand = MovingHand::new(*hand, &setup.settings, &stroke(setup.start_s))?;
    let fitted = hand.fitted(instrument);
    let mut action = Action::asking(&fitted, setup.settings, &mut || progress(0.0))?;
    put_pedal(&mut action, &fitted, setup, &mut || progress(0.0))?;
    let mut run = RunLoop::new(&fitted, stroke, setup, steps, action, None).by_hand(hand);
    run.fixed(progress)?;
    progress(1.0);
    Ok(run.finish(&fitted))
}

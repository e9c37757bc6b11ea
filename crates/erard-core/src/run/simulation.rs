//! One key press: from rest, driven, to the end of its duration.

use super::Run;
use super::run_loop::RunLoop;
use super::setup::{Setup, SimulationError};
use crate::instrument::Instrument;
use crate::mechanism::Halving;
use crate::player::{Action, AtRest, Drive, Input, Observer, RestPose, Snapshot};
use crate::progress::Progress;
use crate::stroke::HandStroke;
use crate::trust::WarningKind;

/// [`simulate`] without a progress callback.
///
/// # Errors
/// See [`SimulationError`].
pub fn press(instrument: &Instrument, drive: &Drive<'_>, setup: &Setup) -> Result<Run, SimulationError> {
    simulate(instrument, drive, setup, &mut |_| true)
}

/// Simulates one press. `progress` receives the share done now and then, and ends the run by returning false.
///
/// The mechanism starts in equilibrium, friction included: undriven for a force or under a hand ([`Setup::hand`]),
/// under the finger's first position for a motion.
///
/// # Errors
/// See [`SimulationError`]. Steps that do not converge are no error: they are counted in the run's
/// [`crate::run::Work`].
pub fn simulate(
    instrument: &Instrument,
    drive: &Drive<'_>,
    setup: &Setup,
    progress: &mut Progress<'_>,
) -> Result<Run, SimulationError> {
    simulate_before(instrument, None, drive, setup, None, progress)
}

/// [`simulate`] from a rest that has been found before.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_at_rest(
    rest: &RestPose,
    drive: &Drive<'_>,
    setup: &Setup,
    progress: &mut Progress<'_>,
) -> Result<Run, SimulationError> {
    simulate_before(rest.instrument(), Some(rest), drive, setup, None, progress)
}

/// [`simulate`] with an additional observer.
///
/// # Errors
/// As [`simulate`].
pub fn simulate_observed(
    instrument: &Instrument,
    drive: &Drive<'_>,
    setup: &Setup,
    observer: &mut dyn Observer,
    progress: &mut Progress<'_>,
) -> Result<Run, SimulationError> {
    simulate_before(instrument, None, drive, setup, Some(observer), progress)
}

/// Simulates a touch: [`simulate`] with the hand and its muscle.
///
/// # Errors
/// See [`SimulationError`].
pub fn press_by_hand(
    instrument: &Instrument,
    hand: &HandStroke,
    setup: &Setup,
    progress: &mut Progress<'_>,
) -> Result<Run, SimulationError> {
    let setup = Setup { hand: Some(hand.hand), ..*setup };
    simulate(instrument, &|t| hand.input(t), &setup, progress)
}

/// Continues a simulation from a saved state of the instrument, which is the start of the run. The state includes the
/// motion of the hand, the pedal's rail and the strings. [`Setup::hand`] sets the properties of the hand, not its
/// position.
///
/// # Errors
/// As [`simulate`]; [`SimulationError::State`]: the state is another instrument's, or of other settings.
pub fn simulate_from(
    instrument: &Instrument,
    start: &Snapshot,
    drive: &Drive<'_>,
    setup: &Setup,
    progress: &mut Progress<'_>,
) -> Result<Run, SimulationError> {
    let steps = setup.check()?;
    let drive = setup.driven(drive)?;
    let mut action = Action::with_progress(instrument, setup.settings, progress)?;
    action.restore(start)?;
    let mut run = RunLoop::new(instrument, &drive, setup, steps, action, None);
    run.fixed(progress)?;
    progress(1.0);
    let mut run = run.finish(instrument);
    // A saved state may be in the middle of a motion: where it begins is no rest.
    run.warnings.retain(|warning| warning.kind != WarningKind::RestFarFromDrawing);
    Ok(run)
}

fn simulate_before(
    instrument: &Instrument,
    rest: Option<&RestPose>,
    drive: &Drive<'_>,
    setup: &Setup,
    observer: Option<&mut dyn Observer>,
    progress: &mut Progress<'_>,
) -> Result<Run, SimulationError> {
    let steps = setup.check()?;
    let drive = setup.driven(drive)?;
    let first = drive(setup.start_s);
    if instrument.roles.key.is_none() && first != Input::Free {
        return Err(SimulationError::NoKey);
    }
    if setup.tolerance.is_some() && instrument.has_yielding_strings() {
        return Err(SimulationError::StringsControlled);
    }
    let mut action = match rest {
        Some(rest) => rest.action(setup.settings)?,
        None => Action::with_progress(instrument, setup.settings, progress)?,
    };
    if setup.halving != Halving::Auto {
        action.halve(setup.halving);
    }
    put_pedal(&mut action, instrument, setup, progress)?;
    if let Some(hand) = &setup.hand {
        action.place_hand(hand.start_m, hand.start_m_per_s);
    } else if let Input::Motion { position_m, .. } | Input::Rigid { position_m, .. } = first
        && position_m > 0.0
    {
        let finger = Input::Motion { position_m, velocity_m_per_s: 0.0 };
        action.settle(instrument, finger, progress).map_err(SimulationError::settling)?;
    }

    let observer = observer.map(|observer| -> &mut dyn Observer { observer });
    let mut run = RunLoop::new(instrument, &drive, setup, steps, action, observer);
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
    progress: &mut Progress<'_>,
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
        action.settle(instrument, Input::Free, progress).map_err(SimulationError::settling)?;
    }
    Ok(())
}

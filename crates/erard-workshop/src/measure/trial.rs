//! Trials with weights on the key front: whether the key sinks, and whether it comes up.
//!
//! The technician's own search. A weight is laid on the resting key, or on the key held just before let-off, and let
//! go. A key that runs away is caught and let go again, so that momentum does not help: a weight is heavy enough if the
//! key starts again from wherever it is stopped. The weight's own inertia is left out, because the motion is slow.

use moreau::Settings;

use super::MeasureError;
use erard::Progress;
use erard::instrument::Instrument;
use erard::mechanism::Halving;
use erard::player::{Action, AtRest, Input, RestPose, Snapshot};

/// Step, s: the key creeps; half the step changes no weight by more than 0.03 g.
const STEP_S: f64 = 400e-6;
/// A key that has not arrived within this time does not sink or rise, s: caught all the way, a dip takes half of it.
const PATIENCE_S: f64 = 40.0;
/// A key at rest for this time will not start again, s.
const STUCK_S: f64 = 0.1;
/// Key speed above which the key is caught, m/s. At this speed the whole action, 0.3 kg at the key front, has the
/// energy to carry a deficit of a tenth of a gram over a sixth of a millimetre.
const CAUGHT_M_PER_S: f64 = 0.001;
/// A key that has arrived is caught there, too, and must go on by itself by this travel, m.
const FURTHER_M: f64 = 2e-5;
/// Time in which the finger brings the key to where it is let go, s.
const APPROACH_S: f64 = 0.4;
/// Final width of the search, N: a fiftieth of a gram.
const CLOSE_N: f64 = 2e-4;
/// Half-width of the first search around a guess, N: a gram and a half.
const NEAR_N: f64 = 0.015;
/// Range of forces tried, N: no action needs 300 g, and one that must be pulled up with more than 100 g does not move.
const TRIED_N: [f64; 2] = [-1.0, 3.0];

/// Finds the smallest force that makes the resting key sink to `to_m`, N; `None` if there is none in the range.
/// `guess_n` is the start of the search.
///
/// # Errors
/// See [`MeasureError`].
pub(super) fn smallest_that_sinks(
    rest: &RestPose,
    to_m: f64,
    guess_n: Option<f64>,
    progress: &mut Progress<'_>,
) -> Result<Option<f64>, MeasureError> {
    let mut trials = Trials::at(rest, 0.0, progress)?;
    boundary(guess_n, &mut |force| trials.moves(force, to_m, progress))
}

/// Finds the largest force against which the key, let go at `from_m`, comes up to `to_m`, N; `None` if there is none in
/// the range.
///
/// # Errors
/// See [`MeasureError`].
pub(super) fn largest_that_is_lifted(
    rest: &RestPose,
    from_m: f64,
    to_m: f64,
    guess_n: Option<f64>,
    progress: &mut Progress<'_>,
) -> Result<Option<f64>, MeasureError> {
    // Searched by the same function: the smallest force that is no longer lifted.
    let mut trials = Trials::at(rest, from_m, progress)?;
    boundary(guess_n, &mut |force| Ok(!trials.moves(force, to_m, progress)?))
}

/// Finds the force at which an answer changes from no to yes. A guess only saves trials: if the answers around it are
/// not no and yes, the whole range is searched.
fn boundary(
    guess_n: Option<f64>,
    holds: &mut dyn FnMut(f64) -> Result<bool, MeasureError>,
) -> Result<Option<f64>, MeasureError> {
    let [mut low, mut high] = TRIED_N;
    let near = guess_n.map(|guess| [guess - NEAR_N, guess + NEAR_N]);
    match near {
        Some(near) if !holds(near[0])? && holds(near[1])? => [low, high] = near,
        _ if holds(low)? || !holds(high)? => return Ok(None),
        _ => {}
    }
    while high - low > CLOSE_N {
        let middle = 0.5 * (low + high);
        if holds(middle)? {
            high = middle;
        } else {
            low = middle;
        }
    }
    Ok(Some(0.5 * (low + high)))
}

/// An action whose key is let go repeatedly from one place.
struct Trials {
    action: Action,
    start: Snapshot,
    from_m: f64,
}

impl Trials {
    /// Brings the key to rest at `from_m`.
    fn at(rest: &RestPose, from_m: f64, progress: &mut Progress<'_>) -> Result<Self, MeasureError> {
        let mut action = rest.action(Settings::new(STEP_S))?;
        // Strings ask for a tenth of the step, for their sound. A key that creeps hears nothing of it.
        action.halve(Halving::Never);
        if from_m > 0.0 {
            hold_at(&mut action, rest.instrument(), from_m, progress)?;
        }
        let start = action.save();
        Ok(Trials { action, start, from_m })
    }

    /// Whether the key, let go under a force, reaches `to_m`.
    fn moves(&mut self, force_n: f64, to_m: f64, progress: &mut Progress<'_>) -> Result<bool, MeasureError> {
        let Trials { action, start, from_m } = self;
        // The snapshot is this action's own.
        let _ = action.restore(start);
        let way = (to_m - *from_m).signum();
        let (mut still_s, mut before_m, mut arrived, mut moved) = (0.0, action.reading().key_m, false, false);
        let mut steps = 0..=(PATIENCE_S / STEP_S) as u64;
        action.play(progress, &mut |action| {
            if steps.next()? == 0 {
                return Some(Input::Force(force_n));
            }
            let at_m = action.reading().key_m;
            let beyond_m = way * (at_m - to_m);
            if arrived && beyond_m >= FURTHER_M {
                moved = true;
                return None;
            }
            if !arrived && beyond_m >= 0.0 {
                arrived = true;
                action.stop();
            }
            let speed = (at_m - before_m) / STEP_S;
            before_m = at_m;
            still_s = if speed == 0.0 { still_s + STEP_S } else { 0.0 };
            if speed.abs() > CAUGHT_M_PER_S {
                action.stop();
            }
            (still_s <= STUCK_S).then_some(Input::Force(force_n))
        })?;
        Ok(moved)
    }
}

/// Moves the key slowly to `travel_m` and lets everything come to rest there.
fn hold_at(
    action: &mut Action,
    instrument: &Instrument,
    travel_m: f64,
    progress: &mut Progress<'_>,
) -> Result<(), MeasureError> {
    let steps = (APPROACH_S / STEP_S) as u64;
    let mut middles = (0..steps).map(|n| (n as f64 + 0.5) / steps as f64);
    action.play(progress, &mut |_| {
        let s = middles.next()?;
        let position_m = travel_m * s * s * (3.0 - 2.0 * s);
        Some(Input::Motion { position_m, velocity_m_per_s: travel_m * 6.0 * s * (1.0 - s) / APPROACH_S })
    })?;
    let finger = Input::Motion { position_m: travel_m, velocity_m_per_s: 0.0 };
    action.settle(instrument, finger, progress)?;
    Ok(())
}

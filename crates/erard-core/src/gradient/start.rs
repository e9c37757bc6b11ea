//! Start of a differentiated press: the rest of [`crate::simulate`], and its derivative.

use moreau::SavedState;
use moreau_kernels::{DIRECTIONS, Number};

use crate::instrument::Instrument;
use crate::player::{Action, Input};
use crate::progress::Progress;
use crate::run::SimulationError;
use moreau::Settings;

/// A state, whatever the mechanism's size.
type State = SavedState<f64, 12, 32>;

/// Where a press starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Poses {
    /// The rest from which travels are measured.
    pub rest: State,
    /// Pose at the beginning of the press: at rest, or under a finger that is already down.
    pub start: State,
}

impl Poses {
    /// Those of [`crate::simulate`], to the bit. `begins_at_m`: how far down a prescribed finger begins, m.
    ///
    /// # Errors
    /// An instrument that cannot be assembled or does not come to rest.
    pub fn of(instrument: &Instrument, begins_at_m: f64, progress: &mut Progress<'_>) -> Result<Self, SimulationError> {
        let mut action = Action::with_progress(instrument, Settings::new(instrument.usual_step_s()), progress)?;
        let rest = action.mechanism().save().state;
        if begins_at_m > 0.0 {
            let finger = Input::Motion { position_m: begins_at_m, velocity_m_per_s: 0.0 };
            action.settle(instrument, finger, progress).map_err(SimulationError::settling)?;
        }
        Ok(Poses { rest, start: action.mechanism().save().state })
    }
}

/// Derivative of the poses with respect to a number. Only angles and the internal states of felts have one.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Moves {
    rest: State,
    start: State,
}

impl Moves {
    /// From the poses with the number a little lower to those with it a little higher, which is `apart` more.
    pub(super) fn between(low: &Poses, high: &Poses, apart: f64) -> Self {
        let slope = |low: &State, high: &State| {
            let mut slope = State::at_rest(core::array::from_fn(|i| (high.angle[i] - low.angle[i]) / apart));
            for (one, (low, high)) in slope.memory.iter_mut().zip(low.memory.iter().zip(&high.memory)) {
                *one = core::array::from_fn(|k| (high[k] - low[k]) / apart);
            }
            slope
        };
        Moves { rest: slope(&low.rest, &high.rest), start: slope(&low.start, &high.start) }
    }
}

/// A state, and its derivative in each direction that moves it.
fn moved<'a>(state: &State, slopes: impl Iterator<Item = Option<&'a State>>) -> SavedState<Number, 12, 32> {
    let mut all = SavedState::at_rest(state.angle.map(Number::constant));
    all.memory = state.memory.map(|one| one.map(Number::constant));
    all.side = state.side.map(Number::constant);
    all.tangential = state.tangential.map(Number::constant);
    all.pivot_friction = state.pivot_friction.map(Number::constant);
    for (d, slope) in slopes.enumerate().take(DIRECTIONS) {
        let Some(slope) = slope else { continue };
        for (own, moves) in all.angle.iter_mut().zip(&slope.angle) {
            own.slope[d] = *moves;
        }
        for (own, moves) in all.memory.iter_mut().flatten().zip(slope.memory.iter().flatten()) {
            own.slope[d] = *moves;
        }
    }
    all
}

/// Rest and start in dual numbers; a direction that holds the poses has no derivative there.
pub(super) fn dual<'a>(
    poses: &Poses,
    moves: impl Iterator<Item = Option<&'a Moves>> + Clone,
) -> [SavedState<Number, 12, 32>; 2] {
    [
        moved(&poses.rest, moves.clone().map(|one| one.map(|one| &one.rest))),
        moved(&poses.start, moves.map(|one| one.map(|one| &one.start))),
    ]
}

//! Sleep: a step that would change nothing is skipped.
//!
//! A step is a function of state and input. If a step leaves every bit of the state unchanged, so would the next one
//! with the same input: it would give the same report and the same workspace. Such steps are skipped. This is exact;
//! there is no threshold and no drift. A mechanism falls asleep where dry friction truly sticks, and where what still
//! slips at the limit of its friction is so slow that the step's product of speed and length rounds to nothing beside
//! every angle: no angle changes, hence no force, hence no speed, for ever.

use crate::input::SiteInput;
use crate::model::Model;
use crate::real::{Real, Scalar, same_bits};
use crate::settings::Settings;
use crate::state::State;
use crate::step::{StepReport, step_out_of_line};
use crate::workspace::Workspace;

/// Record of whether a mechanism's last step changed nothing, and under which input.
///
/// It belongs to one [`State`] and its [`Settings`]. If you change either other than by [`Sleep::step`], call
/// [`Sleep::wake`]. Also call it before you read the [`Workspace`] if another state has used it.
#[derive(Debug, Clone, Copy)]
pub struct Sleep<T> {
    under: Option<(SiteInput<T>, StepReport)>,
}

/// Number of steps of the longest round after which a mechanism counts as standing ([`step_or_stay`]).
const LONGEST_ROUND: usize = 3;

/// Takes a step from `before`, of which `state` is a copy, except that a mechanism which only goes round stays in
/// `before`. `before` is a state whose angles no step of this length changes ([`State::stays`]).
///
/// What slips at the limit of its friction settles at a speed that changes no angle. Rounding can make that speed
/// alternate between two or three numbers for ever: all else being the same, they are one state, and the mechanism
/// stays in the one that it is in. That is a function of state and input, like a step. Report and workspace are those
/// of the step itself.
#[cold]
#[inline(never)]
pub fn step_or_stay<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    input: &SiteInput<T>,
    (before, state): (&State<T, B, Z>, &mut State<T, B, Z>),
    workspace: &mut Workspace<T, B, Z, N>,
) -> StepReport {
    let report = step_out_of_line(model, settings, input, state, workspace);
    if before.identical(state) || !state.stays(settings.step) {
        return report;
    }
    let (mut ahead, mut goes_round) = (state.clone(), false);
    for _ in 1..LONGEST_ROUND {
        step_out_of_line(model, settings, input, &mut ahead, workspace);
        goes_round = before.identical(&ahead);
        if goes_round || !ahead.stays(settings.step) {
            break;
        }
    }
    // Once more, for the workspace.
    state.clone_from(before);
    let report = step_out_of_line(model, settings, input, state, workspace);
    if goes_round {
        state.clone_from(before);
    }
    report
}

impl<T> Sleep<T> {
    /// Returns a record that is awake.
    pub const fn awake() -> Self {
        Sleep { under: None }
    }

    /// Wakes the mechanism: the next step is taken.
    pub fn wake(&mut self) {
        self.under = None;
    }

    /// Returns whether the last step changed nothing.
    pub fn is_asleep(&self) -> bool {
        self.under.is_some()
    }
}

impl<T: Scalar> Sleep<T> {
    /// Returns the report of a step with this input if the step is known to change nothing.
    #[inline(always)]
    pub fn would_rest(&self, input: &SiteInput<T>) -> Option<StepReport> {
        self.under.as_ref().and_then(|(last, report)| last.identical(input).then_some(*report))
    }

    /// Records, after a step with this input, whether the step changed nothing. `before`: the state before the step;
    /// `None` if the mechanism moved ([`State::stays`]), which keeps it awake.
    #[inline]
    pub fn compare<const B: usize, const Z: usize>(
        &mut self,
        before: Option<&State<T, B, Z>>,
        after: &State<T, B, Z>,
        input: &SiteInput<T>,
        report: StepReport,
    ) {
        let same = before.is_some_and(|before| before.identical(after));
        self.under = same.then_some((*input, report));
    }

    /// Takes a step by [`step_out_of_line`], or only returns its report if the step would change nothing.
    pub fn step<const B: usize, const Z: usize, const N: usize>(
        &mut self,
        model: &Model<T, B, Z>,
        settings: &Settings<T>,
        input: &SiteInput<T>,
        state: &mut State<T, B, Z>,
        workspace: &mut Workspace<T, B, Z, N>,
    ) -> StepReport {
        if let Some(report) = self.would_rest(input) {
            return report;
        }
        // A mechanism that moves is not copied: it does not fall asleep in this step.
        let before = state.stays(settings.step).then(|| state.clone());
        let report = step_out_of_line(model, settings, input, state, workspace);
        self.compare(before.as_ref(), state, input, report);
        report
    }
}

impl<T: Real, const B: usize, const Z: usize> State<T, B, Z> {
    /// Returns whether all velocities are zero, in every lane.
    #[inline(always)]
    pub fn stands(&self) -> bool {
        self.velocity.iter().all(|v| (0..T::LANES).all(|lane| v.lane(lane).to_f64() == 0.0))
    }

    /// Returns whether two states are identical to the bit, signs of zeros included, in everything that a step's result
    /// depends on. The broad phase is not compared: it does not change a step's result.
    // Asked only where nothing moves: one copy for a size.
    #[inline(never)]
    pub fn identical(&self, other: &Self) -> bool {
        let mut same = true;
        self.numbers.zip(&other.numbers, |a, b| same = same && same_bits(a, b));
        same
    }
}

impl<T: Scalar, const B: usize, const Z: usize> State<T, B, Z> {
    /// Returns whether no angle would change in a step of this length, s, at the present velocities: these are zero, or
    /// so small that rounding leaves every angle as it is. A step can leave the state as it is only then.
    #[inline(always)]
    pub fn stays(&self, step_s: T) -> bool {
        let mut each = self.angle.iter().zip(&self.velocity);
        each.all(|(angle, velocity)| angle.add_product(step_s, *velocity) == *angle)
    }
}

//! Sleeping: steps that would change nothing are not taken.
//!
//! A step is a function of state and input. If one leaves the state identical to the bit, then every further step with
//! the identical input does the same: it leaves the state as it is, reports the same, and leaves the same in the
//! workspace. So it need not be taken. There is no threshold and no drift: with sleep or without, the bits are the
//! same. A mechanism comes to sleep only where dry friction truly sticks.

use crate::input::Input;
use crate::model::Model;
use crate::real::{Real, Scalar, same_bits};
use crate::settings::Settings;
use crate::state::State;
use crate::step::{StepReport, step_out_of_line};
use crate::workspace::Workspace;

/// Whether a mechanism's last step changed nothing, and under which input.
///
/// It belongs to one [`State`] and its [`Settings`]. Whoever changes either otherwise than by [`Sleep::step`] must call
/// [`Sleep::wake`]; so must whoever wants to read the [`Workspace`] after another state has used it.
#[derive(Debug, Clone, Copy)]
pub struct Sleep<T> {
    under: Option<(Input<T>, StepReport)>,
}

impl<T> Sleep<T> {
    /// Awake.
    pub const fn awake() -> Self {
        Sleep { under: None }
    }

    /// The next step is taken.
    pub fn wake(&mut self) {
        self.under = None;
    }

    /// Whether the last step changed nothing.
    pub fn is_asleep(&self) -> bool {
        self.under.is_some()
    }
}

impl<T: Scalar> Sleep<T> {
    /// The report of a step with this input, if it is known to change nothing.
    #[inline(always)]
    pub fn would_rest(&self, input: &Input<T>) -> Option<StepReport> {
        self.under.as_ref().and_then(|(last, report)| last.identical(input).then_some(*report))
    }

    /// After a step with this input: whether it has changed nothing. `before` is the state before the step, needed of a
    /// mechanism that stood still only.
    #[inline]
    pub fn compare<const B: usize, const Z: usize>(
        &mut self,
        before: Option<&State<T, B, Z>>,
        after: &State<T, B, Z>,
        input: &Input<T>,
        report: StepReport,
    ) {
        let same = before.is_some_and(|before| before.identical(after));
        self.under = same.then_some((*input, report));
    }

    /// [`step_out_of_line`], unless it would change nothing: then only its report is given.
    pub fn step<const B: usize, const Z: usize, const N: usize>(
        &mut self,
        model: &Model<T, B, Z>,
        settings: &Settings<T>,
        input: &Input<T>,
        state: &mut State<T, B, Z>,
        workspace: &mut Workspace<T, B, Z, N>,
    ) -> StepReport {
        if let Some(report) = self.would_rest(input) {
            return report;
        }
        // A mechanism that moves is not copied: it does not fall asleep in this step.
        let before = state.stands().then(|| state.clone());
        let report = step_out_of_line(model, settings, input, state, workspace);
        self.compare(before.as_ref(), state, input, report);
        report
    }
}

impl<T: Real, const B: usize, const Z: usize> State<T, B, Z> {
    /// Whether nothing moves, in any lane.
    #[inline(always)]
    pub fn stands(&self) -> bool {
        self.velocity.iter().all(|v| (0..T::LANES).all(|lane| v.lane(lane).to_f64() == 0.0))
    }

    /// Whether two states are the same to the bit, signs of zeros included, in everything that a step's result depends
    /// on. That leaves out the broad phase: with any of them a step gives the same bits.
    pub fn identical(&self, other: &Self) -> bool {
        let mut same = true;
        self.numbers.zip(&other.numbers, |a, b| same = same && same_bits(a, b));
        same
    }
}

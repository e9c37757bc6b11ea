//! Adaptive steps of an engine.

use moreau::{
    Accuracy, ControlledStep, Controller, Model, Settings, SiteHand, SiteInput, State, StepDoubling, StepOutcome,
    Workspace, controlled_step,
};

/// Callback that returns the input of an inner step. Arguments: time from the start of the adaptive step, s; length of
/// the inner step, s; a function that returns the position of the driven point at that instant, m
/// ([`crate::Observation::site_position`]).
pub type InputDuring<'a> = dyn FnMut(f64, f64, &dyn Fn() -> f64) -> SiteInput<f64> + 'a;

pub(crate) struct Control<const B: usize, const Z: usize, const N: usize> {
    controller: Controller<f64, Z>,
    halves: StepDoubling<f64, B, Z, N>,
    /// Index of the half taken last.
    half: usize,
    /// Hands that drove the halves of the last step, with position and velocity before each.
    pub hands: [Option<(SiteHand<f64>, [f64; 2])>; 2],
}

impl<const B: usize, const Z: usize, const N: usize> Control<B, Z, N> {
    pub(crate) fn new(settings: &Settings<f64>) -> Self {
        Control {
            controller: Controller::new(settings.step),
            halves: StepDoubling::new(settings),
            half: 1,
            hands: [None; 2],
        }
    }

    /// Settings and workspace of the half that was last.
    pub(crate) fn last(&self) -> (&Settings<f64>, &Workspace<f64, B, Z, N>) {
        (&self.halves.settings, &self.halves.workspace[self.half])
    }

    pub(crate) fn enter_second_half(&mut self) {
        self.half = 1;
    }

    /// One adaptive step, and the state at the end of its first half; none where a number is not finite.
    pub(crate) fn step(
        &mut self,
        model: &Model<f64, B, Z>,
        state: &mut State<f64, B, Z>,
        settings: &Settings<f64>,
        accuracy: &Accuracy<f64>,
        limit: f64,
        input: &mut InputDuring,
    ) -> (ControlledStep<f64>, Option<State<f64, B, Z>>) {
        let Control { controller, halves, half, hands } = self;
        let input = |from: f64, h: f64, state: &State<f64, B, Z>| {
            let input = input(from, h, &|| model.site_position(&state.angle));
            // The last two of an attempt drive its halves.
            *hands = [hands[1], hand_of(&input, state)];
            input
        };
        let report = controlled_step(model, settings, accuracy, controller, limit, input, state, halves);
        if report.outcome == StepOutcome::NonFinite {
            return (report, None);
        }
        *half = 0;
        (report, Some(halves.middle.clone()))
    }
}

/// The hand that drives a step, and its place and velocity before it.
#[inline(always)]
pub(crate) fn hand_of<const B: usize, const Z: usize>(
    input: &SiteInput<f64>,
    state: &State<f64, B, Z>,
) -> Option<(SiteHand<f64>, [f64; 2])> {
    if let SiteInput::Hand(hand) = input { Some((*hand, state.hand)) } else { None }
}

//! Adaptive steps with error control. Each step is computed once whole and once in two halves; their difference
//! estimates the error and sets the length.
//!
//! A driver around the inner [`step()`](crate::step()). The equations are in this crate's README, "Error control".

mod changes;

use crate::input::SiteInput;
use crate::model::Model;
use crate::real::{Real, Scalar};
use crate::settings::Settings;
use crate::state::State;
use crate::step::{StepOutcome, step_out_of_line};
use crate::workspace::Workspace;
use changes::Changes;

/// Part of the error allowed that Newton's method may leave in an inner step. More is seen as error and shortens the
/// steps.
const NEWTON_SHARE: f64 = 0.01;
/// A step aims at this part of the length that would just be allowed. More: more are rejected. Less: all are shorter.
const SAFETY: f64 = 0.9;
/// A step is at most so many times as long as the last one, and an attempt at least this part of the one rejected
/// before it.
const GROWTH: f64 = 4.0;
const SHRINKAGE: f64 = 0.1;
/// Most attempts that are rejected in one step; the next one is the smallest step, and is taken.
const REJECTIONS: u32 = 30;
/// Most rejected attempts that aim at the instant at which a law changes.
const AIMED: u32 = 8;

/// Tolerance and bounds of adaptive steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Accuracy<T> {
    /// Relative error allowed in a step. The error of a body's velocity may be this times (`velocity` + |its
    /// velocity|); the error of its angle may be this times `velocity` times `largest`.
    pub tolerance: T,
    /// Reference speed, rad/s. The errors of slower bodies are judged by it. 1 is usual, as for Newton's tolerance.
    pub velocity: T,
    /// Smallest step, s. It is accepted whatever its error, which the report states.
    pub smallest: T,
    /// Largest step, s.
    pub largest: T,
}

impl<T: Real> Accuracy<T> {
    /// Returns an accuracy with a reference speed of 1 rad/s; steps in s.
    pub fn new(tolerance: T, smallest: T, largest: T) -> Self {
        Accuracy { tolerance, velocity: T::ONE, smallest, largest }
    }
}

/// Step-size controller. It keeps its data from step to step, belongs to one [`State`], and must be new for a new
/// state.
#[derive(Debug, Clone, Copy)]
pub struct Controller<T, const Z: usize> {
    /// The length to try next, s.
    next: T,
    /// Length of the last inner step, s; zero before the first.
    last: T,
    /// Error of the last step as a part of what was allowed.
    error: T,
    /// Slip velocities now along the last inner step's rows, m/s, and how fast they changed in it, m/s2.
    slip: [T; Z],
    slip_rate: [T; Z],
}

impl<T: Real, const Z: usize> Controller<T, Z> {
    /// Returns a controller that tries a step of length `first` (s) first.
    pub fn new(first: T) -> Self {
        Controller { next: first, last: T::ZERO, error: T::ONE, slip: [T::ZERO; Z], slip_rate: [T::ZERO; Z] }
    }
}

/// Working memory of an adaptive step, and the results of its two halves.
#[derive(Debug, Clone)]
pub struct StepDoubling<T: Real, const B: usize, const Z: usize, const N: usize> {
    /// Settings of each half.
    pub settings: Settings<T>,
    /// State between the halves.
    pub middle: State<T, B, Z>,
    /// Workspace of each half, with its forces.
    pub workspace: [Workspace<T, B, Z, N>; 2],
    end: State<T, B, Z>,
    whole: State<T, B, Z>,
}

impl<T: Real, const B: usize, const Z: usize, const N: usize> StepDoubling<T, B, Z, N> {
    /// Returns new working memory. Results do not depend on previous contents.
    pub fn new(settings: &Settings<T>) -> Self {
        let state = || State::at_rest([T::ZERO; B]);
        let workspace = [Workspace::new(), Workspace::new()];
        StepDoubling { settings: *settings, middle: state(), workspace, end: state(), whole: state() }
    }

    /// Relative velocities before and after each half of a step from `start`.
    fn joints(&self, model: &Model<T, B, Z>, start: &State<T, B, Z>) -> [[[T; B]; 2]; 2] {
        let [w0, w1, w2] = [start, &self.middle, &self.end].map(|s| model.tree.relative(&s.velocity));
        [[w0, w1], [w1, w2]]
    }
}

/// Report of an adaptive step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ControlledStep<T> {
    /// Outcome of the step; [`StepOutcome::NonFinite`] and [`StepOutcome::TooManyLaws`] leave the state unchanged.
    pub outcome: StepOutcome,
    /// Length, s.
    pub step: T,
    /// Estimated error over the error allowed; above one only at the smallest step.
    pub error: T,
    /// Whether Richardson extrapolation combined whole and halves to a higher order.
    pub extrapolated: bool,
    /// Rejected attempts.
    pub rejected: u32,
    /// Inner steps of all attempts.
    pub inner: u32,
    /// Newton iterations of all inner steps.
    pub newton: u32,
    /// Solver iterations (sweeps or active sets) of all inner steps.
    pub solver: u32,
}

/// Advances `state` by one step whose length is set by the error allowed, and is at most `limit` (s). Never allocates
/// and never panics; the number of inner steps is bounded.
///
/// `input(from, h, state)` returns the input of an inner step of length `h` (s) that starts `from` (s) after this
/// step's start, at `state` ([`SiteInput`] states at which instant each of its numbers holds). The controller does not
/// see how the drive changes between these instants, so end a step where the drive jumps.
///
/// `settings.step` is not used. The Newton tolerance is at most a hundredth of the accuracy's tolerance. Use theta =
/// 1/2: with a larger theta the scheme is of first order, and steps are shorter.
#[allow(clippy::too_many_arguments)]
pub fn controlled_step<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    accuracy: &Accuracy<T>,
    controller: &mut Controller<T, Z>,
    limit: T,
    mut input: impl FnMut(T, T, &State<T, B, Z>) -> SiteInput<T>,
    state: &mut State<T, B, Z>,
    halves: &mut StepDoubling<T, B, Z, N>,
) -> ControlledStep<T> {
    let wanted = controller.next.max(accuracy.smallest).min(accuracy.largest);
    // What is left is taken at once or in two: no crumb remains.
    let first = if limit <= wanted { limit } else { wanted.min(T::from_f64(0.5) * limit) };
    let newton = accuracy.tolerance * accuracy.velocity.min(T::ONE) * T::from_f64(NEWTON_SHARE);
    let tolerance = newton.max(T::from_f64(64.0) * T::EPSILON);
    let settings = Settings { tolerance: tolerance.min(settings.tolerance), ..*settings };
    let mut report = ControlledStep {
        outcome: StepOutcome::Converged,
        step: first,
        error: T::ZERO,
        extrapolated: false,
        rejected: 0,
        inner: 0,
        newton: 0,
        solver: 0,
    };
    let changes = loop {
        attempt(model, &settings, controller, &mut input, state, halves, &mut report);
        let h = report.step;
        let changes = if settings.friction.is_regularised() {
            Changes::none()
        } else {
            Changes::find(model, settings.solver_tolerance, controller, state, halves)
        };
        report.error = error(accuracy, &changes, halves);
        let sound = report.outcome == StepOutcome::Converged && report.error.finite();
        if (sound && report.error <= T::ONE) || h <= accuracy.smallest {
            break changes;
        }
        report.rejected += 1;
        let factor =
            if sound { T::from_f64(SAFETY) * report.error.powf(-exponent(&settings, &changes)) } else { T::ZERO };
        let shorter = h * factor.max(T::from_f64(SHRINKAGE)).min(T::from_f64(0.5));
        report.step = match changes.instant {
            Some(at) if sound && report.rejected <= AIMED && at < h => at.max(shorter),
            _ if report.rejected >= REJECTIONS => accuracy.smallest,
            _ => shorter,
        }
        .max(accuracy.smallest.min(limit));
    };
    if matches!(report.outcome, StepOutcome::NonFinite | StepOutcome::TooManyLaws) {
        return report;
    }
    let second = halves.joints(model, state)[1];
    *state = halves.end.clone();
    report.extrapolated = !changes.any && extrapolate(model, halves, state);
    controller.last = halves.settings.step;
    controller.slip = slips(model, &halves.workspace[1], state);
    for (z, rate) in controller.slip_rate.iter_mut().enumerate() {
        let [u0, u1] = halves.workspace[1].slip(model, z, &second);
        *rate = (u1 - u0) / controller.last;
    }
    let next = report.step * growth(exponent(&settings, &changes), &report, controller.error);
    // A step that the limit cut off says little of what length is possible.
    let cut = report.rejected == 0 && first < wanted;
    controller.next = if cut { next.max(wanted) } else { next };
    controller.error = if report.error <= T::ONE { report.error.max(T::from_f64(1e-2)) } else { T::ONE };
    report
}

/// The step `report.step` from `state` on, whole and in halves.
fn attempt<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    settings: &Settings<T>,
    controller: &Controller<T, Z>,
    input: &mut impl FnMut(T, T, &State<T, B, Z>) -> SiteInput<T>,
    state: &State<T, B, Z>,
    halves: &mut StepDoubling<T, B, Z, N>,
    report: &mut ControlledStep<T>,
) {
    let StepDoubling { settings: own, middle, workspace: [first, second], end, whole } = halves;
    let h = report.step;
    *own = Settings { step: T::from_f64(0.5) * h, ..*settings };
    let mut worst = StepOutcome::Converged;
    // From what the inner step before left: its length, and the slips along its rows.
    let mut go = |settings: &Settings<T>,
                  from: T,
                  last: T,
                  slip: &[T; Z],
                  state: &mut State<T, B, Z>,
                  workspace: &mut Workspace<T, B, Z, N>| {
        let ratio = if T::ZERO < last { settings.step / last } else { T::ZERO };
        for increment in &mut state.increment {
            *increment = *increment * ratio;
        }
        workspace.turning.slip_before = *slip;
        workspace.turning.span = (T::ONE - settings.theta) * last;
        let input = input(from, settings.step, state);
        let did = step_out_of_line(model, settings, &input, state, workspace);
        report.inner += 1;
        report.newton += did.newton;
        report.solver += did.solver;
        worst = match (worst, did.outcome) {
            (StepOutcome::TooManyLaws, _) | (_, StepOutcome::TooManyLaws) => StepOutcome::TooManyLaws,
            (StepOutcome::NonFinite, _) | (_, StepOutcome::NonFinite) => StepOutcome::NonFinite,
            (StepOutcome::IterationLimit, _) | (_, StepOutcome::IterationLimit) => StepOutcome::IterationLimit,
            _ => StepOutcome::Converged,
        };
    };
    whole.clone_from(state);
    go(&Settings { step: h, ..*settings }, T::ZERO, controller.last, &controller.slip, whole, second);
    middle.clone_from(state);
    // What is out of the whole step's reach is out of the halves', too: one broad phase serves all three.
    middle.broad_phase = whole.broad_phase;
    middle.forget_far(model);
    go(own, T::ZERO, controller.last, &controller.slip, middle, first);
    end.clone_from(middle);
    go(own, own.step, own.step, &slips(model, first, middle), end, second);
    report.outcome = worst;
}

/// Slip velocities of a state along an inner step's rows.
fn slips<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    workspace: &Workspace<T, B, Z, N>,
    state: &State<T, B, Z>,
) -> [T; Z] {
    let w = model.tree.relative(&state.velocity);
    let mut slips = [T::ZERO; Z];
    for &z in &model.sliding_zones[..model.sliding_count] {
        if workspace.touched_in(z) {
            slips[z] = model.supports[z].product(&workspace.contacts.slip_row[z], &w);
        }
    }
    slips
}

/// The error of the halves' result as a part of what is allowed.
fn error<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    accuracy: &Accuracy<T>,
    changes: &Changes<T, B>,
    halves: &StepDoubling<T, B, Z, N>,
) -> T {
    // Where laws change, nothing is known of the halves' error but that it is no larger than the whole's.
    let share = if changes.any { T::ONE } else { share(&halves.settings) };
    let (end, whole) = (&halves.end, &halves.whole);
    let turn = accuracy.tolerance * accuracy.velocity * accuracy.largest;
    let mut error = T::ZERO;
    for i in 0..B {
        let allowed = accuracy.tolerance * (accuracy.velocity + end.velocity[i].abs());
        let velocity = (share * (end.velocity[i] - whole.velocity[i]).abs()).max(changes.hidden[i]) / allowed;
        let angle = share * (end.angle[i] - whole.angle[i]).abs() / turn;
        // A sum is not a number if a part is not, a maximum may be.
        error = if (velocity + angle).finite() { error.max(velocity).max(angle) } else { velocity + angle };
    }
    if end.hand != whole.hand {
        // What counts for a joint at the driven point's lever counts for the hand.
        let lever = halves.workspace[1].drive.site_row.iter().fold(T::ZERO, |most, entry| most.max(entry.abs()));
        let allowed = accuracy.tolerance * (accuracy.velocity * lever + end.hand[1].abs());
        let velocity = share * (end.hand[1] - whole.hand[1]).abs() / allowed;
        let place = share * (end.hand[0] - whole.hand[0]).abs() / (turn * lever);
        error = if (velocity + place).finite() { error.max(velocity).max(place) } else { velocity + place };
    }
    error
}

/// Whether the scheme is of second order, which it is at theta = 1/2 only.
fn second_order<T: Scalar>(settings: &Settings<T>) -> bool {
    settings.theta <= T::from_f64(0.5)
}

/// The halves' error where all is smooth, over its difference from the whole's, of which it is a quarter (at first
/// order a half).
fn share<T: Scalar>(settings: &Settings<T>) -> T {
    if second_order(settings) { T::ONE / T::from_f64(3.0) } else { T::ONE }
}

/// The length's growth with the error allowed: a step's error grows with its cube where all is smooth, with its square
/// where a law changes or the scheme is of first order.
fn exponent<T: Scalar, const B: usize>(settings: &Settings<T>, changes: &Changes<T, B>) -> T {
    if second_order(settings) && !changes.any { T::ONE / T::from_f64(3.0) } else { T::from_f64(0.5) }
}

/// Richardson's extrapolation of the velocities and angles, and of the hand: a step's error h^3 becomes h^4. Not where
/// it would turn a joint around.
fn extrapolate<T: Scalar, const B: usize, const Z: usize, const N: usize>(
    model: &Model<T, B, Z>,
    halves: &StepDoubling<T, B, Z, N>,
    state: &mut State<T, B, Z>,
) -> bool {
    let share = share(&halves.settings);
    let (mut v, mut q) = (state.velocity, state.angle);
    for i in 0..B {
        v[i] += share * (v[i] - halves.whole.velocity[i]);
        q[i] += share * (q[i] - halves.whole.angle[i]);
    }
    let (before, after) = (model.tree.relative(&state.velocity), model.tree.relative(&v));
    let sound = (0..B).all(|i| T::ZERO <= before[i] * after[i]);
    if sound {
        (state.velocity, state.angle) = (v, q);
        for (own, whole) in state.hand.iter_mut().zip(halves.whole.hand) {
            *own += share * (*own - whole);
        }
    }
    sound
}

/// Next length over this one: Gustafsson's proportional-integral controller.
fn growth<T: Scalar>(exponent: T, report: &ControlledStep<T>, last_error: T) -> T {
    let error = if report.error.finite() { report.error.max(T::from_f64(1e-6)) } else { T::from_f64(1e6) };
    let factor =
        T::from_f64(SAFETY) * error.powf(T::from_f64(-0.7) * exponent) * last_error.powf(T::from_f64(0.4) * exponent);
    let most = if report.rejected > 0 { T::ONE } else { T::from_f64(GROWTH) };
    factor.max(T::from_f64(SHRINKAGE)).min(most)
}

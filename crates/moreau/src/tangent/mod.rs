//! Derivatives of a motion with switching laws, by forward mode. The equations are in this crate's README,
//! "Derivatives".
//!
//! Steps are taken in [`Dual`] numbers and end where a slipping law begins to stick or reverses. There the saltation
//! matrix gives the jump of the derivatives.

mod crossing;
mod switch;

use crate::description::ModelError;
use crate::dual::Dual;
use crate::input::SiteInput;
use crate::model::Model;
use crate::real::Real;
use crate::saved::SavedState;
use crate::settings::{FrictionLaw, Settings};
use crate::state::State;
use crate::step::{StepOutcome, step_out_of_line};
use crate::workspace::Workspace;
use crossing::Crossing;
use switch::{Before, Change, LetGo, Slips};

pub use switch::SwitchingLaw;

/// The instant of a switch is found to this part of the step. Derivatives err by about as much; rounding forbids far
/// less.
const RESOLUTION: f64 = 1e-5;
/// The shortest bracket of an instant, as a part of the step: what follows another switch so closely is taken as it
/// comes, and counted.
const SHORTEST: f64 = 1e-8;
/// Bisections of a step, at most.
const BISECTIONS: u32 = 60;
/// A switch is crossed from no farther away than this part of the step: a long step and a few short ones do not put it
/// at quite the same instant.
const NEAR: f64 = 2e-4;
/// The part of the way to a switch that a step toward it leaves, and the least that it leaves, as a part of the step.
const CLOSER: [f64; 2] = [0.02, 4.0 * RESOLUTION];
/// Newton iterations of a step, at most: the derivatives converge linearly, by the part of the Jacobian that the step
/// leaves out.
const ITERATIONS: u32 = 16;

/// Callback that returns the input of an inner step. Arguments: time from the outer step's start to the inner step's
/// start, s; length of the inner step, s; position of the driven point at that start, m.
pub type Driven<'a, const D: usize> = dyn FnMut(f64, f64, Dual<D>) -> SiteInput<Dual<D>> + 'a;

/// Callback that receives every [`Switch`].
pub type Switched<'a> = dyn FnMut(Switch) + 'a;

/// Switch of a friction law within a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Switch {
    /// Time from the step's start, s.
    pub after_s: f64,
    /// Law that switched; `None` if it could not be identified.
    pub law: Option<SwitchingLaw>,
    /// Kind of the switch.
    pub kind: SwitchKind,
}

/// Kind of a switch.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SwitchKind {
    /// The law begins to stick.
    Sticks,
    /// The slip reverses.
    Reverses,
    /// The switch could not be separated from another one.
    Unresolved,
}

/// Report of a step with derivatives.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
#[non_exhaustive]
pub struct TangentReport {
    /// Switches at which the derivatives jumped.
    pub switches: u32,
    /// Switches that could not be separated from the previous one. Across these the derivatives are those of one step
    /// over both.
    pub unresolved: u32,
    /// Inner steps whose derivatives or velocities did not converge.
    pub unconverged: u32,
    /// Whether a number became infinite or NaN. If so, all further results are invalid.
    pub failed: bool,
}

impl TangentReport {
    /// Returns the combined report of two consecutive parts of a motion.
    pub fn and(self, other: TangentReport) -> Self {
        TangentReport {
            switches: self.switches + other.switches,
            unresolved: self.unresolved + other.unresolved,
            unconverged: self.unconverged + other.unconverged,
            failed: self.failed || other.failed,
        }
    }
}

/// A mechanism with the derivatives of its motion in D directions.
#[derive(Debug, Clone)]
pub struct Tangent<const B: usize, const Z: usize, const N: usize, const D: usize> {
    /// Model, with the derivatives of its numbers in the directions.
    pub model: Model<Dual<D>, B, Z>,
    plain: Model<f64, B, Z>,
    /// State, with its derivatives in the directions.
    pub state: State<Dual<D>, B, Z>,
    workspace: Workspace<Dual<D>, B, Z, N>,
    probe: Workspace<f64, B, Z, N>,
    /// Treatment of a switch that cannot be separated from another one. If true, the derivatives continue unchanged
    /// across it; if false, they are those of a step across it. The difference between both is the uncertainty due to
    /// such switches.
    pub passes_unresolved: bool,
    /// Length of the last inner step, s; 0 before the first.
    last: f64,
}

/// Error: the model has no derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum TangentError {
    /// The model has more set-valued laws than N.
    Model(ModelError),
    /// Friction that grows at rest is not supported: its bound jumps when it begins to slip.
    Dwell,
    /// A felt with a set-valued loss ([`Loss::SetValued`](crate::Loss)) is not supported: its reversals are not derived
    /// here.
    SetValuedFelt,
    /// A zone with a compliant surface ([`Yields`](crate::Yields)) is not supported: the external subsystem has no
    /// derivatives here.
    Yielding,
}

impl<const B: usize, const Z: usize, const N: usize, const D: usize> Tangent<B, Z, N, D> {
    /// Builds the tangent of a model in dual numbers, at rest at absolute angles, rad. `plain` is the same model in
    /// plain numbers.
    ///
    /// # Errors
    /// Returns [`TangentError`] if the model has a part without derivatives here, or more laws than N.
    pub fn new(
        model: Model<Dual<D>, B, Z>,
        plain: Model<f64, B, Z>,
        angle: [Dual<D>; B],
    ) -> Result<Self, TangentError> {
        if model.dwelling.count > 0 {
            return Err(TangentError::Dwell);
        }
        if model.dry_count > 0 {
            return Err(TangentError::SetValuedFelt);
        }
        if (0..Z).any(|zone| model.yields(zone)) {
            return Err(TangentError::Yielding);
        }
        let workspace = Workspace::for_model(&model).map_err(TangentError::Model)?;
        let (state, probe) = (State::at_rest(angle), Workspace::new());
        Ok(Tangent { model, plain, state, workspace, probe, passes_unresolved: false, last: 0.0 })
    }

    /// Advances by h = `settings.step`, in inner steps that end where a law changes. `switched` receives every switch.
    pub fn step(
        &mut self,
        settings: &Settings<f64>,
        input: &mut Driven<'_, D>,
        switched: &mut Switched<'_>,
    ) -> TangentReport {
        let h = settings.step;
        let (mut done, mut all, mut gone) = (0.0, TangentReport::default(), LetGo::default());
        // Each inner step but the last ends on a change; as many as there are laws may come at once.
        for _ in 0..8 * (B + Z) {
            let left = h - done;
            if left <= SHORTEST * h || all.failed {
                return all;
            }
            let drive = input(done, left, self.site());
            let whole = self.probe(settings, left, &drive);
            if !self.changes(&whole, &gone) {
                return all.and(self.go(settings, left, &drive));
            }
            let (until, stretch) = self.advance_to_change(settings, [done, left], &mut gone, input, switched);
            all = all.and(stretch);
            done += until;
        }
        let left = h - done;
        let drive = input(done, left, self.site());
        switched(Switch { after_s: done, law: None, kind: SwitchKind::Unresolved });
        all.and(TangentReport { unresolved: 1, ..self.go(settings, left, &drive) })
    }

    /// Returns the normal force of a zone during the last inner step, N.
    pub fn normal_force(&self, settings: &Settings<f64>, zone: usize) -> Dual<D> {
        let settings = dual_settings(&Settings { step: self.last, ..*settings });
        self.workspace.normal_force(&self.model, &settings, zone)
    }

    /// Returns the length of the last inner step, s; 0 before the first.
    pub fn last_step_s(&self) -> f64 {
        self.last
    }

    /// Returns the world coordinate of the driven point along the site's direction, m.
    pub fn site(&self) -> Dual<D> {
        self.model.site_position(&self.state.angle)
    }

    /// A step in plain numbers from where it is.
    fn probe(&mut self, settings: &Settings<f64>, length: f64, drive: &SiteInput<Dual<D>>) -> State<f64, B, Z> {
        let from = plain(&self.state);
        self.probe_from(&from, self.last, settings, length, drive)
    }

    fn probe_from(
        &mut self,
        from: &State<f64, B, Z>,
        last: f64,
        settings: &Settings<f64>,
        length: f64,
        drive: &SiteInput<Dual<D>>,
    ) -> State<f64, B, Z> {
        let mut state = from.clone();
        rescale(&mut state.increment, length, last);
        let settings = Settings { step: length, ..*settings };
        let _ = step_out_of_line(&self.plain, &settings, &drive.map(|x| x.value), &mut state, &mut self.probe);
        state
    }

    /// Whether a law has changed in the last probe, which led from here to `after`.
    fn changes(&self, after: &State<f64, B, Z>, gone: &LetGo) -> bool {
        let before = Before::of(&self.plain, &plain(&self.state));
        before.changes(&self.plain, &self.probe, after).any(|change| gone.is_new(change))
    }

    /// A step in dual numbers.
    fn go(&mut self, settings: &Settings<f64>, length: f64, drive: &SiteInput<Dual<D>>) -> TangentReport {
        rescale(&mut self.state.increment, Dual::constant(length), Dual::constant(self.last));
        let settings = dual_settings(&Settings { step: length, ..*settings });
        let report = step_out_of_line(&self.model, &settings, drive, &mut self.state, &mut self.workspace);
        self.last = length;
        let sound = self.state.angle.iter().chain(&self.state.velocity).all(Dual::is_finite);
        TangentReport {
            unconverged: u32::from(report.outcome == StepOutcome::IterationLimit),
            failed: !sound || matches!(report.outcome, StepOutcome::NonFinite | StepOutcome::TooManyLaws),
            ..TangentReport::default()
        }
    }

    /// Advances to the first change within the next `left` s, and across it if it is a switch. Returns how long that
    /// took, s.
    fn advance_to_change(
        &mut self,
        settings: &Settings<f64>,
        [done, left]: [f64; 2],
        gone: &mut LetGo,
        input: &mut Driven<'_, D>,
        switched: &mut Switched<'_>,
    ) -> (f64, TangentReport) {
        let h = settings.step;
        let site = self.site();
        let (mut low, mut high) = (0.0, left);
        for _ in 0..BISECTIONS {
            // Near the start the bracket is narrowed further, so that there is room for two small steps before it.
            if high - low <= (RESOLUTION * h).min(0.1 * low) || high <= SHORTEST * h {
                break;
            }
            let middle = 0.5 * (low + high);
            let drive = input(done, middle, site);
            let state = self.probe(settings, middle, &drive);
            if self.changes(&state, gone) { high = middle } else { low = middle }
        }
        let drive = input(done, high, site);
        let state = self.probe(settings, high, &drive);
        let before = Before::of(&self.plain, &plain(&self.state));
        let (mut switches, now) = (None, *gone);
        for change in before.changes(&self.plain, &self.probe, &state).filter(|change| now.is_new(*change)) {
            match change {
                Change::Switches(law) => switches = Some(law),
                Change::LetsGo(law) => gone.add(law),
            }
        }
        let unresolved = |after_s: f64, law| Switch { after_s, law, kind: SwitchKind::Unresolved };
        if switches.is_none() {
            // From here on it may slip.
            if low <= SHORTEST * h {
                return (0.0, TangentReport::default());
            }
            let drive = input(done, low, site);
            return (low, self.go(settings, low, &drive));
        }
        if low > NEAR * h {
            let at = low - (CLOSER[0] * low).max(CLOSER[1] * h);
            let drive = input(done, at, site);
            return (at, self.go(settings, at, &drive));
        }
        let small = (RESOLUTION * h).min(0.1 * low);
        if small < 0.1 * SHORTEST * h {
            let across = (2.0 * high).max(SHORTEST * h).min(left);
            let drive = input(done, across, site);
            switched(unresolved(done + high, switches));
            let report = TangentReport { unresolved: 1, ..TangentReport::default() };
            if self.passes_unresolved {
                let after = self.probe(settings, across, &drive);
                self.move_on(across);
                self.take_over(&after);
                self.last = across;
                return (across, report);
            }
            return (across, report.and(self.go(settings, across, &drive)));
        }
        let (mut all, mut at) = (TangentReport::default(), 0.0);
        // Two small steps up to the switch tell the slips and accelerations before it.
        let (mut velocity, mut slips) = ([[0.0; B]; 2], [const { Slips::none() }; 2]);
        for k in 0..2 {
            let drive = input(done + at, small, self.site());
            all = all.and(self.go(settings, small, &drive));
            let w = self.model.tree.relative(&self.state.velocity);
            slips[k] = Slips::of(&self.model, &self.workspace, &w);
            velocity[k] = self.state.velocity.map(|v| v.value);
            at += small;
        }
        let crossing = self.cross(settings, done + at, &slips, [small, 2.0 * high], input);
        let Some(Crossing { law, rate, length, after, together }) = crossing else {
            switched(unresolved(done + at, switches));
            return (at, all.and(TangentReport { unresolved: 1, ..TangentReport::default() }));
        };
        let came = law.side(&self.plain, &plain(&self.state));
        let (first, second, ahead) = self.beyond(settings, done + at, &after, [length, small], law, input);
        let slip = slips[1].slip(law);
        self.move_on(length);
        for i in 0..B {
            if together > 0 && self.passes_unresolved {
                break;
            }
            let acceleration = (velocity[1][i] - velocity[0][i]) / small;
            let thereafter = (second.velocity[i] - first.velocity[i]) / ahead;
            // The saltation matrix: I + (f_after - f_before) grad(u) / (du/dt before).
            let jump = (thereafter - acceleration) / rate;
            let v = &mut self.state.velocity[i];
            for d in 0..D {
                v.slope[d] += jump * slip.slope[d];
            }
        }
        // A step across a reversal may end at rest, and only the next one slips back. That is no stick: a dual step
        // from there would ask for du = 0. What slips on as it came does stick: the contact has turned since, and the
        // bound was too small to make up for that in a shorter step.
        let [rests, goes] = [&after, &second].map(|state| law.side(&self.plain, state));
        let turns = [rests, goes].contains(&-came);
        let kind = if turns { SwitchKind::Reverses } else { SwitchKind::Sticks };
        switched(Switch { after_s: done + at, law: Some(law), kind });
        if together > 0 {
            switched(unresolved(done + at, None));
        }
        let (end, length, last) =
            if rests == 0.0 && turns { (second, length + 2.0 * ahead, ahead) } else { (after, length, length) };
        self.take_over(&end);
        self.last = last;
        (at + length, all.and(TangentReport { switches: 1, unresolved: together, ..TangentReport::default() }))
    }

    /// Moves the derivatives of the places by those of the velocities. A hand's force does not jump at a switch.
    fn move_on(&mut self, length: f64) {
        let SavedState { velocity, angle, hand: [place, speed], .. } = &mut *self.state;
        for (q, v) in angle.iter_mut().zip(velocity.iter()).chain([(place, &*speed)]) {
            for d in 0..D {
                q.slope[d] += length * v.slope[d];
            }
        }
    }

    /// Goes on from a plain state; what depends on the directions is kept.
    fn take_over(&mut self, after: &State<f64, B, Z>) {
        let values = self.state.numbers.zip(&after.numbers, |own, value| Dual { value, ..own });
        let SavedState { angle, velocity, memory, hand, .. } = values;
        self.state.numbers = SavedState { angle, velocity, memory, hand, ..after.map(Dual::constant) };
    }
}

/// The state without what depends on the directions.
fn plain<const B: usize, const Z: usize, const D: usize>(state: &State<Dual<D>, B, Z>) -> State<f64, B, Z> {
    State::from(state.map(|x| x.value))
}

fn dual_settings<const D: usize>(settings: &Settings<f64>) -> Settings<Dual<D>> {
    let t = Dual::constant;
    Settings {
        step: t(settings.step),
        theta: t(settings.theta),
        tolerance: t(settings.tolerance),
        newton_limit: settings.newton_limit.min(ITERATIONS),
        solver_tolerance: t(settings.solver_tolerance),
        solver_limit: settings.solver_limit,
        solver: settings.solver,
        // Only the set-valued law switches.
        friction: FrictionLaw::SetValued,
    }
}

/// The increment over a step of another length is foreseen in proportion.
fn rescale<T: Real, const B: usize>(increment: &mut [T; B], length: T, last: T) {
    let ratio = T::select(T::ZERO.lt(last), length / T::select(T::ZERO.lt(last), last, T::ONE), T::ZERO);
    for x in increment {
        *x = *x * ratio;
    }
}

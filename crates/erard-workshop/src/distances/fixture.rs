//! An action on the bench and the finger that presses it: slowly, until an observed event, or with a constant force.

use moreau::{Settings, StepOutcome};
use thiserror::Error;

use erard::Progress;
use erard::grand::{Anatomy, AnatomyError};
use erard::instrument::{Instrument, Vec2};
use erard::player::equilibrium::EquilibriumError;
use erard::player::{Action, ActionError, AtRest, Input, RestPose};

/// Reason why nothing could be measured.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum DistanceError {
    /// The instrument is no grand action.
    #[error(transparent)]
    Anatomy(#[from] AnatomyError),
    /// The action cannot be assembled, or has no equilibrium.
    #[error(transparent)]
    Action(ActionError),
    /// A change of the instrument is not possible.
    #[error("the instrument cannot be changed: {0}")]
    Invalid(#[from] erard::instrument::InvalidInstrument),
    /// A number overflowed.
    #[error("a number became infinite while the key was pressed. Look for a stiffness, mass or length that is far off")]
    NonFinite,
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl From<ActionError> for DistanceError {
    fn from(error: ActionError) -> Self {
        match error {
            ActionError::Equilibrium(EquilibriumError::Interrupted) => DistanceError::Interrupted,
            error => DistanceError::Action(error),
        }
    }
}

/// Steps between questions to the caller whether to go on.
const ASK_EVERY: u64 = 4096;
/// Acceleration time of a slow finger, s: three swings of the hammer on its felts, so that it does not start to swing.
const GATHERING_S: f64 = 0.3;
/// Braking time of the finger, s: it travels another twentieth of a millimetre meanwhile.
const BRAKING_S: f64 = 0.02;

/// Observed values of an action.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct View {
    /// Travel of the key front from its rest, m, down positive.
    pub key_m: f64,
    /// Strike point to string, m.
    pub below_string_m: f64,
    /// Distance of strike point and string, m.
    pub rise_m_per_s: f64,
    /// Force of the finger, N.
    pub force_n: f64,
}

/// An action on the bench.
pub(super) struct Fixture<'i> {
    instrument: &'i Instrument,
    anatomy: Anatomy,
    action: Action,
    /// Position of the fingertip as key travel, m below rest.
    finger_m: f64,
    /// The finger's speed, m/s, down positive.
    speed_m_per_s: f64,
    before: View,
    steps: u64,
    /// Steps that reached an iteration limit.
    pub unconverged: u64,
}

impl<'i> Fixture<'i> {
    /// The action at rest with the key untouched.
    pub(crate) fn at_rest(rest: &'i RestPose, anatomy: Anatomy, step_s: f64) -> Result<Self, DistanceError> {
        let (instrument, action) = (rest.instrument(), rest.action(Settings::new(step_s))?);
        let below_string_m = -action.mechanism().compression(anatomy.string);
        let view = View { key_m: 0.0, below_string_m, rise_m_per_s: 0.0, force_n: 0.0 };
        Ok(Fixture {
            instrument,
            anatomy,
            action,
            finger_m: 0.0,
            speed_m_per_s: 0.0,
            before: view,
            steps: 0,
            unconverged: 0,
        })
    }

    /// Returns the present values.
    pub(crate) fn view(&self) -> View {
        self.before
    }

    /// Simulated time since rest, s.
    pub(crate) fn time_s(&self) -> f64 {
        self.steps as f64 * self.action.settings().step
    }

    /// Compression of a zone, m; negative where it is open.
    pub(crate) fn compression(&self, zone: usize) -> f64 {
        self.action.mechanism().compression(zone)
    }

    /// A point of a body in the world, m.
    pub(crate) fn point(&self, body: Option<usize>, point: Vec2) -> Vec2 {
        self.action.mechanism().point(body, point)
    }

    fn take(&mut self, input: Input, progress: &mut Progress<'_>) -> Result<(), DistanceError> {
        if self.steps.is_multiple_of(ASK_EVERY) && !progress(0.0) {
            return Err(DistanceError::Interrupted);
        }
        match self.action.step(input).outcome {
            StepOutcome::Converged => {}
            StepOutcome::IterationLimit => self.unconverged += 1,
            StepOutcome::NonFinite | StepOutcome::TooManyLaws => return Err(DistanceError::NonFinite),
        }
        self.steps += 1;
        let step_s = self.action.settings().step;
        let below_string_m = -self.action.mechanism().compression(self.anatomy.string);
        self.before = View {
            key_m: self.action.reading().key_m,
            below_string_m,
            rise_m_per_s: (self.before.below_string_m - below_string_m) / step_s,
            force_n: self.action.reading().finger_force_n,
        };
        Ok(())
    }

    /// Moves the finger by one step, at a speed or accelerating to it.
    fn finger_step(
        &mut self,
        to_m_per_s: f64,
        over_s: f64,
        cruise_m_per_s: f64,
        progress: &mut Progress<'_>,
    ) -> Result<(), DistanceError> {
        let Settings { step, theta, .. } = *self.action.settings();
        let most = cruise_m_per_s.abs() * step / over_s;
        let speed = self.speed_m_per_s + (to_m_per_s - self.speed_m_per_s).clamp(-most, most);
        let middle = 0.5 * (self.speed_m_per_s + speed);
        let position_m = self.finger_m + theta * step * middle;
        self.take(Input::Motion { position_m, velocity_m_per_s: middle }, progress)?;
        self.finger_m += step * middle;
        self.speed_m_per_s = speed;
        Ok(())
    }

    /// Moves the finger at a speed (m/s, down positive), reached gently, until `seen` returns true or the finger
    /// reaches `until_m`. Returns whether `seen` did.
    pub(crate) fn move_finger(
        &mut self,
        speed_m_per_s: f64,
        until_m: f64,
        seen: &mut dyn FnMut(&Self) -> bool,
        progress: &mut Progress<'_>,
    ) -> Result<bool, DistanceError> {
        while (until_m - self.finger_m) * speed_m_per_s > 0.0 {
            self.finger_step(speed_m_per_s, GATHERING_S, speed_m_per_s, progress)?;
            if seen(self) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Stops the finger and holds it for a time; `seen` is called at every step, and may end the time.
    pub(crate) fn hold(
        &mut self,
        for_s: f64,
        seen: &mut dyn FnMut(&Self) -> bool,
        progress: &mut Progress<'_>,
    ) -> Result<(), DistanceError> {
        let cruise = self.speed_m_per_s;
        let until = self.time_s() + for_s;
        while self.time_s() < until {
            self.finger_step(0.0, BRAKING_S, cruise, progress)?;
            if seen(self) {
                break;
            }
        }
        Ok(())
    }

    /// Presses with a constant force, N, for a time; `seen` is called at every step, and may end the time.
    pub(crate) fn press(
        &mut self,
        force_n: f64,
        for_s: f64,
        seen: &mut dyn FnMut(&Self) -> bool,
        progress: &mut Progress<'_>,
    ) -> Result<(), DistanceError> {
        let until = self.time_s() + for_s;
        while self.time_s() < until {
            self.take(Input::Force(force_n), progress)?;
            if seen(self) {
                break;
            }
        }
        // A finger that takes over starts where its flesh gives this force.
        self.finger_m = self.before.key_m + force_n / self.instrument.finger.stiffness_n_per_m;
        self.speed_m_per_s = 0.0;
        Ok(())
    }
}

/// Detects that the hammer is at rest: slower than `below_m_per_s` for `for_s` without a break.
pub(super) struct Still {
    below_m_per_s: f64,
    for_s: f64,
    since_s: Option<f64>,
}

impl Still {
    pub(crate) fn new(below_m_per_s: f64, for_s: f64) -> Self {
        Still { below_m_per_s, for_s, since_s: None }
    }

    pub(crate) fn seen(&mut self, fixture: &Fixture<'_>) -> bool {
        let now = fixture.time_s();
        if fixture.view().rise_m_per_s.abs() > self.below_m_per_s {
            self.since_s = None;
            return false;
        }
        now - *self.since_s.get_or_insert(now) >= self.for_s
    }
}

//! One action, owned and stepped from outside.

use moreau::{ModelError, Settings, StepOutcome, StepReport};
use thiserror::Error;

use super::Input;
use super::equilibrium::{self, EquilibriumError};
use super::rest::Rest;
use super::snapshot::{MechanismState, Snapshot, SnapshotError, strings_are_finite};
use crate::identity::Identity;
use crate::index::IndexError;
use crate::instrument::Instrument;
use crate::mechanism::{Halving, Impact, Mechanism, StatePart, StepOutput, Stepping, TellNumbers, mechanism};
use crate::progress::{ASK_EVERY, Progress};
use crate::strings::Strings;

/// Why an action cannot be played.
#[derive(Debug, Clone, Error)]
#[non_exhaustive]
pub enum ActionError {
    /// The step is out of range.
    #[error(
        "the step is {found} s; expected {:e} to {:e} s",
        crate::mechanism::SMALLEST_STEP_S,
        crate::mechanism::MAX_STEP_S
    )]
    Step {
        /// s.
        found: f64,
    },
    /// Not assembled.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The mechanism does not come to rest.
    #[error(transparent)]
    Equilibrium(#[from] EquilibriumError),
}

/// Why [`Action::play`] ended before its inputs did.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum PlayError {
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
    /// A number became infinite.
    #[error("at {time_s:.6} s a number became infinite")]
    NonFinite {
        /// s.
        time_s: f64,
    },
}

/// The readings after a step: SI units, key and finger positive downward (pushing), hammer positive upward.
///
/// Places and speeds are those at the step's end, from rest. The two forces acted in the step: they belong to its theta
/// point, half a step before. (A run's rows centre them on the row's instant by the step after; a reading does not wait
/// for it.)
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct Reading {
    /// Travel of the key front, m.
    pub key_m: f64,
    /// Its speed, m/s.
    pub key_m_per_s: f64,
    /// Force of the finger on the key, N, which a haptic key renders.
    pub finger_force_n: f64,
    /// Rise of the hammer's strike point, m; 0 without a hammer.
    pub hammer_rise_m: f64,
    /// Speed of the hammer's strike point, m/s.
    pub hammer_rise_m_per_s: f64,
    /// Position of the hand ([`Input::Hand`]), m below the key front's rest; without a hand, the last one's.
    pub hand_m: f64,
    /// Its speed, m/s.
    pub hand_m_per_s: f64,
    /// Force between hammer and string, N, never negative.
    pub string_n: f64,
    /// The impact of the hammer on the string in the step, if there was one.
    pub impact: Option<Impact>,
    /// Outcome of the step. After [`StepOutcome::NonFinite`] the action is unchanged and can be stepped further.
    pub outcome: StepOutcome,
}

impl Reading {
    /// A step's output, referred to the rest.
    #[inline]
    pub(crate) fn of(output: &StepOutput, rest: &Rest) -> Self {
        Reading {
            key_m: output.site_m - rest.site_m,
            key_m_per_s: output.site_m_per_s,
            finger_force_n: output.drive_n,
            hammer_rise_m: output.point_m[1] - rest.head_m,
            hammer_rise_m_per_s: output.point_m_per_s[1],
            hand_m: output.hand[0] - rest.site_m,
            hand_m_per_s: output.hand[1],
            string_n: output.zone_n,
            impact: output.impact,
            outcome: output.report.outcome,
        }
    }
}

/// A grand action that is stepped from outside: takes a force or a position, returns the mechanism's response.
///
/// It starts at rest, friction included, with nothing touching the key: at the pose to which the drawing settles, or
/// where a blow left it ([`super::RestPose`]). [`Action::step`] never allocates, never panics
/// and takes a bounded number of iterations. This also holds for all other functions here, except [`Action::new`],
/// [`Action::with`] and those that say otherwise. Nothing uses a clock or a thread.
///
/// ```
/// # extern crate erard_core as erard;
/// use erard::{Action, Input, Instrument};
///
/// let grand = Instrument::builtin("concert-grand")?;
/// let mut action = Action::new(&grand)?;
/// let mut impact = None;
/// for _ in 0..1000 {
///     let reading = action.step(Input::Force(5.0)); // 50 us each
///     assert!(reading.key_m < 0.0105);
///     impact = impact.or(reading.impact);
/// }
/// let impact = impact.expect("5 N in 50 ms are a mezzo forte");
/// assert!((1.0..3.0).contains(&impact.hammer_speed_m_per_s));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Action {
    mechanism: Box<dyn Mechanism>,
    rest: Rest,
    identity: Identity,
    /// Number of contact zones; the engine has room for more.
    zones: usize,
    /// Target of a prescribed motion at the end of the last step, m from rest.
    aimed_m: Option<f64>,
}

impl Action {
    /// At rest, steps of [`Instrument::usual_step_s`], the usual settings.
    ///
    /// # Errors
    /// See [`ActionError`].
    pub fn new(instrument: &Instrument) -> Result<Self, ActionError> {
        Action::with(instrument, Settings::new(instrument.usual_step_s()))
    }

    /// At rest, with other settings.
    ///
    /// # Errors
    /// See [`ActionError`].
    pub fn with(instrument: &Instrument, settings: Settings<f64>) -> Result<Self, ActionError> {
        Action::with_progress(instrument, settings, &mut |_| true)
    }

    /// [`Action::new`] with a `progress` that is called now and then during the search for the rest, and ends it by
    /// returning false.
    ///
    /// # Errors
    /// See [`ActionError`]; [`EquilibriumError::Interrupted`].
    pub fn with_progress(
        instrument: &Instrument,
        settings: Settings<f64>,
        progress: &mut Progress<'_>,
    ) -> Result<Self, ActionError> {
        let mut action = Action::as_drawn(instrument, settings)?;
        action.settle(instrument, Input::Free, progress)?;
        action.set_reference_pose(instrument);
        Ok(action)
    }

    /// Checks whether an action can take steps of this length, s.
    ///
    /// # Errors
    /// [`ActionError::Step`].
    pub fn check_step(step_s: f64) -> Result<(), ActionError> {
        let range = crate::mechanism::SMALLEST_STEP_S..=crate::mechanism::MAX_STEP_S;
        if range.contains(&step_s) { Ok(()) } else { Err(ActionError::Step { found: step_s }) }
    }

    /// An action that is still at the angles as drawn in the file; travels are measured from there.
    ///
    /// # Errors
    /// See [`ActionError`].
    pub fn as_drawn(instrument: &Instrument, settings: Settings<f64>) -> Result<Self, ActionError> {
        Action::check_step(settings.step)?;
        let mechanism = mechanism(instrument, settings)?;
        let mut action = Action {
            rest: Rest { site_m: 0.0, head_m: 0.0 },
            identity: Identity::of(instrument),
            zones: instrument.zones.len(),
            aimed_m: None,
            mechanism,
        };
        action.set_reference_pose(instrument);
        Ok(action)
    }

    /// Makes the present pose the reference of travels and this instant 0 s.
    pub fn set_reference_pose(&mut self, instrument: &Instrument) {
        self.rest = Rest::of(instrument, self.mechanism.as_ref());
        self.place_hand(0.0, 0.0);
        self.begin_at(0.0);
    }

    /// Places the hand ([`Input::Hand`]), m below the key front's rest, with a velocity, m/s, down positive; a new
    /// action has it at the key front's rest. It moves in steps that a hand drives only.
    pub fn place_hand(&mut self, position_m: f64, velocity_m_per_s: f64) {
        self.mechanism.set(StatePart::Hand([self.rest.site_m + position_m, velocity_m_per_s]));
    }

    /// One step of the settings' length under an input. Where strings sound it may be taken in parts
    /// ([`Mechanism::step`]): the reading's forces are those of the last one, its outcome is the worst. A number that
    /// is not finite leaves the action as it was; the reading's outcome reports it.
    ///
    /// The equations are solved in [`moreau::step()`], which [`Mechanism::step`] calls for the mechanism's size.
    #[inline]
    pub fn step(&mut self, input: Input) -> Reading {
        let aimed_m = self.aimed_m;
        let input = self.engine_input(input);
        let output = self.mechanism.step(&input);
        if output.report.outcome == StepOutcome::NonFinite {
            self.aimed_m = aimed_m;
        }
        Reading::of(output, &self.rest)
    }

    /// Returns the present reading: after a step, the one that the step returned.
    #[inline]
    pub fn reading(&self) -> Reading {
        Reading::of(self.output(), &self.rest)
    }

    /// The impact of the hammer on the string in the last step, on the clock of [`Action::time_s`].
    #[inline]
    pub fn impact(&self) -> Option<Impact> {
        self.output().impact
    }

    /// Output of the last step, not referred to the rest.
    #[inline]
    pub(crate) fn output(&self) -> &StepOutput {
        self.mechanism.readout().output
    }

    /// The loop over fixed steps: asks `next` for an input, takes a step, asks again, until there is no input. `next`
    /// sees the action after every step; `progress` is asked every 512 steps, and ends the loop by returning false.
    ///
    /// A step is [`Mechanism::step`], which solves the equations at the top of [`moreau::step()`].
    ///
    /// # Errors
    /// See [`PlayError`]. Steps that reach an iteration limit are no error: the reading reports them.
    pub fn play(
        &mut self,
        progress: &mut Progress<'_>,
        next: &mut dyn FnMut(&mut Self) -> Option<Input>,
    ) -> Result<(), PlayError> {
        self.play_engine(progress, &mut |action, _| {
            let input = next(action)?;
            Some(action.engine_input(input))
        })
    }

    /// The loop over fixed steps, under inputs of the engine's; `next` gets the last step's report, too.
    pub(crate) fn play_engine(
        &mut self,
        progress: &mut Progress<'_>,
        next: &mut NextInput<'_>,
    ) -> Result<(), PlayError> {
        let (mut steps, mut last) = (0_u64, None);
        while let Some(input) = next(self, last.as_ref()) {
            if steps.is_multiple_of(ASK_EVERY) && !progress(0.0) {
                return Err(PlayError::Interrupted);
            }
            let report = self.mechanism.step(&input).report;
            if report.outcome == StepOutcome::NonFinite {
                // It is where it was, and when.
                return Err(PlayError::NonFinite { time_s: self.time_s() });
            }
            last = Some(report);
            steps += 1;
        }
        Ok(())
    }

    /// Lets the action come to rest under a constant input, with true dry friction whatever its settings say; they are
    /// restored, and all velocities are zero, at the end. Returns the simulated time it took, s; [`Action::time_s`]
    /// does not count it.
    ///
    /// # Errors
    /// See [`EquilibriumError`].
    pub fn settle(
        &mut self,
        instrument: &Instrument,
        input: Input,
        progress: &mut Progress<'_>,
    ) -> Result<f64, EquilibriumError> {
        let (input, now_s) = (self.engine_input(input), self.time_s());
        let took = equilibrium::settle(self, instrument, &input, progress);
        self.begin_at(now_s);
        took
    }

    /// Sets the present instant, s, and forgets the flight of the hammer so far.
    pub(crate) fn begin_at(&mut self, now_s: f64) {
        self.mechanism.set(StatePart::Instant(now_s));
        self.aimed_m = None;
    }

    /// The present instant, s; a new action is at 0.
    pub fn time_s(&self) -> f64 {
        self.mechanism.readout().now_s
    }

    /// The settings in force.
    pub fn settings(&self) -> &Settings<f64> {
        &self.mechanism.readout().stepping.settings
    }

    /// Changes the settings from the next step on.
    pub(crate) fn set_settings(&mut self, settings: Settings<f64>) {
        let stepping = *self.mechanism.readout().stepping;
        self.mechanism.configure(Stepping { settings, ..stepping });
    }

    /// How often steps are halved while the hammer is near strings that sound, from the next one on; as these ask, at
    /// first. May allocate.
    pub fn halve(&mut self, halving: Halving) {
        let stepping = *self.mechanism.readout().stepping;
        self.mechanism.configure(Stepping { halving, ..stepping });
    }

    /// Sets whether steps that are known to change nothing are skipped, the default: equal bits for less work.
    pub fn set_sleep(&mut self, may_rest: bool) {
        let stepping = *self.mechanism.readout().stepping;
        self.mechanism.configure(Stepping { may_rest, ..stepping });
    }

    /// Whether the last step changed nothing, so that the next one with the same input changes nothing either.
    pub fn is_asleep(&self) -> bool {
        self.mechanism.readout().rests
    }

    /// Whether nothing but the strings moves, and nothing touches them: under the input of the last step the bodies
    /// rest, and so does the bridge.
    pub fn only_strings_move(&self) -> bool {
        self.mechanism.readout().bodies_rest && self.strings().is_some_and(Strings::ring_freely)
    }

    /// If [`Action::only_strings_move`], lets them ring for a number of spans of a length, s, at once, and shows them
    /// after each span; returns whether it did. A mode's free motion is exact over any span: what differs from steps is
    /// rounding. Allocates.
    pub fn ring(&mut self, spans: u64, span_s: f64, each: &mut dyn FnMut(&Strings)) -> bool {
        if !self.only_strings_move() {
            return false;
        }
        let until_s = self.time_s() + spans as f64 * span_s;
        if let Some(strings) = self.strings_mut() {
            strings.ring(spans, span_s, each);
        }
        self.mechanism.set(StatePart::Instant(until_s));
        true
    }

    /// Puts the bodies at these angles, rad, at a standstill.
    pub(super) fn put(&mut self, angles: &[f64]) {
        let mut saved = self.mechanism.save();
        for (own, angle) in saved.state.angle.iter_mut().zip(angles) {
            *own = *angle;
        }
        self.mechanism.restore(&saved);
        self.stop();
    }

    /// Sets all velocities to zero.
    pub fn stop(&mut self) {
        self.mechanism.set(StatePart::Standstill);
    }

    /// The modal strings, if there are any: their displacement, and their force on the bridge.
    pub fn strings(&self) -> Option<&Strings> {
        Strings::under(self.mechanism.as_ref())
    }

    /// Sends the sustain pedal's rail to a lift, m: see [`Strings::set_pedal`]. Without modal strings, or a rail, it
    /// does nothing.
    pub fn set_pedal(&mut self, lift_m: f64) {
        if self.strings().and_then(Strings::pedal_aim_m).is_some_and(|aim_m| aim_m != lift_m)
            && let Some(strings) = self.strings_mut()
        {
            strings.set_pedal(lift_m);
        }
    }

    /// The strings, to be changed. Wakes the mechanism.
    fn strings_mut(&mut self) -> Option<&mut Strings> {
        self.mechanism.surfaces_mut()?.as_any_mut().downcast_mut()
    }

    /// Mode for the search for rest: the strings follow their forces without ringing.
    pub(crate) fn let_strings_follow(&mut self, statically: bool) {
        if let Some(surfaces) = self.mechanism.surfaces_mut() {
            surfaces.follow(statically);
        }
    }

    /// Absolute angles of the bodies, in the instrument's order, rad, counter-clockwise.
    pub fn angles(&self) -> &[f64] {
        self.mechanism.readout().angles
    }

    /// Absolute angular velocities, rad/s.
    pub fn velocities(&self) -> &[f64] {
        self.mechanism.readout().velocities
    }

    /// Normal force of a contact zone in the last step, N, never negative.
    ///
    /// # Errors
    /// There is no such zone.
    pub fn contact_force(&self, zone: usize) -> Result<f64, IndexError> {
        Ok(self.mechanism.normal_force(self.zone(zone)?))
    }

    fn zone(&self, zone: usize) -> Result<usize, IndexError> {
        IndexError::check("zone", zone, self.zones).map(|()| zone)
    }

    /// Coulomb force of a contact zone in the last step, N, on side A along the tangent (the normal turned clockwise by
    /// a quarter turn).
    ///
    /// # Errors
    /// There is no such zone.
    pub fn tangential_force(&self, zone: usize) -> Result<f64, IndexError> {
        Ok(self.mechanism.readout().tangential_forces[self.zone(zone)?])
    }

    /// Compression of a zone now, m; negative where it is open.
    ///
    /// # Errors
    /// There is no such zone.
    pub fn compression(&self, zone: usize) -> Result<f64, IndexError> {
        Ok(self.mechanism.compression(self.zone(zone)?))
    }

    /// Present position in the world, m, of a point of a body (`None`: of the ground), m in its frame.
    ///
    /// # Errors
    /// There is no such body.
    pub fn point(&self, body: Option<usize>, point: [f64; 2]) -> Result<[f64; 2], IndexError> {
        body.map_or(Ok(()), |body| IndexError::check("body", body, self.angles().len()))?;
        Ok(self.mechanism.point(body, point))
    }

    /// Pose from which travels are measured.
    pub fn rest(&self) -> Rest {
        self.rest
    }

    /// The identity of the instrument for saved states.
    pub(crate) fn identity(&self) -> &Identity {
        &self.identity
    }

    /// The mechanism that is played: energies, rows, contacts.
    pub fn mechanism(&self) -> &dyn Mechanism {
        self.mechanism.as_ref()
    }

    /// Saves everything that the following steps depend on. Allocates for modal strings only;
    /// [`Action::mechanism_state`] and [`Action::save_strings`] never do.
    pub fn save(&self) -> Snapshot {
        Snapshot::new(self.mechanism_state(), self.mechanism.readout().surfaces)
    }

    /// Everything that the following steps depend on, except the vibration of modal strings. Does not allocate.
    pub fn mechanism_state(&self) -> MechanismState {
        MechanismState::new(&self.identity, self.settings(), self.mechanism.save(), self.aimed_m)
    }

    /// State of the modal strings, in named lists of numbers; nothing over a rigid string. Does not allocate.
    pub fn save_strings(&self, put: &mut dyn FnMut(&'static str, &mut dyn Iterator<Item = f64>)) {
        if let Some(strings) = self.mechanism.readout().surfaces {
            strings.save(put);
        }
    }

    /// Continues from a snapshot of the same instrument and the same settings (step, theta, solver, friction), to the
    /// bit. The snapshot does not contain the last step's forces: they are zero until the next step.
    ///
    /// # Errors
    /// [`SnapshotError`]: the snapshot belongs to another instrument, other settings or another version; nothing has
    /// changed.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        self.restore_from(&snapshot.mechanism, &|name, number| snapshot.each(name, number))
    }

    /// Restores a state from its parts. `strings` reads the numbers of a list by its name and returns how many there
    /// are; without any, modal strings are at rest. Does not allocate.
    ///
    /// # Errors
    /// As [`Action::restore`].
    pub fn restore_from(
        &mut self,
        state: &MechanismState,
        strings: &dyn Fn(&str, &mut TellNumbers<'_>) -> usize,
    ) -> Result<(), SnapshotError> {
        let (saved, aimed_m) = state.open(&self.identity, self.settings())?;
        if let Some(surfaces) = self.mechanism.readout().surfaces {
            strings_are_finite(surfaces, strings)?;
        }
        self.mechanism.restore(&saved);
        if let Some(surfaces) = self.mechanism.surfaces_mut() {
            surfaces.restore(strings);
        }
        self.aimed_m = aimed_m;
        Ok(())
    }

    /// Adds to the angular velocity of a body (index as in the instrument), rad/s, like an impulse on it. The last
    /// step's forces are zero until the next step.
    ///
    /// # Errors
    /// There is no such body.
    pub fn add_velocity(&mut self, body: usize, rad_per_s: f64) -> Result<(), IndexError> {
        IndexError::check("body", body, self.angles().len())?;
        let mut saved = self.mechanism.save();
        saved.state.velocity[body] += rad_per_s;
        self.mechanism.restore(&saved);
        Ok(())
    }

    /// The engine's input for the next step.
    #[inline]
    fn engine_input(&mut self, input: Input) -> moreau::SiteInput<f64> {
        let Action { mechanism, rest, aimed_m, .. } = self;
        // A motion that ended is no aim of the next one.
        if !matches!(input, Input::Rigid { .. }) {
            *aimed_m = None;
        }
        rest.engine_input(&input, || {
            let Input::Rigid { position_m, velocity_m_per_s } = input else { return 0.0 };
            let now = mechanism.readout();
            rest.imposed([position_m, velocity_m_per_s], aimed_m, now.output.site_m, now.stepping.settings.step)
        })
    }

    /// The mechanism that is played, to be changed: a ledger to be opened, say.
    pub fn mechanism_mut(&mut self) -> &mut dyn Mechanism {
        self.mechanism.as_mut()
    }
}

/// Gives the engine's input of each step, from the report of the last one; `None` ends the loop.
type NextInput<'a> = dyn FnMut(&mut Action, Option<&StepReport>) -> Option<moreau::SiteInput<f64>> + 'a;

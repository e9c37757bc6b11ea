//! Keys on a chip, from readings of a converter to bytes of MIDI, without a heap and in either precision. All keys
//! share one mechanism; each key has its own state. A key at rest takes no step.

use erard_midi::message::{SOFT, SOSTENUTO, SUSTAIN};
use erard_midi::{Message, Pedal, note_of_key};
use moreau::{
    GROUND, ImpactPredictor, Model, ModelError, RIGID_CORRECTION, Scalar, Settings, SiteHand, SiteInput, Sleep, State,
    StepOutcome, TrackedPoint, Vector, Workspace, vector::dot,
};

use crate::drive::Push;
use crate::limits::Limits;
use crate::sensed::{Counts, Stepped, Steps};
use crate::sensing::Sensing;
pub use crate::sensing::{Sensor, Voice};

/// Number of samples by which a press may begin before its sensor leaves its rest.
pub const REMEMBERED: usize = 16;
/// [`Settings::tolerance`]: coarser than usual, because single precision cannot always distinguish 1e-5 rad/s from
/// rounding.
const TOLERANCE: f64 = 1e-3;
/// A key nearer than this to its prescribed position is left there, m, so that it comes to rest.
const THERE_M: f64 = 1e-6;

/// Properties of a key's action in addition to its model.
#[derive(Debug, Clone, Copy)]
pub struct Outline<const B: usize> {
    /// Angles at rest, rad.
    pub rest: [f64; B],
    /// The body that strikes, and its point that meets the string, m in its frame.
    pub hammer: (usize, [f64; 2]),
    /// The zone of hammer and string.
    pub string: usize,
    /// Largest inputs of the key.
    pub limits: Limits,
    /// Travel at which the key sets its damper down, m.
    pub damper_m: f64,
}

/// The action that all keys share: its constant model and the working memory of a step.
pub struct BoardMechanism<T: Scalar, const B: usize, const Z: usize, const N: usize> {
    model: Model<T, B, Z>,
    settings: Settings<T>,
    step_s: f64,
    outline: Outline<B>,
    /// The key's front, and the direction that counts as down.
    front: (TrackedPoint<T, B>, Vector<T>),
    rest_m: T,
    workspace: Workspace<T, B, Z, N>,
}

impl<T: Scalar, const B: usize, const Z: usize, const N: usize> BoardMechanism<T, B, Z, N> {
    /// Makes the mechanism of a model that has a key's front to drive, with steps of `step_s`.
    ///
    /// # Errors
    /// [`ModelError`]: `N` has too little room for its laws.
    pub fn new(model: Model<T, B, Z>, outline: Outline<B>, step_s: f64) -> Result<Self, ModelError> {
        let workspace = Workspace::for_model(&model)?;
        let nowhere = (TrackedPoint::of(&model, GROUND, [T::ZERO; 2]), [T::ZERO; 2]);
        let front = model.site().map_or(nowhere, |s| (TrackedPoint::of(&model, s.body, s.point), s.direction));
        let tolerance = T::from_f64(TOLERANCE);
        let settings = Settings { tolerance, ..Settings::new(T::from_f64(step_s)) };
        let mut all = BoardMechanism { settings, step_s, outline, front, rest_m: T::ZERO, workspace, model };
        [all.rest_m, _] = all.front(&outline.rest.map(T::from_f64), &[T::ZERO; B]);
        Ok(all)
    }

    /// Position of the key's front along its drive, m, and its speed, m/s.
    fn front(&self, angle: &[T; B], velocity: &[T; B]) -> [T; 2] {
        let (point, direction) = &self.front;
        point.motion(angle, velocity).map(|x| dot(*direction, x))
    }

    /// A key at rest, its number from 1.
    pub fn key(&self, number: usize, sensor: &Sensor) -> Key<T, B, Z> {
        let Outline { limits, damper_m, .. } = &self.outline;
        Key {
            note: note_of_key(number).unwrap_or(0),
            sensing: Sensing::new(sensor, limits, *damper_m, self.step_s),
            action: self.at_rest(),
        }
    }

    fn at_rest(&self) -> Own<T, B, Z> {
        let Outline { rest, hammer: (body, point), string, .. } = self.outline;
        let mut state = State::at_rest(rest.map(T::from_f64));
        state.hand = [self.rest_m, T::ZERO];
        let tracked = TrackedPoint::of(&self.model, body, point.map(T::from_f64));
        let mut predictor = ImpactPredictor::new(tracked, Some(string));
        predictor.update(&self.model, 0.0, &state.angle, &state.velocity);
        Own { state, sleep: Sleep::awake(), predictor, steps: 0, aimed_m: None, unconverged: 0 }
    }

    /// Takes a key's reading at an instant, s, and sends the resulting messages. Returns false and ignores the reading
    /// if the instant is not after the key's last one.
    pub fn take(
        &mut self,
        key: &mut Key<T, B, Z>,
        time_s: f64,
        reading: T,
        voice: &Voice<'_>,
        send: &mut dyn FnMut(Message),
    ) -> bool {
        let Key { note, sensing, action } = key;
        let mut action = Shared { mechanism: self, own: action };
        sensing.take((time_s, reading), &mut action, &mut |event| send(voice.message(*note, event)))
    }

    /// Releases a key, whatever its sensor reads, and follows it to its rest, so that no note keeps sounding.
    pub fn let_go(&mut self, key: &mut Key<T, B, Z>, time_s: f64, voice: &Voice<'_>, send: &mut dyn FnMut(Message)) {
        let Key { note, sensing, action } = key;
        let mut action = Shared { mechanism: self, own: action };
        sensing.let_go(time_s, &mut action, &mut |event| send(voice.message(*note, event)));
    }

    /// Puts a key back where [`BoardMechanism::key`] made it: at rest, without drift, nothing counted.
    pub fn reset(&self, key: &mut Key<T, B, Z>) {
        key.sensing.reset();
        key.action = self.at_rest();
    }
}

/// A key: everything that its next step depends on.
#[derive(Debug, Clone)]
pub struct Key<T: Scalar, const B: usize, const Z: usize> {
    note: u8,
    sensing: Sensing<T, REMEMBERED>,
    action: Own<T, B, Z>,
}

impl<T: Scalar, const B: usize, const Z: usize> Key<T, B, Z> {
    /// Its sensor.
    pub fn sensing(&self) -> &Sensing<T, REMEMBERED> {
        &self.sensing
    }

    /// Its sensor, to be changed.
    pub fn sensing_mut(&mut self) -> &mut Sensing<T, REMEMBERED> {
        &mut self.sensing
    }

    /// Counts of events.
    pub fn counts(&self) -> Counts {
        self.sensing.counts()
    }

    /// Steps that its action has taken; none while it rests.
    pub fn steps(&self) -> u64 {
        self.action.steps
    }

    /// Those of them that reached an iteration limit.
    pub fn unconverged(&self) -> u32 {
        self.action.unconverged
    }

    /// Whether its action is still and its next steps would change nothing.
    pub fn is_asleep(&self) -> bool {
        self.action.sleep.is_asleep()
    }

    /// Absolute angles of its action's bodies, rad.
    pub fn angles(&self) -> &[T; B] {
        &self.action.state.angle
    }
}

/// A key's own part of its action.
#[derive(Debug, Clone)]
struct Own<T: Scalar, const B: usize, const Z: usize> {
    state: State<T, B, Z>,
    sleep: Sleep<T>,
    predictor: ImpactPredictor<T, B>,
    /// The action's own clock, which stops while it rests.
    steps: u64,
    /// Target of a prescribed motion at the end of the last step, m from rest.
    aimed_m: Option<T>,
    unconverged: u32,
}

struct Shared<'a, T: Scalar, const B: usize, const Z: usize, const N: usize> {
    mechanism: &'a mut BoardMechanism<T, B, Z, N>,
    own: &'a mut Own<T, B, Z>,
}

impl<T: Scalar, const B: usize, const Z: usize, const N: usize> Shared<'_, T, B, Z, N> {
    fn key_m(&self) -> T {
        let [front_m, _] = self.mechanism.front(&self.own.state.angle, &self.own.state.velocity);
        front_m - self.mechanism.rest_m
    }

    fn input(&mut self, push: &Push<T>) -> SiteInput<T> {
        let rest_m = self.mechanism.rest_m;
        match *push {
            Push::Free => SiteInput::Free,
            Push::Force(force_n) => SiteInput::Force(force_n),
            Push::Hand(hand) => SiteInput::Hand(SiteHand { position: rest_m + hand.position, ..hand }),
            Push::Rigid { position_m, velocity_m_per_s } => {
                // What the key lags behind the motion is taken back little by little.
                let h = self.mechanism.settings.step;
                let aimed_m = self.own.aimed_m.replace(position_m).unwrap_or(position_m - velocity_m_per_s * h);
                let behind_m = aimed_m - self.key_m();
                let is_there = velocity_m_per_s == T::ZERO && behind_m.abs() < T::from_f64(THERE_M);
                let correction = if is_there { T::ZERO } else { T::from_f64(RIGID_CORRECTION) * behind_m / h };
                SiteInput::Rigid { velocity: velocity_m_per_s + correction }
            }
        }
    }
}

impl<T: Scalar, const B: usize, const Z: usize, const N: usize> Steps<T> for Shared<'_, T, B, Z, N> {
    fn step(&mut self, push: &Push<T>) -> Stepped<T> {
        let input = self.input(push);
        if self.own.sleep.would_rest(&input).is_some() {
            return Stepped { key_m: self.key_m(), hit: None, is_finite: true };
        }
        let BoardMechanism { model, settings, workspace, step_s, .. } = &mut *self.mechanism;
        let Own { state, sleep, predictor, steps, unconverged, .. } = &mut *self.own;
        let report = sleep.step(model, settings, &input, state, workspace);
        *steps += 1;
        *unconverged += u32::from(report.outcome == StepOutcome::IterationLimit);
        let now_s = *steps as f64 * *step_s;
        predictor.update(model, now_s, &state.angle, &state.velocity);
        let hit = predictor.impact().map(|impact| (impact.time_s - now_s, impact.speed));
        Stepped { key_m: self.key_m(), hit, is_finite: report.outcome != StepOutcome::NonFinite }
    }

    fn is_asleep(&self) -> bool {
        self.own.sleep.is_asleep()
    }

    fn hand(&self) -> [T; 2] {
        let [place_m, speed] = self.own.state.hand;
        [place_m - self.mechanism.rest_m, speed]
    }

    fn lay_hand(&mut self) {
        let Own { state, sleep, .. } = &mut *self.own;
        state.hand = self.mechanism.front(&state.angle, &state.velocity);
        sleep.wake();
    }
}

/// The three pedals, as controllers.
#[derive(Debug, Clone)]
pub struct Pedals([(u8, Pedal); 3]);

impl Pedals {
    /// All up.
    #[must_use]
    pub fn up() -> Self {
        Pedals([SUSTAIN, SOSTENUTO, SOFT].map(|controller| (controller, Pedal::up())))
    }

    /// Takes the position of a pedal, 0 (up) to 1 (down), by its controller; returns the message to send if its value
    /// has changed.
    pub fn take(&mut self, channel: u8, controller: u8, down: f64) -> Option<Message> {
        let (_, pedal) = self.0.iter_mut().find(|(own, _)| *own == controller)?;
        pedal.update(down).map(|value| Message::controller(channel, controller, value))
    }
}

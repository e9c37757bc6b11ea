//! The assembled actions of a keyboard, stepped together.
//!
//! A step is a function of state and input. Where it left a key's state identical to the bit, every further step with the identical
//! input would do so too: the key sleeps, and is not stepped until its input changes. That is exact, not a threshold, and it happens,
//! because dry friction as a set-valued law truly sticks: keys at rest, and held notes, come to velocities of exactly zero in
//! finite time. Under a regularised friction law they do not, and keys never sleep. Nor does a key that friction holds exactly at its
//! limit, where rounding lets it slip and stick in turn (velocities of 1e-17 rad/s that move no angle): rare, and then merely not for free.

use moreau::{Input, Model, Outcome, Settings, Sleep, State, Workspace};
use thiserror::Error;

use crate::assembly;
use crate::equilibrium::{self, EquilibriumError};
use crate::instrument::{Instrument, Roles};
use crate::mechanism::{Size, mechanism, with_size};

/// How long the keys are let come to a complete rest before they are handed over, s: a few steps are enough.
const SETTLING_S: f64 = 0.1;

/// Why the keys cannot be assembled.
#[derive(Debug, Error)]
#[error("key {key}: {error}")]
pub struct KeysError {
    /// The key, from 1.
    pub key: usize,
    /// What is wrong with it.
    #[source]
    pub error: Box<dyn std::error::Error + Send + Sync>,
}

/// A hammer has met its string.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Blow {
    /// The key, from 1.
    pub key: usize,
    /// Speed of the strike point along its arc at the start of the step in which it touched, m/s.
    pub speed_m_s: f64,
}

/// What one step of the keyboard did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Tick {
    /// Keys that were stepped; the others slept.
    pub stepped: u32,
    /// Of these, keys whose step reached an iteration limit.
    pub unconverged: u32,
    /// Of these, keys that a number that is not finite left where they were.
    pub non_finite: u32,
}

/// The keys of a keyboard, numbered from 1, each with an input that holds until it is changed.
pub struct Keys {
    bank: Box<dyn Bank>,
    blows: Vec<Blow>,
    count: usize,
}

impl Keys {
    /// Assembles the keys of a keyboard, at rest, nothing touching them; all of them asleep if they come to a complete rest.
    ///
    /// # Errors
    /// [`KeysError`]: a key cannot be assembled, or finds no rest.
    pub fn at_rest(instruments: &[Instrument], settings: Settings<f64>) -> Result<Self, KeysError> {
        let size = instruments.iter().map(|i| Size::of(i, &settings)).max().unwrap_or(Size::One);
        let bank = with_size!(size, bank, instruments, settings)?;
        let count = instruments.len();
        let mut keys = Keys { bank, blows: Vec::with_capacity(count), count };
        let mut steps = (SETTLING_S / settings.step) as u64;
        while keys.awake() > 0 && steps > 0 {
            keys.step();
            steps -= 1;
        }
        Ok(keys)
    }

    /// The settings that they are stepped with.
    #[must_use]
    pub fn settings(&self) -> &Settings<f64> {
        self.bank.settings()
    }

    /// How many there are.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// How many are awake: the next step steps these.
    #[must_use]
    pub fn awake(&self) -> usize {
        self.bank.awake()
    }

    /// Whether a key is awake.
    #[must_use]
    pub fn is_awake(&self, key: usize) -> bool {
        self.bank.is_awake(key - 1)
    }

    /// What drives a key from the next step on, until it is driven otherwise. Wakes it if that is anything new.
    ///
    /// # Panics
    /// If there is no such key; keys count from 1.
    pub fn drive(&mut self, key: usize, input: &Input<f64>) {
        self.bank.drive(key - 1, input);
    }

    /// Whether sleeping keys are left alone (as at first). Otherwise every key is stepped in every step, with the same results.
    pub fn let_sleep(&mut self, sleep: bool) {
        self.bank.let_sleep(sleep);
    }

    /// Steps all keys that are awake. Never allocates.
    pub fn step(&mut self) -> Tick {
        self.blows.clear();
        self.bank.step(&mut self.blows)
    }

    /// The hammers that met their strings in the last step.
    #[must_use]
    pub fn blows(&self) -> &[Blow] {
        &self.blows
    }

    /// Force between a key's hammer and its string in the last step, N.
    #[must_use]
    pub fn string_force(&self, key: usize) -> f64 {
        self.bank.string_force(key - 1)
    }

    /// World coordinate of a key's front along its drive (down), m: what the positions of a motion are compared with.
    #[must_use]
    pub fn key_front(&self, key: usize) -> f64 {
        self.bank.key_front(key - 1)
    }

    /// Absolute angles of a key's bodies, rad.
    #[must_use]
    pub fn angles(&self, key: usize) -> &[f64] {
        self.bank.angles(key - 1)
    }

    /// Absolute angular velocities of a key's bodies, rad/s.
    #[must_use]
    pub fn velocities(&self, key: usize) -> &[f64] {
        self.bank.velocities(key - 1)
    }

    /// A key's state as bits, in an order of its own: to see whether two keyboards are in the same state.
    #[must_use]
    pub fn bits(&self, key: usize) -> Vec<u64> {
        self.bank.bits(key - 1)
    }
}

/// Keys of one engine size. Indices from 0.
trait Bank: Send {
    fn settings(&self) -> &Settings<f64>;
    fn awake(&self) -> usize;
    fn is_awake(&self, key: usize) -> bool;
    fn drive(&mut self, key: usize, input: &Input<f64>);
    fn let_sleep(&mut self, sleep: bool);
    fn step(&mut self, blows: &mut Vec<Blow>) -> Tick;
    fn string_force(&self, key: usize) -> f64;
    fn key_front(&self, key: usize) -> f64;
    fn angles(&self, key: usize) -> &[f64];
    fn velocities(&self, key: usize) -> &[f64];
    fn bits(&self, key: usize) -> Vec<u64>;
}

struct Actions<const B: usize, const Z: usize, const N: usize> {
    actions: Vec<Action<B, Z>>,
    /// Indices of the keys that are awake, in no order: no key feels another.
    awake: Vec<usize>,
    sleep: bool,
    settings: Settings<f64>,
    scratch: Workspace<f64, B, Z, N>,
}

/// One key.
struct Action<const B: usize, const Z: usize> {
    model: Model<f64, B, Z>,
    state: State<f64, B, Z>,
    input: Input<f64>,
    awake: bool,
    bodies: usize,
    hammer: Option<Hammer>,
    string_force_n: f64,
}

/// Where blows are seen.
#[derive(Clone, Copy)]
struct Hammer {
    body: usize,
    /// From its pivot to the strike point, m.
    arm_m: f64,
    string: usize,
}

impl Hammer {
    /// A hammer that is hinged on the ground and has a string.
    fn of(instrument: &Instrument) -> Option<Self> {
        let Roles { hammer, hammer_head_m: [x, y], string, .. } = instrument.roles;
        let (body, string) = (hammer?, string?);
        instrument.bodies[body].parent.is_none().then_some(Hammer { body, arm_m: libm::hypot(x, y), string })
    }
}

fn bank<const B: usize, const Z: usize, const N: usize>(
    instruments: &[Instrument],
    settings: Settings<f64>,
) -> Result<Box<dyn Bank>, KeysError> {
    let actions = instruments.iter().enumerate().map(|(i, instrument)| {
        action::<B, Z>(instrument, settings).map_err(|error| KeysError { key: i + 1, error: Box::new(error) })
    });
    let actions: Vec<_> = actions.collect::<Result<_, _>>()?;
    let awake = (0..actions.len()).collect();
    Ok(Box::new(Actions::<B, Z, N> { actions, awake, sleep: true, settings, scratch: Workspace::new() }))
}

fn action<const B: usize, const Z: usize>(
    instrument: &Instrument,
    settings: Settings<f64>,
) -> Result<Action<B, Z>, EquilibriumError> {
    let mut rest = mechanism(instrument, settings)?;
    equilibrium::settle(rest.as_mut(), instrument, &Input::Free, &mut || true)?;
    let angle = core::array::from_fn(|i| rest.angles().get(i).copied().unwrap_or(0.0));
    Ok(Action {
        model: assembly::assemble(instrument).map_err(EquilibriumError::from)?,
        state: State::at_rest(angle),
        input: Input::Free,
        awake: true,
        bodies: instrument.bodies.len(),
        hammer: Hammer::of(instrument),
        string_force_n: 0.0,
    })
}

impl<const B: usize, const Z: usize> Action<B, Z> {
    /// One step; whether any further one with this input would leave the key as it is, and what became of the step.
    fn step<const N: usize>(
        &mut self,
        settings: &Settings<f64>,
        scratch: &mut Workspace<f64, B, Z, N>,
    ) -> (bool, Outcome, Option<f64>) {
        // A key that is stepped is awake: nothing is known to rest, and its step is taken.
        let mut repose = Sleep::awake();
        let hammer_rad_s = self.hammer.map_or(0.0, |h| self.state.velocity[h.body]);
        let report = repose.step(&self.model, settings, &self.input, &mut self.state, scratch);
        let mut blow = None;
        if let Some(hammer) = self.hammer {
            let force_n = scratch.contact(&self.model, settings, hammer.string).map_or(0.0, |c| c.force);
            if self.string_force_n <= 0.0 && force_n > 0.0 {
                blow = Some(hammer_rad_s.abs() * hammer.arm_m);
            }
            self.string_force_n = force_n;
        }
        (repose.is_asleep(), report.outcome, blow)
    }
}

impl<const B: usize, const Z: usize, const N: usize> Bank for Actions<B, Z, N> {
    fn settings(&self) -> &Settings<f64> {
        &self.settings
    }

    fn awake(&self) -> usize {
        self.awake.len()
    }

    fn is_awake(&self, key: usize) -> bool {
        self.actions[key].awake
    }

    fn drive(&mut self, key: usize, input: &Input<f64>) {
        let action = &mut self.actions[key];
        if input.identical(&action.input) {
            return;
        }
        action.input = *input;
        if !action.awake {
            action.awake = true;
            // There is room: no key is in the list twice.
            self.awake.push(key);
        }
    }

    fn let_sleep(&mut self, sleep: bool) {
        self.sleep = sleep;
        for (key, action) in self.actions.iter_mut().enumerate() {
            if !sleep && !action.awake {
                action.awake = true;
                self.awake.push(key);
            }
        }
    }

    fn step(&mut self, blows: &mut Vec<Blow>) -> Tick {
        let mut tick = Tick::default();
        let mut place = 0;
        while let Some(&key) = self.awake.get(place) {
            let action = &mut self.actions[key];
            let (fixed, outcome, blow) = action.step(&self.settings, &mut self.scratch);
            tick.stepped += 1;
            match outcome {
                Outcome::Converged => {}
                Outcome::IterationLimit => tick.unconverged += 1,
                Outcome::NonFinite | Outcome::TooManyLaws => tick.non_finite += 1,
            }
            if let Some(speed_m_s) = blow {
                blows.push(Blow { key: key + 1, speed_m_s });
            }
            if fixed && self.sleep {
                action.awake = false;
                self.awake.swap_remove(place);
            } else {
                place += 1;
            }
        }
        tick
    }

    fn string_force(&self, key: usize) -> f64 {
        self.actions[key].string_force_n
    }

    fn key_front(&self, key: usize) -> f64 {
        let Action { model, state, .. } = &self.actions[key];
        model.site_position(&state.angle)
    }

    fn angles(&self, key: usize) -> &[f64] {
        let action = &self.actions[key];
        &action.state.angle[..action.bodies]
    }

    fn velocities(&self, key: usize) -> &[f64] {
        let action = &self.actions[key];
        &action.state.velocity[..action.bodies]
    }

    fn bits(&self, key: usize) -> Vec<u64> {
        let State { angle, velocity, increment, pivot_friction, tangential, rigid_force, .. } =
            &self.actions[key].state;
        let all = [&angle[..], velocity, increment, pivot_friction, tangential, std::slice::from_ref(rigid_force)];
        all.concat().into_iter().map(f64::to_bits).collect()
    }
}

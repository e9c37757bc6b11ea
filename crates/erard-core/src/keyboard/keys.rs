//! The assembled actions of a keyboard, stepped together.
//!
//! A key that nothing changes sleeps ([`moreau_kernels::Bank`] says why that is exact): keys at rest, and held notes,
//! cost nothing.

use moreau::{Settings, StepOutcome};
use moreau_kernels::{Bank, StepOutput, bank};
use thiserror::Error;

pub use moreau_kernels::Tick;

use crate::assembly::{describe, probes};
use crate::identity::Identity;
use crate::index::IndexError;
use crate::instrument::Instrument;
use crate::knocks::{Knock, Knocks};
use crate::mechanism::{Halving, Impact, TellNumbers};
use crate::player::rest::Rest;
use crate::player::snapshot::strings_are_finite;
use crate::player::{Action, ActionError, Input, MechanismState, Reading, Snapshot, SnapshotError};
use crate::strings::Strings;

/// Time for the keys to come to a complete rest before they are handed over, s. For most of them a few steps are
/// enough; strings on a soundboard take a tenth of a second and more.
const SETTLING_S: f64 = 1.0;

/// Why the keys cannot be assembled.
#[derive(Debug, Error)]
#[error("key {key}: {error}")]
pub struct KeysError {
    /// The key, from 1.
    pub key: usize,
    /// The fault.
    #[source]
    pub error: ActionError,
}

/// An impact of a key's hammer on its string.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub struct KeyImpact {
    /// The key, from 1.
    pub key: usize,
    /// Instant and speed, as [`Action::impact`] gives them.
    pub impact: Impact,
}

/// The keys of a keyboard, numbered from 1, each with an input that holds until it is changed: [`Action`]s that sleep.
pub struct Keys {
    bank: Box<dyn Bank>,
    own: Vec<Own>,
    impacts: Vec<KeyImpact>,
}

/// Data of one key.
struct Own {
    rest: Rest,
    identity: Identity,
    /// Where the last imposed motion sent the key front, m; see [`Keys::impose`].
    aimed_m: Option<f64>,
}

impl Keys {
    /// Assembles the keys of a keyboard, at rest, nothing touching them; all of them asleep if they come to a complete
    /// rest.
    ///
    /// # Errors
    /// [`KeysError`]: a key cannot be assembled, or finds no rest.
    pub fn at_rest(instruments: &[Instrument], settings: Settings<f64>) -> Result<Self, KeysError> {
        let (mut descriptions, mut all_probes, mut own) = (Vec::new(), Vec::new(), Vec::new());
        let mut rests = Vec::new();
        for (i, instrument) in instruments.iter().enumerate() {
            let wrong = |error| KeysError { key: i + 1, error };
            let action = Action::with(instrument, settings).map_err(wrong)?;
            descriptions.push(describe(instrument));
            all_probes.push(probes(instrument));
            own.push(Own { rest: action.rest(), identity: *action.identity(), aimed_m: None });
            // Strings as they stand under what lies on them, and what felts remember.
            rests.push((action.mechanism().save(), action.strings().cloned()));
        }
        let mut bank = bank(&descriptions, &all_probes, settings)
            .map_err(|(index, error)| KeysError { key: index + 1, error: error.into() })?;
        for (index, (saved, strings)) in rests.into_iter().enumerate() {
            bank.restore(index, &saved);
            if let Some(strings) = strings {
                bank.set_surfaces(index, Box::new(strings));
            }
        }
        let impacts = Vec::with_capacity(instruments.len());
        let mut keys = Keys { bank, own, impacts };
        for key in 1..=keys.count() {
            keys.place_hand_at(key - 1, 0.0, 0.0);
        }
        keys.settle();
        Ok(keys)
    }

    /// Steps them until all of them sleep, or for as long as that may take.
    fn settle(&mut self) {
        let mut steps = (SETTLING_S / self.settings().step) as u64;
        while self.awake() > 0 && steps > 0 {
            self.step();
            steps -= 1;
        }
    }

    /// Has their forces on the key bed added up from now on, of these knocks: [`Keys::knocks_n`]. Takes the instruments
    /// that they are made of. Allocates.
    pub fn listen(&mut self, instruments: &[Instrument], knocks: &[Knock]) {
        for (index, instrument) in instruments.iter().enumerate().take(self.count()) {
            self.bank.listen(index, Knocks::of(instrument, knocks).zones());
        }
    }

    /// By how much the sum of the forces on the key bed has changed so far, N ([`Keys::listen`]): what [`KeyBed::hear`]
    /// hears. A state that is restored changes nothing.
    ///
    /// [`KeyBed::hear`]: crate::knocks::KeyBed::hear
    #[must_use]
    pub fn knocks_n(&self) -> f64 {
        (0..self.count()).map(|index| self.bank.listened_n(index)).sum()
    }

    /// Sound pressure now at two places before the board, Pa: the sum of [`Strings::pressure_pa`] in the order of the
    /// keys. Strings of keys that sleep are silent.
    #[must_use]
    pub fn pressure_pa(&self) -> [f64; 2] {
        let awake = (0..self.count()).filter(|index| self.bank.is_awake(*index));
        let heard = awake.filter_map(|index| self.strings_at(index)).filter_map(Strings::pressure_pa);
        heard.fold([0.0; 2], |[left, right], own| [left + own[0], right + own[1]])
    }

    /// The settings that they are stepped with.
    #[must_use]
    pub fn settings(&self) -> &Settings<f64> {
        self.bank.settings()
    }

    /// Number of keys.
    #[must_use]
    pub fn count(&self) -> usize {
        self.bank.count()
    }

    /// Number of keys that are awake: the next step steps these.
    #[must_use]
    pub fn awake(&self) -> usize {
        self.bank.awake().len()
    }

    /// Index of a key.
    fn index(&self, key: usize) -> Result<usize, IndexError> {
        IndexError::key(key, self.own.len())
    }

    /// Whether a key is awake.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn is_awake(&self, key: usize) -> Result<bool, IndexError> {
        Ok(self.bank.is_awake(self.index(key)?))
    }

    /// The present instant, s.
    #[must_use]
    pub fn time_s(&self) -> f64 {
        self.bank.now_s()
    }

    /// Sets the drive of a key from the next step on, until another is set. Wakes the key if the drive is new. An
    /// imposed motion ([`Input::Rigid`]) holds its velocity; [`Keys::impose`] follows its position as well.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn drive(&mut self, key: usize, input: Input) -> Result<(), IndexError> {
        let index = self.index(key)?;
        let imposed = || if let Input::Rigid { velocity_m_per_s, .. } = input { velocity_m_per_s } else { 0.0 };
        let own = &mut self.own[index];
        own.aimed_m = None;
        let input = own.rest.engine_input(&input, imposed);
        self.bank.drive(index, &input);
        Ok(())
    }

    /// Imposes the motion of a key's front on the next step, as [`Action::step`] does with [`Input::Rigid`]: position
    /// at its end, m below the front's rest, and velocity, m/s. Call it before every step of the motion.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn impose(&mut self, key: usize, position_m: f64, velocity_m_per_s: f64) -> Result<(), IndexError> {
        let index = self.index(key)?;
        let (site_m, h) = (self.bank.output(index).site_m, self.settings().step);
        let own = &mut self.own[index];
        let velocity = own.rest.imposed([position_m, velocity_m_per_s], &mut own.aimed_m, site_m, h);
        self.bank.drive(index, &moreau::SiteInput::Rigid { velocity });
        Ok(())
    }

    /// Places the hand on a key: [`Action::place_hand`]. Wakes the key.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn place_hand(&mut self, key: usize, position_m: f64, velocity_m_per_s: f64) -> Result<(), IndexError> {
        self.place_hand_at(self.index(key)?, position_m, velocity_m_per_s);
        Ok(())
    }

    fn place_hand_at(&mut self, index: usize, position_m: f64, velocity_m_per_s: f64) {
        let site_m = self.own[index].rest.site_m;
        self.bank.place_hand(index, [site_m + position_m, velocity_m_per_s]);
    }

    /// Sends the sustain pedal's rail to a lift, m, under all keys that have one; see [`Strings::set_pedal`]. Wakes
    /// them if the lift is new.
    pub fn set_pedal(&mut self, lift_m: f64) {
        for index in 0..self.bank.count() {
            let aim = |strings: &Strings| strings.pedal_aim_m().filter(|aim_m| *aim_m != lift_m);
            if self.strings_at(index).and_then(aim).is_some()
                && let Some(surfaces) = self.bank.surfaces_mut(index)
                && let Some(strings) = surfaces.as_any_mut().downcast_mut::<Strings>()
            {
                strings.set_pedal(lift_m);
            }
        }
    }

    /// Sets whether sleeping keys are skipped, the default. Otherwise every key is stepped in every step, with the same
    /// results.
    pub fn let_sleep(&mut self, sleep: bool) {
        self.bank.let_sleep(sleep);
    }

    /// Sets the number of halvings of a step while a hammer is near modal strings, from the next step on:
    /// [`Action::halve`], for all keys. As these ask, at first; with [`Halving::Never`] the worst step of a chord costs
    /// an eighth, and contacts in the treble last too long (the book's chapter "Strings"). Wakes the keys; if all of
    /// them slept, time goes on until they do again. May allocate.
    pub fn halve(&mut self, halving: Halving) {
        let all_slept = self.awake() == 0;
        self.bank.halve(halving);
        if all_slept {
            self.settle();
        }
    }

    /// Steps all keys that are awake. Never allocates.
    pub fn step(&mut self) -> Tick {
        let Keys { bank, impacts, .. } = self;
        impacts.clear();
        // There is room: no hammer meets its string twice in a step.
        bank.step(&mut |index, impact| impacts.push(KeyImpact { key: index + 1, impact }))
    }

    /// The impacts of hammers on their strings in the last step.
    #[must_use]
    pub fn impacts(&self) -> &[KeyImpact] {
        &self.impacts
    }

    /// Output of a key's last step.
    fn output(&self, key: usize) -> Result<StepOutput, IndexError> {
        Ok(self.bank.output(self.index(key)?))
    }

    /// The readings of a key after the last step, as an [`Action`]'s; its outcome is
    /// [`StepOutcome::Converged`], for [`Tick`] counts those of a step.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn reading(&self, key: usize) -> Result<Reading, IndexError> {
        let index = self.index(key)?;
        let reading = Reading::of(&self.bank.output(index), &self.own[index].rest);
        Ok(Reading { outcome: StepOutcome::Converged, ..reading })
    }

    /// Force between a key's hammer and its string in the last step, N.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn string_force(&self, key: usize) -> Result<f64, IndexError> {
        Ok(self.output(key)?.zone_n)
    }

    /// A key's strings, where they sound: their force on the bridge ([`Strings::bridge_n`]), for one.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn strings(&self, key: usize) -> Result<Option<&Strings>, IndexError> {
        Ok(self.strings_at(self.index(key)?))
    }

    fn strings_at(&self, index: usize) -> Option<&Strings> {
        self.bank.surfaces(index)?.as_any().downcast_ref()
    }

    /// Force of the strings of all keys on the bridge now, N: the sum of [`Strings::bridge_n`] in the order of the
    /// keys, with what the dampers at rest press; 0 where no strings sound.
    #[must_use]
    pub fn bridge_n(&self) -> f64 {
        (0..self.count()).filter_map(|index| self.strings_at(index)).map(Strings::bridge_n).sum()
    }

    /// Force of the finger on a key in the last step, N.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn finger_force_n(&self, key: usize) -> Result<f64, IndexError> {
        Ok(self.output(key)?.drive_n)
    }

    /// Travel of a key's front from its rest, down positive, m.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn key_m(&self, key: usize) -> Result<f64, IndexError> {
        let index = self.index(key)?;
        Ok(self.bank.output(index).site_m - self.own[index].rest.site_m)
    }

    /// Absolute angles of a key's bodies, rad.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn angles(&self, key: usize) -> Result<&[f64], IndexError> {
        Ok(self.bank.angles(self.index(key)?))
    }

    /// Absolute angular velocities of a key's bodies, rad/s.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn velocities(&self, key: usize) -> Result<&[f64], IndexError> {
        Ok(self.bank.velocities(self.index(key)?))
    }

    /// Saves everything that a key's following steps depend on. An [`Action`] of the same instrument can continue from
    /// it, and the reverse.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn save(&self, key: usize) -> Result<Snapshot, IndexError> {
        Ok(Snapshot::new(self.mechanism_state(key)?, self.bank.surfaces(self.index(key)?)))
    }

    /// The state of a key without the vibration of its strings: [`Action::mechanism_state`].
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn mechanism_state(&self, key: usize) -> Result<MechanismState, IndexError> {
        let index = self.index(key)?;
        let own = &self.own[index];
        Ok(MechanismState::new(&own.identity, self.settings(), self.bank.save(index), own.aimed_m))
    }

    /// [`Action::save_strings`] of a key.
    ///
    /// # Errors
    /// There is no such key; keys count from 1.
    pub fn save_strings(
        &self,
        key: usize,
        put: &mut dyn FnMut(&'static str, &mut dyn Iterator<Item = f64>),
    ) -> Result<(), IndexError> {
        if let Some(strings) = self.bank.surfaces(self.index(key)?) {
            strings.save(put);
        }
        Ok(())
    }

    /// Continues a key from a snapshot of the same instrument and settings, to the bit; its input stays. Its clock
    /// is that of all keys, so the snapshot's record of the hammer's flight is shifted to it.
    ///
    /// # Errors
    /// [`SnapshotError`].
    pub fn restore(&mut self, key: usize, snapshot: &Snapshot) -> Result<(), SnapshotError> {
        self.restore_from(key, &snapshot.mechanism, &|name, number| snapshot.each(name, number))
    }

    /// Whether [`Keys::restore_from`] would go on from there; nothing changes.
    ///
    /// # Errors
    /// [`SnapshotError`].
    pub fn restorable(
        &self,
        key: usize,
        state: &MechanismState,
        strings: &dyn Fn(&str, &mut TellNumbers<'_>) -> usize,
    ) -> Result<(), SnapshotError> {
        let index = self.index(key)?;
        state.open(&self.own[index].identity, self.settings())?;
        self.bank.surfaces(index).map_or(Ok(()), |surfaces| strings_are_finite(surfaces, strings))
    }

    /// Restores a key from the parts of a state: [`Action::restore_from`].
    ///
    /// # Errors
    /// [`SnapshotError`].
    pub fn restore_from(
        &mut self,
        key: usize,
        state: &MechanismState,
        strings: &dyn Fn(&str, &mut TellNumbers<'_>) -> usize,
    ) -> Result<(), SnapshotError> {
        self.restorable(key, state, strings)?;
        let index = self.index(key)?;
        let (mut saved, aimed_m) = state.open(&self.own[index].identity, self.settings())?;
        self.own[index].aimed_m = aimed_m;
        let later_s = self.bank.now_s() - saved.now_s;
        for [time_s, ..] in saved.flight.iter_mut().flatten() {
            *time_s += later_s;
        }
        self.bank.restore(index, &saved);
        if let Some(surfaces) = self.bank.surfaces_mut(index) {
            surfaces.restore(strings);
        }
        Ok(())
    }
}

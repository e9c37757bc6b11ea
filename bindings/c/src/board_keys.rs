//! The keys of a board: actions of `erard`, each its own instrument's.

use std::ffi::c_char;
use std::path::Path;

use erard::damper::DamperHeights;
use erard::instrument::utf8;
use erard::keyboard::Keyboard;
use erard::player::MechanismState;
use erard::{Action, Instrument};
use erard_live::Limits;
use erard_live::action::REMEMBERED;
use erard_live::converter::Stops;
use erard_live::sensed::Counts;
use erard_live::sensing::{Sensing, Sensor, Voice};
use erard_live::sensor::FixedLaw;
use erard_midi::{Message, note_of_key};

use crate::board::Asked;
use crate::instrument::{builtin_keyboard, file_fault};
use crate::outcome::ErardStatus;
use crate::play::settings;
use crate::status::Fault;
use crate::text::bytes;

/// What all keys share: nothing.
pub(crate) struct Shared;

/// A key: its sensor and its action.
pub(crate) struct BoardKey {
    note: u8,
    sensing: Sensing<f64, REMEMBERED>,
    action: Action,
    rest: MechanismState,
}

impl BoardKey {
    fn new(
        (number, silent): (usize, &Instrument),
        asked: &Asked,
        stops: Stops,
        dampers: &DamperHeights<'_>,
    ) -> Result<Self, Fault> {
        let model = |error: &dyn std::fmt::Display| Fault::new(ErardStatus::Model, format!("key {number}: {error}"));
        let limits = Limits::find(silent, asked.sensor.kind).map_err(|error| model(&error))?.ok_or_else(|| {
            model(&"no press throws the hammer to a string; expected an action with key, hammer and string")
        })?;
        let damper_m = dampers.of(number).map_err(|error| Fault::new(ErardStatus::Model, error.to_string()))?;
        let step_s = asked.step_s.unwrap_or_else(|| silent.usual_step_s());
        let action = Action::with(silent, settings(step_s)).map_err(|error| model(&error))?;
        let front_per_sensed = asked.sensor_at_m.map_or(1.0, |at_m| (silent.roles.key_front_m[0] / at_m).abs());
        let sensor = Sensor { stops, front_per_sensed, ..asked.sensor };
        Ok(BoardKey {
            note: note_of_key(number).unwrap_or(0),
            sensing: Sensing::new(&sensor, &limits, damper_m, step_s),
            rest: action.mechanism_state(),
            action,
        })
    }

    /// Takes a reading at an instant, s.
    pub(crate) fn take(
        &mut self,
        _: &mut Shared,
        (time_s, reading): (f64, f32),
        voice: &Voice<'_>,
        send: &mut dyn FnMut(Message),
    ) {
        let BoardKey { note, sensing, action, .. } = self;
        sensing.take((time_s, f64::from(reading)), action, &mut |event| send(voice.message(*note, event)));
    }

    /// Lets it go at an instant, s, and follows it to its rest.
    pub(crate) fn let_go(&mut self, _: &mut Shared, time_s: f64, voice: &Voice<'_>, send: &mut dyn FnMut(Message)) {
        let BoardKey { note, sensing, action, .. } = self;
        sensing.let_go(time_s, action, &mut |event| send(voice.message(*note, event)));
    }

    /// Sets the clock of a key that was let go ahead, s.
    pub(crate) fn jump(&mut self, to_s: f64) {
        self.sensing.jump(to_s);
    }

    /// Puts it back to its rest; returns whether that was possible.
    pub(crate) fn reset(&mut self, _: &mut Shared) -> bool {
        self.sensing.reset();
        self.action.restore_from(&self.rest, &|_, _| 0).is_ok()
    }

    pub(crate) fn set_law(&mut self, law: FixedLaw) {
        self.sensing.set_law(law);
    }

    pub(crate) fn is_asleep(&self) -> bool {
        self.action.is_asleep()
    }

    pub(crate) fn counts(&self) -> Counts {
        self.sensing.counts()
    }

    /// Drift of the sensor's rest, and how often it exceeded the limit.
    pub(crate) fn drift(&self) -> (f64, u64) {
        self.sensing.drift()
    }
}

/// Makes all keys and hands them to `put`, by their numbers; those without stops are `None`. Nothing is handed over if
/// one cannot be made. `keyboard` is a caller's text, and its length.
///
/// # Safety
/// `keyboard` is NULL, or as many readable bytes that do not change during the call.
pub(crate) unsafe fn make(
    asked: &Asked,
    (keyboard, length): (*const c_char, usize),
    stops: &dyn Fn(usize) -> Option<Stops>,
    put: &mut dyn FnMut(usize, Option<BoardKey>),
) -> Result<Shared, Fault> {
    // SAFETY: `keyboard` is NULL, or `length` readable bytes that do not change during the call.
    let keyboard = match unsafe { bytes(keyboard, length) }? {
        None => builtin_keyboard("concert-grand")?,
        Some(bytes) => {
            let text = utf8(bytes, "keyboard").map_err(|error| file_fault(&error))?;
            Keyboard::parse(text, "keyboard", Path::new("")).map_err(|error| file_fault(&error))?
        }
    };
    let instruments = keyboard.instruments().map_err(|error| file_fault(&error))?;
    // As `erard live` plays them: no string sounds, and what a sensor gives cannot lift the key off its rail.
    let silent: Vec<Instrument> = instruments.iter().map(|one| one.with_rigid_string().with_held_key()).collect();
    let dampers = DamperHeights::new(&silent);
    let wanted: Vec<(usize, Option<Stops>)> = asked.keys.clone().map(|number| (number, stops(number))).collect();
    let made = |(number, stops): &(usize, Option<Stops>)| {
        stops.map(|stops| BoardKey::new((*number, &silent[number - 1]), asked, stops, &dampers)).transpose()
    };
    // A page has one thread.
    let cores = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let all: Vec<Result<Option<BoardKey>, Fault>> = if cores == 1 || cfg!(target_family = "wasm") {
        wanted.iter().map(made).collect()
    } else {
        let share = wanted.len().div_ceil(cores);
        std::thread::scope(|scope| {
            let parts: Vec<_> =
                wanted.chunks(share).map(|part| scope.spawn(|| part.iter().map(made).collect::<Vec<_>>())).collect();
            let ended = |part: std::thread::ScopedJoinHandle<'_, Vec<_>>| {
                part.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            };
            parts.into_iter().flat_map(ended).collect()
        })
    };
    let all = all.into_iter().collect::<Result<Vec<_>, _>>()?;
    for (key, (number, _)) in all.into_iter().zip(&wanted) {
        put(*number, key);
    }
    Ok(Shared)
}

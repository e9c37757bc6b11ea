//! The keys of a board on a chip: they share the action that is compiled in, in single precision.

use core::ffi::c_char;

use erard_live::board::{self, BoardMechanism, Sensor, Voice};
use erard_live::converter::Stops;
use erard_live::sensed::Counts;
use erard_live::sensor::FixedLaw;
use erard_midi::Message;

use crate::board::Asked;
use crate::grand::{self, BODIES, ZONES};
use crate::keys::{LONG_STEP_S, mechanism};
use crate::outcome::ErardStatus;
use crate::status::Fault;

/// What all keys share: the model, and the working memory of a step.
pub(crate) struct Shared(BoardMechanism<f32, BODIES, ZONES, { grand::LAWS }>);

/// A key.
pub(crate) struct BoardKey(board::Key<f32, BODIES, ZONES>);

impl BoardKey {
    /// Takes a reading at an instant, s.
    pub(crate) fn take(
        &mut self,
        shared: &mut Shared,
        (time_s, reading): (f64, f32),
        voice: &Voice<'_>,
        send: &mut dyn FnMut(Message),
    ) {
        shared.0.take(&mut self.0, time_s, reading, voice, send);
    }

    /// Lets it go at an instant, s, and follows it to its rest.
    pub(crate) fn let_go(
        &mut self,
        shared: &mut Shared,
        time_s: f64,
        voice: &Voice<'_>,
        send: &mut dyn FnMut(Message),
    ) {
        shared.0.let_go(&mut self.0, time_s, voice, send);
    }

    /// Sets the clock of a key that was let go ahead, s.
    pub(crate) fn jump(&mut self, to_s: f64) {
        self.0.sensing_mut().jump(to_s);
    }

    /// Puts it back to its rest, which is always possible.
    pub(crate) fn reset(&mut self, shared: &mut Shared) -> bool {
        shared.0.reset(&mut self.0);
        true
    }

    pub(crate) fn set_law(&mut self, law: FixedLaw) {
        self.0.sensing_mut().set_law(law);
    }

    pub(crate) fn is_asleep(&self) -> bool {
        self.0.is_asleep()
    }

    pub(crate) fn counts(&self) -> Counts {
        self.0.counts()
    }

    /// Drift of the sensor's rest, and how often it exceeded the limit.
    pub(crate) fn drift(&self) -> (f64, u64) {
        let (drift, beyond) = self.0.sensing().drift();
        (f64::from(drift), beyond)
    }
}

/// Makes all keys and hands them to `put`, by their numbers; those without stops are `None`.
///
/// # Safety
/// None is needed: a keyboard file is refused unread.
pub(crate) unsafe fn make(
    asked: &Asked,
    (keyboard, _): (*const c_char, usize),
    stops: &dyn Fn(usize) -> Option<Stops>,
    put: &mut dyn FnMut(usize, Option<BoardKey>),
) -> Result<Shared, Fault> {
    if !keyboard.is_null() {
        return Err(Fault::of(ErardStatus::NoSuch, &"a chip has the keyboard that is compiled in; expected NULL"));
    }
    let made = mechanism(asked.step_s.unwrap_or(LONG_STEP_S));
    let mechanism = made.map_err(|error| Fault::of(ErardStatus::Model, &error))?;
    let front_m = grand::site::<f64>().point[0];
    let front_per_sensed = asked.sensor_at_m.map_or(1.0, |at_m| (front_m / at_m).abs());
    for number in asked.keys.clone() {
        let sensor = |stops: Stops| Sensor { stops, front_per_sensed, ..asked.sensor };
        put(number, stops(number).map(|stops| BoardKey(mechanism.key(number, &sensor(stops)))));
    }
    Ok(Shared(mechanism))
}

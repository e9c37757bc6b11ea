//! Keys of a keyboard with sensors: readings of a converter in, bytes of MIDI out.

use erard_live::SensorKind;
use erard_live::board::{self, BoardMechanism, Outline, Sensor, Voice};
use erard_live::sensor::FixedLaw;
use erard_midi::Message;
use moreau::{ModelError, Scalar};

use crate::grand::{self, BODIES, ZONES};
use crate::keyboard::{LIMITS, POINTS, STOPS, TRAVEL_M};

/// A key: all that its next step depends on.
pub type Key<T> = board::Key<T, BODIES, ZONES>;

/// The number of the scan's first key, from the lowest A: a middle C.
pub const LOWEST_KEY: usize = 40;

/// Length of a step, s: each note is within one count of the velocity that it has in steps of 50 us
/// (`crates/erard-live/tests/it/chip.rs`).
pub const LONG_STEP_S: f64 = 250e-6;

/// A key takes no more memory on a chip in single precision, bytes.
const MAX_KEY_BYTES: usize = 2048;
const _: () = assert!(size_of::<usize>() > 4 || size_of::<Key<f32>>() <= MAX_KEY_BYTES, "a key has 2 kB at most");

/// What all keys share: the model, and the working memory of a step.
pub struct Keys<T: Scalar>(BoardMechanism<T, BODIES, ZONES, { grand::LAWS }>);

impl<T: Scalar> Keys<T> {
    /// Every key is the built-in grand's, in steps of `step_s`.
    ///
    /// # Errors
    /// None, for the instrument that is compiled in; another one may have a number that is not sound.
    pub fn new(step_s: f64) -> Result<Self, ModelError> {
        Ok(Keys(mechanism(step_s)?))
    }

    /// A key at rest, its number from the lowest A, 1, with its sensor under the front of a real action's key.
    pub fn key(&self, number: usize) -> Key<T> {
        let sensor = Sensor {
            kind: SensorKind::Action,
            law: FixedLaw::Table { points: &POINTS },
            stops: STOPS,
            still: 2.0,
            travel_m: TRAVEL_M,
            front_per_sensed: 1.0,
        };
        self.0.key(number, &sensor)
    }

    /// Takes a key's reading at an instant, s, later than its last one; sends what comes of it.
    pub fn take(&mut self, key: &mut Key<T>, time_s: f64, reading: u16, send: &mut dyn FnMut(Message)) {
        self.0.take(key, time_s, T::from_f64(f64::from(reading)), &Voice::USUAL, send);
    }

    /// Lets a key go: no note is left.
    pub fn let_go(&mut self, key: &mut Key<T>, time_s: f64, send: &mut dyn FnMut(Message)) {
        self.0.let_go(key, time_s, &Voice::USUAL, send);
    }
}

/// The built-in grand's action, in steps of `step_s`.
pub(crate) fn mechanism<T: Scalar>(
    step_s: f64,
) -> Result<BoardMechanism<T, BODIES, ZONES, { grand::LAWS }>, ModelError> {
    let outline = Outline {
        rest: grand::REST,
        hammer: (grand::HAMMER, grand::HAMMER_POINT),
        string: grand::STRING,
        limits: LIMITS,
        damper_m: grand::DAMPER_M,
    };
    BoardMechanism::new(crate::model()?, outline, step_s)
}

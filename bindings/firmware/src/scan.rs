//! The recorded scan, played: ten keys, a chord at all levels, presses one after the other, a key that goes half-way.

use erard_midi::Message;
use moreau::Scalar;

use crate::keyboard::{FRAMES, KEYS, PERIOD_S};
use crate::keys::{Key, Keys, LOWEST_KEY};

/// For every instant the readings of all keys, two bytes each, the lower one first. `.ci/regenerate firmware` writes
/// it.
static SCAN: &[u8; 2 * KEYS * FRAMES] = include_bytes!("scan.bin");

/// What the converter read of a key in a frame, both from 0; `None` beyond them.
#[must_use]
pub fn reading(frame: usize, key: usize) -> Option<u16> {
    let at = 2 * (frame * KEYS + key);
    let bytes = SCAN.get(at..at + 2).filter(|_| key < KEYS)?;
    Some(u16::from_le_bytes([bytes[0], bytes[1]]))
}

/// The scan on its way through ten keys.
pub struct Scanned<T: Scalar> {
    keys: Keys<T>,
    all: [Key<T>; KEYS],
    frame: usize,
}

impl<T: Scalar> Scanned<T> {
    /// Ten keys at rest, in steps of `step_s`; `None` where the instrument is not sound, which the one that is compiled
    /// in is.
    #[must_use]
    pub fn new(step_s: f64) -> Option<Self> {
        let keys = Keys::new(step_s).ok()?;
        let all = core::array::from_fn(|k| keys.key(LOWEST_KEY + k));
        Some(Scanned { keys, all, frame: 0 })
    }

    /// Plays the next frame; false after the last one.
    pub fn frame(&mut self, send: &mut dyn FnMut(Message)) -> bool {
        if self.frame == FRAMES {
            return false;
        }
        let time_s = (self.frame + 1) as f64 * PERIOD_S;
        for (k, key) in self.all.iter_mut().enumerate() {
            if let Some(reading) = reading(self.frame, k) {
                self.keys.take(key, time_s, reading, send);
            }
        }
        self.frame += 1;
        true
    }

    /// Lets all keys go.
    pub fn end(&mut self, send: &mut dyn FnMut(Message)) {
        for key in &mut self.all {
            self.keys.let_go(key, FRAMES as f64 * PERIOD_S, send);
        }
    }

    /// The keys.
    #[must_use]
    pub fn keys(&self) -> &[Key<T>; KEYS] {
        &self.all
    }
}

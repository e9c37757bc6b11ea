//! A fortissimo tremolo that wanders over the whole keyboard: a demanding load for a keyboard in real time.
//!
//! Every finger has a stretch of the keyboard of its own. It strikes a key [`STROKES`] times, [`STROKES_PER_S`] times a
//! second, goes on to the next key and from the last of its stretch back to the first. Every other finger strikes half
//! a stroke later, as in a tremolo. With ten fingers five hammers fly together and all 88 keys are played in turn; one
//! finger plays them all, and 88 play all at once.

use std::f64::consts::PI;

use moreau::Settings;

use super::{Keys, Tick};
use crate::player::Input;

/// Fingers of two hands.
pub const TEN: usize = 10;
/// Strokes of a finger per second: with two fingers in alternation fourteen notes a second.
pub const STROKES_PER_S: f64 = 7.0;
/// Strokes on a key before the finger goes on.
pub const STROKES: usize = 3;
/// Force of the finger on a key that is down, N: as in the built-in stroke `ff`.
pub(crate) const FORCE_N: f64 = 20.0;
/// Time in which the finger's force rises, s: as in that stroke.
const RISE_S: f64 = 0.014;
/// When the finger begins to lift, s after the stroke's start: the hammer has been caught.
const LIFT_S: f64 = 0.035;
/// Time in which it lifts, s.
const LIFTING_S: f64 = 0.010;

/// Keys under the fingers of a tremolo.
pub struct Tremolo {
    keys: Keys,
    fingers: Vec<Finger>,
    /// The finger's force, N, at every tick of a stroke.
    force_n: Vec<f64>,
}

/// A finger and its stretch of the keyboard.
struct Finger {
    /// Keys of its stretch, from 1: the first, and the one after the last.
    first: usize,
    end: usize,
    /// The key that it is at.
    key: usize,
    /// Strokes on it, with the present one.
    strokes: usize,
    /// The tick within the stroke; before it begins to play, counted from the end of a stroke.
    tick: usize,
    playing: bool,
}

impl Tremolo {
    /// So many fingers on a keyboard, at most one for every key; none of them leaves it at rest.
    #[must_use]
    pub fn new(keys: Keys, fingers: usize) -> Self {
        let Settings { step, theta, .. } = *keys.settings();
        let ticks = (1.0 / (STROKES_PER_S * step)).round() as usize;
        let (count, fingers) = (keys.count(), fingers.min(keys.count()));
        let stretch = |finger: usize| 1 + count * finger / fingers;
        let finger = |n: usize| Finger {
            first: stretch(n),
            end: stretch(n + 1),
            key: stretch(n),
            strokes: 1,
            tick: if n.is_multiple_of(2) { 0 } else { ticks / 2 },
            playing: n.is_multiple_of(2),
        };
        Tremolo {
            fingers: (0..fingers).map(finger).collect(),
            force_n: (0..ticks).map(|n| force_n((n as f64 + theta) * step)).collect(),
            keys,
        }
    }

    /// One step of the fingers and of all keys that are awake. Never allocates.
    pub fn tick(&mut self) -> Tick {
        self.drive(&mut |_, _| {});
        self.keys.step()
    }

    /// The fingers' part of a tick, before the keys' step: `pressed` gets each key that is played, from 1, and its
    /// force, N.
    pub fn drive(&mut self, pressed: &mut dyn FnMut(usize, f64)) {
        for finger in &mut self.fingers {
            if finger.playing {
                let force_n = self.force_n[finger.tick];
                // A finger's stretch lies within the keyboard.
                let _ = self.keys.drive(finger.key, Input::Force(force_n));
                pressed(finger.key, force_n);
            }
            finger.tick += 1;
            if finger.tick == self.force_n.len() {
                finger.next_stroke();
            }
        }
    }

    /// The keys, to be looked at.
    #[must_use]
    pub fn keys(&self) -> &Keys {
        &self.keys
    }

    /// The keys, to be changed.
    pub fn keys_mut(&mut self) -> &mut Keys {
        &mut self.keys
    }

    /// Ticks in which every finger has been at every key of its stretch, and every stroke has ended.
    #[must_use]
    pub fn ticks_over_all(&self) -> u64 {
        let longest = self.fingers.iter().map(|f| f.end - f.first).max().unwrap_or(0);
        let stroke = self.force_n.len() as u64;
        (longest * STROKES) as u64 * stroke + stroke / 2
    }
}

impl Finger {
    fn next_stroke(&mut self) {
        self.tick = 0;
        if !self.playing {
            self.playing = true;
            return;
        }
        self.strokes += 1;
        if self.strokes > STROKES {
            self.strokes = 1;
            self.key = if self.key + 1 < self.end { self.key + 1 } else { self.first };
        }
    }
}

/// Force of the finger at a time after a stroke's start, N: up, held, and away.
fn force_n(time_s: f64) -> f64 {
    let ramp = |x: f64| 0.5 - 0.5 * libm::cos(PI * x.clamp(0.0, 1.0));
    FORCE_N * ramp(time_s / RISE_S) * (1.0 - ramp((time_s - LIFT_S) / LIFTING_S))
}

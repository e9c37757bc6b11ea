//! Beginning and end of a note, from the motion of a key's action.

/// Event of a key's action.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Event {
    /// The hammer met the string: a note-on.
    On {
        /// Instant, s.
        time_s: f64,
        /// Total speed of the hammer at the impact, m/s.
        hammer_speed_m_per_s: f64,
    },
    /// The key, coming up, passed where it sets its damper down: a note-off.
    Off {
        /// Instant, s.
        time_s: f64,
        /// Speed of the key's front on its way up there, m/s, up positive; `None` where nobody saw it come up.
        release_m_per_s: Option<f64>,
    },
}

/// Key travel at which the damper falls on the string.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crossing {
    /// Travel of the key's front from rest, m, down positive, at which the key, coming up, sets its damper down while
    /// the pedal is up. Keys without a damper use this travel, too, for their note-offs.
    pub damper_m: f64,
}

/// The note of one key, from step to step. It needs no heap and a few dozen bytes.
///
/// A note begins with the hammer's impact and ends where the key, coming up, passes [`Crossing::damper_m`]. A
/// repetition through the double escapement strikes again before the key comes up so far: the note-ons follow each
/// other, and one note-off ends them. A key that is pressed too gently to strike makes no note at all, and its way up
/// no note-off. A hammer in flight may strike after its key has come up: that note ends as it begins, for the damper
/// lies on the string.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeyNotes {
    crossing: Crossing,
    sounds: bool,
    /// The instant, s, and the key's travel, m, at the end of a step.
    before: Option<[f64; 2]>,
    /// Speed of the rising key at its last passage, m/s.
    release_m_per_s: f64,
}

impl KeyNotes {
    /// A key at rest.
    #[must_use]
    pub fn new(crossing: Crossing) -> Self {
        KeyNotes { crossing, sounds: false, before: None, release_m_per_s: 0.0 }
    }

    /// Whether a note has begun and not ended.
    #[must_use]
    pub fn sounds(&self) -> bool {
        self.sounds
    }

    /// Ends the note, if there is one, wherever the key is; returns whether there was one.
    pub fn end(&mut self) -> bool {
        core::mem::take(&mut self.sounds)
    }

    /// Takes the state at the end of a step: the instant, s, the travel of the key's front, m, down positive, and the
    /// impact in the step, if there was one: its instant, s, and the hammer's speed, m/s. Instants ascend, an impact's
    /// with them. Returns the events of the step, the earlier first.
    pub fn update(&mut self, time_s: f64, key_m: f64, impact: Option<[f64; 2]>) -> [Option<Event>; 3] {
        let at_m = self.crossing.damper_m;
        let [t0, x0] = self.before.replace([time_s, key_m]).unwrap_or([time_s, key_m]);
        let passed_s = (x0 > at_m && key_m <= at_m && time_s > t0).then(|| {
            self.release_m_per_s = (x0 - key_m) / (time_s - t0);
            t0 + (x0 - at_m) / self.release_m_per_s
        });
        let Some([on_s, hammer_speed_m_per_s]) = impact else {
            return [passed_s.and_then(|at| self.ended(at)), None, None];
        };
        let on = Some(Event::On { time_s: on_s, hammer_speed_m_per_s });
        match passed_s {
            // It struck and was let go at once.
            Some(at_s) if on_s <= at_s => {
                self.sounds = true;
                [on, self.ended(at_s), None]
            }
            // The key is up already.
            Some(at_s) => {
                let before = self.ended(at_s);
                self.sounds = true;
                [before, on, self.ended(on_s)]
            }
            None if x0.max(key_m) <= at_m => {
                self.sounds = true;
                [on, self.ended(on_s), None]
            }
            None => {
                self.sounds = true;
                [on, None, None]
            }
        }
    }

    /// The note's end, if there is a note.
    fn ended(&mut self, time_s: f64) -> Option<Event> {
        let off = Event::Off { time_s, release_m_per_s: Some(self.release_m_per_s) };
        self.end().then_some(off)
    }
}

/// A pedal, sent as a continuous controller only: a value is sent when it changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Pedal {
    value: u8,
}

impl Pedal {
    /// A pedal that is up, the state that a receiver assumes at first.
    #[must_use]
    pub fn up() -> Self {
        Pedal { value: 0 }
    }

    /// Takes the pedal's position, 0 (up) to 1 (down); returns the controller's value if it changed. A position that is
    /// not a number counts as up.
    pub fn update(&mut self, down: f64) -> Option<u8> {
        let share = if down > 0.0 { down.min(1.0) } else { 0.0 };
        let value = libm::round(127.0 * share) as u8;
        let changed = value != self.value;
        self.value = value;
        changed.then_some(value)
    }
}

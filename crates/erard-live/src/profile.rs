//! The profile of a device: its sensors' law and the two stops of each key, and how readings become travel.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use erard::instrument::from_toml::from_toml;
use erard::keyboard::KEYS;
use serde::Deserialize;

use crate::sensor::Law;

/// Format name, the first entry of a profile.
pub const FORMAT: &str = "erard-sensors/1";
/// Drift is followed up to this share of a sensor's range.
const MOST_DRIFT: f64 = 0.15;
/// A reading nearer to its rest than this share of the range may be the rest.
const NEAR_REST: f64 = 0.03;
/// It is if it has kept within this share of the range for this time, s.
const STEADY: f64 = 0.005;
const RESTS_S: f64 = 1.0;
/// The rest follows its readings within this time, s.
const FOLLOWS_S: f64 = 10.0;

/// The readings at a key's two stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stops {
    /// Up, at rest.
    pub rest: f64,
    /// Down, held at the bottom.
    pub pressed: f64,
}

/// The profile of a device.
#[derive(Debug, Clone, PartialEq)]
pub struct Profile {
    /// The sensors' law.
    pub law: Law,
    /// The sensed travel between the stops, m.
    pub travel_m: f64,
    /// Whether polyphonic pressure is the key's depth.
    pub pressure_is_depth: bool,
    /// The stops of keys, by number from 1.
    pub keys: BTreeMap<usize, Stops>,
}

/// Fault of a profile.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ProfileFault {
    /// It cannot be read.
    #[error("line {line}: {what}")]
    Toml {
        /// From 1.
        line: usize,
        /// Fault, in words.
        what: String,
    },
    /// A number or word.
    #[error("`{key}` is {found}; expected {expected}")]
    Value {
        /// Its key.
        key: String,
        /// It.
        found: String,
        /// Expected text.
        expected: &'static str,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    format: String,
    travel_mm: f64,
    #[serde(default)]
    polyphonic_pressure_is_depth: bool,
    law: Law,
    #[serde(default)]
    key: Vec<KeyEntry>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct KeyEntry {
    number: usize,
    rest: f64,
    pressed: f64,
}

impl Profile {
    /// Reads a profile.
    ///
    /// # Errors
    /// [`ProfileFault`].
    pub fn parse(text: &str) -> Result<Self, ProfileFault> {
        let file: File = from_toml(text).map_err(|error| ProfileFault::Toml {
            line: error.span.map_or(1, |span| text[..span.start.min(text.len())].lines().count().max(1)),
            what: error.message,
        })?;
        let wrong = |key: &str, found: String, expected| ProfileFault::Value { key: key.to_owned(), found, expected };
        if file.format != FORMAT {
            return Err(wrong("format", format!("\"{}\"", file.format), "\"erard-sensors/1\""));
        }
        if !(0.5..=100.0).contains(&file.travel_mm) {
            return Err(wrong("travel_mm", file.travel_mm.to_string(), "a number from 0.5 to 100"));
        }
        file.law.check().map_err(|fault| wrong("law", fault.to_string(), "a sound law"))?;
        let mut keys = BTreeMap::new();
        for KeyEntry { number, rest, pressed } in file.key {
            if !(1..=KEYS).contains(&number) || keys.contains_key(&number) {
                return Err(wrong("key.number", number.to_string(), "1 to 88, each once"));
            }
            if !(rest.is_finite() && pressed.is_finite() && rest != pressed) {
                let found = format!("{rest} up and {pressed} down");
                return Err(wrong(&format!("key {number}"), found, "two different finite readings"));
            }
            keys.insert(number, Stops { rest, pressed });
        }
        if keys.is_empty() {
            return Err(wrong("key", "missing".into(), "at least one [[key]]"));
        }
        let travel_m = 1e-3 * file.travel_mm;
        Ok(Profile { law: file.law, travel_m, pressure_is_depth: file.polyphonic_pressure_is_depth, keys })
    }

    /// Its text.
    #[must_use]
    pub fn text(&self) -> String {
        let mut out = format!("format = \"{FORMAT}\"\n");
        let mm = |m: f64| (1e9 * m).round() / 1e6;
        // Nothing that is written to a string fails.
        let _ = writeln!(out, "# The sensed place's way between the key's two stops.");
        let _ = writeln!(out, "travel_mm = {}", mm(self.travel_m));
        let _ = writeln!(out, "# Whether polyphonic pressure of this device is the key's depth, not a force.");
        let _ = writeln!(out, "polyphonic_pressure_is_depth = {}\n\n[law]", self.pressure_is_depth);
        let _ = match &self.law {
            Law::Linear {} => writeln!(out, "kind = \"linear\""),
            Law::Cny70 {} => writeln!(out, "kind = \"cny70\""),
            Law::Hall { nearest_mm, at_rest } => {
                writeln!(out, "kind = \"hall\"\nnearest_mm = {nearest_mm}\nat_rest = {at_rest}")
            }
            Law::Table { points } => {
                writeln!(out, "kind = \"table\"\n# Share of the reading's range, share of the travel.")
                    .and_then(|()| writeln!(out, "points = {points:?}"))
            }
        };
        for (number, Stops { rest, pressed }) in &self.keys {
            let _ = writeln!(out, "\n[[key]]\nnumber = {number}\nrest = {rest}\npressed = {pressed}");
        }
        out
    }

    /// Returns the converter of a key's readings; `None` for a key without stops.
    #[must_use]
    pub fn converter(&self, key: usize) -> Option<Converter> {
        let stops = *self.keys.get(&key)?;
        Some(Converter { law: self.law.clone(), stops, travel_m: self.travel_m, drift: 0.0, before: None, beyond: 0 })
    }
}

/// Converts a key's readings to travel, and follows how its rest drifts.
///
/// A reading within 3 % of the range of the last known rest that keeps within 0.5 % for a second is the rest: it is
/// followed within ten seconds, up to 15 % of the range. Both stops drift by the same. What reads beyond the rest,
/// where no key goes, is followed however far it is. A key that is held down does not drift.
#[derive(Debug, Clone)]
pub struct Converter {
    law: Law,
    stops: Stops,
    travel_m: f64,
    /// Share of the range by which readings have drifted.
    drift: f64,
    /// The last reading's instant, s; since when readings have kept together, s, and around which.
    before: Option<[f64; 3]>,
    beyond: u64,
}

impl Converter {
    /// Travel of the sensed place, m, at a reading at an instant, s.
    pub fn travel_m(&mut self, time_s: f64, reading: f64) -> f64 {
        let Stops { rest, pressed } = self.stops;
        let read = (reading - rest) / (pressed - rest);
        let [before_s, since_s, around] = self.before.unwrap_or([time_s, time_s, read]);
        let off = read - self.drift;
        let is_steady = off < NEAR_REST && (read - around).abs() < STEADY;
        let [since_s, around] = if is_steady { [since_s, around] } else { [time_s, read] };
        if time_s - since_s > RESTS_S {
            let wanted = self.drift + off * ((time_s - before_s) / FOLLOWS_S).min(1.0);
            self.beyond += u64::from(wanted.abs() > MOST_DRIFT && self.drift.abs() < MOST_DRIFT);
            self.drift = wanted.clamp(-MOST_DRIFT, MOST_DRIFT);
        }
        self.before = Some([time_s, since_s, around]);
        // No sensor tells what lies far beyond its stops.
        let off = (read - self.drift).clamp(-0.5, 1.5);
        self.travel_m * self.law.share(off, self.travel_m)
    }

    /// The whole travel, m.
    #[must_use]
    pub fn whole_m(&self) -> f64 {
        self.travel_m
    }

    /// By which share of the range the rest has drifted.
    #[must_use]
    pub fn drift(&self) -> f64 {
        self.drift
    }

    /// How often it would have gone beyond what is followed.
    #[must_use]
    pub fn beyond(&self) -> u64 {
        self.beyond
    }
}

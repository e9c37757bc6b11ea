//! The profile of a device: its sensors' law and the two stops of each key.

use std::collections::BTreeMap;
use std::fmt::Write as _;

use erard::instrument::from_toml::from_toml;
use erard::keyboard::KEYS;
use serde::Deserialize;

pub use crate::converter::{Converter, Stops};
use crate::sensor::Law;

/// Format name, the first entry of a profile.
pub const FORMAT: &str = "erard-sensors/1";

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
#[non_exhaustive]
pub enum ProfileFault {
    /// It cannot be read.
    #[error("line {line}: {what}")]
    Toml {
        /// Line, from 1.
        line: usize,
        /// Fault, in words.
        what: String,
    },
    /// A number or word.
    #[error("`{key}` is {found}; expected {expected}")]
    Value {
        /// Key of the entry.
        key: String,
        /// The text found.
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
        let file: File =
            from_toml(text).map_err(|error| ProfileFault::Toml { line: error.line(text), what: error.message })?;
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
    pub fn converter(&self, key: usize) -> Option<Converter<f64, Vec<[f64; 2]>>> {
        let stops = *self.keys.get(&key)?;
        Some(Converter::new(self.law.clone(), stops, self.travel_m))
    }
}

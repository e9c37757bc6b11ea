//! The keyboard: 88 actions, graded from bass to treble, and played together.
//!
//! A [`Keyboard`] holds the instrument file of one key and the differences from key to key (hammers, leads, strings,
//! pins). From it comes every key's [`Instrument`], for every command that takes one. [`Keys`] are the assembled
//! actions, stepped together, in which a key at rest costs nothing; [`tremolo`] plays them.

mod file;
mod format;
mod grading;
mod grading_curve;
mod keys;
pub mod tremolo;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

pub use file::{UnknownKeyboard, is_keyboard, json_schema};
pub use grading::{Absence, Graded, Grading};
pub use grading_curve::{Between, GradingCurve, GradingPoint};
pub use keys::{KeyImpact, Keys, KeysError, Tick};

use toml_edit::DocumentMut;

use crate::instrument::{FileError, Instrument, InstrumentFile, Source};

/// Keys of a piano. They count from 1, the lowest A.
pub const KEYS: usize = 88;

/// A keyboard: the instrument of one key, and how the others differ from it.
#[derive(Debug, Clone, PartialEq)]
pub struct Keyboard {
    /// Name shown in summaries, e.g. `Concert grand`.
    pub name: String,
    /// Description from the file; may be empty.
    pub description: String,
    /// Key number of the base instrument, 1 to 88.
    pub base_key: usize,
    /// Differences from key to key.
    pub gradings: Vec<Grading>,
    /// Parts that some keys lack.
    pub absences: Vec<Absence>,
    /// The sources that the gradings cite, by name.
    pub sources: BTreeMap<String, Source>,
    file_name: String,
    base_text: String,
    base_path: Option<PathBuf>,
}

impl Keyboard {
    /// The file of the base instrument; `None` for a built-in one.
    #[must_use]
    pub fn base_path(&self) -> Option<&Path> {
        self.base_path.as_deref()
    }

    /// The text of the base instrument's file.
    #[must_use]
    pub fn base_text(&self) -> &str {
        &self.base_text
    }

    /// This keyboard with another base instrument, whose file must have the graded numbers.
    ///
    /// # Errors
    /// What is wrong with the text, or with its first or last key.
    pub fn around(&self, base_text: String) -> Result<Self, Box<FileError>> {
        let keyboard = Keyboard { base_text, ..self.clone() };
        for key in [1, KEYS] {
            keyboard.key(key)?;
        }
        Ok(keyboard)
    }

    /// The text of a key's instrument file: the base instrument's with its gradings, every graded number cited. Its
    /// name is the keyboard's with number and note of the key.
    #[must_use]
    pub fn key_text(&self, key: usize) -> String {
        self.graded(self.base(), key)
    }

    fn base(&self) -> DocumentMut {
        // It was read with the file.
        self.base_text.parse().unwrap_or_default()
    }

    fn graded(&self, base: DocumentMut, key: usize) -> String {
        // Every path was looked up when the file was read.
        grading::graded_text(self, base, key).unwrap_or_default()
    }

    /// A key's instrument with its provenance.
    ///
    /// # Errors
    /// A grading leads to an impossible value, such as a negative mass.
    pub fn key_file(&self, key: usize) -> Result<InstrumentFile, Box<FileError>> {
        InstrumentFile::parse(&self.key_text(key), &self.key_name(key))
    }

    /// What errors call a key's file.
    fn key_name(&self, key: usize) -> String {
        format!("{}, key {key}", self.file_name)
    }

    /// A key's instrument, 1 to 88.
    ///
    /// # Errors
    /// As [`Keyboard::key_file`].
    pub fn key(&self, key: usize) -> Result<Instrument, Box<FileError>> {
        self.key_around(self.base(), key)
    }

    fn key_around(&self, base: DocumentMut, key: usize) -> Result<Instrument, Box<FileError>> {
        Instrument::parse(&self.graded(base, key), &self.key_name(key))
    }

    /// The instruments of all keys, from the bass.
    ///
    /// # Errors
    /// As [`Keyboard::key_file`].
    pub fn instruments(&self) -> Result<Vec<Instrument>, Box<FileError>> {
        let base = self.base();
        (1..=KEYS).map(|key| self.key_around(base.clone(), key)).collect()
    }
}

/// The note of a key, e.g. `C4` for key 40 and `A0` for key 1.
#[must_use]
pub fn note_name(key: usize) -> String {
    const NAMES: [&str; 12] = ["C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B"];
    let from_c0 = key + 8;
    format!("{}{}", NAMES[from_c0 % 12], from_c0 / 12)
}

/// The key of a number (`40`) or a note (`C4`, `c#4`, `Db4`), from 1; `None` where it is none of the 88.
#[must_use]
pub fn key_named(text: &str) -> Option<usize> {
    const FLATS: [(&str, &str); 5] = [("DB", "C#"), ("EB", "D#"), ("GB", "F#"), ("AB", "G#"), ("BB", "A#")];
    let text = text.trim();
    if let Ok(number) = text.parse::<usize>() {
        return (1..=KEYS).contains(&number).then_some(number);
    }
    let upper = text.to_uppercase();
    let flat = FLATS.iter().find_map(|(flat, sharp)| Some((sharp, upper.strip_prefix(flat)?)));
    let name = flat.map_or(upper.clone(), |(sharp, octave)| format!("{sharp}{octave}"));
    (1..=KEYS).find(|key| note_name(*key) == name)
}

/// Whether a key is a black one.
#[must_use]
pub fn is_sharp(key: usize) -> bool {
    note_name(key).contains('#')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes() {
        let names = [1, 3, 4, 16, 40, 41, 49, 64, 88].map(note_name);
        assert_eq!(names, ["A0", "B0", "C1", "C2", "C4", "C#4", "A4", "C6", "C8"]);
    }

    /// Numbers, notes, flats, either case; nothing beyond the 88.
    #[test]
    fn keys_by_number_or_note() {
        for (text, key) in [("40", 40), ("C4", 40), (" c4", 40), ("Db4", 41), ("c#4", 41), ("Bb0", 2), ("c8", 88)] {
            assert_eq!(key_named(text), Some(key), "{text}");
        }
        for text in ["0", "89", "H4", "C9", "", "Fb4", "-3", "4.5", "b"] {
            assert_eq!(key_named(text), None, "{text}");
        }
    }
}

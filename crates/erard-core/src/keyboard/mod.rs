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
use grading::GradedDocument;
pub use grading::{Absence, Graded, Grading};
pub use grading_curve::{Between, GradingCurve, GradingPoint};
pub use keys::{KeyImpact, Keys, KeysError, Tick};

pub use crate::key::{KEYS, is_sharp, key_named, keys_named, note_name};

use crate::instrument::{FileError, Instrument, InstrumentFile, Source};

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
        // The base was parsed, and every path looked up, when the file was read.
        self.base_text.parse().ok().and_then(|base| grading::graded_text(self, base, key)).unwrap_or_default()
    }

    /// A key's instrument with its provenance.
    ///
    /// # Errors
    /// There is no such key of a piano, or a grading leads to an impossible value, such as a negative mass.
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
        self.key_of(GradedDocument::parse(self).as_ref(), key)
    }

    /// A fault is found again in the key's own text, whose lines the error names.
    fn key_of(&self, base: Option<&GradedDocument<'_>>, key: usize) -> Result<Instrument, Box<FileError>> {
        let read = base.filter(|_| (1..=KEYS).contains(&key)).and_then(|base| base.instrument(key));
        read.map_or_else(|| Instrument::parse(&self.key_text(key), &self.key_name(key)), Ok)
    }

    /// The instruments of all keys, from the bass.
    ///
    /// # Errors
    /// As [`Keyboard::key_file`].
    pub fn instruments(&self) -> Result<Vec<Instrument>, Box<FileError>> {
        let base = GradedDocument::parse(self);
        (1..=KEYS).map(|key| self.key_of(base.as_ref(), key)).collect()
    }
}

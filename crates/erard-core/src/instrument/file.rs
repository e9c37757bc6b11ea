//! Reading instrument files: from text, from disk, or built in.

use std::io::{self, Read};
use std::path::Path;
use std::sync::Arc;

use super::Instrument;
use super::convert::convert;
use super::error::{Fault, FileError};
use super::format::InstrumentToml;
use super::from_toml::from_toml;
use super::locate::{KeyMap, Lines, dress};
use super::provenance::{CitedNumber, Provenance};
use super::reader::ReadNumber;
use super::serde_fault::serde_fault;
use crate::files::{read_at_most, shown};

/// Largest instrument file that is read, bytes. A grand with all its outlines needs a fiftieth of this.
pub const MAX_FILE_BYTES: usize = 4 << 20;

/// The instruments that come with the program, by name.
const BUILTIN: [(&str, &str); 5] = [
    ("concert-grand", include_str!("../../instruments/concert-grand.toml")),
    ("concert-grand-strings", include_str!("../../instruments/concert-grand-strings.toml")),
    ("concert-grand-rigid", include_str!("../../instruments/concert-grand-rigid.toml")),
    ("steinway-o", include_str!("../../instruments/steinway-o.toml")),
    ("heavy-touch", include_str!("../../instruments/heavy-touch.toml")),
];

/// An instrument file that was read: the instrument in SI units and the sources of its numbers.
#[derive(Debug, Clone, PartialEq)]
pub struct InstrumentFile {
    /// The instrument, checked.
    pub instrument: Instrument,
    /// Description from the file; may be empty.
    pub description: String,
    /// The file's numbers and their sources.
    pub provenance: Provenance,
}

impl InstrumentFile {
    /// Reads the text of an instrument file. `file_name` appears in errors only.
    ///
    /// # Errors
    /// The first fault, with line, key, the text found and the text expected.
    pub fn parse(text: &str, file_name: &str) -> Result<Self, Box<FileError>> {
        let (file, instrument, numbers) = read(text, file_name)?;
        let (keys, lines) = (KeyMap::read(text), Lines::read(text));
        let numbers = numbers
            .into_iter()
            .map(|number| CitedNumber {
                key: keys.key_at(&number.span),
                line: lines.line_of(number.span.start),
                values: number.values,
                citation: number.citation,
            })
            .collect();
        Ok(Self {
            instrument,
            description: file.description.unwrap_or_default(),
            provenance: Provenance { sources: file.sources, numbers },
        })
    }

    /// Reads the bytes of an instrument file, which must be UTF-8 (a byte order mark is allowed).
    ///
    /// # Errors
    /// As [`InstrumentFile::parse`], and where the bytes are not UTF-8.
    pub fn parse_bytes(bytes: &[u8], file_name: &str) -> Result<Self, Box<FileError>> {
        Self::parse(utf8(bytes, file_name)?, file_name)
    }

    /// Reads an instrument file from disk.
    ///
    /// # Errors
    /// As [`InstrumentFile::parse_bytes`], and where the file cannot be read.
    pub fn load(path: &Path) -> Result<Self, Box<FileError>> {
        let (name, bytes) = read_bytes(path)?;
        Self::parse_bytes(&bytes, &name)
    }

    /// A built-in instrument, or `None` when there is none of that name.
    pub fn builtin(name: &str) -> Option<Self> {
        let (name, text) = BUILTIN.iter().find(|(known, _)| *known == name)?;
        // A test checks that every built-in file parses.
        Self::parse(text, name).ok()
    }
}

/// Reads and converts a file: returns its keys, the instrument, and its numbers with their places in the text.
fn read(text: &str, file_name: &str) -> Result<(InstrumentToml, Instrument, Vec<ReadNumber>), Box<FileError>> {
    check_size(text, file_name, "an instrument, starting with its `format`")?;
    let file: InstrumentToml = from_toml(text).map_err(|error| dress(file_name, text, serde_fault(&error, text)))?;
    let (instrument, numbers) = convert(&file).map_err(|fault| dress(file_name, text, fault))?;
    Ok((file, instrument, numbers))
}

/// There is no built-in instrument of that name.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("there is no built-in instrument `{name}`; built in are {}", Instrument::builtin_names().collect::<Vec<_>>().join(", "))]
pub struct UnknownInstrument {
    /// The name that was asked for.
    pub name: String,
}

impl Instrument {
    /// A built-in instrument, e.g. `concert-grand`.
    ///
    /// # Errors
    /// [`UnknownInstrument`]: there is none of that name.
    pub fn builtin(name: &str) -> Result<Self, UnknownInstrument> {
        // A test checks that every built-in file parses.
        let found = Self::builtin_text(name).and_then(|text| Self::parse(text, name).ok());
        found.ok_or_else(|| UnknownInstrument { name: name.to_owned() })
    }

    /// Returns the names of the built-in instruments, the default one first.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        BUILTIN.iter().map(|(name, _)| *name)
    }

    /// Returns the TOML text of a built-in instrument, e.g. as the start of a new one.
    pub fn builtin_text(name: &str) -> Option<&'static str> {
        BUILTIN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    /// Reads an instrument file from disk. See [`InstrumentFile::load`].
    ///
    /// # Errors
    /// The first fault, with file, line and key.
    pub fn load(path: &Path) -> Result<Self, Box<FileError>> {
        InstrumentFile::load(path).map(|file| file.instrument)
    }

    /// Reads the text of an instrument file; `file_name` appears in errors only. See [`InstrumentFile::parse`].
    ///
    /// # Errors
    /// The first fault, with file, line and key.
    pub fn parse(text: &str, file_name: &str) -> Result<Self, Box<FileError>> {
        read(text, file_name).map(|(_, instrument, _)| instrument)
    }
}

/// Refuses a text that is empty or longer than [`MAX_FILE_BYTES`]. `expected` describes the content for the message.
pub fn check_size(text: &str, file_name: &str, expected: &str) -> Result<(), Box<FileError>> {
    if text.len() > MAX_FILE_BYTES {
        return Err(too_large(file_name));
    }
    if text.trim().is_empty() {
        return Err(whole_file(file_name, "the file is empty", expected));
    }
    Ok(())
}

/// Converts the bytes of a file to text.
///
/// # Errors
/// The bytes are not UTF-8; the error names the line.
pub fn utf8<'b>(bytes: &'b [u8], file_name: &str) -> Result<&'b str, Box<FileError>> {
    std::str::from_utf8(bytes).map_err(|error| {
        if bytes.len() > MAX_FILE_BYTES {
            return too_large(file_name);
        }
        let start = error.valid_up_to();
        let text = String::from_utf8_lossy(bytes);
        let span = start..start + char::REPLACEMENT_CHARACTER.len_utf8();
        let fault =
            Fault::at(span, "the file is not UTF-8", "text in UTF-8").found(format!("the byte 0x{:02x}", bytes[start]));
        dress(file_name, &text, fault)
    })
}

/// Reads a file: returns its name as errors show it, and its bytes.
pub fn read_bytes(path: &Path) -> Result<(String, Vec<u8>), Box<FileError>> {
    let name = shown(path);
    let bytes = file_bytes(std::fs::File::open(path), &name)?;
    Ok((name, bytes))
}

/// Reads the bytes of an opened instrument, keyboard or linkage file. It stops one byte after [`MAX_FILE_BYTES`], so an
/// endless device is refused as too large. `file_name` appears in errors only.
///
/// # Errors
/// When it could not be opened, cannot be read, or is too large.
pub fn file_bytes(file: io::Result<impl Read>, file_name: &str) -> Result<Vec<u8>, Box<FileError>> {
    let bytes = file.and_then(|file| read_at_most(file, MAX_FILE_BYTES));
    let bytes = bytes.map_err(|error| whole_file(file_name, format!("cannot be read: {error}"), ""))?;
    bytes.ok_or_else(|| too_large(file_name))
}

fn too_large(file_name: &str) -> Box<FileError> {
    whole_file(file_name, format!("larger than {} MiB", MAX_FILE_BYTES >> 20), "")
}

/// An error about a file as a whole.
pub(crate) fn whole_file(file: &str, message: impl Into<String>, expected: &str) -> Box<FileError> {
    Box::new(FileError {
        file: file.to_owned(),
        line: 0,
        column: 0,
        key: String::new(),
        message: message.into(),
        found: String::new(),
        expected: expected.to_owned(),
        span: 0..0,
        text: Arc::from(""),
    })
}

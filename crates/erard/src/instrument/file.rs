//! Reading instrument files: from text, from disk, or built in.

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use super::Instrument;
use super::convert::convert;
use super::error::{Fault, FileError};
use super::format::InstrumentToml;
use super::locate::{KeyMap, dress, line_column};
use super::provenance::{CitedNumber, Provenance};

/// Largest instrument file that is read, bytes: a grand with all its outlines needs a fiftieth of it.
pub const MAX_FILE_BYTES: usize = 4 << 20;

/// The instruments that come with the program, by name.
const BUILTIN: [(&str, &str); 1] = [("concert-grand", include_str!("../../../../instruments/concert-grand.toml"))];

/// An instrument file, read: the instrument in SI units and where its numbers come from.
#[derive(Debug, Clone, PartialEq)]
pub struct InstrumentFile {
    /// The instrument, checked.
    pub instrument: Instrument,
    /// What the file says it is; empty when it says nothing.
    pub description: String,
    /// Every number's source.
    pub provenance: Provenance,
}

impl InstrumentFile {
    /// Reads the text of an instrument file. `file_name` appears in errors only.
    ///
    /// # Errors
    /// The first thing that is wrong, with line, key, what was found and what was expected.
    pub fn parse(text: &str, file_name: &str) -> Result<Self, Box<FileError>> {
        if text.len() > MAX_FILE_BYTES {
            return Err(whole_file(file_name, format!("larger than {} MiB", MAX_FILE_BYTES >> 20), ""));
        }
        if text.trim().is_empty() {
            return Err(whole_file(file_name, "the file is empty", "an instrument, starting with its `format`"));
        }
        let file: InstrumentToml =
            toml::from_str(text).map_err(|error| dress(file_name, text, serde_fault(&error, text)))?;
        let (instrument, numbers) = convert(&file).map_err(|fault| dress(file_name, text, fault))?;
        let keys = KeyMap::read(text);
        let numbers = numbers
            .into_iter()
            .map(|number| CitedNumber {
                key: keys.key_at(&number.span),
                line: line_column(text, number.span.start).0,
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
        match std::str::from_utf8(bytes) {
            Ok(text) => Self::parse(text, file_name),
            Err(_) if bytes.len() > MAX_FILE_BYTES => Self::parse(&" ".repeat(MAX_FILE_BYTES + 1), file_name),
            Err(error) => {
                let start = error.valid_up_to();
                let text = String::from_utf8_lossy(bytes);
                let span = start..start + char::REPLACEMENT_CHARACTER.len_utf8();
                let fault = Fault::at(span, "the file is not UTF-8", "text in UTF-8")
                    .found(format!("the byte 0x{:02x}", bytes[start]));
                Err(dress(file_name, &text, fault))
            }
        }
    }

    /// Reads an instrument file from disk.
    ///
    /// # Errors
    /// As [`InstrumentFile::parse_bytes`], and where the file cannot be read.
    pub fn load(path: &Path) -> Result<Self, Box<FileError>> {
        let name = path.display().to_string();
        let mut bytes = Vec::new();
        std::fs::File::open(path)
            // One byte more than the limit is enough to know; a device that never ends is not read to its end.
            .and_then(|file| file.take(MAX_FILE_BYTES as u64 + 1).read_to_end(&mut bytes))
            .map_err(|error| whole_file(&name, format!("cannot be read: {error}"), ""))?;
        Self::parse_bytes(&bytes, &name)
    }

    /// A built-in instrument, or `None` when there is none of that name.
    pub fn builtin(name: &str) -> Option<Self> {
        let (name, text) = BUILTIN.iter().find(|(known, _)| *known == name)?;
        // A test reads every one of them.
        Self::parse(text, name).ok()
    }
}

impl Instrument {
    /// A built-in instrument, e.g. `concert-grand`, or `None` when there is none of that name.
    pub fn builtin(name: &str) -> Option<Self> {
        InstrumentFile::builtin(name).map(|file| file.instrument)
    }

    /// The names that [`Instrument::builtin`] knows, the default one first.
    pub fn builtin_names() -> impl Iterator<Item = &'static str> {
        BUILTIN.iter().map(|(name, _)| *name)
    }

    /// The TOML text of a built-in instrument: what a new instrument starts from.
    pub fn builtin_text(name: &str) -> Option<&'static str> {
        BUILTIN.iter().find(|(known, _)| *known == name).map(|(_, text)| *text)
    }

    /// Reads an instrument file from disk. See [`InstrumentFile::load`].
    ///
    /// # Errors
    /// The first thing that is wrong, with file, line and key.
    pub fn load(path: &Path) -> Result<Self, Box<FileError>> {
        InstrumentFile::load(path).map(|file| file.instrument)
    }

    /// Reads the text of an instrument file; `file_name` appears in errors only. See [`InstrumentFile::parse`].
    ///
    /// # Errors
    /// The first thing that is wrong, with file, line and key.
    pub fn parse(text: &str, file_name: &str) -> Result<Self, Box<FileError>> {
        InstrumentFile::parse(text, file_name).map(|file| file.instrument)
    }
}

/// An error about a file as a whole.
fn whole_file(file: &str, message: impl Into<String>, expected: &str) -> Box<FileError> {
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

/// A fault from what serde and the TOML parser say; they know kinds of mistakes by their wording only.
fn serde_fault(error: &toml::de::Error, text: &str) -> Fault {
    let span = error.span().unwrap_or(0..0);
    let message = error.message();
    let quoted = |start: &str| {
        let rest = message.strip_prefix(start)?.strip_prefix('`')?;
        rest.split_once('`')
    };
    if let Some((key, rest)) = quoted("unknown field ") {
        let known: Vec<&str> = rest.split('`').skip(1).step_by(2).collect();
        let expected = match nearest(key, &known) {
            Some(near) => format!("`{near}`"),
            None => rest.trim_start_matches(", ").trim_start_matches("expected ").to_owned(),
        };
        let mut fault = Fault::at(span, "unknown key", expected).found(format!("`{key}`"));
        fault.child_key = Some(key.to_owned());
        return fault;
    }
    if let Some((key, _)) = quoted("missing field ") {
        return Fault::missing(span, key, format!("`{key} = ...`"));
    }
    if let Some((word, rest)) = quoted("unknown variant ") {
        let expected = rest.trim_start_matches(", ").trim_start_matches("expected ").to_owned();
        return Fault::at(span, "unknown word", expected).found(format!("`{word}`"));
    }
    for start in ["invalid type: ", "invalid value: ", "invalid length "] {
        if let Some((found, expected)) = message.strip_prefix(start).and_then(|rest| rest.split_once(", expected ")) {
            let what = match start {
                "invalid length " => format!("{found} of them"),
                _ => found.to_owned(),
            };
            return Fault::at(span, "wrong kind of value", expected).found(what);
        }
    }
    // Everything else is the TOML grammar: quote the parser.
    let found =
        if text.get(span.clone()).is_none_or(|under| under.trim().is_empty()) { Some(String::new()) } else { None };
    let mut fault = Fault::at(span, message.replace('\n', "; "), "");
    fault.found = found;
    fault
}

/// The known key that `key` most likely stands for: the one that adds a unit to it, or one within two slips.
fn nearest<'k>(key: &str, known: &[&'k str]) -> Option<&'k str> {
    let lower = key.to_lowercase();
    let stem = |name: &str| name.split('_').next().unwrap_or_default().to_owned();
    known
        .iter()
        .copied()
        .filter_map(|candidate| {
            let name = candidate.to_lowercase();
            let slips = edit_distance(&lower, &name);
            let unit_missing = name.strip_prefix(&lower).is_some_and(|rest| rest.starts_with('_'));
            let same_stem = stem(&lower) == stem(&name);
            (unit_missing || same_stem || slips <= 2).then_some((!unit_missing, slips, candidate))
        })
        .min()
        .map(|(_, _, candidate)| candidate)
}

/// Levenshtein distance. Both words are short: keys longer than any known one are cut.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().take(64).collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().take(64).enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(row[j + 1] + 1);
        }
    }
    row[b.len()]
}

/// The JSON Schema of instrument files, pretty-printed, with a final newline: what `instruments/instrument.schema.json`
/// holds. Generated from the structs that read the file.
pub fn json_schema() -> String {
    let schema =
        schemars::generate::SchemaSettings::draft07().into_generator().into_root_schema_for::<InstrumentToml>();
    let sorted: BTreeMap<String, serde_json::Value> =
        schema.as_object().map(|object| object.clone().into_iter().collect()).unwrap_or_default();
    serde_json::to_string_pretty(&sorted).unwrap_or_default() + "\n"
}

//! The argument that names an instrument: a file, a built-in one by its name, or a key of a keyboard.

use std::path::Path;

use thiserror::Error;

use crate::files::shown;
use crate::instrument::{FileError, Instrument, UnknownInstrument, file_bytes, utf8};
use crate::keyboard::{KEYS, Keyboard, is_keyboard, key_named};

/// Text between a keyboard and the number or note of a key, as in `concert-grand:key=88`.
pub const KEY: &str = ":key=";

/// Text before the number of a sample, as in `concert-grand:sample=17`.
pub const SAMPLE: &str = ":sample=";
/// The last sample.
pub(crate) const LAST_SAMPLE: u32 = 1_000_000;

/// Splits `:sample=N`, before or after `:key=N`, from the rest of the argument.
///
/// # Errors
/// [`InstrumentSpecError::NoSample`].
pub fn split_sample(asked: &str) -> Result<(String, Option<u32>), InstrumentSpecError> {
    let Some((before, rest)) = asked.split_once(SAMPLE) else { return Ok((asked.to_owned(), None)) };
    let (number, after) = rest.find(':').map_or((rest, ""), |end| rest.split_at(end));
    let sample = number.parse().ok().filter(|sample| (1..=LAST_SAMPLE).contains(sample));
    let is_known = (after.is_empty() || after.starts_with(KEY)) && !before.is_empty();
    match sample.filter(|_| is_known) {
        Some(sample) => Ok((format!("{before}{after}"), Some(sample))),
        None => Err(InstrumentSpecError::NoSample { asked: asked.to_owned(), sample: format!("{number}{after}") }),
    }
}

/// An instrument as a user names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum InstrumentSpec<'a> {
    /// A file.
    File(&'a Path),
    /// A built-in instrument or keyboard, by its name.
    Builtin(&'a str),
    /// A key of a keyboard, which is a file or a built-in one.
    Key {
        /// The keyboard.
        keyboard: &'a str,
        /// Number of the key, from 1.
        key: usize,
    },
}

/// Why there is no such instrument.
#[derive(Debug, Error)]
pub enum InstrumentSpecError {
    /// No such key.
    #[error("{asked}: found key `{key}`; expected a number from 1 to {KEYS}, or a note from A0 to C8")]
    NoKey {
        /// Specification as given.
        asked: String,
        /// Text in place of the number.
        key: String,
    },
    /// No such sample.
    #[error(
        "{asked}: found sample `{sample}`; expected a number from 1 to {LAST_SAMPLE}, e.g. concert-grand{SAMPLE}17 or concert-grand{KEY}88{SAMPLE}17"
    )]
    NoSample {
        /// Specification as given.
        asked: String,
        /// Text in place of the number.
        sample: String,
    },
    /// A sample where only files and names are understood.
    #[error("{asked}: only the command draws samples. Write one as a file: `erard list {asked} > sample.toml`")]
    Sampled {
        /// Specification as given.
        asked: String,
    },
    /// A keyboard has many instruments.
    #[error("{file}: is a keyboard; expected an instrument. Name one of its keys: {file}{KEY}40")]
    IsKeyboard {
        /// The file.
        file: String,
    },
    /// No such keyboard.
    #[error("there is no file and no built-in keyboard `{name}` (built in: {})", Keyboard::builtin_names().collect::<Vec<_>>().join(", "))]
    UnknownKeyboard {
        /// The name.
        name: String,
    },
    /// No such instrument.
    #[error(transparent)]
    Unknown(#[from] UnknownInstrument),
    /// A file that cannot be read, or in which something is wrong.
    #[error(transparent)]
    File(#[from] Box<FileError>),
}

impl<'a> InstrumentSpec<'a> {
    /// Parses a specification. A name that exists as a file, or has an extension or a folder, is a file.
    ///
    /// # Errors
    /// [`InstrumentSpecError::NoKey`], [`InstrumentSpecError::NoSample`], [`InstrumentSpecError::Sampled`].
    pub fn of(asked: &'a str) -> Result<Self, InstrumentSpecError> {
        if split_sample(asked)?.1.is_some() {
            return Err(InstrumentSpecError::Sampled { asked: asked.to_owned() });
        }
        if let Some((keyboard, key)) = asked.rsplit_once(KEY) {
            let number = key_named(key);
            let no_key = || InstrumentSpecError::NoKey { asked: asked.to_owned(), key: key.to_owned() };
            return Ok(InstrumentSpec::Key { keyboard, key: number.ok_or_else(no_key)? });
        }
        let path = Path::new(asked);
        let is_file = path.exists() || path.extension().is_some() || path.components().count() > 1;
        Ok(if is_file { InstrumentSpec::File(path) } else { InstrumentSpec::Builtin(asked) })
    }

    /// The text of the instrument's file, and what messages call it. The text of a keyboard's key is made of the
    /// keyboard's.
    ///
    /// # Errors
    /// See [`InstrumentSpecError`]; the text itself is not read yet.
    pub fn text(self) -> Result<(String, String), InstrumentSpecError> {
        match self {
            InstrumentSpec::File(path) => {
                let name = shown(path);
                let bytes = file_bytes(std::fs::File::open(path), &name)?;
                let text = utf8(&bytes, &name)?;
                if is_keyboard(text) {
                    return Err(InstrumentSpecError::IsKeyboard { file: name });
                }
                Ok((text.to_owned(), name))
            }
            InstrumentSpec::Builtin(name) => match Instrument::builtin_text(name) {
                Some(text) => Ok((text.to_owned(), name.to_owned())),
                None => Err(UnknownInstrument { name: name.to_owned() }.into()),
            },
            InstrumentSpec::Key { keyboard, key } => {
                let keyboard = InstrumentSpec::of(keyboard)?.keyboard()?;
                // What is wrong with it is said of the keyboard's own lines.
                keyboard.key(key)?;
                Ok((keyboard.key_text(key), format!("{}, key {key}", keyboard.name)))
            }
        }
    }

    /// The keyboard that was asked for, or whose key was.
    ///
    /// # Errors
    /// See [`InstrumentSpecError`].
    pub fn keyboard(self) -> Result<Keyboard, InstrumentSpecError> {
        match self {
            InstrumentSpec::File(path) => Ok(Keyboard::load(path)?),
            InstrumentSpec::Builtin(name) => {
                Keyboard::builtin(name).map_err(|unknown| InstrumentSpecError::UnknownKeyboard { name: unknown.name })
            }
            InstrumentSpec::Key { keyboard, .. } => InstrumentSpec::of(keyboard)?.keyboard(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A sample stands before or behind a key; anything else is an error.
    #[test]
    fn samples_are_split_off() {
        let split = |asked: &str| split_sample(asked).map_err(|error| error.to_string());
        for asked in ["concert-grand:key=88:sample=17", "concert-grand:sample=17:key=88"] {
            assert_eq!(split(asked).unwrap(), ("concert-grand:key=88".to_owned(), Some(17)), "{asked}");
        }
        assert_eq!(split("mine.toml:sample=1").unwrap(), ("mine.toml".to_owned(), Some(1)));
        assert_eq!(split("concert-grand").unwrap(), ("concert-grand".to_owned(), None));
        for wrong in [
            "a:sample=0",
            "a:sample=",
            "a:sample=x",
            "a:sample=-1",
            "a:sample=1000001",
            "a:sample=1:sample=2",
            ":sample=3",
            "a:sample=1:keys=2",
        ] {
            assert!(split(wrong).unwrap_err().contains("from 1 to 1000000"), "{wrong}");
        }
        let told = InstrumentSpec::of("concert-grand:sample=17").unwrap_err().to_string();
        assert!(told.contains("erard list concert-grand:sample=17"), "{told}");
    }

    /// Names, files and keys are distinguished; what there is none of is named.
    #[test]
    fn what_is_asked_for() {
        assert_eq!(InstrumentSpec::of("concert-grand").unwrap(), InstrumentSpec::Builtin("concert-grand"));
        assert_eq!(InstrumentSpec::of("no/such.toml").unwrap(), InstrumentSpec::File(Path::new("no/such.toml")));
        let key = InstrumentSpec::of("concert-grand:key=40").unwrap();
        assert_eq!(key, InstrumentSpec::Key { keyboard: "concert-grand", key: 40 });
        let (text, name) = key.text().unwrap();
        assert_eq!(text, Keyboard::builtin("concert-grand").unwrap().key_text(40));
        assert!(name.ends_with("key 40"), "{name}");
        assert!(InstrumentSpec::of("concert-grand:key=89").unwrap_err().to_string().contains("from 1 to 88"));
        for (wrong, told) in [
            ("steinway", "no built-in instrument `steinway`"),
            ("steinway:key=3", "no built-in keyboard `steinway`"),
            ("no/such.toml", "no/such.toml"),
        ] {
            let error = InstrumentSpec::of(wrong).unwrap().text().unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }
}

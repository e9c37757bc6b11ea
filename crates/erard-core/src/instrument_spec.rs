//! The text that names an instrument: a file, a built-in one by its name, or a key of a keyboard; or one random sample
//! of these.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use thiserror::Error;

use crate::files::shown;
use crate::instrument::{FileError, Instrument, UnknownInstrument, file_bytes, utf8};
use crate::key::{EXPECTED, KEYS, UnknownKey, key_named, keys_named};
use crate::keyboard::{Keyboard, is_keyboard};

/// Text between a keyboard and the number or note of a key, as in `concert-grand:key=88`.
pub const KEY: &str = ":key=";
/// Text before the number of a sample, as in `concert-grand:sample=17`.
pub const SAMPLE: &str = ":sample=";
/// The last sample.
pub(crate) const LAST_SAMPLE: u32 = 1_000_000;

/// An instrument as a user names it, read once: `concert-grand:key=A0:sample=17` and
/// `concert-grand:sample=17:key=1` are equal. It is displayed with the key's number, the key before the sample.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct InstrumentSpec {
    base: Base,
    key: Option<usize>,
    sample: Option<u32>,
}

/// The instrument or keyboard before the key and the sample.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Base {
    /// A file.
    File(PathBuf),
    /// A built-in instrument or keyboard, by its name.
    Builtin(String),
}

/// Why there is no such instrument.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum InstrumentSpecError {
    /// No such key.
    #[error("{asked}: found key `{key}`; expected {EXPECTED}")]
    NoKey {
        /// Specification as given.
        asked: String,
        /// Text in place of the number.
        key: String,
    },
    /// A list of keys that holds something else.
    #[error(
        "{asked}: found keys `{key}`; expected keys from 1 to {KEYS} or notes from A0 to C8, as in `1..88`, `1,40,88` or `C4`"
    )]
    NoKeys {
        /// Specification as given.
        asked: String,
        /// The part of the list that names no key.
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

/// The parts of a specification, as text.
struct Parts<'a> {
    base: &'a str,
    key: Option<&'a str>,
    sample: Option<&'a str>,
}

impl<'a> Parts<'a> {
    fn of(asked: &'a str) -> Result<Self, InstrumentSpecError> {
        let begins = |text: &str| [KEY, SAMPLE].iter().filter_map(|part| text.find(part)).min().unwrap_or(text.len());
        let (base, mut rest) = asked.split_at(begins(asked));
        let mut parts = Parts { base, key: None, sample: None };
        while !rest.is_empty() {
            let (what, place) = if rest.starts_with(KEY) { (KEY, &mut parts.key) } else { (SAMPLE, &mut parts.sample) };
            let given = &rest[what.len()..];
            let (text, after) = given.split_at(begins(given));
            if place.replace(text).is_some() {
                let (asked, given) = (asked.to_owned(), rest.to_owned());
                return Err(match what {
                    KEY => InstrumentSpecError::NoKey { asked, key: given },
                    _ => InstrumentSpecError::NoSample { asked, sample: given },
                });
            }
            rest = after;
        }
        Ok(parts)
    }

    /// The specification of one key of those that the text names, or of none.
    fn spec(&self, asked: &str, key: Option<usize>) -> Result<InstrumentSpec, InstrumentSpecError> {
        let number = |text: &str| text.parse().ok().filter(|sample| (1..=LAST_SAMPLE).contains(sample));
        let sample =
            match self.sample {
                Some(text) => Some(number(text).filter(|_| !self.base.is_empty()).ok_or_else(|| {
                    InstrumentSpecError::NoSample { asked: asked.to_owned(), sample: text.to_owned() }
                })?),
                None => None,
            };
        Ok(InstrumentSpec { base: self.base.into(), key, sample })
    }
}

impl From<&str> for Base {
    /// A name that exists as a file, or has an extension or a folder, is a file.
    fn from(text: &str) -> Self {
        let path = Path::new(text);
        let is_file = path.exists() || path.extension().is_some() || path.components().count() > 1;
        if is_file { Base::File(path.to_owned()) } else { Base::Builtin(text.to_owned()) }
    }
}

impl fmt::Display for Base {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Base::File(path) => path.display().fmt(f),
            Base::Builtin(name) => f.write_str(name),
        }
    }
}

impl fmt::Display for InstrumentSpec {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.base.fmt(f)?;
        if let Some(key) = self.key {
            write!(f, "{KEY}{key}")?;
        }
        match self.sample {
            Some(sample) => write!(f, "{SAMPLE}{sample}"),
            None => Ok(()),
        }
    }
}

impl FromStr for InstrumentSpec {
    type Err = InstrumentSpecError;

    /// Reads a specification.
    ///
    /// # Errors
    /// [`InstrumentSpecError::NoKey`], [`InstrumentSpecError::NoSample`].
    fn from_str(asked: &str) -> Result<Self, InstrumentSpecError> {
        let parts = Parts::of(asked)?;
        let no_key = |key: &str| InstrumentSpecError::NoKey { asked: asked.to_owned(), key: key.to_owned() };
        let key = parts.key.map(|text| key_named(text).ok_or_else(|| no_key(text))).transpose()?;
        parts.spec(asked, key)
    }
}

impl InstrumentSpec {
    /// Reads a specification that may name many keys (`concert-grand:key=1..88`, `:key=1,A4,88`): one for each, in
    /// their order.
    ///
    /// # Errors
    /// As of [`FromStr`], and [`InstrumentSpecError::NoKeys`].
    pub fn each(asked: &str) -> Result<Vec<Self>, InstrumentSpecError> {
        let parts = Parts::of(asked)?;
        let Some(keys) = parts.key.filter(|keys| keys.contains("..") || keys.contains(',')) else {
            return Ok(vec![asked.parse()?]);
        };
        let wrong = |UnknownKey { found }| InstrumentSpecError::NoKeys { asked: asked.to_owned(), key: found };
        keys_named(keys).map_err(wrong)?.into_iter().map(|key| parts.spec(asked, Some(key))).collect()
    }

    /// The instrument, or the keyboard, before the key and the sample.
    #[must_use]
    pub fn base(&self) -> &Base {
        &self.base
    }

    /// Number of the key, 1 to 88; `None` where no key of a keyboard is named.
    #[must_use]
    pub fn key(&self) -> Option<usize> {
        self.key
    }

    /// Number of the sample, from 1; `None` where none is named.
    #[must_use]
    pub fn sample(&self) -> Option<u32> {
        self.sample
    }

    /// The instrument that the sample is one of.
    #[must_use]
    pub fn without_sample(&self) -> Self {
        InstrumentSpec { sample: None, ..self.clone() }
    }

    /// The path of an instrument's own file; `None` where a name, a key or a sample is meant.
    #[must_use]
    pub fn path(&self) -> Option<&Path> {
        match (&self.base, self.key, self.sample) {
            (Base::File(path), None, None) => Some(path),
            _ => None,
        }
    }

    /// The text of the instrument's file, and its name in messages. The text of a keyboard's key is made from the
    /// keyboard's.
    ///
    /// # Errors
    /// See [`InstrumentSpecError`]; the text itself is not read yet.
    pub fn text(&self) -> Result<(String, String), InstrumentSpecError> {
        if let Some(key) = self.key {
            let keyboard = self.keyboard()?;
            // An error names the lines of the key's own text.
            keyboard.key(key)?;
            return Ok((keyboard.key_text(key), format!("{}, key {key}", keyboard.name)));
        }
        self.refuse_sample()?;
        match &self.base {
            Base::File(path) => {
                let name = shown(path);
                let bytes = file_bytes(std::fs::File::open(path), &name)?;
                let text = utf8(&bytes, &name)?;
                if is_keyboard(text) {
                    return Err(InstrumentSpecError::IsKeyboard { file: name });
                }
                Ok((text.to_owned(), name))
            }
            Base::Builtin(name) => match Instrument::builtin_text(name) {
                Some(text) => Ok((text.to_owned(), name.clone())),
                None => Err(UnknownInstrument { name: name.clone() }.into()),
            },
        }
    }

    /// The named keyboard, or that of the named key.
    ///
    /// # Errors
    /// See [`InstrumentSpecError`].
    pub fn keyboard(&self) -> Result<Keyboard, InstrumentSpecError> {
        self.refuse_sample()?;
        match &self.base {
            Base::File(path) => Ok(Keyboard::load(path)?),
            Base::Builtin(name) => {
                Keyboard::builtin(name).map_err(|unknown| InstrumentSpecError::UnknownKeyboard { name: unknown.name })
            }
        }
    }

    fn refuse_sample(&self) -> Result<(), InstrumentSpecError> {
        match self.sample {
            Some(_) => Err(InstrumentSpecError::Sampled { asked: self.to_string() }),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(asked: &str) -> InstrumentSpec {
        asked.parse().unwrap_or_else(|error| panic!("{error}"))
    }

    /// Key and sample are read in either order, notes and numbers alike, and displayed in one form.
    #[test]
    fn one_form_of_each() {
        let shown = "concert-grand:key=1:sample=17";
        for asked in [shown, "concert-grand:sample=17:key=A0", "concert-grand:key= a0:sample=17"] {
            let spec = read(asked);
            assert_eq!((spec.to_string().as_str(), &spec), (shown, &read(shown)), "{asked}");
            assert_eq!((spec.key(), spec.sample()), (Some(1), Some(17)), "{asked}");
            assert_eq!(spec.without_sample().to_string(), "concert-grand:key=1");
        }
        for (asked, key) in
            [("a:key=C#4", 41), ("a:key=Db4", 41), ("a:key=C♯4", 41), ("a:key=c8", 88), ("a:key=40", 40)]
        {
            assert_eq!(read(asked).key(), Some(key), "{asked}");
        }
        assert_eq!(read("mine.toml:sample=1").base(), &Base::File("mine.toml".into()));
        assert_eq!((read("concert-grand").key(), read("concert-grand").sample()), (None, None));
    }

    #[test]
    fn what_is_wrong_is_named() {
        for wrong in ["a:sample=0", "a:sample=", "a:sample=x", "a:sample=-1", "a:sample=1000001", ":sample=3"] {
            let told = wrong.parse::<InstrumentSpec>().unwrap_err().to_string();
            assert!(told.contains("from 1 to 1000000"), "{told}");
        }
        for (wrong, told) in [
            ("a:sample=1:keys=2", "from 1 to 1000000"),
            ("a:sample=1:sample=2", "found sample `:sample=2`"),
            ("a:key=1:sample=2:key=3", "found key `:key=3`"),
            ("concert-grand:key=89", "from 1 to 88"),
            ("concert-grand:key=1..3", "found key `1..3`"),
        ] {
            let found = wrong.parse::<InstrumentSpec>().unwrap_err().to_string();
            assert!(found.contains(told), "{found}");
        }
        let told = read("concert-grand:sample=17").text().unwrap_err().to_string();
        assert!(told.contains("erard list concert-grand:sample=17"), "{told}");
    }

    /// Lists and ranges of keys, with a sample on either side.
    #[test]
    fn many_keys() {
        let each = |asked: &str| -> Vec<String> {
            InstrumentSpec::each(asked).unwrap().iter().map(ToString::to_string).collect()
        };
        assert_eq!(each("a:key=A0..2,C8"), ["a:key=1", "a:key=2", "a:key=88"]);
        assert_eq!(each("a:sample=5:key=1,2"), ["a:key=1:sample=5", "a:key=2:sample=5"]);
        assert_eq!(each("a"), ["a"]);
        let told = InstrumentSpec::each("a:key=80..99").unwrap_err().to_string();
        assert!(told.contains("found keys `80..99`") && told.contains("`1..88`"), "{told}");
    }

    /// Names, files and keys are distinguished; what there is none of is named.
    #[test]
    fn names_files_and_keys() {
        assert_eq!(read("concert-grand").base(), &Base::Builtin("concert-grand".into()));
        assert_eq!(read("no/such.toml").path(), Some(Path::new("no/such.toml")));
        assert_eq!(read("no/such.toml:key=3").path(), None);
        let (text, name) = read("concert-grand:key=C4").text().unwrap();
        assert_eq!(text, Keyboard::builtin("concert-grand").unwrap().key_text(40));
        assert!(name.ends_with("key 40"), "{name}");
        for (wrong, told) in [
            ("steinway", "no built-in instrument `steinway`"),
            ("steinway:key=3", "no built-in keyboard `steinway`"),
            ("no/such.toml", "no/such.toml"),
        ] {
            let error = read(wrong).text().unwrap_err().to_string();
            assert!(error.contains(told), "{error}");
        }
    }
}

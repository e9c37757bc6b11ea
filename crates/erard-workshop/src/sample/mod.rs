//! Many pianos instead of one: plausible grands around an instrument file.
//!
//! A sample is one grand. Every number of the file with a spread deviates, numbers that are `together` by the same
//! share of theirs (`draw`, `random`); then screws, friction and leads are adjusted on the bench (`bench`), as a
//! technician would: the drawn piano has the distances of the file's, a balance weight that is drawn from the usual
//! range, and a friction weight within its usual range. A grand that cannot be adjusted so is drawn again.
//!
//! A sample depends on its number and the file alone, and has the same bits on every machine: integers, `libm` and the
//! engine. Keys of one keyboard are one piano: its base instrument is drawn, graded over the keys, and each key is
//! adjusted by itself; one that cannot be is the next piano's. [`technicians_scatter`] then varies keys within what a
//! technician can read.

mod band;
mod bench;
mod draw;
mod random;
mod scatter;

pub use band::{Band, SampleValues, band, bands, failures, unless_interrupted};
pub use draw::drawn;
pub use scatter::technicians_scatter;

use erard::Progress;
use erard::instrument::{FileError, InstrumentFile};
use erard::keyboard::Keyboard;
use erard::run::SimulationError;
use thiserror::Error;

use crate::cores::Ending;
use crate::measure::MeasureError;
use bench::{Aim, Unfit};

/// Most draws of a sample until a grand can be adjusted.
const ATTEMPTS: u32 = 40;

/// Reason why there is no sample.
#[derive(Debug, Error)]
#[non_exhaustive]
pub enum SampleError {
    /// No number of the file has a spread.
    #[error("{file}: no number has a `spread` or `spread_factor`; expected one at least to draw samples from")]
    Certain {
        /// The file.
        file: String,
    },
    /// Too many grands in a row that cannot be adjusted.
    #[error(
        "{file}: none of {ATTEMPTS} samples could be regulated and weighed to the usual ranges; expected smaller spreads"
    )]
    Hopeless {
        /// The file.
        file: String,
    },
    /// The instrument is no piano action.
    #[error(transparent)]
    Measure(#[from] MeasureError),
    /// The file, or a key of it, cannot be read.
    #[error(transparent)]
    File(#[from] Box<FileError>),
    /// The caller asked to stop.
    #[error("interrupted")]
    Interrupted,
}

impl From<SimulationError> for SampleError {
    fn from(error: SimulationError) -> Self {
        match error {
            SimulationError::Interrupted => SampleError::Interrupted,
            error => SampleError::Measure(error.into()),
        }
    }
}

impl Ending for SampleError {
    fn is_interruption(&self) -> bool {
        match self {
            SampleError::Interrupted => true,
            SampleError::Measure(error) => error.is_interruption(),
            _ => false,
        }
    }
}

/// Base of the samples.
#[derive(Debug, Clone)]
pub struct Sampled {
    /// Name in messages.
    name: String,
    base: InstrumentFile,
    base_text: String,
    base_aim: Aim,
    /// For samples of a key: the keyboard, the key, and its target.
    key: Option<(Keyboard, usize, Aim)>,
}

impl Sampled {
    /// Makes samples of an instrument file.
    ///
    /// # Errors
    /// See [`SampleError`].
    pub fn of_file(text: &str, name: &str, progress: &mut Progress<'_>) -> Result<Self, SampleError> {
        let base = InstrumentFile::parse(text, name)?;
        let base_aim = Aim::of(&base.instrument, progress)?;
        Ok(Sampled { name: name.to_owned(), base, base_text: text.to_owned(), base_aim, key: None })
    }

    /// Makes samples of a key, as part of the whole keyboard's piano.
    ///
    /// # Errors
    /// See [`SampleError`].
    pub fn of_key(keyboard: &Keyboard, key: usize, progress: &mut Progress<'_>) -> Result<Self, SampleError> {
        let of_base = Self::of_file(keyboard.base_text(), &keyboard.name, progress)?;
        let aim = Aim::of(&keyboard.key(key)?, progress)?;
        Ok(Sampled { key: Some((keyboard.clone(), key, aim)), ..of_base })
    }

    /// Returns the text of a sample's instrument file, counted from 1. `progress` ends the work by returning false.
    ///
    /// A key of which the sample's piano cannot be put right is that of the piano that is drawn next: at the ends of
    /// the keyboard some pianos' slow keys stick at let-off.
    ///
    /// # Errors
    /// See [`SampleError`].
    pub fn text(&self, sample: u32, progress: &mut Progress<'_>) -> Result<String, SampleError> {
        let mut attempt = 0;
        loop {
            let (base, drawn) = self.base_text(sample, attempt, progress)?;
            let Some((keyboard, key, aim)) = &self.key else { return Ok(base) };
            match aim.put_right(&keyboard.around(base)?.key_text(*key), sample, progress) {
                Ok(right) => return Ok(named(&right, sample)),
                Err(Unfit::Implausible) => attempt = drawn + 1,
                Err(Unfit::Stopped) => return Err(SampleError::Interrupted),
            }
        }
    }

    /// Returns the text of the base instrument's sample, and the attempt at which it was drawn, `from` or a later one.
    fn base_text(&self, sample: u32, from: u32, progress: &mut Progress<'_>) -> Result<(String, u32), SampleError> {
        for attempt in from..ATTEMPTS {
            if !progress(0.0) {
                return Err(SampleError::Interrupted);
            }
            let Some(drawn) = draw::drawn(&self.base, &self.base_text, sample, attempt) else {
                return Err(SampleError::Certain { file: self.name.clone() });
            };
            match self.base_aim.put_right(&drawn, sample, progress) {
                Ok(right) => return Ok((named(&right, sample), attempt)),
                Err(Unfit::Implausible) => {}
                Err(Unfit::Stopped) => return Err(SampleError::Interrupted),
            }
        }
        let key = self.key.as_ref().map_or_else(String::new, |(_, key, _)| format!(", key {key}"));
        Err(SampleError::Hopeless { file: format!("{}{key}, sample {sample}", self.name) })
    }
}

/// Returns the text with the sample's number, in its name and as its `sample`.
fn named(text: &str, sample: u32) -> String {
    let Some(name) = text.lines().find(|line| line.starts_with("name = \"")) else { return text.to_owned() };
    let new = format!("{}, sample {sample}\"", name.trim_end().trim_end_matches('"'));
    let number = format!("sample = {sample}");
    match text.lines().find(|line| line.starts_with("sample = ")) {
        Some(old) => text.replacen(name, &new, 1).replacen(old, &number, 1),
        None => text.replacen(name, &format!("{new}\n{number}"), 1),
    }
}

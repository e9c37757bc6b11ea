//! Samples of an instrument: plausible grands around its file, drawn, put right, and kept in the user's cache.

use std::sync::{Mutex, OnceLock, PoisonError};

use erard::instrument_spec::{InstrumentSpec, SAMPLE};
use erard::keyboard::Keyboard;
use erard_workshop::cores;
use erard_workshop::sample::{SampleError, Sampled};

use crate::cache;
use crate::failure::Failure;
use crate::progress::Progress;

/// What cached samples are called.
const KIND: &str = "sample";

/// Where samples come from.
pub(crate) struct Samples {
    /// What was asked for, without a sample.
    asked: String,
    source: Source,
    /// Made when a sample is not in the cache, once: whoever comes meanwhile waits.
    sampled: OnceLock<Sampled>,
    making: Mutex<()>,
}

pub(super) enum Source {
    Text(String),
    /// A keyboard, and one of its keys.
    Key(Box<Keyboard>, usize),
}

impl Samples {
    /// Samples of a source; `asked` is what they are samples of.
    pub(super) fn of(asked: String, source: Source) -> Self {
        Samples { asked, source, sampled: OnceLock::new(), making: Mutex::new(()) }
    }

    /// The text of one sample's instrument file.
    pub(crate) fn text(&self, sample: u32, progress: &mut erard::Progress<'_>) -> Result<String, SampleError> {
        let number = sample.to_string();
        let (base, key) = match &self.source {
            Source::Text(text) => (text.clone(), String::new()),
            // A key's own text holds its keyboard's gradings; the base is what is drawn.
            Source::Key(keyboard, key) => (keyboard.base_text().to_owned(), keyboard.key_text(*key)),
        };
        let of = [base.as_str(), key.as_str(), &number];
        if let Some(text) = cache::get(KIND, &of) {
            return Ok(text);
        }
        let text = self.sampled(progress)?.text(sample, progress)?;
        cache::put(KIND, &of, &text);
        Ok(text)
    }

    fn sampled(&self, progress: &mut erard::Progress<'_>) -> Result<&Sampled, SampleError> {
        let _alone = self.making.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(made) = self.sampled.get() {
            return Ok(made);
        }
        let made = match &self.source {
            Source::Text(text) => Sampled::of_file(text, &self.asked, progress)?,
            Source::Key(keyboard, key) => Sampled::of_key(keyboard, *key, progress)?,
        };
        Ok(self.sampled.get_or_init(|| made))
    }

    /// Does something with each of the first so many samples, on all cores; the results, in the order of the samples.
    pub(crate) fn each<T: Send>(
        &self,
        count: u32,
        progress: &mut Progress,
        work: impl Fn(u32, &str, &mut erard::Progress<'_>) -> Result<T, SampleError> + Sync,
    ) -> Result<Vec<T>, Failure> {
        progress.say("sampling");
        let numbers: Vec<u32> = (1..=count).collect();
        let found = cores::map(&numbers, cores::count(), &mut |share| progress.tell(share), |sample, progress| {
            let text = self.text(*sample, progress)?;
            work(*sample, &text, progress)
        });
        found.map_err(|error| self.failed(error))
    }

    fn failed(&self, error: SampleError) -> Failure {
        failed(&self.asked, error)
    }
}

/// Refuses one sample where many are drawn.
pub(crate) fn not_one_sample(asked: &InstrumentSpec) -> Result<(), Failure> {
    match asked.sample() {
        Some(_) => Err(Failure::Usage(format!("{asked}: is one sample; --bands needs many. Remove `{SAMPLE}N`"))),
        None => Ok(()),
    }
}

pub(super) fn failed(asked: &str, error: SampleError) -> Failure {
    match error {
        SampleError::Interrupted => Failure::from(erard::run::SimulationError::Interrupted),
        SampleError::Measure(error) if error.is_interruption() => {
            Failure::from(erard::run::SimulationError::Interrupted)
        }
        SampleError::Measure(error) => Failure::Measure { label: asked.to_owned(), error: Box::new(error) },
        error => Failure::Usage(error.to_string()),
    }
}

//! Samples of an instrument: plausible grands around its file, drawn, put right, and kept in the user's cache.

use std::sync::{Mutex, OnceLock, PoisonError};

use erard::instrument_spec::{InstrumentSpec, SAMPLE};
use erard::keyboard::Keyboard;
use erard_workshop::cores;
use erard_workshop::sample::{SampleError, Sampled};

use super::options::{KeyboardKey, load_instrument_and_text};
use crate::cache;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::session::Session;

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

enum Source {
    Text(String),
    Key(KeyboardKey),
}

impl Samples {
    /// Samples of what the user asked for: an instrument, or a key of a keyboard.
    pub(crate) fn of(session: &mut Session, asked: &InstrumentSpec) -> Result<Self, Failure> {
        not_one_sample(asked)?;
        let source = match KeyboardKey::asked(session, asked)? {
            Some(key) => Source::Key(key),
            None => Source::Text(load_instrument_and_text(session, asked)?.1),
        };
        Ok(Samples { asked: asked.to_string(), source, sampled: OnceLock::new(), making: Mutex::new(()) })
    }

    /// The text of one sample's instrument file.
    pub(crate) fn text(&self, sample: u32, progress: &mut erard::Progress<'_>) -> Result<String, SampleError> {
        let number = sample.to_string();
        let (base, key) = match &self.source {
            Source::Text(text) => (text.clone(), String::new()),
            // A key's own text holds its keyboard's gradings; the base is what is drawn.
            Source::Key(KeyboardKey { keyboard, key }) => (keyboard.base_text().to_owned(), keyboard.key_text(*key)),
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
            Source::Key(KeyboardKey { keyboard, key }) => Sampled::of_key(keyboard, *key, progress)?,
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

/// A sample of a keyboard: its base instrument drawn and put right, its gradings around that.
pub(crate) fn keyboard_sample(
    session: &mut Session,
    keyboard: &Keyboard,
    name: &str,
    sample: u32,
) -> Result<Keyboard, Failure> {
    let source = Source::Text(keyboard.base_text().to_owned());
    let samples = Samples { asked: name.to_owned(), source, sampled: OnceLock::new(), making: Mutex::new(()) };
    let mut progress = session.progress("drawing a sample");
    let text = samples.text(sample, &mut |_| progress.tell(0.0)).map_err(|error| failed(name, error))?;
    session.provenance.used("instrument", &format!("{name}{SAMPLE}{sample}"), None, text.as_bytes());
    Ok(keyboard.around(text)?)
}

/// Refuses one sample where many are drawn.
pub(crate) fn not_one_sample(asked: &InstrumentSpec) -> Result<(), Failure> {
    match asked.sample() {
        Some(_) => Err(Failure::Usage(format!("{asked}: is one sample; --bands needs many. Remove `{SAMPLE}N`"))),
        None => Ok(()),
    }
}

/// The text of the sample that is named.
pub(crate) fn sample_text(session: &mut Session, asked: &InstrumentSpec) -> Result<String, Failure> {
    let Some(sample) = asked.sample() else { return Err(Failure::Internal(format!("{asked}: names no sample"))) };
    let mut progress = session.progress("drawing a sample");
    let samples = Samples::of(session, &asked.without_sample())?;
    samples.text(sample, &mut |_| progress.tell(0.0)).map_err(|error| failed(&asked.to_string(), error))
}

fn failed(asked: &str, error: SampleError) -> Failure {
    match error {
        SampleError::Interrupted => Failure::from(erard::run::SimulationError::Interrupted),
        SampleError::Measure(error) if error.is_interruption() => {
            Failure::from(erard::run::SimulationError::Interrupted)
        }
        SampleError::Measure(error) => Failure::Measure { label: asked.to_owned(), error: Box::new(error) },
        error => Failure::Usage(error.to_string()),
    }
}

//! Instruments and keyboards as a user asks for them: files, built-in names, keys of a keyboard, samples.

mod sampled;

use std::path::Path;

use erard::instrument::{Instrument, InstrumentFile, utf8};
use erard::instrument_spec::{Base, InstrumentSpec, KEY, SAMPLE};
use erard::keyboard::{Keyboard, is_keyboard};
use erard_figures::drawing::ChangedNote;

use crate::failure::Failure;
use crate::session::Session;
use crate::suggest::meant;
pub(crate) use sampled::{Samples, not_one_sample};
use sampled::{Source, failed};

/// An instrument, and the numbers of its file whose notes speak of what they were.
#[derive(Debug)]
pub(crate) struct LoadedInstrument {
    /// The instrument.
    pub instrument: Instrument,
    /// The numbers; none in a built-in instrument, nor in a key of a keyboard, whose notes are written with its
    /// numbers.
    pub changed: Vec<ChangedNote>,
    /// The instrument whatever model was asked for: a level is found on it.
    pub whole: Instrument,
}

/// An instrument by file or by name; after either, `:key=N` is key N of a keyboard.
pub fn load_instrument(session: &mut Session, asked: &InstrumentSpec) -> Result<Instrument, Failure> {
    Ok(load_instrument_and_text(session, asked)?.0)
}

/// What is said of a keyboard in the place of an instrument.
pub(crate) const IS_KEYBOARD: &str = "is a keyboard; expected an instrument";

/// An instrument file and its text.
pub(crate) fn load_file(session: &mut Session, path: &Path) -> Result<(InstrumentFile, String), Failure> {
    let (name, bytes) = session.inputs.bytes(path)?;
    let text = utf8(&bytes, &name)?;
    if is_keyboard(text) {
        return Err(Failure::Usage(format!("{name}: {IS_KEYBOARD}. Name one of its keys: {name}{KEY}40")));
    }
    let file = InstrumentFile::parse(text, &name)?;
    session.provenance.used("instrument", &file.instrument.name, Some(&name), &bytes);
    Ok((file, text.to_owned()))
}

/// The same, with the text it was read from.
pub(crate) fn load_instrument_and_text(
    session: &mut Session,
    asked: &InstrumentSpec,
) -> Result<(Instrument, String), Failure> {
    if asked.sample().is_some() {
        let text = sample_text(session, asked)?;
        let instrument = Instrument::parse(&text, &asked.to_string())?;
        session.provenance.used("instrument", &instrument.name, None, text.as_bytes());
        return Ok((instrument, text));
    }
    if let Some(one) = KeyboardKey::asked(session, asked)? {
        return one.instrument(session);
    }
    match asked.base() {
        Base::File(path) => load_file(session, path).map(|(file, text)| (file.instrument, text)),
        Base::Builtin(name) => builtin_instrument(session, name),
    }
}

fn builtin_instrument(session: &mut Session, name: &str) -> Result<(Instrument, String), Failure> {
    let found = Instrument::builtin(name).ok().zip(Instrument::builtin_text(name));
    let (instrument, text) = found.ok_or_else(|| not_found("instrument", name, Instrument::builtin_names()))?;
    session.provenance.used("instrument", &instrument.name, None, text.as_bytes());
    Ok((instrument, text.to_owned()))
}

/// What was asked for by a name that nothing has.
pub(crate) fn not_found<'a>(what: &str, name: &str, known: impl Iterator<Item = &'a str>) -> Failure {
    let known: Vec<&str> = known.collect();
    let meant = meant(name, known.iter().copied());
    Failure::Usage(format!("there is no file and no built-in {what} `{name}` (built in: {}){meant}", known.join(", ")))
}

/// A key of a keyboard.
#[derive(Debug)]
pub(crate) struct KeyboardKey {
    /// The keyboard.
    pub keyboard: Keyboard,
    /// The key, from 1.
    pub key: usize,
}

impl KeyboardKey {
    /// The key of a keyboard that is named, as in `concert-grand:key=88`; `None` where none is.
    pub(crate) fn asked(session: &mut Session, asked: &InstrumentSpec) -> Result<Option<Self>, Failure> {
        let of = |key| Ok(KeyboardKey { keyboard: load_keyboard(session, asked.base())?, key });
        asked.key().map(of).transpose()
    }

    /// Its instrument, and the text of it.
    fn instrument(&self, session: &mut Session) -> Result<(Instrument, String), Failure> {
        let instrument = self.keyboard.key(self.key)?;
        let text = self.keyboard.key_text(self.key);
        session.provenance.used("instrument", &format!("{}, key {}", instrument.name, self.key), None, text.as_bytes());
        Ok((instrument, text))
    }

    /// The text of its instrument file, which is sound.
    pub(crate) fn text(&self) -> Result<String, Failure> {
        self.keyboard.key(self.key)?;
        Ok(self.keyboard.key_text(self.key))
    }
}

/// A keyboard by file or by name.
pub(crate) fn load_keyboard(session: &mut Session, asked: &Base) -> Result<Keyboard, Failure> {
    Ok(load_keyboard_and_text(session, asked)?.0)
}

/// A keyboard, and the text it was read from.
pub(crate) fn load_keyboard_and_text(session: &mut Session, asked: &Base) -> Result<(Keyboard, String), Failure> {
    match asked {
        Base::File(path) => {
            let (name, bytes) = session.inputs.bytes(path)?;
            let keyboard = Keyboard::parse_bytes(&bytes, &name, path.parent().unwrap_or(Path::new("")))?;
            keyboard.base_path().into_iter().for_each(|path| session.inputs.remember(path));
            session.provenance.used("keyboard", &keyboard.name, Some(&name), &bytes);
            Ok((keyboard, utf8(&bytes, &name)?.to_owned()))
        }
        Base::Builtin(name) => {
            let found = Keyboard::builtin(name).ok().zip(Keyboard::builtin_text(name));
            let (keyboard, text) = found.ok_or_else(|| not_found("keyboard", name, Keyboard::builtin_names()))?;
            session.provenance.used("keyboard", &keyboard.name, None, text.as_bytes());
            Ok((keyboard, text.to_owned()))
        }
    }
}

/// Samples of what the user asked for: an instrument, or a key of a keyboard.
pub(crate) fn samples(session: &mut Session, asked: &InstrumentSpec) -> Result<Samples, Failure> {
    not_one_sample(asked)?;
    let source = match KeyboardKey::asked(session, asked)? {
        Some(KeyboardKey { keyboard, key }) => Source::Key(Box::new(keyboard), key),
        None => Source::Text(load_instrument_and_text(session, asked)?.1),
    };
    Ok(Samples::of(asked.to_string(), source))
}

/// A sample of a keyboard: its base instrument drawn and put right, its gradings around that.
pub(crate) fn keyboard_sample(
    session: &mut Session,
    keyboard: &Keyboard,
    name: &str,
    sample: u32,
) -> Result<Keyboard, Failure> {
    let source = Source::Text(keyboard.base_text().to_owned());
    let samples = Samples::of(name.to_owned(), source);
    let mut progress = session.progress("drawing a sample");
    let text = samples.text(sample, &mut |_| progress.tell(0.0)).map_err(|error| failed(name, error))?;
    session.provenance.used("instrument", &format!("{name}{SAMPLE}{sample}"), None, text.as_bytes());
    Ok(keyboard.around(text)?)
}

/// The text of the sample that is named.
pub(crate) fn sample_text(session: &mut Session, asked: &InstrumentSpec) -> Result<String, Failure> {
    let Some(sample) = asked.sample() else { return Err(Failure::Internal(format!("{asked}: names no sample"))) };
    let mut progress = session.progress("drawing a sample");
    let samples = samples(session, &asked.without_sample())?;
    samples.text(sample, &mut |_| progress.tell(0.0)).map_err(|error| failed(&asked.to_string(), error))
}

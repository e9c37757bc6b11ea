//! `erard listen`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use clap::Args;
use erard::keyboard::{key_named, note_name};
use erard::run::SimulationError;
use erard_workshop::cores::{self, Ending};
use erard_workshop::listen::{HeardNote, NoteSummary, listen, summary};
use serde::Serialize;

use super::options::key;
use super::out::OutOptions;
use crate::answer::Answer;
use crate::audio::Audio;
use crate::failure::Failure;
use crate::heard::{NoteRow, PartialRow, partials_table, summary_table};
use crate::inputs::shown;
use crate::print_line;
use crate::session::Session;
use crate::table::{Table, many, spaced, three};
use crate::warn;

/// Text below the options.
const AFTER: &str = include_str!("help/listen.txt");
/// Most bytes of a recording.
const MAX_BYTES: u64 = 256 << 20;
/// Files that are held at a time, for each of the processor's cores.
const HELD: usize = 4;

/// Measures recordings of single notes: decay of the level and of each partial, inharmonicity, centroid.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Listen {
    /// Recordings of single notes, WAV or Ogg Vorbis. The note is the first one in the file's name (`A0v1.ogg`,
    /// `piano_D#4_ff.wav`, `Ds4.wav`)
    #[arg(value_name = "NOTE.wav", required = true)]
    files: Vec<PathBuf>,
    /// Key of all recordings, by number (1 to 88) or note (A0 to C8) [default: the note in the file's name]
    #[arg(long, value_name = "KEY", value_parser = key, allow_negative_numbers = true)]
    key: Option<usize>,
    #[command(flatten)]
    out: OutOptions,
}

#[derive(Debug, Serialize)]
struct Report {
    recordings: usize,
    keys: usize,
    notes: Vec<NoteRow>,
    partials: Vec<PartialRow>,
}

/// Why a recording is not measured, or that the user asked to stop.
enum Stopped {
    Interrupted,
    Refused(String),
}

impl From<SimulationError> for Stopped {
    fn from(_: SimulationError) -> Self {
        Stopped::Interrupted
    }
}

impl Ending for Stopped {
    fn is_interruption(&self) -> bool {
        matches!(self, Stopped::Interrupted)
    }
}

/// A file that has been read.
struct Read {
    name: String,
    key: usize,
    bytes: Vec<u8>,
}

impl Listen {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let keys = self.files.iter().map(|file| self.key_of(file)).collect::<Result<Vec<usize>, Failure>>()?;
        let certain = ["listen.json", "recordings.csv", "recordings-partials.csv", "notes.csv", "notes-partials.csv"];
        let mut output = self.out.prepare(session, "listen", &certain)?;
        let heard = self.listen(session, &keys)?;

        let mut by_key: BTreeMap<usize, Vec<HeardNote>> = BTreeMap::new();
        for (_, note) in &heard {
            by_key.entry(note.key).or_default().push(note.clone());
        }
        let summaries: Vec<NoteSummary> = by_key.values().filter_map(|notes| summary(notes)).collect();
        let report = Report {
            recordings: heard.len(),
            keys: summaries.len(),
            notes: heard.iter().map(|(name, note)| NoteRow::of(name, note)).collect(),
            partials: heard.iter().flat_map(|(name, note)| PartialRow::all(name, note)).collect(),
        };
        output.json(session, "listen.json", &report)?;
        output.table(session, "recordings.csv", &Table::of_records(&report.notes)?)?;
        output.table(session, "recordings-partials.csv", &Table::of_records(&report.partials)?)?;
        output.table(session, "notes.csv", &summary_table(&summaries))?;
        output.table(session, "notes-partials.csv", &partials_table(&summaries))?;
        let written = output.commit(session)?;

        print_line!(session, "{} of {}", many(report.recordings, "recording"), many(report.keys, "key"));
        if summaries.len() > FIRST_KEYS {
            let some = spaced(summaries.len(), FIRST_KEYS).into_iter().map(|at| summaries[at].clone());
            let first: Vec<String> = printed(&some.collect::<Vec<_>>()).lines();
            Answer::begin_with_part(session, &first, "a row for each key");
        } else {
            print_line!(session);
        }
        print_line!(session, "{}", printed(&summaries));
        for (name, note) in heard.iter().filter(|(_, note)| note.clipped > 0) {
            warn!(
                session,
                "warning: {name}: clipped, {} samples at full scale: level, peak and centroid are too small",
                note.clipped
            );
        }
        Ok(Answer::of(&report)?.end(session, &written))
    }

    /// The key of a file.
    fn key_of(&self, file: &Path) -> Result<usize, Failure> {
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        self.key.or_else(|| key_in(&stem)).ok_or_else(|| {
            Failure::Usage(format!(
                "{}: no note in the file's name; expected one from A0 to C8, as in `C4.wav`, or --key C4",
                shown(file)
            ))
        })
    }

    /// What was heard in each file, in their order, with the file's name without its folder.
    fn listen(&self, session: &mut Session, keys: &[usize]) -> Result<Vec<(String, HeardNote)>, Failure> {
        let threads = cores::count();
        let mut heard = Vec::new();
        let mut progress = session.progress("listening");
        let count = self.files.len() as f64;
        for (files, keys) in self.files.chunks(HELD * threads).zip(keys.chunks(HELD * threads)) {
            let mut held = Vec::new();
            for (file, key) in files.iter().zip(keys) {
                held.push(Read { name: shown(file), key: *key, bytes: bytes(session, file)? });
            }
            let done = heard.len() as f64 / count;
            let share = held.len() as f64 / count;
            let found = cores::map(&held, threads, &mut |part| progress.tell(done + share * part), |one, _| {
                let audio =
                    Audio::decode(&one.bytes).map_err(|error| Stopped::Refused(format!("{} {error}", one.name)))?;
                let note = listen(&audio.channels, audio.rate_hz, one.key);
                note.map_err(|error| Stopped::Refused(format!("{}: {error}", one.name)))
            });
            let found = found.map_err(|stopped| match stopped {
                Stopped::Interrupted => Failure::Simulation(SimulationError::Interrupted),
                Stopped::Refused(message) => Failure::Usage(message),
            })?;
            let name = |file: &PathBuf| shown(Path::new(file.file_name().unwrap_or_default()));
            heard.extend(files.iter().map(name).zip(found));
        }
        Ok(heard)
    }
}

/// The bytes of a recording.
fn bytes(session: &mut Session, file: &Path) -> Result<Vec<u8>, Failure> {
    let name = shown(file);
    let unread = |error: std::io::Error| Failure::Usage(format!("{name}: cannot be read: {error}"));
    let bytes = session.inputs.beginning(file, MAX_BYTES + 1).map_err(unread)?;
    if bytes.len() as u64 > MAX_BYTES {
        let limit = MAX_BYTES >> 20;
        return Err(Failure::Usage(format!(
            "{name}: larger than {limit} MiB; expected the recording of a single note"
        )));
    }
    session.provenance.used("recording", &name, Some(&name), &bytes);
    Ok(bytes)
}

/// The key of the first note in a name: a letter that begins a word, an accidental (`#`, `b`, or `s` for sharp), and an
/// octave that does not continue as a longer number.
fn key_in(name: &str) -> Option<usize> {
    let letters: Vec<char> = name.replace('♯', "#").replace('♭', "b").chars().collect();
    let starts = (0..letters.len()).filter(|at| *at == 0 || !letters[at - 1].is_alphanumeric());
    starts
        .filter_map(|at| {
            let mut note = String::from(letters[at]);
            let mut next = at + 1;
            match letters.get(next) {
                Some('#' | 's') => note.push('#'),
                Some('b') => note.push('b'),
                _ => next -= 1,
            }
            next += 1;
            note.push(*letters.get(next).filter(|letter| letter.is_ascii_digit())?);
            let is_longer = letters.get(next + 1).is_some_and(char::is_ascii_digit);
            if is_longer || note.starts_with(|first: char| first.is_ascii_digit()) { None } else { key_named(&note) }
        })
        .next()
}

/// Keys in the first lines of an answer.
const FIRST_KEYS: usize = 5;

/// A line for each key.
fn printed(notes: &[NoteSummary]) -> Table<'static> {
    let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), three);
    let cells = notes.iter().map(|note| {
        let median = |spread: Option<erard_workshop::listen::Spread>| number(spread.map(|one| one.median));
        let [two, one, beats] = note.decay.shapes;
        [
            note_name(note.key),
            note.level_db.count.to_string(),
            note.fall_s.map(median).join("/"),
            format!("{}/{}", median(note.decay.first_db_per_s), median(note.decay.late_db_per_s)),
            format!("{two}/{one}/{beats}"),
            median(note.inharmonicity.map(|b| erard_workshop::listen::Spread { median: 1e4 * b.median, ..b })),
            format!("{:.0}", note.centroid_hz.median),
            number(note.centroid_slope.map(|slope| slope[0])),
        ]
    });
    let heads =
        ["", "files", "t10/20/40 s", "dB/s early/late", "2 stages/line/beats", "B x 1e4", "centroid Hz", "oct/10 dB"];
    Table::of(heads, cells)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_note_is_in_the_name() {
        let named = |name: &str| key_in(name).map(note_name);
        for (name, note) in [
            ("A0v1", "A0"),
            ("D#1v16", "D#1"),
            ("Ds1-soft", "D#1"),
            ("piano_Eb4_ff", "D#4"),
            ("2 C4", "C4"),
            ("c8", "C8"),
            ("take 3 F♯2", "F#2"),
            ("grand-B4", "B4"),
        ] {
            assert_eq!(named(name).as_deref(), Some(note), "{name}");
        }
        for name in ["", "grand", "take4", "A440", "H4", "C9", "ABC4", "4", "b"] {
            assert_eq!(named(name), None, "{name}");
        }
    }
}

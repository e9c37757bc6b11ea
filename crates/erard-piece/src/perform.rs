//! A performance: all keys of a score, each a job of its own.

use std::collections::BTreeMap;
use std::io;

use erard::Progress;
use erard::damper::DamperHeights;
use erard::instrument::Instrument;
use erard_workshop::cores;

use crate::error::PerformError;
use crate::key_score::{KeyPlayed, play_key};
use crate::moment::Moment;
use crate::note::{Played, Reason, Summary};
use crate::options::Options;
use crate::score::Score;
use crate::sink::Sink;

/// The outcome of a score.
#[derive(Debug)]
pub struct Performance {
    /// The notes, in the score's order.
    pub notes: Vec<Played>,
    /// Notes kept for viewing, in the score's order.
    pub moments: Vec<Moment>,
    /// The keys that were played, from 1, with the height at which each sets its damper down, m.
    pub dampers: BTreeMap<usize, f64>,
    /// Steps of all keys, trials included.
    pub steps: u64,
    /// Length of a step, s.
    pub step_s: f64,
}

impl Performance {
    /// All notes together.
    #[must_use]
    pub fn summary(&self) -> Summary {
        Summary::of(&self.notes)
    }

    /// Largest hammer speed that a hand reached, m/s, for each key, from 1, with a note that required more: its key was
    /// at rest, and it was softer than written by more than a count.
    #[must_use]
    pub fn ceilings(&self) -> BTreeMap<usize, f64> {
        let mut ceilings = BTreeMap::new();
        for note in self.notes.iter().filter(|note| note.from_home) {
            for reason in note.reasons() {
                if let Reason::TooLoud { reached_m_per_s } = reason {
                    let most = ceilings.entry(note.wanted.key).or_insert(reached_m_per_s);
                    *most = reached_m_per_s.max(*most);
                }
            }
        }
        ceilings
    }
}

/// One key's job.
struct Job<'a> {
    key: usize,
    instrument: &'a Instrument,
    notes: Vec<usize>,
}

/// Performs a score: each key with its own action of the instrument at its number less one. `sinks` makes the sink for
/// a key's rows and sound. `progress` receives the share of keys that are done, and ends the work by returning false.
///
/// # Errors
/// See [`PerformError`].
pub fn perform(
    score: &Score<'_>,
    instruments: &[Instrument],
    options: &Options,
    sinks: &(dyn Fn(usize) -> io::Result<Box<dyn Sink>> + Sync),
    progress: &mut Progress<'_>,
) -> Result<Performance, PerformError> {
    let mut notes: BTreeMap<usize, Vec<usize>> = BTreeMap::new();
    for (number, note) in score.notes.iter().enumerate() {
        notes.entry(note.key).or_default().push(number);
    }
    let jobs = notes.into_iter().map(|(key, notes)| {
        let instrument = instruments.get(key - 1).ok_or(PerformError::NoInstrument { key })?;
        Ok(Job { key, instrument, notes })
    });
    let mut jobs = jobs.collect::<Result<Vec<Job<'_>>, PerformError>>()?;
    // The longest first, so that no core waits for it at the end.
    jobs.sort_by_key(|job| (std::cmp::Reverse(job.notes.len()), job.key));
    let dampers = DamperHeights::new(instruments);
    let played = cores::map(&jobs, options.threads, progress, |job, progress| {
        let damper_m = dampers.of(job.key)?;
        let mut sink = sinks(job.key)?;
        let key = (job.key, job.instrument, damper_m);
        let played = play_key(key, score, &job.notes, options, sink.as_mut(), progress)?;
        Ok::<_, PerformError>((job.key, damper_m, played))
    })?;
    Ok(gather(played))
}

fn gather(played: Vec<(usize, f64, KeyPlayed)>) -> Performance {
    let (mut notes, mut moments, mut dampers) = (Vec::new(), Vec::new(), BTreeMap::new());
    let (mut steps, mut step_s) = (0, 0.0);
    for (key, damper_m, one) in played {
        notes.extend(one.notes);
        moments.extend(one.moments);
        dampers.insert(key, damper_m);
        (steps, step_s) = (steps + one.steps, one.step_s);
    }
    notes.sort_by_key(|(number, _)| *number);
    moments.sort_by_key(|moment| moment.note);
    Performance { notes: notes.into_iter().map(|(_, note)| note).collect(), moments, dampers, steps, step_s }
}

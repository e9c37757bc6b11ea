//! Comparison of an instrument with measurements on real pianos.
//!
//! `published` is the table: one row per published number, with its source, its certainty and the range that counts as
//! met. `presses` and `touches` simulate what the technician's sheet ([`crate::measure`]) lacks: the order of events
//! against loudness, under constant forces and under a hand, and pressed against struck keys. [`validate`] compares
//! both, and reports misses as misses. `cases` diagnoses published pianos and compares the answers with what was
//! concluded or found. [`sounds`] compares notes with those of a recorded piano.

mod cases;
mod grands;
mod keys;
mod presses;
mod published;
pub mod release;
mod repeats;
mod sound;
mod strings;
mod touches;
mod values;

pub use cases::{Basis, Case, CaseKey, CaseResult, CaseUse, CaseVerdict, Cases, NOTHING, Reading};
pub use grands::{BesideGrands, Timing, fastest_s, grands, published_ms};
pub use presses::{Drive, Loudness, SimulatedPress, measure as loudness};
pub use published::{Published, PublishedError, PublishedKind, PublishedRow};
pub use sound::{
    FALLS_DB, RecordedNote, SPEED_M_PER_S as SOUND_SPEED_M_PER_S, SoundError, SoundMeasures, SoundRow, SoundUse,
    SoundVerdict, heard, recorded_notes, sounds, verdicts,
};
pub use strings::Skipped;
pub use values::names;

use crate::diagnose::Bench;
use crate::measure::flex::{key_flex_m_per_n, shank_flex_m_per_n};
use crate::measure::{MeasureError, measure};
use erard::Progress;
use erard::instrument::Instrument;
use erard::keyboard::Keyboard;
use strings::Strung;
use values::{Flex, Simulated};

/// Number of met rows of one group and kind, and of those judged.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Tally {
    /// Rows met.
    pub met: usize,
    /// Rows met or missed, or whose event did not happen.
    pub judged: usize,
}

/// A group of rows.
#[derive(Debug, Clone, PartialEq)]
pub struct GroupResult {
    /// Name of the group.
    pub name: String,
    /// Title.
    pub title: String,
    /// Rows to which the instrument was set.
    pub set: Tally,
    /// Rows that follow from the model.
    pub predicted: Tally,
    /// Root mean square of z over its predicted rows with two ends: distance from the middle of the range over half its
    /// width, 1 at its ends.
    pub z: Option<f64>,
    /// The same over its set rows.
    pub z_set: Option<f64>,
}

/// Verdict on a simulated value against a published one.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Verdict {
    /// Within the published range.
    Met {
        /// Simulated value, in the row's unit.
        simulated: f64,
    },
    /// Outside the published range.
    Missed {
        /// Simulated value, in the row's unit.
        simulated: f64,
        /// Distance from the range, in the row's unit; negative if too small.
        by: f64,
    },
    /// The event did not happen in the simulation.
    Absent,
    /// No range was published.
    Open {
        /// Simulated value, in the row's unit.
        simulated: f64,
    },
    /// The model has no corresponding value.
    Silent,
    /// This instrument has no corresponding value.
    Skipped(Skipped),
}

impl Verdict {
    /// Simulated value, in the row's unit; `None` if there is none.
    #[must_use]
    pub fn simulated(&self) -> Option<f64> {
        match *self {
            Verdict::Met { simulated } | Verdict::Missed { simulated, .. } | Verdict::Open { simulated } => {
                Some(simulated)
            }
            Verdict::Absent | Verdict::Silent | Verdict::Skipped(_) => None,
        }
    }
}

/// Comparison of an instrument with published measurements.
#[derive(Debug, Clone, PartialEq)]
pub struct Validation {
    /// Instrument name.
    pub instrument: String,
    /// Verdicts on the rows of the table, in their order.
    pub verdicts: Vec<Verdict>,
    /// Value of every row under a constant force, in the row's unit: for comparison, not counted.
    pub beside: Vec<Option<f64>>,
    /// Presses by constant forces, soft to loud: the order of events against loudness.
    pub constant_force: Vec<SimulatedPress>,
    /// Presses by hands, soft to loud.
    pub pressed: Vec<SimulatedPress>,
    /// Timing beside three grands: pressed, soft to loud, then struck.
    pub grands: Vec<BesideGrands>,
}

/// Shares of the work: the technician's sheet, and the work after it.
const SHEET: f64 = 0.5;
const PRESSES: f64 = 0.25;
const TOUCHES: f64 = 0.05;
const GRANDS: f64 = 0.05;
const KEYS: f64 = 0.05;

/// Simulates all values needed by the table. `keyboard`: the one whose middle C is the instrument, for rows about other
/// keys. `progress` receives the share done and ends the work by returning false.
///
/// # Errors
/// See [`MeasureError`]: the instrument is no piano action, or a run failed. A missing event is no error.
pub fn validate(
    instrument: &Instrument,
    keyboard: Option<&Keyboard>,
    published: &Published,
    progress: &mut Progress<'_>,
) -> Result<Validation, MeasureError> {
    let sheet = measure(instrument, &mut |share| progress(SHEET * share))?;
    let loudness = presses::measure(instrument, &mut |share| progress(SHEET + PRESSES * share))?;
    let touches = touches::measure(instrument, &mut |share| progress(SHEET + PRESSES + TOUCHES * share))?;
    let before = SHEET + PRESSES + TOUCHES;
    let releases = release::measure(instrument, &mut |_| progress(before))?;
    let grands = grands::measure(instrument, &mut |share| progress(before + GRANDS * share))?;
    let before = before + GRANDS;
    let repeats = repeats::measure(instrument, &mut |_| progress(before))?;
    let keys = keys::measure(keyboard, &mut |share| progress(before + KEYS * share))?;
    let before = before + KEYS;
    let strung = Strung::measure(instrument, keyboard, &mut |share| progress(before + (1.0 - before) * share))?;
    let flex = Flex { key_m_per_n: key_flex_m_per_n(instrument), shank_m_per_n: shank_flex_m_per_n(instrument) };
    let bench = Bench::of(instrument)?;
    let found = Simulated { sheet, loudness, touches, releases, grands, repeats, flex, bench };
    let value = |name: &str| values::value(name, &found);
    let verdict = |row: &PublishedRow| {
        let Some(name) = row.measure.as_deref() else { return Verdict::Silent };
        match strung.value(name).or_else(|| keys::value(name, keys)) {
            Some(Ok(found)) => row.judge(found),
            Some(Err(skipped)) => Verdict::Skipped(skipped),
            None => row.judge(value(name)),
        }
    };
    let verdicts = published.rows.iter().map(verdict).collect();
    let beside = published.rows.iter().map(|row| row.beside.as_deref().and_then(value)).collect();
    Ok(Validation {
        instrument: instrument.name.clone(),
        verdicts,
        beside,
        constant_force: found.loudness.constant_force,
        pressed: found.loudness.by_hand.pressed,
        grands: found.grands,
    })
}

impl Validation {
    /// Returns the groups, in the order in which the table's rows name them.
    #[must_use]
    pub fn groups(&self, published: &Published) -> Vec<GroupResult> {
        let mut groups: Vec<GroupResult> = Vec::new();
        // Of predicted rows, and of set ones.
        let mut squares: Vec<[Vec<f64>; 2]> = Vec::new();
        for (row, verdict) in published.rows.iter().zip(&self.verdicts) {
            let at = groups.iter().position(|group| group.name == row.group).unwrap_or_else(|| {
                let title = published.groups.get(&row.group).cloned().unwrap_or_default();
                let [set, predicted] = [Tally::default(); 2];
                groups.push(GroupResult { name: row.group.clone(), title, set, predicted, z: None, z_set: None });
                squares.push(Default::default());
                groups.len() - 1
            });
            let tally = match row.kind {
                PublishedKind::Set => &mut groups[at].set,
                PublishedKind::Predicted => &mut groups[at].predicted,
            };
            tally.met += usize::from(matches!(verdict, Verdict::Met { .. }));
            tally.judged +=
                usize::from(matches!(verdict, Verdict::Met { .. } | Verdict::Missed { .. } | Verdict::Absent));
            squares[at][usize::from(row.kind == PublishedKind::Set)].extend(row.z(verdict).map(|z| z * z));
        }
        let root = |squares: &[f64]| {
            (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
        };
        for (group, [predicted, set]) in groups.iter_mut().zip(&squares) {
            (group.z, group.z_set) = (root(predicted), root(set));
        }
        groups
    }
}

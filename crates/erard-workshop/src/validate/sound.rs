//! The sound of an instrument's notes beside those of a recorded piano, measured by the same code.
//!
//! `validation/recorded-grand/` holds what `erard listen` measured of 480 recorded notes; `validation/README.md` says
//! which notes choose and which judge, and how the ranges were made.

use std::sync::LazyLock;

use erard::Progress;
use erard::instrument::Instrument;
use erard::key::key_named;
use erard::keyboard::Keyboard;
use erard::level::{HandKind, LevelError, MASS_KG, Reference};
use erard::run::{RATE_HZ, Setup, SimulationError, sound};
use erard::strings::Pedal;
use erard::stroke::Touch;

use crate::cores::{self, Ending};
use crate::listen::{DecaySummary, HeardNote, ListenError, NoteSummary, PARTIALS, Spread, listen, summary};

const NOTES: &str = include_str!("../../validation/recorded-grand/notes.csv");
const PARTIAL_ROWS: &str = include_str!("../../validation/recorded-grand/notes-partials.csv");

/// Keys whose notes choose or judge: C2 to C6.
const COMPARED: [usize; 2] = [16, 64];
/// Hammer speed of the note whose decay is compared, m/s, and its duration, s.
pub const SPEED_M_PER_S: f64 = 2.0;
const DURATION_S: f64 = 8.0;
/// Hammer speeds of the others, for the centroid over the level, m/s, and their duration after the stroke's start, s.
const OTHERS_M_PER_S: [f64; 2] = [1.0, 4.0];
const SHORT_S: f64 = 0.9;
/// Lift of the sustain pedal, m: no damper touches a string.
const PEDAL_M: f64 = 10e-3;
/// Levels to which a note falls, dB.
pub const FALLS_DB: [f64; 3] = [-10.0, -20.0, -40.0];
/// Ranges of the judged rows: ratios of modelled to recorded, and octaves per 10 dB.
pub const RATIO: [f64; 2] = [0.75, 1.33];
/// The largest mean difference of the centroid's slope, octaves per 10 dB.
pub const SLOPE: f64 = 0.1;

/// What a recorded note may be used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SoundUse {
    /// A number of the model may be chosen by these notes together.
    Choose,
    /// Compared afterwards.
    Judge,
    /// Shown; outside C2 to C6.
    Show,
}

impl SoundUse {
    /// Name in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            SoundUse::Choose => "choose",
            SoundUse::Judge => "judge",
            SoundUse::Show => "show",
        }
    }

    /// C and F sharp choose, D sharp and A judge, from C2 to C6.
    fn of(key: usize) -> Self {
        let is_compared = (COMPARED[0]..=COMPARED[1]).contains(&key);
        match (is_compared, key % 6) {
            (false, _) => SoundUse::Show,
            (true, 4) => SoundUse::Choose,
            (true, _) => SoundUse::Judge,
        }
    }
}

/// Measures of a note that are compared; `None` where there is none.
#[derive(Debug, Clone, PartialEq)]
pub struct SoundMeasures {
    /// Times to [`FALLS_DB`], s.
    pub fall_s: [Option<f64>; 3],
    /// First rate of the level, dB/s ([`crate::listen::Decay::first_db_per_s`]).
    pub early_db_per_s: Option<f64>,
    /// Late rate of a level that falls in two stages, dB/s, and the level at the break, dB.
    pub late: Option<[f64; 2]>,
    /// Centroid, Hz.
    pub centroid_hz: Option<f64>,
    /// Octaves by which the centroid rises while the level rises by 10 dB.
    pub centroid_slope: Option<f64>,
    /// Inharmonicity B.
    pub inharmonicity: Option<f64>,
    /// First partial above equal temperament, cents.
    pub cents: Option<f64>,
    /// First rate of the first partials, dB/s.
    pub partials_db_per_s: [Option<f64>; PARTIALS],
}

/// A recorded note.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedNote {
    /// Key, from 1.
    pub key: usize,
    /// What it may be used for.
    pub used: SoundUse,
    /// Medians over its recordings.
    pub measures: SoundMeasures,
    /// Within which the middle half of its recordings fall to -10, -20 and -40 dB, s.
    pub fall_quartiles_s: [Option<[f64; 2]>; 3],
}

/// A table of numbers with named columns. Lines with `#` are comments.
struct Columns {
    heads: Vec<&'static str>,
    rows: Vec<Vec<&'static str>>,
}

impl Columns {
    fn new(text: &'static str) -> Self {
        let mut lines = text.lines().filter(|line| !line.starts_with('#'));
        let cells = |line: &'static str| line.split(',').collect::<Vec<_>>();
        Columns { heads: lines.next().map(cells).unwrap_or_default(), rows: lines.map(cells).collect() }
    }

    fn at(&self, row: usize, name: &str) -> Option<&'static str> {
        let column = self.heads.iter().position(|head| *head == name)?;
        self.rows.get(row)?.get(column).copied()
    }

    fn number(&self, row: usize, name: &str) -> Option<f64> {
        self.at(row, name)?.parse().ok()
    }

    fn key(&self, row: usize) -> Option<usize> {
        key_named(self.at(row, "note")?)
    }
}

/// The recorded notes, from the lowest.
static RECORDED: LazyLock<Vec<RecordedNote>> = LazyLock::new(|| {
    let (notes, partials) = (Columns::new(NOTES), Columns::new(PARTIAL_ROWS));
    let note = |row: usize| {
        let key = notes.key(row)?;
        let of = |name: &str| notes.number(row, name);
        let partial = |index: usize| {
            let is_it = |row: &usize| {
                partials.key(*row) == Some(key) && partials.number(*row, "partial") == Some((index + 1) as f64)
            };
            (0..partials.rows.len()).find(is_it).and_then(|row| partials.number(row, "early_dB_per_s"))
        };
        Some(RecordedNote {
            key,
            used: SoundUse::of(key),
            measures: SoundMeasures {
                fall_s: ["t10_s", "t20_s", "t40_s"].map(of),
                early_db_per_s: of("early_dB_per_s"),
                late: of("late_dB_per_s").zip(of("break_dB")).map(|(rate, level)| [rate, level]),
                centroid_hz: of("centroid_Hz"),
                centroid_slope: of("centroid_octaves_per_10_dB"),
                inharmonicity: of("inharmonicity"),
                cents: of("cents"),
                partials_db_per_s: std::array::from_fn(partial),
            },
            fall_quartiles_s: ["t10_s", "t20_s", "t40_s"].map(|name| {
                let [low, high] = ["q25", "q75"].map(|quartile| of(&format!("{name}_{quartile}")));
                low.zip(high).map(|(low, high)| [low, high])
            }),
        })
    };
    (0..notes.rows.len()).filter_map(note).collect()
});

/// The recorded notes, from the lowest: medians over 16 loudnesses each.
#[must_use]
pub fn recorded_notes() -> &'static [RecordedNote] {
    &RECORDED
}

/// Why an instrument's notes cannot be heard.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SoundError {
    /// A rigid string has no sound.
    #[error(
        "the strings of {0} are rigid and have no sound; expected a keyboard with modal strings, such as concert-grand-strings"
    )]
    RigidString(String),
    /// A key cannot be built.
    #[error("key {key}: {message}")]
    Key {
        /// Key.
        key: usize,
        /// Why.
        message: String,
    },
    /// No hand reaches the hammer speed.
    #[error("key {key}: {error}")]
    Level {
        /// Key.
        key: usize,
        /// Why.
        error: Box<LevelError>,
    },
    /// A run failed.
    #[error(transparent)]
    Simulation(#[from] SimulationError),
    /// The sound cannot be measured.
    #[error("key {key}: the sound {error}")]
    Listen {
        /// Key.
        key: usize,
        /// Why.
        error: ListenError,
    },
}

impl Ending for SoundError {
    fn is_interruption(&self) -> bool {
        matches!(self, SoundError::Simulation(SimulationError::Interrupted))
    }
}

/// A note of an instrument beside the recorded one.
#[derive(Debug, Clone, PartialEq)]
pub struct SoundRow {
    /// The recorded note.
    pub recorded: RecordedNote,
    /// Hammer speeds, m/s, and the notes as they were heard; the first is the one whose decay is compared.
    pub heard: Vec<(f64, HeardNote)>,
    /// Measures of the instrument's note.
    pub modelled: SoundMeasures,
    /// What the other recorded notes from C2 to C6 predict for this one, from straight lines of their logarithms over
    /// the key: time to -20 dB, s, and first rate of the level, dB/s.
    pub left_out: [Option<f64>; 2],
}

/// Plays and measures the recorded notes' keys (`keys`: of these only) on a keyboard, on several threads. `progress`
/// receives the share done and ends the work by returning false.
///
/// # Errors
/// See [`SoundError`].
pub fn sounds(
    keyboard: &Keyboard,
    keys: Option<&[usize]>,
    progress: &mut Progress<'_>,
) -> Result<Vec<SoundRow>, SoundError> {
    let asked = |note: &&RecordedNote| keys.is_none_or(|keys| keys.contains(&note.key));
    let notes: Vec<&RecordedNote> = recorded_notes().iter().filter(asked).collect();
    cores::map(&notes, cores::count(), progress, |note, progress| row(keyboard, note, progress))
}

fn row(keyboard: &Keyboard, note: &RecordedNote, progress: &mut Progress<'_>) -> Result<SoundRow, SoundError> {
    let key = note.key;
    let instrument = keyboard.key(key).map_err(|error| SoundError::Key { key, message: error.to_string() })?;
    if !instrument.has_yielding_strings() {
        return Err(SoundError::RigidString(instrument.name.clone()));
    }
    let mut heard = Vec::new();
    for (speed_m_per_s, duration_s) in
        std::iter::once((SPEED_M_PER_S, DURATION_S)).chain(OTHERS_M_PER_S.map(|speed| (speed, SHORT_S)))
    {
        heard.push((speed_m_per_s, self::heard(&instrument, key, speed_m_per_s, duration_s, progress)?));
    }
    let modelled = measures(&heard);
    Ok(SoundRow { recorded: note.clone(), heard, modelled, left_out: left_out(key) })
}

/// Plays a note of a hammer speed, held with the pedal down, and measures its force on the bridge.
///
/// # Errors
/// See [`SoundError`].
pub fn heard(
    instrument: &Instrument,
    key: usize,
    speed_m_per_s: f64,
    duration_s: f64,
    progress: &mut Progress<'_>,
) -> Result<HeardNote, SoundError> {
    let bridge_n = note_of(instrument, key, speed_m_per_s, duration_s, progress)?;
    listen(&[bridge_n], f64::from(RATE_HZ), key).map_err(|error| SoundError::Listen { key, error })
}

/// Force on the bridge of a note of this hammer speed, held with the pedal down, N.
fn note_of(
    instrument: &Instrument,
    key: usize,
    speed_m_per_s: f64,
    duration_s: f64,
    progress: &mut Progress<'_>,
) -> Result<Vec<f64>, SoundError> {
    let level = |error: LevelError| match error {
        LevelError::Interrupted => SoundError::Simulation(SimulationError::Interrupted),
        error => SoundError::Level { key, error: Box::new(error) },
    };
    let kind = HandKind::new(Touch::Pressed, MASS_KG);
    let mut reference = Reference::new(instrument, progress).map_err(level)?;
    let hand = reference.solve(kind, speed_m_per_s, progress).map_err(level)?.held();
    let setup = Setup { hand: Some(hand.hand), pedal: Pedal::held(PEDAL_M), ..Setup::of(instrument, duration_s) };
    let heard = sound(instrument, &|t| hand.input(t), &setup, &[], progress)?;
    Ok(heard.unwrap_or_default().bridge_n)
}

/// Measures of notes: of the first, and the centroid's slope over all.
fn measures(heard: &[(f64, HeardNote)]) -> SoundMeasures {
    let all: Vec<HeardNote> = heard.iter().map(|(_, note)| note.clone()).collect();
    let slope = summary(&all).and_then(|all| all.centroid_slope).map(|[slope, _]| slope);
    let of = summary(&all[..1]);
    let median = |get: &dyn Fn(&NoteSummary) -> Option<Spread>| of.as_ref().and_then(get).map(|one| one.median);
    let decay = |get: fn(&DecaySummary) -> Option<Spread>| median(&|note| get(&note.decay));
    let partial = |index: usize| median(&|note| note.partials.get(index)?.decay.first_db_per_s);
    SoundMeasures {
        fall_s: std::array::from_fn(|n| median(&|note| note.fall_s[n])),
        early_db_per_s: decay(|one| one.first_db_per_s),
        late: decay(|one| one.late_db_per_s).zip(decay(|one| one.break_db)).map(|(rate, level)| [rate, level]),
        centroid_hz: median(&|note| Some(note.centroid_hz)),
        centroid_slope: slope,
        inharmonicity: median(&|note| note.inharmonicity),
        cents: median(&|note| Some(note.cents)),
        partials_db_per_s: std::array::from_fn(partial),
    }
}

/// A positive quantity of a note.
type Quantity = fn(&SoundMeasures) -> Option<f64>;

/// Quantities that are predicted from other notes: time to -20 dB, and the level's first rate.
const PREDICTED: [Quantity; 2] = [|one| one.fall_s[1], |one| one.early_db_per_s];

/// What the other recorded notes predict for a key.
fn left_out(key: usize) -> [Option<f64>; 2] {
    let others = |of: Quantity| {
        let compared = recorded_notes().iter().filter(move |note| note.key != key && note.used != SoundUse::Show);
        compared.filter_map(move |note| Some([note.key as f64, of(&note.measures)?.ln()])).collect::<Vec<_>>()
    };
    PREDICTED.map(|of| {
        let points = others(of);
        let [slope, at] = line(&points)?;
        Some((at + slope * key as f64).exp())
    })
}

/// Slope and ordinate at 0 of the line through points by least squares.
fn line(points: &[[f64; 2]]) -> Option<[f64; 2]> {
    let count = points.len() as f64;
    let mean = |of: usize| points.iter().map(|point| point[of]).sum::<f64>() / count;
    let [x0, y0] = [mean(0), mean(1)];
    let xx: f64 = points.iter().map(|[x, _]| (x - x0).powi(2)).sum();
    let xy: f64 = points.iter().map(|[x, y]| (x - x0) * (y - y0)).sum();
    (points.len() >= 3 && xx > 0.0).then(|| [xy / xx, y0 - x0 * xy / xx])
}

/// A judged row: a number over the notes of one use, and the range in which it is met.
#[derive(Debug, Clone, PartialEq)]
pub struct SoundVerdict {
    /// Name.
    pub name: &'static str,
    /// Quantity in words, with its unit.
    pub quantity: &'static str,
    /// Use of the notes.
    pub used: SoundUse,
    /// Number of notes with a value.
    pub notes: usize,
    /// Value; `None` without a note that has one.
    pub value: Option<f64>,
    /// Standard deviation over the notes: of the logarithm, or in the value's unit.
    pub scatter: Option<f64>,
    /// The value that the recorded piano's own trend has for its notes, each left out in turn.
    pub recorded: Option<f64>,
    /// Range.
    pub range: [f64; 2],
}

impl SoundVerdict {
    /// Whether the value is in its range; `None` without a value.
    #[must_use]
    pub fn is_met(&self) -> Option<bool> {
        self.value.map(|value| (self.range[0]..=self.range[1]).contains(&value))
    }
}

/// The judged numbers of rows of one use: geometric means of modelled over recorded, and the mean difference of the
/// centroid's slopes.
#[must_use]
pub fn verdicts(rows: &[SoundRow], used: SoundUse) -> Vec<SoundVerdict> {
    let rows: Vec<&SoundRow> = rows.iter().filter(|row| row.recorded.used == used).collect();
    let log = |modelled: Option<f64>, recorded: Option<f64>| {
        modelled.zip(recorded).filter(|(m, r)| *m > 0.0 && *r > 0.0).map(|(m, r)| (m / r).ln())
    };
    let of = |quantity: Quantity| {
        rows.iter().filter_map(|row| log(quantity(&row.modelled), quantity(&row.recorded.measures))).collect()
    };
    let left = |index: usize| -> Vec<f64> {
        rows.iter().filter_map(|row| log(row.left_out[index], PREDICTED[index](&row.recorded.measures))).collect()
    };
    // A note's partials count together, as one.
    let partials = |row: &&SoundRow| {
        let pairs = row.modelled.partials_db_per_s.iter().zip(row.recorded.measures.partials_db_per_s);
        mean(&pairs.filter_map(|(modelled, recorded)| log(*modelled, recorded)).collect::<Vec<_>>())
    };
    let slopes: Vec<f64> = rows
        .iter()
        .filter_map(|row| Some(row.modelled.centroid_slope? - row.recorded.measures.centroid_slope?))
        .collect();
    let ratio = |name, quantity, values: Vec<f64>, left: Vec<f64>| SoundVerdict {
        name,
        quantity,
        used,
        notes: values.len(),
        value: mean(&values).map(f64::exp),
        scatter: scatter(&values),
        recorded: mean(&left).map(f64::exp),
        range: RATIO,
    };
    vec![
        ratio("t20", "time to -20 dB, modelled over recorded", of(PREDICTED[0]), left(0)),
        ratio("early", "first rate of the level, modelled over recorded", of(PREDICTED[1]), left(1)),
        ratio(
            "early_partials",
            "first rate of partials 1 to 6, modelled over recorded",
            rows.iter().filter_map(partials).collect(),
            Vec::new(),
        ),
        SoundVerdict {
            name: "centroid_slope",
            quantity: "centroid's slope, modelled less recorded, octaves per 10 dB",
            used,
            notes: slopes.len(),
            value: mean(&slopes),
            scatter: scatter(&slopes),
            recorded: None,
            range: [-SLOPE, SLOPE],
        },
    ]
}

fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

fn scatter(values: &[f64]) -> Option<f64> {
    let mean = mean(values)?;
    let squares: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
    (values.len() > 1).then(|| (squares / (values.len() - 1) as f64).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Seventeen notes from C2 to C6: nine that choose, eight that judge.
    #[test]
    fn notes_choose_or_judge() {
        let of = |used: SoundUse| recorded_notes().iter().filter(move |note| note.used == used);
        let keys = |used: SoundUse| of(used).map(|note| erard::key::note_name(note.key)).collect::<Vec<_>>();
        assert_eq!(keys(SoundUse::Choose), ["C2", "F#2", "C3", "F#3", "C4", "F#4", "C5", "F#5", "C6"]);
        assert_eq!(keys(SoundUse::Judge), ["D#2", "A2", "D#3", "A3", "D#4", "A4", "D#5", "A5"]);
        assert_eq!(of(SoundUse::Show).count(), 13);
        assert!(recorded_notes().iter().all(|note| (1..=erard::key::KEYS).contains(&note.key)));
        for note in recorded_notes().iter().filter(|note| note.used != SoundUse::Show) {
            let measures = &note.measures;
            assert!(measures.fall_s[1].is_some() && measures.early_db_per_s.is_some(), "{note:?}");
            assert!(measures.partials_db_per_s.iter().flatten().count() >= 4, "{note:?}");
            assert!(measures.centroid_slope.is_some() && measures.inharmonicity.is_some(), "{note:?}");
        }
    }

    /// A model that is the recorded piano has ratios of 1; one that rings twice as long has 2 in time and a half in
    /// rate.
    #[test]
    fn ratios_are_of_modelled_to_recorded() {
        let row = |note: &RecordedNote, longer: f64| {
            let mut modelled = note.measures.clone();
            modelled.fall_s = modelled.fall_s.map(|fall_s| fall_s.map(|fall_s| fall_s * longer));
            modelled.early_db_per_s = modelled.early_db_per_s.map(|rate| rate / longer);
            modelled.partials_db_per_s = modelled.partials_db_per_s.map(|rate| rate.map(|rate| rate / longer));
            SoundRow { recorded: note.clone(), heard: Vec::new(), modelled, left_out: left_out(note.key) }
        };
        for longer in [1.0, 2.0] {
            let rows: Vec<SoundRow> = recorded_notes().iter().map(|note| row(note, longer)).collect();
            let found = verdicts(&rows, SoundUse::Judge);
            let values: Vec<f64> = found.iter().map(|one| one.value.unwrap()).collect();
            for (value, truth) in values.iter().zip([longer, 1.0 / longer, 1.0 / longer, 0.0]) {
                assert!((value - truth).abs() < 1e-9, "{values:?}");
            }
            let met: Vec<Option<bool>> = found.iter().map(SoundVerdict::is_met).collect();
            assert_eq!(met, [longer == 1.0, longer == 1.0, longer == 1.0, true].map(Some));
            assert!(found.iter().all(|one| one.notes == 8 && one.scatter.unwrap() < 1e-9));
        }
    }

    /// A line through the logarithms of others: where all lie on one, the left-out note is predicted exactly.
    #[test]
    fn a_line_is_its_own() {
        let [slope, at] = line(&[[1.0, 3.0], [2.0, 5.0], [4.0, 9.0]]).unwrap();
        assert!((slope - 2.0).abs() < 1e-12 && (at - 1.0).abs() < 1e-12);
        assert_eq!(line(&[[1.0, 3.0], [2.0, 5.0]]), None);
    }
}

//! A key's notes of several loudnesses, and how far they differ.

use super::{Decay, HeardNote, PARTIALS, Shape};

/// Median and quartiles of a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Median.
    pub median: f64,
    /// A quarter of the values is smaller.
    pub low: f64,
    /// A quarter of the values is larger.
    pub high: f64,
    /// Number of values.
    pub count: usize,
}

impl Spread {
    /// The spread of the values that are known; between two values it is interpolated. `None` without any.
    pub fn of(values: impl IntoIterator<Item = Option<f64>>) -> Option<Self> {
        let mut all: Vec<f64> = values.into_iter().flatten().collect();
        all.sort_by(f64::total_cmp);
        let last = all.len().checked_sub(1)? as f64;
        let at = |share: f64| {
            let place = share * last;
            let (low, high) = (all[place.floor() as usize], all[place.ceil() as usize]);
            low + (place - place.floor()) * (high - low)
        };
        Some(Spread { median: at(0.5), low: at(0.25), high: at(0.75), count: all.len() })
    }
}

/// A key over its notes.
#[derive(Debug, Clone, PartialEq)]
pub struct NoteSummary {
    /// Key, from 1.
    pub key: usize,
    /// Level, dB.
    pub level_db: Spread,
    /// Times to -10, -20 and -40 dB, s.
    pub fall_s: [Option<Spread>; 3],
    /// Decay of the level.
    pub decay: DecaySummary,
    /// Centroid, Hz.
    pub centroid_hz: Spread,
    /// Octaves by which the centroid rises while the level rises by 10 dB, with its standard error; `None` below three
    /// notes or where levels differ by less than 3 dB.
    pub centroid_slope: Option<[f64; 2]>,
    /// Inharmonicity B.
    pub inharmonicity: Option<Spread>,
    /// First partial above equal temperament, cents.
    pub cents: Spread,
    /// The first partials.
    pub partials: Vec<PartialSummary>,
}

/// A partial over a key's notes.
#[derive(Debug, Clone, PartialEq)]
pub struct PartialSummary {
    /// Number, from 1.
    pub number: usize,
    /// Frequency, Hz.
    pub frequency_hz: Spread,
    /// Level above that of the whole note, dB.
    pub level_db: Spread,
    /// Decay.
    pub decay: DecaySummary,
}

/// Decays over a key's notes. Rates are positive where the level falls, dB/s.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DecaySummary {
    /// Number of notes whose level falls in two stages, in one line, and in beats.
    pub shapes: [usize; 3],
    /// The first rate ([`Decay::first_db_per_s`]), dB/s.
    pub first_db_per_s: Option<Spread>,
    /// Rate of the late line of those in two stages, dB/s.
    pub late_db_per_s: Option<Spread>,
    /// Level at the break of those in two stages, dB.
    pub break_db: Option<Spread>,
    /// Rate of one line, dB/s.
    pub one_line_db_per_s: Option<Spread>,
}

impl DecaySummary {
    fn of(decays: &[Option<Decay>]) -> Self {
        let of = |get: &dyn Fn(&Decay) -> Option<f64>| Spread::of(decays.iter().map(|one| one.as_ref().and_then(get)));
        let count = |shape: Shape| decays.iter().flatten().filter(|one| one.shape == shape).count();
        let is_two = |one: &Decay| one.shape == Shape::TwoStages;
        DecaySummary {
            shapes: [Shape::TwoStages, Shape::OneLine, Shape::Beats].map(count),
            first_db_per_s: of(&|one| Some(one.first_db_per_s())),
            late_db_per_s: of(&|one| is_two(one).then_some(one.late_db_per_s)),
            break_db: of(&|one| is_two(one).then_some(one.break_db)),
            one_line_db_per_s: of(&|one| Some(one.one_line_db_per_s)),
        }
    }
}

/// Gathers notes of one key; `None` without any. The key is that of the first.
#[must_use]
pub fn summary(notes: &[HeardNote]) -> Option<NoteSummary> {
    let key = notes.first()?.key;
    let of = |get: &dyn Fn(&HeardNote) -> Option<f64>| Spread::of(notes.iter().map(get));
    let partial = |number: usize| {
        let all = || notes.iter().filter_map(move |note| Some((note, note.partials.get(number - 1)?)));
        Some(PartialSummary {
            number,
            frequency_hz: Spread::of(all().map(|(_, one)| Some(one.frequency_hz)))?,
            level_db: Spread::of(all().map(|(note, one)| Some(one.level_db - note.level_db)))?,
            decay: DecaySummary::of(&all().map(|(_, one)| one.decay).collect::<Vec<_>>()),
        })
    };
    Some(NoteSummary {
        key,
        level_db: of(&|note| Some(note.level_db))?,
        fall_s: [0, 1, 2].map(|n| of(&|note| note.fall_s[n])),
        decay: DecaySummary::of(&notes.iter().map(|note| note.decay).collect::<Vec<_>>()),
        centroid_hz: of(&|note| Some(note.centroid_hz))?,
        centroid_slope: slope(notes),
        inharmonicity: of(&|note| note.inharmonicity),
        cents: of(&|note| Some(note.cents))?,
        partials: (1..=PARTIALS).filter_map(partial).collect(),
    })
}

/// Fewest notes of a slope, and their least range of levels, dB.
const FEWEST: usize = 3;
const RANGE_DB: f64 = 3.0;

/// Slope of log2 of the centroid over the level by least squares, octaves per 10 dB, and its standard error.
fn slope(notes: &[HeardNote]) -> Option<[f64; 2]> {
    let points: Vec<[f64; 2]> = notes.iter().map(|note| [0.1 * note.level_db, note.centroid_hz.log2()]).collect();
    let levels = || points.iter().map(|point| 10.0 * point[0]);
    let range_db = levels().fold(f64::NEG_INFINITY, f64::max) - levels().fold(f64::INFINITY, f64::min);
    if points.len() < FEWEST || range_db < RANGE_DB {
        return None;
    }
    let count = points.len() as f64;
    let mean = |of: usize| points.iter().map(|point| point[of]).sum::<f64>() / count;
    let [x0, y0] = [mean(0), mean(1)];
    let xx: f64 = points.iter().map(|[x, _]| (x - x0).powi(2)).sum();
    let slope = points.iter().map(|[x, y]| (x - x0) * (y - y0)).sum::<f64>() / xx;
    let squares: f64 = points.iter().map(|[x, y]| (y - y0 - slope * (x - x0)).powi(2)).sum();
    Some([slope, (squares / (count - 2.0) / xx).sqrt()])
}

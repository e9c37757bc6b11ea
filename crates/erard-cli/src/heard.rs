//! Rows of notes that were heard, recorded or modelled: what `erard listen` and `erard validate --sound` write.

use erard::keyboard::note_name;
use erard_workshop::listen::{Decay, DecaySummary, HeardNote, NoteSummary, Spread};
use serde::Serialize;

use crate::table::Table;

/// A number to so many significant digits: what a table holds of a measurement.
fn significant(x: f64, digits: usize) -> f64 {
    format!("{x:.*e}", digits.saturating_sub(1)).parse().unwrap_or(x)
}

/// Four significant digits.
pub(crate) fn four(x: f64) -> f64 {
    significant(x, 4)
}

/// A number to so many decimals.
pub(crate) fn decimals(x: f64, count: usize) -> f64 {
    // No -0.
    format!("{x:.count$}").parse::<f64>().unwrap_or(x) + 0.0
}

/// What is written of a decay; empty cells without one.
#[derive(Debug, Serialize)]
struct DecayCells {
    shape: &'static str,
    #[serde(rename = "early_dB_per_s")]
    early_db_per_s: Option<f64>,
    #[serde(rename = "late_dB_per_s")]
    late_db_per_s: Option<f64>,
    break_s: Option<f64>,
    #[serde(rename = "break_dB")]
    break_db: Option<f64>,
    #[serde(rename = "one_line_dB_per_s")]
    one_line_db_per_s: Option<f64>,
    gain: Option<f64>,
}

/// A note.
#[derive(Debug, Serialize)]
pub(crate) struct NoteRow {
    recording: String,
    note: String,
    key: usize,
    #[serde(rename = "level_dB")]
    level_db: f64,
    #[serde(rename = "peak_dB")]
    peak_db: f64,
    clipped_samples: usize,
    t10_s: Option<f64>,
    t20_s: Option<f64>,
    t40_s: Option<f64>,
    #[serde(flatten)]
    decay: DecayCells,
    #[serde(rename = "centroid_Hz")]
    centroid_hz: f64,
    inharmonicity: Option<f64>,
    cents: f64,
    partials_found: usize,
}

/// A partial of a note.
#[derive(Debug, Serialize)]
pub(crate) struct PartialRow {
    recording: String,
    note: String,
    key: usize,
    partial: usize,
    #[serde(rename = "frequency_Hz")]
    frequency_hz: f64,
    #[serde(rename = "level_dB")]
    level_db: f64,
    #[serde(flatten)]
    decay: DecayCells,
    #[serde(rename = "residual_dB")]
    residual_db: Option<f64>,
    window_s: Option<f64>,
}

impl DecayCells {
    fn of(decay: Option<&Decay>) -> Self {
        let cell = |of: fn(&Decay) -> f64| decay.map(|one| four(of(one)));
        DecayCells {
            shape: decay.map_or("", |one| one.shape.name()),
            early_db_per_s: cell(|one| one.early_db_per_s),
            late_db_per_s: cell(|one| one.late_db_per_s),
            break_s: cell(|one| one.break_s),
            break_db: cell(|one| one.break_db),
            one_line_db_per_s: cell(|one| one.one_line_db_per_s),
            gain: cell(|one| one.gain),
        }
    }
}

impl NoteRow {
    pub fn of(recording: &str, note: &HeardNote) -> Self {
        let [t10_s, t20_s, t40_s] = note.fall_s.map(|fall_s| fall_s.map(four));
        NoteRow {
            recording: recording.to_owned(),
            note: note_name(note.key),
            key: note.key,
            level_db: decimals(note.level_db, 2),
            peak_db: decimals(note.peak_db, 2),
            clipped_samples: note.clipped,
            t10_s,
            t20_s,
            t40_s,
            decay: DecayCells::of(note.decay.as_ref()),
            centroid_hz: four(note.centroid_hz),
            inharmonicity: note.inharmonicity.map(four),
            cents: decimals(note.cents, 2),
            partials_found: note.partials_found,
        }
    }
}

impl PartialRow {
    pub fn all(recording: &str, note: &HeardNote) -> Vec<Self> {
        let row = |one: &erard_workshop::listen::HeardPartial| PartialRow {
            recording: recording.to_owned(),
            note: note_name(note.key),
            key: note.key,
            partial: one.number,
            frequency_hz: significant(one.frequency_hz, 6),
            level_db: decimals(one.level_db, 2),
            decay: DecayCells::of(one.decay.as_ref()),
            residual_db: one.decay.map(|decay| four(decay.residual_db)),
            window_s: one.decay.map(|decay| four(decay.window_s)),
        };
        note.partials.iter().map(row).collect()
    }
}

/// Columns of a spread: median and quartiles.
fn spread<'a>(table: Table<'a>, name: &str, values: Vec<Option<Spread>>) -> Table<'a> {
    let get =
        |of: fn(&Spread) -> f64| values.iter().map(|one| one.as_ref().map(|one| four(of(one)))).collect::<Vec<_>>();
    table
        .optional(name.to_owned(), get(|one| one.median))
        .optional(format!("{name}_q25"), get(|one| one.low))
        .optional(format!("{name}_q75"), get(|one| one.high))
}

fn counts<'a>(table: Table<'a>, decays: &[&DecaySummary]) -> Table<'a> {
    ["two_stages", "one_line", "beats"]
        .into_iter()
        .enumerate()
        .fold(table, |table, (n, name)| table.optional(name, decays.iter().map(|one| Some(one.shapes[n] as f64))))
}

fn decays<'a>(table: Table<'a>, decays: &[&DecaySummary]) -> Table<'a> {
    let of = |get: fn(&DecaySummary) -> Option<Spread>| decays.iter().map(|one| get(one)).collect::<Vec<_>>();
    let table = counts(table, decays);
    let table = spread(table, "early_dB_per_s", of(|one| one.first_db_per_s));
    let table = spread(table, "late_dB_per_s", of(|one| one.late_db_per_s));
    let table = spread(table, "break_dB", of(|one| one.break_db));
    spread(table, "one_line_dB_per_s", of(|one| one.one_line_db_per_s))
}

/// A row for each key: medians over its notes, with their quartiles.
pub(crate) fn summary_table(notes: &[NoteSummary]) -> Table<'static> {
    let all = |get: fn(&NoteSummary) -> Option<Spread>| notes.iter().map(get).collect::<Vec<_>>();
    let table = Table::default()
        .words("note", notes.iter().map(|one| note_name(one.key)))
        .optional("key", notes.iter().map(|one| Some(one.key as f64)))
        .optional("recordings", notes.iter().map(|one| Some(one.level_db.count as f64)));
    let table = spread(table, "level_dB", all(|one| Some(one.level_db)));
    let table = spread(table, "t10_s", all(|one| one.fall_s[0]));
    let table = spread(table, "t20_s", all(|one| one.fall_s[1]));
    let table = spread(table, "t40_s", all(|one| one.fall_s[2]));
    let table = decays(table, &notes.iter().map(|one| &one.decay).collect::<Vec<_>>());
    let table = spread(table, "centroid_Hz", all(|one| Some(one.centroid_hz)));
    let slope = |of: usize| notes.iter().map(move |one| one.centroid_slope.map(|slope| four(slope[of])));
    let table =
        table.optional("centroid_octaves_per_10_dB", slope(0)).optional("centroid_octaves_per_10_dB_error", slope(1));
    let table = spread(table, "inharmonicity", all(|one| one.inharmonicity));
    spread(table, "cents", all(|one| Some(one.cents)))
}

/// A row for each partial of each key.
pub(crate) fn partials_table(notes: &[NoteSummary]) -> Table<'static> {
    let all: Vec<_> = notes.iter().flat_map(|note| note.partials.iter().map(move |one| (note.key, one))).collect();
    let table = Table::default()
        .words("note", all.iter().map(|(key, _)| note_name(*key)))
        .optional("key", all.iter().map(|(key, _)| Some(*key as f64)))
        .optional("partial", all.iter().map(|(_, one)| Some(one.number as f64)));
    let table = spread(table, "frequency_Hz", all.iter().map(|(_, one)| Some(one.frequency_hz)).collect());
    let table = spread(table, "level_dB", all.iter().map(|(_, one)| Some(one.level_db)).collect());
    decays(table, &all.iter().map(|(_, one)| &one.decay).collect::<Vec<_>>())
}

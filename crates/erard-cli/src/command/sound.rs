//! `erard validate --sound`: an instrument's notes beside those of a recorded piano.

use erard::instrument_spec::InstrumentSpec;
use erard::keyboard::note_name;
use erard::run::SimulationError;
use erard_figures::Picture;
use erard_figures::figure::{Dash, Figure, Panel, Scale, Trace, figure_picture};
use erard_workshop::validate::{
    FALLS_DB, SoundError, SoundMeasures, SoundRow, SoundUse, SoundVerdict, recorded_notes, sounds, verdicts,
};
use serde::Serialize;

use crate::answer::Answer;
use crate::command::out::OutOptions;
use crate::failure::Failure;
use crate::heard::{decimals, four};
use crate::instruments::load_keyboard;
use crate::print_line;
use crate::session::Session;
use crate::table::{Table, three};

/// A measure of a note: recorded, modelled, and modelled over recorded (of the centroid's slope, cents and the break's
/// level: less).
#[derive(Debug, Serialize)]
struct Row {
    note: String,
    key: usize,
    #[serde(rename = "use")]
    used: &'static str,
    quantity: String,
    unit: &'static str,
    recorded: Option<f64>,
    modelled: Option<f64>,
    ratio: Option<f64>,
    difference: Option<f64>,
    trend_of_others: Option<f64>,
}

/// A number over all notes of a use.
#[derive(Debug, Serialize)]
struct VerdictRow {
    name: &'static str,
    quantity: &'static str,
    #[serde(rename = "use")]
    used: &'static str,
    notes: usize,
    value: Option<f64>,
    scatter: Option<f64>,
    recorded_piano: Option<f64>,
    at_least: f64,
    at_most: f64,
    verdict: &'static str,
}

#[derive(Debug, Serialize)]
struct Report {
    instrument: String,
    met: usize,
    missed: usize,
    verdicts: Vec<VerdictRow>,
    rows: Vec<Row>,
}

/// A quantity: name, unit, whether it is compared by its ratio, and its value.
type Quantity = (String, &'static str, bool, Get, usize);

/// A number of the measures; of a partial, by its index.
type Get = fn(&SoundMeasures, usize) -> Option<f64>;

fn quantities() -> Vec<Quantity> {
    let one = |name: &str, unit: &'static str, is_ratio: bool, get: Get| (name.to_owned(), unit, is_ratio, get, 0);
    let mut all: Vec<Quantity> = vec![
        one("t10", "s", true, |one, _| one.fall_s[0]),
        one("t20", "s", true, |one, _| one.fall_s[1]),
        one("t40", "s", true, |one, _| one.fall_s[2]),
        one("early", "dB/s", true, |one, _| one.early_db_per_s),
        one("late", "dB/s", true, |one, _| one.late.map(|late| late[0])),
        one("break", "dB", false, |one, _| one.late.map(|late| late[1])),
        one("centroid", "Hz", true, |one, _| one.centroid_hz),
        one("centroid_slope", "octaves per 10 dB", false, |one, _| one.centroid_slope),
        one("inharmonicity", "1", true, |one, _| one.inharmonicity),
        one("cents", "cents", false, |one, _| one.cents),
    ];
    all.extend((0..erard_workshop::listen::PARTIALS).map(|n| -> Quantity {
        (format!("early_partial_{}", n + 1), "dB/s", true, |one, n| one.partials_db_per_s[n], n)
    }));
    all
}

impl Row {
    fn all(row: &SoundRow) -> Vec<Self> {
        let left_out = |name: &str| match name {
            "t20" => row.left_out[0],
            "early" => row.left_out[1],
            _ => None,
        };
        let of = |(quantity, unit, is_ratio, get, index): Quantity| {
            let (recorded, modelled) = (get(&row.recorded.measures, index), get(&row.modelled, index));
            let both = modelled.zip(recorded);
            Row {
                note: note_name(row.recorded.key),
                key: row.recorded.key,
                used: row.recorded.used.name(),
                trend_of_others: left_out(&quantity).map(four),
                quantity,
                unit,
                recorded: recorded.map(four),
                modelled: modelled.map(four),
                ratio: both.filter(|_| is_ratio).map(|(m, r)| four(m / r)),
                difference: both.filter(|_| !is_ratio).map(|(m, r)| decimals(m - r, 3)),
            }
        };
        quantities().into_iter().map(of).collect()
    }
}

impl From<SoundVerdict> for VerdictRow {
    fn from(one: SoundVerdict) -> Self {
        VerdictRow {
            name: one.name,
            quantity: one.quantity,
            used: one.used.name(),
            notes: one.notes,
            value: one.value.map(four),
            scatter: one.scatter.map(four),
            recorded_piano: one.recorded.map(four),
            at_least: one.range[0],
            at_most: one.range[1],
            verdict: match one.is_met() {
                Some(true) => "met",
                Some(false) => "missed",
                None => "no value",
            },
        }
    }
}

/// Plays the notes, and prints the table and the verdicts.
pub(super) fn run(
    session: &mut Session,
    out: &OutOptions,
    instrument: &InstrumentSpec,
    keys: &[usize],
    fail_on_miss: bool,
) -> Result<Answer, Failure> {
    let name = instrument.to_string();
    if name != instrument.base().to_string() {
        return Err(Failure::Usage(format!(
            "--sound plays the keys of a whole keyboard; found {name}. Use --instrument concert-grand-strings or the file of a keyboard"
        )));
    }
    if !recorded_notes().iter().any(|note| keys.contains(&note.key)) {
        let known: Vec<String> = recorded_notes().iter().map(|note| note_name(note.key)).collect();
        let message = format!("--sound: none of these keys was recorded; expected some of {}", known.join(", "));
        return Err(Failure::Usage(message));
    }
    let keyboard = load_keyboard(session, instrument.base())?;
    let mut output = out.prepare(session, "validate", &["sound.json", "sound.csv"])?;
    let mut progress = session.progress("playing notes");
    let found = sounds(&keyboard, Some(keys), &mut |share| progress.tell(share));
    drop(progress);
    let rows = found.map_err(|error| match error {
        SoundError::Simulation(SimulationError::Interrupted) => Failure::Simulation(SimulationError::Interrupted),
        error => Failure::Usage(error.to_string()),
    })?;
    let verdicts: Vec<VerdictRow> = [SoundUse::Judge, SoundUse::Choose]
        .into_iter()
        .flat_map(|used| verdicts(&rows, used))
        .filter(|one| one.notes > 0)
        .map(VerdictRow::from)
        .collect();
    let judged = |verdict: &str| verdicts.iter().filter(|one| one.used == "judge" && one.verdict == verdict).count();
    let report = Report {
        instrument: name,
        met: judged("met"),
        missed: judged("missed"),
        rows: rows.iter().flat_map(Row::all).collect(),
        verdicts,
    };
    output.json(session, "sound.json", &report)?;
    output.table(session, "sound.csv", &Table::of_records(&report.rows)?)?;
    output.figure(session, "sound", &picture(&rows, &report.instrument))?;
    if !report.verdicts.is_empty() {
        output.table(session, "sound-verdicts.csv", &Table::of_records(&report.verdicts)?)?;
    }
    let written = output.commit(session)?;

    print_line!(session, "{} compared with a recorded grand, note by note", report.instrument);
    let answer = Answer::of(&report)?;
    let first = match &report.verdicts[..] {
        [] => printed(&rows),
        verdicts => printed_verdicts(verdicts),
    }
    .lines();
    Answer::begin_with_part(session, &first, "every note beside the recorded one: decay, inharmonicity, centroid");
    print_line!(session, "{}", printed(&rows));
    if !report.verdicts.is_empty() {
        print_line!(session, "{}", printed_verdicts(&report.verdicts));
    }
    print_line!(session, "  Pairs are modelled/recorded. A force on the bridge is compared with microphones");
    print_line!(session, "  over another piano: look at rates and trends, not at levels. sound.csv has more.");
    print_line!(session);
    let answer = answer.end(session, &written);
    Ok(match report.missed {
        missed if missed > 0 && fail_on_miss => answer.short_of(Some(format!("{missed} judged rows missed"))),
        _ => answer,
    })
}

/// Panels of a figure at most, and their height, px.
const PANELS: usize = 8;
const PANEL_PX: f64 = 120.0;
const GREY: &str = "#8f8f8f";
const BLACK: &str = "#111111";

/// How notes fall, recorded grey and modelled black: as many as a figure holds, evenly over those that were played.
fn picture(rows: &[SoundRow], instrument: &str) -> Picture {
    let count = rows.len().min(PANELS);
    let shown: Vec<&SoundRow> = (0..count).map(|n| &rows[n * (rows.len() - 1) / (count - 1).max(1)]).collect();
    // Of three levels those that a note falls to.
    let curve = |times: [Option<f64>; 3]| -> [Vec<f64>; 2] {
        let both = times.into_iter().zip(FALLS_DB).filter_map(|(time_s, db)| Some((time_s?, db)));
        let (times, levels) = both.unzip();
        [times, levels]
    };
    let curves: Vec<[[Vec<f64>; 2]; 4]> = shown
        .iter()
        .map(|row| {
            let quartile = |which: usize| curve(row.recorded.fall_quartiles_s.map(|both| both.map(|both| both[which])));
            [curve(row.recorded.measures.fall_s), quartile(1), curve(row.modelled.fall_s), quartile(0)]
        })
        .collect();
    let styles = [
        ("recorded", GREY, Dash::Points),
        ("the middle half", GREY, Dash::Dotted),
        ("modelled", BLACK, Dash::Points),
        ("", GREY, Dash::Dotted),
    ];
    let panels = shown.iter().zip(&curves).map(|(row, curves)| {
        let traces = curves
            .iter()
            .zip(styles)
            .map(|([x, y], (label, colour, dash))| Trace { colour, ..Trace::new(label, x, y.as_slice(), 0, dash) });
        Panel::new(note_name(row.recorded.key), "dB", PANEL_PX, traces.collect()).within(-45.0, -5.0)
    });
    let times = || curves.iter().flatten().flat_map(|[times, _]| times);
    let [least, most] = [times().copied().fold(f64::INFINITY, f64::min), times().copied().fold(0.0, f64::max)];
    let title = format!("{instrument} beside a recorded grand: times to -10, -20 and -40 dB");
    let subtitle = "grey: median and middle half of 16 loudnesses of a Yamaha C5; black: hammer at 2 m/s".to_owned();
    let figure = Figure {
        x_scale: Scale::Logarithmic,
        ..Figure::over("time after the loudest (s)", (0.8 * least, 1.25 * most), title, subtitle, panels.collect())
    };
    figure_picture(&figure)
}

/// A line for each note.
fn printed(rows: &[SoundRow]) -> Table<'static> {
    let pair = |row: &SoundRow, get: fn(&SoundMeasures) -> Option<f64>| {
        let one = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), three);
        let (recorded, modelled) = (get(&row.recorded.measures), get(&row.modelled));
        (recorded, modelled, format!("{}/{}", one(modelled), one(recorded)))
    };
    let over = |(recorded, modelled, both): (Option<f64>, Option<f64>, String)| {
        let ratio = modelled.zip(recorded).map_or_else(String::new, |(m, r)| format!(" = {:.2}", m / r));
        format!("{both}{ratio}")
    };
    let cells = rows.iter().map(|row| {
        [
            note_name(row.recorded.key),
            row.recorded.used.name().to_owned(),
            over(pair(row, |one| one.fall_s[1])),
            over(pair(row, |one| one.early_db_per_s)),
            pair(row, |one| one.late.map(|late| late[0])).2,
            pair(row, |one| one.centroid_slope).2,
            over(pair(row, |one| one.inharmonicity.map(|b| 1e4 * b))),
        ]
    });
    Table::of(["", "use", "t20, s", "early, dB/s", "late, dB/s", "centroid, oct/10 dB", "B x 1e4"], cells)
}

fn printed_verdicts(verdicts: &[VerdictRow]) -> Table<'static> {
    let number = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), three);
    let cells = verdicts.iter().map(|one| {
        [
            one.quantity.to_owned(),
            format!("{} {}", one.notes, one.used),
            number(one.value),
            number(one.scatter),
            number(one.recorded_piano),
            format!("{} to {}", one.at_least, one.at_most),
            if one.used == "judge" { one.verdict } else { "not counted" }.to_owned(),
        ]
    });
    Table::of(["", "notes", "mean", "scatter", "recorded piano's trend", "met if", ""], cells)
}

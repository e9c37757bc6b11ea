//! Two presses on one clock: both actions on one page, their curves over each other, and a table of what differs.

use erard::instrument::Instrument;
use erard::run::Run;
use erard_figures::drawing::ChangedNote;
use erard_figures::figure::pair_picture;
use erard_figures::page::{Shown, SummaryTable, pair_html};
use erard_workshop::digits::signed;
use serde_json::{Map, Value, json};

use crate::failure::Failure;
use crate::output::Output;
use crate::print_line;
use crate::session::Session;
use crate::summary::{MEASURES, Measure, Summary, value};
use crate::table::Table;

/// What is written; the tables of the two runs are numbered.
pub(crate) const FILES: [&str; 6] = ["run-1.csv", "run-2.csv", "summary.json", "run.svg", "run.png", "run.html"];

/// One of the two.
#[derive(Debug)]
pub(crate) struct Played<'a> {
    /// The instrument.
    pub instrument: &'a Instrument,
    /// Numbers of its file whose notes speak of what they were.
    pub changed: &'a [ChangedNote],
    /// The stroke.
    pub stroke: String,
    /// The run.
    pub run: Run,
    /// Its numbers.
    pub summary: Summary,
}

/// What the two are called: by what differs, the instrument or the stroke.
pub(crate) fn names(played: &[Played<'_>; 2]) -> [String; 2] {
    let [a, b] = played;
    if a.stroke != b.stroke {
        [a.stroke.clone(), b.stroke.clone()]
    } else if a.run.instrument != b.run.instrument {
        [a.run.instrument.clone(), b.run.instrument.clone()]
    } else {
        ["first", "second"].map(|which| format!("{}, {which}", a.run.instrument))
    }
}

/// What is compared.
pub(crate) fn title(played: &[Played<'_>; 2]) -> String {
    let ([a, b], names) = (played, names(played));
    let common = if a.stroke == b.stroke { &a.stroke } else { &a.run.instrument };
    format!("{} beside {}: {common}", names[0], names[1])
}

fn json_of<'p>(played: &'p [Played<'_>; 2]) -> [&'p Value; 2] {
    [&played[0].summary.json, &played[1].summary.json]
}

/// The row of hammers that strike more than once.
const IMPACTS: &str = "impacts on the string";

/// Rows of name, first, second and second less first.
fn rows(summaries: [&Value; 2]) -> Vec<(String, [String; 3])> {
    let row = |measure: &Measure| {
        let (_, name, _, unit, decimals) = measure;
        let values = [0, 1].map(|index| value(summaries[index], measure));
        if values == [None, None] {
            return None;
        }
        let shown = |value: Option<f64>| value.map_or("-".to_owned(), |value| format!("{value:.decimals$} {unit}"));
        let difference = values[0].zip(values[1]).map(|(a, b)| b - a);
        let signed = difference.map_or("-".to_owned(), |d| format!("{} {unit}", signed(d, *decimals)));
        Some(((*name).to_owned(), [shown(values[0]), shown(values[1]), signed]))
    };
    let mut rows: Vec<(String, [String; 3])> = MEASURES.iter().filter_map(row).collect();
    // A hammer that strikes again is no detail: the row stands first.
    let impacts = impacts(summaries);
    if impacts.iter().any(|count| *count > 1) {
        let [first, second] = impacts;
        let difference = i64::try_from(second).unwrap_or(0) - i64::try_from(first).unwrap_or(0);
        let difference = if difference == 0 { "0".to_owned() } else { format!("{difference:+}") };
        rows.insert(0, (IMPACTS.to_owned(), [first.to_string(), second.to_string(), difference]));
    }
    rows
}

/// How often each hammer strikes.
fn impacts(summaries: [&Value; 2]) -> [usize; 2] {
    summaries.map(|summary| summary["impacts"].as_array().map_or(0, Vec::len))
}

/// Stages the page, the figure, the tables and the numbers.
pub(crate) fn write(session: &Session, played: &[Played<'_>; 2], output: &mut Output) -> Result<Value, Failure> {
    let (names, title, summaries) = (names(played), title(played), json_of(played));
    for (one, name) in played.iter().zip(["run-1.csv", "run-2.csv"]) {
        let table = Table::of_run(&one.run, Vec::new());
        output.table(session, name, &table)?;
    }
    let mut difference = Map::new();
    for measure in &MEASURES {
        let (key, _, factor, ..) = measure;
        let values = [0, 1].map(|index| value(summaries[index], measure));
        let second_less_first = values[0].zip(values[1]).map(|(a, b)| (b - a) / factor);
        difference.insert((*key).to_owned(), json!(second_less_first));
    }
    let [first, second] = impacts(summaries);
    difference.insert("impacts".to_owned(), json!(second as f64 - first as f64));
    let rows = rows(summaries);
    let both = json!({"names": names, "runs": summaries, "difference": difference});
    output.json(session, "summary.json", &both)?;
    let picture = pair_picture(&title, [(&names[0], &played[0].run), (&names[1], &played[1].run)]);
    output.figure(session, "run", &picture)?;
    let shown = [0, 1].map(|index| Shown {
        name: names[index].clone(),
        changed: played[index].changed,
        ..Shown::new(played[index].instrument, &played[index].run)
    });
    let table = SummaryTable {
        heads: names.iter().cloned().chain(["difference".to_owned()]).collect(),
        rows: rows.into_iter().map(|(name, values)| (name, values.to_vec())).collect(),
    };
    let page = pair_html(&title, &shown, &table);
    output.text(session, "run.html", &page)?;
    Ok(both)
}

/// Measures that most users compare, by their keys in the summary.
const FIRST: [&str; 5] = ["hammer_speed_m_per_s", "hammer_contact_s", "free_flight_s", "key_bottom_s", "peak_force_N"];

/// The first lines: a table of the measures that most users compare.
pub(crate) fn headlines(played: &[Played<'_>; 2]) -> Vec<String> {
    let is_first =
        |name: &str| MEASURES.iter().any(|(key, own, ..)| FIRST.contains(key) && *own == name) || name == IMPACTS;
    let rows = rows(json_of(played)).into_iter().filter(|(name, _)| is_first(name)).collect();
    table(played, rows).lines()
}

fn table(played: &[Played<'_>; 2], rows: Vec<(String, [String; 3])>) -> Table<'static> {
    let rows = rows.into_iter().map(|(name, cells)| [vec![name], cells.to_vec()].concat());
    let heads = [String::new()].into_iter().chain(names(played)).chain(["difference".to_owned()]);
    Table::of(heads, rows)
}

/// Prints the table of differences.
pub(crate) fn tell(session: &mut Session, played: &[Played<'_>; 2]) {
    print_line!(session, "{}", table(played, rows(json_of(played))));
    for (name, count) in names(played).iter().zip(impacts(json_of(played))).filter(|(_, count)| *count > 1) {
        print_line!(session, "  {name}: the hammer strikes {count} times.");
    }
}

//! `erard validate --cases`: diagnoses of published pianos.

use erard::keyboard::note_name;
use erard_workshop::validate::{Case, CaseResult, CaseUse, CaseVerdict, Cases};
use serde::Serialize;

use crate::answer::Answer;
use crate::command::out::OutOptions;
use crate::failure::Failure;
use crate::print_line;
use crate::session::Session;
use crate::suggest::meant;
use crate::table::Table;

/// Cases to be run: `all`, `choose`, `judge`, or names of cases.
#[derive(Debug, Clone)]
pub(crate) struct Which(Vec<String>);

/// Reads names with commas.
pub(crate) fn which(text: &str) -> Result<Which, String> {
    let cases = Cases::builtin().cases;
    let names: Vec<String> = text.split(',').map(|name| name.trim().to_owned()).collect();
    let is_known = |name: &String| cases.iter().any(|case| is_called(case, name));
    if let Some(name) = names.iter().find(|name| !is_known(name)) {
        let known: Vec<&str> = cases.iter().map(|case| &*case.name).collect();
        return Err(format!(
            "found `{name}`; expected `all`, `choose`, `judge`, or names with commas out of {}{}",
            known.join(", "),
            meant(name, known.iter().copied().chain(["all", "choose", "judge"]))
        ));
    }
    Ok(Which(names))
}

fn is_called(case: &Case, name: &str) -> bool {
    match name {
        "all" => true,
        "choose" => case.used == CaseUse::Choose,
        "judge" => case.used == CaseUse::Judge,
        name => case.name == name,
    }
}

/// A key of a case with its verdict, as it is written and printed.
#[derive(Debug, Serialize)]
struct CaseRow<'a> {
    name: &'a str,
    key: usize,
    note: String,
    #[serde(rename = "use")]
    used: &'static str,
    basis: &'static str,
    verdict: &'static str,
    first: String,
    probability: Option<f64>,
    named: String,
    harmful_work: String,
    acceptable: String,
    piano: &'a str,
    concluded: &'a str,
    source: &'a str,
    read: &'a str,
    entered: Option<&'a str>,
}

impl<'a> CaseRow<'a> {
    fn of(case: &'a Case, result: &CaseResult) -> Self {
        CaseRow {
            name: &case.name,
            key: result.key,
            note: note_name(result.key),
            used: case.used.name(),
            basis: case.basis.name(),
            verdict: result.verdict.name(),
            first: result.first.clone(),
            probability: result.probability.map(|p| (p * 1e3).round() / 1e3),
            named: result.named.join(" "),
            harmful_work: result.harmful.join(" "),
            acceptable: case.acceptable.join(" "),
            piano: &case.piano,
            concluded: &case.concluded,
            source: &case.source,
            read: &case.read,
            entered: case.note.as_deref(),
        }
    }
}

#[derive(Debug, Serialize)]
struct Report<'a> {
    cases: usize,
    keys: usize,
    met: usize,
    missed: usize,
    harmful: usize,
    rows: Vec<CaseRow<'a>>,
}

/// Runs the cases and prints their table, misses first.
pub(crate) fn run(
    session: &mut Session,
    out: &OutOptions,
    Which(names): &Which,
    fail_on_miss: bool,
) -> Result<Answer, Failure> {
    let table = Cases::builtin();
    let cases: Vec<&Case> = table.cases.iter().filter(|case| names.iter().any(|name| is_called(case, name))).collect();
    let mut output = out.prepare(session, "validate", &["cases.json", "cases.csv"])?;
    let mut results: Vec<(&Case, CaseResult)> = Vec::new();
    let mut progress = session.progress("diagnosing");
    for (done, case) in cases.iter().enumerate() {
        progress.tell(done as f64 / cases.len() as f64);
        results.extend(case.run().map_err(Failure::Usage)?.into_iter().map(|result| (*case, result)));
    }
    drop(progress);
    results.sort_by_key(|(_, result)| result.verdict);
    let count = |verdict: CaseVerdict| results.iter().filter(|(_, result)| result.verdict == verdict).count();
    let report = Report {
        cases: cases.len(),
        keys: results.len(),
        met: count(CaseVerdict::Met),
        missed: count(CaseVerdict::Missed),
        harmful: count(CaseVerdict::Harmful),
        rows: results.iter().map(|(case, result)| CaseRow::of(case, result)).collect(),
    };
    output.json(session, "cases.json", &report)?;
    output.table(session, "cases.csv", &Table::of_records(&report.rows)?)?;
    let written = output.commit(session)?;
    print_line!(
        session,
        "{} published pianos, {} keys diagnosed: {} met, {} missed, {} with harmful work",
        report.cases,
        report.keys,
        report.met,
        report.missed,
        report.harmful
    );
    let answer = Answer::of(&report)?;
    let heads = ["case", "key", "basis", "verdict", "named first", "acceptable"];
    let row = |row: &CaseRow<'_>| {
        let first = match row.probability {
            Some(p) => format!("{} {:.0} %", row.first, 100.0 * p),
            None => row.first.clone(),
        };
        let harm = if row.harmful_work.is_empty() { String::new() } else { format!(": {}", row.harmful_work) };
        let verdict = format!("{}{harm}", row.verdict);
        [row.name.to_owned(), row.note.clone(), row.basis.to_owned(), verdict, first, row.acceptable.clone()]
    };
    // Misses and harmful work come first.
    let missed = report.missed + report.harmful;
    let worst = Table::of(heads, report.rows.iter().take(missed.max(1)).map(row)).lines();
    let adds = "the other cases, each with the cause that is named first and the acceptable ones";
    Answer::begin_with_part(session, &worst, adds);
    print_line!(session, "{}", Table::of(heads, report.rows.iter().map(row)));
    print_line!(session, "  Readings, sources and what was found are in cases.csv and validation/cases.toml.");
    print_line!(session);
    let answer = answer.end(session, &written);
    let misses = report.missed + report.harmful;
    Ok(if misses > 0 && fail_on_miss {
        answer.short_of(Some(format!("{misses} keys of cases missed")))
    } else {
        answer
    })
}

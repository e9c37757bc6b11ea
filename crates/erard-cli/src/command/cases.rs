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

/// Keys by their verdicts.
#[derive(Debug, Serialize)]
struct Counts {
    keys: usize,
    met: usize,
    missed: usize,
    harmful: usize,
}

impl Counts {
    fn of<'a>(results: impl Iterator<Item = &'a CaseResult>) -> Self {
        let mut counts = Counts { keys: 0, met: 0, missed: 0, harmful: 0 };
        for result in results {
            counts.keys += 1;
            match result.verdict {
                CaseVerdict::Met => counts.met += 1,
                CaseVerdict::Missed => counts.missed += 1,
                CaseVerdict::Harmful => counts.harmful += 1,
            }
        }
        counts
    }

    fn text(&self) -> String {
        format!("{} met, {} missed, {} with harmful work", self.met, self.missed, self.harmful)
    }
}

#[derive(Debug, Serialize)]
struct Report<'a> {
    cases: usize,
    #[serde(flatten)]
    counts: Counts,
    /// The keys of cases that judge.
    judging: Counts,
    rows: Vec<CaseRow<'a>>,
}

/// Runs the cases and prints their table, misses first, and of these the cases that judge.
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
    results.sort_by_key(|(case, result)| (result.verdict, case.used == CaseUse::Choose));
    let judging = results.iter().filter(|(case, _)| case.used == CaseUse::Judge);
    let report = Report {
        cases: cases.len(),
        counts: Counts::of(results.iter().map(|(_, result)| result)),
        judging: Counts::of(judging.map(|(_, result)| result)),
        rows: results.iter().map(|(case, result)| CaseRow::of(case, result)).collect(),
    };
    output.json(session, "cases.json", &report)?;
    output.table(session, "cases.csv", &Table::of_records(&report.rows)?)?;
    let written = output.commit(session)?;
    let Report { counts, judging, .. } = &report;
    print_line!(session, "{} published pianos, {} keys diagnosed: {}", report.cases, counts.keys, counts.text());
    if judging.keys > 0 && judging.keys < counts.keys {
        print_line!(session, "Of the {} keys that judge: {}", judging.keys, judging.text());
    }
    let answer = Answer::of(&report)?;
    let heads = ["case", "key", "use", "basis", "verdict", "named first", "acceptable"];
    let row = |row: &CaseRow<'_>| {
        let first = match row.probability {
            Some(p) => format!("{} {:.0} %", row.first, 100.0 * p),
            None => row.first.clone(),
        };
        let harm = if row.harmful_work.is_empty() { String::new() } else { format!(": {}", row.harmful_work) };
        let verdict = format!("{}{harm}", row.verdict);
        let [used, basis] = [row.used, row.basis].map(str::to_owned);
        [row.name.to_owned(), row.note.clone(), used, basis, verdict, first, row.acceptable.clone()]
    };
    // Misses and harmful work come first.
    let misses = counts.missed + counts.harmful;
    let worst = Table::of(heads, report.rows.iter().take(misses.max(1)).map(row)).lines();
    let adds = "the other cases, each with the cause that is named first and the acceptable ones";
    Answer::begin_with_part(session, &worst, adds);
    print_line!(session, "{}", Table::of(heads, report.rows.iter().map(row)));
    print_line!(session, "  Readings, sources and what was found are in cases.csv and validation/cases.toml.");
    print_line!(session);
    let answer = answer.end(session, &written);
    Ok(if misses > 0 && fail_on_miss {
        answer.short_of(Some(format!("{misses} keys of cases missed")))
    } else {
        answer
    })
}

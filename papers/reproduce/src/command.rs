//! The command line of `erard-reproduce`.

use std::process::ExitCode;

use clap::{CommandFactory, Parser};
use erard_cli::answer::Answer;
use erard_cli::command::out::OutOptions;
use erard_cli::command::{run_program, version};
use erard_cli::failure::Failure;
use erard_cli::inputs::shown;
use erard_cli::instruments::load_instrument;
use erard_cli::print_line;
use erard_cli::printer::OutputMode;
use erard_cli::session::Session;
use erard_cli::table::Table as Lines;
use erard_figures::figure::chart_picture;
use serde::Serialize;

use crate::page::{Reproduced, page};
use crate::subjects::{Claim, ReproduceError, Subject, subjects};

#[derive(Serialize)]
struct Subjects {
    subjects: Vec<Listed>,
}

#[derive(Serialize)]
struct Listed {
    name: &'static str,
    title: &'static str,
}

/// Output of `--json`.
#[derive(Serialize)]
struct Claims<'a> {
    instrument: &'a str,
    hold: usize,
    of: usize,
    claims: Vec<ClaimReport>,
}

#[derive(Serialize)]
struct ClaimReport {
    subject: &'static str,
    source: &'static str,
    claim: String,
    measured: String,
    holds: bool,
}

impl ClaimReport {
    fn all(one: &Reproduced) -> Vec<Self> {
        let report = |claim: &Claim| ClaimReport {
            subject: one.subject.name,
            source: claim.source,
            claim: claim.says.clone(),
            measured: claim.measured.clone(),
            holds: claim.holds,
        };
        one.section.claims.iter().map(report).collect()
    }
}

/// Computes the figures and claims of the papers again, and writes a page that shows which claims hold.
#[derive(Debug, Parser)]
#[command(name = "erard-reproduce", version = version(), about, max_term_width = 100)]
pub(crate) struct Reproduce {
    /// Instrument: a TOML file, or a built-in name
    #[arg(long, value_name = "FILE-OR-NAME", default_value = "concert-grand-rigid")]
    instrument: erard::instrument_spec::InstrumentSpec,
    /// Only these subjects, by names or their beginnings, with commas
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    only: Vec<String>,
    /// List the subjects and stop
    #[arg(long, conflicts_with_all = ["only", "figures", "tables", "out", "force"])]
    list: bool,
    /// Exit with code 1 if a claim does not hold
    #[arg(long)]
    fail_on_miss: bool,
    /// Also write each figure as a file: NAME-0.svg and so on
    #[arg(long)]
    figures: bool,
    /// Print the tables instead of the claims, without those of measured computing times
    #[arg(long)]
    tables: bool,
    #[command(flatten)]
    out: OutOptions,
    #[command(flatten)]
    mode: OutputMode,
}

/// Runs the command line of this process; exit codes are those of `erard`.
pub fn run() -> ExitCode {
    let folder = |argument: clap::Arg| argument.default_value("erard-out-reproduce");
    let definition = Reproduce::command().mut_arg("out", folder);
    run_program(&definition, |reproduce: &Reproduce| reproduce.mode, Reproduce::run)
}

/// Converts a subject's error to a failure of the command.
fn failure(error: ReproduceError) -> Failure {
    match error {
        ReproduceError::Simulation(error) => error.into(),
        ReproduceError::Compare(error) => error.into(),
        ReproduceError::OneDof(error) => error.into(),
        ReproduceError::Levers(error) => Failure::Usage(error.to_string()),
        ReproduceError::Invalid(error) => Failure::Usage(error.to_string()),
        ReproduceError::Index(error) => Failure::Usage(error.to_string()),
        ReproduceError::Instrument(text) => Failure::Usage(text),
    }
}

impl Reproduce {
    fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        if self.list {
            let rows = subjects().into_iter().map(|subject| [subject.name.to_owned(), subject.title.to_owned()]);
            print_line!(session, "{}", Lines::of(["", ""], rows).to_string().trim_end_matches('\n'));
            let named = |subject: &Subject| Listed { name: subject.name, title: subject.title };
            return Answer::of(&Subjects { subjects: subjects().iter().map(named).collect() });
        }
        let chosen = self.chosen()?;
        let instrument = load_instrument(session, &self.instrument)?;
        let mut output = self.out.prepare(session, "reproduce", &["report.html"])?;
        let all: f64 = chosen.iter().map(|s| s.weight).sum();
        let mut done = 0.0;
        let mut reproduced = Vec::new();
        for subject in chosen {
            let mut progress = session.progress(subject.name);
            let section = (subject.run)(&instrument, &mut |share| progress.tell((done + share * subject.weight) / all))
                .map_err(failure)?;
            drop(progress);
            done += subject.weight;
            reproduced.push(Reproduced { subject, section });
        }
        let html = page(&instrument.name, &reproduced);
        output.text(session, "report.html", &html)?;
        let mut written = vec!["report.html".to_owned()];
        if self.figures {
            for one in &reproduced {
                for (index, chart) in one.section.charts.iter().enumerate() {
                    let id = format!("{}-{index}", one.subject.name);
                    let name = format!("{id}.svg");
                    output.text(session, &name, &chart_picture(chart, &id).svg())?;
                    written.push(name);
                }
            }
        }
        let files = output.commit(session)?;
        let claims =
            || reproduced.iter().flat_map(|one| one.section.claims.iter().map(|claim| (one.subject.name, claim)));
        print_line!(
            session,
            "{} of {} claims hold.",
            claims().filter(|(_, claim)| claim.holds).count(),
            claims().count()
        );
        print_line!(session);
        if self.tables {
            let tables = reproduced.iter().flat_map(|one| &one.section.tables);
            for table in tables.filter(|table| !table.clock) {
                print_line!(session, "{}", table.caption);
                print_line!(session, "{}", Lines::of(table.header.iter().map(String::as_str), table.rows.clone()));
            }
        } else {
            for (verdict, holds) in [("DOES NOT HOLD", false), ("holds", true)] {
                for (subject, claim) in claims().filter(|(_, claim)| claim.holds == holds) {
                    print_line!(session, "{subject}: {verdict}: {}: {}", claim.source, claim.says);
                    print_line!(session, "  measured: {}", claim.measured);
                }
            }
            print_line!(session);
        }
        print_line!(session, "Written to {}: {}", shown(self.out.folder()), written.join(", "));
        let claims: Vec<ClaimReport> = reproduced.iter().flat_map(ClaimReport::all).collect();
        let failed: Vec<String> =
            claims.iter().filter(|c| !c.holds).map(|c| format!("{}: {}: {}", c.subject, c.source, c.claim)).collect();
        let answer = Answer::of(&Claims {
            instrument: &instrument.name,
            hold: claims.len() - failed.len(),
            of: claims.len(),
            claims,
        })?;
        let missed = (self.fail_on_miss && !failed.is_empty())
            .then(|| format!("{} claims do not hold\n       {}", failed.len(), failed.join("\n       ")));
        Ok(answer.files(&files).short_of(missed))
    }

    /// The requested subjects, in their own order.
    fn chosen(&self) -> Result<Vec<Subject>, Failure> {
        let known = subjects();
        for name in &self.only {
            if name.is_empty() || !known.iter().any(|s| s.name.starts_with(name.as_str())) {
                let names: Vec<&str> = known.iter().map(|s| s.name).collect();
                return Err(Failure::Usage(format!(
                    "--only {name}: unknown subject; expected one of {}, or the beginning of some",
                    names.join(", ")
                )));
            }
        }
        let wanted =
            |s: &Subject| self.only.is_empty() || self.only.iter().any(|name| s.name.starts_with(name.as_str()));
        Ok(known.into_iter().filter(wanted).collect())
    }
}

//! `erard diagnose`.

use std::path::{Path, PathBuf};

use clap::{Arg, ArgMatches, Args, FromArgMatches};
use erard::instrument::utf8;
use erard::keyboard::key_named;
use erard::parameter::aliases;
use erard_workshop::diagnose::{
    Entry, Known, answer as diagnosis_json, diagnose_all, entries, read, readings, unused_columns,
};
use erard_workshop::measure::norms::MIDDLE_C;
use serde_json::Value;

use super::measure::leads;
use super::options::key;
use super::out::OutOptions;
use crate::answer::Answer;
use crate::diagnose::{Work, headlines, html, table, text, title};
use crate::failure::Failure;
use crate::inputs;
use crate::paper::PageHeader;
use crate::print_line;
use crate::session::Session;
use crate::units::Lengths;
use crate::warn;

/// What stands below the options.
const AFTER: &str = include_str!("help/diagnose.txt");

/// Ranks what may be wrong with a key of your own piano, from whatever was measured of it.
///
/// Readings are options, a table of many keys, or the measure.json of `erard measure`.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Diagnose {
    /// A table of readings (CSV), a row for each key, columns named as the options are; or a measure.json
    #[arg(value_name = "READINGS")]
    file: Option<PathBuf>,
    /// Key, by number (1 to 88) or note (A0 to C8); it selects the usual ranges [default: C4]
    #[arg(long, value_name = "KEY", value_parser = key, allow_negative_numbers = true)]
    key: Option<usize>,
    #[command(flatten)]
    readings: Readings,
    /// The key's leads, g@mm in front of the balance pin with commas (14@165,14@147; behind it negative)
    #[arg(long, value_name = "G@MM,..", allow_hyphen_values = true)]
    leads: Vec<String>,
    #[command(flatten)]
    lengths: Lengths,
    #[command(flatten)]
    page_header: PageHeader,
    #[command(flatten)]
    out: OutOptions,
}

/// One option for each thing that can be measured, made of the workshop's table.
#[derive(Debug, Clone)]
struct Readings(Vec<(&'static Entry, String)>);

/// The option of an entry: its name without the unit.
fn option(entry: &Entry) -> String {
    let ends = ["_m_per_s", "_share", "_mm", "_g"];
    let bare = ends.iter().find_map(|end| entry.name.strip_suffix(end)).unwrap_or(entry.name);
    bare.replace('_', "-")
}

impl Args for Readings {
    fn augment_args(command: clap::Command) -> clap::Command {
        readings().fold(command, |command, entry| {
            let long = option(entry);
            let names = std::iter::once(entry.name).chain(entry.also.iter().copied());
            let names = names.flat_map(|name| [vec![name.to_owned()], aliases(name)].concat());
            let aliases = names.map(|name| name.replace('_', "-")).filter(|name| *name != long);
            let unit = if entry.unit.is_empty() { "NUMBER" } else { entry.unit };
            let arg = Arg::new(entry.name)
                .long(long.clone())
                .aliases(aliases.collect::<Vec<_>>())
                .value_name(unit.to_uppercase())
                .help(format!("{}: {}", entry.label, entry.how))
                .help_heading("Readings, whatever subset was taken")
                .allow_hyphen_values(true);
            command.arg(arg)
        })
    }

    fn augment_args_for_update(command: clap::Command) -> clap::Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Readings {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let given = |entry: &'static Entry| Some((entry, matches.get_one::<String>(entry.name)?.clone()));
        Ok(Readings(readings().filter_map(given).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

impl Diagnose {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let keys = match &self.file {
            None => vec![self.given()?],
            Some(path) => self.of_file(session, path)?,
        };
        let mut output = self.out.prepare(session, "diagnose", &["diagnosis.json", "diagnosis.html"])?;
        let mut progress = session.progress("diagnosing");
        let found = diagnose_all(&keys, &mut |share| progress.tell(share));
        drop(progress);
        let name = self.file.as_deref().map(inputs::shown);
        let is_key_assumed = self.file.is_none() && self.key.is_none();
        let work = Work {
            file: name.as_deref(),
            is_key_assumed,
            found: &found,
            page_header: &self.page_header,
            lengths: self.lengths,
        };
        output.text(session, "diagnosis.html", &html(&work))?;
        let found_json = diagnosis_json(&found, work.file, is_key_assumed);
        output.json(session, "diagnosis.json", &found_json)?;
        if found.len() > 1 {
            output.table(session, "diagnosis.csv", &table(&work))?;
        }
        let written = output.commit(session)?;
        let answer = Answer::of(&found_json)?;
        let adds = match found.len() {
            1 => {
                "all readings with their usual ranges, how to test and cure each cause, and what the next reading decides"
            }
            _ => "every key with work, its causes, and what is uneven",
        };
        print_line!(session, "{}", title(&work));
        answer.begin(session, headlines, adds);
        print_line!(session, "{}", text(&work).trim_end_matches('\n'));
        print_line!(session);
        Ok(answer.end(session, &written))
    }

    /// What the options say of one key.
    fn given(&self) -> Result<(usize, Known), Failure> {
        let key = self.key.unwrap_or(MIDDLE_C);
        let mut known = Known::default();
        known.leads = leads(&self.leads)?;
        for (entry, text) in &self.readings.0 {
            let wrong = |expected: String| Failure::Usage(format!("--{} {text}: expected {expected}", option(entry)));
            known.enter(entry, text).map_err(wrong)?;
        }
        known.settle(key).map_err(|error| Failure::Usage(error.to_string()))?;
        if known.is_empty() {
            return Err(Failure::Usage(
                "no reading was given; expected options such as --down-weight 58 --up-weight 18, a table (CSV), or a measure.json; \
                 `erard diagnose --help` names them all"
                    .into(),
            ));
        }
        known.check().map_err(|error| Failure::Usage(error.to_string()))?;
        Ok((key, known))
    }

    /// The keys of a table, or of a sheet.
    fn of_file(&self, session: &mut Session, path: &Path) -> Result<Vec<(usize, Known)>, Failure> {
        if !self.readings.0.is_empty() || !self.leads.is_empty() {
            let file = inputs::shown(path);
            let why =
                "found readings both in a table and as options; expected one of the two (a table takes more columns)";
            return Err(Failure::Usage(format!("{file}: {why}")));
        }
        let (file, bytes) = session.inputs.bytes(path)?;
        session.provenance.used("readings", &file, Some(&file), &bytes);
        let text = utf8(&bytes, &file)?;
        if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json")) {
            return self.of_sheets(text, &file);
        }
        if self.key.is_some() {
            return Err(Failure::Usage(format!("{file}: --key goes with options; the table names its keys")));
        }
        let keys = read(text, &file).map_err(|error| Failure::Usage(error.to_string()))?;
        let unused = unused_columns(text, &file);
        if !unused.is_empty() {
            warn!(session, "warning: {file}: columns that were not used: {}", unused.join(", "));
        }
        Ok(keys)
    }

    /// What `erard measure` wrote: one sheet, or a list of them.
    fn of_sheets(&self, text: &str, file: &str) -> Result<Vec<(usize, Known)>, Failure> {
        let wrong = |why: &str| Failure::Usage(format!("{file}: {why}; expected the measure.json of `erard measure`"));
        let value: Value = serde_json::from_str(text).map_err(|error| wrong(&error.to_string()))?;
        // An answer of `measure --json` to several instruments is a record with them.
        let all = value.get("instruments").unwrap_or(&value);
        let sheets = all.as_array().cloned().unwrap_or_else(|| vec![all.clone()]);
        let mut keys = Vec::new();
        for sheet in &sheets {
            let key = sheet["norms_for_key"].as_u64().and_then(|key| key_named(&key.to_string()));
            let key = self.key.or(key).ok_or_else(|| wrong("it names no key"))?;
            let mut known = Known::default();
            for entry in entries() {
                // The ratio of the sheet follows from its weights: no reading of its own.
                known.set(entry.name, sheet[entry.name].as_f64());
            }
            known.is_not_caught = sheet.get("check_mm").is_some_and(Value::is_null);
            if known.is_empty() {
                return Err(wrong("it holds no reading"));
            }
            known.check().map_err(|error| wrong(&error.to_string()))?;
            keys.push((key, known));
        }
        Ok(keys)
    }
}

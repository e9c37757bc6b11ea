//! `erard list`.

use clap::Args;
use erard::instrument::Instrument;
use erard::instrument_spec::{InstrumentSpecError, SAMPLE};
use erard::keyboard::Keyboard;
use erard::stroke::{NUANCES, Series, Touch};
use erard_kinematics::LinkageFile;
use serde::Serialize;

use crate::answer::Answer;
use crate::failure::Failure;
use crate::instruments::sample_text;
use crate::print_line;
use crate::session::Session;
use crate::suggest::meant;
use crate::table::Table;

/// Lists the built-in instruments, keyboards, linkages and strokes, or prints the file of one.
#[derive(Debug, Args)]
pub(crate) struct List {
    /// Kind to list (`instruments`, `keyboards`, `linkages`, `strokes`), or name of the file to print: an instrument, a
    /// linkage, a stroke (`mf-struck`), `keyboard:NAME`, or a sample (`concert-grand:sample=17`,
    /// `concert-grand:key=88:sample=17`)
    #[arg(value_name = "NAME")]
    name: Option<String>,
}

/// Something built in.
#[derive(Debug, Serialize)]
struct BuiltIn {
    kind: &'static str,
    name: String,
    title: String,
    #[serde(skip)]
    text: &'static str,
}

/// What can be listed alone.
const KINDS: [&str; 4] = ["instruments", "keyboards", "linkages", "strokes"];

/// What `--json` answers.
#[derive(Debug, Serialize)]
struct Listed {
    built_in: Vec<BuiltIn>,
}

fn all() -> Vec<BuiltIn> {
    let entry = |kind, name: &str, title: String, text: Option<&'static str>| {
        text.map(|text| BuiltIn { kind, name: name.to_owned(), title, text })
    };
    let instruments = Instrument::builtin_names().filter_map(|name| {
        entry("instrument", name, Instrument::builtin(name).ok()?.name.clone(), Instrument::builtin_text(name))
    });
    let keyboards = Keyboard::builtin_names()
        .filter_map(|name| entry("keyboard", name, Keyboard::builtin(name).ok()?.name, Keyboard::builtin_text(name)));
    let linkages = LinkageFile::builtin_names()
        .filter_map(|name| entry("linkage", name, LinkageFile::builtin(name)?.name, LinkageFile::builtin_text(name)));
    let strokes = NUANCES.into_iter().flat_map(|nuance| {
        [(Touch::Pressed, "pressed"), (Touch::Struck, "struck")].into_iter().filter_map(move |(touch, how)| {
            let title = format!("--stroke {nuance} --touch {how}");
            entry("stroke", &format!("{nuance}-{how}"), title, Series::builtin_text(nuance, touch))
        })
    });
    instruments.chain(keyboards).chain(linkages).chain(strokes).collect()
}

/// A built-in file by its name, with its kind; the kind may stand before it.
pub(crate) fn built_in(asked: &str) -> Option<(&'static str, &'static str)> {
    let (kind, name) = asked.split_once(':').map_or((None, asked), |(kind, name)| (Some(kind), name));
    all()
        .into_iter()
        .find(|one| one.name == name && kind.is_none_or(|kind| kind == one.kind))
        .map(|one| (one.kind, one.text))
}

impl List {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        if let Some(name) = &self.name {
            if name.contains(SAMPLE) {
                let asked = name.parse().map_err(|error: InstrumentSpecError| Failure::Usage(error.to_string()))?;
                return Ok(Answer::text(sample_text(session, &asked)?));
            }
            if let Some(kind) = KINDS.iter().find(|kind| *kind == name || kind.trim_end_matches('s') == name) {
                let mut some = all();
                some.retain(|one| one.kind == kind.trim_end_matches('s'));
                return print(session, some);
            }
            let (_, text) = built_in(name).ok_or_else(|| {
                let mut names: Vec<String> = Vec::new();
                for BuiltIn { kind, name, .. } in all() {
                    names.push(if names.contains(&name) { format!("{kind}:{name}") } else { name });
                }
                let meant = meant(name, names.iter().map(String::as_str).chain(KINDS));
                Failure::Usage(format!("there is no built-in `{name}`; expected one of {}{meant}", names.join(", ")))
            })?;
            return Ok(Answer::text(text));
        }
        print(session, all())
    }
}

/// Prints what is built in, kind by kind.
fn print(session: &mut Session, built_in: Vec<BuiltIn>) -> Result<Answer, Failure> {
    let mut rows: Vec<[String; 2]> = Vec::new();
    for (at, one) in built_in.iter().enumerate() {
        let before = at.checked_sub(1).map(|before| built_in[before].kind);
        if before != Some(one.kind) {
            rows.extend(before.map(|_| Default::default()));
            rows.push([format!("{}s", one.kind), String::new()]);
        }
        rows.push([format!("  {}", one.name), one.title.clone()]);
    }
    print_line!(session, "{}", Table::of(["", ""], rows));
    print_line!(
        session,
        "Copy one to edit it: `erard list NAME > FILE`. Each key of a keyboard is an instrument: NAME:key=1 to 88"
    );
    Answer::of(&Listed { built_in })
}

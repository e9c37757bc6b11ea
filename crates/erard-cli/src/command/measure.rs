//! `erard measure`.

use std::path::Path;

use clap::Args;
use erard::instrument::Instrument;
use erard::instrument_spec::InstrumentSpec;
use erard::player::{AtRest, RestKind, RestPose};
use erard::run::SimulationError;
use erard_workshop::balance::Lead;
use erard_workshop::cores::{self, Ending};
use erard_workshop::measure::norms::{Line, page_lines};
use erard_workshop::measure::{MeasureError, Sheet, measure, measure_some};
use erard_workshop::sample::unless_interrupted;
use erard_workshop::worklist::{Readings, worklist};
use moreau::Settings;
use serde_json::Value;

use super::bands::{self, BandOptions};
use super::options::{RestBefore, Stays, key, measured_lines};
use super::out::OutOptions;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::instruments::{load_instrument, load_instrument_and_text};
use crate::measure::figures::{Drawn, figures};
use crate::measure::headlines::{READ_AGAIN, STAYS_OUT};
use crate::measure::rows::{self, MeasuredRow};
use crate::measure::{Measured, doubts, headlines, page, table};
use crate::number::whole;
use crate::paper::PageHeader;
use crate::print_line;
use crate::session::Session;
use crate::sheet::{self, AdvisedInstrument, ORDER, before_and_after, beyond, in_the_end, left, tasks};
use crate::table::spaced;
use crate::units::Lengths;
use crate::warn;
use erard_figures::drawing::{PoseOptions, pose_picture};

/// Text below the options.
const AFTER: &str = include_str!("help/measure.txt");

/// Measures an action as a technician does: weights, ratios, regulation, inertia, timing, repetition.
///
/// Several instruments get a column each.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Measure {
    /// Instruments: TOML files, built-in names, or keys of a keyboard (concert-grand:key=88). Many keys
    /// (concert-grand:key=1..88, concert-grand:key=1,40,88) get a row each [default: concert-grand]
    #[arg(value_name = "INSTRUMENT")]
    instruments: Vec<String>,
    /// One more instrument; can be repeated
    #[arg(long = "instrument", value_name = "FILE-OR-NAME")]
    more: Vec<String>,
    /// Print a row per instrument with these quantities only: keys of measure.json with commas [default for many keys:
    /// weights, ratio, inertia, distances, repetition]
    #[arg(long, value_name = "KEY,KEY,..", value_delimiter = ',', conflicts_with = "sheet")]
    only: Vec<String>,
    /// Also write the technician's sheet, one page per instrument to print: what to turn, and by how much (sheet.html,
    /// sheet.json)
    #[arg(long)]
    sheet: bool,
    /// How the action comes to rest before everything that is measured. The list of --sheet takes it as played
    #[arg(long, value_name = "REST", value_enum, default_value = "as-played")]
    rest: RestBefore,
    /// With --sheet: what to keep if dip and aftertouch cannot both be in range. The other changes within its range,
    /// then the blow
    #[arg(long, value_name = "WHAT", value_enum, default_value = "aftertouch", requires = "sheet")]
    priority: Stays,
    /// With --sheet: the leads in the key, as grams at mm in front of the balance pin (14@165,14@147; negative is
    /// behind it). The work list moves or removes them before it adds new ones
    #[arg(long, value_name = "G@MM,..", requires = "sheet", allow_hyphen_values = true)]
    leads: Vec<String>,
    /// With --sheet: also write the instrument file as it is after the work, or after its first LINES lines
    /// (carried-out.toml)
    #[arg(long, value_name = "LINES", requires = "sheet", num_args = 0..=1, require_equals = true, value_parser = whole::<u8>(1, u64::MAX), default_missing_value = "255")]
    carry_out: Option<u8>,
    /// Key of the instrument, by number (1 to 88) or note (A0 to C8), which selects the usual ranges [default: that of
    /// the instrument, else C4]
    #[arg(long, value_name = "KEY", value_parser = key, allow_negative_numbers = true)]
    key: Option<usize>,
    #[command(flatten)]
    lengths: Lengths,
    #[command(flatten)]
    bands: BandOptions,
    #[command(flatten)]
    page_header: PageHeader,
    #[command(flatten)]
    out: OutOptions,
}

/// Rows of a long table that are printed first.
const FIRST_ROWS: usize = 7;

/// Most instruments side by side: more columns than a page is wide.
const MAX_PAGES: usize = 12;

impl Measure {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        let asked = self.asked()?;
        let many = asked.len() > self.instruments.len() + self.more.len() && asked.len() > 1;
        if let Some(count) = self.bands.bands {
            return self.banded(session, &asked, count);
        }
        if many || !self.only.is_empty() {
            return self.rows(session, &asked);
        }
        let named = self.load(session, &asked)?;
        let leads = leads(&self.leads)?;
        let texts = asked
            .iter()
            .filter(|_| self.carry_out.is_some())
            .map(|name| Ok(load_instrument_and_text(session, name)?.1));
        let texts = texts.collect::<Result<Vec<String>, Failure>>()?;
        let mut output = self.out.prepare(session, "measure", &["measure.json", "measure.html"])?;
        let mut progress = session.progress("measuring");
        let count = named.len() as f64;
        let mut measured = Vec::new();
        // A sheet's screws are tried when it has been measured: a fifth of the work.
        let measuring = if self.sheet { 0.8 } else { 1.0 };
        for (index, LabelledInstrument { label, instrument }) in named.into_iter().enumerate() {
            let mut tell = |share: f64| progress.tell(measuring * (index as f64 + share) / count);
            let failed = |error| Failure::Measure { label: label.clone(), error: Box::new(error) };
            let rest = RestPose::of(&instrument, self.rest.into(), &mut tell).map_err(|error| failed(error.into()))?;
            let sheet = measure(&rest, &mut tell).map_err(failed)?;
            measured.push(Measured { label, rest, sheet });
        }
        let drawings = drawings(&measured)?;
        let mut advised = Vec::new();
        for (index, one) in measured.iter().enumerate().filter(|_| self.sheet) {
            progress.say("working out the list");
            let mut tell = |share: f64| progress.tell(0.8 + 0.2 * (index as f64 + share) / count);
            let readings = Readings::on(&one.sheet);
            let list = worklist(one.rest.instrument(), &readings, &leads, self.priority.into(), &mut tell)?;
            let drawing = drawings.get(index).map_or(String::new(), |drawn| drawn.picture.svg());
            advised.push(AdvisedInstrument {
                measured: one,
                list,
                drawing,
                page_header: &self.page_header,
                lengths: self.lengths,
            });
        }
        drop(progress);

        let figures = figures(&measured);
        for drawn in drawings.iter().chain(&figures) {
            output.figure(session, &drawn.name, &drawn.picture)?;
        }
        let reports: Vec<Value> = advised.iter().map(sheet::report).collect();
        let sheets: Vec<&Sheet> = measured.iter().map(|one| &one.sheet).collect();
        match sheets[..] {
            [one] => output.json(session, "measure.json", one)?,
            _ => output.json(session, "measure.json", &sheets)?,
        }
        let page = page::html(&measured, &drawings, &figures, &self.page_header, self.lengths);
        output.text(session, "measure.html", &page)?;
        if self.sheet {
            output.text(session, "sheet.html", &sheet::html(&advised))?;
            output.json(session, "sheet.json", &reports)?;
            for (index, one) in advised.iter().enumerate() {
                let Some(lines) = self.carry_out.map(usize::from) else { break };
                let (text, begun) = (texts.get(index).map_or("", String::as_str), one.measured.rest.instrument());
                let done = if lines < one.list.items.len() {
                    one.list.first(lines, begun, &mut |_| true)?.rewrite(begun, text)
                } else {
                    one.list.rewrite(begun, text)
                };
                let name = if advised.len() > 1 {
                    format!("carried-out-{}.toml", index + 1)
                } else {
                    "carried-out.toml".into()
                };
                output.text(session, &name, &done.map_err(|error| Failure::Internal(error.to_string()))?)?;
            }
        }
        let written = output.commit(session)?;

        let answer = answer(&sheets, reports)?;
        let labels: Vec<&str> = measured.iter().map(|one| one.label.as_str()).collect();
        match labels[..] {
            [one] if self.sheet => {
                print_line!(session, "{one} - technician's sheet");
                let adds = "the sheet before and after, the reason for each line, and what it reads then";
                answer.begin(session, headlines::of_sheet, adds);
            }
            [one] => {
                print_line!(session, "{one} - protocol sheet");
                let adds = "all lines of the sheet with their usual ranges, the timing and the free flight";
                answer.begin(session, |answer| headlines::of_one(answer, self.lengths), adds);
            }
            _ => {
                print_line!(session, "Protocol sheets side by side");
                let lists = if self.sheet { " and the lists of work" } else { "" };
                let adds = format!("all lines with their usual ranges, the timing, the free flight{lists}");
                answer.begin(session, |answer| headlines::of_several(answer, &labels, self.lengths), &adds);
            }
        }
        // Of one action the sheet has every line that work can set; the whole protocol is in measure.html.
        if !self.sheet || measured.len() > 1 {
            print_line!(session, "{}", table::text(&measured, self.lengths).trim_end_matches('\n'));
            print_line!(session);
        }
        for one in &measured {
            for doubt in doubts(&one.sheet) {
                warn!(session, "warning: {}: this result cannot be trusted: {doubt}", one.label);
            }
        }
        for one in &advised {
            print_line!(session, "{}", before_and_after(one).trim_end_matches('\n'));
            print_line!(session);
            let whose = if advised.len() > 1 { format!(" ({})", one.measured.label) } else { String::new() };
            let tasks = tasks(one);
            if tasks.is_empty() {
                print_line!(session, "  To do{whose}: nothing");
            } else {
                print_line!(session, "  To do{whose}, {ORDER}:");
            }
            for (index, task) in tasks.iter().enumerate() {
                print_line!(session, "    {}. {}: {}", index + 1, task.what, task.by);
                print_line!(session, "       {}", task.for_);
                if let Some(instead) = &task.instead {
                    print_line!(session, "       or instead: {instead}");
                }
                if let Some(then) = &task.then {
                    print_line!(session, "       then {then}");
                }
            }
            if let Some(in_the_end) = in_the_end(&one.list) {
                print_line!(session, "    in the end: {in_the_end}");
            }
            for heading in [READ_AGAIN, STAYS_OUT] {
                for line in left(&one.list, heading, self.lengths) {
                    print_line!(session, "    {}: {}", heading.to_lowercase(), line.why);
                }
            }
            for line in beyond(&one.measured.sheet) {
                print_line!(session, "    not by this list: {line}");
            }
            print_line!(session);
        }
        Ok(answer.end(session, &written))
    }

    /// What was asked for, many keys one by one.
    fn asked(&self) -> Result<Vec<InstrumentSpec>, Failure> {
        let mut asked = Vec::new();
        for one in self.instruments.iter().chain(&self.more).map(String::as_str) {
            asked.extend(InstrumentSpec::each(one).map_err(|error| Failure::Usage(error.to_string()))?);
        }
        if asked.is_empty() {
            asked.extend(InstrumentSpec::each("concert-grand").map_err(|error| Failure::Internal(error.to_string()))?);
        }
        Ok(asked)
    }

    /// The lines of one instrument's sheet with their bands.
    fn banded(&self, session: &mut Session, asked: &[InstrumentSpec], count: u32) -> Result<Answer, Failure> {
        let [asked] = asked else {
            return Err(Failure::Usage(format!("--bands needs one instrument; found {}", asked.len())));
        };
        if self.sheet {
            return Err(Failure::Usage("--bands and --sheet cannot be combined: a sheet describes one piano".into()));
        }
        let lines = if self.only.is_empty() { page_lines().collect() } else { measured_lines("--only", &self.only)? };
        let named = self.named(session, std::slice::from_ref(asked))?;
        let Some(one) = named.first() else { return Err(Failure::Internal("no instrument".into())) };
        let mut output = self.out.prepare(session, "measure", &["bands.csv", "bands.json"])?;
        let mut progress = session.progress("measuring");
        let kind = self.rest.into();
        let own = at_rest(&one.instrument, kind, &lines, &mut |share| progress.tell(share))
            .map_err(|error| Failure::Measure { label: one.label.clone(), error: Box::new(error) })?;
        drop(progress);
        let names: Vec<bands::NameAndUnit> =
            lines.iter().map(|line| (line.key.to_owned(), line.unit.to_owned())).collect();
        let keys: Vec<&str> = lines.iter().map(|line| line.key).collect();
        let kept = match kind {
            RestKind::AsPlayed => keys.join(","),
            RestKind::AsDrawn => format!("{}, as drawn", keys.join(",")),
        };
        let banded =
            bands::bands(session, asked, count, &names, &own, Some(("measured", &kept)), |instrument, _, progress| {
                unless_interrupted(at_rest(instrument, kind, &lines, progress)).map(Into::into)
            })?;
        banded.stage(session, &mut output)?;
        let written = output.commit(session)?;
        let answer = Answer::default().with("bands", &banded.rows)?.with("failed_samples", &banded.failed)?;
        print_line!(session, "{} - values and bands over {count} samples", one.label);
        let all = bands::lines(&banded.rows, count);
        Answer::begin_with_part(session, &all[..all.len().min(FIRST_ROWS)], "all values with their bands");
        all.iter().for_each(|line| print_line!(session, "{line}"));
        print_line!(session);
        Ok(answer.end(session, &written))
    }

    /// One row per instrument.
    fn rows(&self, session: &mut Session, asked: &[InstrumentSpec]) -> Result<Answer, Failure> {
        if self.sheet {
            return Err(Failure::Usage("--sheet writes one page per instrument; found a range of keys. Name the keys one by one: concert-grand:key=1 concert-grand:key=2".into()));
        }
        let lines = if self.only.is_empty() { rows::usual() } else { measured_lines("--only", &self.only)? };
        let named = self.named(session, asked)?;
        let mut output = self.out.prepare(session, "measure", &["measure.csv", "measure.json"])?;
        let mut progress = session.progress("measuring");
        let measure = |one: &LabelledInstrument, progress: &mut erard::Progress<'_>| match at_rest(
            &one.instrument,
            self.rest.into(),
            &lines,
            progress,
        ) {
            Err(error) if error.is_interruption() => Err(Unmeasured::from((one, error))),
            found => Ok(found.map_err(|error| Unmeasured::from((one, error)))),
        };
        let failure = |error: Unmeasured| Failure::Measure { label: error.label, error: error.error };
        let mut found =
            cores::map(&named, cores::count(), &mut |share| progress.tell(share), measure).map_err(failure)?;
        drop(progress);
        if found.iter().all(Result::is_err)
            && let Err(first) = found.swap_remove(0)
        {
            return Err(failure(first));
        }
        let row = |(one, found): (LabelledInstrument, Result<Vec<Option<f64>>, Unmeasured>)| MeasuredRow {
            label: one.label,
            key: one.instrument.key(),
            values: found.map_err(|unmeasured| unmeasured.error.to_string()),
        };
        let measured: Vec<MeasuredRow> = named.into_iter().zip(found).map(row).collect();
        for (label, error) in measured.iter().filter_map(|row| Some((&row.label, row.values.as_ref().err()?))) {
            warn!(session, "warning: {label}: {error}");
        }
        output.table(session, "measure.csv", &rows::table(&lines, &measured))?;
        let report = rows::json(&lines, &measured);
        output.json(session, "measure.json", &report)?;
        let written = output.commit(session)?;
        let answer = Answer::default().with("instruments", &report)?;
        print_line!(session, "{} measured", measured.len());
        let table = |rows: &[MeasuredRow]| rows::text(&lines, rows).lines().map(str::to_owned).collect::<Vec<_>>();
        let places = spaced(measured.len(), FIRST_ROWS);
        if places.len() == measured.len() {
            print_line!(session);
            table(&measured).iter().for_each(|line| print_line!(session, "{line}"));
            print_line!(session);
            return Ok(answer.end(session, &written));
        }
        let some: Vec<MeasuredRow> = places.iter().map(|at| measured[*at].clone()).collect();
        let adds = format!("the other {} rows", measured.len() - some.len());
        Answer::begin_with_part(session, &table(&some), &adds);
        table(&measured).iter().for_each(|line| print_line!(session, "{line}"));
        print_line!(session);
        Ok(answer.end(session, &written))
    }

    /// All instruments of a few, read before anything is measured, by labels that tell them apart.
    fn load(&self, session: &mut Session, asked: &[InstrumentSpec]) -> Result<Vec<LabelledInstrument>, Failure> {
        if asked.len() > MAX_PAGES {
            return Err(Failure::Usage(format!("{} instruments; expected at most {MAX_PAGES}", asked.len())));
        }
        self.named(session, asked)
    }

    fn named(&self, session: &mut Session, asked: &[InstrumentSpec]) -> Result<Vec<LabelledInstrument>, Failure> {
        let instruments = asked.iter().map(|one| self.one(session, one)).collect::<Result<Vec<_>, _>>()?;
        let shared = |name: &str| instruments.iter().filter(|other| other.name == name).count() > 1;
        // A file's own name, for a copy keeps the name of what it was copied from.
        let label = |asked: &InstrumentSpec, instrument: &Instrument| match asked.path() {
            _ if shared(&instrument.name) => asked.to_string(),
            Some(path) => format!("{} ({})", instrument.name, shown(Path::new(path.file_name().unwrap_or_default()))),
            None => instrument.name.clone(),
        };
        let labels: Vec<String> = asked.iter().zip(&instruments).map(|(asked, one)| label(asked, one)).collect();
        Ok(labels
            .into_iter()
            .zip(instruments)
            .map(|(label, instrument)| LabelledInstrument { label, instrument })
            .collect())
    }

    /// An instrument, as that of the key that `--key` names.
    fn one(&self, session: &mut Session, asked: &InstrumentSpec) -> Result<Instrument, Failure> {
        let mut instrument = load_instrument(session, asked)?;
        if let Some(key) = self.key {
            let wrong = |error| Failure::Usage(format!("--key with {asked}: {error}. Leave --key out"));
            instrument.set_key(key).map_err(wrong)?;
        }
        Ok(instrument)
    }
}

/// What was measured of each instrument, with its list of work as `sheet` where there is one: the fields of one
/// instrument, or `instruments` of several.
fn answer(sheets: &[&Sheet], reports: Vec<Value>) -> Result<Answer, Failure> {
    let mut all = sheets.iter().map(serde_json::to_value).collect::<Result<Vec<Value>, _>>()?;
    for (one, report) in all.iter_mut().zip(reports) {
        one["sheet"] = report;
    }
    match &all[..] {
        [one] => Answer::of(one),
        _ => Answer::default().with("instruments", &all),
    }
}

/// A lead: its mass in grams, and where it is in millimetres in front of the balance pin.
/// The leads in a key, of one option `--leads` or several.
pub(super) fn leads(options: &[String]) -> Result<Vec<Lead>, Failure> {
    let lists = options.iter().map(|text| Lead::read_list(text)).collect::<Result<Vec<_>, _>>();
    lists.map(|lists| lists.concat()).map_err(|error| Failure::Usage(format!("--leads {error}")))
}

/// An instrument by what it is called here.
struct LabelledInstrument {
    label: String,
    instrument: Instrument,
}

/// An action that could not be measured.
struct Unmeasured {
    label: String,
    error: Box<MeasureError>,
}

impl From<(&LabelledInstrument, MeasureError)> for Unmeasured {
    fn from((one, error): (&LabelledInstrument, MeasureError)) -> Self {
        Unmeasured { label: one.label.clone(), error: Box::new(error) }
    }
}

impl From<SimulationError> for Unmeasured {
    fn from(error: SimulationError) -> Self {
        Unmeasured { label: "a key".to_owned(), error: Box::new(error.into()) }
    }
}

impl Ending for Unmeasured {
    fn is_interruption(&self) -> bool {
        self.error.is_interruption()
    }
}

/// Lines of the sheet, from a rest of a kind.
fn at_rest(
    instrument: &Instrument,
    kind: RestKind,
    lines: &[&Line],
    progress: &mut erard::Progress<'_>,
) -> Result<Vec<Option<f64>>, MeasureError> {
    measure_some(&RestPose::of(instrument, kind, progress)?, lines, progress)
}

/// A drawing of each action at rest.
fn drawings(measured: &[Measured]) -> Result<Vec<Drawn>, Failure> {
    const STEP_S: f64 = 50e-6;
    let mut drawings = Vec::new();
    for (index, one) in measured.iter().enumerate() {
        let action = one.rest.action(Settings::new(STEP_S)).map_err(SimulationError::from)?;
        // No letters in it: on a phone nobody could read them, and the caption says what it is.
        let picture = pose_picture(one.rest.instrument(), action.angles(), &PoseOptions::default());
        let name = if measured.len() > 1 { format!("action-{}", index + 1) } else { "action".to_owned() };
        drawings.push(Drawn { name, alt: format!("{}, at rest", one.label), picture });
    }
    Ok(drawings)
}

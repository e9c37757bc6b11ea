//! `erard kinematics`.

use std::path::Path;

use clap::Args;
use erard::instrument::Instrument;
use erard::instrument_spec::InstrumentSpec;
use erard::parameter::Quantity;
use erard_kinematics::linkage::{Linkage, latex_align};
use erard_kinematics::three_lever::{Drive, Levers, Move, Regulation};
use erard_kinematics::{Agreement, Derived, Design, LinkageFile, SlowPress, derive, slow_press};
use serde_json::{Value, json};

use super::check::checked_linkage;
use super::out::OutOptions;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::instruments::load_instrument;
use crate::kinematics::moves::{self, AS_IT_IS, MoveOption, UNMOVED};
use crate::kinematics::{Shown, Summary, dynamics_picture, leverage_picture, sliding_picture, table};
use crate::number::number;
use crate::print_line;
use crate::session::Session;
use crate::suggest::meant;
use crate::table::Table;
use crate::warn;

/// Text below the options.
const AFTER: &str = include_str!("help/kinematics.txt");

/// Shows leverage and sliding over the key's travel, from the geometry alone.
///
/// The levers come from a linkage file with the lengths L1 to L10, or from the same instrument file that `press` uses.
#[derive(Debug, Args)]
#[command(after_help = AFTER)]
pub(crate) struct Kinematics {
    /// Linkage of three levers: a TOML file of kind `three-lever`, or the built-in c7f-like or steinway-o-like
    #[arg(value_name = "LINKAGE.toml", conflicts_with = "instrument")]
    linkage: Option<String>,
    /// Instrument: a TOML file, or a built-in name [default: concert-grand]
    #[arg(long, value_name = "FILE-OR-NAME")]
    instrument: Option<InstrumentSpec>,
    /// Move a part and show it with the unmoved case; can be repeated. Distances have a unit; negative is toward the
    /// player (x) or down. Parts: capstan, knuckle, capstan-height, heel-depth, knuckle-depth, jack-height, whippen-x,
    /// whippen-y, hammer-x, hammer-y; commas move several at once
    #[arg(long = "move", value_name = "capstan=-10mm", value_parser = moves::parse)]
    moves: Vec<MoveOption>,
    /// Do not turn the capstan screw to bring the hammer of a moved case back to its rest height
    #[arg(long)]
    no_regulate: bool,
    /// First key travel, mm
    #[arg(long, value_name = "MM", default_value_t = 0.0, value_parser = number(Quantity::Length, "mm"), allow_hyphen_values = true)]
    from_travel: f64,
    /// Last key travel, mm [default: let-off of the unmoved case]
    #[arg(long, value_name = "MM", value_parser = number(Quantity::Length, "mm"), allow_hyphen_values = true)]
    to_travel: Option<f64>,
    /// Number of steps between the two
    #[arg(long, value_name = "N", default_value_t = 200, allow_negative_numbers = true)]
    steps: i64,
    /// Print the closure equations and stop
    #[arg(long, conflicts_with_all = ["moves", "no_regulate", "from_travel", "to_travel", "steps", "out", "force"])]
    equations: bool,
    /// Print the equations as LaTeX
    #[arg(long, requires = "equations")]
    latex: bool,
    /// List the built-in linkages and stop
    #[arg(long, conflicts_with_all = ["linkage", "instrument", "moves", "equations", "check_file", "print", "out", "force"])]
    list: bool,
    /// Check the linkage file, show its contents and stop
    #[arg(long, requires = "linkage", conflicts_with_all = ["moves", "equations", "print", "out", "force"])]
    check_file: bool,
    /// Print the file of a built-in linkage, as a start for your own, and stop
    #[arg(long, requires = "linkage", conflicts_with_all = ["moves", "equations", "out", "force"])]
    print: bool,
    #[command(flatten)]
    out: OutOptions,
}

/// Last key travel if let-off is unknown, m: a usual dip.
const USUAL_DIP_M: f64 = 0.010;
/// Largest sensible key travel, mm.
const MAX_TRAVEL_MM: f64 = 1000.0;
/// Most steps: more than a figure shows.
const MAX_STEPS: i64 = 1_000_000;
/// Most poses of all cases together, because of memory.
const MAX_POSES: i64 = 2_000_000;

/// Subject of the command.
struct Subject {
    design: Design,
    /// The instrument, if any, and its levers.
    instrument: Option<(Instrument, Derived)>,
}

impl Subject {
    fn linkage(session: &mut Session, file_or_name: &str) -> Result<Self, Failure> {
        let file = linkage_file(session, file_or_name)?;
        let design = file.design().map_err(|error| Failure::Usage(format!("{file_or_name}: {error}")))?;
        Ok(Subject { design, instrument: None })
    }

    fn instrument(session: &mut Session, asked: &InstrumentSpec) -> Result<Self, Failure> {
        let instrument = load_instrument(session, asked)?;
        let derived = derive(&instrument).map_err(|error| Failure::Usage(error.to_string()))?;
        Ok(Subject { design: derived.design.clone(), instrument: Some((instrument, derived)) })
    }
}

/// Finds a linkage file, or a built-in one by its name.
fn linkage_file(session: &mut Session, file_or_name: &str) -> Result<LinkageFile, Failure> {
    let path = Path::new(file_or_name);
    if path.exists() || path.extension().is_some() || path.components().count() > 1 {
        let (name, bytes) = session.inputs.bytes(path)?;
        let file = LinkageFile::parse_bytes(&bytes, &name)?;
        session.provenance.used("linkage", &file.name, Some(&name), &bytes);
        return Ok(file);
    }
    let text = LinkageFile::builtin_text(file_or_name).unwrap_or_default();
    let file = LinkageFile::builtin(file_or_name).ok_or_else(|| {
        let names: Vec<&str> = LinkageFile::builtin_names().collect();
        let hint = meant(file_or_name, names.iter().copied());
        let names = names.join(", ");
        Failure::Usage(format!("there is no file and no built-in linkage `{file_or_name}` (built in: {names}){hint}"))
    })?;
    session.provenance.used("linkage", &file.name, None, text.as_bytes());
    Ok(file)
}

/// Requested cases.
struct Cases {
    /// Cases computed as far as possible, the unmoved one first.
    shown: Vec<Shown>,
    /// Range of key travel, m.
    range: (f64, f64),
    /// Unreached poses, a line each.
    unreached: Vec<String>,
}

impl Kinematics {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        self.check_numbers()?;
        if self.list {
            return list(session);
        }
        if let Some(asked) = self.linkage.as_deref().filter(|_| self.check_file || self.print) {
            return if self.print { print(asked) } else { check(session, asked) };
        }
        if self.equations {
            return self.print_equations(session);
        }
        let subject = self.subject(session)?;
        let mut output = self.out.prepare(
            session,
            "kinematics",
            &["kinematics.csv", "summary.json", "sliding.svg", "sliding.png", "leverage.svg", "leverage.png"],
        )?;
        let Cases { shown: cases, range, unreached } = self.cases(&subject.design)?;
        if cases.iter().all(|case| case.stroke.poses.is_empty()) {
            return Err(Failure::Usage(unreached.join("\nerror: ")));
        }
        let unmoved = &cases[0];
        let press =
            subject.instrument.as_ref().and_then(|(instrument, derived)| press(session, instrument, derived, unmoved));
        let agreement = press.as_ref().and_then(|press| press.1.as_ref());
        let derived = subject.instrument.as_ref().map(|(_, derived)| derived);
        let summary = Summary::new(&subject.design, !self.no_regulate, &cases, derived, agreement);

        let design = &subject.design;
        output.table(session, "kinematics.csv", &table(&cases))?;
        output.json(session, "summary.json", &summary.json)?;
        output.figure(session, "sliding", &sliding_picture(design, &cases, range))?;
        output.figure(session, "leverage", &leverage_picture(design, &cases, range))?;
        if let Some((press, agreement)) = &press {
            let picture = dynamics_picture(design, unmoved, press, agreement.as_ref());
            output.figure(session, "leverage-dynamics", &picture)?;
        }
        let written = output.commit(session)?;

        print_line!(session, "{} - kinematics, key {} to {} mm", design.name, short(range.0), short(range.1));
        let answer = Answer::of(&summary.json)?;
        answer.begin(
            session,
            |answer| summary.headlines(answer),
            "sliding over the whole way, the lever arms, the lengths L1 to L10, and what they assume",
        );
        print_line!(session, "{summary}");
        let unreached = (!unreached.is_empty()).then(|| unreached.join("\nerror: "));
        Ok(answer.end(session, &written).short_of(unreached))
    }

    fn subject(&self, session: &mut Session) -> Result<Subject, Failure> {
        match (&self.linkage, &self.instrument) {
            (Some(linkage), _) => Subject::linkage(session, linkage),
            (None, Some(instrument)) => Subject::instrument(session, instrument),
            (None, None) => {
                let own = "concert-grand".parse().map_err(|error| Failure::Internal(format!("{error}")))?;
                Subject::instrument(session, &own)
            }
        }
    }

    /// Checks the numbers before anything is read or written.
    fn check_numbers(&self) -> Result<(), Failure> {
        let usage = |message: String| Err(Failure::Usage(message));
        for (option, mm) in [("--from-travel", Some(self.from_travel)), ("--to-travel", self.to_travel)] {
            if let Some(mm) = mm.filter(|mm| mm.abs() > MAX_TRAVEL_MM) {
                return usage(format!("{option} {mm}: expected a number of at most {MAX_TRAVEL_MM} mm"));
            }
        }
        if let Some(to) = self.to_travel.filter(|to| *to <= self.from_travel) {
            return usage(format!(
                "--from-travel {} --to-travel {to}: the key goes down; expected --to-travel to be larger",
                self.from_travel
            ));
        }
        if !(1..=MAX_STEPS).contains(&self.steps) {
            return usage(format!("--steps {}: expected a number from 1 to {MAX_STEPS}", self.steps));
        }
        let cases = self.moves.len() as i64 + 1;
        if self.steps.saturating_mul(cases) > MAX_POSES {
            return usage(format!(
                "--steps {}: {cases} cases would have more than {MAX_POSES} poses; expected at most {}",
                self.steps,
                MAX_POSES / cases
            ));
        }
        for (i, one) in self.moves.iter().enumerate() {
            if self.moves[..i].iter().any(|other| other.name == one.name) {
                return usage(format!("--move {}: given twice", one.name));
            }
        }
        Ok(())
    }

    fn cases(&self, design: &Design) -> Result<Cases, Failure> {
        let regulation = if self.no_regulate { Regulation::AsMoved } else { Regulation::Regulated };
        let unmoved = design.case(&[], regulation).map_err(|error| Failure::Usage(error.to_string()))?;
        let from = self.from_travel / 1000.0;
        let to = self.to_travel.map_or(unmoved.let_off_key_m.unwrap_or(USUAL_DIP_M), |to| to / 1000.0);
        if to <= from {
            return Err(Failure::Usage(format!(
                "--from-travel {}: expected less than the key travel at let-off, {:.2} mm, or a larger --to-travel",
                self.from_travel,
                to * 1e3
            )));
        }
        let (mut shown, mut unreached) = (Vec::new(), Vec::new());
        let mut show = |name: &str, label: &str, moves: &[Move]| {
            let case = match design.case(moves, regulation) {
                Ok(case) => case,
                Err(error) => {
                    unreached.push(format!("{name}: the levers stop at key 0.000 mm, at rest: {error}"));
                    return;
                }
            };
            let stroke = case.stroke(from, to, self.steps as usize);
            if let Some(stop) = &stroke.stop {
                let poses = match stroke.poses.len() {
                    0 => "no pose is reached".to_owned(),
                    count => format!("the {count} poses up to there are written"),
                };
                let (at, to) = (stop.key * 1e3, short(to));
                unreached
                    .push(format!("{name}: the levers stop at key {at:.3} mm of {to} mm ({}); {poses}", stop.stop));
            }
            let digest = case.digest();
            shown.push(Shown { name: name.to_owned(), label: label.to_owned(), case, digest, stroke });
        };
        show(UNMOVED, AS_IT_IS, &[]);
        for one in &self.moves {
            show(&one.name, &one.label, &one.moves);
        }
        Ok(Cases { shown, range: (from, to), unreached })
    }

    fn print_equations(&self, session: &mut Session) -> Result<Answer, Failure> {
        let text = |title: &str, levers: &Levers| -> Result<String, Failure> {
            let mechanism =
                levers.linkage(Drive::Key).assemble().map_err(|error| Failure::Internal(error.to_string()))?;
            if self.latex {
                return Ok(latex_align(mechanism.equations()));
            }
            let equations: Vec<String> = mechanism.equations().iter().map(|equation| format!("  {equation}")).collect();
            Ok(format!(
                "{title}: angles k (given), w, h of key, whippen, hammer; slidings S1 (capstan), S2 (knuckle)\n\n{}\n\n  \
                 with {}",
                equations.join("\n"),
                constants(mechanism.linkage())
            ))
        };
        let mut texts = Vec::new();
        if self.linkage.is_none() && self.instrument.is_none() {
            // Both kinds: the equations of a linkage file, and those of an instrument.
            let file = LinkageFile::builtin("c7f-like")
                .ok_or_else(|| Failure::Internal("the built-in linkage cannot be read".into()))?;
            texts.push(text(&file.name, &Levers::from(file.levers))?);
        }
        let subject = self.subject(session)?;
        texts.push(text(&subject.design.name, &subject.design.levers)?);
        let text = texts.join("\n\n");
        print_line!(session, "{text}");
        Answer::default().with("text", &text)
    }
}

/// Lists the built-in linkages.
fn list(session: &mut Session) -> Result<Answer, Failure> {
    let titled = |name| Some((name, LinkageFile::builtin(name)?.name));
    let all: Vec<(&str, String)> = LinkageFile::builtin_names().filter_map(titled).collect();
    print_line!(
        session,
        "{}",
        Table::of(["", ""], all.iter().map(|(name, title)| [(*name).to_owned(), title.clone()])).to_string().trim_end()
    );
    let listed = all.iter().map(|(name, title)| json!({"kind": "linkage", "name": name, "title": title}));
    Answer::of(&json!({"built_in": listed.collect::<Value>()}))
}

/// Prints the file of a built-in linkage unchanged.
fn print(asked: &str) -> Result<Answer, Failure> {
    let text = LinkageFile::builtin_text(asked).ok_or_else(|| {
        let names: Vec<&str> = LinkageFile::builtin_names().collect();
        let meant = meant(asked, names.iter().copied());
        Failure::Usage(format!("there is no built-in linkage `{asked}` (built in: {}){meant}", names.join(", ")))
    })?;
    Ok(Answer::text(text))
}

/// Checks a linkage file, and shows its contents as `erard check` does.
fn check(session: &mut Session, asked: &str) -> Result<Answer, Failure> {
    let Subject { design, .. } = Subject::linkage(session, asked)?;
    Answer::of(&checked_linkage(session, asked, &design))
}

/// Named constants of a linkage with their values.
fn constants(linkage: &Linkage) -> String {
    let lengths = linkage.lengths().iter().map(|length| (length, format!("{:.2} mm", length.value * 1e3)));
    let angles = linkage.angles().iter().map(|angle| (angle, format!("{:.3} degrees", angle.value.to_degrees())));
    let named =
        lengths.chain(angles).filter_map(|(constant, value)| Some(format!("{} = {value}", constant.name.as_ref()?)));
    named.collect::<Vec<_>>().join(", ")
}

/// The slow press of an instrument and its agreement with the geometry. If it fails, a warning is printed and the
/// geometry is still shown.
fn press(
    session: &mut Session,
    instrument: &Instrument,
    derived: &Derived,
    unmoved: &Shown,
) -> Option<(SlowPress, Option<Agreement>)> {
    let let_off = unmoved.case.let_off_key_m?;
    match slow_press(instrument, &derived.levers, let_off) {
        Ok(press) => {
            let agreement = press.agreement(&unmoved.case.train, let_off);
            Some((press, agreement))
        }
        Err(error) => {
            warn!(session, "warning: the slow press that checks the geometry failed: {error}");
            None
        }
    }
}

/// Formats millimetres with at most two decimals.
fn short(metres: f64) -> String {
    let text = format!("{:.2}", metres * 1e3 + 0.0);
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

//! `erard check`.

use std::path::{Path, PathBuf};

use clap::Args;
use erard::instrument::{Instrument, InstrumentFile, utf8};
use erard::keyboard::{Graded, Grading, KEYS, Keyboard};
use erard_kinematics::{Design, LinkageFile};
use erard_workshop::diagnose::{entries, is_table_of_keys, read as readings};
use erard_workshop::measure::usual;
use erard_workshop::validate::{Cases, Published};
use serde_json::{Value, json};

use super::check_recording::told;
use super::check_sensors;
use super::checked::checked;
use super::list::built_in;
use super::upgrade;
use crate::answer::Answer;
use crate::failure::Failure;
use crate::inputs::shown;
use crate::keyboard::doubts;
use crate::print_line;
use crate::recordings::RecordingOptions;
use crate::session::Session;
use crate::suggest::meant;
use crate::table::Table;
use crate::warn;
use erard_workshop::test_press::test_presses;

/// Bytes in which the header of a table of keys is looked for, comments before it included.
const HEADER_BYTES: u64 = 64 << 10;

/// Checks a file and shows its contents: instrument, keyboard, linkage, stroke, recording, published measurements or
/// pianos, sensors' stream, profile or law, MIDI file, or result.
#[derive(Debug, Args)]
pub(crate) struct Check {
    /// File, or a built-in name: `.toml` for instruments, keyboards, linkages, measurements and profiles of sensors,
    /// `.csv` or `.parquet` for strokes, recordings, streams of sensors and laws, `.mid` for pieces, `.json` for
    /// results
    #[arg(value_name = "FILE")]
    file: PathBuf,
    /// Rewrite names of earlier versions in the file as this version writes them, and nothing else
    #[arg(long)]
    upgrade: bool,
    #[command(flatten)]
    recording: RecordingOptions,
}

/// Shows three levers from a linkage file; the answer.
pub(super) fn checked_linkage(session: &mut Session, file: &str, design: &Design) -> Value {
    print_line!(session, "{file}: a linkage, \"{}\"", design.name);
    print_line!(session);
    if let Some(let_off) = &design.let_off {
        print_line!(session, "  three levers that reach each other at rest; {}: {}", let_off.name, let_off.what);
    }
    checked("linkage", file, Some(&design.name), [])
}

/// Endings of tables.
const TABLES: [&str; 5] = ["csv", "tsv", "txt", "dat", "parquet"];

impl Check {
    /// Runs the command.
    pub(crate) fn run(&self, session: &mut Session) -> Result<Answer, Failure> {
        if self.upgrade {
            upgrade::refuse(&self.file)?;
        }
        let extension = self.file.extension().and_then(|e| e.to_str()).unwrap_or_default().to_ascii_lowercase();
        let checked = match extension.as_str() {
            "toml" => {
                let (name, bytes) = session.inputs.bytes(&self.file)?;
                self.toml(session, &name, &bytes)?
            }
            "json" => {
                let (name, bytes) = session.inputs.bytes(&self.file)?;
                Self::json(session, &name, &bytes)?
            }
            "mid" | "midi" => check_sensors::piece(session, &self.file)?,
            ending if TABLES.contains(&ending) => self.table(session, ending)?,
            _ => match self.file.to_str().filter(|_| !self.file.exists()).and_then(built_in) {
                Some(("stroke", text)) => {
                    let ready = self.recording.make_ready(&shown(&self.file), text.as_bytes())?;
                    told(session, &ready)
                }
                Some((_, text)) => self.toml(session, &shown(&self.file), text.as_bytes())?,
                None => {
                    return Err(Failure::Usage(format!(
                        "{}: unknown file type; expected .toml (instrument, keyboard, linkage, published measurements, profile of sensors), .csv or .parquet (stroke, recording, stream, law), .mid (piece), .json (result), or a built-in name (`erard list`){}",
                        shown(&self.file),
                        meant(&self.file.to_string_lossy(), Instrument::builtin_names())
                    )));
                }
            },
        };
        let answer = Answer::of(&checked)?.end_without_files(session);
        Ok(if self.upgrade { answer.paths(upgrade::upgrade(session, &self.file)?) } else { answer })
    }

    /// What a text says that it is decides.
    fn toml(&self, session: &mut Session, name: &str, bytes: &[u8]) -> Result<Value, Failure> {
        let text = String::from_utf8_lossy(bytes);
        let document = toml::from_str::<toml::Table>(&text).unwrap_or_default();
        let says = |key: &str| document.get(key).and_then(toml::Value::as_str);
        let is = |kind: &str| says("format").is_some_and(|format| format.starts_with(kind));
        if is("erard-keyboard") {
            self.keyboard(session, name, bytes)
        } else if is("erard-published") {
            Self::published(session, name, &text)
        } else if is("erard-usual") {
            Self::usual(session, name, &text)
        } else if is("erard-cases") {
            Self::cases(session, name, &text)
        } else if is("erard-sensors") {
            check_sensors::profile(session, name, &text)
        } else if says("format").is_none() && says("kind").is_some_and(|kind| kind == "three-lever") {
            let file = LinkageFile::parse_bytes(bytes, name)?;
            let design = file.design().map_err(|error| Failure::Usage(format!("{name}: {error}")))?;
            Ok(checked_linkage(session, name, &design))
        } else {
            Self::instrument(session, name, bytes)
        }
    }

    fn usual(session: &mut Session, name: &str, text: &str) -> Result<Value, Failure> {
        let lines = usual::check(text).map_err(|error| Failure::Usage(format!("{name}: {error}")))?;
        print_line!(session, "{name}: usual ranges");
        print_line!(session);
        print_line!(session, "  of {lines} lines of the technician's sheet");
        Ok(checked("usual ranges", name, None, [("lines", lines)]))
    }

    fn published(session: &mut Session, name: &str, text: &str) -> Result<Value, Failure> {
        let table = Published::parse(text).map_err(|error| Failure::Usage(format!("{name}: {error}")))?;
        let silent = table.rows.iter().filter(|row| row.measure.is_none()).count();
        print_line!(session, "{name}: published measurements");
        print_line!(session);
        print_line!(session, "  {} rows from {} sources; {silent} not modelled", table.rows.len(), table.sources.len());
        let counts = [("rows", table.rows.len()), ("sources", table.sources.len())];
        Ok(checked("published measurements", name, None, counts))
    }

    fn cases(session: &mut Session, name: &str, text: &str) -> Result<Value, Failure> {
        let cases = Cases::parse(text).map_err(|error| Failure::Usage(format!("{name}: {error}")))?.cases;
        let keys = cases.iter().map(|case| case.keys.len()).sum();
        print_line!(session, "{name}: published pianos");
        print_line!(session);
        print_line!(session, "  {} cases, {keys} keys", cases.len());
        Ok(checked("published pianos", name, None, [("cases", cases.len()), ("keys", keys)]))
    }

    /// What this program writes, and its schemas.
    fn json(session: &mut Session, name: &str, bytes: &[u8]) -> Result<Value, Failure> {
        let wrong = |error: &dyn std::fmt::Display| Failure::Usage(format!("{name}: is not JSON: {error}"));
        let value: Value = serde_json::from_slice(bytes).map_err(|error| wrong(&error))?;
        let first = value.as_array().and_then(|list| list.first()).unwrap_or(&value);
        let text = |pointer: &str| first.pointer(pointer).and_then(Value::as_str);
        if let Some(command) = text("/made_by/command") {
            let commit = text("/made_by/commit").map_or(String::new(), |commit| format!(" ({commit})"));
            print_line!(
                session,
                "{name}: a result of {} {}{commit}",
                text("/made_by/program").unwrap_or("?"),
                text("/made_by/version").unwrap_or("?")
            );
            print_line!(session);
            print_line!(session, "  {command}");
            for source in first.pointer("/made_by/sources").and_then(Value::as_array).into_iter().flatten() {
                let of = |key: &str| source[key].as_str().unwrap_or("-");
                print_line!(
                    session,
                    "  from {} \"{}\", {}, sha256 {}",
                    of("kind"),
                    of("name"),
                    source["file"].as_str().unwrap_or("built in"),
                    of("sha256")
                );
            }
        } else if let Some(format) = text("/format") {
            print_line!(session, "{name}: {format}");
        } else if text("/$schema").is_some() {
            print_line!(session, "{name}: a JSON Schema, \"{}\"", text("/title").unwrap_or("without a title"));
        } else {
            let expected = "a result of Erard (with `made_by`), a file with `format`, or a JSON Schema";
            return Err(Failure::Usage(format!("{name}: unknown kind of JSON; expected {expected}")));
        }
        let title = text("/made_by/command").or(text("/format")).or(text("/title"));
        Ok(checked("JSON", name, title, []))
    }

    fn instrument(session: &mut Session, name: &str, bytes: &[u8]) -> Result<Value, Failure> {
        let file = InstrumentFile::parse_bytes(bytes, name)?;
        let i: &Instrument = &file.instrument;
        print_line!(session, "{name}: an instrument, \"{}\"", i.name);
        print_line!(session);
        let some = |count: usize, one: &str| match count {
            0 => None,
            1 => Some(format!("1 {one}")),
            many => Some(format!("{many} {}", one.replace("body", "bodie") + "s")),
        };
        let parts = [
            some(i.bodies.len(), "body"),
            some(i.springs.len(), "spring"),
            some(i.zones.len(), "contact zone"),
            some(i.strings.len(), "string"),
            some(i.screws.len(), "screw"),
            some(i.parts.len(), "outline of its own"),
        ];
        print_line!(session, "  {}.", parts.into_iter().flatten().collect::<Vec<_>>().join(", "));
        let (numbers, bare) = (file.provenance.numbers.len(), file.provenance.bare().count());
        match bare {
            0 => print_line!(session, "  Each of its {numbers} numbers has a source."),
            bare => print_line!(session, "  {bare} of its {numbers} numbers have no source."),
        }
        let outlived = file.provenance.outlived_notes();
        if !outlived.is_empty() {
            print_line!(session);
            print_line!(session, "  Changed numbers whose notes still describe the value of a built-in instrument:");
        }
        let mut changed = Vec::new();
        for one in outlived {
            let note = one.number.citation.and_then(|citation| citation.note).unwrap_or_default();
            let numbers = |values: &[f64]| values.iter().map(f64::to_string).collect::<Vec<_>>().join(", ");
            let (line, key, now) = (one.number.line, one.number.key, numbers(&one.number.values));
            print_line!(
                session,
                "  line {line:>4}  {key}: {now}; {} in {}: \"{note}\"",
                numbers(&one.was),
                one.builtin
            );
            changed.push(json!({
                "line": line, "key": key, "now": one.number.values, "was": one.was, "in": one.builtin, "note": note,
            }));
        }
        session.printer.begin_rest("the tables of bodies, springs, strings and contact zones");
        Self::parts(session, i);
        let counts = [
            ("bodies", i.bodies.len()),
            ("springs", i.springs.len()),
            ("zones", i.zones.len()),
            ("strings", i.strings.len()),
            ("screws", i.screws.len()),
            ("parts", i.parts.len()),
            ("numbers", file.provenance.numbers.len()),
            ("numbers_without_a_source", file.provenance.bare().count()),
        ];
        let mut checked = checked("instrument", name, Some(&i.name), counts);
        checked["changed_numbers"] = changed.into();
        Ok(checked)
    }

    /// The tables of bodies, springs, strings and zones.
    fn parts(session: &mut Session, i: &Instrument) {
        let name = |body: Option<usize>| body.map_or("ground", |body| &i.bodies[body].name);
        let bodies = i.bodies.iter().map(|body| {
            [
                body.name.clone(),
                name(body.parent).to_owned(),
                format!("{:.1} g", body.mass_kg * 1e3),
                format!("{:.3e} kg m2", body.inertia_kg_m2),
                format!("{:.2e} N m", body.friction_torque_n_m),
            ]
        });
        print_line!(session, "{}", Table::of(["body", "hinged on", "mass", "inertia", "friction of its pin"], bodies));
        if !i.springs.is_empty() {
            let springs = i.springs.iter().map(|spring| {
                [spring.name.clone(), name(Some(spring.body)).to_owned(), format!("{:.4} N m", spring.torque_n_m)]
            });
            print_line!(session, "{}", Table::of(["spring", "on", "torque"], springs));
        }
        if !i.strings.is_empty() {
            let strings = i.strings.iter().map(|string| {
                [
                    format!("{}{}", string.name, if i.roles.rigid_string { " (held rigid)" } else { "" }),
                    format!("{:.1} mm", string.length_m * 1e3),
                    format!("{:.3} g/m", string.mass_kg_per_m * 1e3),
                    format!("{:.1} N", string.tension_n),
                    format!("{:.2} Hz", string.partial_hz(1)),
                    format!("{:.2e}", string.inharmonicity()),
                    format!("{:.1} mm", string.strike_m * 1e3),
                ]
            });
            let heads = ["string", "length", "mass", "tension", "first partial", "B", "struck at"];
            print_line!(session, "{}", Table::of(heads, strings));
        }
        let zones = i.zones.iter().map(|zone| {
            let felt = &zone.felt;
            let numbers = felt.loss.table().iter().zip(felt.loss.numbers());
            let losses = numbers.filter(|(number, value)| number.needed || *value != 0.0).map(|(number, value)| {
                let unit = if number.unit == "1" { String::new() } else { format!(" {}", number.unit) };
                format!("{} {}{unit}", number.name, short(value * number.units_per_si))
            });
            let friction = (zone.friction_coefficient > 0.0).then(|| format!("friction {}", zone.friction_coefficient));
            [
                zone.name.clone(),
                format!("{} - {}", name(zone.disc_body), name(zone.curve_body)),
                format!("{:.1e}", felt.stiffness),
                felt.exponent.to_string(),
                losses.chain(friction).collect::<Vec<_>>().join(", "),
            ]
        });
        print_line!(session, "{}", Table::of(["zone", "between", "k", "r", "losses"], zones));
    }

    /// Every key's instrument is read and pressed once, so that a file that is called sound has none that is not.
    fn keyboard(&self, session: &mut Session, name: &str, bytes: &[u8]) -> Result<Value, Failure> {
        let keyboard = Keyboard::parse_bytes(bytes, name, self.file.parent().unwrap_or(Path::new("")))?;
        let instruments = keyboard.instruments()?;
        let mut progress = session.progress("pressing every key");
        let tried = test_presses(&instruments, &mut |share| progress.tell(share))
            .map_err(|error| Failure::Measure { label: keyboard.name.clone(), error: Box::new(error) })?;
        drop(progress);
        print_line!(session, "{name}: a keyboard, \"{}\", around key {}", keyboard.name, keyboard.base_key);
        print_line!(session);
        let points = || keyboard.gradings.iter().flat_map(|grading| &grading.curve.points);
        let gradings = keyboard.gradings.iter().map(|Grading { name, graded, curve }| {
            let (kind, unit) = match graded {
                Graded::AddedMass { .. } => ("mass", " g"),
                Graded::Factor { .. } => ("factor", ""),
                Graded::Shift { .. } => ("shift", " mm"),
            };
            let [low, high] = [1, KEYS].map(|key| format!("{}{unit}", curve.at(key)));
            [name.clone(), kind.to_owned(), low, high]
        });
        match tried.iter().filter(|one| !one.warnings.is_empty()).count() {
            0 => print_line!(session, "  The instruments of all {KEYS} keys are sound."),
            doubtful => print_line!(session, "  {doubtful} of the {KEYS} keys cannot be trusted."),
        }
        print_line!(
            session,
            "  {} gradings of {} points, {} of them without a source.",
            keyboard.gradings.len(),
            points().count(),
            points().filter(|point| point.citation.is_none()).count()
        );
        session.printer.begin_rest("each grading at both ends of the keyboard");
        print_line!(session, "{}", Table::of(["grading", "kind", "at key 1", "at key 88"], gradings));
        let doubts = doubts((1..).zip(&tried));
        for doubt in &doubts {
            warn!(session, "warning: {doubt}");
        }
        let counts = [("gradings", keyboard.gradings.len()), ("points", points().count()), ("keys", KEYS)];
        let mut checked = checked("keyboard", name, Some(&keyboard.name), counts);
        checked["warnings"] = doubts.into();
        Ok(checked)
    }

    /// A table of readings, a row for each key, or a stroke.
    fn table(&self, session: &mut Session, ending: &str) -> Result<Value, Failure> {
        if ending == "parquet" || !self.file.is_file() {
            return self.stroke(session);
        }
        // A recording may be longer than any table of keys: its header tells it.
        let header = session.inputs.beginning(&self.file, HEADER_BYTES).unwrap_or_default();
        let header = String::from_utf8_lossy(&header);
        if !self.recording.are_given()
            && let Some(checked) = check_sensors::table(session, &self.file, &header)?
        {
            return Ok(checked);
        }
        if !is_table_of_keys(&header) {
            return self.stroke(session);
        }
        let (name, bytes) = session.inputs.bytes(&self.file)?;
        let text = String::from_utf8_lossy(&bytes);
        let keys = readings(utf8(&bytes, &name)?, &name).map_err(|error| Failure::Usage(error.to_string()))?;
        let count = entries().iter().filter(|entry| keys.iter().any(|(_, known)| known.get(entry.name).is_some()));
        let names: Vec<&str> = count.map(|entry| entry.label).collect();
        print_line!(session, "{name}: readings of {} keys, for `erard diagnose`", keys.len());
        if let Ok(weighed) = erard_workshop::balance::read(&text, &name) {
            print_line!(session, "  weights of {} keys in it, for `erard keyboard --measured`", weighed.len());
        }
        print_line!(session);
        print_line!(session, "  {}", names.join(", "));
        Ok(checked("readings of keys", &name, None, [("keys", keys.len()), ("readings", names.len())]))
    }

    fn stroke(&self, session: &mut Session) -> Result<Value, Failure> {
        let ready = self.recording.load(session, &self.file)?;
        Ok(told(session, &ready))
    }
}

/// A number in a line of others.
fn short(x: f64) -> String {
    if x != 0.0 && !(1e-3..1e4).contains(&x.abs()) { format!("{x:.1e}") } else { format!("{x}") }
}

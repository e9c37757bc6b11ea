//! `--json` of every command: standard output is one JSON value, and has the schema that stands in `schemas/`.
//!
//! The schemas say what is there in any case and of which type; commands may say more. `.ci/regenerate answers`
//! rewrites them from what the commands answer, to be looked at.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use crate::common::Folder;
use crate::common::schema::{faults, kind};
use crate::generated;
use serde_json::{Map, Value, json};

/// Every command, and calls whose answers differ in kind: one schema holds for all of them.
const CALLS: &[(&str, &[&[&str]])] = &[
    (
        "press",
        &[
            &["press", "--duration", "0.1"],
            &["press", "--model", "one-dof", "--duration", "0.05"],
            &["press", "--tolerance", "1e-4", "--duration", "0.1"],
            &["press", "--stroke", "ff"],
            &["press", "noisy.csv", "--drive", "rigid", "--duration", "0.2"],
            &["press", "--losses", "--reactions", "--duration", "0.05"],
        ],
    ),
    (
        "press-two",
        &[
            &["press", "--against", "ff", "--duration", "0.05"],
            &["press", "--instrument", "concert-grand", "--instrument", "heavy-touch", "--duration", "0.05"],
        ],
    ),
    (
        "press-options",
        &[
            &["press", "--instrument", "concert-grand-strings", "--force-step", "5", "--duration", "0.02", "--wav"],
            &["press", "--force-step", "5", "--duration", "0.02", "--bands=2"],
        ],
    ),
    ("draw", &[&["draw"], &["draw", "--at", "let-off"]]),
    (
        "study",
        &[
            &["study", "--vary", "force=0.1,5", "--duration", "0.1"],
            &["study", "--vary", "let_off=+0mm,0.1mm", "--measure", "key_ratio", "--force-step", "5", "--single"],
            &["study", "--vary", "repetition_spring=+0,-99Nmm", "--force-step", "5", "--duration", "0.1"],
            &["study", "--vary", "key=1,88", "--stroke", "p", "--duration", "0.1"],
        ],
    ),
    (
        "study-bands",
        &[
            &["study", "--vary", "let_off=+0mm,0.1mm", "--force-step", "5", "--duration", "0.05", "--bands=2"],
            // The second of these can be played, and not measured.
            &[
                "study",
                "--vary",
                "capstan_height=+0mm,20mm",
                "--measure",
                "key_ratio",
                "--force-step",
                "5",
                "--duration",
                "0.05",
                "--bands=2",
            ],
        ],
    ),
    (
        "study-sensitivities",
        &[
            &[
                "study",
                "--sensitivities",
                "--outcomes",
                "hammer_speed_m_per_s,up_weight_g",
                "--parameters",
                "let_off,body.hammer.mass",
            ],
            &[
                "study",
                "--sensitivities",
                "--outcomes",
                "let_off_s",
                "--parameters",
                "force,body.key.mass",
                "--force-step",
                "5",
            ],
        ],
    ),
    ("measure", &[&["measure"], &["measure", "heavy-touch", "--sheet"]]),
    ("measure-two", &[&["measure", "concert-grand", "heavy-touch", "--sheet"]]),
    (
        "measure-many",
        &[
            &["measure", "heavy-touch", "--only", "down_weight_g,key_ratio"],
            &["measure", "heavy-touch", "--only", "front_weight_g"],
            // The highest key cannot be measured.
            &["measure", "stuck.toml:key=40,88", "--only", "down_weight_g,key_ratio"],
            &["measure", "concert-grand:key=1,88", "--only", "down_weight_g,key_ratio"],
        ],
    ),
    (
        "measure-bands",
        &[
            &["measure", "--bands=2", "--only", "down_weight_g"],
            &["measure", "concert-grand:key=88", "--bands=2", "--only", "key_ratio,dip_mm"],
        ],
    ),
    ("keyboard", &[&["keyboard", "--every", "60"], &["keyboard", "stuck.toml", "--every", "87"]]),
    (
        "keyboard-two",
        &[
            &["keyboard", "concert-grand", "heavy-touch", "--every", "60"],
            &["keyboard", "concert-grand", "stuck.toml", "--every", "87"],
        ],
    ),
    (
        "text",
        &[
            &["list", "concert-grand"],
            &["list", "mf-struck"],
            &["keyboard", "--key", "C4"],
            &["man"],
            &["man", "press"],
            &["completions", "bash"],
            &["kinematics", "--equations"],
            &["kinematics", "c7f-like", "--print"],
        ],
    ),
    ("man", &[&["man", "--out", "pages"]]),
    (
        "fmu",
        &[&["fmu", "--library", "liberard.so"], &["fmu", "--keyboard", "concert-grand", "--library", "liberard.so"]],
    ),
    (
        "keyboard-measured",
        &[
            &["keyboard", "--measured", "weighed.csv", "--checked-keys", "1", "--simulate-work", "--out", "w1"],
            &["keyboard", "--measured", "weighed.csv", "--checked-keys", "0", "--target", "balance=38g", "--out", "w2"],
        ],
    ),
    ("regulate", &[&["regulate", "mine.toml", "--let-off", "2mm", "--out-file", "regulated.toml", "--force"]]),
    ("validate", &[&["validate"], &["validate", "--instrument", "heavy-touch"]]),
    ("validate-cases", &[&["validate", "--cases=choose"]]),
    ("validate-sound", &[&["validate", "--sound", "A5,C6", "--instrument", "concert-grand-strings"]]),
    ("validate-bands", &[&["validate", "--bands=2"]]),
    (
        "check",
        &[
            &["check", "mine.toml"],
            &["check", "run/run.csv"],
            &["check", "noisy.csv"],
            &["check", "keyboard:concert-grand"],
            &["check", "run/summary.json"],
            &["check", "c7f-like"],
            &["kinematics", "c7f-like", "--check-file"],
            &["check", "weighed.csv"],
            &["check", "mf-struck"],
        ],
    ),
    (
        "compare",
        &[
            &["compare", "run/run.csv"],
            &["compare", "key.csv", "--no-pictures"],
            &["compare", "noisy.csv", "--no-pictures"],
            &["compare", "touched.csv", "--no-pictures"],
            &["compare", "run/run.csv", "--instrument", "heavy-touch", "--drive", "rigid", "--model", "action"],
            &["compare", "run/run.csv", "--way-up", "--drive", "force,motion", "--model", "one-dof", "--no-pictures"],
        ],
    ),
    (
        "fit",
        &[
            &[
                "fit",
                "concert-grand-rigid",
                "run/run.csv",
                "--parameters",
                "body.hammer.mass",
                "--duration",
                "0.05",
                "--restarts",
                "0",
            ],
            &[
                "fit",
                "concert-grand-rigid",
                "run/run.csv",
                "--parameters=body.hammer.mass,zone.check.stiffness,zone.capstan_heel.stiffness",
                "--duration=0.05",
                "--sigma=force=0.02N,position=10um,hammer=50um",
                "--delays",
                "--restarts=0",
                "--no-pictures",
            ],
            // Two recordings, driven by their motion.
            &[
                "fit",
                "concert-grand-rigid",
                "run/run.csv",
                "soft/run.csv",
                "--parameters=body.hammer.mass",
                "--bounds=body.hammer.mass=x0.9..1.1",
                "--start=body.hammer.mass=x1.02",
                "--drive=rigid",
                "--compare=hammer",
                "--loss=soft_l1",
                "--duration=0.05",
                "--restarts=0",
                "--no-pictures",
            ],
            &[
                "fit",
                "concert-grand-rigid",
                "run/run.csv",
                "--parameters=body.hammer.mass",
                "--jacobian=gradient",
                "--compare=position,hammer",
                "--sigma=position=10um,hammer=50um",
                "--duration=0.04",
                "--restarts=0",
                "--no-pictures",
            ],
        ],
    ),
    (
        "live",
        &[
            &["live", "sensed.csv", "--out-file", "notes.mid", "--force"],
            &["live", "sensed.csv", "--ahead", "--out-file", "bytes", "--force"],
            &["live", "sensed.csv", "--out-file", "notes.csv", "--force"],
        ],
    ),
    ("calibrate", &[&["calibrate", "readings.csv", "--out-file", "profile.toml", "--force"]]),
    ("calibrate-contacts", &[&["calibrate", "--contacts", "3,6.5", "--out-file", "contacts.toml", "--force"]]),
    (
        "play",
        &[
            &["play", "two.mid", "--keyboard", "concert-grand", "--slow-motion", "1"],
            &[
                "play",
                "two.mid",
                "--keyboard",
                "concert-grand",
                "--against-keyboard",
                "heavy-touch",
                "--slow-motion",
                "0",
            ],
        ],
    ),
    (
        "scan",
        &[
            &["scan", "two.mid", "--cases", "half-stroke", "--keys", "40", "--keyboard", "concert-grand"],
            &["scan", "--cases", "half-stroke", "--keys", "40", "--keyboard", "concert-grand", "--no-scatter"],
        ],
    ),
    ("listen", &[&["listen", "C4.wav"]]),
    ("list", &[&["list"], &["kinematics", "--list"]]),
    (
        "kinematics",
        &[&["kinematics", "--steps", "20"], &["kinematics", "c7f-like", "--steps", "20", "--move", "capstan=-5mm"]],
    ),
    (
        "diagnose",
        &[
            &["diagnose", "--down-weight", "58", "--up-weight", "18", "--let-off", "3.5", "--drop", "0.2"],
            &["diagnose", "--key", "C#4", "--dip", "9", "--let-off", "1.5", "--check", "none", "--strike-weight", "9"],
            &["diagnose", "--down-weight", "50", "--up-weight", "26", "--front-weight", "26", "--strike-weight", "9"],
            &["diagnose", "weighed.csv"],
        ],
    ),
];

fn home(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("schemas").join(format!("{name}.schema.json"))
}

/// Whose keys are names of things, not of the format.
const MAPS: [&str; 2] = ["options", "table"];

/// Texts that may be null.
const NULLABLE: [&str; 6] = ["commit", "error", "file", "sha256", "likely_reason", "set_by"];

/// The schema of all these values, which stand under the same key.
fn infer(values: &[&Value], key: &str) -> Value {
    let mut kinds: Vec<&str> = values.iter().map(|value| kind(value)).collect();
    // A number that did not come out is null, and so is what is not known of a source.
    if kinds.contains(&"number") || NULLABLE.contains(&key) {
        kinds.push("null");
    }
    kinds.sort_unstable();
    kinds.dedup();
    let mut schema = Map::new();
    // Of what was always null, or never there, nothing is known.
    if !kinds.is_empty() && kinds != ["null"] {
        schema.insert("type".into(), if kinds.len() == 1 { kinds[0].into() } else { kinds.into() });
    }
    let objects: Vec<&Map<String, Value>> = values.iter().filter_map(|value| value.as_object()).collect();
    if MAPS.contains(&key) && !objects.is_empty() {
        let all: Vec<&Value> = objects.iter().flat_map(|object| object.values()).collect();
        schema.insert("additionalProperties".into(), infer(&all, ""));
    } else if let Some(first) = objects.first() {
        let required: Vec<&String> = first.keys().filter(|key| objects.iter().all(|o| o.contains_key(*key))).collect();
        schema.insert("required".into(), json!(required));
        let mut properties = Map::new();
        for key in objects.iter().flat_map(|object| object.keys()) {
            let all: Vec<&Value> = objects.iter().filter_map(|object| object.get(key)).collect();
            properties.insert(key.clone(), infer(&all, key));
        }
        schema.insert("properties".into(), properties.into());
    }
    let items: Vec<&Value> = values.iter().filter_map(|value| value.as_array()).flatten().collect();
    if !items.is_empty() {
        schema.insert("items".into(), infer(&items, ""));
    }
    schema.into()
}

/// Commands that answer within a second.
const QUICK: [&str; 9] = ["press", "press-two", "draw", "list", "listen", "diagnose", "text", "man", "fmu"];

#[test]
fn quick_commands_answer_by_their_schemas() {
    answer_by_their_schemas(&|name| QUICK.contains(&name));
}

/// Commands that take more than ten seconds on a busy machine.
const SLOWEST: [&str; 11] = [
    "study-sensitivities",
    "study-bands",
    "keyboard-measured",
    "validate",
    "validate-bands",
    "fit",
    "measure",
    "measure-two",
    "measure-bands",
    "press-options",
    "regulate",
];

/// Forms of a command that no option of their name makes.
const FORMS: [(&str, &str); 4] = [
    ("two", "two side by side"),
    ("many", "a row for each"),
    ("bands", "with bands"),
    ("options", "with sound or bands"),
];

fn title(name: &str) -> String {
    let form = name.split_once('-').and_then(|(command, form)| {
        let (_, words) = FORMS.iter().find(|(known, _)| *known == form)?;
        Some(format!("erard {command} --json: {words}"))
    });
    form.unwrap_or_else(|| format!("erard {} --json", name.replacen('-', " --", 1)))
}

/// Files of a folder by their paths in it, with the instant of their last change.
fn files(folder: &Path, within: &str, all: &mut BTreeMap<String, SystemTime>) {
    for entry in std::fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = format!("{within}{}", entry.file_name().to_string_lossy());
        if entry.path().is_dir() {
            files(&entry.path(), &format!("{name}/"), all);
        } else if !name.ends_with(".erard.json") {
            all.insert(name, entry.metadata().unwrap().modified().unwrap());
        }
    }
}

/// Paths of the files that stand there now and did not before, or are others.
fn new_files(folder: &Folder, before: &BTreeMap<String, SystemTime>) -> Vec<String> {
    let mut after = BTreeMap::new();
    files(&folder.0, "", &mut after);
    after.retain(|name, changed| before.get(name) != Some(changed));
    after.into_keys().collect()
}

/// Whether an answer holds a whole report, as its own fields, as one of them, or as a field of each of its instruments.
fn holds(answer: &Value, mut report: Value) -> bool {
    let first = if report.is_array() { report.get_mut(0) } else { Some(&mut report) };
    first.and_then(Value::as_object_mut).map(|fields| fields.remove("made_by"));
    let fields = answer.as_object().unwrap();
    let instruments = fields.get("instruments").and_then(Value::as_array).into_iter().flatten();
    let nested: Vec<Value> = instruments.filter_map(|one| one.get("sheet").cloned()).collect();
    let stands = |report: &Value| is_within(report, answer) || fields.values().any(|field| is_within(report, field));
    // The list of one instrument may stand there without the list.
    let is_alone = report.as_array().is_some_and(|list| list.len() == 1 && stands(&list[0]));
    stands(&report) || is_alone || report == json!(nested)
}

/// Whether a value has all fields of another, and else the same content.
fn is_within(part: &Value, whole: &Value) -> bool {
    match (part, whole) {
        (Value::Object(part), Value::Object(whole)) => {
            part.iter().all(|(key, value)| whole.get(key).is_some_and(|own| is_within(value, own)))
        }
        (Value::Array(part), Value::Array(whole)) => {
            part.len() == whole.len() && part.iter().zip(whole).all(|(part, whole)| is_within(part, whole))
        }
        _ => part == whole,
    }
}

#[test]
#[ignore = "ci: commands that compare, study, calibrate and play"]
fn slow_commands_answer_by_their_schemas() {
    answer_by_their_schemas(&|name| !QUICK.contains(&name) && !SLOWEST.contains(&name));
}

mod nightly {
    #[test]
    #[ignore = "nightly: sensitivities, a keyboard weighed and worked on, a validation, fits, a sheet"]
    fn the_slowest_commands_answer_by_their_schemas() {
        super::answer_by_their_schemas(&|name| super::SLOWEST.contains(&name));
    }
}

fn answer_by_their_schemas(chosen: &dyn Fn(&str) -> bool) {
    let folder = Folder::new("json");
    folder.file("mine.toml", include_str!("../../../erard-core/instruments/concert-grand.toml"));
    folder.good(&["press", "--stroke", "f", "--out", "run"]);
    let table = folder.read("run/run.csv");
    let part: Vec<String> = table.lines().map(|l| [0, 2].map(|k| l.split(',').nth(k).unwrap()).join(",")).collect();
    folder.file("key.csv", &part.join("\n"));
    // One that begins while the key moves: it has no rest.
    let moves = |line: &&String| line.split(',').nth(1).unwrap().parse::<f64>().is_ok_and(|key_m| key_m > 1e-3);
    let moving: Vec<&str> = part.iter().skip_while(|line| !moves(line)).map(|line| &line[..]).collect();
    folder.file("touched.csv", &[&[&part[0][..]], &moving[..]].concat().join("\n"));
    // One with a rest, an offset, noise and a gap, so that all of a preparation is there.
    let mut noisy = String::from("t (ms);Force (gf);Travel (mm)\n");
    for n in 0..1000_u64 {
        let push = (n.saturating_sub(300).min(100)) as f64;
        let noise = |salt: u64| ((n * 7919 + salt).wrapping_mul(2_654_435_761) >> 7) as f64 % 1000.0 / 1000.0 - 0.5;
        let force = if n == 500 { String::new() } else { format!("{:.3}", 20.0 + 4.0 * push + 3.0 * noise(1)) };
        noisy.push_str(&format!("{:.1};{force};{:.4}\n", n as f64 * 0.2, 1.0 + 0.09 * push + 0.02 * noise(5)));
    }
    folder.file("noisy.csv", &noisy);
    folder.file("sensed.csv", &crate::live::sensed("mm", 0.0, 9.9));
    folder.file("readings.csv", &crate::live::sensed("raw", 3000.0, 1000.0));
    std::fs::write(folder.0.join("C4.wav"), crate::listen::two_stages(0.3)).unwrap();
    folder.file("weighed.csv", crate::weigh::FEW_KEYS);
    folder.file("stuck.toml", crate::keyboard::STUCK);
    folder.file("grand.toml", include_str!("../../../erard-core/instruments/concert-grand.toml"));
    folder.good(&["press", "--stroke", "p", "--out", "soft"]);
    std::fs::write(folder.0.join("liberard.so"), crate::fmu::library()).unwrap();
    std::fs::write(folder.0.join("two.mid"), crate::play::two_notes()).unwrap();
    let mut without: Vec<&str> = Vec::new();
    for (name, calls) in CALLS.iter().filter(|(name, _)| chosen(name)) {
        let answers: Vec<Value> = calls
            .iter()
            .map(|call| {
                let mut before = BTreeMap::new();
                files(&folder.0, "", &mut before);
                let output = folder.erard(&[*call, &["--json"]].concat());
                let said = String::from_utf8(output.stdout).unwrap();
                let answer: Value =
                    serde_json::from_str(&said).unwrap_or_else(|error| panic!("{call:?}: {error}: {said}"));
                // A fit with doubts answers, and exits with 1.
                let doubts = answer["doubts"].as_array().is_some_and(|doubts| !doubts.is_empty());
                assert_eq!(output.status.code(), Some(i32::from(doubts)), "{call:?}: {said}");
                let named = answer["written"].as_array().unwrap_or_else(|| panic!("{call:?}: no files: {said}"));
                let mut named: Vec<&str> =
                    named.iter().map(|name| name.as_str().unwrap().trim_start_matches("./")).collect();
                named.sort_unstable();
                let new = new_files(&folder, &before);
                assert_eq!(named, new.iter().map(|name| &name[..]).collect::<Vec<_>>(), "{call:?}");
                for report in named.iter().filter(|name| name.ends_with(".json") && !name.ends_with("-metadata.json")) {
                    let report: Value = serde_json::from_str(&folder.read(report)).unwrap();
                    assert!(holds(&answer, report), "{call:?}: the answer lacks what {named:?} say");
                }
                answer
            })
            .collect();
        if let Some(root) = generated::rewritten_below() {
            let mut schema = infer(&answers.iter().collect::<Vec<_>>(), "");
            let own = schema.as_object_mut().unwrap();
            own.insert("$schema".into(), "http://json-schema.org/draft-07/schema#".into());
            own.insert("title".into(), title(name).into());
            let text = serde_json::to_string_pretty(&schema).unwrap() + "\n";
            generated::write(&root, &format!("crates/erard-cli/schemas/{name}.schema.json"), text.as_bytes());
            continue;
        }
        let Ok(text) = std::fs::read_to_string(home(name)) else {
            without.push(name);
            continue;
        };
        let schema: Value = serde_json::from_str(&text).unwrap();
        for (answer, call) in answers.iter().zip(*calls) {
            let mut found = Vec::new();
            faults(answer, &schema, "", &mut found);
            assert!(found.is_empty(), "{call:?}: {found:#?}");
            assert!(answer["made_by"]["command"].as_str().unwrap().starts_with("erard "), "{call:?}");
        }
        // A schema that everything conforms to would say nothing.
        let mut found = Vec::new();
        faults(&json!({}), &schema, "", &mut found);
        assert!(!found.is_empty(), "{name}: an empty object conforms");
        let mut wrong = answers[0].clone();
        wrong["made_by"]["command"] = json!(1);
        found.clear();
        faults(&wrong, &schema, "", &mut found);
        assert_eq!(found.len(), 1, "{name}: {found:?}");
    }
    assert!(without.is_empty(), "without a schema: {without:?}");
}

/// No subcommand is left out, but those that serve until they are ended or have moved.
#[test]
fn every_subcommand_is_called() {
    let program = erard_cli::command::definition();
    for command in program.get_subcommands().filter(|command| !command.is_hide_set()) {
        let name = command.get_name();
        let mut calls = CALLS.iter().flat_map(|(_, calls)| *calls);
        assert!(name == "studio" || calls.any(|call| call[0] == name), "{name}");
    }
}

/// The technician's sheet as an answer: the measures, and the list of work with its lines.
#[test]
#[ignore = "ci: a list of work"]
fn the_answer_of_a_sheet_has_its_list_of_work() {
    let folder = Folder::new("json-sheet");
    let answer: Value = serde_json::from_str(&folder.good(&["measure", "heavy-touch", "--sheet", "--json"])).unwrap();
    let of = |name: &str| -> Value {
        let mut value: Value = serde_json::from_str(&folder.read(&format!("erard-out-measure/{name}"))).unwrap();
        let one = if value.is_array() { &mut value[0] } else { &mut value };
        one.as_object_mut().unwrap().remove("made_by");
        one.take()
    };
    assert_eq!(answer["sheet"], of("sheet.json"));
    assert!(!answer["sheet"]["tasks"].as_array().unwrap().is_empty(), "{answer}");
    for (key, value) in of("measure.json").as_object().unwrap() {
        assert_eq!(&answer[key], value, "{key}");
    }
}

/// The answer is what the file holds.
#[test]
fn the_answer_is_the_file() {
    let folder = Folder::new("json-file");
    let said = folder.good(&["press", "--duration", "0.05", "--json"]);
    let (mut answer, file): (Value, Value) =
        (serde_json::from_str(&said).unwrap(), serde_json::from_str(&folder.read("erard-out/summary.json")).unwrap());
    // It says more: the stroke, the hand, and which files were written.
    answer.as_object_mut().unwrap().retain(|key, _| file.get(key).is_some());
    assert_eq!(answer, file);
    // A failure is reported in words, and as JSON: of the command, and of the arguments.
    let schema: Value = serde_json::from_str(&std::fs::read_to_string(home("error")).unwrap()).unwrap();
    for arguments in [["press", "--dt", "7", "--json"], ["press", "--stroke", "fff", "--json"]] {
        let output = folder.erard(&arguments);
        assert_eq!(output.status.code(), Some(2));
        let error: Value = serde_json::from_slice(&output.stdout).unwrap();
        let mut found = Vec::new();
        faults(&error, &schema, "", &mut found);
        assert!(found.is_empty(), "{found:?}");
        let message = error["error"]["message"].as_str().unwrap();
        assert!(message.contains(arguments[1]) && String::from_utf8_lossy(&output.stderr).contains(message), "{error}");
    }
}

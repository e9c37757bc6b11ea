//! The register of an instrument's numbers against everything that lists them: the schema of files, the identity of
//! saved states, studies, fits, sensitivities, gradings, samples, causes, screws, sliders, units for simulators. A
//! number that is added to one of them and not to the register fails here; so does a number of the register that one of
//! them lost.

use std::collections::{BTreeMap, BTreeSet};
use std::fmt::Write;

use erard::instrument::{Instrument, InstrumentFile, json_schema, numbers_at};
use erard::keyboard::Keyboard;
use erard::parameter::{
    ChangeError, FileNumber, NameError, Parameter, ParameterChange, Quantity, aliases, number_of, register, varied,
    varied_text,
};
use erard_workshop::diagnose::{causes, entries, inject, injected_amount};
use erard_workshop::dials::{Group, dials, with_dials};
use erard_workshop::fit::fit_parameters;
use erard_workshop::fmu::{Role, Unit};
use erard_workshop::measure::norms::lines;
use erard_workshop::regulate::{Goal, KNOWN_SCREWS};
use erard_workshop::sample::drawn;
use erard_workshop::sensitivities::Variable;
use moreau::{LAWS, Range};
use serde_json::Value;

/// Numbers of the schema that are no numbers of the instrument.
const OTHER_NUMBERS: [(&str, &str); 4] = [
    ("key", "which key of a piano it is"),
    ("sample", "which sample of a piano it is"),
    ("board.*.seed", "which modes are drawn: no quantity"),
    ("part.*.outline_mm", "drawings: no result depends on them"),
];
/// Numbers on which no step depends.
const NO_STEP: [(FileNumber, &str); 2] = [
    (FileNumber::BODY_TURN, "a run beyond it is not trusted"),
    (FileNumber::FELT_THICKNESS, "a run that compresses the felt by more is not trusted"),
];
/// Paths of saved states that refer to a body or a zone and are no numbers.
const REFERENCES: [&str; 7] =
    [".hinged_on.", ".body.", ".damper.zone.", "roles.key.", "roles.hammer.", "roles.string.", "roles.pedal."];
/// Screws of the built-in instruments that no goal of a regulation turns.
const OTHER_SCREWS: [&str; 0] = [];

/// Name and text of every built-in instrument.
fn builtin() -> Vec<(String, String)> {
    let text = |name: &str| (name.to_owned(), Instrument::builtin_text(name).unwrap().to_owned());
    Instrument::builtin_names().map(text).collect()
}

/// An instrument with every number that a file can hold, for each law of felts.
fn complete() -> Vec<(String, String)> {
    let text = |law: usize| (format!("law {law}"), complete_of(law));
    // And one whose bridge stands still, so that its numbers are idle.
    let rigid = complete_of(0).replacen("[roles]\n", "[roles]\nrigid_bridge = true\n", 1);
    (0..LAWS.len()).map(text).chain([("rigid bridge".to_owned(), rigid)]).collect()
}

fn complete_of(law: usize) -> String {
    let mut felt = String::from("stiffness_N_per_m_r = 1e6, exponent = 2, thickness_mm = 3");
    for number in LAWS[law] {
        let si = match number.range {
            Range::Between(least, most) => (least * most).sqrt(),
            Range::UpTo(most) => most.sqrt(),
            _ => 0.3,
        };
        let _ = write!(felt, ", {} = {}", number.key, si * number.units_per_si);
    }
    let plain = "stiffness_N_per_m_r = 1e6, exponent = 2";
    format!(
        r#"
format = "erard-instrument/1"
name = "Every number"
gravity_m_s2 = 9.81
[[body]]
name = "key"
pivot_mm = [0, 1]
angle_deg = 1
mass_g = 100
inertia_kg_m2 = 2e-3
center_of_mass_mm = [10, 1]
friction_torque_N_m = 1e-3
viscous_N_m_s = 1e-4
static_friction_ratio = 1.5
dwell_s = 1
bushing_N_per_m = 1e5
bushing_N_s_per_m = 10
turn_deg = [-5, 5]
[[body]]
name = "hammer"
pivot_mm = [100, 50]
mass_g = 10
inertia_kg_m2 = 2e-4
center_of_mass_mm = [-100, 1]
pin_friction_N = 0.1
[[spring]]
name = "return"
body = "hammer"
torque_N_m = 1e-3
stiffness_N_m_per_rad = 1e-2
[[zone]]
name = "contact"
disc = {{ body = "key", center_mm = [80, 5], radius_mm = 5 }}
other_disc = {{ body = "hammer", center_mm = [-20, -30], radius_mm = 6 }}
felt = {{ {felt} }}
friction_coefficient = 0.2
static_friction_ratio = 1.2
dwell_s = 0.5
[[zone]]
name = "stop"
disc = {{ body = "key", center_mm = [-190, -5], radius_mm = 5 }}
segment = {{ body = "ground", from_mm = [-210, -20], to_mm = [-170, -21], rounding_mm = 1 }}
felt = {{ {plain} }}
[[zone]]
name = "string"
disc = {{ body = "hammer", center_mm = [-130, 20], radius_mm = 8 }}
line = {{ body = "ground", point_mm = [-30, 120], normal = [0.1, -1] }}
felt = {{ {plain} }}
[[zone]]
name = "rail"
disc = {{ body = "hammer", center_mm = [0, 0] }}
line = {{ body = "ground", point_mm = [100, 50.1], normal = [0, 1] }}
felt = {{ {plain} }}
[[zone]]
name = "damper"
disc = {{ body = "key", center_mm = [120, 30], radius_mm = 8 }}
line = {{ body = "ground", point_mm = [120, 60], normal = [0.1, -1] }}
felt = {{ {plain} }}
[[string]]
name = "left"
length_mm = 600
diameter_mm = 1
tension_N = 700
detuned_cents = 1
loss_per_s = 1
loss_s = 1e-9
strike_mm = 70
strike_share = 2
strike_angle_deg = 1
damper = {{ zone = "damper", middle_mm = 100, length_mm = 40 }}
[[string]]
name = "right"
length_mm = 610
mass_g_per_m = 6
frequency_Hz = 262
inharmonicity = 3e-4
loss_per_s = 1
strike_mm = 70
[[bridge_mode]]
name = "first"
mass_g = 1000
frequency_Hz = 100
loss_factor = 0.1
horizontal = 0.1
[[board]]
name = "low"
from_Hz = 110
to_Hz = 200
modal_density_s = 0.05
mass_g = 1000
loss_factor = 0.1
horizontal = 0.1
[roles]
key = "key"
key_front_mm = [-200, 1]
hammer = "hammer"
hammer_head_mm = [-130, 28]
string = "string"
[finger]
stiffness_N_per_m = 5e4
damping_N_s_per_m = 20
[[screw]]
name = "move"
zone = "stop"
side = "disc"
direction = [0.1, 1]
setting_mm = 0.1
[[screw]]
name = "turn"
zone = "stop"
side = "curve"
setting_deg = 1
[[screw]]
name = "tighten"
spring = "return"
setting_N_m = 1e-4
"#
    )
}

/// Path of a kind of numbers: the name of the part is `*`.
fn form(number: FileNumber) -> String {
    number.path("*")
}

/// Whether a schema's type, or one of its types, is a number.
fn is_number(kind: &Value) -> bool {
    kind == "number" || kind == "integer" || kind.as_array().is_some_and(|kinds| kinds.iter().any(is_number))
}

/// Kinds of numbers in the schema, as [`form`].
fn schema_forms() -> BTreeSet<String> {
    fn walk(schema: &Value, node: &Value, path: &str, forms: &mut BTreeSet<String>) {
        let mut refers = vec![node];
        for key in ["allOf", "anyOf"] {
            refers.extend(node[key].as_array().into_iter().flatten());
        }
        let target = refers.iter().find_map(|node| node["$ref"].as_str()).map(|name| {
            let name = name.rsplit('/').next().unwrap();
            (name, &schema["definitions"][name])
        });
        let quantity = target.is_some_and(|(name, _)| name.ends_with("Quantity"));
        let node = target.map_or(node, |(_, node)| node);
        let within = |key: &str| if path.is_empty() { key.to_owned() } else { format!("{path}.{key}") };
        if quantity {
            forms.insert(path.to_owned());
        } else if let Some(properties) = node["properties"].as_object() {
            properties.iter().for_each(|(key, node)| walk(schema, node, &within(key), forms));
        } else if node["type"] == "array" && node["items"]["$ref"].is_string() {
            walk(schema, &node["items"], &within("*"), forms);
        } else if [&node["type"], &node["items"]["type"], &node["items"]["items"]["type"]].into_iter().any(is_number) {
            forms.insert(path.to_owned());
        }
    }
    let schema: Value = serde_json::from_str(&json_schema()).unwrap();
    let mut forms = BTreeSet::new();
    walk(&schema, &schema, "", &mut forms);
    forms
}

/// The schema of files and the register list the same numbers, and the end of each key is its unit.
#[test]
fn every_number_of_the_schema_is_registered() {
    let registered: BTreeSet<String> = FileNumber::all().map(form).collect();
    let schema = schema_forms();
    assert!(schema.len() > 50, "{schema:?}");
    for (path, why) in OTHER_NUMBERS {
        assert!(schema.contains(path) && !registered.contains(path), "{path}: {why}");
    }
    let other: BTreeSet<String> = OTHER_NUMBERS.iter().map(|(path, _)| (*path).to_owned()).collect();
    let listed: BTreeSet<String> = registered.union(&other).cloned().collect();
    let missing: Vec<_> = schema.difference(&listed).collect();
    assert!(missing.is_empty(), "not in the register (`erard-core/src/instrument/file_number.rs`): {missing:?}");
    let gone: Vec<_> = listed.difference(&schema).collect();
    assert!(gone.is_empty(), "not in the schema: {gone:?}");
    for number in FileNumber::all() {
        let of_key = number.quantity().1.map_or("", |unit| unit.symbol);
        // For people an angle is in degrees, no radian needs to be named beside a damping, and a share has no unit.
        let shown = [("deg", "degrees"), ("N m s/rad", "N m s"), ("1", "")];
        let own = shown.iter().find(|(symbol, _)| *symbol == of_key).map_or(of_key, |(_, shown)| shown);
        assert_eq!(number.unit, own, "{}", form(number));
        assert!(number.least < number.most, "{}", form(number));
    }
}

/// Identity of an instrument, and on what trust depends: all numbers of which a result depends.
fn numbers(instrument: &Instrument) -> (BTreeMap<String, u64>, Vec<u64>) {
    let identity = instrument.parameters().into_iter().map(|(path, value)| (path, value.to_bits())).collect();
    let turns = instrument.bodies.iter().flat_map(|body| body.turn_rad.unwrap_or_default());
    let thicknesses = instrument.zones.iter().map(|zone| zone.felt.thickness_m.unwrap_or_default());
    (identity, turns.chain(thicknesses).map(f64::to_bits).collect())
}

/// Paths of numbers that differ.
fn differing(a: &BTreeMap<String, u64>, b: &BTreeMap<String, u64>) -> BTreeSet<String> {
    a.keys().chain(b.keys()).filter(|path| a.get(*path) != b.get(*path)).cloned().collect()
}

/// A change that shows of a number at a path: the first of these that the reader takes.
fn changed(text: &str, name: &str, value: f64) -> Result<Instrument, ChangeError> {
    let changes = if value == 0.0 { ["+0.001", "+1e-7", "-1e-7"] } else { ["x1.001", "x0.999", "x1.0000001"] };
    let mut last = None;
    for change in changes {
        match varied(text, "varied", &[(name.to_owned(), ParameterChange::Text(change.to_owned()))]) {
            Ok(file) => return Ok(file.instrument),
            Err(error @ ChangeError::Idle(_)) => return Err(error),
            Err(error) => last = Some(error),
        }
    }
    Err(last.unwrap())
}

/// What the numbers of one file do: kinds that act, each with the identity's paths that it changes.
fn effects(name: &str, text: &str) -> (BTreeMap<String, BTreeSet<String>>, BTreeSet<String>) {
    let file = InstrumentFile::parse(text, name).unwrap();
    let (identity, trust) = numbers(&file.instrument);
    let mut acting: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut idle = BTreeSet::new();
    for number in file.provenance.numbers.iter().filter(|number| !number.key.starts_with("part.")) {
        let kind = FileNumber::of_path(&number.key).unwrap_or_else(|| panic!("{name}: {}", number.key));
        // A direction acts as soon as its screw is turned.
        let screw = kind.part_of(&number.key).and_then(|part| file.instrument.screw(part));
        let is_direction = kind == FileNumber::SCREW_DIRECTION
            && screw.is_some_and(|screw| file.instrument.screws[screw].setting == 0.0);
        for (which, value) in number.values.iter().enumerate() {
            let path = match number.values.len() {
                1 => number.key.clone(),
                _ => format!("{}.{}", number.key, ["x", "y"][which]),
            };
            match changed(text, &path, *value) {
                Ok(instrument) => {
                    let (new, new_trust) = numbers(&instrument);
                    let paths = differing(&identity, &new);
                    let only_trust = NO_STEP.iter().any(|(number, _)| *number == kind);
                    assert_eq!(new_trust != trust, only_trust, "{name}: {path}");
                    assert!(!paths.is_empty() || only_trust || is_direction, "{name}: {path} does nothing");
                    if !is_direction {
                        acting.entry(form(kind)).or_default().extend(paths);
                    }
                }
                Err(ChangeError::Idle(NameError::Idle { acts, .. })) => {
                    if let Some((key, _)) = acts.split_once(" = false") {
                        assert!(text.contains(&format!("{key} = true")), "{name}: {path}: {acts}");
                    } else {
                        let (.., value) = number_of(text, &acts).unwrap_or_else(|| panic!("{name}: {path}: {acts}"));
                        let acted = changed(text, &acts, value).unwrap_or_else(|error| panic!("{path}: {error}"));
                        let is_changed = acted.digest() != file.instrument.digest();
                        assert!(is_changed || is_direction, "{name}: {path}: {acts} does nothing");
                    }
                    idle.insert(format!("{path} -> {acts}"));
                }
                Err(error) => panic!("{name}: {path}: {error}"),
            }
        }
    }
    (acting, idle)
}

/// Every number of every built-in file acts, or its name is refused with one that acts. Every kind of number acts in
/// some file, and every number of an identity is changed by one of them.
#[test]
fn every_number_of_a_file_acts_or_is_refused() {
    let texts: Vec<(String, String)> = builtin().into_iter().chain(complete()).collect();
    let found: Vec<_> = std::thread::scope(|scope| {
        let jobs: Vec<_> = texts.iter().map(|(name, text)| scope.spawn(|| effects(name, text))).collect();
        jobs.into_iter().map(|job| job.join().unwrap()).collect()
    });
    let (mut acting, mut idle) = (BTreeMap::<String, BTreeSet<String>>::new(), BTreeSet::new());
    for (own_acting, own_idle) in found {
        for (kind, paths) in own_acting {
            acting.entry(kind).or_default().extend(paths);
        }
        idle.extend(own_idle);
    }
    for name in [
        "body.key.friction_torque_N_m -> body.key_back.friction_torque_N_m",
        "body.hammer.friction_torque_N_m -> body.shank.friction_torque_N_m",
    ] {
        assert!(idle.contains(name), "{idle:?}");
    }
    assert!(idle.iter().any(|name| name.starts_with("bridge_mode.") && name.ends_with("rigid_bridge = false")));
    let registered: BTreeSet<String> = FileNumber::all().map(form).collect();
    let without: Vec<_> = registered.iter().filter(|kind| !acting.contains_key(*kind)).collect();
    assert!(without.is_empty(), "in no file: {without:?}");
    let changed: BTreeSet<String> = acting.values().flatten().map(|path| kind_of(path)).collect();
    for (name, text) in &texts {
        for (path, _) in Instrument::parse(text, name).unwrap().parameters() {
            let refers = REFERENCES.iter().any(|reference| path.contains(reference));
            assert!(refers || changed.contains(&kind_of(&path)), "{name}: no number of a file changes {path}");
        }
    }
}

/// Kind of a number of an identity: its path with `*` for the part's name, without the coordinate.
fn kind_of(path: &str) -> String {
    let path = path.strip_suffix(".x").or_else(|| path.strip_suffix(".y")).unwrap_or(path);
    let mut segments: Vec<&str> = path.split('.').collect();
    if ["body", "spring", "zone", "string", "bridge_mode"].contains(&segments[0]) {
        segments[1] = "*";
    }
    segments.join(".")
}

/// Kind of a number of files that an identity's number comes from: the unit differs.
fn file_kind(path: &str) -> Option<FileNumber> {
    let kind = kind_of(path);
    let in_file = |(si, unit): (&str, &str)| kind.strip_suffix(si).map(|start| format!("{start}{unit}"));
    let units = [("_kg", "_g"), ("_m", "_mm"), ("_rad", "_deg"), ("", "")];
    units.into_iter().filter_map(in_file).find_map(|path| FileNumber::of_path(&path.replace('*', "part")))
}

fn files() -> Vec<InstrumentFile> {
    Instrument::builtin_names().map(|name| InstrumentFile::builtin(name).unwrap()).collect()
}

/// Kinds of numbers that have names.
const NAMED: [FileNumber; 6] = [
    FileNumber::BODY_MASS,
    FileNumber::BODY_FRICTION,
    FileNumber::SPRING_TORQUE,
    FileNumber::SPRING_STIFFNESS,
    FileNumber::FELT_STIFFNESS,
    FileNumber::ZONE_FRICTION,
];

/// Every registered number of every built-in instrument changes the mechanism, and has its own quantity and path.
#[test]
fn every_name_acts() {
    for file in files() {
        let grand = &file.instrument;
        let all = register(&file);
        let names: BTreeSet<&str> = all.iter().map(|entry| entry.name.as_str()).collect();
        let paths: BTreeSet<&str> = all.iter().map(|entry| entry.path.as_str()).collect();
        assert_eq!((names.len(), paths.len()), (all.len(), all.len()), "{}", grand.name);
        for entry in &all {
            let mut varied = grand.clone();
            let by = if entry.parameter.is_factor() { 1.07 } else { 1.7e-5 };
            entry.parameter.vary(&mut varied, by).unwrap_or_else(|e| panic!("{}: {}: {e}", grand.name, entry.name));
            assert_ne!(varied.digest(), grand.digest(), "{}: {} does nothing", grand.name, entry.name);
            assert_eq!(Parameter::named(grand, &entry.name).unwrap().1, entry.parameter);
            let own = Quantity::of_name(&entry.path).map_or(Quantity::Number, |(quantity, _)| quantity);
            assert_eq!(own, entry.quantity, "{}", entry.path);
        }
    }
}

/// The dry torque of a bend is no pivot's friction: no result depends on it, and its name is refused with the one that
/// acts.
#[test]
fn idle_names_are_refused_with_those_that_act() {
    let mut idle = BTreeSet::new();
    for file in files() {
        let grand = &file.instrument;
        for body in grand.bodies.iter().filter(|body| body.friction_torque_n_m > 0.0) {
            let name = format!("body.{}.friction", body.name);
            match Parameter::named(grand, &name) {
                Ok(_) => assert!(!body.is_bend, "{}: {name}", grand.name),
                Err(NameError::Idle { acts, .. }) => {
                    assert!(body.is_bend && Parameter::named(grand, &acts).is_ok(), "{}: {name} {acts}", grand.name);
                    idle.insert(format!("{name} -> {acts}"));
                }
                Err(error) => assert!(body.is_bend, "{}: {error}", grand.name),
            }
        }
    }
    assert!(idle.contains("body.key.friction -> body.key_back.friction"), "{idle:?}");
    assert!(idle.contains("body.hammer.friction -> body.shank.friction"), "{idle:?}");
}

/// Identity, files and register list the same numbers, both ways.
#[test]
fn identity_files_and_register_agree() {
    let is_named = |path: &str| file_kind(path).is_some_and(|number| NAMED.contains(&number));
    for file in files() {
        let grand = &file.instrument;
        let bends: Vec<String> = grand
            .bodies
            .iter()
            .filter(|body| body.is_bend)
            .map(|body| format!("body.{}.friction_torque_N_m", body.name))
            .collect();
        // The arm of a pin is a device: its numbers change steps and are none of the file's.
        let arms: Vec<String> = (0..grand.bodies.len())
            .filter(|&body| grand.is_arm(body))
            .map(|body| format!("body.{}.", grand.bodies[body].name))
            .collect();
        let is_arms = |path: &str| arms.iter().any(|arm| path.starts_with(arm.as_str()));
        let all = register(&file);
        let si = |path: &str| path.replace(".mass_g", ".mass_kg");
        let registered: BTreeSet<String> = all.iter().map(|entry| si(&entry.path)).collect();
        let identity: BTreeSet<String> = grand.parameters().into_iter().map(|(path, _)| path).collect();
        for path in identity.iter().filter(|path| is_named(path) && !bends.contains(path) && !is_arms(path)) {
            assert!(registered.contains(path), "{}: {path} is not in the register", grand.name);
        }
        for entry in all.iter().filter(|entry| entry.parameter.is_factor()) {
            assert!(identity.contains(&si(&entry.path)), "{}: {} changes no step", grand.name, entry.path);
        }
        for number in &file.provenance.numbers {
            let path = si(&number.key);
            if path.starts_with("part.") || bends.contains(&path) || number.values.first() == Some(&0.0) {
                continue;
            }
            let is_setting = [FileNumber::SCREW_LENGTH, FileNumber::SCREW_ANGLE, FileNumber::SCREW_TORQUE]
                .iter()
                .any(|number| number.part_of(&path).is_some());
            if is_named(&path) || is_setting {
                assert!(registered.contains(&path), "{}: {path} is not in the register", grand.name);
            }
        }
        let written: BTreeSet<&str> = file.provenance.numbers.iter().map(|number| number.key.as_str()).collect();
        for entry in &all {
            let is_made =
                grand.bodies.iter().any(|body| body.is_bend && entry.name.contains(&format!(".{}.", body.name)));
            let is_written = written.contains(entry.path.as_str()) || entry.value == 0.0 || is_made;
            assert!(is_written, "{}: {} is not in the file", grand.name, entry.path);
        }
    }
}

/// Paths of a file's numbers and their values.
fn numbers_of(text: &str) -> BTreeMap<String, u64> {
    let file = InstrumentFile::parse(text, "numbers").unwrap();
    let values = file.provenance.numbers.into_iter().flat_map(|number| {
        let path = move |which: usize| format!("{}[{which}]", number.key);
        number.values.into_iter().enumerate().map(move |(which, value)| (path(which), value.to_bits()))
    });
    values.collect()
}

/// Kinds of the numbers of files that differ; every one of them is registered.
fn kinds_that_differ(a: &str, b: &str, who: &str) -> BTreeSet<String> {
    let paths = differing(&numbers_of(a), &numbers_of(b));
    let kind = |path: String| {
        let path = path.split('[').next().unwrap();
        form(FileNumber::of_path(path).unwrap_or_else(|| panic!("{who} changes {path}")))
    };
    paths.into_iter().map(kind).collect()
}

/// Kinds of the identity's numbers that differ; every one of them is registered.
fn kinds_changed(a: &Instrument, b: &Instrument, who: &str) -> BTreeSet<String> {
    let paths = differing(&numbers(a).0, &numbers(b).0);
    paths.iter().map(|path| form(file_kind(path).unwrap_or_else(|| panic!("{who} changes {path}")))).collect()
}

/// Studies, fits and sensitivities take every parameter by its name and by its regional names, and know no others.
#[test]
fn studies_fits_and_sensitivities_take_every_parameter() {
    let file = InstrumentFile::builtin("concert-grand").unwrap();
    let text = Instrument::builtin_text("concert-grand").unwrap();
    let all = register(&file);
    let variables: BTreeSet<String> = Variable::all(&file.instrument).into_iter().map(|one| one.name).collect();
    let names: BTreeSet<String> = all.iter().map(|entry| entry.name.clone()).collect();
    assert_eq!(variables, names);
    for entry in &all {
        let fitted = fit_parameters(&file, std::slice::from_ref(&entry.name), &Vec::new());
        let [fitted] = &fitted.unwrap_or_else(|error| panic!("{}: {error}", entry.name))[..] else { panic!() };
        assert_eq!((fitted.value, fitted.unit()), (entry.value, entry.quantity.si_unit()), "{}", entry.name);
        for name in aliases(&entry.name) {
            assert_eq!(Parameter::named(&file.instrument, &name).unwrap().0, entry.name, "{name}");
        }
        let change = ParameterChange::Text("x1.0001".to_owned());
        if entry.parameter.is_factor() && numbers_at(text, &entry.path).is_some() {
            let new = varied_text(text, "varied", &entry.name, &change).unwrap();
            let paths: BTreeSet<String> = differing(&numbers_of(text), &numbers_of(&new))
                .iter()
                .map(|path| path.trim_end_matches("[0]").to_owned())
                .collect();
            assert!(
                paths.iter().all(|path| entry.parameter.paths(&file.instrument).unwrap().contains(path)),
                "{paths:?}"
            );
            assert!(paths.contains(&entry.path), "{}: {paths:?}", entry.name);
        }
    }
}

/// Gradings change registered numbers, every one at some key.
#[test]
fn gradings_change_registered_numbers() {
    for name in Keyboard::builtin_names() {
        let keyboard = Keyboard::builtin(name).unwrap();
        let at = |key: usize| kinds_that_differ(keyboard.base_text(), &keyboard.key_text(key), name);
        let kinds: BTreeSet<String> = at(1).union(&at(88)).cloned().collect();
        for grading in &keyboard.gradings {
            let mut without = keyboard.clone();
            without.gradings.retain(|other| other != grading);
            let acts = [1, 88].into_iter().any(|key| without.key_text(key) != keyboard.key_text(key));
            assert!(acts, "{name}: {} does nothing", grading.name);
        }
        assert!(kinds.contains(&form(FileNumber::BODY_MASS)), "{kinds:?}");
    }
}

/// Samples draw the numbers with a spread and no others: what the register says of its own, and every further number of
/// the file that states one.
#[test]
fn samples_draw_the_spreads_of_the_register() {
    for name in Instrument::builtin_names() {
        let text = Instrument::builtin_text(name).unwrap();
        let file = InstrumentFile::parse(text, name).unwrap();
        let stated = |key: &str| {
            let number = file.provenance.numbers.iter().find(|number| number.key == key);
            number.and_then(|number| number.citation.as_ref()).is_some_and(|citation| citation.spread.is_some())
        };
        if drawn(&file, text, 1, 0).is_none() {
            assert!(register(&file).iter().all(|entry| entry.spread.is_none()), "{name}");
            continue;
        }
        // Some draws are no possible instruments.
        let mut draws = (0..40).filter_map(|attempt| drawn(&file, text, 1, attempt));
        let sample = draws.find(|sample| Instrument::parse(sample, "sample").is_ok()).unwrap();
        kinds_that_differ(text, &sample, name);
        let changed: BTreeSet<String> = differing(&numbers_of(text), &numbers_of(&sample))
            .iter()
            .map(|path| path.split('[').next().unwrap().to_owned())
            .collect();
        for path in &changed {
            let exponent = FileNumber::FELT_STIFFNESS.part_of(path).map(|zone| FileNumber::FELT_EXPONENT.path(zone));
            assert!(stated(path) || exponent.is_some_and(|exponent| changed.contains(&exponent)), "{name}: {path}");
        }
        for entry in register(&file) {
            assert!(entry.spread.is_none() || changed.contains(&entry.path), "{name}: {} is not drawn", entry.path);
        }
    }
}

/// Every cause of a diagnosis changes registered numbers.
#[test]
fn causes_change_registered_numbers() {
    let grand = Instrument::builtin("concert-grand").unwrap();
    for cause in causes() {
        let amount = injected_amount(cause, 2.0);
        let changed = inject(&grand, cause, amount, false, &mut |_| true).unwrap();
        let kinds = kinds_changed(&grand, &changed, &cause.key);
        assert!(!kinds.is_empty(), "{} does nothing", cause.key);
    }
}

/// The screws of the trade are the screws of the grands, each goal has one, and their ranges are within the register's.
#[test]
fn known_screws_are_the_screws_of_the_register() {
    let mut used = BTreeSet::new();
    for grand in files().into_iter().map(|file| file.instrument) {
        for (name, parameter) in Parameter::all(&grand) {
            let Parameter::Screw { screw, .. } = parameter else { continue };
            let Some(known) = KNOWN_SCREWS.iter().find(|known| known.name == name) else {
                assert!(OTHER_SCREWS.contains(&name.as_str()), "{}: no goal turns {name}", grand.name);
                continue;
            };
            let ([low, high], [least, most]) = (known.limits(&grand, &grand.screws[screw]), parameter.range());
            assert!(least <= low && low < high && high <= most, "{name}: {low} to {high}");
            used.insert(known.name);
        }
    }
    for known in KNOWN_SCREWS {
        assert!(used.contains(known.name), "no instrument has {}", known.name);
    }
    for goal in Goal::ALL {
        assert!(KNOWN_SCREWS.iter().any(|screw| screw.goals.iter().any(|(own, _)| *own == goal)), "{}", goal.name());
    }
}

/// A goal has the name of its line on the sheet, without the unit, and is found by it however its words are joined;
/// the options of `diagnose` for these readings have the same names.
#[test]
fn goals_are_named_as_the_sheet_names_them() {
    for goal in Goal::ALL {
        let own = goal.name().replace([' ', '-'], "_");
        let is_own =
            |key: &str| key.strip_prefix(&own).is_some_and(|unit| ["_mm", "_m_per_s", "_share"].contains(&unit));
        let line = lines().find(|line| is_own(line.key)).unwrap_or_else(|| panic!("no line is called {own}"));
        if let Some(entry) = entries().iter().find(|entry| *line.key == *entry.name) {
            assert!(entry.is_called(&own), "{own}");
        }
        for name in [own.clone(), own.replace('_', "-"), own.replace('_', " "), format!(" {own}").to_uppercase()] {
            assert_eq!(Goal::named(&name), Some(goal), "{name}");
        }
    }
    for (name, goal) in [("spring", Goal::RepetitionSpring), ("damper", Goal::DamperStart), ("set off", Goal::LetOff)] {
        assert_eq!(Goal::named(name), Some(goal), "{name}");
    }
    assert_eq!(Goal::named("lets-off"), None);
}

/// Sliders are the screws of the register with their settings and units, and further ones that change registered
/// numbers.
#[test]
fn sliders_are_the_screws_and_further_numbers() {
    for name in Instrument::builtin_names() {
        let text = Instrument::builtin_text(name).unwrap();
        let file = InstrumentFile::parse(text, name).unwrap();
        let all = dials(&file);
        let screws: BTreeMap<&str, f64> = all
            .iter()
            .filter(|dial| dial.group == Group::Screws)
            .map(|dial| (dial.name.as_str(), dial.value))
            .collect();
        let entries: Vec<_> = register(&file).into_iter().filter(|entry| !entry.parameter.is_factor()).collect();
        assert_eq!(screws.len(), entries.len(), "{name}");
        for entry in &entries {
            let shown = entry.value * entry.quantity.shown().0;
            let own = screws.get(entry.name.as_str()).unwrap_or_else(|| panic!("{name}: no slider {}", entry.name));
            assert!((own - shown).abs() < 1e-9, "{name}: {} {own} {shown}", entry.name);
        }
        for dial in &all {
            let to = if (dial.to - dial.value).abs() > (dial.value - dial.from).abs() { dial.to } else { dial.from };
            let value = dial.value + 0.1 * (to - dial.value);
            let new = with_dials(&file, text, &[(dial.name.clone(), value)]).unwrap();
            let kinds = kinds_that_differ(text, &new, &dial.name);
            assert!(!kinds.is_empty(), "{name}: {} does nothing", dial.name);
        }
    }
}

/// A unit for simulators has every number of the file that is registered, and the masses of the register.
#[test]
fn units_for_simulators_have_every_number() {
    for name in Instrument::builtin_names() {
        let text = Instrument::builtin_text(name).unwrap();
        let file = InstrumentFile::parse(text, name).unwrap();
        let unit = Unit::of_instrument(text).unwrap();
        let of_role = |is: fn(&Role) -> bool| -> BTreeSet<String> {
            unit.variables.iter().filter(|variable| is(&variable.role)).map(|variable| variable.name.clone()).collect()
        };
        let numbers = of_role(|role| matches!(role, Role::Number(..)));
        let written: BTreeSet<String> = file
            .provenance
            .numbers
            .iter()
            .filter(|number| FileNumber::of_path(&number.key).is_some())
            .flat_map(|number| match number.values.len() {
                1 => vec![number.key.clone()],
                _ => (1..=number.values.len()).map(|which| format!("{}[{which}]", number.key)).collect(),
            })
            .collect();
        assert_eq!(numbers, written, "{name}");
        let masses = of_role(|role| matches!(role, Role::Mass(_)));
        let registered: BTreeSet<String> =
            register(&file).into_iter().filter(|e| matches!(e.parameter, Parameter::Mass(_))).map(|e| e.name).collect();
        assert_eq!(masses, registered, "{name}");
        for variable in &unit.variables {
            let Some(number) = FileNumber::of_path(variable.name.split('[').next().unwrap()) else { continue };
            // A felt's stiffness has no unit that SI units make up.
            let (quantity, own) = number.quantity();
            let own = own.filter(|_| quantity.dimension().is_some_and(|exponents| exponents != [0; 4]));
            assert_eq!(variable.unit, own.map_or("", |unit| unit.symbol), "{name}: {}", variable.name);
        }
    }
}

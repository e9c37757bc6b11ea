//! Functional mock-up units (FMI 2.0, co-simulation) of one key's instrument or of a keyboard: their variables, and the
//! description for the archive.
//!
//! The library inside the unit (`erard-c`) and the command that writes it must number the variables alike: both use
//! this module. `unit` reads a unit's files and applies its parameters, `description` writes `modelDescription.xml`.

mod description;
mod unit;

use erard::instrument::{InstrumentFile, numbers_at_each};
use erard::keyboard::{KEYS, note_name};

use erard::parameter::Parameter;

pub use unit::Unit;

/// Name of the library inside the archive, and of the model.
pub const MODEL: &str = "erard";
/// Path of the instrument file inside the archive; of a keyboard, the file of its base instrument.
pub const INSTRUMENT: &str = "resources/instrument.toml";
/// Path of the keyboard file inside the archive of a keyboard.
pub const KEYBOARD: &str = "resources/keyboard.toml";

/// Meaning of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Force on the key front, N, down positive.
    Force,
    /// Position of the driver's end of the fingertip, m below the key's rest.
    Position,
    /// Its velocity, m/s.
    Velocity,
    /// Lift of the sustain pedal's rail set by the pedal, m.
    Pedal,
    /// Mass of the hand, kg; its muscle's stiffness, N/m, and damping, N s/m; the compliance of its joints, m/N, and
    /// their retardation time, s.
    HandMass,
    /// See [`Role::HandMass`].
    MuscleStiffness,
    /// See [`Role::HandMass`].
    MuscleDamping,
    /// See [`Role::HandMass`].
    JointsCompliance,
    /// See [`Role::HandMass`].
    JointsTime,
    /// Selects the drive, see the description of [`Variable`]; an integer. A parameter of one key's unit, an input of
    /// each key of a keyboard.
    Drive,
    /// Length of a step, s.
    Step,
    /// A number of the reading, by its index in `READING`.
    Reading(usize),
    /// Number of impacts since the start; an integer.
    Impacts,
    /// Force of the strings of all keys of a keyboard on the bridge, N.
    BridgeSum,
    /// Number of awake keys of a keyboard; an integer.
    Awake,
    /// Normal force of a contact zone, N.
    Contact(usize),
    /// Mass of a body, kg, by the body's index: its inertia changes in proportion.
    Mass(usize),
    /// A number of the instrument's file, by its index and the index of its component.
    Number(usize, usize),
}

/// Numbers of the reading: name, unit, description.
pub(crate) const READING: [(&str, &str, &str); 11] = [
    ("key", "m", "Travel of the key front, down positive"),
    ("key_velocity", "m/s", "Its velocity, down positive"),
    ("finger_force", "N", "Force of the finger on the key in the last step"),
    ("hammer", "m", "Rise of the hammer's strike point"),
    ("hammer_velocity", "m/s", "Its velocity, up positive"),
    ("string_force", "N", "Force between hammer and string in the last step"),
    ("impact_time", "s", "Instant of the last impact of the hammer on the string; 0 before the first"),
    ("hammer_speed", "m/s", "Total speed of the strike point at the last impact; 0 before the first"),
    ("bridge_force", "N", "Force of the strings on the bridge; 0 where they do not sound"),
    ("hand", "m", "Place of the hand, below the key front's rest (drive = 4)"),
    ("hand_velocity", "m/s", "Its velocity, down positive"),
];

/// Numbers that belong to the last impact.
const LAST_IMPACT: [&str; 2] = ["impact_time", "hammer_speed"];
/// Numbers left out for keys of a keyboard, to keep its list short.
const KEYBOARD_WITHOUT: [&str; 3] = ["key_velocity", "hand", "hand_velocity"];

/// A variable of the unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Value reference, unique among the variables of its type.
    pub reference: u32,
    /// Name of the variable. Parameters of the file have their dotted path; the two coordinates of a point end in `[1]`
    /// and `[2]`.
    pub name: String,
    /// Meaning.
    pub role: Role,
    /// Key of the keyboard, from 1; `None` for a variable of the whole unit.
    pub key: Option<usize>,
    /// Start value; `None` for calculated variables.
    pub start: Option<f64>,
    /// Unit; empty if the last part of the name has none.
    pub unit: &'static str,
    /// Description in one line.
    pub description: String,
}

impl Variable {
    /// Whether the variable is an integer.
    #[must_use]
    pub fn is_integer(&self) -> bool {
        matches!(self.role, Role::Drive | Role::Impacts | Role::Awake)
    }

    /// Whether it can be set before initialisation only.
    #[must_use]
    pub fn is_parameter(&self) -> bool {
        let is_setting = matches!(
            self.role,
            Role::Step
                | Role::HandMass
                | Role::MuscleStiffness
                | Role::MuscleDamping
                | Role::JointsCompliance
                | Role::JointsTime
                | Role::Mass(_)
                | Role::Number(..)
        );
        is_setting || self.role == Role::Drive && self.key.is_none()
    }

    /// Whether it can be set at any time.
    #[must_use]
    pub fn is_input(&self) -> bool {
        let moves = matches!(self.role, Role::Force | Role::Position | Role::Velocity | Role::Pedal);
        moves || self.role == Role::Drive && self.key.is_some()
    }

    /// Whether it changes at discrete instants only.
    fn is_discrete(&self) -> bool {
        self.is_integer() || matches!(self.role, Role::Reading(n) if LAST_IMPACT.contains(&READING[n].0))
    }
}

/// First references of the reading, of contacts, of bodies' masses and of the file's numbers.
const READING_FROM: u32 = 100;
const CONTACTS_FROM: u32 = 1000;
const MASSES_FROM: u32 = 5000;
const NUMBERS_FROM: u32 = 10_000;

/// Distance of the references of two keys of a keyboard; a key's own unit has those of key 0.
const KEY_SPAN: u32 = 1_000_000;

fn variable(reference: u32, name: &str, role: Role, start: Option<f64>, unit: &'static str, text: &str) -> Variable {
    Variable { reference, name: name.to_owned(), role, key: None, start, unit, description: text.to_owned() }
}

/// Makes a variable of one key's unit that of a key of a keyboard.
fn of_key(key: usize, own: Variable) -> Variable {
    Variable {
        reference: own.reference + KEY_SPAN * key as u32,
        name: format!("key[{key}].{}", own.name),
        key: Some(key),
        description: format!("{}: {}", note_name(key), own.description),
        ..own
    }
}

/// Drive of a key.
fn driver() -> [Variable; 4] {
    [
        variable(
            0,
            "force",
            Role::Force,
            Some(0.0),
            "N",
            "Force on the key front (drive = 1) or of the muscle on its hand (drive = 4), down positive",
        ),
        variable(
            1,
            "position",
            Role::Position,
            Some(0.0),
            "m",
            "Below the key's rest, at the beginning of a communication step, from where it goes on at its velocity: the finger's end of the fingertip (drive = 2), the key front (3), where the muscle holds its hand (4)",
        ),
        variable(2, "velocity", Role::Velocity, Some(0.0), "m/s", "Its velocity"),
        variable(
            0,
            "drive",
            Role::Drive,
            Some(1.0),
            "",
            "What drives the key: 0 nothing, 1 a force, 2 a motion through the fingertip, 3 the key front's own motion, 4 a hand of some mass",
        ),
    ]
}

/// Step, pedal and hand.
fn settings(step_s: f64) -> [Variable; 7] {
    [
        variable(
            3,
            "step_s",
            Role::Step,
            Some(step_s),
            "s",
            "Length of a step of the simulation: at first that of a press, 50e-6, or 1/24000 where strings sound",
        ),
        variable(4, "pedal", Role::Pedal, Some(0.0), "m", "Lift of the sustain pedal's rail, 0 to 0.010"),
        variable(5, "hand_mass", Role::HandMass, Some(0.2), "kg", "Mass of the hand at its fingertip (drive = 4)"),
        variable(6, "muscle_stiffness", Role::MuscleStiffness, Some(0.0), "N/m", "Stiffness of its muscle (drive = 4)"),
        variable(7, "muscle_damping", Role::MuscleDamping, Some(0.0), "N.s/m", "Damping of its muscle (drive = 4)"),
        variable(
            8,
            "joints_compliance",
            Role::JointsCompliance,
            Some(0.0),
            "m/N",
            "Compliance of the joints of its finger, 0 to 0.1 (drive = 4)",
        ),
        variable(
            9,
            "joints_time",
            Role::JointsTime,
            Some(0.0),
            "s",
            "Damping of these joints over their stiffness, 0 to 1 (drive = 4)",
        ),
    ]
}

/// The reading of a key.
fn readings() -> impl Iterator<Item = Variable> {
    let numbers = READING.iter().enumerate().map(|(n, (name, unit, description))| {
        variable(READING_FROM + n as u32, name, Role::Reading(n), None, unit, description)
    });
    numbers.chain([variable(
        1,
        "impact_count",
        Role::Impacts,
        None,
        "",
        "Number of impacts of the hammer on the string since the start",
    )])
}

/// Returns all variables of an instrument's unit, in the order of the description.
#[must_use]
pub fn variables(file: &InstrumentFile, text: &str) -> Vec<Variable> {
    let mut all = Vec::from(driver());
    all.extend(settings(file.instrument.usual_step_s()));
    all.extend(readings());
    for (n, zone) in file.instrument.zones.iter().enumerate() {
        let name = format!("contact.{}", zone.name);
        all.push(variable(CONTACTS_FROM + n as u32, &name, Role::Contact(n), None, "N", &zone.label));
    }
    parameters(file, text, &mut all);
    all
}

/// Returns all variables of a keyboard's unit, in the order of the description. Parameters are those of the base
/// instrument, around which the keys are graded.
#[must_use]
pub fn keyboard_variables(base: &InstrumentFile, base_text: &str) -> Vec<Variable> {
    let mut all = Vec::from(settings(base.instrument.usual_step_s()));
    let sum = "Force of the strings of all keys on the bridge, with what resting dampers press; 0 where none sound";
    all.push(variable(READING_FROM, "bridge_force", Role::BridgeSum, None, "N", sum));
    all.push(variable(2, "awake", Role::Awake, None, "", "How many keys are awake: the others take no step"));
    for key in 1..=KEYS {
        let is_kept = |own: &Variable| !KEYBOARD_WITHOUT.contains(&own.name.as_str());
        all.extend(driver().into_iter().chain(readings().filter(is_kept)).map(|own| of_key(key, own)));
    }
    parameters(base, base_text, &mut all);
    all
}

/// Adds bodies' masses, and every number of the file.
fn parameters(file: &InstrumentFile, text: &str, all: &mut Vec<Variable>) {
    for erard::parameter::Entry { name, parameter, value, .. } in erard::parameter::register(file) {
        if let Parameter::Mass(body) = parameter {
            let start = Some(value);
            let description = "Mass of the body: its inertia changes in proportion. Set this or the file's numbers";
            all.push(variable(MASSES_FROM + body as u32, &name, Role::Mass(body), start, "kg", description));
        }
    }
    let mut reference = NUMBERS_FROM;
    let numbers = &file.provenance.numbers;
    let by_path = numbers_at_each(text, numbers.iter().map(|number| number.key.as_str()));
    for (n, (number, found)) in numbers.iter().zip(by_path).enumerate() {
        // Outlines do not affect the motion.
        let is_changed_by_path = !number.key.starts_with("part.") && found.is_some();
        if !is_changed_by_path {
            continue;
        }
        for (place, value) in number.values.iter().enumerate() {
            let name =
                if number.values.len() == 1 { number.key.clone() } else { format!("{}[{}]", number.key, place + 1) };
            let note = number.citation.as_ref().and_then(|citation| citation.note.as_deref()).unwrap_or_default();
            all.push(variable(
                reference,
                &name,
                Role::Number(n, place),
                Some(*value),
                description::unit_of(&number.key),
                note,
            ));
            reference += 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use erard::Instrument;
    use erard::instrument::numbers_at;
    use erard::keyboard::Keyboard;
    use std::collections::BTreeSet;

    fn told_apart(unit: &Unit) -> &[Variable] {
        let all = &unit.variables;
        let names: BTreeSet<&str> = all.iter().map(|variable| variable.name.as_str()).collect();
        assert_eq!(names.len(), all.len());
        let references: BTreeSet<(bool, u32)> = all.iter().map(|v| (v.is_integer(), v.reference)).collect();
        assert_eq!(references.len(), all.len());
        let description = unit.model_description();
        assert!(description.contains(&unit.guid()) && description.matches("<ScalarVariable ").count() == all.len());
        all
    }

    /// References and names are unique; every number of a mass, a screw or a felt is present with its value.
    #[test]
    fn variables_are_told_apart() {
        for name in Instrument::builtin_names() {
            let text = Instrument::builtin_text(name).unwrap();
            let unit = Unit::of_instrument(text).unwrap();
            let all = told_apart(&unit);
            for (number, unit) in
                [("body.hammer.mass_g", "g"), ("screw.let_off.setting_mm", "mm"), ("zone.string.felt.exponent", "")]
            {
                let found = all.iter().find(|variable| variable.name == number).expect(number);
                assert_eq!(found.start, numbers_at(text, number).map(|values| values[0]), "{number}");
                assert_eq!(found.unit, unit);
            }
        }
        let [a, b] =
            ["concert-grand", "heavy-touch"].map(|name| Unit::of_instrument(Instrument::builtin_text(name).unwrap()));
        assert_ne!(a.unwrap().guid(), b.unwrap().guid());
    }

    /// Every key has its inputs and its reading, and the base instrument's numbers are parameters of all keys.
    #[test]
    fn a_keyboard_has_variables_per_key() {
        for name in Keyboard::builtin_names() {
            let keyboard = Keyboard::builtin(name).unwrap();
            let unit = Unit::of_keyboard(Keyboard::builtin_text(name).unwrap(), keyboard.base_text()).unwrap();
            let all = told_apart(&unit);
            let one = Unit::of_instrument(keyboard.base_text()).unwrap();
            for key in [1, 40, KEYS] {
                let of_it: Vec<&Variable> = all.iter().filter(|variable| variable.key == Some(key)).collect();
                assert_eq!(of_it.iter().filter(|variable| variable.is_input()).count(), 4);
                assert!(of_it.iter().all(|variable| !variable.is_parameter()) && of_it.len() <= 13, "{}", of_it.len());
                for variable in of_it {
                    let own = variable.name.strip_prefix(&format!("key[{key}].")).unwrap();
                    let alone = one.variables.iter().find(|alone| alone.name == own).unwrap();
                    assert_eq!((variable.role, variable.unit, variable.start), (alone.role, alone.unit, alone.start));
                }
            }
            let numbers = |all: &[Variable]| all.iter().filter(|v| matches!(v.role, Role::Number(..))).count();
            assert_eq!(numbers(all), numbers(&one.variables));
            assert!(unit.model_description().contains("variableNamingConvention=\"structured\""));
        }
    }
}

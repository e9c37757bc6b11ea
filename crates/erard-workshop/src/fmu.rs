//! An instrument as a functional mock-up unit (FMI 2.0, co-simulation): its variables, and the description that
//! goes into the archive.
//!
//! The library inside the unit (`erard-c`) and the command that writes it must number the variables alike: both ask
//! here.

use std::fmt::Write;

use erard::instrument::{Instrument, InstrumentFile, numbers_at_each};
use erard::saved::{FNV1A, fnv1a};

use crate::study::Parameter;

/// Name of the library inside the archive, and of the model.
pub const MODEL: &str = "erard";
/// Path of the instrument file inside the archive.
pub const INSTRUMENT: &str = "resources/instrument.toml";

/// Meaning of a variable.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Force on the key front, N, down positive.
    Force,
    /// Position of the driver's end of the fingertip, m below the key's rest.
    Position,
    /// Its velocity, m/s.
    Velocity,
    /// Lift to which the sustain pedal sends its rail, m.
    Pedal,
    /// Mass of the hand, kg; its muscle's stiffness, N/m, and damping, N s/m.
    HandMass,
    /// See [`Role::HandMass`].
    MuscleStiffness,
    /// See [`Role::HandMass`].
    MuscleDamping,
    /// Selects the drive, see the description of [`Variable`]; an integer.
    Drive,
    /// Length of a step, s.
    Step,
    /// A number of the reading, by its place in `READING`.
    Reading(usize),
    /// Number of impacts since the start; an integer.
    Impacts,
    /// Normal force of a contact zone, N.
    Contact(usize),
    /// Mass of a body, kg, by its place among the bodies: its inertia changes in proportion.
    Mass(usize),
    /// A number of the instrument's file: which of its numbers, and which place of that.
    Number(usize, usize),
}

/// The reading's numbers: name, unit, what it is.
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

/// A variable of the unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Variable {
    /// Its value reference, which no other variable of its type has.
    pub reference: u32,
    /// Its name. Numbers of the file are called by their dotted path; a coordinate's two places end in `[1]` and `[2]`.
    pub name: String,
    /// Meaning.
    pub role: Role,
    /// Its value at first; `None` for what is calculated.
    pub start: Option<f64>,
    /// Its unit; empty where the last part of its name says none.
    pub unit: &'static str,
    /// A line for people.
    pub description: String,
}

impl Variable {
    /// Whether it is a whole number.
    #[must_use]
    pub fn is_integer(&self) -> bool {
        matches!(self.role, Role::Drive | Role::Impacts)
    }

    /// Whether it may be set before initialisation only.
    #[must_use]
    pub fn is_parameter(&self) -> bool {
        matches!(
            self.role,
            Role::Drive
                | Role::Step
                | Role::HandMass
                | Role::MuscleStiffness
                | Role::MuscleDamping
                | Role::Mass(_)
                | Role::Number(..)
        )
    }

    /// Whether it is set at any time.
    #[must_use]
    pub(crate) fn is_input(&self) -> bool {
        matches!(self.role, Role::Force | Role::Position | Role::Velocity | Role::Pedal)
    }
}

/// First references of the reading, of contacts, of bodies' masses and of the file's numbers.
const READING_FROM: u32 = 100;
const CONTACTS_FROM: u32 = 1000;
const MASSES_FROM: u32 = 5000;
const NUMBERS_FROM: u32 = 10_000;

/// All variables of an instrument, in the order of the description.
#[must_use]
pub fn variables(file: &InstrumentFile, text: &str) -> Vec<Variable> {
    let variable = |reference, name: &str, role, start, unit, description: &str| Variable {
        reference,
        name: name.to_owned(),
        role,
        start,
        unit,
        description: description.to_owned(),
    };
    let mut all = vec![
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
        variable(
            3,
            "step_s",
            Role::Step,
            Some(file.instrument.usual_step_s()),
            "s",
            "Length of a step of the simulation: at first that of a press, 50e-6, or 1/24000 where strings sound",
        ),
        variable(4, "pedal", Role::Pedal, Some(0.0), "m", "Lift of the sustain pedal's rail, 0 to 0.010"),
        variable(5, "hand_mass", Role::HandMass, Some(0.2), "kg", "Mass of the hand at its fingertip (drive = 4)"),
        variable(6, "muscle_stiffness", Role::MuscleStiffness, Some(0.0), "N/m", "Stiffness of its muscle (drive = 4)"),
        variable(7, "muscle_damping", Role::MuscleDamping, Some(0.0), "N.s/m", "Damping of its muscle (drive = 4)"),
    ];
    for (n, (name, unit, description)) in READING.iter().enumerate() {
        all.push(variable(READING_FROM + n as u32, name, Role::Reading(n), None, unit, description));
    }
    all.push(variable(
        1,
        "impact_count",
        Role::Impacts,
        None,
        "",
        "Number of impacts of the hammer on the string since the start",
    ));
    for (n, zone) in file.instrument.zones.iter().enumerate() {
        let name = format!("contact.{}", zone.name);
        all.push(variable(CONTACTS_FROM + n as u32, &name, Role::Contact(n), None, "N", &zone.label));
    }
    for (name, parameter) in Parameter::all(&file.instrument) {
        if let Parameter::Mass(body) = parameter {
            let start = Some(parameter.value(&file.instrument));
            let description = "Mass of the body: its inertia changes in proportion. Set this or the file's numbers";
            all.push(variable(MASSES_FROM + body as u32, &name, Role::Mass(body), start, "kg", description));
        }
    }
    let mut reference = NUMBERS_FROM;
    let numbers = &file.provenance.numbers;
    let by_path = numbers_at_each(text, numbers.iter().map(|number| number.key.as_str()));
    for (n, (number, found)) in numbers.iter().zip(by_path).enumerate() {
        // Outlines move nothing.
        let is_changed_by_path = !number.key.starts_with("part.") && found.is_some();
        if !is_changed_by_path {
            continue;
        }
        for (place, value) in number.values.iter().enumerate() {
            let name =
                if number.values.len() == 1 { number.key.clone() } else { format!("{}[{}]", number.key, place + 1) };
            let note = number.citation.as_ref().and_then(|citation| citation.note.as_deref()).unwrap_or_default();
            all.push(variable(reference, &name, Role::Number(n, place), Some(*value), unit_of(&number.key), note));
            reference += 1;
        }
    }
    all
}

/// Units as the ends of keys spell them, and how they are made of SI's: exponents of kg, m, s, rad, and a factor.
const UNITS: [(&str, &str, [i32; 4], f64); 24] = [
    ("", "m", [0, 1, 0, 0], 1.0),
    ("", "m/s", [0, 1, -1, 0], 1.0),
    ("", "s", [0, 0, 1, 0], 1.0),
    ("_mm", "mm", [0, 1, 0, 0], 1e-3),
    ("_deg", "deg", [0, 0, 0, 1], std::f64::consts::PI / 180.0),
    ("_rad", "rad", [0, 0, 0, 1], 1.0),
    ("_g", "g", [1, 0, 0, 0], 1e-3),
    ("_kg_m2", "kg.m2", [1, 2, 0, 0], 1.0),
    ("_g_mm2", "g.mm2", [1, 2, 0, 0], 1e-9),
    ("_N_m", "N.m", [1, 2, -2, 0], 1.0),
    ("_N_mm", "N.mm", [1, 2, -2, 0], 1e-3),
    ("_N_m_s_per_rad", "N.m.s/rad", [1, 2, -1, -1], 1.0),
    ("_N_m_per_rad", "N.m/rad", [1, 2, -2, -1], 1.0),
    ("_N_per_m", "N/m", [1, 0, -2, 0], 1.0),
    ("_N_s_per_m", "N.s/m", [1, 0, -1, 0], 1.0),
    ("_N_s_per_m3", "N.s/m3", [1, -2, -1, 0], 1.0),
    ("_m_s2", "m/s2", [0, 1, -2, 0], 1.0),
    ("_s_per_m", "s/m", [0, -1, 1, 0], 1.0),
    ("_N", "N", [1, 1, -2, 0], 1.0),
    ("_s", "s", [0, 0, 1, 0], 1.0),
    ("_ms", "ms", [0, 0, 1, 0], 1e-3),
    ("_m", "m", [0, 1, 0, 0], 1.0),
    ("_m_per_s", "m/s", [0, 1, -1, 0], 1.0),
    ("_kg", "kg", [1, 0, 0, 0], 1.0),
];

/// The unit that a key's name ends in; empty where it is none of the list.
fn unit_of(key: &str) -> &'static str {
    let fits = UNITS.iter().filter(|(end, ..)| !end.is_empty() && key.ends_with(end));
    fits.max_by_key(|(end, ..)| end.len()).map_or("", |(_, unit, ..)| unit)
}

/// A name for this instrument and this version of the numbering, as FMI writes it.
#[must_use]
pub fn guid(text: &str) -> String {
    let version = concat!("erard-fmu/3 ", env!("CARGO_PKG_VERSION"));
    let [a, b] = [FNV1A, 0x9e37_79b9_7f4a_7c15].map(|seed| fnv1a(seed, version.bytes().chain(text.bytes())));
    let hex = format!("{a:016x}{b:016x}");
    format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

/// `modelDescription.xml`.
#[must_use]
pub fn model_description(file: &InstrumentFile, text: &str) -> String {
    let variables = variables(file, text);
    let Instrument { name, .. } = &file.instrument;
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"2.0\" modelName=\"{}\" guid=\"{}\" description=\"{}\" generationTool=\"erard {}\" \
         variableNamingConvention=\"flat\" numberOfEventIndicators=\"0\">\n\
         <CoSimulation modelIdentifier=\"{MODEL}\" canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUstate=\"true\" \
         canSerializeFMUstate=\"true\" canBeInstantiatedOnlyOncePerProcess=\"false\" canNotUseMemoryManagementFunctions=\"true\"/>\n",
        escaped(name),
        guid(text),
        escaped(file.description.lines().next().unwrap_or_default()),
        env!("CARGO_PKG_VERSION"),
    );
    out.push_str("<UnitDefinitions>");
    for (n, (_, unit, exponents, factor)) in UNITS.iter().enumerate() {
        let is_new = UNITS[..n].iter().all(|(_, other, ..)| other != unit);
        if is_new && variables.iter().any(|variable| variable.unit == *unit) {
            let _ = write!(out, "<Unit name=\"{unit}\"><BaseUnit");
            for (base, exponent) in
                ["kg", "m", "s", "rad"].iter().zip(exponents).filter(|(_, exponent)| **exponent != 0)
            {
                let _ = write!(out, " {base}=\"{exponent}\"");
            }
            if *factor != 1.0 {
                let _ = write!(out, " factor=\"{factor}\"");
            }
            out.push_str("/></Unit>");
        }
    }
    out.push_str("</UnitDefinitions>\n<LogCategories><Category name=\"logStatusError\"/></LogCategories>\n");
    out.push_str("<DefaultExperiment startTime=\"0\" stopTime=\"0.3\" stepSize=\"0.001\"/>\n<ModelVariables>\n");
    let mut outputs = Vec::new();
    for (n, variable) in variables.iter().enumerate() {
        let Variable { reference, name, start, unit, description, .. } = variable;
        let causality = if variable.is_input() {
            "causality=\"input\" variability=\"continuous\""
        } else if variable.is_parameter() {
            "causality=\"parameter\" variability=\"fixed\" initial=\"exact\""
        } else if variable.is_integer() || matches!(name.as_str(), "impact_time" | "hammer_speed") {
            "causality=\"output\" variability=\"discrete\" initial=\"calculated\""
        } else {
            "causality=\"output\" variability=\"continuous\" initial=\"calculated\""
        };
        if start.is_none() {
            outputs.push(n + 1);
        }
        let _ = write!(out, "<ScalarVariable name=\"{}\" valueReference=\"{reference}\" {causality}", escaped(name));
        if !description.is_empty() {
            let _ = write!(out, " description=\"{}\"", escaped(description));
        }
        out.push_str(if variable.is_integer() { "><Integer" } else { "><Real" });
        if !unit.is_empty() {
            let _ = write!(out, " unit=\"{unit}\"");
        }
        if let Some(start) = start {
            let _ = write!(out, " start=\"{start}\"");
        }
        out.push_str("/></ScalarVariable>\n");
    }
    out.push_str("</ModelVariables>\n<ModelStructure>");
    for list in ["Outputs", "InitialUnknowns"] {
        let _ = write!(out, "<{list}>");
        for index in &outputs {
            let _ = write!(out, "<Unknown index=\"{index}\"/>");
        }
        let _ = write!(out, "</{list}>");
    }
    out.push_str("</ModelStructure>\n</fmiModelDescription>\n");
    out
}

fn escaped(text: &str) -> String {
    let mut out = String::new();
    for character in text.chars() {
        match character {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // What XML cannot hold, and line ends, which an attribute does not keep.
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use erard::instrument::numbers_at;
    use std::collections::BTreeSet;

    /// References and names are distinguished; every number of a mass, a screw or a felt is there with its value.
    #[test]
    fn variables_are_told_apart() {
        for name in Instrument::builtin_names() {
            let text = Instrument::builtin_text(name).unwrap();
            let file = InstrumentFile::parse(text, name).unwrap();
            let all = variables(&file, text);
            let names: BTreeSet<&str> = all.iter().map(|variable| variable.name.as_str()).collect();
            assert_eq!(names.len(), all.len());
            let references: BTreeSet<(bool, u32)> = all.iter().map(|v| (v.is_integer(), v.reference)).collect();
            assert_eq!(references.len(), all.len());
            for (number, unit) in
                [("body.hammer.mass_g", "g"), ("screw.let_off.setting_mm", "mm"), ("zone.string.felt.exponent", "")]
            {
                let found = all.iter().find(|variable| variable.name == number).expect(number);
                assert_eq!(found.start, numbers_at(text, number).map(|values| values[0]), "{number}");
                assert_eq!(found.unit, unit);
            }
            let description = model_description(&file, text);
            assert!(description.contains(&guid(text)) && description.matches("<ScalarVariable ").count() == all.len());
        }
        assert_ne!(guid("a"), guid("b"));
    }
}

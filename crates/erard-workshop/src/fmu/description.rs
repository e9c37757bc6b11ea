//! `modelDescription.xml`.

use std::fmt::Write;

use super::{MODEL, Unit, Variable};

/// Units by the ends of keys, and their composition from SI units: exponents of kg, m, s, rad, and a factor.
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

/// Unit at the end of a key's name; empty if unknown.
pub(super) fn unit_of(key: &str) -> &'static str {
    let fits = UNITS.iter().filter(|(end, ..)| !end.is_empty() && key.ends_with(end));
    fits.max_by_key(|(end, ..)| end.len()).map_or("", |(_, unit, ..)| unit)
}

/// Whether a name follows FMI's structured naming convention: `key[40].force`, not `contact.back-check`.
fn is_structured(name: &str) -> bool {
    name.split('.').all(|part| {
        let (word, index) = part.split_once('[').map_or((part, None), |(word, index)| (word, Some(index)));
        let is_index = index.is_none_or(|index| {
            let number = index.strip_suffix(']').unwrap_or_default();
            !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit())
        });
        let is_word = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
        is_index && word.bytes().all(is_word) && word.bytes().next().is_some_and(|first| !first.is_ascii_digit())
    })
}

impl Unit {
    /// Returns the text of `modelDescription.xml`.
    #[must_use]
    pub fn model_description(&self) -> String {
        description(self)
    }
}

fn description(unit: &Unit) -> String {
    let Unit { name, description, variables, .. } = unit;
    // Tools display structured names as a tree.
    let is_structured = unit.is_keyboard() && variables.iter().all(|variable| is_structured(&variable.name));
    let convention = if is_structured { "structured" } else { "flat" };
    let mut out = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <fmiModelDescription fmiVersion=\"2.0\" modelName=\"{}\" guid=\"{}\" description=\"{}\" generationTool=\"erard {}\" \
         variableNamingConvention=\"{convention}\" numberOfEventIndicators=\"0\">\n\
         <CoSimulation modelIdentifier=\"{MODEL}\" canHandleVariableCommunicationStepSize=\"true\" canGetAndSetFMUstate=\"true\" \
         canSerializeFMUstate=\"true\" canBeInstantiatedOnlyOncePerProcess=\"false\" canNotUseMemoryManagementFunctions=\"true\"/>\n",
        escaped(name),
        unit.guid(),
        escaped(description.lines().next().unwrap_or_default()),
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
        let causality = if variable.is_input() && variable.is_discrete() {
            "causality=\"input\" variability=\"discrete\""
        } else if variable.is_input() {
            "causality=\"input\" variability=\"continuous\""
        } else if variable.is_parameter() {
            "causality=\"parameter\" variability=\"fixed\" initial=\"exact\""
        } else if variable.is_discrete() {
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
            // Characters not allowed in XML, and line ends, which attributes do not keep.
            c if c.is_control() => out.push(' '),
            c => out.push(c),
        }
    }
    out
}

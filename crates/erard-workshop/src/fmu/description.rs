//! `modelDescription.xml`.

use std::fmt::Write;

use erard::parameter::Quantity;

use super::{MODEL, Unit, Variable};

/// Unit at the end of a key's name; empty if unknown, or if no SI units make it up.
pub(super) fn unit_of(key: &str) -> &'static str {
    let is_made_up = |quantity: Quantity| quantity.dimension().is_some_and(|exponents| exponents != [0; 4]);
    Quantity::of_name(key).filter(|(quantity, _)| is_made_up(*quantity)).map_or("", |(_, unit)| unit.symbol)
}

/// A unit's name in FMI: `kg.m2`.
fn unit_name(unit: &str) -> String {
    unit.replace(' ', ".")
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
    let known =
        Quantity::ALL.into_iter().flat_map(|quantity| quantity.units().iter().map(move |unit| (quantity, unit)));
    // A weight's units are named like a mass's, and are not used.
    let known = known.filter(|(quantity, _)| *quantity != Quantity::Weight);
    for (quantity, own) in known {
        let (name, Some(exponents)) = (unit_name(own.symbol), quantity.dimension()) else { continue };
        if variables.iter().any(|variable| variable.unit == own.symbol) {
            let _ = write!(out, "<Unit name=\"{name}\"><BaseUnit");
            for (base, exponent) in ["kg", "m", "s", "rad"].iter().zip(exponents).filter(|(_, exponent)| *exponent != 0)
            {
                let _ = write!(out, " {base}=\"{exponent}\"");
            }
            if own.si != 1.0 {
                let _ = write!(out, " factor=\"{}\"", own.si);
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
            let _ = write!(out, " unit=\"{}\"", unit_name(unit));
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

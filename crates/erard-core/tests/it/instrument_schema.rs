//! The shipped JSON Schema is the one that the code generates, accepts what ships, and refuses what the reader refuses.

use erard::instrument::{Instrument, json_schema};
use serde_json::{Value, json};

const CLOCK: &str = include_str!("../instruments/escapement.toml");

#[test]
fn the_shipped_schema_is_the_generated_one() {
    crate::common::generated::is_current(
        "crates/erard-core/instruments/instrument.schema.json",
        json_schema(),
        "instrument-schema",
    );
}

#[test]
fn shipped_instruments_name_the_schema_in_their_first_line() {
    for name in Instrument::builtin_names() {
        let text = Instrument::builtin_text(name).expect("a text");
        assert_eq!(text.lines().next(), Some("#:schema ./instrument.schema.json"), "{name}");
    }
}

#[test]
fn what_reads_conforms() {
    for name in Instrument::builtin_names() {
        assert_eq!(faults(Instrument::builtin_text(name).expect("a text")), Vec::<String>::new(), "{name}");
    }
    assert_eq!(faults(CLOCK), Vec::<String>::new());
    // Numbers in quotes, with their units.
    let typed = CLOCK.replacen("mass_g = 250", "mass_g = \"0.25 kg\"", 1).replacen("[60, 0]", "[\"2 1/2in\", 0]", 1);
    assert_ne!(typed, CLOCK);
    assert!(Instrument::parse(&typed, "").is_ok());
    assert_eq!(faults(&typed), Vec::<String>::new());
}

/// Not all that the reader refuses (a schema cannot compare an inertia with a mass), but all that has to do with keys,
/// kinds, and ranges of single numbers.
#[test]
fn what_is_broken_does_not_conform() {
    for (good, bad) in [
        ("mass_g = 250", "mass = 250"),
        ("mass_g = 250", "mass_g = -250"),
        ("mass_g = 250", "mass_g = 0"),
        ("mass_g = 250", "mass_g = \"250\""),
        ("mass_g = 250\n", ""),
        ("mass_g = 250", "mass_g = { value = 250 }"),
        ("mass_g = 250", "mass_g = { value = 250, source = \"s\", certainty = \"sure\" }"),
        ("mass_g = 250", "mass_g = { value = -250, source = \"s\", certainty = \"read\" }"),
        ("pivot_mm = [60, 0]", "pivot_mm = [60, 0, 0]"),
        ("pivot_mm = [60, 0]", "pivot_mm = [60]"),
        ("pivot_mm = [60, 0]", "pivot_mm = [60, \"0\"]"),
        ("exponent = 2\n", "exponent = 0.5\n"),
        ("damping_N_s_per_m3 = 1e6", "damping_N_s_per_m3 = -1"),
        ("name = \"lever\"", "name = \"The lever\""),
        ("format = \"erard-instrument/1\"", "format = \"erard-instrument/9\""),
        ("[zone.line]\nbody = \"ground\"\npoint_mm = [0, -2]\nnormal = [0, 2]\n", ""),
        ("[zone.line]", "[zone.other_disc]\nbody = \"ground\"\ncenter_mm = [0, 0]\n[zone.line]"),
        ("[[spring]]", "[spring]"),
    ] {
        assert!(CLOCK.contains(good), "{good}");
        let text = CLOCK.replacen(good, bad, 1);
        assert!(Instrument::parse(&text, "").is_err(), "{bad:?} reads");
        assert!(!faults(&text).is_empty(), "{bad:?} conforms");
    }
}

/// The faults of a TOML text by the schema.
fn faults(text: &str) -> Vec<String> {
    let schema: Value = serde_json::from_str(&json_schema()).expect("JSON");
    let table: toml::Table = toml::from_str(text).expect("TOML");
    let instance = serde_json::to_value(table).expect("JSON");
    let mut faults = Vec::new();
    validate(&instance, &schema, &schema, "", &mut faults);
    faults
}

/// Draft 7 as far as our schema uses it; a keyword that is not known here fails the test rather than being skipped.
fn validate(instance: &Value, schema: &Value, root: &Value, path: &str, faults: &mut Vec<String>) {
    let mut fault = |what: String| faults.push(format!("{path}: {what}"));
    let conforms = |instance: &Value, schema: &Value| {
        let mut inner = Vec::new();
        validate(instance, schema, root, path, &mut inner);
        inner.is_empty()
    };
    let number = instance.as_f64();
    let no_properties = serde_json::Map::new();
    let object = instance.as_object().unwrap_or(&no_properties);
    let properties = schema.get("properties").and_then(Value::as_object).unwrap_or(&no_properties);
    let length = instance.as_array().map(|array| array.len() as u64);
    let Some(schema) = schema.as_object() else {
        return;
    };

    for (keyword, rule) in schema {
        match keyword.as_str() {
            "$schema" | "title" | "description" | "definitions" | "default" | "format" => {}
            "$ref" => {
                let name =
                    rule.as_str().and_then(|rule| rule.strip_prefix("#/definitions/")).expect("a local reference");
                if !conforms(instance, &root["definitions"][name]) {
                    fault(format!("is not a {name}"));
                }
            }
            "type" => {
                let fits = |rule: &Value| match rule.as_str().expect("a type") {
                    "object" => instance.is_object(),
                    "array" => instance.is_array(),
                    "string" => instance.is_string(),
                    "number" => instance.is_number(),
                    "integer" => instance.is_i64() || instance.is_u64(),
                    "boolean" => instance.is_boolean(),
                    other => panic!("type {other}"),
                };
                if !rule.as_array().map_or_else(|| fits(rule), |rules| rules.iter().any(fits)) {
                    fault(format!("is not of type {rule}"));
                }
            }
            "const" if instance != rule => fault(format!("is not {rule}")),
            "enum" if !rule.as_array().is_some_and(|words| words.contains(instance)) => fault(format!("not in {rule}")),
            // A number in quotes has a unit: a letter other than that of an exponent, or a sign.
            "pattern" if rule.as_str().is_some_and(|rule| rule.starts_with("[A-DF-Z")) => {
                let is_of_a_unit = |c: char| (c.is_alphabetic() && !matches!(c, 'e' | 'E')) || "\u{b0}%\"'".contains(c);
                if instance.as_str().is_some_and(|text| !text.contains(is_of_a_unit)) {
                    fault("is a number in quotes without a unit".to_owned());
                }
            }
            "pattern" => {
                assert_eq!(rule, &json!("^[a-z][a-z0-9_]{0,39}$"), "the only pattern that this validator knows");
                let name = instance.as_str().unwrap_or_default();
                let well_formed = name.starts_with(|c: char| c.is_ascii_lowercase())
                    && name.len() <= 40
                    && name.bytes().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == b'_');
                if !well_formed {
                    fault("is no name".to_owned());
                }
            }
            "minimum" if number.is_some() && number < rule.as_f64() => fault(format!("is less than {rule}")),
            "maximum" if number.is_some() && number > rule.as_f64() => fault(format!("is more than {rule}")),
            "exclusiveMinimum" if number.is_some() && number <= rule.as_f64() => {
                fault(format!("is not more than {rule}"))
            }
            "exclusiveMaximum" if number.is_some() && number >= rule.as_f64() => {
                fault(format!("is not less than {rule}"))
            }
            "minItems" if length < rule.as_u64() => fault(format!("has fewer than {rule}")),
            "maxItems" if length > rule.as_u64() => fault(format!("has more than {rule}")),
            "const" | "enum" | "minimum" | "maximum" | "exclusiveMinimum" | "exclusiveMaximum" | "minItems"
            | "maxItems" => {}
            "required" => {
                for key in rule.as_array().into_iter().flatten().filter_map(Value::as_str) {
                    if !object.contains_key(key) {
                        fault(format!("lacks {key}"));
                    }
                }
            }
            "properties" => {
                for (key, rule) in properties {
                    if object.get(key).is_some_and(|value| !conforms(value, rule)) {
                        fault(format!("{key} does not conform"));
                    }
                }
            }
            "additionalProperties" => {
                for (key, value) in object.iter().filter(|(key, _)| !properties.contains_key(*key)) {
                    if rule == &json!(false) || !conforms(value, rule) {
                        fault(format!("has {key}"));
                    }
                }
            }
            "items" => {
                for (index, value) in instance.as_array().into_iter().flatten().enumerate() {
                    if !conforms(value, rule) {
                        fault(format!("[{index}] does not conform"));
                    }
                }
            }
            "allOf" | "anyOf" | "oneOf" => {
                let choices = rule.as_array().expect("a list");
                let fitting = choices.iter().filter(|choice| conforms(instance, choice)).count();
                let fits = match keyword.as_str() {
                    "allOf" => fitting == choices.len(),
                    "anyOf" => fitting > 0,
                    _ => fitting == 1,
                };
                if !fits {
                    fault(format!("fits {fitting} of {keyword}"));
                }
            }
            other => panic!("this validator does not know the keyword {other}"),
        }
    }
}

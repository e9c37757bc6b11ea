//! Readings of one key from a form or a program, as JSON; all errors are returned at once.

use erard::keyboard::key_named;
use serde_json::{Map, Value};

use super::entry::{Entry, Impossible, Known, readings};
use crate::balance::Lead;
use crate::measure::norms::MIDDLE_C;

/// Readings of one key.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Typed {
    /// Key, 1 to 88; `None` if not given.
    pub key: Option<usize>,
    /// Readings.
    pub known: Known,
}

impl Typed {
    /// Reads `{"key": "C4", "leads": "14@165, 14@147", "down_weight_g": 58, "let-off": "3,5 mm"}`: entries by any of
    /// their names, as numbers or as typed text. Null and empty mean not measured.
    ///
    /// # Errors
    /// All errors, each with the name of its entry, `key` or `leads`; without a name if it belongs to none.
    pub fn read(json: &str) -> Result<Self, Vec<Impossible>> {
        let wrong = |entry, what, expected: &str| Impossible { entry, what, expected: expected.to_owned() };
        let object: Map<String, Value> = serde_json::from_str(json).map_err(|error| {
            let what = format!("the readings are not a JSON object: {error}");
            vec![wrong("", what, "an object such as {\"key\": \"C4\", \"down_weight_g\": 58}")]
        })?;
        let (mut typed, mut faults, mut entered) = (Typed::default(), Vec::new(), Vec::<&Entry>::new());
        for (name, value) in object {
            let text = match value {
                Value::Null => continue,
                Value::String(text) => text,
                other => other.to_string(),
            };
            let text = text.trim();
            if text.is_empty() {
                continue;
            }
            if name == "key" {
                typed.key = key_named(text);
                if typed.key.is_none() {
                    faults.push(wrong("key", format!("`{text}` is not a key"), "1 to 88, or a note from A0 to C8"));
                }
            } else if name == "leads" {
                match leads(text) {
                    Ok(leads) => typed.known.leads = leads,
                    Err(found) => faults.push(wrong("leads", format!("`{found}`"), Lead::EXPECTED)),
                }
            } else if let Some(entry) = readings().find(|entry| entry.is_called(&name)) {
                if entered.contains(&entry) {
                    faults.push(wrong(entry.name, format!("`{name}` is another name for it"), "each reading once"));
                } else if let Err(expected) = typed.known.enter(entry, text) {
                    faults.push(wrong(entry.name, format!("`{text}`"), &expected));
                }
                entered.push(entry);
            } else {
                let known = readings().map(|entry| entry.name).collect::<Vec<_>>().join(", ");
                faults.push(wrong("", format!("unknown reading `{name}`"), &format!("key, leads, {known}")));
            }
        }
        let weights = ["down_weight_g", "up_weight_g", "balance_weight_g", "friction_weight_g", "measured_at_mm"];
        if !faults.iter().any(|fault| weights.contains(&fault.entry)) {
            faults.extend(typed.known.settle(typed.key.unwrap_or(MIDDLE_C)).err());
        }
        faults.extend(typed.known.faults());
        if faults.is_empty() && typed.known.is_empty() {
            faults.push(wrong(
                "",
                "no reading was given".to_owned(),
                "one at least, such as down-weight and up-weight",
            ));
        }
        if faults.is_empty() { Ok(typed) } else { Err(faults) }
    }
}

/// Reads leads separated by commas, semicolons or blanks; else returns the part that is no lead.
fn leads(text: &str) -> Result<Vec<Lead>, String> {
    let each = text.split([',', ';', ' ']).map(str::trim).filter(|one| !one.is_empty());
    each.map(|one| Lead::read(one).ok_or_else(|| one.to_owned())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Any name, numbers or texts with units and decimal commas; empty texts were not measured.
    #[test]
    fn readings_as_people_type_them() {
        let typed = Typed::read(
            r#"{"key": "C4", "D": 58, "up_weight_g": "18 g", "set-off": "3,5mm", "drop_mm": 0, "dip": "", "blow_mm": null,
                "check": "none", "leads": "14@165, 14@147mm"}"#,
        )
        .unwrap();
        let known = &typed.known;
        assert_eq!((typed.key, known.friction_g(), known.get("let_off_mm")), (Some(40), Some(20.0), Some(3.5)));
        assert_eq!((known.get("drop_mm"), known.get("dip_mm"), known.get("blow_mm")), (Some(0.0), None, None));
        assert!(known.is_not_caught && known.leads.len() == 2 && known.leads[1].at_mm == 147.0);
        assert_eq!(Typed::read(r#"{"key": 41, "d": 50}"#).unwrap().key, Some(41));
    }

    /// All errors are returned at once, each under its own name.
    #[test]
    fn all_faults_by_name() {
        let faults = |json: &str| -> Vec<(&str, String)> {
            Typed::read(json).unwrap_err().into_iter().map(|one| (one.entry, one.to_string())).collect()
        };
        let all = faults(
            r#"{"key": "H9", "leads": "14", "down_weight_g": 18, "up_weight_g": 58, "drop": "much", "dip_mm": 8, "aftertouch_mm": 9}"#,
        );
        for (entry, told) in [
            ("key", "`H9` is not a key; expected 1 to 88"),
            ("leads", "`14`; expected grams"),
            ("drop_mm", "`much`; expected a number from 0 to 40 mm"),
            ("up_weight_g", "are they swapped?"),
            ("aftertouch_mm", "less than the dip"),
        ] {
            assert!(all.iter().any(|(name, text)| *name == entry && text.contains(told)), "{entry}: {all:?}");
        }
        assert_eq!(all.len(), 5, "{all:?}");
        for (json, told) in [
            ("", "not a JSON object"),
            ("[1]", "not a JSON object"),
            ("{}", "no reading was given"),
            (r#"{"key": "C4", "leads": "14@165"}"#, "no reading was given"),
            (r#"{"colour": 1}"#, "unknown reading `colour`; expected key, leads, down_weight_g"),
            (r#"{"d": 50, "dw": 50}"#, "each reading once"),
            (r#"{"bw": 38}"#, "a balance weight BW of 38 g alone; expected the friction weight F, a down-weight D"),
            (r#"{"d": 50, "u": 26, "f": 20}"#, "expected 12 g, which follows from these"),
            (r#"{"bw": "38mm", "f": 12}"#, "a number from -25 to 175 g (units: kg, g, oz, lb, N"),
            (r#"{"bw": 38, "f": -1}"#, "a number from 0 to 100 g"),
        ] {
            let found = faults(json);
            assert!(found.len() == 1 && found[0].1.contains(told), "{json}: {found:?}");
        }
    }
}

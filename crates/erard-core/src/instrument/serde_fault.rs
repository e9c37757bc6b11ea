//! Converts errors of serde and of the TOML parser to faults in the words of an instrument file.

use super::error::Fault;
use super::from_toml::TomlError;

/// Converts a message of serde or the TOML parser to a fault. These distinguish mistakes only by their wording, so this
/// function reads the wording and quotes messages that it does not recognise.
pub fn serde_fault(error: &TomlError, text: &str) -> Fault {
    let span = error.span.clone().unwrap_or(0..0);
    let message = error.message.as_str();
    if let Some(expected) = &error.expected {
        return Fault::at(span, message, expected);
    }
    let quoted = |start: &str| message.strip_prefix(start)?.strip_prefix('`')?.split_once('`');
    let wrong_kind =
        |expected: &str| Fault::at(span.clone(), "wrong kind of value", expected.replace("f64", "a number"));

    // The parser passes a date on as a table with one special key.
    if message.contains("$__toml_private") {
        return wrong_kind("a number");
    }
    if let Some((key, rest)) = quoted("unknown field ") {
        let known: Vec<&str> = rest.split('`').skip(1).step_by(2).collect();
        let expected = match nearest(key, &known) {
            Some(near) => format!("`{near}`"),
            None => after_expected(rest),
        };
        let mut fault = Fault::at(span, "unknown key", expected).found(format!("`{key}`"));
        fault.child_key = Some(key.to_owned());
        return fault;
    }
    if let Some((key, _)) = quoted("missing field ") {
        let expected = match key {
            "body" if span.start == 0 => "at least one table [[body]]".to_owned(),
            "disc" | "felt" => format!("a table [zone.{key}]"),
            _ => format!("`{key} = ...`"),
        };
        return Fault::missing(span, key, expected);
    }
    if let Some((word, rest)) = quoted("unknown variant ") {
        return Fault::at(span, "unknown word", after_expected(rest)).found(format!("`{word}`"));
    }
    if let Some((length, expected)) =
        message.strip_prefix("invalid length ").and_then(|rest| rest.split_once(", expected "))
    {
        return wrong_kind(expected).found(format!("{length} of them"));
    }
    for start in ["invalid type: ", "invalid value: "] {
        if let Some((_, expected)) = message.strip_prefix(start).and_then(|rest| rest.split_once(", expected ")) {
            return wrong_kind(expected);
        }
    }
    if let Some(line) = text.get(span.start..).and_then(|rest| rest.lines().next())
        && text[..span.start].trim_end_matches([' ', '\t']).ends_with('=')
        && (line.trim().is_empty() || line.trim_start().starts_with('#'))
    {
        return Fault::at(span, "this key has no value", "a value after `=`");
    }
    Fault::at(span, message.replace('\n', "; "), "")
}

/// Returns the text after `, expected ` in a message of serde: the list of names that it knows.
fn after_expected(rest: &str) -> String {
    rest.trim_start_matches(", ").trim_start_matches("expected ").to_owned()
}

/// Largest number of characters of a key that are compared.
const MAX_KEY_LENGTH: usize = 64;

/// Returns the known key that `key` most likely means: one that adds a unit to it, one with the same first word, or one
/// that differs by two characters (three if the first three agree).
fn nearest<'k>(key: &str, known: &[&'k str]) -> Option<&'k str> {
    // The key is cut: no known key is longer than this, and the cost of a comparison grows with the length.
    let lower = key.chars().take(MAX_KEY_LENGTH).collect::<String>().to_lowercase();
    let stem = |name: &str| name.split('_').next().unwrap_or_default().to_owned();
    known
        .iter()
        .copied()
        .filter_map(|candidate| {
            let name = candidate.to_lowercase();
            let slips = strsim::levenshtein(&lower, &name);
            let unit_missing = name.strip_prefix(&lower).is_some_and(|rest| rest.starts_with('_'));
            let same_stem = stem(&lower) == stem(&name);
            let beginning = lower.bytes().zip(name.bytes()).take_while(|(a, b)| a == b).count();
            (unit_missing || same_stem || slips <= 2 || (slips <= 3 && beginning >= 3)).then_some((
                !unit_missing,
                slips,
                candidate,
            ))
        })
        .min()
        .map(|(_, _, candidate)| candidate)
}

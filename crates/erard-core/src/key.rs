//! The keys of a piano: their numbers, their notes, and the texts that name them.

use thiserror::Error;

/// Keys of a piano. They count from 1, the lowest A.
pub const KEYS: usize = 88;

/// A key as it may be typed, for error messages.
pub const EXPECTED: &str = "a number from 1 to 88, or a note from A0 to C8";

/// A text or a number that names none of the 88 keys.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("found key `{found}`; expected {EXPECTED}")]
pub struct UnknownKey {
    /// Text or number found.
    pub found: String,
}

/// The note of a key, e.g. `C4` for key 40 and `A0` for key 1.
#[must_use]
pub fn note_name(key: usize) -> String {
    const NAMES: [&str; 12] = ["C", "C#", "D", "D#", "E", "F", "F#", "G", "G#", "A", "A#", "B"];
    let from_c0 = key.saturating_add(8);
    format!("{}{}", NAMES[from_c0 % 12], from_c0 / 12)
}

/// The key of a number (`40`) or a note (`C4`, `c#4`, `Db4`, `D♭4`), from 1; `None` where it is none of the 88.
#[must_use]
pub fn key_named(text: &str) -> Option<usize> {
    const FLATS: [(&str, &str); 5] = [("DB", "C#"), ("EB", "D#"), ("GB", "F#"), ("AB", "G#"), ("BB", "A#")];
    let text = text.trim();
    if let Ok(number) = text.parse::<usize>() {
        return (1..=KEYS).contains(&number).then_some(number);
    }
    let upper = text.replace('♯', "#").replace('♭', "b").to_uppercase();
    let flat = FLATS.iter().find_map(|(flat, sharp)| Some((sharp, upper.strip_prefix(flat)?)));
    let name = flat.map_or(upper.clone(), |(sharp, octave)| format!("{sharp}{octave}"));
    (1..=KEYS).find(|key| note_name(*key) == name)
}

/// The keys of a list: numbers and notes with commas, and ranges of them (`1..88`, `A0..C2,40`), in the order of the
/// text.
///
/// # Errors
/// The first part of the list that names no key, or a range that descends.
pub fn keys_named(text: &str) -> Result<Vec<usize>, UnknownKey> {
    let mut all = Vec::new();
    for part in text.split(',') {
        let ends = part.split_once("..").unwrap_or((part, part));
        let range = key_named(ends.0).zip(key_named(ends.1)).filter(|(from, to)| from <= to);
        let (from, to) = range.ok_or_else(|| UnknownKey { found: part.to_owned() })?;
        all.extend(from..=to);
    }
    Ok(all)
}

/// Whether a key is a black one.
#[must_use]
pub fn is_sharp(key: usize) -> bool {
    note_name(key).contains('#')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn notes() {
        let names = [1, 3, 4, 16, 40, 41, 49, 64, 88].map(note_name);
        assert_eq!(names, ["A0", "B0", "C1", "C2", "C4", "C#4", "A4", "C6", "C8"]);
    }

    /// Numbers, notes, flats, either case, printed signs; nothing beyond the 88.
    #[test]
    fn keys_by_number_or_note() {
        for (text, key) in [
            ("40", 40),
            ("C4", 40),
            (" c4", 40),
            ("Db4", 41),
            ("c#4", 41),
            ("C♯4", 41),
            ("d♭4", 41),
            ("Bb0", 2),
            ("B♭0", 2),
            ("c8", 88),
        ] {
            assert_eq!(key_named(text), Some(key), "{text}");
        }
        for text in ["0", "89", "H4", "C9", "", "Fb4", "-3", "4.5", "b", "♯"] {
            assert_eq!(key_named(text), None, "{text}");
        }
    }

    #[test]
    fn lists_of_keys() {
        assert_eq!(keys_named("C4").unwrap(), [40]);
        assert_eq!(keys_named("A0..3, 40,C8").unwrap(), [1, 2, 3, 40, 88]);
        for (text, found) in [("3..1", "3..1"), ("1,89", "89"), ("1,", ""), ("1..88:3", "1..88:3")] {
            assert_eq!(keys_named(text).unwrap_err().found, found, "{text}");
        }
    }
}

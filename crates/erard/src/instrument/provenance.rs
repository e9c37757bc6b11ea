//! Where an instrument's numbers come from.

use std::collections::BTreeMap;

use super::{Instrument, InstrumentFile};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// How sure a number is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Certainty {
    /// Measured on the instrument that the file describes.
    Measured,
    /// Read in a public source, named beside it.
    Read,
    /// Read in somebody's quotation of a source.
    SecondHand,
    /// Estimated; the derivation stands in the note or at the source.
    Estimate,
}

/// A source that numbers can cite.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// What it is called.
    pub title: String,
    /// Who wrote it.
    pub author: Option<String>,
    /// When, e.g. `2001` or `November 2001`.
    pub date: Option<String>,
    /// Where it can be found.
    pub url: Option<String>,
    /// How it was used, or a caution.
    pub note: Option<String>,
}

/// How far a number may be off.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spread {
    /// Plus or minus, in the unit of the file's key.
    PlusMinus(f64),
    /// Times or divided by, at least 1.
    Factor(f64),
}

/// A number's provenance.
#[derive(Debug, Clone, PartialEq)]
pub struct Citation {
    /// Name of a source in [`Provenance::sources`].
    pub source: String,
    /// How sure it is.
    pub certainty: Certainty,
    /// How far it may be off, if that is known.
    pub spread: Option<Spread>,
    /// Derivation or caution.
    pub note: Option<String>,
}

/// One number of the file as it stands there: in the unit that ends the key's name.
#[derive(Debug, Clone, PartialEq)]
pub struct CitedNumber {
    /// Dotted path, e.g. `body.jack.mass_g` or `zone.string.felt.exponent`.
    pub key: String,
    /// Line of the file, from 1.
    pub line: usize,
    /// The number, or the components of the vector (of all corners, for an outline).
    pub values: Vec<f64>,
    /// `None` for a bare number.
    pub citation: Option<Citation>,
}

/// Every number of a file and where it comes from.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Provenance {
    /// The sources by name.
    pub sources: BTreeMap<String, Source>,
    /// The numbers in the order of their reading: top, bodies, springs, zones, roles, finger, screws, parts.
    pub numbers: Vec<CitedNumber>,
}

/// A number that was changed and still carries the note of the built-in instrument that it comes from: the note speaks of the old value.
#[derive(Debug, Clone, PartialEq)]
pub struct OutlivedNote {
    /// The number as it is.
    pub number: CitedNumber,
    /// What it is in the built-in instrument.
    pub was: Vec<f64>,
    /// Name of that instrument, e.g. `concert-grand`.
    pub builtin: &'static str,
}

impl Provenance {
    /// The numbers that differ from a built-in instrument's and have kept its note word for word.
    #[must_use]
    pub fn outlived_notes(&self) -> Vec<OutlivedNote> {
        let note = |number: &CitedNumber| number.citation.as_ref().and_then(|citation| citation.note.clone());
        let builtin = |name: &'static str| Some((name, InstrumentFile::builtin(name)?.provenance.numbers));
        let builtins: Vec<(&'static str, Vec<CitedNumber>)> = Instrument::builtin_names().filter_map(builtin).collect();
        let outlived = |number: &CitedNumber| {
            let text = note(number)?;
            let twins: Vec<(&'static str, &CitedNumber)> = builtins
                .iter()
                .flat_map(|(name, numbers)| numbers.iter().map(move |number| (*name, number)))
                .filter(|(_, twin)| twin.key == number.key && note(twin).as_deref() == Some(&text))
                .collect();
            let (name, twin) = *twins.first()?;
            let is_true = twins.iter().any(|(_, twin)| twin.values == number.values);
            (!is_true).then(|| OutlivedNote { number: number.clone(), was: twin.values.clone(), builtin: name })
        };
        self.numbers.iter().filter_map(outlived).collect()
    }

    /// The numbers that carry no source.
    pub fn bare(&self) -> impl Iterator<Item = &CitedNumber> {
        self.numbers.iter().filter(|number| number.citation.is_none())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A capstan that was moved by hand keeps the note of where it was, and is found; the built-in files have no such notes.
    #[test]
    fn a_note_that_its_number_has_outlived_is_found() {
        for name in Instrument::builtin_names() {
            assert_eq!(InstrumentFile::builtin(name).unwrap().provenance.outlived_notes(), [], "{name}");
        }
        let text = Instrument::builtin_text("concert-grand").unwrap();
        let moved = text.replace("value = [142.23, 18.32]", "value = [132.23, 18.32]");
        let found = InstrumentFile::parse(&moved, "moved").unwrap().provenance.outlived_notes();
        let [one] = &found[..] else { panic!("{found:?}") };
        assert_eq!((one.number.key.as_str(), one.builtin), ("zone.capstan_heel.disc.center_mm", "concert-grand"));
        assert_eq!((&one.number.values[..], &one.was[..]), (&[132.23, 18.32][..], &[142.23, 18.32][..]));
    }
}

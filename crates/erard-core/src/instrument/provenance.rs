//! Where an instrument's numbers come from.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Certainty of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Certainty {
    /// Measured on the instrument that the file describes.
    Measured,
    /// Read in a public source, which is cited with the number.
    Read,
    /// Read in another author's quotation of a source.
    SecondHand,
    /// Estimated; the note or the source gives the derivation.
    Estimate,
}

/// A source that numbers can cite.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Source {
    /// Title.
    pub title: String,
    /// Author.
    pub author: Option<String>,
    /// Date, e.g. `2001` or `November 2001`.
    pub date: Option<String>,
    /// Web address.
    pub url: Option<String>,
    /// How the source is used, or a caution.
    pub note: Option<String>,
}

/// Spread of a number: its likely deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Spread {
    /// Deviation in either direction, in the unit of the file's key.
    PlusMinus(f64),
    /// Deviation as a factor, at least 1, by which the number is multiplied or divided.
    Factor(f64),
}

/// A number's provenance.
#[derive(Debug, Clone, PartialEq)]
pub struct Citation {
    /// Name of a source in [`Provenance::sources`].
    pub source: String,
    /// Certainty.
    pub certainty: Certainty,
    /// Spread, if it is known.
    pub spread: Option<Spread>,
    /// Name of a shared deviation: numbers with the same name here deviate together.
    pub together: Option<String>,
    /// Derivation or caution.
    pub note: Option<String>,
}

/// One number of the file, in the file's own unit: the one at the end of the key's name.
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

/// Every number of a file and its source.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Provenance {
    /// The sources by name.
    pub sources: BTreeMap<String, Source>,
    /// The numbers in the order in which they are read: gravity, bodies, springs, zones, roles, strings, bridge modes,
    /// finger, screws, parts, bushings.
    pub numbers: Vec<CitedNumber>,
}

impl Provenance {
    /// The numbers that carry no source.
    pub fn bare(&self) -> impl Iterator<Item = &CitedNumber> {
        self.numbers.iter().filter(|number| number.citation.is_none())
    }
}

//! The keyboard file as it is written: TOML, units in the keys' names.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::instrument::quantity::{At, Num, Pair, Positive, Real};
use crate::instrument::{Certainty, Source};

/// What the key `format` must say.
pub(crate) const FORMAT: &str = "erard-keyboard/1";

/// A keyboard: one instrument file, and what differs from it from key to key.
///
/// Every quantity over the keyboard is a list of points `{ key = 1, value = ..., source = "...", certainty = "..." }`,
/// joined by straight lines and level beyond the first and the last. Keys count from 1 in the bass.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Erard keyboard file")]
pub(crate) struct KeyboardToml {
    /// Version of the format: `erard-keyboard/1`.
    #[schemars(extend("const" = FORMAT))]
    pub format: At<String>,
    /// Name shown in summaries, e.g. `Concert grand`.
    pub name: At<String>,
    /// Description of the keyboard, for people.
    pub description: Option<String>,
    /// The instrument of one of its keys: a built-in one, or a file beside this one.
    pub instrument: At<String>,
    /// Key number of the base instrument: there every added mass and shift is 0 and every factor 1.
    pub instrument_key: At<i64>,
    /// The sources that points cite, by name.
    #[serde(default)]
    pub sources: BTreeMap<String, Source>,
    /// Masses added to bodies.
    #[serde(default)]
    pub added_mass: Vec<At<AddedMassToml>>,
    /// Numbers of the instrument that are multiplied.
    #[serde(default)]
    pub factor: Vec<At<FactorToml>>,
    /// Points of the instrument that are moved.
    #[serde(default)]
    pub shift: Vec<At<ShiftToml>>,
    /// Tables of the instrument that some keys do not have.
    #[serde(default)]
    pub absent: Vec<At<AbsentToml>>,
}

/// A point mass added to a body (taken away where negative): changes its mass, centre of mass and inertia together.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "AddedMass")]
pub(crate) struct AddedMassToml {
    /// Name of the grading, for people: `hammer head`.
    pub name: At<String>,
    /// The body.
    pub body: At<String>,
    /// Position of the added mass, in the body's own frame, mm.
    pub at_mm: Num<Pair>,
    /// Mass over the keyboard, g.
    pub mass_g: At<Vec<PointToml<Real>>>,
}

/// Numbers of the instrument that are multiplied by a factor; between the points along straight lines of its logarithm.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Factor")]
pub(crate) struct FactorToml {
    /// Name of the graded quantity, for people: `stiffness of the string's felt`.
    pub name: At<String>,
    /// The numbers, each by its dotted path in the instrument file: `zone.string.felt.stiffness_N_per_m_r`.
    pub numbers: Vec<At<String>>,
    /// The factor over the keyboard.
    pub factor: At<Vec<PointToml<Positive>>>,
}

/// Points of the instrument that are moved along a direction.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Shift")]
pub(crate) struct ShiftToml {
    /// Name of the graded quantity, for people: `height of the string`.
    pub name: At<String>,
    /// The points, each by its dotted path in the instrument file: `zone.string.line.point_mm`.
    pub points: Vec<At<String>>,
    /// Direction, of any length but zero, in the frame of the body that carries the point.
    pub direction: Num<Pair>,
    /// Place over the keyboard, mm.
    pub by_mm: At<Vec<PointToml<Real>>>,
}

/// One point of a quantity over the keyboard.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "{T}Point")]
pub(crate) struct PointToml<T> {
    /// Number of the key, 1 to 88.
    pub key: At<i64>,
    /// The quantity there.
    pub value: At<T>,
    /// Source: a name in `[sources]`.
    pub source: Option<At<String>>,
    /// Certainty; required beside a source.
    pub certainty: Option<Certainty>,
    /// Derivation, or a caution.
    pub note: Option<String>,
}

/// Tables of the instrument that some keys do not have: the third string of a note in the bass, say.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Absent")]
pub(crate) struct AbsentToml {
    /// Name, for people: `third string`.
    pub name: At<String>,
    /// The tables, each by its list and name in the instrument file: `string.right`; one within it:
    /// `string.right.damper`.
    pub tables: Vec<At<String>>,
    /// The first and the last key without them.
    pub keys: At<[i64; 2]>,
}

//! The TOML format of keyboard files. Units are at the end of the keys' names.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use crate::instrument::quantity::{At, KeyName, Num, Pair, Positive, Real};
use crate::instrument::{Certainty, Source};

/// Required value of the key `format`.
pub(crate) const FORMAT: &str = "erard-keyboard/1";

/// A keyboard: the instrument of one key, and how the other keys differ from it.
///
/// A quantity over the keyboard is a list of points `{ key = 1, value = ..., source = "...", certainty = "..." }` with
/// ascending keys, counted from 1 in the bass. Between two points a quantity is linear in the key, a factor linear in
/// its logarithm; before the first and after the last point it is constant.
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
    /// Base instrument: the name of a built-in one, or a file, relative to the folder of this file.
    pub instrument: At<String>,
    /// Key that the base instrument belongs to, from 1 to 88, or its note. There every added mass and shift must be 0
    /// and every factor 1.
    pub instrument_key: At<KeyName>,
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

/// A point mass that is added to a body, or removed if negative. It changes the body's mass, centre of mass and inertia
/// together.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "AddedMass")]
pub(crate) struct AddedMassToml {
    /// Name of the grading, for people, e.g. `hammer head`.
    pub name: At<String>,
    /// Name of the body in the instrument file.
    pub body: At<String>,
    /// Position of the added mass, in the body's own frame, mm.
    pub at_mm: Num<Pair>,
    /// Added mass over the keyboard, g; negative removes mass.
    pub mass_g: At<Vec<PointToml<Real>>>,
}

/// Numbers of the instrument that are multiplied by a factor. Between two points the factor's logarithm is linear in
/// the key.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Factor")]
pub(crate) struct FactorToml {
    /// Name of the grading, for people, e.g. `stiffness of the string's felt`.
    pub name: At<String>,
    /// The numbers, each by its dotted path in the instrument file, e.g. `zone.string.felt.stiffness_N_per_m_r`.
    pub numbers: Vec<At<String>>,
    /// Factor over the keyboard, greater than 0.
    pub factor: At<Vec<PointToml<Positive>>>,
}

/// Points of the instrument that are moved along a direction.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Shift")]
pub(crate) struct ShiftToml {
    /// Name of the grading, for people, e.g. `height of the string`.
    pub name: At<String>,
    /// The points, each by its dotted path in the instrument file, e.g. `zone.string.line.point_mm`.
    pub points: Vec<At<String>>,
    /// Direction of a positive shift in the frame of the body that carries the point, of any length but zero.
    pub direction: Num<Pair>,
    /// Shift along `direction` over the keyboard, mm.
    pub by_mm: At<Vec<PointToml<Real>>>,
}

/// One point of a quantity over the keyboard.
#[derive(Debug, Clone, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "{T}Point")]
pub(crate) struct PointToml<T> {
    /// Key, 1 to 88, or its note.
    pub key: At<KeyName>,
    /// Value of the quantity at this key.
    pub value: At<T>,
    /// Source: a name in `[sources]`.
    pub source: Option<At<String>>,
    /// Certainty; required beside a source.
    pub certainty: Option<Certainty>,
    /// Derivation, or a caution.
    pub note: Option<String>,
}

/// Tables of the instrument that some keys do not have, such as the third string in the bass.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Absent")]
pub(crate) struct AbsentToml {
    /// Name, for people, e.g. `third string`.
    pub name: At<String>,
    /// The tables, each by its list and name in the instrument file, e.g. `string.right`, or a table within one, e.g.
    /// `string.right.damper`.
    pub tables: Vec<At<String>>,
    /// First and last key without these tables, `[first, last]`, from 1 to 88, or their notes.
    pub keys: At<[KeyName; 2]>,
}

//! The TOML format of linkage files: three levers, given by their lengths. The JSON Schema is generated from these
//! structs.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use erard::instrument::Source;
use erard::instrument::quantity::{At, NonNegative, Num, Pair, Positive, Real};

/// Required value of the key `kind`.
pub(crate) const KIND: &str = "three-lever";

/// The three levers of a piano action (key, whippen, hammer), given by their lengths: the kinematics of one note.
///
/// Lengths are in millimetres and signed, angles in degrees counter-clockwise; x points away from the player and y up.
/// A, B and C are the pivots of key, whippen and hammer: B - A = (L1, L5), B - C = (L6, -L10). A number is bare or
/// carries its provenance: `L1 = 205.23` or `L1 = { value = 205.23, source = "...", certainty = "estimate" }`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Erard linkage file")]
pub(crate) struct LinkageToml {
    /// Kind of linkage: `three-lever`.
    #[schemars(extend("const" = KIND))]
    pub kind: At<String>,
    /// Name shown in summaries and figures.
    pub name: Option<At<String>>,
    /// Description of the instrument, for people.
    #[serde(rename = "description")]
    pub _description: Option<String>,
    /// The sources that numbers cite, by name.
    #[serde(default)]
    pub sources: BTreeMap<String, Source>,
    /// The lengths L1 to L10, mm.
    pub lengths_mm: LengthsToml,
    /// Front arm and rest angle of the key.
    pub key: KeyToml,
    /// Strike point of the hammer.
    pub hammer: HammerToml,
    /// Blow distance and let-off distance; 46 mm and 1.5 mm when absent.
    pub regulation: Option<At<RegulationToml>>,
}

/// Lengths L1 to L10, mm, signed. The whippen's frame has its origin at B, x away from the player and y up.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Lengths")]
pub(crate) struct LengthsToml {
    /// Distance along x from the key's pivot A to the whippen's pivot B, mm.
    #[serde(rename = "L1")]
    pub l1: Num<Real>,
    /// Height of the capstan's contact over the key's pivot A, along the normal of the key's surface, mm.
    #[serde(rename = "L2")]
    pub l2: Num<Real>,
    /// x of the heel's contact in the whippen's frame, mm; negative in front of B.
    #[serde(rename = "L3")]
    pub l3: Num<Real>,
    /// Depth of the heel's contact below B in the whippen's frame, mm.
    #[serde(rename = "L4")]
    pub l4: Num<Real>,
    /// Height of B over A, along y, mm.
    #[serde(rename = "L5")]
    pub l5: Num<Real>,
    /// Distance along x from the hammer's pivot C to B, mm.
    #[serde(rename = "L6")]
    pub l6: Num<Real>,
    /// Minus the height of the jack's top above B in the whippen's frame, mm: negative for a top above B.
    #[serde(rename = "L7")]
    pub l7: Num<Real>,
    /// Position of the knuckle's contact along the shank, from C, mm.
    #[serde(rename = "L8")]
    pub l8: Num<Real>,
    /// Depth of the knuckle's contact below the shank's axis, mm.
    #[serde(rename = "L9")]
    pub l9: Num<Real>,
    /// Height of C over B, along y, mm.
    #[serde(rename = "L10")]
    pub l10: Num<Real>,
}

impl LengthsToml {
    /// L1 to L10 in order.
    pub(crate) fn all(&self) -> [&Num<Real>; 10] {
        [&self.l1, &self.l2, &self.l3, &self.l4, &self.l5, &self.l6, &self.l7, &self.l8, &self.l9, &self.l10]
    }
}

/// Front arm and rest angle of the key.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Key")]
pub(crate) struct KeyToml {
    /// Distance from the key's pivot to the point where the finger presses, mm.
    pub front_mm: Num<Positive>,
    /// Angle k at rest, degrees: the direction of the normal of the key's surface, 90 for a level key.
    pub rest_deg: Num<Real>,
}

/// Strike point of the hammer.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Hammer")]
pub(crate) struct HammerToml {
    /// Strike point, mm: distance along the shank from the pivot, and height above the shank's axis.
    pub head_mm: Num<Pair>,
}

/// Blow distance and let-off distance of the hammer.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Regulation")]
pub(crate) struct RegulationToml {
    /// Blow distance, from the hammer's rest to the string, mm; 46 when absent.
    pub blow_mm: Option<Num<Positive>>,
    /// Let-off distance, from the string down to the hammer at let-off, mm; less than the blow distance, 1.5 when
    /// absent.
    pub let_off_mm: Option<Num<NonNegative>>,
}

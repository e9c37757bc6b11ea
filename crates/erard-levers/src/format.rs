//! The linkage file as it is written: three levers by their lengths. The JSON Schema is generated from these structs.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use erard::instrument::Source;
use erard::instrument::quantity::{At, NonNegative, Num, Pair, Positive, Real};

/// What the key `kind` must say.
pub(crate) const KIND: &str = "three-lever";

/// Three levers of a piano action by their lengths: the kinematics of one note.
///
/// Lengths in millimetres, signed; angles in degrees, counter-clockwise; x away from the player, y up. A, B and C are
/// the pivots of key, whippen and hammer: B - A = (L1, L5), B - C = (L6, -L10). Every number may stand alone or carry
/// its provenance: `L1 = 205.23` or `L1 = { value = 205.23, source = "...", certainty = "estimate" }`.
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
    /// The lengths.
    pub lengths_mm: LengthsToml,
    /// The key.
    pub key: KeyToml,
    /// The hammer.
    pub hammer: HammerToml,
    /// Let-off: a blow of 46 mm and let-off at 1.5 mm when absent.
    pub regulation: Option<At<RegulationToml>>,
}

/// L1 to L10, mm.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Lengths")]
pub(crate) struct LengthsToml {
    /// x from the key's pivot A to the whippen's pivot B.
    #[serde(rename = "L1")]
    pub l1: Num<Real>,
    /// Height of the capstan's contact line along the key surface's normal.
    #[serde(rename = "L2")]
    pub l2: Num<Real>,
    /// x of the heel's contact in the whippen's frame: negative in front of B.
    #[serde(rename = "L3")]
    pub l3: Num<Real>,
    /// Depth of the heel's contact below B in the whippen's frame.
    #[serde(rename = "L4")]
    pub l4: Num<Real>,
    /// y from A to B.
    #[serde(rename = "L5")]
    pub l5: Num<Real>,
    /// x from the hammer's pivot C to B.
    #[serde(rename = "L6")]
    pub l6: Num<Real>,
    /// Minus the height of the jack's top above B in the whippen's frame.
    #[serde(rename = "L7")]
    pub l7: Num<Real>,
    /// The knuckle's contact along the shank from C.
    #[serde(rename = "L8")]
    pub l8: Num<Real>,
    /// The knuckle's contact below the shank's axis.
    #[serde(rename = "L9")]
    pub l9: Num<Real>,
    /// y from B to C.
    #[serde(rename = "L10")]
    pub l10: Num<Real>,
}

impl LengthsToml {
    /// L1 to L10 in order.
    pub(crate) fn all(&self) -> [&Num<Real>; 10] {
        [&self.l1, &self.l2, &self.l3, &self.l4, &self.l5, &self.l6, &self.l7, &self.l8, &self.l9, &self.l10]
    }
}

/// The key.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Key")]
pub(crate) struct KeyToml {
    /// Radius from the key's pivot to where the finger presses, mm.
    pub front_mm: Num<Positive>,
    /// k at rest, degrees: direction of the key surface's normal, 90 for a level key.
    pub rest_deg: Num<Real>,
}

/// The hammer.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Hammer")]
pub(crate) struct HammerToml {
    /// Strike point: along the shank from the pivot, and above it, mm.
    pub head_mm: Num<Pair>,
}

/// Where the hammer is let off.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Regulation")]
pub(crate) struct RegulationToml {
    /// From the hammer's rest to the string, mm; 46 when absent.
    pub blow_mm: Option<Num<Positive>>,
    /// From the string down to where the hammer is let off, mm; 1.5 when absent.
    pub let_off_mm: Option<Num<NonNegative>>,
}

//! The instrument file as it is written: TOML, a pianist's units, the unit in the key's name.
//!
//! These structs are the format: serde reads the file into them, and the JSON Schema is generated from them, doc
//! comments included. What they mean in SI units, and what is not allowed, is [`super::convert`]'s business.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::felt::FeltToml;
use super::provenance::{Certainty, Source};
use super::quantity::{At, NonNegative, Num, Pair, Part, Positive, Real};
use super::{
    MAX_BODIES, MAX_BRIDGE_MODES, MAX_CORNERS, MAX_PARTS, MAX_SCREWS, MAX_SPRINGS, MAX_STRINGS, MAX_ZONES, Material,
};

/// What the key `format` must say.
pub(crate) const FORMAT: &str = "erard-instrument/1";

/// An instrument: a planar mechanism of hinged rigid bodies with felts between them.
///
/// Lengths in millimetres, masses in grams, angles in degrees; x toward the back of the piano, y up, angles
/// counter-clockwise; the player sits at negative x. Every number may stand alone or carry its provenance:
/// `mass_g = 140` or `mass_g = { value = 140, source = "...", certainty = "estimate" }`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(title = "Erard instrument file")]
pub(crate) struct InstrumentToml {
    /// Version of the format: `erard-instrument/1`.
    #[schemars(extend("const" = FORMAT))]
    pub format: At<String>,
    /// Name shown in summaries, e.g. `Concert grand, C4`.
    pub name: At<String>,
    /// Description of the instrument, for people.
    pub description: Option<String>,
    /// Gravity, m/s2, pointing down.
    #[serde(rename = "gravity_m_s2")]
    pub gravity_m_s2: Num<NonNegative>,
    /// The sources that numbers cite, by name.
    #[serde(default)]
    pub sources: BTreeMap<String, Source>,
    /// The bodies; at most 12.
    #[schemars(length(min = 1, max = MAX_BODIES))]
    pub body: Vec<At<BodyToml>>,
    /// Torsion springs at pivots; at most 24.
    #[serde(default)]
    #[schemars(length(max = MAX_SPRINGS))]
    pub spring: Vec<At<SpringToml>>,
    /// Contact zones: felts, cloths and leathers; at most 32.
    #[serde(default)]
    #[schemars(length(max = MAX_ZONES))]
    pub zone: Vec<At<ZoneToml>>,
    /// The strings that the hammer strikes, at the zone that `roles.string` names; at most 3, those of one note. The
    /// string is rigid when absent.
    #[serde(default)]
    #[schemars(length(max = MAX_STRINGS))]
    pub string: Vec<At<StringToml>>,
    /// Modes of the bridge where the strings end; at most 16. A bridge without modes is rigid.
    #[serde(default)]
    #[schemars(length(max = MAX_BRIDGE_MODES))]
    pub bridge_mode: Vec<At<BridgeModeToml>>,
    /// Roles of the parts of the mechanism. A role that is absent does not exist.
    pub roles: Option<At<RolesToml>>,
    /// The player's fingertip: needed when `roles` names a key.
    pub finger: Option<At<FingerToml>>,
    /// Derivation of the one-degree-of-freedom model.
    pub one_dof: Option<At<OneDofToml>>,
    /// Regulating screws.
    #[serde(default)]
    #[schemars(length(max = MAX_SCREWS))]
    pub screw: Vec<At<ScrewToml>>,
    /// Outlines for drawings; they take no part in the mechanics.
    #[serde(default)]
    #[schemars(length(max = MAX_PARTS))]
    pub part: Vec<At<PartToml>>,
}

/// A rigid body on a hinge. Its own frame has its origin at the pivot and is turned by `angle_deg`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Body")]
pub(crate) struct BodyToml {
    /// Identifier: lower-case letters, digits and underscores; the stem of the run's columns. Not `ground`.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// The body that carries the hinge; `ground` when absent.
    pub hinged_on: Option<At<String>>,
    /// The pivot in the frame of what it is hinged on (the world's frame for the ground), mm.
    pub pivot_mm: Num<Pair>,
    /// Angle of the body's own frame against the world as drawn, degrees counter-clockwise; 0 when absent.
    pub angle_deg: Option<Num<Real>>,
    /// Mass, g.
    pub mass_g: Num<Positive>,
    /// Moment of inertia about its own pivot, kg m2; at least mass times the squared distance of the centre of mass.
    #[serde(rename = "inertia_kg_m2")]
    pub inertia_kg_m2: Num<Positive>,
    /// Centre of mass in the body's own frame, mm.
    pub center_of_mass_mm: Num<Pair>,
    /// Dry friction torque of the pivot, N m; 0 when absent.
    #[serde(rename = "friction_torque_N_m")]
    pub friction_torque_n_m: Option<Num<NonNegative>>,
    /// Viscous friction of the pivot, N m s per radian; 0 when absent.
    #[serde(rename = "viscous_N_m_s")]
    pub viscous_n_m_s: Option<Num<NonNegative>>,
    /// Static over kinetic friction, from 1: what sticks gets harder to move, as 1 - exp(-t/tau), and what slips has
    /// lost that. With `dwell_s`.
    pub static_friction_ratio: Option<Num<Positive>>,
    /// tau of that, s.
    pub dwell_s: Option<Num<Positive>>,
    /// Stiffness of the pivot's bushing, N/m: the pivot may then move, across the x axis of what it is hinged on (for
    /// the ground, up and down). It stands at the end of an arm of 300 mm, a body of its own that the reader adds
    /// (`<name>_bushing`). Rigid when absent.
    #[serde(rename = "bushing_N_per_m")]
    pub bushing_n_per_m: Option<Num<Positive>>,
    /// Damping of the bushing, N s/m; 0 when absent.
    #[serde(rename = "bushing_N_s_per_m")]
    pub bushing_n_s_per_m: Option<Num<NonNegative>>,
    /// Whether the hinge is a bend, false when absent: this body and what it is hinged on are two pieces of one part (a
    /// key, a shank), and the hinge represents the bending of its wood. Its stiffness is that of a spring on this body.
    /// What means the rigid geometry or the weights of parts takes both for one body.
    pub bend: Option<At<bool>>,
    /// Range of its angle against the body that carries it, from the drawn pose, degrees counter-clockwise, as its
    /// stops allow: `[lowest, highest]`, from at most 0 to at least 0. It takes no part in the mechanics: a run in
    /// which the body turns further is not trusted. Not checked when absent.
    pub turn_deg: Option<Num<Pair>>,
}

/// A torsion spring at the pivot of a body.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Spring")]
pub(crate) struct SpringToml {
    /// Identifier: lower-case letters, digits and underscores.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// The body that it turns; the opposite torque acts on what that body is hinged on.
    pub body: At<String>,
    /// Torque on the body as drawn, N m, counter-clockwise positive.
    #[serde(rename = "torque_N_m")]
    pub torque_n_m: Num<Real>,
    /// Stiffness, N m per radian of turning away from the drawn position.
    #[serde(rename = "stiffness_N_m_per_rad")]
    pub stiffness_n_m_per_rad: Num<NonNegative>,
}

/// A modal string under the hammer: a stiff string between two supports that do not move. Its inharmonicity B lifts
/// partial n to n f0 sqrt(1 + B n^2).
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "String", extend("oneOf" = [{ "required": ["frequency_Hz"] }, { "required": ["tension_N"] }]))]
pub(crate) struct StringToml {
    /// Identifier: lower-case letters, digits and underscores.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// Speaking length, mm.
    pub length_mm: Num<Positive>,
    /// Diameter of the wire, of a wound string's core, mm; it bends the string. With `inharmonicity` and `mass_g_per_m`
    /// it may be absent.
    pub diameter_mm: Option<Num<Positive>>,
    /// Mass per length, g/m, for a wound string; that of a steel wire of 7850 kg/m3 when absent.
    pub mass_g_per_m: Option<Num<Positive>>,
    /// Frequency of the first partial, Hz, to which the string is tuned. In place of `tension_N`.
    #[serde(rename = "frequency_Hz")]
    pub frequency_hz: Option<Num<Positive>>,
    /// Tension, N. In place of `frequency_Hz`.
    #[serde(rename = "tension_N")]
    pub tension_n: Option<Num<Positive>>,
    /// B. That of a steel wire of 202 GPa and `diameter_mm` when absent.
    pub inharmonicity: Option<Num<NonNegative>>,
    /// Detuning from its frequency or tension, cents, up positive; 0 when absent.
    pub detuned_cents: Option<Num<Real>>,
    /// b1: what all partials' amplitudes lose, 1/s. Amplitudes decay as exp(-(b1 + b3 omega^2) t).
    pub loss_per_s: Num<NonNegative>,
    /// b3: what they lose the more, the higher they are, s; 0 when absent.
    pub loss_s: Option<Num<NonNegative>>,
    /// Striking point of the hammer, mm from one end.
    pub strike_mm: Num<Positive>,
    /// Damper on the string; none when absent.
    pub damper: Option<At<DamperToml>>,
}

/// The felt of a damper on a string.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Damper")]
pub(crate) struct DamperToml {
    /// The zone between the damper and this string; its side B is a line on the ground, where the string lies at rest.
    pub zone: At<String>,
    /// The middle of the felt, mm from the end that `strike_mm` is counted from.
    pub middle_mm: Num<Positive>,
    /// Its length along the string, mm.
    pub length_mm: Num<Positive>,
}

/// A mode of the soundboard where the strings of a note end: the bridge moves, and strings feel each other through it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "BridgeMode")]
pub(crate) struct BridgeModeToml {
    /// Identifier: lower-case letters, digits and underscores.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// Its mass, referred to the bridge there, g.
    pub mass_g: Num<Positive>,
    /// Its frequency, Hz.
    #[serde(rename = "frequency_Hz")]
    pub frequency_hz: Num<Positive>,
    /// Its loss factor, below 1: amplitudes decay as exp(-loss_factor omega t / 2).
    pub loss_factor: Num<Part>,
}

/// A felt between a disc (or a point) on one body and a line, a rounded segment or a disc on another.
/// Exactly one of `line`, `segment` and `other_disc` is given.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Zone", extend("oneOf" = [{ "required": ["line"] }, { "required": ["segment"] }, { "required": ["other_disc"] }]))]
pub(crate) struct ZoneToml {
    /// Identifier: lower-case letters, digits and underscores; the stem of the run's columns.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// A line for people, e.g. `jack toe - let-off button`; the name when absent.
    pub label: Option<At<String>>,
    /// Side A.
    pub disc: At<DiscToml>,
    /// Side B, a half plane of wood.
    pub line: Option<At<LineToml>>,
    /// Side B, a segment that ends.
    pub segment: Option<At<SegmentToml>>,
    /// Side B, a second disc.
    pub other_disc: Option<At<DiscToml>>,
    /// The felt's law.
    pub felt: At<FeltToml>,
    /// Coulomb friction coefficient; no friction when absent.
    pub friction_coefficient: Option<Num<NonNegative>>,
    /// Static over kinetic friction, from 1: what sticks gets harder to move, as 1 - exp(-t/tau), and what slips has
    /// lost that. With `dwell_s`.
    pub static_friction_ratio: Option<Num<Positive>>,
    /// tau of that, s.
    pub dwell_s: Option<Num<Positive>>,
}

/// A disc; a point when its radius is absent or 0.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Disc")]
pub(crate) struct DiscToml {
    /// The body that carries it, or `ground`.
    pub body: At<String>,
    /// Centre in that body's own frame (the world's for the ground), mm.
    pub center_mm: Num<Pair>,
    /// Radius, mm; 0 when absent.
    pub radius_mm: Option<Num<NonNegative>>,
}

/// A straight edge of wood without ends.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Line")]
pub(crate) struct LineToml {
    /// The body that carries it, or `ground`.
    pub body: At<String>,
    /// A point of the line in that body's own frame (the world's for the ground), mm.
    pub point_mm: Num<Pair>,
    /// Direction that points out of the wood, of any length but zero: [0, 1] for a floor, [0, -1] for a ceiling.
    pub normal: Num<Pair>,
}

/// A straight edge that ends, with round corners: all points within `rounding_mm` of the core segment.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Segment")]
pub(crate) struct SegmentToml {
    /// The body that carries it, or `ground`.
    pub body: At<String>,
    /// One end of the core in that body's own frame (the world's for the ground), mm.
    pub from_mm: Num<Pair>,
    /// The other end of the core, mm.
    pub to_mm: Num<Pair>,
    /// Rounding radius, mm; 0 when absent.
    pub rounding_mm: Option<Num<NonNegative>>,
}

/// Roles: names of bodies and zones.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Roles")]
pub(crate) struct RolesToml {
    /// The body that the finger presses.
    pub key: Option<At<String>>,
    /// Point at which the finger presses, in the key's own frame, mm.
    pub key_front_mm: Option<Num<Pair>>,
    /// Whether the key is a sharp; a keyboard says it of each of its keys. For drawings only.
    #[serde(default)]
    pub sharp: bool,
    /// The body whose speed is the result.
    pub hammer: Option<At<String>>,
    /// The strike point in the hammer's own frame, mm.
    pub hammer_head_mm: Option<Num<Pair>>,
    /// The zone that stops the key: key bottom.
    pub key_bottom: Option<At<String>>,
    /// The zone between hammer and string.
    pub string: Option<At<String>>,
    /// Whether the string stands still although strings are described; no when absent.
    #[serde(default)]
    pub rigid_string: bool,
    /// Whether the bridge stands still although its modes are described; no when absent.
    #[serde(default)]
    pub rigid_bridge: bool,
    /// The zone between the damper's lever and the rail that the sustain pedal lifts.
    pub pedal: Option<At<String>>,
    /// The zone between jack toe and let-off button.
    pub let_off: Option<At<String>>,
    /// The zones that push the hammer up.
    #[serde(default)]
    pub knuckle: Vec<At<String>>,
    /// The zone between hammer tail and back check.
    pub check: Option<At<String>>,
}

/// The fingertip between the player and the key: a spring and a damper in parallel that can only push.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Finger")]
pub(crate) struct FingerToml {
    /// Stiffness, N/m.
    #[serde(rename = "stiffness_N_per_m")]
    pub stiffness_n_per_m: Num<Positive>,
    /// Damping, N s/m.
    #[serde(rename = "damping_N_s_per_m")]
    pub damping_n_s_per_m: Num<NonNegative>,
}

/// What the one-degree-of-freedom model is made of.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "OneDof")]
pub(crate) struct OneDofToml {
    /// Zones that tie the other bodies to the key at rest.
    pub transmits: Vec<At<String>>,
    /// The key's own stops.
    pub stops: Vec<At<String>>,
}

/// A regulating screw: moves one side of a zone (`zone`, `side`, `direction`, `setting_mm`), turns its curve (`zone`,
/// `side`, `setting_deg`), or adds to a spring's torque (`spring`, `setting_N_m`).
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Screw")]
pub(crate) struct ScrewToml {
    /// Identifier: lower-case letters, digits and underscores.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// Effect of a positive setting, for people.
    pub label: Option<At<String>>,
    /// The zone of which it moves one side.
    pub zone: Option<At<String>>,
    /// The side that it moves.
    pub side: Option<At<ScrewSide>>,
    /// Direction of a positive setting in the frame of that side's body, of any length but zero.
    pub direction: Option<Num<Pair>>,
    /// Setting: travel from the drawn geometry, mm.
    pub setting_mm: Option<Num<Real>>,
    /// Rotation of the curve from the drawn geometry, degrees counter-clockwise: a line about its `point_mm`, a
    /// segment about its middle.
    pub setting_deg: Option<Num<Real>>,
    /// The spring that it tightens.
    pub spring: Option<At<String>>,
    /// Torque added to the spring, N m; positive tightens it, whatever the sign of its torque.
    #[serde(rename = "setting_N_m")]
    pub setting_n_m: Option<Num<Real>>,
}

/// The side of a zone that a screw moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub(crate) enum ScrewSide {
    /// Side A, the disc.
    Disc,
    /// Side B, the line, segment or other disc.
    Curve,
}

/// A piece of wood, felt, leather or metal in drawings.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Part")]
pub(crate) struct PartToml {
    /// Name of the part, e.g. `hammer head`.
    pub name: At<String>,
    /// The body that carries it, or `ground`.
    pub body: At<String>,
    /// Material of the part.
    pub material: Material,
    /// Closed polygon in that body's own frame (the world's for the ground), mm; three corners or more.
    #[schemars(length(min = 3, max = MAX_CORNERS))]
    pub outline_mm: At<Vec<Pair>>,
    /// Whether its corners are rounded off into a smooth curve; no when absent.
    #[serde(default)]
    pub smooth: bool,
    /// Source of the outline: a name in `[sources]`.
    pub source: Option<At<String>>,
    /// Certainty.
    pub certainty: Option<Certainty>,
    /// Derivation, or a caution.
    pub note: Option<String>,
}

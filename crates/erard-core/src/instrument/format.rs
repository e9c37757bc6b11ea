//! The TOML format of instrument files: lengths in mm, masses in g, any other unit at the end of the key's name.
//!
//! Serde reads the file into these structs, and the JSON Schema is generated from them, doc comments included.
//! [`super::convert`] checks the values and converts them to SI units.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::Deserialize;

use super::felt::FeltToml;
use super::provenance::{Certainty, Source};
use super::quantity::{At, KeyName, NonNegative, Num, Pair, Part, Positive, Real};
use super::{
    MAX_BODIES, MAX_BRIDGE_MODES, MAX_CORNERS, MAX_PARTS, MAX_SCREWS, MAX_SPRINGS, MAX_STRINGS, MAX_ZONES, Material,
};

/// Required value of the key `format`.
pub(crate) const FORMAT: &str = "erard-instrument/1";

/// An instrument: a planar mechanism of hinged rigid bodies with felts between them.
///
/// Lengths are in millimetres, masses in grams, angles in degrees. x points to the back of the piano and y up, angles
/// are counter-clockwise, and the player sits at negative x. A number is bare or carries its provenance: `mass_g = 140`
/// or `mass_g = { value = 140, source = "...", certainty = "estimate" }`. In quotes it has any unit of its quantity:
/// `mass_g = "0.3oz"`, `point_mm = ["1/16in", 0]`.
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
    /// Key of the piano that the instrument is, 1 to 88 or a note from "A0" to "C8"; it selects the usual ranges.
    pub key: Option<At<KeyName>>,
    /// Number of the random sample that the file was drawn as, from 1.
    pub sample: Option<At<i64>>,
    /// Acceleration of gravity, m/s2; it acts downward.
    #[serde(rename = "gravity_m_s2")]
    pub gravity_m_per_s2: Num<NonNegative>,
    /// The sources that numbers cite, by name.
    #[serde(default)]
    pub sources: BTreeMap<String, Source>,
    /// Rigid bodies, from 1 to 12; each bushing and each sliding pin counts as one more.
    #[schemars(length(min = 1, max = MAX_BODIES))]
    pub body: Vec<At<BodyToml>>,
    /// Torsion springs at pivots, at most 24; each bushing counts as one more.
    #[serde(default)]
    #[schemars(length(max = MAX_SPRINGS))]
    pub spring: Vec<At<SpringToml>>,
    /// Contact zones: felts, cloths and leathers; at most 32.
    #[serde(default)]
    #[schemars(length(max = MAX_ZONES))]
    pub zone: Vec<At<ZoneToml>>,
    /// Modal strings of one note, at most 3. The hammer strikes them at the zone that `roles.string` names. The string
    /// is rigid when absent.
    #[serde(default)]
    #[schemars(length(max = MAX_STRINGS))]
    pub string: Vec<At<StringToml>>,
    /// Modes of the bridge where the strings end; at most 512, those of `board` included. A bridge without modes is
    /// rigid.
    #[serde(default)]
    #[schemars(length(max = MAX_BRIDGE_MODES))]
    pub bridge_mode: Vec<At<BridgeModeToml>>,
    /// Bands of the soundboard's modes at the bridge, drawn from a seed; beside those that `bridge_mode` lists.
    #[serde(default)]
    pub board: Vec<At<BoardToml>>,
    /// Bodies and zones that have a role in the action. An absent role means that the instrument has no such part.
    pub roles: Option<At<RolesToml>>,
    /// The player's fingertip; required when `roles` names a key.
    pub finger: Option<At<FingerToml>>,
    /// Zones from which the one-degree-of-freedom model is derived.
    pub one_dof: Option<At<OneDofToml>>,
    /// Regulating screws, at most 64.
    #[serde(default)]
    #[schemars(length(max = MAX_SCREWS))]
    pub screw: Vec<At<ScrewToml>>,
    /// Outlines for drawings, at most 512. They do not affect the mechanics.
    #[serde(default)]
    #[schemars(length(max = MAX_PARTS))]
    pub part: Vec<At<PartToml>>,
}

/// A rigid body on a hinge. The origin of its frame is the pivot; `angle_deg` is the frame's angle as drawn.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Body")]
pub(crate) struct BodyToml {
    /// Identifier: 1 to 40 lower-case letters, digits and underscores, starting with a letter; not `ground`. Names of a
    /// run's columns begin with it, e.g. `<name>_rad`.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// Body that carries the hinge; `ground` when absent.
    pub hinged_on: Option<At<String>>,
    /// Pivot in the frame of the body that carries the hinge (the world's frame for the ground), mm.
    pub pivot_mm: Num<Pair>,
    /// Angle of the body's frame against the world in the drawn pose, degrees counter-clockwise; 0 when absent.
    pub angle_deg: Option<Num<Real>>,
    /// Mass, g.
    pub mass_g: Num<Positive>,
    /// Moment of inertia about the pivot, kg m2; at least the mass times the squared distance from the pivot to the
    /// centre of mass.
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
    /// Ratio of static to kinetic friction, from 1 to 100. While the pivot sticks, friction grows from kinetic to
    /// static as 1 - exp(-t/tau); slipping resets it. Requires `dwell_s` and `friction_torque_N_m`.
    pub static_friction_ratio: Option<Num<Positive>>,
    /// Time constant tau of the growth of static friction, s. Requires `static_friction_ratio`.
    pub dwell_s: Option<Num<Positive>>,
    /// Stiffness of the pivot's bushing, N/m, from 100 to 1e9; the pivot is rigid when absent. The pivot can move at
    /// right angles to the x axis of the body that carries the hinge (up and down on the ground). The reader adds a
    /// body for it (an arm of 300 mm) and a spring, both named `<name>_bushing`.
    #[serde(rename = "bushing_N_per_m")]
    pub bushing_n_per_m: Option<Num<Positive>>,
    /// Damping of the bushing, N s/m; 0 when absent. Requires `bushing_N_per_m`.
    #[serde(rename = "bushing_N_s_per_m")]
    pub bushing_n_s_per_m: Option<Num<NonNegative>>,
    /// Dry friction along the pin, N, of a pivot that is free along it: it can move at right angles to the x axis of
    /// the body that carries the hinge (up and down on the ground), and lies on a zone, which can only push. This
    /// zone's disc is on this body, within 10 mm of the pivot, and its `line` on the body that carries the hinge. A key
    /// lies so on the punching of its balance rail. The reader adds a body (an arm of 1 m), `<name>_pin`. Not beside
    /// `bushing_N_per_m`.
    #[serde(rename = "pin_friction_N")]
    pub pin_friction_n: Option<Num<NonNegative>>,
    /// True if the hinge represents the bending of wood: this body and the one that carries it are two pieces of one
    /// part, such as a key or a shank. A `[[spring]]` on this body gives the stiffness. Results for weights or rigid
    /// geometry treat both pieces as one body. False when absent.
    pub bend: Option<At<bool>>,
    /// Range of angle that the stops allow, `[lowest, highest]`, degrees counter-clockwise from the drawn pose and
    /// relative to the body that carries the hinge; it must include 0. It does not affect the motion: a run that
    /// exceeds it is marked as not trusted. Not checked when absent.
    pub turn_deg: Option<Num<Pair>>,
}

/// A torsion spring at the pivot of a body.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Spring")]
pub(crate) struct SpringToml {
    /// Identifier: 1 to 40 lower-case letters, digits and underscores, starting with a letter.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// Body on which the torque acts. The opposite torque acts on the body that carries its hinge.
    pub body: At<String>,
    /// Torque on the body in the drawn pose, N m, counter-clockwise positive.
    #[serde(rename = "torque_N_m")]
    pub torque_n_m: Num<Real>,
    /// Stiffness, N m per radian of rotation from the drawn pose, relative to the body that carries the hinge.
    #[serde(rename = "stiffness_N_m_per_rad")]
    pub stiffness_n_m_per_rad: Num<NonNegative>,
}

/// A modal string: a stiff string with one end fixed and the other on the bridge. Partial n has the frequency n f0
/// sqrt(1 + B n^2), with the inharmonicity B.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "String", extend("oneOf" = [{ "required": ["frequency_Hz"] }, { "required": ["tension_N"] }]))]
pub(crate) struct StringToml {
    /// Identifier: 1 to 40 lower-case letters, digits and underscores, starting with a letter.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// Speaking length, mm.
    pub length_mm: Num<Positive>,
    /// Diameter of the wire (of the core of a wound string), mm. It gives the default of `mass_g_per_m` and of
    /// `inharmonicity`, and is required unless both are given.
    pub diameter_mm: Option<Num<Positive>>,
    /// Mass per length, g/m. When absent, that of a steel wire of 7850 kg/m3 and `diameter_mm`; give it for a wound
    /// string.
    pub mass_g_per_m: Option<Num<Positive>>,
    /// Frequency of the first partial before detuning, Hz. Give either this or `tension_N`.
    #[serde(rename = "frequency_Hz")]
    pub frequency_hz: Option<Num<Positive>>,
    /// Tension before detuning, N. Give either this or `frequency_Hz`.
    #[serde(rename = "tension_N")]
    pub tension_n: Option<Num<Positive>>,
    /// Inharmonicity B, from 0 to 1. When absent, that of a steel wire of 202 GPa and `diameter_mm`.
    pub inharmonicity: Option<Num<NonNegative>>,
    /// Detuning from `frequency_Hz` or `tension_N`, cents, from -1200 to 1200, sharp positive; 0 when absent.
    pub detuned_cents: Option<Num<Real>>,
    /// Loss b1, 1/s, equal for all partials. Amplitudes decay as exp(-(b1 + b3 omega^2) t).
    pub loss_per_s: Num<NonNegative>,
    /// Loss b3, s, which makes higher partials decay faster (see `loss_per_s`); 0 when absent.
    pub loss_s: Option<Num<NonNegative>>,
    /// Striking point of the hammer, mm from the end opposite the bridge; less than `length_mm`.
    pub strike_mm: Num<Positive>,
    /// The string's part of the hammer's force, as a weight: each string of the note gets its own over the sum of all;
    /// 1 when absent. A hammer that is not level with the strings strikes them unevenly.
    pub strike_share: Option<Num<Positive>>,
    /// Angle between the blow and the vertical plane of the string, degrees. The string then also moves horizontally,
    /// coupled by this angle and by the bridge's `horizontal` motion; when absent, it moves vertically only.
    pub strike_angle_deg: Option<Num<Real>>,
    /// Damper on the string; none when absent.
    pub damper: Option<At<DamperToml>>,
}

/// The felt of a damper on a string.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Damper")]
pub(crate) struct DamperToml {
    /// Zone between the damper and this string, used for no other contact. Its side B is the string at rest: a line on
    /// the ground.
    pub zone: At<String>,
    /// Middle of the felt, mm from the end from which `strike_mm` is measured.
    pub middle_mm: Num<Positive>,
    /// Length of the felt along the string, mm. The felt must not extend beyond the string.
    pub length_mm: Num<Positive>,
}

/// A vibration mode of the soundboard at the bridge. The bridge then moves and couples the strings of the note.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "BridgeMode")]
pub(crate) struct BridgeModeToml {
    /// Identifier: 1 to 40 lower-case letters, digits and underscores, starting with a letter.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// Mass of the mode, g, referred to the vertical motion of the bridge where the strings end.
    pub mass_g: Num<Positive>,
    /// Frequency of the mode, Hz.
    #[serde(rename = "frequency_Hz")]
    pub frequency_hz: Num<Positive>,
    /// Loss factor of the mode, from 0 to 0.99: amplitudes decay as exp(-loss_factor omega t / 2).
    pub loss_factor: Num<Part>,
    /// Horizontal motion of the bridge per vertical motion, from -100 to 100: bridges rock, and their pins stand
    /// askew; 0 when absent.
    pub horizontal: Option<Num<Real>>,
}

/// A band of the soundboard's modes at the bridge. Each interval of 1 / `modal_density_s` has one, at a random place
/// and with a random phase psi: the bridge lies at cos psi of the mode's shape, whose slope there, sin psi, rocks it.
/// Vertical motion is cos psi times the square root of 2, horizontal motion `horizontal` sin psi times that: the mean
/// conductance is modal_density_s / (4 mass), and across the blow `horizontal` squared of it.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Board")]
pub(crate) struct BoardToml {
    /// Identifier: 1 to 40 lower-case letters, digits and underscores, starting with a letter.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// Lower end of the band, Hz.
    #[serde(rename = "from_Hz")]
    pub from_hz: Num<Positive>,
    /// Upper end of the band, Hz.
    #[serde(rename = "to_Hz")]
    pub to_hz: Num<Positive>,
    /// Modal density, s: modes per Hz.
    pub modal_density_s: Num<Positive>,
    /// Effective mass, g: that of all that moves in a mode, where the mean square of its shape over the board is 1.
    pub mass_g: Num<Positive>,
    /// Loss factor, from 0 to 0.99, as that of a bridge mode.
    pub loss_factor: Num<Part>,
    /// Root mean square of horizontal over that of vertical motion of the bridge; 0 when absent.
    pub horizontal: Option<Num<NonNegative>>,
    /// Seed of frequencies and phases, a whole number from 0; 0 when absent. Other bands draw others.
    pub seed: Option<At<i64>>,
}

/// A contact zone: a felt between a disc or point on one body (side A) and a line, rounded segment or disc on another
/// (side B). Give exactly one of `line`, `segment` and `other_disc`.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Zone", extend("oneOf" = [{ "required": ["line"] }, { "required": ["segment"] }, { "required": ["other_disc"] }]))]
pub(crate) struct ZoneToml {
    /// Identifier: 1 to 40 lower-case letters, digits and underscores, starting with a letter; not `force`, and not
    /// ending in `_tangential`. Names of a run's columns begin with it, e.g. `<name>_N`.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// Label for people, on one line, e.g. `jack toe - let-off button`. When absent, the name with spaces for
    /// underscores.
    pub label: Option<At<String>>,
    /// Side A: a disc or a point.
    pub disc: At<DiscToml>,
    /// Side B: the straight edge of a half plane of wood.
    pub line: Option<At<LineToml>>,
    /// Side B: a straight edge with two ends, so that a disc can slip off.
    pub segment: Option<At<SegmentToml>>,
    /// Side B: a second disc. At least one of the two discs has a radius.
    pub other_disc: Option<At<DiscToml>>,
    /// Force law of the felt.
    pub felt: At<FeltToml>,
    /// Kinetic friction coefficient (Coulomb's law); no friction when absent.
    pub friction_coefficient: Option<Num<NonNegative>>,
    /// Ratio of static to kinetic friction, from 1 to 100. While the surfaces stick, friction grows from kinetic to
    /// static as 1 - exp(-t/tau); slipping resets it. Requires `dwell_s` and `friction_coefficient`.
    pub static_friction_ratio: Option<Num<Positive>>,
    /// Time constant tau of the growth of static friction, s. Requires `static_friction_ratio`.
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

/// A straight edge of wood, unlimited in both directions.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Line")]
pub(crate) struct LineToml {
    /// The body that carries it, or `ground`.
    pub body: At<String>,
    /// A point of the line in that body's own frame (the world's for the ground), mm.
    pub point_mm: Num<Pair>,
    /// Normal that points out of the wood, in the same frame, of any length but zero: [0, 1] for a floor, [0, -1] for a
    /// ceiling.
    pub normal: Num<Pair>,
}

/// A straight edge with rounded ends: all points within `rounding_mm` of the core, the segment from `from_mm` to
/// `to_mm`.
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

/// Names of the bodies and zones that have a role in the action.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Roles")]
pub(crate) struct RolesToml {
    /// The body that the finger presses.
    pub key: Option<At<String>>,
    /// Point at which the finger presses, in the key's own frame, mm; required with `key`.
    pub key_front_mm: Option<Num<Pair>>,
    /// True for a black key, for drawings only; false when absent. A keyboard file sets it for each of its keys.
    #[serde(default)]
    pub sharp: bool,
    /// The hammer: the body whose speed at `hammer_head_mm` is reported.
    pub hammer: Option<At<String>>,
    /// Strike point in the hammer's own frame, mm; required with `hammer`.
    pub hammer_head_mm: Option<Num<Pair>>,
    /// The zone that stops the key at the bottom of its travel (key front punching).
    pub key_bottom: Option<At<String>>,
    /// The zone between hammer and string.
    pub string: Option<At<String>>,
    /// True for a rigid string in spite of `[[string]]`; false when absent.
    #[serde(default)]
    pub rigid_string: bool,
    /// True for a rigid bridge in spite of `[[bridge_mode]]`; false when absent.
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

/// Zones from which the one-degree-of-freedom model is derived.
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "OneDof")]
pub(crate) struct OneDofToml {
    /// Zones that are closed at rest and make the other bodies follow the key: as many zones as such bodies.
    pub transmits: Vec<At<String>>,
    /// Zones that stop the key itself; the model keeps them.
    pub stops: Vec<At<String>>,
}

/// A regulating screw: moves one side of a zone (`zone`, `side`, `direction`, `setting_mm`), turns its curve (`zone`,
/// `side`, `setting_deg`), or adds to a spring's torque (`spring`, `setting_N_m`).
#[derive(Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
#[schemars(rename = "Screw")]
pub(crate) struct ScrewToml {
    /// Identifier: 1 to 40 lower-case letters, digits and underscores, starting with a letter.
    #[schemars(regex(pattern = r"^[a-z][a-z0-9_]{0,39}$"))]
    pub name: At<String>,
    /// Effect of a positive setting, for people. When absent, the name with spaces for underscores.
    pub label: Option<At<String>>,
    /// Zone that the screw changes. Give either this or `spring`.
    pub zone: Option<At<String>>,
    /// Side that the screw moves; `curve` if it turns the curve.
    pub side: Option<At<ScrewSide>>,
    /// Direction of a positive `setting_mm` in the frame of that side's body, of any length but zero.
    pub direction: Option<Num<Pair>>,
    /// Setting of a screw that moves a side: distance along `direction` from the drawn geometry, mm.
    pub setting_mm: Option<Num<Real>>,
    /// Setting of a screw that turns the curve: rotation from the drawn geometry, degrees counter-clockwise, from -90
    /// to 90. A line turns about its `point_mm`, a segment about its middle.
    pub setting_deg: Option<Num<Real>>,
    /// Spring that the screw tightens. Give either this or `zone`.
    pub spring: Option<At<String>>,
    /// Torque added to the magnitude of the spring's torque, N m; negative loosens the spring. It must not cancel or
    /// reverse the torque.
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

/// Outline of a piece of wood, felt, leather or metal, for drawings only.
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
    /// Closed polygon in that body's own frame (the world's for the ground), mm: from 3 to 4096 corners `[x, y]`.
    #[schemars(length(min = 3, max = MAX_CORNERS))]
    pub outline_mm: At<Vec<Pair>>,
    /// True to round the corners off into a smooth curve; false when absent.
    #[serde(default)]
    pub smooth: bool,
    /// Source of the outline: a name in `[sources]`; requires `certainty`.
    pub source: Option<At<String>>,
    /// Certainty of the outline; requires `source`.
    pub certainty: Option<Certainty>,
    /// Derivation, or a caution.
    pub note: Option<String>,
}

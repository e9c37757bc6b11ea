//! The instrument: what a piano action *is*, in SI units, checked, and without a trace of the file it came from.
//!
//! World frame at rest: x toward the back of the piano, y up, angles counter-clockwise; metres, kilograms, seconds,
//! newtons, radians. Every body carries a frame of its own with the origin at its pivot; all geometry on a body is
//! given in that frame, all geometry on the ground in the world frame.
//!
//! Parts may bend: `bends` says what then belongs together. `format` is the file as written, `file` reads it, `convert`
//! checks it and turns it into the types below, `provenance` keeps where every number comes from, `screws` turns the
//! regulating screws, `rewrite` puts their settings back into the file, and `edit` is how numbers in its text are
//! changed.

// Hidden modules are the reader that all kinds of files share; the linkage files of `erard-workshop` are read by it,
// too. They promise nothing to others.
mod bends;
mod bushing;
mod convert;
pub(crate) mod edit;
#[doc(hidden)]
pub mod error;
mod felt;
#[doc(hidden)]
pub mod file;
mod format;
#[doc(hidden)]
pub mod from_toml;
#[doc(hidden)]
pub mod locate;
mod numbers;
mod outlived;
mod placement;
pub(crate) mod provenance;
#[doc(hidden)]
pub mod quantity;
#[doc(hidden)]
pub mod reader;
mod rewrite;
#[doc(hidden)]
pub mod schema;
mod screws;
#[doc(hidden)]
pub mod serde_fault;
mod strings;
mod tuning;

pub use error::FileError;
pub use file::{InstrumentFile, MAX_FILE_BYTES, UnknownInstrument, file_bytes, utf8};
pub use numbers::{numbers_at, numbers_at_each, with_numbers};
pub use outlived::OutlivedNote;
pub use placement::Placement;
pub use provenance::{Certainty, Citation, CitedNumber, Provenance, Source, Spread};
pub use rewrite::{RewriteError, cited};
pub use schema::json_schema;
pub(crate) use tuning::{REACH_HZ, STEEL_DENSITY_KG_M3};

use moreau::{LawNumber, Loss, Range};

/// Most bodies of an instrument: the engine's capacity.
pub(crate) const MAX_BODIES: usize = 12;
/// Most zones of an instrument: the engine's capacity.
pub(crate) const MAX_ZONES: usize = 32;
/// Most springs of an instrument.
pub(crate) const MAX_SPRINGS: usize = 24;
/// Most strings of a note.
pub(crate) const MAX_STRINGS: usize = 3;
/// Most modes of a bridge.
pub(crate) const MAX_BRIDGE_MODES: usize = 16;
/// Most regulating screws of an instrument.
pub(crate) const MAX_SCREWS: usize = 64;
/// Most drawn parts of an instrument.
pub(crate) const MAX_PARTS: usize = 512;
/// Most corners of one outline.
pub(crate) const MAX_CORNERS: usize = 4096;

/// A point or direction in a plane, `[x, y]`, metres (or dimensionless for directions).
pub type Vec2 = [f64; 2];

/// A whole instrument, validated: every index is in range, every number finite, every mass and inertia positive.
#[derive(Debug, Clone, PartialEq)]
pub struct Instrument {
    /// Name shown in summaries, e.g. `Concert grand, C4`.
    pub name: String,
    /// Gravity, m/s2, pointing toward -y.
    pub gravity_m_s2: f64,
    /// Bodies; a parent always precedes its children.
    pub bodies: Vec<Body>,
    /// Torsion springs between a body and what it is hinged on.
    pub springs: Vec<Spring>,
    /// Contact zones.
    pub zones: Vec<Zone>,
    /// The strings that the hammer strikes, those of one note. None: the string is rigid.
    pub strings: Vec<PianoString>,
    /// Modes of the bridge under them. Empty: the bridge is rigid.
    pub bridge_modes: Vec<BridgeMode>,
    /// Roles of the parts of the mechanism; `None` does not exist.
    pub roles: Roles,
    /// The fingertip.
    pub finger: Finger,
    /// The regulating screws (already applied to `zones` and `springs`).
    pub screws: Vec<Screw>,
    /// Outlines for drawing only; they take no part in the mechanics.
    pub parts: Vec<Part>,
}

/// One hinged rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Identifier, e.g. `whippen`; the stem of the run's columns.
    pub name: String,
    /// Index of the body it is hinged on; `None` is the ground.
    pub parent: Option<usize>,
    /// Pivot in the parent's frame (the world frame for the ground), m.
    pub pivot_m: Vec2,
    /// Angle of the body's frame against the world as drawn, rad: the starting guess for the equilibrium.
    pub angle_rad: f64,
    /// Mass, kg, positive.
    pub mass_kg: f64,
    /// Moment of inertia about its own pivot, kg m2; at least mass times the squared distance of the centre of mass.
    pub inertia_kg_m2: f64,
    /// Centre of mass in the body's frame, m.
    pub center_of_mass_m: Vec2,
    /// Dry friction torque of the pivot, N m.
    pub friction_torque_n_m: f64,
    /// Viscous friction of the pivot, N m s/rad.
    pub viscous_n_m_s: f64,
    /// Growth of its dry friction while it sticks; `None`: none.
    pub dwell: Option<Dwell>,
    /// Whether the hinge is a bend (or the far end of a bushing's arm): this body and what it is hinged on are pieces
    /// of one part, and the hinge represents its bending.
    pub is_bend: bool,
    /// Range of its angle against the body that carries it, from the drawn pose, rad counter-clockwise: the lowest and
    /// the highest. It moves nothing: a run that goes further cannot be trusted ([`crate::trust`]). `None`: not
    /// known.
    pub turn_rad: Option<[f64; 2]>,
}

/// A torsion spring at the pivot of `body`: torque on the body `torque - stiffness (relative angle - as drawn)`,
/// counter-clockwise positive, and its opposite on what the body is hinged on.
#[derive(Debug, Clone, PartialEq)]
pub struct Spring {
    /// Identifier.
    pub name: String,
    /// The hinged body (child) it acts on.
    pub body: usize,
    /// Torque as drawn, N m, counter-clockwise positive on `body`.
    pub torque_n_m: f64,
    /// Stiffness, N m/rad.
    pub stiffness_n_m_per_rad: f64,
}

/// A string between two supports. [`crate::strings`] says what its numbers do.
#[derive(Debug, Clone, PartialEq)]
pub struct PianoString {
    /// Identifier, e.g. `left`.
    pub name: String,
    /// Speaking length, m.
    pub length_m: f64,
    /// Mass per length, kg/m.
    pub mass_kg_m: f64,
    /// Tension, N.
    pub tension_n: f64,
    /// Bending stiffness EI, N m2.
    pub bending_n_m2: f64,
    /// b1, 1/s: the decay of amplitudes, sigma = b1 + b3 omega^2.
    pub loss_per_s: f64,
    /// b3, s.
    pub loss_s: f64,
    /// Striking point of the hammer, m from one end.
    pub strike_m: f64,
    /// Damper on the string; `None` without one.
    pub damper: Option<DamperFelt>,
}

/// The felt of a damper on a string.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DamperFelt {
    /// The zone between damper and string.
    pub zone: usize,
    /// Its middle, m from the end that the strike is counted from.
    pub middle_m: f64,
    /// Its length along the string, m.
    pub length_m: f64,
}

/// A mode of the soundboard where the strings of a note end.
#[derive(Debug, Clone, PartialEq)]
pub struct BridgeMode {
    /// Identifier.
    pub name: String,
    /// Its mass, referred to the bridge there, kg.
    pub mass_kg: f64,
    /// Its frequency, Hz.
    pub frequency_hz: f64,
    /// Its loss factor: amplitudes decay as exp(-loss_factor omega t / 2).
    pub loss_factor: f64,
}

/// A felt between two curves.
#[derive(Debug, Clone, PartialEq)]
pub struct Zone {
    /// Identifier, e.g. `let_off_button`; the stem of the run's columns.
    pub name: String,
    /// A line for people, e.g. `jack toe - let-off button`.
    pub label: String,
    /// Side A: always a disc (radius 0 is a point). `None` is the ground.
    pub disc_body: Option<usize>,
    /// Disc centre in its body's frame, m.
    pub disc_center_m: Vec2,
    /// Disc radius, m.
    pub disc_radius_m: f64,
    /// Side B's body; `None` is the ground.
    pub curve_body: Option<usize>,
    /// Side B's curve in its body's frame.
    pub curve: Curve,
    /// Felt law.
    pub felt: Felt,
    /// Coulomb friction coefficient; 0 is none.
    pub friction_coefficient: f64,
    /// Growth of its friction while it sticks; `None`: none.
    pub dwell: Option<Dwell>,
}

/// Dry friction that grows while it sticks, and is lost when it slips ([`moreau::Dwell`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dwell {
    /// Static over kinetic friction, at least 1.
    pub ratio: f64,
    /// tau, s.
    pub time_s: f64,
}

/// The other side of a zone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Curve {
    /// Half plane: the wood lies below, the unit `normal` points out of it.
    Line {
        /// A point of the line, m.
        point_m: Vec2,
        /// Outward unit normal.
        normal: Vec2,
    },
    /// A segment with round edges (a stadium of the given radius about the core segment): it ends, so that a disc can
    /// slip off.
    Segment {
        /// One end of the core, m.
        from_m: Vec2,
        /// The other end of the core, m.
        to_m: Vec2,
        /// Rounding radius, m.
        rounding_m: f64,
    },
    /// A disc.
    Disc {
        /// Centre, m.
        center_m: Vec2,
        /// Radius, m.
        radius_m: f64,
    },
}

/// k g^r and a loss ([`moreau::Loss`]), never pulling.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Felt {
    /// k, N/m^r.
    pub stiffness: f64,
    /// r, at least 1.
    pub exponent: f64,
    /// Law of its energy loss.
    pub loss: Loss<f64>,
    /// Thickness of what is compressed, of both sides together, m. It moves nothing: a run that presses it deeper
    /// cannot be trusted ([`crate::trust`]). `None`: not known.
    pub thickness_m: Option<f64>,
}

impl Felt {
    /// Multiplies its loss, whichever law it has; parts of a whole stay below one.
    pub fn scale_loss(&mut self, factor: f64) {
        const MOST: f64 = 0.99;
        let mut table = self.loss.table().iter();
        self.loss = self.loss.map(|x| match table.next() {
            Some(number) if number.is_loss => match number.range {
                Range::Part | Range::InnerPart if factor == 1.0 => x,
                Range::Part | Range::InnerPart => (x * factor).min(MOST),
                _ => x * factor,
            },
            _ => x,
        });
    }

    /// The first number that says how much it loses, with its value in SI units, if its law has one.
    pub fn first_loss(&self) -> Option<(&'static LawNumber, f64)> {
        self.loss.table().iter().zip(self.loss.numbers()).find(|(number, _)| number.is_loss)
    }

    /// Takes all its force away.
    pub fn remove(&mut self) {
        *self = Felt { exponent: self.exponent, thickness_m: self.thickness_m, ..Felt::default() };
    }
}

/// Roles of the parts, as indices into [`Instrument::bodies`] and [`Instrument::zones`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Roles {
    /// The body that the finger presses.
    pub key: Option<usize>,
    /// Point at which the finger presses, in the key's frame, m.
    pub key_front_m: Vec2,
    /// Whether the key is a sharp, for drawings only.
    pub is_sharp: bool,
    /// The body whose speed is the result.
    pub hammer: Option<usize>,
    /// The strike point, in the hammer's frame, m.
    pub hammer_head_m: Vec2,
    /// Key front punching: key bottom.
    pub key_bottom: Option<usize>,
    /// Hammer - string.
    pub string: Option<usize>,
    /// Whether the string stands still although strings are described.
    pub rigid_string: bool,
    /// Whether the bridge stands still although its modes are described.
    pub rigid_bridge: bool,
    /// Damper lever - the rail that the sustain pedal lifts.
    pub pedal: Option<usize>,
    /// Jack toe - let-off button.
    pub let_off: Option<usize>,
    /// Zones that push the hammer up (jack - knuckle, lever - knuckle).
    pub knuckle: Vec<usize>,
    /// Hammer tail - back check.
    pub check: Option<usize>,
    /// One-degree-of-freedom model: the zones that tie the other bodies to the key at rest.
    pub transmits: Vec<usize>,
    /// One-degree-of-freedom model: the key's own stops.
    pub stops: Vec<usize>,
}

/// The fingertip between the driver and the key: a spring and a damper in parallel that can only push.
/// Zero on an instrument without a key.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Finger {
    /// N/m.
    pub stiffness_n_per_m: f64,
    /// N s/m.
    pub damping_n_s_per_m: f64,
}

/// A regulating screw.
#[derive(Debug, Clone, PartialEq)]
pub struct Screw {
    /// Identifier, e.g. `capstan_height`.
    pub name: String,
    /// Effect of a positive setting, for people, e.g. `raises the capstan: less lost motion`.
    pub label: String,
    /// The action of the screw: the number that it moves.
    pub action: ScrewAction,
    /// Setting: travel from the drawn geometry, in the screw's own unit (m, rad or N m).
    pub setting: f64,
}

/// Effect of a screw.
#[derive(Debug, Clone, PartialEq)]
pub enum ScrewAction {
    /// Moves one side of a zone by `setting` metres along a unit direction in the frame of that side's body.
    Disc {
        /// Zone.
        zone: usize,
        /// Unit direction of a positive setting.
        direction: Vec2,
    },
    /// As [`ScrewAction::Disc`] for side B's curve.
    Curve {
        /// Zone.
        zone: usize,
        /// Unit direction of a positive setting.
        direction: Vec2,
    },
    /// Turns side B's curve by `setting` radians, counter-clockwise: a line about its point, a segment about its
    /// middle.
    Turn {
        /// Zone.
        zone: usize,
    },
    /// Adds `setting` N m, times the sign of the spring's own torque, to a spring's torque.
    Spring {
        /// Spring.
        spring: usize,
    },
}

/// A piece of wood, felt, leather or metal, for drawings only.
#[derive(Debug, Clone, PartialEq)]
pub struct Part {
    /// Name of the part, e.g. `hammer head`.
    pub name: String,
    /// The body that carries it; `None` is the ground.
    pub body: Option<usize>,
    /// Material of the part, which gives its colour.
    pub material: Material,
    /// Closed polygon in the body's frame, m.
    pub outline_m: Vec<Vec2>,
    /// Whether the polygon's corners are rounded off into a smooth curve when drawn.
    pub smooth: bool,
}

/// Materials that a part can be made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Material {
    /// Key sticks, whippens, shanks, mouldings.
    Wood,
    /// Rails and other wood that does not move.
    DarkWood,
    /// Felt.
    Felt,
    /// Bushing and rail cloth.
    Cloth,
    /// Leather: knuckle, back check.
    Leather,
    /// Capstans, screws, wires, brackets.
    Metal,
    /// Leads in the key.
    Lead,
    /// Key tops.
    Ivory,
    /// The string.
    String,
}

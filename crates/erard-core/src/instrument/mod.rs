//! The instrument: a piano action in SI units, checked, and independent of the file that it was read from.
//!
//! World frame at rest: x toward the back of the piano, y up, angles counter-clockwise; metres, kilograms, seconds,
//! newtons, radians. Every body carries a frame of its own with the origin at its pivot; all geometry on a body is
//! given in that frame, all geometry on the ground in the world frame.
//!
//! `format` defines the file, `file` reads it, `convert` checks it and converts it to the types below, and `provenance`
//! keeps the source of every number. `bends` joins the pieces of parts that bend, `screws` turns the regulating screws,
//! `rewrite` writes their settings back to the file, and `edit` changes numbers in its text.

// Hidden modules are the reader that all kinds of files share, the linkage files of `erard-kinematics` included. They
// are no stable interface for others.
mod bends;
mod board;
mod bushing;
mod checked;
pub(crate) mod convert;
pub(crate) mod edit;
#[doc(hidden)]
pub mod error;
mod felt;
#[doc(hidden)]
pub mod file;
mod file_number;
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

pub(crate) use board::{Band, Random};
pub use bushing::Bushing;
pub use checked::InvalidInstrument;
pub use error::FileError;
pub use file::{InstrumentFile, MAX_FILE_BYTES, UnknownInstrument, file_bytes, utf8};
pub use file_number::FileNumber;
pub use numbers::{numbers_at, numbers_at_each, with_numbers};
pub use outlived::OutlivedNote;
pub use placement::Placement;
pub use provenance::{Certainty, Citation, CitedNumber, Provenance, Source, Spread};
pub use rewrite::{RewriteError, cited};
pub use schema::json_schema;
pub(crate) use tuning::{REACH_HZ, STEEL_DENSITY_KG_M3};

use moreau::{LawNumber, Loss, Range};
use thiserror::Error;

use crate::key::{KEYS, UnknownKey, note_name};

/// Largest number of bodies of an instrument: the engine's capacity.
pub(crate) const MAX_BODIES: usize = 12;
/// Largest number of zones of an instrument: the engine's capacity.
pub(crate) const MAX_ZONES: usize = 32;
/// Largest number of springs of an instrument.
pub(crate) const MAX_SPRINGS: usize = 24;
/// Largest number of strings of a note.
pub(crate) const MAX_STRINGS: usize = 3;
/// Largest number of modes of a bridge.
pub(crate) const MAX_BRIDGE_MODES: usize = 512;
/// Largest number of regulating screws of an instrument.
pub(crate) const MAX_SCREWS: usize = 64;
/// Largest number of drawn parts of an instrument.
pub(crate) const MAX_PARTS: usize = 512;
/// Largest number of corners of one outline.
pub(crate) const MAX_CORNERS: usize = 4096;

/// A point or direction in a plane, `[x, y]`, metres (or dimensionless for directions).
pub type Vec2 = [f64; 2];

/// A checked instrument: every index is in range. It is read like its [`InstrumentFields`], and changed by
/// [`Instrument::edit`], which checks again, so no safe call can index out of bounds.
///
/// ```compile_fail
/// # let mut grand = erard_core::Instrument::builtin("concert-grand").unwrap();
/// grand.springs[0].body = 99;
/// ```
///
/// Numbers that a file gave are finite and in their ranges. Those that a program writes are checked where the
/// instrument enters the engine ([`moreau::ModelError`]).
#[derive(Debug, Clone, PartialEq)]
pub struct Instrument {
    // Within this crate, whoever writes here keeps the indices in range.
    pub(crate) fields: InstrumentFields,
}

impl std::ops::Deref for Instrument {
    type Target = InstrumentFields;

    fn deref(&self) -> &InstrumentFields {
        &self.fields
    }
}

/// The fields of an instrument, before they are checked by [`Instrument::new`] or [`Instrument::edit`].
#[derive(Debug, Clone, PartialEq)]
pub struct InstrumentFields {
    /// Name shown in summaries, e.g. `Concert grand, C4`.
    pub name: String,
    /// Gravity, m/s2, pointing toward -y.
    pub gravity_m_per_s2: f64,
    /// Bodies; a parent always precedes its children.
    pub bodies: Vec<Body>,
    /// Torsion springs between a body and the one that carries its hinge.
    pub springs: Vec<Spring>,
    /// Contact zones.
    pub zones: Vec<Zone>,
    /// Modal strings of one note, which the hammer strikes. Empty: the string is rigid.
    pub strings: Vec<PianoString>,
    /// Modes of the bridge at the strings' ends. Empty: the bridge is rigid.
    pub bridge_modes: Vec<BridgeMode>,
    /// Roles of bodies and zones; `None` where the instrument has no such part.
    pub roles: Roles,
    /// The fingertip.
    pub finger: Finger,
    /// The regulating screws (already applied to `zones` and `springs`).
    pub screws: Vec<Screw>,
    /// Outlines for drawing only; they take no part in the mechanics.
    pub parts: Vec<DrawnPart>,
    /// Which key of a piano it is, and which sample.
    pub origin: Origin,
}

/// Which key of a piano an instrument is, and which random sample of its file. It takes no part in the mechanics;
/// every copy, change, reduction and file of the instrument keeps it.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Origin {
    pub(crate) key: Option<usize>,
    pub(crate) sample: Option<u32>,
}

/// Why an instrument is not the instrument of a key.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum KeyError {
    /// No key of a piano.
    #[error(transparent)]
    Unknown(#[from] UnknownKey),
    /// It is the instrument of another key.
    #[error("found key {found} ({}); the instrument is that of key {own} ({})", note_name(*.found), note_name(*.own))]
    Another {
        /// Its own key.
        own: usize,
        /// The key found.
        found: usize,
    },
}

impl Instrument {
    /// Number of the key of the piano that this is, 1 (A0) to 88 (C8); `None` if that is not known.
    #[must_use]
    pub fn key(&self) -> Option<usize> {
        self.origin.key
    }

    /// Number of the random sample of its file that this is, from 1; `None` for the file's own instrument.
    #[must_use]
    pub fn sample(&self) -> Option<u32> {
        self.origin.sample
    }

    /// States which key of the piano an instrument is that does not know it.
    ///
    /// # Errors
    /// [`KeyError`]: no key of a piano, or another than the instrument's own.
    pub fn set_key(&mut self, key: usize) -> Result<(), KeyError> {
        if !(1..=KEYS).contains(&key) {
            return Err(UnknownKey { found: key.to_string() }.into());
        }
        match self.origin.key {
            Some(own) if own != key => Err(KeyError::Another { own, found: key }),
            _ => {
                self.fields.origin.key = Some(key);
                Ok(())
            }
        }
    }
}

/// One hinged rigid body.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// Identifier, e.g. `whippen`; names of a run's columns begin with it.
    pub name: String,
    /// Index of the body it is hinged on; `None` is the ground.
    pub parent: Option<usize>,
    /// Pivot in the parent's frame (the world frame for the ground), m.
    pub pivot_m: Vec2,
    /// Angle of the body's frame against the world as drawn, rad: the starting guess for the equilibrium.
    pub angle_rad: f64,
    /// Mass, kg, positive.
    pub mass_kg: f64,
    /// Moment of inertia about the pivot, kg m2; at least the mass times the squared distance from the pivot to the
    /// centre of mass.
    pub inertia_kg_m2: f64,
    /// Centre of mass in the body's frame, m.
    pub center_of_mass_m: Vec2,
    /// Dry friction torque of the pivot, N m.
    pub friction_torque_n_m: f64,
    /// Viscous friction of the pivot, N m s/rad.
    pub viscous_n_m_s: f64,
    /// Growth of the dry friction while the pivot sticks; `None`: it does not grow.
    pub dwell: Option<Dwell>,
    /// Whether the hinge represents the bending of a part: this body and the one that carries its hinge are pieces of
    /// that part. Also true of the arm that represents a bushing.
    pub is_bend: bool,
    /// Range of angle that the stops allow, lowest and highest, rad counter-clockwise from the drawn pose and relative
    /// to the body that carries the hinge. It does not affect the motion: a run that exceeds it cannot be trusted
    /// ([`crate::trust`]). `None`: not known.
    pub turn_rad: Option<[f64; 2]>,
}

/// A torsion spring at the pivot of `body`: torque on the body `torque - stiffness (relative angle - as drawn)`,
/// counter-clockwise positive. The opposite torque acts on the body that carries the hinge.
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

/// A modal string between a fixed support and the bridge; [`crate::strings`] has its equations.
#[derive(Debug, Clone, PartialEq)]
pub struct PianoString {
    /// Identifier, e.g. `left`.
    pub name: String,
    /// Speaking length, m.
    pub length_m: f64,
    /// Mass per length, kg/m.
    pub mass_kg_per_m: f64,
    /// Tension, N.
    pub tension_n: f64,
    /// Bending stiffness EI, N m2.
    pub bending_n_m2: f64,
    /// Loss b1, 1/s: amplitudes decay at the rate sigma = b1 + b3 omega^2.
    pub loss_per_s: f64,
    /// Loss b3, s.
    pub loss_s: f64,
    /// Striking point of the hammer, m from the end opposite the bridge.
    pub strike_m: f64,
    /// The string's part of the hammer's force, as a weight: each gets its own over the sum of all.
    pub strike_share: f64,
    /// Angle between the blow and the direction in which the damper presses, rad: the string then also moves across the
    /// blow. `None`: it moves in one direction only.
    pub strike_angle_rad: Option<f64>,
    /// Damper on the string; `None` without one.
    pub damper: Option<DamperFelt>,
}

/// The felt of a damper on a string.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DamperFelt {
    /// Index of the zone between damper and string.
    pub zone: usize,
    /// Middle of the felt, m from the end from which `strike_m` is measured.
    pub middle_m: f64,
    /// Length of the felt along the string, m.
    pub length_m: f64,
}

/// A vibration mode of the soundboard at the bridge, where the strings of a note end.
#[derive(Debug, Clone, PartialEq)]
pub struct BridgeMode {
    /// Identifier.
    pub name: String,
    /// Mass of the mode, kg, referred to the vertical motion of the bridge where the strings end.
    pub mass_kg: f64,
    /// Frequency of the mode, Hz.
    pub frequency_hz: f64,
    /// Loss factor of the mode: amplitudes decay as exp(-loss_factor omega t / 2).
    pub loss_factor: f64,
    /// Horizontal motion of the bridge per metre of vertical motion: across the blow.
    pub horizontal: f64,
}

/// A contact zone: a felt between two curves.
#[derive(Debug, Clone, PartialEq)]
pub struct Zone {
    /// Identifier, e.g. `let_off_button`; names of a run's columns begin with it.
    pub name: String,
    /// Label for people, on one line, e.g. `jack toe - let-off button`.
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
    /// Growth of the friction while the surfaces stick; `None`: it does not grow.
    pub dwell: Option<Dwell>,
}

/// Dry friction that grows from kinetic to static while the surfaces stick; slipping resets it ([`moreau::Dwell`]).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dwell {
    /// Ratio of static to kinetic friction, at least 1.
    pub ratio: f64,
    /// Time constant tau of the growth, s.
    pub time_s: f64,
}

/// Side B of a zone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Curve {
    /// Half plane: the wood lies below, the unit `normal` points out of it.
    Line {
        /// A point of the line, m.
        point_m: Vec2,
        /// Outward unit normal.
        normal: Vec2,
    },
    /// A segment with rounded ends: a stadium of the given radius about the core segment. A disc can slip off its ends.
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

/// A felt's force law for the compression g, m: the spring k g^r and a loss ([`moreau::Loss`]). The force never pulls.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Felt {
    /// Stiffness k, N/m^r.
    pub stiffness: f64,
    /// Exponent r, at least 1.
    pub exponent: f64,
    /// Law of its energy loss.
    pub loss: Loss<f64>,
    /// Thickness of felt, cloth or leather, of both sides together, m. It does not affect the motion: a run that
    /// compresses the felt by more cannot be trusted ([`crate::trust`]). `None`: not known.
    pub thickness_m: Option<f64>,
}

impl Felt {
    /// Multiplies the felt's loss parameters by `factor`, whichever law it has. Parameters that are fractions stay
    /// below 1.
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

    /// Returns the first loss parameter of the felt's law with its value in SI units; `None` if the law has none.
    pub fn first_loss(&self) -> Option<(&'static LawNumber, f64)> {
        self.loss.table().iter().zip(self.loss.numbers()).find(|(number, _)| number.is_loss)
    }

    /// Removes the felt's force: stiffness and loss become zero.
    pub fn remove(&mut self) {
        *self = Felt { exponent: self.exponent, thickness_m: self.thickness_m, ..Felt::default() };
    }
}

/// Roles of the parts, as indices into [`InstrumentFields::bodies`] and [`InstrumentFields::zones`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Roles {
    /// The body that the finger presses.
    pub key: Option<usize>,
    /// Point at which the finger presses, in the key's frame, m.
    pub key_front_m: Vec2,
    /// Whether the key is a sharp, for drawings only.
    pub is_sharp: bool,
    /// The hammer: the body whose strike point's speed is reported.
    pub hammer: Option<usize>,
    /// The strike point, in the hammer's frame, m.
    pub hammer_strike_point_m: Vec2,
    /// Zone that stops the key at the bottom of its travel: the key front punching.
    pub key_bottom: Option<usize>,
    /// Zone between hammer and string.
    pub string: Option<usize>,
    /// Whether the string is rigid in spite of [`InstrumentFields::strings`].
    pub rigid_string: bool,
    /// Whether the bridge is rigid in spite of [`InstrumentFields::bridge_modes`].
    pub rigid_bridge: bool,
    /// Zone between the damper lever and the rail that the sustain pedal lifts.
    pub pedal: Option<usize>,
    /// Zone between jack toe and let-off button.
    pub let_off: Option<usize>,
    /// Zones that push the hammer up (jack - knuckle, lever - knuckle).
    pub knuckle: Vec<usize>,
    /// Zone between hammer tail and back check.
    pub check: Option<usize>,
    /// One-degree-of-freedom model: zones that are closed at rest and make the other bodies follow the key.
    pub transmits: Vec<usize>,
    /// One-degree-of-freedom model: zones that stop the key itself.
    pub stops: Vec<usize>,
}

/// The fingertip between the driver and the key: a spring and a damper in parallel that can only push.
/// Zero on an instrument without a key.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Finger {
    /// Stiffness, N/m.
    pub stiffness_n_per_m: f64,
    /// Damping, N s/m.
    pub damping_n_s_per_m: f64,
}

/// A regulating screw.
#[derive(Debug, Clone, PartialEq)]
pub struct Screw {
    /// Identifier, e.g. `capstan_height`.
    pub name: String,
    /// Effect of a positive setting, for people, e.g. `raises the capstan: less lost motion`.
    pub label: String,
    /// Action of the screw on a zone or a spring.
    pub action: ScrewAction,
    /// Setting, counted from the drawn geometry, in the SI unit of the action (m, rad or N m).
    pub setting: f64,
}

/// Effect of a screw.
#[derive(Debug, Clone, PartialEq)]
pub enum ScrewAction {
    /// Moves side A, the disc, by `setting` metres along a unit direction in the frame of its body.
    Disc {
        /// Index of the zone.
        zone: usize,
        /// Unit direction of a positive setting.
        direction: Vec2,
    },
    /// Moves side B, the curve, by `setting` metres along a unit direction in the frame of its body.
    Curve {
        /// Index of the zone.
        zone: usize,
        /// Unit direction of a positive setting.
        direction: Vec2,
    },
    /// Turns side B's curve by `setting` radians, counter-clockwise: a line about its point, a segment about its
    /// middle.
    Turn {
        /// Index of the zone.
        zone: usize,
    },
    /// Adds `setting` N m to the magnitude of a spring's torque; a positive setting tightens the spring.
    Spring {
        /// Index of the spring.
        spring: usize,
    },
}

/// A piece of wood, felt, leather or metal, for drawings only.
#[derive(Debug, Clone, PartialEq)]
pub struct DrawnPart {
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

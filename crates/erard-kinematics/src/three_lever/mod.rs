//! The piano's three levers (key, whippen with jack, hammer) as one linkage.
//!
//! The kinematic model of a piano action by Hirschkorn, Birkett and McPhee, with two contacts, capstan and knuckle,
//! each a prismatic and a revolute joint in series. A, B and C are the pivots of key, whippen and hammer; x points away
//! from the player, y up; angles are counter-clockwise:
//!
//! - `B - A = (L1, L5)` and `B - C = (L6, -L10)`;
//! - the capstan's contact is the point `(L3, -L4)` of the whippen; it slides on the
//!   line of the key at height `L2` along the surface normal, at distance `S1` along it;
//! - the knuckle's contact is the point `(L8, -L9)` of the hammer; it slides on the
//!   line of the whippen at height `-L7`, at distance `S2` in front of B.
//!
//! So `A + R(k)(L2, S1) = B + R(w)(L3, -L4)` and
//! `R(h)(L8, -L9) + R(w)(S2, L7) = (L6, -L10)`. Here `k` is the direction of the key
//! surface's *normal* (inclination plus 90 degrees), `w` and `h` are the angles of
//! whippen and shank. Lengths are signed; all are metres and radians.

mod discs;
mod exact;
mod moves;
mod pose;
mod stroke;
mod train;

pub use discs::{DiscLevers, Line, Touch};
pub use moves::{Move, Regulation};
pub use pose::{LeverArms, StrokePose};
pub use stroke::{Stroke, StrokeStop};
pub use train::{LeverTrain, Levers};

use crate::linkage::AssembleError;
use crate::linkage::Direction;
use crate::linkage::{BodyId, Length, Linkage};
use crate::linkage::{StartError, Stop};

/// Lengths L1 to L10 (metres, signed), as defined at the head of this module.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lengths {
    /// Distance along x from the key's pivot A to the whippen's pivot B.
    pub l1: f64,
    /// Height of the capstan's contact line along the key surface's normal.
    pub l2: f64,
    /// Position along x of the heel's contact in the whippen's frame (negative: in front of B).
    pub l3: f64,
    /// Depth of the heel's contact below B in the whippen's frame.
    pub l4: f64,
    /// Height of B over A, along y.
    pub l5: f64,
    /// Distance along x from the hammer's pivot C to B.
    pub l6: f64,
    /// Height of the jack's top above B in the whippen's frame, with reversed sign.
    pub l7: f64,
    /// Position of the knuckle's contact along the shank, from C.
    pub l8: f64,
    /// Depth of the knuckle's contact below the shank's axis.
    pub l9: f64,
    /// Height of C over B, along y.
    pub l10: f64,
}

impl Lengths {
    /// Returns L1 to L10 in order.
    #[must_use]
    pub fn to_array(self) -> [f64; 10] {
        [self.l1, self.l2, self.l3, self.l4, self.l5, self.l6, self.l7, self.l8, self.l9, self.l10]
    }
}

impl From<[f64; 10]> for Lengths {
    fn from([l1, l2, l3, l4, l5, l6, l7, l8, l9, l10]: [f64; 10]) -> Self {
        Lengths { l1, l2, l3, l4, l5, l6, l7, l8, l9, l10 }
    }
}

/// The three levers of one note: all numbers that the kinematics needs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThreeLever {
    /// Lengths L1 to L10 (m).
    pub lengths: Lengths,
    /// Distance from the key's pivot to the point where the finger presses (m, positive).
    pub key_front: f64,
    /// Key angle `k` at rest (rad): direction of the key surface's normal, π/2 for a level key.
    pub key_rest: f64,
    /// Strike point of the hammer head: along the shank from C, and above it (m).
    pub head: [f64; 2],
}

/// Lever whose angle is prescribed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Drive {
    /// The key, as pressed by a finger.
    #[default]
    Key,
    /// The hammer. Use it to find the key position for a given hammer position.
    Hammer,
}

/// Error: three levers cannot be put together.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ThreeLeverError {
    /// A dimension is infinite or not a number.
    #[error("{0} is not a finite number")]
    NotFinite(&'static str),
    /// The key's front arm is not positive (m).
    #[error("the key's front arm must be positive, not {0} m")]
    NoKeyFront(f64),
    /// The levers do not reach each other at a contact, at the given angle.
    #[error("the {contact} contact cannot be made at {lever} = {at:.6} rad: the levers do not reach")]
    OutOfReach {
        /// `capstan` or `knuckle`.
        contact: &'static str,
        /// Symbol of the given angle.
        lever: &'static str,
        /// Value of the given angle (rad).
        at: f64,
    },
    /// The hammer head cannot rise by the given height (m) on its arc.
    #[error("the hammer head cannot rise by {0} m: its arc ends below")]
    NoSuchRise(f64),
    /// The linkage could not be built.
    #[error(transparent)]
    Assemble(#[from] AssembleError),
    /// No rest pose was found.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The hammer could not move as far as requested.
    #[error(transparent)]
    Stop(#[from] Stop),
}

impl ThreeLever {
    /// Returns levers with the arms of a Yamaha C7F and the stack heights of a Steinway. No such instrument exists: its
    /// lengths were estimated from published arms and regulation (spread 112.5 mm, blow 46 mm). They are not the table
    /// of the action paper.
    #[must_use]
    pub fn c7f_like() -> Self {
        Self::estimated([205.23, 28.32, -63.00, 16.18, 44.50, 92.80, -48.37, 18.0, 9.8, 63.60], 265.0)
    }

    /// Returns levers with the arms of a Steinway O of 1906, otherwise as [`ThreeLever::c7f_like`].
    #[must_use]
    pub fn steinway_o_like() -> Self {
        Self::estimated([186.77, 26.62, -64.62, 17.88, 44.50, 92.80, -48.37, 18.0, 9.8, 63.60], 233.0)
    }

    fn estimated(lengths_mm: [f64; 10], front_mm: f64) -> Self {
        ThreeLever {
            lengths: Lengths::from(lengths_mm.map(|l| l * 1e-3)),
            key_front: front_mm * 1e-3,
            key_rest: std::f64::consts::FRAC_PI_2,
            head: [0.130, 0.048],
        }
    }

    /// Returns the levers as a linkage with the papers' symbols: bodies `k`, `w`, `h`, slidings `S1`, `S2`, lengths
    /// `L1` to `L10`. Its equations are derived from the graph.
    #[must_use]
    pub fn linkage(&self, drive: Drive) -> Linkage {
        let mut m = Linkage::new();
        let mut number = 0;
        let [l1, l2, l3, l4, l5, l6, l7, l8, l9, l10] = self.lengths.to_array().map(|metres| {
            number += 1;
            m.length(&format!("L{number}"), metres)
        });
        let [key, whippen, hammer] = on_pivots(&mut m, [l1, l5], [l6, l10], drive);

        let key_line = m.point(key, "capstan line", l2, Length::Zero);
        let heel = m.point(whippen, "heel contact", l3, -l4);
        m.contact("capstan", "S1", key_line, Direction::Y, heel);

        let jack_top = m.point(whippen, "jack top", Length::Zero, -l7);
        let knuckle = m.point(hammer, "knuckle contact", l8, -l9);
        m.contact("knuckle", "S2", jack_top, Direction::MINUS_X, knuckle);
        m
    }

    /// Assembles the levers at rest (`k = key_rest`).
    ///
    /// # Errors
    /// Returns an error if a dimension is infinite or NaN, the key's front arm is not positive, or the levers do not
    /// reach each other.
    pub fn assemble(&self) -> Result<LeverTrain, ThreeLeverError> {
        LeverTrain::new(Levers::Lengths(*self), Drive::Key)
    }

    pub(crate) fn check(&self) -> Result<(), ThreeLeverError> {
        const NAMES: [&str; 10] = ["L1", "L2", "L3", "L4", "L5", "L6", "L7", "L8", "L9", "L10"];
        let named = NAMES.into_iter().zip(self.lengths.to_array()).chain([
            ("the key's front arm", self.key_front),
            ("the key's rest angle", self.key_rest),
            ("the hammer head's position along the shank", self.head[0]),
            ("the hammer head's height above the shank", self.head[1]),
        ]);
        checked(named, self.key_front)
    }
}

/// Checks the named dimensions, and the key's front arm.
fn checked(named: impl IntoIterator<Item = (&'static str, f64)>, key_front: f64) -> Result<(), ThreeLeverError> {
    if let Some((name, _)) = named.into_iter().find(|(_, value)| !value.is_finite()) {
        return Err(ThreeLeverError::NotFinite(name));
    }
    if key_front <= 0.0 {
        return Err(ThreeLeverError::NoKeyFront(key_front));
    }
    Ok(())
}

/// Key, whippen and hammer on their pivots, one of them driven. B is seen from A, and C from B.
fn on_pivots(m: &mut Linkage, [l1, l5]: [Length; 2], [l6, l10]: [Length; 2], drive: Drive) -> [BodyId; 3] {
    let [key, whippen, hammer] =
        [("key", "k"), ("whippen", "w"), ("hammer", "h")].map(|(name, symbol)| m.body(name, symbol));
    let a = m.origin(m.ground());
    let b = m.point_from(a, "B", l1, l5);
    let c = m.point_from(b, "C", -l6, l10);
    m.revolute("key pivot", a, m.origin(key));
    m.revolute("whippen pivot", b, m.origin(whippen));
    m.revolute("hammer pivot", c, m.origin(hammer));
    m.prescribe_angle(if drive == Drive::Key { key } else { hammer });
    [key, whippen, hammer]
}

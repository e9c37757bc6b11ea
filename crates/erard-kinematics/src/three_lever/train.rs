//! Assembled levers, described by lengths or by discs.

use super::exact::Exact;
use super::{DiscLevers, Drive, LeverArms, Move, Regulation, StrokePose, ThreeLever, ThreeLeverError};
use crate::linkage::{CoordinateId, Linkage};
use crate::linkage::{LinkageMechanism, Pose};

/// Three levers, described by the papers' lengths or by the discs and lines of an instrument.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Levers {
    /// Lengths L1 to L10.
    Lengths(ThreeLever),
    /// Discs on straight lines.
    Discs(DiscLevers),
}

impl From<ThreeLever> for Levers {
    fn from(levers: ThreeLever) -> Self {
        Levers::Lengths(levers)
    }
}

impl From<DiscLevers> for Levers {
    fn from(levers: DiscLevers) -> Self {
        Levers::Discs(levers)
    }
}

/// The same of levers of either kind.
macro_rules! either {
    ($of:expr, $levers:ident => $what:expr) => {
        match $of {
            Levers::Lengths($levers) => $what,
            Levers::Discs($levers) => $what,
        }
    };
}

impl Levers {
    /// Returns the levers as a linkage. Its equations are derived from the graph.
    #[must_use]
    pub fn linkage(&self, drive: Drive) -> Linkage {
        either!(self, levers => levers.linkage(drive))
    }

    /// Assembles the levers at rest.
    ///
    /// # Errors
    /// Returns an error if a dimension is infinite or NaN, the key's front arm is not positive, or the levers do not
    /// reach each other.
    pub fn assemble(&self) -> Result<LeverTrain, ThreeLeverError> {
        LeverTrain::new(*self, Drive::Key)
    }

    /// Returns these levers after `moves`, regulated once at the end.
    ///
    /// # Errors
    /// Returns an error if the levers do not reach each other before or after the moves.
    pub fn moved(&self, moves: &[Move], regulation: Regulation) -> Result<Levers, ThreeLeverError> {
        Ok(either!(self, levers => levers.moved(moves, regulation)?.into()))
    }

    /// Radius from the key's pivot to where the finger presses (m).
    #[must_use]
    pub(crate) fn key_front(&self) -> f64 {
        either!(self, levers => levers.key_front)
    }

    /// `k` at rest (rad).
    #[must_use]
    pub(crate) fn key_rest(&self) -> f64 {
        either!(self, levers => levers.key_rest)
    }

    /// Strike point in the hammer's frame (m).
    #[must_use]
    pub(crate) fn head(&self) -> [f64; 2] {
        either!(self, levers => levers.head)
    }

    /// Returns the position of the hammer's pivot C relative to the key's pivot A (m).
    #[must_use]
    pub fn hammer_pivot(&self) -> [f64; 2] {
        match self {
            Levers::Lengths(ThreeLever { lengths: l, .. }) => [l.l1 - l.l6, l.l5 + l.l10],
            Levers::Discs(levers) => levers.hammer_pivot,
        }
    }

    /// Returns the six lever arms at a pose.
    #[must_use]
    pub fn lever_arms(&self, pose: &StrokePose) -> LeverArms {
        either!(self, levers => levers.lever_arms(pose))
    }

    fn check(&self) -> Result<(), ThreeLeverError> {
        either!(self, levers => levers.check())
    }

    fn exact(&self, k: f64) -> Result<Exact, ThreeLeverError> {
        either!(self, levers => levers.exact(k))
    }
}

/// Where the five symbols sit in a pose.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Places {
    pub k: CoordinateId,
    pub w: CoordinateId,
    pub h: CoordinateId,
    pub s1: CoordinateId,
    pub s2: CoordinateId,
}

/// Three assembled levers: the mechanism and its rest pose.
#[derive(Clone, Debug)]
pub struct LeverTrain {
    pub(super) levers: Levers,
    pub(super) mechanism: LinkageMechanism,
    pub(super) places: Places,
    pub(super) rest: Pose,
    /// Height of the strike point over C at rest.
    pub(super) rest_height: f64,
}

impl LeverTrain {
    pub(super) fn new(levers: Levers, drive: Drive) -> Result<LeverTrain, ThreeLeverError> {
        levers.check()?;
        let mechanism = levers.linkage(drive).assemble()?;
        let find = |symbol| mechanism.coordinate(symbol).expect("named in `linkage`");
        let places = Places { k: find("k"), w: find("w"), h: find("h"), s1: find("S1"), s2: find("S2") };
        let exact = levers.exact(levers.key_rest())?;
        let mut guess = mechanism.zero_pose();
        guess.set(places.k, levers.key_rest());
        guess.set(places.w, exact.w);
        guess.set(places.h, exact.h);
        guess.set(places.s1, exact.s1);
        guess.set(places.s2, exact.s2);
        let rest = mechanism.walk(guess)?.pose().clone();
        let (s, c) = rest.value(places.h).sin_cos();
        let [along, above] = levers.head();
        Ok(LeverTrain { levers, mechanism, places, rest_height: along * s + above * c, rest })
    }

    /// Returns the levers from which this was assembled.
    #[must_use]
    pub fn levers(&self) -> &Levers {
        &self.levers
    }

    /// Returns the height of the strike point at rest over the key's pivot A (m).
    #[must_use]
    pub fn rest_head_height(&self) -> f64 {
        self.levers.hammer_pivot()[1] + self.rest_height
    }
}

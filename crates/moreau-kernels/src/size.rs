//! Sizes that the engine is compiled for.

use moreau::Workspace;

use crate::{Lanes, OwnedDescription};

/// Size of the engine: the largest numbers of bodies B, zones Z and set-valued laws N.
///
/// A mechanism needs a law for every pivot with dry friction, every zone with Coulomb friction, every felt with a
/// set-valued loss, and the driven point. From eight bodies on, a size has room for two laws in every zone.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Size {
    /// One body, four zones.
    One,
    /// Six bodies, fourteen zones, ten laws: the papers' grand action.
    Six,
    /// Eight bodies, twenty zones.
    Eight,
    /// Nine bodies, twenty zones.
    Nine,
    /// Twelve bodies, thirty-two zones: the largest size.
    Most,
}

/// `with_size!(size, f, arguments)` calls `f::<B, Z, N>(arguments)` with the numbers of bodies, zones and laws of that
/// size.
macro_rules! with_size {
    ($size:expr, $f:ident, $($argument:expr),*) => {
        match $size {
            $crate::Size::One => $f::<1, 4, 6>($($argument),*),
            $crate::Size::Six => $f::<6, 14, 10>($($argument),*),
            $crate::Size::Eight => $f::<8, 20, 49>($($argument),*),
            $crate::Size::Nine => $f::<9, 20, 50>($($argument),*),
            $crate::Size::Most => $f::<12, 32, 77>($($argument),*),
        }
    };
}
pub(crate) use with_size;

/// One number for every body of the largest size.
pub type EveryBody = [f64; Size::Most.holds()[0]];

/// Workspace of six bodies, fourteen zones and ten set-valued laws ([`Size::Six`]).
pub type WorkspaceOfSix = Workspace<f64, 6, 14, 10>;

impl Size {
    /// All of them, the small ones first.
    pub(crate) const ALL: [Size; 5] = [Size::One, Size::Six, Size::Eight, Size::Nine, Size::Most];

    /// Returns the largest numbers of bodies, zones and set-valued laws.
    pub const fn holds(self) -> [usize; 3] {
        match self {
            Size::One => [1, 4, 6],
            Size::Six => [6, 14, 10],
            Size::Eight => [8, 20, 49],
            Size::Nine => [9, 20, 50],
            Size::Most => [12, 32, 77],
        }
    }

    /// Returns the smallest size that holds a mechanism. Returns [`Size::Most`] if none does; compiling the model then
    /// fails.
    pub fn of(description: &OwnedDescription) -> Self {
        let needed = [description.bodies.len(), description.zones.len(), description.borrowed().laws()];
        let fits = |size: &Size| needed.iter().zip(size.holds()).all(|(&needed, room)| needed <= room);
        Size::ALL.into_iter().find(fits).unwrap_or(Size::Most)
    }

    /// Returns the lanes that are compiled for this size, `wanted` or none. Each kind of lanes takes as long to compile
    /// as a whole library, so few are: six and nine bodies have four doubles and eight numbers of single precision,
    /// eight use those of nine, and the other sizes have none.
    pub fn lanes(self, wanted: Lanes) -> Lanes {
        match self {
            Size::One | Size::Most => Lanes::One,
            Size::Six | Size::Eight | Size::Nine => wanted,
        }
    }

    /// Returns the size in which lanes and derivatives of this size are compiled. A mechanism has the same bits in a
    /// larger size.
    pub(crate) fn in_lanes(self) -> Self {
        if self == Size::Eight { Size::Nine } else { self }
    }

    /// Returns whether lanes are compiled for this size.
    pub fn has_lanes(self) -> bool {
        self.lanes(Lanes::Four) != Lanes::One
    }
}

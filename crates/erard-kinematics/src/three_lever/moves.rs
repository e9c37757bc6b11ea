//! Moves of parts that a designer or technician can make.

use super::{ThreeLever, ThreeLeverError};

/// Move of a part (metres). Positive is away from the player and up, unless stated otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Move {
    /// Moves the capstan along the heel's underside, negative toward the player. The contact's place on the whippen,
    /// `L3`, changes; its depth `L4` stays. Toward the player, the key's arm becomes shorter and the whippen's heel arm
    /// longer.
    Capstan(f64),
    /// Moves the knuckle along the shank, negative toward the hammer's pivot: `L8`.
    Knuckle(f64),
    /// Raises the capstan: `L2`. Regulation undoes this move.
    CapstanHeight(f64),
    /// Thickens the heel cushion: `L4`.
    HeelDepth(f64),
    /// Thickens the knuckle, so that its contact is farther below the shank: `L9`.
    KnuckleDepth(f64),
    /// Lengthens the jack, so that its top is higher above the whippen's pivot: `-L7`.
    JackHeight(f64),
    /// Moves the whippen's pivot B by (x, y): `L1`, `L5`, `L6`, `L10`.
    WhippenPivot(f64, f64),
    /// Moves the hammer's pivot C by (x, y): `L6`, `L10`.
    HammerPivot(f64, f64),
}

/// Treatment of the capstan's height after a move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Regulation {
    /// The capstan is screwed until the hammer rests at its previous angle: `L2` is computed anew. Moved and unmoved
    /// levers are then compared at the same blow.
    #[default]
    Regulated,
    /// All other lengths stay, and the hammer may rest at another angle.
    AsMoved,
}

impl ThreeLever {
    /// Returns these levers after `moves`, regulated once at the end.
    ///
    /// # Errors
    /// Returns an error if the levers do not reach each other before or after the moves.
    pub fn moved(&self, moves: &[Move], regulation: Regulation) -> Result<ThreeLever, ThreeLeverError> {
        self.check()?;
        let mut moved = *self;
        for &part in moves {
            moved.make(part);
        }
        moved.check()?;
        if regulation == Regulation::Regulated {
            let h = self.exact(self.key_rest)?.h;
            let w = moved.whippen_under(h)?;
            [moved.lengths.l2, _] = moved.capstan_seen_from_key(moved.key_rest, w);
        }
        moved.exact(moved.key_rest)?;
        Ok(moved)
    }

    fn make(&mut self, part: Move) {
        let l = &mut self.lengths;
        match part {
            Move::Capstan(x) => l.l3 += x,
            Move::Knuckle(x) => l.l8 += x,
            Move::CapstanHeight(y) => l.l2 += y,
            Move::HeelDepth(y) => l.l4 += y,
            Move::KnuckleDepth(y) => l.l9 += y,
            Move::JackHeight(y) => l.l7 -= y,
            Move::WhippenPivot(x, y) => {
                l.l1 += x;
                l.l5 += y;
                l.l6 += x;
                l.l10 -= y;
            }
            Move::HammerPivot(x, y) => {
                l.l6 -= x;
                l.l10 += y;
            }
        }
    }
}

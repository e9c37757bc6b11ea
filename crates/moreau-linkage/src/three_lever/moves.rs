//! Moves of parts, as a designer or a technician makes them.

use super::{ThreeLever, ThreeLeverError};

/// A part moved (metres). Positive is away from the player and up, unless said otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Move {
    /// The capstan along the heel's underside, negative toward the player:
    /// the contact's place on the whippen, `L3`, moves; its depth `L4` stays. The key's
    /// arm shrinks and the whippen's heel arm grows when it goes toward the player.
    Capstan(f64),
    /// The knuckle along the shank, negative toward the hammer's pivot: `L8`.
    Knuckle(f64),
    /// The capstan screwed up: `L2`. Undone by regulation.
    CapstanHeight(f64),
    /// A thicker heel cushion: `L4`.
    HeelDepth(f64),
    /// A thicker knuckle: its contact farther below the shank: `L9`.
    KnuckleDepth(f64),
    /// A longer jack: its top higher over the whippen's pivot: `-L7`.
    JackHeight(f64),
    /// The whippen's pivot B, by (x, y): `L1`, `L5`, `L6`, `L10`.
    WhippenPivot(f64, f64),
    /// The hammer's pivot C, by (x, y): `L6`, `L10`.
    HammerPivot(f64, f64),
}

/// Height of the capstan after a move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Regulation {
    /// A technician screws the capstan until the hammer rests at the angle it had:
    /// `L2` is found anew. So moved and unmoved are compared at the same blow.
    #[default]
    Regulated,
    /// Everything else stays, and the hammer rests where it will.
    AsMoved,
}

impl ThreeLever {
    /// These levers with `moves` made, regulated once after all of them.
    ///
    /// # Errors
    /// If the levers do not reach each other, before the moves or after.
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

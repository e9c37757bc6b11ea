//! A design, the cases made from it by moving parts, and the summary of each.

use crate::three_lever::{LeverArms, LeverTrain, Levers, Move, Regulation, Stroke, StrokePose, ThreeLeverError};

/// Poses of the stroke that slidings are measured on: differences between neighbours are below a micrometre.
const DIGEST_STEPS: usize = 400;

/// Let-off. Moves do not change its height, because let-off is regulated relative to the string.
#[derive(Debug, Clone, PartialEq)]
pub struct LetOff {
    /// Height of the strike point above the key's pivot, m.
    pub head_height_m: f64,
    /// Name in figures: `let-off`, or `toe contact` for the point where the jack begins to escape.
    pub name: &'static str,
    /// Description for readers.
    pub what: String,
}

/// Three levers and their let-off.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// Name of the design.
    pub name: String,
    /// Levers, without moves.
    pub levers: Levers,
    /// Let-off; `None` if it is not defined.
    pub let_off: Option<LetOff>,
}

/// Design with some parts moved, assembled.
#[derive(Debug, Clone)]
pub struct Case {
    /// Assembled levers, after the moves.
    pub train: LeverTrain,
    /// Travel of the key's front at let-off, m; `None` if let-off cannot be reached or is not defined.
    pub let_off_key_m: Option<f64>,
}

/// Key position and leverage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Travel of the key's front from rest along its arc, m, positive down.
    pub key_m: f64,
    /// Upward speed of the strike point over the speed of the key's front.
    pub leverage: f64,
}

/// Summary of a case for a designer, from rest to let-off.
#[derive(Debug, Clone, PartialEq)]
pub struct Digest {
    /// Key position and leverage at rest.
    pub start: Spot,
    /// Key position and leverage half-way to let-off; `None` without let-off.
    pub middle: Option<Spot>,
    /// Key position and leverage at let-off; `None` without let-off.
    pub let_off: Option<Spot>,
    /// Largest sliding of capstan and heel from their contact at rest, m; 0 without let-off.
    pub capstan_sliding_m: f64,
    /// Total path of this sliding, forward and backward, m.
    pub capstan_way_m: f64,
    /// Largest sliding of knuckle and jack from their contact at rest, m; 0 without let-off.
    pub knuckle_sliding_m: f64,
    /// Total path of this sliding, forward and backward, m.
    pub knuckle_way_m: f64,
    /// The six classical lever arms at rest.
    pub arms: LeverArms,
}

impl Design {
    /// Returns the design after `moves`; without moves, the design itself.
    ///
    /// # Errors
    /// Returns an error if the levers do not reach each other at rest, before the moves or after.
    pub fn case(&self, moves: &[Move], regulation: Regulation) -> Result<Case, ThreeLeverError> {
        let levers = if moves.is_empty() { self.levers } else { self.levers.moved(moves, regulation)? };
        let train = levers.assemble()?;
        let let_off_key_m = self.let_off.as_ref().and_then(|let_off| {
            // Moved far enough, the hammer may rest above its let-off or never rise to it.
            let key = train.key_travel_at_rise(let_off.head_height_m - train.rest_head_height()).ok()?;
            (key > 0.0 && train.stroke(0.0, key, 1).stop.is_none()).then_some(key)
        });
        Ok(Case { train, let_off_key_m })
    }
}

impl Case {
    /// Returns the poses from key travel `from_m` to `to_m` (m) in `steps` equal steps, as far as they can be reached.
    #[must_use]
    pub fn stroke(&self, from_m: f64, to_m: f64, steps: usize) -> Stroke {
        self.train.stroke(from_m, to_m, steps)
    }

    /// Leverage at one key position; `None` where it cannot be reached.
    #[must_use]
    pub(crate) fn leverage_at(&self, key_m: f64) -> Option<Spot> {
        let pose = self.train.stroke(key_m, key_m, 0).poses.into_iter().next()?;
        Some(Spot { key_m, leverage: pose.leverage })
    }

    /// Returns the summary of the case.
    #[must_use]
    pub fn digest(&self) -> Digest {
        let rest = self.train.rest();
        let poses = self.let_off_key_m.map_or(Vec::new(), |key| self.stroke(0.0, key, DIGEST_STEPS).poses);
        let most = |sliding: fn(&StrokePose) -> f64| poses.iter().map(|p| sliding(p).abs()).fold(0.0, f64::max);
        let way = |sliding: fn(&StrokePose) -> f64| {
            poses.windows(2).map(|two| (sliding(&two[1]) - sliding(&two[0])).abs()).sum()
        };
        Digest {
            start: Spot { key_m: 0.0, leverage: rest.leverage },
            middle: self.let_off_key_m.and_then(|key| self.leverage_at(0.5 * key)),
            let_off: self.let_off_key_m.and_then(|key| self.leverage_at(key)),
            capstan_sliding_m: most(|p| p.capstan_sliding),
            capstan_way_m: way(|p| p.capstan_sliding),
            knuckle_sliding_m: most(|p| p.knuckle_sliding),
            knuckle_way_m: way(|p| p.knuckle_sliding),
            arms: self.train.levers().lever_arms(&rest),
        }
    }
}

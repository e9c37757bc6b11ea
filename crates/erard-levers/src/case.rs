//! A design, the cases made of it by moving parts, and what there is to say about each.

use moreau_linkage::three_lever::{
    LeverArms, LeverTrain, Levers, Move, Regulation, Stroke, StrokePose, ThreeLeverError,
};

/// Poses of the stroke that slidings are measured on: differences between neighbours are below a micrometre.
const DIGEST_STEPS: usize = 400;

/// Let-off. It stays at this height whatever is moved: let-off is regulated against the string.
#[derive(Debug, Clone, PartialEq)]
pub struct LetOff {
    /// Height of the strike point over the key's pivot, m.
    pub head_height_m: f64,
    /// Name in figures: `let-off`, or `toe contact`, where the jack begins to escape.
    pub name: &'static str,
    /// Description for people.
    pub what: String,
}

/// Three levers and where they let the hammer off.
#[derive(Debug, Clone, PartialEq)]
pub struct Design {
    /// Name.
    pub name: String,
    /// The levers, as they are.
    pub levers: Levers,
    /// Let-off; `None` where nothing says it.
    pub let_off: Option<LetOff>,
}

/// A design with some parts moved, put together.
#[derive(Debug, Clone)]
pub struct Case {
    /// The levers, moved and put together.
    pub train: LeverTrain,
    /// Travel of the key's front at let-off, m; `None` where it cannot be reached, or where nothing says what let-off
    /// is.
    pub let_off_key_m: Option<f64>,
}

/// Key position and leverage.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spot {
    /// Travel of the key's front since rest along its arc, m, down positive.
    pub key_m: f64,
    /// Upward speed of the strike point over the speed of the key's front.
    pub leverage: f64,
}

/// Summary of a case for a designer, from rest to let-off.
#[derive(Debug, Clone, PartialEq)]
pub struct Digest {
    /// At rest.
    pub start: Spot,
    /// Half-way down to let-off.
    pub middle: Option<Spot>,
    /// At let-off.
    pub let_off: Option<Spot>,
    /// Largest sliding of capstan and heel away from where they touch at rest, m; without let-off, 0.
    pub capstan_sliding_m: f64,
    /// Their whole way to and fro, m.
    pub capstan_way_m: f64,
    /// Largest sliding of knuckle and jack away from where they touch at rest, m.
    pub knuckle_sliding_m: f64,
    /// Their whole way to and fro, m.
    pub knuckle_way_m: f64,
    /// The six classical lever arms at rest.
    pub arms: LeverArms,
}

impl Design {
    /// The design with `moves` made; none of them is the design as it is.
    ///
    /// # Errors
    /// When the levers do not reach each other at rest.
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
    /// The poses from key travel `from_m` to `to_m`, as far as they can be reached.
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

    /// Summary of the case.
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

//! The stroke of a key: sliding, leverage and lever arms from pose to pose.

use super::{Drive, LeverTrain, Levers, ThreeLever, ThreeLeverError};
use crate::closed_form::{cosine_equation, wrap};
use crate::mechanism::Pose;
use crate::newton::NewtonReport;
use crate::walk::{Stop, Walk};

/// One pose of a stroke. Metres, radians.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StrokePose {
    /// Travel of the key's front since rest, along its arc, down positive.
    pub key: f64,
    /// Direction of the key surface's normal; grows as the key goes down.
    pub k: f64,
    /// Whippen.
    pub w: f64,
    /// Hammer shank.
    pub h: f64,
    /// Place of the capstan's contact along the key (from the key's pivot, toward the player).
    pub s1: f64,
    /// Place of the knuckle's contact along the whippen (from its pivot, toward the player).
    pub s2: f64,
    /// How far capstan and heel have slid along each other since rest: the change of `s1`,
    /// less what a disc has rolled (a contact point without a radius only slides).
    pub capstan_sliding: f64,
    /// The same of knuckle and jack, with `s2`.
    pub knuckle_sliding: f64,
    /// Rise of the strike point since rest, straight up, toward the string.
    pub head_rise: f64,
    /// Upward speed of the strike point over the speed of the key's front.
    pub leverage: f64,
    /// Speed of the strike point along its arc over the speed of the key's front.
    pub arc_leverage: f64,
    /// dw/dk: whippen angle over key angle, first order.
    pub whippen_ratio: f64,
    /// dh/dk: hammer angle over key angle, first order.
    pub hammer_ratio: f64,
    /// Largest closure residual over the largest length.
    pub residual: f64,
    /// Newton steps the pose took.
    pub iterations: usize,
}

/// Where a stroke had to stop.
#[derive(Clone, Debug, PartialEq)]
pub struct StrokeStop {
    /// Travel of the key's front there (m).
    pub key: f64,
    /// Why, in the linkage's own terms.
    pub stop: Stop,
}

/// The poses of a stroke, as far as it went.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// The levers at rest: where slidings and rises are counted from.
    pub rest: StrokePose,
    /// One pose per key position, in order.
    pub poses: Vec<StrokePose>,
    /// Where and why it stopped short, if it did.
    pub stop: Option<StrokeStop>,
}

/// The six classical lever arms (m): straight distances from a pivot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LeverArms {
    /// Key pivot to where the finger presses.
    pub key_front: f64,
    /// Key pivot to capstan contact.
    pub key_back: f64,
    /// Whippen pivot to heel (capstan) contact.
    pub whippen_heel: f64,
    /// Whippen pivot to jack (knuckle) contact.
    pub whippen_jack: f64,
    /// Hammer pivot to knuckle contact.
    pub hammer_knuckle: f64,
    /// Hammer pivot to strike point.
    pub hammer_head: f64,
}

impl LeverArms {
    /// key back / key front x whippen jack / heel x hammer head / knuckle: the
    /// technician's overall ratio (Overs; Delacour). It takes every force as
    /// square to its arm, so it is not the leverage, only near it.
    #[must_use]
    pub fn product(&self) -> f64 {
        self.key_back / self.key_front
            * (self.whippen_jack / self.whippen_heel)
            * (self.hammer_head / self.hammer_knuckle)
    }
}

impl ThreeLever {
    /// The six lever arms at a pose.
    #[must_use]
    pub fn lever_arms(&self, pose: &StrokePose) -> LeverArms {
        let l = &self.lengths;
        LeverArms {
            key_front: self.key_front,
            key_back: l.l2.hypot(pose.s1),
            whippen_heel: l.l3.hypot(l.l4),
            whippen_jack: pose.s2.hypot(l.l7),
            hammer_knuckle: l.l8.hypot(l.l9),
            hammer_head: self.head[0].hypot(self.head[1]),
        }
    }

    /// Height of the strike point over the hammer's pivot at shank angle `h` (m).
    #[must_use]
    pub fn head_height(&self, h: f64) -> f64 {
        let (s, c) = h.sin_cos();
        self.head[0] * s + self.head[1] * c
    }
}

impl LeverTrain {
    /// The levers at rest: key travel, slidings and rise are zero.
    #[must_use]
    pub fn rest(&self) -> StrokePose {
        let mut walk = self.start();
        self.read(&mut walk)
    }

    /// Presses the key's front from travel `from` to `to` (m, along its arc) in
    /// `steps` equal steps: `steps + 1` poses, the first at `from`, or as many as
    /// can be reached. Zero steps give the one pose at `from`.
    #[must_use]
    pub fn stroke(&self, from: f64, to: f64, steps: usize) -> Stroke {
        let mut poses = Vec::with_capacity(steps + 1);
        let stop = self.stroke_into(from, to, steps, &mut poses);
        Stroke { rest: self.rest(), poses, stop }
    }

    /// As [`LeverTrain::stroke`], into a vector that is emptied first and whose
    /// memory is used again.
    pub fn stroke_into(&self, from: f64, to: f64, steps: usize, poses: &mut Vec<StrokePose>) -> Option<StrokeStop> {
        poses.clear();
        let mut walk = self.start();
        for i in 0..=steps {
            let part = if steps == 0 { 0.0 } else { i as f64 / steps as f64 };
            let key = from + part * (to - from);
            if let Err(stop) = walk.advance(&[self.key_angle(key)]) {
                let key = self.key_travel(walk.pose());
                return Some(StrokeStop { key, stop });
            }
            poses.push(self.read(&mut walk));
        }
        None
    }

    /// Travel of the key's front (m) at which the strike point has risen by `rise`
    /// (m) since rest, taking the hammer as the driver: let-off, for example, is
    /// the blow distance minus the let-off distance.
    ///
    /// # Errors
    /// If the head cannot rise so far, or not while the contacts hold.
    pub fn key_travel_at_rise(&self, rise: f64) -> Result<f64, ThreeLeverError> {
        let rest = self.rest.value(self.places.h);
        let [along, above] = self.levers.head();
        let height = self.rest_height + rise;
        let h = cosine_equation(above, along, height)
            .map(|solutions| solutions.map(|h| rest + wrap(h - rest)))
            .map(|[a, b]| if (a - rest).abs() <= (b - rest).abs() { a } else { b })
            .ok_or(ThreeLeverError::NoSuchRise(rise))?;
        let driven = LeverTrain::new(self.levers, Drive::Hammer)?;
        let mut walk = driven.start();
        walk.advance(&[h])?;
        Ok(driven.key_travel(walk.pose()))
    }

    fn start(&self) -> Walk<'_> {
        (self.mechanism.walk(self.rest.clone())).expect("the rest pose was solved in `assemble`")
    }

    fn key_angle(&self, travel: f64) -> f64 {
        self.levers.key_rest() + travel / self.levers.key_front()
    }

    fn key_travel(&self, pose: &Pose) -> f64 {
        (pose.value(self.places.k) - self.levers.key_rest()) * self.levers.key_front()
    }

    fn read(&self, walk: &mut Walk<'_>) -> StrokePose {
        let NewtonReport { iterations, residual, .. } = walk.report();
        let at = self.places;
        let rates = walk.rates(&[1.0]);
        let (whippen_ratio, hammer_ratio) = (rates[at.w.0], rates[at.h.0]);
        let pose = walk.pose();
        let value = |id| pose.value(id);
        let since_rest = |id| pose.value(id) - self.rest.value(id);
        let h = value(at.h);
        let [c, s] = walk.cos_sin(at.h);
        let [along, above] = self.levers.head();
        let per_key_front = hammer_ratio / self.levers.key_front();
        let (capstan_rolling, knuckle_rolling) = match &self.levers {
            Levers::Lengths(_) => (0.0, 0.0),
            Levers::Discs(levers) => {
                let [k, w, h] = [at.k, at.w, at.h].map(since_rest);
                (levers.capstan.rolling(k, w), levers.knuckle.rolling(h, w))
            }
        };
        StrokePose {
            key: self.key_travel(pose),
            k: value(at.k),
            w: value(at.w),
            h,
            s1: value(at.s1),
            s2: value(at.s2),
            capstan_sliding: since_rest(at.s1) - capstan_rolling,
            knuckle_sliding: since_rest(at.s2) - knuckle_rolling,
            head_rise: along * s + above * c - self.rest_height,
            leverage: (along * c - above * s) * per_key_front,
            arc_leverage: along.hypot(above) * per_key_front,
            whippen_ratio,
            hammer_ratio,
            residual,
            iterations,
        }
    }
}

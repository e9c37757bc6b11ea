//! Stroke of a key: sliding, leverage and lever arms, pose by pose.

use super::{Drive, LeverArms, LeverTrain, Levers, StrokePose, ThreeLever, ThreeLeverError};
use crate::linkage::NewtonReport;
use crate::linkage::Pose;
use crate::linkage::closed_form::{cosine_equation, wrap};
use crate::linkage::{Stop, Walk};

/// Position and reason of an early stop of a stroke.
#[derive(Clone, Debug, PartialEq)]
pub struct StrokeStop {
    /// Travel of the key's front at the stop (m).
    pub key: f64,
    /// Reason, as the linkage reports it.
    pub stop: Stop,
}

/// Poses of a stroke, as far as they were reached.
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    /// Pose at rest, from which slidings and rises are measured.
    pub rest: StrokePose,
    /// One pose per key position, in order.
    pub poses: Vec<StrokePose>,
    /// Position and reason of an early stop; `None` if the stroke is complete.
    pub stop: Option<StrokeStop>,
}

impl ThreeLever {
    /// Returns the six lever arms at a pose.
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
}

impl LeverTrain {
    /// Returns the pose at rest: key travel, slidings and rise are zero.
    #[must_use]
    pub fn rest(&self) -> StrokePose {
        let mut walk = self.start();
        self.read(&mut walk)
    }

    /// Presses the key's front from travel `from` to `to` (m, along its arc) in `steps` equal steps. Returns `steps +
    /// 1` poses, the first at `from`, or as many as can be reached. With zero steps it returns the one pose at `from`.
    #[must_use]
    pub fn stroke(&self, from: f64, to: f64, steps: usize) -> Stroke {
        let mut poses = Vec::with_capacity(steps + 1);
        let stop = self.stroke_into(from, to, steps, &mut poses);
        Stroke { rest: self.rest(), poses, stop }
    }

    /// Computes a stroke as [`LeverTrain::stroke`] does, into a vector that is cleared first and whose memory is
    /// reused. Returns the early stop, if there was one.
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

    /// Returns the travel of the key's front (m) at which the strike point has risen by `rise` (m) from rest. The
    /// hammer is taken as the driver. For let-off, for example, `rise` is the blow distance minus the let-off distance.
    ///
    /// # Errors
    /// Returns an error if the head cannot rise so far, or the contacts open before.
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

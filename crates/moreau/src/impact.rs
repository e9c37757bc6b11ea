//! Instant and speed at which a tracked point hits a zone (a hammer its string), extrapolated from its motion just
//! before. Times are counted from step to step, so that single precision is as accurate after an hour as at the start.

use crate::model::Model;
use crate::pose::Pose;
use crate::real::{Real, Scalar};
use crate::tracking::{Clearance, TrackedPoint};

/// Impact of a tracked point on a zone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PointImpact<T> {
    /// Instant at which the compression becomes positive, s.
    pub time_s: f64,
    /// Total speed of the point along its path at that instant, m/s.
    pub speed: T,
    /// Normal part of this speed, toward the zone, m/s.
    pub normal_speed: T,
}

/// Where a mechanism is at an instant.
#[derive(Debug, Clone, Copy)]
struct Moment<T, const B: usize> {
    time_s: f64,
    angle: [T; B],
    velocity: [T; B],
}

/// The zone at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sample<T> {
    time_s: f64,
    /// Compression, m; negative apart.
    compression_m: T,
    /// Speed of the point, m/s.
    speed_m_per_s: T,
}

/// Predicts an impact from a point's flight. While the point is out of the zone's reach, an update costs one
/// comparison; results are unaffected, because the last two moments are kept.
#[derive(Debug, Clone)]
pub struct ImpactPredictor<T, const B: usize> {
    point: TrackedPoint<T, B>,
    zone: Option<usize>,
    open: Option<Clearance<T, B>>,
    skipped: [Option<Moment<T, B>>; 2],
    /// Where in `skipped` the next one goes.
    next: usize,
    before: Option<Sample<T>>,
    older: Option<Sample<T>>,
    impact: Option<PointImpact<T>>,
}

impl<T: Scalar, const B: usize> ImpactPredictor<T, B> {
    /// Returns a predictor for a point and a zone; without a zone there is never an impact.
    pub fn new(point: TrackedPoint<T, B>, zone: Option<usize>) -> Self {
        ImpactPredictor {
            point,
            zone,
            open: None,
            skipped: [None; 2],
            next: 0,
            before: None,
            older: None,
            impact: None,
        }
    }

    /// Returns the impact in the last step, if there was one.
    #[inline(always)]
    pub fn impact(&self) -> Option<PointImpact<T>> {
        self.impact
    }

    /// Returns the tracked point.
    #[inline(always)]
    pub fn point(&self) -> &TrackedPoint<T, B> {
        &self.point
    }

    /// Returns whether the zone was out of reach at the last update.
    pub fn is_far(&self) -> bool {
        self.open.is_some() && self.skipped.iter().any(Option::is_some)
    }

    /// Discards all samples. Call it after the mechanism was moved to another state.
    pub fn forget(&mut self) {
        (self.open, self.skipped, self.next) = (None, [None; 2], 0);
        (self.before, self.older, self.impact) = (None, None, None);
    }

    /// Adds the motion at an instant: time, s; absolute angles, rad; angular velocities, rad/s. Call it at the start
    /// and after every step.
    #[inline(always)]
    pub fn update<const Z: usize>(&mut self, model: &Model<T, B, Z>, time_s: f64, angle: &[T; B], velocity: &[T; B]) {
        let Some(zone) = self.zone else { return };
        self.impact = None;
        if self.open.as_ref().is_some_and(|open| open.holds(model, angle)) {
            self.skipped[self.next] = Some(Moment { time_s, angle: *angle, velocity: *velocity });
            self.next ^= 1;
            return;
        }
        self.update_closely(model, zone, &Moment { time_s, angle: *angle, velocity: *velocity });
    }

    #[cold]
    #[inline(never)]
    fn update_closely<const Z: usize>(&mut self, model: &Model<T, B, Z>, zone: usize, now: &Moment<T, B>) {
        for k in [self.next, self.next ^ 1] {
            if let Some(moment) = self.skipped[k].take() {
                self.sample(model, zone, &moment);
            }
        }
        self.impact = self.sample(model, zone, now);
        self.open = Clearance::of(model, zone, &now.angle).0;
    }

    fn sample<const Z: usize>(
        &mut self,
        model: &Model<T, B, Z>,
        zone: usize,
        now: &Moment<T, B>,
    ) -> Option<PointImpact<T>> {
        let [_, velocity] = self.point.motion(&now.angle, &now.velocity);
        let now = Sample {
            time_s: now.time_s,
            compression_m: Pose::of(model, &now.angle).compression(model, zone),
            speed_m_per_s: T::from_f64(libm::hypot(velocity[0].to_f64(), velocity[1].to_f64())),
        };
        let impact =
            self.before.filter(|before| before.compression_m <= T::ZERO && now.compression_m > T::ZERO).map(|before| {
                let flown = self.older.as_ref().and_then(|older| before.flight(older, &now));
                flown.unwrap_or_else(|| before.straight(&now))
            });
        self.older = self.before.replace(now);
        impact
    }

    /// Replaces the updates of a mechanism that stood still until `until_s` (s) in steps of `h` (s). The result is the
    /// same as after an update in each of these steps.
    pub fn unchanged(&mut self, until_s: f64, h: f64) {
        self.impact = None;
        let newest = [self.next ^ 1, self.next].into_iter().find_map(|k| self.skipped[k]);
        if let Some(moment) = newest {
            let [before, last] = [until_s - h, until_s].map(|time_s| Some(Moment { time_s, ..moment }));
            (self.skipped, self.next) = ([before, last], 0);
        } else if let Some(sample) = self.before {
            self.older = Some(Sample { time_s: until_s - h, ..sample });
            self.before = Some(Sample { time_s: until_s, ..sample });
        }
    }

    /// Returns the last two samples: instant, s; compression, m; speed, m/s (see [`ImpactPredictor::resume`]).
    pub fn samples<const Z: usize>(&self, model: &Model<T, B, Z>) -> [Option<[f64; 3]>; 2] {
        let Some(zone) = self.zone else { return [None; 2] };
        let mut now = self.clone();
        for k in [self.next, self.next ^ 1] {
            if let Some(moment) = &self.skipped[k] {
                now.sample(model, zone, moment);
            }
        }
        [now.older, now.before].map(|s| s.map(|s| [s.time_s, s.compression_m.to_f64(), s.speed_m_per_s.to_f64()]))
    }

    /// Continues from the samples that [`ImpactPredictor::samples`] returned.
    pub fn resume(&mut self, samples: [Option<[f64; 3]>; 2]) {
        self.forget();
        [self.older, self.before] = samples.map(|s| {
            s.map(|[time_s, compression_m, speed_m_per_s]| Sample {
                time_s,
                compression_m: T::from_f64(compression_m),
                speed_m_per_s: T::from_f64(speed_m_per_s),
            })
        });
    }
}

/// Returns instant (s) and speed (m/s) of the impact of a point that moves with constant acceleration, extrapolated
/// from two samples (instant, s; the zone's compression, m; speed, m/s), at the latest at `now_s`:
///
/// a = dv/dt, d = -g / (dg/dx), v^2 = v_b^2 + 2 a d, t = t_b + 2 d / (v_b + v)
///
/// with both slopes taken over the interval between the samples, g the zone's compression and x the point's path. The
/// state at the end of the impact's step is not used: the zone has pushed by then, which with steps of 200 us would
/// make a piano hammer's impact speed one percent too small. Returns `None` if the zone was touched at the older
/// sample, if the point did not approach, or if it would stop before the zone.
pub fn impact_in_flight<T: Scalar>([older, before]: [[T; 3]; 2], now_s: T) -> Option<[T; 2]> {
    let ([older_s, older_m, v0], [before_s, before_m, v1]) = (older, before);
    let last_s = before_s - older_s;
    let nearer = before_m - older_m;
    if older_m > T::ZERO || nearer <= T::ZERO {
        return None;
    }
    let (half, two) = (T::from_f64(0.5), T::from_f64(2.0));
    let distance_m = -before_m / nearer * half * (v0 + v1) * last_s;
    let square = v1 * v1 + two * (v1 - v0) / last_s * distance_m;
    if square <= T::ZERO {
        return None;
    }
    let speed_m_per_s = Real::sqrt(square);
    let flight_s = two * distance_m / (v1 + speed_m_per_s);
    Some([Real::min(before_s + flight_s, now_s), speed_m_per_s])
}

impl<T: Scalar> Sample<T> {
    /// The impact that follows if the point flies on as it did between `older` and here ([`impact_in_flight`]).
    fn flight(&self, older: &Sample<T>, now: &Sample<T>) -> Option<PointImpact<T>> {
        let after = |s: &Sample<T>| T::from_f64(s.time_s - self.time_s);
        let numbers = |s: &Sample<T>| [after(s), s.compression_m, s.speed_m_per_s];
        let [flight_s, speed] = impact_in_flight([numbers(older), numbers(self)], after(now))?;
        // The share of the path that led toward the zone in the step before.
        let last_s = T::from_f64(self.time_s - older.time_s);
        let path_m = T::from_f64(0.5) * (older.speed_m_per_s + self.speed_m_per_s) * last_s;
        let normal_speed = speed * (self.compression_m - older.compression_m) / path_m;
        let time_s = f64::min(self.time_s + flight_s.to_f64(), now.time_s);
        Some(PointImpact { time_s, speed, normal_speed })
    }

    /// The impact where the compression, running linearly from here to `now`, is zero; the speed runs linearly, too.
    fn straight(&self, now: &Sample<T>) -> PointImpact<T> {
        let (last_s, apart) = (T::from_f64(now.time_s - self.time_s), self.compression_m - now.compression_m);
        let share = self.compression_m / apart;
        PointImpact {
            time_s: self.time_s + (last_s * self.compression_m / apart).to_f64(),
            speed: self.speed_m_per_s + share * (now.speed_m_per_s - self.speed_m_per_s),
            normal_speed: (now.compression_m - self.compression_m) / last_s,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(time_s: f64, compression_m: f64, speed_m_per_s: f64) -> Sample<f64> {
        Sample { time_s, compression_m, speed_m_per_s }
    }

    /// A head thrown with 2 m/s and uniformly slowed: what the string did to it by the end of the step plays no part.
    #[test]
    fn a_uniformly_slowed_flight_is_met_exactly() {
        let (v, a, h) = (2.0, -30.0, 2e-4);
        // It starts 1 mm below; the string's compression grows by 0.98 of the path.
        let at = |t: f64| sample(t, 0.98 * (v * t + 0.5 * a * t * t - 1e-3), v + a * t);
        let [older, before] = [at(1.5 * h), at(2.2 * h)];
        let now = sample(3.2 * h, 5e-5, 1.5);
        let impact = before.flight(&older, &now).unwrap();
        // 1 mm = v t + a t^2/2.
        let t = (v - (v * v + 2.0 * a * 1e-3_f64).sqrt()) / -a;
        assert!((impact.time_s - t).abs() < 1e-15, "{} {t}", impact.time_s);
        assert!((impact.speed - (v + a * t)).abs() < 1e-12, "{}", impact.speed);
        assert!((impact.normal_speed - 0.98 * (v + a * t)).abs() < 1e-12, "{impact:?}");
        assert!(before.time_s < t && t < now.time_s);
    }

    /// Without a flight before it, as at the first step or while it bounces on the string, there is the straight line.
    #[test]
    fn no_flight_no_extrapolation() {
        let (older, before, now) = (sample(0.0, 1e-5, 1.0), sample(1e-3, -1e-5, 2.0), sample(2e-3, 1e-5, 3.0));
        assert_eq!(before.flight(&older, &now), None);
        // It would turn around before the string.
        let fast = sample(0.0, -3e-5, 20.0);
        assert_eq!(before.flight(&fast, &now), None);
        let impact = before.straight(&now);
        assert_eq!((impact.time_s, impact.speed), (1.5e-3, 2.5));
        assert!((impact.normal_speed - 0.02).abs() < 1e-15, "{impact:?}");
    }
}

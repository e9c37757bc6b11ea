//! Instant and speed of an impact: the marked point (an action's hammer) meets the marked zone (its string). Both are
//! predicted from the flight before.

use moreau::{Clearance, Model, Pose, Real, Scalar, TrackedPoint};

use crate::Probes;

/// An impact of the hammer on the string: of the marked point on the marked zone ([`Probes`]).
///
/// This is the one type that carries these numbers from the step that finds them to the report.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Impact {
    /// Instant at which the zone begins to be pressed, s.
    pub time_s: f64,
    /// Total speed of the point along its path at that instant, m/s.
    pub hammer_speed_m_per_s: f64,
    /// Its part along the zone's normal, toward the zone, m/s: how fast the compression begins to grow where what is
    /// pressed stands still.
    pub hammer_speed_normal_m_per_s: f64,
}

/// Where a mechanism is at an instant.
#[derive(Debug, Clone, Copy)]
struct Moment<const B: usize> {
    time_s: f64,
    angle: [f64; B],
    velocity: [f64; B],
}

/// The marked zone at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Sample {
    pub time_s: f64,
    /// Compression, m; negative apart.
    pub compression_m: f64,
    /// Speed of the point, m/s.
    pub speed_m_per_s: f64,
}

/// Predicts an impact from the marked point's flight. While the point is out of the zone's reach, an update costs one
/// comparison; results are unaffected, because the last two moments are kept.
#[derive(Debug, Clone)]
pub(crate) struct ImpactPredictor<const B: usize> {
    point: TrackedPoint<f64, B>,
    zone: Option<usize>,
    open: Option<Clearance<f64, B>>,
    skipped: [Option<Moment<B>>; 2],
    /// Where in `skipped` the next one goes.
    next: usize,
    before: Option<Sample>,
    older: Option<Sample>,
    impact: Option<Impact>,
}

impl<const B: usize> ImpactPredictor<B> {
    pub(crate) fn new<const Z: usize>(model: &Model<f64, B, Z>, probes: &Probes) -> Self {
        let (body, point) = probes.point.unwrap_or((moreau::GROUND, [0.0; 2]));
        ImpactPredictor {
            point: TrackedPoint::of(model, body, point),
            zone: probes.zone.filter(|_| probes.point.is_some()),
            open: None,
            skipped: [None; 2],
            next: 0,
            before: None,
            older: None,
            impact: None,
        }
    }

    /// The impact in the last step, if there was one.
    #[inline(always)]
    pub(crate) fn impact(&self) -> Option<Impact> {
        self.impact
    }

    /// The marked point.
    #[inline(always)]
    pub(crate) fn point(&self) -> &TrackedPoint<f64, B> {
        &self.point
    }

    /// Whether the zone was out of reach at the last update.
    pub(crate) fn is_far(&self) -> bool {
        self.open.is_some() && self.skipped.iter().any(Option::is_some)
    }

    /// Nothing is known any more: the mechanism was put somewhere else.
    pub(crate) fn forget(&mut self) {
        (self.open, self.skipped, self.next) = (None, [None; 2], 0);
        (self.before, self.older, self.impact) = (None, None, None);
    }

    /// Updates at the start, and after every step.
    #[inline(always)]
    pub(crate) fn update<const Z: usize>(
        &mut self,
        model: &Model<f64, B, Z>,
        time_s: f64,
        angle: &[f64; B],
        velocity: &[f64; B],
    ) {
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
    fn update_closely<const Z: usize>(&mut self, model: &Model<f64, B, Z>, zone: usize, now: &Moment<B>) {
        for k in [self.next, self.next ^ 1] {
            if let Some(moment) = self.skipped[k].take() {
                self.sample(model, zone, &moment);
            }
        }
        self.impact = self.sample(model, zone, now);
        self.open = Clearance::of(model, zone, &now.angle).0;
    }

    fn sample<const Z: usize>(&mut self, model: &Model<f64, B, Z>, zone: usize, now: &Moment<B>) -> Option<Impact> {
        let [_, velocity] = self.point.motion(&now.angle, &now.velocity);
        let now = Sample {
            time_s: now.time_s,
            compression_m: Pose::of(model, &now.angle).compression(model, zone),
            speed_m_per_s: libm::hypot(velocity[0], velocity[1]),
        };
        let impact =
            self.before.filter(|before| before.compression_m <= 0.0 && now.compression_m > 0.0).map(|before| {
                let flown = self.older.as_ref().and_then(|older| before.flight(older, &now));
                flown.unwrap_or_else(|| before.straight(&now))
            });
        self.older = self.before.replace(now);
        impact
    }

    /// The mechanism has stood still without updates until this instant, in steps of h (s): as if it had been updated
    /// after every one of them.
    pub(crate) fn stood(&mut self, until_s: f64, h: f64) {
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

    /// The last two samples and moments in plain numbers (see [`ImpactPredictor::resume`]).
    pub(crate) fn samples<const Z: usize>(&self, model: &Model<f64, B, Z>) -> [Option<[f64; 3]>; 2] {
        let Some(zone) = self.zone else { return [None; 2] };
        let mut now = self.clone();
        for k in [self.next, self.next ^ 1] {
            if let Some(moment) = &self.skipped[k] {
                now.sample(model, zone, moment);
            }
        }
        [now.older, now.before].map(|s| s.map(|s| [s.time_s, s.compression_m, s.speed_m_per_s]))
    }

    /// Goes on from what [`ImpactPredictor::samples`] gave.
    pub(crate) fn resume(&mut self, samples: [Option<[f64; 3]>; 2]) {
        self.forget();
        [self.older, self.before] = samples
            .map(|s| s.map(|[time_s, compression_m, speed_m_per_s]| Sample { time_s, compression_m, speed_m_per_s }));
    }
}

/// Instant (s) and speed (m/s) of the impact that follows if a point flies on as it did between two samples (instant,
/// s; the zone's compression, m; speed, m/s), its acceleration unchanged, at the latest at `now_s`:
///
/// a = dv/dt, d = -g / (dg/dx), v^2 = v_b^2 + 2 a d, t = t_b + 2 d / (v_b + v)
///
/// with both slopes taken over the step before, g the zone's compression and x the point's path. The end of the step in
/// which the zone is met plays no part: there it has pushed already, which at 200 us would make a piano hammer's blow a
/// hundredth slower. `None` where there is no such flight: at the second look, and where the zone was touched a step
/// before.
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

impl Sample {
    /// The impact that follows if the point flies on as it did between `older` and here ([`impact_in_flight`]).
    pub(crate) fn flight(&self, older: &Sample, now: &Sample) -> Option<Impact> {
        let numbers = |s: &Sample| [s.time_s, s.compression_m, s.speed_m_per_s];
        let [time_s, hammer_speed_m_per_s] = impact_in_flight([numbers(older), numbers(self)], now.time_s)?;
        // The share of the path that led toward the zone in the step before.
        let path_m = 0.5 * (older.speed_m_per_s + self.speed_m_per_s) * (self.time_s - older.time_s);
        let hammer_speed_normal_m_per_s = hammer_speed_m_per_s * (self.compression_m - older.compression_m) / path_m;
        Some(Impact { time_s, hammer_speed_m_per_s, hammer_speed_normal_m_per_s })
    }

    /// The impact where the compression, running linearly from here to `now`, is zero; the speed runs linearly, too.
    pub(crate) fn straight(&self, now: &Sample) -> Impact {
        let share = self.compression_m / (self.compression_m - now.compression_m);
        Impact {
            time_s: self.time_s
                + (now.time_s - self.time_s) * self.compression_m / (self.compression_m - now.compression_m),
            hammer_speed_m_per_s: self.speed_m_per_s + share * (now.speed_m_per_s - self.speed_m_per_s),
            hammer_speed_normal_m_per_s: (now.compression_m - self.compression_m) / (now.time_s - self.time_s),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(time_s: f64, compression_m: f64, speed_m_per_s: f64) -> Sample {
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
        assert!((impact.hammer_speed_m_per_s - (v + a * t)).abs() < 1e-12, "{}", impact.hammer_speed_m_per_s);
        assert!((impact.hammer_speed_normal_m_per_s - 0.98 * (v + a * t)).abs() < 1e-12, "{impact:?}");
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
        assert_eq!((impact.time_s, impact.hammer_speed_m_per_s), (1.5e-3, 2.5));
        assert!((impact.hammer_speed_normal_m_per_s - 0.02).abs() < 1e-15, "{impact:?}");
    }
}

//! The instants of a key press, found while it runs.

use crate::instrument::{Instrument, Roles};
use crate::run::{Events, Strike};
use crate::sight::Visible;

/// The key front has left its rest when it is this far down, m: a tenth of a millimetre, ten times what its cloths breathe
/// and a hundredth of its dip.
pub const KEY_START_M: f64 = 1e-4;

/// The head's speed is looked at within this distance of the string, m: three times what the fastest travels in the longest step.
const NEAR_M: f64 = 0.02;

/// Watches a running mechanism. Instants are interpolated within the step, so that they are not tied to the step's grid.
#[derive(Debug)]
pub struct Watch {
    roles: Roles,
    events: Events,
    previous: Option<Sample>,
    /// The one before it.
    older: Option<Sample>,
    /// Last instant at which a push on the knuckle ended, if none has begun since.
    released_s: Option<f64>,
    highest_m: f64,
    released_at_apex_s: Option<f64>,
}

/// What the watch looks at in one instant.
#[derive(Debug, Clone, Copy)]
struct Sample {
    time_s: f64,
    key_m: f64,
    hammer_m: f64,
    string: f64,
    /// Looked at near the string only.
    head_speed: Option<f64>,
    key_bottom: f64,
    toe: f64,
    knuckle: f64,
    check: f64,
}

impl Watch {
    /// A watch for an instrument's roles.
    pub fn new(instrument: &Instrument) -> Self {
        Watch {
            roles: instrument.roles.clone(),
            events: Events::default(),
            previous: None,
            older: None,
            released_s: None,
            highest_m: f64::NEG_INFINITY,
            released_at_apex_s: None,
        }
    }

    /// Looks once: after every step, and before the first. `key_m` is the key front's travel, `hammer_m` the head's rise.
    pub fn look(&mut self, time_s: f64, key_m: f64, hammer_m: f64, mechanism: &dyn Visible) {
        let (roles, events) = (&self.roles, &self.events);
        let gap = |zone: Option<usize>| zone.map_or(f64::NEG_INFINITY, |z| mechanism.gap(z));
        // What has happened once is not looked for again.
        let once = |event: Option<f64>, zone: Option<usize>| if event.is_none() { gap(zone) } else { f64::INFINITY };
        let string = gap(roles.string);
        let struck = events.hammer_contact_s.is_some();
        let now = Sample {
            time_s,
            key_m,
            hammer_m,
            string,
            head_speed: roles
                .hammer
                .filter(|_| string > -NEAR_M)
                .map(|hammer| mechanism.point_speed(hammer, roles.hammer_head_m)),
            key_bottom: once(events.key_bottom_s, roles.key_bottom),
            toe: once(events.toe_contact_s, roles.let_off),
            knuckle: match struck {
                false => roles.knuckle.iter().map(|&z| mechanism.gap(z)).fold(f64::NEG_INFINITY, f64::max),
                true => f64::NEG_INFINITY,
            },
            // Only after the blow does a check count; the sample before it is the first that is needed.
            check: if struck || string > -NEAR_M { once(events.check_s, roles.check) } else { f64::NEG_INFINITY },
        };
        if let Some(before) = self.previous {
            self.compare(&before, &now);
        }
        self.older = self.previous.replace(now);
    }

    fn compare(&mut self, before: &Sample, now: &Sample) {
        let rising = |a: f64, b: f64| (a <= 0.0 && b > 0.0).then(|| before.at_zero(a, b, now));
        let events = &mut self.events;
        let first = |event: &mut Option<f64>, at: Option<f64>| *event = event.or(at);
        first(&mut events.key_start_s, rising(before.key_m - KEY_START_M, now.key_m - KEY_START_M));
        first(&mut events.key_bottom_s, rising(before.key_bottom, now.key_bottom));
        if events.key_start_s.is_some() {
            first(&mut events.toe_contact_s, rising(before.toe, now.toe));
        }

        if before.knuckle > 0.0 && now.knuckle <= 0.0 {
            self.released_s = Some(before.at_zero(before.knuckle, now.knuckle, now));
        } else if now.knuckle > 0.0 {
            self.released_s = None;
        }
        if now.hammer_m > self.highest_m {
            self.highest_m = now.hammer_m;
            self.released_at_apex_s = self.released_s;
        }

        if let Some(linear_s) = rising(before.string, now.string) {
            let flown = self.older.as_ref().and_then(|older| before.flight(older, now));
            let Strike { time_s, speed_m_s } = flown.unwrap_or_else(|| before.straight(linear_s, now));
            if events.hammer_contact_s.is_none() {
                events.hammer_contact_s = Some(time_s);
                events.hammer_speed_m_s = Some(speed_m_s);
                events.let_off_s = self.released_s;
            }
            events.strikes.push(Strike { time_s, speed_m_s });
        }
        if events.hammer_contact_s.is_some() {
            first(&mut events.check_s, rising(before.check, now.check));
        }
    }

    /// Whether all that happens once has happened, so that nothing is left to be seen but further blows.
    pub fn sees_blows_only(&self) -> bool {
        let (roles, events) = (&self.roles, &self.events);
        let over = |event: Option<f64>, zone: Option<usize>| event.is_some() || zone.is_none();
        events.key_start_s.is_some()
            && events.hammer_contact_s.is_some()
            && over(events.toe_contact_s, roles.let_off)
            && over(events.key_bottom_s, roles.key_bottom)
            && over(events.check_s, roles.check)
    }

    /// What was seen. Where the hammer never reached the string, let-off is the last push before its highest point.
    pub fn finish(mut self) -> Events {
        if self.events.hammer_contact_s.is_none() && self.events.key_start_s.is_some() {
            self.events.let_off_s = self.released_at_apex_s.filter(|_| self.events.toe_contact_s.is_some());
        }
        self.events
    }
}

impl Sample {
    /// The instant at which a quantity that runs linearly from a (here) to b (at `now`) is zero.
    fn at_zero(&self, a: f64, b: f64, now: &Sample) -> f64 {
        self.time_s + (now.time_s - self.time_s) * a / (a - b)
    }

    /// The blow that follows if the head flies on as it did between `older` and here, its acceleration unchanged:
    ///
    /// a = dv/dt, d = -g / (dg/dx), v^2 = v_b^2 + 2 a d, t = t_b + 2 d / (v_b + v)
    ///
    /// with both slopes taken over the step before, g the string's compression and x the head's path. The end of the step in which the
    /// string is met plays no part: there it has pushed already, which at 200 us would make the blow a hundredth slower.
    /// `None` where there is no such flight: at the second look, and where the string was touched a step before.
    fn flight(&self, older: &Sample, now: &Sample) -> Option<Strike> {
        let (v0, v1) = (older.head_speed?, self.head_speed?);
        let last_s = self.time_s - older.time_s;
        let nearer = self.string - older.string;
        if older.string > 0.0 || nearer <= 0.0 {
            return None;
        }
        let distance_m = -self.string / nearer * 0.5 * (v0 + v1) * last_s;
        let square = v1 * v1 + 2.0 * (v1 - v0) / last_s * distance_m;
        if square <= 0.0 {
            return None;
        }
        let speed_m_s = square.sqrt();
        let flight_s = 2.0 * distance_m / (v1 + speed_m_s);
        Some(Strike { time_s: (self.time_s + flight_s).min(now.time_s), speed_m_s })
    }

    /// The blow at this instant, the head's speed running linearly from here to `now`.
    fn straight(&self, time_s: f64, now: &Sample) -> Strike {
        let (before, after) = (self.head_speed.unwrap_or(0.0), now.head_speed.unwrap_or(0.0));
        let share = (time_s - self.time_s) / (now.time_s - self.time_s);
        Strike { time_s, speed_m_s: before + share * (after - before) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(time_s: f64, string: f64, head_speed: Option<f64>) -> Sample {
        let never = f64::NEG_INFINITY;
        let (key_bottom, toe, knuckle, check) = (never, never, never, never);
        Sample { time_s, key_m: 0.0, hammer_m: 0.0, string, head_speed, key_bottom, toe, knuckle, check }
    }

    /// A head thrown with 2 m/s and uniformly slowed: what the string did to it by the end of the step plays no part.
    #[test]
    fn a_uniformly_slowed_flight_is_met_exactly() {
        let (v, a, h) = (2.0, -30.0, 2e-4);
        // It starts 1 mm below; the string's compression grows by 0.98 of the path.
        let at = |t: f64| sample(t, 0.98 * (v * t + 0.5 * a * t * t - 1e-3), Some(v + a * t));
        let [older, before] = [at(1.5 * h), at(2.2 * h)];
        let now = sample(3.2 * h, 5e-5, Some(1.5));
        let blow = before.flight(&older, &now).unwrap();
        // 1 mm = v t + a t^2/2.
        let t = (v - (v * v + 2.0 * a * 1e-3_f64).sqrt()) / -a;
        assert!((blow.time_s - t).abs() < 1e-15, "{} {t}", blow.time_s);
        assert!((blow.speed_m_s - (v + a * t)).abs() < 1e-12, "{}", blow.speed_m_s);
        assert!(before.time_s < t && t < now.time_s);
    }

    /// Without a flight before it, as at the first step or while it bounces on the string, there is the straight line.
    #[test]
    fn no_flight_no_extrapolation() {
        let (older, before, now) =
            (sample(0.0, 1e-5, Some(1.0)), sample(1e-3, -1e-5, Some(2.0)), sample(2e-3, 1e-5, Some(3.0)));
        assert_eq!(before.flight(&older, &now), None);
        let unseen = sample(0.0, -1e-3, None);
        assert_eq!(before.flight(&unseen, &now), None);
        // It would turn around before the string.
        let fast = sample(0.0, -3e-5, Some(20.0));
        assert_eq!(before.flight(&fast, &now), None);
        let blow = before.straight(1.5e-3, &now);
        assert_eq!((blow.time_s, blow.speed_m_s), (1.5e-3, 2.5));
    }
}

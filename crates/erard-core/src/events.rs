//! The instants of a key press, found while it runs.

use crate::instrument::{Instrument, Roles};
use crate::mechanism::{Impact, Observation};
use crate::player::Action;

/// The key front has left its rest when it is this far down, m: a tenth of a millimetre, ten times the slow motion of
/// its cloths and a hundredth of its dip.
pub(crate) const KEY_START_M: f64 = 1e-4;

/// Distance from the string within which a check is detected, m.
const NEAR_M: f64 = 0.02;

/// Instants and speeds of one press; `None` where it did not happen. Seconds from the stroke's start.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Events {
    /// The key front leaves its rest.
    pub key_start_s: Option<f64>,
    /// The jack's toe meets the let-off button.
    pub toe_contact_s: Option<f64>,
    /// The last force on the knuckle before the string ends. A felt that is slow to recover may touch for longer.
    pub let_off_s: Option<f64>,
    /// The key meets its front punching.
    pub key_bottom_s: Option<f64>,
    /// The tail meets the back check after the impact.
    pub check_s: Option<f64>,
    /// Every impact of the hammer on the string.
    pub impacts: Vec<Impact>,
}

impl Events {
    /// The first impact of the hammer on the string.
    pub(crate) fn first_impact(&self) -> Option<Impact> {
        self.impacts.first().copied()
    }

    /// Instant of the first impact, s.
    pub fn hammer_contact_s(&self) -> Option<f64> {
        self.first_impact().map(|impact| impact.time_s)
    }

    /// Total speed of the strike point at the first impact, m/s.
    pub fn hammer_speed_m_per_s(&self) -> Option<f64> {
        self.first_impact().map(|impact| impact.hammer_speed_m_per_s)
    }

    /// Component of that speed along the string's normal, m/s, which compresses the felt.
    pub fn hammer_speed_normal_m_per_s(&self) -> Option<f64> {
        self.first_impact().map(|impact| impact.hammer_speed_normal_m_per_s)
    }

    /// From let-off to the string, s.
    pub fn free_flight_s(&self) -> Option<f64> {
        Some(self.hammer_contact_s()? - self.let_off_s?)
    }

    /// From the impact to the key's bottom, s; negative where the key is down before the hammer strikes.
    pub fn key_bottom_after_impact_s(&self) -> Option<f64> {
        Some(self.key_bottom_s? - self.hammer_contact_s()?)
    }
}

/// Finds the events of a running mechanism. Instants are interpolated within the step, so that they are not tied to the
/// step's grid.
#[derive(Debug, Clone)]
pub struct EventDetector {
    roles: Roles,
    events: Events,
    previous: Option<Sample>,
    /// The last two steps' pushes on the knuckle, the older one first.
    pushes: [Push; 2],
    /// Last instant at which a push on the knuckle ended, if none has begun since.
    released_s: Option<f64>,
    highest_m: f64,
    released_at_apex_s: Option<f64>,
}

/// Quantities that are compared from step to step.
#[derive(Debug, Clone, Copy)]
struct Sample {
    time_s: f64,
    key_m: f64,
    hammer_rise_m: f64,
    key_bottom: f64,
    toe: f64,
    /// Force on the knuckle in the step that ends here, N.
    knuckle_n: f64,
    check: f64,
}

/// Mean force on the knuckle over a step, and the step's middle.
#[derive(Debug, Clone, Copy, Default)]
struct Push {
    time_s: f64,
    force_n: f64,
}

impl Push {
    /// Instant at which the last of two pushes ends, the older one first, by linear extrapolation of both; at the
    /// latest `until`, the middle of a step without a push.
    fn end_of([older, last]: [Push; 2], until: f64) -> f64 {
        let falls_by = older.force_n - last.force_n;
        let end = last.time_s + (last.time_s - older.time_s) * last.force_n / falls_by;
        if falls_by > 0.0 { end.min(until) } else { until }
    }
}

impl EventDetector {
    /// A detector for an instrument's roles.
    pub fn new(instrument: &Instrument) -> Self {
        EventDetector {
            roles: instrument.roles.clone(),
            events: Events::default(),
            previous: None,
            pushes: [Push::default(); 2],
            released_s: None,
            highest_m: f64::NEG_INFINITY,
            released_at_apex_s: None,
        }
    }

    /// Observes an action: call before the first step of a press and after every one.
    pub fn observe_action(&mut self, action: &Action) {
        let now = action.reading();
        self.observe(action.time_s(), now.key_m, now.hammer_rise_m, action.impact(), action.mechanism());
    }

    /// Call before the first step and after every one. `key_m` is the key front's travel, `hammer_rise_m` the head's
    /// rise, `impact` the impact of the hammer on the string in the step, if there was one.
    pub fn observe(
        &mut self,
        time_s: f64,
        key_m: f64,
        hammer_rise_m: f64,
        impact: Option<Impact>,
        mechanism: &dyn Observation,
    ) {
        if self.awaits_impacts_only() {
            self.events.impacts.extend(impact);
            return;
        }
        let (roles, events) = (&self.roles, &self.events);
        let compression = |zone: Option<usize>| zone.map_or(f64::NEG_INFINITY, |z| mechanism.compression(z));
        // What has happened once is not looked for again.
        let once =
            |event: Option<f64>, zone: Option<usize>| if event.is_none() { compression(zone) } else { f64::INFINITY };
        let struck = !events.impacts.is_empty();
        let now = Sample {
            time_s,
            key_m,
            hammer_rise_m,
            key_bottom: once(events.key_bottom_s, roles.key_bottom),
            toe: once(events.toe_contact_s, roles.let_off),
            knuckle_n: match struck {
                false => roles.knuckle.iter().map(|&z| mechanism.normal_force(z)).sum(),
                true => 0.0,
            },
            // Only after the impact does a check count; the sample before it is the first that is needed.
            check: if struck || compression(roles.string) > -NEAR_M {
                once(events.check_s, roles.check)
            } else {
                f64::NEG_INFINITY
            },
        };
        if let Some(before) = self.previous {
            self.compare(&before, &now, impact);
        }
        self.previous = Some(now);
    }

    /// Reports that nothing has moved until this instant, s, as if every step had been observed.
    pub(crate) fn unchanged(&mut self, time_s: f64) {
        if let Some(previous) = &mut self.previous {
            previous.time_s = time_s;
        }
    }

    fn compare(&mut self, before: &Sample, now: &Sample, impact: Option<Impact>) {
        let rising = |a: f64, b: f64| (a <= 0.0 && b > 0.0).then(|| before.at_zero(a, b, now));
        let events = &mut self.events;
        let first = |event: &mut Option<f64>, at: Option<f64>| *event = event.or(at);
        first(&mut events.key_start_s, rising(before.key_m - KEY_START_M, now.key_m - KEY_START_M));
        first(&mut events.key_bottom_s, rising(before.key_bottom, now.key_bottom));
        if events.key_start_s.is_some() {
            first(&mut events.toe_contact_s, rising(before.toe, now.toe));
        }

        let push = Push { time_s: 0.5 * (before.time_s + now.time_s), force_n: now.knuckle_n };
        if push.force_n > 0.0 {
            self.released_s = None;
        } else if self.pushes[1].force_n > 0.0 {
            self.released_s = Some(Push::end_of(self.pushes, push.time_s));
        }
        self.pushes = [self.pushes[1], push];
        if now.hammer_rise_m > self.highest_m {
            self.highest_m = now.hammer_rise_m;
            self.released_at_apex_s = self.released_s;
        }

        if let Some(impact) = impact {
            if events.impacts.is_empty() {
                events.let_off_s = self.released_s;
            }
            events.impacts.push(impact);
        }
        if !events.impacts.is_empty() {
            first(&mut events.check_s, rising(before.check, now.check));
        }
    }

    /// Whether all events that happen once have happened, so that only further impacts remain to be found.
    pub fn awaits_impacts_only(&self) -> bool {
        let (roles, events) = (&self.roles, &self.events);
        let over = |event: Option<f64>, zone: Option<usize>| event.is_some() || zone.is_none();
        events.key_start_s.is_some()
            && !events.impacts.is_empty()
            && over(events.toe_contact_s, roles.let_off)
            && over(events.key_bottom_s, roles.key_bottom)
            && over(events.check_s, roles.check)
    }

    /// Whether the force on the knuckle is still needed: until the first impact.
    pub fn awaits_let_off(&self) -> bool {
        self.events.impacts.is_empty() && !self.roles.knuckle.is_empty()
    }

    /// The events found. Where the hammer never reached the string, let-off is the last push before its highest point.
    pub fn finish(mut self) -> Events {
        self.conclude();
        self.events
    }

    /// The events found so far, as if the run ended now.
    pub fn so_far(&self) -> Events {
        let mut now = self.clone();
        now.conclude();
        now.events
    }

    fn conclude(&mut self) {
        if self.events.impacts.is_empty() && self.events.key_start_s.is_some() {
            self.events.let_off_s = self.released_at_apex_s.filter(|_| self.events.toe_contact_s.is_some());
        }
    }
}

impl Sample {
    /// The instant at which a quantity that changes linearly from a (here) to b (at `now`) is zero; the instant of
    /// `now` if a was not observed.
    fn at_zero(&self, a: f64, b: f64, now: &Sample) -> f64 {
        if a == f64::NEG_INFINITY {
            return now.time_s;
        }
        self.time_s + (now.time_s - self.time_s) * a / (a - b)
    }
}

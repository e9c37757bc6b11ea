//! The instants of a press in dual numbers: [`crate::events::EventDetector`] with derivatives.

use moreau::{Real, Settings};
use moreau_kernels::{Number, Tangents, impact_in_flight};

use super::Places;
use crate::events::KEY_START_M;
use crate::instrument::{Instrument, Roles};

/// Instants and speeds with their derivatives; `None` where it did not happen. Seconds from the stroke's start.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Instants {
    /// The key front leaves its rest.
    pub key_start_s: Option<Number>,
    /// The jack's toe meets the let-off button.
    pub toe_contact_s: Option<Number>,
    /// The last force on the knuckle before the string ends.
    pub let_off_s: Option<Number>,
    /// The hammer meets the string.
    pub hammer_contact_s: Option<Number>,
    /// Speed of the strike point at that instant, m/s.
    pub hammer_speed_m_per_s: Option<Number>,
    /// The key meets its front punching.
    pub key_bottom_s: Option<Number>,
}

/// A quantity of [`Instants`].
type Get = fn(&Instants) -> Option<Number>;

/// Quantities with derivatives, by the names of a study's columns.
pub const QUANTITIES: [(&str, Get); 9] = [
    ("hammer_speed_m_per_s", |i| i.hammer_speed_m_per_s),
    ("let_off_s", |i| i.let_off_s),
    ("hammer_contact_s", |i| i.hammer_contact_s),
    ("key_bottom_s", |i| i.key_bottom_s),
    ("key_bottom_after_impact_s", |i| Some(i.key_bottom_s? - i.hammer_contact_s?)),
    ("free_flight_s", |i| Some(i.hammer_contact_s? - i.let_off_s?)),
    ("key_start_s", |i| i.key_start_s),
    ("toe_contact_s", |i| i.toe_contact_s),
    ("key_start_to_hammer_s", |i| Some(i.hammer_contact_s? - i.key_start_s?)),
];

/// Watches a press.
pub(super) struct DualEventDetector {
    roles: Roles,
    head: [Number; 2],
    site_m: Number,
    head_m: Number,
    instants: Instants,
    before: Option<Sample>,
    /// Instant, compression of the string, speed of the strike point.
    flight: [Option<[Number; 3]>; 2],
    /// The last two steps' pushes on the knuckle, the older one first: the middle of a step, s, and the mean force, N.
    pushes: [(f64, Number); 2],
    /// Compressions of the knuckle's zones before the last step.
    knuckle: Vec<Number>,
    /// Instant at which the last of them separated, s.
    parted_s: Option<Number>,
    released_s: Option<Number>,
    highest_m: f64,
    released_at_apex_s: Option<Number>,
}

#[derive(Clone, Copy)]
struct Sample {
    time_s: f64,
    key_m: Number,
    key_bottom: Option<Number>,
    toe: Option<Number>,
    /// The push on the knuckle in the last step.
    push: (f64, Number),
}

impl Sample {
    /// The instant at which a quantity that runs linearly from a (here) to b (at `now`) is zero.
    fn at_zero(&self, a: Number, b: Number, now: &Sample) -> Number {
        let t = Number::constant;
        t(self.time_s) + t(now.time_s - self.time_s) * (a / (a - b))
    }

    fn rising(&self, a: Option<Number>, b: Option<Number>, now: &Sample) -> Option<Number> {
        let (a, b) = (a?, b?);
        (a.value <= 0.0 && b.value > 0.0).then(|| self.at_zero(a, b, now))
    }
}

/// As [`crate::events::EventDetector`] has it, with the derivative of the instant at which the zones `parted` if that
/// was near: the line through two forces jumps from step to step around the end of a felt's curved force.
fn end_of_push(older: (f64, Number), last: (f64, Number), until: f64, parted: Option<Number>) -> Number {
    let t = Number::constant;
    let falls_by = older.1 - last.1;
    let end = t(last.0) + t(last.0 - older.0) * (last.1 / falls_by);
    let end = if falls_by.value > 0.0 && end.value < until { end } else { t(until) };
    match parted.filter(|parted| (parted.value - end.value).abs() < NEAR * (until - older.0)) {
        Some(parted) => Number { slope: parted.slope, ..end },
        None => end,
    }
}

/// Number of steps around the end of a push within which separating zones end it.
const NEAR: f64 = 1.5;

impl DualEventDetector {
    /// Of a mechanism that stands at rest.
    pub(crate) fn new(instrument: &Instrument, places: &Places, m: &dyn Tangents) -> Self {
        let roles = instrument.roles.clone();
        let head_m = roles.hammer.map_or(Number::ZERO, |hammer| m.motion(hammer, places.head)[0][1]);
        DualEventDetector {
            roles,
            head: places.head,
            site_m: places.site,
            head_m,
            instants: Instants::default(),
            before: None,
            flight: [None; 2],
            pushes: [(0.0, Number::ZERO); 2],
            knuckle: Vec::new(),
            parted_s: None,
            released_s: None,
            highest_m: f64::NEG_INFINITY,
            released_at_apex_s: None,
        }
    }

    /// Key travel and rise of the strike point now, m.
    pub(crate) fn travels(&self, m: &dyn Tangents) -> [Number; 2] {
        let hammer_rise_m =
            self.roles.hammer.map_or(Number::ZERO, |hammer| m.motion(hammer, self.head)[0][1] - self.head_m);
        [m.site_position() - self.site_m, hammer_rise_m]
    }

    /// After every step, and before the first.
    pub(crate) fn observe(&mut self, time_s: f64, settings: &Settings<f64>, m: &dyn Tangents) {
        let roles = &self.roles;
        let compression = |zone: Option<usize>| zone.map(|z| m.compression(z));
        let mut push = (time_s, Number::ZERO);
        for &zone in &roles.knuckle {
            let (force, step_s) = m.normal_force(settings, zone);
            push = (time_s - 0.5 * step_s, push.1 + force);
        }
        let now = Sample {
            time_s,
            key_m: m.site_position() - self.site_m - Number::constant(KEY_START_M),
            key_bottom: compression(roles.key_bottom),
            toe: compression(roles.let_off),
            push,
        };
        if let Some(before) = self.before {
            let parted = self.knuckle.iter().zip(&roles.knuckle).filter_map(|(a, &zone)| {
                let b = m.compression(zone);
                (a.value > 0.0 && b.value <= 0.0).then(|| before.at_zero(*a, b, &now))
            });
            let last = parted.max_by(|a, b| a.value.total_cmp(&b.value));
            self.parted_s = last.or(self.parted_s);
        }
        self.knuckle = roles.knuckle.iter().map(|&zone| m.compression(zone)).collect();
        let mut impact = None;
        if let Some(hammer) = roles.hammer {
            let [place, velocity] = m.motion(hammer, self.head);
            let hammer_rise_m = (place[1] - self.head_m).value;
            if let Some(string) = compression(roles.string) {
                let speed = Real::sqrt(velocity[0] * velocity[0] + velocity[1] * velocity[1]);
                let sample = [Number::constant(time_s), string, speed];
                impact = self.impact(&sample);
                self.flight = [self.flight[1], Some(sample)];
            }
            self.compare(&now, hammer_rise_m, impact);
        } else {
            self.compare(&now, 0.0, None);
        }
        self.before = Some(now);
    }

    fn impact(&self, now: &[Number; 3]) -> Option<[Number; 2]> {
        let before = self.flight[1]?;
        if !(before[1].value <= 0.0 && now[1].value > 0.0) {
            return None;
        }
        let flown = self.flight[0].and_then(|older| impact_in_flight([older, before], now[0]));
        flown.or_else(|| {
            let share = before[1] / (before[1] - now[1]);
            Some([before[0] + (now[0] - before[0]) * share, before[2] + share * (now[2] - before[2])])
        })
    }

    fn compare(&mut self, now: &Sample, hammer_rise_m: f64, impact: Option<[Number; 2]>) {
        let Some(before) = self.before else { return };
        let instants = &mut self.instants;
        let first = |event: &mut Option<Number>, at: Option<Number>| *event = event.or(at);
        first(&mut instants.key_start_s, before.rising(Some(before.key_m), Some(now.key_m), now));
        first(&mut instants.key_bottom_s, before.rising(before.key_bottom, now.key_bottom, now));
        if instants.key_start_s.is_some() {
            first(&mut instants.toe_contact_s, before.rising(before.toe, now.toe, now));
        }
        let [older, last] = self.pushes;
        if now.push.1.value > 0.0 {
            self.released_s = None;
        } else if last.1.value > 0.0 {
            self.released_s = Some(end_of_push(older, last, now.push.0, self.parted_s));
        }
        self.pushes = [last, now.push];
        if hammer_rise_m > self.highest_m {
            self.highest_m = hammer_rise_m;
            self.released_at_apex_s = self.released_s;
        }
        if let Some([time_s, speed_m_per_s]) = impact.filter(|_| instants.hammer_contact_s.is_none()) {
            instants.hammer_contact_s = Some(time_s);
            instants.hammer_speed_m_per_s = Some(speed_m_per_s);
            instants.let_off_s = self.released_s;
        }
    }

    /// Whether all events have been found.
    pub(crate) fn has_seen_all(&self) -> bool {
        let (roles, instants) = (&self.roles, &self.instants);
        let over = |event: Option<Number>, zone: Option<usize>| event.is_some() || zone.is_none();
        instants.key_start_s.is_some()
            && instants.hammer_contact_s.is_some()
            && over(instants.toe_contact_s, roles.let_off)
            && over(instants.key_bottom_s, roles.key_bottom)
    }

    /// The events found. If the hammer never reached the string, let-off is the last push before its highest point.
    pub(crate) fn finish(mut self) -> Instants {
        if self.instants.hammer_contact_s.is_none() && self.instants.key_start_s.is_some() {
            self.instants.let_off_s = self.released_at_apex_s.filter(|_| self.instants.toe_contact_s.is_some());
        }
        self.instants
    }
}

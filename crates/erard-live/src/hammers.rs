//! Sensors at hammer shanks: from the travel of a head to notes. Without a heap.

use erard_midi::{Crossing, Event, KeyNotes};

use crate::converter::Converter;
use crate::limits::MAX_HAMMER_M_PER_S;
use crate::sensor::LawOf;

/// The speed is the slope over the last part of the head's travel before its stop: over this much of it, m, or over
/// more, at most this much, if it holds too few readings.
const SLOPE_M: [f64; 2] = [5e-3, 15e-3];
/// Number of readings that are enough.
const ENOUGH: usize = 4;
/// Readings that are nearer to each other are not kept, m.
const APART_M: f64 = 0.5e-3;
/// Noise of a reading, m.
const NOISE_M: f64 = 1e-3;
/// A head this near to where its rise begins still stands there, m.
const STANDS_M: f64 = 0.25e-3;
/// Number of readings that are kept: 15 mm and some.
const KEPT: usize = 40;
/// A head that falls by this much below its highest place no longer rises, m.
const FALLS_M: f64 = 1.5e-3;
/// After a strike the next one needs a head that has fallen so far below its stop, m: a bent shank swings meanwhile.
const REARMS_M: f64 = 5e-3;
/// A rise by less is none, m.
const RISES_M: f64 = 3e-3;
/// A slower head strikes no string, and no hammer is faster, m/s: a reading that says so is none of a head.
const SPEEDS_M_PER_S: [f64; 2] = [0.05, 1.5 * MAX_HAMMER_M_PER_S];
/// A head that flies freely loses speed to gravity, m/s2: a hammer's shank is nearly level, its mass in the head.
const GRAVITY_M_PER_S2: f64 = 9.81;
/// A note whose release nobody sees ends when its head has fallen to this share of its travel: below a back check,
/// above the rest.
pub const OFF_SHARE: f64 = 0.25;
/// Time between two readings before it is known, s; a longer time is a pause of the sender, s.
const USUAL_PERIOD_S: f64 = 1e-3;
const PAUSE_S: f64 = 0.1;

/// What ends the notes of a hammer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Release {
    /// Travel of the second sensor's place, at the key or the damper, m.
    pub travel_m: f64,
    /// Its travel at which, coming up, the damper lies on the string, m.
    pub off_m: f64,
}

/// Counts of one hammer.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct HammerCounts {
    /// Rises of 3 mm or more that turned before the stop, from which a jack that resets, a repetition lever and a
    /// silent press cannot be told.
    pub lifts: u64,
    /// The fastest head at its stop, m/s.
    pub fastest_m_per_s: f64,
    /// The highest place of the head below its stop, m.
    pub nearest_m: f64,
}

/// One hammer, and the sensor that sees its release if there is one.
#[derive(Debug, Clone)]
pub struct HammerKey<P> {
    head: Converter<f64, P>,
    release: Option<(Converter<f64, P>, Release)>,
    /// Notes by the place that ends them: the second sensor's, or the head's own.
    crossing: Crossing,
    notes: KeyNotes,
    last: Option<[f64; 2]>,
    /// Instant of the last reading of either sensor, s.
    seen_s: f64,
    /// The last reading that was no outlier.
    accepted: Option<[f64; 2]>,
    is_sensed: bool,
    released_m: f64,
    /// Instant of the last strike, s.
    struck_s: f64,
    period_s: f64,
    /// Readings of the rise, and their number.
    rise: ([[f64; 2]; KEPT], usize),
    /// Lowest place since the head fell, and highest since, m.
    lowest_m: f64,
    highest_m: f64,
    has_struck: bool,
    /// What was counted.
    pub counts: HammerCounts,
}

impl<P: AsRef<[[f64; 2]]>> HammerKey<P> {
    /// A hammer at rest: its converter, whose travel is the head's way from its rest to its stop, and the converter of
    /// the second sensor.
    #[must_use]
    pub fn new(head: Converter<f64, P>, release: Option<(Converter<f64, P>, Release)>) -> Self {
        let damper_m = release.as_ref().map_or(OFF_SHARE * head.whole_m(), |(_, release)| release.off_m);
        HammerKey {
            crossing: Crossing { damper_m },
            notes: KeyNotes::new(Crossing { damper_m }),
            last: None,
            seen_s: f64::NEG_INFINITY,
            accepted: None,
            is_sensed: false,
            released_m: 0.0,
            struck_s: f64::NEG_INFINITY,
            period_s: USUAL_PERIOD_S,
            rise: ([[0.0; 2]; KEPT], 0),
            lowest_m: 0.0,
            highest_m: 0.0,
            has_struck: false,
            counts: HammerCounts { nearest_m: head.whole_m(), ..HammerCounts::default() },
            head,
            release,
        }
    }

    /// Changes the law of the head's sensor.
    pub fn set_law(&mut self, law: LawOf<P>) {
        self.head.set_law(law);
    }

    /// At rest again, as it was made, with the law that is in force.
    pub fn reset(&mut self) {
        self.head.reset();
        if let Some((release, _)) = &mut self.release {
            release.reset();
        }
        self.notes = KeyNotes::new(self.crossing);
        (self.last, self.accepted, self.is_sensed) = (None, None, false);
        self.seen_s = f64::NEG_INFINITY;
        (self.released_m, self.struck_s) = (0.0, f64::NEG_INFINITY);
        (self.period_s, self.has_struck) = (USUAL_PERIOD_S, false);
        (self.rise.1, self.lowest_m, self.highest_m) = (0, 0.0, 0.0);
        self.counts = HammerCounts { nearest_m: self.head.whole_m(), ..HammerCounts::default() };
    }

    /// Whether there was a reading of the head.
    #[must_use]
    pub fn is_sensed(&self) -> bool {
        self.is_sensed
    }

    /// Whether a second sensor sees its release.
    #[must_use]
    pub fn sees_release(&self) -> bool {
        self.release.is_some()
    }

    /// Whether no note sounds.
    #[must_use]
    pub fn is_up(&self) -> bool {
        !self.notes.sounds()
    }

    /// How far the readings have drifted, and how often beyond the limit.
    #[must_use]
    pub fn drift(&self) -> (f64, u64) {
        (self.head.drift(), self.head.beyond())
    }

    /// Takes a reading of the head at an instant, s; sends the resulting events. A note is sent when the next reading
    /// would come after the impact. Returns false and ignores the reading if it does not come after the last one, or
    /// comes before the last one of the other sensor: a note must not begin before its predecessor has ended.
    pub fn take(&mut self, time_s: f64, reading: f64, send: &mut dyn FnMut(Event)) -> bool {
        let before = self.last;
        if before.is_some_and(|[last_s, _]| time_s <= last_s) || time_s < self.seen_s {
            return false;
        }
        self.seen_s = time_s;
        let (x, stop_m) = (self.head.travel_m(time_s, reading), self.head.whole_m());
        (self.last, self.is_sensed) = (Some([time_s, x]), true);
        if let Some([last_s, _]) = before {
            match time_s - last_s {
                passed_s if passed_s > PAUSE_S => self.falls(x),
                passed_s => self.period_s += 0.1 * (passed_s - self.period_s),
            }
        }
        // No head gets here from where it was, nor from where the last reading saw it: an outlier is left out.
        let [slowest, fastest] = SPEEDS_M_PER_S;
        let jumps = |from: Option<[f64; 2]>| {
            from.is_some_and(|[from_s, place_m]| (x - place_m).abs() > fastest * (time_s - from_s) + NOISE_M)
        };
        if jumps(self.accepted) && jumps(before) {
            return true;
        }
        self.accepted = self.last;
        self.counts.nearest_m = self.counts.nearest_m.min(stop_m - x);
        if x < self.highest_m - FALLS_M {
            self.falls(x);
        } else if x < self.lowest_m {
            self.begins_at(x);
        }
        self.highest_m = self.highest_m.max(x);
        self.keep([time_s, x]);
        let mut hit = None;
        if !self.has_struck
            && let Some([v, middle_m]) = self.slope([time_s, x], stop_m)
        {
            let left_m = stop_m - x;
            let flies = v * v > 2.0 * GRAVITY_M_PER_S2 * left_m;
            if v > slowest && v <= fastest && flies && left_m <= v * self.period_s {
                // From the middle of the slope on it flies, and loses speed to gravity.
                let lost = 2.0 * GRAVITY_M_PER_S2 * (stop_m - middle_m);
                let speed = libm::sqrt((v * v - lost).max(0.25 * v * v));
                self.has_struck = true;
                self.counts.fastest_m_per_s = self.counts.fastest_m_per_s.max(speed);
                self.struck_s = time_s + (left_m / speed).max(-self.period_s);
                hit = Some([self.struck_s, speed]);
                // Wherever the next reading is, the head comes from its stop.
                (self.lowest_m, self.highest_m, self.rise.1) = (stop_m, stop_m, 0);
            }
        }
        if self.release.is_none() {
            for event in self.notes.update(time_s, x, hit).into_iter().flatten() {
                send(match event {
                    Event::Off { time_s, .. } => Event::Off { time_s, release_m_per_s: None },
                    on @ Event::On { .. } => on,
                });
            }
        } else if hit.is_some() {
            self.notes.update(time_s, self.released_m, hit).into_iter().flatten().for_each(send);
        }
        true
    }

    /// Takes a reading of the sensor that sees the release, at an instant, s. Returns false and ignores the reading if
    /// there is no such sensor, or it comes before the last one of either sensor.
    pub fn take_release(&mut self, time_s: f64, reading: f64, send: &mut dyn FnMut(Event)) -> bool {
        let Some((converter, _)) = self.release.as_mut().filter(|_| time_s >= self.seen_s) else { return false };
        self.seen_s = time_s;
        self.released_m = converter.travel_m(time_s, reading);
        for event in self.notes.update(time_s, self.released_m, None).into_iter().flatten() {
            send(match event {
                // Its readings may be farther apart than its strikes: no note ends before it begins.
                Event::Off { time_s, release_m_per_s } => {
                    Event::Off { time_s: time_s.max(self.struck_s), release_m_per_s }
                }
                on @ Event::On { .. } => on,
            });
        }
        true
    }

    /// Ends the note at an instant, s: nobody saw its release.
    pub fn let_go(&mut self, time_s: f64, send: &mut dyn FnMut(Event)) {
        if self.notes.end() {
            send(Event::Off { time_s, release_m_per_s: None });
        }
        (self.last, self.accepted, self.has_struck) = (None, None, false);
        self.seen_s = f64::NEG_INFINITY;
        (self.rise.1, self.lowest_m, self.highest_m) = (0, self.head.whole_m(), 0.0);
    }

    /// The head falls: its rise is over.
    fn falls(&mut self, x: f64) {
        let is_lift = !self.has_struck && self.highest_m - self.lowest_m > RISES_M;
        self.counts.lifts += u64::from(is_lift);
        self.begins_at(x);
    }

    /// A rise begins at a place.
    fn begins_at(&mut self, x: f64) {
        (self.lowest_m, self.highest_m, self.rise.1) = (x, x, 0);
        self.has_struck &= x > self.head.whole_m() - REARMS_M;
    }

    /// Keeps a reading of the rise, which rises.
    fn keep(&mut self, reading: [f64; 2]) {
        let (kept, count) = &mut self.rise;
        // It has not left the place where it stands: a rise begins with the last reading there.
        if *count == 1 && reading[1] < self.lowest_m + STANDS_M {
            kept[0] = reading;
            return;
        }
        if *count > 0 && reading[1] < kept[*count - 1][1] + APART_M {
            return;
        }
        if *count == KEPT {
            kept.copy_within(1.., 0);
            *count -= 1;
        }
        kept[*count] = reading;
        *count += 1;
    }

    /// Slope of the rise's last readings, this one included, m/s, and their mean place, m: over the last 5 mm below the
    /// stop or, where these hold fewer than four readings, over as many more as there are within 15 mm.
    fn slope(&self, now: [f64; 2], stop_m: f64) -> Option<[f64; 2]> {
        let (kept, count) = &self.rise;
        let is_kept = |one: &[f64; 2]| *one != now;
        let mut sums = [0.0; 5];
        let mut add = |[t, x]: [f64; 2]| {
            // From now, so that the sums are of small numbers.
            let (t, x) = (t - now[0], x - now[1]);
            let of = [1.0, t, x, t * t, t * x];
            sums.iter_mut().zip(of).for_each(|(sum, one)| *sum += one);
        };
        add(now);
        let mut taken = 1;
        for own in kept[..*count].iter().rev().filter(|one| is_kept(one)) {
            let below_m = stop_m - own[1];
            if below_m > SLOPE_M[0] && taken >= ENOUGH || below_m > SLOPE_M[1] && taken >= 2 {
                break;
            }
            add(*own);
            taken += 1;
        }
        let [n, t, x, tt, tx] = sums;
        let spread = n * tt - t * t;
        (taken >= 2 && spread > 0.0).then(|| [(n * tx - t * x) / spread, now[1] + x / n])
    }
}

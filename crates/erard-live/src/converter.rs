//! Conversion of a key's readings to travel.

use moreau::Scalar;

use crate::sensor::LawOf;

/// Drift is followed up to this share of a sensor's range.
const MAX_DRIFT: f64 = 0.15;
/// A reading nearer to its rest than this share of the range may be the rest.
const NEAR_REST: f64 = 0.03;
/// Such a reading is the rest if it has stayed within this share of the range for this time, s.
const STEADY: f64 = 0.005;
const RESTS_S: f64 = 1.0;
/// The rest follows its readings within this time, s.
const FOLLOWS_S: f64 = 10.0;

/// The readings at a key's two stops.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stops {
    /// Up, at rest.
    pub rest: f64,
    /// Down, held at the bottom.
    pub pressed: f64,
}

/// Converts a key's readings to travel, and follows how its rest drifts.
///
/// A reading within 3 % of the range of the last known rest that keeps within 0.5 % for a second is the rest: it is
/// followed within ten seconds, up to 15 % of the range. Both stops drift by the same. Readings beyond the rest, which
/// no key reaches, are followed at any distance. There is no drift while a key is held down.
#[derive(Debug, Clone)]
pub struct Converter<T, P> {
    law: LawOf<P>,
    /// The reading at rest, and its increase down to the bottom.
    rest: T,
    range: T,
    travel_m: T,
    /// Share of the range by which readings have drifted.
    drift: T,
    /// The last reading's instant, s.
    before_s: f64,
    /// Instant since when readings have stayed together, s, and their centre; none before the first.
    steady: Option<(f64, T)>,
    beyond: u32,
}

impl<T: Scalar, P: AsRef<[[f64; 2]]>> Converter<T, P> {
    /// Makes a converter from a sensor's law, the two different readings at the key's stops, and the sensed travel
    /// between them, m.
    #[must_use]
    pub fn new(law: LawOf<P>, stops: Stops, travel_m: f64) -> Self {
        let (rest, range) = (T::from_f64(stops.rest), T::from_f64(stops.pressed - stops.rest));
        let travel_m = T::from_f64(travel_m);
        Converter { law, rest, range, travel_m, drift: T::ZERO, before_s: 0.0, steady: None, beyond: 0 }
    }

    /// Changes the sensor's law.
    pub fn set_law(&mut self, law: LawOf<P>) {
        self.law = law;
    }

    /// Forgets all readings, and the drift. Returns the reading at rest.
    pub fn reset(&mut self) -> T {
        (self.drift, self.before_s, self.steady, self.beyond) = (T::ZERO, 0.0, None, 0);
        self.rest
    }

    /// Travel of the sensed place, m, at a reading at an instant, s.
    pub fn travel_m(&mut self, time_s: f64, reading: T) -> T {
        let most = T::from_f64(MAX_DRIFT);
        let read = (reading - self.rest) / self.range;
        let (since_s, around) = self.steady.unwrap_or((time_s, read));
        let off = read - self.drift;
        let is_steady = off < T::from_f64(NEAR_REST) && (read - around).abs() < T::from_f64(STEADY);
        let (since_s, around) = if is_steady { (since_s, around) } else { (time_s, read) };
        if time_s - since_s > RESTS_S {
            let share = T::from_f64(f64::min((time_s - self.before_s) / FOLLOWS_S, 1.0));
            let wanted = self.drift + off * share;
            self.beyond += u32::from(wanted.abs() > most && self.drift.abs() < most);
            self.drift = wanted.max(-most).min(most);
        }
        self.before_s = time_s;
        self.steady = Some((since_s, around));
        // No sensor tells what lies far beyond its stops.
        let off = (read - self.drift).max(T::from_f64(-0.5)).min(T::from_f64(1.5));
        self.travel_m * self.law.share(off, self.travel_m)
    }

    /// The whole travel, m.
    #[must_use]
    pub fn whole_m(&self) -> T {
        self.travel_m
    }

    /// Drift of the rest, as a share of the range.
    #[must_use]
    pub fn drift(&self) -> T {
        self.drift
    }

    /// Number of times that the drift exceeded the limit.
    #[must_use]
    pub fn beyond(&self) -> u64 {
        u64::from(self.beyond)
    }
}

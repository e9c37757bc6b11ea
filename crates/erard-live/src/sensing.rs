//! A key from readings of its sensor to messages of MIDI, whatever its action is; and the clock of scans. Without a
//! heap, in either precision.

use erard_midi::{Event, Law, Message, ReleaseLaw, Resolution, Velocity};
use moreau::Scalar;

use crate::converter::{Converter, Stops};
use crate::drive::SensorKind;
use crate::limits::Limits;
use crate::sensed::{APART_S, BEGINS_BEFORE_S, Counts, SensedKey, Steps};
use crate::sensor::FixedLaw;

/// The sensor of a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Kind of keyboard: [`SensorKind::Action`] or [`SensorKind::Light`].
    pub kind: SensorKind,
    /// Its law.
    pub law: FixedLaw,
    /// Readings at the key's two stops; they must differ.
    pub stops: Stops,
    /// A reading that differs from the last accepted one by no more than this counts as equal, so that noise does not
    /// keep a resting key awake.
    pub still: f64,
    /// The sensed travel between them, m.
    pub travel_m: f64,
    /// Travel of the key's front per travel of the sensed place; for a light device its whole travel is mapped to the
    /// simulated key's dip instead.
    pub front_per_sensed: f64,
}

/// What becomes of notes: channel, velocities and their bits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Voice<'a> {
    /// From 0 to 15.
    pub channel: u8,
    /// From hammer speed to velocity.
    pub law: Law<'a>,
    /// From the speed of a rising key to release velocity.
    pub release: ReleaseLaw,
    /// Bits of both.
    pub resolution: Resolution,
}

impl<'a> Voice<'a> {
    /// The first channel, the usual laws, seven bits.
    pub const USUAL: Voice<'static> =
        Voice { channel: 0, law: Law::GOEBL, release: ReleaseLaw::USUAL, resolution: Resolution::SevenBits };

    /// The message of an event. A release that nobody saw has the velocity of senders that measure none.
    #[must_use]
    pub fn message(&self, note: u8, event: Event) -> Message {
        match event {
            Event::On { hammer_speed_m_per_s, .. } => {
                Message::note_on(self.channel, note, self.law.velocity(hammer_speed_m_per_s), self.resolution)
            }
            Event::Off { release_m_per_s, .. } => {
                let unseen = (Velocity::of_seven_bits(64), Resolution::SevenBits);
                let seen = |m_per_s: f64| (self.release.velocity(m_per_s), self.resolution);
                let (velocity, resolution) = release_m_per_s.map_or(unseen, seen);
                Message::note_off(self.channel, note, velocity, resolution)
            }
        }
    }
}

/// A key without its action: its sensor, its clock, its notes. It keeps the last `W` samples at rest.
#[derive(Debug, Clone)]
pub struct Sensing<T, const W: usize> {
    kind: SensorKind,
    damper_m: f64,
    front_per_sensed: T,
    still: T,
    /// The last accepted reading.
    taken: T,
    converter: Converter<T, &'static [[f64; 2]]>,
    sensed: SensedKey<T, W>,
}

impl<T: Scalar, const W: usize> Sensing<T, W> {
    /// At rest, with the largest inputs of its key and the travel at which that sets its damper down, m; in steps of
    /// `step_s`.
    #[must_use]
    pub fn new(sensor: &Sensor, limits: &Limits, damper_m: f64, step_s: f64) -> Self {
        let Sensor { kind, law, stops, still, travel_m, front_per_sensed } = *sensor;
        let front = if kind == SensorKind::Light { limits.dip_m / travel_m } else { front_per_sensed };
        Sensing {
            kind,
            damper_m,
            front_per_sensed: T::from_f64(front),
            still: T::from_f64(still),
            taken: T::from_f64(stops.rest),
            converter: Converter::new(law, stops, travel_m),
            sensed: SensedKey::new(kind, limits.to(), damper_m, step_s),
        }
    }

    /// Takes a reading: instant, s, and value. Gives the resulting events. Returns false and ignores the reading if the
    /// instant is not after the last one.
    pub fn take(
        &mut self,
        (time_s, reading): (f64, T),
        action: &mut impl Steps<T>,
        give: &mut dyn FnMut(Event),
    ) -> bool {
        if (reading - self.taken).abs() > self.still {
            self.taken = reading;
        }
        let front_m = self.converter.travel_m(time_s, self.taken) * self.front_per_sensed;
        self.sensed.take((time_s, front_m), action, &mut |event| give(event))
    }

    /// Releases the key, whatever its sensor reads, and follows it to its rest, so that no note keeps sounding.
    pub fn let_go(&mut self, time_s: f64, action: &mut impl Steps<T>, give: &mut dyn FnMut(Event)) {
        self.sensed.let_go(time_s, action, &mut |event| give(event));
    }

    /// Sets the clock of a key that was let go ahead to an instant, s. Nothing is simulated.
    pub fn jump(&mut self, to_s: f64) {
        self.sensed.jump(to_s);
    }

    /// At rest again, as it was made, with the law that is in force.
    pub fn reset(&mut self) {
        let Sensing { kind, damper_m, taken, converter, sensed, .. } = self;
        *taken = converter.reset();
        *sensed = SensedKey::new(*kind, sensed.limits, *damper_m, sensed.h);
    }

    /// Changes the sensor's law.
    pub fn set_law(&mut self, law: FixedLaw) {
        self.converter.set_law(law);
    }

    /// Drift of the sensor's rest, as a share of its range, and how often it exceeded the limit.
    #[must_use]
    pub fn drift(&self) -> (T, u64) {
        (self.converter.drift(), self.converter.beyond())
    }

    /// Counts of events.
    #[must_use]
    pub fn counts(&self) -> Counts {
        self.sensed.counts
    }
}

/// The clock of scans, each of which reads all keys at one instant.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ScanClock {
    /// The beginning, and the last scan's instant, s on the scanner's clock.
    known: Option<[f64; 2]>,
}

/// An accepted scan.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scan {
    /// Its instant on the keys' clock, s.
    pub time_s: f64,
    /// After a gap of more than a second: the instant at which held notes end, and the one to which the keys' clocks
    /// jump, s. Nothing is simulated meanwhile.
    pub gap: Option<[f64; 2]>,
}

impl ScanClock {
    /// Takes a scan's instant, s on the scanner's clock; `None`, and nothing changes, if it is not after the last one.
    pub fn take(&mut self, time_s: f64) -> Option<Scan> {
        // A key may have begun to move a period before the first scan.
        let [begins_s, last_s] = self.known.unwrap_or([time_s - BEGINS_BEFORE_S, f64::NEG_INFINITY]);
        if time_s <= last_s {
            return None;
        }
        let own_s = time_s - begins_s;
        let gap = self.known.filter(|_| time_s - last_s > APART_S).map(|_| {
            let now_s = last_s - begins_s;
            [now_s, own_s.max(now_s + APART_S + BEGINS_BEFORE_S) - BEGINS_BEFORE_S]
        });
        self.known = Some([begins_s, time_s]);
        Some(Scan { time_s: own_s, gap })
    }

    /// Takes the instant of an edge, s on the scanner's clock, and returns it on the keys' clock; `None`, and nothing
    /// changes, if it is before the last one. A sender of edges is silent while nothing happens: that is no gap.
    pub fn take_edge(&mut self, time_s: f64) -> Option<f64> {
        let [begins_s, last_s] = self.known.unwrap_or([time_s - BEGINS_BEFORE_S, f64::NEG_INFINITY]);
        if time_s < last_s {
            return None;
        }
        self.known = Some([begins_s, time_s]);
        Some(time_s - begins_s)
    }

    /// The last scan's instant on the keys' clock, s.
    #[must_use]
    pub fn now_s(&self) -> f64 {
        self.known.map_or(0.0, |[begins_s, last_s]| last_s - begins_s)
    }
}

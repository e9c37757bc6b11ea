//! Sensors under the keys' fronts or at the hammers' shanks: a converter's readings of the travel, scan by scan; and
//! contacts under the keys.

use std::collections::{BTreeMap, VecDeque};
use std::io;
use std::sync::{Arc, Mutex, PoisonError};

use erard::Action;
use erard::instrument::Instrument;
use erard::keyboard::KEYS;
use erard::player::ActionError;
use erard_live::blow_m;
use erard_live::profile::Stops;

use crate::sink::{Block, Sink};

/// Column of a row that holds the rise of the hammer.
const RISE: usize = 4;

/// Highest rate of a sensor, Hz: that of an action's steps.
pub const MAX_RATE_HZ: f64 = 20_000.0;
/// A key's stops lie at these shares of the converter's range: a key that bounces at its bottom is not cut off.
const STOPS: [f64; 2] = [0.10, 0.85];
/// A key is off its rest from this travel on, m.
const OFF_M: f64 = 0.05e-3;
/// Time before a key leaves its rest, and after it comes back, for which its readings are sent, s.
const MARGIN_S: f64 = 0.03;

/// A sensor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sensor {
    /// Bits of the converter. The key's travel takes three quarters of its range. Contacts have 1.
    pub bits: u32,
    /// Readings of each key a second, Hz. The keys are read one after the other within a period, as a multiplexer does.
    pub rate_hz: f64,
    /// Standard deviation of the readings, a share of the key's travel.
    pub noise: f64,
}

/// A reading of one key.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Reading {
    /// Instant, us.
    pub time_us: u64,
    /// The key, from 1.
    pub key: usize,
    /// The converter's count; of contacts a bit for each that is closed, the lowest bit for the upper contact.
    pub raw: u32,
}

/// The readings at a key's two stops in counts of a converter with this number of bits, without noise: not whole
/// numbers.
#[must_use]
pub fn stops(bits: u32) -> Stops {
    let full = f64::from(full(bits));
    Stops { rest: STOPS[0] * full, pressed: STOPS[1] * full }
}

fn full(bits: u32) -> u32 {
    u32::MAX >> (32 - bits.clamp(1, 32))
}

impl Sensor {
    /// Its reading at a share of the key's travel, with an error in standard deviations of its noise.
    fn reads(&self, share: f64, deviation: f64) -> u32 {
        let Stops { rest, pressed } = stops(self.bits);
        let exact = rest + (share + self.noise * deviation) * (pressed - rest);
        exact.round().clamp(0.0, f64::from(full(self.bits))) as u32
    }

    /// The instant of a key's scan, us.
    fn time_us(&self, key: usize, scan: u64) -> u64 {
        let turn = (key - 1) as f64 / KEYS as f64;
        (1e6 * (scan as f64 + turn) / self.rate_hz).round() as u64
    }
}

/// One sensor of one key.
#[derive(Debug)]
struct Channel {
    sensor: Sensor,
    key: usize,
    /// Depths at which its contacts close, m, the upper one first; none of a converter.
    depths_m: Vec<f64>,
    /// The contacts that are closed.
    closed: u32,
    /// The next scan.
    scan: u64,
    random: fastrand::Rng,
    /// Readings that are sent if the key leaves its rest within the margin.
    pending: VecDeque<Reading>,
    sent: Vec<Reading>,
}

impl Channel {
    /// Sends which contacts are closed at an instant, us, with the key at a place, m, if others are than before.
    fn take_contacts(&mut self, time_us: u64, x: f64) {
        let bit = |(contact, depth_m): (usize, &f64)| u32::from(x >= *depth_m) << contact;
        let raw = self.depths_m.iter().enumerate().map(bit).sum();
        if raw != self.closed {
            self.closed = raw;
            self.sent.push(Reading { time_us, key: self.key, raw });
        }
    }

    /// The key went straight from one place to the next, s and m; it was off its rest until an instant, s.
    fn follow(&mut self, [t0, x0]: [f64; 2], [t1, x1]: [f64; 2], travel_m: f64, off_until_s: f64) {
        loop {
            let time_us = self.sensor.time_us(self.key, self.scan);
            let t = 1e-6 * time_us as f64;
            if t > t1 {
                return;
            }
            self.scan += 1;
            let share = if t1 > t0 { ((t - t0) / (t1 - t0)).max(0.0) } else { 1.0 };
            let x = x0 + share * (x1 - x0);
            // Every scan takes its own number: what is sent of the others changes no reading.
            let deviation = normal(&mut self.random);
            if !self.depths_m.is_empty() {
                self.take_contacts(time_us, x + self.sensor.noise * deviation * travel_m);
                continue;
            }
            let reading = Reading { time_us, key: self.key, raw: self.sensor.reads(x / travel_m, deviation) };
            if x > OFF_M || t <= off_until_s + MARGIN_S {
                self.sent.extend(self.pending.drain(..));
                self.sent.push(reading);
            } else {
                self.pending.push_back(reading);
                while self.pending.front().is_some_and(|first| 1e-6 * first.time_us as f64 + MARGIN_S < t) {
                    self.pending.pop_front();
                }
            }
        }
    }
}

/// A normal deviate (Box and Muller 1958).
fn normal(random: &mut fastrand::Rng) -> f64 {
    let (u, v) = (1.0 - random.f64(), random.f64());
    libm::sqrt(-2.0 * libm::log(u)) * libm::cos(std::f64::consts::TAU * v)
}

/// A hammer's head on its arc.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Shank {
    /// Distance of the point that strikes from the shank's pin, m.
    radius_m: f64,
    /// That point's height above the pin at rest, m.
    height_m: f64,
    /// Its way on the arc from its rest to the string, m.
    pub way_m: f64,
}

impl Shank {
    /// Of an instrument's hammer; `None` where none meets a string.
    ///
    /// # Errors
    /// [`ActionError`].
    pub fn of(instrument: &Instrument) -> Result<Option<Self>, ActionError> {
        let (roles, bodies) = (&instrument.roles, &instrument.bodies);
        let (Some(hammer), Some(blow_m)) = (roles.hammer, blow_m(instrument)?) else { return Ok(None) };
        // The pin on the ground about which it turns.
        let mut shank = hammer;
        while let Some(parent) = bodies[shank].parent {
            shank = parent;
        }
        let action = Action::new(instrument)?;
        let places = [(hammer, roles.hammer_strike_point_m), (shank, [0.0; 2])];
        let [Ok(head), Ok(pin)] = places.map(|(body, at)| action.point(Some(body), at)) else { return Ok(None) };
        let (radius_m, height_m) = ((head[0] - pin[0]).hypot(head[1] - pin[1]), head[1] - pin[1]);
        let shank = Shank { radius_m, height_m, way_m: 0.0 };
        Ok(Some(Shank { way_m: shank.arc_m(blow_m), ..shank }))
    }

    /// Way on the arc, m, at a rise, m.
    fn arc_m(&self, rise_m: f64) -> f64 {
        let angle = |height_m: f64| libm::asin((height_m / self.radius_m).clamp(-1.0, 1.0));
        self.radius_m * (angle(self.height_m + rise_m) - angle(self.height_m))
    }
}

/// All sensors of one key.
#[derive(Debug)]
pub(super) struct Sampler {
    travel_m: f64,
    /// The hammer, where that is sensed.
    shank: Option<Shank>,
    channels: Vec<Channel>,
    /// The last place, s and m.
    last: [f64; 2],
    off_until_s: f64,
}

impl Sampler {
    /// Takes the position of the key's front and the rise of the hammer, m, at an instant, s. Between two positions
    /// they move linearly.
    pub(super) fn take(&mut self, time_s: f64, [key_m, rise_m]: [f64; 2]) {
        self.take_sensed(time_s, self.shank.map_or(key_m, |shank| shank.arc_m(rise_m)));
    }

    fn take_sensed(&mut self, time_s: f64, sensed_m: f64) {
        let to = [time_s, sensed_m];
        for channel in &mut self.channels {
            channel.follow(self.last, to, self.travel_m, self.off_until_s);
        }
        if sensed_m > OFF_M {
            self.off_until_s = time_s;
        }
        self.last = to;
    }
}

/// The sensors of a keyboard.
#[derive(Debug)]
pub struct Scans {
    sensors: Vec<Sensor>,
    seed: u64,
    /// Travel of each key's front between its stops, m, from the lowest key.
    travels_m: Vec<f64>,
    /// Hammers, from the lowest, where these are sensed.
    shanks: Vec<Option<Shank>>,
    /// Depths at which the contacts of every key close, m, where there are contacts.
    depths_m: Vec<f64>,
    samplers: Mutex<BTreeMap<usize, Arc<Mutex<Sampler>>>>,
}

struct Sampling(Arc<Mutex<Sampler>>);

impl Sink for Sampling {
    fn take(&mut self, block: Block) -> io::Result<()> {
        if let Block::Rows(rows) = block {
            let mut sampler = self.0.lock().unwrap_or_else(PoisonError::into_inner);
            rows.iter().for_each(|row| sampler.take(row[0], [row[1], row[RISE]]));
        }
        Ok(())
    }
}

impl Scans {
    /// Sensors of keys with such travels between their stops, m, from the lowest key. The same seed gives the same
    /// noise.
    #[must_use]
    pub fn new(sensors: &[Sensor], travels_m: Vec<f64>, seed: u64) -> Self {
        let (sensors, samplers) = (sensors.to_vec(), Mutex::default());
        Scans { sensors, seed, travels_m, shanks: Vec::new(), depths_m: Vec::new(), samplers }
    }

    /// Contacts under keys with such travels, m, that close at these depths of the keys' fronts, m, the upper one
    /// first. The noise of a sensor is that of the place which a scan finds. Readings are sent where they change.
    #[must_use]
    pub fn of_contacts(sensors: &[Sensor], travels_m: Vec<f64>, depths_m: &[f64], seed: u64) -> Self {
        Scans { depths_m: depths_m.to_vec(), ..Scans::new(sensors, travels_m, seed) }
    }

    /// Sensors of hammers, from the lowest key; `None` for keys that are not played. The same seed gives the same
    /// noise.
    #[must_use]
    pub fn of_hammers(sensors: &[Sensor], shanks: Vec<Option<Shank>>, seed: u64) -> Self {
        let travels_m = shanks.iter().map(|shank| shank.map_or(f64::INFINITY, |shank| shank.way_m)).collect();
        Scans { shanks, ..Scans::new(sensors, travels_m, seed) }
    }

    /// Whether hammers are sensed.
    pub(super) fn are_hammers(&self) -> bool {
        !self.shanks.is_empty()
    }

    /// The sampler of a key, always the same one.
    pub(super) fn sampler(&self, key: usize) -> Arc<Mutex<Sampler>> {
        let make = || {
            let random = |index: usize| fastrand::Rng::with_seed(self.seed << 16 ^ (index as u64) << 8 ^ key as u64);
            let channel = |(index, &sensor): (usize, &Sensor)| Channel {
                sensor,
                key,
                depths_m: self.depths_m.clone(),
                closed: 0,
                scan: 0,
                random: random(index),
                pending: VecDeque::new(),
                sent: Vec::new(),
            };
            let travel_m = self.travels_m.get(key - 1).copied().unwrap_or(f64::INFINITY);
            let channels = self.sensors.iter().enumerate().map(channel).collect();
            let shank = self.shanks.get(key - 1).copied().flatten();
            Arc::new(Mutex::new(Sampler { travel_m, shank, channels, last: [0.0; 2], off_until_s: f64::NEG_INFINITY }))
        };
        let mut samplers = self.samplers.lock().unwrap_or_else(PoisonError::into_inner);
        Arc::clone(samplers.entry(key).or_insert_with(make))
    }

    /// The sink for a key's rows in a performance, one for each step ([`crate::Options::row_s`] of 0).
    #[must_use]
    pub fn sink(&self, key: usize) -> Box<dyn Sink> {
        Box::new(Sampling(self.sampler(key)))
    }

    /// The readings of each sensor, in the order of time, then of keys. A key is read while it is off its rest, and 30
    /// ms before and after.
    #[must_use]
    pub fn readings(self) -> Vec<Vec<Reading>> {
        let samplers = self.samplers.into_inner().unwrap_or_else(PoisonError::into_inner);
        let mut all: Vec<Vec<Reading>> = vec![Vec::new(); self.sensors.len()];
        for sampler in samplers.into_values() {
            let mut sampler = sampler.lock().unwrap_or_else(PoisonError::into_inner);
            // What was sent last is followed by its margin.
            let [last_s, last_m] = sampler.last;
            sampler.take_sensed(last_s + MARGIN_S, last_m);
            for (own, channel) in all.iter_mut().zip(&mut sampler.channels) {
                own.append(&mut channel.sent);
            }
        }
        all.iter_mut().for_each(|own| own.sort_unstable());
        all
    }
}

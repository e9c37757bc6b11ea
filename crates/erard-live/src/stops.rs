//! The two stops of a key, from its readings. Without a heap.
//!
//! The key was left at rest, pressed to its bottom, held there, and let go, as often as you like. A key is still at its
//! stops only, so readings that stay equal for 50 ms gather there. The first such reading is its rest, the farthest
//! from it its bottom. The stops are the medians of these readings.

use crate::converter::Stops;

/// A key that stays within [`STILL`] of its range for this time is still, s.
const STANDS_S: f64 = 0.05;
/// A share of the range.
const STILL: f64 = 0.01;
/// Still readings this near to a stop belong to it, as a share of the range.
const BESIDE: f64 = 0.02;
/// The range must be at least this multiple of the largest noise at the rest.
const CLEAR: f64 = 8.0;

/// Why a key's stops are not found.
#[derive(Debug, Clone, Copy, PartialEq)]
#[non_exhaustive]
pub enum StopsFault {
    /// There are too few readings of the key.
    Few {
        /// Number of the key, from 1.
        key: usize,
        /// Number of readings.
        found: usize,
    },
    /// The readings never change.
    Stuck {
        /// Number of the key, from 1.
        key: usize,
        /// The reading.
        found: f64,
    },
    /// The range of the readings is too small compared with the noise.
    Noise {
        /// Number of the key, from 1.
        key: usize,
        /// The lowest.
        low: f64,
        /// The highest.
        high: f64,
        /// Largest change between neighbours at rest.
        noise: f64,
    },
    /// The key is still only at its rest.
    NotHeld {
        /// Number of the key, from 1.
        key: usize,
    },
}

/// Result of a key's calibration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Found {
    /// Readings at its stops.
    pub stops: Stops,
    /// Standard deviation of readings at rest, a share of the range.
    pub noise: f64,
    /// Drift of the readings at rest from the beginning of the recording to its end, as a share of the range.
    pub drift: f64,
    /// Readings.
    pub count: usize,
}

impl core::fmt::Display for StopsFault {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            StopsFault::Few { key, found } => write!(
                f,
                "key {key}: {found} readings; expected the key at rest for half a second, pressed and held, and let go"
            ),
            StopsFault::Stuck { key, found } => {
                write!(f, "key {key}: the reading is {found} all the time; is the sensor stuck?")
            }
            StopsFault::Noise { key, low, high, noise } => write!(
                f,
                "key {key}: readings go from {low} to {high} with a noise of {noise}; expected a range 8 times as wide"
            ),
            StopsFault::NotHeld { key } => {
                write!(f, "key {key}: it is never held for 50 ms; press it to the bottom and hold it there")
            }
        }
    }
}

impl core::error::Error for StopsFault {}

/// An interval in which a key is still.
#[derive(Debug, Clone, Copy)]
pub struct Still {
    /// Mean of its readings.
    mean: f64,
    /// Mean square deviation from it.
    square: f64,
}

/// The readings of one key: instants, s, ascending, and values, by their index.
#[derive(Debug, Clone, Copy)]
pub struct Seen<F> {
    key: usize,
    count: usize,
    at: F,
    range: f64,
    noise: f64,
}

impl<F: Fn(usize) -> [f64; 2] + Copy> Seen<F> {
    /// Reads all of them.
    ///
    /// # Errors
    /// [`StopsFault`].
    pub fn of(key: usize, count: usize, at: F) -> Result<Self, StopsFault> {
        let few = StopsFault::Few { key, found: count };
        let Some(last) = count.checked_sub(1) else { return Err(few) };
        let ([first_s, first], [last_s, _]) = (at(0), at(last));
        if count < 20 || last_s - first_s < 3.0 * STANDS_S {
            return Err(few);
        }
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        let (mut noise, mut before) = (0.0_f64, Some(first));
        for index in 0..count {
            let [time_s, reading] = at(index);
            (low, high) = (low.min(reading), high.max(reading));
            let is_first = time_s - first_s < STANDS_S;
            noise = noise.max(before.filter(|_| is_first).map_or(0.0, |before| (reading - before).abs()));
            before = is_first.then_some(reading);
        }
        let range = high - low;
        if range == 0.0 {
            return Err(StopsFault::Stuck { key, found: low });
        }
        if range < CLEAR * noise {
            return Err(StopsFault::Noise { key, low, high, noise });
        }
        Ok(Seen { key, count, at, range, noise })
    }

    /// The intervals in which the key is still. They are found anew each time: keep them where there is a heap.
    pub fn still(&self) -> impl Iterator<Item = Still> + Clone {
        let Seen { count, at, range, noise, .. } = *self;
        let (width, mut from) = (STILL * range + noise, 0);
        core::iter::from_fn(move || {
            while from < count {
                let [first_s, first] = at(from);
                let (mut low, mut high, mut to, mut last_s) = (first, first, from, first_s);
                while to < count && at(to)[0] - first_s < STANDS_S {
                    let [time_s, reading] = at(to);
                    (low, high, last_s) = (low.min(reading), high.max(reading), time_s);
                    to += 1;
                }
                let is_whole = to < count || last_s - first_s > 0.8 * STANDS_S;
                if is_whole && high - low <= width && to > from + 1 {
                    let number = (to - from) as f64;
                    let mean = (from..to).map(|i| at(i)[1]).sum::<f64>() / number;
                    let square = (from..to).map(|i| (at(i)[1] - mean) * (at(i)[1] - mean)).sum::<f64>() / number;
                    from = to;
                    return Some(Still { mean, square });
                }
                from += 1;
            }
            None
        })
    }

    /// The stops, from [`Seen::still`].
    ///
    /// # Errors
    /// [`StopsFault`].
    pub fn found(&self, still: impl Iterator<Item = Still> + Clone) -> Result<Found, StopsFault> {
        let Seen { key, count, range, .. } = *self;
        let Some(first) = still.clone().next() else { return Err(StopsFault::NotHeld { key }) };
        let rest_0 = first.mean;
        let farthest = |a: &Still, b: &Still| (a.mean - rest_0).abs().total_cmp(&(b.mean - rest_0).abs());
        let bottom_0 = still.clone().max_by(farthest).map_or(rest_0, |one| one.mean);
        if (bottom_0 - rest_0).abs() < 0.5 * range {
            return Err(StopsFault::NotHeld { key });
        }
        let around = |at: f64| {
            let own = still.clone().filter(move |one| (one.mean - at).abs() < BESIDE * range);
            let (number, sum) = own.clone().fold((0, 0.0), |(n, sum), one| (n + 1, sum + one.square));
            let early = own.clone().next().map_or(0.0, |one| one.mean);
            let late = own.clone().last().map_or(0.0, |one| one.mean);
            (median(own.map(|one| one.mean), number), sum / number as f64, late - early)
        };
        let ((rest, square, drift), (pressed, ..)) = (around(rest_0), around(bottom_0));
        let span = (pressed - rest).abs();
        Ok(Found { stops: Stops { rest, pressed }, noise: libm::sqrt(square) / span, drift: drift / span, count })
    }
}

/// The median of `count` numbers, the upper one of two, found by bisection in their order, without room for them.
fn median(all: impl Iterator<Item = f64> + Clone, count: usize) -> f64 {
    // The order of numbers as one of integers, and back (as `f64::total_cmp`).
    let order = |number: f64| {
        let bits = number.to_bits() as i64;
        bits ^ ((bits >> 63) as u64 >> 1) as i64
    };
    let number = |order: i64| f64::from_bits((order ^ ((order >> 63) as u64 >> 1) as i64) as u64);
    let keys = all.map(order);
    let (mut low, mut high) = (i64::MAX, i64::MIN);
    keys.clone().for_each(|key| (low, high) = (low.min(key), high.max(key)));
    while low < high {
        // Rounded down, without overflow.
        let middle = ((i128::from(low) + i128::from(high)) >> 1) as i64;
        if keys.clone().filter(|key| *key <= middle).count() > count / 2 { high = middle } else { low = middle + 1 }
    }
    number(low)
}

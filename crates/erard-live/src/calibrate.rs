//! Finds the two stops of each key in readings of a device that is played for this purpose.
//!
//! Leave every key at rest for half a second, press it to its bottom, hold it there, and let it go; repeat this as
//! often as you like. A key is still at its stops only, so readings that stay equal for 50 ms gather there. The first
//! such reading is its rest, the farthest from it its bottom. The stops are the medians of these readings.

use std::collections::BTreeMap;

use crate::profile::Stops;

/// A key that stays within [`STILL`] of its range for this time is still, s.
const STANDS_S: f64 = 0.05;
/// A share of the range.
const STILL: f64 = 0.01;
/// Still readings this near to a stop belong to it, as a share of the range.
const BESIDE: f64 = 0.02;
/// The range must be at least this multiple of the largest noise at the rest.
const CLEAR: f64 = 8.0;

/// Readings of one key.
#[derive(Debug, Clone, Default)]
pub struct Readings {
    /// Instants, s, and readings.
    pub all: Vec<[f64; 2]>,
}

/// Why a key's stops are not found.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum StopsFault {
    /// There are too few readings of the key.
    #[error("key {key}: {found} readings; expected the key at rest for half a second, pressed and held, and let go")]
    Few {
        /// Number of the key, from 1.
        key: usize,
        /// Number of readings.
        found: usize,
    },
    /// The readings never change.
    #[error("key {key}: the reading is {found} all the time; is the sensor stuck?")]
    Stuck {
        /// Number of the key, from 1.
        key: usize,
        /// The reading.
        found: f64,
    },
    /// The range of the readings is too small compared with the noise.
    #[error("key {key}: readings go from {low} to {high} with a noise of {noise}; expected a range 8 times as wide")]
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
    #[error("key {key}: it is never held for 50 ms; press it to the bottom and hold it there")]
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

/// Finds the stops of all keys.
///
/// # Errors
/// [`StopsFault`] of the first key that cannot be calibrated.
pub fn stops(readings: &BTreeMap<usize, Readings>) -> Result<BTreeMap<usize, Found>, StopsFault> {
    readings.iter().map(|(key, one)| Ok((*key, of_key(*key, &one.all)?))).collect()
}

/// Keys whose range of readings is unlike that of the others, with its ratio to the median of all: less than two thirds
/// of it, more than one and a half times as much, or of the other sign. None of fewer than three keys. Sensors of one
/// kind differ by less; a key that was not pressed to its bottom, or a sensor that sits elsewhere, by more.
#[must_use]
pub fn unlike(found: &BTreeMap<usize, Found>) -> Vec<(usize, f64)> {
    let range = |one: &Found| one.stops.pressed - one.stops.rest;
    let mut all: Vec<f64> = found.values().map(range).collect();
    all.sort_by(f64::total_cmp);
    if all.len() < 3 {
        return Vec::new();
    }
    let middle = all[all.len() / 2];
    let ratios = found.iter().map(|(key, one)| (*key, range(one) / middle));
    ratios.filter(|(_, ratio)| !(2.0 / 3.0..=1.5).contains(ratio)).collect()
}

fn of_key(key: usize, all: &[[f64; 2]]) -> Result<Found, StopsFault> {
    let few = StopsFault::Few { key, found: all.len() };
    let ([first_s, _], [last_s, _]) = match (all.first(), all.last()) {
        (Some(first), Some(last)) => (*first, *last),
        _ => return Err(few),
    };
    if all.len() < 20 || last_s - first_s < 3.0 * STANDS_S {
        return Err(few);
    }
    let low = all.iter().map(|[_, x]| *x).fold(f64::INFINITY, f64::min);
    let high = all.iter().map(|[_, x]| *x).fold(f64::NEG_INFINITY, f64::max);
    let range = high - low;
    if range == 0.0 {
        return Err(StopsFault::Stuck { key, found: low });
    }
    let at_first: Vec<f64> = all.iter().take_while(|[t, _]| t - first_s < STANDS_S).map(|[_, x]| *x).collect();
    let noise = at_first.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f64::max);
    if range < CLEAR * noise {
        return Err(StopsFault::Noise { key, low, high, noise });
    }
    let still = standing(all, STILL * range + noise);
    let Some(first) = still.first() else { return Err(StopsFault::NotHeld { key }) };
    let rest_0 = first.mean;
    let farthest = |a: &&Still, b: &&Still| (a.mean - rest_0).abs().total_cmp(&(b.mean - rest_0).abs());
    let bottom_0 = still.iter().max_by(farthest).map_or(rest_0, |one| one.mean);
    if (bottom_0 - rest_0).abs() < 0.5 * range {
        return Err(StopsFault::NotHeld { key });
    }
    let around = |at: f64| {
        let own: Vec<&Still> = still.iter().filter(|one| (one.mean - at).abs() < BESIDE * range).collect();
        let mut means: Vec<f64> = own.iter().map(|one| one.mean).collect();
        means.sort_by(f64::total_cmp);
        let square = own.iter().map(|one| one.square).sum::<f64>() / own.len() as f64;
        let ends = [own.first(), own.last()].map(|one| one.map_or(0.0, |one| one.mean));
        (means[means.len() / 2], square, ends)
    };
    let ((rest, square, [early, late]), (pressed, ..)) = (around(rest_0), around(bottom_0));
    let span = (pressed - rest).abs();
    let (noise, drift) = (square.sqrt() / span, (late - early) / span);
    Ok(Found { stops: Stops { rest, pressed }, noise, drift, count: all.len() })
}

/// An interval in which a key is still: mean and mean square deviation of its readings.
struct Still {
    mean: f64,
    square: f64,
}

/// Intervals of [`STANDS_S`] in which readings stay within a width.
fn standing(all: &[[f64; 2]], width: f64) -> Vec<Still> {
    let (mut found, mut from) = (Vec::new(), 0);
    while from < all.len() {
        let (mut low, mut high, mut to) = (all[from][1], all[from][1], from);
        while to < all.len() && all[to][0] - all[from][0] < STANDS_S {
            (low, high) = (low.min(all[to][1]), high.max(all[to][1]));
            to += 1;
        }
        let is_whole = to < all.len() || all[to - 1][0] - all[from][0] > 0.8 * STANDS_S;
        if is_whole && high - low <= width && to > from + 1 {
            let count = (to - from) as f64;
            let mean = all[from..to].iter().map(|[_, x]| x).sum::<f64>() / count;
            let square = all[from..to].iter().map(|[_, x]| (x - mean) * (x - mean)).sum::<f64>() / count;
            found.push(Still { mean, square });
            from = to;
        } else {
            from += 1;
        }
    }
    found
}

//! Finds the two stops of each key in readings of a device that is played for this purpose.
//!
//! Leave every key at rest for half a second, press it to its bottom, hold it there, and let it go; repeat this as
//! often as you like. [`crate::stops`] finds the stops of one key, without a heap.

use std::collections::BTreeMap;

pub use crate::stops::{Found, StopsFault};
use crate::stops::{Seen, Still};

/// Readings of one key.
#[derive(Debug, Clone, Default)]
pub struct Readings {
    /// Instants, s, and readings.
    pub all: Vec<[f64; 2]>,
}

/// Finds the stops of all keys.
///
/// # Errors
/// [`StopsFault`] of the first key that cannot be calibrated.
pub fn stops(readings: &BTreeMap<usize, Readings>) -> Result<BTreeMap<usize, Found>, StopsFault> {
    let found = readings.iter().map(|(key, one)| {
        let seen = Seen::of(*key, one.all.len(), |index| one.all[index])?;
        let still: Vec<Still> = seen.still().collect();
        Ok((*key, seen.found(still.iter().copied())?))
    });
    found.collect()
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

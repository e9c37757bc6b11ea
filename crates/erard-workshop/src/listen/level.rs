//! The level of a sound over time.

use super::decay::{Decay, Point, decay};
use super::scale::db;

/// Window of the largest level, s.
pub(super) const LOUDEST_S: f64 = 20e-3;
/// Windows of the level as it falls, s: the first that is a tenth of the time to -20 dB or less.
const WINDOWS_S: [f64; 6] = [0.1, 0.05, 0.025, 0.0125, 6.25e-3, 3.125e-3];
/// Share of the time to -20 dB that a window may last.
pub(super) const SHARE: f64 = 0.1;
/// Window of the onset, s, and its level below the largest one, dB.
const ONSET_S: f64 = 5e-3;
const ONSET_DB: f64 = 20.0;
/// Falls that are timed, dB.
const FALLS_DB: [f64; 3] = [10.0, 20.0, 40.0];
/// Levels a window.
const FINENESS: f64 = 8.0;
/// What a level is above that of the time before the note, dB; else it is noise.
const ABOVE_NOISE_DB: f64 = 10.0;
/// Time before the note from which its noise is known, s.
const BEFORE_S: f64 = 0.05;

/// Mean power of all channels, as running sums.
pub(super) struct Power {
    /// Sum of the samples before each one.
    sums: Vec<f64>,
    rate_hz: f64,
}

/// The loudest window.
pub(super) struct Loudest {
    pub level_db: f64,
    /// Its middle, s.
    pub time_s: f64,
}

impl Power {
    pub fn new(channels: &[Vec<f64>], rate_hz: f64) -> Self {
        let length = channels.first().map_or(0, Vec::len);
        let mut sums = Vec::with_capacity(length + 1);
        let (mut sum, share) = (0.0, 1.0 / channels.len() as f64);
        sums.push(sum);
        for n in 0..length {
            sum += share * channels.iter().map(|one| one[n] * one[n]).sum::<f64>();
            sums.push(sum);
        }
        Power { sums, rate_hz }
    }

    fn length(&self) -> usize {
        self.sums.len() - 1
    }

    fn window(&self, window_s: f64) -> usize {
        ((window_s * self.rate_hz).round() as usize).clamp(1, self.length())
    }

    /// Mean power of a window from a sample on.
    fn mean(&self, from: usize, window: usize) -> f64 {
        ((self.sums[from + window] - self.sums[from]) / window as f64).max(0.0)
    }

    /// First sample and mean power of the strongest window.
    fn strongest(&self, window: usize) -> (usize, f64) {
        let powers = (0..=self.length() - window).map(|from| (from, self.mean(from, window)));
        powers.fold((0, 0.0), |best, one| if one.1 > best.1 { one } else { best })
    }

    /// The loudest window of a length, s.
    pub fn loudest(&self, window_s: f64) -> Loudest {
        let window = self.window(window_s);
        let (from, power) = self.strongest(window);
        Loudest { level_db: db(power), time_s: (from as f64 + 0.5 * window as f64) / self.rate_hz }
    }

    /// The sample at which the note begins: the middle of the first window of 5 ms within 20 dB of the strongest.
    pub fn onset(&self) -> usize {
        let window = self.window(ONSET_S);
        let (strongest, power) = self.strongest(window);
        let least = power * libm::pow(10.0, -ONSET_DB / 10.0);
        (0..strongest).find(|from| self.mean(*from, window) >= least).unwrap_or(strongest) + window / 2
    }

    /// Levels of windows from an instant on, with their middles counted from it.
    fn levels(&self, from_s: f64, window_s: f64) -> impl Iterator<Item = Point> {
        let window = self.window(window_s);
        let hop = ((window as f64 / FINENESS) as usize).max(1);
        let first = (from_s * self.rate_hz) as usize;
        let middles = (first..).step_by(hop).take_while(move |middle| middle + window.div_ceil(2) <= self.length());
        middles.filter(move |middle| *middle >= window / 2).map(move |middle| Point {
            time_s: middle as f64 / self.rate_hz - from_s,
            level_db: db(self.mean(middle - window / 2, window)),
        })
    }

    /// Time from the middle of the loudest window until a window's level is so far below it, s.
    fn fall_s(&self, fall_db: f64, window_s: f64) -> Option<f64> {
        let loudest = self.loudest(window_s);
        let below_db = loudest.level_db - fall_db;
        let mut before = Point { time_s: 0.0, level_db: loudest.level_db };
        for point in self.levels(loudest.time_s, window_s) {
            if point.level_db <= below_db {
                let share = (before.level_db - below_db) / (before.level_db - point.level_db).max(1e-9);
                return Some(before.time_s + share.clamp(0.0, 1.0) * (point.time_s - before.time_s));
            }
            before = point;
        }
        None
    }

    /// The window in which the level is measured, s: a tenth of the time to -20 dB or less. `None` where the fall is
    /// faster than the shortest window resolves.
    pub fn window_s(&self) -> Option<f64> {
        let is_short =
            |window_s: &f64| self.fall_s(FALLS_DB[1], *window_s).is_none_or(|fall_s| *window_s <= SHARE * fall_s);
        WINDOWS_S.into_iter().find(is_short)
    }

    /// Times until the level of windows is 10, 20 and 40 dB below the loudest, s.
    pub fn falls(&self, window_s: f64) -> [Option<f64>; 3] {
        FALLS_DB.map(|fall_db| self.fall_s(fall_db, window_s))
    }

    /// Decay of the level.
    pub fn decay(&self, window_s: f64, fall_s: Option<f64>) -> Option<Decay> {
        let before = self.window(BEFORE_S);
        let noise_db = if self.onset() >= 2 * before { db(self.mean(0, before)) } else { f64::NEG_INFINITY };
        let points: Vec<Point> = self.levels(self.loudest(window_s).time_s, window_s).collect();
        decay(&points, window_s, fall_s, &|_| noise_db + ABOVE_NOISE_DB)
    }
}

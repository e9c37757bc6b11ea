//! How long after the simulated impact its bytes were handed over.

use std::time::Instant;

use serde::Serialize;

/// A note is late with more, s.
pub(crate) const LATE_S: f64 = 1e-3;
/// By so much the sender's clock may differ from this machine's, a share.
const DRIFT: f64 = 100e-6;

/// The sender's clock on this machine: the line that took the shortest way tells it.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Clock {
    begins: Instant,
    /// This machine's time less the sender's, s, and when that was known, s.
    offset: Option<[f64; 2]>,
}

/// What came of all notes.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub(crate) struct Latency {
    /// Note-ons that were not announced.
    pub notes: usize,
    /// Half of them took less than this from the simulated impact to the bytes, ms.
    pub p50_ms: f64,
    /// 99 of 100.
    pub p99_ms: f64,
    /// 999 of 1000.
    pub p999_ms: f64,
    /// The longest.
    pub longest_ms: f64,
    /// Those that took more than 1 ms.
    pub late: usize,
}

impl Clock {
    pub(crate) fn new() -> Self {
        Clock { begins: Instant::now(), offset: None }
    }

    /// A line of an instant of the sender's, s, came.
    pub(crate) fn came(&mut self, time_s: f64, at: Instant) {
        let now_s = at.saturating_duration_since(self.begins).as_secs_f64();
        let found_s = now_s - time_s;
        let known_s = self.offset.map(|[offset_s, known_s]| offset_s + DRIFT * (now_s - known_s));
        self.offset = Some([known_s.map_or(found_s, |known_s| known_s.min(found_s)), now_s]);
    }

    /// How long ago an instant of the sender's was, s.
    pub(crate) fn since_s(&self, time_s: f64) -> f64 {
        let [offset_s, _] = self.offset.unwrap_or_default();
        self.begins.elapsed().as_secs_f64() - offset_s - time_s
    }
}

impl Latency {
    /// Of all times, s.
    pub(crate) fn of(mut all: Vec<f64>) -> Self {
        all.sort_by(f64::total_cmp);
        let at = |share: f64| {
            let place = ((share * all.len() as f64) as usize).min(all.len().saturating_sub(1));
            1e3 * all.get(place).copied().unwrap_or(0.0)
        };
        let late = all.iter().filter(|s| **s > LATE_S).count();
        Latency { notes: all.len(), p50_ms: at(0.5), p99_ms: at(0.99), p999_ms: at(0.999), longest_ms: at(1.0), late }
    }
}

//! Errors from the bits and the rate of a sensor.
//!
//! There are two errors of the hammer speed, in counts of velocity: one from the converter's steps, largest at pp, and
//! one from the motion between two samples, largest at ff and proportional to the square of the period. A test measures
//! them: it samples and rounds presses of the concert grand from pp to ff and plays them again.

/// Fewer bits over a key's travel cause a warning.
pub const FEWEST_BITS: f64 = 10.0;
/// A lower rate causes a warning, Hz.
pub const LOWEST_HZ: f64 = 500.0;
/// Root mean square error at pp, counts, by bits.
const BY_BITS: [[f64; 2]; 3] = [[7.0, 1.4], [10.0, 0.23], [12.0, 0.08]];
/// At ff, counts, at 250 Hz.
const AT_250_HZ: f64 = 1.0;

/// The expected error of a hammer speed, in counts of velocity (2.8 % of the speed each), for a number of bits over a
/// key's travel and of samples a second. An estimate for hands that press; noise adds to it.
#[must_use]
pub fn expected_error_counts(bits: f64, rate_hz: f64) -> f64 {
    let above = BY_BITS.iter().position(|[b, _]| bits <= *b).unwrap_or(2).max(1);
    let ([b0, e0], [b1, e1]) = (BY_BITS[above - 1], BY_BITS[above]);
    let steps = e0 * (e1 / e0).powf((bits - b0) / (b1 - b0));
    let between = AT_250_HZ * (250.0 / rate_hz).powi(2);
    steps.hypot(between)
}

/// Observed resolution and rate of a sensor.
#[derive(Debug, Clone, Default)]
pub struct Seen {
    intervals_s: Vec<f64>,
    least_step_m: Option<f64>,
    next: usize,
}

/// Number of intervals that are kept.
const KEPT: usize = 2048;

impl Seen {
    /// Takes two samples of a moving key: the time between them, s, and the distance, m.
    pub fn take(&mut self, interval_s: f64, step_m: f64) {
        if step_m != 0.0 {
            self.least_step_m = Some(self.least_step_m.map_or(step_m.abs(), |least| least.min(step_m.abs())));
        }
        if self.intervals_s.len() < KEPT {
            self.intervals_s.push(interval_s);
        } else {
            self.intervals_s[self.next % KEPT] = interval_s;
        }
        self.next += 1;
    }

    /// Median number of samples a second of a key; `None` before any key has moved.
    #[must_use]
    pub fn rate_hz(&self) -> Option<f64> {
        let mut all = self.intervals_s.clone();
        all.sort_by(f64::total_cmp);
        all.get(all.len() / 2).map(|middle_s| 1.0 / middle_s)
    }

    /// Bits over a travel, m, from the smallest step that was observed.
    #[must_use]
    pub fn bits(&self, travel_m: f64) -> Option<f64> {
        self.least_step_m.map(|step_m| (travel_m / step_m).log2())
    }
}

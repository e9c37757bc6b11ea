//! Levels and pitches as numbers.

/// A power as a level, dB.
pub(super) fn db(power: f64) -> f64 {
    10.0 * power.max(1e-30).log10()
}

/// Frequency of a key in equal temperament at A4 = 440 Hz, Hz.
#[must_use]
pub fn tempered_hz(key: usize) -> f64 {
    440.0 * libm::exp2((key as f64 - 49.0) / 12.0)
}

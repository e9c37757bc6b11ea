//! The spectrogram of a sound.

use std::f64::consts::PI;

use erard::recording::Fourier;
use erard_figures::Picture;
use erard_figures::figure::Spectrogram;

/// Samples under one window; 85 ms at 48 kHz, so that partials of the lowest notes stand apart.
const WINDOW: usize = 4096;
/// Columns and rows at most, and the highest frequency shown, Hz.
const COLUMNS: usize = 160;
const ROWS: usize = 200;
const MAX_HZ: f64 = 10e3;
/// Below the loudest place, dB.
const RANGE_DB: f64 = 90.0;

/// Levels of a sound, dB below the loudest place and at least -[`RANGE_DB`]: columns of rows, the lowest frequency
/// first. Columns share the duration equally, and each has its window around its middle: a tone that begins is half as
/// strong there as later.
fn levels(samples: &[f64], rate_hz: f64) -> Vec<Vec<f64>> {
    let columns = samples.len().clamp(1, COLUMNS);
    let transform = Fourier::of(WINDOW);
    let weight = |i: usize| 0.5 - 0.5 * (2.0 * PI * i as f64 / WINDOW as f64).cos();
    let bins = (MAX_HZ / rate_hz * WINDOW as f64) as usize;
    let column = |index: usize| -> Vec<f64> {
        let middle = (2 * index + 1) * samples.len() / (2 * columns);
        // Before the sound and after it there is silence.
        let at = |i: usize| (middle + i).checked_sub(WINDOW / 2).and_then(|i| samples.get(i)).copied().unwrap_or(0.0);
        let squares = transform.squares((0..WINDOW).map(|i| weight(i) * at(i)));
        (0..ROWS)
            .map(|row| {
                let (low, high) = (row * bins / ROWS, ((row + 1) * bins / ROWS).max(row * bins / ROWS + 1));
                squares[low..high].iter().copied().fold(0.0, f64::max)
            })
            .collect()
    };
    let powers: Vec<Vec<f64>> = (0..columns).map(column).collect();
    let loudest = powers.iter().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
    let level = |power: f64| (10.0 * (power / loudest).max(1e-30).log10()).max(-RANGE_DB);
    powers.into_iter().map(|column| column.into_iter().map(level).collect()).collect()
}

/// The spectrogram of samples, so many a second; `what` they are.
pub(crate) fn spectrogram_picture(samples: &[f64], rate_hz: f64, title: &str, what: &str) -> Picture {
    let blackness = |column: Vec<f64>| column.into_iter().map(|level| level / RANGE_DB + 1.0).collect();
    let spectrogram = Spectrogram {
        title: title.to_owned(),
        subtitle: format!(
            "{what}; {RANGE_DB:.0} dB from white to black; each place shows {:.0} ms around it",
            1e3 * WINDOW as f64 / rate_hz
        ),
        levels: levels(samples, rate_hz).into_iter().map(blackness).collect(),
        duration_s: samples.len() as f64 / rate_hz,
        highest_hz: MAX_HZ,
    };
    spectrogram.picture()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A tone of 3 kHz that begins half-way: its row is loud from there on, and others are not.
    #[test]
    fn a_tone_is_where_it_sounds() {
        let tone = |i: usize| if i < 24_000 { 0.0 } else { (2.0 * PI * 3e3 * i as f64 / 48e3).sin() };
        let samples: Vec<f64> = (0..48_000).map(tone).collect();
        let levels = levels(&samples, 48e3);
        let row = (3e3 / MAX_HZ * ROWS as f64) as usize;
        let of = |share: f64| &levels[(share * levels.len() as f64) as usize];
        let near = |column: &Vec<f64>| column[row - 1..=row + 1].iter().copied().fold(-1e3, f64::max);
        assert!(near(of(0.8)) > -1.0 && near(of(0.2)) < -80.0);
        assert!(of(0.8)[row + 20] < -80.0 && of(0.8)[row - 20] < -80.0);
        // It begins where it does: nothing half a window earlier, half of its amplitude (-6 dB) there, all of it half a
        // window later.
        let half = WINDOW as f64 / 2.0 / 48e3;
        let at = |time_s: f64| near(of(time_s));
        assert!(at(0.5 - half - 0.01) < -80.0 && at(0.5 + half + 0.01) > -0.1);
        assert!((at(0.5) + 6.0).abs() < 1.5, "{}", at(0.5));
        assert!(spectrogram_picture(&samples, 48e3, "a < b", "force").svg().contains("a &lt; b"));
    }
}

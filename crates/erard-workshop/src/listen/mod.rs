//! Measures of single notes from their sound, recorded or modelled: level, decay, partials, inharmonicity, centroid.
//!
//! [`listen`] measures one note; [`summary`] gathers a key's notes of several loudnesses. Recordings of a piano and the
//! model's sound go through the same code, so that their rows can be compared.
//!
//! A level is the mean power of all channels in a window, dB; 0 dB is a constant of 1 in every channel (full scale of
//! a file, 1 N of a modelled force on the bridge). The effective length of a window, the reciprocal of its noise
//! bandwidth, is a tenth of the time in which what it measures falls by 20 dB, or less.

mod decay;
mod level;
mod partial;
mod scale;
mod spectrum;
mod summary;

pub use decay::{Decay, Shape};
pub use scale::tempered_hz;
pub use summary::{DecaySummary, NoteSummary, PartialSummary, Spread, summary};

use level::{LOUDEST_S, Power};
use spectrum::Spectrum;
use thiserror::Error;

use erard::key::{KEYS, note_name};

/// Number of partials whose decay is measured.
pub const PARTIALS: usize = 6;
/// Sampling rates, 1/s.
const RATES_HZ: [f64; 2] = [8e3, 768e3];
/// Most channels.
const MAX_CHANNELS: usize = 64;
/// Below this level there is no note, dB.
const SILENCE_DB: f64 = -100.0;
/// A note lasts at least as long, s.
const SHORTEST_S: f64 = 0.2;
/// Samples at the very peak from which a recording counts as clipped, if its peak is near full scale.
const CLIPPED: usize = 8;
/// Peak near full scale, dB.
const NEAR_FULL_SCALE_DB: f64 = -1.0;

/// A note as it was heard.
#[derive(Debug, Clone, PartialEq)]
pub struct HeardNote {
    /// Key, from 1.
    pub key: usize,
    /// Largest level of 20 ms, dB.
    pub level_db: f64,
    /// Largest sample, dB.
    pub peak_db: f64,
    /// Number of samples at the largest value, if so many are at it near full scale that the recording is clipped;
    /// else 0.
    pub clipped: usize,
    /// Times from the middle of the loudest window until the level is 10, 20 and 40 dB lower, s; `None` where the sound
    /// ends before.
    pub fall_s: [Option<f64>; 3],
    /// Decay of the level.
    pub decay: Option<Decay>,
    /// Centroid of the power spectrum of the first half second, from 20 Hz to 16 kHz, Hz.
    pub centroid_hz: f64,
    /// B in n f0 sqrt(1 + B n^2), fitted to the partials that were found; `None` below five partials or where B is not
    /// known to a fifth.
    pub inharmonicity: Option<f64>,
    /// The fitted first partial above the key's note in equal temperament at A4 = 440 Hz, cents.
    pub cents: f64,
    /// Number of partials that the fit used.
    pub partials_found: usize,
    /// The first partials, in their order.
    pub partials: Vec<HeardPartial>,
}

/// A partial of a note.
#[derive(Debug, Clone, PartialEq)]
pub struct HeardPartial {
    /// Number, from 1.
    pub number: usize,
    /// Frequency, Hz.
    pub frequency_hz: f64,
    /// Largest level, dB, of a sine of 0 dB peak: -3 dB.
    pub level_db: f64,
    /// Decay; `None` where the partial does not stand out, or falls faster than a window that separates it from its
    /// neighbours resolves.
    pub decay: Option<Decay>,
}

/// Why a note cannot be measured.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ListenError {
    /// No such key.
    #[error("key {0}; expected a number from 1 to 88")]
    Key(usize),
    /// Sampling rate.
    #[error("{0} samples per second; expected 8000 to 768000")]
    Rate(f64),
    /// Number of channels, or channels of different lengths.
    #[error("{0} channels; expected 1 to 64 of the same length")]
    Channels(usize),
    /// No sample.
    #[error("holds no sound: no samples")]
    Empty,
    /// A sample is infinite or no number.
    #[error("sample {0} is not a finite number")]
    NotFinite(usize),
    /// Nothing is heard.
    #[error("is silent: the loudest 20 ms are below {SILENCE_DB} dB of full scale")]
    Silent,
    /// Nothing can be measured in so short a time.
    #[error("the sound lasts {0:.3} s after its beginning; expected {SHORTEST_S} s or more")]
    Short(f64),
    /// The sound is another note.
    #[error(
        "the strongest component, {found_hz:.1} Hz, is no partial of {note} ({expected_hz:.1} Hz): is it another key?"
    )]
    OtherNote {
        /// Note of the key.
        note: String,
        /// Its first partial, Hz.
        expected_hz: f64,
        /// Hz.
        found_hz: f64,
    },
}

/// Measures one note: `channels` of samples, `rate_hz` of them a second, of a key from 1 to 88.
///
/// # Errors
/// See [`ListenError`].
pub fn listen(channels: &[Vec<f64>], rate_hz: f64, key: usize) -> Result<HeardNote, ListenError> {
    if !(1..=KEYS).contains(&key) {
        return Err(ListenError::Key(key));
    }
    if !(RATES_HZ[0]..=RATES_HZ[1]).contains(&rate_hz) {
        return Err(ListenError::Rate(rate_hz));
    }
    let length = channels.first().map_or(0, Vec::len);
    if !(1..=MAX_CHANNELS).contains(&channels.len()) || channels.iter().any(|one| one.len() != length) {
        return Err(ListenError::Channels(channels.len()));
    }
    if length == 0 {
        return Err(ListenError::Empty);
    }
    if let Some(at) = channels.iter().find_map(|one| one.iter().position(|x| !x.is_finite())) {
        return Err(ListenError::NotFinite(at));
    }
    let (peak, at_peak) = peak(channels);
    let channels = without_offset(channels);
    let power = Power::new(&channels, rate_hz);
    let loudest = power.loudest(LOUDEST_S);
    if loudest.level_db < SILENCE_DB {
        return Err(ListenError::Silent);
    }
    let onset = power.onset();
    let lasts_s = (length - onset) as f64 / rate_hz;
    if lasts_s < SHORTEST_S {
        return Err(ListenError::Short(lasts_s));
    }
    let window_s = power.window_s();
    let fall_s = window_s.map_or([None; 3], |window_s| power.falls(window_s));
    let spectrum = Spectrum::new(&channels, rate_hz, onset, key, fall_s[1]);
    let tones = spectrum.tones(key).ok_or_else(|| ListenError::OtherNote {
        note: note_name(key),
        expected_hz: tempered_hz(key),
        found_hz: spectrum.strongest_hz(key),
    })?;
    let partials = partial::partials(&channels, rate_hz, onset, &tones);
    let peak_db = 20.0 * peak.log10();
    let is_clipped = at_peak >= CLIPPED && peak_db > NEAR_FULL_SCALE_DB;
    Ok(HeardNote {
        key,
        level_db: loudest.level_db,
        peak_db,
        clipped: if is_clipped { at_peak } else { 0 },
        fall_s,
        decay: window_s.and_then(|window_s| power.decay(window_s, fall_s[1])),
        centroid_hz: spectrum::centroid_hz(&channels, rate_hz, onset),
        inharmonicity: tones.inharmonicity(),
        cents: 1200.0 * (tones.fitted_hz(1) / tempered_hz(key)).log2(),
        partials_found: tones.found(),
        partials,
    })
}

/// The largest magnitude, and how many samples have it.
fn peak(channels: &[Vec<f64>]) -> (f64, usize) {
    let all = || channels.iter().flatten().map(|x| x.abs());
    let peak = all().fold(0.0, f64::max);
    (peak, all().filter(|x| *x == peak).count())
}

/// Channels without their mean.
fn without_offset(channels: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let of = |one: &Vec<f64>| {
        let mean = one.iter().sum::<f64>() / one.len() as f64;
        one.iter().map(|x| x - mean).collect()
    };
    channels.iter().map(of).collect()
}

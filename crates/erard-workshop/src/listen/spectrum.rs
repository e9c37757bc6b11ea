//! The partials of a note in its spectrum, and its centroid.

use std::f64::consts::PI;

use erard::recording::Fourier;

use super::scale::tempered_hz;

/// Most partials that are looked for.
const MAX_PARTIALS: usize = 40;
/// Highest frequency, Hz, and share of the sampling rate.
const HIGHEST_HZ: f64 = 16e3;
const HIGHEST_SHARE: f64 = 0.45;
/// Lowest frequency of the centroid, Hz, and time after the onset, s.
const LOWEST_HZ: f64 = 20.0;
const CENTROID_S: f64 = 0.5;
/// Longest part of the sound in which partials are looked for, s; the shortest in periods of the note.
const LONGEST_S: f64 = 1.5;
const PERIODS: f64 = 12.0;
/// Bins of the padded transform to one of the sound's.
const PADDING: usize = 4;
/// What is lower than this share of a note's frequency is a knock.
const KNOCK: f64 = 0.4;
/// How far a note may be from equal temperament, cents.
const TUNED_CENTS: i32 = 60;
/// How much more for each key above C7, cents: the highest notes are stretched.
const TREBLE_CENTS: i32 = 4;
/// Range of inharmonicity around a key's usual one, as a factor, and its number of steps.
const AROUND: f64 = 6.0;
const STEPS: i32 = 36;
/// Partials that place a note.
const PLACING: usize = 16;
/// What a partial is above the median around it, dB.
const ABOVE_DB: f64 = 12.0;
/// Fewest partials from which inharmonicity is known, and its largest relative standard error.
const FEWEST: usize = 5;
const CERTAIN: f64 = 0.2;

/// Power spectrum of the beginning of a note.
pub(super) struct Spectrum {
    /// Power by bin.
    power: Vec<f64>,
    bin_hz: f64,
    /// Width of a line, Hz.
    width_hz: f64,
    highest_hz: f64,
}

impl Spectrum {
    /// A window of Hann over the beginning of a note, from its onset on; it falls by 20 dB within `fall_s`.
    pub fn new(channels: &[Vec<f64>], rate_hz: f64, onset: usize, key: usize, fall_s: Option<f64>) -> Self {
        let shortest_s = PERIODS / tempered_hz(key);
        let length_s = fall_s.unwrap_or(LONGEST_S).clamp(shortest_s, LONGEST_S.max(shortest_s));
        let available = channels.first().map_or(0, Vec::len) - onset;
        let length = ((length_s * rate_hz) as usize).clamp(1, available);
        let size = PADDING * length.next_power_of_two();
        let weight = |n: usize| 0.5 - 0.5 * (2.0 * PI * (n as f64 + 0.5) / length as f64).cos();
        let padded = |one: &[f64]| {
            let sound = one[onset..onset + length].iter().enumerate().map(|(n, x)| weight(n) * x);
            sound.chain(std::iter::repeat(0.0)).take(size).collect::<Vec<f64>>()
        };
        Spectrum {
            power: summed(channels.iter().map(|one| padded(one)), size),
            bin_hz: rate_hz / size as f64,
            width_hz: 4.0 * rate_hz / length as f64,
            highest_hz: HIGHEST_HZ.min(HIGHEST_SHARE * rate_hz),
        }
    }

    /// Frequency of the strongest component that a key's note may have, Hz; what is lower is a knock.
    pub fn strongest_hz(&self, key: usize) -> f64 {
        self.peak(KNOCK * tempered_hz(key), self.highest_hz).map_or(0.0, |peak| peak.hz)
    }

    fn bins(&self, low_hz: f64, high_hz: f64) -> std::ops::Range<usize> {
        let low = ((low_hz / self.bin_hz).max(1.0) as usize).min(self.power.len() / 2);
        low..((high_hz / self.bin_hz) as usize + 1).clamp(low, self.power.len() / 2)
    }

    /// The strongest line in a range, its place by a parabola through three levels.
    fn peak(&self, low_hz: f64, high_hz: f64) -> Option<Peak> {
        let at = self.bins(low_hz, high_hz).max_by(|a, b| self.power[*a].total_cmp(&self.power[*b]))?;
        let [before, here, after] = [at - 1, at, at + 1].map(|bin| self.power[bin].max(1e-300).ln());
        // At an edge of the range a stronger line beside it shines in: no line.
        if here < before || here < after {
            return None;
        }
        let bend = before - 2.0 * here + after;
        let shift = if bend < 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
        Some(Peak { hz: (at as f64 + shift) * self.bin_hz, power: self.power[at] })
    }

    /// Median power in a range.
    fn median(&self, low_hz: f64, high_hz: f64) -> f64 {
        let mut powers = self.power[self.bins(low_hz, high_hz)].to_vec();
        let middle = powers.len() / 2;
        if powers.is_empty() { 0.0 } else { *powers.select_nth_unstable_by(middle, f64::total_cmp).1 }
    }

    /// The partials of a key's note; `None` where the strongest component is none of them.
    pub fn tones(&self, key: usize) -> Option<Tones> {
        let first_hz = tempered_hz(key);
        let mut tones = Tones { fit: self.placed(key), found: Vec::new() };
        let strongest_hz = self.strongest_hz(key);
        let is_near = |hz: f64| (hz - strongest_hz).abs() <= self.reach_hz(hz, first_hz);
        if !(1..=PLACING).any(|number| is_near(tones.fit.hz(number))) {
            return None;
        }
        // The low ones first, whose places are known best; what they say leads to the higher ones, and these back.
        for last in [PLACING, 24, 32, MAX_PARTIALS, MAX_PARTIALS] {
            let partials = (1..=last).map(|number| (number, tones.fit.hz(number)));
            let found = partials.filter_map(|(number, hz)| Some((number, self.partial(hz, first_hz)?)));
            tones.found = found.collect();
            tones.drop_outliers(self.width_hz);
        }
        Some(tones)
    }

    /// How far from its expected place a partial is looked for, Hz.
    fn reach_hz(&self, expected_hz: f64, first_hz: f64) -> f64 {
        (0.25 * first_hz).min((0.75 * self.width_hz).max(0.004 * expected_hz))
    }

    /// Frequency of the line near an expected one that stands out, Hz.
    fn partial(&self, expected_hz: f64, first_hz: f64) -> Option<f64> {
        if expected_hz > self.highest_hz {
            return None;
        }
        let reach_hz = self.reach_hz(expected_hz, first_hz);
        let peak = self.peak(expected_hz - reach_hz, expected_hz + reach_hz)?;
        let least = libm::pow(10.0, ABOVE_DB / 10.0) * self.around(expected_hz, first_hz);
        (peak.power > least).then_some(peak.hz)
    }

    /// Median power around a partial, its own line left out on both sides.
    fn around(&self, hz: f64, first_hz: f64) -> f64 {
        self.median(hz - 0.5 * first_hz, hz + 0.5 * first_hz)
    }

    /// The first partial and the inharmonicity at whose partials most is heard, from a grid.
    fn placed(&self, key: usize) -> Fit {
        let strongest = self.power[self.bins(LOWEST_HZ, self.highest_hz)].iter().copied().fold(0.0, f64::max);
        // The square root of an amplitude, so that weak partials count and noise does not.
        let heard = |hz: f64| {
            let power = self.power.get((hz / self.bin_hz).round() as usize).copied().unwrap_or(0.0);
            (power / strongest).sqrt().sqrt()
        };
        let tuned_cents = TUNED_CENTS + TREBLE_CENTS * i32::try_from(key.saturating_sub(76)).unwrap_or(0);
        let mut best = (f64::NEG_INFINITY, Fit { square: 0.0, bend: 0.0, error: f64::INFINITY });
        for step in -STEPS..=STEPS {
            let b = usual_inharmonicity(key) * libm::pow(AROUND, f64::from(step) / f64::from(STEPS));
            for cents in -tuned_cents..=tuned_cents {
                let first_hz = tempered_hz(key) * libm::exp2(f64::from(cents) / 1200.0);
                let square = first_hz * first_hz / (1.0 + b);
                let fit = Fit { square, bend: square * b, error: f64::INFINITY };
                let partials = (1..=PLACING).map(|n| fit.hz(n)).take_while(|hz| *hz < self.highest_hz);
                let score = partials.map(heard).sum();
                if score > best.0 {
                    best = (score, fit);
                }
            }
        }
        best.1
    }
}

/// A line of a spectrum.
struct Peak {
    hz: f64,
    power: f64,
}

/// The sum of the power spectra of series of equal size.
fn summed(series: impl Iterator<Item = Vec<f64>>, size: usize) -> Vec<f64> {
    let transform = Fourier::of(size);
    let mut sum = vec![0.0; size];
    for one in series {
        sum.iter_mut().zip(transform.squares(one.into_iter())).for_each(|(sum, x)| *sum += x);
    }
    sum
}

/// Inharmonicity that is usual for a key: where the search begins. Two branches, bass strings and treble strings, near
/// the values of a medium grand.
fn usual_inharmonicity(key: usize) -> f64 {
    let key = key as f64;
    2.9e-4 * ((key - 40.0) * 1.1 / 12.0).exp() + 0.9e-4 * (-(key - 16.0) * 0.9 / 15.0).exp()
}

/// f_n^2 = n^2 (square + bend n^2): square is f0^2, bend f0^2 B.
#[derive(Debug, Clone, Copy)]
struct Fit {
    square: f64,
    bend: f64,
    /// Relative standard error of the bend.
    error: f64,
}

impl Fit {
    fn hz(&self, number: usize) -> f64 {
        let n = number as f64;
        n * (self.square + self.bend * n * n).max(0.0).sqrt()
    }

    /// Least squares; lines are equally sharp in Hz, so that (f_n/n)^2 is known as n to the power -1.
    fn of(found: &[(usize, f64)]) -> Option<Self> {
        let rows = || {
            found.iter().map(|(number, hz)| {
                let n = *number as f64;
                [n * n, n * n, (hz / n).powi(2)]
            })
        };
        let weights: f64 = rows().map(|[w, ..]| w).sum();
        let mean = |of: usize| rows().map(|row| row[0] * row[of]).sum::<f64>() / weights;
        let (x0, y0) = (mean(1), mean(2));
        let xx: f64 = rows().map(|[w, x, _]| w * (x - x0).powi(2)).sum();
        if xx <= 0.0 {
            return None;
        }
        let bend = rows().map(|[w, x, y]| w * (x - x0) * (y - y0)).sum::<f64>() / xx;
        let square = y0 - bend * x0;
        let squares: f64 = rows().map(|[w, x, y]| w * (y - square - bend * x).powi(2)).sum();
        let free = (found.len() as f64 - 2.0).max(1.0);
        Some(Fit { square, bend, error: (squares / free / xx).sqrt() / bend.abs().max(1e-300) })
    }
}

/// The partials of a note.
pub(super) struct Tones {
    fit: Fit,
    /// Number and frequency, Hz.
    found: Vec<(usize, f64)>,
}

impl Tones {
    /// Fits the partials without those that are farther from the fit than four times the median distance and a 50th of
    /// a line's width, Hz, in three rounds. Fewer than five leave the fit as it is.
    fn drop_outliers(&mut self, width_hz: f64) {
        for _ in 0..3 {
            let Some(fit) = Fit::of(&self.found).filter(|_| self.found.len() >= FEWEST) else { return };
            let distance_hz = |(number, hz): &(usize, f64)| (hz - fit.hz(*number)).abs();
            let mut all: Vec<f64> = self.found.iter().map(distance_hz).collect();
            let middle = all.len() / 2;
            let most_hz = (4.0 * *all.select_nth_unstable_by(middle, f64::total_cmp).1).max(0.02 * width_hz);
            self.found.retain(|one| distance_hz(one) <= most_hz);
            self.fit = Fit::of(&self.found).filter(|_| self.found.len() >= FEWEST).unwrap_or(fit);
        }
    }

    /// Frequency of a partial by the fit, Hz.
    pub fn fitted_hz(&self, number: usize) -> f64 {
        self.fit.hz(number)
    }

    /// Frequency of a partial as it was found, else by the fit, Hz.
    pub fn hz(&self, number: usize) -> f64 {
        let found = self.found.iter().find(|(one, _)| *one == number);
        found.map_or_else(|| self.fitted_hz(number), |(_, hz)| *hz)
    }

    /// Number of partials.
    pub fn found(&self) -> usize {
        self.found.len()
    }

    pub fn inharmonicity(&self) -> Option<f64> {
        let is_known = self.found.len() >= FEWEST && self.fit.error < CERTAIN && self.fit.bend > 0.0;
        is_known.then(|| self.fit.bend / self.fit.square)
    }
}

/// Centroid of the power spectrum of the first half second, Hz.
pub(super) fn centroid_hz(channels: &[Vec<f64>], rate_hz: f64, onset: usize) -> f64 {
    let available = channels.first().map_or(0, Vec::len) - onset;
    let length = ((CENTROID_S * rate_hz) as usize).clamp(1, available);
    let power = summed(channels.iter().map(|one| one[onset..onset + length].to_vec()), length);
    let hz = |bin: usize| bin as f64 * rate_hz / length as f64;
    let bins = (1..length / 2).filter(|bin| (LOWEST_HZ..=HIGHEST_HZ).contains(&hz(*bin)));
    let (moment, sum) = bins.fold((0.0, 0.0), |(m, s), bin| (m + hz(bin) * power[bin], s + power[bin]));
    moment / f64::max(sum, 1e-300)
}

//! Noise of a series, and the frequency up to which its signal is above the noise.

use super::fourier::Fourier;
use std::f64::consts::{LN_2, TAU};

/// Where the noise was estimated.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Whence {
    /// The rest before the touch.
    Rest,
    /// The upper end of the spectrum, where it is flat.
    Spectrum,
}

/// White noise of a channel.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Noise {
    /// Standard deviation, in the channel's unit.
    pub rms: f64,
    /// Where the noise was estimated.
    pub whence: Whence,
    /// Standard deviation of `rms` over `rms`, as its estimate scatters.
    pub uncertainty: f64,
}

/// Fewest samples from which noise is estimated.
const FEWEST: usize = 64;
/// Share of the range below which noise is only the rounding of the written numbers.
const ROUNDING: f64 = 1e-5;
/// Longest piece that is transformed at once, samples.
const MAX_WINDOW: usize = 1 << 17;
/// Parts of the half rate between which the spectrum is compared: noise is as strong in both.
const LOWER: [f64; 2] = [0.4, 0.6];
const UPPER: [f64; 2] = [0.8, 0.95];
/// Largest ratio that counts as equally strong: that of a long series, and that of a short one, whose two levels
/// scatter. The spectrum of a smooth motion without noise falls by 29 between the two parts.
const FLAT: [f64; 2] = [2.0, 6.0];
/// Second differences of white noise are larger than this share of its deviation in nine of ten samples; they have to
/// be in this share of the samples, since a sensor that rounds shows none while nothing moves.
const ROUGH: f64 = 0.3;
const ROUGH_SHARE: f64 = 0.1;
/// Bands are a third of an octave, from this frequency on, Hz.
const LOWEST_HZ: f64 = 8.0;

/// Power per Hz, one-sided; the value n belongs to n times the spacing.
struct Spectrum {
    spacing_hz: f64,
    power: Vec<f64>,
}

impl Spectrum {
    /// By Welch's method, with Hann's window over pieces that overlap by half.
    fn new(x: &[f64], rate_hz: f64) -> Self {
        let length = x.len().min(MAX_WINDOW);
        let window: Vec<f64> =
            (0..length).map(|n| 0.5 - 0.5 * (TAU * (n as f64 + 0.5) / length as f64).cos()).collect();
        let scale = 2.0 / (rate_hz * window.iter().map(|w| w * w).sum::<f64>());
        let transform = Fourier::of(length);
        let mut power = vec![0.0; length / 2 + 1];
        let mut pieces = 0.0;
        for from in (0..=x.len() - length).step_by((length / 2).max(1)) {
            let piece = &x[from..from + length];
            let mean = piece.iter().sum::<f64>() / length as f64;
            let squares = transform.squares(piece.iter().zip(&window).map(|(x, w)| (x - mean) * w));
            for (power, square) in power.iter_mut().zip(squares) {
                *power += scale * square;
            }
            pieces += 1.0;
        }
        power.iter_mut().for_each(|power| *power /= pieces);
        Spectrum { spacing_hz: rate_hz / length as f64, power }
    }

    fn between(&self, from_hz: f64, to_hz: f64) -> &[f64] {
        let index = |hz: f64| ((hz / self.spacing_hz).ceil() as usize).min(self.power.len());
        &self.power[index(from_hz)..index(to_hz).max(index(from_hz))]
    }

    /// The level of noise between two frequencies: what half of the values are below. Of white noise their mean is that
    /// over ln 2.
    fn level(&self, from_hz: f64, to_hz: f64) -> f64 {
        let mut values = self.between(from_hz, to_hz).to_vec();
        values.sort_unstable_by(f64::total_cmp);
        values.get(values.len() / 2).map_or(f64::NAN, |median| median / LN_2)
    }
}

/// The noise of an evenly sampled series that begins with a number of samples at rest; `None` if it shows none.
pub(super) fn noise(x: &[f64], rate_hz: f64, rest: usize) -> Option<Noise> {
    let (low, high) = range(x);
    if x.len() < FEWEST || high <= low {
        return None;
    }
    let mut found: Option<Noise> = None;
    if rest >= FEWEST {
        // Of n normal numbers the deviation scatters by 1 / sqrt(2 (n - 1)).
        let uncertainty = 1.0 / (2.0 * (rest - 1) as f64).sqrt();
        found = Some(Noise { rms: deviation(&x[..rest]), whence: Whence::Rest, uncertainty });
    }
    let spectrum = Spectrum::new(x, rate_hz);
    let half = 0.5 * rate_hz;
    let [lower, upper] = [LOWER, UPPER].map(|[from, to]| spectrum.level(from * half, to * half));
    // The median of n values of a spectrum scatters by 1 / (ln 2 sqrt(n)) in power, half of that in amplitude. Hann's
    // window makes neighbouring values depend on each other: two thirds of them count.
    let values = [LOWER, UPPER].map(|[from, to]| spectrum.between(from * half, to * half).len() as f64);
    let [below, scatter] = values.map(|n| 1.0 / (LN_2 * (n / 1.5).sqrt()));
    let most = (3.0 * below.hypot(scatter)).clamp(FLAT[0].ln(), FLAT[1].ln());
    let rms = (upper * half).sqrt();
    if (lower / upper).ln().abs() < most && is_everywhere(&x[rest..], rms) {
        // A rest in which one and the same number is rounded off every time has none, and the motion after it has.
        // Within three times the scatter the rest, which has more samples, is right.
        if found.is_none_or(|noise| noise.rms < rms * (1.0 - 1.5 / (LN_2 * values[1].sqrt()))) {
            let uncertainty = 0.5 * scatter;
            found = Some(Noise { rms, whence: Whence::Spectrum, uncertainty });
        }
    }
    found.filter(|noise| noise.rms > ROUNDING * (high - low))
}

/// Whether a series shows noise of this size wherever it moves, and not in a few jumps, whose spectrum is almost as
/// flat.
fn is_everywhere(x: &[f64], rms: f64) -> bool {
    let differs = |three: &[f64]| (three[0] - 2.0 * three[1] + three[2]).abs() > ROUGH * rms;
    let rough = x.windows(3).filter(|three| differs(three)).count();
    rough as f64 > ROUGH_SHARE * x.len() as f64
}

/// Up to which frequency a series is more than this noise, Hz: the last third of an octave, from below, in which its
/// power is twice the noise's or more; one that fails between two that do not is a zero of the spectrum. The half rate
/// where it never falls so low; 0 where it never is more.
pub(super) fn band(x: &[f64], rate_hz: f64, noise: &Noise) -> f64 {
    let spectrum = Spectrum::new(x, rate_hz);
    let half = 0.5 * rate_hz;
    let level = noise.rms * noise.rms / half;
    let step = 2.0_f64.powf(1.0 / 3.0);
    let (mut edge, mut reached, mut failed) = (LOWEST_HZ.max(2.0 * spectrum.spacing_hz), 0.0, 0);
    while edge < half && failed < 2 {
        let upper = (edge * step).min(half);
        let values = spectrum.between(edge, upper);
        if !values.is_empty() {
            let power = values.iter().sum::<f64>() / values.len() as f64;
            if power > 2.0 * level {
                (reached, failed) = (upper, 0);
            } else {
                failed += 1;
            }
        }
        edge = upper;
    }
    reached
}

pub(super) fn range(x: &[f64]) -> (f64, f64) {
    x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &x| (low.min(x), high.max(x)))
}

pub(super) fn mean(x: &[f64]) -> f64 {
    x.iter().sum::<f64>() / x.len().max(1) as f64
}

/// Standard deviation.
pub(super) fn deviation(x: &[f64]) -> f64 {
    let mean = mean(x);
    (x.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / x.len().saturating_sub(1).max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fastrand::Rng;

    /// Normal noise from twelve uniform numbers.
    pub(super) fn normal(rng: &mut Rng) -> f64 {
        (0..12).map(|_| rng.f64()).sum::<f64>() - 6.0
    }

    const RATE_HZ: f64 = 20e3;

    /// 10 mm in 40 ms, as smooth as a raised cosine.
    fn stroke(n: usize) -> f64 {
        let s = ((n as f64 / RATE_HZ - 0.1) / 0.04).clamp(0.0, 1.0);
        0.005 * (1.0 - (0.5 * TAU * s).cos())
    }

    /// The noise that was put in is found to a twentieth, in the rest and in the spectrum.
    #[test]
    fn noise_is_found() {
        for rms in [15e-6, 1e-6] {
            let mut rng = Rng::with_seed(7);
            let x: Vec<f64> = (0..12_000).map(|n| stroke(n) + rms * normal(&mut rng)).collect();
            for (rest, whence) in [(2000, Whence::Rest), (0, Whence::Spectrum)] {
                let found = noise(&x, RATE_HZ, rest).unwrap();
                assert!((found.rms / rms - 1.0).abs() < 0.08, "{found:?}");
                assert!(rest == 0 || found.whence == whence || found.rms < 1.08 * rms, "{found:?}");
            }
        }
    }

    /// Without noise none is found, although the spectrum goes on.
    #[test]
    fn a_clean_series_has_none() {
        let x: Vec<f64> = (0..12_000).map(stroke).collect();
        assert_eq!(noise(&x, RATE_HZ, 2000), None);
        assert_eq!(noise(&x, RATE_HZ, 0), None);
        assert_eq!(noise(&vec![1.0; 5000], RATE_HZ, 0), None);
        // Jumps, whose spectrum is almost flat.
        let x: Vec<f64> = (0..1200).map(|n| if n < 400 { 5.0 } else { 8.0 }).collect();
        assert_eq!(noise(&x, 4e3, 396), None);
        assert_eq!(noise(&x[..240], 4e3, 0).or(noise(&x[300..540], 4e3, 0)), None);
    }

    /// A short series of noise, as a recording of a single stroke in 60 ms is, has noise as often as it should: of 200
    /// drawings one part in a hundred may look like a falling spectrum.
    #[test]
    fn short_series_have_noise_too() {
        let found: Vec<f64> = (0..200)
            .filter_map(|seed| {
                let mut rng = Rng::with_seed(seed);
                let x: Vec<f64> = (0..240).map(|_| normal(&mut rng)).collect();
                noise(&x, 4e3, 0).map(|noise| noise.rms)
            })
            .collect();
        assert!(found.len() >= 198, "{}", found.len());
        let mean = found.iter().sum::<f64>() / found.len() as f64;
        assert!((mean - 1.0).abs() < 0.06, "{mean}");
        assert!(found.iter().all(|rms| (0.4..1.8).contains(rms)), "{found:?}");
        for length in [64, 120, 240] {
            let x: Vec<f64> = (0..length).map(|n| stroke(2000 + n * 800 / length)).collect();
            assert_eq!(noise(&x, RATE_HZ, 0), None, "{length}");
        }
    }

    /// The band ends where the raised cosine's spectrum meets the noise's: its energy density |X(f)|^2 = (A pi / T)^2 /
    /// (2 pi f)^2 (2 + 2 cos(2 pi f T)) / ((pi/T)^2 - (2 pi f)^2)^2 ... of amplitude A in the time T, against the
    /// noise's over the window.
    #[test]
    fn the_band_ends_where_noise_begins() {
        let at = |rms: f64| {
            let mut rng = Rng::with_seed(11);
            let x: Vec<f64> = (0..12_000).map(|n| stroke(n) + rms * normal(&mut rng)).collect();
            band(&x, RATE_HZ, &Noise { rms, whence: Whence::Rest, uncertainty: 0.0 })
        };
        let (coarse, fine) = (at(15e-6), at(0.15e-6));
        // The spectrum falls with the third power of the frequency: a hundredth of the noise is 4.6 times the band.
        assert!((60.0..250.0).contains(&coarse), "{coarse}");
        assert!((2.5..8.0).contains(&(fine / coarse)), "{fine} {coarse}");
    }
}

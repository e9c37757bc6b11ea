//! The level of a partial over time.

use std::f64::consts::PI;

use super::decay::{Point, decay};
use super::level::SHARE;
use super::scale::db;
use super::spectrum::Tones;
use super::{HeardPartial, PARTIALS};

/// Four terms of the window of Blackman and Harris: what is four bins away is 92 dB down (F. J. Harris, Proc. IEEE 66
/// (1978) 51).
const TERMS: [f64; 4] = [0.358_75, -0.488_29, 0.141_28, -0.011_68];
/// Its noise bandwidth, bins: its length over this is its effective length.
const BANDWIDTH: f64 = 2.004;
/// Bins to the nearest partial, at least, so that it is not heard.
const BINS_APART: f64 = 4.0;
/// Longest effective length, s.
const LONGEST_S: f64 = 0.1;
/// Levels a window.
const FINENESS: usize = 4;
/// What a partial is above the background between partials, dB; else it is noise.
const ABOVE_DB: f64 = 10.0;
/// Levels of the background on either side of an instant that are averaged.
const MEAN: usize = 3 * FINENESS;
/// A fall that makes the window, dB.
const FALL_DB: f64 = 20.0;

/// Sound and onset.
struct Sound<'a> {
    channels: &'a [Vec<f64>],
    rate_hz: f64,
    onset: usize,
}

/// The first partials of a note.
pub(super) fn partials(channels: &[Vec<f64>], rate_hz: f64, onset: usize, tones: &Tones) -> Vec<HeardPartial> {
    let sound = Sound { channels, rate_hz, onset };
    let numbers = (1..=PARTIALS).take_while(|number| tones.hz(*number) < 0.45 * rate_hz);
    numbers.map(|number| sound.partial(tones, number)).collect()
}

impl Sound<'_> {
    fn partial(&self, tones: &Tones, number: usize) -> HeardPartial {
        let hz = tones.hz(number);
        let spacing_hz = tones.fitted_hz(1);
        let shortest_s = BINS_APART / spacing_hz;
        let rough = self.levels(hz, shortest_s);
        let fall_s = fall_s(&rough);
        let longest_s = fall_s.map_or(LONGEST_S, |fall_s| SHARE * fall_s).min(LONGEST_S);
        let effective_s = longest_s.max(shortest_s / BANDWIDTH);
        let fine = self.levels(hz, BANDWIDTH * effective_s);
        let level_db = fine.iter().map(|point| point.level_db).fold(f64::NEG_INFINITY, f64::max);
        // The background between two partials, in windows twice as long, as noise in the partial's own window.
        let background_s = (2.125 * shortest_s).max(LONGEST_S);
        let background = self.levels(hz + 0.5 * spacing_hz, background_s);
        let noise_db = |time_s: f64| {
            let at = background.partition_point(|point| point.time_s < time_s);
            // Noise in one window may be weak by chance.
            let near = &background[at.saturating_sub(MEAN).min(background.len())..(at + MEAN).min(background.len())];
            let mean =
                near.iter().map(|point| libm::exp10(0.1 * point.level_db)).sum::<f64>() / near.len().max(1) as f64;
            db(mean) + 10.0 * (background_s / (BANDWIDTH * effective_s)).log10() + ABOVE_DB
        };
        let is_resolved = fall_s.is_none_or(|fall_s| effective_s <= SHARE * fall_s * (1.0 + 1e-9));
        let decay = if is_resolved { decay(&fine, effective_s, fall_s, &noise_db) } else { None };
        HeardPartial { number, frequency_hz: hz, level_db, decay }
    }

    /// Levels near a frequency in windows that begin at the onset or later, at their middles after it.
    fn levels(&self, hz: f64, window_s: f64) -> Vec<Point> {
        let length = ((window_s * self.rate_hz).round() as usize).max(8);
        let turn = 2.0 * PI * hz / self.rate_hz;
        let weights: Vec<[f64; 2]> = (0..length)
            .map(|n| {
                let at = 2.0 * PI * (n as f64 + 0.5) / length as f64;
                let window: f64 = TERMS.iter().enumerate().map(|(k, term)| term * (k as f64 * at).cos()).sum();
                let scale = window / (TERMS[0] * length as f64);
                let (sin, cos) = (turn * n as f64).sin_cos();
                [scale * cos, scale * sin]
            })
            .collect();
        let hop = (length / FINENESS).max(1);
        let end = self.channels.first().map_or(0, Vec::len);
        let firsts = (self.onset..).step_by(hop).take_while(|from| from + length <= end);
        let point = |from: usize| {
            let power = |one: &Vec<f64>| {
                let products = one[from..from + length].iter().zip(&weights);
                let [re, im] = products.fold([0.0; 2], |[re, im], (x, [c, s])| [re + x * c, im + x * s]);
                // A sine of amplitude a has power a^2/2 and gives a/2 here.
                2.0 * (re * re + im * im)
            };
            let mean = self.channels.iter().map(power).sum::<f64>() / self.channels.len() as f64;
            let middle = from as f64 + 0.5 * length as f64 - self.onset as f64;
            Point { time_s: middle / self.rate_hz, level_db: db(mean) }
        };
        firsts.map(point).collect()
    }
}

/// Time from the largest of the first levels until the level is 20 dB lower, s.
fn fall_s(points: &[Point]) -> Option<f64> {
    let top = points.iter().take(1 + points.len() / 4).max_by(|a, b| a.level_db.total_cmp(&b.level_db))?;
    let below_db = top.level_db - FALL_DB;
    let at = points.iter().position(|point| point.time_s > top.time_s && point.level_db < below_db)?;
    let (before, low) = (points[at - 1], points[at]);
    let share = (before.level_db - below_db) / (before.level_db - low.level_db).max(1e-9);
    Some(before.time_s + share.clamp(0.0, 1.0) * (low.time_s - before.time_s) - top.time_s)
}

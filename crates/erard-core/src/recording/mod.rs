//! A prepared recording: its zero, its sign, its clock and its noise.
//!
//! Raw sensor data can seldom drive a model. [`prepare`] subtracts the zero found in the rest before the touch,
//! reverses signs, moves one channel's clock against the other's, and filters noise by Butterworth's low-pass forward
//! and backward; a derivative is that of the filtered series. It reports all its changes, and what it noticed without
//! changing it.

mod butterworth;
mod fourier;
mod noise;
mod report;
mod rest;

pub use butterworth::{Butterworth, ORDERS};
pub use fourier::Fourier;
pub use noise::{Noise, Whence};
pub use report::{ChannelReport, Filtered, Report, Zero};

use crate::stroke::{
    Channel, ForceSeries, MAX_ROWS, PositionSeries, Recording, Role, SampleError, Series, SpeedSeries,
};
use thiserror::Error;

/// Options for preparing a recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Preparation {
    /// Take the mean of the rest before the touch from every channel that has one.
    pub zero: bool,
    /// Take it, too, from a channel that is computed, not measured: one that begins with one number and has no noise.
    pub zero_of_computed: bool,
    /// Reading of a channel in the file where its quantity is zero, N, m or m/s: subtracted, with or without a rest.
    pub zero_at: Vec<(Role, f64)>,
    /// Channels that are positive upward (the hammer's: downward), and are turned.
    pub inverted: Vec<Role>,
    /// Delay of a channel against the others, s; positive when it was recorded late.
    pub late_s: Vec<(Role, f64)>,
    /// Noise.
    pub low_pass: LowPass,
    /// Order of the low-pass, of one of its two passes.
    pub order: usize,
}

/// Cutoff of the low-pass.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LowPass {
    /// The frequency at which a channel's own noise begins; a channel without noise passes unchanged.
    Own,
    /// Nothing is filtered.
    Off,
    /// At this frequency for every channel, Hz.
    At(f64),
}

impl Default for Preparation {
    fn default() -> Self {
        Preparation {
            zero: true,
            zero_of_computed: false,
            zero_at: Vec::new(),
            inverted: Vec::new(),
            late_s: Vec::new(),
            low_pass: LowPass::Own,
            order: 4,
        }
    }
}

impl Preparation {
    /// Nothing is done.
    pub fn none() -> Self {
        Preparation { zero: false, low_pass: LowPass::Off, ..Preparation::default() }
    }
}

/// Longest delay of a channel against the others, s.
pub const MAX_LATE_S: f64 = 10.0;

/// Why a recording cannot be prepared.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
#[non_exhaustive]
pub enum PrepareError {
    /// The order of the filter.
    #[error("the order of the low-pass is {0}; expected 1 to 10")]
    Order(usize),
    /// The cutoff.
    #[error("low-pass at {cutoff_hz} Hz: the {} has {rate_hz:.0} samples per second; expected less than half of that", .role.name())]
    Cutoff {
        /// Channel.
        role: Role,
        /// Hz.
        cutoff_hz: f64,
        /// Hz.
        rate_hz: f64,
    },
    /// Sampled so unevenly that an even series of the same fineness would be too long.
    #[error("the {} is sampled too unevenly for a low-pass; expected even sampling, or no low-pass", .0.name())]
    Uneven(Role),
    /// The delay of a channel.
    #[error("the {} is {late_s} s late; expected at most {MAX_LATE_S} s either way", .role.name())]
    Late {
        /// Channel.
        role: Role,
        /// s.
        late_s: f64,
    },
    /// A channel cannot be interpolated.
    #[error(transparent)]
    Samples(#[from] SampleError),
}

/// A prepared recording.
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    /// The prepared series.
    pub series: Series,
    /// Report of the changes and remarks.
    pub report: Report,
}

/// Prepares a recording.
///
/// # Errors
/// See [`PrepareError`].
pub fn prepare(recording: &Recording, preparation: &Preparation) -> Result<Prepared, PrepareError> {
    if !ORDERS.contains(&preparation.order) {
        return Err(PrepareError::Order(preparation.order));
    }
    // What is not a number lies within no limit.
    let late = preparation.late_s.iter().find(|(_, late_s)| !(-MAX_LATE_S..=MAX_LATE_S).contains(late_s));
    if let Some((role, late_s)) = late {
        return Err(PrepareError::Late { role: *role, late_s: *late_s });
    }
    let mut channels: Vec<Samples> =
        recording.channels.iter().map(|channel| Samples::new(recording, channel, preparation)).collect();
    // Nothing rests any more when the first channel has begun to move.
    let touched_s = channels.iter().filter_map(Samples::rest_ends_s).fold(f64::INFINITY, f64::min);
    let mut series = Series { force: None, position: None, hammer_head: None, hammer_speed: None };
    let mut reports = Vec::new();
    for samples in &mut channels {
        samples.end_rest(touched_s);
        let (times, values, report) = samples.ready(preparation)?;
        reports.push(report);
        match samples.role {
            Role::Force => series.force = Some(ForceSeries::new(times, values)?),
            Role::Position => series.position = Some(PositionSeries::new(times, values)?),
            Role::HammerHead => series.hammer_head = Some(PositionSeries::new(times, values)?),
            Role::HammerSpeed => series.hammer_speed = Some(SpeedSeries::new(times, values)?),
            Role::Time => {}
        }
    }
    Ok(Prepared { series, report: Report { channels: reports } })
}

/// Jumps from sample to sample that differ by no more than this share are an even clock, written down with few digits.
const EVEN: f64 = 0.1;
/// A step longer than this, in medians, is a gap: the noise of such a channel is not reported, and it is filtered only
/// on request.
const GAP: f64 = 3.0;

/// A channel's samples without the missing ones.
struct Samples {
    role: Role,
    gaps: crate::stroke::Gaps,
    times: Vec<f64>,
    values: Vec<f64>,
    late_s: f64,
    inverted: bool,
    rest: usize,
}

impl Samples {
    fn new(recording: &Recording, channel: &Channel, preparation: &Preparation) -> Self {
        let (mut times, mut values) = channel.samples(&recording.time_s);
        let inverted = preparation.inverted.contains(&channel.role);
        if inverted {
            values.iter_mut().for_each(|value| *value = -*value);
        }
        let late_s: f64 =
            preparation.late_s.iter().filter(|(role, _)| *role == channel.role).fold(0.0, |sum, (_, late)| sum + late);
        if late_s != 0.0 {
            times.iter_mut().for_each(|time| *time -= late_s);
        }
        let rest = rest::rest(&times, &values);
        Samples { role: channel.role, gaps: channel.gaps(&recording.time_s), times, values, late_s, inverted, rest }
    }

    fn rest_ends_s(&self) -> Option<f64> {
        self.rest.checked_sub(1).map(|last| self.times[last])
    }

    fn end_rest(&mut self, touched_s: f64) {
        self.rest = self.rest.min(self.times.partition_point(|t| *t <= touched_s));
    }

    /// The usual time between two samples, and the longest, s.
    fn steps_s(&self) -> (f64, f64) {
        let mut steps: Vec<f64> = self.times.windows(2).map(|pair| pair[1] - pair[0]).collect();
        steps.sort_unstable_by(f64::total_cmp);
        (steps[steps.len() / 2], steps[steps.len() - 1])
    }

    /// Whether the series is computed, not measured: it begins with one and the same number, and it shows no noise.
    /// Such a number is no zero of a sensor.
    fn is_computed(&self) -> bool {
        let first = self.values[0];
        if self.values[..self.rest].iter().any(|value| *value != first) {
            return false;
        }
        let (usual_s, _) = self.steps_s();
        let (begin, end) = (self.times[0], self.times[self.times.len() - 1]);
        let count = ((end - begin) / usual_s).round() + 1.0;
        if !(4.0..=MAX_ROWS as f64).contains(&count) {
            return false;
        }
        let rate_hz = (count - 1.0) / (end - begin);
        let even_times: Vec<f64> = (0..count as usize).map(|n| begin + n as f64 / rate_hz).collect();
        let rest = self.rest_on(&even_times);
        noise::noise(&interpolated(&self.times, &self.values, &even_times), rate_hz, rest).is_none()
    }

    /// Samples of the rest on another clock.
    fn rest_on(&self, times: &[f64]) -> usize {
        self.rest_ends_s().map_or(0, |end_s| times.partition_point(|t| *t <= end_s))
    }

    /// Everything that is to be done; instants, values and the report on it.
    fn ready(&self, preparation: &Preparation) -> Result<(Vec<f64>, Vec<f64>, ChannelReport), PrepareError> {
        let (usual_s, longest_s) = self.steps_s();
        let shortest_s = self.times.windows(2).map(|pair| pair[1] - pair[0]).fold(f64::INFINITY, f64::min);
        let is_even = longest_s - usual_s <= EVEN * usual_s && usual_s - shortest_s <= EVEN * usual_s;
        let mut values = self.values.clone();
        let stated = preparation.zero_at.iter().find(|(role, _)| *role == self.role).map(|(_, at)| *at);
        // As it stands in the file: before its sign is turned.
        let stated = stated.map(|at| if self.inverted { -at } else { at });
        let takes_zero = preparation.zero && stated.is_none() && self.rest > 0;
        let is_computed = takes_zero && !preparation.zero_of_computed && self.is_computed();
        let zero = (takes_zero && !is_computed).then(|| {
            let offset = noise::mean(&self.values[..self.rest]);
            Zero { offset, until_s: self.times[self.rest - 1], samples: self.rest }
        });
        if let Some(offset) = stated.or(zero.map(|zero| zero.offset)) {
            values.iter_mut().for_each(|value| *value -= offset);
        }
        let mut report = ChannelReport::new(self.role, &values, self.rest);
        report.rate_hz = 1.0 / usual_s;
        report.is_even = is_even;
        report.inverted = self.inverted;
        report.late_s = self.late_s;
        report.gaps = self.gaps;
        report.zero = zero;
        report.is_computed = is_computed;
        report.stated_zero = stated;
        let (first, last) = (self.times[0], self.times[self.times.len() - 1]);
        let count = ((last - first) / usual_s).round() + 1.0;
        let may_be_even = longest_s <= GAP * usual_s;
        let asked = matches!(preparation.low_pass, LowPass::At(_));
        if count < 4.0 || count > MAX_ROWS as f64 || !(may_be_even || asked) {
            report.told(&values);
            return if asked { Err(PrepareError::Uneven(self.role)) } else { Ok((self.times.clone(), values, report)) };
        }
        // An even series of the same fineness; of an even one its own samples.
        let rate_hz = (count - 1.0) / (last - first);
        report.rate_hz = rate_hz;
        let even_times: Vec<f64> = (0..count as usize).map(|n| first + n as f64 / rate_hz).collect();
        let (even, rest) = if is_even && count as usize == values.len() {
            (values.clone(), self.rest)
        } else {
            (interpolated(&self.times, &values, &even_times), self.rest_on(&even_times))
        };
        if may_be_even {
            report.noise = noise::noise(&even, rate_hz, rest);
            report.band_hz = report.noise.map(|noise| noise::band(&even, rate_hz, &noise));
            // Straight lines between samples average their noise, to 0.8 of it; that of the rest is the samples' own.
            if let Some(noise) = report.noise.as_mut().filter(|noise| noise.whence == Whence::Rest) {
                noise.rms = noise::deviation(&values[..self.rest]);
            }
        }
        report.told(&values);
        let cutoff_hz = match (preparation.low_pass, report.band_hz) {
            (LowPass::Off, _) | (LowPass::Own, None) => None,
            (LowPass::At(hz), _) => Some(hz),
            // Noise and nothing else: what is left is its mean.
            (LowPass::Own, Some(band)) => Some(band.max(2.0 / (last - first))).filter(|hz| *hz < 0.45 * rate_hz),
        };
        let Some(cutoff_hz) = cutoff_hz else { return Ok((self.times.clone(), values, report)) };
        let filter = Butterworth::low_pass(preparation.order, cutoff_hz, rate_hz).ok_or(PrepareError::Cutoff {
            role: self.role,
            cutoff_hz,
            rate_hz,
        })?;
        report.low_pass = Some(Filtered { order: preparation.order, cutoff_hz });
        let filtered = filter.forth_and_back(&even);
        if is_even && even_times.len() == self.times.len() {
            return Ok((self.times.clone(), filtered, report));
        }
        report.resampled_hz = Some(rate_hz);
        Ok((even_times, filtered, report))
    }
}

/// A series at other instants, linearly interpolated; both axes ascend.
pub fn interpolated(times: &[f64], values: &[f64], wanted: &[f64]) -> Vec<f64> {
    let mut i = 0;
    wanted
        .iter()
        .map(|&t| {
            while i + 2 < times.len() && times[i + 1] <= t {
                i += 1;
            }
            let share = ((t - times[i]) / (times[i + 1] - times[i])).clamp(0.0, 1.0);
            values[i] + share * (values[i + 1] - values[i])
        })
        .collect()
}

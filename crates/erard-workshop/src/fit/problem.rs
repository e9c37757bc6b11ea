//! The question of a fit: which parameters of an instrument explain which recordings.

use std::ops::Range;

use erard::instrument::Instrument;

use super::data::Data;
use super::parameter::varied;
use super::readings::Readings;
use super::{FitError, FitParameter};

/// Largest delay in either direction, ms.
const MAX_DELAY_MS: f64 = 20.0;

/// Question of a fit: parameters of an instrument, and the recordings that they explain. It does not change while it is
/// answered.
///
/// The solver's points hold the parameters ([`FitParameter::to_solver`]), then the delays, ms.
#[derive(Debug)]
pub struct Problem {
    instrument: Instrument,
    parameters: Vec<FitParameter>,
    recordings: Vec<Data>,
    blocks: Vec<ResidualBlock>,
    delay: bool,
}

/// Residuals of one column of one recording.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ResidualBlock {
    /// Index of the recording.
    pub recording: usize,
    /// Column compared.
    pub column: &'static str,
    /// Title: the column, and the recording if there are several.
    pub title: String,
    /// Range among all residuals.
    pub rows: Range<usize>,
    /// Index of the column among the recording's compared ones.
    pub(super) place: usize,
}

impl Problem {
    /// Makes a problem from an instrument, the parameters to fit and recordings. With `delay`, the delay of each block
    /// against its drive is estimated.
    ///
    /// # Errors
    /// Without recordings.
    pub fn new(
        instrument: &Instrument,
        parameters: Vec<FitParameter>,
        recordings: Vec<Data>,
        delay: bool,
    ) -> Result<Self, FitError> {
        if recordings.is_empty() {
            return Err(FitError::argument("recordings", "found none, expected one or more"));
        }
        let mut blocks: Vec<ResidualBlock> = Vec::new();
        for (recording, one) in recordings.iter().enumerate() {
            for (place, column) in one.columns.iter().copied().enumerate() {
                let title = if recordings.len() == 1 {
                    column.to_owned()
                } else {
                    format!("{column} of recording {recording}")
                };
                let first = blocks.last().map_or(0, |block| block.rows.end);
                blocks.push(ResidualBlock { recording, column, title, rows: first..first + one.rows(), place });
            }
        }
        // Outlines do not move.
        let instrument = instrument.clone().without_outlines();
        Ok(Problem { instrument, parameters, recordings, blocks, delay })
    }

    /// Instrument at the start of the fit, without outlines.
    pub(super) fn instrument(&self) -> &Instrument {
        &self.instrument
    }

    /// Fitted parameters.
    pub fn parameters(&self) -> &[FitParameter] {
        &self.parameters
    }

    /// Recordings.
    pub fn recordings(&self) -> &[Data] {
        &self.recordings
    }

    /// Blocks of residuals, in their order.
    pub fn blocks(&self) -> &[ResidualBlock] {
        &self.blocks
    }

    /// Recording of a block.
    pub(super) fn recording_of(&self, block: &ResidualBlock) -> &Data {
        &self.recordings[block.recording]
    }

    /// Number of residuals.
    pub fn rows(&self) -> usize {
        self.blocks.last().map_or(0, |block| block.rows.end)
    }

    /// Whether delays are estimated.
    pub(super) fn has_delays(&self) -> bool {
        self.delay
    }

    /// Number of delays: 0, or one for every block.
    pub(super) fn delays(&self) -> usize {
        if self.delay { self.blocks.len() } else { 0 }
    }

    /// Delay of a block against the drive, s; positive if recorded late.
    pub(super) fn delay_s(&self, point: &[f64], block: usize) -> f64 {
        if self.delay { 1e-3 * point[self.parameters.len() + block] } else { 0.0 }
    }

    /// Lower and upper bounds of the solver's points.
    pub fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let delays = std::iter::repeat_n([-MAX_DELAY_MS, MAX_DELAY_MS], self.delays());
        self.parameters.iter().map(FitParameter::bounds).chain(delays).map(|[low, high]| (low, high)).unzip()
    }

    /// Moves a point inside its bounds, with a small margin.
    pub(super) fn clamp(&self, point: &mut [f64]) {
        let (low, high) = self.bounds();
        for (k, x) in point.iter_mut().enumerate() {
            let margin = 1e-6 * (high[k] - low[k]);
            *x = x.clamp(low[k] + margin, high[k] - margin);
        }
    }

    /// Returns the turns and factors of a point.
    pub fn from_solver(&self, point: &[f64]) -> Vec<f64> {
        self.parameters.iter().zip(point).map(|(one, p)| one.from_solver(*p)).collect()
    }

    /// Returns the instrument at a point; `None` if it cannot have these values.
    pub(super) fn instrument_at(&self, point: &[f64]) -> Option<Instrument> {
        varied(&self.instrument, &self.parameters, &self.from_solver(point))
    }

    /// Expected readings of each block at a point, with its delay, at the instants compared.
    pub(super) fn fitted(&self, point: &[f64], readings: &Readings) -> Vec<Vec<f64>> {
        let of = |(k, block): (usize, &ResidualBlock)| {
            let own = self.recording_of(block);
            let late = delayed(&own.time_s, readings.curve(k), self.delay_s(point, k));
            late[own.compared.clone()].to_vec()
        };
        self.blocks.iter().enumerate().map(of).collect()
    }
}

/// Returns a curve delayed by `late_s`, with constant ends.
pub(super) fn delayed(times: &[f64], curve: &[f64], late_s: f64) -> Vec<f64> {
    if late_s == 0.0 {
        return curve.to_vec();
    }
    let last = times.len() - 1;
    let of = |t: f64| {
        let t = t - late_s;
        if t <= times[0] {
            return curve[0];
        }
        if t >= times[last] {
            return curve[last];
        }
        let k = times.partition_point(|time| *time <= t) - 1;
        curve[k] + (curve[k + 1] - curve[k]) * (t - times[k]) / (times[k + 1] - times[k])
    };
    times.iter().map(|t| of(*t)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_delayed() {
        let (times, curve) = ([0.0, 1.0, 2.0, 3.0], [0.0, 10.0, 20.0, 0.0]);
        assert_eq!(delayed(&times, &curve, 0.5), [0.0, 5.0, 15.0, 10.0]);
        assert_eq!(delayed(&times, &curve, -0.5), [5.0, 15.0, 10.0, 0.0]);
        assert_eq!(delayed(&times, &curve, 0.0), curve);
    }
}

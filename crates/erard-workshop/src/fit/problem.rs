//! Residuals over the inner parameters: those of the instrument, then the delays in ms.

use std::ops::Range;

use crate::study::{Job, Sampling, Workers, sample_all};
use erard::instrument::Instrument;
use erard::run::SimulationError;

use super::candidate::Candidate;
use super::data::{COLUMNS, Data};
use super::free::varied;
use super::{FitError, Free, Loss};

/// Residual of a point that cannot be played: worse than any other.
const WORST: f64 = 1e6;
/// Largest delay in either direction, ms.
const LONGEST_DELAY_MS: f64 = 20.0;

/// Measured quantity of a recording with its fitted values; SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct Channel {
    /// Title: the column, and the recording if there are several.
    pub title: String,
    /// Number of the recording.
    pub recording: usize,
    /// Column of the quantity.
    pub column: &'static str,
    /// Instants, s.
    pub time_s: Vec<f64>,
    /// Measured values there.
    pub measured: Vec<f64>,
    /// Fitted values.
    pub fitted: Vec<f64>,
    /// Noise.
    pub sigma: f64,
    /// Delay against the drive, s; positive if recorded late.
    pub delay_s: f64,
}

/// Samples of the model: by recording, point and column.
pub(crate) type Curves = Vec<Vec<Vec<Vec<f64>>>>;

/// Receives the number of strokes played, at least every 20 ms during play; false ends the work.
pub(crate) type Proceed = Box<dyn FnMut(u64) -> bool + Send>;

/// Residuals of recordings, in units of their noise.
pub struct Problem {
    /// Instrument at the start of the fit, with the fixed parameters; without outlines.
    pub instrument: Instrument,
    /// Free parameters.
    pub free: Vec<Free>,
    /// Recordings.
    pub data: Vec<Data>,
    /// Whether the delay of each channel against the drive is estimated.
    pub delay: bool,
    /// Number of threads.
    pub threads: usize,
    /// Noise of every channel, root mean square, N, m or m/s.
    pub sigma: Vec<f64>,
    /// Known noise of each channel; `None` if unknown.
    pub told: Vec<Option<f64>>,
    /// Relative standard deviation of every channel's noise; 0 where the caller gave the noise.
    pub uncertainty: Vec<f64>,
    /// Noise of each recording's drive, where known.
    pub drive_sigma: Vec<Option<f64>>,
    /// Weight of every row; `None` weights all alike.
    pub weights: Option<Vec<f64>>,
    /// Whether the Jacobian of fine steps comes from the model's own derivatives.
    pub exact: bool,
    /// Number of strokes played without derivatives.
    pub evaluations: u64,
    /// Number of strokes played with derivatives.
    pub differentiated: u64,
    /// Progress, and whether to go on.
    pub watch: Proceed,
    pub(super) kept: Option<(Vec<f64>, Vec<f64>)>,
    /// Loss function for comparing points.
    pub(super) loss: Loss,
    /// The best point played.
    pub(super) best: Option<Candidate>,
    /// Root mean square residual of each channel at the start of the fit, N, m or m/s.
    pub(super) rms_at_start: Vec<f64>,
}

impl Problem {
    /// Makes a problem from an instrument and recordings. `sigma` is the known noise of columns, including the driving
    /// one, N, m or m/s.
    ///
    /// # Errors
    /// If `sigma` names a missing column, or a noise is not positive (for the driving column: is negative).
    pub fn new(
        instrument: &Instrument,
        free: Vec<Free>,
        data: Vec<Data>,
        delay: bool,
        sigma: &[(String, f64)],
        threads: usize,
    ) -> Result<Self, FitError> {
        if data.is_empty() {
            return Err(FitError::asked("recordings", "found none, expected one or more"));
        }
        let known = |column: &str| sigma.iter().find(|(own, _)| own == column).map(|(_, sigma)| *sigma);
        let mut problem = Problem {
            instrument: Instrument { parts: Vec::new(), ..instrument.clone() },
            free,
            delay,
            threads,
            sigma: Vec::new(),
            told: Vec::new(),
            uncertainty: Vec::new(),
            drive_sigma: data.iter().map(|one| known(one.driving).or_else(|| one.noise(one.driving))).collect(),
            data,
            weights: None,
            exact: false,
            evaluations: 0,
            differentiated: 0,
            watch: Box::new(|_| true),
            kept: None,
            loss: Loss::Linear,
            best: None,
            rms_at_start: Vec::new(),
        };
        let channels: Vec<(usize, &str)> = problem.channels().collect();
        for (column, sigma) in sigma {
            let compared = channels.iter().any(|(_, own)| own == column);
            if !compared && !problem.data.iter().any(|one| one.driving == column) {
                return Err(FitError::asked(
                    "sigma",
                    format!("{column} is neither compared nor the drive; expected no noise (sigma) for it"),
                ));
            }
            if !(sigma.is_finite() && *sigma >= 0.0 && (*sigma > 0.0 || !compared)) {
                return Err(FitError::asked("sigma", format!("{column} is {sigma}; expected positive numbers")));
            }
        }
        let told: Vec<Option<f64>> =
            channels.iter().map(|(i, column)| known(column).or_else(|| problem.data[*i].noise(column))).collect();
        let usual = |column: &str| COLUMNS.iter().find(|(own, ..)| *own == column).map_or(1.0, |(.., sigma)| *sigma);
        let sigma: Vec<f64> =
            channels.iter().zip(&told).map(|((_, column), told)| told.unwrap_or_else(|| usual(column))).collect();
        if let Some(at) = sigma.iter().position(|sigma| *sigma <= 0.0) {
            let column = channels[at].1;
            return Err(FitError::asked(
                "sigma",
                format!("{column} shows no noise; expected its noise (sigma) to be given"),
            ));
        }
        let uncertain = |(i, column): &(usize, &'static str)| match known(column) {
            Some(_) => 0.0,
            None => problem.data[*i].noise_uncertainty(column),
        };
        problem.uncertainty = channels.iter().map(uncertain).collect();
        (problem.told, problem.sigma) = (told, sigma);
        Ok(problem)
    }

    /// Recording and column of every channel, in the order of the residuals.
    pub fn channels(&self) -> impl Iterator<Item = (usize, &'static str)> + '_ {
        self.data.iter().enumerate().flat_map(|(i, one)| one.columns.iter().map(move |column| (i, *column)))
    }

    /// Range of each channel's rows among the residuals.
    pub(super) fn channel_rows(&self) -> Vec<Range<usize>> {
        let mut first = 0;
        let of = |(recording, _): (usize, &str)| {
            let rows = first..first + self.data[recording].rows();
            first = rows.end;
            rows
        };
        self.channels().map(of).collect()
    }

    /// Recording of a channel, and its place among that recording's columns.
    pub(super) fn place(&self, channel: usize) -> (usize, usize) {
        let mut first = 0;
        for (i, one) in self.data.iter().enumerate() {
            if channel < first + one.columns.len() {
                return (i, channel - first);
            }
            first += one.columns.len();
        }
        unreachable!("there are no more channels than columns")
    }

    /// Title of a channel: its column, and the recording if there are several.
    pub(crate) fn title(&self, channel: usize) -> String {
        let (i, column) = self.place(channel);
        let column = self.data[i].columns[column];
        if self.data.len() == 1 { column.to_owned() } else { format!("{column} of recording {i}") }
    }

    /// Number of delays: 0, or one for every channel.
    pub(crate) fn delays(&self) -> usize {
        if self.delay { self.sigma.len() } else { 0 }
    }

    /// Number of residuals.
    pub fn rows(&self) -> usize {
        self.data.iter().map(|one| one.rows() * one.columns.len()).sum()
    }

    /// Driving columns of unknown noise.
    pub(crate) fn silent(&self) -> Vec<&'static str> {
        let unknown = self.data.iter().zip(&self.drive_sigma).filter(|(_, sigma)| sigma.is_none());
        let mut found: Vec<&'static str> = unknown.map(|(one, _)| one.driving).collect();
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Lower and upper bounds of the inner parameters.
    pub fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        let delays = std::iter::repeat_n([-LONGEST_DELAY_MS, LONGEST_DELAY_MS], self.delays());
        self.free.iter().map(Free::bounds).chain(delays).map(|[low, high]| (low, high)).unzip()
    }

    /// Moves a point inside its bounds, with a small margin.
    pub(super) fn keep_inside(&self, point: &mut [f64]) {
        let (low, high) = self.bounds();
        for (k, x) in point.iter_mut().enumerate() {
            let margin = 1e-6 * (high[k] - low[k]);
            *x = x.clamp(low[k] + margin, high[k] - margin);
        }
    }

    /// Returns the outer values of a point.
    pub fn outer(&self, point: &[f64]) -> Vec<f64> {
        self.free.iter().zip(point).map(|(one, p)| one.outer(*p)).collect()
    }

    /// Returns the instrument at a point; `None` if it cannot have these values.
    pub(crate) fn at(&self, point: &[f64]) -> Option<Instrument> {
        varied(&self.instrument, &self.free, &self.outer(point))
    }

    pub(super) fn workers(&self) -> Workers {
        Workers { threads: self.threads, ..Workers::all() }
    }

    /// Plays every recording at every point, all points of one recording side by side. A point that cannot be played
    /// gives NaN.
    ///
    /// # Errors
    /// An interruption, or a setting that is wrong for all points.
    pub(crate) fn simulate(&mut self, points: &[Vec<f64>]) -> Result<Curves, FitError> {
        let variants: Vec<Option<Instrument>> = points.iter().map(|point| self.at(point)).collect();
        let places: Vec<usize> = (0..points.len()).filter(|&row| variants[row].is_some()).collect();
        let instruments: Vec<Instrument> = variants.into_iter().flatten().collect();
        let mut all = Vec::with_capacity(self.data.len());
        for i in 0..self.data.len() {
            let one = &self.data[i];
            let none = || vec![vec![f64::NAN; one.time_s.len()]; one.columns.len()];
            let mut curves: Vec<Vec<Vec<f64>>> = points.iter().map(|_| none()).collect();
            if let Some(first) = instruments.first() {
                let inputs =
                    |at: usize| one.stroke.inputs(&instruments[at].finger).map(|stroke| Job { instrument: at, stroke });
                let jobs = (0..instruments.len()).map(inputs).collect::<Result<Vec<_>, _>>()?;
                let played =
                    sampled(first, &instruments, one, jobs, self.workers(), self.evaluations, &mut self.watch)?;
                for (row, found) in places.iter().zip(played) {
                    if let Some(found) = found {
                        curves[*row] = found;
                    }
                }
            }
            self.evaluations += points.len() as u64;
            all.push(curves);
        }
        self.go_on()?;
        Ok(all)
    }

    pub(super) fn go_on(&mut self) -> Result<(), FitError> {
        if (self.watch)(self.evaluations) { Ok(()) } else { Err(SimulationError::Interrupted.into()) }
    }

    /// Delay of a channel against the drive, s; positive if recorded late.
    pub(crate) fn delay_s(&self, point: &[f64], channel: usize) -> f64 {
        if self.delay { 1e-3 * point[self.free.len() + channel] } else { 0.0 }
    }

    /// Expected readings of each channel, with its delay, at the point played in row `row`.
    pub(crate) fn fitted(&self, point: &[f64], played: &Curves, row: usize) -> Vec<Vec<f64>> {
        (0..self.sigma.len())
            .map(|channel| {
                let (i, column) = self.place(channel);
                let one = &self.data[i];
                let late = moved(&one.time_s, &played[i][row][column], self.delay_s(point, channel));
                late[one.compared.clone()].to_vec()
            })
            .collect()
    }

    /// Weighted residuals at the point played in row `row`; not finite if it could not be played. The point becomes a
    /// candidate.
    pub(crate) fn left(&mut self, point: &[f64], played: &Curves, row: usize) -> Vec<f64> {
        let mut left = self.unweighted(point, played, row);
        self.consider(point, &left);
        self.weigh(&mut left);
        left
    }

    /// Unweighted residuals at the point played in row `row`.
    pub(super) fn unweighted(&self, point: &[f64], played: &Curves, row: usize) -> Vec<f64> {
        let mut left = Vec::with_capacity(self.rows());
        for (channel, curve) in self.fitted(point, played, row).iter().enumerate() {
            let (i, column) = self.place(channel);
            let measured = &self.data[i].measured[column];
            left.extend(curve.iter().zip(measured).map(|(fitted, measured)| (fitted - measured) / self.sigma[channel]));
        }
        left
    }

    pub(super) fn weigh(&self, rows: &mut [f64]) {
        if let Some(weights) = &self.weights {
            rows.iter_mut().zip(weights).for_each(|(row, weight)| *row *= weight);
        }
    }

    /// Weighted residuals at a point: fitted less measured, over the noise.
    ///
    /// # Errors
    /// An interruption.
    pub(crate) fn residuals(&mut self, point: &[f64]) -> Result<Vec<f64>, FitError> {
        if let Some((of, left)) = &self.kept
            && of == point
        {
            let mut left = left.clone();
            self.weigh(&mut left);
            return Ok(left);
        }
        let played = self.simulate(&[point.to_vec()])?;
        let mut left = self.unweighted(point, &played, 0);
        self.consider(point, &left);
        if left.iter().any(|x| !x.is_finite()) {
            left.fill(WORST);
        }
        self.kept = Some((point.to_vec(), left.clone()));
        self.weigh(&mut left);
        Ok(left)
    }

    /// Weighted residuals at many points, played side by side; not finite where a point cannot be played.
    ///
    /// # Errors
    /// An interruption.
    pub fn residuals_at(&mut self, points: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, FitError> {
        let played = self.simulate(points)?;
        Ok(points.iter().enumerate().map(|(row, point)| self.left(point, &played, row)).collect())
    }

    /// Whether these are the residuals of a point that cannot be played.
    pub(crate) fn is_unplayable(residuals: &[f64]) -> bool {
        !residuals.is_empty() && residuals.iter().all(|x| *x == WORST)
    }

    /// Sets the noise of every channel to another fit's estimate, N, m or m/s.
    ///
    /// # Panics
    /// If the number of values differs from the number of channels.
    pub fn take_noise(&mut self, sigma: Vec<f64>) {
        assert_eq!(sigma.len(), self.sigma.len(), "one for every channel");
        self.sigma = sigma;
        self.forget();
    }

    /// Returns every measured quantity with the model's values at a point.
    ///
    /// # Errors
    /// An interruption.
    pub fn curves(&mut self, point: &[f64]) -> Result<Vec<Channel>, FitError> {
        let played = self.simulate(&[point.to_vec()])?;
        let fitted = self.fitted(point, &played, 0);
        let of = |(k, fitted): (usize, Vec<f64>)| {
            let (recording, column) = self.place(k);
            let one = &self.data[recording];
            Channel {
                title: self.title(k),
                recording,
                column: one.columns[column],
                time_s: one.time_s[one.compared.clone()].to_vec(),
                measured: one.measured[column].clone(),
                fitted,
                sigma: self.sigma[k],
                delay_s: self.delay_s(point, k),
            }
        };
        Ok(fitted.into_iter().enumerate().map(of).collect())
    }

    /// Drops the residuals of the last point: noise or weights have changed.
    pub(crate) fn forget(&mut self) {
        self.kept = None;
    }

    /// Estimates the unknown noise of channels from the residuals at a point. Returns whether it changed by less than 2
    /// %.
    ///
    /// # Errors
    /// An interruption.
    pub(crate) fn estimate_noise(&mut self, point: &[f64]) -> Result<bool, FitError> {
        if self.told.iter().all(Option::is_some) {
            return Ok(true);
        }
        let left = self.residuals(point)?;
        let share = 1.0 - point.len() as f64 / left.len() as f64;
        let before = self.sigma.clone();
        for (channel, rows) in self.channel_rows().into_iter().enumerate() {
            let own = &left[rows];
            if self.told[channel].is_none() {
                let mean = own.iter().map(|x| x * x).sum::<f64>() / own.len() as f64;
                self.sigma[channel] *= (mean / share).sqrt().max(1e-9);
            }
        }
        self.forget();
        Ok(self.sigma.iter().zip(&before).all(|(now, before)| (now / before - 1.0).abs() < 0.02))
    }
}

/// Plays jobs over a recording and samples the compared columns; `None` for a job that could not be played.
pub(super) fn sampled(
    first: &Instrument,
    instruments: &[Instrument],
    one: &Data,
    jobs: Vec<Job<'_>>,
    workers: Workers,
    before: u64,
    watch: &mut Proceed,
) -> Result<Vec<Option<Vec<Vec<f64>>>>, FitError> {
    // Every instrument has the columns for key, hammer and force.
    let sampling = Sampling::of(first, &one.columns, one.every)
        .map_err(|error| FitError::Recording { recording: one.name.clone(), message: error.to_string() })?;
    let count = jobs.len() as f64;
    let mut tell = |share: f64| watch(before + (share * count) as u64);
    let results = sample_all(instruments, jobs, &one.setup(), Some(&sampling), workers, &mut tell)?;
    let of = |result: Result<crate::study::Played, SimulationError>| {
        let mut samples = result.ok()?.samples;
        samples.resize(one.columns.len(), Vec::new());
        samples.iter_mut().for_each(|own| own.resize(one.time_s.len(), f64::NAN));
        Some(samples)
    };
    Ok(results.into_iter().map(of).collect())
}

/// Returns a curve delayed by `late_s`, with constant ends.
pub(super) fn moved(times: &[f64], curve: &[f64], late_s: f64) -> Vec<f64> {
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
    fn curves_are_moved() {
        let (times, curve) = ([0.0, 1.0, 2.0, 3.0], [0.0, 10.0, 20.0, 0.0]);
        assert_eq!(moved(&times, &curve, 0.5), [0.0, 5.0, 15.0, 10.0]);
        assert_eq!(moved(&times, &curve, -0.5), [5.0, 15.0, 10.0, 0.0]);
        assert_eq!(moved(&times, &curve, 0.0), curve);
    }
}

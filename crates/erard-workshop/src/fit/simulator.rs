//! Plays the recorded strokes on the model at the solver's points.

use crate::sensitivities::{Differentiation, Rest, Sampled, Variable, gradient};
use crate::study::{Job, Played, Sampling, Stroke as Drive, Workers, play_all, sample_all};
use erard::instrument::Instrument;
use erard::player::Input;
use erard::run::SimulationError;
use erard::stroke::Stroke;

use super::data::Data;
use super::problem::{Problem, ResidualBlock};
use super::readings::Readings;
use super::{FitError, NoiseModel};

/// Duration of the first stage of a fit beyond the impact, s: later motion reacts strongly to small changes.
const AFTER_IMPACT_S: f64 = 2e-3;

/// Receives the number of strokes played, at least every 20 ms during play; returns false to end the work.
pub type Progress<'a> = Box<dyn FnMut(u64) -> bool + Send + 'a>;

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

/// Plays the strokes of a problem, and counts them.
pub struct Simulator<'a> {
    problem: &'a Problem,
    threads: usize,
    progress: Progress<'a>,
    evaluations: u64,
    differentiated: u64,
    /// Whether strokes are played in half of the recordings' steps.
    in_half_steps: bool,
    /// The point played last and its readings.
    cache: Option<(Vec<f64>, Readings)>,
}

impl<'a> Simulator<'a> {
    /// Makes a simulator on so many threads. `progress` returns false to end the work.
    pub fn new(problem: &'a Problem, threads: usize, progress: Progress<'a>) -> Self {
        Simulator { problem, threads, progress, evaluations: 0, differentiated: 0, in_half_steps: false, cache: None }
    }

    /// The problem.
    pub fn problem(&self) -> &'a Problem {
        self.problem
    }

    /// Number of strokes played without derivatives.
    pub(super) fn evaluations(&self) -> u64 {
        self.evaluations
    }

    /// Number of strokes played with derivatives.
    pub(super) fn differentiated(&self) -> u64 {
        self.differentiated
    }

    /// Reports progress.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn report(&mut self) -> Result<(), FitError> {
        if (self.progress)(self.evaluations) { Ok(()) } else { Err(SimulationError::Interrupted.into()) }
    }

    /// Plays every recording at every point, all points of one recording side by side. A point that cannot be played
    /// gives NaN.
    ///
    /// # Errors
    /// An interruption, or a setting that is wrong for all points.
    pub(super) fn play(&mut self, points: &[Vec<f64>]) -> Result<Vec<Readings>, FitError> {
        let problem = self.problem;
        let variants: Vec<Option<Instrument>> = points.iter().map(|point| problem.instrument_at(point)).collect();
        let playable: Vec<usize> = (0..points.len()).filter(|&row| variants[row].is_some()).collect();
        let instruments: Vec<Instrument> = variants.into_iter().flatten().collect();
        let instants = problem.blocks().iter().map(|block| problem.recording_of(block).time_s.len());
        let mut all: Vec<Readings> = points.iter().map(|_| Readings::unplayable(instants.clone())).collect();
        let mut first = 0;
        for one in problem.recordings() {
            let strokes: Vec<(usize, &Stroke)> = (0..instruments.len()).map(|at| (at, &one.stroke)).collect();
            let played = self.play_strokes(&instruments, one, &strokes)?;
            for (row, curves) in playable.iter().zip(played) {
                if let Some(curves) = curves {
                    all[*row].replace(first, curves);
                }
            }
            first += one.columns.len();
            self.evaluations += points.len() as u64;
        }
        self.report()?;
        Ok(all)
    }

    /// Plays a recording with its drive replaced by these strokes on the instrument at a point. Returns the curves of
    /// the recording's columns for every stroke; `None` for one that could not be played.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn play_drives(
        &mut self,
        point: &[f64],
        one: &Data,
        strokes: &[Stroke],
    ) -> Result<Vec<Option<Vec<Vec<f64>>>>, FitError> {
        let instrument = self.problem.instrument_at(point).ok_or(FitError::Unplayable)?;
        let strokes_on: Vec<(usize, &Stroke)> = strokes.iter().map(|stroke| (0, stroke)).collect();
        let played = self.play_strokes(std::slice::from_ref(&instrument), one, &strokes_on)?;
        self.evaluations += strokes.len() as u64;
        Ok(played)
    }

    /// Plays strokes, each on the instrument of its index, over a recording's time, and samples its columns.
    fn play_strokes(
        &mut self,
        instruments: &[Instrument],
        one: &Data,
        strokes: &[(usize, &Stroke)],
    ) -> Result<Vec<Option<Vec<Vec<f64>>>>, FitError> {
        let Some(first) = instruments.first() else { return Ok(Vec::new()) };
        let jobs = strokes.iter().map(|(instrument, stroke)| {
            let inputs = stroke.inputs(&instruments[*instrument].finger)?;
            Ok(Job { instrument: *instrument, stroke: inputs })
        });
        let jobs = jobs.collect::<Result<Vec<_>, FitError>>()?;
        // Every instrument has the columns for key, hammer and force.
        let (mut setup, mut every) = (one.setup(), one.every);
        if self.in_half_steps {
            (setup.settings.step, every) = (0.5 * setup.settings.step, 2 * every);
        }
        let sampling = Sampling::of(first, &one.columns, every)
            .map_err(|error| FitError::Recording { recording: one.name.clone(), message: error.to_string() })?;
        let (before, count) = (self.evaluations, jobs.len() as f64);
        let workers = self.workers();
        let mut progress = |share: f64| (self.progress)(before + (share * count) as u64);
        let results = sample_all(instruments, jobs, &setup, Some(&sampling), workers, &mut progress)?;
        let of = |result: Result<Played, SimulationError>| {
            let mut samples = result.ok()?.samples;
            samples.resize(one.columns.len(), Vec::new());
            samples.iter_mut().for_each(|own| own.resize(one.time_s.len(), f64::NAN));
            Some(samples)
        };
        Ok(results.into_iter().map(of).collect())
    }

    fn workers(&self) -> Workers {
        Workers { threads: self.threads, ..Workers::all() }
    }

    /// Whether the cache holds a point.
    pub(super) fn holds(&self, point: &[f64]) -> bool {
        self.cache.as_ref().is_some_and(|(of, _)| of == point)
    }

    /// Returns the readings at a point. Plays it unless the cache holds it.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn readings(&mut self, point: &[f64]) -> Result<&Readings, FitError> {
        if !self.holds(point) {
            let played = self.play(&[point.to_vec()])?;
            self.cache = played.into_iter().next().map(|readings| (point.to_vec(), readings));
        }
        Ok(&self.cache.as_ref().expect("the point was just played").1)
    }

    /// Caches the readings at a point.
    pub(super) fn remember(&mut self, point: &[f64], readings: Readings) {
        self.cache = Some((point.to_vec(), readings));
    }

    /// Empties the cache: another stage begins, and plays its first point itself. The number of strokes of a stage then
    /// does not depend on the stage before.
    pub(super) fn clear_cache(&mut self) {
        self.cache = None;
    }

    /// Plays in half of the recordings' steps during some work. The cache is empty before and after it.
    ///
    /// # Errors
    /// Errors of the work.
    pub(super) fn with_half_steps<T>(
        &mut self,
        work: impl FnOnce(&mut Self) -> Result<T, FitError>,
    ) -> Result<T, FitError> {
        self.clear_cache();
        self.in_half_steps = true;
        let found = work(self);
        self.in_half_steps = false;
        self.clear_cache();
        found
    }

    /// Residuals at many points, played side by side; not finite where a point cannot be played.
    ///
    /// # Errors
    /// An interruption.
    pub fn residuals(&mut self, noise: &NoiseModel, points: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, FitError> {
        let played = self.play(points)?;
        Ok(points.iter().zip(&played).map(|(point, one)| noise.residuals(self.problem, point, one)).collect())
    }

    /// Returns every measured quantity with the model's values at a point.
    ///
    /// # Errors
    /// An interruption.
    pub fn curves(&mut self, noise: &NoiseModel, point: &[f64]) -> Result<Vec<Channel>, FitError> {
        let problem = self.problem;
        let played = self.play(&[point.to_vec()])?;
        let fitted = problem.fitted(point, &played[0]);
        let of = |(k, (block, fitted)): (usize, (&ResidualBlock, Vec<f64>))| {
            let one = problem.recording_of(block);
            Channel {
                title: block.title.clone(),
                recording: block.recording,
                column: block.column,
                time_s: one.time_s[one.compared.clone()].to_vec(),
                measured: one.measured[block.place].clone(),
                fitted,
                sigma: noise.sigma[k],
                delay_s: problem.delay_s(point, k),
            }
        };
        Ok(problem.blocks().iter().zip(fitted).enumerate().map(of).collect())
    }

    /// Returns the time of the first impact in each recording's stroke at a point, on the recording's clock, s; `None`
    /// without an impact or if the stroke cannot be played.
    ///
    /// # Errors
    /// An interruption.
    pub(super) fn first_impacts(&mut self, point: &[f64]) -> Result<Vec<Option<f64>>, FitError> {
        let recordings = self.problem.recordings();
        let Some(instrument) = self.problem.instrument_at(point) else { return Ok(vec![None; recordings.len()]) };
        let (workers, count) = (self.workers(), self.evaluations);
        let mut impacts = Vec::with_capacity(recordings.len());
        for one in recordings {
            let job = vec![Job { instrument: 0, stroke: one.stroke.inputs(&instrument.finger)? }];
            let progress = &mut self.progress;
            let played =
                play_all(std::slice::from_ref(&instrument), job, &one.setup(), workers, &mut |_| progress(count))?;
            let first = played.into_iter().next().and_then(Result::ok);
            impacts.push(first.and_then(|played| played.events.hammer_contact_s()));
        }
        Ok(impacts)
    }

    /// Returns row weights: 1 up to shortly after the impact, 0 later.
    ///
    /// # Errors
    /// An interruption.
    pub fn weights_until_impact(&mut self, point: &[f64]) -> Result<Vec<f64>, FitError> {
        let problem = self.problem;
        let impacts = self.first_impacts(point)?;
        let mut weights = Vec::with_capacity(problem.rows());
        for block in problem.blocks() {
            let (one, impact_s) = (problem.recording_of(block), impacts[block.recording]);
            let weight = |t: &f64| f64::from(impact_s.is_none_or(|s| *t <= s + AFTER_IMPACT_S));
            weights.extend(one.time_s[one.compared.clone()].iter().map(weight));
        }
        Ok(weights)
    }

    /// Returns the derivatives of each recording's sampled columns by the parameters at a point: each recording is
    /// played once, eight parameters at a time.
    ///
    /// # Errors
    /// An interruption; a model without derivatives.
    pub(super) fn play_with_derivatives(&mut self, point: &[f64]) -> Result<Vec<Vec<Sampled>>, FitError> {
        let problem = self.problem;
        let instrument = problem.instrument_at(point).ok_or(FitError::Unplayable)?;
        let mut by = Vec::with_capacity(problem.parameters().len());
        for one in problem.parameters() {
            let variable = Variable::named(&instrument, "", &one.name);
            by.push(variable.map_err(|error| FitError::argument("jacobian", error.to_string()))?);
        }
        let mut played: Vec<Vec<Sampled>> = Vec::new();
        for one in problem.recordings() {
            // Reports errors of the stroke before any work.
            drop(one.stroke.inputs(&instrument.finger)?);
            let stroke =
                || -> Drive<'_> { one.stroke.inputs(&instrument.finger).unwrap_or_else(|_| Box::new(|_| Input::Free)) };
            let (progress, count) = (&mut self.progress, self.evaluations);
            let mut progress = |_: f64| progress(count);
            let how = Differentiation {
                rest: Rest::Moves,
                sample_every: Some(one.every),
                compares: false,
                refuses: false,
                of: Vec::new(),
                threads: self.threads,
            };
            let found = gradient(&instrument, by.clone(), &stroke, &one.setup(), how, &mut progress)?;
            self.differentiated += 1;
            played.push(found.sampled);
        }
        self.report()?;
        Ok(played)
    }
}

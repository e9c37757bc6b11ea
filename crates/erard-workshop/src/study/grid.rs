//! The grid of a study: a stroke on every combination of the axes' values, and what each variant measures.

use erard::Progress;
use erard::instrument::Instrument;
use erard::player::{Input, RestKind, RestPose};
use erard::run::{Setup, SimulationError};
use erard::stroke::Stroke;
use erard::trust::worst_of_each;

use super::{Axis, Job, MakeStroke, OUTCOMES, OwnResult, Played, Source, Target, Workers, play_all, play_each};
use crate::compare::Which;
use crate::cores;
use crate::measure::norms::Line;
use crate::measure::{MeasureError, measure_some};
use crate::sample::{SampleError, SampleValues};

/// Strokes that are played at a time: their instruments are held in memory.
const PORTION: usize = 4096;

/// A study: what is varied, and what is done with each variant.
#[derive(Clone, Copy)]
pub struct Grid<'a> {
    /// The unvaried instrument, of the model that is played.
    pub instrument: &'a Instrument,
    /// Source of the variants.
    pub source: &'a Source,
    /// Model of a variant that is read from the source.
    pub model: Which,
    /// Varied names and their values; the last varies fastest.
    pub axes: &'a [Axis],
    /// Lines of the technician's sheet to measure on each variant.
    pub lines: &'a [&'static Line],
    /// How each variant comes to rest before it is measured. Strokes start as drawn.
    pub rest: RestKind,
    /// Stroke on all variants; an axis of forces replaces its force.
    pub stroke: &'a Stroke,
    /// Makes a stroke of its own for each variant instead.
    pub each: Option<&'a MakeStroke<'a>>,
    /// Setup of the runs.
    pub setup: &'a Setup,
    /// Threads and lanes.
    pub workers: Workers,
}

impl std::fmt::Debug for Grid<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Grid").field("axes", &self.axes).finish_non_exhaustive()
    }
}

/// One stroke of a study.
#[derive(Debug, Clone, PartialEq)]
pub struct StudyRow {
    /// The varied values as shown, one for each axis.
    pub values: Vec<f64>,
    /// The outcome, or why there is none.
    pub outcome: OwnResult,
    /// The variant's measures, in the order asked for; or why there are none.
    pub measured: MeasuredLines,
}

impl StudyRow {
    /// Reason why the stroke failed, or why nothing was measured.
    #[must_use]
    pub fn error(&self) -> Option<String> {
        match (&self.outcome, &self.measured) {
            (Err(error), _) => Some(error.clone()),
            (_, Err(error)) => Some(format!("not measured: {error}")),
            _ => None,
        }
    }

    /// Whether it was played and nothing speaks against it.
    #[must_use]
    pub fn is_trusted(&self) -> bool {
        self.outcome.as_ref().is_ok_and(|played| played.warnings.is_empty())
    }
}

/// Reasons not to trust strokes: for each kind and part the number of strokes, and the worst of them as a sentence.
#[must_use]
pub fn doubts<'a>(outcomes: impl Iterator<Item = &'a OwnResult> + Clone) -> Vec<String> {
    let count = outcomes.clone().count();
    let warnings = outcomes.filter_map(|outcome| outcome.as_ref().ok()).flat_map(|played| &played.warnings);
    let each = worst_of_each(warnings).into_iter();
    each.map(|(n, worst)| format!("{n} of {count} strokes; the worst: {worst}")).collect()
}

/// A column's name and its values.
pub type Column = (String, Vec<Option<f64>>);
/// Values of a variant's measured lines in their order, each `None` where it has none; or why it has no values.
pub type MeasuredLines = Result<Vec<Option<f64>>, String>;

/// `failed`, `trusted` and the energy residual.
const OF_THE_SOLUTION: usize = 3;

/// Title of a measured column: the line's key. A varied column may have that title already: `let_off_mm` is a screw
/// that is set and a distance that is measured. The measured one then begins with `measured_`.
#[must_use]
pub fn measured_title(axes: &[Axis], line: &Line) -> String {
    let is_taken = axes.iter().any(|axis| axis.column() == line.key);
    if is_taken { format!("measured_{}", line.key) } else { line.key.to_owned() }
}

impl Grid<'_> {
    /// Number of combinations.
    ///
    /// # Panics
    /// If a `usize` cannot hold it; [`Axis::parse_all`] makes no such axes, and [`Axis::combinations`] tells.
    #[must_use]
    pub fn count(&self) -> usize {
        Axis::combinations(self.axes).expect("a number of combinations")
    }

    /// Plays and measures every combination, in portions. `progress` receives the share done and ends the work by
    /// returning false. A variant that fails is a row with its reason.
    ///
    /// # Errors
    /// A setup out of range, or [`SimulationError::Interrupted`].
    pub fn play(&self, progress: &mut Progress<'_>) -> Result<Vec<StudyRow>, SimulationError> {
        self.play_rows(0..self.count(), progress)
    }

    /// Plays and measures some of the combinations, as [`Grid::play`] does.
    ///
    /// # Errors
    /// See [`Grid::play`].
    pub fn play_rows(
        &self,
        combinations: std::ops::Range<usize>,
        progress: &mut Progress<'_>,
    ) -> Result<Vec<StudyRow>, SimulationError> {
        let count = combinations.len();
        let mut rows = Vec::with_capacity(count);
        // Measuring one variant takes as long as playing many.
        let playing = if self.lines.is_empty() { 1.0 } else { 0.05 };
        while rows.len() < count {
            let from = rows.len();
            let portion: Vec<Vec<usize>> =
                combinations.clone().skip(from).take(PORTION).map(|k| self.combination(k)).collect();
            let size = portion.len() as f64;
            let mut tell = |share: f64| progress((from as f64 + share * size) / count as f64);
            let played = self.play_portion(&portion, &mut |share| tell(playing * share))?;
            let measured = self.measure_portion(&played, &mut |share| tell(playing + (1.0 - playing) * share))?;
            rows.extend(portion.iter().zip(played.outcomes).zip(measured).map(|((indices, outcome), measured)| {
                StudyRow {
                    values: self.axes.iter().zip(indices).map(|(axis, &i)| axis.shown[i]).collect(),
                    outcome,
                    measured,
                }
            }));
        }
        Ok(rows)
    }

    /// The index of each axis' value in the k-th combination, the last axis fastest.
    fn combination(&self, mut k: usize) -> Vec<usize> {
        let mut indices: Vec<usize> = self
            .axes
            .iter()
            .rev()
            .map(|axis| {
                let index = k % axis.shown.len();
                k /= axis.shown.len();
                index
            })
            .collect();
        indices.reverse();
        indices
    }

    fn play_portion(
        &self,
        portion: &[Vec<usize>],
        progress: &mut Progress<'_>,
    ) -> Result<PlayedPortion, SimulationError> {
        // Outlines are for drawings.
        let plain = self.instrument.clone().without_outlines();
        let mut instruments: Vec<Instrument> = Vec::new();
        // The last combination's own values, and where its variant is.
        let mut last: Option<(Vec<usize>, Result<usize, String>)> = None;
        let mut variants = Vec::with_capacity(portion.len());
        let mut forces = Vec::with_capacity(portion.len());
        for (done, indices) in portion.iter().enumerate() {
            // Variants that are read from a text take a while.
            if done % BETWEEN_CALLS == 0 && !progress(0.0) {
                return Err(SimulationError::Interrupted);
            }
            let mut force_n = None;
            let mut own = Vec::new();
            for (axis, &index) in self.axes.iter().zip(indices) {
                if axis.target == Target::Force { force_n = Some(axis.force_n(index)) } else { own.push(index) }
            }
            // Strokes on the same variant share it.
            let place = match &last {
                Some((values, place)) if *values == own => place.clone(),
                _ => self.variant(&plain, indices).map(|instrument| {
                    instruments.push(instrument);
                    instruments.len() - 1
                }),
            };
            last = Some((own, place.clone()));
            variants.push(place);
            forces.push(force_n);
        }
        // Where each stroke's job is, or why there is none.
        let mut places = Vec::with_capacity(portion.len());
        let mut jobs = Vec::with_capacity(portion.len());
        for (variant, force_n) in variants.iter().zip(forces) {
            places.push(variant.clone().and_then(|instrument| {
                let stroke: super::Stroke<'_> = match force_n {
                    Some(force_n) => Box::new(move |_| Input::Force(force_n)),
                    None => self.stroke.inputs(&instruments[instrument].finger).map_err(|error| error.to_string())?,
                };
                jobs.push(Job { instrument, stroke });
                Ok(jobs.len() - 1)
            }));
        }
        let played: Vec<OwnResult> = match self.each {
            // Without forces every combination is a variant, in the order of the jobs.
            Some(make) => {
                let own: Vec<usize> = jobs.iter().map(|job| job.instrument).collect();
                let found = play_each(&instruments, make, self.setup, self.workers.threads, progress)?;
                own.into_iter().map(|index| found[index].clone()).collect()
            }
            None => {
                let played = play_all(&instruments, jobs, self.setup, self.workers, progress)?;
                played.into_iter().map(|result| result.map_err(|error| error.to_string())).collect()
            }
        };
        let mut results: Vec<Option<OwnResult>> = played.into_iter().map(Some).collect();
        let outcome = |place: Result<usize, String>| {
            let result = results[place?].take();
            result.ok_or_else(|| "no result".to_owned())?
        };
        let outcomes = places.into_iter().map(outcome).collect();
        Ok(PlayedPortion { outcomes, instruments, variants })
    }

    /// Measures every variant of a portion, in parallel.
    fn measure_portion(
        &self,
        played: &PlayedPortion,
        progress: &mut Progress<'_>,
    ) -> Result<Vec<MeasuredLines>, SimulationError> {
        if self.lines.is_empty() {
            return Ok(vec![Ok(Vec::new()); played.variants.len()]);
        }
        let measure = |instrument: &Instrument, progress: &mut Progress<'_>| {
            let rest = RestPose::of(instrument, self.rest, progress).map_err(MeasureError::from);
            rest.and_then(|rest| measure_some(&rest, self.lines, progress)).map_or_else(
                |error| {
                    if error.is_interruption() { Err(SimulationError::Interrupted) } else { Ok(Err(error.to_string())) }
                },
                |values| Ok(Ok(values)),
            )
        };
        let found = cores::map(&played.instruments, self.workers.threads, progress, measure)?;
        let of = |place: &Result<usize, String>| found[*place.as_ref().map_err(String::clone)?].clone();
        Ok(played.variants.iter().map(of).collect())
    }

    /// The instrument with one combination of values.
    fn variant(&self, plain: &Instrument, indices: &[usize]) -> Result<Instrument, String> {
        let mut instrument = match self.source.instrument(self.axes, indices) {
            None => plain.clone(),
            Some(read) => {
                let read = self.model.of(read?).map_err(|error| error.to_string())?;
                read.without_outlines()
            }
        };
        for (axis, &index) in self.axes.iter().zip(indices) {
            if let Target::Parameter(parameter) = &axis.target {
                let by = axis.by(parameter, &instrument, index).map_err(|error| error.to_string())?;
                let [least, most] = parameter.range();
                if !(least..=most).contains(&by) || parameter.vary(&mut instrument, by).is_err() {
                    return Err(axis.refusal(parameter, index, by));
                }
            }
        }
        Ok(instrument)
    }

    /// Columns of the rows: what was varied, what came of each stroke, what was measured, and how well it was computed.
    #[must_use]
    pub fn columns(&self, rows: &[StudyRow]) -> Vec<Column> {
        let played = |row: &'_ StudyRow, get: fn(&Played) -> Option<f64>| row.outcome.as_ref().ok().and_then(get);
        let flag = |is_it: bool| Some(f64::from(u8::from(is_it)));
        let varied = self.axes.iter().enumerate().map(|(i, axis)| {
            let values = rows.iter().map(|row| row.values.get(i).copied()).collect();
            (axis.column(), values)
        });
        let outcomes = OUTCOMES.iter().map(|(name, get)| {
            let values = rows.iter().map(|row| played(row, *get)).collect();
            ((*name).to_owned(), values)
        });
        let measured = self.lines.iter().enumerate().map(|(i, line)| {
            let values = rows.iter().map(|row| *row.measured.as_ref().ok()?.get(i)?).collect();
            (measured_title(self.axes, line), values)
        });
        let solution: [Column; OF_THE_SOLUTION] = [
            ("failed".to_owned(), rows.iter().map(|row| flag(row.outcome.is_err())).collect()),
            ("trusted".to_owned(), rows.iter().map(|row| flag(row.is_trusted())).collect()),
            (
                "energy_residual_relative".to_owned(),
                rows.iter().map(|row| played(row, |p| p.energy_residual)).collect(),
            ),
        ];
        varied.chain(outcomes).chain(measured).chain(solution).collect()
    }

    /// Those of the columns that have bands: what came of a stroke, not what was varied, nor how well it was computed.
    #[must_use]
    pub fn results<'c>(&self, columns: &'c [Column]) -> &'c [Column] {
        &columns[self.axes.len()..columns.len() - OF_THE_SOLUTION]
    }

    /// Values of the results, row by row.
    #[must_use]
    pub fn result_values(&self, columns: &[Column]) -> Vec<Option<f64>> {
        let results = self.results(columns);
        let rows = columns.first().map_or(0, |(_, values)| values.len());
        (0..rows).flat_map(|row| results.iter().map(move |(_, values)| values[row])).collect()
    }

    /// Plays the study on a sample of the instrument, given by the text of its file, on the caller's thread. Returns
    /// the values of the results, row by row, and a reason why rows of it failed.
    ///
    /// # Errors
    /// [`SampleError::Interrupted`].
    pub fn of_sample(
        &self,
        sample: &Instrument,
        text: &str,
        progress: &mut Progress<'_>,
    ) -> Result<SampleValues, SampleError> {
        let instrument = match self.model.of(sample.clone()) {
            Ok(instrument) => instrument,
            Err(error) => return Ok(Err(error.to_string()).into()),
        };
        let source = Source::of_text(text);
        let own = Grid { instrument: &instrument, source: &source, workers: Workers::one(), ..*self };
        match own.play(progress) {
            Ok(rows) => {
                let error = rows.iter().find_map(StudyRow::error);
                Ok(SampleValues { values: own.result_values(&own.columns(&rows)), error })
            }
            Err(SimulationError::Interrupted) => Err(SampleError::Interrupted),
            Err(error) => Ok(Err(error.to_string()).into()),
        }
    }
}

/// Number of variants between two calls of the progress.
const BETWEEN_CALLS: usize = 64;

/// A portion that has been played.
struct PlayedPortion {
    outcomes: Vec<OwnResult>,
    /// Its variants, and for each combination which of them is its own, or why there is none.
    instruments: Vec<Instrument>,
    variants: Vec<Result<usize, String>>,
}

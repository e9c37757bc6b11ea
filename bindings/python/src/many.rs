//! Many strokes at once: arrays in, arrays out.

use std::sync::Arc;

use erard::Progress;
use erard::instrument::Instrument as Inner;
use erard::parameter::{Change, Parameter};
use erard::player::Input;
use erard::run::{Setup, SimulationError};
use erard::stroke::{PositionOf, Prescribed, Stroke as InnerStroke};
use erard::trust::{Warning, worst_of_each};
use erard_workshop::cores;
use erard_workshop::study::{Job, JobResult, OUTCOMES, Sampling, Workers, sample_all};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::fault::{self, wrong_argument};
use crate::instrument::Instrument;
use crate::setup::Steps;
use crate::stroke::{Stroke, prescribed, sampled};
use crate::watch::watched;

/// Settings of the work, and columns to record.
#[derive(FromPyObject)]
pub(crate) struct Work {
    #[pyo3(item)]
    threads: Option<usize>,
    #[pyo3(item)]
    single: bool,
    #[pyo3(item)]
    ledger: bool,
    #[pyo3(item)]
    columns: Vec<String>,
    #[pyo3(item)]
    every: u64,
}

impl Work {
    fn workers(&self) -> PyResult<Workers> {
        let all = if self.single { Workers::all_single() } else { Workers::all() };
        match self.threads {
            Some(0) => Err(wrong_argument("threads", "found 0, expected a number of threads, from 1")),
            Some(threads) => Ok(Workers { threads, ..all }),
            None => Ok(Workers { threads: cores::count(), ..all }),
        }
    }

    fn sampling(&self, instrument: &Inner) -> PyResult<Option<Sampling>> {
        let names: Vec<&str> = self.columns.iter().map(String::as_str).collect();
        if names.is_empty() {
            return Ok(None);
        }
        Sampling::of(instrument, &names, self.every).map(Some).map_err(|error| wrong_argument("columns", error))
    }
}

/// Jobs to play: instruments, and for each job its instrument (or the reason why there is none) and its stroke.
struct Plan {
    instruments: Vec<Inner>,
    jobs: Vec<(Result<usize, String>, usize)>,
    strokes: Vec<Arc<InnerStroke>>,
}

/// Result of a job of a plan.
type Outcome = Result<JobResult, String>;

impl Plan {
    fn play(
        &self,
        setup: &Setup,
        sampling: Option<&Sampling>,
        workers: Workers,
        going: &mut Progress<'_>,
    ) -> Result<Vec<Outcome>, SimulationError> {
        let mut jobs = Vec::with_capacity(self.jobs.len());
        let mut places: Vec<Result<usize, String>> = Vec::with_capacity(self.jobs.len());
        for (instrument, stroke) in &self.jobs {
            let place = instrument.clone().and_then(|instrument| {
                let inputs = self.strokes[*stroke].inputs(&self.instruments[instrument].finger);
                let inputs: Box<dyn Fn(f64) -> Input + Send + '_> = inputs.map_err(|error| error.to_string())?;
                jobs.push(Job { instrument, stroke: inputs });
                Ok(jobs.len() - 1)
            });
            places.push(place);
        }
        let results = sample_all(&self.instruments, jobs, setup, sampling, workers, going)?;
        let mut results: Vec<Option<JobResult>> = results.into_iter().map(Some).collect();
        Ok(places
            .into_iter()
            .map(|place| place.and_then(|place| results[place].take().ok_or_else(|| "no result".to_owned())))
            .collect())
    }
}

/// Returns arrays of the results of every job: a study's columns, `impacts` (time and speed of each), `failed`,
/// `trusted`, `energy_residual_relative`, `errors` by the job's index, `doubts` as sentences, and the samples, one row
/// for each job.
fn arrays<'py>(
    py: Python<'py>,
    outcomes: Vec<Outcome>,
    columns: &[String],
    rows: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    let played = |outcome: &Outcome| outcome.as_ref().ok().and_then(|result| result.as_ref().ok()).is_some();
    fn got(outcome: &Outcome) -> Option<&erard_workshop::study::Played> {
        outcome.as_ref().ok()?.as_ref().ok()
    }
    for (name, get) in OUTCOMES {
        let values: Vec<f64> = outcomes.iter().map(|one| got(one).and_then(get).unwrap_or(f64::NAN)).collect();
        all.set_item(name, values.into_pyarray(py))?;
    }
    let residual: Vec<f64> =
        outcomes.iter().map(|one| got(one).and_then(|p| p.energy_residual).unwrap_or(f64::NAN)).collect();
    all.set_item("energy_residual_relative", residual.into_pyarray(py))?;
    let failed: Vec<bool> = outcomes.iter().map(|one| !played(one)).collect();
    all.set_item("failed", PyArray1::from_vec(py, failed))?;
    let trusted: Vec<bool> = outcomes.iter().map(|one| got(one).is_some_and(|p| p.warnings.is_empty())).collect();
    all.set_item("trusted", PyArray1::from_vec(py, trusted))?;
    let mut errors: Vec<(usize, String)> = Vec::new();
    for (at, one) in outcomes.iter().enumerate() {
        match one {
            Err(error) => errors.push((at, error.clone())),
            Ok(Err(error)) => errors.push((at, error.to_string())),
            Ok(Ok(_)) => {}
        }
    }
    let impacts: Vec<Vec<(f64, f64)>> = outcomes
        .iter()
        .map(|one| {
            got(one).map_or_else(Vec::new, |p| {
                p.events.impacts.iter().map(|s| (s.time_s, s.hammer_speed_m_per_s)).collect()
            })
        })
        .collect();
    all.set_item("impacts", impacts)?;
    let worst = worst_of_each(outcomes.iter().filter_map(got).flat_map(|played: &_| &played.warnings));
    let count = outcomes.len();
    let doubts: Vec<String> = worst
        .into_iter()
        .map(|(n, worst): (usize, &Warning)| format!("{n} of {count} strokes; the worst: {worst}"))
        .collect();
    all.set_item("errors", errors)?;
    all.set_item("doubts", doubts)?;
    for (i, name) in columns.iter().enumerate() {
        let mut values = Vec::with_capacity(count * rows);
        for one in &outcomes {
            let own = got(one).and_then(|played| played.samples.get(i)).map_or(&[][..], Vec::as_slice);
            let taken = own.len().min(rows);
            values.extend_from_slice(&own[..taken]);
            values.resize(values.len() + rows - taken, f64::NAN);
        }
        all.set_item(name, values.into_pyarray(py).reshape([count, rows])?)?;
    }
    Ok(all)
}

fn run<'py>(
    py: Python<'py>,
    plan: Plan,
    setup: Setup,
    work: &Work,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let workers = work.workers()?;
    let sampling = match plan.instruments.first() {
        Some(first) => work.sampling(first)?,
        None => None,
    };
    let setup = Setup { ledger: work.ledger, ..setup };
    let steps = setup.check().map_err(|error| fault::simulation(&error))?;
    let rows = (steps / work.every.max(1)) as usize + 1;
    let outcomes =
        watched(py, progress, move |going| plan.play(&setup, sampling.as_ref(), workers, going), fault::simulation)?;
    arrays(py, outcomes, &work.columns, rows)
}

/// Returns the instrument without outlines, which only drawings need.
fn plain(instrument: &Inner) -> Inner {
    Inner { parts: Vec::new(), ..instrument.clone() }
}

/// Number of strokes and variants that are prepared between two checks for signals.
const BETWEEN_SIGNALS: usize = 256;

/// Plays one stroke for each row of `values` (N x T samples, one every `dt` s), on one instrument or on one for each
/// row.
#[pyfunction]
#[pyo3(signature = (instruments, kind, values, dt, steps, work, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn rollout<'py>(
    py: Python<'py>,
    instruments: Vec<Bound<'py, Instrument>>,
    kind: &str,
    values: PyReadonlyArray2<'py, f64>,
    dt: f64,
    steps: Steps,
    work: Work,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let drive = prescribed(kind)?;
    let values = values.as_array();
    let (count, samples) = values.dim();
    let position_of = if drive == Prescribed::Motion { PositionOf::Fingertip } else { PositionOf::Key };
    let many = instruments.len() > 1;
    if many && instruments.len() != count {
        let found = format!("found {} for {count} rows", instruments.len());
        return Err(wrong_argument("instruments", format!("{found}; expected one, or one for each row")));
    }
    let mut strokes = Vec::with_capacity(count);
    for (row, own) in values.rows().into_iter().enumerate() {
        if row % BETWEEN_SIGNALS == 0 {
            py.check_signals()?;
        }
        let series = sampled(drive, &own.to_vec(), dt, &format!("{kind}[{row}]"))?;
        let (stroke, _) =
            InnerStroke::recorded(String::new(), series, position_of, Some(drive)).map_err(fault::wrong)?;
        strokes.push(Arc::new(stroke));
    }
    let jobs = (0..count).map(|row| (Ok(if many { row } else { 0 }), row)).collect();
    let instruments: Vec<Inner> = instruments.iter().map(|one| plain(&one.get().inner)).collect();
    let Some(reference) = instruments.first() else {
        return Err(wrong_argument("instruments", "found none, expected one or more"));
    };
    let setup = steps.setup(reference, 0.0, dt * (samples.max(2) - 1) as f64)?;
    run(py, Plan { instruments, jobs, strokes }, setup, &work, progress)
}

/// Plays strokes on instruments; each job names its instrument and its stroke.
#[pyfunction]
#[pyo3(signature = (instruments, strokes, jobs, duration, steps, work, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn play_all<'py>(
    py: Python<'py>,
    instruments: Vec<Bound<'py, Instrument>>,
    strokes: Vec<Bound<'py, Stroke>>,
    jobs: Vec<(usize, usize)>,
    duration: Option<f64>,
    steps: Steps,
    work: Work,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let Some(first) = strokes.first().map(|stroke| stroke.get().inner.clone()) else {
        return Err(wrong_argument("strokes", "found none, expected one or more"));
    };
    if let Some((i, s)) = jobs.iter().find(|(i, s)| *i >= instruments.len() || *s >= strokes.len()) {
        return Err(wrong_argument("jobs", format!("there is no instrument {i} or no stroke {s}")));
    }
    let longest = strokes.iter().map(|stroke| stroke.get().inner.duration_s).fold(0.0, f64::max);
    let Some(reference) = instruments.first() else {
        return Err(wrong_argument("instruments", "found none, expected one or more"));
    };
    let setup = steps.setup_of(&reference.get().inner, &first, duration.or(Some(longest)))?;
    if strokes.iter().any(|stroke| stroke.get().inner.hand() != first.hand()) {
        return Err(wrong_argument("strokes", "are played by different hands; expected one hand for all"));
    }
    let instruments = instruments.iter().map(|one| plain(&one.get().inner)).collect();
    let strokes = strokes.iter().map(|stroke| stroke.get().inner.clone()).collect();
    let jobs = jobs.into_iter().map(|(instrument, stroke)| (Ok(instrument), stroke)).collect();
    run(py, Plan { instruments, jobs, strokes }, setup, &work, progress)
}

/// Plays a stroke, or constant forces, on variants of an instrument, given row by row as values of parameters in SI
/// units.
#[pyfunction]
#[pyo3(signature = (instrument, names, values, stroke, forces, duration, steps, work, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn study<'py>(
    py: Python<'py>,
    instrument: &Instrument,
    names: Vec<String>,
    values: PyReadonlyArray2<'py, f64>,
    stroke: Option<Bound<'py, Stroke>>,
    forces: Option<PyReadonlyArray1<'py, f64>>,
    duration: Option<f64>,
    steps: Steps,
    work: Work,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let own = &instrument.inner;
    let find = |name: &String| {
        let found = Parameter::named(own, name).map_err(|error| wrong_argument(name, error))?;
        Ok(found.1)
    };
    let parameters: Vec<Parameter> = names.iter().map(find).collect::<PyResult<_>>()?;
    let values = values.as_array();
    let plain = plain(own);
    let mut plan = Plan { instruments: Vec::new(), jobs: Vec::new(), strokes: Vec::new() };
    if let Some(stroke) = &stroke {
        plan.strokes.push(stroke.get().inner.clone());
    }
    let forces: Option<Vec<f64>> = forces.map(|forces| forces.to_vec()).transpose().map_err(fault::wrong)?;
    // Neighbours that differ in the force alone share their instrument.
    let mut last: Option<(Vec<f64>, Result<usize, String>)> = None;
    for (row, own) in values.rows().into_iter().enumerate() {
        if row % BETWEEN_SIGNALS == 0 {
            py.check_signals()?;
        }
        let own = own.to_vec();
        let place = match &last {
            Some((values, place)) if *values == own => place.clone(),
            _ => variant(&plain, &names, &parameters, &own).map(|instrument| {
                plan.instruments.push(instrument);
                plan.instruments.len() - 1
            }),
        };
        last = Some((own, place.clone()));
        let stroke = match &forces {
            Some(forces) => {
                plan.strokes.push(Arc::new(InnerStroke::constant(String::new(), forces[row])));
                plan.strokes.len() - 1
            }
            None => 0,
        };
        plan.jobs.push((place, stroke));
    }
    let Some(first) = plan.strokes.first() else {
        return Err(wrong_argument("force", "expected a force or a stroke"));
    };
    let setup = steps.setup_of(&plain, first, duration)?;
    run(py, plan, setup, &work, progress)
}

fn variant(plain: &Inner, names: &[String], parameters: &[Parameter], values: &[f64]) -> Result<Inner, String> {
    let mut instrument = plain.clone();
    for ((name, parameter), value) in names.iter().zip(parameters).zip(values) {
        let [least, most] = parameter.range();
        let by = parameter.by(&instrument, Change::Set(*value));
        if !(least..=most).contains(&by) || !parameter.vary(&mut instrument, by) {
            return Err(format!("{name} cannot be varied to {value} {}", parameter.quantity(plain).si_unit()));
        }
    }
    Ok(instrument)
}

//! Many strokes at once: arrays in, arrays out.

use std::sync::Arc;

use erard::Progress;
use erard::instrument::Instrument as Inner;
use erard::player::RestKind;
use erard::run::{Setup, SimulationError};
use erard::stroke::{PositionOf, Prescribed, Stroke as InnerStroke};
use erard_workshop::compare::Which;
use erard_workshop::cores;
use erard_workshop::study::{
    Axis, Grid, Job, MAX_STROKES, OUTCOMES, OwnResult, Played, Sampling, StudyRow, Workers, doubts, sample_all,
};
use numpy::{IntoPyArray, PyArray1, PyArrayMethods, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::bench::lines_named;
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
    #[pyo3(item)]
    tolerance: Option<f64>,
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

/// Returns arrays of the results of every job: a study's columns, `impacts` (time and speed of each), `failed`,
/// `trusted`, `energy_residual_relative`, `error` (empty if it did not fail), `doubts` as sentences, and the samples,
/// one row for each job.
fn arrays<'py>(
    py: Python<'py>,
    outcomes: &[OwnResult],
    columns: &[String],
    rows: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    fn got(outcome: &OwnResult) -> Option<&Played> {
        outcome.as_ref().ok()
    }
    for (name, get) in OUTCOMES {
        let values: Vec<f64> = outcomes.iter().map(|one| got(one).and_then(get).unwrap_or(f64::NAN)).collect();
        all.set_item(name, values.into_pyarray(py))?;
    }
    let residual: Vec<f64> =
        outcomes.iter().map(|one| got(one).and_then(|p| p.energy_residual).unwrap_or(f64::NAN)).collect();
    all.set_item("energy_residual_relative", residual.into_pyarray(py))?;
    let failed: Vec<bool> = outcomes.iter().map(Result::is_err).collect();
    all.set_item("failed", PyArray1::from_vec(py, failed))?;
    let trusted: Vec<bool> = outcomes.iter().map(|one| got(one).is_some_and(|p| p.warnings.is_empty())).collect();
    all.set_item("trusted", PyArray1::from_vec(py, trusted))?;
    all.set_item(
        "error",
        outcomes.iter().map(|one| one.as_ref().err().cloned().unwrap_or_default()).collect::<Vec<_>>(),
    )?;
    all.set_item("doubts", doubts(outcomes.iter()))?;
    let impacts: Vec<Vec<(f64, f64)>> = outcomes
        .iter()
        .map(|one| {
            got(one).map_or_else(Vec::new, |p| {
                p.events.impacts.iter().map(|s| (s.time_s, s.hammer_speed_m_per_s)).collect()
            })
        })
        .collect();
    all.set_item("impacts", impacts)?;
    let count = outcomes.len();
    for (i, name) in columns.iter().enumerate() {
        let mut values = Vec::with_capacity(count * rows);
        for one in outcomes {
            let own = got(one).and_then(|played| played.samples.get(i)).map_or(&[][..], Vec::as_slice);
            let taken = own.len().min(rows);
            values.extend_from_slice(&own[..taken]);
            values.resize(values.len() + rows - taken, f64::NAN);
        }
        all.set_item(name, values.into_pyarray(py).reshape([count, rows])?)?;
    }
    Ok(all)
}

/// Plays each stroke on its instrument: the only one, or that of its row.
fn play_strokes(
    instruments: &[Inner],
    strokes: &[InnerStroke],
    setup: &Setup,
    sampling: Option<&Sampling>,
    workers: Workers,
    going: &mut Progress<'_>,
) -> Result<Vec<OwnResult>, SimulationError> {
    let mut jobs = Vec::with_capacity(strokes.len());
    let mut faults = Vec::with_capacity(strokes.len());
    for (row, stroke) in strokes.iter().enumerate() {
        let instrument = if instruments.len() > 1 { row } else { 0 };
        match stroke.inputs(&instruments[instrument].finger) {
            Ok(stroke) => {
                jobs.push(Job { instrument, stroke });
                faults.push(None);
            }
            Err(error) => faults.push(Some(error.to_string())),
        }
    }
    let mut results = sample_all(instruments, jobs, setup, sampling, workers, going)?.into_iter();
    let outcome = |fault: Option<String>| match fault {
        Some(fault) => Err(fault),
        None => {
            results.next().map_or_else(|| Err("no result".to_owned()), |one| one.map_err(|error| error.to_string()))
        }
    };
    Ok(faults.into_iter().map(outcome).collect())
}

/// Number of strokes that are prepared between two checks for signals.
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
        strokes.push(stroke);
    }
    let instruments: Vec<Inner> = instruments.iter().map(|one| (*one.get().inner).clone().without_outlines()).collect();
    let Some(reference) = instruments.first() else {
        return Err(wrong_argument("instruments", "found none, expected one or more"));
    };
    let setup = steps.setup(reference, 0.0, dt * (samples.max(2) - 1) as f64)?;
    let workers = work.workers()?;
    let sampling = work.sampling(reference)?;
    let setup = Setup { ledger: work.ledger, ..setup };
    let taken = setup.check().map_err(|error| fault::simulation(&error))?;
    let outcomes = watched(
        py,
        progress,
        |going| play_strokes(&instruments, &strokes, &setup, sampling.as_ref(), workers, going),
        fault::simulation,
    )?;
    arrays(py, &outcomes, &work.columns, (taken / work.every.max(1)) as usize + 1)
}

/// Plays a stroke, or constant forces, on all combinations of values of an instrument's parameters and numbers, or on
/// some of them (`rows`, from one to before another), and measures lines of the sheet on every variant. The last name
/// varies fastest, forces fastest of all. Values are in SI units, of a number of the file in its own.
///
/// Returns the results of every stroke, and `varied`, a column for each name and for the forces, and `measured`, one
/// for each line. `error` also says why nothing was measured.
#[pyfunction]
#[pyo3(signature = (instrument, axes, stroke, forces, rows, measure, duration, steps, work, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn study<'py>(
    py: Python<'py>,
    instrument: &Instrument,
    axes: Vec<(String, Vec<f64>)>,
    stroke: Option<Bound<'py, Stroke>>,
    forces: Option<Vec<f64>>,
    rows: Option<(usize, usize)>,
    measure: Vec<String>,
    duration: Option<f64>,
    steps: Steps,
    work: Work,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    let (own, source) = (&*instrument.inner, instrument.source()?);
    let axis = |(name, values): (String, Vec<f64>)| {
        Axis::of_values(&name, values, own, &source).map_err(|error| fault::change(&error))
    };
    let mut axes: Vec<Axis> = axes.into_iter().map(axis).collect::<PyResult<_>>()?;
    let lines = lines_named("measure", &measure)?;
    let constant = forces.as_ref().and_then(|forces| forces.first());
    let stroke = match (constant, stroke) {
        (Some(force_n), _) => Arc::new(InnerStroke::constant(String::new(), *force_n)),
        (None, Some(stroke)) => stroke.get().inner.clone(),
        (None, None) => return Err(wrong_argument("force", "expected a force or a stroke")),
    };
    axes.extend(forces.map(Axis::of_forces));
    let setup = Setup { ledger: work.ledger, tolerance: work.tolerance, ..steps.setup_of(own, &stroke, duration)? };
    setup.check().map_err(|error| fault::simulation(&error))?;
    let grid = Grid {
        instrument: own,
        source: &source,
        model: Which::Action,
        axes: &axes,
        lines: &lines,
        rest: RestKind::AsPlayed,
        stroke: &stroke,
        each: None,
        setup: &setup,
        workers: work.workers()?,
    };
    let Some(count) = Axis::combinations(&axes) else {
        return Err(wrong_argument("vary", "more combinations than can be counted; expected fewer values"));
    };
    let (from, to) = rows.unwrap_or((0, count));
    if to.min(count).saturating_sub(from) > MAX_STROKES {
        return Err(wrong_argument("vary", format!("found {count} strokes, expected at most {MAX_STROKES}")));
    }
    let rows = watched(py, progress, |going| grid.play_rows(from..to.min(count), going), fault::simulation)?;
    let columns = |count: usize, of: &dyn Fn(&StudyRow, usize) -> Option<f64>| {
        let column = |k| rows.iter().map(|row| of(row, k).unwrap_or(f64::NAN)).collect::<Vec<f64>>().into_pyarray(py);
        (0..count).map(column).collect::<Vec<_>>()
    };
    let varied = columns(axes.len(), &|row, k| row.values.get(k).copied());
    let measured = columns(lines.len(), &|row, k| *row.measured.as_ref().ok()?.get(k)?);
    let errors: Vec<String> = rows.iter().map(|row| row.error().unwrap_or_default()).collect();
    let outcomes: Vec<OwnResult> = rows.into_iter().map(|row| row.outcome).collect();
    let all = arrays(py, &outcomes, &[], 0)?;
    all.set_item("error", errors)?;
    all.set_item("varied", varied)?;
    all.set_item("measured", measured)?;
    Ok(all)
}

//! Comparison of the model with measurements: recordings, and published numbers.

use erard::run::Setup;
use erard::stroke::Prescribed;
use erard_workshop::compare::{Choice, CompareError, Which, compare_chosen, outcome};
use erard_workshop::validate::{Published, Verdict, validate as hold};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::fault::{self, failed, wrong, wrong_argument};
use crate::instrument::{Instrument, certainty};
use crate::press::array;
use crate::recording::Recording;
use crate::setup::Steps;
use crate::watch::watched;

/// Compares a recording with the models. Returns columns, a row of errors for each drive and model, and verdicts in
/// words.
#[pyfunction]
#[pyo3(signature = (instrument, recording, drives, models, duration, steps, progress))]
#[allow(clippy::too_many_arguments, clippy::type_complexity)]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    instrument: &Instrument,
    recording: &Recording,
    drives: Option<Vec<String>>,
    models: Option<Vec<String>>,
    duration: Option<f64>,
    steps: Steps,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyDict>, Vec<Bound<'py, PyDict>>, Vec<String>)> {
    let mut choice = Choice { position_of: recording.position_of, ..Choice::default() };
    if let Some(drives) = drives {
        choice.drives = drives.iter().map(|name| driven(name)).collect::<PyResult<_>>()?;
    }
    if let Some(models) = models {
        choice.models = models.iter().map(|name| which(name)).collect::<PyResult<_>>()?;
    }
    let choice = choice.limited_by(&recording.prepared.report);
    let (_, series, _) = recording.series()?;
    let series = match duration {
        Some(duration) => series.first(duration).map_err(|error| wrong_argument("duration", error))?,
        None => series,
    };
    // Only the settings count: how long it lasts, the recording says.
    let setup: Setup = steps.setup(&instrument.inner, 0.0, 1.0)?;
    let own = instrument.inner.clone();
    let comparison = watched(
        py,
        progress,
        move |going| compare_chosen(&own, &series, &choice, &setup, going),
        |error| match error {
            CompareError::Simulation(error) => fault::simulation(error),
            error => wrong(error),
        },
    )?;
    let verdicts =
        comparison.verdicts().into_iter().chain(comparison.rests()).chain(comparison.notes.iter().cloned()).collect();
    let columns = PyDict::new(py);
    let mut rows = Vec::new();
    for trial in &comparison.trials {
        let stem = format!("{}_{}", trial.driven.name(), trial.which.name().replace('-', "_"));
        let quantity = outcome(trial.driven);
        for (quantity, errors, up_to) in
            [(quantity, &trial.errors, trial.told_to_hz), ("hammer", &trial.hammer_errors, trial.hammer_told_to_hz)]
        {
            let Some(errors) = errors else { continue };
            let row = PyDict::new(py);
            row.set_item("drive", trial.driven.name())?;
            row.set_item("model", trial.which.name())?;
            row.set_item("quantity", quantity)?;
            row.set_item("rms", errors.rms)?;
            row.set_item("rms_of_range", errors.rms_of_range)?;
            row.set_item("largest", errors.largest)?;
            row.set_item("explained", errors.explained)?;
            row.set_item("correlation", errors.correlation)?;
            row.set_item("delay_s", errors.delay_s)?;
            row.set_item("told_to_Hz", up_to.is_finite().then_some(up_to))?;
            rows.push(row);
        }
        columns.set_item(format!("{stem}_force_N"), array(py, trial.force_n.clone()))?;
        columns.set_item(format!("{stem}_key_m"), array(py, trial.key_m.clone()))?;
        if !trial.hammer_rise_m.is_empty() {
            columns.set_item(format!("{stem}_hammer_rise_m"), array(py, trial.hammer_rise_m.clone()))?;
        }
    }
    let all = PyDict::new(py);
    all.set_item("time_s", array(py, comparison.time_s))?;
    let measured = [
        ("measured_force_N", comparison.measured_force_n),
        ("measured_position_m", comparison.measured_position_m),
        ("measured_hammer_rise_m", comparison.measured_hammer_rise_m),
    ];
    for (name, values) in measured {
        if let Some(values) = values {
            all.set_item(name, array(py, values))?;
        }
    }
    all.update(columns.as_mapping())?;
    Ok((all, rows, verdicts))
}

fn driven(name: &str) -> PyResult<Prescribed> {
    let known = [Prescribed::Force, Prescribed::Motion, Prescribed::Rigid];
    let one = known.into_iter().find(|one| one.name() == name);
    one.ok_or_else(|| wrong_argument("drives", format!("found `{name}`, expected force, motion or rigid")))
}

fn which(name: &str) -> PyResult<Which> {
    let one = [Which::Action, Which::OneDof].into_iter().find(|one| one.name() == name);
    one.ok_or_else(|| wrong_argument("models", format!("found `{name}`, expected action or one-dof")))
}

/// Compares an instrument with measurements on real pianos. Returns one row for each published number.
#[pyfunction]
#[pyo3(signature = (instrument, progress))]
pub(crate) fn validate<'py>(
    py: Python<'py>,
    instrument: &Instrument,
    progress: Option<Py<PyAny>>,
) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let published = Published::builtin();
    let own = instrument.inner.clone();
    let validation = {
        let published = &published;
        watched(py, progress, move |going| hold(&own, None, published, going), |error| failed(error))?
    };
    let rows = published.rows.iter().zip(&validation.verdicts);
    rows.map(|(row, verdict)| {
        let (told, simulated, by) = match verdict {
            Verdict::Met { simulated } => ("met", Some(*simulated), None),
            Verdict::Missed { simulated, by } => ("missed", Some(*simulated), Some(*by)),
            Verdict::Absent => ("did not happen", None, None),
            Verdict::Open { simulated } => ("nothing published", Some(*simulated), None),
            Verdict::Silent | Verdict::Skipped(_) => ("not modelled", None, None),
        };
        let reason = if let Verdict::Skipped(skipped) = verdict { Some(skipped.reason()) } else { None };
        let one = PyDict::new(py);
        one.set_item("name", &row.name)?;
        one.set_item("quantity", &row.quantity)?;
        one.set_item("group", &row.group)?;
        one.set_item("kind", row.kind.name())?;
        one.set_item("unit", &row.unit)?;
        one.set_item("published", row.range())?;
        one.set_item("at_least", row.at_least)?;
        one.set_item("at_most", row.at_most)?;
        one.set_item("simulated", simulated)?;
        one.set_item("verdict", told)?;
        one.set_item("missed_by", by)?;
        one.set_item("source", &row.source)?;
        one.set_item("certainty", certainty(row.certainty))?;
        one.set_item("likely_reason", if told == "met" { None } else { reason.or(row.if_missed.as_deref()) })?;
        Ok(one)
    })
    .collect()
}

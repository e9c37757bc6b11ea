//! One press and its derivatives.

use erard::gradient::GradientError;
use erard::run::Setup;
use erard_workshop::cores;
use erard_workshop::sensitivities::{Differentiation, Rest, SensitivityError, Variable, gradient as find};
use numpy::PyArray2;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::fault::{self, wrong_argument};
use crate::instrument::Instrument;
use crate::press::array;
use crate::setup::Steps;
use crate::stroke::Stroke;
use crate::watch::watched;

/// Two instruments, one on each side of a number that has a path but no name, and the difference of the number.
type Sides<'py> = (Bound<'py, Instrument>, Bound<'py, Instrument>, f64);

/// Whether the rest is held, whether two step lengths are compared, whether a derivative that does not converge is an
/// error, and the quantities for which this matters (all if empty).
type How = (bool, bool, bool, Vec<String>);

/// Plays a press with its derivatives, per bare number, with respect to parameters, `force`, and pairs of instruments.
/// Returns `values` and `slopes` of every quantity (and `in_shorter_steps` and `unresolved` if compared), `columns` and
/// `column_slopes` (one row for each variable) sampled every `every` steps if given, `switches`, and `refused`
/// (quantity, variable, reason).
#[pyfunction]
#[pyo3(signature = (instrument, by, stroke, duration, steps, every, how, threads, progress))]
#[allow(clippy::too_many_arguments)]
pub(crate) fn gradient<'py>(
    py: Python<'py>,
    instrument: &Instrument,
    by: Vec<(String, Option<Sides<'py>>)>,
    stroke: &Stroke,
    duration: Option<f64>,
    steps: Steps,
    every: Option<u64>,
    how: How,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyDict>> {
    steps.for_derivatives()?;
    let inner = stroke.inner.clone();
    let setup = steps.setup_of(&instrument.inner, &inner, duration)?;
    let setup = Setup { ledger: false, ..setup };
    let own = instrument.inner.clone();
    let variable = |(name, sides): (String, Option<Sides<'py>>)| {
        let made = match sides {
            Some((low, high, apart)) => Variable::between(&name, &low.get().inner, &high.get().inner, apart),
            None => Variable::named(&own, "", &name),
        };
        made.map_err(|error| wrong_argument("parameters", error))
    };
    let by: Vec<Variable> = by.into_iter().map(variable).collect::<PyResult<_>>()?;
    let count = by.len();
    // A stroke that cannot drive this instrument says so before it is played.
    inner.inputs(&own.finger).map(drop).map_err(fault::wrong)?;
    let threads = match threads {
        Some(0) => return Err(wrong_argument("threads", "found 0, expected a number of threads, from 1")),
        Some(threads) => threads,
        None => cores::count(),
    };
    let (held, compares, refuses, of) = how;
    let rest = if held { Rest::Held } else { Rest::Moves };
    let how = Differentiation { rest, sample_every: every, compares, refuses, of, threads };
    let found = watched(
        py,
        progress,
        |going| {
            let drive = || inner.inputs(&own.finger).unwrap_or_else(|_| Box::new(|_| erard::Input::Free));
            find(&own, by, &drive, &setup, how, going)
        },
        told,
    )?;
    let all = PyDict::new(py);
    let (values, slopes, shorter, unresolved) = (PyDict::new(py), PyDict::new(py), PyDict::new(py), PyDict::new(py));
    for (key, one) in found.of {
        values.set_item(key, one.as_ref().map(|one| one.value))?;
        let unknown = || vec![f64::NAN; count];
        let each = one.map_or_else(
            || [unknown(), unknown(), unknown()],
            |one| [one.slopes, one.in_shorter_steps, one.unresolved],
        );
        for (place, numbers) in [&slopes, &shorter, &unresolved].into_iter().zip(each) {
            place.set_item(key, array(py, numbers))?;
        }
    }
    let refused = found.refused.iter().map(|one| (one.of, one.by.clone(), one.told.clone())).collect::<Vec<_>>();
    let (columns, column_slopes) = (PyDict::new(py), PyDict::new(py));
    for one in found.sampled {
        let slopes = PyArray2::from_vec2(py, &one.slopes).map_err(fault::failed)?;
        column_slopes.set_item(one.name, slopes)?;
        columns.set_item(one.name, array(py, one.values))?;
    }
    all.set_item("values", values)?;
    all.set_item("slopes", slopes)?;
    all.set_item("in_shorter_steps", shorter)?;
    all.set_item("unresolved", unresolved)?;
    all.set_item("refused", refused)?;
    all.set_item("columns", columns)?;
    all.set_item("column_slopes", column_slopes)?;
    all.set_item("switches", found.switches.to_vec())?;
    Ok(all)
}

pub(crate) fn told(error: &SensitivityError) -> PyErr {
    match error {
        SensitivityError::Simulation(error) | SensitivityError::Gradient(GradientError::Simulation(error)) => {
            fault::simulation(error)
        }
        SensitivityError::Gradient(error) => fault::wrong(error),
        SensitivityError::Measure(error) => fault::measure(error),
        _ => fault::failed(error),
    }
}

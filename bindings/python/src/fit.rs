//! Fits: the problem (residuals and their Jacobian), what solves it, and what was found.

use std::sync::{Arc, Mutex, PoisonError, mpsc};
use std::time::{Duration, Instant};

use erard::parameter::{Bare, Change, Parameter};
use erard::run::SimulationError;
use erard_workshop::cores;
use erard_workshop::fit::{
    DIFFERENCES, Data, FitError, FitResult, Jacobian, LeastSquares, Loss, MAX_EVALUATIONS, MAX_RESTARTS, NoiseModel,
    Plan, Problem as Question, Simulator, Solution, Solver, TrustRegion, by_differences, by_gradient, fit_by,
    fit_parameters,
};
use numpy::{PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, ToPyArray};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::fault::{self, failed, wrong, wrong_argument};
use crate::instrument::{Instrument, Value};
use crate::recording::Recording;
use crate::setup::Steps;
use crate::stroke::prescribed;

/// Time between checks for Python's signals, short enough that Control-C stops the work within 0.2 s.
const EVERY: Duration = Duration::from_millis(50);

/// Residuals of recordings over the parameters of an instrument. Points hold the solver's values: logarithms of
/// factors, turns of screws over half their bounds, then delays in ms.
#[pyclass(frozen, module = "erard._erard")]
pub(crate) struct Problem {
    question: Question,
    threads: usize,
    /// Noise as given, or as the last fit estimated it.
    noise: Mutex<NoiseModel>,
    /// Instrument at which the fit starts.
    instrument: Arc<erard::Instrument>,
}

/// Turn or factor for a value or a text, as in `Instrument.vary`.
fn outer(instrument: &erard::Instrument, argument: &str, name: &str, value: Value) -> PyResult<f64> {
    let (_, parameter) = Parameter::named(instrument, name).map_err(|error| wrong_argument(argument, error))?;
    let change = match value {
        Value::Number(value) => Change::Set(value),
        Value::Text(text) => Change::read(&text, parameter.quantity(instrument).map_err(wrong)?, Bare::Si)
            .map_err(|error| wrong_argument(argument, format!("{name}: {error}")))?,
    };
    parameter.by(instrument, change).map_err(wrong)
}

/// Arguments of the fit, besides the problem: start, loss, Jacobian, restarts, largest number of evaluations.
type FitArguments = (Vec<(String, Value)>, String, String, usize, usize);

/// Title, index of the recording, column, times, measured values, fitted values, noise, delay.
type Curve<'py> = (
    String,
    usize,
    &'static str,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    f64,
    f64,
);

#[pymethods]
impl Problem {
    #[new]
    #[allow(clippy::too_many_arguments)]
    fn new(
        instrument: &Instrument,
        vary: Vec<String>,
        bounds: Vec<(String, (Value, Value))>,
        recordings: Vec<Bound<'_, Recording>>,
        drive: Option<&str>,
        columns: Option<Vec<String>>,
        delay: bool,
        sigma: Vec<(String, f64)>,
        steps: Steps,
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let drive = drive.map(prescribed).transpose()?;
        let how = steps.setup(&instrument.inner, 0.0, 1.0)?;
        how.check().map_err(|error| fault::simulation(&error))?;
        let ends = |(name, (low, high)): (String, (Value, Value))| {
            let ends =
                [outer(&instrument.inner, "bounds", &name, low)?, outer(&instrument.inner, "bounds", &name, high)?];
            Ok((name, ends))
        };
        let bounds = bounds.into_iter().map(ends).collect::<PyResult<_>>()?;
        let parameters = fit_parameters(&instrument.file(), &vary, &bounds).map_err(told)?;
        let data = recordings.iter().map(|recording| {
            let own = recording.get();
            let (recorded, preparation) = (&own.inner, &own.preparation);
            Data::new(own.name(), recorded, own.position_of, preparation, drive, columns.as_deref(), &how).map_err(told)
        });
        let data = data.collect::<PyResult<Vec<_>>>()?;
        let threads = match threads {
            Some(0) => return Err(wrong_argument("threads", "found 0, expected a number of threads, from 1")),
            Some(threads) => threads,
            None => cores::count(),
        };
        let question = Question::new(&instrument.inner, parameters, data, delay).map_err(told)?;
        let noise = Mutex::new(NoiseModel::new(&question, &sigma).map_err(told)?);
        Ok(Problem { question, threads, noise, instrument: instrument.inner.clone() })
    }

    /// Fits with the solver of this library or with one in Python. A Python solver is called with two functions
    /// (residuals, Jacobian), the start, the lower and upper bounds, the loss and the largest number of evaluations. It
    /// returns a point, its residuals and the reason why it ended.
    fn fit<'py>(
        &self,
        py: Python<'py>,
        arguments: FitArguments,
        solver: Option<Py<PyAny>>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyDict>> {
        let (start, loss, jacobian, restarts, max_evaluations) = arguments;
        for (key, found, most) in
            [("restarts", restarts, MAX_RESTARTS), ("max_evaluations", max_evaluations, MAX_EVALUATIONS)]
        {
            if found > usize::from(most) {
                return Err(wrong_argument(key, format!("found {found}, expected at most {most}")));
            }
        }
        let of = |(name, value): (String, Value)| {
            let value = outer(&self.instrument, "start", &name, value)?;
            Ok((name, value))
        };
        let start = start.into_iter().map(of).collect::<PyResult<_>>()?;
        let plan = Plan { start, loss: loss_of(&loss)?, jacobian: jacobian_of(&jacobian)?, restarts, max_evaluations };
        let noise = self.noise();
        let found = self.watched(py, progress, |simulator, raised| match solver {
            None => fit_by(simulator, &noise, &plan, &mut TrustRegion),
            Some(call) => fit_by(simulator, &noise, &plan, &mut Foreign { call, raised }),
        })?;
        self.set_noise(found.noise.clone());
        result(py, &found)
    }

    /// Returns every measured quantity with the model's values at a point.
    fn curves<'py>(&self, py: Python<'py>, point: Vec<f64>) -> PyResult<Vec<Curve<'py>>> {
        let point = self.point(point)?;
        let noise = self.noise();
        let curves = self.watched(py, None, |simulator, _| simulator.curves(&noise, &point))?;
        let array = |values: &[f64]| values.to_pyarray(py);
        let of = |one: &erard_workshop::fit::Channel| {
            let [times, measured, fitted] = [&one.time_s, &one.measured, &one.fitted].map(|values| array(values));
            (one.title.clone(), one.recording, one.column, times, measured, fitted, one.sigma, one.delay_s)
        };
        Ok(curves.iter().map(of).collect())
    }

    /// Returns the residuals, (fitted - measured) / noise, whitened as the noise is correlated, one row for each point;
    /// nan for points that cannot be played.
    #[pyo3(signature = (points, progress = None))]
    fn residuals<'py>(
        &self,
        py: Python<'py>,
        points: PyReadonlyArray2<'py, f64>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = self.points(&points)?;
        let noise = self.noise();
        let mut residuals = self.watched(py, progress, |simulator, _| simulator.residuals(&noise, &points))?;
        for row in &mut residuals {
            if row.iter().any(|x| !x.is_finite()) {
                row.fill(f64::NAN);
            }
        }
        PyArray2::from_vec2(py, &residuals).map_err(failed)
    }

    /// Returns the derivatives of the residuals at a point, one row for each residual: differences, or the model's own
    /// derivatives if `exact`.
    fn jacobian<'py>(&self, py: Python<'py>, point: Vec<f64>, exact: bool) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let point = self.point(point)?;
        let noise = self.noise();
        let columns = self.watched(py, None, |simulator, _| match exact {
            true => by_gradient(simulator, &noise, None, &point),
            false => by_differences(simulator, &noise, None, &point, DIFFERENCES[1]),
        })?;
        rows_of(py, &columns)
    }

    /// Returns the lower and upper bounds of the solver's points.
    fn bounds(&self) -> (Vec<f64>, Vec<f64>) {
        self.question.bounds()
    }

    /// Converts the solver's points, row by row, to turns and factors, without delays.
    fn outer<'py>(&self, py: Python<'py>, points: PyReadonlyArray2<'py, f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let points = self.points(&points)?;
        let values: Vec<Vec<f64>> = points.iter().map(|point| self.question.from_solver(point)).collect();
        PyArray2::from_vec2(py, &values).map_err(failed)
    }

    /// Returns the noise of every channel, N, m or m/s, and its correlation time, s.
    fn sigma(&self) -> Vec<(f64, f64)> {
        let noise = self.noise();
        noise.sigma.into_iter().zip(noise.correlation_time_s).collect()
    }

    /// Sets the noise of every channel and its correlation time, as another fit estimated them.
    fn set_sigma(&self, sigma: Vec<(f64, f64)>) -> PyResult<()> {
        let noise = self.noise();
        let is_valid = |(sigma, time_s): &(f64, f64)| *sigma > 0.0 && *time_s >= 0.0;
        if sigma.len() != noise.sigma.len() || !sigma.iter().all(is_valid) {
            return Err(wrong_argument("sigma", "expected a positive number for every channel"));
        }
        let (sigma, correlation_time_s) = sigma.into_iter().unzip();
        self.set_noise(NoiseModel { sigma, correlation_time_s, ..noise });
        Ok(())
    }
}

impl Problem {
    fn noise(&self) -> NoiseModel {
        // A noise model is replaced as a whole, so a panic elsewhere leaves a valid one.
        self.noise.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn set_noise(&self, noise: NoiseModel) {
        *self.noise.lock().unwrap_or_else(PoisonError::into_inner) = noise;
    }

    fn point(&self, point: Vec<f64>) -> PyResult<Vec<f64>> {
        let count = self.question.bounds().0.len();
        if point.len() != count {
            return Err(wrong_argument("point", format!("found {} numbers, expected {count}", point.len())));
        }
        Ok(point)
    }

    fn points(&self, points: &PyReadonlyArray2<'_, f64>) -> PyResult<Vec<Vec<f64>>> {
        points.as_array().rows().into_iter().map(|row| self.point(row.to_vec())).collect()
    }

    /// Simulates the problem without Python's lock. Every 50 ms it checks for signals and calls `progress` with the
    /// number of newly played strokes; an exception raised there stops the work.
    fn watched<T: Send>(
        &self,
        py: Python<'_>,
        progress: Option<Py<PyAny>>,
        work: impl FnOnce(&mut Simulator<'_>, Raised) -> Result<T, FitError> + Send,
    ) -> PyResult<T> {
        let raised = Raised::default();
        let own = raised.clone();
        let done = py.detach(|| {
            let mut before = 0;
            let (mut last, seen) = (Instant::now(), raised.clone());
            let watch = move |strokes: u64| {
                if seen.is_set() {
                    return false;
                }
                if last.elapsed() < EVERY {
                    return true;
                }
                last = Instant::now();
                let more = strokes.saturating_sub(before);
                before = before.max(strokes);
                let asked = Python::attach(|py| {
                    py.check_signals()?;
                    match &progress {
                        Some(progress) if more > 0 => progress.call1(py, (more,)).map(|_| ()),
                        _ => Ok(()),
                    }
                });
                asked.map_err(|error| seen.set(error)).is_ok()
            };
            work(&mut Simulator::new(&self.question, self.threads, Box::new(watch)), own)
        });
        match raised.take() {
            Some(error) => Err(error),
            None => done.map_err(told),
        }
    }
}

/// Exception that Python raised while a fit ran.
#[derive(Clone, Default)]
struct Raised(Arc<Mutex<Option<PyErr>>>);

impl Raised {
    fn is_set(&self) -> bool {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).is_some()
    }

    fn set(&self, error: PyErr) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error);
    }

    fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }
}

/// Solver in Python. It runs in its own thread and asks for residuals and Jacobians.
struct Foreign {
    call: Py<PyAny>,
    raised: Raised,
}

/// Request of the solver's thread.
enum Request {
    Residuals(Vec<f64>, mpsc::Sender<Vec<f64>>),
    Jacobian(Vec<f64>, mpsc::Sender<Vec<Vec<f64>>>),
    /// The solver has ended: its point, residuals, and reason.
    Ended(PyResult<(Vec<f64>, Vec<f64>, String)>),
}

/// Functions that the solver in Python calls.
#[pyclass(frozen)]
struct Requests(Mutex<mpsc::Sender<Request>>);

impl Requests {
    fn ask<T: Send>(&self, py: Python<'_>, request: impl FnOnce(mpsc::Sender<T>) -> Request + Send) -> PyResult<T> {
        let ended = || PyRuntimeError::new_err("the fit has ended");
        py.detach(|| {
            let (answer, answered) = mpsc::channel();
            self.0.lock().ok()?.send(request(answer)).ok()?;
            answered.recv().ok()
        })
        .ok_or_else(ended)
    }
}

#[pymethods]
impl Requests {
    fn residuals<'py>(
        &self,
        py: Python<'py>,
        point: PyReadonlyArray1<'py, f64>,
    ) -> PyResult<Bound<'py, PyArray1<f64>>> {
        let point = point.to_vec().map_err(wrong)?;
        Ok(self.ask(py, |answer| Request::Residuals(point, answer))?.to_pyarray(py))
    }

    fn jacobian<'py>(&self, py: Python<'py>, point: PyReadonlyArray1<'py, f64>) -> PyResult<Bound<'py, PyArray2<f64>>> {
        let point = point.to_vec().map_err(wrong)?;
        rows_of(py, &self.ask(py, |answer| Request::Jacobian(point, answer))?)
    }
}

impl Solver for Foreign {
    fn solve(
        &mut self,
        problem: &mut dyn LeastSquares<Error = FitError>,
        from: &[f64],
        (low, high): (&[f64], &[f64]),
        loss: Loss,
        max_evaluations: usize,
    ) -> Result<Solution, FitError> {
        let (ask, asked) = mpsc::channel();
        let call = &self.call;
        let solved = std::thread::scope(|scope| {
            scope.spawn(move || {
                let found = Python::attach(|py| {
                    let requests = Bound::new(py, Requests(Mutex::new(ask.clone())))?;
                    let (residuals, jacobian) = (requests.getattr("residuals")?, requests.getattr("jacobian")?);
                    let [from, low, high] = [from, low, high].map(|values| values.to_pyarray(py));
                    call.bind(py)
                        .call1((residuals, jacobian, from, low, high, name_of(loss), max_evaluations))?
                        .extract()
                });
                // The receiver is dropped only after the fit; ignore the error.
                let _ = ask.send(Request::Ended(found));
            });
            answer(problem, &asked)
        })?;
        match solved {
            Ok((point, residuals, message)) => Ok(Solution::new(point, &residuals, message)),
            Err(error) => {
                self.raised.set(error);
                Err(SimulationError::Interrupted.into())
            }
        }
    }
}

/// Answers the solver until it ends, or until the problem fails.
#[allow(clippy::type_complexity)]
fn answer(
    problem: &mut dyn LeastSquares<Error = FitError>,
    asked: &mpsc::Receiver<Request>,
) -> Result<PyResult<(Vec<f64>, Vec<f64>, String)>, FitError> {
    loop {
        match asked.recv() {
            // A solver that has ended drops its receiver; ignore the error.
            Ok(Request::Residuals(point, to)) => drop(to.send(problem.residuals(&point)?)),
            Ok(Request::Jacobian(point, to)) => drop(to.send(problem.jacobian(&point)?)),
            Ok(Request::Ended(found)) => return Ok(found),
            Err(_) => return Err(SimulationError::Interrupted.into()),
        }
    }
}

const LOSSES: [(&str, Loss); 4] =
    [("linear", Loss::Linear), ("soft_l1", Loss::SoftL1), ("huber", Loss::Huber), ("cauchy", Loss::Cauchy)];

fn loss_of(name: &str) -> PyResult<Loss> {
    let found = LOSSES.iter().find(|(known, _)| *known == name).map(|(_, loss)| *loss);
    found.ok_or_else(|| {
        let known = LOSSES.map(|(name, _)| name).join(", ");
        wrong_argument("loss", format!("found `{name}`, expected {known}"))
    })
}

fn name_of(loss: Loss) -> &'static str {
    LOSSES.iter().find(|(_, known)| *known == loss).map_or("linear", |(name, _)| name)
}

fn jacobian_of(name: &str) -> PyResult<Jacobian> {
    match name {
        "differences" => Ok(Jacobian::Differences),
        "gradient" => Ok(Jacobian::Gradient),
        found => Err(wrong_argument("jacobian", format!("found `{found}`, expected differences or gradient"))),
    }
}

/// Makes a matrix from its columns.
fn rows_of<'py>(py: Python<'py>, columns: &[Vec<f64>]) -> PyResult<Bound<'py, PyArray2<f64>>> {
    let count = columns.first().map_or(0, Vec::len);
    let rows: Vec<Vec<f64>> = (0..count).map(|row| columns.iter().map(|column| column[row]).collect()).collect();
    PyArray2::from_vec2(py, &rows).map_err(failed)
}

/// Converts the result of a fit to a dictionary, by the names of `Fit`'s attributes.
fn result<'py>(py: Python<'py>, found: &FitResult) -> PyResult<Bound<'py, PyDict>> {
    let all = PyDict::new(py);
    let matrix = |rows: &Vec<Vec<f64>>| PyArray2::from_vec2(py, rows).map_err(failed);
    let free = found.parameters.iter().zip(&found.x).map(|(one, x)| {
        (one.name.clone(), one.unit(), one.parameter.is_factor(), one.low, one.high, one.is_at_a_bound(*x))
    });
    all.set_item("free", free.collect::<Vec<_>>())?;
    all.set_item("point", found.point.to_pyarray(py))?;
    all.set_item("message", &found.message)?;
    all.set_item("x", &found.x)?;
    all.set_item("std", &found.std)?;
    let intervals: Vec<(f64, f64)> = found
        .values()
        .zip(found.x.iter().zip(&found.half_width_95))
        .map(|((one, ..), (x, half))| (one.si(x - half), one.si(x + half)))
        .collect();
    all.set_item("intervals", intervals)?;
    all.set_item("independent_samples", found.independent_samples)?;
    all.set_item("values", found.values().map(|(_, value, error)| (value, error)).collect::<Vec<_>>())?;
    all.set_item("cov", matrix(&found.cov)?)?;
    all.set_item("inner_cov", matrix(&found.solver_cov)?)?;
    all.set_item("sensors_cov", matrix(&found.sensors_cov)?)?;
    all.set_item("residuals", found.residuals.to_pyarray(py))?;
    all.set_item("degrees_of_freedom", found.degrees_of_freedom)?;
    all.set_item("chi2_reduced", found.chi2().map(|(reduced, _)| reduced))?;
    all.set_item("chi2_expected", found.chi2().map(|(_, expected)| expected))?;
    all.set_item("singular_values", found.singular_values.to_pyarray(py))?;
    all.set_item("unseen", found.unseen())?;
    all.set_item("jacobian_agreement", found.jacobian_agreement)?;
    all.set_item("time_step_agreement", found.time_step_agreement)?;
    let channels = found.channels.iter().map(|one| {
        let delay_s = one.delay_s.map(|(s, _)| s);
        (one.title.clone(), one.noise, one.noise_is_known, one.correlation_time_s, one.rms_at_start, one.rms, delay_s)
    });
    all.set_item("channels", channels.collect::<Vec<_>>())?;
    all.set_item("correlated", found.correlated())?;
    all.set_item("evaluations", found.evaluations)?;
    all.set_item("differentiated", found.differentiated)?;
    let meanings = found
        .meanings
        .iter()
        .map(|one| (one.name.as_str(), one.explanation, one.quantity, one.unit, one.before, one.value, one.std));
    all.set_item("meanings", meanings.collect::<Vec<_>>())?;
    let doubts = found.doubts.iter().map(|doubt| (doubt.kind.name(), doubt.text.as_str()));
    all.set_item("doubts", doubts.collect::<Vec<_>>())?;
    Ok(all)
}

fn told(error: FitError) -> PyErr {
    match error {
        FitError::Argument { argument, message } => wrong_argument(argument, message),
        FitError::Simulation(error) => fault::simulation(&error),
        FitError::Sensitivity(error) => crate::gradient::told(&error),
        error @ FitError::Unplayable => failed(error),
        error => wrong(error),
    }
}

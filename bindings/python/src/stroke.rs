//! Strokes from numbers, arrays, names and recordings.

use std::sync::Arc;

use erard::level::{DURATION_S, HandKind, Reference, named};
use erard::stroke::{
    ForceSeries, MAX_FORCE_N, MAX_POSITION_M, PositionOf, PositionSeries, Prescribed, SampleError, Series,
    Stroke as Inner, Touch, constant_force_fault,
};
use numpy::PyReadonlyArray1;
use pyo3::prelude::*;

use crate::fault::{wrong, wrong_argument};
use crate::instrument::Instrument;
use crate::recording::Recording;
use crate::setup::joints_over;
use crate::watch::watched;

/// Stroke that can drive a key.
#[pyclass(frozen, module = "erard._erard")]
pub(crate) struct Stroke {
    pub inner: Arc<Inner>,
    /// How a recording was prepared, and remarks on how the stroke drives the key.
    #[pyo3(get)]
    notes: Vec<String>,
    /// Preparation of its recording as JSON, the `preparation` of the command's results.
    #[pyo3(get)]
    preparation: Option<String>,
}

/// Returns the prescribed quantity, by its name.
pub(crate) fn prescribed(name: &str) -> PyResult<Prescribed> {
    match name {
        "force" => Ok(Prescribed::Force),
        "motion" => Ok(Prescribed::Motion),
        "rigid" => Ok(Prescribed::Rigid),
        found => Err(wrong_argument("drive", format!("found `{found}`, expected `force`, `motion` or `rigid`"))),
    }
}

/// Returns a touch, by its name.
fn touched(name: &str) -> PyResult<Touch> {
    match name {
        "pressed" => Ok(Touch::Pressed),
        "struck" => Ok(Touch::Struck),
        found => Err(wrong_argument("touch", format!("found `{found}`, expected `pressed` or `struck`"))),
    }
}

/// Makes a series of samples from time 0 on, one every `dt` s, which prescribes a force, N, or a position, m.
pub(crate) fn sampled(kind: Prescribed, values: &[f64], dt: f64, name: &str) -> PyResult<Series> {
    if !(dt > 0.0 && dt.is_finite()) {
        return Err(wrong_argument("dt", format!("found {dt}, expected a positive number of seconds")));
    }
    let (most, unit) = if kind == Prescribed::Force { (MAX_FORCE_N, "N") } else { (MAX_POSITION_M, "m") };
    if let Some((at, value)) = values.iter().enumerate().find(|(_, value)| value.is_nan() || value.abs() > most) {
        let expected = format!("expected numbers of at most {most} {unit}");
        return Err(wrong_argument(name, format!("sample {at} is {value}; {expected}")));
    }
    let times = (0..values.len()).map(|i| i as f64 * dt).collect();
    series(kind, times, values.to_vec()).map_err(|error| wrong_argument(name, error))
}

fn series(kind: Prescribed, times: Vec<f64>, values: Vec<f64>) -> Result<Series, SampleError> {
    let mut series = Series { force: None, position: None, hammer_head: None, hammer_speed: None };
    match kind {
        Prescribed::Force => series.force = Some(ForceSeries::new(times, values)?),
        Prescribed::Motion | Prescribed::Rigid => series.position = Some(PositionSeries::new(times, values)?),
    }
    Ok(series)
}

#[pymethods]
impl Stroke {
    /// Makes a stroke of a constant force from the start on, N.
    #[staticmethod]
    fn constant(force_n: f64) -> PyResult<Self> {
        if let Some(fault) = constant_force_fault(force_n) {
            return Err(wrong_argument("force", format!("found {force_n}; {fault}")));
        }
        Ok(Self::of(Inner::constant(format!("{force_n} N"), force_n)))
    }

    /// Makes a stroke from samples, one every `dt` s; `kind` is `force`, `motion` or `rigid`.
    #[staticmethod]
    fn samples(kind: &str, values: PyReadonlyArray1<'_, f64>, dt: f64) -> PyResult<Self> {
        let drive = prescribed(kind)?;
        let values = values.as_slice().map_err(wrong)?;
        let series = sampled(drive, values, dt, kind)?;
        let position_of = if drive == Prescribed::Motion { PositionOf::Fingertip } else { PositionOf::Key };
        let title = format!("{} samples", values.len());
        let (inner, _) = Inner::recorded(title, series, position_of, Some(drive)).map_err(wrong)?;
        Ok(Self::of(inner))
    }

    /// Makes the built-in touch that reaches this total hammer speed at the string of an instrument, m/s, played by a
    /// hand of `mass_kg`. The joints of its finger have this compliance, m/N, and this retardation time, s, or those of
    /// the touch.
    #[staticmethod]
    #[allow(clippy::too_many_arguments)]
    fn level(
        py: Python<'_>,
        instrument: &Instrument,
        name: &str,
        speed_m_per_s: Option<f64>,
        touch: &str,
        mass_kg: f64,
        joints_m_per_n: Option<f64>,
        joints_s: Option<f64>,
    ) -> PyResult<Self> {
        let own = HandKind::new(touched(touch)?, mass_kg);
        let kind = HandKind { joints: joints_over(own.joints, joints_m_per_n, joints_s), ..own };
        let speed_m_per_s = speed_m_per_s.or_else(|| named(name)).ok_or_else(|| {
            wrong_argument("stroke", format!("found `{name}`, expected pp, p, mf, f, ff or a recording"))
        })?;
        let own = instrument.inner.clone();
        let solve = |going: &mut erard::Progress<'_>| Reference::new(&own, going)?.solve(kind, speed_m_per_s, going);
        let found = watched(py, None, solve, |error| wrong_argument("stroke", error))?;
        Ok(Self::of(Inner::by_hand(format!("{name}, {touch}"), found.whole(), DURATION_S)))
    }

    /// Makes a stroke from a built-in force curve.
    #[staticmethod]
    fn curve(nuance: &str, touch: &str, drive: Option<&str>) -> PyResult<Self> {
        let touch = touched(touch)?;
        let drive = drive.map(prescribed).transpose()?;
        match Inner::curve(nuance, touch, drive) {
            None => {
                Err(wrong_argument("stroke", format!("found `{nuance}`, expected pp, p, mf, f, ff or a recording")))
            }
            Some(made) => {
                let (inner, note) = made.map_err(wrong)?;
                Ok(Stroke { notes: note.into_iter().map(str::to_owned).collect(), ..Self::of(inner) })
            }
        }
    }

    /// Makes a stroke from a recording.
    #[staticmethod]
    fn recorded(recording: &Recording, drive: Option<&str>) -> PyResult<Self> {
        let drive = drive.map(prescribed).transpose()?;
        let (title, series, position_of) = recording.series()?;
        let (inner, note) = Inner::recorded(title, series, position_of, drive).map_err(wrong)?;
        let mut notes = recording.preparation_notes();
        notes.extend(note.map(str::to_owned));
        let preparation = Some(recording.prepared.report.json().to_string());
        Ok(Stroke { inner: Arc::new(inner), notes, preparation })
    }

    #[getter]
    fn title(&self) -> &str {
        &self.inner.title
    }

    #[getter]
    fn drive(&self) -> &'static str {
        self.inner.drive_name()
    }

    #[getter]
    fn start_s(&self) -> f64 {
        self.inner.start_s
    }

    #[getter]
    fn duration_s(&self) -> f64 {
        self.inner.duration_s
    }
}

impl Stroke {
    fn of(inner: Inner) -> Self {
        Stroke { inner: Arc::new(inner), notes: Vec::new(), preparation: None }
    }
}

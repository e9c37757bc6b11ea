//! Recordings: tables of what was measured.

use std::path::Path;

use erard::recording::{LowPass, Preparation, Prepared, prepare};
use erard::stroke::{Columns, Layout, PositionOf, Recording as Inner, Role, Series};
use numpy::{PyArray1, PyReadonlyArray1, ToPyArray};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::fault::{self, wrong, wrong_argument};

/// Prepared recording.
#[pyclass(frozen, module = "erard._erard")]
pub(crate) struct Recording {
    name: String,
    pub inner: Inner,
    /// Preparation of the recording.
    pub preparation: Preparation,
    pub prepared: Prepared,
    pub position_of: PositionOf,
}

/// Arguments of the preparation: part whose position it is, whether the zero is taken from the rest, low-pass in Hz,
/// whether each channel's own noise sets it, inverted columns, delays of columns, s, and stated zeros of columns.
type Ready = (Option<String>, bool, Option<f64>, bool, Vec<String>, Vec<(String, f64)>, Vec<(String, f64)>);

#[pymethods]
impl Recording {
    /// Reads a recording from a text file.
    #[staticmethod]
    fn load(path: &str, columns: Option<&str>, ready: Ready) -> PyResult<Self> {
        let columns = asked(columns)?;
        let path = Path::new(path);
        let name = erard::files::shown(path);
        let inner =
            Inner::read_opened(std::fs::File::open(path), &name, &columns).map_err(|error| fault::stroke(&error))?;
        Self::made(name, inner, ready)
    }

    /// Makes a recording from columns with titles.
    #[staticmethod]
    fn table(
        name: &str,
        titles: Vec<String>,
        values: Vec<PyReadonlyArray1<'_, f64>>,
        columns: Option<&str>,
        ready: Ready,
    ) -> PyResult<Self> {
        let columns = asked(columns)?;
        let titles: Vec<&str> = titles.iter().map(String::as_str).collect();
        let layout = Layout::of(&titles, &columns, name).map_err(|error| fault::stroke(&error))?;
        let values: Vec<&[f64]> =
            values.iter().map(|values| values.as_slice().map_err(wrong)).collect::<PyResult<_>>()?;
        let own: Vec<&[f64]> = layout.columns.iter().map(|column| values[column.index]).collect();
        let inner = Inner::from_columns(layout, name, &own).map_err(|error| fault::stroke(&error))?;
        Self::made(name.to_owned(), inner, ready)
    }

    #[getter]
    pub(crate) fn name(&self) -> &str {
        &self.name
    }

    /// Returns the samples of the file, unprepared but in SI units, by the columns' names.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let columns = PyDict::new(py);
        columns.set_item("time_s", self.inner.time_s.to_pyarray(py))?;
        for channel in &self.inner.channels {
            columns.set_item(column(channel.role), channel.values.to_pyarray(py))?;
        }
        Ok(columns)
    }

    /// Returns a prepared channel at these times, s; `None` if it was not recorded.
    fn at<'py>(
        &self,
        py: Python<'py>,
        name: &str,
        times: PyReadonlyArray1<'_, f64>,
    ) -> PyResult<Option<Bound<'py, PyArray1<f64>>>> {
        let times = times.as_slice().map_err(wrong)?;
        let Series { force, position, hammer_head, hammer_speed } = &self.prepared.series;
        let mut cursor = erard::stroke::Cursor::default();
        let values: Option<Vec<f64>> = match name {
            "force_N" => force.as_ref().map(|s| times.iter().map(|t| s.at(*t, &mut cursor)).collect()),
            "key_m" => position.as_ref().map(|s| times.iter().map(|t| s.at(*t, &mut cursor).0).collect()),
            "hammer_rise_m" => hammer_head.as_ref().map(|s| times.iter().map(|t| s.at(*t, &mut cursor).0).collect()),
            "hammer_rise_m_per_s" => {
                hammer_speed.as_ref().map(|s| times.iter().map(|t| s.at(*t, &mut cursor)).collect())
            }
            _ => None,
        };
        Ok(values.map(|values| values.to_pyarray(py)))
    }

    /// Returns the root mean square noise of a channel, N, m or m/s; `None` if it could not be measured.
    fn noise(&self, name: &str) -> Option<f64> {
        self.prepared.report.channel(role(name).ok()?)?.noise.map(|noise| noise.rms)
    }

    /// Part whose position was recorded: `key`, `fingertip` or `key-back`.
    #[getter]
    fn position_of(&self) -> &'static str {
        self.position_of.name()
    }

    /// Changes and observations of the preparation.
    #[getter]
    fn notes(&self) -> Vec<String> {
        let report = &self.prepared.report;
        let done = report.channels.iter().flat_map(|channel| {
            channel.lines().into_iter().map(|line| format!("{}: {line}", channel.role.name())).collect::<Vec<_>>()
        });
        done.chain(report.warnings()).collect()
    }
}

/// Parses the requested columns.
fn asked(columns: Option<&str>) -> PyResult<Columns> {
    columns
        .map_or_else(|| Ok(Columns::default()), |text| text.parse().map_err(|error| wrong_argument("columns", error)))
}

/// Returns the name of a role's column in a run.
fn column(role: Role) -> &'static str {
    match role {
        Role::Time => "time_s",
        Role::Force => "force_N",
        Role::Position => "key_m",
        Role::HammerHead => "hammer_rise_m",
        Role::HammerSpeed => "hammer_rise_m_per_s",
    }
}

/// Returns the role of a compared column, by its name.
fn role(name: &str) -> PyResult<Role> {
    let known = [Role::Force, Role::Position, Role::HammerHead, Role::HammerSpeed];
    known
        .into_iter()
        .find(|role| column(*role) == name)
        .ok_or_else(|| wrong_argument("columns", format!("found `{name}`, expected {}", known.map(column).join(", "))))
}

impl Recording {
    fn made(name: String, inner: Inner, (position, zero, hz, own, inverted, late, zeros): Ready) -> PyResult<Self> {
        let low_pass = match (hz, own) {
            (Some(hz), _) if hz > 0.0 && hz.is_finite() => LowPass::At(hz),
            (Some(hz), _) => {
                return Err(wrong_argument("low_pass", format!("found {hz}, expected a positive number of Hz")));
            }
            (None, true) => LowPass::Own,
            (None, false) => LowPass::Off,
        };
        let position_of = match position.as_deref() {
            None => inner.position_of,
            Some("key") => PositionOf::Key,
            Some("fingertip") => PositionOf::Fingertip,
            Some("key-back") => PositionOf::KeyBack,
            Some(found) => {
                let expected = "expected `key`, `fingertip` or `key-back`";
                return Err(wrong_argument("position", format!("found `{found}`, {expected}")));
            }
        };
        let inverted = inverted.iter().map(|name| role(name)).collect::<PyResult<_>>()?;
        let late_s = late.iter().map(|(name, s)| Ok((role(name)?, *s))).collect::<PyResult<_>>()?;
        let zero_at = zeros.iter().map(|(name, at)| Ok((role(name)?, *at))).collect::<PyResult<_>>()?;
        let preparation = Preparation { zero, zero_at, low_pass, inverted, late_s, ..Preparation::default() };
        let prepared = prepare(&inner, &preparation).map_err(|error| wrong(format!("{name}: {error}")))?;
        Ok(Recording { name, inner, preparation, prepared, position_of })
    }

    /// How it was prepared, and what was noticed, as the command reports it; empty if it was left as it is.
    pub(crate) fn preparation_notes(&self) -> Vec<String> {
        let is_plain = !self.preparation.zero && self.preparation.low_pass == LowPass::Off;
        if is_plain { Vec::new() } else { self.prepared.report.told() }
    }

    /// Returns the data that can drive a key: name, series, and part whose position it is.
    pub(crate) fn series(&self) -> PyResult<(String, Series, PositionOf)> {
        Ok((self.name.clone(), self.prepared.series.clone(), self.position_of))
    }
}

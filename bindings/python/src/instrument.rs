//! Instruments: a file's text, and what was changed of it.

use std::sync::Arc;

use erard::instrument::{Certainty, Instrument as Inner, InstrumentFile, Provenance, numbers_at};
use erard::instrument_spec::InstrumentSpec;
use erard::keyboard::Keyboard;
use erard::parameter::{ParameterChange, register, varied_of, with_changed_numbers};
use erard::stroke::NUANCES;
use erard_kinematics::LinkageFile;
use erard_workshop::study::Source;
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::fault;

/// Value of a change: a number or a text.
#[derive(FromPyObject, IntoPyObject, Clone)]
pub(crate) enum Value {
    Number(f64),
    Text(String),
}

impl From<Value> for ParameterChange {
    fn from(value: Value) -> Self {
        match value {
            Value::Number(number) => ParameterChange::Value(number),
            Value::Text(text) => ParameterChange::Text(text),
        }
    }
}

/// Instrument, given by its file's text and the changes that are applied one after the other; so it is pickled.
#[pyclass(frozen, module = "erard._erard")]
pub(crate) struct Instrument {
    text: Arc<str>,
    file_name: Arc<str>,
    /// File as it was read, without the changes.
    read: Arc<InstrumentFile>,
    changes: Vec<(String, Value)>,
    provenance: Provenance,
    pub inner: Arc<Inner>,
}

#[pymethods]
impl Instrument {
    #[new]
    pub(crate) fn new(text: &str, file_name: &str, changes: Vec<(String, Value)>) -> PyResult<Self> {
        Self::made(text.into(), file_name.into(), None, changes)
    }

    /// Loads a built-in instrument, a file, or a key of a keyboard.
    #[staticmethod]
    fn load(asked: &str) -> PyResult<Self> {
        let (text, file_name) =
            asked.parse().and_then(|asked: InstrumentSpec| asked.text()).map_err(|error| fault::asked(&error))?;
        Self::made(text.into(), file_name.into(), None, Vec::new())
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
    }

    #[getter]
    fn key(&self) -> Option<usize> {
        self.inner.key()
    }

    #[getter]
    fn sample(&self) -> Option<u32> {
        self.inner.sample()
    }

    #[getter]
    fn usual_step_s(&self) -> f64 {
        self.inner.usual_step_s()
    }

    #[getter]
    fn description(&self) -> &str {
        &self.read.description
    }

    #[getter]
    fn text(&self) -> &str {
        &self.text
    }

    #[getter]
    fn file_name(&self) -> &str {
        &self.file_name
    }

    #[getter]
    fn changes(&self) -> Vec<(String, Value)> {
        self.changes.clone()
    }

    #[getter]
    fn bodies(&self) -> Vec<&str> {
        self.inner.bodies.iter().map(|body| body.name.as_str()).collect()
    }

    #[getter]
    fn zones(&self) -> Vec<&str> {
        self.inner.zones.iter().map(|zone| zone.name.as_str()).collect()
    }

    /// Screws: name, and effect of a positive setting.
    #[getter]
    fn screws(&self) -> Vec<(&str, &str)> {
        self.inner.screws.iter().map(|screw| (screw.name.as_str(), screw.label.as_str())).collect()
    }

    /// Returns all named parameters.
    fn quantities<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        register(&self.file())
            .into_iter()
            .map(|entry| {
                // Turns and factors become values.
                let si = |by: f64| if entry.parameter.is_factor() { entry.value * by } else { entry.value + by };
                let ends = |[low, high]: [f64; 2]| {
                    if entry.value < 0.0 && entry.parameter.is_factor() {
                        vec![si(high), si(low)]
                    } else {
                        vec![si(low), si(high)]
                    }
                };
                let row = PyDict::new(py);
                row.set_item("name", &entry.name)?;
                row.set_item("value", entry.value)?;
                row.set_item("unit", entry.quantity.si_unit())?;
                row.set_item("is_screw", !entry.parameter.is_factor())?;
                row.set_item("range", ends(entry.parameter.range()))?;
                row.set_item("spread", entry.spread.map(ends))?;
                row.set_item("certainty", entry.certainty.map(certainty))?;
                row.set_item("path", &entry.path)?;
                Ok(row)
            })
            .collect()
    }

    /// Returns the instrument with further changes.
    fn varied(&self, changes: Vec<(String, Value)>) -> PyResult<Self> {
        let all = self.changes.iter().cloned().chain(changes).collect();
        Self::made(self.text.clone(), self.file_name.clone(), Some(self.read.clone()), all)
    }

    /// Returns a number of the file by its path (`zone.string.disc.center_mm.x`), in the file's own unit: the value set
    /// last, or the one in the text. `None` if there is no such number, or if a text changed it.
    fn number_at(&self, path: &str) -> Option<f64> {
        match self.changes.iter().rev().find(|(name, _)| name == path) {
            Some((_, Value::Number(number))) => return Some(*number),
            Some((_, Value::Text(_))) => return None,
            None => {}
        }
        let place = |text: &str, path: &str, which: usize, of: usize| {
            numbers_at(text, path).filter(|numbers| numbers.len() == of).map(|numbers| numbers[which])
        };
        place(&self.text, path, 0, 1).or_else(|| {
            let (path, axis) = path.rsplit_once('.')?;
            place(&self.text, path, ["x", "y"].iter().position(|known| *known == axis)?, 2)
        })
    }

    fn equals(&self, other: &Self) -> bool {
        self.inner == other.inner
    }
}

impl Instrument {
    /// Returns the text of the file with the numbers that were changed by their paths, and the other changes: variants
    /// of a study are made from them.
    pub(crate) fn source(&self) -> PyResult<Source> {
        let changes: Vec<(String, ParameterChange)> =
            self.changes.iter().map(|(name, value)| (name.clone(), value.clone().into())).collect();
        let (text, changes) =
            with_changed_numbers(&self.read.instrument, &self.text, &changes).map_err(|error| fault::change(&error))?;
        Ok(Source::Text { text: text.unwrap_or_else(|| self.text.to_string()), changes })
    }

    /// Returns the instrument with the sources of its parameters.
    pub(crate) fn file(&self) -> InstrumentFile {
        InstrumentFile {
            instrument: (*self.inner).clone(),
            description: String::new(),
            provenance: self.provenance.clone(),
        }
    }

    /// Makes an instrument from a text, which may have been `read` already.
    fn made(
        text: Arc<str>,
        file_name: Arc<str>,
        read: Option<Arc<InstrumentFile>>,
        changes: Vec<(String, Value)>,
    ) -> PyResult<Self> {
        let read = match read {
            Some(read) => read,
            None => Arc::new(InstrumentFile::parse(&text, &file_name).map_err(|error| fault::file(&error))?),
        };
        let asked: Vec<(String, ParameterChange)> =
            changes.iter().map(|(name, value)| (name.clone(), value.clone().into())).collect();
        let file = varied_of(&read, &text, &file_name, &asked).map_err(|error| fault::change(&error))?;
        Ok(Instrument { text, file_name, read, changes, provenance: file.provenance, inner: Arc::new(file.instrument) })
    }

    /// Returns the instrument with its screws set as in `regulated`, which was made from it by turning screws.
    pub(crate) fn turned(&self, regulated: &Inner, title: &str, note: &str) -> PyResult<Self> {
        let text = regulated.rewrite(&self.text, title, note).map_err(fault::failed)?;
        let is_screw = |name: &String| self.inner.screws.iter().any(|screw| screw.name == *name);
        let changes = self.changes.iter().filter(|(name, _)| !is_screw(name)).cloned().collect();
        Self::made(text.into(), self.file_name.clone(), None, changes)
    }
}

pub fn certainty(certainty: Certainty) -> &'static str {
    match certainty {
        Certainty::Measured => "measured",
        Certainty::Read => "read",
        Certainty::SecondHand => "second-hand",
        Certainty::Estimate => "estimate",
    }
}

/// Returns the names of the built-in instruments, keyboards, linkages and strokes.
#[pyfunction]
pub fn builtin() -> (Vec<&'static str>, Vec<&'static str>, Vec<&'static str>, Vec<&'static str>) {
    (
        Inner::builtin_names().collect(),
        Keyboard::builtin_names().collect(),
        LinkageFile::builtin_names().collect(),
        NUANCES.to_vec(),
    )
}

//! Instruments: a file's text, and what was changed of it.

use std::sync::Arc;

use erard::instrument::{Certainty, Instrument as Inner, InstrumentFile, Provenance, numbers_at};
use erard::instrument_spec::InstrumentSpec;
use erard::keyboard::Keyboard;
use erard::stroke::NUANCES;
use erard_levers::LinkageFile;
use erard_workshop::study::{Change, quantities, varied_of};
use pyo3::prelude::*;
use pyo3::types::PyDict;

use crate::fault;

/// A change of a number: a name, and a number or a text.
#[derive(FromPyObject, IntoPyObject, Clone)]
pub(crate) enum Value {
    Number(f64),
    Text(String),
}

impl From<Value> for Change {
    fn from(value: Value) -> Self {
        match value {
            Value::Number(number) => Change::Number(number),
            Value::Text(text) => Change::Text(text),
        }
    }
}

/// An instrument. It is what its file's text says, with the changes done to it one after the other: that is how it is
/// pickled.
#[pyclass(frozen, module = "erard._erard")]
pub(crate) struct Instrument {
    text: Arc<str>,
    file_name: Arc<str>,
    /// The text as it was read, without the changes.
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

    /// A built-in one, a file, or a key of a keyboard.
    #[staticmethod]
    fn load(asked: &str) -> PyResult<Self> {
        let (text, file_name) =
            InstrumentSpec::of(asked).and_then(InstrumentSpec::text).map_err(|error| fault::asked(&error))?;
        Self::made(text.into(), file_name.into(), None, Vec::new())
    }

    #[getter]
    fn name(&self) -> &str {
        &self.inner.name
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

    /// Name and what a positive setting does.
    #[getter]
    fn screws(&self) -> Vec<(&str, &str)> {
        self.inner.screws.iter().map(|screw| (screw.name.as_str(), screw.label.as_str())).collect()
    }

    /// Everything that has a name of its own to be varied by.
    fn quantities<'py>(&self, py: Python<'py>) -> PyResult<Vec<Bound<'py, PyDict>>> {
        quantities(&self.file())
            .into_iter()
            .map(|quantity| {
                let row = PyDict::new(py);
                row.set_item("name", quantity.name)?;
                row.set_item("value", quantity.value)?;
                row.set_item("unit", quantity.unit)?;
                row.set_item("is_factor", quantity.parameter.is_factor())?;
                row.set_item("range", quantity.parameter.range().to_vec())?;
                row.set_item("spread", quantity.spread.map(|spread| spread.to_vec()))?;
                row.set_item("certainty", quantity.certainty.map(certainty))?;
                row.set_item("path", quantity.path)?;
                Ok(row)
            })
            .collect()
    }

    /// The same instrument with further changes.
    fn varied(&self, changes: Vec<(String, Value)>) -> PyResult<Self> {
        let all = self.changes.iter().cloned().chain(changes).collect();
        Self::made(self.text.clone(), self.file_name.clone(), Some(self.read.clone()), all)
    }

    /// A number of the file by its path (`zone.string.disc.center_mm.x`), in the file's own unit: as it was last set,
    /// or as it stands in the text. None where there is no such number, or where it was changed by a text.
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
    /// The instrument with the sources of its numbers.
    pub(crate) fn file(&self) -> InstrumentFile {
        InstrumentFile {
            instrument: (*self.inner).clone(),
            description: String::new(),
            provenance: self.provenance.clone(),
        }
    }

    /// Of a text that has been `read` already, or has not.
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
        let asked: Vec<(String, Change)> =
            changes.iter().map(|(name, value)| (name.clone(), value.clone().into())).collect();
        let file = varied_of(&read, &text, &file_name, &asked).map_err(|error| fault::change(&error))?;
        Ok(Instrument { text, file_name, read, changes, provenance: file.provenance, inner: Arc::new(file.instrument) })
    }

    /// The instrument with its screws turned as in another, which was made of it by turning screws.
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

/// Names of the built-in instruments, keyboards, linkages and strokes.
#[pyfunction]
pub fn builtin() -> (Vec<&'static str>, Vec<&'static str>, Vec<&'static str>, Vec<&'static str>) {
    (
        Inner::builtin_names().collect(),
        Keyboard::builtin_names().collect(),
        LinkageFile::builtin_names().collect(),
        NUANCES.to_vec(),
    )
}

//! Causes from one's own readings of a key.

use erard_workshop::diagnose::{Typed, answer, diagnose as judge};
use erard_workshop::measure::norms::MIDDLE_C;
use pyo3::prelude::*;

use crate::fault::{wrong, wrong_argument};

/// Diagnoses readings and returns the JSON of `erard diagnose`.
#[pyfunction]
pub(crate) fn diagnose(py: Python<'_>, readings: &str) -> PyResult<String> {
    let typed = Typed::read(readings).map_err(|faults| {
        let each: Vec<String> = faults.iter().map(ToString::to_string).collect();
        match faults.first().filter(|first| !first.entry.is_empty()) {
            Some(first) => wrong_argument(first.entry, each.join("; ")),
            None => wrong(each.join("; ")),
        }
    })?;
    let found = py.detach(|| judge(&typed.known, typed.key.unwrap_or(MIDDLE_C)));
    Ok(answer(&[found], None, typed.key.is_none()).to_string())
}

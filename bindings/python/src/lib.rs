//! The Python extension `erard._erard`: conversion between Python and the crates below, and nothing else. What users
//! see is `python/erard`.
//!
//! Every long call lets go of Python's lock, and looks for signals at least every 50 ms (`watch`).

mod action;
mod advance;
mod bench;
mod diagnosis;
mod fault;
mod fit;
mod gradient;
mod instrument;
mod keys;
mod lab;
mod many;
mod press;
mod recording;
mod setup;
mod stroke;
mod watch;

use pyo3::prelude::*;

#[pymodule]
mod _erard {
    #[pymodule_export]
    use super::action::{Action, Reading};
    #[pymodule_export]
    use super::advance::advance;
    #[pymodule_export]
    use super::bench::{draw, keyboard, kinematics, measure, measure_lines, regulate};
    #[pymodule_export]
    use super::diagnosis::diagnose;
    #[pymodule_export]
    use super::fit::Problem;
    #[pymodule_export]
    use super::gradient::gradient;
    #[pymodule_export]
    use super::instrument::{Instrument, builtin};
    #[pymodule_export]
    use super::keys::Keys;
    #[pymodule_export]
    use super::lab::{compare, validate};
    #[pymodule_export]
    use super::many::{rollout, study};
    #[pymodule_export]
    use super::press::{figure, press, unit};
    #[pymodule_export]
    use super::recording::Recording;
    #[pymodule_export]
    use super::stroke::Stroke;

    /// Loads NumPy's interface with the module: at the first call an interrupt could end it half-way.
    #[pymodule_init]
    fn init(module: &pyo3::Bound<'_, pyo3::types::PyModule>) -> pyo3::PyResult<()> {
        drop(numpy::PyArray1::<f64>::zeros(module.py(), 0, false));
        Ok(())
    }
}

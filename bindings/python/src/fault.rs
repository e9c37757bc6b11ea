//! Errors of the crates below as Python's: `InputError` for what the caller gave, with file, line and key;
//! `SimulationError` for what came of it.

use erard::instrument::FileError;
use erard::instrument_spec::InstrumentSpecError;
use erard::parameter::{ChangeError, NameError};
use erard::player::ActionError;
use erard::run::SimulationError;
use erard::stroke::StrokeError;
use erard_workshop::measure::MeasureError;
use pyo3::prelude::*;

mod python {
    pyo3::import_exception!(erard._errors, InputError);
    pyo3::import_exception!(erard._errors, MissingFileError);
    pyo3::import_exception!(erard._errors, SimulationError);
}

/// Place of an error; empty or 0 means unknown.
#[derive(Default)]
struct Place<'a> {
    file: &'a str,
    line: u64,
    key: &'a str,
    found: &'a str,
    expected: &'a str,
}

fn input(message: String, place: &Place<'_>) -> PyErr {
    let text = |text: &str| (!text.is_empty()).then(|| text.to_owned());
    let line = (place.line > 0).then_some(place.line);
    let arguments = (message, text(place.file), line, text(place.key), text(place.found), text(place.expected));
    if place.line == 0 && arguments.0.contains("cannot be read: ") {
        return python::MissingFileError::new_err(arguments);
    }
    python::InputError::new_err(arguments)
}

/// Makes an `InputError` from a message.
pub(crate) fn wrong(message: impl std::fmt::Display) -> PyErr {
    input(message.to_string(), &Place::default())
}

/// Makes an `InputError` for an argument, by its name.
pub(crate) fn wrong_argument(key: &str, message: impl std::fmt::Display) -> PyErr {
    input(format!("{key}: {message}"), &Place { key, ..Place::default() })
}

/// Makes a `SimulationError` from a message.
pub(crate) fn failed(message: impl std::fmt::Display) -> PyErr {
    python::SimulationError::new_err(message.to_string())
}

pub(crate) fn file(error: &FileError) -> PyErr {
    let FileError { file, line, key, found, expected, .. } = error;
    input(error.to_string(), &Place { file, line: *line as u64, key, found, expected })
}

pub(crate) fn stroke(error: &StrokeError) -> PyErr {
    let StrokeError { file, line, column, found, expected, .. } = error;
    input(error.to_string(), &Place { file, line: *line, key: column, found, expected })
}

pub(crate) fn asked(error: &InstrumentSpecError) -> PyErr {
    match error {
        InstrumentSpecError::File(error) => file(error),
        InstrumentSpecError::NoKey { key, .. } => input(error.to_string(), &Place { found: key, ..Place::default() }),
        InstrumentSpecError::NoSample { sample, .. } => {
            input(error.to_string(), &Place { found: sample, ..Place::default() })
        }
        InstrumentSpecError::Sampled { asked } => input(error.to_string(), &Place { found: asked, ..Place::default() }),
        InstrumentSpecError::IsKeyboard { file } => input(error.to_string(), &Place { file, ..Place::default() }),
        InstrumentSpecError::UnknownKeyboard { name } => {
            input(error.to_string(), &Place { found: name, ..Place::default() })
        }
        InstrumentSpecError::Unknown(unknown) => {
            input(error.to_string(), &Place { found: &unknown.name, ..Place::default() })
        }
        error => input(error.to_string(), &Place::default()),
    }
}

pub(crate) fn change(error: &ChangeError) -> PyErr {
    let message = error.to_string();
    match error {
        ChangeError::File(error) => file(error),
        ChangeError::Unknown(NameError::Unknown { name, nearest: expected, .. })
        | ChangeError::Idle(NameError::Idle { name, acts: expected, .. }) => {
            input(message, &Place { key: name, found: name, expected, ..Place::default() })
        }
        ChangeError::Range { name, found, expected } => {
            input(message, &Place { key: name, found, expected, ..Place::default() })
        }
        ChangeError::Value { name, error } => {
            let expected = error.to_string();
            input(message, &Place { key: name, found: error.found(), expected: &expected, ..Place::default() })
        }
        _ => input(message, &Place::default()),
    }
}

/// Converts the error of a run; invalid input names the argument.
pub(crate) fn simulation(error: &SimulationError) -> PyErr {
    let key = match error {
        SimulationError::Step { .. } => "step",
        SimulationError::Theta { .. } => "theta",
        SimulationError::Tolerance { .. } => "tolerance",
        SimulationError::Duration { .. } => "duration",
        SimulationError::Rows { .. } => "record_every",
        SimulationError::Start { .. } => "stroke",
        SimulationError::NoKey => return wrong(error),
        _ => return failed(error),
    };
    wrong_argument(key, error)
}

/// Converts the error of making an action.
pub(crate) fn action(error: &ActionError) -> PyErr {
    match error {
        ActionError::Step { .. } => wrong_argument("step", error),
        error => failed(error),
    }
}

pub(crate) fn measure(error: &MeasureError) -> PyErr {
    match error {
        MeasureError::NotAnAction(_) | MeasureError::Anatomy(_) => wrong(error),
        error => failed(error),
    }
}

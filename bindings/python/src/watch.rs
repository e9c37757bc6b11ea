//! Long work without Python's lock: signals are looked for, and progress told, at least every 50 ms.

use erard::Progress;
use std::time::{Duration, Instant};

use pyo3::prelude::*;

/// Time between checks for Python's signals, short enough that Control-C stops the work within 0.2 s.
const EVERY: Duration = Duration::from_millis(50);

/// Does the work without Python's lock and calls `progress` with the share done. An exception from `progress` or from a
/// signal handler stops the work and is raised.
pub(crate) fn watched<T: Send, E: Send>(
    py: Python<'_>,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&mut Progress<'_>) -> Result<T, E> + Send,
    fault: impl FnOnce(&E) -> PyErr,
) -> PyResult<T> {
    let mut raised: Option<PyErr> = None;
    let done = py.detach(|| {
        let mut last = Instant::now();
        let mut going = |share: f64| {
            if raised.is_some() {
                return false;
            }
            if last.elapsed() < EVERY && share < 1.0 {
                return true;
            }
            last = Instant::now();
            let asked = Python::attach(|py| {
                py.check_signals()?;
                match &progress {
                    Some(progress) => progress.call1(py, (share,)).map(|_| ()),
                    None => Ok(()),
                }
            });
            match asked {
                Ok(()) => true,
                Err(error) => {
                    raised = Some(error);
                    false
                }
            }
        };
        work(&mut going)
    });
    if let Some(error) = raised {
        return Err(error);
    }
    done.map_err(|error| fault(&error))
}

//! Test whether an instrument plays: one press, with warnings about the run.

use crate::cores;
use crate::measure::MeasureError;
use erard::Progress;
use erard::instrument::Instrument;
use erard::player;
use erard::run::{Setup, SimulationError, simulate};
use erard::stroke::{Series, Touch};
use erard::trust::Warning;

/// Built-in stroke for this test.
pub(crate) const NUANCE: &str = "mf";

/// An instrument that was pressed once.
#[derive(Debug, Clone, PartialEq)]
pub struct TestPress {
    /// Speed of the strike point at the string, m/s; `None` if it does not reach the string.
    pub hammer_speed_m_per_s: Option<f64>,
    /// Reasons why the press cannot be trusted: a limit that it exceeded, or why it could not be played.
    pub warnings: Vec<Warning>,
}

/// Presses an instrument once with a pressed mezzo forte. An instrument without a key is not pressed and has no
/// warnings.
///
/// # Errors
/// An interruption, or an error not caused by this instrument ([`SimulationError::warning`]).
pub fn test_press(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<TestPress, SimulationError> {
    let silent = TestPress { hammer_speed_m_per_s: None, warnings: Vec::new() };
    // A test of strokes reads every built-in stroke.
    let Some(force) = Series::builtin(NUANCE, Touch::Pressed).and_then(|series| series.force) else {
        return Ok(silent);
    };
    if instrument.roles.key.is_none() {
        return Ok(silent);
    }
    let end_s = force.times_s().last().copied().unwrap_or_default();
    let setup = Setup { record_every: Some(100), ..Setup::new(end_s) };
    match simulate(instrument, &player::force(force.drive()), &setup, progress) {
        Ok(run) => Ok(TestPress { hammer_speed_m_per_s: run.events.hammer_speed_m_per_s(), warnings: run.warnings }),
        Err(error) => match error.warning() {
            Some(warning) => Ok(TestPress { warnings: vec![warning], ..silent }),
            None => Err(error),
        },
    }
}

/// Tries many instruments on all cores. `progress` receives the share done, and ends the work by returning false.
///
/// # Errors
/// See [`test_press`].
pub fn test_presses(instruments: &[Instrument], progress: &mut Progress<'_>) -> Result<Vec<TestPress>, MeasureError> {
    cores::map(instruments, cores::count(), progress, |instrument, progress| Ok(test_press(instrument, progress)?))
}

//! One note of a performance, for viewing in detail.

use erard::instrument::Instrument;
use erard::run::{Run, Setup, SimulationError, simulate_from};
use erard::strings::Pedal;
use erard::stroke::HandStroke;
use erard::{Progress, Snapshot};

/// Time for which a note is shown beyond the longest stroke, s.
const SHOWN_S: f64 = 0.25;
/// Approximate number of rows of a run for viewing.
const ROWS: f64 = 500.0;

/// The beginning of a note: the key's state when the hand began to press, and the hand's stroke.
#[derive(Debug, Clone)]
pub struct Moment {
    /// Its number in the score, from 0.
    pub note: usize,
    /// The key, from 1.
    pub key: usize,
    pub(crate) start: Snapshot,
    pub(crate) stroke: HandStroke,
    /// Instant at which the hand began to press, s.
    pub pressed_s: f64,
    pub(crate) lift_m: f64,
}

impl Moment {
    /// Replays the note as a run from the beginning of its hand (0 s).
    ///
    /// # Errors
    /// As [`erard::run::simulate`]; [`SimulationError::State`] for another instrument.
    pub fn run(
        &self,
        instrument: &Instrument,
        step_s: f64,
        progress: &mut Progress<'_>,
    ) -> Result<Run, SimulationError> {
        let struck_s = self.stroke.relaxes.map_or(0.1, |relax| relax.at_s);
        let mut setup = Setup::new(struck_s + SHOWN_S);
        setup.settings.step = step_s;
        setup.record_every = Some(((struck_s + SHOWN_S) / step_s / ROWS).ceil() as u64);
        setup.hand = Some(self.stroke.hand);
        if self.lift_m > 0.0 {
            setup.pedal = Pedal::held(self.lift_m);
        }
        simulate_from(instrument, &self.start, &|t| self.stroke.input(t), &setup, progress)
    }
}

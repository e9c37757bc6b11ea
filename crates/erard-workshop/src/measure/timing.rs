//! The timing sheet: what happens when, from pianissimo to fortissimo, pressed and struck.

use moreau::Settings;

use super::MeasureError;
use super::flight::{Flights, flights};
use erard::Progress;
use erard::instrument::Instrument;
use erard::player;
use erard::run::Events;
use erard::run::{Setup, simulate};
use erard::stroke::{NUANCES, Series, Touch};
use erard::trust::Warning;

/// Step, s.
const STEP_S: f64 = 50e-6;

/// One built-in stroke, force driven. Its forces are those that were written for the concert grand.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Timing {
    /// `pp`, `p`, `mf`, `f`, `ff`.
    pub nuance: &'static str,
    /// Pressed or struck.
    pub touch: Touch,
    /// Largest force on the key, N.
    pub peak_force_n: f64,
    /// What happened when.
    pub events: Events,
    /// How the hammer flew.
    pub flights: Option<Flights>,
    /// Why the run is not to be trusted.
    pub warnings: Vec<Warning>,
}

impl Timing {
    /// `pressed` or `struck`.
    #[must_use]
    pub(crate) fn touch_name(&self) -> &'static str {
        match self.touch {
            Touch::Pressed => "pressed",
            Touch::Struck => "struck",
        }
    }

    /// From key start to an event, s.
    #[must_use]
    pub(crate) fn since_key_start(&self, event: Option<f64>) -> Option<f64> {
        Some(event? - self.events.key_start_s?)
    }

    /// How long before key bottom the hammer meets the string, s; negative when it comes later.
    #[must_use]
    pub(crate) fn hammer_before_bottom_s(&self) -> Option<f64> {
        Some(self.events.key_bottom_s? - self.events.hammer_contact_s()?)
    }
}

/// Plays all built-in strokes, pressed ones first.
///
/// # Errors
/// See [`MeasureError`].
pub(crate) fn timing(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Vec<Timing>, MeasureError> {
    let mut sheet = Vec::new();
    for touch in [Touch::Pressed, Touch::Struck] {
        for nuance in NUANCES {
            // Every one of them is there: a test reads them all.
            let Some(series) = Series::builtin(nuance, touch) else { continue };
            let Some(force) = &series.force else { continue };
            let setup = Setup {
                settings: Settings::new(STEP_S),
                start_s: series.start_s(),
                record_every: Some(1),
                ..Setup::new(series.end_s() - series.start_s())
            };
            let run = simulate(instrument, &player::force(force.drive()), &setup, &mut |_| progress(0.0))?;
            sheet.push(Timing {
                nuance,
                touch,
                peak_force_n: run.peak_force_n,
                flights: flights(&run.time_s, &run.hammer_head_m, &run.events),
                events: run.events,
                warnings: run.warnings,
            });
        }
    }
    Ok(sheet)
}

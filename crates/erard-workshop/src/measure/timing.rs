//! Timing sheet: times of the events, from pianissimo to fortissimo, pressed and struck.

use moreau::Settings;

use super::MeasureError;
use super::flight::{Flights, flights};
use erard::Progress;
use erard::level::{HandKind, LEVELS, LevelError, MASS_KG, Reference};
use erard::player::AtRest;
use erard::run::Events;
use erard::run::{Setup, SimulationError, simulate_at_rest};
use erard::stroke::Touch;
use erard::trust::Warning;

/// Step, s.
const STEP_S: f64 = 50e-6;
/// Time recorded after the impact, s: the hammer is checked by then.
const AFTER_S: f64 = 0.15;

/// One built-in touch: a hand whose level is a hammer speed ([`erard::level`]), found on this instrument.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Timing {
    /// Level: `pp`, `p`, `mf`, `f`, `ff`.
    pub nuance: &'static str,
    /// Pressed or struck.
    pub touch: Touch,
    /// Largest force on the key, N.
    pub peak_force_n: f64,
    /// Events of the run.
    pub events: Events,
    /// Flight of the hammer.
    pub flights: Option<Flights>,
    /// Reasons why the run cannot be trusted.
    pub warnings: Vec<Warning>,
}

impl Timing {
    /// Name of the touch: `pressed` or `struck`.
    #[must_use]
    pub(crate) fn touch_name(&self) -> &'static str {
        match self.touch {
            Touch::Pressed => "pressed",
            Touch::Struck => "struck",
        }
    }

    /// Time from key start to an event, s.
    #[must_use]
    pub(crate) fn since_key_start(&self, event: Option<f64>) -> Option<f64> {
        Some(event? - self.events.key_start_s?)
    }

    /// Time from the impact to key bottom, s; negative if the key is down first.
    #[must_use]
    pub(crate) fn hammer_before_bottom_s(&self) -> Option<f64> {
        Some(self.events.key_bottom_s? - self.events.hammer_contact_s()?)
    }
}

/// Plays all built-in touches, pressed ones first. A level out of reach on this instrument is left out.
///
/// # Errors
/// See [`MeasureError`].
pub(crate) fn timing(action: &dyn AtRest, progress: &mut Progress<'_>) -> Result<Vec<Timing>, MeasureError> {
    let failed = |error: LevelError| -> Result<(), MeasureError> {
        match error {
            LevelError::Interrupted => Err(SimulationError::Interrupted.into()),
            LevelError::Action(error) => Err(SimulationError::from(error).into()),
            _ => Ok(()),
        }
    };
    let mut sheet = Vec::new();
    let rest = action.pose(progress)?;
    let mut reference = match Reference::at_rest(&rest) {
        Ok(reference) => reference,
        Err(error) => return failed(error).map(|()| sheet),
    };
    for touch in [Touch::Pressed, Touch::Struck] {
        for (nuance, speed_m_per_s) in LEVELS {
            let solved = match reference.solve(HandKind::new(touch, MASS_KG), speed_m_per_s, &mut |_| progress(0.0)) {
                Ok(solved) => solved,
                Err(error) => {
                    failed(error)?;
                    continue;
                }
            };
            let hand = solved.held();
            let setup = Setup {
                hand: Some(hand.hand),
                settings: Settings::new(STEP_S),
                record_every: Some(1),
                ..Setup::new(solved.impact.time_s + AFTER_S)
            };
            let run = simulate_at_rest(&rest, &|t| hand.input(t), &setup, &mut |_| progress(0.0))?;
            sheet.push(Timing {
                nuance,
                touch,
                peak_force_n: run.peak_force_n,
                flights: flights(&run.time_s, &run.hammer_rise_m, &run.events),
                events: run.events,
                warnings: run.warnings,
            });
        }
    }
    Ok(sheet)
}

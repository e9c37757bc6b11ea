//! The force on the bridge as sound. It is not the sound of a piano: there is no soundboard and no room.

use moreau::Settings;

use super::setup::{Setup, SimulationError};
use super::simulation::simulate_observed;
use crate::instrument::Instrument;
use crate::mechanism::Mechanism;
use crate::player::{Drive, Observer};
use crate::progress::Progress;
use crate::strings::Strings;

/// Samples per second of a [`Sound`].
pub const RATE_HZ: u32 = 48_000;
/// Steps per sample. The strings have no partials above 20 kHz, so that taking every other step folds nothing back.
pub(crate) const STEPS_PER_SAMPLE: u64 = 2;

/// The force of a note's strings on the bridge.
#[derive(Debug, Clone, Default)]
pub struct Sound {
    /// Force, N, [`RATE_HZ`] samples a second, from the stroke's start, without the initial static load.
    pub bridge_n: Vec<f64>,
}

impl Sound {
    /// The largest force, N, either way.
    #[must_use]
    pub fn peak_n(&self) -> f64 {
        self.bridge_n.iter().fold(0.0, |peak: f64, n| peak.max(n.abs()))
    }
}

struct Microphone {
    sound: Sound,
    /// Static load on the strings at rest, which is inaudible.
    rest_n: f64,
    steps: u64,
}

impl Observer for Microphone {
    fn begin(&mut self, _: f64, mechanism: &dyn Mechanism) {
        self.rest_n = Strings::under(mechanism).map_or(0.0, Strings::bridge_n);
    }

    fn step(&mut self, _: f64, _: bool, mechanism: &dyn Mechanism) {
        self.steps += 1;
        if self.steps.is_multiple_of(STEPS_PER_SAMPLE) {
            self.sound.bridge_n.push(Strings::under(mechanism).map_or(0.0, Strings::bridge_n) - self.rest_n);
        }
    }
}

/// Plays a stroke in steps of 1/96000 s, whatever its other settings, and records the force on the bridge. `None` where
/// the string is rigid.
///
/// # Errors
/// As [`crate::run::simulate`].
pub fn sound(
    instrument: &Instrument,
    drive: &Drive<'_>,
    setup: &Setup,
    progress: &mut Progress<'_>,
) -> Result<Option<Sound>, SimulationError> {
    if !instrument.has_yielding_strings() {
        return Ok(None);
    }
    let step = 1.0 / (f64::from(RATE_HZ) * STEPS_PER_SAMPLE as f64);
    let settings = Settings { step, ..setup.settings };
    let steps = (setup.duration_s / step) as u64;
    // A row is kept of the end only.
    let setup = Setup { settings, record_every: Some(steps.max(1)), tolerance: None, ledger: false, ..*setup };
    let mut microphone = Microphone { sound: Sound::default(), rest_n: 0.0, steps: 0 };
    simulate_observed(instrument, drive, &setup, &mut microphone, progress)?;
    Ok(Some(microphone.sound))
}

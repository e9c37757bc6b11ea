//! Notes as sound: the pressure before the board, or the force on a bridge that does not move. There is no room.

use moreau::Settings;

use super::setup::{Setup, SimulationError};
use super::simulation::simulate_observed;
use crate::instrument::Instrument;
use crate::knocks::{KeyBed, Knock, Knocks};
use crate::mechanism::Mechanism;
use crate::player::{Drive, Observer};
use crate::progress::Progress;
use crate::strings::Strings;

/// Samples per second of a [`Sound`].
pub const RATE_HZ: u32 = 48_000;
/// Steps per sample. The strings have no partials above 20 kHz, so that taking every other step folds nothing back.
pub(crate) const STEPS_PER_SAMPLE: u64 = 2;

/// A sample that has gone so far has ended: the rest of it is rounding.
const WHOLE: f64 = 0.999;

/// What is heard of strings.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub enum Heard {
    /// Their force on a bridge that does not move, N, the same on both channels.
    #[default]
    BridgeForce,
    /// The pressure at two places before the soundboard, Pa ([`Strings::pressure_pa`]).
    Pressure,
}

impl Heard {
    /// What is heard of instruments together: the pressure, if some have strings, all of which move a board.
    #[must_use]
    pub fn of(instruments: &[Instrument]) -> Self {
        let mut strung = instruments.iter().filter(|instrument| instrument.has_yielding_strings()).peekable();
        let is_strung = strung.peek().is_some();
        match is_strung && strung.all(|own| !own.roles.rigid_bridge && !own.bridge_modes.is_empty()) {
            true => Heard::Pressure,
            false => Heard::BridgeForce,
        }
    }

    /// Unit of its numbers.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Heard::BridgeForce => "N",
            Heard::Pressure => "Pa",
        }
    }

    /// What is heard now, on two channels. A static load is part of a force.
    #[must_use]
    pub fn now(self, strings: &Strings) -> [f64; 2] {
        match self {
            Heard::BridgeForce => [strings.bridge_n(); 2],
            Heard::Pressure => strings.pressure_pa().unwrap_or_default(),
        }
    }
}

/// A note as sound, [`RATE_HZ`] samples a second, from the stroke's start.
#[derive(Debug, Clone, Default)]
pub struct Sound {
    /// What the samples are.
    pub heard: Heard,
    /// Samples of two channels, N without the initial static load, or Pa.
    pub samples: Vec<[f64; 2]>,
    /// Force of the strings on the bridge, N, without the initial static load.
    pub bridge_n: Vec<f64>,
}

impl Sound {
    /// The largest sample, N or Pa, either way.
    #[must_use]
    pub fn peak(&self) -> f64 {
        self.samples.iter().flatten().fold(0.0, |peak: f64, n| peak.max(n.abs()))
    }
}

struct Microphone {
    sound: Sound,
    knocks: Knocks,
    bed: KeyBed,
    /// Static load on the strings at rest, which is inaudible.
    rest_n: f64,
    began_s: f64,
}

impl Observer for Microphone {
    fn begin(&mut self, time_s: f64, mechanism: &dyn Mechanism) {
        self.began_s = time_s;
        self.rest_n = Strings::under(mechanism).map_or(0.0, Strings::bridge_n);
    }

    /// Near strings a step is taken in parts, and this is called after each: what counts is the time.
    fn step(&mut self, time_s: f64, _: bool, mechanism: &dyn Mechanism) {
        let samples = (time_s - self.began_s) * f64::from(RATE_HZ);
        if samples > self.sound.samples.len() as f64 + WHOLE
            && let Some(strings) = Strings::under(mechanism)
        {
            let bridge_n = strings.bridge_n() - self.rest_n;
            self.sound.bridge_n.push(bridge_n);
            self.sound.samples.push(match self.sound.heard {
                Heard::BridgeForce => [bridge_n; 2],
                heard => {
                    let knocks_n = self.knocks.force_n(|zone| mechanism.normal_force(zone));
                    let [strings, knocks] = [heard.now(strings), self.bed.hear(knocks_n)];
                    [strings[0] + knocks[0], strings[1] + knocks[1]]
                }
            });
        }
    }
}

/// Plays a stroke in steps of 1/96000 s, whatever its other settings, and records it as sound, before a soundboard with
/// these knocks. `None` where the string is rigid.
///
/// # Errors
/// As [`crate::run::simulate`].
pub fn sound(
    instrument: &Instrument,
    drive: &Drive<'_>,
    setup: &Setup,
    knocks: &[Knock],
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
    let sound = Sound { heard: Heard::of(std::slice::from_ref(instrument)), ..Sound::default() };
    let (knocks, bed) = (Knocks::of(instrument, knocks), KeyBed::new(f64::from(RATE_HZ)));
    let mut microphone = Microphone { sound, knocks, bed, rest_n: 0.0, began_s: 0.0 };
    simulate_observed(instrument, drive, &setup, &mut microphone, progress)?;
    Ok(Some(microphone.sound))
}

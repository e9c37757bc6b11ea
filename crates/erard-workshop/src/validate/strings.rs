//! Hammer and strings over the compass: contact time, largest force, return speed, inharmonicity.

use super::presses::{FF_M_PER_S, MF_M_PER_S, PP_M_PER_S};
use crate::first_impact::{FirstImpact, STEP_S, Stopped, action_at_rest, first_impact_of_speed};
use crate::measure::MeasureError;
use erard::Progress;
use erard::instrument::Instrument;
use erard::keyboard::Keyboard;
use erard::run::SimulationError;
use erard::strings::Strings;
use erard::{Action, Input};

/// Keys other than the instrument, which is middle C: A0, C6, C8.
const A0: usize = 1;
const C6: usize = 64;
const C8: usize = 88;
/// Number of searches for impacts, and about how many tries each takes.
const SEARCHES: f64 = 5.0;
const TRIES: f64 = 11.0;
/// Cents of the second partial per B: 1200/ln 2 times B n^2/2.
const CENTS_PER_B: f64 = 1200.0 / std::f64::consts::LN_2 * 0.5 * 4.0;

/// Names for rows; each ends with its unit.
pub(super) const NAMES: [&str; 15] = [
    "contact_a0_mf_ms",
    "contact_c8_mf_ms",
    "peak_a0_mf_N",
    "peak_c4_mf_N",
    "peak_c8_mf_N",
    "return_c4_pp",
    "return_c4_mf",
    "return_c4_ff",
    "second_partial_c4_cents",
    "second_partial_c6_cents",
    "second_partial_c8_cents",
    "contact_c4_ff_over_mf",
    "t60_a0_s",
    "t60_c4_s",
    "t60_c6_s",
];

/// Whether a rigid string also has this value: its felt represents hammer felt and string of middle C. The felts of
/// other keys are not graded for that, and a rigid string has no partials.
fn asks_no_string(name: &str) -> bool {
    name.starts_with("peak_c4") || name.starts_with("return_c4")
}

/// Reason why a row on strings is skipped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Skipped {
    /// The instrument's string is rigid.
    RigidString,
    /// The row is about another key, and no keyboard is known.
    NoKeyboard,
}

impl Skipped {
    /// Describes the reason in words.
    #[must_use]
    pub fn reason(self) -> &'static str {
        match self {
            Skipped::RigidString => "not modelled: the instrument's string is rigid",
            Skipped::NoKeyboard => {
                "not modelled: the row is for another key, and the instrument comes from no keyboard"
            }
        }
    }
}

/// Results; `None` if an event did not happen.
#[derive(Debug, Clone, Default)]
struct Found {
    c4: [Option<FirstImpact>; 3],
    a0: Option<FirstImpact>,
    c8: Option<FirstImpact>,
    /// Sharpness of the second partial of C4, C6, C8, cents.
    cents: [Option<f64>; 3],
    /// Decay times of A0, C4, C6 under their dampers, s.
    t60_s: [Option<f64>; 3],
}

/// Values of the rows on strings for one instrument.
#[derive(Debug, Clone)]
pub(super) struct Strung {
    found: Found,
    yields: bool,
    keyboard: bool,
}

impl Strung {
    /// Simulates the rows: middle C on the instrument, other keys on its keyboard.
    pub(crate) fn measure(
        instrument: &Instrument,
        keyboard: Option<&Keyboard>,
        progress: &mut Progress<'_>,
    ) -> Result<Self, MeasureError> {
        let yields = instrument.has_yielding_strings();
        let mut done = 0.0;
        let mut going = |_: f64| {
            done += 1.0 / (SEARCHES * TRIES);
            progress(f64::min(done, 1.0))
        };
        let mut play = |one: &Instrument, speed_m_per_s: f64| -> Result<Option<FirstImpact>, MeasureError> {
            let mut action = action_at_rest(one)?;
            first_impact_of_speed(&mut action, speed_m_per_s, &mut going)
                .map_err(|Stopped| SimulationError::Interrupted.into())
        };
        let mut found = Found::default();
        for (impact, speed_m_per_s) in found.c4.iter_mut().zip([PP_M_PER_S, MF_M_PER_S, FF_M_PER_S]) {
            *impact = play(instrument, speed_m_per_s)?;
        }
        if yields {
            found.cents[0] = cents(instrument);
            found.t60_s[1] = t60_s(instrument)?;
        }
        if let Some(keyboard) = keyboard.filter(|_| yields) {
            let key = |key: usize| keyboard.key(key).ok().filter(Instrument::has_yielding_strings);
            if let Some(one) = key(A0) {
                found.a0 = play(&one, MF_M_PER_S)?;
                found.t60_s[0] = t60_s(&one)?;
            }
            if let Some(one) = key(C8) {
                found.c8 = play(&one, MF_M_PER_S)?;
            }
            if let Some(one) = key(C6) {
                found.t60_s[2] = t60_s(&one)?;
            }
            for (found, key) in found.cents[1..].iter_mut().zip([C6, C8].map(key)) {
                *found = key.as_ref().and_then(cents);
            }
        }
        Ok(Strung { found, yields, keyboard: keyboard.is_some() })
    }

    /// Value of one of [`NAMES`], in the unit that ends it, or why it is skipped; `None` for another name.
    pub(crate) fn value(&self, name: &str) -> Option<Result<Option<f64>, Skipped>> {
        if !NAMES.contains(&name) {
            return None;
        }
        if !self.yields && !asks_no_string(name) {
            return Some(Err(Skipped::RigidString));
        }
        if !self.keyboard && !name.contains("_c4") {
            return Some(Err(Skipped::NoKeyboard));
        }
        let contact = |impact: &Option<FirstImpact>| impact.map(|impact| 1e3 * impact.contact_s);
        let peak = |impact: &Option<FirstImpact>| impact.map(|impact| impact.peak_n);
        let back = |impact: &Option<FirstImpact>| impact.map(|impact| impact.back_m_per_s / impact.speed_m_per_s);
        let found = &self.found;
        let [pp, mf, ff] = &found.c4;
        Some(Ok(match name {
            "contact_a0_mf_ms" => contact(&found.a0),
            "contact_c8_mf_ms" => contact(&found.c8),
            "peak_a0_mf_N" => peak(&found.a0),
            "peak_c4_mf_N" => peak(mf),
            "peak_c8_mf_N" => peak(&found.c8),
            "return_c4_pp" => back(pp),
            "return_c4_mf" => back(mf),
            "return_c4_ff" => back(ff),
            "second_partial_c4_cents" => found.cents[0],
            "second_partial_c6_cents" => found.cents[1],
            "contact_c4_ff_over_mf" => contact(ff).zip(contact(mf)).map(|(ff, mf)| ff / mf),
            "t60_a0_s" => found.t60_s[0],
            "t60_c4_s" => found.t60_s[1],
            "t60_c6_s" => found.t60_s[2],
            _ => found.cents[2],
        }))
    }
}

/// Second partial of the note's last string above twice its ideal fundamental, cents.
fn cents(instrument: &Instrument) -> Option<f64> {
    instrument.strings.last().map(|string| CENTS_PER_B * string.inharmonicity())
}

/// A note under its damper: force of its stroke, N, time held, s, and time after the release at which the damper is
/// taken to lie still, s.
const STRUCK_N: f64 = 5.0;
const HELD_S: f64 = 0.3;
const LIES_S: f64 = 0.1;
/// Averaging time of levels, s; level of the fall, dB, and longest wait for it, s.
const WINDOW_S: f64 = 20e-3;
const FALL_DB: f64 = 20.0;
const PATIENCE_S: f64 = 2.0;

/// Time in which the force on the bridge falls by 60 dB under the damper, from its rate over the first 20 dB or two
/// seconds, s; `None` without a damper or a fall.
fn t60_s(instrument: &Instrument) -> Result<Option<f64>, MeasureError> {
    if instrument.strings.iter().all(|string| string.damper.is_none()) {
        return Ok(None);
    }
    let mut action = action_at_rest(instrument)?;
    let steps = |seconds: f64| (seconds / STEP_S).round() as usize;
    for (input, seconds) in [(Input::Force(STRUCK_N), HELD_S), (Input::Free, LIES_S)] {
        for _ in 0..steps(seconds) {
            action.step(input);
        }
    }
    let from_db = level_db(&mut action);
    let mut time_s = 0.0;
    loop {
        time_s += WINDOW_S;
        let fallen_db = from_db - level_db(&mut action);
        if fallen_db >= FALL_DB || time_s >= PATIENCE_S {
            return Ok((fallen_db > 0.0).then(|| 60.0 * time_s / fallen_db));
        }
    }
}

/// Level of the changing part of the force on the bridge over one window, dB.
fn level_db(action: &mut Action) -> f64 {
    let steps = (WINDOW_S / STEP_S) as usize;
    let (mut squares, mut sum) = (0.0, 0.0);
    for _ in 0..steps {
        action.step(Input::Free);
        let n = action.strings().map_or(0.0, Strings::bridge_n);
        (squares, sum) = (squares + n * n, sum + n);
    }
    let mean = sum / steps as f64;
    10.0 * (squares / steps as f64 - mean * mean).max(1e-30).log10()
}

//! A key of a keyboard with strings under a constant force: its hammer's first impact.

use moreau::Settings;

use erard::Progress;
use erard::instrument::Instrument;
use erard::player::ActionError;
use erard::{Action, Input};

/// Steps, s.
pub const STEP_S: f64 = 50e-6;
/// How far the hammer's force is followed after it met the string, s.
const FOLLOWED_S: f64 = 10e-3;
/// A key that has not sounded after this time does not, s.
const PATIENCE_S: f64 = 0.5;
/// Forces of published playing, N.
const FORCES_N: [f64; 2] = [0.3, 35.0];
/// A force is found when it is known to this share.
const CLOSE: f64 = 5e-3;

/// The first impact of a hammer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstImpact {
    /// Speed of the hammer when it meets the string, m/s.
    pub speed_m_per_s: f64,
    /// Duration of contact, s: from the first touch to the last one within 10 ms, including short separations by
    /// returning waves.
    pub contact_s: f64,
    /// Number of contact pulses.
    pub pulses: u32,
    /// The largest force, N.
    pub peak_n: f64,
    /// Speed at which it leaves, m/s, positive away from the string.
    pub back_m_per_s: f64,
}

/// An action at rest.
pub fn rest(instrument: &Instrument) -> Result<Action, ActionError> {
    Action::with(instrument, Settings::new(STEP_S))
}

/// The first impact under a constant force, from rest; `None`: it does not sound.
pub fn impact(action: &mut Action, force_n: f64) -> Option<FirstImpact> {
    let (mut first, mut impact, mut touching) = (None, None, false);
    for n in 0..((PATIENCE_S + FOLLOWED_S) / STEP_S) as usize {
        let reading = action.step(Input::Force(force_n));
        if let (Some(strike), None) = (action.impact(), first) {
            first = Some(n);
            impact = Some(FirstImpact {
                speed_m_per_s: strike.hammer_speed_m_per_s,
                contact_s: 0.0,
                pulses: 0,
                peak_n: 0.0,
                back_m_per_s: 0.0,
            });
        }
        let (Some(since), Some(impact)) = (first, &mut impact) else {
            if n as f64 * STEP_S > PATIENCE_S {
                break;
            }
            continue;
        };
        if (n - since) as f64 * STEP_S > FOLLOWED_S {
            break;
        }
        if reading.string_n > 0.0 {
            impact.pulses += u32::from(!touching);
            (impact.contact_s, impact.back_m_per_s) = ((n - since + 1) as f64 * STEP_S, -reading.hammer_m_per_s);
            impact.peak_n = impact.peak_n.max(reading.string_n);
        }
        touching = reading.string_n > 0.0;
    }
    impact
}

/// The impact under the smallest constant force with which the hammer is so fast, m/s, by bisection; `None` where none
/// is. `progress` ends it by returning false.
pub(crate) fn impact_of_speed(
    action: &mut Action,
    speed_m_per_s: f64,
    progress: &mut Progress<'_>,
) -> Result<Option<FirstImpact>, Stopped> {
    let still = action.save();
    let mut fast_enough = |force_n: f64| -> Result<Option<FirstImpact>, Stopped> {
        if !progress(0.0) {
            return Err(Stopped);
        }
        action.restore(&still).expect("it is the action's own");
        Ok(impact(action, force_n).filter(|impact| impact.speed_m_per_s >= speed_m_per_s))
    };
    let [mut low, mut high] = FORCES_N;
    let Some(mut found) = fast_enough(high)? else { return Ok(None) };
    while high / low > 1.0 + CLOSE {
        let middle = (low * high).sqrt();
        match fast_enough(middle)? {
            Some(impact) => (high, found) = (middle, impact),
            None => low = middle,
        }
    }
    Ok(Some(found))
}

/// Somebody asked to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stopped;

//! First impact of the hammer of a key with strings, under a constant force.

use moreau::Settings;

use erard::Progress;
use erard::instrument::Instrument;
use erard::player::ActionError;
use erard::{Action, Input};

/// Step, s.
pub const STEP_S: f64 = 50e-6;
/// Time after the impact over which the hammer's force is recorded, s.
const FOLLOWED_S: f64 = 10e-3;
/// A key that has not sounded within this time does not sound, s.
const PATIENCE_S: f64 = 0.5;
/// Range of forces in published playing, N.
const FORCES_N: [f64; 2] = [0.3, 35.0];
/// Relative tolerance of a force found by bisection.
const CLOSE: f64 = 5e-3;

/// The first impact of a hammer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FirstImpact {
    /// Hammer speed at the string, m/s.
    pub speed_m_per_s: f64,
    /// Contact time, s: from the first touch to the last one within 10 ms, including short separations caused by
    /// returning waves.
    pub contact_s: f64,
    /// Number of contact pulses.
    pub pulses: u32,
    /// The largest force, N.
    pub peak_n: f64,
    /// Hammer speed after the last contact, m/s, positive away from the string.
    pub back_m_per_s: f64,
}

/// Returns an action at rest.
pub fn action_at_rest(instrument: &Instrument) -> Result<Action, ActionError> {
    Action::with(instrument, Settings::new(STEP_S))
}

/// Returns the first impact under a constant force, from rest; `None` if the key does not sound.
pub fn first_impact(action: &mut Action, force_n: f64) -> Option<FirstImpact> {
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
            (impact.contact_s, impact.back_m_per_s) = ((n - since + 1) as f64 * STEP_S, -reading.hammer_rise_m_per_s);
            impact.peak_n = impact.peak_n.max(reading.string_n);
        }
        touching = reading.string_n > 0.0;
    }
    impact
}

/// Returns the impact under the smallest constant force that reaches this hammer speed, m/s, by bisection; `None` if
/// none does. `progress` ends it by returning false.
pub(crate) fn first_impact_of_speed(
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
        Ok(first_impact(action, force_n).filter(|impact| impact.speed_m_per_s >= speed_m_per_s))
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

/// The caller asked to stop.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Stopped;

//! The height at which a key, coming up, sets its damper down.

use moreau::Settings;

use crate::grand::{Anatomy, AnatomyError};
use crate::instrument::Instrument;
use crate::player::{Action, ActionError, Input};
use crate::stroke::least_jerk;

/// Height of note-offs on a keyboard without dampers, m: the middle of a usual dip.
pub const USUAL_HEIGHT_M: f64 = 5e-3;
/// Depth to which the key is pressed, m: every damper of a grand is up by then, and no let-off has begun.
const DEPTH_M: f64 = 8e-3;
/// Duration of this press, s: too slow to throw the hammer to its string.
const DOWN_S: f64 = 0.3;
/// Speed at which the key comes up again, m/s: a twentieth of that of a released key, so that the damper follows it.
const UP_M_PER_S: f64 = 0.01;
/// The damper counts as set down when it presses with this share of its force at rest.
const SHARE: f64 = 0.01;

/// Why the height cannot be found.
#[derive(Debug, Clone, thiserror::Error)]
pub enum DamperError {
    /// The instrument is not a grand action.
    #[error(transparent)]
    Anatomy(#[from] AnatomyError),
    /// The instrument cannot be played.
    #[error(transparent)]
    Action(#[from] ActionError),
}

/// Travel of the key's front, m below its rest, at which the key, coming up slowly with the pedal up, sets its damper
/// down: where a note-off belongs. `None` where the key lifts no damper.
///
/// The key is driven down until the damper is up, and then up at 10 mm/s; the height is where the damper's first felt
/// presses again. The string is rigid meanwhile.
///
/// # Errors
/// See [`DamperError`].
pub fn damper_height_m(instrument: &Instrument) -> Result<Option<f64>, DamperError> {
    let Some(damper) = Anatomy::find(instrument)?.damper else { return Ok(None) };
    let silent = instrument.with_rigid_string();
    let lies_on: Vec<usize> = silent
        .zones
        .iter()
        .enumerate()
        .filter(|(index, zone)| {
            let sides = [zone.disc_body, zone.curve_body];
            sides.contains(&Some(damper)) && sides.contains(&None) && silent.roles.pedal != Some(*index)
        })
        .map(|(index, _)| index)
        .collect();
    let mut action = Action::with(&silent, Settings::new(silent.usual_step_s()))?;
    let presses = |action: &Action| lies_on.iter().map(|&zone| action.contact_force(zone)).sum::<f64>();
    let h = action.settings().step;
    action.step(Input::Free);
    let at_rest_n = presses(&action);
    let mut steps = 0_u32;
    let mut lead = |action: &mut Action, at: &dyn Fn(f64) -> [f64; 2]| {
        steps += 1;
        let [position_m, velocity_m_per_s] = at(f64::from(steps) * h);
        action.step(Input::Rigid { position_m, velocity_m_per_s }).key_m
    };
    for _ in 0..(DOWN_S / h) as u32 {
        lead(&mut action, &|t| {
            let [x, v] = least_jerk(t / DOWN_S);
            [DEPTH_M * x, DEPTH_M * v / DOWN_S]
        });
    }
    if at_rest_n <= 0.0 || presses(&action) > 0.0 {
        return Ok(None);
    }
    let mut before_m = DEPTH_M;
    for _ in 0..(DEPTH_M / UP_M_PER_S / h) as u32 {
        let now_m = lead(&mut action, &|t| [DEPTH_M - UP_M_PER_S * (t - DOWN_S), -UP_M_PER_S]);
        if presses(&action) > SHARE * at_rest_n {
            return Ok(Some(0.5 * (before_m + now_m)));
        }
        before_m = now_m;
    }
    Ok(None)
}

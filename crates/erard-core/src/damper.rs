//! The height at which a key, coming up, sets its damper down.

use std::sync::OnceLock;

use moreau::Settings;

use crate::grand::{Anatomy, AnatomyError};
use crate::index::IndexError;
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
#[non_exhaustive]
pub enum DamperError {
    /// The instrument is not a grand action.
    #[error(transparent)]
    Anatomy(#[from] AnatomyError),
    /// The instrument cannot be played.
    #[error(transparent)]
    Action(#[from] ActionError),
    /// There is no such key.
    #[error(transparent)]
    Key(#[from] IndexError),
}

/// Where a key of a keyboard sets its damper down cannot be found.
#[derive(Debug, Clone, thiserror::Error)]
#[error("key {key}: {error}")]
pub struct KeyDamperError {
    /// Number of the key, from 1.
    pub key: usize,
    /// Reason.
    pub error: DamperError,
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
    let presses = |action: &Action| lies_on.iter().map(|&zone| action.mechanism().normal_force(zone)).sum::<f64>();
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

/// Heights at which the keys of a keyboard set their dampers down. Each is simulated at most once, when it is first
/// needed; threads may share it.
#[derive(Debug)]
pub struct DamperHeights<'a> {
    instruments: &'a [Instrument],
    found: Vec<OnceLock<Result<Option<f64>, DamperError>>>,
}

impl<'a> DamperHeights<'a> {
    /// Of these instruments, one for each key from the lowest. Nothing is simulated yet.
    #[must_use]
    pub fn new(instruments: &'a [Instrument]) -> Self {
        DamperHeights { instruments, found: instruments.iter().map(|_| OnceLock::new()).collect() }
    }

    /// Returns the height of a key, from 1, m ([`damper_height_m`]). A key without a damper takes that of the next
    /// lower key with one; below all dampers it is [`USUAL_HEIGHT_M`].
    ///
    /// # Errors
    /// See [`KeyDamperError`].
    pub fn of(&self, key: usize) -> Result<f64, KeyDamperError> {
        IndexError::key(key, self.instruments.len()).map_err(|error| KeyDamperError { key, error: error.into() })?;
        for below in (1..=key).rev() {
            let found = self.found[below - 1].get_or_init(|| damper_height_m(&self.instruments[below - 1]));
            if let Some(height_m) = found.clone().map_err(|error| KeyDamperError { key: below, error })? {
                return Ok(height_m);
            }
        }
        Ok(USUAL_HEIGHT_M)
    }
}

//! A finger that follows a path, on one key.

use std::sync::{Mutex, PoisonError};

use erard::instrument::Instrument;
use erard::{Action, Input, Progress, Settings, StepOutcome};
use erard_live::finger::{FINGER, Leg, place};
use erard_midi::{Crossing, Event, KeyNotes};

use super::sensor::Sampler;
use super::truth::Strike;
use crate::error::PerformError;

/// Rise of the key below which a second impact counts as a bounce of the hammer, m.
const BOUNCED_M: f64 = 1e-3;
/// A finger this high above the key's rest is away from the key, m.
const AWAY_M: f64 = 4e-3;
/// Number of steps between questions to the caller whether to go on.
const ASK_EVERY: u64 = 512;

/// Drives a finger along a path on an action at rest, whose hammer rests so far above that of the sensors' action, m.
/// It begins at an instant, s, and goes on for a while after the path's end, s. Returns the strikes of the window and
/// its end, s.
pub(super) fn play(
    (instrument, lifted_m): (&Instrument, f64),
    [begins_s, tail_s]: [f64; 2],
    path: &[Leg],
    (key, window, damper_m): (usize, usize, f64),
    sampler: &Mutex<Sampler>,
    progress: &mut Progress<'_>,
) -> Result<(Vec<Strike>, f64), PerformError> {
    let action = Action::with(instrument, Settings::new(instrument.usual_step_s()));
    let mut action = action.map_err(|error| PerformError::Action { key, error })?;
    let Settings { step: h, theta, .. } = *action.settings();
    let lasts_s = path.iter().map(|[s, _]| s).sum::<f64>() + tail_s;
    let mut sampler = sampler.lock().unwrap_or_else(PoisonError::into_inner);
    let mut notes = KeyNotes::new(Crossing { damper_m });
    let mut strikes: Vec<Strike> = Vec::new();
    let (mut deepest_m, mut risen_m) = (0.0_f64, 0.0_f64);
    action.place_hand(0.0, 0.0);
    for n in 0..(lasts_s / h).ceil() as u64 {
        if n.is_multiple_of(ASK_EVERY) && !progress(0.0) {
            return Err(PerformError::interrupted());
        }
        let [position_m, velocity_m_per_s] = place(0.0, path, (n as f64 + theta) * h);
        let is_away = position_m < -AWAY_M;
        let input =
            if is_away { Input::Free } else { FINGER.input(&Input::Motion { position_m, velocity_m_per_s })? };
        let reading = action.step(input);
        let now_s = begins_s + (n + 1) as f64 * h;
        if reading.outcome == StepOutcome::NonFinite {
            return Err(PerformError::NotFinite { time_s: now_s });
        }
        sampler.take(now_s, [reading.key_m, lifted_m + reading.hammer_rise_m]);
        deepest_m = deepest_m.max(reading.key_m);
        risen_m = risen_m.max(deepest_m - reading.key_m);
        let hit = reading.impact.map(|hit| [now_s + (hit.time_s - action.time_s()), hit.hammer_speed_m_per_s]);
        for event in notes.update(now_s, reading.key_m, hit).into_iter().flatten() {
            match event {
                Event::On { time_s, hammer_speed_m_per_s } => {
                    let again = !strikes.is_empty() && risen_m < BOUNCED_M;
                    strikes.push(Strike { key, window, time_s, hammer_speed_m_per_s, again, released: None });
                    (deepest_m, risen_m) = (reading.key_m, 0.0);
                }
                Event::Off { time_s, release_m_per_s } => {
                    // The last stroke's note ends, bounces or not.
                    if let Some(last) = strikes.iter_mut().rev().find(|strike| !strike.again) {
                        last.released = last.released.or(release_m_per_s.map(|m_per_s| [time_s, m_per_s]));
                    }
                }
            }
        }
    }
    Ok((strikes, begins_s + lasts_s))
}

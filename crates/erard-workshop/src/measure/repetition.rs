//! Rate of repetition of a note.
//!
//! A finger presses the key with a constant force until it reaches its punching, stays there for a moment, and lifts
//! off; weights and springs alone return the key. When it is up, at its rest (fully released) or at half its dip, the
//! finger waits for a moment or not at all, and presses again. Shorter stays and waits give a higher rate; the rate of
//! repetition is the highest at which every stroke still sounds once and no more softly than the softest published
//! playing. It is therefore the action's own rate, not that of a prescribed motion.
//!
//! Reason for the wait: a jack thrown back under the knuckle by its spring bounces off its rest, and is still moving
//! when a light treble key is home. Pressed at once it meets the knuckle beside its edge and is kicked out to the end
//! of its window, and the hammer, caught on its way by the check, does not sound, however long the finger stayed below.
//! Some ten milliseconds later it is at rest.

use moreau::Settings;

use super::{MeasureError, NotAnAction};
use erard::Progress;
use erard::mechanism::Impact;
use erard::player::{Action, AtRest, Input};

/// Step, s.
const STEP_S: f64 = 50e-6;
/// The finger's force, N: a forte.
pub(crate) const PRESS_N: f64 = 8.0;
/// Strokes of a trial; the first one starts from rest and does not count.
const STROKES: usize = 9;
/// Softest impact that counts, m/s: published hammer speeds begin at 0.5 m/s (pp).
const SPEAKS_M_PER_S: f64 = 0.5;
/// Step of the finger's stay below plus wait above, s, and number of steps tried from 0.
const STAY_STEP_S: f64 = 2e-3;
const STAYS: usize = 100;
/// Waits above, in these steps.
const WAITS: [usize; 4] = [0, 3, 6, 9];
/// Number of neighbouring stays that must all hold; the slowest of them counts, because no finger keeps time to a step,
/// and a rate reached by only one of them is luck.
const NEIGHBOURS: usize = 3;
/// A stroke that takes longer is stuck, s.
const PATIENCE_S: f64 = 1.0;

/// The fastest reliable rate, with its times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repetition {
    /// Strokes per second.
    pub rate_hz: f64,
    /// Time that the finger stays on the bottom, s. With `wait_s`, the shortest times with which every stroke sounds.
    pub stay_s: f64,
    /// Time that the finger waits above, s.
    pub wait_s: f64,
    /// Time from the bottom until the key is up, s.
    pub return_s: f64,
    /// The softest of the impacts, m/s.
    pub softest_m_per_s: f64,
}

/// Finds the fastest rate at which every stroke sounds; `None` if none does. `up_m`: the finger presses again when the
/// key has come up to this travel below its rest.
///
/// # Errors
/// See [`MeasureError`].
pub fn repetition(
    action: &dyn AtRest,
    up_m: f64,
    progress: &mut Progress<'_>,
) -> Result<Option<Repetition>, MeasureError> {
    let Some(bottom) = action.instrument().roles.key_bottom else {
        return Err(NotAnAction::NoKeyBottom.into());
    };
    let mut action = action.pose(progress)?.action(Settings::new(STEP_S))?;
    let rest = action.save();
    let mut neighbours: [Vec<Repetition>; WAITS.len()] = Default::default();
    for n in 0..STAYS {
        let mut best: Option<Repetition> = None;
        for (wait, neighbours) in WAITS.iter().zip(&mut neighbours) {
            let Some(stay) = n.checked_sub(*wait) else { continue };
            // The snapshot is this action's own.
            let _ = action.restore(&rest);
            let times_s = [stay, *wait].map(|n| n as f64 * STAY_STEP_S);
            match held(&mut action, bottom, up_m, times_s, progress)? {
                Some(repetition) => neighbours.push(repetition),
                None => neighbours.clear(),
            }
            if neighbours.len() == NEIGHBOURS {
                let slowest = neighbours.drain(..).min_by(|a, b| a.rate_hz.total_cmp(&b.rate_hz));
                best = [best, slowest].into_iter().flatten().max_by(|a, b| a.rate_hz.total_cmp(&b.rate_hz));
            }
        }
        if best.is_some() {
            return Ok(best);
        }
    }
    Ok(None)
}

/// Action of the finger, with its start, s.
#[derive(Debug, Clone, Copy)]
enum Finger {
    Presses(f64),
    Stays(f64),
    IsOff(f64),
    Waits(f64),
}

/// Hammer speed of a stroke from one press to the next, s, if it sounds once and loud enough, m/s.
fn sounds([from_s, to_s]: [f64; 2], impacts: &[Impact]) -> Option<f64> {
    let mut own = impacts.iter().filter(|impact| (from_s..to_s).contains(&impact.time_s));
    let speed = own.next()?.hammer_speed_m_per_s;
    (own.next().is_none() && speed >= SPEAKS_M_PER_S).then_some(speed)
}

/// Repeats from rest; ends with the first stroke that does not sound, because then the trial has failed.
fn held(
    action: &mut Action,
    bottom: usize,
    up_m: f64,
    [stay_s, wait_s]: [f64; 2],
    progress: &mut Progress<'_>,
) -> Result<Option<Repetition>, MeasureError> {
    let mut finger = Finger::Presses(0.0);
    // Starts of the presses, and the key's return times.
    let (mut presses, mut returns, mut impacts) = (vec![0.0], Vec::new(), Vec::new());
    let mut softest_m_per_s = f64::INFINITY;
    let (mut step, mut fails) = (0_u64, false);
    action.play(progress, &mut |action| {
        let now = step as f64 * STEP_S;
        if step > 0 {
            let travel_m = action.reading().key_m;
            impacts.extend(action.impact());
            match finger {
                Finger::Presses(_) if action.mechanism().compression(bottom) > 0.0 => finger = Finger::Stays(now),
                Finger::Stays(since) if now - since >= stay_s => finger = Finger::IsOff(now),
                Finger::IsOff(since) if travel_m <= up_m => {
                    returns.push(now - since);
                    finger = Finger::Waits(now);
                }
                Finger::Presses(since) | Finger::IsOff(since) if now - since > PATIENCE_S => fails = true,
                _ => {}
            }
            // The wait may be 0.
            if let Finger::Waits(since) = finger
                && now - since >= wait_s
            {
                presses.push(now);
                finger = Finger::Presses(now);
                // The first stroke starts from rest, and does not count.
                if let [_, .., from_s, to_s] = presses[..] {
                    match sounds([from_s, to_s], &impacts) {
                        Some(speed) => softest_m_per_s = softest_m_per_s.min(speed),
                        None => fails = true,
                    }
                }
            }
        }
        step += 1;
        let force_n = if matches!(finger, Finger::IsOff(_) | Finger::Waits(_)) { 0.0 } else { PRESS_N };
        (!fails && presses.len() <= STROKES).then_some(Input::Force(force_n))
    })?;
    if fails {
        return Ok(None);
    }
    let counted = (presses.len() - 2) as f64;
    Ok(Some(Repetition {
        rate_hz: counted / (presses[presses.len() - 1] - presses[1]),
        stay_s,
        wait_s,
        return_s: returns[1..].iter().sum::<f64>() / counted,
        softest_m_per_s,
    }))
}

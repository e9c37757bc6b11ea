//! The least lift of the key that lets a note be repeated, with the repetition lever and without it.
//!
//! A finger presses a key, holds it, leads it up by some distance along a smooth path, waits there, and presses again.
//! The least lift is the smallest from which on, for three lifts in a row, the second blow sounds: one that sounds
//! between silent ones is luck.

use moreau::Settings;

use crate::measure::MeasureError;
use crate::measure::repetition::PRESS_N;
use erard::Progress;
use erard::grand::Anatomy;
use erard::instrument::Instrument;
use erard::player::{Action, Input, Snapshot};

/// Step, s.
const STEP_S: f64 = 50e-6;
/// The key is pressed with [`PRESS_N`] for this long, s, and held with this force, N, until the second instant, s.
const PRESSED_S: f64 = 0.15;
const HELD_N: f64 = 5.0;
const HELD_S: f64 = 0.35;
/// Durations of the way up, of the wait above, and of the second press, s.
const UP_S: f64 = 0.05;
const WAIT_S: f64 = 0.1;
const AGAIN_S: f64 = 0.2;
/// Step of the lift, m.
const LIFT_M: f64 = 0.25e-3;
/// Number of lifts in a row that must sound.
const IN_A_ROW: usize = 3;
/// Softest impact that counts, m/s, as in the rate of repetition.
const SPEAKS_M_PER_S: f64 = 0.5;
/// A knuckle that the lever does not hold up: share of its felt's stiffness.
const WITHOUT: f64 = 1e-6;

/// Least lifts over the depth at which the key was held; `None` if it does not repeat at all, or has no lever.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Repeats {
    pub with_lever: Option<f64>,
    pub without_lever: Option<f64>,
}

pub(super) fn measure(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Repeats, MeasureError> {
    let Some(lever) = Anatomy::find(instrument)?.lever_knuckle else {
        return Ok(Repeats { with_lever: None, without_lever: least_lift(instrument, progress)? });
    };
    let mut without = instrument.clone();
    let weaken = |fields: &mut erard::instrument::InstrumentFields| fields.zones[lever].felt.stiffness *= WITHOUT;
    let without_lever = match without.edit(weaken) {
        Ok(()) => least_lift(&without, progress)?,
        Err(_) => None,
    };
    Ok(Repeats { with_lever: least_lift(instrument, progress)?, without_lever })
}

/// Least lift over the depth at which the key is held.
fn least_lift(instrument: &Instrument, progress: &mut Progress<'_>) -> Result<Option<f64>, MeasureError> {
    let mut action = Action::with_progress(instrument, Settings::new(STEP_S), progress)?;
    let mut step = 0_u64;
    action.play(progress, &mut |_| {
        let t = step as f64 * STEP_S;
        step += 1;
        let force_n = if t < PRESSED_S { PRESS_N } else { HELD_N };
        (t < HELD_S).then_some(Input::Force(force_n))
    })?;
    let (held, depth_m) = (action.save(), action.reading().key_m);
    let count = (depth_m / LIFT_M).floor().max(0.0) as usize;
    let mut in_a_row = 0;
    for n in 1..=count {
        let sounds = again(&mut action, &held, depth_m, n as f64 * LIFT_M, progress)?;
        in_a_row = if sounds { in_a_row + 1 } else { 0 };
        if in_a_row == IN_A_ROW {
            return Ok(Some((n + 1 - IN_A_ROW) as f64 * LIFT_M / depth_m));
        }
    }
    // The largest lifts need no more in a row than there are.
    Ok((in_a_row > 0).then(|| (count + 1 - in_a_row) as f64 * LIFT_M / depth_m))
}

/// Whether a second blow sounds after the key was led up by `lift_m`.
fn again(
    action: &mut Action,
    held: &Snapshot,
    depth_m: f64,
    lift_m: f64,
    progress: &mut Progress<'_>,
) -> Result<bool, MeasureError> {
    // The snapshot is this action's own.
    let _ = action.restore(held);
    let (mut step, mut sounds) = (0_u64, false);
    action.play(progress, &mut |action| {
        sounds |= step > 0 && action.impact().is_some_and(|impact| impact.hammer_speed_m_per_s >= SPEAKS_M_PER_S);
        step += 1;
        // An imposed motion belongs to the end of its step.
        let t = step as f64 * STEP_S;
        let input = if t < UP_S + WAIT_S {
            let (share, rate) = smooth(t / UP_S);
            Input::Rigid { position_m: depth_m - lift_m * share, velocity_m_per_s: -lift_m * rate / UP_S }
        } else {
            Input::Force(PRESS_N)
        };
        (!sounds && t < UP_S + WAIT_S + AGAIN_S).then_some(input)
    })?;
    Ok(sounds)
}

/// Path of least jerk from 0 to 1, and its derivative.
fn smooth(share: f64) -> (f64, f64) {
    let s = share.clamp(0.0, 1.0);
    (s * s * s * (10.0 + s * (6.0 * s - 15.0)), 30.0 * s * s * (1.0 - s) * (1.0 - s))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The path begins and ends at rest, and its derivative is that of the path.
    #[test]
    fn the_way_up_is_smooth() {
        assert_eq!((smooth(-1.0), smooth(2.0)), ((0.0, 0.0), (1.0, 0.0)));
        assert_eq!(smooth(0.5), (0.5, 1.875));
        let slope = (smooth(0.3 + 1e-6).0 - smooth(0.3 - 1e-6).0) / 2e-6;
        assert!((slope - smooth(0.3).1).abs() < 1e-8);
    }
}

//! How fast a note can be repeated.
//!
//! A finger presses the key with a constant force until it is at its punching, stays there for a moment, and lifts off
//! altogether; the key comes up by itself, as fast as its weights and springs let it. As soon as it is up, at its rest (fully
//! released) or at half of its dip, the finger presses again. The shorter the finger stays, the higher the rate; the fastest at
//! which every stroke still sounds, once and not more softly than the softest playing that has been published, is the rate of
//! repetition. So the rate is the action's own, not that of a prescribed motion.

use moreau::Settings;

use super::{Interrupt, MeasureError, NotAnAction};
use erard::events::Watch;
use erard::instrument::Instrument;
use erard::player::{Action, Input};

/// Step, s.
const STEP_S: f64 = 50e-6;
/// The finger's force, N: a forte.
pub const PRESS_N: f64 = 8.0;
/// Strokes of a trial; the first one starts from rest and does not count.
const STROKES: usize = 9;
/// A blow that is softer does not speak, m/s: published hammer speeds begin at 0.5 m/s (pp).
const SPEAKS_M_S: f64 = 0.5;
/// How long the finger stays on the bottom: tried from nothing, in steps of this, to so many, s.
const STAY_STEP_S: f64 = 2e-3;
const STAYS: usize = 100;
/// So many neighbouring stays must all hold, and the slowest of them counts: no finger keeps time to a step, and a rate that
/// only one of them reaches is luck.
const NEIGHBOURS: usize = 3;
/// A stroke that takes longer has got stuck, s.
const PATIENCE_S: f64 = 1.0;

/// The fastest rate that is held, and how.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Repetition {
    /// Blows per second.
    pub rate_hz: f64,
    /// How long the finger stays on the bottom, s: the shortest stay with which every stroke sounds.
    pub stay_s: f64,
    /// From bottom until the key is up, s.
    pub return_s: f64,
    /// The softest of the blows, m/s.
    pub softest_m_s: f64,
}

/// The fastest rate at which every stroke sounds; `None` where none does. `up_m`: the finger presses again when the key has come
/// up to this travel below its rest.
///
/// # Errors
/// See [`MeasureError`].
pub fn repetition(
    instrument: &Instrument,
    up_m: f64,
    going: Interrupt<'_>,
) -> Result<Option<Repetition>, MeasureError> {
    let Some(bottom) = instrument.roles.key_bottom else {
        return Err(NotAnAction::NoKeyBottom.into());
    };
    let mut neighbours = Vec::new();
    for n in 0..STAYS {
        match held(instrument, bottom, up_m, n as f64 * STAY_STEP_S, going)? {
            Some(repetition) => neighbours.push(repetition),
            None => neighbours.clear(),
        }
        if neighbours.len() == NEIGHBOURS {
            return Ok(neighbours.into_iter().min_by(|a, b| a.rate_hz.total_cmp(&b.rate_hz)));
        }
    }
    Ok(None)
}

/// What the finger is doing, since when.
#[derive(Debug, Clone, Copy)]
enum Finger {
    Presses(f64),
    Stays(f64),
    IsOff(f64),
}

fn held(
    instrument: &Instrument,
    bottom: usize,
    up_m: f64,
    stay_s: f64,
    going: Interrupt<'_>,
) -> Result<Option<Repetition>, MeasureError> {
    let mut action = Action::asking(instrument, Settings::new(STEP_S), &mut || going())?;
    let mut watch = Watch::new(instrument);
    let mut finger = Finger::Presses(0.0);
    // When the finger began to press, and how long the key took to come up.
    let (mut presses, mut returns) = (vec![0.0], Vec::new());
    let (mut step, mut stuck) = (0_u64, false);
    action.play(&mut || going(), &mut |action| {
        let now = step as f64 * STEP_S;
        if step > 0 {
            let travel_m = action.reading().key_m;
            // Nothing but blows is asked of the watch: the head's height does not matter to them.
            watch.look(now, travel_m, 0.0, action.mechanism().met(), action.mechanism());
            match finger {
                Finger::Presses(_) if action.gap(bottom) > 0.0 => finger = Finger::Stays(now),
                Finger::Stays(since) if now - since >= stay_s => finger = Finger::IsOff(now),
                Finger::IsOff(since) if travel_m <= up_m => {
                    returns.push(now - since);
                    presses.push(now);
                    finger = Finger::Presses(now);
                }
                Finger::Presses(since) | Finger::IsOff(since) if now - since > PATIENCE_S => stuck = true,
                _ => {}
            }
        }
        step += 1;
        let force_n = if matches!(finger, Finger::IsOff(_)) { 0.0 } else { PRESS_N };
        (!stuck && presses.len() <= STROKES).then_some(Input::Force(force_n))
    })?;
    if stuck {
        return Ok(None);
    }
    let blows = watch.finish().strikes;
    let mut softest_m_s = f64::INFINITY;
    for stroke in presses[1..].windows(2) {
        let mut own = blows.iter().filter(|blow| (stroke[0]..stroke[1]).contains(&blow.time_s));
        match (own.next(), own.next()) {
            (Some(blow), None) if blow.speed_m_s >= SPEAKS_M_S => softest_m_s = softest_m_s.min(blow.speed_m_s),
            _ => return Ok(None),
        }
    }
    let counted = (presses.len() - 2) as f64;
    Ok(Some(Repetition {
        rate_hz: counted / (presses[presses.len() - 1] - presses[1]),
        stay_s,
        return_s: returns[1..].iter().sum::<f64>() / counted,
        softest_m_s,
    }))
}

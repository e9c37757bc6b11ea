//! The release of a key: the hand leaves so that the key, coming up, sets its damper down at the written instant, as
//! fast as the piece says.

use erard::Progress;

use crate::error::PerformError;
use crate::hand::Way;
use crate::key::Key;
use crate::touches::Touches;

/// A release is in time within this, s.
const CLOSE_S: f64 = 1e-3;
/// A written speed is met within this share.
const CLOSE: f64 = 0.1;
/// Largest amount by which a hand may have to leave earlier than expected, s.
const GUARD_S: f64 = 15e-3;
/// Likewise for a release of unknown duration, s.
const WIDE_GUARD_S: f64 = 0.3;
/// Shortest and longest time in which a hand leaves, s.
const WITHIN_S: [f64; 2] = [2e-3, 0.5];
/// Time after the end of the hand's force by which a key that comes up at all is up, s.
const PATIENCE_S: f64 = 0.3;
/// Number of trials of a release; one with a written speed gets more.
const TRIALS: [u32; 2] = [3, 6];

/// How a hand left a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Left {
    /// The step in which it began to leave.
    pub leaves: u64,
    pub way: Way,
}

/// Releases a key from its present state, for its damper to be down at an instant, s, its front coming up so fast, m/s,
/// where the piece says so. Afterwards the damper is down, or the key was not.
pub(crate) fn release(
    key: &mut Key<'_>,
    touches: &mut Touches,
    off_s: f64,
    speed_m_per_s: Option<f64>,
    progress: &mut Progress<'_>,
) -> Result<Left, PerformError> {
    let speed = speed_m_per_s.filter(|speed| *speed > 0.0);
    let mut within_s = speed.map_or(Way::USUAL.within_s, |speed| touches.way_of(speed));
    let mut lag_s = touches.lag_s(within_s);
    let is_known = speed.is_none_or(|speed| touches.knows_way(speed));
    let guard_s = if is_known { GUARD_S } else { WIDE_GUARD_S };
    let earliest = key.step_at(off_s - lag_s - guard_s).max(key.now());
    key.advance(earliest, progress)?;
    let mark = key.mark();
    let mut left = Left { leaves: earliest, way: Way { within_s } };
    for trial in 0..TRIALS[usize::from(speed.is_some())] {
        if trial > 0 {
            key.back_to(&mark)?;
        }
        let leaves = key.step_at(off_s - lag_s).max(earliest);
        key.advance(leaves, progress)?;
        left = Left { leaves, way: Way { within_s } };
        key.hand.leave(leaves, key.h(), left.way);
        if key.reading().key_m <= key.damper_m() {
            break;
        }
        let (before, until) = (key.ups.len(), leaves + key.step_at(within_s + PATIENCE_S));
        while key.ups.len() == before && key.now() < until {
            key.step(progress)?;
        }
        let Some(&[at_s, came_m_per_s]) = key.ups.get(before) else { break };
        lag_s = at_s - leaves as f64 * key.h();
        touches.learn_way(within_s, lag_s, came_m_per_s);
        let in_time = (at_s - off_s).abs() <= CLOSE_S || (leaves == earliest && at_s > off_s);
        let wanted = speed.map(|speed| (within_s * (came_m_per_s / speed).powi(2)).clamp(WITHIN_S[0], WITHIN_S[1]));
        let as_fast = speed.is_none_or(|speed| (came_m_per_s / speed).ln().abs() <= CLOSE);
        match wanted {
            Some(next_s) if !as_fast && (next_s / within_s).ln().abs() > 0.02 => {
                lag_s += 0.5 * (next_s - within_s);
                within_s = next_s;
            }
            _ if in_time => break,
            _ => {}
        }
    }
    Ok(left)
}

//! Regulation that ends with the aftertouch in its usual range. Aftertouch has no screw: dip or blow changes for it.

use super::aims::KEY_PER_HAMMER;
use super::planner::Priority;
use super::readings::ReadingQuantity;
use crate::distances::{Distances, Protocol};
use crate::measure::norms::norms_key;
use crate::regulate::{Goal, RegulateError, Regulated, Specification, Status, regulate, regulate_following};
use erard::instrument::Instrument;

/// Most changes of dip and blow, each followed by a regulation.
const PASSES: u32 = 4;
/// Steps of dip and blow, m: a paper, and the visible change of a blow.
const DIP_STEP_M: f64 = 1e-4;
const BLOW_STEP_M: f64 = 5e-4;

/// A goal that changed for the aftertouch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaveUp {
    /// Dip or blow.
    pub goal: Goal,
    /// Value requested, or found, m.
    pub asked_m: f64,
    /// Value set instead, m.
    pub instead_m: f64,
}

/// A regulation that ends with the aftertouch in its usual range, if possible.
#[derive(Debug, Clone)]
pub struct Settled {
    /// The action. Its goals have their final values.
    pub regulated: Regulated,
    /// The goals that changed for the aftertouch.
    pub gave_up: Vec<GaveUp>,
    /// Whether the aftertouch is in its usual range.
    pub is_settled: bool,
}

/// Usual range of an instrument's aftertouch, m.
#[must_use]
pub fn usual_aftertouch_m(instrument: &Instrument) -> [f64; 2] {
    range_m(ReadingQuantity::Aftertouch, norms_key(instrument))
}

/// Whether an instrument's aftertouch is in its usual range, as the sheet reads it.
#[must_use]
pub fn is_usual_aftertouch(instrument: &Instrument, distances: &Distances) -> bool {
    let aftertouch_mm = distances.aftertouch_m.map(|m| 1e3 * m);
    !ReadingQuantity::Aftertouch.line().is_out_at(aftertouch_mm, norms_key(instrument))
}

/// Regulates a copy of an instrument, and again with another blow ([`Priority::Dip`]), or another dip and then another
/// blow ([`Priority::Aftertouch`]), until the aftertouch is in its usual range. Both change no more than needed and
/// stay in their own usual ranges. `follow` is as in [`regulate_following`].
///
/// # Errors
/// See [`regulate`].
pub fn regulate_to_aftertouch(
    instrument: &Instrument,
    specification: &Specification,
    priority: Priority,
    follow: bool,
    progress: &mut dyn FnMut(&Status) -> bool,
) -> Result<Settled, RegulateError> {
    let work = if follow { regulate_following } else { regulate };
    let protocol = Protocol::default();
    let mut specification = specification.clone();
    let mut regulated = work(instrument, &specification, &protocol, progress)?;
    let kept = |goal: Goal| {
        let asked = specification.iter().rev().find(|(other, _)| *other == goal).map(|(_, value)| *value);
        asked.or_else(|| goal.of(&regulated.after))
    };
    let Some(asked) = kept(Goal::Dip).zip(kept(Goal::Blow)) else {
        let is_settled = is_usual_aftertouch(instrument, &regulated.after);
        return Ok(Settled { regulated, gave_up: Vec::new(), is_settled });
    };
    let mut set = asked;
    for _ in 0..PASSES {
        let Some(aftertouch) =
            regulated.after.aftertouch_m.filter(|_| !is_usual_aftertouch(instrument, &regulated.after))
        else {
            break;
        };
        let next = dip_and_blow(norms_key(instrument), priority, asked, set, aftertouch);
        if next == set {
            break;
        }
        set = next;
        specification.retain(|(goal, _)| ![Goal::Dip, Goal::Blow].contains(goal));
        specification.extend([(Goal::Dip, set.0), (Goal::Blow, set.1)]);
        let earlier = (regulated.simulations, regulated.rounds);
        regulated = work(instrument, &specification, &protocol, progress)?;
        regulated.simulations += earlier.0;
        regulated.rounds += earlier.1;
    }
    let both = [(Goal::Dip, asked.0, set.0), (Goal::Blow, asked.1, set.1)];
    let changed = both.into_iter().filter(|(_, asked_m, instead_m)| asked_m != instead_m);
    let gave_up = changed.map(|(goal, asked_m, instead_m)| GaveUp { goal, asked_m, instead_m }).collect();
    let is_settled = is_usual_aftertouch(instrument, &regulated.after);
    Ok(Settled { regulated, gave_up, is_settled })
}

fn range_m(quantity: ReadingQuantity, key: usize) -> [f64; 2] {
    quantity.range(key).map(|end| end / quantity.factor())
}

/// Returns dip and blow for an aftertouch inside its range by the reading's error, from the dip and the blow that gave
/// `aftertouch`, m.
fn dip_and_blow(key: usize, priority: Priority, asked: (f64, f64), set: (f64, f64), aftertouch: f64) -> (f64, f64) {
    let room_m = ReadingQuantity::Aftertouch.precision() / ReadingQuantity::Aftertouch.factor();
    let [low, high] = range_m(ReadingQuantity::Aftertouch, key);
    let mut missing = aftertouch.clamp(low + room_m, high - room_m) - aftertouch;
    let (mut dip, mut blow) = set;
    if priority == Priority::Aftertouch {
        dip = within(key, ReadingQuantity::Dip, asked.0, set.0 + whole(missing, DIP_STEP_M));
        missing -= dip - set.0;
    }
    // Less blow is more aftertouch. A difference below one paper needs no other blow.
    if missing.abs() > DIP_STEP_M {
        blow = within(key, ReadingQuantity::Blow, asked.1, set.1 - whole(missing / KEY_PER_HAMMER, BLOW_STEP_M));
    }
    (dip, blow)
}

/// Rounds to whole steps, away from zero.
fn whole(value: f64, step: f64) -> f64 {
    value.signum() * (value.abs() / step - 1e-6).ceil() * step
}

/// Clamps to the usual range, widened to the requested value.
fn within(key: usize, quantity: ReadingQuantity, asked_m: f64, value_m: f64) -> f64 {
    let [low, high] = range_m(quantity, key);
    value_m.clamp(low.min(asked_m), high.max(asked_m))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::norms::MIDDLE_C;

    /// The usual range begins at 0.67 mm, and 0.1 mm inside is wanted. 0.34 mm lack 0.43: five papers, or 0.43 / 0.19 =
    /// 2.3 mm of blow, which is 2.5 in halves, of which 2 mm are available.
    #[test]
    fn steps_by_hand() {
        let near = |(dip, blow): (f64, f64), expected: (f64, f64)| {
            assert!((dip - expected.0).abs() < 1e-9 && (blow - expected.1).abs() < 1e-9, "{dip} {blow}");
        };
        let asked = (10e-3, 46e-3);
        near(dip_and_blow(MIDDLE_C, Priority::Aftertouch, asked, asked, 0.34e-3), (10.5e-3, 46e-3));
        near(dip_and_blow(MIDDLE_C, Priority::Dip, asked, asked, 0.34e-3), (10e-3, 44e-3));
        // 0.57 mm lack. The dip ends at 11 mm, and the blow has to do the rest: 0.27 mm are 1.4 mm, in halves 1.5.
        let deep = (10.7e-3, 48e-3);
        near(dip_and_blow(MIDDLE_C, Priority::Aftertouch, deep, deep, 0.2e-3), (11e-3, 46.5e-3));
        // A requested dip outside the usual range is not drawn into it.
        let shallow = (9e-3, 46e-3);
        near(dip_and_blow(MIDDLE_C, Priority::Dip, shallow, shallow, 0.6e-3), (9e-3, 45e-3));
    }
}

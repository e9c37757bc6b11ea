//! Screws that must follow: turning one screw disturbs the goals of others.

use super::rounds::{Regulated, Status, regulate};
use super::{Goal, RegulateError, Specification};
use crate::distances::{Distances, Protocol};
use crate::measure::norms::norms_key;
use erard::instrument::Instrument;
use erard::parameter::Quantity;
use erard::player::AtRest;

/// Largest change of a distance, m, or as a share of a speed, or of the dip, that does not count as disturbed.
const SEEN_M: f64 = 0.25e-3;
const SEEN_OF_SPEED: f64 = 0.15;
const SEEN_OF_DIP: f64 = 0.03;
/// Most regulations, each with newly disturbed goals added.
const PASSES: u32 = 4;

/// Returns the trade's norms of the distances that are out of their usual ranges at the action's key, as the sheet
/// flags them, and for which the instrument has a screw. What is in its range is no goal: nobody need turn it.
///
/// # Errors
/// See [`regulate`].
pub fn needed(
    action: &dyn AtRest,
    protocol: &Protocol,
    progress: &mut dyn FnMut(&Status) -> bool,
) -> Result<Specification, RegulateError> {
    let found = regulate(action, &Specification::new(), protocol, progress)?.before;
    let instrument = action.instrument();
    let key = norms_key(instrument);
    let is_needed = |goal: &Goal| has_screw(instrument, *goal) && is_out(*goal, &found, key);
    Ok(Goal::ALL.into_iter().filter(is_needed).filter_map(|goal| Some((goal, goal.norm()?))).collect())
}

fn has_screw(instrument: &Instrument, goal: Goal) -> bool {
    goal.screws().next().is_some_and(|(first, _)| instrument.screw(first.name).is_some())
}

/// Whether the sheet would flag a goal's distance at a key.
fn is_out(goal: Goal, found: &Distances, key: usize) -> bool {
    let value = goal.of(found).map(|value| if goal.quantity() == Quantity::Length { 1e3 * value } else { value });
    goal.line().is_some_and(|line| line.is_out_at(value, key))
}

/// Returns the goals that were not given and that a regulation has disturbed, each with its earlier value to restore:
/// it moved by more than one sees, or it left its usual range. Goals without a screw of their own in this instrument
/// are left out, as is the repetition rise, whose screw is the check's.
#[must_use]
pub fn disturbed(regulated: &Regulated) -> Specification {
    let asked = |goal: Goal| regulated.achieved.iter().any(|achieved| achieved.goal == goal);
    let instrument = &regulated.instrument;
    let key = norms_key(instrument);
    let moved = |goal: Goal| {
        let left = is_out(goal, &regulated.after, key) && !is_out(goal, &regulated.before, key);
        let earlier = goal.of(&regulated.before).filter(|_| left);
        has_moved(goal, &regulated.before, &regulated.after).or(earlier)
    };
    let is_free = |goal: &Goal| *goal != Goal::RepetitionRise && !asked(*goal) && has_screw(instrument, *goal);
    let goals = Goal::ALL.into_iter().filter(is_free);
    goals.filter_map(|goal| Some((goal, moved(goal)?))).collect()
}

/// Earlier value of a goal, if it has changed.
fn has_moved(goal: Goal, before: &Distances, after: &Distances) -> Option<f64> {
    let before = goal.of(before)?;
    let seen = match goal.quantity() {
        Quantity::Speed => SEEN_OF_SPEED * before,
        Quantity::Share => SEEN_OF_DIP,
        _ => SEEN_M,
    };
    // An event that no longer happens counts as changed.
    let is_there = goal.of(after).is_some_and(|after| (after - before).abs() <= seen);
    (!is_there).then_some(before)
}

/// Runs [`regulate`], and again with disturbed goals kept at their earlier values, until no other goal is disturbed.
/// `before` holds the distances before the first turn.
///
/// # Errors
/// See [`regulate`].
pub fn regulate_following(
    action: &dyn AtRest,
    specification: &Specification,
    protocol: &Protocol,
    progress: &mut dyn FnMut(&Status) -> bool,
) -> Result<Regulated, RegulateError> {
    let mut specification = specification.clone();
    let mut regulated = regulate(action, &specification, protocol, progress)?;
    for _ in 1..PASSES {
        let more = disturbed(&regulated);
        if more.is_empty() {
            break;
        }
        specification.extend(more);
        let earlier = (regulated.simulations, regulated.rounds);
        regulated = regulate(action, &specification, protocol, progress)?;
        regulated.simulations += earlier.0;
        regulated.rounds += earlier.1;
    }
    Ok(regulated)
}

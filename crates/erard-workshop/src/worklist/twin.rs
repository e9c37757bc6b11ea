//! A model adjusted to the readings of a piano whose parameters are unknown.

use super::WorklistResult;
use super::hand::{Rubs, Work, ease};
use super::readings::{ReadingQuantity, Readings, is_seen_to_drop};
use crate::balance::KeyModel;
use crate::distances::{Distances, Protocol};
use crate::regulate::{Goal, Specification, Status, regulate};
use crate::weighing::Scale;
use erard::Progress;
use erard::instrument::Instrument;

/// Tolerance of the friction weight, g.
const FRICTION_CLOSE_G: f64 = 0.5;
/// Smallest drop that a screw is set to, mm: it must be visible as a drop.
const LEAST_DROP_MM: f64 = 0.3;
/// Steps, m, by which dip and blow of the copy differ from those read where they cannot be the same, and most of them.
const DEEPER_M: f64 = 5e-4;
const NEARER_M: f64 = -2e-3;
const MAX_SHIFTS: u32 = 3;

/// Returns a copy of a model with the hammer, front weight, friction and screws read on a piano. It predicts how a line
/// of work changes a reading; its own readings may differ.
///
/// # Errors
/// See [`super::WorklistError`].
pub fn twin(model: &Instrument, readings: &Readings, progress: &mut Progress<'_>) -> WorklistResult<Instrument> {
    let own = KeyModel::of(model)?;
    let mut twin = model.clone();
    if let Some(strike_g) = readings.get(ReadingQuantity::StrikeWeight) {
        Work::Hammer { by_g: strike_g - own.strike_weight_g }.carry_out(&mut twin, progress)?;
    }
    if let Some(front_g) = readings.get(ReadingQuantity::FrontWeight) {
        Work::FrontWeight { by_g: front_g - own.front_weight_g }.carry_out(&mut twin, progress)?;
    }
    let mut goals: Specification = ReadingQuantity::ALL
        .into_iter()
        .filter_map(|quantity| {
            let goal = quantity.goal()?;
            let has_screw = goal.screws().any(|(known, _)| model.screw(known.name).is_some());
            // Missing readings are no goals: their screw stays, and the other goals decide. A hammer that does not drop
            // is held up by a screw at least so far out of place.
            let value = readings.get(quantity).filter(|_| has_screw)?;
            let value = if quantity == ReadingQuantity::Drop { value.max(LEAST_DROP_MM) } else { value };
            Some((goal, value / quantity.factor()))
        })
        .collect();
    if !goals.is_empty() {
        let (as_built, mut shifts) = (twin.clone(), 0);
        loop {
            let mut going = |status: &Status| progress(status.share);
            let regulated = regulate(&as_built, &goals, &Protocol::default(), &mut going)?;
            twin = regulated.instrument;
            let Some((shifted, by_m)) = shift(&regulated.after, &goals, readings).filter(|_| shifts < MAX_SHIFTS)
            else {
                break;
            };
            let Some((_, value)) = goals.iter_mut().find(|(goal, _)| *goal == shifted) else { break };
            *value += by_m;
            shifts += 1;
        }
    }
    let mut scale = Scale::default();
    if let Some(friction_g) = readings.get(ReadingQuantity::FrictionWeight)
        && let Some(own_g) = scale.touch(&twin, progress)?.friction_weight_g()
        && (friction_g - own_g).abs() > FRICTION_CLOSE_G
    {
        let by_g = friction_g - own_g;
        // Excess friction goes to the key, whose bushings swell: at the hammer's pin it would hold up a hammer that is
        // read to drop.
        let rubs = if by_g > 0.0 { Rubs::Key } else { Rubs::Everywhere };
        ease(&mut twin, rubs, by_g, &mut scale, progress)?;
    }
    Ok(twin)
}

/// Returns the goal that the copy needs another value of, and by how much, m, if it does not come to its goals: on the
/// copy, only changes have to be right.
fn shift(copy: &Distances, goals: &Specification, readings: &Readings) -> Option<(Goal, f64)> {
    let own_drop_mm = Goal::Drop.of(copy).map(|drop_m| 1e3 * drop_m);
    let asked_m = goals.iter().find(|(goal, _)| *goal == Goal::Blow).map(|(_, value)| *value);
    let is_short = asked_m
        .zip(Goal::Blow.of(copy))
        .is_some_and(|(asked_m, own_m)| 1e3 * (asked_m - own_m) > ReadingQuantity::Blow.precision());
    if is_short {
        // A hammer that already lies on its rail comes no farther down, and the capstan leaves the heel.
        Some((Goal::Blow, NEARER_M))
    } else if is_seen_to_drop(readings.get(ReadingQuantity::Drop)) && !is_seen_to_drop(own_drop_mm) {
        // Its key ends before the jack lets off, as the piano's does not.
        Some((Goal::Dip, DEEPER_M))
    } else {
        None
    }
}

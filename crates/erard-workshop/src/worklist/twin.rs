//! A model brought to the readings of a piano that nobody has the numbers of.

use super::Worked;
use super::hand::{Rubs, Work, ease};
use super::readings::{Quantity, Readings};
use crate::balance::KeyModel;
use crate::distances::Protocol;
use crate::regulate::{Specification, Status, regulate};
use erard::Progress;
use erard::instrument::Instrument;

/// A friction weight is not brought nearer than this, g.
const FRICTION_CLOSE_G: f64 = 0.5;
/// The smallest drop that a screw is set to, mm: one that is seen as a drop.
const LEAST_DROP_MM: f64 = 0.3;

/// A copy of a model with hammer, front weight, friction and screws as they were read on a piano. It answers one
/// question: how much does a reading change by a line of work. What it reads by itself may differ.
///
/// # Errors
/// See [`super::WorklistError`].
pub fn twin(model: &Instrument, readings: &Readings, progress: &mut Progress<'_>) -> Worked<Instrument> {
    let own = KeyModel::of(model)?;
    let mut twin = model.clone();
    if let Some(strike_g) = readings.get(Quantity::StrikeWeight) {
        Work::Hammer { by_g: strike_g - own.strike_weight_g }.carry_out(&mut twin, progress)?;
    }
    if let Some(front_g) = readings.get(Quantity::FrontWeight) {
        Work::FrontWeight { by_g: front_g - own.front_weight_g }.carry_out(&mut twin, progress)?;
    }
    let goals: Specification = Quantity::ALL
        .into_iter()
        .filter_map(|quantity| {
            let goal = quantity.goal()?;
            let has_screw = goal.screws().iter().any(|(name, _)| model.screw(name).is_some());
            // What did not happen is not asked for: its screw stays, and the other goals decide. A hammer that does not
            // drop is held up: by a screw that stands at least so far out of its place.
            let value = readings.get(quantity).filter(|_| has_screw)?;
            let value = if quantity == Quantity::Drop { value.max(LEAST_DROP_MM) } else { value };
            Some((goal, value / quantity.factor()))
        })
        .collect();
    if !goals.is_empty() {
        let mut going = |status: &Status| progress(status.share);
        twin = regulate(&twin, &goals, &Protocol::default(), &mut going)?.instrument;
    }
    if let Some(friction_g) = readings.get(Quantity::FrictionWeight)
        && let Some(own_g) = Readings::of(&twin, progress)?.get(Quantity::FrictionWeight)
        && (friction_g - own_g).abs() > FRICTION_CLOSE_G
    {
        let by_g = friction_g - own_g;
        // What is too much goes to the key, whose bushings swell: at the hammer's pin it would hold up a hammer that is
        // read to drop.
        let rubs = if by_g > 0.0 { Rubs::Key } else { Rubs::Everywhere };
        ease(&mut twin, rubs, by_g, progress)?;
    }
    Ok(twin)
}

//! The list of a keyboard carried out on simulated copies of its keys, which are weighed again.

use super::hand::Work;
use super::keyboard::{KeyLine, KeyboardList, Operation};
use crate::balance::{BalancedKey, KeyModel, MeasuredKey};
use crate::cores;
use crate::measure::MeasureError;
use crate::measure::weights::Touch;
use crate::weighing::touch;
use erard::Progress;
use erard::instrument::Instrument;

/// Carries out a list and returns the weights that a technician would measure afterwards. `instruments` has every key's
/// model, the first key at index 0. Each key with work is copied from its model, adjusted to the key's strike weight,
/// front weight and, where it is to be eased, friction. The work changes the key's weights as it changes the copy's.
/// `progress` receives the share done, and ends the work by returning false.
///
/// # Errors
/// See [`MeasureError`].
pub fn carry_out(
    list: &KeyboardList,
    instruments: &[Instrument],
    progress: &mut Progress<'_>,
) -> Result<Vec<MeasuredKey>, MeasureError> {
    let of_key = |key: &BalancedKey, progress: &mut Progress<'_>| {
        let lines: Vec<&KeyLine> = list.lines.iter().filter(|line| line.key == key.measured.key).collect();
        match instruments.get(key.measured.key - 1) {
            Some(model) if !lines.is_empty() => worked_on(key, model, &lines, progress),
            _ => Ok(key.measured.clone()),
        }
    };
    cores::map(&list.plan.keys, cores::count(), progress, of_key)
}

fn worked_on(
    key: &BalancedKey,
    model: &Instrument,
    lines: &[&KeyLine],
    progress: &mut Progress<'_>,
) -> Result<MeasuredKey, MeasureError> {
    let mut copy = model.clone();
    let scale = KeyModel::of(model)?;
    if let Some(strike_g) = key.measured.strike_weight_g {
        Work::Hammer { by_g: strike_g - scale.strike_weight_g }.carry_out(&mut copy, progress)?;
    }
    if let Some(front_g) = key.measured.front_weight_g {
        Work::FrontWeight { by_g: front_g - scale.front_weight_g }.carry_out(&mut copy, progress)?;
    }
    // The effect of hammers and leads does not depend on friction.
    if lines.iter().any(|line| line.operation == Operation::Friction)
        && let Some(friction_g) = key.friction_weight_g
        && let Some(now_g) = touch(&copy, progress)?.friction_weight_g()
    {
        Work::Friction { by_g: friction_g - now_g }.carry_out(&mut copy, progress)?;
    }
    let weighed = |copy: &Instrument, progress: &mut Progress<'_>| -> Result<(KeyModel, Touch), MeasureError> {
        Ok((KeyModel::of(copy)?, touch(copy, progress)?))
    };
    let before = weighed(&copy, progress)?;
    for line in lines {
        line.work.carry_out(&mut copy, progress)?;
    }
    let after = weighed(&copy, progress)?;
    let moved = |own: Option<f64>, before: Option<f64>, after: Option<f64>| Some(own? + after? - before?);
    let own = &key.measured;
    let mut leads = own.leads.clone();
    for line in lines {
        if let Work::Leads(work) = &line.work {
            leads.retain(|lead| !work.out.contains(lead));
            // If the present leads are unknown, the new ones are not all of them.
            if !own.leads.is_empty() {
                leads.extend(&work.put);
            }
        }
    }
    let scales = |of: fn(&KeyModel) -> f64| (Some(of(&before.0)), Some(of(&after.0)));
    let ((strike, strike_then), (front, front_then)) =
        (scales(|scale| scale.strike_weight_g), scales(|scale| scale.front_weight_g));
    Ok(MeasuredKey {
        strike_weight_g: moved(own.strike_weight_g, strike, strike_then),
        front_weight_g: moved(own.front_weight_g, front, front_then),
        down_weight_g: moved(own.down_weight_g, before.1.down_weight_g, after.1.down_weight_g),
        up_weight_g: moved(own.up_weight_g, before.1.up_weight_g, after.1.up_weight_g),
        leads,
        ..own.clone()
    })
}

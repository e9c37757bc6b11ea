//! Check of the statics: remedies made in the dynamic model and weighed there.

use super::model::add_mass;
use super::plan::{BalancedKey, Remedy};
use crate::cores;
use crate::measure::MeasureError;
use crate::weighing::touch;
use erard::Progress;
use erard::grand::{Parts, strike_weight_g};
use erard::instrument::Instrument;

/// Effect of a remedy on the balance weight, g: by the equation of balance, and in the dynamic model.
#[derive(Debug, Clone, PartialEq)]
pub struct Checked {
    /// The key.
    pub key: usize,
    /// The remedy.
    pub remedy: Remedy,
    /// Effect by the equation of balance with the model's own ratio, g.
    pub by_equation_g: f64,
    /// Effect in the model, from slow loops before and after, g; `None` if no weight moves the key.
    pub in_model_g: Option<f64>,
}

/// Makes each key's remedies (leads, strike weight, capstan) one by one in its model, which is first adjusted to the
/// measured weights, and weighs the key before and after in a slow loop with the damper lifted. The equation uses the
/// model's own ratio: this checks the equation, not whether the model's levers match the piano's. `progress` receives
/// the share done, and ends the work by returning false.
///
/// # Errors
/// See [`MeasureError`].
pub fn check(keys: &[(&BalancedKey, Instrument)], progress: &mut Progress<'_>) -> Result<Vec<Checked>, MeasureError> {
    let each =
        cores::map(keys, cores::count(), progress, |(key, instrument), progress| check_key(key, instrument, progress))?;
    Ok(each.into_iter().flatten().collect())
}

fn check_key(
    key: &BalancedKey,
    instrument: &Instrument,
    progress: &mut Progress<'_>,
) -> Result<Vec<Checked>, MeasureError> {
    // Flexible parts are locked: weights are put on whole parts.
    let instrument = &instrument.locked();
    let parts = Parts::of(instrument)?;
    let mut as_weighed = instrument.clone();
    let model = &key.model;
    let front_m = 1e-3 * model.key_front_mm;
    let strike_arm_m = instrument.roles.hammer_strike_point_m[0];
    let strike = |instrument: &mut Instrument, by_g: f64| {
        let height_m = instrument.bodies[parts.hammer].center_of_mass_m[1];
        add_mass(instrument, parts.hammer, 1e-3 * by_g, [strike_arm_m, height_m])
    };
    let front = |instrument: &mut Instrument, mass_g: f64, at_mm: f64| {
        let height_m = instrument.bodies[parts.key].center_of_mass_m[1];
        add_mass(instrument, parts.key, 1e-3 * mass_g, [-1e-3 * at_mm, height_m])
    };
    if let Some(strike_g) = key.measured.strike_weight_g {
        strike(&mut as_weighed, strike_g - strike_weight_g(instrument, &parts)?)?;
    }
    if let Some(front_g) = key.measured.front_weight_g {
        let at_mm = 0.6 * model.key_front_mm;
        front(&mut as_weighed, (front_g - model.front_weight_g) * model.key_front_mm / at_mm, at_mm)?;
    }
    let Some(before_g) = touch(&as_weighed, progress)?.balance_weight_g() else { return Ok(Vec::new()) };
    let (strike_g, front_g) =
        (strike_weight_g(&as_weighed, &parts)?, erard::grand::front_weight_g(&as_weighed, &parts, front_m)?);
    let whippen_g = model.key_ratio * model.whippen_weight_g;
    let ratio = (before_g + front_g - whippen_g) / strike_g;
    let mut checked = Vec::new();
    let mut remedies: Vec<(Remedy, f64, Instrument)> = Vec::new();
    if let Some(leads) = key.leads.clone().map(|leads| leads.work).filter(|leads| leads.front_weight_g != 0.0) {
        let mut after = as_weighed.clone();
        leads.put.iter().try_for_each(|lead| front(&mut after, lead.mass_g, lead.at_mm))?;
        leads.out.iter().try_for_each(|lead| front(&mut after, -lead.mass_g, lead.at_mm))?;
        let by_g = -leads.front_weight_g;
        remedies.push((Remedy::Leads(leads), by_g, after));
    }
    if let Some(by_g) = key.strike_change_g.filter(|by_g| by_g.abs() > 0.05) {
        let mut after = as_weighed.clone();
        strike(&mut after, by_g)?;
        remedies.push((Remedy::Strike(by_g), ratio * by_g, after));
    }
    let capstan = instrument.zones.iter().position(|zone| {
        let touches = |body: usize| zone.disc_body == Some(body) || zone.curve_body == Some(body);
        touches(parts.key) && touches(parts.whippen) && zone.disc_body == Some(parts.key)
    });
    if let Some((by_mm, zone)) = key.capstan_move_mm.filter(|by_mm| by_mm.abs() > 0.05).zip(capstan) {
        let mut after = as_weighed.clone();
        after.edit(|fields| fields.zones[zone].disc_center_m[0] -= 1e-3 * by_mm)?;
        let by_g = (model.capstan_factor(by_mm) - 1.0) * (before_g + front_g);
        remedies.push((Remedy::Capstan(by_mm), by_g, after));
    }
    for (remedy, by_equation_g, after) in remedies {
        let after_g = touch(&after, progress)?.balance_weight_g();
        checked.push(Checked {
            key: key.measured.key,
            remedy,
            by_equation_g,
            in_model_g: after_g.map(|after_g| after_g - before_g),
        });
    }
    Ok(checked)
}

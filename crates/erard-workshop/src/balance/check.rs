//! Check of the statics: remedies made in the dynamic model and weighed there.

use super::model::add_mass;
use super::plan::{BalancedKey, Bound, Plan, Remedy, Withheld};
use crate::cores;
use crate::measure::MeasureError;
use crate::weighing::touch;
use erard::Progress;
use erard::grand::{Parts, strike_weight_g};
use erard::instrument::Instrument;

/// Largest difference of the model from the equation with which a remedy is given: a reading's error and a quarter.
const DIFFERS_G: f64 = 2.0;
const DIFFERS: f64 = 0.25;

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
pub fn check(keys: &[(BalancedKey, Instrument)], progress: &mut Progress<'_>) -> Result<Vec<Checked>, MeasureError> {
    let each =
        cores::map(keys, cores::count(), progress, |(key, instrument), progress| check_key(key, instrument, progress))?;
    Ok(each.into_iter().flatten().collect())
}

impl BalancedKey {
    /// Withholds a remedy that the model refutes: its effect differs from the equation's by more than a reading's error
    /// and a quarter.
    pub fn withhold(&mut self, checked: &Checked) {
        let [by_equation_g, in_model_g] = [Some(checked.by_equation_g), checked.in_model_g];
        let apart = by_equation_g.zip(in_model_g).map(|(equation, model)| (equation - model).abs());
        if apart.is_some_and(|apart| apart <= DIFFERS_G + DIFFERS * checked.by_equation_g.abs()) {
            return;
        }
        match checked.remedy {
            Remedy::Capstan(_) => self.capstan_move_mm = None,
            Remedy::Strike(_) => self.strike_change_g = None,
            // A gram of lead, or of a spring weighed at the key, is a gram at the key in any model.
            Remedy::Leads(_) | Remedy::Assist(_) => return,
        }
        self.withheld.push(Withheld { remedy: checked.remedy.clone(), bound: Bound::Model(in_model_g) });
    }
}

impl Plan {
    /// Withholds remedies that the model refutes, at the checked keys and, of a capstan that moves no less the same
    /// way, at keys that were not checked.
    pub fn withhold(&mut self, checked: &[Checked]) {
        for one in checked {
            self.keys.iter_mut().filter(|key| key.measured.key == one.key).for_each(|key| key.withhold(one));
        }
        let refuted = |key: &&BalancedKey| {
            key.withheld.iter().find_map(|one| match (&one.remedy, one.bound) {
                (Remedy::Capstan(by_mm), Bound::Model(in_model_g)) => Some((*by_mm, in_model_g)),
                _ => None,
            })
        };
        let refuted: Vec<(f64, Option<f64>)> = self.keys.iter().filter_map(|key| refuted(&key)).collect();
        for key in self.keys.iter_mut().filter(|key| checked.iter().all(|one| one.key != key.measured.key)) {
            let Some(by_mm) = key.capstan_move_mm else { continue };
            let no_less = |(other_mm, _): &&(f64, Option<f64>)| by_mm * other_mm > 0.0 && by_mm.abs() >= other_mm.abs();
            if refuted.iter().any(|one| no_less(&one)) {
                key.capstan_move_mm = None;
                key.withheld.push(Withheld { remedy: Remedy::Capstan(by_mm), bound: Bound::AsChecked });
            }
        }
    }
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

#[cfg(test)]
mod tests {
    use super::super::leads::LEADS_G;
    use super::super::measured::MeasuredKey;
    use super::super::model::KeyModel;
    use super::super::plan::{MOST_CAPSTAN_MM, Target, plan};
    use super::*;
    use erard::keyboard::KEYS;

    /// A remedy that the model refutes is withheld, one that it confirms is given. Key 88 of a published piano (CAUT
    /// list, October 2004: D 67, U 46, FW -8.6, SW 5.5 g) gets neither 26 mm of capstan nor 3 g off its hammer.
    #[test]
    fn remedies_have_bounds() {
        let model = KeyModel::of(&Instrument::builtin("concert-grand").unwrap()).unwrap();
        let weighed = |key: usize, [down_g, up_g, front_g, strike_g]: [f64; 4]| {
            let key = MeasuredKey {
                key,
                down_weight_g: Some(down_g),
                up_weight_g: Some(up_g),
                front_weight_g: Some(front_g),
                strike_weight_g: Some(strike_g),
                ..MeasuredKey::default()
            };
            let target = Target { balance_weight_g: 38.0, inertia_kg: None, hammers: false };
            plan(&[key], &[model; KEYS], target, &LEADS_G).keys.swap_remove(0)
        };
        let top = weighed(88, [67.0, 46.0, -8.6, 5.5]);
        assert!(top.capstan_move_mm.is_none() && top.strike_change_g.is_none(), "{top:?}");
        let bounds: Vec<Bound> = top.withheld.iter().map(|one| one.bound).collect();
        assert!(matches!(bounds[..], [Bound::StrikeWeight(then_g), Bound::Heel] if then_g < 4.0), "{bounds:?}");
        let mut key = weighed(40, [55.0, 29.0, 22.0, 9.0]);
        let by_mm = key.capstan_move_mm.filter(|by_mm| by_mm.abs() < MOST_CAPSTAN_MM).unwrap();
        let checked = |in_model_g| Checked { key: 40, remedy: Remedy::Capstan(by_mm), by_equation_g: -4.0, in_model_g };
        key.withhold(&checked(Some(-6.5)));
        assert!(key.capstan_move_mm.is_some() && key.withheld.is_empty());
        key.withhold(&checked(Some(2.0)));
        assert!(key.capstan_move_mm.is_none() && key.withheld[0].bound == Bound::Model(Some(2.0)), "{key:?}");
    }

    /// Springs: more of them is a remedy of a key that has them, up to 15 g. Aftertouch: 4 mm of capstan take 0.7 mm of
    /// it; a dip with room gives it back.
    #[test]
    fn bounds_of_springs_and_of_aftertouch() {
        let model = KeyModel::of(&Instrument::builtin("concert-grand").unwrap()).unwrap();
        let of = |assist_g: Option<f64>, aftertouch_mm: Option<f64>, dip_mm: Option<f64>| {
            let key = MeasuredKey {
                key: 40,
                down_weight_g: Some(57.0),
                up_weight_g: Some(31.0),
                front_weight_g: Some(22.0),
                strike_weight_g: Some(9.0),
                assist_g,
                aftertouch_mm,
                dip_mm,
                ..MeasuredKey::default()
            };
            let target = Target { balance_weight_g: 38.0, inertia_kg: None, hammers: false };
            plan(&[key], &[model; KEYS], target, &LEADS_G).keys.swap_remove(0)
        };
        let bare = of(None, None, None);
        assert_eq!((bare.assist_change_g, bare.withheld.len()), (None, 0));
        assert_eq!(of(Some(8.0), None, None).assist_change_g, Some(6.0));
        // With 8 g of spring the same balance weight hides 8 g more of action.
        assert!((of(Some(8.0), None, None).ratio.unwrap() - bare.ratio.unwrap() - 8.0 / 9.0).abs() < 1e-12);
        let much = of(Some(10.0), None, None);
        assert!(much.assist_change_g.is_none() && much.withheld[0].bound == Bound::Assist(16.0), "{much:?}");
        let short = of(None, Some(0.9), None);
        assert!(matches!(short.withheld[0].bound, Bound::Aftertouch(then_mm) if then_mm < 0.67), "{short:?}");
        assert!(of(None, Some(2.2), None).withheld.is_empty() && of(None, Some(0.9), Some(9.8)).withheld.is_empty());
        let mut plan = Plan {
            keys: vec![bare.clone(), bare.clone()],
            curves: plan(&[], &[model; KEYS], bare_target(), &LEADS_G).curves,
            target: bare_target(),
        };
        plan.keys[0].measured.key = 39;
        let by_mm = bare.capstan_move_mm.unwrap();
        let checked = Checked { key: 39, remedy: Remedy::Capstan(by_mm), by_equation_g: -6.0, in_model_g: None };
        plan.withhold(&[checked]);
        assert_eq!(plan.keys[0].withheld[0].bound, Bound::Model(None));
        assert_eq!(plan.keys[1].withheld[0].bound, Bound::AsChecked);
    }

    fn bare_target() -> Target {
        Target { balance_weight_g: 38.0, inertia_kg: None, hammers: false }
    }
}

//! Lengths, ratios and inertias from a keyboard's model, where nothing was weighed.

use super::leads::LEADS_AT;
use crate::measure::MeasureError;
use crate::measure::levers::Levers;
use erard::grand::{Parts, front_weight_g, strike_weight_g, whippen_weight_g};
use erard::instrument::{Instrument, InvalidInstrument, Vec2};
use moreau::vector::{dot, sub};

/// The lengths, ratios and inertias of a key's model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KeyModel {
    /// Distance of balance pin and finger, mm.
    pub key_front_mm: f64,
    /// Distance of balance pin and capstan contact, mm.
    pub capstan_mm: f64,
    /// Distance of capstan contact and whippen pin, mm.
    pub heel_mm: f64,
    /// KR: grams at the front per gram over the capstan.
    pub key_ratio: f64,
    /// WW, g.
    pub whippen_weight_g: f64,
    /// FW of the model, g.
    pub front_weight_g: f64,
    /// SW of the model, g.
    pub strike_weight_g: f64,
    /// Inertia of the key alone at its front, with the leads that give [`KeyModel::front_weight_g`], g.
    pub key_inertia_g: f64,
    /// Inertia of whippen, jack and lever at the key's front, half-way, g.
    pub whippen_inertia_g: f64,
    /// Hammer's inertia about its pin over that of its strike weight at the strike point.
    pub hammer_factor: f64,
}

/// Grams per kilogram, millimetres per metre.
const G: f64 = 1e3;
const MM: f64 = 1e3;
/// Key travel at which inertias are evaluated: half-way to where let-off usually begins, m.
const HALF_WAY_M: f64 = 4e-3;

impl KeyModel {
    /// Computes the model of an instrument, without bending.
    ///
    /// # Errors
    /// If the instrument is not a grand action, has no equilibrium, or its levers do not reach half-way.
    pub fn of(instrument: &Instrument) -> Result<Self, MeasureError> {
        let instrument = &instrument.locked();
        let parts = Parts::of(instrument)?;
        let mut levers = Levers::of(instrument)?;
        let (front_m, capstan_m) = (levers.key_front_m, levers.capstan_m);
        let [whippen_ratio, _] = levers.ratios(HALF_WAY_M)?;
        let (key, hammer) = (&instrument.bodies[parts.key], &instrument.bodies[parts.hammer]);
        let strike_g = strike_weight_g(instrument, &parts)?;
        let strike_arm_m = instrument.roles.hammer_strike_point_m[0];
        Ok(KeyModel {
            key_front_mm: front_m * MM,
            capstan_mm: capstan_m * MM,
            heel_mm: -levers.whippen_arm_m * MM,
            key_ratio: capstan_m / front_m,
            whippen_weight_g: whippen_weight_g(instrument, &parts, levers.whippen_arm_m)?,
            front_weight_g: front_weight_g(instrument, &parts, front_m)?,
            strike_weight_g: strike_g,
            key_inertia_g: G * key.inertia_kg_m2 / (front_m * front_m),
            whippen_inertia_g: G * stack_inertia_kg_m2(instrument, parts.whippen) * (whippen_ratio / front_m).powi(2),
            hammer_factor: hammer.inertia_kg_m2 / (1e-3 * strike_g * strike_arm_m * strike_arm_m),
        })
    }

    /// Effective inertia at the key's front for these weights, kg: the hammer's from strike weight and ratio, the key's
    /// with leads at `LEADS_AT` changed for the front weight, the whippen's from the model.
    #[must_use]
    pub(crate) fn inertia_kg(&self, strike_weight_g: f64, front_weight_g: f64, ratio: f64) -> f64 {
        let hammer_g = self.hammer_factor * strike_weight_g * ratio * ratio;
        1e-3 * (hammer_g + self.whippen_inertia_g + self.key_g(front_weight_g))
    }

    /// Inertia of the key at its front with leads changed for a front weight, g: each gram of it needs `1 / LEADS_AT`
    /// of lead, whose inertia counts `LEADS_AT` squared.
    fn key_g(&self, front_weight_g: f64) -> f64 {
        self.key_inertia_g + LEADS_AT * (front_weight_g - self.front_weight_g)
    }

    /// Strike weight for an inertia, with leads that keep the balance weight, g: inertia is linear in it.
    #[must_use]
    pub(crate) fn strike_weight_for_inertia(
        &self,
        inertia_kg: f64,
        ratio: f64,
        whippen_at_front_g: f64,
        balance_weight_g: f64,
    ) -> f64 {
        let at = |strike_g: f64| {
            let front_g = whippen_at_front_g + ratio * strike_g - balance_weight_g;
            self.inertia_kg(strike_g, front_g, ratio)
        };
        (inertia_kg - at(0.0)) / (at(1.0) - at(0.0))
    }

    /// Factor of the action weight (KR WW and R SW alike) for a capstan move of `by_mm` toward the player: the key's
    /// arm gets shorter, the whippen's longer.
    #[must_use]
    pub(crate) fn capstan_factor(&self, by_mm: f64) -> f64 {
        (self.capstan_mm - by_mm) / self.capstan_mm * self.heel_mm / (self.heel_mm + by_mm)
    }

    /// Move of the capstan for such a factor, mm, positive toward the player: the inverse of
    /// [`KeyModel::capstan_factor`].
    #[must_use]
    pub(crate) fn capstan_move_mm(&self, factor: f64) -> f64 {
        let (c, h) = (self.capstan_mm, self.heel_mm);
        c * h * (1.0 - factor) / (h + factor * c)
    }
}

/// Moment of inertia of a part and all parts on it about its pin, as drawn, kg m2.
fn stack_inertia_kg_m2(instrument: &Instrument, part: usize) -> f64 {
    let drawn = instrument.drawn();
    Parts::riders(instrument, part)
        .map(|body| {
            let own = &instrument.bodies[body];
            let center = drawn[body].direction_to_world(own.center_of_mass_m);
            let from_part = sub(drawn[body].to_world(own.center_of_mass_m), drawn[part].pivot_m);
            own.inertia_kg_m2 + own.mass_kg * (dot(from_part, from_part) - dot(center, center))
        })
        .sum()
}

/// Adds a point mass to a body at a point of its frame, kg and m (negative: removes it). Changes mass, centre of mass
/// and inertia about the pin.
///
/// # Errors
/// See [`Instrument::edit`].
pub(crate) fn add_mass(
    instrument: &mut Instrument,
    body: usize,
    mass_kg: f64,
    [x, y]: Vec2,
) -> Result<(), InvalidInstrument> {
    instrument.edit(|fields| {
        let body = &mut fields.bodies[body];
        let total = body.mass_kg + mass_kg;
        let [cx, cy] = body.center_of_mass_m;
        body.center_of_mass_m = [(cx * body.mass_kg + x * mass_kg) / total, (cy * body.mass_kg + y * mass_kg) / total];
        body.mass_kg = total;
        body.inertia_kg_m2 += mass_kg * (x * x + y * y);
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::inertia::inertia;

    /// The scale's numbers are the sheet's. The static inertia equals that from the kinetic energy of the simulated
    /// action, half-way, to 3 %: the ratio of the equation of balance holds at another place of the stroke.
    #[test]
    fn the_built_in_grand() {
        let grand = Instrument::builtin("concert-grand").unwrap();
        let model = KeyModel::of(&grand).unwrap();
        assert!((model.strike_weight_g - 8.7).abs() < 0.01 && (model.key_front_mm - 265.0).abs() < 1.0, "{model:?}");
        let simulated = inertia(&grand, 2.0 * HALF_WAY_M, &mut |_| true).unwrap().half_way;
        let ratio = {
            let mut levers = Levers::of(&grand).unwrap();
            levers.ratios(HALF_WAY_M).unwrap()[1] * grand.locked().roles.hammer_strike_point_m[0] / levers.key_front_m
        };
        let ours = model.inertia_kg(model.strike_weight_g, model.front_weight_g, ratio);
        assert!((ours / simulated.total_kg() - 1.0).abs() < 0.03, "{ours} {simulated:?}");
        assert!((1e-3 * model.key_inertia_g / simulated.key_kg - 1.0).abs() < 0.01, "{model:?} {simulated:?}");
        assert!((1e-3 * model.whippen_inertia_g / simulated.whippen_kg - 1.0).abs() < 0.05, "{model:?} {simulated:?}");
    }

    /// A move and its reverse cancel; by hand, 145 mm and 60 mm with 5 mm toward the player make 140/145 x 60/65.
    #[test]
    fn capstans_by_hand() {
        let model = KeyModel {
            capstan_mm: 145.0,
            heel_mm: 60.0,
            ..KeyModel::of(&Instrument::builtin("concert-grand").unwrap()).unwrap()
        };
        assert!((model.capstan_factor(5.0) - 140.0 / 145.0 * 60.0 / 65.0).abs() < 1e-12);
        for by in [-8.0, -1.0, 0.0, 3.0, 12.0] {
            assert!((model.capstan_move_mm(model.capstan_factor(by)) - by).abs() < 1e-9);
        }
    }
}

//! Leads: present ones are moved or taken out before any is added.

use super::WorklistResult;
use super::hand::{FRONT_G, Work};
use super::list::Why;
use super::planner::{Planner, is_surely_out};
use super::readings::{ReadingQuantity, Readings};
use super::weights::{WEIGHED, balance_for};
use crate::balance::{LEADS_G, Lead, lead_work};

use ReadingQuantity::{BalanceWeight, FrictionWeight, FrontWeight, Ratio, StrikeWeight};

/// Change of a front weight, g.
pub(super) struct Change {
    /// To the balance weight with the largest margin.
    wanted_g: f64,
    /// As done: under the ceiling, in steps, and moving no weight out of its range.
    pub by_g: f64,
    /// That margin; negative where no balance weight suits all weights.
    margin_g: f64,
}

impl Planner<'_, '_> {
    /// Chooses leads for the balance weight with the largest margin, with the front weight under its ceiling.
    pub(super) fn leads(&mut self, leads: &[Lead]) -> WorklistResult<()> {
        self.weigh()?;
        let out = self.out_of(&self.now);
        // A front weight above its ceiling alone stays: the weights leave no room for less lead.
        if out.is_empty() {
            return Ok(());
        }
        if is_surely_out(FrictionWeight, &self.now, self.key) {
            out.iter().for_each(|quantity| self.leave(*quantity, Why::Friction));
            return Ok(());
        }
        let (Some(Change { wanted_g, by_g, margin_g }), Some(front_g)) =
            (self.change_of_front_weight(&self.now), self.now.get(FrontWeight))
        else {
            return Ok(());
        };
        let key_front_mm = 1e3 * self.copy.roles.key_front_m[0].abs();
        let ratio = self.now.get(Ratio);
        let instead = ratio.map(|ratio| Work::Hammer { by_g: -wanted_g / ratio }).and_then(|work| work.in_steps());
        let instead = instead.filter(|work| {
            let [low, high] = StrikeWeight.range(self.key);
            self.now.get(StrikeWeight).is_some_and(|own| (low..=high).contains(&(own + work.amount())))
        });
        if by_g != 0.0 {
            let work = if leads.is_empty() && by_g < 0.0 && front_g + by_g > 0.0 {
                // Some leads stand in front; the technician must see which.
                Some(Work::FrontWeight { by_g })
            } else {
                lead_work(by_g, key_front_mm, &LEADS_G, leads).map(Work::Leads)
            };
            self.do_it(BalanceWeight, &work.unwrap_or(Work::FrontWeight { by_g }), instead)?;
        }
        for quantity in WEIGHED {
            if self.is_out(quantity) {
                let why = if wanted_g > by_g + FRONT_G {
                    Why::Ceiling
                } else if margin_g < 0.0 && self.now.beyond(quantity, self.key) > quantity.precision() {
                    Why::NoBalance
                } else {
                    Why::TooFine
                };
                self.leave(quantity, why);
            }
        }
        Ok(())
    }

    /// Down-weight, up-weight and balance weight, where these readings have them out of range.
    fn out_of(&self, readings: &Readings) -> Vec<ReadingQuantity> {
        WEIGHED.into_iter().filter(|quantity| readings.is_out(*quantity, self.key)).collect()
    }

    /// Returns the change of the front weight for these readings; `None` where one of them is missing, or all weights
    /// are in range.
    pub(super) fn change_of_front_weight(&self, now: &Readings) -> Option<Change> {
        let (friction_g, balance_g, front_g) =
            (now.get(FrictionWeight)?, now.get(BalanceWeight)?, now.get(FrontWeight)?);
        if self.out_of(now).is_empty() {
            return None;
        }
        let best = balance_for(friction_g, self.key);
        let ceiling_g = FrontWeight.range(self.key)[1].max(front_g);
        let wanted_g = balance_g - best.balance_g;
        let by_g = self.bringing_none_out(now, wanted_g.min(ceiling_g - front_g));
        let by_g = (by_g / FRONT_G).round() * FRONT_G;
        // Down-weight and up-weight are weighed in steps: leads that change them by less are not requested. A whole
        // step is, where it leaves more room than none.
        let least_g = BalanceWeight.least_change();
        let whole_g = self.bringing_none_out(now, least_g.copysign(wanted_g).min(ceiling_g - front_g));
        let by_g = if by_g.abs() >= least_g {
            by_g
        } else if whole_g.abs() >= least_g && (whole_g - wanted_g).abs() < wanted_g.abs() {
            whole_g
        } else {
            0.0
        };
        Some(Change { wanted_g, by_g, margin_g: best.margin_g })
    }

    /// Less of a front weight, g: down-weight, up-weight and balance weight fall by it, and none that is in its range
    /// may leave it. Where no balance weight suits all three, the middle between them would bring another one out.
    fn bringing_none_out(&self, now: &Readings, by_g: f64) -> f64 {
        let room = |quantity: ReadingQuantity| {
            let [low, high] = quantity.range(self.key);
            now.get(quantity).map_or(0.0, |now| if by_g > 0.0 { now - low } else { high - now })
        };
        let inside = WEIGHED.into_iter().filter(|quantity| !now.is_out(*quantity, self.key));
        by_g.signum() * inside.map(room).fold(by_g.abs(), f64::min)
    }
}

//! Leads: present ones are moved or taken out before any is added.

use super::Worked;
use super::hand::{FRONT_G, Work};
use super::plan::{Planner, Why, is_surely_out};
use super::readings::Quantity;
use super::weights::balance_for;
use crate::balance::{LEADS_G, Lead, lead_work};

use Quantity::{BalanceWeight, DownWeight, FrictionWeight, FrontWeight, Ratio, StrikeWeight, UpWeight};

impl Planner<'_, '_> {
    /// Chooses leads for the balance weight with the largest margin, with the front weight under its ceiling.
    pub(super) fn leads(&mut self, leads: &[Lead]) -> Worked<()> {
        self.weigh()?;
        let out: Vec<Quantity> =
            [DownWeight, UpWeight, BalanceWeight].into_iter().filter(|quantity| self.is_out(*quantity)).collect();
        // A front weight above its ceiling alone stays: the weights leave no room for less lead.
        if out.is_empty() {
            return Ok(());
        }
        if is_surely_out(FrictionWeight, &self.now, self.key) {
            out.iter().for_each(|quantity| self.leave(*quantity, Why::Friction));
            return Ok(());
        }
        let (Some(friction_g), Some(balance_g), Some(front_g)) =
            (self.now.get(FrictionWeight), self.now.get(BalanceWeight), self.now.get(FrontWeight))
        else {
            return Ok(());
        };
        let best = balance_for(friction_g, self.key);
        let ceiling_g = FrontWeight.range(self.key)[1].max(front_g);
        let wanted_g = balance_g - best.balance_g;
        let by_g = self.bringing_none_out(wanted_g.min(ceiling_g - front_g));
        let by_g = (by_g / FRONT_G).round() * FRONT_G;
        // Down-weight and up-weight are weighed in steps: leads that change them by less are not requested. A whole
        // step is, where it leaves more room than none.
        let least_g = BalanceWeight.least_change();
        let whole_g = self.bringing_none_out(least_g.copysign(wanted_g).min(ceiling_g - front_g));
        let by_g = if by_g.abs() >= least_g {
            by_g
        } else if whole_g.abs() >= least_g && (whole_g - wanted_g).abs() < wanted_g.abs() {
            whole_g
        } else {
            0.0
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
        for quantity in [DownWeight, UpWeight, BalanceWeight] {
            if self.is_out(quantity) {
                let why = if wanted_g > by_g + FRONT_G {
                    Why::Ceiling
                } else if best.margin_g < 0.0 && self.now.beyond(quantity, self.key) > quantity.precision() {
                    Why::NoBalance
                } else {
                    Why::TooFine
                };
                self.leave(quantity, why);
            }
        }
        Ok(())
    }

    /// Less of a front weight, g: down-weight, up-weight and balance weight fall by it, and none that is in its range
    /// may leave it. Where no balance weight suits all three, the middle between them would bring another one out.
    fn bringing_none_out(&self, by_g: f64) -> f64 {
        let room = |quantity: Quantity| {
            let [low, high] = quantity.range(self.key);
            self.now.get(quantity).map_or(0.0, |now| if by_g > 0.0 { now - low } else { high - now })
        };
        let inside = [DownWeight, UpWeight, BalanceWeight].into_iter().filter(|quantity| !self.is_out(*quantity));
        by_g.signum() * inside.map(room).fold(by_g.abs(), f64::min)
    }
}

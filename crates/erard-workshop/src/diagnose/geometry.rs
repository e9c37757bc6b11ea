//! Leverage, inertia and what else follows from weights and lengths, as bands, with notes on missing readings.

use super::effect::{BALANCE, FEATURES};
use super::entry::{Known, at, entries, usual_range};
use super::healthy::WHIPPEN_AT_FRONT_G;
use crate::measure::usual::usual;

/// Range of a quantity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Band {
    /// Lower end.
    pub low: f64,
    /// Upper end.
    pub high: f64,
}

impl Band {
    /// Returns the middle, and the largest error of it.
    #[must_use]
    pub fn middle_and_error(self) -> (f64, f64) {
        (0.5 * (self.low + self.high), 0.5 * (self.high - self.low))
    }
}

/// Quantities that a technician cannot weigh, as far as they follow from readings.
#[derive(Debug, Clone, PartialEq)]
pub struct Geometry {
    /// R by the equation of balance, or as given; `None` if a reading is missing.
    pub ratio: Option<Band>,
    /// Front weight: as weighed, or from the leads.
    pub front_weight_g: Option<Band>,
    /// Effective inertia at the key's front, kg.
    pub inertia_kg: Option<Band>,
    /// Weight that follows from the others, where the ratio was read.
    pub(super) follows: Option<Follows>,
    /// Assumptions and omissions, a sentence each.
    pub notes: Vec<String>,
}

/// Weight that follows from the ratio and the other weights by the equation of balance, BW + FW = KR WW + R SW.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Follows {
    /// The features of which it is the sum, less `without`.
    pub of: &'static [usize],
    /// Balance weight that is assumed and not part of it, g.
    pub without: f64,
    /// Label of its line.
    pub label: &'static str,
    /// Its value, g.
    pub value: Band,
    /// Range of sound keys, g.
    pub usual: [f64; 2],
}

impl Follows {
    /// Name of its line.
    pub(super) fn name(&self) -> &'static str {
        FEATURES[self.of[0]]
    }
}

/// Distance from the balance pin to where the key is pressed, mm: naturals of full-size grands. The built-in grand's is
/// 265, a Steinway O's 233 (Delacour 2001).
const FRONT_MM: [f64; 2] = [230.0, 270.0];
/// Front weight of a key without leads, g: 5 in the built-in grand. An estimate.
const BARE_G: [f64; 2] = [0.0, 10.0];
/// Inertia of a key without leads and of a whippen, kg at the key's front: 0.03 and 0.006 in the built-in grand.
/// Estimates.
const WOOD_KG: [f64; 2] = [0.025, 0.050];
const WHIPPEN_KG: [f64; 2] = [0.003, 0.010];
/// A hammer's inertia about its pin over that of its strike weight at the strike point: 0.95 in the built-in grand.
const HAMMER: [f64; 2] = [0.90, 1.02];
/// Ratio half-way, where inertia is felt, over that of the weights: an estimate.
const HALF_WAY: [f64; 2] = [0.95, 1.03];
/// Places of unknown leads, as shares of the key's front arm.
const LEADS_AT: [f64; 2] = [0.25, 0.9];

impl Geometry {
    /// Computes leverage, front weight and inertia of a key from its readings.
    #[must_use]
    pub fn of(known: &Known, key: usize) -> Self {
        let mut notes = known.notes.clone();
        if let (Some(_), Some(down_g), Some(up_g)) = (known.at(at::ASSIST), known.at(at::DOWN), known.at(at::UP)) {
            let [down_g, up_g] = [down_g, up_g].map(|own| own + known.assist_g());
            notes.push(format!("without its springs or magnets: D {down_g:.1} g, U {up_g:.1} g"));
        }
        let front_weight_g = front(known, &mut notes);
        let ratio = ratio(known, front_weight_g, &mut notes);
        let follows = follows(known, key, front_weight_g, &mut notes);
        let inertia_kg = inertia(known, key, ratio, front_weight_g, &mut notes);
        Geometry { ratio, front_weight_g, inertia_kg, follows, notes }
    }
}

/// Band of a reading within its precision.
fn read(known: &Known, at: usize) -> Option<Band> {
    let precision = super::entry::entries()[at].precision;
    known.at(at).map(|x| Band { low: x - precision, high: x + precision })
}

fn front(known: &Known, notes: &mut Vec<String>) -> Option<Band> {
    if let Some(weighed) = read(known, at::FRONT) {
        return Some(weighed);
    }
    if known.leads.is_empty() {
        return None;
    }
    let moment: f64 = known.leads.iter().map(|lead| lead.mass_g * lead.at_mm).sum();
    notes.push(format!(
        "front weight from the leads: a key without leads is taken to weigh {} to {} g in front, and to be pressed {} to {} mm before its \
         pin (estimates)",
        BARE_G[0], BARE_G[1], FRONT_MM[0], FRONT_MM[1]
    ));
    let by = FRONT_MM.map(|mm| moment / mm);
    Some(Band { low: BARE_G[0] + by[0].min(by[1]), high: BARE_G[1] + by[0].max(by[1]) })
}

/// KR WW, g.
fn whippen_at_front(known: &Known, notes: &mut Vec<String>) -> Band {
    let of = |at: usize, line: &str| {
        let usual = || {
            let [low, high] = usual(line).map_or([None; 2], |range| range.at(40));
            Band { low: low.unwrap_or(0.0), high: high.unwrap_or(0.0) }
        };
        read(known, at).unwrap_or_else(usual)
    };
    if known.at(at::WHIPPEN).is_none() && known.at(at::KEY_RATIO).is_none() {
        let [middle, sd] = WHIPPEN_AT_FRONT_G;
        notes.push(format!(
            "whippen weight and key ratio were not given: the whippen is taken to weigh {middle} g at the key's front, within {:.1} g (usual \
             ranges, not this piano)",
            2.0 * sd
        ));
        return Band { low: middle - 2.0 * sd, high: middle + 2.0 * sd };
    }
    let [weight, ratio] = [of(at::WHIPPEN, "whippen_weight_g"), of(at::KEY_RATIO, "key_ratio")];
    Band { low: weight.low * ratio.low, high: weight.high * ratio.high }
}

fn ratio(known: &Known, front: Option<Band>, notes: &mut Vec<String>) -> Option<Band> {
    if let Some(given) = read(known, at::RATIO) {
        return Some(given);
    }
    let strike = read(known, at::STRIKE);
    let missing: Vec<&str> = [
        (known.balance_g().is_none(), "down-weight and up-weight"),
        (front.is_none(), "front weight (or leads with their places)"),
        (strike.is_none(), "strike weight"),
    ]
    .into_iter()
    .filter_map(|(missing, what)| missing.then_some(what))
    .collect();
    let (Some(balance), Some(front), Some(strike)) = (known.balance_g(), front, strike) else {
        notes.push(format!("leverage left out: it needs {}", missing.join(", ")));
        return None;
    };
    let whippen = whippen_at_front(known, notes);
    let assist = read(known, at::ASSIST).unwrap_or(Band { low: 0.0, high: 0.0 });
    Some(Band {
        low: (balance - 1.0 + front.low + assist.low - whippen.high) / strike.high,
        high: (balance + 1.0 + front.high + assist.high - whippen.low) / strike.low,
    })
}

/// Returns what follows where the ratio was read and one weight was not: a balance weight, front weight or strike
/// weight. Without a balance weight and a front weight, the front weight that the largest usual balance weight leaves.
fn follows(known: &Known, key: usize, front: Option<Band>, notes: &mut Vec<String>) -> Option<Follows> {
    let (ratio, strike) = (read(known, at::RATIO)?, read(known, at::STRIKE));
    let balance = known.balance_g().map(|g| Band { low: g - 1.0, high: g + 1.0 });
    let is_front_judged = entries()[at::FRONT].not_judged(key).is_none();
    let (of, label): (&'static [usize], _) = match (balance, front, strike) {
        (None, Some(_), Some(_)) => (&[BALANCE], "balance weight by the equation of balance"),
        (Some(_), Some(_), None) => (&[at::STRIKE], "strike weight by the equation of balance"),
        (Some(_), None, Some(_)) if is_front_judged => (&[at::FRONT], "front weight by the equation of balance"),
        (None, None, Some(_)) if is_front_judged => {
            (&[at::FRONT, BALANCE], "front weight at the largest usual balance weight")
        }
        _ => return None,
    };
    let usual = usual_range(FEATURES[of[0]], key)?;
    let without = if of.len() > 1 { usual_range(FEATURES[BALANCE], key)?[1] } else { 0.0 };
    let nothing = Band { low: 0.0, high: 0.0 };
    let whippen = whippen_at_front(known, notes);
    let assist = read(known, at::ASSIST).unwrap_or(nothing);
    let [balance, front] = [balance, front].map(|own| own.unwrap_or(nothing));
    let lifted = Band {
        low: balance.low + front.low + assist.low - whippen.high,
        high: balance.high + front.high + assist.high - whippen.low,
    };
    let value = match strike {
        Some(strike) => Band {
            low: ratio.low * strike.low - lifted.high - without,
            high: ratio.high * strike.high - lifted.low - without,
        },
        None => Band { low: lifted.low / ratio.high, high: lifted.high / ratio.low },
    };
    Some(Follows { of, without, label, value, usual })
}

fn inertia(
    known: &Known,
    key: usize,
    ratio: Option<Band>,
    front: Option<Band>,
    notes: &mut Vec<String>,
) -> Option<Band> {
    let Some(strike) = read(known, at::STRIKE) else {
        notes.push("inertia left out: it needs a strike weight".to_owned());
        return None;
    };
    if front.is_none() && known.leads.is_empty() {
        notes.push("inertia left out: it needs a front weight, or the leads by mass and place".to_owned());
        return None;
    }
    let ratio = ratio.unwrap_or_else(|| {
        notes.push("inertia with the usual leverage, 5.0 to 6.06, not this piano's".to_owned());
        let [low, high] = usual("strike_weight_ratio_weights").map_or([None; 2], |range| range.at(key));
        Band { low: low.unwrap_or(5.0), high: high.unwrap_or(6.06) }
    });
    let leads = if known.leads.is_empty() {
        let front = front?;
        notes.push(format!(
            "the leads' places were not given: they are taken to stand at {} to {} of the key's front arm, so that the inertia is a band",
            LEADS_AT[0], LEADS_AT[1]
        ));
        let by_leads = [front.low - BARE_G[1], front.high - BARE_G[0]].map(|g| 1e-3 * g.max(0.0));
        Band { low: by_leads[0] * LEADS_AT[0], high: by_leads[1] * LEADS_AT[1] }
    } else {
        let at = |front_mm: f64| -> f64 {
            known.leads.iter().map(|lead| 1e-3 * lead.mass_g * (lead.at_mm / front_mm).powi(2)).sum()
        };
        Band { low: at(FRONT_MM[1]), high: at(FRONT_MM[0]) }
    };
    let hammer = |factor: f64, strike_g: f64, ratio: f64| 1e-3 * factor * strike_g * ratio * ratio;
    Some(Band {
        low: hammer(HAMMER[0], strike.low, HALF_WAY[0] * ratio.low) + WOOD_KG[0] + WHIPPEN_KG[0] + leads.low,
        high: hammer(HAMMER[1], strike.high, HALF_WAY[1] * ratio.high) + WOOD_KG[1] + WHIPPEN_KG[1] + leads.high,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::balance::Lead;

    /// By hand: BW 38, FW 26, SW 10 and a whippen of 18 g at 0.5: R = (38 + 26 - 9) / 10 = 5.5. With a reading missing
    /// it is left out, with a note.
    #[test]
    fn leverage_by_hand() {
        let mut known = Known::default();
        for (name, value) in [("down_weight_g", 50.0), ("up_weight_g", 26.0), ("strike_weight_g", 10.0)] {
            known.set(name, Some(value));
        }
        let without = Geometry::of(&known, 40);
        assert!(
            without.ratio.is_none() && without.notes.iter().any(|note| note.contains("front weight")),
            "{without:?}"
        );
        known.set("front_weight_g", Some(26.0));
        known.set("whippen_weight_g", Some(18.0));
        known.set("key_ratio", Some(0.5));
        let ratio = Geometry::of(&known, 40).ratio.unwrap();
        assert!(ratio.low < 5.5 && ratio.high > 5.5 && ratio.high - ratio.low < 0.6, "{ratio:?}");
        // A spring that carries the whippen, 9 g, with as much less balance weight: the same leverage.
        for (name, g) in [("assist_g", 9.0), ("down_weight_g", 41.0), ("up_weight_g", 17.0)] {
            known.set(name, Some(g));
        }
        let sprung = Geometry::of(&known, 40);
        let (middle, own) = (ratio.low + ratio.high, sprung.ratio.unwrap());
        assert!((own.low + own.high - middle).abs() < 0.02, "{own:?}");
        assert!(sprung.notes.iter().any(|note| note.contains("D 50.0 g, U 26.0 g")), "{:?}", sprung.notes);
    }

    /// Known places of leads narrow the inertia.
    #[test]
    fn places_of_leads_narrow_the_inertia() {
        let mut known = Known::default();
        for (name, value) in
            [("down_weight_g", 50.0), ("up_weight_g", 26.0), ("strike_weight_g", 8.7), ("front_weight_g", 21.0)]
        {
            known.set(name, Some(value));
        }
        let wide = Geometry::of(&known, 40).inertia_kg.unwrap();
        known.leads = vec![Lead { mass_g: 14.0, at_mm: 164.0 }, Lead { mass_g: 14.0, at_mm: 146.0 }];
        let narrow = Geometry::of(&known, 40).inertia_kg.unwrap();
        assert!(narrow.high - narrow.low < wide.high - wide.low, "{wide:?} {narrow:?}");
    }
}

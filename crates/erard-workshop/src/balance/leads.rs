//! Leads of available masses at places where they fit.

use erard::parameter::{Quantity, list_items};

/// A lead in a key.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lead {
    /// Mass, g.
    pub mass_g: f64,
    /// Place in front of the balance pin, mm; negative behind it.
    pub at_mm: f64,
}

impl Lead {
    /// Notation of a lead, for error messages.
    pub const EXPECTED: &str =
        "grams (0.5 to 60), @ and millimetres in front of the balance pin (behind it negative), e.g. 14@165";

    /// Reads `14@165`, with or without the unit mm; `None` if the text is not a lead, or a key cannot hold the lead.
    #[must_use]
    pub fn read(text: &str) -> Option<Self> {
        let (mass, at) = text.trim().split_once('@')?;
        let (mass_g, at_mm) = (Quantity::Weight.read_in(mass, "g").ok()?, Quantity::Length.read_in(at, "mm").ok()?);
        ((0.5..=60.0).contains(&mass_g) && (-250.0..=400.0).contains(&at_mm)).then_some(Lead { mass_g, at_mm })
    }

    /// Reads a list of leads, `14@165,14@147`; between semicolons decimal commas are read.
    ///
    /// # Errors
    /// What was found and expected.
    pub fn read_list(text: &str) -> Result<Vec<Self>, String> {
        let read = |one: &str| Self::read(one).ok_or_else(|| format!("{}: expected {}", one.trim(), Self::EXPECTED));
        list_items(text).map_err(|error| format!("{text}: {error}"))?.into_iter().map(read).collect()
    }

    /// Contribution to the front weight of a key with this front arm, g.
    #[must_use]
    pub(crate) fn front_weight_g(&self, key_front_mm: f64) -> f64 {
        self.mass_g * self.at_mm / key_front_mm
    }

    /// Contribution to the inertia at the key's front, g.
    #[must_use]
    pub(crate) fn inertia_g(&self, key_front_mm: f64) -> f64 {
        self.mass_g * (self.at_mm / key_front_mm).powi(2)
    }
}

/// Default masses of available leads, g. An estimate: cylinders of lead (11.34 g/cm3) through a key 12 mm wide, of 1/2,
/// 7/16, 3/8 and 1/4 inch (12.7, 11.1, 9.5 and 6.4 mm) weigh 17.2, 13.2, 9.7 and 4.3 g; sold leads are shorter.
pub const LEADS_G: [f64; 4] = [14.0, 10.0, 7.0, 4.0];
/// Most leads added to a key.
pub(crate) const MAX_LEADS: usize = 3;
/// Smaller changes of front weight are not made, g: half the resolution of a scale in grams.
pub(crate) const FEWEST_GRAMS: f64 = 0.5;
/// Largest error of the front weight from leads, g.
const CLOSE_G: f64 = 0.25;
/// Least distance of leads from the pin, and from the key's front, mm: balance hole and front pin's mortise need their
/// wood.
const NEAR_PIN_MM: f64 = 40.0;
const NEAR_FRONT_MM: f64 = 60.0;
/// Least distance between two leads, mm: a lead is 12.7 mm wide, with some wood between.
const APART_MM: f64 = 16.0;

/// Work on the leads of a key.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LeadWork {
    /// Leads taken out.
    pub out: Vec<Lead>,
    /// Leads put in.
    pub put: Vec<Lead>,
    /// Change of the front weight, g.
    pub front_weight_g: f64,
    /// Change of the inertia at the front, g.
    pub inertia_g: f64,
}

impl LeadWork {
    /// Sorts the work lead by lead: moves (from, to), leads removed for good, and new leads. A lead is moved if one of
    /// the same mass is both taken out and put in.
    #[must_use]
    pub fn moved(&self) -> (Vec<[Lead; 2]>, Vec<Lead>, Vec<Lead>) {
        let (mut moves, mut out, mut new) = (Vec::new(), self.out.clone(), Vec::new());
        for put in &self.put {
            match out.iter().position(|old| old.mass_g == put.mass_g) {
                Some(at) => moves.push([out.remove(at), *put]),
                None => new.push(*put),
            }
        }
        (moves, out, new)
    }
}

/// Assumed place of a lead whose place is unknown, as a share of the key's front arm: an estimate (the built-in grand's
/// two leads stand at 0.62 and 0.55 of it).
pub(super) const LEADS_AT: f64 = 0.6;

/// Returns the change of inertia at the key's front, g, when a lead at an unknown place moves toward the front by
/// `by_mm`. The place is an estimate.
#[must_use]
pub fn moved_inertia_g(mass_g: f64, by_mm: f64, key_front_mm: f64) -> f64 {
    let from = Lead { mass_g, at_mm: LEADS_AT * key_front_mm };
    let to = Lead { mass_g, at_mm: from.at_mm + by_mm };
    to.inertia_g(key_front_mm) - from.inertia_g(key_front_mm)
}

/// Leads for a change of front weight, and an alternative.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LeadChoice {
    /// Preferred work: present leads are moved or taken out before any is added.
    pub work: LeadWork,
    /// Alternative if the choice takes out or moves leads: leads that would be added with nothing taken out.
    pub adding: Option<LeadWork>,
}

/// [`lead_work`], with the leads to add if the present ones stay.
#[must_use]
pub(crate) fn lead_choice(change_g: f64, key_front_mm: f64, masses_g: &[f64], present: &[Lead]) -> Option<LeadChoice> {
    let work = lead_work(change_g, key_front_mm, masses_g, present)?;
    let adding = if work.out.is_empty() { None } else { best_work(change_g, key_front_mm, masses_g, present, true) };
    Some(LeadChoice { work, adding })
}

/// Returns the leads for a change of front weight, at whole millimetres. `present` are the key's own leads where known:
/// they are moved or taken out before any is added, nothing is put where one of them stays, and nothing goes behind the
/// pin if several stand in front. Among the rest, the fewest holes are plugged and bored, with the least inertia.
/// `None` if no leads come within a quarter of a gram, e.g. if a key must lose more front weight than its known leads
/// have.
#[must_use]
pub(crate) fn lead_work(change_g: f64, key_front_mm: f64, masses_g: &[f64], present: &[Lead]) -> Option<LeadWork> {
    if change_g.abs() < FEWEST_GRAMS {
        return Some(LeadWork::default());
    }
    best_work(change_g, key_front_mm, masses_g, present, false)
}

/// Returns the best work, or the best that takes nothing out.
fn best_work(change_g: f64, key_front_mm: f64, masses_g: &[f64], present: &[Lead], all_stay: bool) -> Option<LeadWork> {
    let mut best: Option<([usize; 2], f64, LeadWork)> = None;
    // The present leads that may come out: few keys have more than five.
    let known = &present[..if all_stay { 0 } else { present.len().min(8) }];
    let several_in_front = present.iter().filter(|lead| lead.at_mm > 0.0).count() > 1;
    for set in 0..1_usize << known.len() {
        let out: Vec<Lead> = (0..known.len()).filter(|i| set >> i & 1 == 1).map(|i| known[i]).collect();
        let taken: f64 = out.iter().map(|lead| lead.front_weight_g(key_front_mm)).sum();
        let mut masses: Vec<f64> = masses_g.iter().copied().chain(out.iter().map(|lead| lead.mass_g)).collect();
        masses.sort_by(|a, b| b.total_cmp(a));
        masses.dedup();
        let places = places(change_g + taken, key_front_mm);
        for mass_g in (0..=MAX_LEADS).flat_map(|count| choices(&masses, count)) {
            if places[0] < 0.0 && several_in_front && !mass_g.is_empty() {
                continue;
            }
            let added = added(&mass_g, &out);
            // A moved lead leaves one hole to plug and needs a new one.
            let cost = [added, out.len() + mass_g.len()];
            if best.as_ref().is_some_and(|(least, ..)| cost > *least) {
                continue;
            }
            // Neither beside a lead that stays, nor into the plug of one that comes out.
            let Some(put) = stand((change_g + taken) * key_front_mm, &mass_g, places, present) else { continue };
            let sum = |of: fn(&Lead, f64) -> f64, leads: &[Lead]| -> f64 {
                leads.iter().map(|lead| of(lead, key_front_mm)).sum()
            };
            let front_weight_g = sum(Lead::front_weight_g, &put) - taken;
            if (front_weight_g - change_g).abs() > CLOSE_G {
                continue;
            }
            let inertia_g = sum(Lead::inertia_g, &put) - sum(Lead::inertia_g, &out);
            if best.as_ref().is_none_or(|(least, lowest, _)| (cost, inertia_g) < (*least, *lowest)) {
                best = Some((cost, inertia_g, LeadWork { out: out.clone(), put, front_weight_g, inertia_g }));
            }
        }
    }
    best.map(|(.., work)| work)
}

/// Number of masses put in that are not among those taken out.
fn added(mass_g: &[f64], out: &[Lead]) -> usize {
    let mut left: Vec<f64> = out.iter().map(|lead| lead.mass_g).collect();
    let is_new = |mass: &&f64| match left.iter().position(|old| old == *mass) {
        Some(at) => {
            left.swap_remove(at);
            false
        }
        None => true,
    };
    mass_g.iter().filter(is_new).count()
}

/// Range of places for leads, mm from the pin: in front of it to add front weight, behind it to reduce it.
fn places(change_g: f64, key_front_mm: f64) -> [f64; 2] {
    let [near, far] = [NEAR_PIN_MM, key_front_mm - NEAR_FRONT_MM];
    if change_g > 0.0 { [near, far] } else { [-far.min(BEHIND_MM), -near] }
}

/// Farthest place of leads behind the pin, mm: they stand before the capstan.
const BEHIND_MM: f64 = 120.0;

/// Returns all combinations of `count` of the masses, with repetition.
fn choices(masses_g: &[f64], count: usize) -> Vec<Vec<f64>> {
    if count == 0 {
        return vec![Vec::new()];
    }
    let mut all = Vec::new();
    for (i, mass) in masses_g.iter().enumerate() {
        for mut rest in choices(&masses_g[i..], count - 1) {
            rest.push(*mass);
            all.push(rest);
        }
    }
    all
}

/// Places leads of these masses side by side, so that mass times place is `moment` (g mm) to the nearest whole
/// millimetre of the group. They keep their distance from each other and from present holes. Without masses there are
/// no leads.
fn stand(moment: f64, masses_g: &[f64], [from, to]: [f64; 2], holes: &[Lead]) -> Option<Vec<Lead>> {
    if masses_g.is_empty() {
        return Some(Vec::new());
    }
    let total: f64 = masses_g.iter().sum();
    let offset = |i: usize| (i as f64 - 0.5 * (masses_g.len() - 1) as f64) * APART_MM;
    let middle_mm = (moment - masses_g.iter().enumerate().map(|(i, mass)| mass * offset(i)).sum::<f64>()) / total;
    let group = |middle_mm: f64| -> Vec<Lead> {
        let each = masses_g.iter().enumerate();
        each.map(|(i, mass_g)| Lead { mass_g: *mass_g, at_mm: (middle_mm + offset(i)).round() }).collect()
    };
    // A single lead may stand at an end of the range; the caller checks whether its moment is near enough.
    let middle_mm = if masses_g.len() == 1 { middle_mm.clamp(from, to) } else { middle_mm };
    let fits = |put: &[Lead]| {
        put.iter().all(|lead| {
            (from..=to).contains(&lead.at_mm) && holes.iter().all(|other| (other.at_mm - lead.at_mm).abs() >= APART_MM)
        })
    };
    let put = group(middle_mm);
    if fits(&put) {
        return Some(put);
    }
    // Spread around the holes in the way: the same moment with wider distances.
    (1..=6)
        .map(|wider| {
            let spread = 1.0 + 0.5 * f64::from(wider);
            let each = masses_g.iter().enumerate();
            let middle_mm =
                (moment - masses_g.iter().enumerate().map(|(i, mass)| mass * offset(i) * spread).sum::<f64>()) / total;
            each.map(|(i, mass_g)| Lead { mass_g: *mass_g, at_mm: (middle_mm + offset(i) * spread).round() })
                .collect::<Vec<Lead>>()
        })
        .find(|put| masses_g.len() > 1 && fits(put))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRONT_MM: f64 = 250.0;

    /// By hand: 5 g at a front 250 mm from the pin are 1250 g mm: 14 g at 89 mm (1246). It is the least inertia of one
    /// lead, because the heaviest stands nearest.
    #[test]
    fn one_lead_by_hand() {
        let work = lead_work(5.0, FRONT_MM, &LEADS_G, &[]).unwrap();
        assert_eq!((work.out.len(), work.put.as_slice()), (0, &[Lead { mass_g: 14.0, at_mm: 89.0 }][..]));
        assert!((work.front_weight_g - 14.0 * 89.0 / 250.0).abs() < 1e-12);
        assert!((work.inertia_g - 14.0 * (89.0_f64 / 250.0).powi(2)).abs() < 1e-12);
        // With small leads only, the same weight stands further out: 7 g at 179 mm.
        assert_eq!(lead_work(5.0, FRONT_MM, &[7.0], &[]).unwrap().put, [Lead { mass_g: 7.0, at_mm: 179.0 }]);
    }

    /// Every change comes out to within half a gram, with available leads at whole millimetres, in the wood, and apart.
    #[test]
    fn what_is_asked_for_comes_out() {
        for tenths in 5..=280 {
            let change = f64::from(tenths) / 10.0;
            let work = lead_work(change, FRONT_MM, &LEADS_G, &[]).unwrap_or_else(|| panic!("{change}"));
            let sum: f64 = work.put.iter().map(|lead| lead.mass_g * lead.at_mm).sum();
            assert!((sum / FRONT_MM - change).abs() <= CLOSE_G, "{change}: {work:?}");
            for (i, lead) in work.put.iter().enumerate() {
                assert!(LEADS_G.contains(&lead.mass_g) && lead.at_mm == lead.at_mm.round());
                assert!((40.0..=190.0).contains(&lead.at_mm), "{change}: {work:?}");
                assert!(work.put[..i].iter().all(|other| (other.at_mm - lead.at_mm).abs() >= APART_MM - 1.0));
            }
        }
    }

    /// One lead is preferred to two, even if the heaviest would stand too near to the pin: 2.1 g at a front of 265 mm
    /// are 14 g at 40 mm, 1.8 g are 10 g at 48 mm.
    #[test]
    fn one_lead_is_better_than_two() {
        assert_eq!(lead_work(2.1, 265.0, &LEADS_G, &[]).unwrap().put, [Lead { mass_g: 14.0, at_mm: 40.0 }]);
        assert_eq!(lead_work(1.8, 265.0, &LEADS_G, &[]).unwrap().put, [Lead { mass_g: 10.0, at_mm: 48.0 }]);
    }

    const fn lead(mass_g: f64, at_mm: f64) -> Lead {
        Lead { mass_g, at_mm }
    }

    /// A present lead comes out where that is enough, and nothing is put where another stays.
    #[test]
    fn present_leads_are_used() {
        let present = [lead(14.0, 150.0), lead(14.0, 100.0)];
        let work = lead_work(-5.6, FRONT_MM, &LEADS_G, &present).unwrap();
        assert_eq!((work.out.as_slice(), work.put.len()), (&[lead(14.0, 100.0)][..], 0));
        // 5.6 g at a front 250 mm away are 14 g moved by 100 mm, from 100 mm to where no lead may stand: one is added.
        let work = lead_work(5.6, FRONT_MM, &LEADS_G, &present[1..]).unwrap();
        assert_eq!((work.out.len(), work.put.len()), (0, 1), "{work:?}");
        // 3 g are 54 mm for one of them: the inner one would come to the other's hole, the outer one into the front
        // pin's mortise. Both move.
        let work = lead_work(3.0, FRONT_MM, &LEADS_G, &present).unwrap();
        let (moves, out, new) = work.moved();
        assert_eq!((moves.len(), out.len(), new.len()), (2, 0, 0), "{work:?}");
    }

    /// By hand: 2 g less at a front 250 mm away are 14 g moved toward the pin by 36 mm (2.016 g). Nothing is added, and
    /// nothing goes behind the pin.
    #[test]
    fn a_lead_is_moved_before_one_is_added() {
        let present = [lead(14.0, 165.0), lead(14.0, 147.0)];
        let work = lead_work(-2.0, FRONT_MM, &LEADS_G, &present).unwrap();
        let (moves, out, new) = work.moved();
        assert_eq!((out.len(), new.len()), (0, 0), "{work:?}");
        assert_eq!(moves, [[lead(14.0, 165.0), lead(14.0, 129.0)]]);
        assert!((work.front_weight_g + 14.0 * 36.0 / 250.0).abs() < 1e-12);
    }

    /// By hand, at a front 250 mm away. 2 g less: a move of 14 g toward the pin takes inertia off, 14 g x (165^2 -
    /// 129^2) / 250^2, and with two leads in front none is added behind the pin. 2 g more: 14 g moved out by 36 mm, or
    /// a lead added near the pin, with less inertia than the move.
    #[test]
    fn moving_is_compared_with_adding() {
        let present = [lead(14.0, 165.0), lead(14.0, 147.0)];
        let less = lead_choice(-2.0, FRONT_MM, &LEADS_G, &present).unwrap();
        assert_eq!(less.adding, None);
        let by_hand = -14.0 * (165.0_f64.powi(2) - 129.0_f64.powi(2)) / FRONT_MM.powi(2);
        assert!((less.work.inertia_g - by_hand).abs() < 1e-12, "{less:?}");
        let one = [lead(14.0, 120.0)];
        let more = lead_choice(2.0, FRONT_MM, &LEADS_G, &one).unwrap();
        assert_eq!((more.work.out.len(), more.work.put[0].at_mm), (1, 156.0), "{more:?}");
        let adding = more.adding.unwrap();
        assert!(adding.out.is_empty() && (adding.front_weight_g - 2.0).abs() <= CLOSE_G, "{adding:?}");
        let put = adding.put[0];
        assert!((adding.inertia_g - put.mass_g * (put.at_mm / FRONT_MM).powi(2)).abs() < 1e-12);
        assert!(adding.inertia_g < more.work.inertia_g);
    }

    /// With several leads in front none goes behind the pin for any change, and none is added while moving the present
    /// ones is enough.
    #[test]
    fn nothing_behind_the_pin_where_several_stand_in_front() {
        let present = [lead(14.0, 165.0), lead(10.0, 120.0), lead(7.0, 80.0)];
        for halves in -40..=20_i32 {
            let change_g = 0.5 * f64::from(halves);
            let Some(work) = lead_work(change_g, FRONT_MM, &LEADS_G, &present) else { continue };
            assert!(work.put.iter().all(|lead| lead.at_mm > 0.0), "{change_g}: {work:?}");
            let stays = present.iter().filter(|lead| !work.out.contains(lead));
            for stays in stays {
                assert!(work.put.iter().all(|put| (put.at_mm - stays.at_mm).abs() >= APART_MM), "{change_g}: {work:?}");
            }
            if (-8.0..0.0).contains(&change_g) {
                assert!(work.moved().2.is_empty(), "{change_g}: {work:?}");
            }
        }
        assert!(lead_work(-2.0, FRONT_MM, &LEADS_G, &present).is_some());
    }

    /// Without known leads a front that is too heavy gets one behind the pin; a change below half a gram is not made.
    #[test]
    fn behind_the_pin_and_nothing() {
        let work = lead_work(-3.0, FRONT_MM, &LEADS_G, &[]).unwrap();
        assert!(work.put.len() == 1 && work.put[0].at_mm < 0.0 && (work.front_weight_g + 3.0).abs() <= CLOSE_G);
        assert_eq!(lead_work(0.4, FRONT_MM, &LEADS_G, &[]), Some(LeadWork::default()));
        assert_eq!(lead_work(200.0, FRONT_MM, &LEADS_G, &[]), None);
    }
}

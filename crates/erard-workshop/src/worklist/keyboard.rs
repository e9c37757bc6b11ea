//! Work list of a weighed keyboard, by operation: friction first, then hammers, then leads.
//!
//! Friction is in every weight. A key whose friction is out of range therefore gets this line only, and is weighed
//! again before other work. In each operation the first and the last key of every section come first: these samples
//! show whether the operation works before the rest follows.

use erard::keyboard::KEYS;

use super::hand::Work;
use super::list::Why;
use super::readings::ReadingQuantity;
use super::weights::{balance_for, best_friction_g, friction_change_g};
use crate::balance::{
    BalancedKey, KeyModel, LEAST_BALANCE_G, MOST_CAPSTAN_MM, MeasuredKey, Plan, Target, UNTAPPED_G, median, plan,
};
use crate::measure::usual::{ratio_factor, ratio_range, usual};

use ReadingQuantity::{FrictionWeight, Ratio};

/// Fewest keys for a median balance weight.
const FEWEST: usize = 4;
/// Fewest keys with one cause.
const COMMON_KEYS: usize = 3;
/// Ends of the ideal ratio: Stanwood 1995.
const IDEAL_RATIO: [f64; 2] = [5.5, 5.75];
/// Balance weight at which the trade aims, g: Love 38 to 40 (CAUT list), Stanwood 38.
const TRADE_G: f64 = 38.0;
/// Last keys of the string sections except the highest: an estimate for a concert grand. Every piano has its own.
pub const SECTION_ENDS: [usize; 3] = [20, 50, 70];

/// Source of the target balance weight.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum AimFrom {
    /// The caller's target.
    Asked,
    /// The median of the weighed keys.
    Median,
    /// The balance weight nearest to that median for which D, U and balance weight are usual at every key, if the
    /// median is farther from it than a hand can weigh.
    NearMedian,
    /// The trade's 38 g, if too few keys were weighed for a median.
    Trade,
}

/// An operation over the keyboard.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Operation {
    /// Easing of friction, or repinning.
    Friction,
    /// Weight off or on hammers.
    Hammers,
    /// Leads.
    Leads,
}

impl Operation {
    /// All operations, in the order of work.
    pub const ALL: [Operation; 3] = [Operation::Friction, Operation::Hammers, Operation::Leads];
}

/// Weights of a key, g; `None` if unknown.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Weights {
    /// D.
    pub down_g: Option<f64>,
    /// U.
    pub up_g: Option<f64>,
    /// SW.
    pub strike_g: Option<f64>,
    /// FW.
    pub front_g: Option<f64>,
}

/// A line of work.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyLine {
    /// The operation.
    pub operation: Operation,
    /// The key.
    pub key: usize,
    /// Whether the key is the first or the last of its section in this operation.
    pub is_sample: bool,
    /// The work.
    pub work: Work,
    /// Leads to add instead, if the work moves or takes out leads.
    pub instead: Option<Work>,
    /// Weights expected after it.
    pub after: Weights,
}

/// Leverage that is out of its range at most of the keys: one cause of the whole keyboard.
#[derive(Debug, Clone, PartialEq)]
pub struct Leverage {
    /// Keys whose ratio is out on this side.
    pub keys: Vec<usize>,
    /// Number of keys whose ratio follows from their own weights.
    pub of: usize,
    /// Smallest and largest of these ratios.
    pub ratios: [f64; 2],
    /// Ratio to aim at, of naturals.
    pub aim: f64,
    /// Move of the capstan line toward the player, mm: the median over the keys, no more than is possible.
    pub capstan_move_mm: f64,
    /// Median ratio of the keys after it, sharps as naturals.
    pub reaches: f64,
}

/// Work list of a keyboard.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct KeyboardList {
    /// Plan with the results of the weights, key by key.
    pub plan: Plan,
    /// Source of the plan's target balance weight.
    pub aim_from: AimFrom,
    /// Leverage, before hammers and leads; `None` if it is usual, or known at too few keys.
    pub leverage: Option<Leverage>,
    /// The lines, in the order of work.
    pub lines: Vec<KeyLine>,
    /// Keys with a quantity that stays off its target or out of range, and the reason.
    pub left: Vec<(usize, Why)>,
}

impl KeyboardList {
    /// Whether the friction of a key is out of its range by more than the reading's error.
    #[must_use]
    pub fn is_friction_out(key: &BalancedKey) -> bool {
        let untapped_g = if key.measured.is_untapped { UNTAPPED_G } else { 0.0 };
        beyond_g(key).is_some_and(|by_g| by_g > FrictionWeight.precision() + untapped_g)
    }

    /// Whether hammers and leads of a key wait for friction or leverage, after which it is weighed again.
    #[must_use]
    pub fn waits(&self, key: &BalancedKey) -> bool {
        Self::is_friction_out(key) || self.leverage.as_ref().is_some_and(|out| out.keys.contains(&key.measured.key))
    }

    /// Whether it is out of range by less than the reading's error.
    #[must_use]
    pub fn is_friction_doubtful(key: &BalancedKey) -> bool {
        beyond_g(key).is_some_and(|by_g| by_g > 0.0) && !Self::is_friction_out(key)
    }

    /// The friction weights of a key beyond which it is a fault, as `erard diagnose` judges them, g: little friction is
    /// none.
    #[must_use]
    pub fn usual_friction_g(key: usize) -> [f64; 2] {
        let [_, high] = usual(FrictionWeight.key()).map_or([None; 2], |range| range.faults(key));
        [0.0, high.unwrap_or(f64::INFINITY)]
    }
}

/// Distance of a key's friction reading from its range, g: 0 inside.
fn beyond_g(key: &BalancedKey) -> Option<f64> {
    let [_, high] = KeyboardList::usual_friction_g(key.measured.key);
    Some((key.friction_weight_g? - high).max(0.0))
}

/// Targets of a keyboard.
#[derive(Debug, Clone, PartialEq)]
pub struct KeyboardGoal {
    /// Balance weight of every key, g; `None`: see [`AimFrom`].
    pub balance_weight_g: Option<f64>,
    /// Ratio of the naturals; `None`: the upper end of the ideal, if the ratio is out of its range.
    pub ratio: Option<f64>,
    /// Target inertia as in [`Target`], kg.
    pub inertia_kg: Option<f64>,
    /// Whether hammers are weighed first, as in [`Target`].
    pub hammers: bool,
    /// Masses of available leads, g.
    pub leads_g: Vec<f64>,
    /// Last keys of the string sections, without the highest section.
    pub section_ends: Vec<usize>,
}

/// Makes the work list. `models` has every key's model, the first key at index 0. `None` if no balance weight was
/// requested and no key has both weights.
#[must_use]
pub fn keyboard_list(measured: &[MeasuredKey], models: &[KeyModel; KEYS], goal: &KeyboardGoal) -> Option<KeyboardList> {
    let (balance_weight_g, aim_from) = match goal.balance_weight_g {
        Some(asked_g) => (asked_g, AimFrom::Asked),
        None => aim(measured)?,
    };
    let target = Target { balance_weight_g, inertia_kg: goal.inertia_kg, hammers: goal.hammers };
    let plan = plan(measured, models, target, &goal.leads_g);
    let (mut lines, mut left) = (Vec::new(), Vec::new());
    let leverage = leverage(&plan, goal.ratio);
    let is_lever_out = |key: &BalancedKey| leverage.as_ref().is_some_and(|out| out.keys.contains(&key.measured.key));
    for key in &plan.keys {
        let of_key = lines_of(key);
        if KeyboardList::is_friction_out(key) {
            if of_key.len() > 1 || of_key.iter().any(|line| line.operation != Operation::Friction) {
                left.push((key.measured.key, Why::Friction));
            }
            lines.extend(of_key.into_iter().filter(|line| line.operation == Operation::Friction));
            continue;
        }
        if is_lever_out(key) {
            if !of_key.is_empty() || key.is_at_ceiling {
                left.push((key.measured.key, Why::Leverage));
            }
            continue;
        }
        if key.is_at_ceiling {
            left.push((key.measured.key, Why::Ceiling));
        }
        lines.extend(of_key);
    }
    samples(&mut lines, &goal.section_ends);
    lines.sort_by_key(|line| (line.operation, !line.is_sample, line.key));
    Some(KeyboardList { plan, aim_from, leverage, lines, left })
}

/// Leverage of a keyboard whose ratio is out of its range, or off a requested one, at three keys and half of those
/// where it is known.
fn leverage(plan: &Plan, asked: Option<f64>) -> Option<Leverage> {
    let own = |key: &&BalancedKey| {
        let weighed = &key.measured;
        weighed.front_weight_g.is_some() && weighed.strike_weight_g.is_some() && weighed.balance_weight_g().is_some()
    };
    let known: Vec<(&BalancedKey, f64)> =
        plan.keys.iter().filter(own).filter_map(|key| Some((key, key.ratio?))).collect();
    let side = |key: &BalancedKey, ratio: f64| {
        let [low, high] = match asked {
            Some(aim) => [aim * ratio_factor(key.measured.key); 2],
            None => ratio_range(key.measured.key),
        };
        if ratio > high + Ratio.precision() {
            1
        } else if ratio < low - Ratio.precision() {
            -1
        } else {
            0
        }
    };
    let of_side = |wanted: i32| -> Vec<(&BalancedKey, f64)> {
        known.iter().filter(|(key, ratio)| side(key, *ratio) == wanted).copied().collect()
    };
    let out = [1, -1].map(of_side).into_iter().max_by_key(Vec::len)?;
    if out.len() < COMMON_KEYS || 2 * out.len() < known.len() {
        return None;
    }
    let aim = asked.unwrap_or(if side(out[0].0, out[0].1) > 0 { IDEAL_RATIO[1] } else { IDEAL_RATIO[0] });
    let middle = |of: &dyn Fn(&BalancedKey, f64) -> f64| {
        median(&out.iter().map(|(key, ratio)| of(key, *ratio)).collect::<Vec<_>>())
    };
    let of_natural = |key: &BalancedKey, ratio: f64| ratio / ratio_factor(key.measured.key);
    let wanted_mm = middle(&|key: &BalancedKey, ratio: f64| key.model.capstan_move_mm(aim / of_natural(key, ratio)))?;
    let capstan_move_mm = wanted_mm.clamp(-MOST_CAPSTAN_MM, MOST_CAPSTAN_MM);
    let reaches =
        middle(&|key: &BalancedKey, ratio: f64| of_natural(key, ratio) * key.model.capstan_factor(capstan_move_mm))?;
    let ratios = out.iter().map(|(_, ratio)| *ratio);
    let ends = [ratios.clone().fold(f64::INFINITY, f64::min), ratios.fold(f64::NEG_INFINITY, f64::max)];
    let keys = out.iter().map(|(key, _)| key.measured.key).collect();
    Some(Leverage { keys, of: known.len(), ratios: ends, aim, capstan_move_mm, reaches })
}

/// Returns the default target balance weight, g. Each key allows those for which D, U and balance weight are all usual
/// at the best friction.
fn aim(measured: &[MeasuredKey]) -> Option<(f64, AimFrom)> {
    let own = |key: &MeasuredKey| Some((key.key, key.balance_weight_g()?));
    let balances: Vec<(usize, f64)> = measured.iter().filter_map(own).collect();
    let middle = median(&balances.iter().map(|(_, balance_g)| *balance_g).collect::<Vec<_>>())?;
    let borne = balances.iter().map(|(key, _)| balance_for(best_friction_g(*key), *key));
    let [low, high] = borne.fold([f64::NEG_INFINITY, f64::INFINITY], |[low, high], one| {
        [low.max(one.balance_g - one.margin_g), high.min(one.balance_g + one.margin_g)]
    });
    let borne_g = |aim_g: f64| if low <= high { aim_g.clamp(low, high) } else { 0.5 * (low + high) };
    if balances.len() < FEWEST {
        return Some((borne_g(TRADE_G), AimFrom::Trade));
    }
    let near_g = borne_g(middle);
    // A target nearer than that would move some keys and leave their neighbours.
    let is_near = (middle - near_g).abs() < LEAST_BALANCE_G;
    Some(if is_near { (middle, AimFrom::Median) } else { (near_g, AimFrom::NearMedian) })
}

/// Returns the lines of a key, in the order of work.
fn lines_of(key: &BalancedKey) -> Vec<KeyLine> {
    let number = key.measured.key;
    let mut now = Weights {
        down_g: key.measured.down_weight_g,
        up_g: key.measured.up_weight_g,
        strike_g: key.measured.strike_weight_g,
        front_g: key.measured.front_weight_g,
    };
    let mut lines = Vec::new();
    let mut push = |operation, work, instead, after| {
        lines.push(KeyLine { operation, key: number, is_sample: false, work, instead, after });
    };
    let by = |weight: &mut Option<f64>, by_g: Option<f64>| *weight = weight.zip(by_g).map(|(now, by_g)| now + by_g);
    if let Some(friction_g) = key.friction_weight_g.filter(|_| KeyboardList::is_friction_out(key)) {
        let by_g = friction_change_g(friction_g, best_friction_g(number), number);
        if by_g != 0.0 {
            by(&mut now.down_g, Some(by_g));
            by(&mut now.up_g, Some(-by_g));
            push(Operation::Friction, Work::Friction { by_g }, None, now);
        }
    }
    if key.hammer_change_g != 0.0 {
        let by_g = key.hammer_change_g;
        let at_key_g = key.ratio.map(|ratio| ratio * by_g);
        by(&mut now.strike_g, Some(by_g));
        by(&mut now.down_g, at_key_g);
        by(&mut now.up_g, at_key_g);
        push(Operation::Hammers, Work::Hammer { by_g }, None, now);
    }
    if let Some(by_g) = key.front_change_g.filter(|by_g| *by_g != 0.0) {
        by(&mut now.front_g, Some(by_g));
        by(&mut now.down_g, Some(-by_g));
        by(&mut now.up_g, Some(-by_g));
        let (work, instead) = match &key.leads {
            Some(leads) => (Work::Leads(leads.work.clone()), leads.adding.clone().map(Work::Leads)),
            None => (Work::FrontWeight { by_g }, None),
        };
        push(Operation::Leads, work, instead, now);
    }
    lines
}

/// Flags the lines of the first and the last key of every section, operation by operation.
fn samples(lines: &mut [KeyLine], section_ends: &[usize]) {
    let section = |key: usize| section_ends.iter().filter(|end| key > **end).count();
    let places: Vec<(Operation, usize, usize)> =
        lines.iter().map(|line| (line.operation, section(line.key), line.key)).collect();
    for line in lines {
        let beside =
            || places.iter().filter(|(operation, at, _)| (*operation, *at) == (line.operation, section(line.key)));
        line.is_sample = beside().all(|(.., key)| *key >= line.key) || beside().all(|(.., key)| *key <= line.key);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::balance::{LEADS_G, Lead};
    use erard::keyboard::Keyboard;
    use std::sync::LazyLock;

    static MODELS: LazyLock<[KeyModel; KEYS]> = LazyLock::new(|| {
        let grand = Keyboard::builtin("concert-grand").unwrap();
        std::array::from_fn(|at| KeyModel::of(&grand.key(at + 1).unwrap()).unwrap())
    });

    fn goal(balance_weight_g: Option<f64>) -> KeyboardGoal {
        let (leads_g, section_ends) = (LEADS_G.to_vec(), SECTION_ENDS.to_vec());
        KeyboardGoal { balance_weight_g, ratio: None, inertia_kg: None, hammers: false, leads_g, section_ends }
    }

    fn weighed(key: usize, down_g: f64, up_g: f64) -> MeasuredKey {
        MeasuredKey { key, down_weight_g: Some(down_g), up_weight_g: Some(up_g), ..MeasuredKey::default() }
    }

    /// D 58 and U 18 at middle C: 20 g of friction are 4.8 over the range. 10 g less come nearest to the best, D 48 and
    /// U 28, and no lead moves before it has been weighed again.
    #[test]
    fn a_lone_key_with_friction() {
        let list = keyboard_list(&[weighed(40, 58.0, 18.0)], &MODELS, &goal(None)).unwrap();
        let works: Vec<&Work> = list.lines.iter().map(|line| &line.work).collect();
        assert_eq!(works, [&Work::Friction { by_g: -10.0 }]);
        assert_eq!((list.lines[0].after.down_g, list.lines[0].after.up_g), (Some(48.0), Some(28.0)));
        // Its balance weight is the trade's: nothing waits.
        assert_eq!((list.aim_from, list.left.as_slice()), (AimFrom::Trade, &[][..]));
        assert_eq!(list.plan.target.balance_weight_g, TRADE_G);
        // A lone key of 44 g with usual friction: the target is not its own balance weight.
        let list = keyboard_list(&[weighed(40, 55.0, 33.0)], &MODELS, &goal(None)).unwrap();
        assert!(matches!(list.lines[0].work, Work::Leads(_)), "{list:?}");
        let after_g = list.lines[0].after;
        assert!((0.5 * (after_g.down_g.unwrap() + after_g.up_g.unwrap()) - TRADE_G).abs() < 0.3, "{after_g:?}");
        assert!(keyboard_list(&[MeasuredKey { key: 3, ..MeasuredKey::default() }], &MODELS, &goal(None)).is_none());
    }

    /// Friction before hammers before leads, and the ends of the sections first in each.
    #[test]
    fn operations_and_their_samples() {
        let mut keys: Vec<MeasuredKey> = (1..=88).map(|key| weighed(key, 53.0, 31.0)).collect();
        for key in &mut keys {
            let x = key.key as f64;
            // Front weights with which the ratio is 5.6.
            let strike_g = 10.5 - 0.06 * x;
            (key.strike_weight_g, key.front_weight_g) = (Some(strike_g), Some(9.9 + 5.6 * strike_g - 42.0));
            if (30..=34).contains(&key.key) {
                (key.down_weight_g, key.up_weight_g) = (Some(62.0), Some(22.0));
            }
        }
        keys[59].strike_weight_g = keys[59].strike_weight_g.map(|g| g + 1.0);
        let list = keyboard_list(&keys, &MODELS, &goal(Some(38.0))).unwrap();
        let of = |wanted| list.lines.iter().filter(move |line| line.operation == wanted);
        let keys_of = |operation| of(operation).map(|line| line.key).collect::<Vec<_>>();
        assert_eq!(keys_of(Operation::Friction), [30, 34, 31, 32, 33]);
        assert_eq!(keys_of(Operation::Hammers), [60]);
        assert_eq!(&keys_of(Operation::Leads)[..8], &[1, 20, 21, 50, 51, 70, 71, 88]);
        // A gram of hammer is R grams at the key; the leads do the rest.
        let hammer = of(Operation::Hammers).next().unwrap();
        assert!((hammer.work.amount() + 1.0).abs() < 1e-9, "{hammer:?}");
        let ratio = list.plan.keys[59].ratio.unwrap();
        assert!((hammer.after.down_g.unwrap() - (53.0 - ratio)).abs() < 1e-9);
        for line in of(Operation::Leads) {
            let after_g = 0.5 * (line.after.down_g.unwrap() + line.after.up_g.unwrap());
            assert!((after_g - 38.0).abs() < 0.3, "{line:?}");
        }
        // Keys with too much friction wait for their leads.
        assert_eq!(list.left, (30..=34).map(|key| (key, Why::Friction)).collect::<Vec<_>>());
        // Operations come in the order of work.
        assert!(list.lines.is_sorted_by_key(|line| line.operation));
    }

    /// Changes too small to weigh are not requested, a key gets no more lead than usual, and a median out of the usual
    /// range is not followed.
    #[test]
    fn what_is_not_asked_for() {
        let keys: Vec<MeasuredKey> = (38..=42).map(|key| weighed(key, 49.0, 26.0)).collect();
        let list = keyboard_list(&keys, &MODELS, &goal(Some(39.0))).unwrap();
        assert!(list.lines.is_empty() && list.left.is_empty(), "{list:?}");
        // Their own 37.5 g is usual, and so is a published standard of 52 and 28 g: no lead at any key.
        for (down_g, up_g, balance_g) in [(49.0, 26.0, 37.5), (52.0, 28.0, 40.0)] {
            let keys: Vec<MeasuredKey> = (38..=42).map(|key| weighed(key, down_g, up_g)).collect();
            let list = keyboard_list(&keys, &MODELS, &goal(None)).unwrap();
            assert_eq!((list.aim_from, list.plan.target.balance_weight_g), (AimFrom::Median, balance_g));
            assert!(list.lines.is_empty(), "{list:?}");
        }
        let keys: Vec<MeasuredKey> = (38..=42).map(|key| weighed(key, 56.0, 32.0)).collect();
        let list = keyboard_list(&keys, &MODELS, &goal(None)).unwrap();
        assert_eq!((list.aim_from, list.lines.len()), (AimFrom::NearMedian, 5));
        assert!((list.plan.target.balance_weight_g - 40.0).abs() < 0.1, "{list:?}");
        // 16 g of friction are 0.8 g over: less than the error of a reading. Little friction is no fault.
        let list = keyboard_list(&[weighed(40, 54.0, 22.0)], &MODELS, &goal(None)).unwrap();
        assert!(list.lines.is_empty() && KeyboardList::is_friction_doubtful(&list.plan.keys[0]), "{list:?}");
        let list = keyboard_list(&[weighed(40, 44.0, 32.0)], &MODELS, &goal(None)).unwrap();
        assert!(list.lines.is_empty() && !KeyboardList::is_friction_doubtful(&list.plan.keys[0]), "{list:?}");
        let mut full = weighed(40, 56.0, 33.0);
        (full.front_weight_g, full.strike_weight_g) = (Some(30.0), Some(10.0));
        let list = keyboard_list(&[full], &MODELS, &goal(Some(38.0))).unwrap();
        assert!(list.lines.is_empty(), "{list:?}");
        assert_eq!(list.left, [(40, Why::Ceiling)]);
    }

    /// Keys of a published piano (CAUT list, October 2004: C4 is D 65, U 41, FW 25, SW 9.8) say the same thing: the
    /// capstan line, and no lead. One such key among others is that key's.
    #[test]
    fn one_leverage_for_the_keyboard() {
        let heavy = |key: usize, [down_g, up_g, front_g, strike_g]: [f64; 4]| MeasuredKey {
            front_weight_g: Some(front_g),
            strike_weight_g: Some(strike_g),
            ..weighed(key, down_g, up_g)
        };
        let keys = [
            heavy(28, [64.0, 43.0, 25.6, 10.1]),
            heavy(40, [65.0, 41.0, 25.0, 9.8]),
            heavy(41, [63.0, 41.0, 26.9, 9.7]),
            heavy(52, [57.0, 36.0, 24.2, 8.9]),
            heavy(64, [58.0, 39.0, 15.6, 8.2]),
        ];
        let list = keyboard_list(&keys, &MODELS, &goal(None)).unwrap();
        let leverage = list.leverage.as_ref().unwrap();
        assert_eq!((leverage.keys.len(), leverage.of), (5, 5));
        assert!(leverage.capstan_move_mm > 5.0 && leverage.capstan_move_mm <= MOST_CAPSTAN_MM, "{leverage:?}");
        assert!(leverage.reaches >= leverage.aim - 1e-9 && leverage.reaches < 6.06, "{leverage:?}");
        assert!(list.lines.is_empty() && list.left.iter().all(|(_, why)| *why == Why::Leverage), "{list:?}");
        // A ratio that is asked for is aimed at.
        let list = keyboard_list(&keys, &MODELS, &KeyboardGoal { ratio: Some(6.5), ..goal(None) }).unwrap();
        let asked = list.leverage.unwrap();
        assert!(asked.aim == 6.5 && asked.capstan_move_mm < leverage.capstan_move_mm, "{asked:?}");
        let one = keyboard_list(&keys[..1], &MODELS, &goal(None)).unwrap();
        assert!(one.leverage.is_none() && !one.lines.is_empty(), "{one:?}");
    }

    /// Present leads move; if they are unknown, none is put behind the pin to take weight away.
    #[test]
    fn leads_that_are_there() {
        let mut key = weighed(40, 42.0, 21.0);
        key.front_weight_g = Some(25.0);
        let list = keyboard_list(std::slice::from_ref(&key), &MODELS, &goal(Some(38.0))).unwrap();
        assert_eq!(list.lines[0].work, Work::FrontWeight { by_g: -6.5 });
        key.leads = vec![Lead { mass_g: 14.0, at_mm: 165.0 }, Lead { mass_g: 14.0, at_mm: 120.0 }];
        let list = keyboard_list(&[key], &MODELS, &goal(Some(38.0))).unwrap();
        let Work::Leads(leads) = &list.lines[0].work else { panic!("{list:?}") };
        assert!(!leads.out.is_empty() && leads.put.iter().all(|lead| lead.at_mm > 0.0), "{leads:?}");
        assert!((leads.front_weight_g + 6.5).abs() <= 0.25, "{leads:?}");
    }
}

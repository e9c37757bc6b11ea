//! A keyboard unknown to the program, put out of order, weighed by hand, and worked on by its list.
//!
//! Its keys have other levers and hammers than the model's. Some rub, some have lost or gained a lead, one hammer is
//! too heavy. Each weight read is off by up to its precision; the hand is off by up to half its step.

use erard::instrument::Instrument;
use erard::keyboard::{KEYS, Keyboard};
use erard_workshop::balance::{KeyModel, LEADS_G, MeasuredKey};
use erard_workshop::weighing::{Weights, weigh};
use erard_workshop::worklist::{KeyboardGoal, KeyboardList, Operation, SECTION_ENDS, Work, keyboard_list};

use super::hand::Chance;

/// Weighed keys; their disturbances, g of friction, front weight and strike weight.
const PIANO: [(usize, f64, f64, f64); 14] = [
    (1, 0.0, 0.0, 0.0),
    (9, 8.0, 0.0, 0.0),
    (16, 0.0, 0.0, 0.0),
    (20, 0.0, -6.0, 0.0),
    (27, 0.0, 0.0, 0.0),
    (34, 0.0, 0.0, 0.0),
    (40, 8.0, -5.0, 0.0),
    (46, 0.0, 0.0, 0.0),
    (51, 0.0, 5.0, 0.0),
    (58, 0.0, 0.0, 1.2),
    (64, 0.0, 0.0, 0.0),
    (71, 9.0, 0.0, 0.0),
    (80, 0.0, 0.0, 0.0),
    (88, 0.0, 0.0, 0.0),
];
/// Balance weight of the undisturbed keys, g.
const BALANCE_G: f64 = 36.5;

fn does(work: &Work, key: &mut Instrument) {
    work.carry_out(key, &mut |_| true).unwrap();
}

fn all_weighed(piano: &[(usize, Instrument)]) -> Vec<(usize, Weights)> {
    weigh(piano, &mut |_| true).unwrap().into_iter().map(|one| (one.key, one.weights.unwrap())).collect()
}

/// Other levers, heavier hammers, leads for one balance weight; then the disturbances.
fn piano(grand: &Keyboard) -> Vec<(usize, Instrument)> {
    let mut piano: Vec<(usize, Instrument)> = PIANO.iter().map(|(key, ..)| (*key, grand.key(*key).unwrap())).collect();
    for (_, key) in &mut piano {
        does(&Work::Capstan { by_mm: 1.5 }, key);
        does(&Work::Hammer { by_g: 0.4 }, key);
    }
    let weighed = all_weighed(&piano);
    for ((_, key), ((_, weighed), (_, friction_g, front_g, strike_g))) in
        piano.iter_mut().zip(weighed.iter().zip(PIANO))
    {
        let by_g = weighed.touch.balance_weight_g().unwrap() - BALANCE_G + front_g;
        does(&Work::FrontWeight { by_g }, key);
        if friction_g != 0.0 {
            does(&Work::Friction { by_g: friction_g }, key);
        }
        does(&Work::Hammer { by_g: strike_g }, key);
    }
    piano
}

/// A technician's notes: D and U in whole grams, strike weights in tenths, front weights in halves.
fn read(weighed: &[(usize, Weights)], chance: &mut Chance) -> Vec<MeasuredKey> {
    let mut off = |value: f64, by: f64, step: f64| Some(((value + by * chance.either_way()) / step).round() * step);
    let key = |(key, one): &(usize, Weights)| MeasuredKey {
        key: *key,
        strike_weight_g: off(one.strike_weight_g, 0.05, 0.1),
        front_weight_g: off(one.front_weight_g, 0.25, 0.5),
        down_weight_g: off(one.touch.down_weight_g.unwrap(), 0.5, 1.0),
        up_weight_g: off(one.touch.up_weight_g.unwrap(), 0.5, 1.0),
        ..MeasuredKey::default()
    };
    weighed.iter().map(key).collect()
}

/// Keys whose friction is truly out of its range, or whose balance weight is farther from the target than a hand can
/// weigh; ranges are widened by a reading's error.
fn out(weighed: &[(usize, Weights)], aim_g: f64) -> Vec<usize> {
    let is_out = |(key, one): &&(usize, Weights)| {
        let [low, high] = KeyboardList::usual_friction_g(*key);
        let (friction_g, balance_g) = (one.touch.friction_weight_g().unwrap(), one.touch.balance_weight_g().unwrap());
        !(low - 1.0..=high + 1.0).contains(&friction_g) || (balance_g - aim_g).abs() > 3.0
    };
    weighed.iter().filter(is_out).map(|(key, _)| *key).collect()
}

mod nightly {
    use super::*;

    /// After two passes every key is in order. The first eases friction and adjusts the keys that do not rub; the
    /// second adjusts those weighed again. Keys in order get no work.
    #[test]
    #[ignore = "nightly: fourteen keys weighed four times"]
    fn a_keyboard_that_is_not_known_is_put_right() {
        let grand = Keyboard::builtin("concert-grand").unwrap();
        let models: [KeyModel; KEYS] = std::array::from_fn(|at| KeyModel::of(&grand.key(at + 1).unwrap()).unwrap());
        let goal = KeyboardGoal {
            balance_weight_g: None,
            ratio: None,
            inertia_kg: None,
            hammers: false,
            leads_g: LEADS_G.to_vec(),
            section_ends: SECTION_ENDS.to_vec(),
        };
        let mut piano = piano(&grand);
        let mut chance = Chance::new(31);
        let disturbed: Vec<usize> =
            PIANO.iter().filter(|(_, a, b, c)| *a != 0.0 || *b != 0.0 || *c != 0.0).map(|one| one.0).collect();
        let mut counts = Vec::new();
        for pass in 1..=2 {
            let weighed = all_weighed(&piano);
            let list = keyboard_list(&read(&weighed, &mut chance), &models, &goal).unwrap();
            let aim_g = list.plan.target.balance_weight_g;
            counts.push(out(&weighed, aim_g));
            println!("pass {pass}: aim {aim_g}, out {:?}, waits {:?}", counts[pass - 1], list.left);
            for line in &list.lines {
                println!("  {:?} {} {:?}", line.operation, line.key, line.work);
                assert!(disturbed.contains(&line.key), "{line:?}");
                let (_, key) = piano.iter_mut().find(|(key, _)| *key == line.key).unwrap();
                let front_mm = 1e3 * key.roles.key_front_m[0].abs();
                let amount = line.work.amount() + 0.5 * line.work.step() * chance.either_way();
                does(&line.work.with_amount(amount, front_mm), key);
            }
            // Keys that rub wait: in one pass a key has its friction eased or other work done, never both.
            for key in &disturbed {
                let of_key = list.lines.iter().filter(|line| line.key == *key);
                let friction = of_key.clone().filter(|line| line.operation == Operation::Friction).count();
                assert!(friction == 0 || of_key.count() == 1, "{key}");
            }
        }
        let weighed = all_weighed(&piano);
        counts.push(out(&weighed, BALANCE_G));
        println!("out before, after one pass, after two: {counts:?}");
        assert!(counts[0].len() >= 6 && counts[1].len() < counts[0].len() && counts[2].is_empty(), "{counts:?}");
        // The heavy hammer again matches its neighbours.
        let strike_g = |key: usize| weighed.iter().find(|one| one.0 == key).unwrap().1.strike_weight_g;
        assert!((strike_g(58) - 0.5 * (strike_g(51) + strike_g(64))).abs() < 0.4, "{}", strike_g(58));
    }
}

//! A technician's measurements obey the known laws of weights and levers, of friction, and of let-off.
//!
//! Where a law is a formula, the number comes from masses and arms of the instrument file, not from the measuring code.

use std::sync::OnceLock;

use crate::common::{body, rigid_grand};
use erard::grand::{Parts, pedal_down};
use erard::instrument::{Curve, Instrument, InstrumentFields, Vec2};
use erard::one_dof;
use erard::player::{self, Action, RestKind, RestPose};
use erard::run::{Setup, simulate};
use erard_workshop::balance::KeyModel;
use erard_workshop::measure::inertia::inertia;
use erard_workshop::measure::norms::lines;
use erard_workshop::measure::range::{SoftFlight, softest};
use erard_workshop::measure::repetition::repetition;
use erard_workshop::measure::weights::{HOME_M, Weights, weigh};
use erard_workshop::measure::{measure, slow_loop};
use moreau::Settings;

/// Error of a balance weight, g: two weights are searched to a fiftieth of a gram each, and a key caught at a
/// millimetre per second is carried over a deficit of a tenth of a gram for a sixth of a millimetre.
const SCALE_G: f64 = 0.1;
/// Remainder of the hammer's swing in a slow loop, whose largest and smallest force are read: a millinewton, g.
const SWING_G: f64 = 0.1;

fn go(_: f64) -> bool {
    true
}

/// Weights with the pedal down: the damper is removed, which is equivalent and saves half of the runs.
fn weighed(instrument: &Instrument) -> Weights {
    weigh(&without_damper(instrument), &mut go).unwrap()
}

fn without_damper(instrument: &Instrument) -> Instrument {
    let mut bare = instrument.clone();
    let damper = body(&bare, "damper");
    // The last body, so that no other's index changes; its zones are last, too.
    assert_eq!(damper + 1, bare.bodies.len());
    bare.edit(|fields| {
        fields.bodies.truncate(damper);
        fields.zones.retain(|zone| ![zone.disc_body, zone.curve_body].contains(&Some(damper)));
        fields.parts.retain(|part| part.body != Some(damper));
        // It turns one of these zones.
        fields.screws.retain(|screw| screw.name != "damper_timing");
    })
    .unwrap();
    bare
}

/// The shipped grand's weights, found once.
fn grand_weighed() -> &'static Weights {
    static WEIGHED: OnceLock<Weights> = OnceLock::new();
    WEIGHED.get_or_init(|| weigh(&rigid_grand(), &mut go).unwrap())
}

fn down(w: &Weights) -> f64 {
    w.pedal_down.by_weights.down_weight_g.unwrap()
}

fn up(w: &Weights) -> f64 {
    w.pedal_down.by_weights.up_weight_g.unwrap()
}

fn balance(w: &Weights) -> f64 {
    w.pedal_down.by_weights.balance_weight_g().unwrap()
}

fn near(what: &str, found: f64, expected: f64, tolerance: f64) {
    println!("{what}: {found:.4}, expected {expected:.4} within {tolerance:.4}");
    assert!((found - expected).abs() <= tolerance, "{what}: {found}, expected {expected} within {tolerance}");
}

fn zone(instrument: &Instrument, name: &str) -> usize {
    instrument.zones.iter().position(|zone| zone.name == name).expect("a zone of this name")
}

/// Adds a point mass to a body, kg at a point of its frame, m.
fn add_mass(instrument: &mut Instrument, name: &str, mass_kg: f64, at: Vec2) {
    let body = body(instrument, name);
    let add = |fields: &mut InstrumentFields| {
        let body = &mut fields.bodies[body];
        let whole = body.mass_kg + mass_kg;
        for (c, x) in body.center_of_mass_m.iter_mut().zip(at) {
            *c = (*c * body.mass_kg + x * mass_kg) / whole;
        }
        body.mass_kg = whole;
        body.inertia_kg_m2 += mass_kg * (at[0] * at[0] + at[1] * at[1]);
    };
    instrument.edit(add).unwrap();
}

/// Absolute angle of the hammer at rest, rad.
fn hammer_at_rest(instrument: &Instrument) -> f64 {
    Action::new(instrument).unwrap().angles()[body(instrument, "hammer")]
}

/// Sets the capstan so that the hammer rests where it rests in `model`: this keeps the blow.
fn keep_the_blow(instrument: &mut Instrument, model: &Instrument) {
    let goal = hammer_at_rest(model);
    let capstan = zone(instrument, "capstan_heel");
    let drawn = instrument.zones[capstan].disc_center_m[1];
    let miss = |instrument: &mut Instrument, height: f64| {
        instrument.edit(|fields| fields.zones[capstan].disc_center_m[1] = height).unwrap();
        hammer_at_rest(instrument) - goal
    };
    // Secant method: the hammer's angle is almost linear in the capstan's height.
    let (mut a, mut b) = (drawn, drawn + 1e-4);
    let (mut at_a, mut at_b) = (miss(instrument, a), miss(instrument, b));
    for _ in 0..20 {
        if at_b.abs() < 1e-5 {
            return;
        }
        let next = b - at_b * (b - a) / (at_b - at_a);
        (a, at_a) = (b, at_b);
        (b, at_b) = (next, miss(instrument, next));
    }
    panic!("the capstan cannot restore the blow: still {at_b} rad off");
}

fn effective_kg(instrument: &Instrument, w: &Weights) -> f64 {
    inertia(instrument, w.free_way.end_m, &mut go).unwrap().half_way.total_kg()
}

/// Trials with weights and the force of a slow loop give the same down-weight and up-weight.
#[test]
fn weights_and_loop_agree() {
    let w = grand_weighed();
    for (damper, key) in [("pedal down", &w.pedal_down), ("dampers down", w.dampers_down.as_ref().unwrap())] {
        let (tried, read) = (key.by_weights, key.by_loop);
        near(
            &format!("{damper}: down-weight"),
            tried.down_weight_g.unwrap(),
            read.down_weight_g.unwrap(),
            SCALE_G + SWING_G,
        );
        near(&format!("{damper}: up-weight"), tried.up_weight_g.unwrap(), read.up_weight_g.unwrap(), SCALE_G + SWING_G);
    }
}

/// The shipped grand is within the published norms, and R of the equation of balance is R of the geometry within 2 %.
#[test]
fn the_concert_grand_is_within_the_norms() {
    let grand = Instrument::builtin("concert-grand").unwrap();
    let w = &weigh(&grand, &mut go).unwrap();
    let touch = w.pedal_down.by_weights;
    let within = |what: &str, x: f64, low: f64, high: f64| assert!((low..=high).contains(&x), "{what}: {x}");
    within("down-weight", down(w), 45.0, 55.0);
    within("up-weight", up(w), 20.0, 30.0);
    within("friction weight", touch.friction_weight_g().unwrap(), 8.0, 14.0);
    within("balance weight", balance(w), 34.0, 40.0);
    let (weights, kinematics) = (w.strike_weight_ratio().unwrap(), w.strike_ratio.where_weighed);
    within("R by weights", weights, 5.0, 6.1);
    within("R by kinematics", kinematics, 5.0, 6.1);
    // D is decided where more rubs than where U is: 5 % of R, all of it friction that BW contains.
    near("R by weights over R by kinematics", weights / kinematics, 1.05, 0.02);
    let friction_g = w.pedal_down.friction_in_balance_g(grand.gravity_m_per_s2).unwrap();
    let ratio = w.parts.strike_weight_ratio(balance(w) - friction_g).unwrap() / kinematics;
    near("R by weights without friction over R by kinematics", ratio, 1.0, 0.01);
    // At one place, friction cancels between the two directions, whatever its size.
    let half_way = w.pedal_down.balance_weight_at(0.5 * w.free_way.end_m, grand.gravity_m_per_s2).unwrap();
    let ratio = w.parts.strike_weight_ratio(half_way).unwrap() / w.strike_ratio.half_way;
    near("R by weights over R by kinematics, half-way", ratio, 1.0, 0.01);
    within("effective inertia", effective_kg(&grand, w), 0.2, 0.35);
}

/// The detached parts have the weights of their masses and arms: key 140 g at 39.75 of 265 mm, hammer 11.2 g at 101 of
/// 130 mm, whippen, jack and lever 11, 4 and 5 g at 50, 85 and 65 mm, on a heel touched at 63 mm of the whippen and 142
/// mm of the key (which felts and the dome shift by some tenths of a millimetre).
#[test]
fn the_parts_weigh_what_they_are() {
    let grand = rigid_grand();
    let parts = grand_weighed().parts.clone();
    let key = &grand.bodies[body(&grand, "key")];
    let front = key.mass_kg * 1e3 * key.center_of_mass_m[0] / grand.roles.key_front_m[0];
    near("front weight", parts.front_weight_g, front, 1e-3);
    let hammer = &grand.bodies[body(&grand, "hammer")];
    let strike = hammer.mass_kg * 1e3 * hammer.center_of_mass_m[0] / grand.roles.hammer_strike_point_m[0];
    near("strike weight", parts.strike_weight_g, strike, 1e-9);
    let x = |name: &str| {
        let b = &grand.bodies[body(&grand, name)];
        let pivot = b.parent.map_or(0.0, |_| b.pivot_m[0]);
        b.mass_kg * 1e3 * (pivot + b.center_of_mass_m[0])
    };
    let moment = x("whippen") + x("jack") + x("lever");
    near("whippen weight", parts.whippen_weight_g, moment / -63e-3, 0.01 * moment / -63e-3);
    near("key ratio", parts.key_ratio, 142.23 / 265.0, 2e-3);
}

/// Prints leverage and down-weight before and after a move.
fn show_change(before: &Weights, after: &Weights) {
    let ratios = [before, after].map(|w| w.strike_ratio.half_way);
    println!("R {} -> {}, D {} -> {}", ratios[0], ratios[1], down(before), down(after));
}

/// Toward the player the capstan's arm on the key shrinks and the heel's on the whippen grows: less leverage, so that
/// everything beyond it weighs less at the key, at rest and in motion. The capstan's height keeps the blow.
#[test]
fn capstan_toward_the_player_is_lighter() {
    let grand = rigid_grand();
    let mut moved = grand.clone();
    let capstan = zone(&grand, "capstan_heel");
    moved.edit(|fields| fields.zones[capstan].disc_center_m[0] -= 0.010).unwrap();
    keep_the_blow(&mut moved, &grand);
    let (before, after) = (grand_weighed(), weighed(&moved));
    show_change(before, &after);
    // The two arms, 142.23 and 63 mm, as drawn.
    let expected = (132.23 / 73.0) / (142.23 / 63.0);
    near("leverage", after.strike_ratio.at_rest / before.strike_ratio.at_rest, expected, 0.02);
    assert!(down(&after) < down(before) - 5.0);
    assert!(effective_kg(&moved, &after) < 0.8 * effective_kg(&grand, before));
}

/// A knuckle nearer to the hammer's pin: a shorter arm drives the same hammer.
#[test]
fn knuckle_in_is_heavier() {
    let grand = rigid_grand();
    let mut moved = grand.clone();
    for knuckle in ["jack_knuckle", "lever_knuckle"] {
        let knuckle = zone(&grand, knuckle);
        moved.edit(|fields| fields.zones[knuckle].disc_center_m[0] -= 0.001).unwrap();
    }
    keep_the_blow(&mut moved, &grand);
    let (before, after) = (grand_weighed(), weighed(&moved));
    show_change(before, &after);
    assert!(after.strike_ratio.half_way > 1.03 * before.strike_ratio.half_way);
    assert!(down(&after) > down(before) + 1.0);
    assert!(effective_kg(&moved, &after) > 1.05 * effective_kg(&grand, before));
}

/// A gram at the hammer's head raises the strike weight by a gram and the balance weight by R grams, for both ways to
/// find R. The head's centre is 18 mm above the shank's line: above the weighing place when the shank hangs by 8
/// degrees, as in the middle of the stroke, so that its arm is 130 mm there within a hundredth.
///
/// The law is one of levers. It needs the hammer at its earlier height (a heavier one sinks into its felts and is
/// screwed up again), and a knuckle without friction: with it, jack and lever share a heavier hammer differently, and
/// the balance weight, a mean of two directions, contains half of the difference in their friction.
#[test]
fn a_gram_at_the_hammer_is_r_grams_at_the_key() {
    let mut smooth = rigid_grand();
    let knuckle = zone(&smooth, "jack_knuckle");
    smooth.edit(|fields| fields.zones[knuckle].friction_coefficient = 0.0).unwrap();
    let (before, after) = with_a_gram(&smooth);
    near("strike weight", after.parts.strike_weight_g - before.parts.strike_weight_g, 1.0, 1e-9);
    let raised = balance(&after) - balance(&before);
    near("balance weight, R by weights", raised, before.strike_weight_ratio().unwrap(), SCALE_G);
    near("balance weight, R by kinematics", raised, before.strike_ratio.where_weighed, SCALE_G);
}

/// Weights of an action, and with a gram more at the hammer's head.
fn with_a_gram(grand: &Instrument) -> (Weights, Weights) {
    let mut heavier = grand.clone();
    add_mass(&mut heavier, "hammer", 1e-3, [0.130, 0.018]);
    keep_the_blow(&mut heavier, grand);
    (weighed(grand), weighed(&heavier))
}

#[test]
#[ignore = "ci: an action weighed twice more"]
fn a_gram_at_the_hammer_with_a_knuckle_that_rubs() {
    let (before, after) = with_a_gram(&rigid_grand());
    let raised = balance(&after) - balance(&before);
    let ratio = before.strike_ratio.where_weighed;
    // The whole hammer on the jack: 9.7 g times 138/21 by the arms, times 0.25, times the knuckle's sliding per key
    // travel.
    let rubs = 9.7 * (138.0 / 21.0) * 0.25 * (0.87 / 5.54);
    near("balance weight, with a knuckle that rubs", raised, ratio, SCALE_G + 0.5 * rubs);
}

/// A key lead of 14 g at 147 of 265 mm in front of the balance rail: 7.8 g less down-weight and up-weight at the front.
#[test]
#[ignore = "ci: actions weighed anew"]
fn a_lead_lowers_the_balance_weight_by_its_lever() {
    let grand = rigid_grand();
    let mut leaded = grand.clone();
    add_mass(&mut leaded, "key", 14e-3, [-0.147, 0.010]);
    let (before, after) = (grand_weighed(), weighed(&leaded));
    let lever = 14.0 * 147.0 / 265.0;
    near("front weight", after.parts.front_weight_g - before.parts.front_weight_g, lever, 1e-3 * lever);
    near("balance weight", balance(before) - balance(&after), lever, SCALE_G);
    near("down-weight", down(before) - down(&after), lever, SCALE_G);
    near("up-weight", up(before) - up(&after), lever, SCALE_G);
    // R is the action's, not the key's.
    near("R", after.strike_weight_ratio().unwrap(), before.strike_weight_ratio().unwrap(), 0.02);
}

/// A spring that carries the whippen takes its weight at the key off, KR WW (D. Stanwood, Pianotech list, 28 June 1996:
/// 18 g times 0.55), like a lead; R is the action's.
#[test]
#[ignore = "ci: actions weighed anew"]
fn a_whippen_spring_lowers_the_balance_weight_by_what_it_carries() {
    let grand = rigid_grand();
    let before = grand_weighed();
    let whippen = body(&grand, "whippen");
    let heel_m = 1e-3 * KeyModel::of(&grand).unwrap().heel_mm;
    // Clockwise lifts the heel, which lies before the pin.
    let torque_n_m = -1e-3 * before.parts.whippen_weight_g * grand.gravity_m_per_s2 * heel_m;
    let mut sprung = grand.clone();
    let spring =
        erard::instrument::Spring { name: "assist".to_owned(), body: whippen, torque_n_m, stiffness_n_m_per_rad: 0.0 };
    sprung.edit(|fields| fields.springs.push(spring)).unwrap();
    let after = weighed(&sprung);
    let carried = before.parts.key_ratio * before.parts.whippen_weight_g;
    near("springs", after.parts.assist_g, carried, 0.1);
    near("balance weight", balance(before) - balance(&after), carried, SCALE_G);
    near("R", after.strike_weight_ratio().unwrap(), before.strike_weight_ratio().unwrap(), 0.02);
    assert_eq!(before.parts.assist_g, 0.0);
}

/// More friction in the key's bushings, 5 mN m at an arm of 265 mm: 1.9 g more down-weight, 1.9 g less up-weight.
#[test]
fn friction_raises_one_weight_and_lowers_the_other_by_the_same() {
    let grand = rigid_grand();
    let mut tight = grand.clone();
    let key = body(&grand, "key");
    tight.edit(|fields| fields.bodies[key].friction_torque_n_m += 5e-3).unwrap();
    let (before, after) = (grand_weighed(), weighed(&tight));
    let grams = 5e-3 / 0.265 / grand.gravity_m_per_s2 * 1e3;
    near("down-weight", down(&after) - down(before), grams, SCALE_G);
    near("up-weight", up(before) - up(&after), grams, SCALE_G);
    near("balance weight", balance(&after), balance(before), SCALE_G);
    let friction = |w: &Weights| w.pedal_down.by_weights.friction_weight_g().unwrap();
    near("friction weight", friction(&after) - friction(before), grams, SCALE_G);
}

/// Weight of the damper on the key: 34 g at 36 mm of its pin, lifted at 65 mm of it and 235 mm of the key, is 16.7 g at
/// 265 mm; the key lifts it late in its stroke, where it decides the down-weight, so that friction weight does not
/// contain all of it.
#[test]
fn dampers_down_are_heavier() {
    let grand = rigid_grand();
    let w = grand_weighed();
    let with = w.dampers_down.as_ref().unwrap();
    let at = w.free_way.end_m - 0.3e-3;
    let force = |key: &erard_workshop::measure::weights::KeyWeights| {
        key.slow.down.force(at).unwrap() / grand.gravity_m_per_s2 * 1e3
    };
    // Its pin's friction, 1 mN m, acts against the press.
    let weight = (34e-3 * 36e-3 * grand.gravity_m_per_s2 + 1e-3) / 65e-3 * 235.0 / 265.0 / grand.gravity_m_per_s2 * 1e3;
    near("the damper at the key", force(with) - force(&w.pedal_down), weight, 0.05 * weight);
    assert!(with.by_weights.down_weight_g.unwrap() > down(w) + 5.0);
}

/// Inertia from the geometry of three levers and, at rest, from the closed contacts of the one-degree-of-freedom model:
/// at most 3 % apart, because the levers assume closed contacts and the other model takes them as they are.
#[test]
fn inertia_is_that_of_the_reduced_model() {
    let grand = rigid_grand();
    let curve = inertia(&grand, 5e-3, &mut go).unwrap();
    let reduced = one_dof::reduce(&grand).unwrap().inertia_kg_m2 / 0.265_f64.powi(2);
    near("at rest", curve.pedal_down_kg[0], reduced, 0.03 * reduced);
    let half = curve.pedal_down_kg[curve.pedal_down_kg.len() / 2];
    near("the shares are the whole", curve.half_way.total_kg(), half, 1e-3 * half);
    let key = grand.bodies[body(&grand, "key")].inertia_kg_m2;
    near("the key's share", curve.half_way.key_kg, key / 0.265_f64.powi(2), 1e-6);
    assert!(curve.pedal_down_kg.is_sorted_by(|a, b| a > b), "leverage falls through the stroke, and inertia with it");
}

/// Effective inertia is what a force accelerates: the work of a force beyond that of a slow press is half the effective
/// mass times the square of the key front's speed. Tested with felts a thousand times stiffer, a repetition lever that
/// no hammer presses off its stop and a smoothly rising force, so that the hammer does not lag and swing ahead.
#[test]
fn inertia_is_what_a_force_accelerates() {
    let mut stiff = rigid_grand();
    stiff
        .edit(|fields| {
            for zone in &mut fields.zones {
                zone.felt.stiffness *= 1000.0;
                zone.felt.scale_loss(1000.0);
            }
            for spring in fields.springs.iter_mut().filter(|spring| spring.name == "repetition") {
                spring.torque_n_m *= 20.0;
            }
        })
        .unwrap();
    let lifted = pedal_down(&stiff, &Parts::of(&stiff).unwrap()).unwrap();
    let slow = slow_loop(&lifted, 5e-3, &mut go).unwrap().down;
    let curve = inertia(&stiff, 5e-3, &mut go).unwrap();
    let force = |t: f64| 1.0 - (50.0 * t.min(0.06)).cos();
    let setup = Setup { settings: Settings::new(10e-6), record_every: Some(1), ..Setup::new(0.12) };
    let run = simulate(&lifted, &player::force(&force), &setup, &mut |_| true).unwrap();
    let work = |key: &[f64], force: &[f64], to: f64| -> f64 {
        let ways = key.windows(2).zip(force.windows(2)).take_while(|(key, _)| key[1] <= to);
        ways.map(|(key, f)| 0.5 * (f[0] + f[1]) * (key[1] - key[0])).sum()
    };
    for at_m in [1.5e-3, 2e-3, 3e-3, 4e-3] {
        let row = run.key_m.iter().position(|&key| key > at_m).unwrap();
        let (before, after) = (row - 100, row + 100);
        let speed = (run.key_m[after] - run.key_m[before]) / (run.time_s[after] - run.time_s[before]);
        let kept = work(&run.key_m, &run.force_n, at_m) - work(&slow.key_m, &slow.force_n, at_m);
        let mass = 2.0 * kept / (speed * speed);
        let i = curve.key_m.iter().position(|&key| key >= at_m).unwrap();
        near("effective mass", mass, curve.pedal_down_kg[i], 0.03 * mass);
    }
}

/// Lowers the let-off button (and the drop screw with it) by `by_m`: the hammer is let off farther from the string.
fn lower_let_off(instrument: &mut Instrument, by_m: f64) {
    for stop in ["let_off_button", "drop_screw"] {
        let stop = zone(instrument, stop);
        let lower = |fields: &mut InstrumentFields| {
            if let Curve::Line { point_m, .. } = &mut fields.zones[stop].curve {
                point_m[1] -= by_m;
            }
        };
        instrument.edit(lower).unwrap();
    }
}

/// Distance below the string at which a slow press lets the hammer fall, m.
fn let_off_distance(instrument: &Instrument) -> f64 {
    let press = slow_loop(instrument, 10e-3, &mut go).unwrap();
    let string = instrument.roles.string.unwrap();
    -Action::new(instrument).unwrap().compression(string).unwrap()
        - press.down.head_m.iter().copied().fold(0.0, f64::max)
}

/// From twice the distance the hammer flies longer, and must be released faster to reach the string: v = sqrt(2 a d),
/// with a the deceleration of a freely rising hammer, from its weight, pin friction and inertia, and d the distance of
/// flight.
#[test]
#[ignore = "ci: searches for the softest blow"]
fn twice_the_let_off_needs_a_faster_hammer() {
    let near_string = rigid_grand();
    let distance = let_off_distance(&near_string);
    let mut far = near_string.clone();
    // Button and hammer move in the ratio of their arms: found by the secant method, with the reached distance
    // measured.
    let (mut by, mut reached) = (1e-4, distance);
    for _ in 0..6 {
        far = near_string.clone();
        lower_let_off(&mut far, by);
        reached = let_off_distance(&far);
        by *= distance / (reached - distance);
    }
    near("let-off distance", reached, 2.0 * distance, 0.1 * distance);
    let [a, b] = [&near_string, &far].map(|instrument| softest(instrument, &mut go).unwrap().unwrap().flight.unwrap());
    println!("let-off {:.2} mm: {a:?}\nlet-off {:.2} mm: {b:?}", distance * 1e3, reached * 1e3);
    for SoftFlight { let_off_speed_m_per_s, fall_speed_m_per_s, .. } in [a, b] {
        near("speed at let-off", let_off_speed_m_per_s, fall_speed_m_per_s, 0.05 * fall_speed_m_per_s);
    }
    assert!(b.flight_s > a.flight_s && b.flight_m > a.flight_m && b.let_off_speed_m_per_s > a.let_off_speed_m_per_s);
}

/// The double escapement works: from half-way the note repeats faster than fully released, and nearly as fast as the
/// twelve to fourteen strokes per second published for grands.
#[test]
fn half_way_repeats_faster() {
    let grand = rigid_grand();
    let full = repetition(&grand, HOME_M, &mut go).unwrap().unwrap();
    let half = repetition(&grand, 4.8e-3, &mut go).unwrap().unwrap();
    println!("{full:?}\n{half:?}");
    assert!(half.rate_hz > full.rate_hz && full.rate_hz > 8.0, "{full:?} {half:?}");
    assert!(half.return_s < full.return_s);
    // A lever without a spring cannot lift the hammer for the jack to slip under it.
    let mut slack = grand.clone();
    slack
        .edit(|fields| {
            for spring in &mut fields.springs {
                if spring.name == "repetition" {
                    spring.torque_n_m *= 0.05;
                    spring.stiffness_n_m_per_rad *= 0.05;
                }
            }
        })
        .unwrap();
    let slack = repetition(&slack, 4.8e-3, &mut go).unwrap();
    assert!(slack.is_none_or(|slack| slack.rate_hz < 0.8 * half.rate_hz), "{slack:?}");
}

/// The whole sheet of an action without a damper: lines that need one are missing, all others are present and equal
/// those with the pedal down. Measured on several threads, the sheet is the same, bit for bit.
#[test]
#[ignore = "ci: another sheet"]
fn an_action_without_a_damper_has_a_sheet() {
    let bare = without_damper(&rigid_grand());
    let sheet = measure(&bare, &mut |_| true).unwrap();
    assert!(sheet.dampers_down.is_none() && sheet.hysteresis_dampers_down.is_none());
    near("down-weight", sheet.down_weight_g.unwrap(), down(grand_weighed()), SCALE_G);
    // Every row has its level's speed.
    let levels = erard::level::LEVELS.iter().cycle();
    for (row, (name, speed_m_per_s)) in sheet.timing.iter().zip(levels) {
        assert_eq!(row.nuance, *name);
        near(name, row.hammer_speed_m_per_s.unwrap(), *speed_m_per_s, 2e-3 * speed_m_per_s);
    }
    assert_eq!(sheet.timing.len(), 10);
    // Every line of the printed sheet is in the JSON under its key, with the same value.
    let json = serde_json::to_value(&sheet).unwrap();
    for line in lines() {
        let found = line.key.split('.').try_fold(&json, |at, key| at.get(key).filter(|_| !at.is_null()));
        let value = (line.value)(&sheet);
        match found {
            Some(found) => assert_eq!(found.as_f64(), value, "{}", line.key),
            None => assert!(line.key.starts_with("dampers_down.") && value.is_none(), "{}", line.key),
        }
    }
    let again = measure(&bare, &mut |_| true).unwrap();
    assert_eq!(json, serde_json::to_value(&again).unwrap());
}

/// An instrument that is no action is refused, and an interruption ends the work.
#[test]
fn what_cannot_be_measured_is_said() {
    let mut no_hammer = rigid_grand();
    no_hammer.edit(|fields| fields.roles.hammer = None).unwrap();
    let error = measure(&no_hammer, &mut |_| true).unwrap_err().to_string();
    assert!(error.contains("names no `hammer`"), "{error}");
    let mut floating = rigid_grand();
    floating.edit(|fields| fields.gravity_m_per_s2 = 0.0).unwrap();
    assert!(measure(&floating, &mut |_| true).is_err());
    assert!(measure(&rigid_grand(), &mut |_| false).unwrap_err().is_interruption());
}

/// An action that blocks, with let-off button and drop screw turned out of reach, is still measured: up to where the
/// hammer reaches the string, with flags for let-off, drop and aftertouch.
#[test]
#[ignore = "ci: a sheet whose searches go to their ends"]
fn a_blocking_action_has_a_sheet() {
    let mut blocking = without_damper(&rigid_grand());
    lower_let_off(&mut blocking, -10e-3);
    // As drawn: after a blow a hammer that was not let off rests elsewhere than one that was.
    let drawn = |action: &Instrument| RestPose::of(action, RestKind::AsDrawn, &mut |_| true).unwrap();
    let sheet = measure(&drawn(&blocking), &mut |_| true).unwrap();
    assert_eq!(sheet.let_off_begins_mm, None);
    assert!(sheet.let_off_mm.unwrap() <= 0.0 && sheet.aftertouch_mm.is_none());
    for key in ["let_off_mm", "drop_mm", "aftertouch_mm"] {
        assert!(sheet.flags.iter().any(|flag| flag.key == key), "{key}: {:?}", sheet.flags);
    }
    let whole = measure(&drawn(&rigid_grand()), &mut |_| true).unwrap();
    near("down-weight", sheet.down_weight_g.unwrap(), whole.down_weight_g.unwrap(), SCALE_G);
}

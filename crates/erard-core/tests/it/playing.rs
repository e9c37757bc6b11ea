//! The concert grand is played: let-off before the string, free flight, impact, check, repetition, and back to rest.
//!
//! `cargo run --release -p erard-core --example force_steps` prints the table.

use crate::common::{Play, USUAL_STEP_S, grand, key_rests_within_m, largest, rigid_grand};
use erard::instrument::Instrument;
use erard::player;
use erard::player::Action;
use erard::run::Run;
use erard::run::{Setup, simulate};
use moreau::{Loss, Settings};

/// How long a key is held, and how long is waited for rest, s.
const HELD_S: f64 = 0.5;
const WHOLE_S: f64 = 2.0;

fn press(grand: &Instrument, force: f64) -> Run {
    Play::ForceStep(force, HELD_S).run(grand, Settings::new(USUAL_STEP_S), WHOLE_S)
}

fn row_at(run: &Run, time_s: f64) -> usize {
    run.time_s.partition_point(|&t| t < time_s)
}

fn zone<'a>(run: &'a Run, name: &str) -> &'a [f64] {
    &run.zones.iter().find(|z| z.name == name).expect("a zone of this name").normal_n
}

/// Toe on the button, let-off, free flight, impact. In free flight nothing touches the knuckle, and what is left to the
/// string is the let-off distance: technicians set 1.5 mm, and it grows a little with softness (the hammer rises more
/// slowly than the felts part), so that 0.5 to 4 mm are asked for.
#[test]
fn every_force_lets_off_before_the_string() {
    // Parts that bend are wound up: under 20 N and more the jack still pushes when the hammer is at the string.
    let rigid = [0.8, 2.0, 5.0, 8.0, 20.0, 35.0].map(|force| (rigid_grand(), force));
    for (grand, force) in rigid.into_iter().chain([0.8, 2.0, 5.0, 8.0].map(|force| (grand(), force))) {
        let run = press(&grand, force);
        let e = &run.events;
        let (toe, off, impact) = (e.toe_contact_s.unwrap(), e.let_off_s.unwrap(), e.hammer_contact_s().unwrap());
        assert!(e.key_start_s.unwrap() < toe && toe < off && off < impact, "{force} N: {e:?}");
        let (first, last) = (row_at(&run, off) + 1, row_at(&run, impact) - 1);
        for knuckle in ["jack_knuckle", "lever_knuckle"] {
            assert_eq!(
                largest(zone(&run, knuckle)[first..last.max(first)].iter().copied()),
                0.0,
                "{force} N: {knuckle}"
            );
        }
        let left = run.hammer_rise_m[row_at(&run, impact)] - run.hammer_rise_m[row_at(&run, off)];
        assert!((0.02e-3..4e-3).contains(&left), "{force} N: {left}");
        assert_eq!(run.work.unconverged_steps, 0);
    }
}

/// Hammers thrown back hard enough are caught, 10 to 20 mm below the string (technicians set 12 to 15), and held
/// there motionless by a check that presses on the tail.
#[test]
fn hard_enough_blows_are_checked() {
    let grand = grand();
    for force in [2.0, 5.0, 8.0, 20.0, 35.0] {
        let run = press(&grand, force);
        assert_eq!(run.events.impacts.len(), 1, "{force} N: one impact");
        assert!(run.events.check_s.unwrap() > run.events.hammer_contact_s().unwrap());
        let held = row_at(&run, HELD_S) - 1;
        let string = run.hammer_rise_m[row_at(&run, run.events.hammer_contact_s().unwrap())];
        let below = string - run.hammer_rise_m[held];
        assert!((10e-3..20e-3).contains(&below), "{force} N: checked {below} m below the string");
        assert!(zone(&run, "check")[held] > 0.5, "{force} N");
        // Held by the check alone, with its own pin at the limit of its friction, it stands still to rounding: 1e-15
        // rad/s is a millionth of a degree in a year.
        let rate = run.bodies[4].rate_rad_per_s[held];
        assert!(rate.abs() < 1e-15, "{force} N: the hammer stands still, not {rate:e}");
    }
}

/// The softest note: published 150 ms from key start to key bottom at 0.8 N, and the hammer about 12 ms before key
/// bottom.
#[test]
fn the_softest_blow_keeps_its_times() {
    let e = press(&grand(), 0.8).events;
    let bottom = e.key_bottom_s.unwrap();
    let stroke = bottom - e.key_start_s.unwrap();
    let ahead = bottom - e.hammer_contact_s().unwrap();
    assert!((0.130..0.165).contains(&stroke), "{stroke}");
    assert!((0.008..0.016).contains(&ahead), "{ahead}");
    assert!((0.45..0.65).contains(&e.hammer_speed_m_per_s().unwrap()), "{e:?}");
}

/// Softly, the hammer is first; loudly, the key bottoms first (Askenfelt and Jansson's order of events). Speeds rise
/// with force.
#[test]
fn the_order_of_events_reverses() {
    let grand = grand();
    let mut speed = 0.0;
    for (force, hammer_first) in [(0.8, true), (2.0, true), (4.0, true), (8.0, false), (20.0, false), (35.0, false)] {
        let e = press(&grand, force).events;
        let (impact, bottom) = (e.hammer_contact_s().unwrap(), e.key_bottom_s.unwrap());
        assert_eq!(impact < bottom, hammer_first, "{force} N: {e:?}");
        assert!(e.hammer_speed_m_per_s().unwrap() > speed);
        speed = e.hammer_speed_m_per_s().unwrap();
    }
    assert!((5.0..8.0).contains(&speed), "35 N: {speed} m/s");
}

/// Let go, everything falls back and stops: all velocities are exactly zero. Where it stops is a set, not a point, for
/// every pivot holds what its friction can hold:
/// - the key within what friction and the back-rail cloth's own loss hold ([`key_rests_within_m`]): 115 um;
/// - the hammer rests on the repetition lever, whose spring carries it almost by itself and whose pivot friction then
///   decides how high; it can sink until the knuckle sits on the jack's top. The bound downward is that gap, with the
///   leather that gives for the tenth of a newton that friction may leave to the jack and 10 um of whippen, times the
///   head's lever arm over the knuckle's (138.6 / 14.4 mm, both horizontal), and the key's own way at a leverage of
///   6.5. Upward it is what the felt under the lever's tail gives when the pins of lever and hammer, which pushed one
///   way at first, push the other way: twice their friction more on that felt, at the arms of tail (20 mm) and knuckle
///   (37 mm); the key's own way at a leverage of 6.5; and a tenth of a millimetre for the felts of knuckle and capstan.
#[test]
fn let_go_everything_comes_to_rest() {
    let grand = grand();
    let rest = Action::with(&grand, Settings::new(USUAL_STEP_S)).unwrap();
    let key = key_rests_within_m(&grand);
    let jack = grand.zones.iter().position(|z| z.name == "jack_knuckle").unwrap();
    let leather = &grand.zones[jack].felt;
    let least = if let Loss::Iwan(law) = leather.loss { 1.0 - law.eta } else { 1.0 };
    let pressed = (0.1 / (least * leather.stiffness)).sqrt();
    let sink = (pressed + 10e-6 - rest.compression(jack).unwrap()) * 138.6 / 14.4 + key * 6.5;
    assert!(sink < 2e-3, "the lever holds the hammer less than 2 mm above the jack: {sink}");
    let stop = grand.zones.iter().position(|z| z.name == "lever_stop").unwrap();
    let dry = |name: &str| grand.bodies.iter().find(|b| b.name == name).unwrap().friction_torque_n_m;
    let pins = (dry("lever") + dry("shank") * 37.0 / 14.4) / 20e-3;
    let (felt, pressed) = (grand.zones[stop].felt.stiffness, rest.compression(stop).unwrap());
    let rise = ((pressed.powi(2) + 2.0 * pins / felt).sqrt() - pressed) * 37.0 / 20.0 * 138.6 / 14.4 + key * 6.5 + 1e-4;
    assert!(rise < 2e-3, "two millimetres at most: {rise}");
    let strokes = Play::force_steps().chain(Play::strokes());
    for play in strokes {
        let run = play.run(&grand, Settings::new(USUAL_STEP_S), WHOLE_S);
        let last = run.time_s.len() - 1;
        for body in &run.bodies {
            assert_eq!(body.rate_rad_per_s[last], 0.0, "{play:?}: {}", body.name);
        }
        assert!(run.key_m[last].abs() < key, "{play:?}: key {}", run.key_m[last]);
        assert!((-sink..rise).contains(&run.hammer_rise_m[last]), "{play:?}: head {}", run.hammer_rise_m[last]);
        let friction = largest(run.final_pivot_friction_n_m.iter().copied());
        assert!(friction > 1e-4, "{play:?}: friction still holds something at rest");
    }
}

/// One impact in every stroke, and at least `highest` of key travel left between two of them.
fn repeats(play: &Play, frequency: f64, strokes: u32, highest: f64, grand: &Instrument) {
    let run = play.run(grand, Settings::new(USUAL_STEP_S), f64::from(strokes) / frequency);
    let impacts: Vec<f64> = run.events.impacts.iter().map(|s| s.time_s * frequency).collect();
    assert_eq!(impacts.len(), strokes as usize, "{play:?}: {impacts:?}");
    for (n, impact) in impacts.iter().enumerate() {
        assert_eq!(*impact as usize, n, "{play:?}: impact {n} in stroke {impact}");
    }
    let after = &run.key_m[row_at(&run, 0.5 / frequency)..];
    let top = after.iter().fold(f64::INFINITY, |a, b| a.min(*b));
    assert!(top > highest, "{play:?}: the key comes up to {top}");
}

/// The double escapement: at 8 strokes a second between 3 mm and the full dip every stroke sounds, although the key
/// stays 2.8 mm from home at least (an action without a repetition lever needs the key all the way up).
#[test]
fn eight_strokes_a_second_without_coming_home() {
    let play = Play::Tremolo { top: 3e-3, bottom: 9.9e-3, frequency: 8.0 };
    repeats(&play, 8.0, 16, 2.8e-3, &grand());
}

/// From home, ten strokes a second all sound under the shipped finger, and twelve under a softer one (2 N/mm): a stiff
/// finger throws the key so that it and the finger meet out of step.
#[test]
fn ten_and_twelve_strokes_a_second_from_home() {
    let mut grand = grand();
    let tremolo = |frequency| Play::Tremolo { top: 0.0, bottom: 9.9e-3, frequency };
    repeats(&tremolo(10.0), 10.0, 10, -1e-3, &grand);
    grand.edit(|fields| fields.finger.stiffness_n_per_m = 2e3).unwrap();
    repeats(&tremolo(12.0), 12.0, 20, -1e-3, &grand);
}

/// 3 x^2 - 2 x^3 and its slope, over [0, 1].
fn smooth_step(x: f64) -> [f64; 2] {
    let x = x.clamp(0.0, 1.0);
    [x * x * (3.0 - 2.0 * x), 6.0 * x * (1.0 - x)]
}

/// Pressed, held until the hammer is checked, let up half-way (5 of 9.9 mm) and pressed again: it sounds again, whether
/// the second press comes at once or later.
#[test]
fn a_second_press_from_half_way_sounds() {
    let grand = grand();
    for wait in [0.0, 0.05, 0.1, 0.3] {
        let motion = |t: f64| {
            let legs = [(0.0, 0.05, 9.9e-3), (0.2, 0.06, -4.9e-3), (0.26 + wait, 0.04, 4.9e-3)];
            legs.iter().fold([0.0; 2], |[y, v], (start, lasts, travel)| {
                let [s, slope] = smooth_step((t - start) / lasts);
                [y + travel * s, v + travel * slope / lasts]
            })
        };
        let duration_s = 0.5 + wait;
        let setup = Setup { settings: Settings::new(USUAL_STEP_S), ..Setup::new(duration_s) };
        let run = simulate(&grand, &player::motion(&motion), &setup, &mut |_| true).unwrap();
        let impacts = &run.events.impacts;
        assert_eq!(impacts.len(), 2, "{wait}: {impacts:?}");
        assert!(impacts[1].time_s > 0.26 + wait && impacts[1].hammer_speed_m_per_s > 0.8, "{wait}: {impacts:?}");
        let top = run.key_m[row_at(&run, 0.1)..].iter().fold(f64::INFINITY, |a, b| a.min(*b));
        assert!(top > 4.8e-3, "{wait}: the key comes up to {top}");
    }
}

/// Where a zone pushes, its place is known: the normal is a unit vector (to single precision), also in the first row of
/// a contact that began within the step after it.
#[test]
fn what_pushes_has_a_place() {
    let run = press(&grand(), 5.0);
    for zone in &run.zones {
        for (row, _) in zone.normal_n.iter().enumerate().filter(|(_, force)| **force > 0.0) {
            let [_, _, nx, ny] = zone.contact[row];
            assert!((nx.hypot(ny) - 1.0).abs() < 1e-6, "{} at {} s", zone.name, run.time_s[row]);
        }
    }
}

//! A hand that presses: what it does that a prescribed force does not.

use crate::common::grand;
use erard::gradient::{DIRECTIONS, Direction, GradientError, How, Poses, follow};
use erard::keyboard::Keys;
use erard::player::{self, Hand, Inside, Joints, LossRecorder, ReactionRecorder};
use erard::run::{Run, simulate_observed};
use erard::stroke::{HandStroke, STRUCK_JOINTS, least_jerk};
use erard::{Action, Input, Instrument, Settings, Setup, Snapshot};

fn pressed(hand: Hand, force_n: f64, step_s: f64) -> Run {
    let setup = Setup { settings: Settings::new(step_s), hand: Some(hand), ..Setup::new(0.4) };
    let stroke = player::force(move |t| if t < 0.2 { force_n } else { -1.0 });
    erard::press(&grand(), &stroke, &setup).unwrap()
}

/// Without inertia it is the force that its muscle gives.
#[test]
fn a_hand_of_a_gram_is_a_force() {
    let hand = Hand { mass_kg: 1e-3, ..Hand::default() };
    let setup = Setup::new(0.4);
    let force = erard::press(&grand(), &player::force(|t| if t < 0.2 { 5.0 } else { 0.0 }), &setup).unwrap();
    let [by_hand, by_force] = [pressed(hand, 5.0, 50e-6), force].map(|run| run.events.hammer_speed_m_per_s().unwrap());
    // A gram beside the 0.3 kg that the finger feels.
    assert!((by_hand / by_force - 1.0).abs() < 5e-3, "{by_hand} {by_force}");
}

/// A heavier hand takes longer, and arrives at the key bottom with a force far above its muscle's; when it leaves, it
/// lifts off.
#[test]
fn its_mass_is_felt_at_the_bottom() {
    let runs = [0.1, 0.2, 0.3].map(|mass_kg| pressed(Hand { mass_kg, ..Hand::default() }, 6.0, 50e-6));
    for run in &runs {
        println!(
            "peak {:.1} N, hammer {:.2} m/s, bottom after {:.1} ms",
            run.peak_force_n,
            run.events.hammer_speed_m_per_s().unwrap(),
            1e3 * run.events.key_bottom_s.unwrap()
        );
    }
    let bottoms = runs.each_ref().map(|run| run.events.key_bottom_s.unwrap());
    let peaks = runs.each_ref().map(|run| run.peak_force_n);
    assert!(bottoms.is_sorted() && peaks.is_sorted());
    assert!(peaks[0] > 12.0, "{peaks:?}");
    for run in &runs {
        let last = run.time_s.partition_point(|&t| t < 0.3);
        assert!(run.force_n[last..].iter().all(|force| *force == 0.0), "it has lifted off");
        assert!(run.ledger.as_ref().unwrap().residual_relative() < 1e-4);
        assert_eq!(run.work.unconverged_steps, 0);
    }
}

/// What a hand of the default mass plays from mezzo forte on: a struck touch, let go after 0.1 s.
fn struck(t: f64) -> Input {
    Input::Force(if t < 0.1 { 6.0 } else { -1.5 })
}

const STRIKES: Hand = Hand {
    mass_kg: 0.2,
    stiffness_n_per_m: 0.0,
    damping_n_s_per_m: 0.0,
    start_m: -1e-3,
    start_m_per_s: 0.3,
    joints: STRUCK_JOINTS,
};

/// Adaptive steps carry the hand along: they arrive at the speed of short fixed ones, and a tighter tolerance arrives
/// closer.
#[test]
fn adaptive_steps_take_a_hand() {
    let speed = |setup: Setup| {
        let run = erard::press(&grand(), &struck, &Setup { hand: Some(STRIKES), ..setup }).unwrap();
        assert!(run.is_trusted(), "{:?}", run.warnings);
        run.events.hammer_speed_m_per_s().unwrap()
    };
    let fine = speed(Setup { settings: Settings::new(2e-6), ..Setup::new(0.06) });
    let off = [1e-3, 1e-5]
        .map(|tolerance| (speed(Setup { tolerance: Some(tolerance), ..Setup::new(0.06) }) / fine - 1.0).abs());
    println!("off by {off:?} of {fine} m/s");
    assert!(off[0] < 5e-3 && off[1] < 2e-4, "{off:?}");
}

/// The balance of the hand closes: what muscle did is what the hand gained, what its fingertip holds and lost, and its
/// work on the key. What is left falls with the step.
#[test]
fn its_energy_is_accounted_for() {
    let left = |step_s: f64, tolerance: Option<f64>| {
        let setup = Setup { settings: Settings::new(step_s), tolerance, hand: Some(STRIKES), ..Setup::new(0.25) };
        let ledger = erard::press(&grand(), &struck, &setup).unwrap().ledger.unwrap();
        assert_eq!(ledger.hand.work, ledger.drive_work);
        assert!(ledger.hand.fingertip_loss > 0.0 && ledger.hand.kinetic_gain > 0.0);
        assert!(ledger.residual_relative() < 2e-3);
        ledger.hand.residual().abs() / ledger.drive_work_in
    };
    let [coarse, fine] = [50e-6, 12.5e-6].map(|step_s| left(step_s, None));
    let adaptive = left(50e-6, Some(1e-4));
    println!("left of the work: {coarse:.1e}, {fine:.1e}, adaptive {adaptive:.1e}");
    assert!(coarse < 1e-8 && fine < 0.3 * coarse && adaptive < 1e-4, "{coarse:.1e} {fine:.1e} {adaptive:.1e}");
}

/// Pins, contacts and losses are observed under a hand as under a force, and change nothing.
#[test]
fn observers_see_a_hand_press() {
    let (grand, setup) = (grand(), Setup { hand: Some(STRIKES), ..Setup::new(0.1) });
    let mut inside = Inside { reactions: Some(ReactionRecorder::new(&grand)), losses: Some(LossRecorder::new(&grand)) };
    let run = simulate_observed(&grand, &struck, &setup, &mut inside, &mut |_| true).unwrap();
    let losses = inside.losses.unwrap();
    let lost: f64 = losses.losses().unwrap().by_size().iter().map(|loss| loss.all_j()).sum();
    let booked = run.ledger.as_ref().unwrap().dissipated();
    assert!((lost / booked - 1.0).abs() < 1e-9, "{lost} {booked}");
    assert_eq!(run.force_n, erard::press(&grand, &struck, &setup).unwrap().force_n);
}

/// A saved state holds the hand's place: a restored press goes on with the same bits. In a state without that list the
/// hand is at the world's origin.
#[test]
fn a_saved_state_has_the_hand() {
    let grand = grand();
    let press = |action: &mut Action, steps: std::ops::Range<u32>| {
        let h = action.settings().step;
        let at = |n: u32| STRIKES.input(&struck((f64::from(n) + 0.5) * h)).unwrap();
        steps.map(|n| action.step(at(n))).last().unwrap()
    };
    let mut action = Action::new(&grand).unwrap();
    action.place_hand(STRIKES.start_m, STRIKES.start_m_per_s);
    press(&mut action, 0..700);
    let saved = action.save();
    let through = press(&mut action, 700..3000);
    let mut other = Action::new(&grand).unwrap();
    other.restore(&Snapshot::from_bytes(&saved.to_vec()).unwrap()).unwrap();
    assert_eq!(press(&mut other, 700..3000), through);
    assert!(through.hand_m != 0.0 && through.hand_m_per_s < 0.0, "{through:?}");
    let mut text: serde_json::Map<String, serde_json::Value> =
        serde_json::from_str(&serde_json::to_string(&saved).unwrap()).unwrap();
    text.remove("hand_m_and_m_per_s").unwrap();
    let without: Snapshot = serde_json::from_value(text.into()).unwrap();
    other.restore(&without).unwrap();
    assert_eq!((other.reading().hand_m + other.rest().site_m, other.reading().hand_m_per_s), (0.0, 0.0));
}

/// Ten hands of ten masses play ten keys at once, each as it plays its action alone, to the bit. Held notes fall asleep
/// under them; hands that leave and come back find their keys again.
#[test]
fn ten_hands_play_a_keyboard() {
    let rigid = Instrument::builtin("concert-grand-rigid").unwrap();
    let settings = Settings::new(50e-6);
    let instruments = vec![rigid.clone(); 10];
    let mut keys = Keys::at_rest(&instruments, settings).unwrap();
    let mut actions: Vec<Action> = instruments.iter().map(|one| Action::with(one, settings).unwrap()).collect();
    let hand = |n: usize| Hand { mass_kg: 0.05 + 0.05 * n as f64, ..Hand::default() };
    // Pressed for 2 s, lifted off within 0.3 s, brought back, pressed again.
    let down = |n: usize, step: u32| {
        let force_n = if (40_000..46_000).contains(&step) { -2.0 } else { 3.0 + 0.4 * n as f64 };
        hand(n).input(&Input::Force(force_n)).unwrap()
    };
    let (mut impacts, mut asleep, mut away) = ([0; 10], 10, 0.0_f64);
    for (n, action) in actions.iter_mut().enumerate() {
        keys.place_hand(n + 1, -1e-3 * n as f64, 0.0).unwrap();
        action.place_hand(-1e-3 * n as f64, 0.0);
    }
    for step in 0..50_000 {
        for (n, action) in actions.iter_mut().enumerate() {
            if step == 46_000 {
                keys.place_hand(n + 1, -2e-3, 0.0).unwrap();
                action.place_hand(-2e-3, 0.0);
            }
            keys.drive(n + 1, down(n, step)).unwrap();
        }
        keys.step();
        for impact in keys.impacts() {
            impacts[impact.key - 1] += 1;
        }
        if step == 39_999 {
            asleep = keys.awake();
        }
        for (n, action) in actions.iter_mut().enumerate() {
            let alone = action.step(down(n, step));
            if step % 500 == 0 {
                let here = keys.reading(n + 1).unwrap();
                assert_eq!(
                    (here.key_m, here.hand_m, here.finger_force_n),
                    (alone.key_m, alone.hand_m, alone.finger_force_n)
                );
            }
            away = away.min(alone.hand_m);
        }
    }
    println!("impacts {impacts:?}, awake before they are let go {asleep}, farthest away {away} m");
    assert!(impacts.iter().all(|count| *count >= 2), "{impacts:?}");
    assert_eq!(asleep, 0, "every held note sleeps");
    assert!(away < -5e-3, "{away}");
}

/// Derivatives of the hammer's speed under a hand, against central differences of runs.
#[test]
fn derivatives_take_a_hand() {
    let rigid = Instrument::builtin("concert-grand-rigid").unwrap();
    let stroke = |t: f64| Input::Force(8.0 * least_jerk(t / 0.02)[0]);
    let hand = Hand { mass_kg: 0.2, joints: STRUCK_JOINTS, ..Hand::default() };
    let setup = Setup { hand: Some(hand), ledger: false, ..Setup::new(0.1) };
    let found = std::thread::Builder::new()
        .stack_size(erard::gradient::STACK_BYTES)
        .spawn({
            let (rigid, setup) = (rigid.clone(), setup);
            move || {
                let poses = Poses::of(&rigid, 0.0, &mut |_| true).unwrap();
                let many = vec![Direction::force(); DIRECTIONS + 1];
                let refused = follow(&rigid, &many, &stroke, &setup, &poses, How::default(), &mut |_| true);
                assert!(matches!(refused, Err(GradientError::Directions { .. })));
                follow(&rigid, &[Direction::force()], &stroke, &setup, &poses, How::default(), &mut |_| true).unwrap()
            }
        })
        .unwrap()
        .join()
        .unwrap();
    let derived = found.instants.hammer_speed_m_per_s.unwrap().slope[0];
    let speed = |more: f64| {
        let stroke = move |t: f64| match stroke(t) {
            Input::Force(force_n) => Input::Force(force_n + more),
            other => other,
        };
        erard::press(&rigid, &stroke, &setup).unwrap().events.hammer_speed_m_per_s().unwrap()
    };
    let differenced = (speed(0.02) - speed(-0.02)) / 0.04;
    println!("d(hammer speed)/d(muscle force) {derived}, by differences {differenced} m/s per N");
    assert!((derived / differenced - 1.0).abs() < 0.02, "{derived} {differenced}");
}

/// A struck note by flesh and joints as two springs with dampers in series, nothing of mass between them: instant of
/// the impact, s, and hammer speed, m/s. Their common force drives the key, one step late; `joints` are stiffness, N/m,
/// and damping, N s/m.
fn struck_in_series(grand: &Instrument, stroke: &HandStroke, joints: [f64; 2], settings: Settings<f64>) -> [f64; 2] {
    let (h, finger) = (settings.step, grand.finger);
    let (kf, cf, [kj, cj]) = (finger.stiffness_n_per_m, finger.damping_n_s_per_m, joints);
    let mut action = Action::with_progress(grand, settings, &mut |_| true).unwrap();
    // Place and speed of the hand and of the key, and how far the joints are bent.
    let (mut hand, mut key, mut bent) = ([0.0, stroke.hand.start_m_per_s], [0.0, 0.0], 0.0);
    for n in 0..40_000 {
        let [way, rate] = [hand[0] - key[0], hand[1] - key[1]];
        let mut bends = (kf * (way - bent) + cf * rate - kj * bent) / (cj + cf);
        let mut force_n = kj * bent + cj * bends;
        if force_n <= 0.0 {
            (force_n, bends) = (0.0, -kj * bent / cj);
        }
        bent += h * bends;
        let Input::Force(muscle_n) = stroke.input(n as f64 * h) else { panic!("a force") };
        hand[1] += h * (muscle_n - force_n) / stroke.hand.mass_kg;
        hand[0] += h * hand[1];
        let reading = action.step(Input::Force(force_n));
        if let Some(impact) = reading.impact {
            return [impact.time_s, impact.hammer_speed_m_per_s];
        }
        key = [reading.key_m, reading.key_m_per_s];
    }
    panic!("it does not sound");
}

/// Flesh and joints are in series: exactly so if both have one retardation time, but for the explicit steps of the
/// comparison; with the joints of the struck touch, eight times as slow as the flesh, to the first order in the rate of
/// the force.
#[test]
fn joints_are_in_series_with_the_flesh() {
    let grand = grand();
    let settings = Settings::new(10e-6);
    let flesh_s = grand.finger.damping_n_s_per_m / grand.finger.stiffness_n_per_m;
    let alike = Joints { retardation_s: flesh_s, ..STRUCK_JOINTS };
    for (joints, bound) in [(alike, 0.003), (STRUCK_JOINTS, 0.03)] {
        for arrives in [0.25, 0.5, 1.1] {
            let stroke = HandStroke::struck(0.2, arrives);
            let stroke = HandStroke { hand: Hand { joints, ..stroke.hand }, ..stroke };
            let mut action = Action::with_progress(&grand, settings, &mut |_| true).unwrap();
            action.place_hand(0.0, arrives);
            let impact = (0..40_000).find_map(|n| {
                let muscle = stroke.input((n as f64 + 0.5) * settings.step);
                action.step(stroke.hand.input(&muscle).unwrap()).impact
            });
            let one = impact.map(|impact| [impact.time_s, impact.hammer_speed_m_per_s]).unwrap();
            let stiffness = 1.0 / joints.compliance_m_per_n;
            let two = struck_in_series(&grand, &stroke, [stiffness, stiffness * joints.retardation_s], settings);
            println!("{arrives} m/s, {joints:?}: {one:?}, in series {two:?}");
            assert!(one.iter().zip(two).all(|(a, b)| (a / b - 1.0).abs() < bound), "{one:?} {two:?}");
        }
    }
}

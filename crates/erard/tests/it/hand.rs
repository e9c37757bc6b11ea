//! A hand that presses: what it does that a prescribed force does not.

use crate::common::grand;
use erard::player::{self, Hand};
use erard::run::Run;
use erard::run::{SimulationError, simulate_hand};
use erard::{Input, Settings, Setup};

fn pressed(hand: Hand, force_n: f64, step_s: f64) -> Run {
    let setup = Setup { settings: Settings::new(step_s), ..Setup::new(0.4) };
    let stroke = player::force(move |t| if t < 0.2 { force_n } else { -1.0 });
    simulate_hand(&grand(), &hand, &stroke, &setup, &mut |_| true).unwrap()
}

/// Without inertia it is the force that its muscle gives.
#[test]
fn a_hand_of_a_gram_is_a_force() {
    let hand = Hand { mass_kg: 1e-3, damping_n_s_per_m: 0.0, ..Hand::default() };
    let setup = Setup::new(0.4);
    let force = erard::press(&grand(), &player::force(|t| if t < 0.2 { 5.0 } else { 0.0 }), &setup).unwrap();
    let [by_hand, by_force] = [pressed(hand, 5.0, 50e-6), force].map(|run| run.events.hammer_speed_m_s().unwrap());
    // A gram beside the 0.3 kg that the finger feels.
    assert!((by_hand / by_force - 1.0).abs() < 5e-3, "{by_hand} {by_force}");
}

/// A heavier hand takes longer, and arrives at the key bottom with a force far above its muscle's; when it leaves, it lifts off.
#[test]
fn its_mass_is_felt_at_the_bottom() {
    let runs =
        [0.1, 0.2, 0.3].map(|mass_kg| pressed(Hand { mass_kg, damping_n_s_per_m: 0.0, ..Hand::default() }, 6.0, 50e-6));
    for run in &runs {
        println!(
            "peak {:.1} N, hammer {:.2} m/s, bottom after {:.1} ms",
            run.peak_force_n,
            run.events.hammer_speed_m_s().unwrap(),
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

#[test]
fn steps_of_one_length_only() {
    let setup = Setup { tolerance: Some(1e-3), ..Setup::new(0.1) };
    let error = simulate_hand(&grand(), &Hand::default(), &|_| Input::Free, &setup, &mut |_| true).unwrap_err();
    assert!(matches!(error, SimulationError::HandControlled));
}

//! Presses whose error is controlled: the tolerance is what the error follows, and all else stays as it was.

use crate::common::{Play, grand};
use erard::run::Run;
use erard::stroke::Touch;
use moreau::Settings;

const MF: Play = Play::Frozen("mf", Touch::Pressed);

fn controlled(play: &Play, tolerance: f64, until_s: f64, record_every: u64) -> Run {
    play.run_controlled(&grand(), Settings::new(50e-6), until_s, Some(record_every), Some(tolerance))
}

fn speed(run: &Run) -> f64 {
    run.events.hammer_speed_m_per_s().expect("the string is struck")
}

/// The hammer's speed against fixed steps of 0.2 and 0.1 us, extrapolated by their first order (they differ by some
/// 1e-7, so that 1e-6 can be told), over four decades, by force, by motion and with the key's motion imposed; in every
/// run of the tests by force, over three decades, against steps that are four times as long. The tolerance is that of a
/// step. What is smooth is extrapolated beyond it; up to the impact some sixteen changes of friction may each err by
/// it, either way, which makes four of it.
#[test]
fn the_error_follows_the_tolerance() {
    error_follows(MF, 0.4e-6, &[1e-2, 1e-3, 1e-4, 1e-5]);
}

#[test]
#[ignore = "ci: every drive, beside steps of 0.1 us"]
fn the_error_follows_the_tolerance_for_every_drive() {
    for play in [
        MF,
        Play::FrozenMotion("mf", Touch::Pressed),
        Play::FrozenRigid("mf", Touch::Pressed),
        Play::ForceStep(8.0, 1.0),
    ] {
        error_follows(play, 0.1e-6, &[1e-2, 1e-3, 1e-4, 1e-5, 1e-6]);
    }
}

/// `fine_s`: the shorter of the fixed steps; the other is twice as long.
fn error_follows(play: Play, fine_s: f64, tolerances: &[f64]) {
    let fixed = |h: f64| speed(&play.run_every(&grand(), Settings::new(h), 0.06, Some(u64::MAX)));
    let exact = 2.0 * fixed(fine_s) - fixed(2.0 * fine_s);
    for &tolerance in tolerances {
        let error = (speed(&controlled(&play, tolerance, 0.06, 40)) / exact - 1.0).abs();
        println!("{play:?}, tolerance {tolerance:e}: {error:.1e}");
        assert!(error < 4.0 * tolerance, "{play:?}, tolerance {tolerance:e}: {error:.1e}");
    }
}

/// A tenth of the tolerance takes 10^(1/3) = 2.15 times as many steps, since the estimate grows with the cube of the
/// step, plus what the events take; nothing ends at the smallest step with too large an error.
#[test]
fn work_grows_with_the_cube_root() {
    let work: Vec<_> = [1e-4, 1e-5, 1e-6, 1e-7]
        .map(|tolerance| controlled(&MF, tolerance, 0.12, 40).work)
        .into_iter()
        .map(|w| (w.unconverged_steps, w.control.expect("controlled")))
        .collect();
    for (unconverged, control) in &work {
        assert_eq!((*unconverged, control.beyond_tolerance), (0, 0), "{control:?}");
        assert!(control.rejected < control.accepted / 4, "{control:?}");
        assert!(control.inner_steps == 3 * (control.accepted + control.rejected), "{control:?}");
        assert!(control.extrapolated > control.accepted * 3 / 4, "{control:?}");
    }
    for pair in work.windows(2) {
        let growth = pair[1].1.inner_steps as f64 / pair[0].1.inner_steps as f64;
        assert!((1.5..2.5).contains(&growth), "{growth}");
    }
}

/// The energy balance, half by half: what it does not explain follows the tolerance too, and no loss is negative
/// in any half.
#[test]
fn the_balance_closes() {
    for (tolerance, most) in [(1e-3, 1e-3), (1e-5, 1e-4), (1e-7, 1e-5)] {
        let ledger = controlled(&MF, tolerance, 1.0, 20).ledger.unwrap();
        println!("tolerance {tolerance:e}: residual {:.1e}", ledger.residual_relative());
        assert!(ledger.residual_relative() < most && ledger.smallest_term >= 0.0, "{tolerance:e}: {ledger:?}");
    }
}

/// Rows stand at the same instants as with fixed steps, and the same run twice gives the same bits.
#[test]
fn rows_are_regular_and_runs_repeat() {
    let fixed = MF.run_every(&grand(), Settings::new(50e-6), 0.1003, Some(7));
    let (once, twice) = (controlled(&MF, 1e-4, 0.1003, 7), controlled(&MF, 1e-4, 0.1003, 7));
    assert_eq!(fixed.time_s, once.time_s);
    for (a, b) in once.bodies.iter().zip(&twice.bodies) {
        assert_eq!((&a.angle_rad, &a.rate_rad_per_s), (&b.angle_rad, &b.rate_rad_per_s));
    }
    assert_eq!((once.events, once.ledger, once.force_n), (twice.events, twice.ledger, twice.force_n));
}

/// A key that rests costs next to nothing: steps are the longest there are, and nothing moves, to the bit.
#[test]
fn rest_is_rest() {
    let run = controlled(&Play::Free, 1e-6, 1.0, 1000);
    let control = run.work.control.expect("controlled");
    assert!(control.accepted < 1100 && control.rejected == 0, "{control:?}");
    for body in &run.bodies {
        assert!(body.angle_rad.iter().all(|q| *q == body.angle_rad[0]), "{}", body.name);
    }
}

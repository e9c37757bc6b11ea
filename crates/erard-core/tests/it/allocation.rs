//! A step takes no memory from the heap, whatever happens in it.
//!
//! The counting allocator belongs to this test's process only (`allocation-counter`).

use crate::common::rigid_grand_at_rest;
use erard::instrument::Instrument;
use erard::mechanism::mechanism;
use moreau::{Accuracy, FrictionLaw, Settings, SiteInput, Solver, StepOutcome};
use moreau_kernels::Lanes;

type GrandGroup = moreau_kernels::Group<6, 14, 10>;

/// The input at a step: silence, strokes of up to 40 N, a soft finger's and an imposed motion, so that every kind of
/// step occurs.
fn input(n: u64) -> SiteInput<f64> {
    let phase = (n % 2000) as f64 / 2000.0;
    match n / 2000 % 5 {
        0 => SiteInput::Free,
        1 => SiteInput::Force(40.0 * phase),
        2 => SiteInput::Motion { position: 0.01 * phase, velocity: 0.1 },
        3 => SiteInput::Rigid { velocity: 0.05 * (0.5 - phase) },
        _ => SiteInput::Force(0.0),
    }
}

/// Ten seconds of playing, for both solvers, both friction laws, and with the iteration limit reached in every step.
#[test]
fn a_step_never_allocates() {
    let grand = Instrument::builtin("concert-grand").expect("built in");
    let usual = Settings::new(50e-6);
    let tanh = FrictionLaw::Regularised { pivot_width: 0.01, sliding_width: 0.001 };
    let variants = [
        usual,
        Settings { solver: Solver::ProjectedGaussSeidel, ..usual },
        Settings { friction: tanh, ..usual },
        Settings { tolerance: 0.0, newton_limit: 3, solver_limit: 3, ..usual },
    ];
    for settings in variants {
        let mut m = mechanism(&grand, settings).expect("assembles");
        let mut steps = 0;
        let counted = allocation_counter::measure(|| {
            for n in 0..40_000 {
                m.step(&input(n));
                steps += 1;
            }
        });
        assert_eq!(steps, 40_000);
        assert_eq!((counted.count_total, counted.bytes_total), (0, 0), "{settings:?}: {counted:?}");
    }
}

/// As many grands as the batch has lanes, each in another part of its playing; inputs of one kind go in lanes, of
/// several kinds one by one. With the iteration limit reached, too.
#[test]
fn a_group_step_never_allocates() {
    groups_never_allocate(4);
}

#[test]
#[ignore = "ci: a second of playing in every kind of lanes"]
fn a_second_of_group_steps_never_allocates() {
    groups_never_allocate(1);
}

/// Every input, or one of so many.
fn groups_never_allocate(of: u64) {
    let (model, state) = rigid_grand_at_rest();
    let usual = Settings::new(50e-6);
    for lanes in Lanes::here() {
        for settings in [usual, Settings { tolerance: 0.0, newton_limit: 3, ..usual }] {
            let count = lanes.count();
            let mut group = GrandGroup::new(&vec![model.clone(); count], &vec![state.clone(); count], &settings, lanes);
            let (mut inputs, mut outcomes) = ([SiteInput::Free; 16], [StepOutcome::Converged; 16]);
            let mut steps = 0;
            let counted = allocation_counter::measure(|| {
                for n in (0..20_000).step_by(of as usize) {
                    let apart = if n < 10_000 { 0 } else { 700 };
                    for (own, i) in inputs.iter_mut().zip(0..) {
                        *own = input(n + apart * i);
                    }
                    group.step(&inputs[..count], &mut outcomes[..count]);
                    steps += 1;
                }
            });
            assert_eq!(steps * of, 20_000);
            assert_eq!((counted.count_total, counted.bytes_total), (0, 0), "{lanes:?} {settings:?}: {counted:?}");
        }
    }
}

/// A controlled step takes none either, once its working memory is there: that is taken with the first one.
#[test]
fn a_controlled_step_never_allocates() {
    let grand = Instrument::builtin("concert-grand").expect("built in");
    let mut m = mechanism(&grand, Settings::new(50e-6)).expect("assembles");
    let accuracy = Accuracy::new(1e-5, 1e-11, 1e-3);
    let mut rejected = 0;
    let mut play = |steps: u64| {
        for n in 0..steps {
            let report = m.controlled_step(&accuracy, 1e-3, &|after| after, &mut |_, _, _| input(n), &mut |_| {});
            rejected += report.rejected;
        }
    };
    play(1);
    let counted = allocation_counter::measure(|| play(20_000));
    assert_eq!((counted.count_total, counted.bytes_total), (0, 0), "{counted:?}");
    assert!(rejected > 100, "{rejected}");
}

/// The counter counts: what does allocate is seen.
#[test]
fn the_counter_sees_an_allocation() {
    let counted = allocation_counter::measure(|| drop(std::hint::black_box(Box::new(1.0_f64))));
    assert_eq!(counted.count_total, 1);
}

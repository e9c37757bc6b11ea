//! Steps that would change nothing are left out, and nobody can tell.

use crate::common::rigid_grand_at_rest;
use moreau::{Settings, SiteInput, Sleep, StepOutcome, step};
use moreau_kernels::{Lanes, WorkspaceOfSix};

type GrandGroup = moreau_kernels::Group<6, 14, 10>;

/// Struck, held in check, held harder, let go: each for a while.
fn input(n: usize) -> SiteInput<f64> {
    match n {
        0..8_000 => SiteInput::Force(5.0),
        8_000..10_000 => SiteInput::Force(6.0),
        10_000..10_500 => SiteInput::Motion { position: 0.0, velocity: 0.0 },
        _ => SiteInput::Free,
    }
}

const STEPS: usize = 20_000;

/// State, report and every contact are those of a mechanism whose steps are all taken; and a good part is not taken.
#[test]
fn a_mechanism_at_rest_takes_no_steps() {
    let (model, start) = rigid_grand_at_rest();
    let settings = Settings::new(50e-6);
    let (mut plain, mut workspace) = (start.clone(), WorkspaceOfSix::new());
    let (mut resting, mut own_workspace, mut repose) = (start.clone(), WorkspaceOfSix::new(), Sleep::awake());
    let (mut left_out, mut woken) = (0, 0);
    for n in 0..STEPS {
        let input = input(n);
        let rested = repose.is_asleep();
        let report = step(&model, &settings, &input, &mut plain, &mut workspace);
        let own = repose.step(&model, &settings, &input, &mut resting, &mut own_workspace);
        assert_eq!(own, report, "step {n}");
        assert!(resting.identical(&plain), "step {n}");
        for zone in 0..14 {
            let force =
                |workspace: &WorkspaceOfSix| workspace.contact(&model, &settings, zone).map(|c| c.force.to_bits());
            assert_eq!(force(&own_workspace), force(&workspace), "step {n}, zone {zone}");
        }
        assert_eq!(own_workspace.drive_force().to_bits(), workspace.drive_force().to_bits());
        left_out += usize::from(rested && repose.is_asleep());
        woken += usize::from(rested && !repose.is_asleep());
    }
    println!("{left_out} of {STEPS} steps left out, woken {woken} times");
    assert!(left_out > STEPS / 3 && woken >= 2, "{left_out} {woken}");
    repose.wake();
    assert!(!repose.is_asleep());
}

/// The same in every kind of lanes: they rest together, and one of them is enough to wake all.
#[test]
fn a_group_at_rest_takes_no_steps() {
    let (model, start) = rigid_grand_at_rest();
    for lanes in Lanes::here() {
        let count = lanes.count();
        let group =
            || GrandGroup::new(&vec![model.clone(); count], &vec![start.clone(); count], &Settings::new(50e-6), lanes);
        let (mut plain, mut resting) = (group(), group());
        let (mut outcomes, mut own) = (vec![StepOutcome::Converged; count], vec![StepOutcome::Converged; count]);
        let mut left_out = 0;
        for n in 0..STEPS {
            let rested = resting.is_at_rest();
            // The last lane is a little later than the others.
            let inputs: Vec<_> =
                (0..count).map(|i| input(if i + 1 == count { n.saturating_sub(50) } else { n })).collect();
            plain.step(&inputs, &mut outcomes);
            resting.step_or_rest(&inputs, &mut own);
            assert_eq!(own, outcomes, "{lanes:?}, step {n}");
            left_out += usize::from(rested && resting.is_at_rest());
            for i in 0..count {
                assert_eq!(resting.motion(i), plain.motion(i), "{lanes:?}, step {n}, lane {i}");
            }
        }
        println!("{lanes:?}: {left_out} of {STEPS} steps left out");
        assert!(left_out > STEPS / 3, "{lanes:?}: {left_out}");
        for i in 0..count {
            assert!(resting.state(i).identical(&plain.state(i)), "{lanes:?}, lane {i}");
        }
    }
}

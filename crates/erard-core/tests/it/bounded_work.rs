//! The work of a step is bounded, and a step that runs into its bound leaves a state that can be gone on from.

use crate::common::rigid_grand_at_rest;
use erard::assembly::describe;
use erard::instrument::Instrument;
use erard::mechanism::{mechanism, open_ledger, update_energies};
use moreau::{Settings, SiteInput, StepOutcome};
use moreau_kernels::{Lanes, side_by_side};

type GrandGroup = moreau_kernels::Group<6, 14, 10>;

/// With no tolerance at all, an iteration is accepted only when it changes nothing: steps that move run into the bound.
/// Two seconds of strokes of 40 N and releases, with one, two and five iterations allowed.
///
/// What is claimed: no step takes more iterations than allowed; every step ends, and says how; the state stays finite;
/// and the energy stored is never more than what was there and what the drive has put in, to a percent (one iteration
/// alone leaves the felts linear over a step, which is what the percent is for).
#[test]
fn the_bound_is_reached_and_nothing_blows_up() {
    let grand = Instrument::builtin("concert-grand").expect("built in");
    for newton_limit in [1, 2, 5] {
        let settings = Settings { tolerance: 0.0, newton_limit, ..Settings::new(50e-6) };
        let mut m = mechanism(&grand, settings).expect("assembles");
        let mut ledger = open_ledger(m.as_mut());
        let (mut limited, mut most_sets) = (0, 0);
        for n in 0..40_000 {
            let force = if n % 4000 < 2000 { 40.0 } else { 0.0 };
            let report = m.step(&SiteInput::Force(force)).report;
            m.record_energy(&mut ledger);
            assert!(report.newton <= newton_limit, "{report:?}");
            assert_ne!(report.outcome, StepOutcome::NonFinite, "step {n}");
            limited += u32::from(report.outcome == StepOutcome::IterationLimit);
            most_sets = most_sets.max(report.solver);
            if n % 100 == 0 {
                update_energies(m.as_ref(), &mut ledger);
                let (stored, put_in) = (ledger.now.total() - ledger.start.total(), ledger.drive_work);
                assert!(stored.is_finite() && stored <= put_in + 0.01 * ledger.drive_work_in, "step {n}: {ledger:?}");
                assert!(m.readout().angles.iter().chain(m.readout().velocities).all(|x| x.is_finite()), "step {n}");
            }
        }
        println!(
            "at most {newton_limit}: {limited} of 40000 steps ran into the bound, at most {most_sets} active sets"
        );
        assert!(limited > 1000, "the bound is reached: {limited}");
    }
}

/// The search for what sticks ends soon, too, in the hardest steps that were found: a pressed key that is let go from
/// one step to the next, when friction under load reverses in many contacts at once. Every built-in grand, pressed with
/// 1 to 40 N and let go, at once and over a millisecond. docs/notes/chip.md quotes what this prints (`-- the_search
/// --nocapture`).
///
/// What is claimed: every step converges, and no search takes more than 64 active sets: 32 guesses, and where they
/// cycle, the exact solver's own.
#[test]
fn the_search_for_what_sticks_ends() {
    const RELEASE: usize = 6000;
    for name in Instrument::builtin_names().filter(|name| !name.contains("strings")) {
        let grand = Instrument::builtin(name).expect("built in");
        let settings = Settings::new(50e-6);
        for (release, steps_of_release) in [("from one step to the next", 1), ("over a millisecond", 20)] {
            let (mut most, mut at, mut sets, mut steps) = (0, (0.0, 0), 0_u64, 0_u64);
            for force in [1.0, 2.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0] {
                let mut m = mechanism(&grand, settings).expect("assembles");
                for n in 0..2 * RELEASE {
                    let left = (RELEASE + steps_of_release).saturating_sub(n + 1).min(steps_of_release);
                    let report = m.step(&SiteInput::Force(force * left as f64 / steps_of_release as f64)).report;
                    assert_eq!(report.outcome, StepOutcome::Converged, "{name}, {force} N, step {n}");
                    (sets, steps) = (sets + u64::from(report.solver), steps + 1);
                    if most < report.solver {
                        (most, at) = (report.solver, (force, n));
                    }
                }
            }
            let (event, from) = if at.1 < RELEASE { ("the press", 0) } else { ("the release", RELEASE) };
            println!(
                "{name}, let go {release}: at most {most} active sets, at {} N, {:.2} ms after {event}; {:.3} a step",
                at.0,
                0.05 * (at.1 - from) as f64,
                sets as f64 / steps as f64
            );
            assert!((1..=64).contains(&most), "{name}: {most} active sets");
        }
    }
}

/// The one-step solver's bound likewise: with one sweep of Gauss-Seidel allowed, steps say that they have not
/// converged, and go on.
#[test]
fn one_sweep_is_no_disaster() {
    let grand = Instrument::builtin("concert-grand").expect("built in");
    let usual = Settings::new(50e-6);
    let settings = Settings { solver: moreau::Solver::ProjectedGaussSeidel, solver_limit: 1, newton_limit: 4, ..usual };
    let mut m = mechanism(&grand, settings).expect("assembles");
    let mut limited = 0;
    for n in 0..20_000 {
        let report = m.step(&SiteInput::Force(if n < 10_000 { 40.0 } else { 0.0 })).report;
        assert!(report.newton <= 4 && report.solver <= 4, "{report:?}");
        assert_ne!(report.outcome, StepOutcome::NonFinite, "step {n}");
        limited += u32::from(report.outcome == StepOutcome::IterationLimit);
    }
    let energies = m.energies_at(m.readout().velocities);
    println!("{limited} of 20000 steps ran into the bound; energies {energies:?}");
    assert!(limited > 1000 && energies.total().is_finite());
    assert!(m.readout().angles.iter().all(|q| q.abs() < 1.0), "{:?}", m.readout().angles);
}

/// The same in the lanes of the batch: with no tolerance every moving step runs into its bound; each lane says so for
/// itself, goes on, and is where it would be alone, its neighbours' work being no concern of it.
#[test]
fn lanes_run_into_the_bound_each_for_itself() {
    let (model, state) = rigid_grand_at_rest();
    let settings = Settings { tolerance: 0.0, newton_limit: 2, ..Settings::new(50e-6) };
    for lanes in [Lanes::Four].into_iter().filter(|lanes| lanes.is_here()) {
        let count = lanes.count();
        let group = |lanes| GrandGroup::new(&vec![model.clone(); count], &vec![state.clone(); count], &settings, lanes);
        let (mut together, mut alone) = (group(lanes), group(Lanes::One));
        let (mut outcomes, mut unused) = (vec![StepOutcome::Converged; count], vec![StepOutcome::Converged; count]);
        let mut limited = vec![0_u32; count];
        for n in 0..20_000 {
            // One lane rests, the others are struck at different rates.
            let force = |i: usize| if i > 0 && (n / (1000 * i)).is_multiple_of(2) { 40.0 } else { 0.0 };
            let inputs: Vec<SiteInput<f64>> = (0..count).map(|i| SiteInput::Force(force(i))).collect();
            together.step(&inputs, &mut outcomes);
            // Without a tolerance rounding decides whether the last iteration changed nothing at all, so that outcomes
            // may differ.
            alone.step(&inputs, &mut unused);
            for (i, outcome) in outcomes.iter().enumerate() {
                assert_ne!(*outcome, StepOutcome::NonFinite, "step {n}, lane {i}");
                limited[i] += u32::from(*outcome == StepOutcome::IterationLimit);
                let ((angle, _), (own, _)) = (together.motion(i), alone.motion(i));
                assert!(angle.iter().zip(&own).all(|(a, b)| (a - b).abs() < 1e-9), "step {n}, lane {i}");
            }
        }
        println!("{lanes:?}: {limited:?} of 20000 steps ran into the bound");
        assert!(limited[1..].iter().all(|&limited| limited > 500) && limited[0] < limited[1], "{limited:?}");
    }
}

/// The stack that a step in lanes takes is bounded, too: the widest lanes of the grand that bends are made and stepped
/// on half of what a thread has. (Lanes of twice this width once took more than all of it.)
#[test]
fn lanes_are_made_on_half_a_threads_stack() {
    let stepped = std::thread::Builder::new().stack_size(1 << 20).spawn(|| {
        let grand = describe(&Instrument::builtin("concert-grand").expect("built in"));
        let state = moreau::SavedState::<f64, 12, 32>::at_rest(core::array::from_fn(|i| {
            grand.angles.get(i).copied().unwrap_or(0.0)
        }));
        Lanes::here()
            .map(|lanes| {
                let count = lanes.count();
                let mut group = side_by_side(&vec![&grand; count], &vec![state; count], &Settings::new(50e-6), lanes)
                    .expect("a size holds it");
                let mut outcomes = vec![StepOutcome::Converged; count];
                for _ in 0..200 {
                    group.step(&vec![SiteInput::Force(20.0); count], &mut outcomes);
                }
                assert!(outcomes.iter().all(|outcome| *outcome == StepOutcome::Converged), "{lanes:?}: {outcomes:?}");
                (group.lanes(), group.state(count - 1).angle[0])
            })
            .collect::<Vec<_>>()
    });
    let stepped = stepped.expect("a thread").join().expect("no step fails");
    println!("{stepped:?}");
    let (_, alone) = stepped[0];
    // Single precision is among them.
    assert!(stepped.iter().all(|(_, angle)| (angle - alone).abs() < 1e-5), "{stepped:?}");
}

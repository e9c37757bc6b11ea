//! Mechanisms in lanes move as each of them does alone.

use batch::{Group, Lanes};
use moreau::{Body, Curve, Exponent, Felt, GROUND, Input, Model, Outcome, Settings, Site, State, Zone};

/// A lever on a felt, hit by a second one: two hinges with dry friction, a rubbing contact and a stop. `i` changes the masses.
fn pair(i: usize) -> Model<f64, 2, 3> {
    let heavier = 1.0 + 0.3 * i as f64;
    let body = |pivot, inertia: f64| Body {
        pivot,
        mass: 0.1 * heavier,
        inertia: inertia * heavier,
        center_of_mass: [0.05, 0.0],
        dry: 1e-3,
        viscous: 1e-4,
        ..Body::inert()
    };
    let felt = Felt { stiffness: 1e8, exponent: Exponent::Two, damping: 1e8 };
    let zone = |disc_body, center, curve_body, y, friction| Zone {
        disc_body,
        center,
        radius: 0.005,
        curve_body,
        curve: Curve::Line { point: [0.1, y], normal: [0.0, 1.0] },
        felt,
        friction,
    };
    let zones = [
        zone(0, [0.1, 0.0], GROUND, -0.006, None),
        zone(1, [0.1, -0.005], 0, 0.0, Some(0.3)),
        zone(1, [0.15, 0.02], GROUND, -0.004, None),
    ];
    let site = Site { body: 0, point: [0.1, 0.0], direction: [0.0, -1.0], stiffness: 2e4, damping: 20.0 };
    let bodies = [body([0.0, 0.0], 1e-3), body([0.02, 0.01], 2e-4)];
    Model::new(&bodies, &[], &zones, Some(site), 9.81).expect("sound")
}

/// A group of as many mechanisms as there are lanes, each its own, at rest.
fn group(lanes: Lanes, count: usize) -> Group<2, 3, 4> {
    let models: Vec<_> = (0..count).map(pair).collect();
    let states = vec![State::at_rest([0.0; 2]); count];
    Group::new(&models, &states, &Settings::new(50e-6), lanes)
}

/// Half a second of pushes, each lane with its own model and its own pushes. The sums run in the same order in lanes and alone, so that
/// only rounding may differ: a part in 1e9 after 10 000 steps with impacts, which multiply rounding. The lanes slide, stick and need
/// Newton iterations at different times, so that none of it may reach a neighbour either.
#[test]
fn lanes_move_as_alone() {
    for lanes in [Lanes::Four, Lanes::Eight] {
        if lanes > Lanes::most() {
            println!("{lanes:?}: not on this processor");
            continue;
        }
        let count = lanes.count();
        let (mut together, mut alone) = (group(lanes, count), group(Lanes::One, count));
        assert_eq!((together.lanes(), alone.lanes()), (lanes, Lanes::One));
        let mut outcomes = [vec![Outcome::Converged; count], vec![Outcome::Converged; count]];
        let mut moved = 0.0_f64;
        for n in 0..10_000 {
            let push = |i| Input::Force(if n / (400 + 100 * i) % 2 == 0 { -3.0 } else { 2.0 });
            let inputs: Vec<_> = (0..count).map(push).collect();
            together.step(&inputs, &mut outcomes[0]);
            alone.step(&inputs, &mut outcomes[1]);
            assert_eq!(outcomes[0], outcomes[1], "step {n}");
            for i in 0..count {
                let (a, b) = (together.state(i), alone.state(i));
                for k in 0..2 {
                    assert!((a.angle[k] - b.angle[k]).abs() < 1e-9, "step {n}, lane {i}: {a:?} {b:?}");
                    moved = moved.max(b.angle[k].abs());
                }
            }
        }
        assert!(moved > 0.01, "they do move: {moved}");
    }
}

/// Inputs of several kinds, and numbers that are not finite in one lane: each lane gets its own, and the others go on.
#[test]
fn a_lane_by_itself() {
    let lanes = Lanes::most();
    let count = lanes.count();
    let (mut together, mut alone) = (group(lanes, count), group(Lanes::One, count));
    let mut outcomes = [vec![Outcome::Converged; count], vec![Outcome::Converged; count]];
    for n in 0..200 {
        let push = |i: usize| match (i, n) {
            (0, 100..) => Input::Force(f64::NAN),
            (1, 50..100) => Input::Free,
            _ => Input::Force(-1.0),
        };
        let inputs: Vec<_> = (0..count).map(push).collect();
        together.step(&inputs, &mut outcomes[0]);
        alone.step(&inputs, &mut outcomes[1]);
        assert_eq!(outcomes[0], outcomes[1], "step {n}");
        assert_eq!(outcomes[0][0] == Outcome::NonFinite, n >= 100, "step {n}");
    }
    for i in 0..count {
        let (a, b) = (together.state(i), alone.state(i));
        assert!((a.angle[0] - b.angle[0]).abs() < 1e-12, "lane {i}: {a:?} {b:?}");
    }
}

/// As many as there are lanes and alike: otherwise one by one.
#[test]
fn groups_that_do_not_fit_are_stepped_one_by_one() {
    assert_eq!(group(Lanes::Four, 3).lanes(), Lanes::One);
    assert_eq!(group(Lanes::Eight, 9).lanes(), Lanes::One);
    assert!(group(Lanes::most(), Lanes::most().count()).lanes() == Lanes::most());
}

//! Mechanisms in lanes move as each of them does alone.

use batch::{Group, Lanes, WIDTH};
use moreau::{Body, Curve, Exponent, Felt, GROUND, Input, Model, Settings, Site, State, Zone};

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

/// Half a second of pushes, each lane with its own model and its own pushes. The sums run in the same order in lanes and alone, so that
/// only rounding may differ: a part in 1e9 after 10 000 steps with impacts, which multiply rounding.
#[test]
fn lanes_move_as_alone() {
    let models: [_; WIDTH] = std::array::from_fn(pair);
    let states: [_; WIDTH] = std::array::from_fn(|_| State::<f64, 2, 3>::at_rest([0.0; 2]));
    let settings = Settings::new(50e-6);
    let mut together = Group::<2, 3, 4>::new(models.clone(), states.clone(), settings, true);
    let mut alone = Group::<2, 3, 4>::new(models, states, settings, false);
    assert!(!alone.in_lanes());
    println!("in lanes: {}", together.in_lanes());
    let mut moved = 0.0_f64;
    for n in 0..10_000 {
        let inputs = std::array::from_fn(|i| Input::Force(if n / (400 + 100 * i) % 2 == 0 { -3.0 } else { 2.0 }));
        assert_eq!(together.step(&inputs), alone.step(&inputs), "step {n}");
        for i in 0..WIDTH {
            let (a, b) = (together.state(i), alone.state(i));
            for k in 0..2 {
                assert!((a.angle[k] - b.angle[k]).abs() < 1e-9, "step {n}, lane {i}: {a:?} {b:?}");
                moved = moved.max(b.angle[k].abs());
            }
        }
    }
    assert!(moved > 0.01, "they do move: {moved}");
}

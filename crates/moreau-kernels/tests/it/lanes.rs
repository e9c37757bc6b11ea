//! Mechanisms in lanes move as each of them does alone.

use moreau::{
    Body, ContactCurve, Description, Exponent, Felt, GROUND, Loss, Model, Settings, Site, SiteInput, State,
    StepOutcome, Workspace, Zone, step,
};
use moreau_kernels::{Group, Lanes};

/// A lever on a felt, hit by a second one: two hinges with dry friction, a rubbing contact and a stop. `i` changes the
/// masses.
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
    let felt = Felt { stiffness: 1e8, exponent: Exponent::Two, loss: Loss::quadratic(1e8) };
    let zone = |disc_body, center, curve_body, y, friction| Zone {
        disc_body,
        center,
        radius: 0.005,
        curve_body,
        curve: ContactCurve::Line { point: [0.1, y], normal: [0.0, 1.0] },
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
    Description { bodies: &bodies, zones: &zones, site: Some(site), gravity: 9.81, ..Description::default() }
        .compile()
        .expect("sound")
}

fn models(count: usize) -> Vec<Model<f64, 2, 3>> {
    (0..count).map(pair).collect()
}

/// A group of as many mechanisms as there are lanes, each its own, at rest.
fn group(lanes: Lanes, count: usize) -> Group<2, 3, 4> {
    Group::new(&models(count), &vec![State::at_rest([0.0; 2]); count], &Settings::new(50e-6), lanes)
}

/// Pushes at a step, each lane's its own, so that the lanes slide, stick and need Newton iterations at different times.
fn pushes(n: usize, count: usize) -> Vec<SiteInput<f64>> {
    (0..count).map(|i| SiteInput::Force(if (n / (400 + 100 * i)).is_multiple_of(2) { -3.0 } else { 2.0 })).collect()
}

/// The largest differences of two groups' angles and velocities.
fn apart(a: &Group<2, 3, 4>, b: &Group<2, 3, 4>, count: usize) -> [f64; 2] {
    let mut most = [0.0_f64; 2];
    for i in 0..count {
        let (a, b) = (a.motion(i), b.motion(i));
        for k in 0..2 {
            most[0] = most[0].max((a.0[k] - b.0[k]).abs());
            most[1] = most[1].max((a.1[k] - b.1[k]).abs());
        }
    }
    most
}

fn in_doubles(test: impl FnOnce(Lanes)) {
    let lanes = Lanes::Four;
    if !lanes.is_here() {
        println!("{lanes:?}: not on this processor");
        return;
    }
    test(lanes);
}

/// From wherever the mechanisms are, a step in lanes is a step alone to rounding: velocities of a few rad/s, made of
/// sums that cancel to a thousandth of their parts, agree to 1e-12.
#[test]
fn a_step_in_lanes_is_a_step_alone() {
    in_doubles(|lanes| {
        let (count, settings) = (lanes.count(), Settings::new(50e-6));
        let (models, mut alone) = (models(count), group(Lanes::One, count));
        let mut outcomes = [vec![StepOutcome::Converged; count], vec![StepOutcome::Converged; count]];
        let mut moved = 0.0_f64;
        for n in 0..10_000 {
            let states: Vec<_> = (0..count).map(|i| alone.state(i)).collect();
            let mut together = Group::new(&models, &states, &settings, lanes);
            assert_eq!(together.lanes(), lanes);
            let inputs = pushes(n, count);
            together.step(&inputs, &mut outcomes[0]);
            alone.step(&inputs, &mut outcomes[1]);
            assert_eq!(outcomes[0], outcomes[1], "step {n}");
            let [angle, velocity] = apart(&together, &alone, count);
            assert!(angle < 1e-16 && velocity < 1e-12, "step {n}: {angle:e} rad, {velocity:e} rad/s");
            moved = moved.max(alone.motion(0).0[0].abs());
        }
        assert!(moved > 0.01, "they do move: {moved}");
    });
}

/// In single precision, too, of whose rounding units of 6e-8 an update of these velocities has some hundred: A is
/// nearly singular to them where a stiff felt pushes a light lever.
#[test]
fn a_single_step_in_lanes_is_a_single_step_alone() {
    let lanes = Lanes::EightSingle;
    if !lanes.is_here() {
        println!("{lanes:?}: not on this processor");
        return;
    }
    let (count, settings) = (lanes.count(), Settings::new(50e-6));
    let models = models(count);
    let alone: Vec<Model<f32, 2, 3>> = (0..count).map(|i| Model::of_lanes(&[&models[i]]).expect("one")).collect();
    let own = Settings::in_lanes(&settings);
    let mut states = vec![State::<f32, 2, 3>::at_rest([0.0; 2]); count];
    let mut workspace = Workspace::<f32, 2, 3, 4>::new();
    let mut outcomes = vec![StepOutcome::Converged; count];
    let (mut moved, mut apart) = (0.0_f64, [0.0_f64; 2]);
    for n in 0..10_000 {
        let before: Vec<State<f64, 2, 3>> = states.iter().map(|state| state.lane(0)).collect();
        let mut together = Group::<2, 3, 4>::new(&models, &before, &settings, lanes);
        assert_eq!(together.lanes(), lanes);
        let inputs = pushes(n, count);
        together.step(&inputs, &mut outcomes);
        for (i, state) in states.iter_mut().enumerate() {
            let input = SiteInput::of_lanes(&inputs[i..=i]).expect("one");
            let report = step(&alone[i], &own, &input, state, &mut workspace);
            assert_eq!(outcomes[i], report.outcome, "step {n}, lane {i}");
            let (angle, velocity) = together.motion(i);
            for k in 0..2 {
                apart[0] = apart[0].max((angle[k] - f64::from(state.angle[k])).abs());
                apart[1] = apart[1].max((velocity[k] - f64::from(state.velocity[k])).abs());
            }
        }
        moved = moved.max(f64::from(states[0].angle[0]).abs());
    }
    println!("{lanes:?}: {apart:?}");
    assert!(apart[0] < 1e-7 && apart[1] < 1e-4, "{apart:?}");
    assert!(moved > 0.01, "they do move: {moved}");
}

/// Half a second of pushes: impacts multiply rounding, and lanes drift apart from mechanisms alone no more than those
/// do from themselves when every push is changed by a few units in its last place.
#[test]
fn lanes_move_as_alone() {
    in_doubles(|lanes| {
        let count = lanes.count();
        let (mut together, mut alone, mut shaken) =
            (group(lanes, count), group(Lanes::One, count), group(Lanes::One, count));
        assert_eq!((together.lanes(), alone.lanes()), (lanes, Lanes::One));
        let mut outcomes = [vec![StepOutcome::Converged; count], vec![StepOutcome::Converged; count]];
        let (mut lanes_apart, mut shaken_apart) = (0.0_f64, 0.0_f64);
        for n in 0..10_000 {
            let inputs = pushes(n, count);
            let sign = if n.is_multiple_of(2) { 1.0 } else { -1.0 };
            let others: Vec<_> = inputs
                .iter()
                .map(|push| match push {
                    SiteInput::Force(force) => SiteInput::Force(force * (1.0 + sign * 8.0 * f64::EPSILON)),
                    other => *other,
                })
                .collect();
            together.step(&inputs, &mut outcomes[0]);
            alone.step(&inputs, &mut outcomes[1]);
            assert_eq!(outcomes[0], outcomes[1], "step {n}");
            shaken.step(&others, &mut outcomes[1]);
            lanes_apart = lanes_apart.max(apart(&together, &alone, count)[0]);
            shaken_apart = shaken_apart.max(apart(&shaken, &alone, count)[0]);
        }
        println!("{lanes:?}: {lanes_apart:e} rad, shaken {shaken_apart:e} rad");
        assert!(shaken_apart < 1e-6 && lanes_apart < 10.0 * shaken_apart, "{lanes_apart:e} {shaken_apart:e}");
    });
}

/// Inputs of several kinds, and numbers that are not finite in one lane: each lane gets its own, and the others go on.
#[test]
fn a_lane_by_itself() {
    let lanes = Lanes::most();
    let count = lanes.count();
    let (mut together, mut alone) = (group(lanes, count), group(Lanes::One, count));
    let mut outcomes = [vec![StepOutcome::Converged; count], vec![StepOutcome::Converged; count]];
    for n in 0..200 {
        let push = |i: usize| match (i, n) {
            (0, 100..) => SiteInput::Force(f64::NAN),
            (1, 50..100) => SiteInput::Free,
            _ => SiteInput::Force(-1.0),
        };
        let inputs: Vec<_> = (0..count).map(push).collect();
        together.step(&inputs, &mut outcomes[0]);
        alone.step(&inputs, &mut outcomes[1]);
        assert_eq!(outcomes[0], outcomes[1], "step {n}");
        assert_eq!(outcomes[0][0] == StepOutcome::NonFinite, n >= 100, "step {n}");
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
    assert_eq!(group(Lanes::EightSingle, 9).lanes(), Lanes::One);
    assert!(group(Lanes::most(), Lanes::most().count()).lanes() == Lanes::most());
}

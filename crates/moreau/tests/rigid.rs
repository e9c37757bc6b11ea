//! Rigid bodies: collisions, redundant loops, self-locking, and what a step does with what it cannot do.

use moreau::GROUND;
use moreau::rigid::{
    Body, Contact, Energies, Joint, JointKind, Model, ModelError, Outcome, Placement, Scratch, Settings, State,
    Surface, step,
};

fn at(x: f64, y: f64, angle: f64) -> Placement<f64> {
    Placement { at: [x, y], angle }
}

fn hinge(first: usize, at_first: [f64; 2], second: usize, at_second: [f64; 2]) -> Joint<f64> {
    Joint { kind: JointKind::Hinge, first, at_first, second, at_second, dry: 0.0, viscous: 0.0, rate: None }
}

fn floor(body: usize, mu: f64, belt: f64) -> Contact<f64> {
    Contact {
        disc_body: body,
        center: [0.0, 0.0],
        radius: 0.0,
        surface_body: GROUND,
        surface: Surface::Line { point: [0.0, 0.0], normal: [0.0, 1.0] },
        restitution: 0.0,
        kinetic: mu,
        limit: mu,
        belt,
    }
}

/// Two smooth discs collide off centre: along the line of centres momentum and Newton's restitution decide, across it nothing
/// changes. The line is that at the instant of the step's middle, off by v h / 2 over the distance of the centres.
#[test]
fn discs_collide() {
    let (m1, m2, e, h) = (0.3, 0.5, 0.7, 1e-6);
    let bodies = [Body { mass: m1, inertia: 1.0 }, Body { mass: m2, inertia: 1.0 }];
    let contacts = [Contact {
        disc_body: 0,
        center: [0.0; 2],
        radius: 0.1,
        surface_body: 1,
        surface: Surface::Disc { center: [0.0; 2], radius: 0.2 },
        restitution: e,
        kinetic: 0.0,
        limit: 0.0,
        belt: 0.0,
    }];
    let model = Model::new(&bodies, &[], &[], &contacts, [0.0; 2]).unwrap();
    let mut state = State::<f64, 2, 2>::new(&[(at(-0.3, 0.15, 0.0), [2.0, 0.0, 0.0]), (at(0.0, 0.0, 0.0), [0.0; 3])]);
    let mut scratch = Scratch::new();
    for _ in 0..100_000 {
        let report = step(&model, &Settings::new(h), &[], &mut state, &mut scratch);
        assert_eq!(report.outcome, Outcome::Converged);
    }
    // At touch the centres are 0.3 apart, 0.15 of it upward: the line of centres is at 30 degrees.
    let n = [-(3.0_f64.sqrt()) / 2.0, 0.5];
    let impulse = (1.0 + e) * 2.0 * -n[0] / (1.0 / m1 + 1.0 / m2);
    let tolerance = 2.0 * 2.0 * h / 0.3 * 4.0;
    let expected = [[2.0 + impulse * n[0] / m1, impulse * n[1] / m1], [-impulse * n[0] / m2, -impulse * n[1] / m2]];
    for (v, expected) in state.velocity.iter().zip(expected) {
        assert!((v[0] - expected[0]).abs() < tolerance && (v[1] - expected[1]).abs() < tolerance, "{v:?} {expected:?}");
        assert!(v[2].abs() < 1e-15, "smooth discs do not spin");
    }
}

/// A parallelogram with a third, redundant crank: one equality more than the bodies can tell apart. The loads of the joints are not
/// determined, the motion is: the coupler keeps its angle, and the energy its value to second order.
#[test]
fn redundant_closures_are_solved() {
    let bar = Body { mass: 1.0, inertia: 0.02 };
    let bodies = [bar, bar, bar, Body { mass: 2.0, inertia: 0.5 }];
    let mut joints = Vec::new();
    // Not in one line, so that the third crank leads the others through the pose in which they are.
    let pivots = [[0.0, 0.0], [0.5, 0.3], [1.0, 0.0]];
    for (i, [x, y]) in pivots.into_iter().enumerate() {
        joints.push(hinge(GROUND, [x, y], i, [-0.25, 0.0]));
        joints.push(hinge(i, [0.25, 0.0], 3, [x - 0.5, y]));
    }
    let model = Model::new(&bodies, &joints, &[], &[], [0.0, -9.81]).unwrap();
    let (angle, rate) = (1.0_f64, 3.0);
    let (s, c) = angle.sin_cos();
    let crank = |i: usize| {
        (at(pivots[i][0] + 0.25 * c, pivots[i][1] + 0.25 * s, angle), [-0.25 * s * rate, 0.25 * c * rate, rate])
    };
    let coupler = (at(0.5 + 0.5 * c, 0.5 * s, 0.0), [-0.5 * s * rate, 0.5 * c * rate, 0.0]);
    let mut changes = Vec::new();
    for h in [1e-3, 5e-4] {
        let mut state = State::<f64, 4, 18>::new(&[crank(0), crank(1), crank(2), coupler]);
        assert!(state.assemble(&model, 1e-13));
        let mut scratch = Scratch::new();
        let start = Energies::of(&model, &state).total();
        let mut change = 0.0_f64;
        for _ in 0..(2.0 / h) as u32 {
            let report = step(&model, &Settings::new(h), &[], &mut state, &mut scratch);
            assert_eq!(report.outcome, Outcome::Converged);
            assert!(state.drift(&model) < 1e-10 && state.placement[3].angle.abs() < 1e-10);
            change = change.max((Energies::of(&model, &state).total() - start).abs());
        }
        changes.push(change);
    }
    let order = (changes[0] / changes[1]).log2();
    assert!((order - 2.0).abs() < 0.3, "{changes:?}");
}

/// A slide 60 degrees off the floor's normal, pressed on a belt that drags its foot further down: friction mu > 1/tan 60 degrees
/// loads the foot more than it can bear, whatever the normal force, and there is no solution. The step says so and leaves the
/// state alone. The belt turned round, there is one.
#[test]
fn self_locking_has_no_solution() {
    let bodies = [Body { mass: 1.0, inertia: 1.0 }];
    let angle = 30.0_f64.to_radians();
    let axis = [angle.cos(), angle.sin()];
    let kind = JointKind::Slide { axis, angle: 0.0 };
    let joints = [Joint {
        kind,
        first: GROUND,
        at_first: [0.0; 2],
        second: 0,
        at_second: [0.0; 2],
        dry: 0.0,
        viscous: 0.0,
        rate: None,
    }];
    for (mu, belt, expected) in
        [(0.7, -1.0, Outcome::NoSolution), (0.7, 1.0, Outcome::Converged), (0.5, -1.0, Outcome::Converged)]
    {
        let contacts = [floor(0, mu, belt)];
        let model = Model::new(&bodies, &joints, &[], &contacts, [0.0, -9.81]).unwrap();
        let mut state = State::<f64, 1, 5>::new(&[(at(0.0, 0.0, 0.0), [0.0; 3])]);
        let before = state.clone();
        let report = step(&model, &Settings::new(1e-3), &[], &mut state, &mut Scratch::new());
        assert_eq!(report.outcome, expected, "mu {mu}, belt {belt}");
        if expected == Outcome::NoSolution {
            assert_eq!(state, before);
            assert!(report.guesses < 100, "{report:?}");
        } else {
            // Along the slide: (sin 30 +- mu cos 30) N = m g sin 30, and it stays.
            let friction = if belt > 0.0 { mu } else { -mu };
            let normal = 9.81 * angle.sin() / (angle.sin() + friction * angle.cos());
            let found = state.impulse[model.contact_laws(0)[0]] / 1e-3;
            assert!((found / normal - 1.0).abs() < 1e-9, "{found} {normal}");
            assert!(state.velocity[0].iter().all(|v| v.abs() < 1e-12));
        }
    }
}

/// A hinge's dry friction holds a pendulum up to its torque and brakes it beyond: m g l = 0.981 N m at 90 degrees.
#[test]
fn a_dry_hinge_sticks() {
    let bodies = [Body { mass: 0.1, inertia: 0.05 }];
    for (dry, moves) in [(1.0, false), (0.9, true)] {
        let joints = [Joint { dry, ..hinge(GROUND, [0.0; 2], 0, [-1.0, 0.0]) }];
        let model = Model::new(&bodies, &joints, &[], &[], [0.0, -9.81]).unwrap();
        let mut state = State::<f64, 1, 3>::new(&[(at(1.0, 0.0, 0.0), [0.0; 3])]);
        let mut scratch = Scratch::new();
        for _ in 0..1000 {
            let report = step(&model, &Settings::new(1e-5), &[], &mut state, &mut scratch);
            assert_eq!(report.outcome, Outcome::Converged);
        }
        if moves {
            // (0.981 - 0.9) / (0.05 + 0.1) rad/s2 for 10 ms; the arm shortens by (angle)2/2, 1e-9 of it.
            let rate = -(0.981 - 0.9) / 0.15 * 0.01;
            assert!((state.velocity[0][2] - rate).abs() < 1e-8, "{}", state.velocity[0][2]);
        } else {
            assert!(state.placement[0].angle.abs() < 1e-15, "{}", state.placement[0].angle);
        }
    }
}

/// What a step cannot do it says, and leaves the state as it was.
#[test]
fn refusals_leave_the_state() {
    let bodies = [Body { mass: 1.0, inertia: 1.0 }; 2];
    let model = Model::new(&bodies, &[], &[], &[], [0.0, -9.81]).unwrap();
    let mut small = State::<f64, 1, 0>::new(&[]);
    let report = step(&model, &Settings::new(1e-3), &[], &mut small, &mut Scratch::new());
    assert_eq!(report.outcome, Outcome::NoRoom);
    let mut state = State::<f64, 2, 0>::new(&[]);
    for bad in [f64::NAN, f64::INFINITY] {
        let report = step(&model, &Settings::new(1e-3), &[[bad, 0.0, 0.0]], &mut state, &mut Scratch::new());
        assert_eq!(report.outcome, Outcome::NonFinite);
        assert_eq!(state, State::new(&[]));
    }
}

/// Nothing that is not finite, negative or unknown enters a model.
#[test]
fn bad_models_are_refused() {
    let body = Body { mass: 1.0, inertia: 1.0 };
    let none = [0.0; 2];
    let of = |bodies: &[Body<f64>], joints: &[Joint<f64>], contacts: &[Contact<f64>]| {
        Model::new(bodies, joints, &[], contacts, none).err()
    };
    assert_eq!(of(&[Body { mass: 0.0, ..body }], &[], &[]), Some(ModelError::BadBody(0)));
    assert_eq!(of(&[body], &[hinge(GROUND, none, 1, none)], &[]), Some(ModelError::UnknownBody));
    assert_eq!(of(&[body], &[hinge(0, none, 0, none)], &[]), Some(ModelError::UnknownBody));
    assert_eq!(of(&[body], &[hinge(GROUND, [f64::NAN, 0.0], 0, none)], &[]), Some(ModelError::BadJoint(0)));
    assert_eq!(
        of(&[body], &[], &[Contact { restitution: 1.1, ..floor(0, 0.1, 0.0) }]),
        Some(ModelError::BadContact(0))
    );
    assert_eq!(of(&[body], &[], &[Contact { limit: 0.05, ..floor(0, 0.1, 0.0) }]), Some(ModelError::BadContact(0)));
}

/// The same source in single precision: a block slides with g (sin 20 - mu cos 20) to seven digits less rounding of 100 steps.
#[test]
fn single_precision_works() {
    let bodies = [Body { mass: 0.5_f32, inertia: 0.01 }];
    let slope = 20.0_f32.to_radians();
    let contact = Contact {
        disc_body: 0,
        center: [0.0, 0.0],
        radius: 0.0,
        surface_body: GROUND,
        surface: Surface::Line { point: [0.0, 0.0], normal: [-slope.sin(), slope.cos()] },
        restitution: 0.0_f32,
        kinetic: 0.3,
        limit: 0.3,
        belt: 0.0,
    };
    let contacts = [contact];
    let model = Model::new(&bodies, &[], &[], &contacts, [0.0, -9.81]).unwrap();
    let mut state = State::<f32, 1, 2>::new(&[]);
    let mut scratch = Scratch::new();
    for _ in 0..100 {
        let report = step(&model, &Settings::new(0.01), &[], &mut state, &mut scratch);
        assert_eq!(report.outcome, Outcome::Converged);
    }
    let speed = state.velocity[0][0].hypot(state.velocity[0][1]);
    assert!((speed - 0.589_702_2).abs() < 1e-5, "{speed}");
}

/// Moving ground: a table on a driven slide, speeding up by 4 m/s2, with a block on it and friction of 0.3. The block slides: it speeds up
/// by 0.3 g = 2.943 m/s2. When the table keeps its speed from t = 0.5 s on, the block catches up at t = 2 / 2.943 = 0.6796 s and rides
/// along. Exact in between, rounding of 10 000 steps; the catching up is known to a step.
#[test]
fn a_table_carries_a_block() {
    let bodies = [Body { mass: 5.0, inertia: 1.0 }, Body { mass: 0.5, inertia: 0.01 }];
    let kind = JointKind::Slide { axis: [1.0, 0.0], angle: 0.0 };
    let contacts = [Contact {
        disc_body: 1,
        center: [0.0, 0.0],
        radius: 0.0,
        surface_body: 0,
        surface: Surface::Line { point: [0.0, 0.0], normal: [0.0, 1.0] },
        restitution: 0.0,
        kinetic: 0.3,
        limit: 0.3,
        belt: 0.0,
    }];
    let h = 1e-4;
    let mut state = State::<f64, 2, 5>::new(&[]);
    let mut scratch = Scratch::new();
    for n in 1..=10_000 {
        let t = f64::from(n) * h;
        let rate = Some(4.0 * t.min(0.5));
        let slide = Joint {
            kind,
            first: GROUND,
            at_first: [0.0; 2],
            second: 0,
            at_second: [0.0; 2],
            dry: 0.0,
            viscous: 0.0,
            rate,
        };
        let joints = [slide];
        let model = Model::new(&bodies, &joints, &[], &contacts, [0.0, -9.81]).unwrap();
        let report = step(&model, &Settings::new(h), &[], &mut state, &mut scratch);
        assert_eq!(report.outcome, Outcome::Converged, "step {n}");
        let [table, block] = [state.velocity[0][0], state.velocity[1][0]];
        assert!((table - 4.0 * t.min(0.5)).abs() < 1e-11, "{t}: {table}");
        let expected = (2.943 * t).min(2.0);
        assert!((block - expected).abs() < 1e-10, "{t}: {block} {expected}");
    }
}

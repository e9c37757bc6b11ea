//! Rigid bodies: collisions, redundant loops, self-locking, and what a step does with what it cannot do.

use moreau::GROUND;
use moreau_rigid::{
    Body, Contact, Energies, ImpactLaw, Joint, JointKind, Model, ModelError, Placement, PolygonContact, Settings,
    SolvedBy, Spring, State, StepOutcome, Surface, Torsion, Workspace, step,
};

fn at(x: f64, y: f64, angle: f64) -> Placement<f64> {
    Placement { at: [x, y], angle }
}

fn hinge(first: usize, at_first: [f64; 2], second: usize, at_second: [f64; 2]) -> Joint<f64> {
    Joint { kind: JointKind::Hinge, first, at_first, second, at_second, dry: 0.0, viscous: 0.0, rate: None }
}

fn floor(body: usize, mu: f64, belt: f64) -> Contact<'static, f64> {
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

/// Two smooth discs collide off centre: along the line of centres momentum and Newton's restitution decide, across it
/// nothing changes. The line is that at the instant of the step's middle, off by v h / 2 over the distance of the
/// centres.
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
    let mut workspace = Workspace::new();
    for _ in 0..100_000 {
        let report = step(&model, &Settings::new(h), &[], &mut state, &mut workspace);
        assert_eq!(report.outcome, StepOutcome::Converged);
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

/// A parallelogram with a third, redundant crank: one equality more than the bodies can tell apart. The loads of the
/// joints are not determined, the motion is: the coupler keeps its angle, and the energy its value to second order.
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
        let mut workspace = Workspace::new();
        let start = Energies::of(&model, &state).total();
        let mut change = 0.0_f64;
        for _ in 0..(2.0 / h) as u32 {
            let report = step(&model, &Settings::new(h), &[], &mut state, &mut workspace);
            assert_eq!(report.outcome, StepOutcome::Converged);
            assert!(state.drift(&model) < 1e-10 && state.placement[3].angle.abs() < 1e-10);
            change = change.max((Energies::of(&model, &state).total() - start).abs());
        }
        changes.push(change);
    }
    let order = (changes[0] / changes[1]).log2();
    assert!((order - 2.0).abs() < 0.3, "{changes:?}");
}

/// A slide 60 degrees off the floor's normal, pressed on a belt that drags its foot further down: friction mu > 1/tan
/// 60 degrees loads the foot more than it can bear, whatever the normal force, and there is no solution. The step says
/// so and leaves the state alone. The belt turned round, there is one.
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
        [(0.7, -1.0, StepOutcome::NoSolution), (0.7, 1.0, StepOutcome::Converged), (0.5, -1.0, StepOutcome::Converged)]
    {
        let contacts = [floor(0, mu, belt)];
        let model = Model::new(&bodies, &joints, &[], &contacts, [0.0, -9.81]).unwrap();
        let mut state = State::<f64, 1, 5>::new(&[(at(0.0, 0.0, 0.0), [0.0; 3])]);
        let before = state.clone();
        let report = step(&model, &Settings::new(1e-3), &[], &mut state, &mut Workspace::new());
        assert_eq!(report.outcome, expected, "mu {mu}, belt {belt}");
        if expected == StepOutcome::NoSolution {
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
        let mut workspace = Workspace::new();
        for _ in 0..1000 {
            let report = step(&model, &Settings::new(1e-5), &[], &mut state, &mut workspace);
            assert_eq!(report.outcome, StepOutcome::Converged);
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
    let report = step(&model, &Settings::new(1e-3), &[], &mut small, &mut Workspace::new());
    assert_eq!(report.outcome, StepOutcome::NoRoom);
    let mut state = State::<f64, 2, 0>::new(&[]);
    for bad in [f64::NAN, f64::INFINITY] {
        let report = step(&model, &Settings::new(1e-3), &[[bad, 0.0, 0.0]], &mut state, &mut Workspace::new());
        assert_eq!(report.outcome, StepOutcome::NonFinite);
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
    let slot = |axis| Joint { kind: JointKind::Slot { axis }, ..hinge(GROUND, none, 0, none) };
    assert_eq!(of(&[body], &[slot([1.0, 1.0])], &[]), Some(ModelError::BadJoint(0)));
    let clockwise = [[0.0, 0.0], [0.0, 1.0], [1.0, 0.0]];
    let star: Vec<[f64; 2]> = (0..5).map(|k| (f64::from(k) * 144.0_f64.to_radians()).sin_cos().into()).collect();
    let dented = [[0.0, 0.0], [1.0, 0.0], [0.2, 0.2], [0.0, 1.0]];
    let whole = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0]];
    let bare = Model::new(std::slice::from_ref(&body), &[], &[], &[], none).unwrap();
    for (corners, sound) in
        [(&clockwise[..], false), (&star, false), (&dented, false), (&whole[..2], false), (&whole, true)]
    {
        let contact = Contact { surface: Surface::Polygon { corners }, ..floor(0, 0.1, 0.0) };
        assert_eq!(of(&[body], &[], &[contact]).is_none(), sound, "{corners:?}");
        let pair = PolygonContact {
            first: 0,
            first_corners: &whole,
            second: GROUND,
            second_corners: corners,
            restitution: 0.0,
            kinetic: 0.0,
            limit: 0.0,
        };
        assert_eq!(bare.with_polygons(&[pair]).is_ok(), sound, "{corners:?}");
    }
    let plate = |from, to, depth| Contact { surface: Surface::Segment { from, to, depth }, ..floor(0, 0.1, 0.0) };
    assert_eq!(of(&[body], &[], &[plate(none, none, 1.0)]), Some(ModelError::BadContact(0)));
    assert_eq!(of(&[body], &[], &[plate(none, [1.0, 0.0], 0.0)]), Some(ModelError::BadContact(0)));
    let torsion = Torsion { first: GROUND, second: 0, stiffness: 1.0, damping: 0.0, angle: 0.0 };
    let torsions = |torsion| bare.with_torsions(&[torsion]).err();
    assert_eq!(torsions(Torsion { stiffness: -1.0, ..torsion }), Some(ModelError::BadTorsion(0)));
    assert_eq!(torsions(Torsion { angle: f64::NAN, ..torsion }), Some(ModelError::BadTorsion(0)));
    assert_eq!(torsions(Torsion { second: 1, ..torsion }), Some(ModelError::UnknownBody));
    assert_eq!(torsions(torsion), None);
}

/// Five blocks on lines (each carries a line for the next one's corners), tilted by 0.01 rad, restitution 0.3: ten
/// contacts at once, which were tried guess by guess. No contact pulls, no friction is beyond its cone, a step is
/// quick, and they come to rest.
#[test]
fn a_tilted_stack_on_lines() {
    let (x, y, mu) = (0.1, 0.05, 0.5);
    let bodies = [Body { mass: 1.0, inertia: (x * x + y * y) / 3.0 }; 5];
    let contacts: Vec<Contact<'_, f64>> = (0..5)
        .flat_map(|i| {
            [-x, x].map(|corner| Contact {
                disc_body: i,
                center: [corner, -y],
                radius: 0.0,
                surface_body: if i == 0 { GROUND } else { i - 1 },
                surface: Surface::Line { point: [0.0, if i == 0 { 0.0 } else { y }], normal: [0.0, 1.0] },
                restitution: 0.3,
                kinetic: mu,
                limit: mu,
                belt: 0.0,
            })
        })
        .collect();
    let model = Model::new(&bodies, &[], &[], &contacts, [0.0, -9.81]).unwrap();
    for law in [ImpactLaw::Newton, ImpactLaw::Stronge] {
        let start: Vec<_> = (0..5).map(|i| (at(0.0, 0.01 + y + 2.0 * y * f64::from(i), 0.01), [0.0; 3])).collect();
        let mut state = State::<f64, 5, 20>::new(&start);
        let mut workspace = Workspace::new();
        let settings = Settings { impact_law: law, ..Settings::new(1e-3) };
        for n in 0..1000 {
            let report = step(&model, &settings, &[], &mut state, &mut workspace);
            assert_eq!(report.outcome, StepOutcome::Converged, "{law:?}, step {n}: {report:?}");
            assert!(report.guesses < 1000 && report.residual < 1e-11, "{law:?}, step {n}: {report:?}");
            for c in 0..10 {
                let [normal, friction] = model.contact_laws(c).map(|i| state.impulse[i]);
                assert!(
                    normal >= 0.0 && friction.abs() <= mu * normal + 1e-15,
                    "{law:?}, step {n}: {normal} {friction}"
                );
            }
        }
        assert!(state.velocity.iter().flatten().all(|v| v.abs() < 1e-13), "{law:?}: {:?}", state.velocity);
    }
}

/// Without sweeps a step cannot solve a stack. It says so, and how far off it is, and its impulses are admissible.
#[test]
fn what_is_not_solved_is_told() {
    let (x, y) = (0.1, 0.05);
    let bodies = [Body { mass: 1.0, inertia: (x * x + y * y) / 3.0 }; 15];
    let corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
    let ground = [[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [-1.0, 0.0]];
    let pairs: Vec<PolygonContact<'_, f64>> = (0..15)
        .map(|i| PolygonContact {
            first: i,
            first_corners: &corners,
            second: if i == 0 { GROUND } else { i - 1 },
            second_corners: if i == 0 { &ground } else { &corners },
            restitution: 0.3,
            kinetic: 0.5,
            limit: 0.5,
        })
        .collect();
    let model = Model::new(&bodies, &[], &[], &[], [0.0, -9.81]).unwrap().with_polygons(&pairs).unwrap();
    let tilt = |i: usize| if i.is_multiple_of(2) { 0.01 } else { -0.01 };
    let start: Vec<_> = (0..15).map(|i| (at(0.0, 0.002 + 0.05 + 0.102 * i as f64, tilt(i)), [0.0; 3])).collect();
    let mut state = State::<f64, 15, 60>::new(&start);
    let mut workspace = Workspace::new();
    let settings = Settings { sweep_limit: 0, solver_limit: 0, ..Settings::new(1e-3) };
    let mut nearly = 0;
    for n in 0..300 {
        let report = step(&model, &settings, &[], &mut state, &mut workspace);
        if report.outcome == StepOutcome::Approximate {
            nearly += 1;
            assert!(report.solver == SolvedBy::Sweeps && report.residual > 1e-12, "step {n}: {report:?}");
        } else {
            assert_eq!(report.outcome, StepOutcome::Converged, "step {n}");
        }
        for c in 0..15 {
            for k in 0..2 {
                let [normal, friction] = model.polygon_laws(c, k).map(|i| state.impulse[i]);
                assert!(normal >= 0.0 && friction.abs() <= 0.5 * normal + 1e-15, "step {n}: {normal} {friction}");
            }
        }
    }
    assert!(nearly > 0, "guesses alone were enough");
}

/// A frictionless block falls flat, with spin zero, on two corners: by Stronge's law it leaves flat with e times its
/// speed, whatever its contacts share; and a ball on the way between two others passes its momentum on. Both without a
/// gain.
#[test]
fn stronges_law_with_several_contacts() {
    let bodies = [Body { mass: 2.0, inertia: 0.01 }];
    let corner = |x: f64| Contact { center: [x, -0.05], restitution: 0.6, ..floor(0, 0.0, 0.0) };
    let contacts = [corner(-0.1), corner(0.1)];
    let model = Model::new(&bodies, &[], &[], &contacts, [0.0; 2]).unwrap();
    let mut state = State::<f64, 1, 4>::new(&[(at(0.0, 0.05, 0.0), [0.3, -1.0, 0.0])]);
    let settings = Settings { impact_law: ImpactLaw::Stronge, ..Settings::new(1e-6) };
    let report = step(&model, &settings, &[], &mut state, &mut Workspace::new());
    assert!(report.outcome == StepOutcome::Converged && report.impact_ended, "{report:?}");
    for (v, expected) in state.velocity[0].iter().zip([0.3, 0.6, 0.0]) {
        assert!((v - expected).abs() < 1e-12, "{:?}", state.velocity);
    }
    // 1/2 m (e2 - 1) u2.
    assert!((report.impact_energy - (0.36 - 1.0)).abs() < 1e-12, "{report:?}");

    // Springs of one stiffness between three equal balls, the first one struck: momentum and, with e = 1, energy are
    // kept, and the last one leaves with most of it, but not all (a chain of springs disperses: Newton's cradle needs
    // gaps).
    let balls = [Body { mass: 1.0, inertia: 1.0 }; 3];
    let touch = |first: usize| Contact {
        disc_body: first,
        center: [0.0; 2],
        radius: 0.5,
        surface_body: first + 1,
        surface: Surface::Disc { center: [0.0; 2], radius: 0.5 },
        restitution: 1.0,
        kinetic: 0.0,
        limit: 0.0,
        belt: 0.0,
    };
    let contacts = [touch(0), touch(1)];
    let model = Model::new(&balls, &[], &[], &contacts, [0.0; 2]).unwrap();
    let mut state = State::<f64, 3, 4>::new(&[
        (at(0.0, 0.0, 0.0), [1.0, 0.0, 0.0]),
        (at(1.0, 0.0, 0.0), [0.0; 3]),
        (at(2.0, 0.0, 0.0), [0.0; 3]),
    ]);
    let report = step(&model, &settings, &[], &mut state, &mut Workspace::new());
    assert!(report.outcome == StepOutcome::Converged && report.impact_ended, "{report:?}");
    let v = [0, 1, 2].map(|i| state.velocity[i][0]);
    assert!((v.iter().sum::<f64>() - 1.0).abs() < 1e-12 && report.impact_energy.abs() < 1e-10, "{v:?} {report:?}");
    // By Newton's equations of the two springs, solved by an independent integration at a step of 1e-5 of their time.
    let expected = three_balls();
    for (ours, expected) in v.iter().zip(expected) {
        assert!((ours - expected).abs() < 2e-3, "{v:?} {expected:?}");
    }
}

/// Three balls of mass one, springs of stiffness one that push only: velocities after the first one has come with speed
/// one. Verlet's method.
fn three_balls() -> [f64; 3] {
    let (mut x, mut v, h) = ([0.0; 3], [1.0, 0.0, 0.0], 1e-4);
    for _ in 0..200_000 {
        let mut kick = |x: &[f64; 3]| {
            for i in 0..2 {
                let force = f64::max(0.0, x[i] - x[i + 1]);
                v[i] -= 0.5 * h * force;
                v[i + 1] += 0.5 * h * force;
            }
        };
        kick(&x);
        for i in 0..3 {
            x[i] += h * v[i];
        }
        let mut kick = |x: &[f64; 3]| {
            for i in 0..2 {
                let force = f64::max(0.0, x[i] - x[i + 1]);
                v[i] -= 0.5 * h * force;
                v[i + 1] += 0.5 * h * force;
            }
        };
        kick(&x);
    }
    v
}

/// A pin in a slot with a stop: it slides without friction, meets the end and rests there; the slot turns with its
/// body.
#[test]
fn a_slot_may_end() {
    let bodies = [Body { mass: 1.0, inertia: 0.1 }];
    // The slot goes down to the right at 30 degrees and ends after one metre.
    let (s, c) = 30.0_f64.to_radians().sin_cos();
    let slot = Joint { kind: JointKind::Slot { axis: [c, -s] }, ..hinge(GROUND, [0.0; 2], 0, [0.0; 2]) };
    let stop =
        Contact { surface: Surface::Line { point: [c, -s], normal: [-c, s] }, restitution: 0.0, ..floor(0, 0.0, 0.0) };
    let (joints, contacts) = [[slot], [slot]].into_iter().zip([vec![], vec![stop]]).unzip::<_, _, Vec<_>, Vec<_>>();
    for (joints, contacts) in joints.iter().zip(&contacts) {
        let model = Model::new(&bodies, joints, &[], contacts, [0.0, -9.81]).unwrap();
        let mut state = State::<f64, 1, 5>::new(&[(at(0.0, 0.0, 0.0), [0.0, 0.0, 2.0])]);
        let mut workspace = Workspace::new();
        for _ in 0..1000 {
            let report = step(&model, &Settings::new(1e-3), &[], &mut state, &mut workspace);
            assert_eq!(report.outcome, StepOutcome::Converged);
        }
        let place = state.placement[0];
        let way = place.at[0] * c - place.at[1] * s;
        // Half g sin 30 t2 without the stop; with it one metre, and a closing that is known to a step of 3.1 m/s.
        let expected = if contacts.is_empty() { 0.5 * 9.81 * s } else { 1.0 };
        assert!((way - expected).abs() < if contacts.is_empty() { 1e-11 } else { 3.2e-3 }, "{way} {expected}");
        assert!((place.at[0] * s + place.at[1] * c).abs() < 1e-12, "it stays in the slot");
        assert!((place.angle - 2.0).abs() < 1e-11, "it turns freely");
    }
}

/// Viscous friction and a damper that would brake a body many times over in a step: v1 / v0 = (1 - a) / (1 + a), a =
/// theta h c / m.
#[test]
fn strong_dampers_are_stable() {
    let bodies = [Body { mass: 0.5, inertia: 0.02 }];
    let joints = [Joint { viscous: 400.0, ..hinge(GROUND, [0.0; 2], 0, [0.0; 2]) }];
    let torsions = [Torsion { first: GROUND, second: 0, stiffness: 0.0, damping: 200.0, angle: 0.0 }];
    let model = Model::new(&bodies, &joints, &[], &[], [0.0; 2]).unwrap().with_torsions(&torsions).unwrap();
    let mut state = State::<f64, 1, 3>::new(&[(at(0.0, 0.0, 0.0), [0.0, 0.0, 3.0])]);
    let report = step(&model, &Settings::new(1e-2), &[], &mut state, &mut Workspace::new());
    let a = 0.5 * 1e-2 * 600.0 / 0.02;
    assert_eq!(report.outcome, StepOutcome::Converged);
    assert!((state.velocity[0][2] / (3.0 * (1.0 - a) / (1.0 + a)) - 1.0).abs() < 1e-11, "{:?}", state.velocity);
    // A spring without length whose ends coincide: the midpoint rule, in any direction.
    let springs = [Spring {
        first: GROUND,
        at_first: [0.0; 2],
        second: 0,
        at_second: [0.0; 2],
        stiffness: 1e9,
        damping: 0.0,
        length: 0.0,
    }];
    let model = Model::new(&bodies, &[], &springs, &[], [0.0; 2]).unwrap();
    let mut state = State::<f64, 1, 0>::new(&[(at(0.0, 0.0, 0.0), [0.6, 0.8, 0.0])]);
    let report = step(&model, &Settings::new(1e-2), &[], &mut state, &mut Workspace::new());
    let b = 0.25 * 1e-4 * 1e9 / 0.5;
    assert_eq!(report.outcome, StepOutcome::Converged);
    for (v, v0) in state.velocity[0].iter().zip([0.6, 0.8]) {
        assert!((v - v0 * (1.0 - b) / (1.0 + b)).abs() < 1e-9, "{:?}", state.velocity);
    }
}

/// A torsion spring holds half its stiffness times the square of what it is turned by from where it has no moment.
#[test]
fn torsion_springs_hold_their_energy() {
    let bodies = [Body { mass: 0.5, inertia: 0.02 }];
    let torsions = [Torsion { first: GROUND, second: 0, stiffness: 3.0, damping: 0.0, angle: 0.2 }];
    let model = Model::new(&bodies, &[], &[], &[], [0.0; 2]).unwrap().with_torsions(&torsions).unwrap();
    let state = State::<f64, 1, 0>::new(&[(at(0.0, 0.0, 0.7), [0.0; 3])]);
    assert!((Energies::of(&model, &state).springs - 0.5 * 3.0 * 0.25).abs() < 1e-15);
}

/// The same source in single precision: a block slides with g (sin 20 - mu cos 20) to seven digits less rounding of 100
/// steps.
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
    let mut workspace = Workspace::new();
    for _ in 0..100 {
        let report = step(&model, &Settings::new(0.01), &[], &mut state, &mut workspace);
        assert_eq!(report.outcome, StepOutcome::Converged);
    }
    let speed = state.velocity[0][0].hypot(state.velocity[0][1]);
    assert!((speed - 0.589_702_2).abs() < 1e-5, "{speed}");
}

/// Moving ground: a table on a driven slide, speeding up by 4 m/s2, with a block on it and friction of 0.3. The block
/// slides: it speeds up by 0.3 g = 2.943 m/s2. When the table keeps its speed from t = 0.5 s on, the block catches up
/// at t = 2 / 2.943 = 0.6796 s and rides along. Exact in between, rounding of 10 000 steps; the catching up is known to
/// a step.
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
    let mut workspace = Workspace::new();
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
        let report = step(&model, &Settings::new(h), &[], &mut state, &mut workspace);
        assert_eq!(report.outcome, StepOutcome::Converged, "step {n}");
        let [table, block] = [state.velocity[0][0], state.velocity[1][0]];
        assert!((table - 4.0 * t.min(0.5)).abs() < 1e-11, "{t}: {table}");
        let expected = (2.943 * t).min(2.0);
        assert!((block - expected).abs() < 1e-10, "{t}: {block} {expected}");
    }
}

/// Three tilted blocks in single precision, by both laws of impacts: they come to rest, and a step that does not meet
/// its tolerance says so.
#[test]
fn a_stack_in_single_precision() {
    let (x, y) = (0.1_f32, 0.05_f32);
    let bodies = [Body { mass: 1.0, inertia: (x * x + y * y) / 3.0 }; 3];
    let corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
    let ground = [[-1.0, -1.0], [1.0, -1.0], [1.0, 0.0], [-1.0, 0.0]];
    let pairs = [0, 1, 2].map(|i| PolygonContact {
        first: i,
        first_corners: &corners[..],
        second: if i == 0 { GROUND } else { i - 1 },
        second_corners: if i == 0 { &ground[..] } else { &corners },
        restitution: 0.3,
        kinetic: 0.5,
        limit: 0.5,
    });
    let model = Model::new(&bodies, &[], &[], &[], [0.0, -9.81]).unwrap().with_polygons(&pairs).unwrap();
    for law in [ImpactLaw::Newton, ImpactLaw::Stronge] {
        let place = |i: usize| Placement { at: [0.0, 0.055 + 0.102 * i as f32], angle: [0.01, -0.01, 0.01][i] };
        let start = [0, 1, 2].map(|i| (place(i), [0.0; 3]));
        let mut state = State::<f32, 3, 12>::new(&start);
        let mut workspace = Workspace::new();
        let settings = Settings { impact_law: law, ..Settings::new(1e-3) };
        for n in 0..1000 {
            let report = step(&model, &settings, &[], &mut state, &mut workspace);
            let sound = matches!(report.outcome, StepOutcome::Converged | StepOutcome::Approximate);
            assert!(sound && report.residual < 1e-3, "{law:?}, step {n}: {report:?}");
            for (c, k) in [(0, 0), (0, 1), (1, 0), (1, 1), (2, 0), (2, 1)] {
                let [normal, friction] = model.polygon_laws(c, k).map(|i| state.impulse[i]);
                assert!(normal >= 0.0 && friction.abs() <= 0.5 * normal + 1e-8, "{law:?}, step {n}");
            }
        }
        assert!(state.velocity.iter().flatten().all(|v| v.abs() < 1e-4), "{law:?}: {:?}", state.velocity);
    }
}

//! Derivatives of motions with dry friction against what is worked out by hand: where sliding turns round, comes to
//! stick, and sets off something else.

use moreau::{
    Body, ContactCurve, Description, Dual, Exponent, Felt, GROUND, Loss, Model, Real, Scalar, Settings, SiteInput,
    Spring, State, Tangent, TangentReport, Workspace, Zone, step,
};

type D2 = Dual<2>;

fn constant(x: f64) -> D2 {
    Dual::constant(x)
}

/// A value of which the derivative in one direction is 1.
fn along(value: f64, direction: usize) -> D2 {
    let mut slope = [0.0; 2];
    slope[direction] = 1.0;
    Dual { value, slope }
}

/// Unit inertia on a pivot with dry friction c, driven by a steady torque.
fn mass(torque: D2, dry: D2) -> ([Body<D2>; 1], [Spring<D2>; 1]) {
    let spring = Spring { body: 0, torque, stiffness: Dual::ZERO, reference: Dual::ZERO };
    ([Body { dry, ..Body::inert() }], [spring])
}

fn plain(bodies: &[Body<D2>], springs: &[Spring<D2>]) -> (Vec<Body<f64>>, Vec<Spring<f64>>) {
    let point = |p: [D2; 2]| p.map(|x| x.value);
    let body = |b: &Body<D2>| Body {
        parent: b.parent,
        pivot: point(b.pivot),
        mass: b.mass.value,
        inertia: b.inertia.value,
        center_of_mass: point(b.center_of_mass),
        dry: b.dry.value,
        viscous: b.viscous.value,
    };
    let spring = |s: &Spring<D2>| Spring {
        body: s.body,
        torque: s.torque.value,
        stiffness: s.stiffness.value,
        reference: s.reference.value,
    };
    (bodies.iter().map(body).collect(), springs.iter().map(spring).collect())
}

/// Runs for so long from given velocities.
fn run<const B: usize, const N: usize>(
    bodies: &[Body<D2>],
    springs: &[Spring<D2>],
    velocity: [D2; B],
    h: f64,
    steps: usize,
) -> (State<D2, B, 0>, TangentReport) {
    let (plain_bodies, plain_springs) = plain(bodies, springs);
    let model: Model<D2, B, 0> = Description { bodies, springs, ..Description::default() }.compile().unwrap();
    let description = Description { bodies: &plain_bodies, springs: &plain_springs, ..Description::default() };
    let mut tangent: Tangent<B, 0, N, 2> =
        Tangent::new(model, description.compile().unwrap(), [Dual::ZERO; B]).unwrap();
    tangent.state.velocity = velocity;
    let (settings, mut all) = (Settings::new(h), TangentReport::default());
    for _ in 0..steps {
        all = all.and(tangent.step(&settings, &mut |_, _, _| SiteInput::Free, &mut |_| {}));
    }
    (tangent.state, all)
}

/// A mass is thrown against a steady force F, with dry friction c. It stops after v0/(F + c) and comes back with (F -
/// c) t. So dv/dv0 = (F - c)/(F + c): 0.92 with c = F/24. A fixed step in dual numbers gives 1, whatever its length,
/// for each of its steps has one side: this test shows that, too.
#[test]
fn a_reversal_changes_the_derivative() {
    let (force, dry, v0) = (24.0, 1.0, 1.0);
    let expected = (force - dry) / (force + dry);
    assert!((expected - 0.92_f64).abs() < 1e-15);
    let (bodies, springs) = mass(constant(-force), along(dry, 1));
    for h in [1e-3, 3.1e-4, 1e-4] {
        let steps = (0.1 / h) as usize;
        let (state, all) = run::<1, 1>(&bodies, &springs, [along(v0, 0)], h, steps);
        assert_eq!((all.switches, all.unresolved, all.unconverged, all.failed), (1, 0, 0, false));
        let [by_speed, by_friction] = state.velocity[0].slope;
        assert!((by_speed - expected).abs() < 1e-4, "{h} {by_speed}");
        // v = -(F - c) (t - v0/(F + c)).
        let t = steps as f64 * h;
        let truth = t - v0 / (force + dry) - (force - dry) * v0 / (force + dry).powi(2);
        assert!((by_friction - truth).abs() < 1e-4 * truth, "{h} {by_friction} {truth}");
        // Where: the derivative of -(F - c) (t - t0)^2/2 + v0 t0/2.
        let t0 = v0 / (force + dry);
        let place = (force - dry) * (t - t0) / (force + dry) + v0 / (force + dry);
        assert!((state.angle[0].slope[0] - place).abs() < 1e-4 * place, "{h} {:?} {place}", state.angle);

        let model: Model<D2, 1, 0> =
            Description { bodies: &bodies, springs: &springs, ..Description::default() }.compile().unwrap();
        let mut fixed = State::at_rest([Dual::ZERO]);
        fixed.velocity = [along(v0, 0)];
        let settings = dual(&Settings::new(h));
        let mut workspace = Workspace::<D2, 1, 0, 1>::for_model(&model).unwrap();
        for _ in 0..steps {
            step(&model, &settings, &SiteInput::Free, &mut fixed, &mut workspace);
        }
        let wrong = fixed.velocity[0].slope[0];
        assert!((wrong - expected).abs() > 0.05, "{h} {wrong}");
    }
}

fn dual(settings: &Settings<f64>) -> Settings<D2> {
    let Settings { step, theta, tolerance, solver_tolerance, newton_limit, solver_limit, solver, .. } = *settings;
    let [step, theta, tolerance, solver_tolerance] = [step, theta, tolerance, solver_tolerance].map(constant);
    Settings { step, theta, tolerance, solver_tolerance, newton_limit, solver_limit, solver, ..Settings::new(step) }
}

/// Less force than friction: it comes to rest after v0/(F + c), for good. Its place depends on how fast it was thrown,
/// its speed on nothing.
#[test]
fn what_comes_to_rest_keeps_its_place() {
    let (force, dry, v0) = (1.0, 4.0, 0.3);
    let (bodies, springs) = mass(along(-force, 1), constant(dry));
    let (state, all) = run::<1, 1>(&bodies, &springs, [along(v0, 0)], 1e-3, 100);
    assert_eq!((all.switches, all.unresolved), (1, 0));
    assert_eq!(state.velocity[0].value, 0.0);
    assert!(state.velocity[0].slope.iter().all(|x| x.abs() < 1e-6), "{:?}", state.velocity);
    // v0^2 / (2 (c + F)).
    let truth = [v0 / (dry + force), v0 * v0 / (2.0 * (dry + force).powi(2))];
    for k in 0..2 {
        assert!((state.angle[0].slope[k] - truth[k]).abs() < 1e-3 * truth[k], "{:?} {truth:?}", state.angle);
    }
}

/// A body on a body: the outer pivot comes to rest on the inner body, which stuck to the ground until then, and its
/// friction, which turns from pushing back to carrying the load, sets the inner one off at that very instant. The
/// derivatives follow from the two motions, pieced together by hand.
#[test]
fn one_that_sticks_may_set_off_another() {
    // Inner: inertia i, bound a, torque s. Outer: inertia j, relative speed w0, bound c, torque -t (its reaction on the
    // inner one: t).
    let (i, j, a, c) = (2.0, 1.0, 3.0, 1.5);
    let (s, t, w0) = (3.5, 0.9, 0.4);
    // While the outer slips forward, friction on it is -c and its springs give -t: on the inner one they act with c +
    // t... and -s.
    let held = c + t - s;
    assert!(f64::abs(held) < a, "{held}");
    // Then both go as one, with the torque -s alone: |s| > a.
    assert!(s > a);
    let together = -(s - a) / (i + j);
    // As one they need of the pivot between them: j times the acceleration, less its spring.
    assert!((j * together + t).abs() < c);
    let bodies = [
        Body { inertia: constant(i), dry: constant(a), ..Body::inert() },
        Body { parent: 0, inertia: constant(j), dry: along(c, 1), ..Body::inert() },
    ];
    let spring = |body, torque| Spring { body, torque: constant(torque), stiffness: Dual::ZERO, reference: Dual::ZERO };
    let springs = [spring(0, -s), spring(1, -t)];
    let (state, all) = run::<2, 2>(&bodies, &springs, [Dual::ZERO, along(w0, 0)], 1e-3, 300);
    assert!(all.switches >= 1 && all.unresolved == 0, "{all:?}");
    // It stops after w0 j/(c + t); from there on v = together (time - that).
    let (end, stop) = (0.3, w0 * j / (c + t));
    let truth = [-together * j / (c + t), together * w0 * j / (c + t).powi(2)];
    for body in 0..2 {
        let v = &state.velocity[body];
        assert!((v.value - together * (end - stop)).abs() < 1e-3, "{v:?}");
        for k in 0..2 {
            assert!((v.slope[k] - truth[k]).abs() < 1e-3 * truth[k].abs(), "{v:?} {truth:?}");
        }
    }
}

/// Two masses that know nothing of each other turn round 3e-9 s apart, which is less than the steps that look for
/// either: both derivatives jump.
#[test]
fn two_that_turn_round_together_both_jump() {
    let (force, dry, v0) = (24.0, 1.0, 1.0);
    let body = Body { dry: constant(dry), ..Body::inert() };
    let spring = |body| Spring { body, torque: constant(-force), stiffness: Dual::ZERO, reference: Dual::ZERO };
    let expected = (force - dry) / (force + dry);
    for (h, apart) in [(1e-3, 3e-9), (3.1e-4, 3e-9), (1e-3, 4e-8), (1e-3, 1e-6)] {
        let second = v0 + apart * (force + dry);
        let velocity = [along(v0, 0), along(second, 1)];
        let (state, all) = run::<2, 2>(&[body, body], &[spring(0), spring(1)], velocity, h, (0.1 / h) as usize);
        assert_eq!((all.switches, all.unresolved), (2, 0), "{h} {apart}");
        for k in 0..2 {
            let slope = state.velocity[k].slope;
            assert!((slope[k] - expected).abs() < 1e-4 && slope[1 - k].abs() < 1e-6, "{h} {apart} {slope:?}");
        }
    }
}

/// Of two bodies that touch.
type Touching<T> = ([Body<T>; 2], [Spring<T>; 2], [Zone<T>; 1]);

/// A hanging table under a felted arm that presses on it: where the table is thrown against a steady torque, and slides
/// back under the arm. The contact turns with both, and the arm still swings on its felt, so that the row of the slip
/// is never the same for two steps.
fn table<T: Scalar>(friction: T) -> Touching<T> {
    let t = T::from_f64;
    let table = Body { inertia: t(1.0), ..Body::inert() };
    let arm = Body { inertia: t(0.05), pivot: [t(-0.5), t(1.3)], ..Body::inert() };
    let steady = |body, torque| Spring { body, torque: t(torque), stiffness: T::ZERO, reference: T::ZERO };
    let felt = Felt { stiffness: t(4e5), exponent: Exponent::Two, loss: Loss::quadratic(T::ZERO) };
    let surface = ContactCurve::Line { point: [T::ZERO, t(1.0)], normal: [T::ZERO, t(1.0)] };
    let zone = Zone {
        disc_body: 1,
        center: [t(0.5), t(-0.1)],
        radius: t(0.2),
        curve_body: 0,
        curve: surface,
        felt,
        friction: Some(friction),
    };
    ([Body { parent: GROUND, ..table }, Body { parent: GROUND, ..arm }], [steady(0, 3.0), steady(1, -2.0)], [zone])
}

/// The derivative is that of wide differences, and the same for every length of step: a step across the reversal that
/// ends at rest, as four of five do here, is no stick.
#[test]
fn a_reversal_in_a_contact_that_turns_is_no_stick() {
    const END: f64 = 0.4;
    let thrown = |v0: f64, friction: f64, h: f64| {
        let (bodies, springs, zones) = table::<f64>(friction);
        let description = Description { bodies: &bodies, springs: &springs, zones: &zones, ..Description::default() };
        let model: Model<f64, 2, 1> = description.compile().unwrap();
        let mut state = State::at_rest([0.0; 2]);
        state.velocity = [-v0, 0.0];
        let mut workspace = Workspace::<f64, 2, 1, 3>::for_model(&model).unwrap();
        for _ in 0..(END / h).round() as usize {
            step(&model, &Settings::new(h), &SiteInput::Free, &mut state, &mut workspace);
        }
        state.velocity[0]
    };
    let (v0, mu, h) = (1.0, 0.5, 2e-5);
    let [by_speed, by_friction] = [
        (thrown(v0 + 0.01, mu, h) - thrown(v0 - 0.01, mu, h)) / 0.02,
        (thrown(v0, mu + 0.005, h) - thrown(v0, mu - 0.005, h)) / 0.01,
    ];
    // It came back.
    assert!(thrown(v0, mu, h) > 0.1);
    let (bodies, springs, zones) = table::<D2>(along(mu, 1));
    let (plain_bodies, plain_springs, plain_zones) = table::<f64>(mu);
    for part in 0..24 {
        let h = END / (400.0 + 37.0 * f64::from(part));
        let description = Description { bodies: &bodies, springs: &springs, zones: &zones, ..Description::default() };
        let plain = Description {
            bodies: &plain_bodies,
            springs: &plain_springs,
            zones: &plain_zones,
            ..Description::default()
        };
        let mut tangent: Tangent<2, 1, 3, 2> =
            Tangent::new(description.compile().unwrap(), plain.compile().unwrap(), [Dual::ZERO; 2]).unwrap();
        tangent.state.velocity[0] = Dual { value: -v0, slope: [-1.0, 0.0] };
        let mut all = TangentReport::default();
        for _ in 0..(END / h).round() as usize {
            all = all.and(tangent.step(&Settings::new(h), &mut |_, _, _| SiteInput::Free, &mut |_| {}));
        }
        let slope = tangent.state.velocity[0].slope;
        assert!(!all.failed && all.switches > 0, "{h} {all:?}");
        for (found, truth) in slope.into_iter().zip([by_speed, by_friction]) {
            assert!(
                (found - truth).abs() < 0.02 * truth.abs(),
                "{h}: {slope:?}, differences {by_speed} {by_friction} {all:?}"
            );
        }
    }
}

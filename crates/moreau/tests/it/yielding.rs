//! Zones whose curves yield, against answers that are not this engine's.

use moreau::{
    Body, COUPLED, ContactCurve, Description, Exponent, Felt, GROUND, Hereditary, Ledger, Loss, Model, ModelError,
    SetValued, Settings, SiteInput, State, StepOutcome, Surface, Workspace, Yields, Zone, step,
};

/// kg; on an arm of 1 m.
const MASS: f64 = 0.009;
/// N/m, of a linear felt.
const STIFF: f64 = 2e5;
/// N s/m: two directions of a string of 670 N and 6.34 g/m, 2 sqrt(T mu), three times.
const DAMPER: f64 = 3.0 * 2.0 * 2.061;
const SPEED: f64 = 2.0;

type One = (Model<f64, 1, 1>, State<f64, 1, 1>, Workspace<f64, 1, 1, 2>);

/// A mass at the end of a long arm, flying upward against a felt under a line.
fn thrown(felt: Felt<f64>, yields: &[Yields<f64>], gravity: f64) -> One {
    let bodies = [Body { mass: MASS, center_of_mass: [1.0, 0.0], inertia: MASS, ..Body::inert() }];
    let curve = ContactCurve::Line { point: [0.0, 0.0], normal: [0.0, -1.0] };
    let zone = Zone { disc_body: 0, center: [1.0, 0.0], radius: 0.0, curve_body: GROUND, curve, felt, friction: None };
    let description = Description { bodies: &bodies, zones: &[zone], yields, gravity, ..Description::default() };
    let model = description.compile().unwrap();
    let mut state = State::at_rest([0.0]);
    state.velocity = [SPEED];
    (model, state, Workspace::new())
}

const YIELDS: [Yields<f64>; 1] = [Yields { zone: 0, excursion: 1e-3 }];

fn linear() -> Felt<f64> {
    Felt { stiffness: STIFF, exponent: Exponent::Other(1.0), loss: Loss::quadratic(0.0) }
}

/// Force at an instant against a surface that yields as a dashpot does, F = R du/dt: an infinite string.
fn against_a_dashpot(h: f64, at: f64) -> f64 {
    let (model, mut state, mut workspace) = thrown(linear(), &YIELDS, 0.0);
    let settings = Settings { tolerance: 1e-12, ..Settings::new(h) };
    let (mut place, mut last, mut seen, mut t) = (0.0, 0.0, 0.0, 0.0);
    while t < 3e-3 {
        let surface = Surface { displacement: place, free: place, compliance: h / DAMPER };
        workspace.set_surface(&settings, 0, &surface);
        assert_eq!(
            step(&model, &settings, &SiteInput::Free, &mut state, &mut workspace).outcome,
            StepOutcome::Converged
        );
        let force = workspace.normal_force(&model, &settings, 0);
        place += h * force / DAMPER;
        // Forces belong to the middles of their steps.
        if t - 0.5 * h < at && at <= t + 0.5 * h {
            seen = last + (force - last) * (at - (t - 0.5 * h)) / h;
        }
        (last, t) = (force, t + h);
    }
    seen
}

/// With g the felt's compression, m (g' + F/R)' = -F and F = k g: g'' + 2 s g' + (k/m) g = 0 with 2 s = k/R, g(0) = 0,
/// g'(0) = v. Here s^2 > k/m: the string is so light that the mass only creeps to rest. Order: a quarter of the error
/// at half the step.
#[test]
fn a_mass_on_an_infinite_string() {
    let (s, square) = (0.5 * STIFF / DAMPER, STIFF / MASS);
    let exact = |t: f64| {
        let root = (s * s - square).sqrt();
        STIFF * SPEED * (-s * t).exp() * (root * t).sinh() / root
    };
    assert!(s * s > square);
    let at = 0.4e-3;
    let errors = [40e-6, 20e-6, 10e-6].map(|h| (against_a_dashpot(h, at) - exact(at)).abs() / exact(at));
    println!("{errors:?}");
    assert!(errors[2] < 2e-3, "{errors:?}");
    for pair in errors.windows(2) {
        let order = (pair[0] / pair[1]).log2();
        assert!((1.7..2.4).contains(&order), "{order} {errors:?}");
    }
}

/// What yields by nothing is a curve that stands still, whatever the felt: the same motion, but for the quadrature of
/// the felt's mean there, which is exact here.
#[test]
fn what_does_not_yield_stands_still() {
    for loss in
        [Loss::quadratic(1e5), Loss::hunt_crossley(0.1), Loss::Hereditary(Hereditary { relaxed: 0.5, time: 1e-4 })]
    {
        let felt = Felt { stiffness: 1e10, exponent: Exponent::TwoAndHalf, loss };
        let settings = Settings { tolerance: 1e-10, ..Settings::new(25e-6) };
        let [yielding, still] = [&YIELDS[..], &[]].map(|yields| {
            let (model, mut state, mut workspace) = thrown(felt, yields, 0.0);
            for _ in 0..100 {
                step(&model, &settings, &SiteInput::Free, &mut state, &mut workspace);
            }
            state.velocity[0]
        });
        assert!(still < -0.1 && (yielding - still).abs() < 1e-4 * still.abs(), "{loss:?}: {yielding} {still}");
    }
}

/// A mass that falls upward on a surface, bounces and comes to lie on it, for a second: the energy balance closes at
/// every length of step, and no felt gives energy. The surface is one undamped mode, stepped exactly; its energy is
/// added by hand.
#[test]
fn nothing_is_won_between_felt_and_surface() {
    for h in [20e-6, 50e-6, 200e-6] {
        let felt = Felt { stiffness: 1e10, exponent: Exponent::Three, loss: Loss::quadratic(1e5) };
        let (model, mut state, mut workspace) = thrown(felt, &YIELDS, -9.81);
        let (modal_mass, omega) = (2e-3, 1600.0_f64);
        let (mut q, mut v) = (0.0, 0.0);
        let settings = Settings { tolerance: 1e-12, ..Settings::new(h) };
        let mut ledger = Ledger::open(&model, &state);
        let (c, s) = ((omega * h).cos(), (omega * h).sin());
        for _ in 0..(1.0 / h) as usize {
            let free = q * c + v * s / omega;
            let compliance = (1.0 - c) / (modal_mass * omega * omega);
            workspace.set_surface(&settings, 0, &Surface { displacement: q, free, compliance });
            let before = state.clone();
            step(&model, &settings, &SiteInput::Free, &mut state, &mut workspace);
            ledger.record(&model, &settings, &before, &state, &workspace);
            let rest = workspace.normal_force(&model, &settings, 0) / (modal_mass * omega * omega);
            (q, v) = (rest + (q - rest) * c + v * s / omega, v * c - (q - rest) * omega * s);
        }
        ledger.now = moreau::Energies::displaced(&model, &state, |_| q);
        ledger.now.surface = 0.5 * modal_mass * (v * v + omega * omega * q * q);
        let residual = ledger.residual().abs() / ledger.start.kinetic;
        println!("h {h:e}: residual {residual:.2e}, lost {:.3e} J", ledger.dissipated());
        assert!(residual < 1e-8 && ledger.smallest_term >= 0.0 && ledger.felt_damping > 0.0, "{h}: {residual:e}");
    }
}

type Two = (Model<f64, 2, 2>, State<f64, 2, 2>, Workspace<f64, 2, 2, 4>);

/// Two masses at the ends of long arms, flying upward at given speeds against felts under a line.
fn two_thrown(masses: [f64; 2], speeds: [f64; 2], felt: Felt<f64>, gravity: f64) -> Two {
    let bodies = masses.map(|mass| Body { mass, center_of_mass: [1.0, 0.0], inertia: mass, ..Body::inert() });
    let curve = ContactCurve::Line { point: [0.0, 0.0], normal: [0.0, -1.0] };
    let zone = |body| Zone {
        disc_body: body,
        center: [1.0, 0.0],
        radius: 0.0,
        curve_body: GROUND,
        curve,
        felt,
        friction: None,
    };
    let (zones, yields) = ([zone(0), zone(1)], [0, 1].map(|zone| Yields { zone, excursion: 1e-3 }));
    let description =
        Description { bodies: &bodies, zones: &zones, yields: &yields, gravity, ..Description::default() };
    let model = description.compile().unwrap();
    let mut state = State::at_rest([0.0; 2]);
    state.velocity = speeds;
    (model, state, Workspace::new())
}

/// Two alike masses strike one thing at once: each finds what one mass finds on a surface with the compliance of both,
/// a + b, or, struck from the two sides, a - b.
#[test]
fn two_that_strike_together_are_one_on_what_yields_to_both() {
    let felt = Felt { stiffness: 1e10, exponent: Exponent::TwoAndHalf, loss: Loss::quadratic(1e6) };
    let settings = Settings { tolerance: 1e-13, ..Settings::new(50e-6) };
    // Of a step, 50 us: a dashpot's, and the other's part of it.
    let own = settings.step / DAMPER;
    for other in [0.6 * own, -0.6 * own] {
        let (model, mut state, mut workspace) = thrown(felt, &YIELDS, 0.0);
        let mut place = 0.0;
        let one: Vec<f64> = (0..100)
            .map(|_| {
                let surface = Surface { displacement: place, free: place, compliance: own + other };
                workspace.set_surface(&settings, 0, &surface);
                step(&model, &settings, &SiteInput::Free, &mut state, &mut workspace);
                let force = workspace.normal_force(&model, &settings, 0);
                place += (own + other) * force;
                force
            })
            .collect();
        let (model, mut state, mut workspace) = two_thrown([MASS; 2], [SPEED; 2], felt, 0.0);
        let mut compliance = [[0.0; COUPLED]; COUPLED];
        [compliance[0][1], compliance[1][0]] = [other; 2];
        let (mut places, mut most) = ([0.0; 2], 0.0_f64);
        for (n, expected) in one.iter().enumerate() {
            for (zone, displacement) in places.into_iter().enumerate() {
                workspace.set_surface(&settings, zone, &Surface { displacement, free: displacement, compliance: own });
            }
            // A bad guess costs rounds and nothing else.
            workspace.set_coupled_surfaces(&settings, &[0, 1], &compliance, &[3.0, 0.0, 0.0, 0.0]);
            assert_eq!(
                step(&model, &settings, &SiteInput::Free, &mut state, &mut workspace).outcome,
                StepOutcome::Converged
            );
            workspace.settle_surfaces(&model, &settings);
            let forces = [0, 1].map(|zone| workspace.normal_force(&model, &settings, zone));
            for (force, zone) in forces.iter().zip([0, 1]) {
                assert!(
                    (force - expected).abs() < 1e-9 * (1.0 + expected),
                    "step {n}, zone {zone}: {force} {expected}"
                );
            }
            places = [places[0] + own * forces[0] + other * forces[1], places[1] + own * forces[1] + other * forces[0]];
            most = most.max(forces[0]);
        }
        assert!(most > 10.0, "{most}");
    }
}

/// Two unlike masses that rattle on one undamped mode for a second: the energy balance closes at every length of step.
#[test]
fn nothing_is_won_where_two_press_one_thing() {
    for (h, shapes) in [(20e-6, [1.0, 0.7]), (50e-6, [1.0, -0.7]), (50e-6, [1.0, 0.7]), (200e-6, [1.0, 0.7])] {
        let felt = Felt { stiffness: 1e10, exponent: Exponent::Three, loss: Loss::quadratic(1e5) };
        let (model, mut state, mut workspace) = two_thrown([MASS, 0.03], [SPEED, 0.5], felt, -9.81);
        let (modal_mass, omega) = (2e-3, 1600.0_f64);
        let (mut q, mut v) = (0.0, 0.0);
        let settings = Settings { tolerance: 1e-12, ..Settings::new(h) };
        let mut ledger = Ledger::open(&model, &state);
        let (c, s) = ((omega * h).cos(), (omega * h).sin());
        let a = (1.0 - c) / (modal_mass * omega * omega);
        let mut compliance = [[0.0; COUPLED]; COUPLED];
        [compliance[0][1], compliance[1][0]] = [a * shapes[0] * shapes[1]; 2];
        let (mut both, mut forces) = (0, [0.0; COUPLED]);
        for _ in 0..(1.0 / h) as usize {
            let free = q * c + v * s / omega;
            for (zone, shape) in shapes.into_iter().enumerate() {
                let surface = Surface { displacement: shape * q, free: shape * free, compliance: a * shape * shape };
                workspace.set_surface(&settings, zone, &surface);
            }
            workspace.set_coupled_surfaces(&settings, &[0, 1], &compliance, &forces);
            let before = state.clone();
            step(&model, &settings, &SiteInput::Free, &mut state, &mut workspace);
            workspace.settle_surfaces(&model, &settings);
            ledger.record(&model, &settings, &before, &state, &workspace);
            for zone in [0, 1] {
                forces[zone] = workspace.normal_force(&model, &settings, zone);
            }
            both += usize::from(forces[0] > 0.0 && forces[1] > 0.0);
            let rest = (shapes[0] * forces[0] + shapes[1] * forces[1]) / (modal_mass * omega * omega);
            (q, v) = (rest + (q - rest) * c + v * s / omega, v * c - (q - rest) * omega * s);
        }
        ledger.now = moreau::Energies::displaced(&model, &state, |zone| shapes[zone] * q);
        ledger.now.surface = 0.5 * modal_mass * (v * v + omega * omega * q * q);
        let residual = ledger.residual().abs() / ledger.start.kinetic;
        println!(
            "h {h:e}, {shapes:?}: residual {residual:.2e}, lost {:.3e} J, both press in {both} steps",
            ledger.dissipated()
        );
        assert!(residual < 1e-8 && ledger.smallest_term >= 0.0 && ledger.felt_damping > 0.0, "{h}: {residual:e}");
        assert!(both > 10, "{both}");
    }
}

#[test]
fn wrong_surfaces_are_told() {
    let zone = |felt| Zone {
        disc_body: 0,
        center: [1.0, 0.0],
        radius: 0.0,
        curve_body: GROUND,
        curve: ContactCurve::Line { point: [0.0; 2], normal: [0.0, 1.0] },
        felt,
        friction: None,
    };
    let wrong = |felt, yields: Yields<f64>| {
        let (bodies, zones, yields) = ([Body::inert()], [zone(felt)], [yields]);
        let description = Description { bodies: &bodies, zones: &zones, yields: &yields, ..Description::default() };
        match description.check() {
            Err(ModelError::BadNumber { fault, .. }) => fault.field,
            other => panic!("{other:?}"),
        }
    };
    let dry = Felt { loss: Loss::SetValued(SetValued { eta: 0.2 }), ..linear() };
    assert_eq!(wrong(dry, YIELDS[0]), "the eta of a zone that yields");
    assert_eq!(wrong(linear(), Yields { zone: 1, excursion: 0.0 }), "the zone that yields");
    assert_eq!(wrong(linear(), Yields { zone: 0, excursion: -1.0 }), "excursion");
}

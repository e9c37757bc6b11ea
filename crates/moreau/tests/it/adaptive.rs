//! Steps with controlled error: what holds whatever the tolerance. That errors follow the tolerance is a conformance
//! problem.

use moreau::{
    Accuracy, Body, ControlledStep, Controller, Description, Model, Settings, SiteHand, SiteInput, Spring, State,
    StepDoubling, StepOutcome, controlled_step,
};

/// A body of unit inertia on a spring of unit stiffness, with dry friction.
struct Oscillator {
    model: Model<f64, 1, 0>,
    state: State<f64, 1, 0>,
    controller: Controller<f64, 0>,
    halves: StepDoubling<f64, 1, 0, 2>,
}

impl Oscillator {
    fn new(dry: f64, angle: f64, velocity: f64) -> Self {
        let body = Body { inertia: 1.0, dry, ..Body::inert() };
        let spring = Spring { body: 0, torque: 0.0, stiffness: 1.0, reference: 0.0 };
        let model =
            Description { bodies: &[body], springs: &[spring], ..Description::default() }.compile().expect("sound");
        let mut state = State::at_rest([angle]);
        state.velocity = [velocity];
        Oscillator { model, state, controller: Controller::new(1e-2), halves: StepDoubling::new(&Settings::new(1e-3)) }
    }

    fn step(&mut self, accuracy: &Accuracy<f64>, limit: f64) -> ControlledStep<f64> {
        let Oscillator { model, state, controller, halves } = self;
        let free = |_: f64, _: f64, _: &State<f64, 1, 0>| SiteInput::Free;
        controlled_step(model, &Settings::new(1e-3), accuracy, controller, limit, free, state, halves)
    }
}

/// Friction far larger than the spring's torque: nothing moves, to the bit, and steps become as long as they may.
#[test]
fn what_sticks_stays() {
    let mut o = Oscillator::new(2.0, 1.0, 0.0);
    let accuracy = Accuracy::new(1e-6, 1e-9, 1.0);
    let mut longest = 0.0_f64;
    for _ in 0..20 {
        let did = o.step(&accuracy, 10.0);
        assert_eq!((did.rejected, did.error), (0, 0.0));
        longest = longest.max(did.step);
    }
    assert_eq!((o.state.angle, o.state.velocity, longest), ([1.0], [0.0], 1.0));
}

/// The error of a smooth step in closed form, where the velocity's counts and where the angle's does: the midpoint rule
/// turns (angle, velocity) of the oscillator by 2 atan(h/2), its halves by 4 atan(h/4), and a third of the difference
/// is their error; backward Euler divides them by 1 + h^2 and turns them, and all of the difference is it.
#[test]
fn the_error_of_a_smooth_step_is_the_closed_form() {
    let (h, tolerance) = (0.125_f64, 1e-2);
    let midpoint = |h: f64, [x, v]: [f64; 2]| {
        let (s, c) = (2.0 * (0.5 * h).atan()).sin_cos();
        [c * x + s * v, c * v - s * x]
    };
    let euler = |h: f64, [x, v]: [f64; 2]| {
        let v = (v - h * x) / (1.0 + h * h);
        [x + h * v, v]
    };
    type Rule<'a> = (f64, f64, &'a dyn Fn(f64, [f64; 2]) -> [f64; 2]);
    let rules: [Rule<'_>; 2] = [(0.5, 1.0 / 3.0, &midpoint), (1.0, 1.0, &euler)];
    // A large longest step makes little of the angle's error.
    for (start, largest, of_velocity) in [([1.0, 0.0], 10.0, true), ([0.0, 1.0], h, false)] {
        for (theta, share, rule) in rules {
            let mut o = Oscillator::new(0.0, start[0], start[1]);
            let settings = Settings { theta, ..Settings::new(1e-3) };
            let accuracy = Accuracy::new(tolerance, 1e-9, largest);
            let mut controller = Controller::new(h);
            let free = |_: f64, _: f64, _: &State<f64, 1, 0>| SiteInput::Free;
            let Oscillator { model, state, halves, .. } = &mut o;
            let did = controlled_step(model, &settings, &accuracy, &mut controller, h, free, state, halves);
            let (whole, end) = (rule(h, start), rule(0.5 * h, rule(0.5 * h, start)));
            let velocity = share * (end[1] - whole[1]).abs() / (tolerance * (1.0 + end[1].abs()));
            let angle = share * (end[0] - whole[0]).abs() / (tolerance * largest);
            assert_eq!(velocity > angle, of_velocity, "{velocity} {angle}");
            let expected = velocity.max(angle);
            assert!((did.error - expected).abs() < 1e-9 * expected, "theta {theta}: {} {expected}", did.error);
            assert_eq!(did.rejected, 0, "{did:?}");
        }
    }
}

/// Across a reversal nothing is extrapolated; where the law's side stays, all is. A step never exceeds its limit.
#[test]
fn nothing_is_extrapolated_across_a_reversal() {
    let mut o = Oscillator::new(0.1, 12.0, 0.0);
    let accuracy = Accuracy::new(1e-4, 1e-9, 1.0);
    let (mut time, mut smooth, mut changed) = (0.0, 0, 0);
    while time < 20.0 {
        let before = o.state.velocity[0];
        let did = o.step(&accuracy, 0.37);
        assert!(did.step <= 0.37 && did.error <= 1.0 && did.outcome == StepOutcome::Converged, "{did:?}");
        let [middle, after] = [o.halves.middle.velocity[0], o.state.velocity[0]];
        let one_side = before * middle > 0.0 && middle * after > 0.0;
        if one_side {
            smooth += 1;
            assert!(did.extrapolated, "{did:?} {before} {middle} {after}");
        } else {
            changed += 1;
            assert!(!did.extrapolated, "{did:?} {before} {middle} {after}");
        }
        time += did.step;
    }
    // Seven turning points in 20 s of a period of 2 pi, the first at once; each takes a step or a few.
    assert!(smooth > 50 && (7..40).contains(&changed), "{smooth} {changed}");
}

/// A tolerance that cannot be met: every step is the smallest, says so, and has taken a bounded number of attempts.
#[test]
fn the_work_of_a_step_is_bounded() {
    let mut o = Oscillator::new(0.1, 12.0, 1.0);
    let accuracy = Accuracy::new(0.0, 1e-6, 1.0);
    for n in 0..100 {
        let did = o.step(&accuracy, 1.0);
        assert!(did.step == 1e-6 && (did.error > 1.0 || did.error.is_nan()), "{did:?}");
        assert!(did.rejected <= 30 && did.inner == 3 * (did.rejected + 1), "{did:?}");
        assert!(did.newton >= did.inner, "every inner step takes an iteration: {did:?}");
        assert!(n == 0 || did.rejected == 0, "{did:?}");
    }
    assert!(o.state.angle[0].is_finite() && o.state.angle[0] > 12.0);
}

/// What is not a number comes in, is said, and leaves the state as it was.
#[test]
fn a_state_outlives_an_input_that_is_no_number() {
    let site = moreau::Site { body: 0, point: [0.1, 0.0], direction: [0.0, 1.0], stiffness: 1.0, damping: 0.0 };
    let model =
        Description { bodies: &[Body { inertia: 1.0, ..Body::inert() }], site: Some(site), ..Description::default() }
            .compile::<1, 0>()
            .expect("sound");
    let (mut state, settings) = (State::at_rest([0.5]), Settings::new(1e-3));
    let mut halves = StepDoubling::<f64, 1, 0, 2>::new(&settings);
    let accuracy = Accuracy::new(1e-6, 1e-9, 1e-3);
    let mut controller = Controller::new(1e-4);
    let before = state.clone();
    let no_number = |_: f64, _: f64, _: &State<f64, 1, 0>| SiteInput::Force(f64::NAN);
    let did = controlled_step(&model, &settings, &accuracy, &mut controller, 1e-3, no_number, &mut state, &mut halves);
    assert_eq!((did.outcome, &state), (StepOutcome::NonFinite, &before));
}

/// An attempt that is rejected leaves the hand where it was: the step that follows it has the bits of one that was
/// taken at once in that length.
#[test]
fn a_rejected_step_leaves_the_hand_where_it_was() {
    let site = moreau::Site { body: 0, point: [0.1, 0.0], direction: [0.0, 1.0], stiffness: 1e3, damping: 1.0 };
    let model =
        Description { bodies: &[Body { inertia: 1e-2, ..Body::inert() }], site: Some(site), ..Description::default() }
            .compile::<1, 0>()
            .expect("sound");
    let (settings, accuracy) = (Settings::new(1e-3), Accuracy::new(1e-4, 1e-9, 1.0));
    let hand = SiteHand {
        mass: 0.2,
        force: 3.0,
        stiffness: 0.0,
        damping: 0.0,
        position: 0.0,
        velocity: 0.0,
        compliance: 0.0,
        retardation: 0.0,
    };
    let go = |first: f64| {
        let mut state = State::at_rest([0.0]);
        state.hand = [0.0, 0.5];
        let mut halves = StepDoubling::<f64, 1, 0, 2>::new(&settings);
        let mut controller = Controller::new(first);
        let drive = |_: f64, _: f64, _: &State<f64, 1, 0>| SiteInput::Hand(hand);
        let did = controlled_step(&model, &settings, &accuracy, &mut controller, 1.0, drive, &mut state, &mut halves);
        (did, state)
    };
    let (long, after_rejections) = go(0.1);
    let (short, at_once) = go(long.step);
    assert!(long.rejected > 0 && short.rejected == 0, "{long:?} {short:?}");
    assert_eq!((long.step, after_rejections), (short.step, at_once.clone()));
    assert!(at_once.hand[0] > 0.0);
}

/// A force that is given as a function of time is asked for at the theta points of whole and halves: one that is linear
/// in time moves the body as it should, v = f t^2/2 to rounding.
#[test]
fn the_drive_is_asked_at_the_right_instants() {
    let site = moreau::Site { body: 0, point: [1.0, 0.0], direction: [0.0, 1.0], stiffness: 1.0, damping: 0.0 };
    let model =
        Description { bodies: &[Body { inertia: 1.0, ..Body::inert() }], site: Some(site), ..Description::default() }
            .compile::<1, 0>()
            .expect("sound");
    let (mut state, settings) = (State::at_rest([0.0]), Settings::new(1e-3));
    let mut halves = StepDoubling::<f64, 1, 0, 2>::new(&settings);
    let accuracy = Accuracy::new(1e-3, 1e-9, 1e-2);
    let mut controller = Controller::new(1e-3);
    let mut time = 0.0;
    while time < 0.1 {
        let t0 = time;
        // Small enough that the lever arm's cosine is one to 1e-16.
        let force = |from: f64, h: f64, _: &State<f64, 1, 0>| SiteInput::Force(1e-6 * (t0 + from + 0.5 * h));
        let did =
            controlled_step(&model, &settings, &accuracy, &mut controller, 0.1 - time, force, &mut state, &mut halves);
        time += did.step;
    }
    let expected = 1e-6 * time * time / 2.0;
    assert!((state.velocity[0] / expected - 1.0).abs() < 1e-12, "{} {expected}", state.velocity[0]);
}

//! The regularised friction law.

use moreau::{Body, Description, FrictionLaw, Settings, SiteInput, State, StepOutcome, Workspace, step};

/// Kept for comparison, the law is at least solved: every step satisfies J (w1 - w0) = -h c_d tanh(w_theta / width) to
/// the Newton tolerance of 1e-5 (1 rad/s + |w|), also where the body comes to rest within a step and tanh is at its
/// most curved. (Once a step was accepted on the felts' curvature alone, of which there is none here.)
#[test]
fn a_regularised_pivot_is_solved() {
    let body = Body { dry: 1.0, inertia: 1.0, ..Body::inert() };
    let model = Description { bodies: &[body], ..Description::default() }.compile::<1, 0>().unwrap();
    for theta in [0.5, 1.0] {
        let friction = FrictionLaw::Regularised { pivot_width: 0.1, sliding_width: 0.1 };
        let settings = Settings { theta, friction, ..Settings::new(0.3) };
        let mut state = State::at_rest([0.0]);
        state.velocity = [1.4];
        let mut workspace = Workspace::<f64, 1, 0, 1>::new();
        for _ in 0..20 {
            let w0 = state.velocity[0];
            let report = step(&model, &settings, &SiteInput::Free, &mut state, &mut workspace);
            assert_eq!(report.outcome, StepOutcome::Converged);
            let w1 = state.velocity[0];
            let friction = (((1.0 - theta) * w0 + theta * w1) / 0.1).tanh();
            // The slope of the residual is 1 + h theta c_d / width, 4 at most.
            assert!((w1 - w0 + 0.3 * friction).abs() < 4e-5 * (1.0 + w1.abs()), "{w0} -> {w1}");
            // The torque that is kept is the one that acted, against the motion.
            let kept = state.save().pivot_friction[0];
            assert!((0.3 * kept - (w1 - w0)).abs() < 4e-5 * (1.0 + w1.abs()), "{kept}: {w0} -> {w1}");
        }
    }
}

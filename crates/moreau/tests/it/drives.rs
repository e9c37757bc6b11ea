//! An imposed motion against set-valued friction.

use moreau::osnsp::delassus::OneStepProblem;
use moreau::osnsp::relay::solve_dense;
use moreau::{
    Body, Description, GROUND, Model, Settings, Site, SiteInput, Solver, State, StepOutcome, Workspace, step,
};

const RATE: f64 = 0.7;

/// Two bodies in a chain at the origin, both stuck by dry friction; the outer one is moved by its tip, 0.2 m out, at
/// `RATE` times the tip's lever arm.
fn chain() -> Model<f64, 2, 0> {
    let body = |parent, pivot, dry| Body { parent, pivot, mass: 0.01, inertia: 1e-4, dry, ..Body::inert() };
    let bodies = [body(GROUND, [0.0, 0.0], 2e-3), body(0, [0.1, 0.0], 1e-3)];
    let site = Site { body: 1, point: [0.1, 0.0], direction: [0.0, 1.0], stiffness: 1.0, damping: 0.0 };
    Description { bodies: &bodies, site: Some(site), ..Description::default() }.compile().unwrap()
}

/// From rest every pivot sticks, so that the warm start's guess admits no motion at all: an imposed velocity must still
/// be reached, in the very first step, to the solver's tolerance, and friction must oppose it with its whole torque.
/// (Once the default solver held such a mechanism still and called that converged.)
#[test]
fn a_rigid_drive_moves_what_sticks() {
    let model = chain();
    let mut settings = Settings::new(1e-4);
    settings.solver = Solver::ActiveSet;
    for sign in [1.0, -1.0] {
        let mut state = State::at_rest([0.0; 2]);
        let mut workspace = Workspace::<f64, 2, 0, 3>::new();
        for n in 0..100 {
            let input = SiteInput::Rigid { velocity: sign * 0.2 * RATE };
            let report = step(&model, &settings, &input, &mut state, &mut workspace);
            assert_eq!(report.outcome, StepOutcome::Converged, "step {n}");
            let [a, b] = state.velocity;
            let tip = 0.1 * a * state.angle[0].cos() + 0.1 * b * state.angle[1].cos();
            // The row is taken half a step before: its cosine is off by angle x rate x h/2, below 1e-6, times 0.1 m x
            // 1.4 rad/s.
            assert!((tip - sign * 0.2 * RATE).abs() < 2e-7, "step {n}: {tip}");
        }
        // The pivot that turns has its whole torque against it.
        let relative = [state.velocity[0], state.velocity[1] - state.velocity[0]];
        for (i, dry) in [2e-3, 1e-3].into_iter().enumerate() {
            let p = state.pivot_friction[i];
            if relative[i] == 0.0 {
                assert!(p.abs() <= dry * (1.0 + 1e-12));
            } else {
                assert!((p + dry * relative[i].signum()).abs() < 1e-12, "pivot {i}: {p} at {}", relative[i]);
            }
        }
        assert!(relative.iter().any(|w| *w != 0.0));
    }
}

/// The same in dense form: an equality (infinite bound) on a velocity that a stuck law holds. The law slides with its
/// whole bound, and the equality's impulse makes up for it.
#[test]
fn an_equality_moves_what_sticks() {
    let mut problem = OneStepProblem::<f64, 2>::new();
    problem.count = 2;
    problem.delassus = [[1.0, 2.0], [2.0, 4.0]];
    problem.bound = [0.3, f64::INFINITY];
    problem.free = [0.0, -5.0];
    let mut p = [0.0; 2];
    let report = solve_dense(&problem, &mut p, 1e-12, 100);
    assert!(report.converged, "{report:?} {p:?}");
    // u_1 = 2 p_0 + 4 p_1 - 5 = 0 with p_0 = -0.3, since the first law's velocity p_0 + 2 p_1 is 2.5.
    assert!((p[0] + 0.3).abs() < 1e-12 && (p[1] - 1.4).abs() < 1e-12, "{p:?}");
}

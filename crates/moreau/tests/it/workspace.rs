//! Working memory holds nothing that a later step depends on.

use moreau::{
    Body, ContactCurve, Description, Exponent, Felt, GROUND, Loss, Model, Settings, Site, SiteInput, State, Workspace,
    Zone, step,
};

/// Three levers that swing down onto felts with friction, the first one driven at its tip: hinged on the ground each,
/// in a chain of two, or in a chain of three.
fn levers(parents: [usize; 3]) -> Model<f64, 3, 3> {
    let body = |i: usize| Body {
        parent: parents[i],
        pivot: if parents[i] == GROUND { [0.3 * i as f64, 0.0] } else { [0.1, 0.0] },
        mass: 0.02,
        center_of_mass: [0.05, 0.0],
        inertia: 1e-4,
        dry: 1e-4,
        ..Body::inert()
    };
    // Where each tip is in the world: the links of a chain lie in a line.
    let pivot_x = |i: usize| {
        let (mut x, mut at) = (0.0, i);
        loop {
            x += body(at).pivot[0];
            if parents[at] == GROUND {
                return x;
            }
            at = parents[at];
        }
    };
    let zone = |i: usize| Zone {
        disc_body: i,
        center: [0.09, 0.0],
        radius: 0.005,
        curve_body: GROUND,
        curve: ContactCurve::Line { point: [pivot_x(i) + 0.09, -0.006 - 0.002 * i as f64], normal: [0.0, 1.0] },
        felt: Felt { stiffness: 1e6, exponent: Exponent::Two, loss: Loss::quadratic(1e5) },
        friction: Some(0.3),
    };
    let site = Site { body: 0, point: [0.09, 0.0], direction: [0.0, -1.0], stiffness: 100.0, damping: 1.0 };
    let bodies = [0, 1, 2].map(body);
    Description {
        bodies: &bodies,
        zones: &[0, 1, 2].map(zone),
        site: Some(site),
        gravity: 9.81,
        ..Description::default()
    }
    .compile()
    .unwrap()
}

/// Mechanisms of different trees, stepped in turn with one working memory, do to the bit what each does with its own;
/// so do the contacts that are read from it.
#[test]
fn mechanisms_may_share_working_memory() {
    let settings = Settings::new(1e-4);
    let models = [[GROUND; 3], [GROUND, 0, GROUND], [GROUND, 0, 1], [GROUND, GROUND, 1]].map(levers);
    // Some begin on their felts, others far above them.
    let starts = [0.0, 0.4, 0.8, 0.0].map(|angle| State::at_rest([angle; 3]));
    let mut alone = starts.clone().map(|start| (start, Workspace::<f64, 3, 3, 7>::new()));
    let mut together = starts;
    let mut shared = Workspace::<f64, 3, 3, 7>::new();
    let mut touched = [0; 4];
    for n in 0..4000 {
        // Down, held, and let go of.
        let input = if n < 2400 { SiteInput::Force(0.3) } else { SiteInput::Force(-0.2) };
        for (m, model) in models.iter().enumerate() {
            let (state, own) = &mut alone[m];
            let (a, b) = (
                step(model, &settings, &input, state, own),
                step(model, &settings, &input, &mut together[m], &mut shared),
            );
            assert_eq!(a, b, "mechanism {m}, step {n}");
            assert!(*state == together[m], "mechanism {m}, step {n}: {state:?} {:?}", together[m]);
            for zone in 0..3 {
                let force =
                    |workspace: &Workspace<f64, 3, 3, 7>| workspace.contact(model, &settings, zone).map(|c| c.force);
                assert_eq!(force(own), force(&shared), "mechanism {m}, step {n}, zone {zone}");
                touched[m] += usize::from(force(own).is_some());
            }
        }
    }
    assert!(touched.iter().all(|steps| (1..11_000).contains(steps)), "{touched:?}");
}

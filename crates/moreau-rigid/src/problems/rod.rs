//! Problem 13: Painleve's rod. A uniform rod at 45 degrees slides on its lower end, with its upper end trailing.

use crate::{Body, Contact, Model, StepOutcome, StepReport, Surface};
use moreau::GROUND;

use super::row::{Expected, Order, ProblemRow};
use super::run::{Run, at};

const G: f64 = 9.81;
const LENGTH: f64 = 1.0;
const MASS: f64 = 0.7;

/// The first step: its report and normal force over mass.
fn first_step(mu: f64, h: f64) -> (StepReport<f64>, f64) {
    let bodies = [Body { mass: MASS, inertia: MASS * LENGTH * LENGTH / 12.0 }];
    let contacts = [Contact {
        disc_body: 0,
        center: [0.5 * LENGTH, 0.0],
        radius: 0.0,
        surface_body: GROUND,
        surface: Surface::Line { point: [0.0, 0.0], normal: [0.0, 1.0] },
        restitution: 0.0,
        kinetic: mu,
        limit: mu,
        belt: 0.0,
    }];
    let model = Model::new(&bodies, &[], &[], &contacts, [0.0, -G]).expect("sound");
    let angle = -std::f64::consts::FRAC_PI_4;
    // The lower end a hair inside the floor, so that rounding does not lift it off.
    let height = 0.5 * LENGTH * std::f64::consts::FRAC_1_SQRT_2 - 1e-15;
    let mut run = Run::<1, 2>::new(model, h, &[(at(0.0, height, angle), [1.0, 0.0, 0.0])]);
    let report = run.step();
    (report, run.state.impulse[model.contact_laws(0)[0]] / (h * MASS))
}

/// The friction coefficient above which a step reports that no finite force keeps the rod on the floor while it slides,
/// by bisection.
fn critical() -> f64 {
    let (mut finite, mut infinite) = (0.5, 3.0);
    while infinite - finite > 1e-13 {
        let mu = 0.5 * (finite + infinite);
        // Just below the critical one the force is finite and without bounds: the step may not converge, and says so.
        match first_step(mu, 1e-9).0.outcome {
            StepOutcome::Painleve => infinite = mu,
            _ => finite = mu,
        }
    }
    infinite
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    // Normal mobility under friction, times mass: 1 + 3 cos2 - 3 mu sin cos at 45 degrees.
    let force = |mu: f64| G / (2.5 - 1.5 * mu);
    let order = Order::halving(1e-3, 5, |h| (first_step(0.5, h).1 - force(0.5)).abs());
    let guesses = [1.7, 2.0, 5.0]
        .map(|mu| first_step(mu, 1e-3).0)
        .map(|r| if r.outcome == StepOutcome::Painleve { f64::from(r.guesses) } else { f64::NAN });
    let most = guesses.iter().fold(0.0, |a: f64, b| if b.is_nan() { *b } else { a.max(*b) });
    vec![
        ProblemRow::new(
            "critical friction coefficient",
            "",
            5.0 / 3.0,
            critical(),
            1e-8,
            "the rod turns by h in the first step of 1 ns",
        ),
        ProblemRow::new(
            "mu 0.5: normal force over mass, h = 1e-6",
            "m/s2",
            force(0.5),
            first_step(0.5, 1e-6).1,
            1e-9,
            "of order h2: the rod begins to turn within the step",
        ),
        ProblemRow::new(
            "mu 0.5: order of that force, h from 1 ms",
            "",
            2.0,
            order.observed(),
            0.1,
            "slope over four halvings",
        ),
        ProblemRow::bounded(
            "mu 1.7, 2 and 5: the most guesses in the step that reports it",
            Expected::AtMost(200.0),
            most,
            "it reports and does not loop",
        ),
    ]
}

//! Problem 21: torsion springs and stiff springs. The midpoint rule rotates the phase of an oscillator by exactly 2
//! atan(omega h / 2) per step; Newton's method finds that step for any stiffness.

use crate::{Body, Joint, JointKind, Model, Spring, Torsion};
use moreau::GROUND;

use super::row::{Expected, Order, ProblemRow};
use super::run::{Run, at};

const BODY: Body<f64> = Body { mass: 0.2, inertia: 3e-3 };

/// A body on a torsion spring, hinged: the mean of its first ten periods, from crossings of zero, interpolated.
fn period(stiffness: f64, h: f64) -> f64 {
    let bodies = [BODY];
    let torsions = [Torsion { first: GROUND, second: 0, stiffness, damping: 0.0, angle: 0.1 }];
    let joints = [Joint {
        kind: JointKind::Hinge,
        first: GROUND,
        at_first: [0.0; 2],
        second: 0,
        at_second: [0.0; 2],
        dry: 0.0,
        viscous: 0.0,
        rate: None,
    }];
    let model =
        Model::new(&bodies, &joints, &[], &[], [0.0, 0.0]).and_then(|m| m.with_torsions(&torsions)).expect("sound");
    let mut run = Run::<1, 3>::new(model, h, &[(at(0.0, 0.0, 0.1), [0.0, 0.0, 2.0])]);
    let mut crossings = 0;
    while run.sound && run.time() < 1e3 {
        let before = run.state.placement[0].angle - 0.1;
        run.step();
        let after = run.state.placement[0].angle - 0.1;
        if before < 0.0 && after >= 0.0 {
            crossings += 1;
            if crossings == 10 {
                return (run.time() - h * after / (after - before)) / 10.0;
            }
        }
    }
    f64::NAN
}

/// A mass on a straight spring along x, drawn by 1 mm: largest error of x against the rule's closed form over 100
/// steps, as a part of the 1 mm, and the most iterations of a step. `stiff` is theta2 h2 k / m.
fn straight(stiff: f64) -> [f64; 2] {
    let h = 1e-3;
    let stiffness = stiff * BODY.mass * 4.0 / (h * h);
    let bodies = [BODY];
    let springs = [Spring {
        first: GROUND,
        at_first: [0.0; 2],
        second: 0,
        at_second: [0.0; 2],
        stiffness,
        damping: 0.0,
        length: 1.0,
    }];
    let model = Model::new(&bodies, &[], &springs, &[], [0.0, 0.0]).expect("sound");
    let mut run = Run::<1, 1>::new(model, h, &[(at(1.001, 0.0, 0.0), [0.0; 3])]);
    let turn = 2.0 * stiff.sqrt().atan();
    let (mut error, mut most) = (0.0_f64, 0);
    for n in 1..=100 {
        most = most.max(run.step().iterations);
        error = error.max((run.state.placement[0].at[0] - 1.0 - 1e-3 * (f64::from(n) * turn).cos()).abs());
    }
    [run.value(error / 1e-3), f64::from(most)]
}

/// A point mass of a pendulum on a spring of 1 m that stretches by 1e-8 m: the period of a swing of 1 rad.
fn pendulum(h: f64) -> [f64; 2] {
    const G: f64 = 9.81;
    let bodies = [Body { mass: 0.2, inertia: 1.0 }];
    let stiffness = 0.2 * G / 1e-8;
    let springs = [Spring {
        first: GROUND,
        at_first: [0.0; 2],
        second: 0,
        at_second: [0.0; 2],
        stiffness,
        damping: 0.0,
        length: 1.0,
    }];
    let model = Model::new(&bodies, &[], &springs, &[], [0.0, -G]).expect("sound");
    let (s, c) = 1.0_f64.sin_cos();
    let mut run = Run::<1, 1>::new(model, h, &[(at(s, -c, 0.0), [0.0; 3])]);
    let (mut crossings, mut most) = (0, 0);
    while run.sound && run.time() < 100.0 {
        let before = run.state.placement[0].at[0];
        most = most.max(run.step().iterations);
        let after = run.state.placement[0].at[0];
        if before < 0.0 && after >= 0.0 {
            crossings += 1;
            if crossings == 4 {
                // Upward through the middle for the fourth time: three quarters of a period and three periods.
                let time = run.time() - h * after / (after - before);
                return [time / 3.75, f64::from(most)];
            }
        }
    }
    [f64::NAN; 2]
}

/// Period of a pendulum of 1 m: 2 pi sqrt(l / g) over the arithmetic-geometric mean of 1 and cos(amplitude / 2).
fn pendulum_period() -> f64 {
    let (mut a, mut b) = (1.0_f64, 0.5_f64.cos());
    for _ in 0..8 {
        (a, b) = (0.5 * (a + b), (a * b).sqrt());
    }
    std::f64::consts::TAU * (1.0_f64 / 9.81).sqrt() / a
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let stiffness = 1.2;
    let exact = std::f64::consts::TAU * (BODY.inertia / stiffness).sqrt();
    let mut rows = Vec::new();
    for h in [1e-3, 1e-4] {
        let w = std::f64::consts::TAU / exact;
        rows.push(ProblemRow::new(
            format!("torsion spring: period, h = {h:.0e}"),
            "s",
            exact,
            period(stiffness, h),
            exact * (w * h).powi(2) / 10.0,
            "the midpoint rule's is longer by (omega h)2/12; crossings are interpolated",
        ));
    }
    let order = Order::halving(4e-3, 4, |h| (period(stiffness, h) - exact).abs());
    let because = "slope over three halvings from 4 ms";
    rows.push(ProblemRow::new("torsion spring: order of the period", "", 2.0, order.observed(), 0.1, because));
    for stiff in [0.1, 10.0, 1e4] {
        let [error, iterations] = straight(stiff);
        let because = "exact at any stiffness: rounding of forces that turn round in every step";
        rows.push(ProblemRow::new(
            format!("straight spring, theta2 h2 k / m = {stiff}: largest error over its draw"),
            "",
            0.0,
            error,
            1e-9,
            because,
        ));
        rows.push(ProblemRow::bounded(
            &format!("straight spring, theta2 h2 k / m = {stiff}: most iterations"),
            Expected::AtMost(3.0),
            iterations,
            "Newton's method on a linear force: one, and one that finds nothing left",
        ));
    }
    for h in [1e-3, 5e-4] {
        let [ours, iterations] = pendulum(h);
        rows.push(ProblemRow::new(
            format!("pendulum on a spring of theta2 h2 k / m = {:.0}: period", 0.25 * h * h * 9.81 / 1e-8),
            "s",
            pendulum_period(),
            ours,
            5.0 * h * h,
            "the midpoint rule's (omega h)2/12, and a radius that is held in the middle of each chord, (v h)2/8 more at its ends: 1.5 h2 and \
             1.2 h2 s for small swings, up to twice that at 1 rad",
        ));
        rows.push(ProblemRow::bounded(
            &format!("the same, h = {h:.0e}: most iterations"),
            Expected::AtMost(12.0),
            iterations,
            "the curvature left out of Newton's matrix is of the order of h times the rate of turning",
        ));
    }
    rows
}

//! Problem 15: problems 2 and 6 again, with adaptive steps.

use moreau::{Accuracy, Controller, Loss, SiteInput, State, StepDoubling, StepOutcome, controlled_step};

use crate::felt;
use crate::hinge;
use crate::mechanism::Mechanism;
use moreau_rigid::problems::{Expected, ProblemRow};

/// Tolerances.
const TOLERANCES: [f64; 5] = [1e-3, 1e-4, 1e-5, 1e-6, 1e-7];

/// A mechanism with adaptive steps.
struct Controlled<const B: usize, const Z: usize, const N: usize> {
    m: Mechanism<B, Z, N>,
    accuracy: Accuracy<f64>,
    controller: Controller<f64, Z>,
    halves: StepDoubling<f64, B, Z, N>,
    inner: u32,
}

impl<const B: usize, const Z: usize, const N: usize> Controlled<B, Z, N> {
    fn new(m: Mechanism<B, Z, N>, accuracy: Accuracy<f64>) -> Self {
        let halves = StepDoubling::new(&m.settings);
        Controlled { m, accuracy, controller: Controller::new(0.01 * accuracy.largest), halves, inner: 0 }
    }

    /// Steps until a time.
    fn until(&mut self, end: f64) {
        let Controlled { m, accuracy, controller, halves, inner } = self;
        while m.time < end && m.sound {
            let left = end - m.time;
            let free = |_: f64, _: f64, _: &State<f64, B, Z>| SiteInput::Free;
            let did = controlled_step(&m.model, &m.settings, accuracy, controller, left, free, &mut m.state, halves);
            m.sound &= did.outcome == StepOutcome::Converged && did.error <= 1.0;
            *inner += did.inner;
            m.time = if did.step < left { m.time + did.step } else { end };
        }
    }
}

/// Oscillator with dry friction: eight reversals, then it sticks.
fn dry_oscillator(rows: &mut Vec<ProblemRow>) {
    let rest = 15.0 - 205.0_f64.sqrt();
    for tolerance in TOLERANCES {
        let mut c = Controlled::new(hinge::dry_oscillator_at(1e-3), Accuracy::new(tolerance, 1e-9, 1.0));
        c.until(30.0);
        let name = |s: &str| format!("dry oscillator, tolerance {tolerance:.0e}: {s}");
        rows.push(ProblemRow::new(name("rests at"), "", rest, c.m.value(c.m.state.angle[0]), 8.0 * tolerance, BECAUSE));
        let held = c.m.state.angle[0];
        c.until(60.0);
        rows.push(ProblemRow::new(
            name("moves within 30 more"),
            "",
            0.0,
            c.m.value(c.m.state.angle[0] - held),
            0.0,
            "exactly zero",
        ));
    }
}

const BECAUSE: &str =
    "each of eight reversals may err by the tolerance times 1 rad/s; what is smooth is extrapolated beyond it";

/// A mass thrown at the damped felt.
fn damped_felt(rows: &mut Vec<ProblemRow>) {
    let mut steps = Vec::new();
    for tolerance in TOLERANCES {
        let (r, k, b, rebound, _) = felt::DAMPED[0];
        let m = felt::thrown(k, r, Loss::quadratic(b), 1e-6, 1e-3 / 3.0);
        // The mass moves at 0.01 rad/s.
        let accuracy = Accuracy { velocity: 0.01, ..Accuracy::new(tolerance, 1e-9, 1e-3) };
        let mut c = Controlled::new(m, accuracy);
        c.until(6e-3);
        let ours = c.m.value(-c.m.state.velocity[0] * felt::ARM);
        let because = "two tolerances of this speed in a step, of which all but the contact's ends are extrapolated beyond; the reference's digits";
        rows.push(ProblemRow::new(
            format!("damped felt, tolerance {tolerance:.0e}: speed of rebound"),
            "m/s",
            rebound,
            ours,
            2.0 * tolerance,
            because,
        ));
        steps.push(f64::from(c.inner));
    }
    // The error of a step grows with its cube: a tenth of the tolerance needs 10^(1/3) times as many steps.
    let growth = (steps[4] / steps[1]).powf(1.0 / 3.0);
    let because = "order 2 of the estimate: 2.15 times as many steps for a tenth of the tolerance";
    rows.push(ProblemRow::bounded(
        "damped felt: steps for a tenth of the tolerance",
        Expected::AtMost(2.5),
        growth,
        because,
    ));
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let mut rows = Vec::new();
    dry_oscillator(&mut rows);
    damped_felt(&mut rows);
    rows
}

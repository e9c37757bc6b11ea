//! Problem 28: difference quotients through an impact. A ball flies at a wall, is thrown back elastically, and is
//! looked at after a second. Its distance from the wall is then that second's way less its first distance: the slope
//! of the last place over the first is -1.
//!
//! An impact acts at an instant of the step's grid. Two balls that strike in one step have one instant, and are as far
//! apart afterwards as before: slope +1. The rows state how often, and what gives -1 instead.

use crate::{Body, Model, Surface};

use super::row::ProblemRow;
use super::run::{Run, at, point_on};

/// Speed of the ball, m/s, and time after which it is looked at, s.
const SPEED: f64 = 5.0;
const END: f64 = 1.0;
/// First distance from the wall, m, not on the grid of any step below; number of differences and the distance of two
/// neighbours, m.
const FIRST: f64 = 2.000_06;
const DIFFERENCES: usize = 400;
const APART: f64 = 0.25e-3;

/// Where the ball is in the end, m from the wall: as the steps have it, and with the instant of the impact put right.
fn flight(h: f64, first: f64) -> [f64; 2] {
    let bodies = [Body { mass: 1.0, inertia: 1.0 }];
    let contacts = [point_on(Surface::Line { point: [0.0, 0.0], normal: [0.0, 1.0] }, 1.0)];
    let model = Model::new(&bodies, &[], &[], &contacts, [0.0, 0.0]).expect("sound");
    let mut run = Run::<1, 2>::new(model, h, &[(at(0.0, first, 0.0), [0.0, -SPEED, 0.0])]);
    let mut missing = f64::NAN;
    for _ in 0..(END / h).round() as u32 {
        let (distance, before) = (run.state.placement[0].at[1], run.state.velocity[0][1]);
        run.step();
        let after = run.state.velocity[0][1];
        if before < 0.0 && after > 0.0 {
            // The step goes half of its time with either velocity, the ball as far as the wall with the first.
            missing = (before - after) * (-distance / before - 0.5 * h);
        }
    }
    let last = run.value(run.state.placement[0].at[1]);
    [last, last + missing]
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let mut rows = Vec::new();
    for h in [1e-2, 1e-4] {
        let flights: Vec<[f64; 2]> = (0..=DIFFERENCES).map(|n| flight(h, FIRST + n as f64 * APART)).collect();
        let slopes = |which: usize| {
            flights.windows(2).map(move |pair| (pair[1][which] - pair[0][which]) / APART).collect::<Vec<f64>>()
        };
        let wrong = slopes(0).iter().filter(|slope| (*slope - 1.0).abs() < 1e-6).count();
        let whole = DIFFERENCES as f64 * APART;
        rows.push(ProblemRow::new(
            format!("differences of {DIFFERENCES} with the slope +1, h = {h:.0e}"),
            "",
            DIFFERENCES as f64 - whole / (SPEED * h),
            wrong as f64,
            0.0,
            "all but those in which the impact comes a step later: one to a step's way, SPEED h",
        ));
        let farthest =
            |slopes: &[f64]| slopes.iter().copied().max_by(|a, b| (a + 1.0).abs().total_cmp(&(b + 1.0).abs()));
        rows.push(ProblemRow::new(
            format!("the others: slope, h = {h:.0e}"),
            "",
            1.0 - 2.0 * SPEED * h / APART,
            slopes(0).iter().copied().fold(f64::INFINITY, f64::min),
            1e-6,
            "a step later is twice a step's way less; rounding of the last place over the distance of two starts",
        ));
        rows.push(ProblemRow::new(
            format!("instant put right: slope farthest from -1, h = {h:.0e}"),
            "",
            -1.0,
            farthest(&slopes(1)).unwrap_or(f64::NAN),
            1e-6,
            "rounding, as above",
        ));
        // Not a whole number of steps' ways.
        let wide = whole - APART;
        if SPEED * h < 0.01 * wide {
            rows.push(ProblemRow::new(
                format!("slope over {:.0} steps' ways, h = {h:.0e}", wide / (SPEED * h)),
                "",
                -1.0,
                (flights[DIFFERENCES - 1][0] - flights[0][0]) / wide,
                2.0 * SPEED * h / wide,
                "either instant is off by up to half a step, which is a step's way of the last place",
            ));
        }
    }
    rows
}

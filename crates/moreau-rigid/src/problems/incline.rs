//! Problem 10: a block on two corners, free in the plane, on an incline of 20 degrees.

use crate::{Body, Contact, Model, Surface};
use moreau::GROUND;

use super::row::ProblemRow;
use super::run::{Run, at};

const G: f64 = 9.81;
const SLOPE: f64 = 20.0 * std::f64::consts::PI / 180.0;
/// Half the block's length and height, m.
const HALF: [f64; 2] = [0.10, 0.02];

/// The block after a time: how far it went and how fast it is, uphill; and when it last moved.
struct Slid {
    way: f64,
    speed: f64,
    stopped: f64,
}

fn slide(mu: f64, speed: f64, h: f64, duration: f64) -> Slid {
    let bodies = [Body { mass: 0.5, inertia: 0.5 * (4.0 * HALF[0] * HALF[0] + 4.0 * HALF[1] * HALF[1]) / 12.0 }];
    let (s, c) = SLOPE.sin_cos();
    let (normal, uphill) = ([-s, c], [c, s]);
    let corner = |x: f64| Contact {
        disc_body: 0,
        center: [x, -HALF[1]],
        radius: 0.0,
        surface_body: GROUND,
        surface: Surface::Line { point: [0.0, 0.0], normal },
        restitution: 0.0,
        kinetic: mu,
        limit: mu,
        belt: 0.0,
    };
    let contacts = [corner(-HALF[0]), corner(HALF[0])];
    let model = Model::new(&bodies, &[], &[], &contacts, [0.0, -G]).expect("sound");
    let start = at(HALF[1] * normal[0], HALF[1] * normal[1], SLOPE);
    let mut run = Run::<1, 4>::new(model, h, &[(start, [speed * uphill[0], speed * uphill[1], 0.0])]);
    let along = |v: [f64; 2]| v[0] * uphill[0] + v[1] * uphill[1];
    let mut stopped = 0.0;
    while run.time() < duration - 0.5 * h && run.sound {
        let before = along([run.state.velocity[0][0], run.state.velocity[0][1]]);
        run.step();
        if before > 1e-12 {
            stopped = run.time() - 0.5 * h;
        }
    }
    let [x, y] = run.state.placement[0].at;
    let v = run.state.velocity[0];
    Slid {
        way: run.value(along([x - start.at[0], y - start.at[1]])),
        speed: run.value(along([v[0], v[1]])),
        stopped: run.value(stopped),
    }
}

/// The friction coefficient from which on the block sticks, by bisection on whether it has moved after ten steps.
fn critical() -> f64 {
    let (mut slips, mut sticks) = (0.1, 0.9);
    while sticks - slips > 1e-13 {
        let mu = 0.5 * (slips + sticks);
        let v = slide(mu, 0.0, 1e-2, 0.1).speed;
        if v.is_nan() {
            return v;
        }
        if v < -1e-12 { slips = mu } else { sticks = mu }
    }
    sticks
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let (s, c) = SLOPE.sin_cos();
    let deceleration = G * (s + 0.5 * c);
    let mut rows = vec![
        ProblemRow::new(
            "friction coefficient from which on it sticks",
            "",
            SLOPE.tan(),
            critical(),
            1e-10,
            "slips below 1e-12 m/s are the solver's tolerance; ten steps of 10 ms bring 1e-12 m/s at 1e-12 of mu",
        ),
        ProblemRow::new(
            "mu 0.3, from rest: acceleration downhill",
            "m/s2",
            G * (s - 0.3 * c),
            -slide(0.3, 0.0, 1e-3, 1.0).speed,
            1e-11,
            "exact: rounding of 1000 steps",
        ),
        ProblemRow::new(
            "mu 0.37, from rest: way in 10 s",
            "m",
            0.0,
            slide(0.37, 0.0, 1e-3, 10.0).way,
            1e-14,
            "sticks: rounding of the plane's normal",
        ),
    ];
    for h in [1e-2, 1e-3, 1e-4] {
        let slid = slide(0.5, 1.0, h, 2.0);
        rows.push(ProblemRow::new(
            format!("mu 0.5, uphill at 1 m/s: stops at, h = {h:.0e}"),
            "s",
            1.0 / deceleration,
            slid.stopped,
            0.5 * h * 1.000_001,
            "known to half a step",
        ));
        rows.push(ProblemRow::new(
            format!("mu 0.5, uphill at 1 m/s: way after 2 s, h = {h:.0e}"),
            "m",
            0.5 / deceleration,
            slid.way,
            deceleration * h * h / 8.0 + 1e-13,
            "the last step's trapezium against its parabola: a h2/8 at most",
        ));
    }
    rows
}

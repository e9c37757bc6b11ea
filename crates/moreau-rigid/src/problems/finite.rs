//! Problem 19: surfaces of finite length. A block beside a pedestal falls, an overhanging block tips if its middle
//! overhangs, and a bead leaves its plate.

use crate::{Body, Model, PolygonContact, Surface};
use moreau::GROUND;

use super::row::ProblemRow;
use super::run::{Run, at, point_on};

const G: f64 = 9.81;
/// Half width and height of the block, m.
const HALF: [f64; 2] = [0.1, 0.05];

/// Where a block is, and its velocity, after a time: set down with its middle `over` m to the right of the middle of a
/// pedestal of 0.1 m half width whose top is at zero.
fn block(over: f64, h: f64, time: f64) -> [f64; 6] {
    let [x, y] = HALF;
    let bodies = [Body { mass: 2.0, inertia: 2.0 * (x * x + y * y) / 3.0 }];
    let corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
    let pedestal = [[-0.1, -0.3], [0.1, -0.3], [0.1, 0.0], [-0.1, 0.0]];
    let contacts = [PolygonContact {
        first: 0,
        first_corners: &corners,
        second: GROUND,
        second_corners: &pedestal,
        restitution: 0.0,
        kinetic: 0.9,
        limit: 0.9,
    }];
    let model = Model::new(&bodies, &[], &[], &[], [0.0, -G]).and_then(|m| m.with_polygons(&contacts)).expect("sound");
    let mut run = Run::<1, 4>::new(model, h, &[(at(over, y, 0.0), [0.0; 3])]);
    run.until(time);
    let (q, v) = (run.state.placement[0], run.state.velocity[0]);
    [q.at[0], q.at[1], q.angle, v[0], v[1], v[2]].map(|x| run.value(x))
}

/// A smooth bead slides along a plate that ends at x = 0, and falls: where it is after a time.
fn bead(h: f64, time: f64) -> [f64; 2] {
    let bodies = [Body { mass: 1.0, inertia: 1.0 }];
    let contacts = [point_on(Surface::Segment { from: [0.0, 0.0], to: [-1.0, 0.0], depth: 0.01 }, 0.0)];
    let model = Model::new(&bodies, &[], &[], &contacts, [0.0, -G]).expect("sound");
    let mut run = Run::<1, 2>::new(model, h, &[(at(-0.5, 0.0, 0.0), [1.0, 0.0, 0.0])]);
    run.until(time);
    run.state.placement[0].at.map(|x| run.value(x))
}

/// Angle and rate of a block that tips about the pedestal's edge, its middle `over` m beyond it, by Runge-Kutta of
/// order 4 at 10 us; while it sticks: (I + m r2) phi'' = m g (over cos phi + y sin phi), clockwise.
fn tipped(over: f64, time: f64) -> [f64; 2] {
    let [x, y] = HALF;
    let inertia = (x * x + y * y) / 3.0 + over * over + y * y;
    let rate = |s: [f64; 2]| [s[1], G * (over * s[0].cos() + y * s[0].sin()) / inertia];
    let on = |s: [f64; 2], k: [f64; 2], d: f64| [s[0] + d * k[0], s[1] + d * k[1]];
    let (n, mut s) = ((time / 1e-5).round() as u32, [0.0, 0.0]);
    let d = time / f64::from(n);
    for _ in 0..n {
        let k1 = rate(s);
        let k2 = rate(on(s, k1, d / 2.0));
        let k3 = rate(on(s, k2, d / 2.0));
        let k4 = rate(on(s, k3, d));
        s = core::array::from_fn(|i| s[i] + d / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
    }
    s
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let y = HALF[1];
    let aside = block(10.0, 1e-3, 1.0);
    let rests = block(0.09, 1e-3, 1.0);
    let mut rows = vec![
        ProblemRow::new(
            "ten metres aside: height after 1 s",
            "m",
            y - 0.5 * G,
            aside[1],
            1e-11,
            "free fall is exact: rounding of 1000 steps",
        ),
        ProblemRow::new(
            "its middle 10 mm inside the edge: height after 1 s",
            "m",
            y,
            rests[1],
            1e-12,
            "rests: rounding",
        ),
        ProblemRow::new("the same: angle", "rad", 0.0, rests[2], 1e-12, "rests: rounding"),
    ];
    for h in [1e-3, 1e-4] {
        let ours = block(0.11, h, 0.2);
        let [angle, rate] = tipped(0.01, 0.2);
        let because =
            "of order h2: the trapezium of rates that grow as exp(12 t), and the corner that slips in by as little";
        rows.push(ProblemRow::new(
            format!("10 mm beyond it: angle after 0.2 s, h = {h:.0e}"),
            "rad",
            -angle,
            ours[2],
            500.0 * h * h,
            because,
        ));
        rows.push(ProblemRow::new(
            format!("10 mm beyond it: rate after 0.2 s, h = {h:.0e}"),
            "rad/s",
            -rate,
            ours[5],
            5000.0 * h * h,
            because,
        ));
    }
    for h in [1e-3, 1e-4] {
        let [along, height] = bead(h, 1.0);
        // It leaves after half a second and falls for another.
        rows.push(ProblemRow::new(
            format!("bead: way after 1 s, h = {h:.0e}"),
            "m",
            0.5,
            along,
            1e-12,
            "no force along the plate: rounding",
        ));
        rows.push(ProblemRow::new(
            format!("bead: height after 1 s, h = {h:.0e}"),
            "m",
            -0.5 * G * 0.25,
            height,
            G * 0.5 * h,
            "the end of the plate is known to a step: g t h",
        ));
    }
    rows
}

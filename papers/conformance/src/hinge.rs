//! Problems 1 to 3: one body on a hinge with dry friction.

use moreau::{Body, Description, Settings, Spring};

use crate::mechanism::{Mechanism, hinge};
use moreau_rigid::problems::ProblemRow;

fn loaded_pivot(load: f64) -> Mechanism<1, 0, 1> {
    let body = Body { dry: 2e-3, ..hinge(1.5e-4) };
    let spring = Spring { body: 0, torque: load, stiffness: 0.0, reference: 0.0 };
    let model = Description { bodies: &[body], springs: &[spring], ..Description::default() }.compile().expect("sound");
    Mechanism::new(model, [0.0], [0.0], Settings::new(1e-4))
}

/// Problem 1: below the limit the pivot does not move at all; above it the scheme is exact for a constant torque.
pub(crate) fn pivot() -> Vec<ProblemRow> {
    let mut rows = Vec::new();
    for load in [1e-3, 1.8e-3, -1.8e-3] {
        let mut m = loaded_pivot(load);
        m.run(1.0);
        let name = |s: &str| format!("load {load:e} N m of 2e-3: {s}");
        rows.push(ProblemRow::new(name("angle after 1 s"), "rad", 0.0, m.value(m.state.angle[0]), 0.0, "exactly zero"));
        let friction = m.value(m.state.pivot_friction[0]);
        rows.push(ProblemRow::new(name("friction at rest"), "N m", -load, friction, 1e-15, "exact: rounding"));
    }
    let mut m = loaded_pivot(3e-3);
    m.run(1.0);
    let angle = m.value(m.state.angle[0]);
    rows.push(ProblemRow::new(
        "load 3e-3 N m: angle after 1 s",
        "rad",
        10.0 / 3.0,
        angle,
        1e-10,
        "exact: rounding of 10 000 steps",
    ));
    rows
}

pub(crate) fn dry_oscillator_at(h: f64) -> Mechanism<1, 0, 1> {
    let body = Body { dry: 1.0, ..hinge(1.0) };
    let spring = Spring { body: 0, torque: 0.0, stiffness: 1.0, reference: 0.0 };
    let model = Description { bodies: &[body], springs: &[spring], ..Description::default() }.compile().expect("sound");
    Mechanism::new(model, [12.0], [6.0], Settings::new(h))
}

/// Turning points until a time, and the time of the last one.
fn turning_points(m: &mut Mechanism<1, 0, 1>, until: f64) -> (Vec<f64>, f64) {
    let (mut points, mut last) = (Vec::new(), 0.0);
    while m.time < until {
        let (before, v) = (m.state.angle[0], m.state.velocity[0]);
        m.step();
        if m.state.velocity[0] * v < 0.0 || (m.state.velocity[0] == 0.0 && v != 0.0) {
            points.push(if before.abs() > m.state.angle[0].abs() { before } else { m.state.angle[0] });
            last = m.time;
        }
    }
    (points, last)
}

/// Problem 2: each half cycle is half a circle in the phase plane, about the springs' rest shifted by the friction.
pub(crate) fn dry_oscillator() -> Vec<ProblemRow> {
    let mut rows = Vec::new();
    let because = "friction has one sign in a step: each of eight reversals leaves an error of order h";
    for h in [1e-3, 1e-4] {
        let mut m = dry_oscillator_at(h);
        let (points, stop) = turning_points(&mut m, 30.0);
        let name = |s: &str| format!("{s}, h = {h:.0e}");
        for i in 0..7 {
            // The circle about -1 through (12, 6), then 2 less each time.
            let sign = if i % 2 == 0 { 1.0 } else { -1.0 };
            let expected = sign * (205.0_f64.sqrt() - 1.0 - 2.0 * f64::from(i));
            let ours = m.value(points.get(i as usize).copied().unwrap_or(f64::NAN));
            rows.push(ProblemRow::new(name(&format!("turning point {}", i + 1)), "", expected, ours, 3.0 * h, because));
        }
        let rest = 15.0 - 205.0_f64.sqrt();
        rows.push(ProblemRow::new(name("rests at"), "", rest, m.value(m.state.angle[0]), 3.0 * h, because));
        let time = (6.0_f64 / 13.0).atan() + 7.0 * std::f64::consts::PI;
        rows.push(ProblemRow::new(name("from"), "", time, m.value(stop), 3.0 * h, because));
    }
    let mut m = dry_oscillator_at(1e-3);
    m.run(23.0);
    let held = m.state.angle[0];
    m.run(100.0);
    let moved = m.value(m.state.angle[0] - held);
    rows.push(ProblemRow::new("moves within 100 more", "", 0.0, moved, 0.0, "exactly zero"));
    rows
}

/// Problem 3, from m g l (cos a1 - cos a0) = c_d (a0 + a1), solved by bisection.
pub(crate) fn dry_pendulum() -> Vec<ProblemRow> {
    let (mass, length, dry, g) = (0.010, 0.112, 8e-4, 9.81);
    let body = Body { mass, center_of_mass: [0.0, -length], inertia: mass * length * length, dry, ..Body::inert() };
    let model = Description { bodies: &[body], gravity: g, ..Description::default() }.compile::<1, 0>().expect("sound");
    let mut m = Mechanism::<1, 0, 1>::new(model, [0.5], [0.0], Settings::new(1e-5));
    let (points, _) = turning_points(&mut m, 5.0);
    let mut rows = Vec::new();
    let because = "smooth between turning points, order h2; at each friction turns within a step: 2 c_d h / J of speed";
    let mut from = 0.5;
    for i in 0..3 {
        from = next_turning_point(from, mass * g * length, dry);
        let ours = m.value(points.get(i).map_or(f64::NAN, |x| x.abs()));
        rows.push(ProblemRow::new(format!("turning point {}, h = 1e-5", i + 1), "rad", from, ours, 3e-6, because));
    }
    rows.push(ProblemRow::new("turning points in all", "", 3.0, m.value(points.len() as f64), 0.0, "then it sticks"));
    rows.push(ProblemRow::new("speed after 5 s", "rad/s", 0.0, m.value(m.state.velocity[0]), 0.0, "exactly zero"));
    rows
}

/// Angle on the other side at which the weight's work equals the friction's loss.
pub(crate) fn next_turning_point(from: f64, weight: f64, dry: f64) -> f64 {
    let left = |to: f64| weight * (to.cos() - from.cos()) - dry * (from + to);
    let (mut low, mut high) = (0.0, from);
    for _ in 0..100 {
        let middle = 0.5 * (low + high);
        if left(middle) > 0.0 { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

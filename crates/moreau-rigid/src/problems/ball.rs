//! Problem 12: a ball dropped from 0.9 m with restitution 0.9, which makes infinitely many impacts in finite time.

use crate::{Body, Energies, Mode, Model, Surface};

use super::row::{Order, ProblemRow};
use super::run::{Run, at, point_on};

const G: f64 = 9.81;
const HEIGHT: f64 = 0.9;
const RESTITUTION: f64 = 0.9;

struct Bounce {
    first: f64,
    rests: f64,
    speed_after: f64,
    height_after: f64,
    /// The largest rise of the mechanical energy in one step, J for 1 kg.
    gain: f64,
}

fn bounce(h: f64, height: f64) -> Bounce {
    let bodies = [Body { mass: 1.0, inertia: 1.0 }];
    let contacts = [point_on(Surface::Line { point: [0.0, 0.0], normal: [0.0, 1.0] }, RESTITUTION)];
    let model = Model::new(&bodies, &[], &[], &contacts, [0.0, -G]).expect("sound");
    let mut run = Run::<1, 2>::new(model, h, &[(at(0.0, height, 0.0), [0.0; 3])]);
    let normal = model.contact_laws(0)[0];
    let mut found = Bounce { first: 0.0, rests: 0.0, speed_after: 0.0, height_after: 0.0, gain: 0.0 };
    let end = zeno_time(height) + 2.0;
    let mut energy = Energies::of(&model, &run.state).total();
    while run.time() < end && run.sound {
        let before = run.state.velocity[0][1];
        run.step();
        let after = Energies::of(&model, &run.state).total();
        found.gain = found.gain.max(after - energy);
        energy = after;
        if found.first == 0.0 && run.state.impulse[normal] > 0.0 && run.state.mode[normal] == Mode::Hold {
            found.first = run.time() - 0.5 * h;
        }
        if before != 0.0 {
            found.rests = run.time() - 0.5 * h;
        }
    }
    found.speed_after = run.state.velocity[0][1];
    found.height_after = run.state.placement[0].at[1];
    if !run.sound {
        found.rests = f64::NAN;
    }
    found
}

fn fall_time(height: f64) -> f64 {
    (2.0 * height / G).sqrt()
}

/// The fall, and twice the rise of every bounce: t (1 + e) / (1 - e).
fn zeno_time(height: f64) -> f64 {
    fall_time(height) * (1.0 + RESTITUTION) / (1.0 - RESTITUTION)
}

/// Root mean square of the error of the Zeno time over 16 heights that differ by less than a percent: impacts meet the
/// steps at all phases.
fn zeno_error(h: f64) -> f64 {
    let errors = (0..16).map(|k| {
        let height = HEIGHT * (1.0 - f64::from(k) / 2048.0);
        (bounce(h, height).rests - zeno_time(height)).powi(2)
    });
    (errors.sum::<f64>() / 16.0).sqrt()
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let mut rows = Vec::new();
    for h in [1e-3, 1e-4, 1e-5] {
        let b = bounce(h, HEIGHT);
        let name = |s: &str| format!("{s}, h = {h:.0e}");
        rows.push(ProblemRow::new(
            name("first impact"),
            "s",
            fall_time(HEIGHT),
            b.first,
            h,
            "acts in the middle of the first step whose middle is past it",
        ));
        let because = "every impact is off by up to half a step, g h/2 of speed, and 2/(g (1 - e)) of time for each speed: 10 h, \
                       of random sign, over some hundred impacts";
        rows.push(ProblemRow::new(name("comes to rest"), "s", zeno_time(HEIGHT), b.rests, 100.0 * h, because));
        rows.push(ProblemRow::new(name("speed two seconds later"), "m/s", 0.0, b.speed_after, 0.0, "exactly zero"));
        let because = "the last impacts sink in by what a step falls";
        rows.push(ProblemRow::new(name("height then"), "m", 0.0, b.height_after, 4.2 * h, because));
        let because = "impacts take; only the step in which it comes to rest may give m (g h)2/8";
        rows.push(ProblemRow::new(
            name("largest gain of energy in a step"),
            "J",
            0.0,
            b.gain,
            (G * h).powi(2) / 8.0 + 1e-14,
            because,
        ));
    }
    let order = Order::halving(1.6e-3, 5, zeno_error);
    rows.push(ProblemRow::new(
        "order of the time of rest, h from 1.6 to 0.1 ms",
        "",
        1.0,
        order.observed(),
        0.25,
        "rms over 16 heights scatters by 18 %",
    ));
    rows
}

//! Problem 20: a Scotch yoke. The pin of a crank runs in the vertical slot of a sliding yoke; x = r cos(omega t).

use crate::{Body, Energies, Joint, JointKind, Model};
use moreau::GROUND;

use super::row::{Order, ProblemRow};
use super::run::{Run, at};

const R: f64 = 0.05;
const OMEGA: f64 = 20.0;
const CRANK: Body<f64> = Body { mass: 0.3, inertia: 2e-4 };
const YOKE: f64 = 0.8;
/// Dry friction in the slot, N.
const DRY: f64 = 2.0;

/// The crank turns about its middle; its pin is at radius R.
fn joints(motor: Option<f64>, dry: f64) -> [Joint<f64>; 3] {
    let joint = |kind, first, at_first, second, at_second| Joint {
        kind,
        first,
        at_first,
        second,
        at_second,
        dry: 0.0,
        viscous: 0.0,
        rate: None,
    };
    [
        Joint { rate: motor, ..joint(JointKind::Hinge, GROUND, [0.0; 2], 0, [0.0; 2]) },
        joint(JointKind::Slide { axis: [1.0, 0.0], angle: 0.0 }, GROUND, [0.0; 2], 1, [0.0; 2]),
        Joint { dry, ..joint(JointKind::Slot { axis: [0.0, 1.0] }, 1, [0.0; 2], 0, [R, 0.0]) },
    ]
}

struct Turned {
    /// Largest |x - r cos(angle)|, m.
    off: f64,
    /// Largest error of the force across the slot, N.
    force: f64,
    /// Work of the motor, J.
    work: f64,
}

/// Turns by the motor for a number of turns.
fn driven(steps_a_turn: u32, turns: u32, dry: f64) -> Turned {
    let bodies = [CRANK, Body { mass: YOKE, inertia: 1e-3 }];
    let joints = joints(Some(OMEGA), dry);
    let model = Model::new(&bodies, &joints, &[], &[], [0.0, 0.0]).expect("sound");
    let h = std::f64::consts::TAU / OMEGA / f64::from(steps_a_turn);
    let start = [(at(0.0, 0.0, 0.0), [0.0, 0.0, OMEGA]), (at(R, 0.0, 0.0), [0.0; 3])];
    let mut run = Run::<2, 9>::new(model, h, &start);
    let mut turned = Turned { off: 0.0, force: 0.0, work: 0.0 };
    for k in 0..steps_a_turn * turns {
        run.step();
        let angle = OMEGA * run.time();
        turned.off = turned.off.max((run.state.placement[1].at[0] - R * angle.cos()).abs());
        // The pin's force is what the yoke's mass asks for in the middle of the step. Row 6: across the slot, (-1, 0)
        // in the world.
        let middle = OMEGA * h * (f64::from(k) + 0.5);
        let force = run.state.impulse[6] / h;
        turned.force = turned.force.max((force.abs() - (YOKE * R * OMEGA * OMEGA * middle.cos()).abs()).abs());
        turned.work += run.state.impulse[2] * OMEGA;
    }
    Turned { off: run.value(turned.off), force: run.value(turned.force), work: run.value(turned.work) }
}

/// Turns freely: the energy 1/2 (J + m r2 sin2) rate2 is kept; the crank's angle after a time, and the largest relative
/// change of energy.
fn free(h: f64, time: f64) -> [f64; 2] {
    let bodies = [CRANK, Body { mass: YOKE, inertia: 1e-3 }];
    let joints = joints(None, 0.0);
    let model = Model::new(&bodies, &joints, &[], &[], [0.0, 0.0]).expect("sound");
    let start = [(at(0.0, 0.0, 0.0), [0.0, 0.0, OMEGA]), (at(R, 0.0, 0.0), [0.0; 3])];
    let mut run = Run::<2, 9>::new(model, h, &start);
    let energy = Energies::of(&model, &run.state).total();
    let mut change = 0.0_f64;
    while run.time() < time - 0.5 * h && run.sound {
        run.step();
        change = change.max((Energies::of(&model, &run.state).total() / energy - 1.0).abs());
    }
    [run.value(run.state.placement[0].angle), run.value(change)]
}

/// The crank's angle after a time: angle' = omega sqrt(J / (J + m r2 sin2 angle)), by Runge-Kutta of order 4 at 10 us.
fn free_angle(time: f64) -> f64 {
    let rate = |a: f64| OMEGA * (CRANK.inertia / (CRANK.inertia + YOKE * R * R * a.sin().powi(2))).sqrt();
    let n = (time / 1e-5).round() as u32;
    let d = time / f64::from(n);
    (0..n).fold(0.0, |a, _| {
        let k1 = rate(a);
        let k2 = rate(a + 0.5 * d * k1);
        let k3 = rate(a + 0.5 * d * k2);
        let k4 = rate(a + d * k3);
        a + d / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    })
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let smooth = driven(1000, 10, 0.0);
    let force = Order::halving(1e-2, 4, |part| driven((1.0 / part).round() as u32, 1, 0.0).force);
    let rubbing = driven(1000, 1, DRY);
    let angle = Order::halving(1e-3, 4, |h| (free(h, 1.0)[0] - free_angle(1.0)).abs());
    vec![
        ProblemRow::new(
            "driven for ten turns: largest |x - r cos(omega t)|",
            "m",
            0.0,
            smooth.off,
            1e-12,
            "the crank's rate is given, the joints are closed in position",
        ),
        ProblemRow::new(
            "driven: order of the pin's force m r omega2 cos",
            "",
            2.0,
            force.observed(),
            0.1,
            "slope over three halvings from 100 steps a turn",
        ),
        ProblemRow::new(
            "dry slot: work of the motor in a turn, 4 r F",
            "J",
            4.0 * R * DRY,
            rubbing.work,
            1e-5,
            "the pin's way in the slot is 4 r in a turn; of order h2 of 1000 steps",
        ),
        ProblemRow::new(
            "turning freely: order of the crank's angle after 1 s",
            "",
            2.0,
            angle.observed(),
            0.1,
            "slope over three halvings from 1 ms",
        ),
    ]
}

//! Problem 11: a disc placed on the floor while sliding; friction spins it until it rolls.

use crate::{Body, Contact, Energies, Mode, Model, Surface};
use moreau::GROUND;

use super::row::ProblemRow;
use super::run::{Run, at};

const G: f64 = 9.81;
const MU: f64 = 0.2;
const RADIUS: f64 = 0.3;
const MASS: f64 = 2.0;

/// When it rolls, at what speed, how fast its contact point still moves a second later, and the largest rise of the
/// energy in a step.
fn roll(h: f64) -> [f64; 4] {
    let bodies = [Body { mass: MASS, inertia: 0.5 * MASS * RADIUS * RADIUS }];
    let contacts = [Contact {
        disc_body: 0,
        center: [0.0, 0.0],
        radius: RADIUS,
        surface_body: GROUND,
        surface: Surface::Line { point: [0.0, 0.0], normal: [0.0, 1.0] },
        restitution: 0.0,
        kinetic: MU,
        limit: MU,
        belt: 0.0,
    }];
    let model = Model::new(&bodies, &[], &[], &contacts, [0.0, -G]).expect("sound");
    let mut run = Run::<1, 2>::new(model, h, &[(at(0.0, RADIUS, 0.0), [1.0, 0.0, 0.0])]);
    let tangential = model.contact_laws(0)[1];
    let mut energy = Energies::of(&model, &run.state).total();
    let mut gain = 0.0_f64;
    loop {
        run.step();
        let after = Energies::of(&model, &run.state).total();
        gain = gain.max(after - energy);
        energy = after;
        if run.state.mode[tangential] == Mode::Hold || !run.sound || run.time() > 1.0 {
            break;
        }
    }
    let rolls = run.time() - 0.5 * h;
    run.until(rolls + 1.0);
    let v = run.state.velocity[0];
    gain = gain.max(Energies::of(&model, &run.state).total() - energy);
    [rolls, v[0], v[0] + RADIUS * v[2], gain].map(|x| run.value(x))
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let mut rows = Vec::new();
    for h in [1e-2, 1e-3, 1e-4] {
        let [rolls, speed, slip, gain] = roll(h);
        let reference = 1.0 / (3.0 * MU * G);
        let name = |s: &str| format!("{s}, h = {h:.0e}");
        rows.push(ProblemRow::new(
            name("rolls from"),
            "s",
            reference,
            rolls,
            0.5 * h * 1.000_001,
            "known to half a step",
        ));
        let because = "exact at any h: friction keeps the angular momentum about the line; rounding";
        rows.push(ProblemRow::new(name("speed of rolling"), "m/s", 2.0 / 3.0, speed, 1e-12, because));
        rows.push(ProblemRow::new(name("slip a second later"), "m/s", 0.0, slip, 1e-12, "exact: rounding"));
        rows.push(ProblemRow::new(
            name("largest gain of energy in a step"),
            "J",
            0.0,
            gain,
            1e-13,
            "friction takes: rounding",
        ));
    }
    rows
}

//! Problem 16: blocks, each tilted by 0.01 rad to the one below and 2 mm above it, fall, rebound and come to rest as a
//! stack. There are more contacts than their motion determines: with seven or more closed at once, there are too many
//! guesses to enumerate.

use crate::{Body, Energies, ImpactLaw, Model, PolygonContact};
use moreau::GROUND;

use super::row::{Expected, ProblemRow};
use super::run::{Run, at};

const G: f64 = 9.81;
/// Half width and height of a block, m; its mass, kg.
const HALF: [f64; 2] = [0.1, 0.05];
const MASS: f64 = 1.0;
const MU: f64 = 0.5;
const RESTITUTION: f64 = 0.3;
const STEP: f64 = 1e-3;
const MAX_BLOCKS: usize = 16;

struct Fallen {
    /// The most negative normal impulse, and the largest friction beyond mu times the normal impulse, N s.
    pull: f64,
    beyond: f64,
    /// Largest rise of the energy in a step, J.
    gain: f64,
    /// Largest penetration of a corner, over h/2 times the largest closing speed that two corners could have had.
    sunk: f64,
    /// Largest relative error of what a floor of the stack carries at the end.
    load: f64,
    /// Largest speed at the end, m/s or rad/s.
    speed: f64,
    /// Largest residual of a step, m/s.
    residual: f64,
}

fn fall(blocks: usize, law: ImpactLaw) -> Fallen {
    let [x, y] = HALF;
    let bodies = vec![Body { mass: MASS, inertia: MASS * (x * x + y * y) / 3.0 }; blocks];
    let corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
    let floor = [[-10.0, -1.0], [10.0, -1.0], [10.0, 0.0], [-10.0, 0.0]];
    let contacts: Vec<PolygonContact<'_, f64>> = (0..blocks)
        .map(|i| PolygonContact {
            first: i,
            first_corners: &corners,
            second: if i == 0 { GROUND } else { i - 1 },
            second_corners: if i == 0 { &floor } else { &corners },
            restitution: RESTITUTION,
            kinetic: MU,
            limit: MU,
        })
        .collect();
    let model = Model::new(&bodies, &[], &[], &[], [0.0, -G]).and_then(|m| m.with_polygons(&contacts)).expect("sound");
    let start: Vec<_> = (0..blocks)
        .map(|i| {
            let tilt = if i % 2 == 0 { 0.01 } else { -0.01 };
            (at(0.0, y + 0.002 + i as f64 * (2.0 * y + 0.002), tilt), [0.0; 3])
        })
        .collect();
    let mut run = Run::<MAX_BLOCKS, { 4 * MAX_BLOCKS }>::new(model, STEP, &start);
    run.settings.impact_law = law;
    let mut fallen = Fallen { pull: 0.0, beyond: 0.0, gain: 0.0, sunk: 0.0, load: 0.0, speed: 0.0, residual: 0.0 };
    let mut energy = Energies::of(&model, &run.state).total();
    let (mut deepest, mut fastest) = (0.0_f64, 0.0_f64);
    while run.time() < 1.0 && run.sound {
        let report = run.step();
        fallen.residual = fallen.residual.max(report.residual);
        let after = Energies::of(&model, &run.state).total();
        fallen.gain = fallen.gain.max(after - energy);
        energy = after;
        for v in &run.state.velocity[..blocks] {
            fastest = fastest.max(v[0].hypot(v[1]) + v[2].abs() * x.hypot(y));
        }
        for c in 0..blocks {
            for k in 0..2 {
                let [n, t] = model.polygon_laws(c, k);
                let (normal, friction) = (run.state.impulse[n], run.state.impulse[t]);
                fallen.pull = fallen.pull.min(normal);
                fallen.beyond = fallen.beyond.max(friction.abs() - MU * normal);
            }
            for point in model.polygon_points(&run.state.placement, c, 0.0).into_iter().flatten() {
                deepest = deepest.max(-point.distance);
            }
        }
    }
    // Two bodies may close.
    fallen.sunk = deepest / (0.5 * STEP * 2.0 * fastest);
    for c in 0..blocks {
        // Upward, of impulses along a normal that is tilted a little.
        let points = model.polygon_points(&run.state.placement, c, 1e-3);
        let carried: f64 = (0..2)
            .filter_map(|k| {
                let [n, t] = model.polygon_laws(c, k).map(|i| run.state.impulse[i]);
                let [x, y] = points[k]?.normal;
                // The normal of the lower block is minus that of the upper one.
                Some(if y > 0.0 { n * y - t * x } else { t * x - n * y })
            })
            .sum();
        let weight = (blocks - c) as f64 * MASS * G * STEP;
        fallen.load = fallen.load.max((carried / weight - 1.0).abs());
    }
    fallen.speed = run.state.velocity[..blocks].iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
    for x in [&mut fallen.pull, &mut fallen.load, &mut fallen.speed, &mut fallen.residual] {
        *x = run.value(*x);
    }
    fallen
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let mut rows = Vec::new();
    for (blocks, law, name) in [
        (5, ImpactLaw::Newton, "5 blocks, Newton's law"),
        (5, ImpactLaw::Stronge, "5 blocks, Stronge's law"),
        (15, ImpactLaw::Newton, "15 blocks, Newton's law"),
    ] {
        let f = fall(blocks, law);
        let mut bound = |what: &str, expected, ours, because| {
            rows.push(ProblemRow::bounded(&format!("{name}: {what}"), expected, ours, because));
        };
        bound(
            "smallest normal impulse (N s)",
            Expected::AtLeast(0.0),
            f.pull,
            "no contact pulls; every step converged",
        );
        bound("friction beyond its cone (N s)", Expected::AtMost(1e-15), f.beyond, "rounding of mu p");
        bound("largest residual (m/s)", Expected::AtMost(1e-11), f.residual, "the solver's tolerance times some m/s");
        bound(
            "largest gain of energy in a step (J)",
            Expected::AtMost(blocks as f64 * MASS * (G * STEP).powi(2) / 8.0 + 1e-13),
            f.gain,
            "only blocks that come to rest in a step may give m (g h)2/8 each",
        );
        bound(
            "deepest corner, over h/2 times the fastest closing",
            Expected::AtMost(1.0),
            f.sunk,
            "a contact closes in the first step whose middle is past it",
        );
        bound("fastest body after 1 s (m/s, rad/s)", Expected::AtMost(1e-13), f.speed, "rest: rounding");
        rows.push(ProblemRow::new(
            format!("{name}: what every floor carries, over the weight above"),
            "",
            1.0,
            1.0 + f.load,
            1e-11,
            "rest: rounding, and points that are chosen anew after the step",
        ));
    }
    rows
}

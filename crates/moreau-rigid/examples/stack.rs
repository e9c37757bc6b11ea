//! A stack of blocks, each tilted a little against the one below, falls, rebounds and comes to rest: what a step costs
//! and what solved it.
//!
//! `cargo run --release -p moreau --example stack [BLOCKS [STEP_S [SECONDS]]] [stronge]`; 15 blocks touch at thirty
//! points.

use std::time::Instant;

use moreau::GROUND;
use moreau_rigid::{
    Body, Energies, ImpactLaw, Model, Placement, PolygonContact, Settings, SolvedBy, State, StepOutcome, Workspace,
    step,
};

const MAX_BLOCKS: usize = 16;
const LAWS: usize = 4 * MAX_BLOCKS;
/// Half width and height of a block, m.
const HALF: [f64; 2] = [0.1, 0.05];

fn main() {
    let stronge = std::env::args().any(|a| a == "stronge");
    let mut arguments =
        std::env::args().skip(1).filter(|a| a != "stronge").map(|a| a.parse::<f64>().expect("a number or `stronge`"));
    let blocks = (arguments.next().unwrap_or(15.0) as usize).clamp(1, MAX_BLOCKS);
    let h = arguments.next().unwrap_or(1e-3);
    let duration = arguments.next().unwrap_or(1.0);
    let [x, y] = HALF;
    let mass = 1.0;
    let bodies = vec![Body { mass, inertia: mass * (4.0 * x * x + 4.0 * y * y) / 12.0 }; blocks];
    let corners = [[-x, -y], [x, -y], [x, y], [-x, y]];
    let ground = [[-10.0, -1.0], [10.0, -1.0], [10.0, 0.0], [-10.0, 0.0]];
    let contacts: Vec<PolygonContact<f64>> = (0..blocks)
        .map(|i| PolygonContact {
            first: i,
            first_corners: &corners,
            second: if i == 0 { GROUND } else { i - 1 },
            second_corners: if i == 0 { &ground } else { &corners },
            restitution: 0.3,
            kinetic: 0.5,
            limit: 0.5,
        })
        .collect();
    let model = Model::new(&bodies, &[], &[], &[], [0.0, -9.81]).unwrap().with_polygons(&contacts).unwrap();
    let start: Vec<_> = (0..blocks)
        .map(|i| {
            let angle = if i % 2 == 0 { 0.01 } else { -0.01 };
            (Placement { at: [0.0, y + i as f64 * (2.0 * y + 0.002) + 0.002], angle }, [0.0; 3])
        })
        .collect();
    let mut state = Box::new(State::<f64, MAX_BLOCKS, LAWS>::new(&start));
    let mut workspace = Box::new(Workspace::new());
    let mut settings = Settings::new(h);
    if stronge {
        settings.impact_law = ImpactLaw::Stronge;
    }
    let mut times = Vec::new();
    let (mut outcomes, mut solvers) = ([0u32; 4], [0u32; 4]);
    let (mut residual, mut sweeps, mut guesses, mut gain, mut increments) = (0.0f64, 0, 0, 0.0f64, 0);
    let mut energy = Energies::of(&model, &state).total();
    for _ in 0..(duration / h).round() as u32 {
        let clock = Instant::now();
        let report = step(&model, &settings, &[], &mut state, &mut workspace);
        times.push(clock.elapsed().as_secs_f64());
        outcomes[match report.outcome {
            StepOutcome::Converged => 0,
            StepOutcome::Approximate => 1,
            StepOutcome::Painleve => 2,
            _ => 3,
        }] += 1;
        solvers[match report.solver {
            SolvedBy::Guesses => 0,
            SolvedBy::SweptGuess => 1,
            SolvedBy::Enumeration => 2,
            SolvedBy::Sweeps => 3,
        }] += 1;
        residual = residual.max(report.residual);
        sweeps = sweeps.max(report.sweeps);
        guesses = guesses.max(report.guesses);
        increments = increments.max(report.impact_increments);
        let after = Energies::of(&model, &state).total();
        gain = gain.max(after - energy);
        energy = after;
    }
    times.sort_by(f64::total_cmp);
    let at = |part: f64| times[((times.len() - 1) as f64 * part) as usize] * 1e3;
    println!("{blocks} blocks, {} points, {} steps of {h} s", 2 * blocks, times.len());
    println!("ms a step: median {:.3}, 99 % {:.3}, most {:.3}", at(0.5), at(0.99), at(1.0));
    println!("converged {}, approximate {}, Painleve {}, other {}", outcomes[0], outcomes[1], outcomes[2], outcomes[3]);
    println!(
        "last solved by: guesses {}, a guess after sweeps {}, enumeration {}, sweeps {}",
        solvers[0], solvers[1], solvers[2], solvers[3]
    );
    println!(
        "most guesses {guesses}, most sweeps {sweeps}, most increments {increments}, largest residual {residual:.1e} m/s"
    );
    println!("largest gain of energy in a step {gain:.1e} J");
    for (i, place) in state.placement.iter().enumerate().take(blocks) {
        let v = state.velocity[i];
        println!(
            "  block {i}: x {:+.5} m, sunk {:+.2e} m, angle {:+.2e} rad, speed {:.1e}",
            place.at[0],
            y + i as f64 * 2.0 * y - place.at[1],
            place.angle,
            v.iter().fold(0.0f64, |m, u| m.max(u.abs()))
        );
    }
}

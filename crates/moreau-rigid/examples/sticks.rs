//! Two problems that friction holds at rest: a block on a slope and a cylinder that two pads pinch. Prints how far each
//! goes between the first second and the tenth, mm, as a table in Markdown; `papers/peers/python/sticks.py` does so for
//! MuJoCo. See `docs/notes/sticks.md`.
//!
//! `cargo run --release -p moreau-rigid --example sticks`

use moreau::GROUND;
use moreau_rigid::{
    Body, Contact, Joint, JointKind, Model, Placement, Settings, State, StepOutcome, Surface, Workspace, step,
};

const GRAVITY: f64 = 9.81;
/// Friction coefficient of both problems.
pub const FRICTION: f64 = 0.5;
/// Slope of the plane; friction holds the block up to atan(0.5), 26.6 degrees.
pub const SLOPE_DEG: f64 = 20.0;
/// Force of the pad, N: friction can carry 2 x 0.5 x 5 N, and the cylinder weighs 0.98 N.
pub const PUSH_N: f64 = 5.0;
/// Beginning and end of the drift, s.
pub const BETWEEN_S: [f64; 2] = [1.0, 10.0];

/// Where the first body is at both instants, m; `None` if a step failed.
fn play<const B: usize, const N: usize>(
    model: &Model<'_, f64>,
    start: &[(Placement<f64>, [f64; 3])],
    loads: &[[f64; 3]],
    h: f64,
    between_s: [f64; 2],
) -> Option<[[f64; 2]; 2]> {
    let mut state = State::<f64, B, N>::new(start);
    let (mut workspace, settings) = (Workspace::new(), Settings::new(h));
    let [first, last] = between_s.map(|t| (t / h).round() as u32);
    let mut from = [0.0; 2];
    for n in 0..last {
        if n == first {
            from = state.placement[0].at;
        }
        let report = step(model, &settings, loads, &mut state, &mut workspace);
        if report.outcome != StepOutcome::Converged {
            return None;
        }
    }
    Some([from, state.placement[0].at])
}

fn contact(disc_body: usize, center: [f64; 2], radius: f64, of: usize, surface: Surface<'_, f64>) -> Contact<'_, f64> {
    let (restitution, kinetic, limit, belt) = (0.0, FRICTION, FRICTION, 0.0);
    Contact { disc_body, center, radius, surface_body: of, surface, restitution, kinetic, limit, belt }
}

fn way([[x0, y0], [x1, y1]]: [[f64; 2]; 2]) -> f64 {
    (x1 - x0).hypot(y1 - y0)
}

/// Drift of a block of 20 x 4 cm and 0.5 kg on two corners on a slope, m.
pub fn block_m(slope_deg: f64, h: f64, between_s: [f64; 2]) -> Option<f64> {
    let half = [0.10, 0.02];
    let bodies = [Body { mass: 0.5, inertia: 0.5 * 4.0 * (half[0] * half[0] + half[1] * half[1]) / 12.0 }];
    let slope = slope_deg.to_radians();
    let normal = [-slope.sin(), slope.cos()];
    let corners = [-half[0], half[0]]
        .map(|x| contact(0, [x, -half[1]], 0.0, GROUND, Surface::Line { point: [0.0, 0.0], normal }));
    let model = Model::new(&bodies, &[], &[], &corners, [0.0, -GRAVITY]).ok()?;
    let start = Placement { at: normal.map(|x| half[1] * x), angle: slope };
    play::<1, 4>(&model, &[(start, [0.0; 3])], &[], h, between_s).map(way)
}

/// Drift of a cylinder of 4 cm and 0.1 kg between a wall and a pad that pushes with a force, m.
pub fn pinched_m(push_n: f64, h: f64, between_s: [f64; 2]) -> Option<f64> {
    let (radius, mass) = (0.02, 0.1);
    let bodies = [Body { mass, inertia: 0.5 * mass * radius * radius }, Body { mass: 0.1, inertia: 1e-4 }];
    let contacts = [
        contact(0, [0.0; 2], radius, GROUND, Surface::Line { point: [-radius, 0.0], normal: [1.0, 0.0] }),
        contact(0, [0.0; 2], radius, 1, Surface::Line { point: [-0.02, 0.0], normal: [-1.0, 0.0] }),
    ];
    let joints = [Joint {
        kind: JointKind::Slide { axis: [1.0, 0.0], angle: 0.0 },
        first: GROUND,
        at_first: [0.0; 2],
        second: 1,
        at_second: [0.0; 2],
        dry: 0.0,
        viscous: 0.0,
        rate: None,
    }];
    let model = Model::new(&bodies, &joints, &[], &contacts, [0.0, -GRAVITY]).ok()?;
    let at = |x: f64| (Placement { at: [x, 0.0], angle: 0.0 }, [0.0; 3]);
    let loads = [[0.0; 3], [-push_n, 0.0, 0.0]];
    play::<2, 8>(&model, &[at(0.0), at(radius + 0.02)], &loads, h, between_s).map(way)
}

fn main() {
    println!("Erard's general step: drift from 1 to 10 s, mm\n");
    println!("| step, ms | block on a slope | pinched cylinder |");
    println!("|---|---|---|");
    for h in [2e-3, 5e-4] {
        let [block, pinched] = [block_m(SLOPE_DEG, h, BETWEEN_S), pinched_m(PUSH_N, h, BETWEEN_S)]
            .map(|drift_m| drift_m.map_or("failed".to_owned(), |drift_m| format!("{:.2e}", 1e3 * drift_m)));
        println!("| {} | {block} | {pinched} |", 1e3 * h);
    }
}

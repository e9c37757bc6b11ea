//! Textbook problems with known answers, solved by the engine and by the general step for rigid bodies
//! (`moreau-rigid`).
//!
//! Every reference is a closed form (or a quadrature) that shares no code with the engine; each problem states it, with
//! the reason for its tolerance. The tests check every row, and a report can list them.

// Matrix problems index several arrays by one number.
#![allow(clippy::needless_range_loop)]

mod control;
mod dry_felt;
mod dwell;
mod felt;
mod hereditary;
mod hinge;
mod mechanism;
mod pendulum;
mod relay;

pub use dry_felt::thrown_back;
pub use moreau_rigid::problems::{Expected, Order, Problem, ProblemRow};

/// All problems, those of the engine and those of rigid bodies, in order.
#[must_use]
pub fn problems() -> Vec<Problem> {
    let problem = |number, name, rows| Problem { number, name, rows };
    let mut all = vec![
        problem(1, "Pivot that sticks", hinge::pivot),
        problem(2, "Oscillator with dry friction", hinge::dry_oscillator),
        problem(3, "Pendulum with a dry pivot", hinge::dry_pendulum),
        problem(4, "Double pendulum", pendulum::rows),
        problem(5, "Elastic felt", felt::elastic),
        problem(6, "Damped felt", felt::damped),
        problem(7, "Relay problems alone", relay::rows),
        problem(15, "Steps with controlled error", control::rows),
        problem(22, "Hunt and Crossley's felt", felt::hunt_crossley),
        problem(23, "Felt with a dry loss", dry_felt::set_valued),
        problem(24, "Felt with a dry loss that slips", dry_felt::elastoplastic),
        problem(25, "Stulov's hereditary felt", hereditary::rows),
        problem(26, "Friction that grows at rest", dwell::rows),
        problem(27, "Felt with sliders in parallel", dry_felt::sliders_in_parallel),
    ];
    all.extend(moreau_rigid::problems::problems());
    all.sort_by_key(|problem| problem.number);
    all
}

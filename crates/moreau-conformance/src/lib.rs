//! Textbook problems with known answers, solved by the engine.
//!
//! Every reference is a closed form (or a quadrature) that shares no code with the engine; it stands beside the problem, with
//! the reason for its tolerance. The tests hold every row, and a report can list them.

// Matrix problems index several arrays by one number.
#![allow(clippy::needless_range_loop)]

mod ball;
mod belt;
mod control;
mod disc;
mod dry_felt;
mod dwell;
mod felt;
mod finite;
mod hereditary;
mod hinge;
mod incline;
mod kane;
mod loops;
mod mechanism;
mod pendulum;
mod relay;
mod rocking;
mod rod;
mod row;
mod run;
mod slot;
mod springs;
mod stack;

pub use dry_felt::thrown_back;
pub use row::{Expected, Order, Row};

/// A problem: its number and name, and how its rows are computed.
#[derive(Debug, Clone, Copy)]
pub struct Problem {
    /// Its place in the list; 8, the held note, is the piano layer's.
    pub number: u32,
    /// What it is called.
    pub name: &'static str,
    /// Solves it. Takes from milliseconds to some seconds.
    pub rows: fn() -> Vec<Row>,
}

/// All problems, in order.
#[must_use]
pub fn problems() -> Vec<Problem> {
    let problem = |number, name, rows| Problem { number, name, rows };
    vec![
        problem(1, "Pivot that sticks", hinge::pivot),
        problem(2, "Oscillator with dry friction", hinge::dry_oscillator),
        problem(3, "Pendulum with a dry pivot", hinge::dry_pendulum),
        problem(4, "Double pendulum", pendulum::rows),
        problem(5, "Elastic felt", felt::elastic),
        problem(6, "Damped felt", felt::damped),
        problem(7, "Relay problems alone", relay::rows),
        problem(9, "Oscillator on a belt", belt::rows),
        problem(10, "Block on an incline", incline::rows),
        problem(11, "Disc from sliding to rolling", disc::rows),
        problem(12, "Bouncing ball", ball::rows),
        problem(13, "Painleve's rod", rod::rows),
        problem(14, "Closed loops", loops::rows),
        problem(15, "Steps with controlled error", control::rows),
        problem(16, "Stack of tilted blocks", stack::rows),
        problem(17, "Rocking block", rocking::rows),
        problem(18, "Kane's paradox", kane::rows),
        problem(19, "Surfaces that end", finite::rows),
        problem(20, "Scotch yoke", slot::rows),
        problem(21, "Torsion springs and stiff springs", springs::rows),
        problem(22, "Hunt and Crossley's felt", felt::hunt_crossley),
        problem(23, "Felt with a dry loss", dry_felt::set_valued),
        problem(24, "Felt with a dry loss that slips", dry_felt::elastoplastic),
        problem(25, "Stulov's hereditary felt", hereditary::rows),
        problem(26, "Friction that grows at rest", dwell::rows),
    ]
}

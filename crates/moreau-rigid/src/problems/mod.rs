//! Textbook problems of rigid bodies, with known answers.
//!
//! Every reference is a closed form or a quadrature that shares no code with the step. Each problem states it, with the
//! reason for its tolerance.

mod ball;
mod belt;
pub mod closed_forms;
mod disc;
mod finite;
mod incline;
mod kane;
mod loops;
mod rocking;
mod rod;
mod row;
mod run;
mod slopes;
mod slot;
mod springs;
mod stack;

pub use row::{Expected, Order, ProblemRow};
pub use run::{Run, at};

/// Textbook problem: number, name, and the function that computes its rows.
#[derive(Debug, Clone, Copy)]
pub struct Problem {
    /// Number in the list of all problems. Number 8, the held note, belongs to the piano layer.
    pub number: u32,
    /// Name.
    pub name: &'static str,
    /// Function that solves the problem. It takes from milliseconds to a few seconds.
    pub rows: fn() -> Vec<ProblemRow>,
}

/// Returns the problems of rigid bodies, in order.
#[must_use]
pub fn problems() -> Vec<Problem> {
    let problem = |number, name, rows| Problem { number, name, rows };
    vec![
        problem(9, "Oscillator on a belt", belt::rows),
        problem(10, "Block on an incline", incline::rows),
        problem(11, "Disc from sliding to rolling", disc::rows),
        problem(12, "Bouncing ball", ball::rows),
        problem(13, "Painleve's rod", rod::rows),
        problem(14, "Closed loops", loops::rows),
        problem(16, "Stack of tilted blocks", stack::rows),
        problem(17, "Rocking block", rocking::rows),
        problem(18, "Kane's paradox", kane::rows),
        problem(19, "Surfaces that end", finite::rows),
        problem(20, "Scotch yoke", slot::rows),
        problem(21, "Torsion springs and stiff springs", springs::rows),
        problem(28, "Difference quotients through an impact", slopes::rows),
    ]
}

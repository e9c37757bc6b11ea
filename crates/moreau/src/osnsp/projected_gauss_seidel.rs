//! The papers' solver: p <- proj_[-bound, bound](p - rho u), law by law, until no velocity changes.
//!
//! With rho_i = 1/W_ii each update solves its own law exactly, given the others.

use super::delassus::{Dense, OneStepProblem};
use super::system::{Impulses, SolveReport, System};
use crate::real::{Mask, Real, Scalar};

/// Solves a system by way of its Delassus matrix.
pub(crate) fn solve<T: Scalar, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    tolerance: T,
    limit: u32,
) -> ([T; B], SolveReport) {
    let mut dense = Dense::new(system, impulses);
    let report = solve_dense(&dense.problem, &mut dense.impulse, tolerance, limit);
    (dense.finish(impulses), report)
}

/// Sweeps over the laws until no velocity changes by more than `tolerance`, at most `limit` times.
pub fn solve_dense<T: Real, const N: usize>(
    problem: &OneStepProblem<T, N>,
    p: &mut [T; N],
    tolerance: T,
    limit: u32,
) -> SolveReport {
    let n = problem.count;
    for i in 0..n {
        let b = problem.bound_at(i, p);
        p[i] = p[i].max(-b).min(b);
    }
    for sweep in 1..=limit {
        let mut change = T::ZERO;
        for i in 0..n {
            let w = problem.delassus[i][i];
            let movable = T::ZERO.lt(w);
            let u = problem.velocity_at(i, p);
            let b = problem.bound_at(i, p);
            let target = (p[i] - u / T::select(movable, w, T::ONE)).max(-b).min(b);
            let next = T::select(movable, target, p[i]);
            change = change.max((next - p[i]).abs() * w);
            p[i] = next;
        }
        if change.le(tolerance).all() {
            return SolveReport { converged: true, iterations: sweep };
        }
    }
    SolveReport { converged: n == 0, iterations: limit }
}

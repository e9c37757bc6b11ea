//! The one-step non-smooth problem (OSNSP): velocities and impulses of one linearised step.
//!
//! In relative (joint) velocities w the linearised step reads A w = b + p + sum_k row_k p_k, with one dry pivot per
//! joint,
//! |p_i| <= bound_i, and sliding laws u_k = row_k . w, |p_k| <= bound_k + slope_k . w (the bound follows the felt's force),
//! every impulse opposing its own velocity: p = proj_[-bound, bound](p - rho u) for any rho > 0 [T12 eqs 2-4].
//!
//! `system.rs` holds the data. Alternative solvers are sibling files with one signature; some of them use the dense
//! form u = u_free + W p of `delassus.rs`.

pub mod active_set;
pub mod delassus;
pub mod projected_gauss_seidel;
pub mod relay;
mod system;

use crate::real::{Mask, Real};
pub use system::{Guess, Impulses, SlidingLaw, SolveReport, System};

/// Solver of the one-step problem.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Solver {
    /// Active set on the velocities, with an exact fallback. The default.
    #[default]
    ActiveSet,
    /// Projected Gauss-Seidel on the augmented Lagrangian, as in the papers. For reference.
    ProjectedGaussSeidel,
}

impl Solver {
    /// Solves the system from its warm start, which is overwritten; `w`: the relative velocities. `tolerance` is on the
    /// laws' velocities, `limit` the largest number of sweeps or active sets. Says which lanes converged, and after how
    /// many sweeps or active sets.
    #[inline(always)]
    #[allow(clippy::too_many_arguments)]
    pub(crate) fn solve<T: Real, const B: usize, const N: usize>(
        self,
        system: &System<T, B, N>,
        impulses: &mut Impulses<T, B, N>,
        guess: &mut Guess<T, B, N>,
        condensed: &mut active_set::Condensed<T, B, N>,
        tolerance: T,
        limit: u32,
        w: &mut [T; B],
    ) -> (T::Mask, u32) {
        match self {
            Solver::ActiveSet => active_set::solve(system, impulses, guess, condensed, tolerance, limit, w),
            Solver::ProjectedGaussSeidel => sweep(system, impulses, guess, tolerance.lane(0), limit, w),
        }
    }
}

/// The reference solver.
#[inline(never)]
fn sweep<T: Real, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    guess: &mut Guess<T, B, N>,
    tolerance: T::Lane,
    limit: u32,
    w: &mut [T; B],
) -> (T::Mask, u32) {
    let one = |system: &_, own: &mut _| projected_gauss_seidel::solve(system, own, tolerance, limit);
    system::lane_by_lane(system, impulses, guess, w, T::Mask::splat(true), one)
}

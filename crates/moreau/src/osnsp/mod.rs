//! The one-step non-smooth problem (OSNSP): the impulses of all set-valued laws of one linearised step.
//!
//! Find p with u = u_free + W p and, for every law i, |p_i| <= bound_i, p_i = -bound_i sign(u_i) where u_i is not zero
//! (MODEL: p = proj_[-bound, bound](p - rho u) for any rho > 0). The bound of a sliding contact follows the felt's force,
//! so it is affine in p: bound_i(p) = max(0, bound_i + sum_j slope_ij p_j). An infinite bound is an equality, u_i = 0.
//!
//! Rival solvers are sibling files with one signature.

pub mod active_set;
pub mod projected_gauss_seidel;

use crate::{Real, Scalar};

/// One linearised step, `count` laws in use.
#[derive(Debug, Clone)]
pub struct OneStepProblem<T, const N: usize> {
    /// Number of laws in use.
    pub count: usize,
    /// Delassus matrix W = D^T A^-1 D, symmetric positive semidefinite.
    pub delassus: [[T; N]; N],
    /// u_free, the laws' velocities without impulses.
    pub free: [T; N],
    /// Constant part of the bounds, impulse units.
    pub bound: [T; N],
    /// Dependence of the bounds on the impulses.
    pub slope: [[T; N]; N],
    /// Whether a row of `slope` is in use; the others are not read.
    pub sloped: [bool; N],
}

impl<T: Real, const N: usize> OneStepProblem<T, N> {
    /// An empty problem.
    pub fn new() -> Self {
        let z = T::ZERO;
        OneStepProblem {
            count: 0,
            delassus: [[z; N]; N],
            free: [z; N],
            bound: [z; N],
            slope: [[z; N]; N],
            sloped: [false; N],
        }
    }

    /// The bound of law i at impulses p.
    #[inline(always)]
    pub fn bound_at(&self, i: usize, p: &[T; N]) -> T {
        let mut b = self.bound[i];
        if self.sloped[i] {
            for j in 0..self.count {
                b += self.slope[i][j] * p[j];
            }
        }
        b.max(T::ZERO)
    }

    /// The velocity of law i at impulses p.
    #[inline(always)]
    pub fn velocity_at(&self, i: usize, p: &[T; N]) -> T {
        let mut u = self.free[i];
        for j in 0..self.count {
            u += self.delassus[i][j] * p[j];
        }
        u
    }
}

impl<T: Scalar, const N: usize> OneStepProblem<T, N> {
    /// The solver-independent error measure: the largest |p - proj(p - u / W_ii)| W_ii over the laws, a velocity.
    pub fn error(&self, p: &[T; N]) -> T {
        let mut worst = T::ZERO;
        for i in 0..self.count {
            let (b, w) = (self.bound_at(i, p), self.delassus[i][i]);
            if T::ZERO < w {
                let projected = (p[i] - self.velocity_at(i, p) / w).max(-b).min(b);
                worst = worst.max((p[i] - projected).abs() * w);
            }
        }
        worst
    }
}

impl<T: Real, const N: usize> Default for OneStepProblem<T, N> {
    fn default() -> Self {
        Self::new()
    }
}

/// Which solver.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Solver {
    /// Semismooth Newton on the active set, with an exact fallback: the default.
    #[default]
    ActiveSet,
    /// The papers' projected Gauss-Seidel on the augmented Lagrangian: the reference.
    ProjectedGaussSeidel,
}

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SolveReport {
    /// The tolerance was met.
    pub converged: bool,
    /// Sweeps or active sets tried.
    pub iterations: u32,
}

impl Solver {
    /// Solves the problem from a warm start `p`, which it overwrites.
    #[inline(always)]
    pub fn solve<T: Scalar, const N: usize>(
        self,
        problem: &OneStepProblem<T, N>,
        p: &mut [T; N],
        tolerance: T,
        limit: u32,
    ) -> SolveReport {
        match self {
            Solver::ActiveSet => active_set::solve(problem, p, tolerance, limit),
            Solver::ProjectedGaussSeidel => projected_gauss_seidel::solve(problem, p, tolerance, limit),
        }
    }
}

//! Dense form of the one-step problem: all laws in one list, coupled by the Delassus matrix.
//!
//! Find p with u = u_free + W p and, for every law i, |p_i| <= bound_i, p_i = -bound_i sign(u_i) where u_i is not zero.
//! The bound of a sliding contact follows the felt's force, so it is affine in p:
//! bound_i(p) = max(0, bound_i + sum_j slope_ij p_j). An infinite bound is an equality, u_i = 0.

use super::system::{Impulses, System};
use crate::linear;
use crate::real::{Real, Scalar};

/// One-step problem in dense form, with `count` laws in use.
#[derive(Debug, Clone)]
pub struct OneStepProblem<T, const N: usize> {
    /// Number of laws in use.
    pub count: usize,
    /// Delassus matrix W = D^T A^-1 D, symmetric positive semidefinite.
    pub delassus: [[T; N]; N],
    /// Velocities u_free of the laws without impulses.
    pub free: [T; N],
    /// Constant part of the bounds, impulse units.
    pub bound: [T; N],
    /// Gradient of each bound in the impulses.
    pub slope: [[T; N]; N],
    /// Whether each row of `slope` is in use; the others are not read.
    pub sloped: [bool; N],
}

impl<T: Real, const N: usize> OneStepProblem<T, N> {
    /// Returns an empty problem.
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
    pub(crate) fn bound_at(&self, i: usize, p: &[T; N]) -> T {
        let mut b = self.bound[i];
        if self.sloped[i] {
            for j in 0..self.count {
                b += self.slope[i][j] * p[j];
            }
        }
        b.max(T::ZERO)
    }

    /// Returns the velocity of law i at impulses p.
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
    pub(crate) fn error(&self, p: &[T; N]) -> T {
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

/// The laws of a system in dense order: the pivots with friction, then the sliding laws.
pub(super) struct Dense<T, const B: usize, const N: usize> {
    pub problem: OneStepProblem<T, N>,
    /// p in dense order.
    pub impulse: [T; N],
    columns: [[T; B]; N],
    free: [T; B],
    pivot: [usize; N],
    pivots: usize,
}

impl<T: Scalar, const B: usize, const N: usize> Dense<T, B, N> {
    /// W = D^T A^-1 D and u_free of a system, warm-started.
    pub(crate) fn new(system: &System<T, B, N>, impulses: &Impulses<T, B, N>) -> Self {
        let mut factors = [[T::ZERO; B]; B];
        let mut free = system.b;
        let inverse_d = system.a.factor(&system.a.diagonal, &mut factors, [&mut free]);
        linear::back_substitute(&factors, &inverse_d, &mut free);
        let mut dense = Dense {
            problem: OneStepProblem::new(),
            impulse: [T::ZERO; N],
            columns: [[T::ZERO; B]; N],
            free,
            pivot: [0; N],
            pivots: 0,
        };
        let mut rows = [[T::ZERO; B]; N];
        let mut n = 0;
        for i in 0..B {
            if T::ZERO < system.pivot_bound[i] && n < N {
                rows[n][i] = T::ONE;
                dense.pivot[n] = i;
                dense.problem.bound[n] = system.pivot_bound[i];
                dense.problem.free[n] = dense.free[i];
                dense.impulse[n] = impulses.pivot[i];
                n += 1;
            }
        }
        dense.pivots = n;
        for (k, law) in system.sliding[..system.count].iter().enumerate() {
            if n == N {
                break;
            }
            rows[n] = law.row;
            dense.problem.free[n] = linear::product(&law.row, &dense.free) - law.target;
            dense.problem.bound[n] =
                if law.rigid { T::ONE / T::ZERO } else { law.bound + linear::product(&law.slope, &dense.free) };
            dense.problem.sloped[n] = !law.rigid;
            dense.impulse[n] = impulses.sliding[k];
            n += 1;
        }
        dense.problem.count = n;
        for j in 0..n {
            dense.columns[j] = linear::solve(&factors, &inverse_d, &rows[j]);
            for i in 0..n {
                dense.problem.delassus[i][j] = linear::product(&rows[i], &dense.columns[j]);
                if i >= dense.pivots {
                    let slope = &system.sliding[i - dense.pivots].slope;
                    dense.problem.slope[i][j] = linear::product(slope, &dense.columns[j]);
                }
            }
        }
        dense
    }

    /// Hands the solution back: impulses, velocities; what sticks has a velocity of zero, not of zero plus rounding.
    pub(crate) fn finish(&self, impulses: &mut Impulses<T, B, N>) -> [T; B] {
        let mut w = self.free;
        for (p, column) in self.impulse.iter().zip(&self.columns).take(self.problem.count) {
            for i in 0..B {
                w[i] += column[i] * *p;
            }
        }
        for n in 0..self.problem.count {
            if n < self.pivots {
                impulses.pivot[self.pivot[n]] = self.impulse[n];
                if self.impulse[n].abs() < self.problem.bound[n] {
                    w[self.pivot[n]] = T::ZERO;
                }
            } else {
                impulses.sliding[n - self.pivots] = self.impulse[n];
            }
        }
        w
    }
}

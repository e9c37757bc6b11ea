//! Exact solver of the dense problem. It guesses which laws stick, solves the linear system of the guess, and corrects
//! the guess until it is right.
//!
//! If the guesses cycle (badly conditioned or rank-deficient problems), a primal active-set method takes over. It
//! solves the convex quadratic programme min 1/2 p.W p + u_free.p over the box, decreases the objective at every step,
//! and terminates (Nocedal & Wright, Numerical Optimization, section 16.5).

use super::delassus::OneStepProblem;
use super::system::SolveReport;
use crate::real::{Mask, Real, Scalar};

/// Guesses before the fallback; usual problems need one or two, and what cycles does so from the start.
const GUESSES: u32 = 12;
/// Passes of the fallback, each with the bounds frozen at the last impulses.
const BOUND_PASSES: u32 = 40;
/// Pivots below this part of their diagonal mean a law that the other sticking laws already hold.
const DEPENDENT: f64 = 1e-11;

/// Which end of its interval a law is at.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Side {
    /// p = -bound, u >= 0.
    Lower,
    /// Strictly inside, u = 0.
    Stick,
    /// p = +bound, u <= 0.
    Upper,
}

/// Solves the problem to `tolerance` on the laws' velocities. `limit` bounds the fallback's steps per pass.
#[inline]
pub fn solve_dense<T: Scalar, const N: usize>(
    problem: &OneStepProblem<T, N>,
    p: &mut [T; N],
    tolerance: T,
    limit: u32,
) -> SolveReport {
    let n = problem.count;
    let mut side = [Side::Stick; N];
    for i in 0..n {
        let b = problem.bound_at(i, p);
        side[i] = if b.finite() && p[i] >= b {
            Side::Upper
        } else if b.finite() && p[i] <= -b {
            Side::Lower
        } else {
            Side::Stick
        };
    }
    for guess in 1..=GUESSES {
        let dependent = impulses_of_guess(problem, &side, p);
        if !correct_guess(problem, p, &mut side, &dependent, tolerance) {
            return SolveReport { converged: true, iterations: guess };
        }
    }
    fallback(problem, p, tolerance, limit)
}

/// The impulses that make every sticking law's velocity zero and put every sliding law on its bound. Returns the
/// sticking laws that the others hold already.
#[inline(always)]
fn impulses_of_guess<T: Scalar, const N: usize>(
    problem: &OneStepProblem<T, N>,
    side: &[Side; N],
    p: &mut [T; N],
) -> [bool; N] {
    let mut dependent = [false; N];
    let n = problem.count;
    // Laws with a constant bound that slide are known; the others go into a small linear system.
    let mut unknown = [0usize; N];
    let mut m = 0;
    for i in 0..n {
        match side[i] {
            Side::Upper if !problem.sloped[i] => p[i] = problem.bound[i].max(T::ZERO),
            Side::Lower if !problem.sloped[i] => p[i] = -problem.bound[i].max(T::ZERO),
            _ => {
                unknown[m] = i;
                m += 1;
            }
        }
    }
    if m == 0 {
        return dependent;
    }
    let mut is_unknown = [false; N];
    for &i in &unknown[..m] {
        is_unknown[i] = true;
    }
    let mut own = Elimination::<T, N>::new();
    for (row, &i) in unknown[..m].iter().enumerate() {
        // Sticking: (W p)_i = -u_free_i. Sliding with a slope: p_i - s (slope p)_i = s bound_i.
        let (coefficients, sign, constant) = match side[i] {
            Side::Stick => (&problem.delassus[i], T::ONE, -problem.free[i]),
            Side::Upper => (&problem.slope[i], -T::ONE, problem.bound[i]),
            Side::Lower => (&problem.slope[i], T::ONE, -problem.bound[i]),
        };
        let mut known = T::ZERO;
        for j in 0..n {
            if !is_unknown[j] {
                known += sign * coefficients[j] * p[j];
            }
        }
        for (column, &j) in unknown[..m].iter().enumerate() {
            own.matrix[row][column] = sign * coefficients[j];
        }
        if side[i] != Side::Stick {
            own.matrix[row][row] += T::ONE;
        }
        own.right[row] = constant - known;
    }
    for (row, &i) in unknown[..m].iter().enumerate() {
        let b = problem.bound_at(i, p);
        own.x[row] = p[i].max(-b).min(b);
    }
    for k in 0..m {
        own.scale[k] = own.matrix[k][k].abs();
    }
    own.eliminate(m);
    for (row, &i) in unknown[..m].iter().enumerate() {
        p[i] = own.x[row];
        dependent[i] = own.dependent[row];
    }
    dependent
}

/// Whether a pivot has vanished against its scale.
#[inline(always)]
pub(super) fn is_dependent<T: Real>(pivot: T, scale: T) -> T::Mask {
    pivot.abs().le(scale * T::from_f64(DEPENDENT).max(T::from_f64(16.0) * T::EPSILON))
}

/// A dense linear system of some of the laws, and its elimination's working memory: arrays that would be cleared in
/// every step if they were not kept. Of each, only what belongs to the laws in question is read.
#[derive(Debug, Clone)]
pub(super) struct Elimination<T: Real, const N: usize> {
    pub matrix: [[T; N]; N],
    pub right: [T; N],
    /// What pivots are compared with.
    pub scale: [T; N],
    /// Before: what a law whose pivot vanishes keeps. After: the solution.
    pub x: [T; N],
    inverse: [T; N],
    /// The laws whose pivot has vanished: the others hold them, and their impulse is not determined.
    pub dependent: [T::Mask; N],
}

impl<T: Real, const N: usize> Elimination<T, N> {
    pub(super) fn new() -> Self {
        let (zero, no) = ([T::ZERO; N], T::Mask::splat(false));
        Elimination { matrix: [zero; N], right: zero, scale: zero, x: zero, inverse: zero, dependent: [no; N] }
    }

    /// Makes a row of the first `m` zero. In sizes with room for few laws it is quicker to clear all of it.
    #[inline(always)]
    pub(super) fn clear_row(&mut self, row: usize, m: usize) {
        if const { N > 16 } {
            for j in 0..m {
                self.matrix[row][j] = T::ZERO;
            }
        } else {
            self.matrix[row] = [T::ZERO; N];
        }
    }

    /// Gaussian elimination of the first `m` laws in the given order.
    #[inline(always)]
    pub(super) fn eliminate(&mut self, m: usize) {
        let Elimination { matrix: a, right: rhs, scale, x, inverse, dependent } = self;
        for k in 0..m {
            dependent[k] = is_dependent(a[k][k], scale[k]);
            if dependent[k].all() {
                inverse[k] = T::ZERO;
                continue;
            }
            inverse[k] = T::select(dependent[k], T::ZERO, T::ONE / a[k][k]);
            for i in k + 1..m {
                let factor = a[i][k] * inverse[k];
                for j in k + 1..m {
                    let t = a[k][j];
                    a[i][j] -= factor * t;
                }
                let t = rhs[k];
                rhs[i] -= factor * t;
            }
        }
        for k in (0..m).rev() {
            if !dependent[k].all() {
                let mut s = rhs[k];
                for j in k + 1..m {
                    s -= a[k][j] * x[j];
                }
                let free = s * inverse[k];
                x[k] = if dependent[k].any() { T::select(dependent[k], x[k], free) } else { free };
            }
        }
    }
}

/// Moves every law whose guess is refuted; says whether there was one.
#[inline(always)]
fn correct_guess<T: Scalar, const N: usize>(
    problem: &OneStepProblem<T, N>,
    p: &mut [T; N],
    side: &mut [Side; N],
    dependent: &[bool; N],
    tolerance: T,
) -> bool {
    let mut changed = false;
    for i in 0..problem.count {
        match side[i] {
            Side::Stick if dependent[i] && problem.velocity_at(i, p).abs() > tolerance => {
                let u = problem.velocity_at(i, p);
                if problem.bound[i].finite() {
                    // The others do not hold it after all: it slides, against its velocity.
                    side[i] = if u > T::ZERO { Side::Lower } else { Side::Upper };
                } else {
                    release_blocking_law(problem, side, i, u);
                }
                changed = true;
            }
            Side::Stick => {
                let b = problem.bound_at(i, p);
                // Rounding in the bound must not turn a law that holds at its limit back and forth.
                let slack = b * (T::from_f64(8.0) * T::EPSILON);
                if p[i] > b + slack {
                    side[i] = Side::Upper;
                    changed = true;
                } else if p[i] < -b - slack {
                    side[i] = Side::Lower;
                    changed = true;
                }
            }
            Side::Upper => {
                if problem.velocity_at(i, p) > tolerance || p[i] < T::ZERO {
                    side[i] = Side::Stick;
                    changed = true;
                }
            }
            Side::Lower => {
                if problem.velocity_at(i, p) < -tolerance || p[i] > T::ZERO {
                    side[i] = Side::Stick;
                    changed = true;
                }
            }
        }
    }
    changed
}

/// The sticking laws do not admit an equality: the one that is most strongly coupled to it is released, and slides
/// against the motion.
#[cold]
fn release_blocking_law<T: Scalar, const N: usize>(
    problem: &OneStepProblem<T, N>,
    side: &mut [Side; N],
    i: usize,
    u: T,
) {
    let (mut most, mut holder) = (T::ZERO, None);
    for j in 0..problem.count {
        let (coupling, mobility) = (problem.delassus[i][j], problem.delassus[j][j]);
        if side[j] == Side::Stick && problem.bound[j].finite() && T::ZERO < mobility {
            let share = coupling * coupling / mobility;
            if most < share {
                (most, holder) = (share, Some(j));
            }
        }
    }
    if let Some(j) = holder {
        side[j] = if T::ZERO < u * problem.delassus[i][j] { Side::Upper } else { Side::Lower };
    }
}

/// The primal active-set method, repeated until the bounds that follow the impulses stand still.
#[cold]
fn fallback<T: Scalar, const N: usize>(
    problem: &OneStepProblem<T, N>,
    p: &mut [T; N],
    tolerance: T,
    limit: u32,
) -> SolveReport {
    let n = problem.count;
    let mut iterations = GUESSES;
    let any_slope = problem.sloped[..n].iter().any(|&s| s);
    let passes = if any_slope { BOUND_PASSES } else { 2 };
    for _ in 0..passes {
        let mut bound = [T::ZERO; N];
        for (i, b) in bound.iter_mut().enumerate().take(n) {
            *b = problem.bound_at(i, p);
        }
        iterations += downhill(problem, &bound, p, tolerance, limit);
        if problem.error(p) <= tolerance {
            return SolveReport { converged: true, iterations };
        }
    }
    SolveReport { converged: false, iterations }
}

/// Minimises 1/2 p.W p + u_free.p over |p_i| <= bound_i; returns the number of steps taken.
fn downhill<T: Scalar, const N: usize>(
    problem: &OneStepProblem<T, N>,
    bound: &[T; N],
    p: &mut [T; N],
    tolerance: T,
    limit: u32,
) -> u32 {
    let n = problem.count;
    let mut largest = T::ZERO;
    for i in 0..n {
        p[i] = p[i].max(-bound[i]).min(bound[i]);
        largest = largest.max(problem.delassus[i][i]);
    }
    // A proximal term far below the smallest useful eigenvalue gives null directions a finite, downhill step.
    let proximal = largest * T::from_f64(1e-13).max(T::from_f64(4.0) * T::EPSILON);
    let mut free = [false; N];
    for i in 0..n {
        free[i] = p[i].abs() < bound[i];
    }
    for step in 1..=limit {
        let mut index = [0usize; N];
        let mut m = 0;
        for i in 0..n {
            if free[i] {
                index[m] = i;
                m += 1;
            }
        }
        let mut own = Elimination::<T, N>::new();
        for (row, &i) in index[..m].iter().enumerate() {
            for (column, &j) in index[..m].iter().enumerate() {
                own.matrix[row][column] = problem.delassus[i][j];
            }
            own.matrix[row][row] += proximal;
            own.right[row] = -problem.velocity_at(i, p);
        }
        // Positive definite by the proximal term: no pivot vanishes.
        own.eliminate(m);
        let d = own.x;
        let mut length = T::ONE;
        let mut blocking = None;
        for (row, &i) in index[..m].iter().enumerate() {
            let end = if d[row] > T::ZERO { bound[i] } else { -bound[i] };
            if d[row] != T::ZERO && (p[i] + d[row]).abs() > bound[i] {
                let reach = ((end - p[i]) / d[row]).max(T::ZERO);
                if reach < length {
                    length = reach;
                    blocking = Some((i, end));
                }
            }
        }
        for (row, &i) in index[..m].iter().enumerate() {
            p[i] = (p[i] + length * d[row]).max(-bound[i]).min(bound[i]);
        }
        if let Some((i, end)) = blocking {
            p[i] = end;
            free[i] = false;
            continue;
        }
        let mut worst = tolerance * T::from_f64(0.5);
        let mut release = None;
        let mut at_rest = true;
        for i in 0..n {
            let u = problem.velocity_at(i, p);
            if free[i] {
                at_rest &= u.abs() <= tolerance;
            } else {
                let pull = if p[i] > T::ZERO { u } else { -u };
                if bound[i] > T::ZERO && pull > worst {
                    worst = pull;
                    release = Some(i);
                }
            }
        }
        match release {
            Some(i) => free[i] = true,
            None if at_rest => return step,
            None => {}
        }
    }
    limit
}

//! Active set on the velocities: guess which laws stick, take the velocities that stick out of the system, solve it, correct
//! the guess, until it is right. The warm start is right in most steps, and then one factorisation is all; the Delassus
//! matrix is never formed.
//!
//! Sticking pivots are left out of the system, so that their velocities are exactly zero (a held note does not drift by
//! rounding), and it is solved by code unrolled for its size. Sliding contacts are few: they are condensed onto a system of
//! their own. Where guesses cycle, the exact dense solver takes over.

use super::delassus::Dense;
use super::relay::{eliminate, is_dependent, solve_dense};
use super::{Impulses, SolveReport, System};
use crate::linear::{back_substitute, factor, product, solve as solve_factored, symmetric_product};
use crate::{Real, Scalar};

/// Guesses that correct every refuted law at once; usual problems need one or two, and what cycles does so from the start.
const GUESSES: u32 = 8;
/// Guesses that then correct only the first refuted law, which ends most cycles, before the exact dense solver takes over.
const SINGLE_GUESSES: u32 = 24;

/// Where every law stands: 0 sticks, +1 and -1 slide with p = +bound and -bound.
#[derive(Debug, Clone)]
pub struct Guess<T, const B: usize, const N: usize> {
    /// Pivots; those without dry friction never stick.
    pub pivot: [T; B],
    /// Sliding laws.
    pub sliding: [T; N],
    /// Sliding laws whose bound falls to zero within the step, because the felt is left: p = 0, whatever the velocity.
    open: [bool; N],
}

/// The sliding laws' own system, once the pivots are guessed: workspace.
#[derive(Debug, Clone)]
pub struct Condensed<T, const B: usize, const N: usize> {
    /// A^-1 row of every law.
    columns: [[T; B]; N],
    matrix: [[T; N]; N],
}

impl<T: Real, const B: usize, const N: usize> Guess<T, B, N> {
    pub(crate) fn new() -> Self {
        Guess { pivot: [T::ZERO; B], sliding: [T::ZERO; N], open: [false; N] }
    }
}

impl<T: Real, const B: usize, const N: usize> Condensed<T, B, N> {
    pub(crate) fn new() -> Self {
        Condensed { columns: [[T::ZERO; B]; N], matrix: [[T::ZERO; N]; N] }
    }
}

impl<T: Scalar, const B: usize, const N: usize> Guess<T, B, N> {
    /// What a solution's impulses say: a law at its bound slides.
    pub(crate) fn read(&mut self, system: &System<T, B, N>, impulses: &Impulses<T, B, N>) {
        for k in 0..system.count {
            let (law, p) = (&system.sliding[k], impulses.sliding[k]);
            let side = if p >= law.bound { T::ONE } else { -T::ONE };
            self.sliding[k] = if law.rigid || p.abs() < law.bound { T::ZERO } else { side };
        }
    }
}

/// Solves to `tolerance` on the laws' velocities, from a guess, which is corrected; `limit` bounds the fallback. `w`: the relative
/// velocities.
#[inline(always)]
pub fn solve<T: Scalar, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    guess: &mut Guess<T, B, N>,
    condensed: &mut Condensed<T, B, N>,
    tolerance: T,
    limit: u32,
    w: &mut [T; B],
) -> SolveReport {
    for k in 0..system.count {
        guess.open[k] = false;
    }
    for iterations in 1..=GUESSES + SINGLE_GUESSES {
        if !try_guess(system, guess, impulses, condensed, tolerance, iterations > GUESSES, w) {
            return SolveReport { converged: true, iterations };
        }
    }
    let (velocities, report) = fall_back(system, impulses, guess, tolerance, limit);
    *w = velocities;
    report
}

#[cold]
#[inline(never)]
fn fall_back<T: Scalar, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    guess: &mut Guess<T, B, N>,
    tolerance: T,
    limit: u32,
) -> ([T; B], SolveReport) {
    let mut dense = Dense::new(system, impulses);
    let mut report = solve_dense(&dense.problem, &mut dense.impulse, tolerance, limit);
    report.iterations += GUESSES + SINGLE_GUESSES;
    let w = dense.finish(impulses);
    guess.read(system, impulses);
    (w, report)
}

/// Solves the system that a guess leaves, and corrects the guess where the solution refutes it; `single`: in one place only.
#[inline(always)]
fn try_guess<T: Scalar, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    guess: &mut Guess<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    condensed: &mut Condensed<T, B, N>,
    tolerance: T,
    single: bool,
    w: &mut [T; B],
) -> bool {
    let (mut free, mut m) = ([0; B], 0);
    for i in 0..B {
        impulses.pivot[i] = guess.pivot[i] * system.pivot_bound[i];
        if guess.pivot[i] != T::ZERO {
            free[m] = i;
            m += 1;
        }
    }
    *w = [T::ZERO; B];
    let mut changed = match m {
        // Sizes that the compiler unrolls.
        1 => reduced::<T, B, N, 1>(system, guess, impulses, condensed, &free, 1, w, tolerance, single),
        2 => reduced::<T, B, N, 2>(system, guess, impulses, condensed, &free, 2, w, tolerance, single),
        3 => reduced::<T, B, N, 3>(system, guess, impulses, condensed, &free, 3, w, tolerance, single),
        4 => reduced::<T, B, N, 4>(system, guess, impulses, condensed, &free, 4, w, tolerance, single),
        5 => reduced::<T, B, N, 5>(system, guess, impulses, condensed, &free, 5, w, tolerance, single),
        6 => reduced::<T, B, N, 6>(system, guess, impulses, condensed, &free, 6, w, tolerance, single),
        _ => reduced::<T, B, N, B>(system, guess, impulses, condensed, &free, m, w, tolerance, single),
    };
    for i in 0..B {
        if guess.pivot[i] == T::ZERO {
            let mut p = symmetric_product(&system.a, i, w) - system.b[i];
            for law in 0..system.count {
                p -= system.sliding[law].row[i] * impulses.sliding[law];
            }
            impulses.pivot[i] = p;
            // Rounding in the bound must not turn a pivot that holds at its limit back and forth.
            let bound = system.pivot_bound[i] * (T::ONE + T::from_f64(8.0) * T::EPSILON);
            if bound < p.abs() && !(single && changed) {
                guess.pivot[i] = if T::ZERO < p { T::ONE } else { -T::ONE };
                changed = true;
            }
        } else if tolerance < guess.pivot[i] * w[i] && T::ZERO < system.pivot_bound[i] {
            if single && changed {
                continue;
            }
            guess.pivot[i] = T::ZERO;
            changed = true;
        }
    }
    changed
}

/// The first `m` (at most M) joints of `free` move, the others stick: their velocities and the sliding laws' impulses. Corrects the
/// guesses of the sliding laws.
#[inline(never)]
#[allow(clippy::too_many_arguments)]
fn reduced<T: Scalar, const B: usize, const N: usize, const M: usize>(
    system: &System<T, B, N>,
    guess: &mut Guess<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    condensed: &mut Condensed<T, B, N>,
    free: &[usize; B],
    m: usize,
    w: &mut [T; B],
    tolerance: T,
    single: bool,
) -> bool {
    let mut factors = [[T::ZERO; M]; M];
    let mut v = [T::ZERO; M];
    for r in 0..M {
        if r < m {
            let i = free[r];
            v[r] = system.b[i] + impulses.pivot[i];
            for c in 0..=r {
                factors[r][c] = system.a[i][free[c]];
            }
        } else {
            factors[r][r] = T::ONE;
        }
    }
    let gather = |row: &[T; B]| {
        let mut reduced = [T::ZERO; M];
        for r in 0..m.min(M) {
            reduced[r] = row[free[r]];
        }
        reduced
    };
    let mut changed = false;
    if system.count == 1 && !system.sliding[0].rigid {
        // The usual case of several laws, spelt out.
        let law = &system.sliding[0];
        let (row, slope) = (gather(&law.row), gather(&law.slope));
        let mut column = row;
        let inverse_d = factor(&mut factors, [&mut v, &mut column]);
        back_substitute(&factors, &inverse_d, &mut v);
        back_substitute(&factors, &inverse_d, &mut column);
        let side = guess.sliding[0];
        let (mut p, mut dependent) = (T::ZERO, false);
        if guess.open[0] {
        } else if side == T::ZERO {
            let pivot = product(&row, &column);
            dependent = is_dependent(pivot, scale_of(system, &law.row));
            p = if dependent { impulses.sliding[0] } else { (law.target - product(&row, &v)) / pivot };
        } else {
            p = side * (law.bound + product(&slope, &v)) / (T::ONE - side * product(&slope, &column));
        }
        for r in 0..M {
            v[r] += column[r] * p;
        }
        impulses.sliding[0] = p;
        let (u, bound) = (product(&row, &v) - law.target, law.bound + product(&slope, &v));
        let (side, open) = corrected(side, guess.open[0], p, u, bound, dependent, tolerance);
        changed = side != guess.sliding[0] || open != guess.open[0];
        (guess.sliding[0], guess.open[0]) = (side, open);
    } else {
        let inverse_d = factor(&mut factors, [&mut v]);
        back_substitute(&factors, &inverse_d, &mut v);
        if system.count > 0 {
            changed =
                slide(system, guess, impulses, condensed, &factors, &inverse_d, gather, &mut v, tolerance, single);
        }
    }
    for r in 0..m.min(M) {
        w[free[r]] = v[r];
    }
    changed
}

/// Sliding laws, condensed: adds their share to the velocities `v`, and corrects their guesses.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn slide<T: Scalar, const B: usize, const N: usize, const M: usize>(
    system: &System<T, B, N>,
    guess: &mut Guess<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    condensed: &mut Condensed<T, B, N>,
    factors: &[[T; M]; M],
    inverse_d: &[T; M],
    gather: impl Fn(&[T; B]) -> [T; M],
    v: &mut [T; M],
    tolerance: T,
    single: bool,
) -> bool {
    let n = system.count.min(N);
    let Condensed { columns, matrix } = condensed;
    let (mut rhs, mut p, mut diagonal) = ([T::ZERO; N], [T::ZERO; N], [T::ONE; N]);
    for k in 0..n {
        let column = solve_factored(factors, inverse_d, &gather(&system.sliding[k].row));
        columns[k][..M.min(B)].copy_from_slice(&column[..M.min(B)]);
    }
    let along = |row: &[T; M], column: &[T; B]| {
        let mut sum = T::ZERO;
        for r in 0..M.min(B) {
            sum += row[r] * column[r];
        }
        sum
    };
    for k in 0..n {
        let law = &system.sliding[k];
        let s = guess.sliding[k];
        if guess.open[k] {
            matrix[k] = [T::ZERO; N];
            matrix[k][k] = T::ONE;
        } else if s == T::ZERO {
            // Sticking: row . (w + sum columns p) = target.
            let row = gather(&law.row);
            rhs[k] = law.target - product(&row, v);
            for j in 0..n {
                matrix[k][j] = along(&row, &columns[j]);
            }
            p[k] = impulses.sliding[k];
            diagonal[k] = scale_of(system, &law.row);
        } else {
            // Sliding: p = s (bound + slope . (w + sum columns p)).
            let slope = gather(&law.slope);
            rhs[k] = s * (law.bound + product(&slope, v));
            for j in 0..n {
                matrix[k][j] = -s * along(&slope, &columns[j]);
            }
            matrix[k][k] += T::ONE;
        }
    }
    let dependent = eliminate(matrix, &mut rhs, &mut p, &diagonal, n);
    for k in 0..n {
        for r in 0..M.min(B) {
            v[r] += columns[k][r] * p[k];
        }
    }
    let mut changed = false;
    for k in 0..n {
        let law = &system.sliding[k];
        let u = product(&gather(&law.row), v) - law.target;
        impulses.sliding[k] = p[k];
        if law.rigid {
            if dependent[k] && tolerance < u.abs() && !(single && changed) {
                give_way(system, guess, k, u);
                changed = true;
            }
            continue;
        }
        let bound = law.bound + product(&gather(&law.slope), v);
        let (side, open) = corrected(guess.sliding[k], guess.open[k], p[k], u, bound, dependent[k], tolerance);
        if (side != guess.sliding[k] || open != guess.open[k]) && !(single && changed) {
            (guess.sliding[k], guess.open[k]) = (side, open);
            changed = true;
        }
    }
    changed
}

/// What a row would see if nothing stuck: the scale that tells a law that is held already from a free one. An upper bound of it
/// is enough, within the orders of magnitude between the two.
#[inline(always)]
fn scale_of<T: Scalar, const B: usize, const N: usize>(system: &System<T, B, N>, row: &[T; B]) -> T {
    let mut scale = T::ZERO;
    for i in 0..B {
        scale += row[i] * row[i] / system.a[i][i];
    }
    scale
}

/// Where a sliding contact stands after a guess gave it impulse p, velocity u and bound; the same again if that agrees.
#[inline(always)]
fn corrected<T: Scalar>(side: T, open: bool, p: T, u: T, bound: T, dependent: bool, tolerance: T) -> (T, bool) {
    let against = if T::ZERO < u { -T::ONE } else { T::ONE };
    if open {
        // Pressed after all: it slides against its velocity.
        return if T::ZERO < bound { (against, false) } else { (T::ZERO, true) };
    }
    if bound <= T::ZERO {
        return (T::ZERO, true);
    }
    if side == T::ZERO {
        if bound * (T::ONE + T::from_f64(8.0) * T::EPSILON) < p.abs() {
            return (if T::ZERO < p { T::ONE } else { -T::ONE }, false);
        }
        if dependent && tolerance < u.abs() {
            return (against, false);
        }
    } else if tolerance < side * u {
        return (T::ZERO, false);
    }
    (side, false)
}

/// An imposed velocity that the sticking laws do not admit: the one that stands most in its way slides, against the motion.
#[cold]
#[inline(never)]
fn give_way<T: Scalar, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    guess: &mut Guess<T, B, N>,
    rigid: usize,
    u: T,
) {
    let row = &system.sliding[rigid].row;
    // How much of the imposed motion a law sees, against its own mobility; A's diagonal is enough to choose by.
    let (mut most, mut holder, mut side) = (T::ZERO, None, T::ZERO);
    let mut compare = |index: usize, coupling: T, mobility: T| {
        let share = coupling * coupling / mobility;
        if most < share {
            (most, holder) = (share, Some(index));
            side = if T::ZERO < u * coupling { T::ONE } else { -T::ONE };
        }
    };
    for i in 0..B {
        if guess.pivot[i] == T::ZERO {
            compare(i, row[i] / system.a[i][i], T::ONE / system.a[i][i]);
        }
    }
    for k in 0..system.count {
        let law = &system.sliding[k];
        if guess.sliding[k] == T::ZERO && !law.rigid {
            let (mut coupling, mut mobility) = (T::ZERO, T::ZERO);
            for i in 0..B {
                coupling += row[i] * law.row[i] / system.a[i][i];
                mobility += law.row[i] * law.row[i] / system.a[i][i];
            }
            if T::ZERO < mobility {
                compare(B + k, coupling, mobility);
            }
        }
    }
    match holder {
        Some(i) if i < B => guess.pivot[i] = side,
        Some(k) => guess.sliding[k - B] = side,
        None => {}
    }
}

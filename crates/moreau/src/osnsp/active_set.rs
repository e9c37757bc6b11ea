//! Active set on the velocities: guess which laws stick, take the velocities that stick out of the system, solve it, correct
//! the guess, until it is right. The warm start is right in most steps, and then one factorisation is all; the Delassus
//! matrix is never formed.
//!
//! A sticking pivot's row and column are replaced by the identity's, so that its velocity is exactly zero (a held note does
//! not drift by rounding) and the loops keep their fixed size. Sliding contacts are few: they are condensed onto a system of
//! their own. Where guesses cycle, the exact dense solver takes over.

use super::delassus::Dense;
use super::relay::{eliminate, solve_dense};
use super::{Impulses, SolveReport, System};
use crate::Scalar;
use crate::linear::{factor, product, solve as solve_factored};

/// Guesses that correct every refuted law at once; usual problems need one or two, and what cycles does so from the start.
const GUESSES: u32 = 8;
/// Guesses that then correct only the first refuted law, which ends most cycles, before the exact dense solver takes over.
const SINGLE_GUESSES: u32 = 24;

/// Where a law stands: 0 sticks, +1 and -1 slide with p = +bound and -bound.
struct Guess<T, const B: usize, const N: usize> {
    pivot: [T; B],
    sliding: [T; N],
    /// Sliding laws whose bound falls to zero within the step, because the felt is left: p = 0, whatever the velocity.
    open: [bool; N],
}

/// Solves to `tolerance` on the laws' velocities; `limit` bounds the fallback.
#[inline(always)]
pub fn solve<T: Scalar, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    tolerance: T,
    limit: u32,
) -> ([T; B], SolveReport) {
    let mut guess = first_guess(system, impulses);
    for iterations in 1..=GUESSES + SINGLE_GUESSES {
        let (w, changed) = try_guess(system, &mut guess, impulses, tolerance, iterations > GUESSES);
        if !changed {
            return (w, SolveReport { converged: true, iterations });
        }
    }
    fall_back(system, impulses, tolerance, limit)
}

#[cold]
#[inline(never)]
fn fall_back<T: Scalar, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    tolerance: T,
    limit: u32,
) -> ([T; B], SolveReport) {
    let mut dense = Dense::new(system, impulses);
    let mut report = solve_dense(&dense.problem, &mut dense.impulse, tolerance, limit);
    report.iterations += GUESSES + SINGLE_GUESSES;
    (dense.finish(impulses), report)
}

/// What the warm start's impulses say: a law at its bound slides.
#[inline(always)]
fn first_guess<T: Scalar, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    impulses: &Impulses<T, B, N>,
) -> Guess<T, B, N> {
    let side = |p: T, bound: T| {
        if p >= bound {
            T::ONE
        } else if p <= -bound {
            -T::ONE
        } else {
            T::ZERO
        }
    };
    let mut guess = Guess { pivot: [T::ZERO; B], sliding: [T::ZERO; N], open: [false; N] };
    for i in 0..B {
        guess.pivot[i] = side(impulses.pivot[i], system.pivot_bound[i]);
    }
    for k in 0..system.count {
        let law = &system.sliding[k];
        guess.sliding[k] = if law.rigid { T::ZERO } else { side(impulses.sliding[k], law.bound) };
    }
    guess
}

/// Solves the system that a guess leaves, and corrects the guess where the solution refutes it; `single`: in one place only.
#[inline(always)]
fn try_guess<T: Scalar, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    guess: &mut Guess<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    tolerance: T,
    single: bool,
) -> ([T; B], bool) {
    let mut a = system.a;
    let mut w = system.b;
    for i in 0..B {
        impulses.pivot[i] = guess.pivot[i] * system.pivot_bound[i];
        w[i] += impulses.pivot[i];
        if guess.pivot[i] == T::ZERO {
            w[i] = T::ZERO;
            for j in 0..B {
                a[i][j] = T::ZERO;
                a[j][i] = T::ZERO;
            }
            a[i][i] = T::ONE;
        }
    }
    let inverse_d = factor(&mut a);
    w = solve_factored(&a, &inverse_d, &w);
    let mut changed = false;
    if system.count > 0 {
        changed = slide(system, guess, impulses, &a, &inverse_d, &mut w, tolerance, single);
    }
    for i in 0..B {
        if guess.pivot[i] == T::ZERO {
            let mut p = product(&system.a[i], &w) - system.b[i];
            for k in 0..system.count {
                p -= system.sliding[k].row[i] * impulses.sliding[k];
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
    (w, changed)
}

/// Sliding laws, condensed: adds their share to the velocities `w`, and corrects their guesses.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn slide<T: Scalar, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    guess: &mut Guess<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    factors: &[[T; B]; B],
    inverse_d: &[T; B],
    w: &mut [T; B],
    tolerance: T,
    single: bool,
) -> bool {
    let n = system.count;
    let mut columns = [[T::ZERO; B]; N];
    let mut matrix = [[T::ZERO; N]; N];
    let (mut rhs, mut p, mut diagonal) = ([T::ZERO; N], [T::ZERO; N], [T::ZERO; N]);
    for k in 0..n {
        let mut row = system.sliding[k].row;
        for i in 0..B {
            // What the row would see without sticking pivots: the scale that tells a held law from a free one.
            diagonal[k] += row[i] * row[i] / system.a[i][i];
            if guess.pivot[i] == T::ZERO {
                row[i] = T::ZERO;
            }
        }
        columns[k] = solve_factored(factors, inverse_d, &row);
    }
    for k in 0..n {
        let law = &system.sliding[k];
        let s = guess.sliding[k];
        if guess.open[k] {
            matrix[k][k] = T::ONE;
            diagonal[k] = T::ONE;
        } else if s == T::ZERO {
            // Sticking: row . (w + sum columns p) = target.
            rhs[k] = law.target - product(&law.row, w);
            for j in 0..n {
                matrix[k][j] = product(&law.row, &columns[j]);
            }
            p[k] = impulses.sliding[k];
        } else {
            // Sliding: p = s (bound + slope . (w + sum columns p)).
            rhs[k] = s * (law.bound + product(&law.slope, w));
            for j in 0..n {
                matrix[k][j] = -s * product(&law.slope, &columns[j]);
            }
            matrix[k][k] += T::ONE;
            diagonal[k] = T::ONE;
        }
    }
    let dependent = eliminate(&mut matrix, &mut rhs, &mut p, &diagonal, n);
    for k in 0..n {
        for i in 0..B {
            w[i] += columns[k][i] * p[k];
        }
    }
    let mut changed = false;
    for k in 0..n {
        let law = &system.sliding[k];
        let u = product(&law.row, w) - law.target;
        impulses.sliding[k] = p[k];
        if law.rigid {
            if dependent[k] && tolerance < u.abs() && !(single && changed) {
                give_way(system, guess, k, u);
                changed = true;
            }
            continue;
        }
        let bound = law.bound + product(&law.slope, w);
        let (side, open) = corrected(guess.sliding[k], guess.open[k], p[k], u, bound, dependent[k], tolerance);
        if (side != guess.sliding[k] || open != guess.open[k]) && !(single && changed) {
            (guess.sliding[k], guess.open[k]) = (side, open);
            changed = true;
        }
    }
    changed
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

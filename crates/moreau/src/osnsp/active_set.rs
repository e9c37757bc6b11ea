//! Active set on the velocities: guesses which laws stick, fixes these velocities, solves the system, and corrects the
//! guess until it is right. The warm start is right in most steps; one factorisation then suffices. The Delassus matrix
//! is never formed.
//!
//! Sticking pivots stay in the system with a huge inertia. The others then move as if those were not in it. The solver
//! sets the velocities of sticking pivots to zero exactly, so that a held note does not drift by rounding. Sliding
//! contacts are few: they are condensed onto a system of their own. Where guesses cycle, the exact dense solver takes
//! over.

use super::delassus::Dense;
use super::relay::{Elimination, is_dependent, solve_dense};
use super::system::{Guess, Impulses, SlidingLaw, System, lane_by_lane};
use crate::linear::{back_substitute, product, solve as solve_factored};
use crate::real::{Mask, Real, Scalar};

/// Guesses that correct every refuted law at once. Usual problems need one or two; a problem that cycles does so from
/// the start.
const GUESSES: u32 = 8;
/// Guesses that then correct only the first refuted law, which ends most cycles, before the exact dense solver takes
/// over.
const SINGLE_GUESSES: u32 = 24;

/// The sliding laws' own system, once the pivots are guessed, and what it is made from: workspace.
#[derive(Debug, Clone)]
pub(crate) struct Condensed<T: Real, const B: usize, const N: usize> {
    /// The factors of A for the joints that move.
    factors: [[T; B]; B],
    /// A^-1 row of every law.
    columns: [[T; B]; N],
    own: Elimination<T, N>,
}

impl<T: Real, const B: usize, const N: usize> Condensed<T, B, N> {
    pub(crate) fn new() -> Self {
        Condensed { factors: [[T::ZERO; B]; B], columns: [[T::ZERO; B]; N], own: Elimination::new() }
    }
}

#[inline(always)]
fn not_zero<T: Real>(x: T) -> T::Mask {
    T::ZERO.lt(x.abs())
}

#[inline(always)]
fn sign<T: Real>(x: T) -> T {
    T::select(T::ZERO.lt(x), T::ONE, -T::ONE)
}

/// Solves to `tolerance` on the laws' velocities, from a guess, which is corrected; `limit` bounds the fallback. `w`:
/// the relative velocities. Says which lanes converged, after how many guesses.
#[inline(always)]
pub(crate) fn solve<T: Real, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    guess: &mut Guess<T, B, N>,
    condensed: &mut Condensed<T, B, N>,
    tolerance: T,
    limit: u32,
    w: &mut [T; B],
) -> (T::Mask, u32) {
    let mut changed = T::Mask::splat(true);
    for iterations in 1..=GUESSES + SINGLE_GUESSES {
        changed = try_guess(system, guess, impulses, condensed, tolerance, iterations > GUESSES, w);
        if !changed.any() {
            return (T::Mask::splat(true), iterations);
        }
    }
    fall_back(system, impulses, guess, tolerance.lane(0), limit, w, changed)
}

#[cold]
#[inline(never)]
fn fall_back<T: Real, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    guess: &mut Guess<T, B, N>,
    tolerance: T::Lane,
    limit: u32,
    w: &mut [T; B],
    lanes: T::Mask,
) -> (T::Mask, u32) {
    let (solved, most) = lane_by_lane(system, impulses, guess, w, lanes, |system, own| {
        let mut dense = Dense::new(system, own);
        let report = solve_dense(&dense.problem, &mut dense.impulse, tolerance, limit);
        (dense.finish(own), report)
    });
    (solved, GUESSES + SINGLE_GUESSES + most)
}

/// Solves the system that a guess leaves, and corrects the guess where the solution refutes it; `single`: in one place
/// only. Says in which lanes it did.
#[inline(always)]
fn try_guess<T: Real, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    guess: &mut Guess<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    condensed: &mut Condensed<T, B, N>,
    tolerance: T,
    single: bool,
    w: &mut [T; B],
) -> T::Mask {
    for i in 0..B {
        impulses.pivot[i] = guess.pivot[i] * system.pivot_bound[i];
    }
    let (mut changed, moves) = velocities(system, guess, impulses, condensed, tolerance, single, w);
    // A w = b + p + sum row_k p_k: the impulse of a pivot that sticks is A w less the rest. This is minus the rest.
    let mut lacking = system.b.map(|b| -b);
    for k in 0..system.count {
        for i in 0..B {
            lacking[i] = lacking[i].sub_product(system.sliding[k].row[i], impulses.sliding[k]);
        }
    }
    // Usually no sliding pivot has reversed. With several lanes one test for all pivots is cheaper; with one lane, a
    // test per sliding pivot is.
    let turning = T::LANES > 1 && tolerance.lt(fastest(&guess.pivot, w)).any();
    for i in 0..B {
        let slides = not_zero(guess.pivot[i]);
        if !slides.all() {
            let p = if moves { lacking[i] + system.a.row_product(i, w) } else { lacking[i] };
            // A pivot that sticks has no impulse yet.
            impulses.pivot[i] += T::select(slides, T::ZERO, p);
            // p is a difference of loads, so it is rounded as they are. A pivot that holds just at its limit must not
            // begin to slide because of that.
            let rounding = T::from_f64(8.0) * T::EPSILON * (system.pivot_bound[i] + system.b[i].abs());
            let bound = system.pivot_bound[i] + rounding;
            let exceeded = slides.not().and(bound.lt(p.abs())).and(may_change::<T>(changed, single));
            if exceeded.any() {
                guess.pivot[i] = T::select(exceeded, sign(p), guess.pivot[i]);
                changed = changed.or(exceeded);
            }
        }
        let may_have_turned = if T::LANES > 1 { turning } else { slides.any() };
        if may_have_turned {
            let turned = slides.and(tolerance.lt(guess.pivot[i] * w[i])).and(T::ZERO.lt(system.pivot_bound[i]));
            let turned = turned.and(may_change::<T>(changed, single));
            if turned.any() {
                guess.pivot[i] = T::select(turned, T::ZERO, guess.pivot[i]);
                changed = changed.or(turned);
            }
        }
    }
    changed
}

/// The largest velocity that goes against a pivot's guess: positive where the pivot turns the way that its friction
/// pushes.
#[inline(always)]
fn fastest<T: Real, const B: usize>(guess: &[T; B], w: &[T; B]) -> T {
    let mut fastest = T::ZERO;
    for i in 0..B {
        fastest = fastest.max(guess[i] * w[i]);
    }
    fastest
}

/// In which lanes a guess may be corrected, when it has been corrected already in `changed`.
#[inline(always)]
fn may_change<T: Real>(changed: T::Mask, single: bool) -> T::Mask {
    if single { changed.not() } else { T::Mask::splat(true) }
}

/// A joint that sticks is held by so many times its own inertia: its share in the others' velocities is then below any
/// rounding.
const HELD: f64 = 1e20;

/// The velocities of the joints that move (the others stick: exactly zero) and the sliding laws' impulses. Corrects the
/// guesses of the sliding laws, and says in which lanes; and whether any joint moves in any lane.
#[inline(always)]
fn velocities<T: Real, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    guess: &mut Guess<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    condensed: &mut Condensed<T, B, N>,
    tolerance: T,
    single: bool,
    w: &mut [T; B],
) -> (T::Mask, bool) {
    let no = T::Mask::splat(false);
    let Condensed { factors, columns, own } = condensed;
    let (mut moves, mut diagonal, mut any) = ([T::ZERO; B], [T::ONE; B], no);
    for i in 0..B {
        let slides = not_zero(guess.pivot[i]);
        moves[i] = T::only(slides, T::ONE);
        diagonal[i] = system.a.diagonal[i] * T::select(slides, T::ONE, T::from_f64(HELD));
        any = any.or(slides);
    }
    let (free, spelt_out) = (any.any(), system.count == 1 && !system.sliding[0].rigid);
    let mut column = [T::ZERO; B];
    let mut inverse_d = [T::ZERO; B];
    *w = [T::ZERO; B];
    if free {
        for i in 0..B {
            w[i] = system.b[i] + impulses.pivot[i];
        }
        if spelt_out {
            column = system.sliding[0].row;
            inverse_d = system.a.factor(&diagonal, factors, [w, &mut column]);
            back_substitute(factors, &inverse_d, &mut column);
            only(&moves, &mut column);
        } else {
            inverse_d = system.a.factor(&diagonal, factors, [w]);
        }
        back_substitute(factors, &inverse_d, w);
        only(&moves, w);
    }
    if !free {
        return (all_stick(system, guess, impulses, tolerance, single), false);
    }
    if !spelt_out {
        for k in 0..system.count.min(N) {
            columns[k] = solve_factored(factors, &inverse_d, &system.sliding[k].row);
            only(&moves, &mut columns[k]);
        }
        return (slide(system, guess, impulses, columns, own, w, tolerance, single), true);
    }
    // The usual case of several laws, spelt out.
    let law = &system.sliding[0];
    let (side, open) = (guess.sliding[0], guess.open[0]);
    let slides = not_zero(side);
    let (mut numerator, mut denominator) = (T::ZERO, T::ONE);
    let mut dependent = no;
    if !slides.all() {
        let pivot = product(&law.row, &column);
        dependent = slides.not().and(is_dependent(pivot, scale_of(system, &law.row)));
        let sticking = dependent.or(slides).not();
        numerator = T::select(sticking, law.target - product(&law.row, w), impulses.sliding[0]);
        denominator = T::select(sticking, pivot, T::ONE);
    }
    if slides.any() {
        let sliding = side * (law.bound + product(&law.slope, w));
        numerator = T::select(slides, sliding, numerator);
        denominator = T::select(slides, T::ONE - side * product(&law.slope, &column), denominator);
    }
    let p = T::select(open, T::ZERO, numerator / denominator);
    for i in 0..B {
        w[i] = w[i].add_product(column[i], p);
    }
    impulses.sliding[0] = p;
    let found = Found::at(law, w, p, dependent);
    (correct(guess, 0, found, tolerance, T::Mask::splat(true)), true)
}

/// What a guess gave a sliding law: its impulse, velocity and bound, and whether the other sticking laws hold it
/// already.
struct Found<T: Real> {
    p: T,
    u: T,
    bound: T,
    dependent: T::Mask,
}

impl<T: Real> Found<T> {
    /// Of a law with impulse p where the joints move at `w`.
    #[inline(always)]
    fn at<const B: usize>(law: &SlidingLaw<T, B>, w: &[T; B], p: T, dependent: T::Mask) -> Self {
        let (u, bound) = (product(&law.row, w) - law.target, law.bound + product(&law.slope, w));
        Found { p, u, bound, dependent }
    }
}

/// x for the joints that move (1), zero for those that stick (0).
#[inline(always)]
fn only<T: Real, const B: usize>(moves: &[T; B], x: &mut [T; B]) {
    for i in 0..B {
        x[i] = x[i] * moves[i];
    }
}

/// Sliding laws, condensed: adds their share to the velocities `v`, and corrects their guesses.
#[inline(always)]
#[allow(clippy::too_many_arguments)]
fn slide<T: Real, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    guess: &mut Guess<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    columns: &[[T; B]; N],
    own: &mut Elimination<T, N>,
    v: &mut [T; B],
    tolerance: T,
    single: bool,
) -> T::Mask {
    let n = system.count.min(N);
    for k in 0..n {
        let (law, side, closed) = (&system.sliding[k], guess.sliding[k], guess.open[k].not());
        let (slides, sticks) = (closed.and(not_zero(side)), closed.and(not_zero(side).not()));
        own.clear_row(k, n);
        own.matrix[k][k] = T::select(sticks, T::ZERO, T::ONE);
        (own.right[k], own.x[k], own.scale[k]) = (T::ZERO, T::ZERO, T::ONE);
        if sticks.any() {
            // Sticking: row . (w + sum columns p) = target.
            own.right[k] = T::only(sticks, law.target - product(&law.row, v));
            for j in 0..n {
                own.matrix[k][j] += T::only(sticks, product(&law.row, &columns[j]));
            }
            own.x[k] = impulses.sliding[k] * T::only(sticks, T::ONE);
            own.scale[k] = T::select(sticks, scale_of(system, &law.row), T::ONE);
        }
        if slides.any() {
            // Sliding: p = s (bound + slope . (w + sum columns p)).
            own.right[k] += T::only(slides, side * (law.bound + product(&law.slope, v)));
            for j in 0..n {
                own.matrix[k][j] -= T::only(slides, side * product(&law.slope, &columns[j]));
            }
        }
    }
    own.eliminate(n);
    let Elimination { x: p, dependent, .. } = own;
    for k in 0..n {
        for r in 0..B {
            v[r] = v[r].add_product(columns[k][r], p[k]);
        }
    }
    let mut changed = T::Mask::splat(false);
    for k in 0..n {
        impulses.sliding[k] = p[k];
        let found = Found::at(&system.sliding[k], v, p[k], dependent[k]);
        changed = changed.or(correct_law(system, guess, k, found, tolerance, may_change::<T>(changed, single)));
    }
    changed
}

/// Sliding laws of a mechanism in which every pivot sticks, in every lane. A law that slides is at its bound; the
/// impulse of one that sticks is not determined, and keeps its value. Corrects the guesses.
#[inline(always)]
fn all_stick<T: Real, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    guess: &mut Guess<T, B, N>,
    impulses: &mut Impulses<T, B, N>,
    tolerance: T,
    single: bool,
) -> T::Mask {
    let mut changed = T::Mask::splat(false);
    for k in 0..system.count.min(N) {
        let (law, side, closed) = (&system.sliding[k], guess.sliding[k], guess.open[k].not());
        let sticks = closed.and(not_zero(side).not());
        let p = T::select(sticks, impulses.sliding[k], T::only(closed, side * law.bound));
        impulses.sliding[k] = p;
        let found = Found { p, u: -law.target, bound: law.bound, dependent: sticks };
        changed = changed.or(correct_law(system, guess, k, found, tolerance, may_change::<T>(changed, single)));
    }
    changed
}

/// Corrects where a sliding law stands, as [`correct`] does. A rigid drive that the sticking laws block releases one of
/// them.
#[inline(always)]
fn correct_law<T: Real, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    guess: &mut Guess<T, B, N>,
    k: usize,
    found: Found<T>,
    tolerance: T,
    allowed: T::Mask,
) -> T::Mask {
    if !system.sliding[k].rigid {
        return correct(guess, k, found, tolerance, allowed);
    }
    let blocked = found.dependent.and(tolerance.lt(found.u.abs())).and(allowed);
    for lane in (0..T::LANES).filter(|&l| blocked.lane(l)) {
        let mut own = guess.lane(lane);
        release_blocking_law(&system.lane(lane), &mut own, k, found.u.lane(lane));
        guess.set_lane(lane, &own);
    }
    blocked
}

/// The mobility that a row would have if nothing stuck. Against it a law that other sticking laws hold already has
/// none.
#[inline(always)]
fn scale_of<T: Real, const B: usize, const N: usize>(system: &System<T, B, N>, row: &[T; B]) -> T {
    let mut scale = T::ZERO;
    for i in 0..B {
        scale += row[i] * row[i] / system.a.diagonal[i];
    }
    scale
}

/// Corrects where a sliding contact stands, where a guess is refuted by what it gave and may be changed; says in which
/// lanes.
#[inline(always)]
fn correct<T: Real, const B: usize, const N: usize>(
    guess: &mut Guess<T, B, N>,
    k: usize,
    Found { p, u, bound, dependent }: Found<T>,
    tolerance: T,
    allowed: T::Mask,
) -> T::Mask {
    let (side, open) = (guess.sliding[k], guess.open[k]);
    let slides = not_zero(side);
    let pressed = T::ZERO.lt(bound);
    // Sticking beyond its bound, or held by nothing after all: it slides against its velocity.
    let exceeded = (bound * (T::ONE + T::from_f64(8.0) * T::EPSILON)).lt(p.abs());
    let loose = dependent.and(tolerance.lt(u.abs())).or(open);
    let if_sticking = T::select(exceeded, sign(p), T::only(loose, -sign(u)));
    let if_sliding = T::select(tolerance.lt(side * u), T::ZERO, side);
    let next = T::only(pressed, T::select(slides, if_sliding, if_sticking));
    let moved = not_zero(next - side).or(pressed.and(open)).or(pressed.or(open).not()).and(allowed);
    if moved.any() {
        guess.sliding[k] = T::select(moved, next, side);
        guess.open[k] = open.and(moved.not()).or(pressed.not().and(moved));
    }
    moved
}

/// The sticking laws do not admit a prescribed velocity: the one that blocks it most is released, and slides against
/// the motion.
#[cold]
#[inline(never)]
fn release_blocking_law<T: Scalar, const B: usize, const N: usize>(
    system: &System<T, B, N>,
    guess: &mut Guess<T, B, N>,
    rigid: usize,
    u: T,
) {
    let row = &system.sliding[rigid].row;
    // How much of the prescribed motion a law sees, against its own mobility; A's diagonal is enough to choose by.
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
            compare(i, row[i] / system.a.diagonal[i], T::ONE / system.a.diagonal[i]);
        }
    }
    for k in 0..system.count {
        let law = &system.sliding[k];
        if guess.sliding[k] == T::ZERO && !law.rigid {
            let (mut coupling, mut mobility) = (T::ZERO, T::ZERO);
            for i in 0..B {
                coupling += row[i] * law.row[i] / system.a.diagonal[i];
                mobility += law.row[i] * law.row[i] / system.a.diagonal[i];
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

//! Projected Gauss-Seidel on the friction cone: each contact in turn is solved exactly while the others keep their
//! impulses.
//!
//! Joints are eliminated first, so that sweeps pass over contacts and dry joints only. Every iterate is admissible,
//! p_n >= 0 and |p_t| <= mu p_n, and redundant contacts do not disturb. Now and then what the sweeps found serves as a
//! guess for the exact solver.

use super::eliminate::DEPENDENT;
use super::mixed::{Law, Limits, Mode, Problem, Solution};
use moreau::Scalar;

/// Sweeps between two guesses from them.
const SWEEPS: u32 = 10;
/// Corrections of such a guess.
const CORRECTIONS: u32 = 4;
/// After so many sweeps the guess is corrected one law at a time, so often at most.
const PATIENCE: u32 = 30;
const FLIPS: u32 = 60;
/// Mobilities below this part of the full one are none: joints hold the law's coordinate.
const HELD: f64 = 1e-12;

/// The problem after its equalities were eliminated.
#[derive(Debug, Clone)]
pub(super) struct Reduced<T, const N: usize> {
    /// Rows of laws: the reduced Delassus matrix. Rows of equalities: as they stood when they were eliminated.
    w: [[T; N]; N],
    free: [T; N],
    /// Equalities in the order in which they were eliminated.
    order: [usize; N],
    eliminated: usize,
    /// The laws that are left.
    left: [usize; N],
    count: usize,
}

impl<T: Scalar, const N: usize> Reduced<T, N> {
    pub(crate) fn new() -> Self {
        Reduced { w: [[T::ZERO; N]; N], free: [T::ZERO; N], order: [0; N], eliminated: 0, left: [0; N], count: 0 }
    }

    fn of(&mut self, problem: &Problem<T, N>) {
        let n = problem.count;
        for i in 0..n {
            self.w[i][..n].copy_from_slice(&problem.delassus[i][..n]);
        }
        self.free = problem.free;
        self.eliminated = 0;
        let mut done = [false; N];
        let mut largest = T::ZERO;
        loop {
            let (mut best, mut at) = (T::ZERO, None);
            for i in 0..n {
                if problem.law[i] == Law::Equality && !done[i] && self.w[i][i] > best {
                    (best, at) = (self.w[i][i], Some(i));
                }
            }
            largest = largest.max(best);
            let Some(k) = at.filter(|_| best > largest * T::from_f64(DEPENDENT).max(T::from_f64(16.0) * T::EPSILON))
            else {
                break;
            };
            done[k] = true;
            self.order[self.eliminated] = k;
            self.eliminated += 1;
            let pivot = self.w[k];
            for i in 0..n {
                if !done[i] && self.w[i][k] != T::ZERO {
                    let factor = self.w[i][k] / pivot[k];
                    for j in 0..n {
                        if !done[j] {
                            self.w[i][j] -= factor * pivot[j];
                        }
                    }
                    self.free[i] -= factor * self.free[k];
                }
            }
        }
        self.count = 0;
        for i in 0..n {
            if !matches!(problem.law[i], Law::Equality | Law::Absent) {
                self.left[self.count] = i;
                self.count += 1;
            }
        }
    }

    /// Impulses of the equalities from those of the others. Redundant equalities have none.
    fn close(&self, problem: &Problem<T, N>, p: &mut [T; N]) {
        for i in 0..problem.count {
            if problem.law[i] == Law::Equality {
                p[i] = T::ZERO;
            }
        }
        for k in (0..self.eliminated).rev() {
            let i = self.order[k];
            let mut s = self.free[i];
            for &j in self.left[..self.count].iter().chain(&self.order[k + 1..self.eliminated]) {
                s += self.w[i][j] * p[j];
            }
            p[i] = -(s / self.w[i][i]);
        }
    }

    fn velocity(&self, i: usize, p: &[T; N]) -> T {
        self.left[..self.count].iter().fold(self.free[i], |u, &j| u + self.w[i][j] * p[j])
    }
}

impl<T: Scalar, const N: usize> Problem<T, N> {
    /// Sweeps from a warm start, whose impulses need not be admissible. True if a guess from what was swept met every
    /// law; else the impulses are the best that were swept, admissible ones.
    #[cold]
    pub(crate) fn sweep(
        &self,
        mode: &mut [Mode; N],
        p: &mut [T; N],
        limits: &Limits<T>,
        reduced: &mut Reduced<T, N>,
        solution: &mut Solution<T>,
    ) -> bool {
        reduced.of(self);
        self.project(p);
        // Friction starts from nothing: what redundant contacts braced against each other in the last step would be
        // carried along for ever.
        for i in 0..self.count {
            if matches!(self.law[i], Law::Coulomb(..)) {
                p[i] = T::ZERO;
            }
        }
        let mut best = *p;
        reduced.close(self, &mut best);
        let mut least = self.residual(&best);
        for sweep in 1..=limits.sweeps {
            solution.sweeps += 1;
            let change = self.sweep_once(reduced, p, sweep % 2 == 0);
            let settled = change <= limits.tolerance * T::from_f64(0.1);
            if !(sweep % SWEEPS == 0 || settled || sweep == limits.sweeps) {
                continue;
            }
            let mut swept = *p;
            reduced.close(self, &mut swept);
            let residual = self.residual(&swept);
            if residual < least {
                (best, least) = (swept, residual);
            }
            // What the laws seem to do, solved exactly.
            let (mut guess, mut exact) = (*mode, swept);
            self.modes_of(&mut guess, &swept);
            // All refuted laws at once are quick, and may go round; one at a time is slow, and does not if the laws
            // alone would not (Murty).
            let patient = sweep == PATIENCE;
            for _ in 0..if patient { FLIPS } else { CORRECTIONS } {
                solution.guesses += 1;
                let consistent = self.impulses(&guess, &self.free, &mut exact, limits.tolerance);
                if !self.correct(&mut guess, &exact, limits.tolerance, !patient) && consistent {
                    (*mode, *p) = (guess, exact);
                    return true;
                }
                // Not it; but it may be nearer, and the sweeps go on from there.
                let mut nearer = exact;
                self.project(&mut nearer);
                reduced.close(self, &mut nearer);
                let residual = self.residual(&nearer);
                if residual < least {
                    (best, least) = (nearer, residual);
                    *p = nearer;
                }
            }
            if settled {
                break;
            }
        }
        *p = best;
        self.modes_of(mode, p);
        false
    }

    /// Onto the cones.
    fn project(&self, p: &mut [T; N]) {
        for i in 0..self.count {
            match self.law[i] {
                Law::Absent => p[i] = T::ZERO,
                Law::Equality => {}
                Law::Unilateral => p[i] = p[i].max(T::ZERO),
                Law::Relay(bound) => p[i] = p[i].max(-bound).min(bound),
                Law::Coulomb(n, mu) => {
                    let bound = mu * p[n].max(T::ZERO);
                    p[i] = p[i].max(-bound).min(bound);
                }
            }
        }
    }

    /// One sweep, forward or backward; the largest change of an impulse, as a velocity.
    fn sweep_once(&self, reduced: &Reduced<T, N>, p: &mut [T; N], backward: bool) -> T {
        let mut change = T::ZERO;
        for k in 0..reduced.count {
            let i = reduced.left[if backward { reduced.count - 1 - k } else { k }];
            match self.law[i] {
                Law::Relay(bound) => {
                    let w = reduced.w[i][i];
                    if w > self.delassus[i][i] * T::from_f64(HELD) {
                        let before = p[i];
                        p[i] = (before - reduced.velocity(i, p) / w).max(-bound).min(bound);
                        change = change.max((p[i] - before).abs() * w);
                    }
                }
                // A contact is solved with its friction, which stands right behind it.
                Law::Unilateral => {
                    let friction = match self.law.get(i + 1) {
                        Some(&Law::Coulomb(n, mu)) if n == i => Some((i + 1, mu)),
                        _ => None,
                    };
                    change = change.max(self.contact(reduced, p, i, friction));
                }
                _ => {}
            }
        }
        change
    }

    /// Solves one contact while all others keep their impulses; its change, as a velocity.
    fn contact(&self, reduced: &Reduced<T, N>, p: &mut [T; N], n: usize, friction: Option<(usize, T)>) -> T {
        let w = &reduced.w;
        let nn = w[n][n];
        if nn <= self.delassus[n][n] * T::from_f64(HELD) {
            return T::ZERO;
        }
        let Some((t, mu)) = friction else {
            let before = p[n];
            p[n] = (before - reduced.velocity(n, p) / nn).max(T::ZERO);
            return (p[n] - before).abs() * nn;
        };
        let before = [p[n], p[t]];
        let u = [reduced.velocity(n, p), reduced.velocity(t, p)];
        let (nt, tn, tt) = (w[n][t], w[t][n], w[t][t]);
        // Velocities without the contact's own impulses.
        let a = [u[0] - nn * before[0] - nt * before[1], u[1] - tn * before[0] - tt * before[1]];
        let found = local(a, [[nn, nt], [tn, tt]], mu, self.delassus[t][t] * T::from_f64(HELD));
        [p[n], p[t]] = found;
        ((found[0] - before[0]).abs() * nn).max((found[1] - before[1]).abs() * tt)
    }

    /// What the laws do with these impulses.
    fn modes_of(&self, mode: &mut [Mode; N], p: &[T; N]) {
        let most = (0..self.count).fold(T::ZERO, |most, i| most.max(p[i].abs()));
        let some = T::from_f64(64.0) * T::EPSILON;
        for i in 0..self.count {
            let bounded = |bound: T| {
                let slack = bound * T::from_f64(1e-9).max(some);
                if p[i] >= bound - slack {
                    Mode::Upper
                } else if p[i] <= slack - bound {
                    Mode::Lower
                } else {
                    Mode::Hold
                }
            };
            mode[i] = match self.law[i] {
                Law::Absent => Mode::Open,
                Law::Equality => Mode::Hold,
                Law::Unilateral if p[i] > most * some => Mode::Hold,
                Law::Unilateral => Mode::Open,
                Law::Relay(bound) => bounded(bound),
                Law::Coulomb(n, mu) if p[n] > most * some => bounded(mu * p[n]),
                Law::Coulomb(..) => Mode::Hold,
            };
        }
    }
}

/// One contact with friction alone: u = a + W p. If no mode is consistent, the normal law as it would be without
/// friction and friction projected onto its bound.
fn local<T: Scalar>(a: [T; 2], w: [[T; 2]; 2], mu: T, held: T) -> [T; 2] {
    let [[nn, nt], [tn, tt]] = w;
    if a[0] >= T::ZERO {
        return [T::ZERO; 2];
    }
    let det = nn * tt - nt * tn;
    let mut toward = if a[1] > T::ZERO { -T::ONE } else { T::ONE };
    if tt > held && det > nn * tt * T::from_f64(HELD) {
        let p = [(nt * a[1] - tt * a[0]) / det, (tn * a[0] - nn * a[1]) / det];
        if p[0] >= T::ZERO && p[1].abs() <= mu * p[0] {
            return p;
        }
        if p[0] > T::ZERO {
            toward = if p[1] > T::ZERO { T::ONE } else { -T::ONE };
        }
    }
    for side in [toward, -toward] {
        // Full friction, against a slip the other way.
        let mobility = nn + side * mu * nt;
        if mobility > nn * T::from_f64(HELD) {
            let normal = -(a[0] / mobility);
            let friction = side * mu * normal;
            if side * (a[1] + tn * normal + tt * friction) <= T::ZERO {
                return [normal, friction];
            }
        }
    }
    let normal = -(a[0] / nn);
    let bound = mu * normal;
    let friction = if tt > held { -((a[1] + tn * normal) / tt) } else { T::ZERO };
    [normal, friction.max(-bound).min(bound)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mixed::Solved;

    const CONTACTS: usize = 20;
    const N: usize = 2 * CONTACTS;

    /// A contact that jams when it slips the one way, does not slip the other, and cannot be held: the normal law as
    /// without friction.
    #[test]
    fn where_no_mode_is_consistent_the_normal_law_is_left() {
        assert_eq!(local([-1.0, 1.0], [[1.0, 2.0], [2.0, 0.0]], 0.6, 1e-9), [1.0, 0.0]);
        assert_eq!(local([0.5, 1.0], [[1.0, 0.0], [0.0, 1.0]], 0.6, 1e-9), [0.0, 0.0]);
        // Held; and sliding against full friction.
        assert_eq!(local([-1.0, 0.25], [[1.0, 0.0], [0.0, 1.0]], 0.5, 1e-9), [1.0, -0.25]);
        assert_eq!(local([-1.0, 2.0], [[1.0, 0.0], [0.0, 1.0]], 0.5, 1e-9), [1.0, -0.5]);
    }

    /// Twenty contacts of bodies with fifteen coordinates in all: redundant ones. Whatever a solve gives is admissible,
    /// its residual is what it says, and what is called solved meets the tolerance. Two sweeps are too few for some,
    /// two hundred leave a quarter of them at most (the rows are random, not those of bodies).
    #[test]
    fn impulses_are_admissible_whatever_the_limit() {
        let mut state = 7u64;
        let mut random = || {
            state ^= state >> 12;
            state ^= state << 25;
            state ^= state >> 27;
            (state.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        };
        let mut nearly = [0; 2];
        for _ in 0..60 {
            let mut problem = Problem::<f64, N>::new();
            problem.count = N;
            let mut g = [[0.0; 15]; N];
            for row in &mut g {
                // A contact concerns two bodies at most.
                for body in [0, 1].map(|_| ((random() + 1.0) * 2.5) as usize) {
                    for x in &mut row[3 * body..3 * body + 3] {
                        *x = random();
                    }
                }
            }
            let v0: [f64; 15] = core::array::from_fn(|_| random());
            for i in 0..N {
                problem.free[i] = (0..15).map(|k| g[i][k] * v0[k]).sum();
                problem.law[i] = if i % 2 == 0 { Law::Unilateral } else { Law::Coulomb(i - 1, 0.4) };
                for j in 0..N {
                    problem.delassus[i][j] = (0..15).map(|k| g[i][k] * g[j][k]).sum();
                }
            }
            for (few, sweeps) in [(0, 2), (1, 200)] {
                let (mut mode, mut p) = ([Mode::Hold; N], [0.0; N]);
                let limits = Limits { tolerance: 1e-10, guesses: 5000, sweeps };
                let solution = problem.solve(&mut mode, &mut p, &limits, &mut Reduced::new());
                for n in (0..N).step_by(2) {
                    assert!(p[n] >= 0.0 && p[n + 1].abs() <= 0.4 * p[n] + 1e-14, "{} {}", p[n], p[n + 1]);
                }
                assert_eq!(solution.residual, problem.residual(&p));
                match solution.solved {
                    Solved::Yes => assert!(solution.residual < 1e-9, "{solution:?}"),
                    _ => nearly[few] += 1,
                }
            }
        }
        assert!(nearly[0] > 0 && 4 * nearly[1] <= nearly[0], "{nearly:?}");
    }
}

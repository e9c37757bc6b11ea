//! The one-step problem of rigid bodies: u = u_free + W p with equalities, unilateral laws and friction at once.
//!
//! - equality: u = 0, any p;
//! - unilateral: 0 <= u, 0 <= p, u p = 0;
//! - relay: |p| <= bound, p = -bound sign(u) where u is not zero;
//! - Coulomb: as the relay, with bound = mu p_n, p_n the impulse of a unilateral law of the same step.
//!
//! Because the bound follows the normal impulse, the problem is not convex: it may have several solutions or none
//! (Painleve). The solver guesses the mode of every law, solves the linear system of the guess, and corrects the guess;
//! the result is exact. If guesses cycle, sweeps (`sweeps.rs`) supply a better one. If they fail too, and there are few
//! enough guesses, all are tried in order. The work is bounded, and every result is admissible: no contact pulls, and
//! no friction exceeds its cone.

use super::eliminate::eliminate;
use super::sweeps::Reduced;
use moreau::Scalar;

/// Corrected guesses before something else is done.
const GUESSES: u32 = 16;
/// If there are no more guesses than this, all are tried in order before there are sweeps.
const FEW: u32 = 100;

/// What a law is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Law<T> {
    /// None: a contact that is open, a joint without friction.
    Absent,
    /// u = 0.
    Equality,
    /// 0 <= u, 0 <= p, u p = 0.
    Unilateral,
    /// |p| <= bound, opposing u.
    Relay(T),
    /// |p| <= mu p_n, opposing u: (n, mu).
    Coulomb(usize, T),
}

/// Mode of a law.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// The velocity is zero: a joint, a closed contact, or friction that sticks.
    Hold,
    /// The impulse is zero: an open contact.
    Open,
    /// Friction slips with its largest impulse.
    Upper,
    /// Friction slips with its smallest (most negative) impulse.
    Lower,
}

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Solved {
    /// Every law is met.
    Yes,
    /// All guesses were tried, and none meets every law.
    None,
    /// Admissible impulses that miss some laws by the residual.
    Nearly,
}

/// Solver that found the impulses of a step.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum SolvedBy {
    /// Guesses of the modes, corrected from those of the previous step. Exact.
    Guesses,
    /// Projected Gauss-Seidel sweeps, then a guess that satisfied every law. Exact.
    SweptGuess,
    /// Enumeration of all guesses. Exact, or proof that there is no solution.
    Enumeration,
    /// Projected Gauss-Seidel sweeps only. Accurate to the residual.
    Sweeps,
}

/// How a solve went.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Solution<T> {
    pub solved: Solved,
    pub by: SolvedBy,
    pub guesses: u32,
    pub sweeps: u32,
    /// The largest amount, as a velocity, by which a law is missed.
    pub residual: T,
}

/// What a solve may do.
#[derive(Debug, Clone, Copy)]
pub(super) struct Limits<T> {
    /// Tolerance of velocities.
    pub tolerance: T,
    /// Guesses tried in order.
    pub guesses: u32,
    /// Sweeps.
    pub sweeps: u32,
}

/// The problem; only the first `count` laws are in use.
#[derive(Debug, Clone)]
pub(super) struct Problem<T, const N: usize> {
    pub count: usize,
    pub delassus: [[T; N]; N],
    pub free: [T; N],
    pub law: [Law<T>; N],
}

impl<T: Scalar, const N: usize> Problem<T, N> {
    pub(crate) fn new() -> Self {
        Problem { count: 0, delassus: [[T::ZERO; N]; N], free: [T::ZERO; N], law: [Law::Absent; N] }
    }

    /// u of law i at impulses p.
    pub(crate) fn velocity(&self, i: usize, free: &[T; N], p: &[T; N]) -> T {
        let mut u = free[i];
        for j in 0..self.count {
            u += self.delassus[i][j] * p[j];
        }
        u
    }

    /// Solves from a warm start, which it overwrites.
    pub(crate) fn solve(
        &self,
        mode: &mut [Mode; N],
        p: &mut [T; N],
        limits: &Limits<T>,
        reduced: &mut Reduced<T, N>,
    ) -> Solution<T> {
        let mut solution =
            Solution { solved: Solved::Yes, by: SolvedBy::Guesses, guesses: 0, sweeps: 0, residual: T::ZERO };
        let start = *p;
        self.admit(mode);
        if self.guess(mode, p, limits.tolerance, &mut solution.guesses) {
            solution.residual = self.residual(p);
            return solution;
        }
        *p = start;
        if self.guesses_at_most(FEW.min(limits.guesses)) {
            solution.by = SolvedBy::Enumeration;
            solution.solved = self.enumerate(mode, p, limits.tolerance, &mut solution.guesses);
            solution.residual = self.residual(p);
            return solution;
        }
        solution.by = SolvedBy::SweptGuess;
        if self.sweep(mode, p, limits, reduced, &mut solution) {
            solution.residual = self.residual(p);
            return solution;
        }
        let swept = self.residual(p);
        if swept > limits.tolerance && self.guesses_at_most(limits.guesses) {
            let (mut all, mut tried) = (*mode, *p);
            solution.by = SolvedBy::Enumeration;
            solution.solved = self.enumerate(&mut all, &mut tried, limits.tolerance, &mut solution.guesses);
            solution.residual = swept;
            if solution.solved == Solved::Yes {
                (*mode, *p) = (all, tried);
                solution.residual = self.residual(p);
            }
            return solution;
        }
        solution.by = SolvedBy::Sweeps;
        solution.solved = if swept <= limits.tolerance { Solved::Yes } else { Solved::Nearly };
        solution.residual = swept;
        solution
    }

    /// Corrects a guess until it meets every law; false if it was not met.
    fn guess(&self, mode: &mut [Mode; N], p: &mut [T; N], tolerance: T, guesses: &mut u32) -> bool {
        for _ in 0..GUESSES {
            *guesses += 1;
            let consistent = self.impulses(mode, &self.free, p, tolerance);
            if !self.correct(mode, p, tolerance, true) && consistent {
                return true;
            }
        }
        false
    }

    /// Whether there are so many guesses at most.
    fn guesses_at_most(&self, limit: u32) -> bool {
        let mut all = 1u32;
        for law in &self.law[..self.count] {
            all = all.saturating_mul(match law {
                Law::Absent | Law::Equality => 1,
                Law::Unilateral => 2,
                Law::Relay(_) | Law::Coulomb(..) => 3,
            });
        }
        all <= limit
    }

    /// The largest amount, as a velocity, by which impulses miss a law: u where it must be zero, else the distance of
    /// W_ii p from its projection after -u.
    pub(crate) fn residual(&self, p: &[T; N]) -> T {
        let mut most = T::ZERO;
        for i in 0..self.count {
            let w = self.delassus[i][i];
            let within = |bound: T| {
                let u = self.velocity(i, &self.free, p);
                // A law that nothing moves can only be missed by u.
                let at = (w * p[i] - u).max(-(w * bound)).min(w * bound);
                (w * p[i] - at).abs()
            };
            most = most.max(match self.law[i] {
                Law::Absent => T::ZERO,
                Law::Equality => self.velocity(i, &self.free, p).abs(),
                Law::Unilateral => {
                    let u = self.velocity(i, &self.free, p);
                    u.min(w * p[i]).abs()
                }
                Law::Relay(bound) => within(bound),
                Law::Coulomb(n, mu) => within(mu * p[n]),
            });
        }
        most
    }

    /// Turns modes that a law cannot have into ones that it can.
    fn admit(&self, mode: &mut [Mode; N]) {
        for i in 0..self.count {
            mode[i] = match (self.law[i], mode[i]) {
                (Law::Absent, _) => Mode::Open,
                (Law::Equality, _) => Mode::Hold,
                (Law::Unilateral, Mode::Upper | Mode::Lower) => Mode::Hold,
                (Law::Relay(_) | Law::Coulomb(..), Mode::Open) => Mode::Hold,
                (_, mode) => mode,
            };
        }
    }

    /// Whether a law's impulse is zero whatever its own mode: absent, open, or friction of an open contact.
    fn idle(&self, i: usize, mode: &[Mode; N]) -> bool {
        match self.law[i] {
            Law::Coulomb(n, _) => mode[n] == Mode::Open,
            _ => mode[i] == Mode::Open,
        }
    }

    /// The impulses of a guess: zero velocity of what holds, full friction of what slips. False if the guess has none.
    pub(crate) fn impulses(&self, mode: &[Mode; N], free: &[T; N], p: &mut [T; N], tolerance: T) -> bool {
        let n = self.count;
        let mut unknown = [0usize; N];
        // Where a law stands among the unknowns.
        let mut place = [usize::MAX; N];
        let mut m = 0;
        for i in 0..n {
            match (self.law[i], mode[i]) {
                _ if self.idle(i, mode) => p[i] = T::ZERO,
                (Law::Relay(bound), Mode::Upper) => p[i] = bound,
                (Law::Relay(bound), Mode::Lower) => p[i] = -bound,
                (Law::Coulomb(..), Mode::Upper | Mode::Lower) => {}
                _ => {
                    unknown[m] = i;
                    place[i] = m;
                    m += 1;
                }
            }
        }
        // Slipping Coulomb friction goes with its normal impulse: p_i = +-mu p_n.
        let share = |i: usize| match (self.law[i], mode[i]) {
            (Law::Coulomb(n, mu), Mode::Upper) if mode[n] != Mode::Open => Some((n, mu)),
            (Law::Coulomb(n, mu), Mode::Lower) if mode[n] != Mode::Open => Some((n, -mu)),
            _ => None,
        };
        let mut a = [[T::ZERO; N]; N];
        let mut rhs = [T::ZERO; N];
        let mut x = [T::ZERO; N];
        for (row, &i) in unknown[..m].iter().enumerate() {
            rhs[row] = -free[i];
            x[row] = p[i];
            for j in 0..n {
                match (self.law[j], mode[j]) {
                    (Law::Relay(_), Mode::Upper | Mode::Lower) => rhs[row] -= self.delassus[i][j] * p[j],
                    _ => {
                        let (to, factor) = share(j).unwrap_or((j, T::ONE));
                        if place[to] < m {
                            a[row][place[to]] += factor * self.delassus[i][j];
                        }
                    }
                }
            }
        }
        eliminate(&mut a, &mut rhs, &mut x, m);
        for (row, &i) in unknown[..m].iter().enumerate() {
            p[i] = x[row];
        }
        for i in 0..n {
            if let Some((normal, factor)) = share(i) {
                p[i] = factor * p[normal];
            }
        }
        unknown[..m].iter().all(|&i| self.velocity(i, free, p).abs() <= tolerance)
    }

    /// Moves laws whose guess is refuted: all of them, or the first one alone. Says whether there was one.
    pub(crate) fn correct(&self, mode: &mut [Mode; N], p: &[T; N], tolerance: T, all: bool) -> bool {
        let before = *mode;
        let mut changed = false;
        for i in 0..self.count {
            if changed && !all {
                break;
            }
            let u = self.velocity(i, &self.free, p);
            let bound = match self.law[i] {
                Law::Absent | Law::Equality => continue,
                Law::Unilateral => {
                    let next = match before[i] {
                        Mode::Open if u < -tolerance => Mode::Hold,
                        Mode::Hold if p[i] < T::ZERO => Mode::Open,
                        same => same,
                    };
                    changed |= next != before[i];
                    mode[i] = next;
                    continue;
                }
                Law::Relay(bound) => bound,
                Law::Coulomb(n, _) if before[n] == Mode::Open => {
                    // Not in force; should its contact close, it opposes the slip that there is.
                    mode[i] = opposing(u, tolerance);
                    continue;
                }
                Law::Coulomb(n, mu) => mu * p[n],
            };
            // Rounding in the bound must not turn a law that holds at its limit back and forth.
            let slack = bound.abs() * (T::from_f64(64.0) * T::EPSILON);
            let next = match before[i] {
                Mode::Hold if p[i] > bound + slack => Mode::Upper,
                Mode::Hold if p[i] < -bound - slack => Mode::Lower,
                Mode::Upper if u > tolerance => Mode::Hold,
                Mode::Lower if u < -tolerance => Mode::Hold,
                same => same,
            };
            changed |= next != before[i];
            mode[i] = next;
        }
        changed
    }

    /// Tries all guesses in order.
    #[cold]
    fn enumerate(&self, mode: &mut [Mode; N], p: &mut [T; N], tolerance: T, guesses: &mut u32) -> Solved {
        for i in 0..self.count {
            mode[i] = if self.law[i] == Law::Absent { Mode::Open } else { Mode::Hold };
        }
        loop {
            *guesses += 1;
            let consistent = self.impulses(mode, &self.free, p, tolerance);
            let mut corrected = *mode;
            if consistent && !self.correct(&mut corrected, p, tolerance, true) {
                return Solved::Yes;
            }
            if !self.next_guess(mode) {
                return Solved::None;
            }
        }
    }

    /// Counts on: the modes as digits of a number. False after the last one.
    fn next_guess(&self, mode: &mut [Mode; N]) -> bool {
        for i in 0..self.count {
            let next = match (self.law[i], mode[i]) {
                (Law::Unilateral, Mode::Hold) => Some(Mode::Open),
                (Law::Relay(_) | Law::Coulomb(..), Mode::Hold) => Some(Mode::Upper),
                (Law::Relay(_) | Law::Coulomb(..), Mode::Upper) => Some(Mode::Lower),
                _ => None,
            };
            match next {
                Some(next) => {
                    mode[i] = next;
                    return true;
                }
                None if self.law[i] != Law::Absent => mode[i] = Mode::Hold,
                None => {}
            }
        }
        false
    }

    /// Change of a contact's normal velocity per normal impulse while it slips with friction p_t = factor p_n,
    /// everything else doing what `mode` says; and its velocity without its impulses. Where both are negative, no
    /// finite force keeps it closed while it slips.
    pub(crate) fn slipping_mobility(&self, n: usize, t: usize, factor: T, mode: &[Mode; N], tolerance: T) -> (T, T) {
        let mut others = *mode;
        others[n] = Mode::Open;
        let mut p = [T::ZERO; N];
        self.impulses(&others, &self.free, &mut p, tolerance);
        let without = self.velocity(n, &self.free, &p);
        let mut free = [T::ZERO; N];
        for i in 0..self.count {
            free[i] = self.delassus[i][n] + factor * self.delassus[i][t];
            if matches!(self.law[i], Law::Relay(_)) && others[i] != Mode::Hold {
                // Full friction does not change with a small impulse.
                others[i] = Mode::Open;
            }
        }
        p = [T::ZERO; N];
        self.impulses(&others, &free, &mut p, tolerance);
        (self.velocity(n, &free, &p), without)
    }
}

/// The mode of friction that opposes a slip.
fn opposing<T: Scalar>(u: T, tolerance: T) -> Mode {
    if u > tolerance {
        Mode::Lower
    } else if u < -tolerance {
        Mode::Upper
    } else {
        Mode::Hold
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use moreau::osnsp::delassus::OneStepProblem;
    use moreau::osnsp::relay::solve_dense;

    const N: usize = 8;

    /// Uniform in [-1, 1], xorshift64*.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 ^= self.0 >> 12;
            self.0 ^= self.0 << 25;
            self.0 ^= self.0 >> 27;
            (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }
    }

    /// W = G G^T with `columns` random columns, u_free random.
    fn random_problem(count: usize, columns: usize, random: &mut Random) -> Problem<f64, N> {
        let mut problem = Problem::new();
        problem.count = count;
        let mut g = [[0.0; N]; N];
        for row in g.iter_mut().take(count) {
            for x in row.iter_mut().take(columns) {
                *x = random.next();
            }
        }
        for i in 0..count {
            problem.free[i] = random.next();
            for j in 0..count {
                problem.delassus[i][j] = (0..columns).map(|k| g[i][k] * g[j][k]).sum();
            }
        }
        problem
    }

    /// Friction with constant bounds alone has one solution, and it is the one that the relay solver finds.
    #[test]
    fn agrees_with_the_relay_solver() {
        let mut random = Random(11);
        for _ in 0..2000 {
            let mut problem = random_problem(6, 8, &mut random);
            let mut relay = OneStepProblem::<f64, N>::new();
            relay.count = 6;
            relay.delassus = problem.delassus;
            relay.free = problem.free;
            for i in 0..6 {
                let bound = 0.6 + 0.5 * random.next();
                problem.law[i] = Law::Relay(bound);
                relay.bound[i] = bound;
            }
            let (mut mode, mut p, mut expected) = ([Mode::Hold; N], [0.0; N], [0.0; N]);
            let limits = Limits { tolerance: 1e-12, guesses: 10_000, sweeps: 100 };
            assert_eq!(problem.solve(&mut mode, &mut p, &limits, &mut Reduced::new()).solved, Solved::Yes);
            assert!(solve_dense(&relay, &mut expected, 1e-12, 1000).converged);
            for i in 0..6 {
                assert!((p[i] - expected[i]).abs() < 1e-7, "{p:?} {expected:?}");
            }
        }
    }

    /// An equality, a dry joint and three contacts with friction, rank-deficient. Whatever is called solved satisfies
    /// every law, checked here from p and u alone. Where there is said to be no solution all guesses were tried; that
    /// is rare at friction of 0.3.
    #[test]
    fn solutions_satisfy_every_law() {
        let mut random = Random(5);
        let mut solved = 0;
        for _ in 0..2000 {
            let mut problem = random_problem(8, 7, &mut random);
            problem.law = [
                Law::Equality,
                Law::Relay(0.4),
                Law::Unilateral,
                Law::Coulomb(2, 0.3),
                Law::Unilateral,
                Law::Coulomb(4, 0.3),
                Law::Unilateral,
                Law::Coulomb(6, 0.3),
            ];
            let (mut mode, mut p) = ([Mode::Hold; N], [0.0; N]);
            let limits = Limits { tolerance: 1e-10, guesses: 5000, sweeps: 1000 };
            let solution = problem.solve(&mut mode, &mut p, &limits, &mut Reduced::new());
            assert_ne!(solution.solved, Solved::Nearly, "2 x 3 to the third times 3 guesses are all that there are");
            if solution.solved != Solved::Yes {
                continue;
            }
            solved += 1;
            let u: [f64; N] = core::array::from_fn(|i| problem.velocity(i, &problem.free, &p));
            let opposes = |i: usize, bound: f64| {
                assert!(p[i].abs() <= bound * (1.0 + 1e-12) + 1e-15, "law {i}: {} of {bound}", p[i]);
                assert!(u[i].abs() <= 2e-10 || (p[i] + bound * u[i].signum()).abs() <= 1e-12, "law {i}");
            };
            assert!(u[0].abs() <= 2e-10);
            opposes(1, 0.4);
            for n in [2, 4, 6] {
                assert!(p[n] >= 0.0 && u[n] >= -2e-10 && (p[n] == 0.0 || u[n] <= 2e-10), "contact {n}");
                opposes(n + 1, 0.3 * p[n]);
            }
        }
        assert!(solved > 1900, "{solved} of 2000");
    }

    /// One law whose friction turns its normal mobility negative, held in slip: 1 - 2 mu < 0. No mode is admitted.
    #[test]
    fn says_that_there_is_no_solution() {
        let mut problem = Problem::<f64, N>::new();
        problem.count = 2;
        problem.delassus[0][..2].copy_from_slice(&[1.0, 2.0]);
        problem.delassus[1][..2].copy_from_slice(&[2.0, 4.0]);
        problem.free[..2].copy_from_slice(&[-1.0, 1.0]);
        problem.law[..2].copy_from_slice(&[Law::Unilateral, Law::Coulomb(0, 0.9)]);
        let (mut mode, mut p) = ([Mode::Hold; N], [0.0; N]);
        let limits = Limits { tolerance: 1e-12, guesses: 1000, sweeps: 100 };
        let solution = problem.solve(&mut mode, &mut p, &limits, &mut Reduced::new());
        assert_eq!(solution.solved, Solved::None);
        assert!(solution.guesses < 200 && solution.residual > 0.1, "{solution:?}");
    }
}

//! The one-step problem of rigid bodies: u = u_free + W p with equalities, unilateral laws and friction at once.
//!
//! - equality: u = 0, any p;
//! - unilateral: 0 <= u, 0 <= p, u p = 0;
//! - relay: |p| <= bound, p = -bound sign(u) where u is not zero;
//! - Coulomb: the same with bound = mu p_n, p_n the impulse of a unilateral law of the same step.
//!
//! Because the bound follows the normal impulse the problem is not a convex one: it may have several solutions or none
//! (Painleve). It is solved exactly, by guessing what every law does, solving the linear system that the guess leaves and
//! correcting the guess; where guesses cycle, all of them are tried in order. Both are bounded.

use crate::Scalar;

/// Corrected guesses before all are tried in order.
const GUESSES: u32 = 16;
/// Pivots below this part of the largest entry mean a law that the others hold already.
const DEPENDENT: f64 = 1e-11;

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

/// What a law does.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Mode {
    /// Its velocity is zero: a joint, a closed contact, friction that sticks.
    Hold,
    /// No impulse: an open contact.
    Open,
    /// Slips, with the largest impulse.
    Upper,
    /// Slips, with the smallest one.
    Lower,
}

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Solved {
    /// Every law is met.
    Yes,
    /// All guesses were tried, and none meets every law.
    None,
    /// The limit was reached before all guesses were tried.
    Limit,
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
    pub fn new() -> Self {
        Problem { count: 0, delassus: [[T::ZERO; N]; N], free: [T::ZERO; N], law: [Law::Absent; N] }
    }

    /// u of law i at impulses p.
    fn velocity(&self, i: usize, free: &[T; N], p: &[T; N]) -> T {
        let mut u = free[i];
        for j in 0..self.count {
            u += self.delassus[i][j] * p[j];
        }
        u
    }

    /// Solves from a warm start, which it overwrites. Velocities may miss by `tolerance`. Returns the number of guesses too.
    pub fn solve(&self, mode: &mut [Mode; N], p: &mut [T; N], tolerance: T, limit: u32) -> (Solved, u32) {
        self.admit(mode);
        for guess in 1..=GUESSES.min(limit) {
            let consistent = self.impulses(mode, &self.free, p, tolerance);
            if !self.correct(mode, p, tolerance) && consistent {
                return (Solved::Yes, guess);
            }
        }
        self.enumerate(mode, p, tolerance, limit)
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
    fn impulses(&self, mode: &[Mode; N], free: &[T; N], p: &mut [T; N], tolerance: T) -> bool {
        let n = self.count;
        let mut unknown = [0usize; N];
        let mut m = 0;
        for i in 0..n {
            match (self.law[i], mode[i]) {
                _ if self.idle(i, mode) => p[i] = T::ZERO,
                (Law::Relay(bound), Mode::Upper) => p[i] = bound,
                (Law::Relay(bound), Mode::Lower) => p[i] = -bound,
                (Law::Coulomb(..), Mode::Upper | Mode::Lower) => {}
                _ => {
                    unknown[m] = i;
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
                        if let Some(column) = unknown[..m].iter().position(|&k| k == to) {
                            a[row][column] += factor * self.delassus[i][j];
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

    /// Moves every law whose guess is refuted; says whether there was one.
    fn correct(&self, mode: &mut [Mode; N], p: &[T; N], tolerance: T) -> bool {
        let before = *mode;
        let mut changed = false;
        for i in 0..self.count {
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
    fn enumerate(&self, mode: &mut [Mode; N], p: &mut [T; N], tolerance: T, limit: u32) -> (Solved, u32) {
        for i in 0..self.count {
            mode[i] = if self.law[i] == Law::Absent { Mode::Open } else { Mode::Hold };
        }
        let mut tried = GUESSES.min(limit);
        while tried < limit {
            tried += 1;
            let consistent = self.impulses(mode, &self.free, p, tolerance);
            let mut corrected = *mode;
            if consistent && !self.correct(&mut corrected, p, tolerance) {
                return (Solved::Yes, tried);
            }
            if !self.next_guess(mode) {
                return (Solved::None, tried);
            }
        }
        (Solved::Limit, tried)
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

    /// Change of a contact's normal velocity per normal impulse while it slips with friction p_t = factor p_n, everything else
    /// doing what `mode` says. Where that is not positive, no finite force keeps the contact closed while it slips.
    pub fn slipping_mobility(&self, n: usize, t: usize, factor: T, mode: &[Mode; N], tolerance: T) -> T {
        let mut others = *mode;
        others[n] = Mode::Open;
        let mut free = [T::ZERO; N];
        for i in 0..self.count {
            free[i] = self.delassus[i][n] + factor * self.delassus[i][t];
            if matches!(self.law[i], Law::Relay(_)) && others[i] != Mode::Hold {
                // Full friction does not change with a small impulse.
                others[i] = Mode::Open;
            }
        }
        let mut p = [T::ZERO; N];
        self.impulses(&others, &free, &mut p, tolerance);
        self.velocity(n, &free, &p)
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

/// Gaussian elimination with complete pivoting of the first `m` rows and columns. Unknowns that the others determine already keep
/// the value that `x` came with.
pub(super) fn eliminate<T: Scalar, const N: usize>(a: &mut [[T; N]; N], rhs: &mut [T; N], x: &mut [T; N], m: usize) {
    let mut column: [usize; N] = core::array::from_fn(|k| k);
    let mut largest = T::ZERO;
    let mut rank = 0;
    while rank < m {
        let (mut best, mut at) = (T::ZERO, (rank, rank));
        for i in rank..m {
            for j in rank..m {
                if best < a[i][j].abs() {
                    (best, at) = (a[i][j].abs(), (i, j));
                }
            }
        }
        largest = largest.max(best);
        if best <= largest * T::from_f64(DEPENDENT).max(T::from_f64(16.0) * T::EPSILON) {
            break;
        }
        a.swap(rank, at.0);
        rhs.swap(rank, at.0);
        for row in a.iter_mut().take(m) {
            row.swap(rank, at.1);
        }
        column.swap(rank, at.1);
        for i in rank + 1..m {
            let factor = a[i][rank] / a[rank][rank];
            for j in rank..m {
                let t = a[rank][j];
                a[i][j] -= factor * t;
            }
            let t = rhs[rank];
            rhs[i] -= factor * t;
        }
        rank += 1;
    }
    for k in (0..rank).rev() {
        let mut s = rhs[k];
        for j in k + 1..m {
            s -= a[k][j] * x[column[j]];
        }
        x[column[k]] = s / a[k][k];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::osnsp::delassus::OneStepProblem;
    use crate::osnsp::relay::solve_dense;

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
            assert_eq!(problem.solve(&mut mode, &mut p, 1e-12, 10_000).0, Solved::Yes);
            assert!(solve_dense(&relay, &mut expected, 1e-12, 1000).converged);
            for i in 0..6 {
                assert!((p[i] - expected[i]).abs() < 1e-7, "{p:?} {expected:?}");
            }
        }
    }

    /// An equality, a dry joint and three contacts with friction, rank-deficient. Whatever is called solved satisfies every law,
    /// checked here from p and u alone. Where there is said to be no solution all guesses were tried; that is rare at friction of 0.3.
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
            let (outcome, guesses) = problem.solve(&mut mode, &mut p, 1e-10, 5000);
            assert_ne!(outcome, Solved::Limit, "2 x 3 to the third times 3 guesses are all that there are, {guesses}");
            if outcome != Solved::Yes {
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
        let (outcome, guesses) = problem.solve(&mut mode, &mut p, 1e-12, 1000);
        assert_eq!(outcome, Solved::None);
        assert!(guesses < 30, "{guesses}");
    }
}

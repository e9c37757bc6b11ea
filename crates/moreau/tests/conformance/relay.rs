//! Problem 7: the one-step problem alone.
//!
//! Problems are built around a known answer z: free laws get a residual velocity of zero, laws at a bound get one of the right
//! sign, and u_free = u - W z. W = G^T G is positive definite, badly conditioned or rank-deficient by choice.

use moreau::osnsp::delassus::OneStepProblem;
use moreau::osnsp::projected_gauss_seidel;
use moreau::osnsp::relay::solve_dense;

const N: usize = 16;

/// A small deterministic generator (xorshift64*), uniform in [-1, 1].
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_F491_4F6C_DD1D) >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Random orthogonal columns by Gram-Schmidt, so that the spectrum of W can be prescribed.
fn orthogonal(n: usize, random: &mut Random) -> Vec<Vec<f64>> {
    let mut q: Vec<Vec<f64>> = Vec::new();
    while q.len() < n {
        let mut v: Vec<f64> = (0..n).map(|_| random.next()).collect();
        for _ in 0..2 {
            for u in &q {
                let d: f64 = u.iter().zip(&v).map(|(a, b)| a * b).sum();
                v.iter_mut().zip(u).for_each(|(x, y)| *x -= d * y);
            }
        }
        let norm = v.iter().map(|x| x * x).sum::<f64>().sqrt();
        if norm > 1e-3 {
            q.push(v.iter().map(|x| x / norm).collect());
        }
    }
    q
}

struct Relay {
    problem: OneStepProblem<f64, N>,
    answer: [f64; N],
}

fn relay(n: usize, rank: usize, condition: f64, random: &mut Random) -> Relay {
    let q = orthogonal(n, random);
    let mut problem = OneStepProblem::new();
    problem.count = n;
    for (k, column) in q.iter().enumerate().take(rank) {
        let eigenvalue = condition.powf(-(k as f64) / (rank.max(2) - 1) as f64);
        for i in 0..n {
            for j in 0..n {
                problem.delassus[i][j] += eigenvalue * column[i] * column[j];
            }
        }
    }
    let (mut answer, mut u) = ([0.0; N], [0.0; N]);
    for i in 0..n {
        problem.bound[i] = 1.5 + random.next();
        match (random.next() * 1.5).round() as i32 {
            0 => answer[i] = 0.9 * problem.bound[i] * random.next(),
            s => {
                answer[i] = f64::from(s.signum()) * problem.bound[i];
                u[i] = -f64::from(s.signum()) * (1.1 + random.next());
            }
        }
    }
    for i in 0..n {
        problem.free[i] = u[i] - (0..n).map(|j| problem.delassus[i][j] * answer[j]).sum::<f64>();
    }
    Relay { problem, answer }
}

/// The default solver finds z of 1 to 15 unknowns, to 1e7 of condition, within a few dozen active sets. The error of z may be
/// the rounding of the data (1e-16 times a few) times the condition number.
#[test]
fn exact_solver_finds_the_exact_answer() {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    let mut most = 0;
    for n in 1..=15 {
        for condition in [1.0, 1e3, 1e7] {
            for _ in 0..200 {
                let r = relay(n, n, condition, &mut random);
                let mut p = [0.0; N];
                let report = solve_dense(&r.problem, &mut p, 1e-12, 1000);
                assert!(report.converged, "{n} {condition}: error {}", r.problem.error(&p));
                most = most.max(report.iterations);
                for i in 0..n {
                    assert!((p[i] - r.answer[i]).abs() < 1e-14 * condition.max(100.0), "{n} {condition} law {i}");
                }
            }
        }
    }
    assert!(most <= 80, "work has grown: {most} active sets");
}

/// Rank-deficient W: z need not be unique, u is, and p must satisfy every law.
#[test]
fn exact_solver_solves_rank_deficient_problems() {
    let mut random = Random(42);
    for n in 2..=15 {
        for rank in 1..n {
            for _ in 0..50 {
                let r = relay(n, rank, 10.0, &mut random);
                let mut p = [0.0; N];
                let report = solve_dense(&r.problem, &mut p, 1e-10, 1000);
                assert!(report.converged, "{n} rank {rank}: error {}", r.problem.error(&p));
                for i in 0..n {
                    let expected = r.problem.velocity_at(i, &r.answer);
                    assert!((r.problem.velocity_at(i, &p) - expected).abs() < 1e-8, "{n} rank {rank} law {i}");
                }
            }
        }
    }
}

/// The papers' method gets there too where the condition is mild, and needs tens of thousands of sweeps where it is not.
#[test]
fn gauss_seidel_agrees_and_is_slow_on_bad_conditions() {
    let mut random = Random(7);
    let mut worst = 0;
    for n in 1..=15 {
        for condition in [1.0, 100.0] {
            let r = relay(n, n, condition, &mut random);
            let mut p = [0.0; N];
            let report = projected_gauss_seidel::solve_dense(&r.problem, &mut p, 1e-13, 100_000);
            assert!(report.converged);
            for i in 0..n {
                assert!((p[i] - r.answer[i]).abs() < 1e-9, "{n} {condition} law {i}");
            }
        }
    }
    for _ in 0..20 {
        let r = relay(15, 15, 1e7, &mut random);
        let mut p = [0.0; N];
        worst = worst.max(projected_gauss_seidel::solve_dense(&r.problem, &mut p, 1e-13, 100_000).iterations);
    }
    assert!(worst > 10_000, "{worst} sweeps");
}

/// An infinite bound is an equality.
#[test]
fn infinite_bound_is_an_equality() {
    let mut random = Random(3);
    let mut r = relay(6, 6, 10.0, &mut random);
    r.problem.bound[2] = f64::INFINITY;
    for solve in [solve_dense::<f64, N>, projected_gauss_seidel::solve_dense::<f64, N>] {
        let mut p = [0.0; N];
        assert!(solve(&r.problem, &mut p, 1e-13, 10_000).converged);
        assert!(r.problem.velocity_at(2, &p).abs() < 1e-12);
    }
}

//! Problem 7: the one-step problem alone.
//!
//! Problems are built around a known answer z: free laws get a residual velocity of zero, laws at a bound get one of
//! the right sign, and u_free = u - W z. W = Q S Q^T has a prescribed spectrum, badly conditioned or rank-deficient by
//! choice.

use fastrand::Rng;
use moreau::osnsp::delassus::OneStepProblem;
use moreau::osnsp::projected_gauss_seidel;
use moreau::osnsp::relay::solve_dense;

use moreau_rigid::problems::{Expected, ProblemRow};

/// Most laws of a problem.
const N: usize = 16;

/// Random numbers, uniform in [-1, 1), the same every time.
struct Random(Rng);

impl Random {
    fn next(&mut self) -> f64 {
        2.0 * self.0.f64() - 1.0
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

/// Full rank at a condition number: the largest error of z, and the most active sets, over 200 problems of each size.
fn full_rank(condition: f64, random: &mut Random) -> [f64; 2] {
    let (mut worst, mut most) = (0.0_f64, 0);
    for n in 1..=15 {
        for _ in 0..200 {
            let r = relay(n, n, condition, random);
            let mut p = [0.0; N];
            let report = solve_dense(&r.problem, &mut p, 1e-12, 1000);
            if !report.converged {
                return [f64::NAN; 2];
            }
            most = most.max(report.iterations);
            for i in 0..n {
                worst = worst.max((p[i] - r.answer[i]).abs());
            }
        }
    }
    [worst, f64::from(most)]
}

/// Rank-deficient: z need not be unique, but the velocities are; returns their largest error.
fn deficient(random: &mut Random) -> f64 {
    let mut worst = 0.0_f64;
    for n in 2..=15 {
        for rank in 1..n {
            for _ in 0..50 {
                let r = relay(n, rank, 10.0, random);
                let mut p = [0.0; N];
                if !solve_dense(&r.problem, &mut p, 1e-10, 1000).converged {
                    return f64::NAN;
                }
                for i in 0..n {
                    worst = worst.max((r.problem.velocity_at(i, &p) - r.problem.velocity_at(i, &r.answer)).abs());
                }
            }
        }
    }
    worst
}

/// The papers' method: the largest error of z on mild problems, and the most sweeps on bad ones.
fn gauss_seidel(random: &mut Random) -> [f64; 2] {
    let mut worst = 0.0_f64;
    for n in 1..=15 {
        for condition in [1.0, 100.0] {
            let r = relay(n, n, condition, random);
            let mut p = [0.0; N];
            if !projected_gauss_seidel::solve_dense(&r.problem, &mut p, 1e-13, 100_000).converged {
                return [f64::NAN; 2];
            }
            for i in 0..n {
                worst = worst.max((p[i] - r.answer[i]).abs());
            }
        }
    }
    let mut most = 0;
    for _ in 0..20 {
        let r = relay(15, 15, 1e7, random);
        let mut p = [0.0; N];
        most = most.max(projected_gauss_seidel::solve_dense(&r.problem, &mut p, 1e-13, 100_000).iterations);
    }
    [worst, f64::from(most)]
}

/// An infinite bound is an equality: largest velocity there from both solvers.
fn equality(random: &mut Random) -> f64 {
    let mut r = relay(6, 6, 10.0, random);
    r.problem.bound[2] = f64::INFINITY;
    let mut worst = 0.0_f64;
    for solve in [solve_dense::<f64, N>, projected_gauss_seidel::solve_dense::<f64, N>] {
        let mut p = [0.0; N];
        if !solve(&r.problem, &mut p, 1e-13, 10_000).converged {
            return f64::NAN;
        }
        worst = worst.max(r.problem.velocity_at(2, &p).abs());
    }
    worst
}

pub(crate) fn rows() -> Vec<ProblemRow> {
    let mut random = Random(Rng::with_seed(0x9E37_79B9_7F4A_7C15));
    let mut rows = Vec::new();
    let mut most = 0.0_f64;
    for condition in [1.0, 1e3, 1e7] {
        let [worst, sets] = full_rank(condition, &mut random);
        most = if sets.is_nan() { sets } else { most.max(sets) };
        rows.push(ProblemRow::new(
            format!("3000 problems of 1 to 15 laws, condition {condition:.0e}: largest error of z"),
            "",
            0.0,
            worst,
            1e-14 * condition.max(100.0),
            "rounding of the data times the condition number",
        ));
    }
    rows.push(ProblemRow::bounded("the most active sets", Expected::AtMost(80.0), most, "work must not grow"));
    let worst = deficient(&mut random);
    rows.push(ProblemRow::new(
        "5250 rank-deficient problems: largest error of u",
        "",
        0.0,
        worst,
        1e-8,
        "z is not unique, u is",
    ));
    let [worst, sweeps] = gauss_seidel(&mut random);
    rows.push(ProblemRow::new(
        "Gauss-Seidel, mild problems: largest error of z",
        "",
        0.0,
        worst,
        1e-9,
        "its stopping tolerance",
    ));
    rows.push(ProblemRow::bounded(
        "Gauss-Seidel, condition 1e7: the most sweeps",
        Expected::AtLeast(10_000.0),
        sweeps,
        "why it is not the default",
    ));
    let worst = equality(&mut random);
    rows.push(ProblemRow::new(
        "an equality among six laws, both solvers: its velocity",
        "",
        0.0,
        worst,
        1e-12,
        "the solvers' tolerance",
    ));
    rows
}

//! The course of a fit: what leads to the impact, then all of it in coarse differences, then finely; and from elsewhere
//! again.

use fastrand::Rng;

use super::candidate::Candidate;
use super::doubts::doubts;
use super::ends::{Ended, alike, best_of};
use super::jacobian::DIFFERENCES;
use super::solver::{self, LeastSquares};
use super::svd::Columns;
use super::{Asked, FitError, FitResult, Jacobian, Loss, Problem};

/// The step of the first differences: long enough to look past what jumps.
const COARSE: f64 = 1e-2;
/// Most evaluations up to the impact, and of all of it in coarse differences.
const COARSE_MOST: [usize; 2] = [20, 15];
/// Beyond so many times the misfit that the sensors' noise explains, the fit begins again elsewhere.
const MISFIT: f64 = 1.03;
/// How far away the next one begins, as it is counted, and as a share of narrower bounds. From farther away in wide
/// bounds few come back.
const FAR: f64 = 0.2;
/// A point is better than where the solver ended if its log-likelihood is higher by so much.
const BETTER: f64 = 1e-3;
/// Rounds in which noise and parameters are estimated by turns.
const ROUNDS: usize = 3;

/// Settings of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Starting values, in SI units; other parameters start as in the instrument.
    pub start: Asked<f64>,
    /// Loss function of the last steps.
    pub loss: Loss,
    /// Derivatives of the last steps and of the covariance.
    pub jacobian: Jacobian,
    /// Number of times the fit may begin again elsewhere.
    pub restarts: usize,
    /// Most evaluations of one solution.
    pub most: usize,
}

impl Default for Plan {
    fn default() -> Self {
        Plan { start: Vec::new(), loss: Loss::Linear, jacobian: Jacobian::Differences, restarts: 5, most: 50 }
    }
}

/// Result of a solver.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Point, in the solver's coordinates.
    pub point: Vec<f64>,
    /// Mean square of the residuals there.
    pub misfit: f64,
    /// Why it ended, in words.
    pub message: String,
}

/// A problem with differences of one step.
struct Shared<'a>(&'a mut Problem, f64);

impl LeastSquares for Shared<'_> {
    type Error = FitError;

    fn residuals(&mut self, x: &[f64]) -> Result<Vec<f64>, FitError> {
        self.0.residuals(x)
    }

    fn jacobian(&mut self, x: &[f64]) -> Result<Columns, FitError> {
        self.0.jacobian(x, self.1)
    }
}

/// Minimises sums of squares between bounds.
pub trait Solver {
    /// From a point within the bounds, with so many evaluations of the residuals at most.
    ///
    /// # Errors
    /// Those of the problem; an interruption.
    fn solve(
        &mut self,
        problem: &mut dyn LeastSquares<Error = FitError>,
        from: &[f64],
        bounds: (&[f64], &[f64]),
        loss: Loss,
        most: usize,
    ) -> Result<Solution, FitError>;
}

/// The solver of this crate: a reflective trust region.
#[derive(Debug, Clone, Copy, Default)]
pub struct TrustRegion;

impl Solver for TrustRegion {
    fn solve(
        &mut self,
        problem: &mut dyn LeastSquares<Error = FitError>,
        from: &[f64],
        bounds: (&[f64], &[f64]),
        loss: Loss,
        most: usize,
    ) -> Result<Solution, FitError> {
        let found = solver::solve(problem, from, bounds, loss, most)?;
        Ok(Solution::new(found.x, &found.residuals, found.ended.words().to_owned()))
    }
}

impl Solution {
    /// A solution at a point, with the residuals there and the reason why the solver ended.
    pub fn new(point: Vec<f64>, residuals: &[f64], message: String) -> Self {
        let misfit = residuals.iter().map(|x| x * x).sum::<f64>() / residuals.len() as f64;
        Solution { point, misfit, message }
    }
}

/// A problem and who solves it.
struct Course<'a> {
    problem: &'a mut Problem,
    solver: &'a mut dyn Solver,
}

impl Course<'_> {
    /// Solves within the bounds, from a point, with differences of this step, and so many evaluations at most.
    fn solve(&mut self, from: &[f64], share: f64, loss: Loss, most: usize) -> Result<Solution, FitError> {
        let (low, high) = self.problem.bounds();
        self.solver.solve(&mut Shared(self.problem, share), from, (&low, &high), loss, most)
    }
}

/// Fits: the best point, and what speaks for it.
///
/// # Errors
/// A start that is none, what cannot be played there, an interruption.
pub fn fit(problem: &mut Problem, plan: &Plan) -> Result<FitResult, FitError> {
    fit_by(problem, plan, &mut TrustRegion)
}

/// [`fit()`] by a solver of the caller's.
///
/// # Errors
/// As of [`fit()`].
pub fn fit_by(problem: &mut Problem, plan: &Plan, solver: &mut dyn Solver) -> Result<FitResult, FitError> {
    problem.begin(plan.loss);
    let begin = start(problem, plan)?;
    problem.begun(&begin)?;
    let mut course = Course { problem, solver };
    let mut rng = Rng::with_seed(0);
    let mut ends: Vec<Candidate> = Vec::new();
    let mut message = String::new();
    for attempt in 0..=plan.restarts {
        let from = if attempt == 0 { begin.clone() } else { elsewhere(course.problem, &ends, &mut rng) };
        let (found, end) = course.attempt(&from, plan)?;
        if ends.iter().all(|other| end.score < other.score) {
            message = found.message;
        }
        ends.push(end);
        // Two that end alike, and leave no more than the sensors' noise, have found the place.
        let best = best_of(&ends);
        if alike(&ends, best).count() >= 2 && best.misfit <= MISFIT {
            break;
        }
    }
    if let Some(found) = course.polish(&ends, plan)? {
        message = found.message;
    }
    conclude(course.problem, message, ends)
}

/// Not far from the best end: from elsewhere in wide bounds few come back.
fn elsewhere(problem: &Problem, ends: &[Candidate], rng: &mut Rng) -> Vec<f64> {
    let (low, high) = problem.bounds();
    let mut from = best_of(ends).point.clone();
    for k in 0..problem.free.len() {
        from[k] += FAR * (high[k] - low[k]).min(1.0) * (2.0 * rng.f64() - 1.0);
    }
    problem.keep_inside(&mut from);
    from
}

impl Course<'_> {
    /// All stages from a point.
    fn attempt(&mut self, from: &[f64], plan: &Plan) -> Result<(Solution, Candidate), FitError> {
        // First what leads to the impact, which is smooth; then all of it, in steps that look past what jumps.
        self.problem.weights = Some(self.problem.until_the_impact(from)?);
        self.problem.forget();
        let found = self.solve(from, COARSE, Loss::SoftL1, COARSE_MOST[0])?;
        self.problem.weights = None;
        self.problem.forget();
        let found = self.solve(&found.point, COARSE, Loss::SoftL1, COARSE_MOST[1])?;
        let mut found = self.solve(&found.point, DIFFERENCES[1], plan.loss, plan.most)?;
        if self.problem.told.iter().any(Option::is_none) {
            // The noise that nothing tells is estimated with the parameters held and the other way round, until neither
            // moves.
            for _ in 0..ROUNDS {
                if self.problem.estimate_noise(&found.point)? {
                    break;
                }
                found = self.solve(&found.point, DIFFERENCES[1], plan.loss, plan.most)?;
            }
        }
        let end = self.problem.candidate(&found.point)?;
        Ok((found, end))
    }

    /// Solves again from the best point that was ever played, as long as that is better than where the solver ended.
    fn polish(&mut self, ends: &[Candidate], plan: &Plan) -> Result<Option<Solution>, FitError> {
        let mut last = None;
        let mut ended = best_of(ends).score;
        for _ in 0..ROUNDS {
            let from = self.problem.best()?.clone();
            self.problem.estimate_noise(&from.point)?;
            if from.score > ended - BETTER {
                break;
            }
            let found = self.solve(&from.point, DIFFERENCES[1], plan.loss, plan.most)?;
            ended = self.problem.candidate(&found.point)?.score;
            last = Some(found);
        }
        Ok(last)
    }
}

/// Where a fit begins, as parameters are counted: within the bounds, where the instrument can be played.
fn start(problem: &mut Problem, plan: &Plan) -> Result<Vec<f64>, FitError> {
    if let Some((name, _)) = plan.start.iter().find(|(name, _)| problem.free.iter().all(|one| one.name != *name)) {
        return Err(FitError::asked("start", format!("{name} is not varied")));
    }
    let mut begin = Vec::with_capacity(problem.free.len());
    for one in &problem.free {
        let asked = plan.start.iter().find(|(name, _)| *name == one.name).map(|(_, x)| *x);
        if let Some(x) = asked.filter(|x| !(one.low..=one.high).contains(x)) {
            let message = format!("{} at {x}; its bounds are {} and {}", one.name, one.low, one.high);
            return Err(FitError::asked("start", message));
        }
        begin.push(one.inner(asked.unwrap_or(one.nothing())));
    }
    begin.resize(begin.len() + problem.delays(), 0.0);
    problem.keep_inside(&mut begin);
    if Problem::is_unplayable(&problem.residuals(&begin)?) {
        return Err(FitError::Unplayable);
    }
    if plan.jacobian == Jacobian::Gradient {
        problem.use_gradient(&begin)?;
    }
    Ok(begin)
}

/// The Jacobian at the best point that was ever played, how far that depends on its steps, and all that follows.
fn conclude(problem: &mut Problem, message: String, ends: Vec<Candidate>) -> Result<FitResult, FitError> {
    let point = problem.best()?.point.clone();
    problem.estimate_noise(&point)?;
    let disturbed = problem.drive_noise(&point)?;
    problem.forget();
    let jacobian = problem.jacobian(&point, DIFFERENCES[1])?;
    let wide = problem.by_differences(&point, DIFFERENCES[0])?;
    let other = if problem.exact { jacobian.clone() } else { problem.by_differences(&point, DIFFERENCES[2])? };
    let residuals = problem.residuals(&point)?;
    let found = Ended { point, message, residuals, agreement: agreement(&wide, &other), ends };
    let mut result = FitResult::new(problem, &found, &jacobian, &disturbed);
    result.doubts = doubts(problem, &result, &disturbed)?;
    result.meanings = problem.meanings(&result)?;
    result.evaluations = problem.evaluations;
    Ok(result)
}

/// The largest relative difference between columns of two Jacobians.
fn agreement(one: &[Vec<f64>], other: &[Vec<f64>]) -> f64 {
    let of = |(one, other): (&Vec<f64>, &Vec<f64>)| {
        let apart = one.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let size = super::svd::norm(other);
        apart / if size > 0.0 { size } else { 1.0 }
    };
    one.iter().zip(other).map(of).fold(0.0, f64::max)
}

//! Stages of a fit: up to the impact, then all rows with coarse differences, then with fine ones; repeated from other
//! starts.

use fastrand::Rng;

use super::candidate::Candidate;
use super::doubts::doubts;
use super::ends::{Ended, alike, best_of};
use super::jacobian::DIFFERENCES;
use super::solver::{self, LeastSquares};
use super::svd::Columns;
use super::{Asked, FitError, FitResult, Jacobian, Loss, Problem};

/// Step of the first differences: long enough to smooth over jumps.
const COARSE: f64 = 1e-2;
/// Most evaluations in the stage up to the impact, and in the coarse stage over all rows.
const COARSE_MOST: [usize; 2] = [20, 15];
/// Beyond this many times the misfit explained by the sensors' noise, the fit starts again elsewhere.
const MISFIT: f64 = 1.03;
/// Largest distance of the next start, in inner coordinates, and as a share of narrower bounds. From farther away in
/// wide bounds few attempts return.
const FAR: f64 = 0.2;
/// A point is better than the solver's end if its log-likelihood is higher by this.
const BETTER: f64 = 1e-3;
/// Rounds of alternating estimates of noise and parameters.
const ROUNDS: usize = 3;

/// Settings of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Starting values, in SI units; other parameters start as in the instrument.
    pub start: Asked<f64>,
    /// Loss function of the last steps.
    pub loss: Loss,
    /// Method for derivatives in the last steps and in the covariance.
    pub jacobian: Jacobian,
    /// Number of restarts elsewhere.
    pub restarts: usize,
    /// Most evaluations per solution.
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
    /// Reason why it ended, in words.
    pub message: String,
}

/// A problem with one difference step.
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
    /// Starts at a point within the bounds and uses at most `most` evaluations of the residuals.
    ///
    /// # Errors
    /// Errors of the problem; an interruption.
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
    /// Makes a solution from a point, its residuals and the reason why the solver ended.
    pub fn new(point: Vec<f64>, residuals: &[f64], message: String) -> Self {
        let misfit = residuals.iter().map(|x| x * x).sum::<f64>() / residuals.len() as f64;
        Solution { point, misfit, message }
    }
}

/// A problem and its solver.
struct Course<'a> {
    problem: &'a mut Problem,
    solver: &'a mut dyn Solver,
}

impl Course<'_> {
    /// Solves from a point within the bounds, with this difference step and at most `most` evaluations.
    fn solve(&mut self, from: &[f64], share: f64, loss: Loss, most: usize) -> Result<Solution, FitError> {
        let (low, high) = self.problem.bounds();
        self.solver.solve(&mut Shared(self.problem, share), from, (&low, &high), loss, most)
    }
}

/// Fits the free parameters to the recordings.
///
/// # Errors
/// An invalid start, a start that cannot be played, an interruption.
pub fn fit(problem: &mut Problem, plan: &Plan) -> Result<FitResult, FitError> {
    fit_by(problem, plan, &mut TrustRegion)
}

/// [`fit()`] with the caller's solver.
///
/// # Errors
/// See [`fit()`].
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
        // Two attempts that end alike, with no more misfit than the sensors' noise, have found the minimum.
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

/// Returns a start near the best end: from farther away in wide bounds few attempts return.
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
    /// Runs all stages from a point.
    fn attempt(&mut self, from: &[f64], plan: &Plan) -> Result<(Solution, Candidate), FitError> {
        // First the smooth motion up to the impact; then all rows, with steps that smooth over jumps.
        self.problem.weights = Some(self.problem.until_the_impact(from)?);
        self.problem.forget();
        let found = self.solve(from, COARSE, Loss::SoftL1, COARSE_MOST[0])?;
        self.problem.weights = None;
        self.problem.forget();
        let found = self.solve(&found.point, COARSE, Loss::SoftL1, COARSE_MOST[1])?;
        let mut found = self.solve(&found.point, DIFFERENCES[1], plan.loss, plan.most)?;
        if self.problem.told.iter().any(Option::is_none) {
            // Estimates unknown noise and parameters in turn until neither changes.
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

    /// Solves again from the best point ever played, as long as it is better than the solver's end.
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

/// Returns the start in inner coordinates, within the bounds and playable.
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

/// Computes the Jacobian at the best point ever played, its dependence on the difference step, and the result.
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

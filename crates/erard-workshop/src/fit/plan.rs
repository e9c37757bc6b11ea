//! The course of a fit: what leads to the blow, then all of it in coarse differences, then finely; and from elsewhere
//! again.

use fastrand::Rng;

use super::drive_noise::Disturbed;
use super::jacobian::DIFFERENCES;
use super::solver::{self, LeastSquares};
use super::svd::Columns;
use super::{Asked, FitError, FitResult, Jacobian, Loss, Problem};

/// The step of the first differences: long enough to look past what jumps.
const COARSE: f64 = 1e-2;
/// Most evaluations up to the blow, and of all of it in coarse differences.
const COARSE_MOST: [usize; 2] = [20, 15];
/// Beyond so many times the misfit that the sensors' noise explains, the fit begins again elsewhere.
const MISFIT: f64 = 1.03;
/// Two fits whose misfits differ by less have ended at the same place.
const AGREED: f64 = 1.005;
/// How far away the next one begins, as it is counted, and as a share of narrower bounds. From farther away in wide
/// bounds few come back.
const FAR: f64 = 0.2;
/// Rounds in which noise and parameters are estimated by turns.
const ROUNDS: usize = 3;

/// What is asked for.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Where to begin, outside; what is not named begins as the instrument has it.
    pub start: Asked<f64>,
    /// What is made of squares in the last steps.
    pub loss: Loss,
    /// Where the derivatives of the last steps and of the covariance come from.
    pub jacobian: Jacobian,
    /// How often the fit may begin again elsewhere.
    pub restarts: usize,
    /// Most evaluations of one solution.
    pub most: usize,
}

impl Default for Plan {
    fn default() -> Self {
        Plan { start: Vec::new(), loss: Loss::Linear, jacobian: Jacobian::Differences, restarts: 5, most: 50 }
    }
}

/// What a solver found.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// Where, as parameters are counted.
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

/// Solves a problem within its bounds, from a point, with differences of this step, and so many evaluations at most.
fn solve(problem: &mut Problem, from: &[f64], share: f64, loss: Loss, most: usize) -> Result<Solution, FitError> {
    let (low, high) = problem.bounds();
    let found = solver::solve(&mut Shared(problem, share), from, (&low, &high), loss, most)?;
    let misfit = mean_square(&found.residuals);
    Ok(Solution { point: found.x, misfit, message: found.ended.words().to_owned() })
}

fn mean_square(residuals: &[f64]) -> f64 {
    residuals.iter().map(|x| x * x).sum::<f64>() / residuals.len() as f64
}

/// Fits: the best point, and what speaks for it.
///
/// # Errors
/// A start that is none, what cannot be played there, an interruption.
pub fn fit(problem: &mut Problem, plan: &Plan) -> Result<FitResult, FitError> {
    let begin = start(problem, plan)?;
    let (low, high) = problem.bounds();
    let silent = problem.told.iter().any(Option::is_none);
    let count = problem.free.len();
    let mut rng = Rng::with_seed(0);
    let mut ends: Vec<f64> = Vec::new();
    let mut best: Option<(Solution, Disturbed)> = None;
    for attempt in 0..=plan.restarts {
        let mut from = begin.clone();
        if let (true, Some((found, _))) = (attempt > 0, &best) {
            from = found.point.clone();
            for k in 0..count {
                from[k] += FAR * (high[k] - low[k]).min(1.0) * (2.0 * rng.f64() - 1.0);
            }
            problem.keep_inside(&mut from);
        }
        // First what leads to the blow, which is smooth; then all of it, in steps that look past what jumps.
        problem.weights = Some(problem.until_the_blow(&from)?);
        problem.forget();
        let found = solve(problem, &from, COARSE, Loss::SoftL1, COARSE_MOST[0])?;
        problem.weights = None;
        problem.forget();
        let found = solve(problem, &found.point, COARSE, Loss::SoftL1, COARSE_MOST[1])?;
        let mut found = solve(problem, &found.point, DIFFERENCES[1], plan.loss, plan.most)?;
        if silent {
            // The noise that nothing tells is estimated with the parameters held and the other way round, until neither
            // moves.
            for _ in 0..ROUNDS {
                if problem.estimate_noise(&found.point)? {
                    break;
                }
                found = solve(problem, &found.point, DIFFERENCES[1], plan.loss, plan.most)?;
            }
        }
        ends.push(found.misfit);
        if best.as_ref().is_none_or(|(best, _)| found.misfit < best.misfit) {
            let disturbed = problem.drive_noise(&found.point)?;
            best = Some((found, disturbed));
        }
        // Two that end alike, and leave no more than the sensors' noise, have found the place.
        let least = best.as_ref().map_or(f64::INFINITY, |(best, _)| best.misfit);
        if ends.iter().filter(|end| **end < AGREED * least).count() >= 2 && least <= MISFIT {
            break;
        }
    }
    let (found, disturbed) = best.ok_or(FitError::Unplayable)?;
    conclude(problem, found, &disturbed)
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

/// The Jacobian where it ended, how far that depends on its steps, and all that follows.
fn conclude(problem: &mut Problem, found: Solution, disturbed: &Disturbed) -> Result<FitResult, FitError> {
    problem.forget();
    let jacobian = problem.jacobian(&found.point, DIFFERENCES[1])?;
    let wide = problem.by_differences(&found.point, DIFFERENCES[0])?;
    let other = if problem.exact { jacobian.clone() } else { problem.by_differences(&found.point, DIFFERENCES[2])? };
    let residuals = problem.residuals(&found.point)?;
    Ok(FitResult::new(problem, found, residuals, &jacobian, agreement(&wide, &other), disturbed))
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

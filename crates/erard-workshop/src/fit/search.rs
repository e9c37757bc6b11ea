//! Search of a fit: stages from several starts. A stage up to the impact, then all rows with coarse differences, then
//! with fine ones.

use fastrand::Rng;

use crate::dense::{Columns, norm};

use super::candidate::{Candidate, best_of, within_tolerance};
use super::correlation::{Leftovers, NoisyRows};
use super::doubts::doubts;
use super::drive_noise::DriveNoise;
use super::jacobian::DIFFERENCES;
use super::meaning::meanings;
use super::objective::{Objective, WithStep};
use super::problem::Problem;
use super::result::Conclusion;
use super::simulator::Simulator;
use super::{FitError, FitResult, Jacobian, Loss, NoiseModel, Plan, Solution, Solver, TrustRegion};

/// Step of the first differences: long enough to smooth over jumps.
const COARSE: f64 = 1e-2;
/// Largest number of evaluations in the stage up to the impact, and in the coarse stage over all rows.
const MAX_COARSE: [usize; 2] = [20, 15];
/// Beyond this many times the misfit explained by the sensors' noise, the fit starts again elsewhere.
const MISFIT: f64 = 1.03;
/// Largest distance of a random start, in the solver's coordinates, and as a share of narrower bounds. From farther
/// away in wide bounds few attempts return.
const MAX_DISTANCE: f64 = 0.2;
/// A point is better than the solver's end if its log-likelihood is higher by this.
const BETTER: f64 = 1e-3;
/// Rounds of alternating estimates of noise and parameters.
const ROUNDS: usize = 3;
/// Rounds of alternating estimates of the noise's correlation and parameters.
const MAX_CORRELATIONS: usize = 4;

/// Fits the parameters of the simulator's problem to its recordings. Noise that is unknown is estimated; the result has
/// the estimate.
///
/// # Errors
/// An invalid start, a start that cannot be played, an interruption.
pub fn fit(simulator: &mut Simulator<'_>, noise: &NoiseModel, plan: &Plan) -> Result<FitResult, FitError> {
    fit_by(simulator, noise, plan, &mut TrustRegion)
}

/// [`fit()`] with the caller's solver.
///
/// # Errors
/// See [`fit()`].
pub fn fit_by(
    simulator: &mut Simulator<'_>,
    noise: &NoiseModel,
    plan: &Plan,
    solver: &mut dyn Solver,
) -> Result<FitResult, FitError> {
    let mut search = Search::new(simulator, noise, plan, solver);
    let start = search.record_start()?;
    search.attempt(&start)?;
    for _ in 0..plan.restarts {
        if search.has_converged() {
            break;
        }
        let start = search.random_start();
        search.attempt(&start)?;
    }
    search.polish()?;
    search.conclude()
}

/// Search for the best point of an objective.
struct Search<'a, 's, 'p> {
    objective: Objective<'s, 'p>,
    plan: &'a Plan,
    solver: &'a mut dyn Solver,
    rng: Rng,
    /// Ends of the attempts.
    ends: Vec<Candidate>,
    /// Reason why the solver ended at the best of them.
    message: String,
    /// Root mean square residual of each block at the start, N, m or m/s.
    rms_at_start: Vec<f64>,
}

impl<'a, 's, 'p> Search<'a, 's, 'p> {
    fn new(simulator: &'s mut Simulator<'p>, noise: &NoiseModel, plan: &'a Plan, solver: &'a mut dyn Solver) -> Self {
        Search {
            objective: Objective::new(simulator, noise.clone(), plan.loss),
            plan,
            solver,
            rng: Rng::with_seed(0),
            ends: Vec::new(),
            message: String::new(),
            rms_at_start: Vec::new(),
        }
    }

    /// Plays the plan's start and records its residuals. Returns its point.
    fn record_start(&mut self) -> Result<Vec<f64>, FitError> {
        let start = start(self.objective.problem(), self.plan)?;
        if !self.objective.is_playable(&start)? {
            return Err(FitError::Unplayable);
        }
        if self.plan.jacobian == Jacobian::Gradient {
            self.objective.use_gradient(&start)?;
        }
        self.rms_at_start = self.objective.candidate(&start)?.rms;
        Ok(start)
    }

    /// Solves from a point within the bounds, with this difference step and at most so many evaluations.
    fn solve(&mut self, from: &[f64], share: f64, loss: Loss, max_evaluations: usize) -> Result<Solution, FitError> {
        let (low, high) = self.objective.problem().bounds();
        let mut problem = WithStep(&mut self.objective, share);
        self.solver.solve(&mut problem, from, (&low, &high), loss, max_evaluations)
    }

    /// Solves with fine differences and the plan's loss.
    fn solve_finely(&mut self, from: &[f64]) -> Result<Solution, FitError> {
        self.solve(from, DIFFERENCES[1], self.plan.loss, self.plan.max_evaluations)
    }

    /// Runs all stages from a point, and records the end.
    fn attempt(&mut self, from: &[f64]) -> Result<(), FitError> {
        // First the smooth motion up to the impact; then all rows, with steps that smooth over jumps.
        let weights = self.objective.simulator.weights_until_impact(from)?;
        self.objective.set_weights(Some(weights));
        let found = self.solve(from, COARSE, Loss::SoftL1, MAX_COARSE[0])?;
        self.objective.set_weights(None);
        let found = self.solve(&found.point, COARSE, Loss::SoftL1, MAX_COARSE[1])?;
        let mut found = self.solve_finely(&found.point)?;
        if !self.objective.noise.is_known() {
            // Estimates unknown noise and parameters in turn until neither changes.
            for _ in 0..ROUNDS {
                if self.objective.estimate_noise(&found.point)? {
                    break;
                }
                found = self.solve_finely(&found.point)?;
            }
        }
        let end = self.objective.candidate(&found.point)?;
        if self.ends.iter().all(|other| end.score < other.score) {
            self.message = found.message;
        }
        self.ends.push(end);
        Ok(())
    }

    /// Whether two attempts ended at the same place with no more misfit than the sensors' noise: that is the minimum.
    fn has_converged(&self) -> bool {
        let best = best_of(&self.ends);
        within_tolerance(&self.ends, best).count() >= 2 && best.misfit <= MISFIT
    }

    /// Returns a random start near the best end: from farther away in wide bounds few attempts return.
    fn random_start(&mut self) -> Vec<f64> {
        let problem = self.objective.problem();
        let (low, high) = problem.bounds();
        let mut from = best_of(&self.ends).point.clone();
        for k in 0..problem.parameters().len() {
            from[k] += MAX_DISTANCE * (high[k] - low[k]).min(1.0) * (2.0 * self.rng.f64() - 1.0);
        }
        problem.clamp(&mut from);
        from
    }

    /// Solves again from the best point ever played, as long as it is better than the solver's end.
    fn polish(&mut self) -> Result<(), FitError> {
        let mut ended = best_of(&self.ends).score;
        for _ in 0..ROUNDS {
            let from = self.objective.best.candidate()?.clone();
            self.objective.estimate_noise(&from.point)?;
            if from.score > ended - BETTER {
                break;
            }
            let found = self.solve_finely(&from.point)?;
            ended = self.objective.candidate(&found.point)?.score;
            self.message = found.message;
        }
        Ok(())
    }

    /// Solves again with the correlation of the noise that the residuals show, until both agree. Returns the best
    /// point, the Jacobian there and the effect of a noisy drive.
    fn correlate(&mut self) -> Result<(Vec<f64>, Columns, DriveNoise), FitError> {
        let mut round = 0;
        loop {
            let objective = &mut self.objective;
            let point = objective.best.candidate()?.point.clone();
            objective.estimate_noise(&point)?;
            let drive_noise = DriveNoise::play(objective.simulator, &objective.noise, &point)?;
            let jacobian = objective.jacobian(&point, DIFFERENCES[1])?;
            if round == MAX_CORRELATIONS || !objective.correlate(&point, &jacobian, &drive_noise)? {
                return Ok((point, jacobian, drive_noise));
            }
            round += 1;
            // Every attempt goes on from where it ended, the best one from the best point.
            let best = best_of(&self.ends).point.clone();
            for from in std::mem::take(&mut self.ends) {
                let is_best = from.point == best;
                let found = self.solve_finely(if is_best { &point } else { &from.point })?;
                if is_best {
                    self.message = found.message;
                }
                self.ends.push(self.objective.candidate(&found.point)?);
            }
        }
    }

    /// Computes the Jacobian at the best point ever played, its dependence on the difference step and on the time step,
    /// and the result.
    fn conclude(mut self) -> Result<FitResult, FitError> {
        let (point, jacobian, drive_noise) = self.correlate()?;
        let objective = &mut self.objective;
        let wide = objective.by_differences(&point, DIFFERENCES[0])?;
        let other =
            if objective.is_exact() { jacobian.clone() } else { objective.by_differences(&point, DIFFERENCES[2])? };
        let half = objective.in_half_steps(&point, DIFFERENCES[1])?;
        let residuals = objective.residuals(&point)?;
        let (unwhitened, unwhitened_jacobian) = objective.unwhitened(&point, &jacobian)?;
        let noise = &objective.noise;
        let channels = noise.channels(objective.problem(), |k| noise.known_noise[k].is_none());
        let drive = drive_noise.covariance_columns();
        let left =
            Leftovers { channels: &channels, residuals: &unwhitened, jacobian: &unwhitened_jacobian, drive: &drive };
        let variance_freedom = left.degrees_of_freedom(&left.sized(times_of(noise, &channels)));
        let conclusion = Conclusion {
            point,
            message: self.message,
            residuals,
            jacobian_agreement: agreement(&wide, &other),
            // An error in proportion to the time step is twice the change in half the step.
            time_step_agreement: 2.0 * agreement(&half, &jacobian),
            jacobian,
            unwhitened,
            variance_freedom,
            ends: self.ends,
            rms_at_start: self.rms_at_start,
            noise: self.objective.noise,
        };
        let simulator = self.objective.simulator;
        let mut result = FitResult::new(simulator, &conclusion, &drive_noise);
        result.bend(simulator, &conclusion)?;
        result.doubts = doubts(simulator, &result, &conclusion.jacobian, &drive_noise)?;
        result.meanings = meanings(simulator, &result)?;
        Ok(result)
    }
}

/// Correlation time of every column, s.
fn times_of(noise: &NoiseModel, channels: &[NoisyRows]) -> Vec<f64> {
    let columns = channels.iter().map(|one| one.column + 1).max().unwrap_or(0);
    let of = |column: usize| {
        let own = channels.iter().position(|one| one.column == column);
        own.map_or(0.0, |k| noise.correlation_time_s[k])
    };
    (0..columns).map(of).collect()
}

/// Returns the plan's start in the solver's coordinates, within the bounds.
fn start(problem: &Problem, plan: &Plan) -> Result<Vec<f64>, FitError> {
    let is_fitted = |name: &str| problem.parameters().iter().any(|one| one.name == name);
    if let Some((name, _)) = plan.start.iter().find(|(name, _)| !is_fitted(name)) {
        return Err(FitError::argument("start", format!("{name} is not varied")));
    }
    let mut start = Vec::with_capacity(problem.parameters().len());
    for one in problem.parameters() {
        let given = plan.start.iter().find(|(name, _)| *name == one.name).map(|(_, x)| *x);
        if let Some(x) = given.filter(|x| !(one.low..=one.high).contains(x)) {
            let message = format!("{} at {x}; its bounds are {} and {}", one.name, one.low, one.high);
            return Err(FitError::argument("start", message));
        }
        start.push(one.to_solver(given.unwrap_or(one.unchanged())));
    }
    start.resize(start.len() + problem.delays(), 0.0);
    problem.clamp(&mut start);
    Ok(start)
}

/// The largest relative difference between columns of two Jacobians.
fn agreement(one: &[Vec<f64>], other: &[Vec<f64>]) -> f64 {
    let of = |(one, other): (&Vec<f64>, &Vec<f64>)| {
        let apart = one.iter().zip(other).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
        let size = norm(other);
        apart / if size > 0.0 { size } else { 1.0 }
    };
    one.iter().zip(other).map(of).fold(0.0, f64::max)
}

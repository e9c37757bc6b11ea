//! The best of all points played: the result is no worse than any of them.

use super::problem::Problem;
use super::{FitError, Loss, NoiseModel};

/// Smallest noise estimated for data without noise, as a share of the assumed noise.
const MIN_NOISE: f64 = 1e-9;
/// Two fits whose misfits have a ratio below this ended at the same place.
const TOLERANCE: f64 = 1.005;

/// A point that was played, with its score.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Candidate {
    /// Point in the solver's coordinates.
    pub point: Vec<f64>,
    /// Negative log-likelihood over all rows: half the loss for blocks of known noise, plus the logarithm of the
    /// residual for the others. Scores compare whatever noise was assumed when the points were played.
    pub score: f64,
    /// Mean square residual over the known noise; blocks of unknown noise count as 1.
    pub misfit: f64,
    /// Root mean square residual of each block, N, m or m/s.
    pub rms: Vec<f64>,
    rows: usize,
}

impl Candidate {
    /// Rates a point by its residuals without weights.
    pub(super) fn new(problem: &Problem, noise: &NoiseModel, loss: Loss, point: &[f64], residuals: &[f64]) -> Self {
        let (mut score, mut squares) = (0.0, 0.0);
        let mut rms = Vec::with_capacity(noise.sigma.len());
        for (k, block) in problem.blocks().iter().enumerate() {
            let own = &residuals[block.rows.clone()];
            let rows = own.len();
            let sigma = noise.sigma[k];
            let remaining = sigma * (own.iter().map(|x| x * x).sum::<f64>() / rows as f64).sqrt();
            let noise = match noise.known_noise[k] {
                Some(noise) => noise,
                None => {
                    let noise = remaining.max(MIN_NOISE * sigma);
                    score += rows as f64 * noise.ln();
                    noise
                }
            };
            let scaled: Vec<f64> = own.iter().map(|x| x * (sigma / noise)).collect();
            score += loss.cost(&scaled);
            squares += scaled.iter().map(|x| x * x).sum::<f64>();
            rms.push(remaining);
        }
        let rows = residuals.len();
        Candidate { point: point.to_vec(), score, misfit: squares / rows as f64, rms, rows }
    }

    /// Whether its misfit is at most `times` that of the best one.
    fn is_as_good_as(&self, best: &Candidate, times: f64) -> bool {
        // Half the sum of squares of n residuals is n / 2 times the misfit.
        self.score - best.score <= 0.5 * best.rows as f64 * (times - 1.0) * best.misfit
    }
}

/// The best point played under a loss.
#[derive(Debug)]
pub(super) struct Best {
    loss: Loss,
    candidate: Option<Candidate>,
}

impl Best {
    pub(super) fn new(loss: Loss) -> Self {
        Best { loss, candidate: None }
    }

    /// Forgets all points.
    pub(super) fn forget(&mut self) {
        self.candidate = None;
    }

    /// Rates a point by its residuals without weights.
    pub(super) fn rate(&self, problem: &Problem, noise: &NoiseModel, point: &[f64], residuals: &[f64]) -> Candidate {
        Candidate::new(problem, noise, self.loss, point, residuals)
    }

    /// Keeps a played point if it is the best so far.
    pub(super) fn update(&mut self, problem: &Problem, noise: &NoiseModel, point: &[f64], residuals: &[f64]) {
        if residuals.iter().any(|x| !x.is_finite()) {
            return;
        }
        let one = self.rate(problem, noise, point, residuals);
        if self.candidate.as_ref().is_none_or(|best| one.score < best.score) {
            self.candidate = Some(one);
        }
    }

    /// The best of all points that were played.
    ///
    /// # Errors
    /// If none could be played.
    pub(super) fn candidate(&self) -> Result<&Candidate, FitError> {
        self.candidate.as_ref().ok_or(FitError::Unplayable)
    }
}

/// The end with the lowest score.
pub(super) fn best_of(ends: &[Candidate]) -> &Candidate {
    ends.iter().min_by(|a, b| a.score.total_cmp(&b.score)).expect("there is one attempt at least")
}

/// The ends with as small a misfit as the best one.
pub(super) fn within_tolerance<'a>(ends: &'a [Candidate], best: &'a Candidate) -> impl Iterator<Item = &'a Candidate> {
    ends.iter().filter(|end| end.is_as_good_as(best, TOLERANCE))
}

//! The best of all points played: the result is no worse than any of them.

use super::{FitError, Loss, Problem};

/// A point that was played, with its score.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Candidate {
    /// Point in the solver's coordinates.
    pub point: Vec<f64>,
    /// Negative log-likelihood over all rows: half the loss for channels of known noise, plus the logarithm of the
    /// residual for the others. Scores compare whatever noise was assumed when the points were played.
    pub score: f64,
    /// Mean square residual over the known noise; channels of unknown noise count as 1.
    pub misfit: f64,
    /// Root mean square residual of each channel, N, m or m/s.
    pub rms: Vec<f64>,
    rows: usize,
}

impl Candidate {
    /// Whether its misfit is at most `times` that of the best one.
    pub(super) fn is_as_good_as(&self, best: &Candidate, times: f64) -> bool {
        // Half the sum of squares of n residuals is n / 2 times the misfit.
        self.score - best.score <= 0.5 * best.rows as f64 * (times - 1.0) * best.misfit
    }
}

impl Problem {
    /// Forgets earlier points: another fit begins.
    pub(super) fn begin(&mut self, loss: Loss) {
        (self.loss, self.best, self.rms_at_start, self.weights) = (loss, None, Vec::new(), None);
        self.forget();
    }

    /// Records the residuals at the start of the fit.
    pub(super) fn begun(&mut self, point: &[f64]) -> Result<(), FitError> {
        self.rms_at_start = self.candidate(point)?.rms;
        Ok(())
    }

    /// The best of all points that were played.
    pub(super) fn best(&self) -> Result<&Candidate, FitError> {
        self.best.as_ref().ok_or(FitError::Unplayable)
    }

    /// Returns the candidate at a point. Plays it unless it was the last one played.
    pub(super) fn candidate(&mut self, point: &[f64]) -> Result<Candidate, FitError> {
        let weights = self.weights.take();
        let left = self.residuals(point);
        self.weights = weights;
        Ok(self.rated(point, &left?))
    }

    /// Keeps a played point if it is the best so far. `left`: unweighted residuals.
    pub(super) fn consider(&mut self, point: &[f64], left: &[f64]) {
        if left.iter().any(|x| !x.is_finite()) {
            return;
        }
        let one = self.rated(point, left);
        if self.best.as_ref().is_none_or(|best| one.score < best.score) {
            self.best = Some(one);
        }
    }

    fn rated(&self, point: &[f64], left: &[f64]) -> Candidate {
        let (mut score, mut squares) = (0.0, 0.0);
        let mut rms = Vec::with_capacity(self.sigma.len());
        for (channel, rows) in self.channel_rows().into_iter().enumerate() {
            let own = &left[rows];
            let rows = own.len();
            let sigma = self.sigma[channel];
            let left_over = sigma * (own.iter().map(|x| x * x).sum::<f64>() / rows as f64).sqrt();
            let noise = match self.told[channel] {
                Some(noise) => noise,
                None => {
                    let noise = left_over.max(SMALLEST * sigma);
                    score += rows as f64 * noise.ln();
                    noise
                }
            };
            let scaled: Vec<f64> = own.iter().map(|x| x * (sigma / noise)).collect();
            score += self.loss.cost(&scaled);
            squares += scaled.iter().map(|x| x * x).sum::<f64>();
            rms.push(left_over);
        }
        Candidate { point: point.to_vec(), score, misfit: squares / left.len() as f64, rms, rows: left.len() }
    }
}

/// Least noise estimated for data without noise, as a share of the assumed noise.
const SMALLEST: f64 = 1e-9;

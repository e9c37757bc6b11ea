//! The best of all points that were ever played: no result is worse.

use super::{FitError, Loss, Problem};

/// A point that was played, and how good it is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Candidate {
    /// Point in the solver's coordinates.
    pub point: Vec<f64>,
    /// Minus its log-likelihood, all rows counted: of channels whose noise is known half of what the loss makes of
    /// their squares, of the others the logarithm of what is left over, besides. So points compare whatever noise was
    /// assumed as they were played.
    pub score: f64,
    /// Mean square of what is left over, over the noise that is known; 1 of a channel of which it is not.
    pub misfit: f64,
    /// Root mean square of what is left over of every channel, N or m.
    pub rms: Vec<f64>,
    rows: usize,
}

impl Candidate {
    /// Whether its misfit is no more than so many times that of the best one.
    pub(super) fn is_as_good_as(&self, best: &Candidate, times: f64) -> bool {
        // Half the squares of n residuals are n / 2 times the misfit.
        self.score - best.score <= 0.5 * best.rows as f64 * (times - 1.0) * best.misfit
    }
}

impl Problem {
    /// Forgets what was played before: another fit begins.
    pub(super) fn begin(&mut self, loss: Loss) {
        (self.loss, self.best, self.rms_at_start, self.weights) = (loss, None, Vec::new(), None);
        self.forget();
    }

    /// Remembers what is left over where the fit begins.
    pub(super) fn begun(&mut self, point: &[f64]) -> Result<(), FitError> {
        self.rms_at_start = self.candidate(point)?.rms;
        Ok(())
    }

    /// The best of all points that were played.
    pub(super) fn best(&self) -> Result<&Candidate, FitError> {
        self.best.as_ref().ok_or(FitError::Unplayable)
    }

    /// How good a point is. It is played, if it was not the last one.
    pub(super) fn candidate(&mut self, point: &[f64]) -> Result<Candidate, FitError> {
        let weights = self.weights.take();
        let left = self.residuals(point);
        self.weights = weights;
        Ok(self.rated(point, &left?))
    }

    /// Takes notice of a point that was played: its residuals, all rows alike.
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

/// Data without any noise are taken to have so much of what was assumed.
const SMALLEST: f64 = 1e-9;

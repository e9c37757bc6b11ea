//! End points of the attempts of a fit.

use super::candidate::Candidate;

/// Two fits whose misfits have a ratio below this ended at the same place.
const AGREED: f64 = 1.005;

/// End of a fit.
#[derive(Debug, Clone)]
pub(super) struct Ended {
    pub point: Vec<f64>,
    pub message: String,
    pub residuals: Vec<f64>,
    /// Relative change of the Jacobian with its difference step.
    pub agreement: f64,
    /// End points of all attempts.
    pub ends: Vec<Candidate>,
}

/// The end with the lowest score.
pub(super) fn best_of(ends: &[Candidate]) -> &Candidate {
    ends.iter().min_by(|a, b| a.score.total_cmp(&b.score)).expect("there is one attempt at least")
}

/// The ends with as small a misfit as the best one.
pub(super) fn alike<'a>(ends: &'a [Candidate], best: &'a Candidate) -> impl Iterator<Item = &'a Candidate> {
    ends.iter().filter(|end| end.is_as_good_as(best, AGREED))
}

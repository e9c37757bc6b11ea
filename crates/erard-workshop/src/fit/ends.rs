//! Where the attempts of a fit ended.

use super::candidate::Candidate;

/// Two fits whose misfits differ by less have ended at the same place.
const AGREED: f64 = 1.005;

/// Where a fit ended, and how it came there.
#[derive(Debug, Clone)]
pub(super) struct Ended {
    pub point: Vec<f64>,
    pub message: String,
    pub residuals: Vec<f64>,
    /// How far the Jacobian depends on the length of its steps.
    pub agreement: f64,
    /// End points of all attempts.
    pub ends: Vec<Candidate>,
}

/// The end with the lowest score.
pub(super) fn best_of(ends: &[Candidate]) -> &Candidate {
    ends.iter().min_by(|a, b| a.score.total_cmp(&b.score)).expect("there is one attempt at least")
}

/// The ends that leave as much as the best one.
pub(super) fn alike<'a>(ends: &'a [Candidate], best: &'a Candidate) -> impl Iterator<Item = &'a Candidate> {
    ends.iter().filter(|end| end.is_as_good_as(best, AGREED))
}

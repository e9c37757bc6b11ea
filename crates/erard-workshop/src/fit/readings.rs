//! Readings of the model at one point.

use super::problem::Problem;

/// Readings of the model at one point: a curve for every block of residuals, at all instants of its recording.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Readings {
    curves: Vec<Vec<f64>>,
}

impl Readings {
    /// Readings of a point that cannot be played: not a number.
    pub(super) fn unplayable(problem: &Problem) -> Self {
        let of = |block| vec![f64::NAN; problem.recording_of(block).time_s.len()];
        Readings { curves: problem.blocks().iter().map(of).collect() }
    }

    /// Curve of a block.
    pub(super) fn curve(&self, block: usize) -> &[f64] {
        &self.curves[block]
    }

    /// Replaces the curves of a recording, whose first block is `first`, in the order of its columns.
    pub(super) fn replace(&mut self, first: usize, curves: Vec<Vec<f64>>) {
        for (own, new) in self.curves[first..].iter_mut().zip(curves) {
            *own = new;
        }
    }
}

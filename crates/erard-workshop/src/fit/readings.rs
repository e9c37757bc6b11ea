//! Readings of the model at one point.

/// Readings of the model at one point: a curve for every block of residuals, at all instants of its recording.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Readings {
    curves: Vec<Vec<f64>>,
}

impl Readings {
    /// Readings of a point that cannot be played: not a number, for so many instants of each block.
    pub(super) fn unplayable(instants: impl Iterator<Item = usize>) -> Self {
        Readings { curves: instants.map(|count| vec![f64::NAN; count]).collect() }
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

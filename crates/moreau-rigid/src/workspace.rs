//! Working memory of a step.

use super::implicit::Implicit;
use super::mixed::Problem;
use super::rows::Row;
use super::sweeps::Reduced;
use super::touch::Touch;
use moreau::Scalar;

/// Working memory of a step.
#[derive(Debug, Clone)]
pub struct Workspace<T, const B: usize, const N: usize> {
    /// Along which impulses act: the rows at t0 + theta h.
    pub(super) rows: [Row<T>; N],
    /// Whose velocity the laws speak of: the rows at t0 + h.
    pub(super) end_rows: [Row<T>; N],
    pub(super) problem: Problem<T, N>,
    /// The problem without its equalities, for sweeps.
    pub(super) reduced: Reduced<T, N>,
    /// What touches, point by point.
    pub(super) touch: [Touch<T>; N],
    /// Regular forces that depend on the step's end, linearised.
    pub(super) implicit: Implicit<T, B>,
}

impl<T: Scalar, const B: usize, const N: usize> Workspace<T, B, N> {
    /// Returns new working memory. Results do not depend on previous contents.
    pub fn new() -> Self {
        Workspace {
            rows: [Row::none(); N],
            end_rows: [Row::none(); N],
            problem: Problem::new(),
            reduced: Reduced::new(),
            touch: [Touch::None; N],
            implicit: Implicit::new(),
        }
    }
}

impl<T: Scalar, const B: usize, const N: usize> Default for Workspace<T, B, N> {
    fn default() -> Self {
        Self::new()
    }
}

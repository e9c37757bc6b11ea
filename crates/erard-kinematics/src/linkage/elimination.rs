//! Gauss elimination with row pivoting on small rectangular systems: it finds the
//! rank, solves what can be solved, and never divides by nothing.
//!
//! A column that depends on those before it is passed over (row echelon form).
//! Complete pivoting would judge the rank a little better, but searching for its
//! pivots took longer than everything else in a Newton step; and the matrices here
//! are of order one, small, and judged by [`super::Mobility`] where it matters.

/// A factorised `rows × cols` matrix. All memory is taken once, in [`Elimination::new`].
#[derive(Clone, Debug)]
pub(crate) struct Elimination {
    rows: usize,
    cols: usize,
    /// Row-major, `L` below the diagonal and `U` on and above it, both permuted.
    a: Vec<f64>,
    row_of: Vec<usize>,
    col_of: Vec<usize>,
    /// One over each pivot: divisions are slow and needed again in every solution.
    reciprocal: Vec<f64>,
    work: Vec<f64>,
    rank: usize,
    sign: f64,
}

impl Elimination {
    pub(crate) fn new(rows: usize, cols: usize) -> Self {
        Elimination {
            rows,
            cols,
            a: vec![0.0; rows * cols],
            row_of: (0..rows).collect(),
            col_of: (0..cols).collect(),
            reciprocal: vec![0.0; rows.min(cols)],
            work: vec![0.0; rows],
            rank: 0,
            sign: 0.0,
        }
    }

    /// The matrix to be factorised, row-major; to be filled before [`Elimination::factor`].
    pub(crate) fn matrix_mut(&mut self) -> &mut [f64] {
        &mut self.a
    }

    /// Number of pivots, each larger than the `tolerance` of [`Elimination::factor`].
    pub(crate) fn rank(&self) -> usize {
        self.rank
    }

    /// Sign of the determinant; 0 unless the matrix is square and of full rank.
    pub(crate) fn orientation(&self) -> f64 {
        if self.rows == self.cols && self.rank == self.rows { self.sign } else { 0.0 }
    }

    /// The smallest of the first `count` pivots; 0 if there are fewer.
    pub(crate) fn smallest_pivot(&self, count: usize) -> f64 {
        if self.rank < count {
            return 0.0;
        }
        let pivots = self.reciprocal[..count].iter().map(|r| 1.0 / r.abs());
        pivots.fold(f64::INFINITY, f64::min)
    }

    /// Factorises what `matrix_mut` was filled with. Pivots up to `tolerance` count as
    /// zero; it is absolute, for matrices of order one.
    pub(crate) fn factor(&mut self, tolerance: f64) {
        // One and two loops with one drive are the common cases: with the sizes
        // known to the compiler they take half the time.
        match (self.rows, self.cols) {
            (2, 2) => self.factor_sized(2, 2, tolerance),
            (4, 4) => self.factor_sized(4, 4, tolerance),
            (rows, cols) => self.factor_sized(rows, cols, tolerance),
        }
    }

    #[inline(always)]
    fn factor_sized(&mut self, rows: usize, cols: usize, tolerance: f64) {
        if cols == 0 {
            return;
        }
        assert!(self.a.len() == rows * cols);
        for (i, row) in self.row_of.iter_mut().enumerate() {
            *row = i;
        }
        for (j, col) in self.col_of.iter_mut().enumerate() {
            *col = j;
        }
        self.sign = 1.0;
        self.rank = 0;
        let a = &mut self.a[..rows * cols];
        let mut next = 0;
        for step in 0..rows.min(cols) {
            // The next column with something left outside the columns before it.
            let mut pr = step;
            loop {
                if next == cols {
                    return;
                }
                let mut largest = 0.0;
                for i in step..rows {
                    let size = a[i * cols + next].abs();
                    // Never true for NaN, which so counts as nothing.
                    if size > largest {
                        (pr, largest) = (i, size);
                    }
                }
                if largest > tolerance {
                    break;
                }
                next += 1;
            }
            if pr != step {
                for j in 0..cols {
                    a.swap(step * cols + j, pr * cols + j);
                }
                self.row_of.swap(step, pr);
                self.sign = -self.sign;
            }
            if next != step {
                for i in 0..rows {
                    a.swap(i * cols + step, i * cols + next);
                }
                self.col_of.swap(step, next);
            }
            next += 1;
            let pivot = a[step * cols + step];
            if pivot < 0.0 {
                self.sign = -self.sign;
            }
            let reciprocal = 1.0 / pivot;
            self.reciprocal[step] = reciprocal;
            for i in step + 1..rows {
                let factor = a[i * cols + step] * reciprocal;
                a[i * cols + step] = factor;
                for j in step + 1..cols {
                    a[i * cols + j] -= factor * a[step * cols + j];
                }
            }
            self.rank = step + 1;
        }
    }

    /// Solves `A x = b` through the independent rows; the free columns get `x = 0`.
    /// Dependent rows are left to the caller's residual.
    pub(crate) fn solve(&mut self, b: &[f64], x: &mut [f64]) {
        x.fill(0.0);
        match (self.cols, self.rank) {
            (_, 0) => {}
            (2, 2) => self.solve_sized(2, 2, b, x),
            (4, 4) => self.solve_sized(4, 4, b, x),
            (cols, rank) => self.solve_sized(cols, rank, b, x),
        }
    }

    #[inline(always)]
    fn solve_sized(&mut self, cols: usize, rank: usize, b: &[f64], x: &mut [f64]) {
        assert!(self.work.len() >= rank && self.reciprocal.len() >= rank);
        for (i, row) in self.a.chunks_exact(cols).take(rank).enumerate() {
            let (done, rest) = self.work.split_at_mut(i);
            let mut y = b[self.row_of[i]];
            for (l, y_j) in row.iter().zip(done) {
                y -= l * *y_j;
            }
            rest[0] = y;
        }
        for i in (0..rank).rev() {
            let row = &self.a[i * cols..(i + 1) * cols];
            let (head, done) = self.work[..rank].split_at_mut(i + 1);
            let mut y = head[i];
            for (u, x_j) in row[i + 1..].iter().zip(done) {
                y -= u * *x_j;
            }
            head[i] = y * self.reciprocal[i];
        }
        for (&col, value) in self.col_of.iter().zip(&self.work[..rank]) {
            x[col] = *value;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn factored(rows: usize, cols: usize, a: &[f64]) -> Elimination {
        let mut e = Elimination::new(rows, cols);
        e.matrix_mut().copy_from_slice(a);
        e.factor(1e-12);
        e
    }

    /// Integers of this size are exact in binary, so the solution is too, to the
    /// rounding of one division: 1e-15. The determinant is -2, so its sign is known.
    #[test]
    fn a_square_system() {
        let mut e = factored(2, 2, &[1.0, 2.0, 3.0, 4.0]);
        let mut x = [0.0; 2];
        e.solve(&[5.0, 11.0], &mut x);
        assert!((x[0] - 1.0).abs() < 1e-15 && (x[1] - 2.0).abs() < 1e-15);
        assert_eq!(e.rank(), 2);
        assert_eq!(e.orientation(), -1.0);
    }

    /// Three consistent equations in two unknowns, one the sum of the others:
    /// rank 2, solved exactly.
    #[test]
    fn a_redundant_equation_does_no_harm() {
        let mut e = factored(3, 2, &[1.0, 1.0, 1.0, -1.0, 2.0, 0.0]);
        let mut x = [0.0; 2];
        e.solve(&[3.0, 1.0, 4.0], &mut x);
        assert_eq!(e.rank(), 2);
        assert!((x[0] - 2.0).abs() < 1e-15 && (x[1] - 1.0).abs() < 1e-15);
    }

    /// Zeros, and NaN, have rank 0: nothing is divided by, nothing spreads.
    #[test]
    fn nothing_and_not_a_number_have_rank_zero() {
        for fill in [0.0, f64::NAN] {
            let mut e = factored(2, 2, &[fill; 4]);
            let mut x = [7.0; 2];
            e.solve(&[1.0, 1.0], &mut x);
            assert_eq!((e.rank(), x), (0, [0.0; 2]));
        }
    }
}

//! Symmetric positive definite systems of the mechanism's size, factorised as A = L D L^T without square roots.

use crate::real::Real;

/// Repeats a body for every `row` below B (or down to 0), written out up to nine, the size of a piano's action that
/// bends: the compiler does not unroll loops within loops early enough to keep a matrix in registers, and beyond eight
/// rows not at all. Numbers that do not fit into a register ([`Real::WRITTEN_OUT`]) keep the loop.
macro_rules! written_out {
    (up $row:ident, $size:ident, $body:block) => {{
        written_out!(@each $row, $size, $body, 0 1 2 3 4 5 6 7 8);
        for $row in if T::WRITTEN_OUT { 9 } else { 0 }..$size $body
    }};
    (down $row:ident, $size:ident, $body:block) => {{
        for $row in (if T::WRITTEN_OUT { 9 } else { 0 }..$size).rev() $body
        written_out!(@each $row, $size, $body, 8 7 6 5 4 3 2 1 0);
    }};
    (@each $row:ident, $size:ident, $body:block, $($index:literal)+) => {
        $(if const { T::WRITTEN_OUT } && $index < $size {
            let $row: usize = $index;
            $body
        })+
    };
}

/// Symmetric matrix.
#[derive(Debug, Clone, Copy)]
pub struct Symmetric<T, const B: usize> {
    /// Diagonal, stored separately so that it is written and read in one piece.
    pub diagonal: [T; B],
    /// Entries below the diagonal; the other entries are not read.
    pub below: [[T; B]; B],
}

impl<T: Real, const B: usize> Symmetric<T, B> {
    pub(crate) fn zero() -> Self {
        Symmetric { diagonal: [T::ZERO; B], below: [[T::ZERO; B]; B] }
    }

    /// Clears what is below the diagonal: not what is never read.
    #[inline(always)]
    pub(crate) fn clear_below(&mut self) {
        written_out!(up i, B, {
            for j in 0..i {
                self.below[i][j] = T::ZERO;
            }
        });
    }

    /// One lane's matrix.
    pub(crate) fn lane(&self, lane: usize) -> Symmetric<T::Lane, B> {
        Symmetric {
            diagonal: self.diagonal.map(|x| x.lane(lane)),
            below: self.below.map(|row| row.map(|x| x.lane(lane))),
        }
    }

    /// A row times x.
    #[inline(always)]
    pub(crate) fn row_product(&self, i: usize, x: &[T; B]) -> T {
        let mut sum = self.diagonal[i] * x[i];
        for j in 0..i {
            sum = sum.add_product(self.below[i][j], x[j]);
        }
        for j in i + 1..B {
            sum = sum.add_product(self.below[j][i], x[j]);
        }
        sum
    }

    /// Factorises the matrix, with another diagonal, into `l` (strictly lower: L) and returns 1/D; takes right-hand
    /// sides `x` along through the forward substitution, which then waits for nothing.
    ///
    /// The matrix must be positive definite: here a mass matrix plus positive semidefinite terms.
    #[inline(always)]
    pub(crate) fn factor<const R: usize>(&self, diagonal: &[T; B], l: &mut [[T; B]; B], x: [&mut [T; B]; R]) -> [T; B] {
        let mut inverse = [T::ZERO; B];
        // Row by row: while one row's division is under way, the next row's products can be.
        written_out!(up i, B, {
            let mut scaled = self.below[i];
            let mut d = diagonal[i];
            for j in 0..i {
                for k in 0..j {
                    let t = scaled[k];
                    scaled[j] = scaled[j].sub_product(t, l[j][k]);
                }
                l[i][j] = scaled[j] * inverse[j];
                d = d.sub_product(scaled[j], l[i][j]);
            }
            inverse[i] = T::ONE / d;
            for r in 0..R {
                for k in 0..i {
                    let t = x[r][k];
                    x[r][i] = x[r][i].sub_product(l[i][k], t);
                }
            }
        });
        inverse
    }
}

/// The rest of A^-1 x, after [`Symmetric::factor`] has taken x along.
#[inline(always)]
pub(crate) fn back_substitute<T: Real, const B: usize>(l: &[[T; B]; B], inverse_d: &[T; B], x: &mut [T; B]) {
    for i in 0..B {
        x[i] = x[i] * inverse_d[i];
    }
    written_out!(down i, B, {
        for k in 0..i {
            let t = x[i];
            x[k] = x[k].sub_product(l[i][k], t);
        }
    });
}

/// A^-1 x from the factors.
#[inline(always)]
pub(crate) fn solve<T: Real, const B: usize>(l: &[[T; B]; B], inverse_d: &[T; B], x: &[T; B]) -> [T; B] {
    let mut y = *x;
    written_out!(up i, B, {
        for k in 0..i {
            let t = y[k];
            y[i] = y[i].sub_product(l[i][k], t);
        }
    });
    back_substitute(l, inverse_d, &mut y);
    y
}

/// Solves `matrix` x = `right` for all columns of `right`, in place, by Gauss-Jordan elimination without pivoting. No
/// pivot may vanish; none does if the matrix is positive definite, or a product of such a matrix and a positive
/// diagonal one.
pub fn gauss_jordan<T: Real, const K: usize, const C: usize>(matrix: &mut [[T; K]; K], right: &mut [[T; C]; K]) {
    for pivot in 0..K {
        eliminate(matrix, right, pivot);
    }
}

/// Solves as [`gauss_jordan`] does, with the largest pivot of each column. Returns false if a pivot is below
/// `smallest`; `right` then holds no solution.
pub fn gauss_jordan_pivoting<const K: usize, const C: usize>(
    matrix: &mut [[f64; K]; K],
    right: &mut [[f64; C]; K],
    smallest: f64,
) -> bool {
    for pivot in 0..K {
        let mut largest = pivot;
        for i in pivot + 1..K {
            if matrix[i][pivot].abs() > matrix[largest][pivot].abs() {
                largest = i;
            }
        }
        matrix.swap(pivot, largest);
        right.swap(pivot, largest);
        if matrix[pivot][pivot].abs() < smallest {
            return false;
        }
        eliminate(matrix, right, pivot);
    }
    true
}

/// One column of the elimination.
#[inline(always)]
fn eliminate<T: Real, const K: usize, const C: usize>(matrix: &mut [[T; K]; K], right: &mut [[T; C]; K], pivot: usize) {
    let by = T::ONE / matrix[pivot][pivot];
    for k in 0..K {
        matrix[pivot][k] = by * matrix[pivot][k];
    }
    for k in 0..C {
        right[pivot][k] = by * right[pivot][k];
    }
    for i in (0..K).filter(|i| *i != pivot) {
        let factor = matrix[i][pivot];
        for k in 0..K {
            matrix[i][k] = matrix[i][k].sub_product(factor, matrix[pivot][k]);
        }
        for k in 0..C {
            right[i][k] = right[i][k].sub_product(factor, right[pivot][k]);
        }
    }
}

/// a . b.
#[inline(always)]
pub(crate) fn product<T: Real, const B: usize>(a: &[T; B], b: &[T; B]) -> T {
    let mut sum = T::ZERO;
    for i in 0..B {
        sum = sum.add_product(a[i], b[i]);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A times A^-1 x is x, to the condition number (about 1e3) times rounding.
    #[test]
    fn solves_a_gram_matrix() {
        let mut a = Symmetric::<f64, 5>::zero();
        for i in 0..5 {
            a.diagonal[i] = 1.0 / (1.0 + 2.0 * i as f64) + 0.01;
            for j in 0..i {
                a.below[i][j] = 1.0 / (1.0 + i as f64 + j as f64);
            }
        }
        let mut l = [[0.0; 5]; 5];
        let d = a.factor(&a.diagonal, &mut l, []);
        let x = [1.0, -2.0, 0.5, 3.0, -1.0];
        let y = solve(&l, &d, &x);
        for i in 0..5 {
            assert!((a.row_product(i, &y) - x[i]).abs() < 1e-12);
        }
    }
}

//! Small dense matrices: singular values, and the Cholesky factor of a covariance.
//!
//! The singular values are those of a tall matrix by Hestenes' one-sided rotations: small ones have their own relative
//! accuracy, not that of the largest (Demmel and Veselic, "Jacobi's method is more accurate than QR", SIAM J. Matrix
//! Anal. Appl. 13 (1992)).

/// A matrix, column by column.
pub type Columns = Vec<Vec<f64>>;

/// Singular values in descending order, and their right singular vectors.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Svd {
    /// Not negative, descending.
    pub values: Vec<f64>,
    /// Each of unit length.
    pub directions: Columns,
}

/// Largest number of sweeps over all pairs: about eight are needed; only matrices that are not finite take more.
const MAX_SWEEPS: usize = 60;

/// Decomposes a matrix given by its columns.
pub(crate) fn svd(matrix: &[Vec<f64>]) -> Svd {
    let count = matrix.len();
    let mut columns: Columns = matrix.to_vec();
    let mut right: Columns = (0..count).map(|i| (0..count).map(|j| f64::from(i == j)).collect()).collect();
    for _ in 0..MAX_SWEEPS {
        let mut turned = false;
        for i in 0..count {
            for j in i + 1..count {
                let (a, b, c) =
                    (dot(&columns[i], &columns[i]), dot(&columns[j], &columns[j]), dot(&columns[i], &columns[j]));
                if c.abs() <= f64::EPSILON * (a * b).sqrt() || c == 0.0 {
                    continue;
                }
                turned = true;
                let zeta = (b - a) / (2.0 * c);
                let tangent = zeta.signum() / (zeta.abs() + zeta.hypot(1.0));
                let cosine = 1.0 / tangent.hypot(1.0);
                for all in [&mut columns, &mut right] {
                    let (head, tail) = all.split_at_mut(j);
                    for (x, y) in head[i].iter_mut().zip(&mut tail[0]) {
                        (*x, *y) = (cosine * (*x - tangent * *y), cosine * (*y + tangent * *x));
                    }
                }
            }
        }
        if !turned {
            break;
        }
    }
    let mut found: Vec<(f64, Vec<f64>)> = columns.iter().map(|column| norm(column)).zip(right).collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let (values, directions) = found.into_iter().unzip();
    Svd { values, directions }
}

/// Scalar product.
pub(crate) fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Euclidean norm.
pub(crate) fn norm(a: &[f64]) -> f64 {
    dot(a, a).sqrt()
}

/// Product of a matrix and a vector.
pub(crate) fn times(matrix: &[Vec<f64>], vector: &[f64]) -> Vec<f64> {
    let mut found = vec![0.0; matrix.first().map_or(0, Vec::len)];
    for (column, by) in matrix.iter().zip(vector) {
        for (sum, x) in found.iter_mut().zip(column) {
            *sum += by * x;
        }
    }
    found
}

/// Lower Cholesky factor of a symmetric positive definite matrix.
#[derive(Debug, Clone)]
pub(crate) struct Cholesky {
    n: usize,
    lower: Vec<f64>,
}

impl Cholesky {
    /// Factorises an n by n matrix stored by rows; `None` if it is not positive definite.
    pub(crate) fn of(matrix: &[f64], n: usize) -> Option<Self> {
        let mut lower = matrix.to_vec();
        for i in 0..n {
            for j in 0..=i {
                let mut sum = lower[i * n + j];
                for k in 0..j {
                    sum -= lower[i * n + k] * lower[j * n + k];
                }
                if i == j {
                    if sum <= 0.0 || !sum.is_finite() {
                        return None;
                    }
                    lower[i * n + i] = libm::sqrt(sum);
                } else {
                    lower[i * n + j] = sum / lower[j * n + j];
                }
            }
        }
        Some(Cholesky { n, lower })
    }

    /// L^-1 b.
    pub(crate) fn forward(&self, b: &[f64]) -> Vec<f64> {
        let n = self.n;
        let mut x = b.to_vec();
        for i in 0..n {
            for k in 0..i {
                x[i] -= self.lower[i * n + k] * x[k];
            }
            x[i] /= self.lower[i * n + i];
        }
        x
    }

    /// Solves A x = b.
    pub(crate) fn solve(&self, b: &[f64]) -> Vec<f64> {
        let n = self.n;
        let mut x = self.forward(b);
        for i in (0..n).rev() {
            for k in i + 1..n {
                x[i] -= self.lower[k * n + i] * x[k];
            }
            x[i] /= self.lower[i * n + i];
        }
        x
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.n
    }

    /// Logarithm of the factor's determinant.
    pub(crate) fn log_determinant(&self) -> f64 {
        (0..self.n).map(|i| libm::log(self.lower[i * self.n + i])).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Lauchli's matrix has singular values sqrt(n + e^2) and e; those of a graded matrix each come out to their own
    /// accuracy.
    #[test]
    fn known_singular_values() {
        let e = 1e-7;
        let found = svd(&[vec![1.0, e, 0.0, 0.0], vec![1.0, 0.0, e, 0.0], vec![1.0, 0.0, 0.0, e]]);
        for (value, known) in found.values.iter().zip([(3.0 + e * e).sqrt(), e, e]) {
            assert!((value / known - 1.0).abs() < 1e-8, "{value} {known}");
        }
        let graded = svd(&[vec![1e8, 0.0, 0.0], vec![0.0, 0.0, -3e-9], vec![0.0, 2.0, 0.0]]);
        assert_eq!(graded.values, [1e8, 2.0, 3e-9]);
        assert_eq!(graded.directions[2].iter().map(|x| x.abs()).collect::<Vec<_>>(), [0.0, 1.0, 0.0]);
    }

    /// The factors reproduce the matrix: J v = s u, and the u are orthogonal. Equal columns give a singular value of
    /// zero.
    #[test]
    fn directions_are_right() {
        let matrix = vec![vec![1.0, 2.0, 3.0, 4.0], vec![2.0, -1.0, 0.5, 1.0], vec![3.0, 1.0, 3.5, 5.0]];
        let found = svd(&matrix);
        assert!(found.values[2] < 1e-15 * found.values[0]);
        let images: Columns = found.directions.iter().map(|direction| times(&matrix, direction)).collect();
        for (i, a) in images.iter().enumerate() {
            assert!((norm(a) - found.values[i]).abs() < 1e-14 * found.values[0]);
            for b in &images[..i] {
                assert!(dot(a, b).abs() < 1e-13 * found.values[0]);
            }
        }
    }
}

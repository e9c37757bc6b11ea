//! Small normal distributions: Cholesky factor of a covariance, densities, conditioning.

/// Lower Cholesky factor of a symmetric positive definite matrix.
#[derive(Debug, Clone)]
pub(super) struct Factor {
    n: usize,
    lower: Vec<f64>,
}

impl Factor {
    /// Factorises an n by n matrix stored by rows; `None` if it is not positive definite.
    pub(super) fn of(matrix: &[f64], n: usize) -> Option<Self> {
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
        Some(Factor { n, lower })
    }

    /// L^-1 b.
    pub(super) fn forward(&self, b: &[f64]) -> Vec<f64> {
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

    /// Logarithm of the normal density at a distance from the mean.
    pub(super) fn log_density(&self, off: &[f64]) -> f64 {
        let z = self.forward(off);
        let log_det: f64 = (0..self.n).map(|i| libm::log(self.lower[i * self.n + i])).sum();
        let tau = std::f64::consts::TAU;
        -0.5 * z.iter().map(|z| z * z).sum::<f64>() - log_det - 0.5 * self.n as f64 * libm::log(tau)
    }
}

/// Logarithm of the sum of exponentials.
pub(super) fn log_sum(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let most = values.clone().fold(f64::NEG_INFINITY, f64::max);
    if most == f64::NEG_INFINITY { most } else { most + libm::log(values.map(|x| libm::exp(x - most)).sum()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two variables with covariance [[4, 2], [2, 3]]: determinant 8, inverse [[3, -2], [-2, 4]] / 8; at (1, 1) the
    /// quadratic form is 3/8, by hand.
    #[test]
    fn a_density_by_hand() {
        let factor = Factor::of(&[4.0, 2.0, 2.0, 3.0], 2).unwrap();
        let expected = -0.5 * 3.0 / 8.0 - 0.5 * 8.0_f64.ln() - std::f64::consts::TAU.ln();
        assert!((factor.log_density(&[1.0, 1.0]) - expected).abs() < 1e-12);
        assert!(Factor::of(&[1.0, 2.0, 2.0, 1.0], 2).is_none());
        assert!((log_sum([0.0, 0.0].into_iter()) - 2.0_f64.ln()).abs() < 1e-12);
    }
}

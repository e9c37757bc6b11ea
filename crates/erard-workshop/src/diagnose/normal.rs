//! Normal distributions: density of a deviation, and sums of densities by their logarithms.

use crate::dense::Cholesky;

/// Logarithm of the normal density at a distance from the mean, by the Cholesky factor of the covariance.
pub(super) fn log_density(covariance: &Cholesky, off: &[f64]) -> f64 {
    let z = covariance.forward(off);
    let tau = std::f64::consts::TAU;
    -0.5 * z.iter().map(|z| z * z).sum::<f64>()
        - covariance.log_determinant()
        - 0.5 * covariance.rows() as f64 * libm::log(tau)
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
        let factor = Cholesky::of(&[4.0, 2.0, 2.0, 3.0], 2).unwrap();
        let expected = -0.5 * 3.0 / 8.0 - 0.5 * 8.0_f64.ln() - std::f64::consts::TAU.ln();
        assert!((log_density(&factor, &[1.0, 1.0]) - expected).abs() < 1e-12);
        assert!(Cholesky::of(&[1.0, 2.0, 2.0, 1.0], 2).is_none());
        assert!((log_sum([0.0, 0.0].into_iter()) - 2.0_f64.ln()).abs() < 1e-12);
    }
}

//! Symmetric positive definite systems of the size of the mechanism: A = L D L^T, without square roots.

use crate::Real;

/// Factorises the lower triangle of `a` in place (strictly lower: L; the diagonal is left) and returns 1/D.
///
/// `a` must be positive definite: here a mass matrix plus positive semidefinite terms.
#[inline(always)]
pub(crate) fn factor<T: Real, const B: usize>(a: &mut [[T; B]; B]) -> [T; B] {
    let mut inverse = [T::ZERO; B];
    for j in 0..B {
        let mut d = a[j][j];
        let mut scaled = [T::ZERO; B];
        for k in 0..j {
            scaled[k] = a[j][k];
            a[j][k] = scaled[k] * inverse[k];
            d -= scaled[k] * a[j][k];
        }
        inverse[j] = T::ONE / d;
        for i in j + 1..B {
            let mut x = a[i][j];
            for k in 0..j {
                x -= a[i][k] * a[j][k];
            }
            a[i][j] = x;
        }
    }
    inverse
}

/// A^-1 from the factors.
#[inline(always)]
pub(crate) fn inverse<T: Real, const B: usize>(l: &[[T; B]; B], inverse_d: &[T; B]) -> [[T; B]; B] {
    // Rows of L^-1, then A^-1 = L^-T D^-1 L^-1.
    let mut m = [[T::ZERO; B]; B];
    for i in 0..B {
        m[i][i] = T::ONE;
        for j in 0..i {
            let mut x = -l[i][j];
            for k in j + 1..i {
                x -= l[i][k] * m[k][j];
            }
            m[i][j] = x;
        }
    }
    let mut out = [[T::ZERO; B]; B];
    for i in 0..B {
        for j in 0..=i {
            let mut x = T::ZERO;
            for k in i..B {
                x += m[k][i] * inverse_d[k] * m[k][j];
            }
            out[i][j] = x;
            out[j][i] = x;
        }
    }
    out
}

/// out = A x for a full matrix.
#[inline(always)]
pub(crate) fn times<T: Real, const B: usize>(a: &[[T; B]; B], x: &[T; B]) -> [T; B] {
    let mut out = [T::ZERO; B];
    for i in 0..B {
        for j in 0..B {
            out[i] += a[i][j] * x[j];
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A times its inverse is the identity, to the condition number (about 1e3) times rounding.
    #[test]
    fn inverse_of_a_gram_matrix() {
        let mut a = [[0.0_f64; 5]; 5];
        for (i, row) in a.iter_mut().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                *x = 1.0 / (1.0 + i as f64 + j as f64) + if i == j { 0.01 } else { 0.0 };
            }
        }
        let mut l = a;
        let d = factor(&mut l);
        let inv = inverse(&l, &d);
        for i in 0..5 {
            let column = core::array::from_fn(|k| inv[k][i]);
            let product = times(&a, &column);
            for (j, x) in product.iter().enumerate() {
                let expected = if i == j { 1.0 } else { 0.0 };
                assert!((x - expected).abs() < 1e-12);
            }
        }
    }
}

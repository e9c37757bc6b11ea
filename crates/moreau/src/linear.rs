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

/// A^-1 x from the factors.
#[inline(always)]
pub(crate) fn solve<T: Real, const B: usize>(l: &[[T; B]; B], inverse_d: &[T; B], x: &[T; B]) -> [T; B] {
    let mut y = *x;
    for i in 0..B {
        for k in 0..i {
            let t = y[k];
            y[i] -= l[i][k] * t;
        }
    }
    for i in (0..B).rev() {
        y[i] = y[i] * inverse_d[i];
        for k in i + 1..B {
            let t = y[k];
            y[i] -= l[k][i] * t;
        }
    }
    y
}

/// Row i of a symmetric matrix, of which the lower triangle is given, times x.
#[inline(always)]
pub(crate) fn symmetric_product<T: Real, const B: usize>(a: &[[T; B]; B], i: usize, x: &[T; B]) -> T {
    let mut sum = T::ZERO;
    for j in 0..i {
        sum += a[i][j] * x[j];
    }
    for j in i..B {
        sum += a[j][i] * x[j];
    }
    sum
}

/// a . b.
#[inline(always)]
pub(crate) fn product<T: Real, const B: usize>(a: &[T; B], b: &[T; B]) -> T {
    let mut sum = T::ZERO;
    for i in 0..B {
        sum += a[i] * b[i];
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A times A^-1 x is x, to the condition number (about 1e3) times rounding.
    #[test]
    fn solves_a_gram_matrix() {
        let mut a = [[0.0_f64; 5]; 5];
        for (i, row) in a.iter_mut().enumerate() {
            for (j, x) in row.iter_mut().enumerate() {
                *x = 1.0 / (1.0 + i as f64 + j as f64) + if i == j { 0.01 } else { 0.0 };
            }
        }
        let mut l = a;
        let d = factor(&mut l);
        let x = [1.0, -2.0, 0.5, 3.0, -1.0];
        let y = solve(&l, &d, &x);
        for i in 0..5 {
            assert!((product(&a[i], &y) - x[i]).abs() < 1e-12);
        }
    }
}

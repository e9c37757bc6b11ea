//! Symmetric positive definite systems of the size of the mechanism: A = L D L^T, without square roots.

use crate::Real;

/// Factorises A, given by its lower triangle and (apart) its diagonal, into `l` (strictly lower: L) and returns 1/D; takes
/// right-hand sides `x` along through the forward substitution, which then waits for nothing.
///
/// A must be positive definite: here a mass matrix plus positive semidefinite terms.
#[inline(always)]
pub(crate) fn factor<T: Real, const B: usize, const R: usize>(
    a: &[[T; B]; B],
    diagonal: &[T; B],
    l: &mut [[T; B]; B],
    x: [&mut [T; B]; R],
) -> [T; B] {
    let mut inverse = [T::ZERO; B];
    // Row by row: while one row's division is under way, the next row's products can be.
    for i in 0..B {
        let mut scaled = a[i];
        let mut d = diagonal[i];
        for j in 0..i {
            for k in 0..j {
                let t = scaled[k];
                scaled[j] -= t * l[j][k];
            }
            l[i][j] = scaled[j] * inverse[j];
            d -= scaled[j] * l[i][j];
        }
        inverse[i] = T::ONE / d;
        for r in 0..R {
            for k in 0..i {
                let t = x[r][k];
                x[r][i] -= l[i][k] * t;
            }
        }
    }
    inverse
}

/// The diagonal of a matrix.
pub(crate) fn diagonal<T: Real, const B: usize>(a: &[[T; B]; B]) -> [T; B] {
    core::array::from_fn(|i| a[i][i])
}

/// The rest of A^-1 x, after [`factor`] has taken x along.
#[inline(always)]
pub(crate) fn back_substitute<T: Real, const B: usize>(l: &[[T; B]; B], inverse_d: &[T; B], x: &mut [T; B]) {
    for i in 0..B {
        x[i] = x[i] * inverse_d[i];
    }
    for i in (0..B).rev() {
        for k in 0..i {
            let t = x[i];
            x[k] -= l[i][k] * t;
        }
    }
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
    back_substitute(l, inverse_d, &mut y);
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
        let mut l = [[0.0; 5]; 5];
        let d = factor(&a, &diagonal(&a), &mut l, []);
        let x = [1.0, -2.0, 0.5, 3.0, -1.0];
        let y = solve(&l, &d, &x);
        for i in 0..5 {
            assert!((product(&a[i], &y) - x[i]).abs() < 1e-12);
        }
    }
}

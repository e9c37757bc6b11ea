//! Linear equations whose unknowns may be redundant.

use moreau::Scalar;

/// Pivots below this part of the largest entry mean an equation that the others hold already.
pub(super) const DEPENDENT: f64 = 1e-11;

/// Gaussian elimination with complete pivoting of the first `m` rows and columns. Unknowns that the others determine
/// already keep the value that `x` came with. Rows that a pivot does not concern cost nothing: blocks in a stack
/// concern their neighbours only.
pub(super) fn eliminate<T: Scalar, const N: usize>(a: &mut [[T; N]; N], rhs: &mut [T; N], x: &mut [T; N], m: usize) {
    let (mut row_used, mut column_used) = ([false; N], [false; N]);
    let mut pivots = [(0usize, 0usize); N];
    // The largest entry of every row, in the columns that are left.
    let mut most = [(T::ZERO, 0usize); N];
    for i in 0..m {
        most[i] = largest(&a[i], &column_used, m);
    }
    // The columns of a pivot's row that are left and not zero.
    let mut concerned = [0usize; N];
    let mut scale = T::ZERO;
    let mut rank = 0;
    while rank < m {
        let (mut best, mut r) = (T::ZERO, 0);
        for i in 0..m {
            if !row_used[i] && best < most[i].0 {
                (best, r) = (most[i].0, i);
            }
        }
        scale = scale.max(best);
        if best <= scale * T::from_f64(DEPENDENT).max(T::from_f64(16.0) * T::EPSILON) {
            break;
        }
        let c = most[r].1;
        (row_used[r], column_used[c]) = (true, true);
        pivots[rank] = (r, c);
        rank += 1;
        let pivot = a[r];
        let mut count = 0;
        for j in 0..m {
            if !column_used[j] && pivot[j] != T::ZERO {
                concerned[count] = j;
                count += 1;
            }
        }
        for i in 0..m {
            if row_used[i] || a[i][c] == T::ZERO {
                continue;
            }
            let factor = a[i][c] / pivot[c];
            for &j in &concerned[..count] {
                a[i][j] -= factor * pivot[j];
            }
            let t = rhs[r];
            rhs[i] -= factor * t;
            most[i] = largest(&a[i], &column_used, m);
        }
    }
    for &(r, c) in pivots[..rank].iter().rev() {
        // Columns of earlier pivots are not part of this row's equation any more.
        let mut s = rhs[r];
        column_used[c] = false;
        for j in 0..m {
            if !column_used[j] && j != c {
                s -= a[r][j] * x[j];
            }
        }
        x[c] = s / a[r][c];
    }
}

fn largest<T: Scalar, const N: usize>(row: &[T; N], used: &[bool; N], m: usize) -> (T, usize) {
    let mut best = (T::ZERO, 0);
    for j in 0..m {
        if !used[j] && best.0 < row[j].abs() {
            best = (row[j].abs(), j);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A regular system, and one whose third equation is the sum of the others: the unknown that is left keeps its
    /// value.
    #[test]
    fn regular_and_redundant() {
        let (mut a, mut rhs, mut x) = ([[2.0, 1.0, 0.0], [0.0, 0.0, 4.0], [1.0, -1.0, 3.0]], [4.0, 8.0, 5.0], [0.0; 3]);
        eliminate(&mut a, &mut rhs, &mut x, 3);
        assert!((x[0] - 1.0_f64).abs() + (x[1] - 2.0).abs() + (x[2] - 2.0).abs() < 1e-14, "{x:?}");
        for kept in [0.0, 7.0] {
            let mut a = [[1.0, 1.0, 0.0], [0.0, 0.0, 2.0], [1.0, 1.0, 2.0]];
            let (mut rhs, mut x) = ([3.0, 4.0, 7.0], [kept, kept, 0.0]);
            eliminate(&mut a, &mut rhs, &mut x, 3);
            assert!((x[2] - 2.0_f64).abs() < 1e-14 && (x[0] + x[1] - 3.0).abs() < 1e-14, "{x:?}");
            assert!(x[0] == kept || x[1] == kept, "{x:?}");
        }
    }
}

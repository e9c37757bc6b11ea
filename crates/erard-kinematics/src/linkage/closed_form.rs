//! Closed-form angles: first guesses for Newton-Raphson.

use std::f64::consts::PI;

/// Both solutions `x` (rad) of `a cos x + b sin x = c`, or `None` if there is none.
///
/// They lie at equal distances on either side of `atan2(b, a)`: the first is the
/// lower one. The equation is Freudenstein's for a four-bar, and that of a point
/// on a circle that must keep a given distance from a line.
#[must_use]
pub(crate) fn cosine_equation(a: f64, b: f64, c: f64) -> Option<[f64; 2]> {
    let amplitude = a.hypot(b);
    let cosine = c / amplitude;
    if cosine.abs() > 1.0 || cosine.is_nan() {
        return None;
    }
    let middle = b.atan2(a);
    let half = cosine.acos();
    Some([middle - half, middle + half])
}

/// Returns the angle equal to `x` (rad) up to whole turns, in (-π, π].
#[must_use]
pub fn wrap(x: f64) -> f64 {
    let y = x.rem_euclid(2.0 * PI);
    if y > PI { y - 2.0 * PI } else { y }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Out of reach is `None`, and so is NaN: never a number.
    #[test]
    fn no_solution_is_none() {
        assert_eq!(cosine_equation(1.0, 0.0, 1.1), None);
        assert_eq!(cosine_equation(f64::NAN, 0.0, 0.0), None);
    }
}

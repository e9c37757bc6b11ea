//! Vectors of the plane.

use crate::real::Real;

/// A vector of the plane, `[x, y]`.
pub type Vector<T> = [T; 2];

#[inline(always)]
pub(crate) fn add<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] + b[0], a[1] + b[1]]
}

#[inline(always)]
pub(crate) fn sub<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] - b[0], a[1] - b[1]]
}

#[inline(always)]
pub(crate) fn scale<T: Real>(a: Vector<T>, s: T) -> Vector<T> {
    [a[0] * s, a[1] * s]
}

#[inline(always)]
pub(crate) fn dot<T: Real>(a: Vector<T>, b: Vector<T>) -> T {
    (a[0] * b[0]).add_product(a[1], b[1])
}

/// The z component of a x b: the lever arm of b about the origin of a, times |b|.
#[inline(always)]
pub(crate) fn cross<T: Real>(a: Vector<T>, b: Vector<T>) -> T {
    (a[0] * b[1]).sub_product(a[1], b[0])
}

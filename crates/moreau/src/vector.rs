//! Vectors of the plane.

use crate::real::Real;

/// A vector of the plane, `[x, y]`.
pub type Vector<T> = [T; 2];

/// a + b.
#[inline(always)]
pub fn add<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] + b[0], a[1] + b[1]]
}

/// a - b.
#[inline(always)]
pub fn sub<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] - b[0], a[1] - b[1]]
}

/// a s.
#[inline(always)]
pub fn scale<T: Real>(a: Vector<T>, s: T) -> Vector<T> {
    [a[0] * s, a[1] * s]
}

/// The scalar product a . b.
#[inline(always)]
pub fn dot<T: Real>(a: Vector<T>, b: Vector<T>) -> T {
    (a[0] * b[0]).add_product(a[1], b[1])
}

/// The z component of a x b: the lever arm of b about the origin of a, times |b|.
#[inline(always)]
pub fn cross<T: Real>(a: Vector<T>, b: Vector<T>) -> T {
    (a[0] * b[1]).sub_product(a[1], b[0])
}

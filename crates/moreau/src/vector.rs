//! Vectors in the plane.

use crate::real::Real;

/// Vector in the plane, `[x, y]`.
pub type Vector<T> = [T; 2];

/// Returns a + b.
#[inline(always)]
pub fn add<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] + b[0], a[1] + b[1]]
}

/// Returns a - b.
#[inline(always)]
pub fn sub<T: Real>(a: Vector<T>, b: Vector<T>) -> Vector<T> {
    [a[0] - b[0], a[1] - b[1]]
}

/// Returns s a.
#[inline(always)]
pub fn scale<T: Real>(a: Vector<T>, s: T) -> Vector<T> {
    [a[0] * s, a[1] * s]
}

/// Returns the scalar product a . b.
#[inline(always)]
pub fn dot<T: Real>(a: Vector<T>, b: Vector<T>) -> T {
    (a[0] * b[0]).add_product(a[1], b[1])
}

/// Returns the z component of a x b: the moment of a force b at the point a about the origin.
#[inline(always)]
pub fn cross<T: Real>(a: Vector<T>, b: Vector<T>) -> T {
    (a[0] * b[1]).sub_product(a[1], b[0])
}

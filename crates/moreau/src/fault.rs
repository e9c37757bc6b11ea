//! Faults of numbers in a description.

use core::fmt;

use crate::real::Scalar;
use crate::vector::{Vector, dot};

/// A number out of its range: its name, its value, and the expected range.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fault {
    /// Name of the number in the description, e.g. `mass`.
    pub field: &'static str,
    /// Value of the number.
    pub found: f64,
    /// Expected range, in words.
    pub expected: &'static str,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} is {}, expected {}", self.field, self.found, self.expected)
    }
}

impl Fault {
    fn unless<T: Scalar>(sound: bool, field: &'static str, x: T, expected: &'static str) -> Option<Self> {
        (!sound).then(|| Fault { field, found: x.to_f64(), expected })
    }

    pub(crate) fn not_finite<T: Scalar>(field: &'static str, x: T) -> Option<Self> {
        Fault::unless(x.finite(), field, x, "a finite number")
    }

    pub(crate) fn negative<T: Scalar>(field: &'static str, x: T) -> Option<Self> {
        Fault::unless(x.finite() && x >= T::ZERO, field, x, "a finite number, at least 0")
    }

    pub(crate) fn not_positive<T: Scalar>(field: &'static str, x: T) -> Option<Self> {
        Fault::unless(x.finite() && x > T::ZERO, field, x, "a finite number greater than 0")
    }

    pub(crate) fn not_a_part<T: Scalar>(field: &'static str, x: T) -> Option<Self> {
        Fault::unless(x.finite() && x >= T::ZERO && x < T::ONE, field, x, "a finite number from 0 to below 1")
    }

    pub(crate) fn below_one<T: Scalar>(field: &'static str, x: T) -> Option<Self> {
        Fault::unless(x.finite() && x >= T::ONE, field, x, "a finite number, at least 1")
    }

    pub(crate) fn vector<T: Scalar>(field: &'static str, x: Vector<T>) -> Option<Self> {
        Fault::not_finite(field, x[0]).or_else(|| Fault::not_finite(field, x[1]))
    }

    /// `found` is the length.
    pub(crate) fn not_unit<T: Scalar>(field: &'static str, x: Vector<T>) -> Option<Self> {
        Fault::vector(field, x).or_else(|| {
            let length = dot(x, x).sqrt();
            let sound = (length - T::ONE).abs() <= T::from_f64(64.0) * T::EPSILON;
            Fault::unless(sound, field, length, "a unit vector (the number is its length)")
        })
    }
}

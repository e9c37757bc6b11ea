//! Dual numbers: a value with its derivatives (forward mode), several directions in one pass.
//!
//! `Dual<D>` is a value and its derivatives in D directions. The kernel runs on it unchanged. Comparisons use the value
//! only, so that every branch is that of the plain number, and the derivative belongs to this branch of the solution.
//! `tangent/` treats the switches between branches.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use crate::power::power;
use crate::real::{COSINE, Real, SINE, Scalar};

/// A Newton iteration on derivatives ends when none of them changes any more by this part of the largest of its
/// direction.
const SETTLED: f64 = 1e-10;
/// Derivatives below this, in the units of the caller, are rounding.
const NOTHING: f64 = 1e-200;

/// A number with its derivatives in D directions.
#[derive(Debug, Clone, Copy)]
pub struct Dual<const D: usize> {
    /// Value of the number.
    pub value: f64,
    /// Derivative in each direction.
    pub slope: [f64; D],
}

impl<const D: usize> Dual<D> {
    /// Returns a number whose derivatives are all zero.
    pub const fn constant(value: f64) -> Self {
        Dual { value, slope: [0.0; D] }
    }

    // What follows is compiled once: copied to every place where a step computes, it was most of what is compiled for
    // derivatives. Numbers go in by reference, which saves a copy of each.

    /// A smooth function of it: its value, and its derivative.
    #[inline(never)]
    fn through(&self, value: f64, derivative: f64) -> Self {
        Dual { value, slope: core::array::from_fn(|k| self.slope[k] * derivative) }
    }

    /// A smooth function of two numbers: its value, and its derivatives by both.
    #[inline(never)]
    fn both(&self, other: &Self, value: f64, own: f64, others: f64) -> Self {
        Dual { value, slope: core::array::from_fn(|k| self.slope[k] * own + other.slope[k] * others) }
    }

    #[inline(never)]
    fn sum(&self, other: &Self) -> Self {
        Dual { value: self.value + other.value, slope: core::array::from_fn(|k| self.slope[k] + other.slope[k]) }
    }

    #[inline(never)]
    fn difference(&self, other: &Self) -> Self {
        Dual { value: self.value - other.value, slope: core::array::from_fn(|k| self.slope[k] - other.slope[k]) }
    }

    /// It plus a times b.
    #[inline(never)]
    fn plus_product(&self, a: &Self, b: &Self) -> Self {
        let slope = core::array::from_fn(|k| self.slope[k] + (a.slope[k] * b.value + b.slope[k] * a.value));
        Dual { value: self.value + a.value * b.value, slope }
    }

    /// It minus a times b.
    #[inline(never)]
    fn minus_product(&self, a: &Self, b: &Self) -> Self {
        let slope = core::array::from_fn(|k| self.slope[k] - (a.slope[k] * b.value + b.slope[k] * a.value));
        Dual { value: self.value - a.value * b.value, slope }
    }

    /// Returns whether value and derivatives are all finite.
    pub fn is_finite(&self) -> bool {
        self.value.is_finite() && self.slope.iter().all(|x| x.is_finite())
    }
}

impl<const D: usize> PartialEq for Dual<D> {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

impl<const D: usize> PartialOrd for Dual<D> {
    fn partial_cmp(&self, other: &Self) -> Option<core::cmp::Ordering> {
        self.value.partial_cmp(&other.value)
    }
}

impl<const D: usize> Add for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        self.sum(&other)
    }
}

impl<const D: usize> Sub for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        self.difference(&other)
    }
}

impl<const D: usize> Mul for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        self.both(&other, self.value * other.value, other.value, self.value)
    }
}

impl<const D: usize> Div for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn div(self, other: Self) -> Self {
        let (value, inverse) = (self.value / other.value, 1.0 / other.value);
        self.both(&other, value, inverse, -value * inverse)
    }
}

impl<const D: usize> Neg for Dual<D> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.through(-self.value, -1.0)
    }
}

impl<const D: usize> AddAssign for Dual<D> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const D: usize> SubAssign for Dual<D> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

const fn constants<const D: usize>(numbers: &[f64; 6]) -> [Dual<D>; 6] {
    let mut all = [Dual::constant(0.0); 6];
    let mut i = 0;
    while i < 6 {
        all[i] = Dual::constant(numbers[i]);
        i += 1;
    }
    all
}

impl<const D: usize> Real for Dual<D> {
    type Mask = bool;
    type Lane = Self;
    const LANES: usize = 1;
    const WRITTEN_OUT: bool = false;
    const ZERO: Self = Dual::constant(0.0);
    const ONE: Self = Dual::constant(1.0);
    const EPSILON: Self = Dual::constant(f64::EPSILON);
    const SINE: &'static [Self; 6] = &constants(&SINE);
    const COSINE: &'static [Self; 6] = &constants(&COSINE);

    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Dual::constant(x)
    }

    #[inline(always)]
    fn join(x: impl Fn(usize) -> Self) -> Self {
        x(0)
    }

    #[inline(always)]
    fn lane(self, _: usize) -> Self {
        self
    }

    #[inline(always)]
    fn with_lane(self, _: usize, x: Self) -> Self {
        x
    }

    #[inline(always)]
    fn add_product(self, a: Self, b: Self) -> Self {
        self.plus_product(&a, &b)
    }

    #[inline(always)]
    fn sub_product(self, a: Self, b: Self) -> Self {
        self.minus_product(&a, &b)
    }

    /// At zero, where the root has no derivative, it is given none: only a number that is zero whatever the directions
    /// are has one there.
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = libm::sqrt(self.value);
        self.through(root, if root > 0.0 { 0.5 / root } else { 0.0 })
    }

    #[inline(always)]
    fn abs(self) -> Self {
        if self.value < 0.0 { -self } else { self }
    }

    #[inline(always)]
    fn max(self, other: Self) -> Self {
        if self.value < other.value { other } else { self }
    }

    #[inline(always)]
    fn min(self, other: Self) -> Self {
        if other.value < self.value { other } else { self }
    }

    #[inline(always)]
    fn lt(self, other: Self) -> bool {
        self.value < other.value
    }

    #[inline(always)]
    fn le(self, other: Self) -> bool {
        self.value <= other.value
    }

    #[inline(always)]
    fn finite(self) -> bool {
        self.value.is_finite()
    }

    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }

    fn powf(self, exponent: Self) -> Self {
        let value = power(self.value, exponent.value);
        if self.value > 0.0 {
            let by_base = exponent.value * power(self.value, exponent.value - 1.0);
            self.both(&exponent, value, by_base, value * libm::log(self.value))
        } else {
            // Zero to a power: smooth from one on, and whatever the power is.
            Dual::constant(value)
        }
    }

    fn tanh(self) -> Self {
        let value = libm::tanh(self.value);
        self.through(value, 1.0 - value * value)
    }

    #[cold]
    fn sin_cos_any(self) -> (Self, Self) {
        let (s, c) = libm::sincos(self.value);
        (self.through(s, c), self.through(c, -s))
    }

    fn is_zero(self) -> bool {
        self.value == 0.0 && self.slope.iter().all(|x| *x == 0.0)
    }
    fn derivatives_settled(corrections: &[Self], values: &[Self]) -> bool {
        let (mut change, mut size) = ([0.0_f64; D], [NOTHING; D]);
        for k in 0..D {
            for x in corrections {
                change[k] = change[k].max(x.slope[k].abs());
            }
            for x in values {
                size[k] = size[k].max(x.slope[k].abs());
            }
        }
        (0..D).all(|k| change[k] <= SETTLED * size[k])
    }
}

impl<const D: usize> Scalar for Dual<D> {
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self.value
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every operation against the derivative that calculus gives.
    #[test]
    fn derivatives_are_those_of_calculus() {
        let (x, y) = (Dual { value: 0.7, slope: [1.0, 0.0] }, Dual { value: -1.3, slope: [0.0, 1.0] });
        let close = |found: Dual<2>, value: f64, slope: [f64; 2]| {
            assert!((found.value - value).abs() < 1e-14, "{found:?} {value}");
            for k in 0..2 {
                assert!((found.slope[k] - slope[k]).abs() < 1e-13, "{found:?} {slope:?}");
            }
        };
        close(x + y, -0.6, [1.0, 1.0]);
        close(x - y, 2.0, [1.0, -1.0]);
        close(x * y, -0.91, [-1.3, 0.7]);
        close(x / y, 0.7 / -1.3, [1.0 / -1.3, -0.7 / 1.69]);
        close(-y, 1.3, [0.0, -1.0]);
        close(y.abs(), 1.3, [0.0, -1.0]);
        close(x.sqrt(), 0.7_f64.sqrt(), [0.5 / 0.7_f64.sqrt(), 0.0]);
        close(Dual::constant(0.0).sqrt(), 0.0, [0.0, 0.0]);
        close(x.max(y), 0.7, [1.0, 0.0]);
        close(x.min(y), -1.3, [0.0, 1.0]);
        close(Dual::select(true, x, y), 0.7, [1.0, 0.0]);
        close(x.add_product(x, y), 0.7 - 0.91, [1.0 - 1.3, 0.7]);
        let power = 0.7_f64.powf(-1.3);
        close(x.powf(y), power, [-1.3 * power / 0.7, power * 0.7_f64.ln()]);
        let tanh = 0.7_f64.tanh();
        close(x.tanh(), tanh, [1.0 - tanh * tanh, 0.0]);
        let (s, c) = y.sin_cos_any();
        close(s, (-1.3_f64).sin(), [0.0, (-1.3_f64).cos()]);
        close(c, (-1.3_f64).cos(), [0.0, -(-1.3_f64).sin()]);
        assert!(y < x && x != y && x.finite() && !Dual::<2>::constant(f64::NAN).is_finite());
        assert!(!Dual { value: 1.0, slope: [f64::NAN] }.is_finite());
    }
}

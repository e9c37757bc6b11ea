//! Numbers for the equations of motion: plain ones, and ones that carry a derivative.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Operations that the equations need.
pub(crate) trait Number:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// A constant.
    fn constant(x: f64) -> Self;
    /// The value, without its derivative.
    fn value(self) -> f64;
    /// Multiplies by a constant.
    fn times(self, x: f64) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// Square root.
    fn sqrt(self) -> Self;
    /// A constant power.
    fn powf(self, r: f64) -> Self;
    /// Hyperbolic tangent.
    fn tanh(self) -> Self;
}

impl Number for f64 {
    #[inline(always)]
    fn constant(x: f64) -> Self {
        x
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self
    }
    #[inline(always)]
    fn times(self, x: f64) -> Self {
        self * x
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    #[inline(always)]
    fn powf(self, r: f64) -> Self {
        f64::powf(self, r)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        // Takes a third of the library's time; its relative precision near zero is not needed.
        1.0 - 2.0 / ((2.0 * self).exp() + 1.0)
    }
}

/// A number and its derivative in one direction (forward-mode differentiation).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Dual {
    /// Value.
    pub value: f64,
    /// Derivative.
    pub slope: f64,
}

impl Dual {
    /// A function of one variable with this value and derivative.
    #[inline(always)]
    fn through(self, value: f64, derivative: f64) -> Self {
        Dual { value, slope: derivative * self.slope }
    }
}

impl Add for Dual {
    type Output = Dual;
    #[inline(always)]
    fn add(self, o: Dual) -> Dual {
        Dual { value: self.value + o.value, slope: self.slope + o.slope }
    }
}

impl Sub for Dual {
    type Output = Dual;
    #[inline(always)]
    fn sub(self, o: Dual) -> Dual {
        Dual { value: self.value - o.value, slope: self.slope - o.slope }
    }
}

impl Mul for Dual {
    type Output = Dual;
    #[inline(always)]
    fn mul(self, o: Dual) -> Dual {
        Dual { value: self.value * o.value, slope: self.slope * o.value + self.value * o.slope }
    }
}

impl Div for Dual {
    type Output = Dual;
    #[inline(always)]
    fn div(self, o: Dual) -> Dual {
        let quotient = self.value / o.value;
        Dual { value: quotient, slope: (self.slope - quotient * o.slope) / o.value }
    }
}

impl Neg for Dual {
    type Output = Dual;
    #[inline(always)]
    fn neg(self) -> Dual {
        Dual { value: -self.value, slope: -self.slope }
    }
}

impl AddAssign for Dual {
    #[inline(always)]
    fn add_assign(&mut self, o: Dual) {
        *self = *self + o;
    }
}

impl SubAssign for Dual {
    #[inline(always)]
    fn sub_assign(&mut self, o: Dual) {
        *self = *self - o;
    }
}

impl Number for Dual {
    #[inline(always)]
    fn constant(x: f64) -> Self {
        Dual { value: x, slope: 0.0 }
    }
    #[inline(always)]
    fn value(self) -> f64 {
        self.value
    }
    #[inline(always)]
    fn times(self, x: f64) -> Self {
        Dual { value: self.value * x, slope: self.slope * x }
    }
    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (self.through(s, c), self.through(c, -s))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        self.through(root, 0.5 / root)
    }
    #[inline(always)]
    fn powf(self, r: f64) -> Self {
        let lower = self.value.powf(r - 1.0);
        self.through(lower * self.value, r * lower)
    }
    #[inline(always)]
    fn tanh(self) -> Self {
        let t = Number::tanh(self.value);
        self.through(t, 1.0 - t * t)
    }
}

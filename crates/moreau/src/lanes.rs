//! Several numbers side by side: the scalar that steps as many mechanisms at once.
//!
//! Plain arrays, no processor's own instructions: the compiler makes vectors of them for whatever target the code around is
//! compiled for. Every lane computes what a single `f64` would.

use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use crate::{Mask, Real};

/// `L` numbers in double precision.
#[derive(Debug, Clone, Copy, PartialEq)]
#[repr(align(32))]
pub struct Lanes<const L: usize>(pub [f64; L]);

/// One truth value per lane: all bits set, or none.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(align(32))]
pub struct LaneMask<const L: usize>([u64; L]);

impl<const L: usize> LaneMask<L> {
    #[inline(always)]
    fn map2(self, other: Self, f: impl Fn(u64, u64) -> u64) -> Self {
        let mut out = self;
        for i in 0..L {
            out.0[i] = f(self.0[i], other.0[i]);
        }
        out
    }
}

impl<const L: usize> Mask for LaneMask<L> {
    #[inline(always)]
    fn any(self) -> bool {
        let mut bits = 0;
        for i in 0..L {
            bits |= self.0[i];
        }
        bits != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        let mut bits = u64::MAX;
        for i in 0..L {
            bits &= self.0[i];
        }
        bits != 0
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self.map2(other, |a, b| a & b)
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self.map2(other, |a, b| a | b)
    }
    #[inline(always)]
    fn not(self) -> Self {
        self.map2(self, |a, _| !a)
    }
    #[inline(always)]
    fn splat(value: bool) -> Self {
        LaneMask([if value { u64::MAX } else { 0 }; L])
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> bool {
        self.0[lane] != 0
    }
}

impl<const L: usize> Lanes<L> {
    #[inline(always)]
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        let mut out = self;
        for i in 0..L {
            out.0[i] = f(self.0[i]);
        }
        out
    }

    #[inline(always)]
    fn map2(self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let mut out = self;
        for i in 0..L {
            out.0[i] = f(self.0[i], other.0[i]);
        }
        out
    }

    #[inline(always)]
    fn compare(self, other: Self, f: impl Fn(f64, f64) -> bool) -> LaneMask<L> {
        let mut out = LaneMask([0; L]);
        for i in 0..L {
            out.0[i] = if f(self.0[i], other.0[i]) { u64::MAX } else { 0 };
        }
        out
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $op:tt) => {
        impl<const L: usize> $trait for Lanes<L> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                self.map2(other, |a, b| a $op b)
            }
        }
    };
}

operator!(Add, add, +);
operator!(Sub, sub, -);
operator!(Mul, mul, *);
operator!(Div, div, /);

impl<const L: usize> Neg for Lanes<L> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl<const L: usize> AddAssign for Lanes<L> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<const L: usize> SubAssign for Lanes<L> {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl<const L: usize> Real for Lanes<L> {
    type Mask = LaneMask<L>;
    type Lane = f64;
    const LANES: usize = L;
    const ZERO: Self = Lanes([0.0; L]);
    const ONE: Self = Lanes([1.0; L]);
    const EPSILON: Self = Lanes([f64::EPSILON; L]);
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        Lanes([x; L])
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        self.0[lane]
    }
    #[inline(always)]
    fn with_lane(mut self, lane: usize, x: f64) -> Self {
        self.0[lane] = x;
        self
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        self.map(libm::sqrt)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        self.map(f64::abs)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.map2(other, |a, b| if a < b { b } else { a })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.map2(other, |a, b| if b < a { b } else { a })
    }
    #[inline(always)]
    fn lt(self, other: Self) -> LaneMask<L> {
        self.compare(other, |a, b| a < b)
    }
    #[inline(always)]
    fn le(self, other: Self) -> LaneMask<L> {
        self.compare(other, |a, b| a <= b)
    }
    #[inline(always)]
    fn finite(self) -> LaneMask<L> {
        self.compare(self, |a, _| a.is_finite())
    }
    #[inline(always)]
    fn select(mask: LaneMask<L>, yes: Self, no: Self) -> Self {
        let mut out = no;
        for i in 0..L {
            out.0[i] = f64::from_bits(yes.0[i].to_bits() & mask.0[i] | no.0[i].to_bits() & !mask.0[i]);
        }
        out
    }
    fn powf(self, exponent: Self) -> Self {
        self.map2(exponent, libm::pow)
    }
    fn tanh(self) -> Self {
        self.map(libm::tanh)
    }
    #[cold]
    fn sin_cos_any(self) -> (Self, Self) {
        let (mut sin, mut cos) = (self, self);
        for i in 0..L {
            (sin.0[i], cos.0[i]) = libm::sincos(self.0[i]);
        }
        (sin, cos)
    }
}

//! Scalar type of the kernel.
//!
//! The kernel compares through masks and chooses through [`Real::select`], so that one source serves a single number
//! (mask = `bool`), several SIMD lanes, and dual numbers. Results are bit-identical on every target: the kernel uses
//! only `+ - * /`, square root and the `libm` crate.

use core::fmt::Debug;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Result of a comparison: one truth value per lane.
pub trait Mask: Copy + Debug {
    /// Returns whether any lane is true.
    fn any(self) -> bool;
    /// Returns whether every lane is true.
    fn all(self) -> bool;
    /// Lane-wise conjunction.
    fn and(self, other: Self) -> Self;
    /// Lane-wise disjunction.
    fn or(self, other: Self) -> Self;
    /// Lane-wise negation.
    fn not(self) -> Self;
    /// Returns a mask with this truth value in every lane.
    fn splat(value: bool) -> Self;
    /// Returns the truth value of one lane.
    fn lane(self, lane: usize) -> bool;
}

impl Mask for bool {
    #[inline(always)]
    fn any(self) -> bool {
        self
    }
    #[inline(always)]
    fn all(self) -> bool {
        self
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        self & other
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        self | other
    }
    #[inline(always)]
    fn not(self) -> Self {
        !self
    }
    #[inline(always)]
    fn splat(value: bool) -> Self {
        value
    }
    #[inline(always)]
    fn lane(self, _: usize) -> bool {
        self
    }
}

/// A real number, or one real number per lane.
pub trait Real:
    Copy
    + 'static
    + Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    /// Result type of a comparison.
    type Mask: Mask;
    /// Number type of one lane.
    type Lane: Scalar;
    /// Number of lanes.
    const LANES: usize;
    /// Whether a step's first Newton iteration is compiled separately from the further ones. This is faster, but
    /// doubles the code to compile.
    const FIRST_APART: bool = false;
    /// Whether loops over the rows of a matrix are written out. This is faster where a number fits into a register.
    const WRITTEN_OUT: bool = true;
    /// Zero.
    const ZERO: Self;
    /// One.
    const ONE: Self;
    /// Distance from 1 to the next larger number.
    const EPSILON: Self;
    /// Coefficients of [`SINE`] in this type.
    const SINE: &'static [Self; 6];
    /// Coefficients of [`COSINE`] in this type.
    const COSINE: &'static [Self; 6];
    /// Returns the nearest representable number (in every lane).
    fn from_f64(x: f64) -> Self;
    /// Returns one number per lane, from a function of the lane's index.
    fn join(x: impl Fn(usize) -> Self::Lane) -> Self;
    /// Returns the number of one lane.
    fn lane(self, lane: usize) -> Self::Lane;
    /// Returns the number of one lane, read where it stands. What reads a lane that is not known when this is compiled
    /// needs no copy of all lanes.
    #[inline(always)]
    fn lane_in(&self, lane: usize) -> Self::Lane {
        self.lane(lane)
    }
    /// Returns these numbers with another one in one lane.
    fn with_lane(self, lane: usize, x: Self::Lane) -> Self;
    /// Returns self + a b. Lanes round once, with one fused instruction. A single number rounds twice, product and sum,
    /// so that its bits are the same on targets without that instruction.
    #[inline(always)]
    fn add_product(self, a: Self, b: Self) -> Self {
        self + a * b
    }
    /// Returns self - a b, rounded as [`Real::add_product`] rounds.
    #[inline(always)]
    fn sub_product(self, a: Self, b: Self) -> Self {
        self - a * b
    }
    /// Returns the square root.
    fn sqrt(self) -> Self;
    /// Returns the absolute value.
    fn abs(self) -> Self;
    /// Returns the larger of the two.
    fn max(self, other: Self) -> Self;
    /// Returns the smaller of the two.
    fn min(self, other: Self) -> Self;
    /// Returns self < other.
    fn lt(self, other: Self) -> Self::Mask;
    /// Returns self <= other.
    fn le(self, other: Self) -> Self::Mask;
    /// Returns whether the number is neither infinite nor NaN.
    fn finite(self) -> Self::Mask;
    /// Returns `yes` where the mask is true, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Returns `x` where the mask is true, 0 elsewhere.
    #[inline(always)]
    fn only(mask: Self::Mask, x: Self) -> Self {
        Self::select(mask, x, Self::ZERO)
    }
    /// Returns self^exponent, for self >= 0. Slow; the kernel avoids it for the usual felt exponents.
    fn powf(self, exponent: Self) -> Self;
    /// Returns the hyperbolic tangent. Slow; only regularised friction uses it.
    fn tanh(self) -> Self;
    /// Returns sine and cosine of any angle, rad. Slow; the kernel uses it for angles beyond a quarter of pi.
    fn sin_cos_any(self) -> (Self, Self);
    /// Returns whether the number is zero in every lane, and so are its derivatives where it carries any.
    #[inline(always)]
    fn is_zero(self) -> bool {
        self.le(Self::ZERO).and(Self::ZERO.le(self)).all()
    }
    /// Runs work that was moved out of line. Lanes run it in a function compiled for their instructions. See
    /// [`Aside::run`].
    #[inline(always)]
    fn aside<W: Aside>(work: W) -> W::Output {
        work.run()
    }
    /// Returns whether Newton's method has converged for the derivatives that these numbers carry, given its last
    /// `corrections`. Always true for numbers without derivatives ([`Dual`](crate::Dual) has them).
    #[inline(always)]
    fn derivatives_settled(corrections: &[Self], values: &[Self]) -> Self::Mask {
        let _ = (corrections, values);
        Self::Mask::splat(true)
    }
}

/// Work that few steps or few mechanisms need. It is done in a function out of line, so that the others pay nothing for
/// it. In lanes such a function passes its work to [`Real::aside`]. This is a trait because a closure cannot be
/// `#[inline(always)]`.
pub trait Aside {
    /// Result of the work.
    type Output;
    /// Does the work. This function and all functions on numbers that it calls must be `#[inline(always)]`: the
    /// compiler does not inline lane operations into a function that is not compiled for the lanes' instructions, and
    /// each of them would become a call.
    fn run(self) -> Self::Output;
}

/// Hides from the compiler, in lanes, what a reference points to.
///
/// The compiler hoists out of a loop the loads that do not change in it, and the addresses. Lanes have too few
/// registers to keep them, so it spills them to the stack. A loop that usually runs once only pays for that.
#[inline(always)]
pub(crate) fn opaque<T: Real, R>(reference: R) -> R {
    if T::LANES > 1 { core::hint::black_box(reference) } else { reference }
}

/// A [`Real`] with one lane.
pub trait Scalar: Real<Mask = bool, Lane = Self> + PartialOrd {
    /// Converts to double precision, by widening or rounding.
    fn to_f64(self) -> f64;
}

/// Coefficients of the sine on [-pi/4, pi/4], of x^13, x^11 ... x^3 (fdlibm's `__kernel_sin`).
pub const SINE: [f64; 6] = [
    1.589_690_995_211_55e-10,
    -2.505_076_025_340_686_3e-8,
    2.755_731_370_707_007e-6,
    -1.984_126_982_985_795e-4,
    8.333_333_333_322_49e-3,
    -1.666_666_666_666_663_2e-1,
];
/// Coefficients of the cosine on [-pi/4, pi/4], of x^14, x^12 ... x^4 (fdlibm's `__kernel_cos`).
pub const COSINE: [f64; 6] = [
    -1.135_964_755_778_819_5e-11,
    2.087_572_321_298_175e-9,
    -2.755_731_435_139_066_3e-7,
    2.480_158_728_947_673e-5,
    -1.388_888_888_887_411e-3,
    4.166_666_666_666_66e-2,
];

/// Sines and cosines of angles, radians.
///
/// Bodies of a mechanism stay near their drawn angle, so the usual case is the polynomial on [-pi/4, pi/4] (error below
/// one unit in the last place); elsewhere `libm`.
#[inline(always)]
pub(crate) fn sin_cos<T: Real, const B: usize>(angle: &[T; B], sin: &mut [T; B], cos: &mut [T; B]) {
    // Lanes have no registers left for these constants. To read them from memory at full width is cheaper than what the
    // compiler would do instead, to broadcast each from a single number.
    let (sine, cosine) = (opaque::<T, _>(T::SINE), opaque::<T, _>(T::COSINE));
    let mut largest = T::ZERO;
    for i in 0..B {
        (sin[i], cos[i]) = near_zero(angle[i], sine, cosine);
    }
    for i in 0..B {
        largest = largest.max(angle[i].abs());
    }
    // What is not a number is not larger either; its sine is not a number in both branches.
    if T::from_f64(core::f64::consts::FRAC_PI_4).lt(largest).any() {
        far_from_zero(angle, sin, cos);
    }
}

#[cold]
#[inline(never)]
fn far_from_zero<T: Real, const B: usize>(angle: &[T; B], sin: &mut [T; B], cos: &mut [T; B]) {
    for i in 0..B {
        let far = T::from_f64(core::f64::consts::FRAC_PI_4).lt(angle[i].abs());
        if far.any() {
            let (s, c) = angle[i].sin_cos_any();
            (sin[i], cos[i]) = (T::select(far, s, sin[i]), T::select(far, c, cos[i]));
        }
    }
}

#[inline(always)]
fn near_zero<T: Real>(x: T, sine: &[T; 6], cosine: &[T; 6]) -> (T, T) {
    let z = x * x;
    let polynomial = |[first, rest @ ..]: &[T; 6]| rest.iter().fold(*first, |sum, &next| next.add_product(z, sum));
    let sin = x.add_product(x * z, polynomial(sine));
    let cos = T::ONE.sub_product(z, T::from_f64(0.5).sub_product(z, polynomial(cosine)));
    (sin, cos)
}

/// A number in another precision.
#[inline(always)]
pub(crate) fn cast<S: Scalar, L: Scalar>(x: S) -> L {
    L::from_f64(x.to_f64())
}

/// A number per lane, in the lanes' precision.
#[inline(always)]
pub(crate) fn join<S: Scalar, T: Real>(x: impl Fn(usize) -> S) -> T {
    T::join(|lane| cast(x(lane)))
}

/// As many of them as an array has.
pub(crate) fn join_all<S: Scalar, T: Real, const K: usize>(x: impl Fn(usize) -> [S; K]) -> [T; K] {
    // Compiled once for all lists of a length: mechanisms are put into lanes once, and their lists are many.
    #[inline(never)]
    fn joined<S: Scalar, T: Real, const K: usize>(x: &dyn Fn(usize) -> [S; K]) -> [T; K] {
        core::array::from_fn(|k| join(|lane| x(lane)[k]))
    }
    joined(&x)
}

/// Whether two numbers are the same to the bit in every lane. Widening to f64 keeps every bit's meaning.
pub(crate) fn same_bits<T: Real>(a: T, b: T) -> bool {
    (0..T::LANES).all(|lane| a.lane(lane).to_f64().to_bits() == b.lane(lane).to_f64().to_bits())
}

macro_rules! in_precision {
    ($numbers:ident, $t:ident) => {{
        let (mut all, mut i) = ([0.0; $numbers.len()], 0);
        while i < $numbers.len() {
            all[i] = $numbers[i] as $t;
            i += 1;
        }
        all
    }};
}

macro_rules! real_for {
    ($t:ident, $sqrt:path, $pow:path, $tanh:path, $sincos:path) => {
        impl Real for $t {
            type Mask = bool;
            type Lane = $t;
            const LANES: usize = 1;
            const FIRST_APART: bool = true;
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = $t::EPSILON;
            const SINE: &'static [Self; 6] = &in_precision!(SINE, $t);
            const COSINE: &'static [Self; 6] = &in_precision!(COSINE, $t);
            #[inline(always)]
            fn from_f64(x: f64) -> Self {
                x as $t
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
            fn sqrt(self) -> Self {
                $sqrt(self)
            }
            #[inline(always)]
            fn abs(self) -> Self {
                $t::abs(self)
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self < other { other } else { self }
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if other < self { other } else { self }
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn le(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn finite(self) -> bool {
                self.is_finite()
            }
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
            fn powf(self, exponent: Self) -> Self {
                $pow(self, exponent)
            }
            fn tanh(self) -> Self {
                $tanh(self)
            }
            #[cold]
            fn sin_cos_any(self) -> (Self, Self) {
                $sincos(self)
            }
        }
        impl Scalar for $t {
            #[inline(always)]
            #[allow(clippy::unnecessary_cast)]
            fn to_f64(self) -> f64 {
                self as f64
            }
        }
    };
}

real_for!(f64, libm::sqrt, crate::power::power, libm::tanh, libm::sincos);
real_for!(f32, libm::sqrtf, libm::powf, libm::tanhf, libm::sincosf);

#[cfg(test)]
mod tests {
    use super::*;

    fn sine_and_cosine(x: f64) -> [f64; 2] {
        let (mut s, mut c) = ([0.0], [0.0]);
        sin_cos(&[x], &mut s, &mut c);
        [s[0], c[0]]
    }

    /// The polynomial agrees with `libm` to two units in the last place on its interval.
    #[test]
    fn sin_cos_matches_libm() {
        for i in -1000..=1000 {
            let x = f64::from(i) * core::f64::consts::FRAC_PI_4 / 1000.0;
            let [s, c] = sine_and_cosine(x);
            let (s_ref, c_ref) = libm::sincos(x);
            assert!((s - s_ref).abs() <= 2.0 * f64::EPSILON * s_ref.abs(), "sin {x}");
            assert!((c - c_ref).abs() <= 2.0 * f64::EPSILON, "cos {x}");
        }
        let [s, c] = sine_and_cosine(10.0);
        assert_eq!((s, c), libm::sincos(10.0));
    }
}

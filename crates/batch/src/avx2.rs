//! Four doubles in one 256-bit register.
//!
//! Private to this crate: these numbers exist only inside `avx2_step`, which is entered after the processor has been asked for
//! AVX2. That is what makes the intrinsics below sound.

use core::arch::x86_64::{
    __m256d, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_pd, _mm256_and_pd, _mm256_andnot_pd, _mm256_blendv_pd, _mm256_cmp_pd,
    _mm256_div_pd, _mm256_max_pd, _mm256_min_pd, _mm256_movemask_pd, _mm256_mul_pd, _mm256_or_pd, _mm256_set1_pd,
    _mm256_sqrt_pd, _mm256_sub_pd, _mm256_xor_pd,
};
use core::fmt;
use core::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

use moreau::{Mask, Real};

#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct F64x4(__m256d);

#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct M64x4(__m256d);

/// Every use is in code that only `avx2_step` reaches.
macro_rules! avx {
    ($e:expr) => {
        // SAFETY: AVX2 has been detected, see the module's documentation.
        unsafe { $e }
    };
}

impl From<[f64; 4]> for F64x4 {
    #[inline(always)]
    fn from(x: [f64; 4]) -> Self {
        // SAFETY: both are 32 bytes of plain numbers.
        F64x4(unsafe { core::mem::transmute::<[f64; 4], __m256d>(x) })
    }
}

impl From<F64x4> for [f64; 4] {
    #[inline(always)]
    fn from(x: F64x4) -> Self {
        // SAFETY: both are 32 bytes of plain numbers.
        unsafe { core::mem::transmute::<__m256d, [f64; 4]>(x.0) }
    }
}

impl fmt::Debug for F64x4 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        <[f64; 4]>::from(*self).fmt(f)
    }
}

impl fmt::Debug for M64x4 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        <[f64; 4]>::from(F64x4(self.0)).map(|x| x.to_bits() != 0).fmt(f)
    }
}

impl Mask for M64x4 {
    #[inline(always)]
    fn any(self) -> bool {
        avx!(_mm256_movemask_pd(self.0)) != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        avx!(_mm256_movemask_pd(self.0)) == 15
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        M64x4(avx!(_mm256_and_pd(self.0, other.0)))
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        M64x4(avx!(_mm256_or_pd(self.0, other.0)))
    }
    #[inline(always)]
    fn not(self) -> Self {
        M64x4(avx!(_mm256_xor_pd(self.0, Self::splat(true).0)))
    }
    #[inline(always)]
    fn splat(value: bool) -> Self {
        M64x4(F64x4::from([f64::from_bits(if value { u64::MAX } else { 0 }); 4]).0)
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> bool {
        avx!(_mm256_movemask_pd(self.0)) >> lane & 1 != 0
    }
}

macro_rules! operator {
    ($trait:ident, $method:ident, $intrinsic:ident) => {
        impl $trait for F64x4 {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                F64x4(avx!($intrinsic(self.0, other.0)))
            }
        }
    };
}

operator!(Add, add, _mm256_add_pd);
operator!(Sub, sub, _mm256_sub_pd);
operator!(Mul, mul, _mm256_mul_pd);
operator!(Div, div, _mm256_div_pd);

impl Neg for F64x4 {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        F64x4(avx!(_mm256_xor_pd(self.0, F64x4::from([-0.0; 4]).0)))
    }
}

impl AddAssign for F64x4 {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl SubAssign for F64x4 {
    #[inline(always)]
    fn sub_assign(&mut self, other: Self) {
        *self = *self - other;
    }
}

impl F64x4 {
    fn map(self, f: impl Fn(f64) -> f64) -> Self {
        <[f64; 4]>::from(self).map(f).into()
    }

    const fn constant(x: f64) -> Self {
        // SAFETY: both are 32 bytes of plain numbers.
        F64x4(unsafe { core::mem::transmute::<[f64; 4], __m256d>([x; 4]) })
    }
}

impl Real for F64x4 {
    type Mask = M64x4;
    type Lane = f64;
    const LANES: usize = 4;
    const ZERO: Self = F64x4::constant(0.0);
    const ONE: Self = F64x4::constant(1.0);
    const EPSILON: Self = F64x4::constant(f64::EPSILON);
    #[inline(always)]
    fn from_f64(x: f64) -> Self {
        F64x4(avx!(_mm256_set1_pd(x)))
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> f64 {
        <[f64; 4]>::from(self)[lane]
    }
    #[inline(always)]
    fn with_lane(self, lane: usize, x: f64) -> Self {
        let mut all = <[f64; 4]>::from(self);
        all[lane] = x;
        all.into()
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        F64x4(avx!(_mm256_sqrt_pd(self.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        F64x4(avx!(_mm256_andnot_pd(F64x4::constant(-0.0).0, self.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        // Of two numbers of which one is not a number, the intrinsic takes its second: here as in the scalar's `if self < other`.
        F64x4(avx!(_mm256_max_pd(other.0, self.0)))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        F64x4(avx!(_mm256_min_pd(other.0, self.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M64x4 {
        M64x4(avx!(_mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M64x4 {
        M64x4(avx!(_mm256_cmp_pd::<_CMP_LE_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn finite(self) -> M64x4 {
        self.abs().lt(Self::constant(f64::INFINITY))
    }
    #[inline(always)]
    fn select(mask: M64x4, yes: Self, no: Self) -> Self {
        F64x4(avx!(_mm256_blendv_pd(no.0, yes.0, mask.0)))
    }
    #[inline(never)]
    fn powf(self, exponent: Self) -> Self {
        let (x, r) = (<[f64; 4]>::from(self), <[f64; 4]>::from(exponent));
        core::array::from_fn::<f64, 4, _>(|i| libm::pow(x[i], r[i])).into()
    }
    #[inline(never)]
    fn tanh(self) -> Self {
        self.map(libm::tanh)
    }
    #[inline(never)]
    fn sin_cos_any(self) -> (Self, Self) {
        let both = <[f64; 4]>::from(self).map(libm::sincos);
        (both.map(|(s, _)| s).into(), both.map(|(_, c)| c).into())
    }
}

//! Four doubles in one 256-bit register.

use core::arch::x86_64::{
    __m256d, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_pd, _mm256_and_pd, _mm256_andnot_pd, _mm256_blendv_pd, _mm256_cmp_pd,
    _mm256_div_pd, _mm256_fmadd_pd, _mm256_fnmadd_pd, _mm256_max_pd, _mm256_min_pd, _mm256_movemask_pd, _mm256_mul_pd,
    _mm256_or_pd, _mm256_set1_pd, _mm256_sqrt_pd, _mm256_sub_pd, _mm256_xor_pd,
};

use crate::number::{operator, simd, vector_number};

vector_number! {
    F64x4, M64x4, __m256d, f64, 4,
    add: _mm256_add_pd, sub: _mm256_sub_pd, mul: _mm256_mul_pd, div: _mm256_div_pd,
    fused: _mm256_fmadd_pd, fused_minus: _mm256_fnmadd_pd,
    sqrt: _mm256_sqrt_pd, max: _mm256_max_pd, min: _mm256_min_pd, splat: _mm256_set1_pd,
    pow: libm::pow, tanh: libm::tanh, sincos: libm::sincos,
}

/// All bits of a lane are set where it is true.
#[derive(Clone, Copy)]
#[repr(transparent)]
pub(crate) struct M64x4(__m256d);

#[inline(always)]
fn less(a: F64x4, b: F64x4) -> M64x4 {
    M64x4(simd!(_mm256_cmp_pd::<_CMP_LT_OQ>(a.0, b.0)))
}

#[inline(always)]
fn at_most(a: F64x4, b: F64x4) -> M64x4 {
    M64x4(simd!(_mm256_cmp_pd::<_CMP_LE_OQ>(a.0, b.0)))
}

#[inline(always)]
fn choose(mask: M64x4, yes: F64x4, no: F64x4) -> F64x4 {
    F64x4(simd!(_mm256_blendv_pd(no.0, yes.0, mask.0)))
}

#[inline(always)]
fn kept(mask: M64x4, x: F64x4) -> F64x4 {
    F64x4(simd!(_mm256_and_pd(mask.0, x.0)))
}

#[inline(always)]
fn magnitude(x: F64x4) -> F64x4 {
    F64x4(simd!(_mm256_andnot_pd(F64x4::constant(-0.0).0, x.0)))
}

#[inline(always)]
fn negated(x: F64x4) -> F64x4 {
    F64x4(simd!(_mm256_xor_pd(x.0, F64x4::constant(-0.0).0)))
}

impl core::fmt::Debug for M64x4 {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        <[f64; 4]>::from(F64x4(self.0)).map(|x| x.to_bits() != 0).fmt(f)
    }
}

impl moreau::Mask for M64x4 {
    #[inline(always)]
    fn any(self) -> bool {
        simd!(_mm256_movemask_pd(self.0)) != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        simd!(_mm256_movemask_pd(self.0)) == 15
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        M64x4(simd!(_mm256_and_pd(self.0, other.0)))
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        M64x4(simd!(_mm256_or_pd(self.0, other.0)))
    }
    #[inline(always)]
    fn not(self) -> Self {
        M64x4(simd!(_mm256_xor_pd(self.0, Self::splat(true).0)))
    }
    #[inline(always)]
    fn splat(value: bool) -> Self {
        M64x4(F64x4::from([f64::from_bits(if value { u64::MAX } else { 0 }); 4]).0)
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> bool {
        simd!(_mm256_movemask_pd(self.0)) >> lane & 1 != 0
    }
}

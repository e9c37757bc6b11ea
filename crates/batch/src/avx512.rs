//! Eight doubles in one 512-bit register; comparisons go to mask registers.

use core::arch::x86_64::{
    __m512d, __mmask8, _CMP_LE_OQ, _CMP_LT_OQ, _mm512_abs_pd, _mm512_add_pd, _mm512_cmp_pd_mask, _mm512_div_pd,
    _mm512_fmadd_pd, _mm512_fnmadd_pd, _mm512_mask_blend_pd, _mm512_maskz_mov_pd, _mm512_max_pd, _mm512_min_pd,
    _mm512_mul_pd, _mm512_set1_pd, _mm512_sqrt_pd, _mm512_sub_pd,
};

use crate::number::{operator, simd, vector_number};

vector_number! {
    F64x8, M64x8, __m512d, f64, 8,
    add: _mm512_add_pd, sub: _mm512_sub_pd, mul: _mm512_mul_pd, div: _mm512_div_pd,
    fused: _mm512_fmadd_pd, fused_minus: _mm512_fnmadd_pd,
    sqrt: _mm512_sqrt_pd, max: _mm512_max_pd, min: _mm512_min_pd, splat: _mm512_set1_pd,
    pow: libm::pow, tanh: libm::tanh, sincos: libm::sincos,
}

/// A bit per lane.
#[derive(Debug, Clone, Copy)]
#[repr(transparent)]
pub(crate) struct M64x8(__mmask8);

#[inline(always)]
fn less(a: F64x8, b: F64x8) -> M64x8 {
    M64x8(simd!(_mm512_cmp_pd_mask::<_CMP_LT_OQ>(a.0, b.0)))
}

#[inline(always)]
fn at_most(a: F64x8, b: F64x8) -> M64x8 {
    M64x8(simd!(_mm512_cmp_pd_mask::<_CMP_LE_OQ>(a.0, b.0)))
}

#[inline(always)]
fn choose(mask: M64x8, yes: F64x8, no: F64x8) -> F64x8 {
    F64x8(simd!(_mm512_mask_blend_pd(mask.0, no.0, yes.0)))
}

#[inline(always)]
fn kept(mask: M64x8, x: F64x8) -> F64x8 {
    F64x8(simd!(_mm512_maskz_mov_pd(mask.0, x.0)))
}

#[inline(always)]
fn magnitude(x: F64x8) -> F64x8 {
    F64x8(simd!(_mm512_abs_pd(x.0)))
}

#[inline(always)]
fn negated(x: F64x8) -> F64x8 {
    // Exact, signed zeros included; a bitwise operation on doubles would ask for more than the foundation instructions.
    x * F64x8::constant(-1.0)
}

impl moreau::Mask for M64x8 {
    #[inline(always)]
    fn any(self) -> bool {
        self.0 != 0
    }
    #[inline(always)]
    fn all(self) -> bool {
        self.0 == u8::MAX
    }
    #[inline(always)]
    fn and(self, other: Self) -> Self {
        M64x8(self.0 & other.0)
    }
    #[inline(always)]
    fn or(self, other: Self) -> Self {
        M64x8(self.0 | other.0)
    }
    #[inline(always)]
    fn not(self) -> Self {
        M64x8(!self.0)
    }
    #[inline(always)]
    fn splat(value: bool) -> Self {
        M64x8(if value { u8::MAX } else { 0 })
    }
    #[inline(always)]
    fn lane(self, lane: usize) -> bool {
        self.0 >> lane & 1 != 0
    }
}

//! Eight doubles in one 512-bit register; comparisons go to mask registers.

#![allow(unsafe_code)]

use core::arch::x86_64::{
    __m512d, _CMP_LE_OQ, _CMP_LT_OQ, _mm512_abs_pd, _mm512_add_pd, _mm512_cmp_pd_mask, _mm512_div_pd, _mm512_fmadd_pd,
    _mm512_fnmadd_pd, _mm512_mask_blend_pd, _mm512_maskz_mov_pd, _mm512_max_pd, _mm512_min_pd, _mm512_mul_pd,
    _mm512_set1_pd, _mm512_sqrt_pd, _mm512_sub_pd,
};

use super::number::{mask_register, operator, simd, vector_number};

vector_number! {
    F64x8, M64x8, __m512d, f64, 8,
    add: _mm512_add_pd, sub: _mm512_sub_pd, mul: _mm512_mul_pd, div: _mm512_div_pd,
    fused: _mm512_fmadd_pd, fused_minus: _mm512_fnmadd_pd,
    sqrt: _mm512_sqrt_pd, max: _mm512_max_pd, min: _mm512_min_pd, splat: _mm512_set1_pd,
    features: "avx512f,avx512vl,avx512dq,avx512bw",
    pow: moreau::Real::powf, tanh: libm::tanh, sincos: libm::sincos,
}

mask_register! {
    M64x8, F64x8, u8,
    compare: _mm512_cmp_pd_mask, blend: _mm512_mask_blend_pd, keep: _mm512_maskz_mov_pd, abs: _mm512_abs_pd,
}

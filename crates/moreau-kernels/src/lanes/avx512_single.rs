//! Sixteen numbers of single precision in one 512-bit register; comparisons go to mask registers.

#![allow(unsafe_code)]

use core::arch::x86_64::{
    __m512, _CMP_LE_OQ, _CMP_LT_OQ, _mm512_abs_ps, _mm512_add_ps, _mm512_cmp_ps_mask, _mm512_div_ps, _mm512_fmadd_ps,
    _mm512_fnmadd_ps, _mm512_mask_blend_ps, _mm512_maskz_mov_ps, _mm512_max_ps, _mm512_min_ps, _mm512_mul_ps,
    _mm512_set1_ps, _mm512_sqrt_ps, _mm512_sub_ps,
};

use super::number::{mask_register, operator, simd, vector_number};

vector_number! {
    F32x16, M32x16, __m512, f32, 16,
    add: _mm512_add_ps, sub: _mm512_sub_ps, mul: _mm512_mul_ps, div: _mm512_div_ps,
    fused: _mm512_fmadd_ps, fused_minus: _mm512_fnmadd_ps,
    sqrt: _mm512_sqrt_ps, max: _mm512_max_ps, min: _mm512_min_ps, splat: _mm512_set1_ps,
    features: "avx512f,avx512vl,avx512dq,avx512bw",
    pow: libm::powf, tanh: libm::tanhf, sincos: libm::sincosf,
}

mask_register! {
    M32x16, F32x16, u16,
    compare: _mm512_cmp_ps_mask, blend: _mm512_mask_blend_ps, keep: _mm512_maskz_mov_ps, abs: _mm512_abs_ps,
}

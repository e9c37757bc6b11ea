//! Eight numbers of single precision in one 256-bit register.

#![allow(unsafe_code)]

use core::arch::x86_64::{
    __m256, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_ps, _mm256_and_ps, _mm256_andnot_ps, _mm256_blendv_ps, _mm256_cmp_ps,
    _mm256_div_ps, _mm256_fmadd_ps, _mm256_fnmadd_ps, _mm256_max_ps, _mm256_min_ps, _mm256_movemask_ps, _mm256_mul_ps,
    _mm256_or_ps, _mm256_set1_ps, _mm256_sqrt_ps, _mm256_sub_ps, _mm256_xor_ps,
};

use super::number::{mask_of_bits, operator, simd, vector_number};

vector_number! {
    F32x8, M32x8, __m256, f32, 8,
    add: _mm256_add_ps, sub: _mm256_sub_ps, mul: _mm256_mul_ps, div: _mm256_div_ps,
    fused: _mm256_fmadd_ps, fused_minus: _mm256_fnmadd_ps,
    sqrt: _mm256_sqrt_ps, max: _mm256_max_ps, min: _mm256_min_ps, splat: _mm256_set1_ps, features: "avx2,fma",
    pow: libm::powf, tanh: libm::tanhf, sincos: libm::sincosf,
}

mask_of_bits! {
    M32x8, F32x8, __m256, f32, 8,
    compare: _mm256_cmp_ps, blend: _mm256_blendv_ps, and: _mm256_and_ps, and_not: _mm256_andnot_ps, or: _mm256_or_ps,
    xor: _mm256_xor_ps, movemask: _mm256_movemask_ps,
}

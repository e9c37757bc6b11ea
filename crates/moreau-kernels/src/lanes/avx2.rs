//! Four doubles in one 256-bit register.

#![allow(unsafe_code)]

use core::arch::x86_64::{
    __m256d, _CMP_LE_OQ, _CMP_LT_OQ, _mm256_add_pd, _mm256_and_pd, _mm256_andnot_pd, _mm256_blendv_pd, _mm256_cmp_pd,
    _mm256_div_pd, _mm256_fmadd_pd, _mm256_fnmadd_pd, _mm256_max_pd, _mm256_min_pd, _mm256_movemask_pd, _mm256_mul_pd,
    _mm256_or_pd, _mm256_set1_pd, _mm256_sqrt_pd, _mm256_sub_pd, _mm256_xor_pd,
};

use super::number::{mask_of_bits, operator, simd, vector_number};

vector_number! {
    F64x4, M64x4, __m256d, f64, 4,
    add: _mm256_add_pd, sub: _mm256_sub_pd, mul: _mm256_mul_pd, div: _mm256_div_pd,
    fused: _mm256_fmadd_pd, fused_minus: _mm256_fnmadd_pd,
    sqrt: _mm256_sqrt_pd, max: _mm256_max_pd, min: _mm256_min_pd, splat: _mm256_set1_pd, features: "avx2,fma",
    pow: moreau::Real::powf, tanh: libm::tanh, sincos: libm::sincos,
}

mask_of_bits! {
    M64x4, F64x4, __m256d, f64, 4,
    compare: _mm256_cmp_pd, blend: _mm256_blendv_pd, and: _mm256_and_pd, and_not: _mm256_andnot_pd, or: _mm256_or_pd,
    xor: _mm256_xor_pd, movemask: _mm256_movemask_pd,
}

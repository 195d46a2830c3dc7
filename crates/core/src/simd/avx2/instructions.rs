//! Types and instructions of 256 bits, under the names that the x86 widths share.

pub(super) use std::arch::x86_64::{
    __m256 as Floats, __m256i as Bools, __m256i as Ints, _mm256_add_epi32 as add_epi32,
    _mm256_add_ps as add_ps, _mm256_and_si256 as and_si, _mm256_castps_si256 as castps_si,
    _mm256_castsi256_ps as castsi_ps, _mm256_cvtepi32_ps as cvtepi32_ps, _mm256_cvttps_epi32 as cvttps_epi32,
    _mm256_div_ps as div_ps, _mm256_loadu_ps as loadu_ps, _mm256_loadu_si256 as loadu_si,
    _mm256_max_epi32 as max_epi32, _mm256_max_ps as max_ps, _mm256_min_epi32 as min_epi32,
    _mm256_min_ps as min_ps, _mm256_mul_ps as mul_ps, _mm256_mullo_epi32 as mullo_epi32,
    _mm256_or_si256 as or_si, _mm256_set1_epi32 as set1_epi32, _mm256_set1_ps as set1_ps,
    _mm256_shuffle_ps as shuffle_ps, _mm256_sll_epi32 as sll_epi32, _mm256_sqrt_ps as sqrt_ps,
    _mm256_sra_epi32 as sra_epi32, _mm256_srl_epi32 as srl_epi32, _mm256_storeu_ps as storeu_ps,
    _mm256_storeu_si256 as storeu_si, _mm256_sub_epi32 as sub_epi32, _mm256_sub_ps as sub_ps,
    _mm256_unpackhi_epi32 as unpackhi_epi32, _mm256_unpackhi_epi64 as unpackhi_epi64,
    _mm256_unpackhi_ps as unpackhi_ps, _mm256_unpacklo_epi32 as unpacklo_epi32,
    _mm256_unpacklo_epi64 as unpacklo_epi64, _mm256_unpacklo_ps as unpacklo_ps, _mm256_xor_ps as xor_ps,
    _mm256_xor_si256 as xor_si,
};
use std::arch::x86_64::{_mm256_cmp_ps, _mm256_cmpeq_epi32, _mm256_cmpgt_epi32};

/// Hides from the compiler that a mask is the result of a comparison. It would make eight single
/// bits of it, which AVX2 has no registers for: they are packed to 16 bits a lane, and back.
#[inline]
#[target_feature(enable = "avx2")]
fn opaque(mask: Bools) -> Bools {
    let mut mask = mask;
    // SAFETY: there is no instruction.
    unsafe {
        std::arch::asm!("/* {} */", inout(ymm_reg) mask, options(pure, nomem, nostack, preserves_flags));
    }
    mask
}

/// Compares lanes for equality.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn cmpeq_epi32(a: Ints, b: Ints) -> Bools {
    opaque(_mm256_cmpeq_epi32(a, b))
}

/// Compares lanes for a > b, signed.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn cmpgt_epi32(a: Ints, b: Ints) -> Bools {
    opaque(_mm256_cmpgt_epi32(a, b))
}

/// Compares lanes by a predicate.
#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn cmp_ps<const PREDICATE: i32>(a: Floats, b: Floats) -> Bools {
    opaque(castps_si(_mm256_cmp_ps::<PREDICATE>(a, b)))
}

//! Types and instructions of 128 bits, under the names that the x86 widths share; what SSE2 has no
//! instruction for, by several.

pub(super) use std::arch::x86_64::{
    __m128 as Floats, __m128i as Bools, __m128i as Ints, _mm_add_epi32 as add_epi32, _mm_add_ps as add_ps,
    _mm_and_si128 as and_si, _mm_castps_si128 as castps_si, _mm_castsi128_ps as castsi_ps,
    _mm_cmpeq_epi32 as cmpeq_epi32, _mm_cmpgt_epi32 as cmpgt_epi32, _mm_cvtepi32_ps as cvtepi32_ps,
    _mm_cvttps_epi32 as cvttps_epi32, _mm_div_ps as div_ps, _mm_loadu_ps as loadu_ps,
    _mm_loadu_si128 as loadu_si, _mm_max_ps as max_ps, _mm_min_ps as min_ps, _mm_mul_ps as mul_ps,
    _mm_or_si128 as or_si, _mm_set1_epi32 as set1_epi32, _mm_set1_ps as set1_ps, _mm_sll_epi32 as sll_epi32,
    _mm_sqrt_ps as sqrt_ps, _mm_sra_epi32 as sra_epi32, _mm_srl_epi32 as srl_epi32,
    _mm_storeu_ps as storeu_ps, _mm_storeu_si128 as storeu_si, _mm_sub_epi32 as sub_epi32,
    _mm_sub_ps as sub_ps, _mm_unpackhi_epi32 as unpackhi_epi32, _mm_unpackhi_epi64 as unpackhi_epi64,
    _mm_unpacklo_epi32 as unpacklo_epi32, _mm_unpacklo_epi64 as unpacklo_epi64, _mm_xor_ps as xor_ps,
    _mm_xor_si128 as xor_si,
};
use std::arch::x86_64::{
    _mm_and_ps, _mm_andnot_ps, _mm_andnot_si128, _mm_cmpgt_ps, _mm_cmplt_ps, _mm_mul_epu32, _mm_or_ps,
    _mm_shuffle_epi32, _mm_srli_epi64,
};

/// Returns `a` where the mask is set, else `b`.
#[inline]
#[target_feature(enable = "sse2")]
pub(super) fn select(mask: Bools, a: Ints, b: Ints) -> Ints {
    or_si(and_si(mask, a), _mm_andnot_si128(mask, b))
}

/// Returns the smaller of each two lanes, signed.
#[inline]
#[target_feature(enable = "sse2")]
pub(super) fn min_epi32(a: Ints, b: Ints) -> Ints {
    select(cmpgt_epi32(b, a), a, b)
}

/// Returns the larger of each two lanes, signed.
#[inline]
#[target_feature(enable = "sse2")]
pub(super) fn max_epi32(a: Ints, b: Ints) -> Ints {
    select(cmpgt_epi32(a, b), a, b)
}

/// Returns the lower 32 bits of each product. SSE2 multiplies the even lanes only.
#[inline]
#[target_feature(enable = "sse2")]
pub(super) fn mullo_epi32(a: Ints, b: Ints) -> Ints {
    let even = _mm_mul_epu32(a, b);
    let odd = _mm_mul_epu32(_mm_srli_epi64::<32>(a), _mm_srli_epi64::<32>(b));
    let (even, odd) = (_mm_shuffle_epi32::<0b00_00_10_00>(even), _mm_shuffle_epi32::<0b00_00_10_00>(odd));
    unpacklo_epi32(even, odd)
}

/// Clears the signs.
#[inline]
#[target_feature(enable = "sse2")]
pub(super) fn abs_ps(a: Floats) -> Floats {
    _mm_andnot_ps(set1_ps(-0.0), a)
}

/// Returns the largest integer not above each number.
#[inline]
#[target_feature(enable = "sse2")]
pub(super) fn floor_ps(a: Floats) -> Floats {
    let truncated = cvtepi32_ps(cvttps_epi32(a));
    let above = _mm_and_ps(_mm_cmpgt_ps(truncated, a), set1_ps(1.0));
    // -0.0 floors to -0.0; no other result changes by the sign of its number.
    let floor = _mm_or_ps(sub_ps(truncated, above), _mm_and_ps(a, set1_ps(-0.0)));
    // From 2^23 on every number is an integer, and from 2^31 on it is out of the
    // conversion's range. NaN is not below 2^23 either.
    let has_fraction = castps_si(_mm_cmplt_ps(abs_ps(a), set1_ps(8_388_608.0)));
    castsi_ps(select(has_fraction, castps_si(floor), castps_si(a)))
}

//! Gathers and stores of whole records: transposition between lanes and consecutive memory.

use super::{I, M};
use crate::simd::spill::Spill;
use crate::simd::x86::{rows_of_two, two_pairs};
use std::arch::x86_64::*;

/// Panics unless every set lane of `index`, read as unsigned, is below `len`.
#[inline(always)]
pub(super) fn check(mask: M, index: I, len: usize) {
    let len = len.min(i32::MAX as usize) as i32;
    // SAFETY: holding a vector proves the features.
    let outside = unsafe { _mm512_mask_cmpge_epu32_mask(mask.0, index.0, _mm512_set1_epi32(len)) };
    assert!(outside == 0, "gathered index outside the slice's {len}");
}

/// Gathers four words for each lane, transposed: from STRIDE times its index bytes after `from`
/// where it is set, from `from` elsewhere.
///
/// # Safety
/// The CPU must have the level's features, and 16 bytes must be there at each of those places.
#[inline(always)]
pub(super) unsafe fn transposed<const STRIDE: usize>(mask: M, index: I, from: *const u8) -> [__m512; 4] {
    // SAFETY: as promised by the caller; the array holds 16 elements.
    unsafe {
        let mut at = Spill([0i32; 16]);
        _mm512_storeu_si512(at.0.as_mut_ptr().cast(), _mm512_maskz_mov_epi32(mask.0, index.0));
        // Row r holds the records of lanes r, 4+r, ...; a 4x4 transpose within each part finishes
        // it.
        let ([a, b], [c, d]) = (two_rows::<STRIDE>(from, &at, 0), two_rows::<STRIDE>(from, &at, 1));
        let (ab, cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
        let (ef, gh) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
        [
            _mm512_shuffle_ps::<0b01_00_01_00>(ab, cd),
            _mm512_shuffle_ps::<0b11_10_11_10>(ab, cd),
            _mm512_shuffle_ps::<0b01_00_01_00>(ef, gh),
            _mm512_shuffle_ps::<0b11_10_11_10>(ef, gh),
        ]
    }
}

/// Transposes four fields into rows of records: row r holds in quarter q the four numbers of lane
/// 4 q + r.
///
/// # Safety
/// The CPU must have the level's features.
#[inline(always)]
pub(super) unsafe fn rows_of_four([a, b, c, d]: [__m512i; 4]) -> [__m512i; 4] {
    // SAFETY: as promised by the caller.
    unsafe {
        let (ab, cd) = (_mm512_unpacklo_epi32(a, b), _mm512_unpacklo_epi32(c, d));
        let (ef, gh) = (_mm512_unpackhi_epi32(a, b), _mm512_unpackhi_epi32(c, d));
        [
            _mm512_unpacklo_epi64(ab, cd),
            _mm512_unpackhi_epi64(ab, cd),
            _mm512_unpacklo_epi64(ef, gh),
            _mm512_unpackhi_epi64(ef, gh),
        ]
    }
}

/// Loads pixel pairs: quarter q holds those at the indices of lanes 4 q + 2 k and 4 q + 2 k + 1.
///
/// # Safety
/// The CPU must have the level's features, and 8 bytes must be there at each of those places.
#[inline(always)]
pub(super) unsafe fn pixel_pairs(from: &[u8], at: &Spill<16>, k: usize) -> __m512 {
    // SAFETY: as promised by the caller.
    unsafe {
        let low = _mm256_castps128_ps256(two_pairs(from, at.pair(k)));
        let low = _mm256_insertf128_ps::<1>(low, two_pairs(from, at.pair(k + 2)));
        let high = _mm256_castps128_ps256(two_pairs(from, at.pair(k + 4)));
        let high = _mm256_insertf128_ps::<1>(high, two_pairs(from, at.pair(k + 6)));
        _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high)
    }
}

/// Loads the records of lanes 2 k, 4 + 2 k, ... and those of lanes 2 k + 1, 4 + 2 k + 1, ...
///
/// # Safety
/// That of [`transposed`].
#[inline(always)]
unsafe fn two_rows<const STRIDE: usize>(from: *const u8, at: &Spill<16>, k: usize) -> [__m512; 2] {
    // SAFETY: as promised by the caller.
    unsafe {
        let [a, b] = rows_of_two::<STRIDE>(from, at.pair(k), at.pair(k + 2));
        let [c, d] = rows_of_two::<STRIDE>(from, at.pair(k + 4), at.pair(k + 6));
        [
            _mm512_insertf32x8::<1>(_mm512_castps256_ps512(a), c),
            _mm512_insertf32x8::<1>(_mm512_castps256_ps512(b), d),
        ]
    }
}

//! Records that are gathered or written whole: their numbers from lanes to places that follow each other, and back.

use super::{I, M};
use crate::simd::spilled::Spilled;
use crate::simd::x86::{record, two_pairs};
use std::arch::x86_64::*;

/// Panics unless every set lane of `index`, read as unsigned, is below `len`.
#[inline(always)]
pub(super) fn check(mask: M, index: I, len: usize) {
    let len = len.min(i32::MAX as usize) as i32;
    // SAFETY: holding a vector proves the features.
    let outside = unsafe { _mm512_mask_cmpge_epu32_mask(mask.0, index.0, _mm512_set1_epi32(len)) };
    assert!(outside == 0, "gathered index outside the slice's {len}");
}

/// Four words a lane, read STRIDE bytes times its index from `from` on where it is set and at `from` elsewhere, transposed.
///
/// # Safety
/// The CPU must have the level's features, and 16 bytes must be there at each of those places.
#[inline(always)]
pub(super) unsafe fn transposed<const STRIDE: usize>(mask: M, index: I, from: *const u8) -> [__m512; 4] {
    // SAFETY: as promised by the caller; 16 places are there.
    unsafe {
        let mut at = Spilled([0i32; 16]);
        _mm512_storeu_si512(at.0.as_mut_ptr().cast(), _mm512_maskz_mov_epi32(mask.0, index.0));
        // Row r holds the records of lanes r, 4+r, ...; a 4x4 transpose within each part finishes it.
        let (a, b) = (row_of::<STRIDE>(from, &at, 0), row_of::<STRIDE>(from, &at, 1));
        let (c, d) = (row_of::<STRIDE>(from, &at, 2), row_of::<STRIDE>(from, &at, 3));
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

/// Four fields by lanes as rows of records: row r holds in quarter q the four numbers of lane 4 q + r.
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

/// In quarter q the pixels at the places of lanes 4 q + r and 4 q + r + 1, two each.
///
/// # Safety
/// The CPU must have the level's features, and 8 bytes must be there at each of those places.
#[inline(always)]
pub(super) unsafe fn pixel_pairs(from: &[u8], at: &Spilled<16>, r: usize) -> __m512 {
    // SAFETY: as promised by the caller.
    unsafe {
        let v = _mm512_castps128_ps512(two_pairs(from, at.lane(r), at.lane(r + 1)));
        let v = _mm512_insertf32x4::<1>(v, two_pairs(from, at.lane(r + 4), at.lane(r + 5)));
        let v = _mm512_insertf32x4::<2>(v, two_pairs(from, at.lane(r + 8), at.lane(r + 9)));
        _mm512_insertf32x4::<3>(v, two_pairs(from, at.lane(r + 12), at.lane(r + 13)))
    }
}

/// The records of lanes r, 4 + r, ...
///
/// # Safety
/// As for [`transposed`].
#[inline(always)]
unsafe fn row_of<const STRIDE: usize>(from: *const u8, at: &Spilled<16>, r: usize) -> __m512 {
    // SAFETY: as promised by the caller.
    unsafe {
        let low = _mm256_castps128_ps256(record::<STRIDE>(from, at.lane(r)));
        let low = _mm256_insertf128_ps::<1>(low, record::<STRIDE>(from, at.lane(r + 4)));
        let high = _mm256_castps128_ps256(record::<STRIDE>(from, at.lane(r + 8)));
        let high = _mm256_insertf128_ps::<1>(high, record::<STRIDE>(from, at.lane(r + 12)));
        _mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high)
    }
}

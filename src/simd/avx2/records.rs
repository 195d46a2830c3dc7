//! Gathers and stores of whole records: transposition between lanes and consecutive memory.

use super::{I, M};
use crate::simd::Mask;
use crate::simd::spill::Spill;
use crate::simd::x86::{rows_of_two, two_pairs};
use std::arch::x86_64::*;

/// Indices of the set lanes for each mask, in order.
pub(super) static COMPRESS: [[i32; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut bits = 0;
    while bits < 256 {
        let (mut lane, mut n) = (0, 0);
        while lane < 8 {
            if bits >> lane & 1 == 1 {
                table[bits][n] = lane;
                n += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    table
};

/// Panics unless every set lane of `index`, read as unsigned, is below `len`.
#[inline(always)]
pub(super) fn check(mask: M, index: I, len: usize) {
    let len = len.min(i32::MAX as usize) as i32;
    // SAFETY: holding a vector proves the features. Unsigned a <= b is min(a, b) == a.
    let inside = unsafe {
        let below = _mm256_min_epu32(index.0, _mm256_set1_epi32(len - 1));
        M(_mm256_cmpeq_epi32(below, index.0))
    };
    assert!(len > 0 && !(mask & !inside).any() || !mask.any(), "gathered index outside the slice's {len}");
}

/// Gathers four words for each lane, transposed: from STRIDE times its index bytes after `from`
/// where it is set, from `from` elsewhere.
///
/// # Safety
/// The CPU must have the level's features, and 16 bytes must be there at each of those places.
#[inline(always)]
pub(super) unsafe fn transposed<const STRIDE: usize>(mask: M, index: I, from: *const u8) -> [__m256; 4] {
    // SAFETY: as promised by the caller; the array holds 8 elements.
    unsafe {
        let mut at = Spill([0i32; 8]);
        _mm256_storeu_si256(at.0.as_mut_ptr().cast(), _mm256_and_si256(mask.0, index.0));
        // Row r holds the records of lanes r and 4 + r; a 4x4 transpose within each half finishes
        // it.
        let [a, b] = rows_of_two::<STRIDE>(from, at.pair(0), at.pair(2));
        let [c, d] = rows_of_two::<STRIDE>(from, at.pair(1), at.pair(3));
        let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
        let (ef, gh) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
        [
            _mm256_shuffle_ps::<0b01_00_01_00>(ab, cd),
            _mm256_shuffle_ps::<0b11_10_11_10>(ab, cd),
            _mm256_shuffle_ps::<0b01_00_01_00>(ef, gh),
            _mm256_shuffle_ps::<0b11_10_11_10>(ef, gh),
        ]
    }
}

/// Permutes the lanes to `order` and zeroes those that `kept` masks out.
///
/// # Safety
/// The CPU must have the level's features.
#[inline(always)]
pub(super) unsafe fn packed(v: I, order: __m256i, kept: __m256i) -> __m256i {
    // SAFETY: as promised by the caller.
    unsafe { _mm256_and_si256(_mm256_permutevar8x32_epi32(v.0, order), kept) }
}

/// Transposes four fields into rows of records: row r holds in half q the four numbers of lane
/// 4 q + r.
///
/// # Safety
/// The CPU must have the level's features.
#[inline(always)]
pub(super) unsafe fn rows_of_four([a, b, c, d]: [__m256i; 4]) -> [__m256i; 4] {
    // SAFETY: as promised by the caller.
    unsafe {
        let (ab, cd) = (_mm256_unpacklo_epi32(a, b), _mm256_unpacklo_epi32(c, d));
        let (ef, gh) = (_mm256_unpackhi_epi32(a, b), _mm256_unpackhi_epi32(c, d));
        [
            _mm256_unpacklo_epi64(ab, cd),
            _mm256_unpackhi_epi64(ab, cd),
            _mm256_unpacklo_epi64(ef, gh),
            _mm256_unpackhi_epi64(ef, gh),
        ]
    }
}

/// Loads pixel pairs: half q holds those at the indices of lanes 4 q + 2 k and 4 q + 2 k + 1.
///
/// # Safety
/// The CPU must have the level's features, and 8 bytes must be there at each of those places.
#[inline(always)]
pub(super) unsafe fn pixel_pairs(from: &[u8], at: &Spill<8>, k: usize) -> __m256 {
    // SAFETY: as promised by the caller.
    unsafe {
        let v = _mm256_castps128_ps256(two_pairs(from, at.pair(k)));
        _mm256_insertf128_ps::<1>(v, two_pairs(from, at.pair(k + 2)))
    }
}

//! Gathers and stores of records: transposition between lanes and consecutive memory.

use super::instructions::*;
use super::{I, M};
use crate::simd::avx_records::{rows_of_two, transpositions, two_pairs};
use crate::simd::spill::Spill;
use crate::simd::x86::{registers, rows_of_four};
use std::arch::x86_64::*;

/// Panics unless every set lane of `index`, read as unsigned, is below `len`.
#[inline(always)]
pub(super) fn check(mask: M, index: I, len: usize) {
    let len = len.min(i32::MAX as usize) as i32;
    let outside = registers!(index => _mm512_mask_cmpge_epu32_mask(mask.0, index.0, set1_epi32(len)));
    assert!(outside == 0, "gathered index outside the slice's {len}");
}

/// Returns the index of each set lane, 0 in the others.
#[inline(always)]
pub(super) fn index_or_0(mask: M, index: I) -> Ints {
    registers!(mask => _mm512_maskz_mov_epi32(mask.0, index.0))
}

rows_of_four!();
transpositions!(16);

/// Loads pixel pairs: quarter q holds those at the indices of lanes 4 q + 2 k and 4 q + 2 k + 1.
///
/// # Safety
/// The CPU must have the level's features, and 8 bytes must be readable at each of those places.
#[inline(always)]
pub(super) unsafe fn pixel_pairs(from: &[u8], at: &Spill<16>, k: usize) -> Floats {
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
unsafe fn two_rows(from: *const u8, at: &Spill<16>, k: usize) -> [Floats; 2] {
    // SAFETY: as promised by the caller.
    unsafe {
        let [a, b] = rows_of_two(from, at.pair(k), at.pair(k + 2));
        let [c, d] = rows_of_two(from, at.pair(k + 4), at.pair(k + 6));
        [
            _mm512_insertf32x8::<1>(_mm512_castps256_ps512(a), c),
            _mm512_insertf32x8::<1>(_mm512_castps256_ps512(b), d),
        ]
    }
}

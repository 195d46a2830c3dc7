//! Gathers and stores of records: transposition between lanes and consecutive memory.

use super::instructions::*;
use super::{I, M};
use crate::simd::Mask;
use crate::simd::avx_records::{rows_of_two, transpositions, two_pairs};
use crate::simd::spill::Spill;
use crate::simd::x86::{registers, rows_of_four};
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
    let most = len.min(i32::MAX as usize) as i32 - 1;
    // Unsigned a <= b is min(a, b) == a; of an empty slice every lane is.
    let is_inside = registers!(index => {
        let index = index_or_0(mask, index);
        let inside = _mm256_cmpeq_epi32(_mm256_min_epu32(index, set1_epi32(most)), index);
        _mm256_movemask_ps(castsi_ps(inside)) == 0xff
    });
    if !is_inside || (len == 0 && mask.any()) {
        outside(len);
    }
}

#[cold]
#[inline(never)]
fn outside(len: usize) -> ! {
    panic!("gathered index outside the slice's {len}");
}

/// Returns the index of each set lane, 0 in the others.
#[inline(always)]
pub(super) fn index_or_0(mask: M, index: I) -> Ints {
    registers!(mask => and_si(mask.0, index.0))
}

rows_of_four!();
transpositions!(8);

/// Permutes the lanes to `order` and zeroes those that `kept` masks out.
#[inline(always)]
pub(super) fn packed(v: I, order: I, kept: I) -> I {
    registers!(v => I(and_si(_mm256_permutevar8x32_epi32(v.0, order.0), kept.0)))
}

/// Returns lanes 2 k and 2 k + 1, by a load each: CPUs without wider vectors have more loads to spare
/// than other operations.
#[inline(always)]
fn lanes(at: &Spill<8>, k: usize) -> [usize; 2] {
    [at.lane(2 * k), at.lane(2 * k + 1)]
}

/// Loads pixel pairs: half q holds those at the indices of lanes 4 q + 2 k and 4 q + 2 k + 1.
///
/// # Safety
/// The CPU must have the level's features, and 8 bytes must be readable at each of those places.
#[inline(always)]
pub(super) unsafe fn pixel_pairs(from: &[u8], at: &Spill<8>, k: usize) -> Floats {
    // SAFETY: as promised by the caller.
    unsafe {
        let v = _mm256_castps128_ps256(two_pairs(from, lanes(at, k)));
        _mm256_insertf128_ps::<1>(v, two_pairs(from, lanes(at, k + 2)))
    }
}

/// Loads the records of lanes 2 k and 4 + 2 k, and those of lanes 2 k + 1 and 4 + 2 k + 1.
///
/// # Safety
/// That of [`transposed`].
#[inline(always)]
unsafe fn two_rows(from: *const u8, at: &Spill<8>, k: usize) -> [Floats; 2] {
    // SAFETY: as promised by the caller.
    unsafe { rows_of_two(from, lanes(at, k), lanes(at, k + 2)) }
}

/// Moves the lower half to the upper one, over zeros.
///
/// # Safety
/// The CPU must have AVX2.
#[inline(always)]
pub(super) unsafe fn upwards(v: Ints) -> Ints {
    // SAFETY: as promised by the caller; no memory is accessed.
    unsafe { _mm256_permute2x128_si256::<0x08>(v, v) }
}

/// Returns the lanes of `v` whose number is that of a set lane further down: in each 16 bytes, those
/// from byte END on of the second part, then the first part's.
///
/// # Safety
/// The CPU must have AVX2.
#[inline(always)]
pub(super) unsafe fn repeats<const END: i32>(v: Ints, [numbers, set]: [[Ints; 2]; 2]) -> Ints {
    // SAFETY: as promised by the caller; no memory is accessed.
    unsafe {
        let other = _mm256_alignr_epi8::<END>(numbers[0], numbers[1]);
        and_si(_mm256_cmpeq_epi32(v, other), _mm256_alignr_epi8::<END>(set[0], set[1]))
    }
}

//! Gathers and stores of records: transposition between lanes and consecutive memory.

use super::{I, M};
use crate::simd::Mask;
use crate::simd::four_lanes::PACKING;
use std::arch::aarch64::*;

/// Returns the order of bytes that packs the lanes of `bits` to the front.
#[inline(always)]
pub(super) fn packing(bits: u32) -> uint8x16_t {
    // SAFETY: NEON is part of the target; a row of the table holds 16 bytes.
    unsafe { vld1q_u8(PACKING[bits as usize & 15].as_ptr()) }
}

/// Permutes the bytes to `order`.
#[inline(always)]
pub(super) fn packed(v: I, order: uint8x16_t) -> int32x4_t {
    registers!(vreinterpretq_s32_u8(vqtbl1q_u8(vreinterpretq_u8_s32(v.0), order)))
}

/// Transposes four vectors: number c of row r becomes number r of row c.
#[inline(always)]
pub(super) fn transposed([a, b, c, d]: [int32x4_t; 4]) -> [int32x4_t; 4] {
    registers!({
        let (ab, cd) = (vtrn1q_s32(a, b), vtrn1q_s32(c, d));
        let (ab_odd, cd_odd) = (vtrn2q_s32(a, b), vtrn2q_s32(c, d));
        let (ab, cd) = (vreinterpretq_s64_s32(ab), vreinterpretq_s64_s32(cd));
        let (ab_odd, cd_odd) = (vreinterpretq_s64_s32(ab_odd), vreinterpretq_s64_s32(cd_odd));
        [
            vreinterpretq_s32_s64(vtrn1q_s64(ab, cd)),
            vreinterpretq_s32_s64(vtrn1q_s64(ab_odd, cd_odd)),
            vreinterpretq_s32_s64(vtrn2q_s64(ab, cd)),
            vreinterpretq_s32_s64(vtrn2q_s64(ab_odd, cd_odd)),
        ]
    })
}

/// Returns the index of each set lane, 0 in the others.
///
/// # Panics
/// Unless every set lane of `index`, read as unsigned, is below `len`.
#[inline(always)]
pub(super) fn checked(mask: M, index: I, len: usize) -> [usize; 4] {
    let len = len.min(i32::MAX as usize) as u32;
    let (outside, at) = registers!({
        let index = vreinterpretq_u32_s32(index.0);
        (M(vandq_u32(mask.0, vcgeq_u32(index, vdupq_n_u32(len)))), vandq_u32(mask.0, index))
    });
    assert!(!outside.any(), "gathered index outside the slice's {len}");
    let lanes = registers!([
        vgetq_lane_u32::<0>(at),
        vgetq_lane_u32::<1>(at),
        vgetq_lane_u32::<2>(at),
        vgetq_lane_u32::<3>(at),
    ]);
    lanes.map(|lane| lane as usize)
}

/// Loads one number from 4 times each index bytes after `from`.
///
/// # Safety
/// 4 bytes must be readable at each of those places.
#[inline(always)]
pub(super) unsafe fn numbers(from: *const u8, at: [usize; 4]) -> int32x4_t {
    // SAFETY: NEON is part of the target; the rest as promised by the caller; these loads need no
    // alignment.
    unsafe {
        let [a, b, c, d] = at.map(|at| from.add(4 * at).cast::<i32>());
        let v = vdupq_n_s32(a.read_unaligned());
        let v = vsetq_lane_s32::<1>(b.read_unaligned(), v);
        let v = vsetq_lane_s32::<2>(c.read_unaligned(), v);
        vsetq_lane_s32::<3>(d.read_unaligned(), v)
    }
}

/// Loads four words from STRIDE times each index bytes after `from`, transposed.
///
/// # Safety
/// 16 bytes must be readable at each of those places.
#[inline(always)]
pub(super) unsafe fn records<const STRIDE: usize>(from: *const u8, at: [usize; 4]) -> [int32x4_t; 4] {
    let [a, b, c, d] = at;
    // SAFETY: NEON is part of the target; the rest as promised by the caller; loads of bytes need
    // no alignment, and the level exists on little-endian CPUs only.
    unsafe {
        transposed([
            vreinterpretq_s32_u8(vld1q_u8(from.add(STRIDE * a))),
            vreinterpretq_s32_u8(vld1q_u8(from.add(STRIDE * b))),
            vreinterpretq_s32_u8(vld1q_u8(from.add(STRIDE * c))),
            vreinterpretq_s32_u8(vld1q_u8(from.add(STRIDE * d))),
        ])
    }
}

/// Loads two words from 4 times each index bytes after `from`: the first of each, and the second.
///
/// # Safety
/// 8 bytes must be readable at each of those places.
#[inline(always)]
pub(super) unsafe fn pairs(from: *const u8, at: [usize; 4]) -> [int32x4_t; 2] {
    let [a, b, c, d] = at;
    // SAFETY: NEON is part of the target; the rest as promised by the caller; loads of bytes need
    // no alignment, and the level exists on little-endian CPUs only.
    unsafe {
        let low = vcombine_u8(vld1_u8(from.add(4 * a)), vld1_u8(from.add(4 * b)));
        let high = vcombine_u8(vld1_u8(from.add(4 * c)), vld1_u8(from.add(4 * d)));
        let (low, high) = (vreinterpretq_s32_u8(low), vreinterpretq_s32_u8(high));
        [vuzp1q_s32(low, high), vuzp2q_s32(low, high)]
    }
}

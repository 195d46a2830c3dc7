//! Loads, stores and gathers: between vectors and memory.

use super::{I, M};
use crate::simd::Mask;
use crate::simd::four_lanes::PACKING;
use std::arch::wasm32::*;

/// Loads 16 bytes.
#[inline(always)]
pub(super) fn load16(from: &[u8; 16]) -> v128 {
    // SAFETY: the array holds 16 bytes; the load needs no alignment.
    unsafe { v128_load(from.as_ptr().cast()) }
}

/// Loads the first four numbers of a slice.
#[inline(always)]
pub(super) fn load4<T: Number>(from: &[T]) -> v128 {
    let from = &from[..4];
    // SAFETY: the slice holds four numbers of four bytes; the load needs no alignment.
    unsafe { v128_load(from.as_ptr().cast()) }
}

/// Stores four numbers at the beginning of a slice.
#[inline(always)]
pub(super) fn store4<T: Number>(v: v128, to: &mut [T]) {
    let to = &mut to[..4];
    // SAFETY: the slice holds four numbers of four bytes, for which any bits are a value; the store
    // needs no alignment.
    unsafe { v128_store(to.as_mut_ptr().cast(), v) }
}

/// A number of four bytes.
pub(super) trait Number {}
impl Number for i32 {}
impl Number for f32 {}

/// Returns the order of bytes that packs the lanes of `bits` to the front.
#[inline(always)]
pub(super) fn packing(bits: u32) -> v128 {
    load16(&PACKING[bits as usize & 15])
}

/// Permutes the bytes to `order`.
#[inline(always)]
pub(super) fn packed(v: I, order: v128) -> v128 {
    u8x16_swizzle(v.0, order)
}

/// Transposes four vectors: number c of row r becomes number r of row c.
#[inline(always)]
pub(super) fn transposed([a, b, c, d]: [v128; 4]) -> [v128; 4] {
    let (ab, cd) = (i32x4_shuffle::<0, 4, 1, 5>(a, b), i32x4_shuffle::<0, 4, 1, 5>(c, d));
    let (ab_end, cd_end) = (i32x4_shuffle::<2, 6, 3, 7>(a, b), i32x4_shuffle::<2, 6, 3, 7>(c, d));
    [
        i64x2_shuffle::<0, 2>(ab, cd),
        i64x2_shuffle::<1, 3>(ab, cd),
        i64x2_shuffle::<0, 2>(ab_end, cd_end),
        i64x2_shuffle::<1, 3>(ab_end, cd_end),
    ]
}

/// Returns the index of each set lane, 0 in the others.
///
/// # Panics
/// Unless every set lane of `index`, read as unsigned, is below `len`.
#[inline(always)]
pub(super) fn checked(mask: M, index: I, len: usize) -> [usize; 4] {
    let len = len.min(i32::MAX as usize) as u32;
    let outside = M(v128_and(mask.0, u32x4_ge(index.0, u32x4_splat(len))));
    assert!(!outside.any(), "gathered index outside the slice's {len}");
    let at = v128_and(mask.0, index.0);
    [
        u32x4_extract_lane::<0>(at) as usize,
        u32x4_extract_lane::<1>(at) as usize,
        u32x4_extract_lane::<2>(at) as usize,
        u32x4_extract_lane::<3>(at) as usize,
    ]
}

//! Gathers and stores of records: lanes as indices, transposition between lanes and memory.

use super::instructions::*;
use super::{F, I, M};
use crate::simd::x86::{registers, rows_of_four};
use std::arch::x86_64::*;

/// Type all of whose bytes are initialised.
///
/// # Safety
/// It must have no padding.
pub(super) unsafe trait NoPadding {}
// SAFETY: a number.
unsafe impl NoPadding for f32 {}
// SAFETY: numbers of the same type, one behind another.
unsafe impl NoPadding for [u16; 4] {}

/// Loads an array of 16 bytes.
#[inline(always)]
pub(super) fn load16<T: NoPadding, const N: usize>(from: &[T; N]) -> F {
    const { assert!(size_of::<[T; N]>() == 16) };
    // SAFETY: SSE is part of every x86-64; the array holds 16 bytes, all initialised, and the load
    // needs no alignment.
    unsafe { F(loadu_ps(from.as_ptr().cast())) }
}

rows_of_four!();

/// Returns the lanes, read as unsigned.
#[inline(always)]
pub(super) fn unsigned_lanes(v: I) -> [usize; 4] {
    let [low, high] = registers!(v => [_mm_cvtsi128_si64(v.0), _mm_cvtsi128_si64(unpackhi_epi64(v.0, v.0))]);
    let [low, high] = [low as u64, high as u64];
    [low as u32 as usize, (low >> 32) as usize, high as u32 as usize, (high >> 32) as usize]
}

/// Returns the index of each set lane, 0 in the others.
#[inline(always)]
pub(super) fn indices(mask: M, index: I) -> [usize; 4] {
    unsigned_lanes(registers!(mask => I(and_si(mask.0, index.0))))
}

/// Returns a vector of four numbers.
#[inline(always)]
pub(super) fn vector([a, b, c, d]: [i32; 4]) -> I {
    // SAFETY: SSE2 is part of every x86-64; no memory is accessed.
    unsafe { I(_mm_setr_epi32(a, b, c, d)) }
}

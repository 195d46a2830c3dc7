//! NEON: 4 lanes, masks as all-ones lanes.
//!
//! In: vectors and tokens of this level, slices. Out: vectors, stored numbers. Promise: the bits of
//! `portable.rs`. Safety: this module is compiled only for targets whose every CPU has NEON, so its
//! instructions may be executed anywhere; a block that reads or writes memory says why its bytes are
//! there.

/// Evaluates intrinsics that work on registers alone.
macro_rules! registers {
    ($body:expr) => {{
        // SAFETY: NEON is part of the target; no memory is accessed.
        unsafe { $body }
    }};
}

mod lanes;
mod records;

use super::four_lanes::{block_of_one_row_methods, packing_methods};
use super::{I32, Mask, Simd};
use lanes::{F, I, M, lane_bits};
use records::{checked, numbers, packed, packing, pairs, records, transposed};
use std::arch::aarch64::*;

/// Token of the level.
#[derive(Clone, Copy, Debug)]
pub struct Neon;

impl Simd for Neon {
    const LANES: usize = 4;
    type F = F;
    type I = I;
    type M = M;

    block_of_one_row_methods!();
    packing_methods!();

    #[inline(always)]
    fn splat(self, v: f32) -> F {
        registers!(F(vdupq_n_f32(v)))
    }
    #[inline(always)]
    fn splat_i(self, v: i32) -> I {
        registers!(I(vdupq_n_s32(v)))
    }
    #[inline(always)]
    fn iota(self) -> I {
        self.load_i(&[0, 1, 2, 3])
    }
    #[inline(always)]
    fn load(self, from: &[f32]) -> F {
        let from = &from[..4];
        // SAFETY: NEON is part of the target; the slice holds 4 numbers.
        unsafe { F(vld1q_f32(from.as_ptr())) }
    }
    #[inline(always)]
    fn load_i(self, from: &[i32]) -> I {
        let from = &from[..4];
        // SAFETY: NEON is part of the target; the slice holds 4 numbers.
        unsafe { I(vld1q_s32(from.as_ptr())) }
    }
    #[inline(always)]
    fn store(self, v: F, to: &mut [f32]) {
        let to = &mut to[..4];
        // SAFETY: NEON is part of the target; the target holds 4 elements.
        unsafe { vst1q_f32(to.as_mut_ptr(), v.0) }
    }
    #[inline(always)]
    fn store_i(self, v: I, to: &mut [i32]) {
        let to = &mut to[..4];
        // SAFETY: NEON is part of the target; the target holds 4 elements.
        unsafe { vst1q_s32(to.as_mut_ptr(), v.0) }
    }
    #[inline(always)]
    fn load_bytes(self, from: &[u8]) -> I {
        let from = &from[..16];
        // SAFETY: NEON is part of the target; the slice holds 16 bytes, and the level exists on
        // little-endian CPUs only.
        unsafe { I(vreinterpretq_s32_u8(vld1q_u8(from.as_ptr()))) }
    }
    #[inline(always)]
    fn store_masked_bytes(self, mask: M, v: I, to: &mut [u8]) {
        let to = &mut to[..16];
        let new = self.select_i(mask, v, self.load_bytes(to));
        // SAFETY: NEON is part of the target; the slice holds 16 bytes, and the level exists on
        // little-endian CPUs only.
        unsafe { vst1q_u8(to.as_mut_ptr(), vreinterpretq_u8_s32(new.0)) }
    }
    #[inline(always)]
    fn zip(self, a: I, b: I) -> [I; 2] {
        registers!([I(vzip1q_s32(a.0, b.0)), I(vzip2q_s32(a.0, b.0))])
    }
    #[inline(always)]
    fn first_occurrences(self, mask: M, v: I) -> M {
        // Lane i sees lane i - k; where there is none, an unset lane.
        registers!({
            let (none, unset) = (vdupq_n_s32(0), vdupq_n_u32(0));
            let is_one = vceqq_s32(vextq_s32::<3>(none, v.0), v.0);
            let is_two = vceqq_s32(vextq_s32::<2>(none, v.0), v.0);
            let is_three = vceqq_s32(vextq_s32::<1>(none, v.0), v.0);
            let one = vandq_u32(is_one, vextq_u32::<3>(unset, mask.0));
            let two = vandq_u32(is_two, vextq_u32::<2>(unset, mask.0));
            let three = vandq_u32(is_three, vextq_u32::<1>(unset, mask.0));
            M(vbicq_u32(mask.0, vorrq_u32(one, vorrq_u32(two, three))))
        })
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> M {
        registers!(M(vtstq_u32(vdupq_n_u32(bits), lane_bits())))
    }
    #[inline(always)]
    fn increment(self, mask: M, counts: I) -> I {
        registers!(I(vsubq_s32(counts.0, vreinterpretq_s32_u32(mask.0))))
    }
    #[inline(always)]
    fn select(self, mask: M, a: F, b: F) -> F {
        registers!(F(vbslq_f32(mask.0, a.0, b.0)))
    }
    #[inline(always)]
    fn select_i(self, mask: M, a: I, b: I) -> I {
        registers!(I(vbslq_s32(mask.0, a.0, b.0)))
    }
    #[inline(always)]
    fn lookup(self, table: &[i32; 8], index: I) -> I {
        // SAFETY: NEON is part of the target; both halves of the table hold 16 bytes.
        unsafe {
            // The places of each number's four bytes, lowest first.
            let first = vandq_s32(index.0, vdupq_n_s32(7));
            let places = vmlaq_s32(vdupq_n_s32(0x0302_0100), first, vdupq_n_s32(0x0404_0404));
            let bytes = table.as_ptr().cast::<u8>();
            let rows = uint8x16x2_t(vld1q_u8(bytes), vld1q_u8(bytes.add(16)));
            I(vreinterpretq_s32_u8(vqtbl2q_u8(rows, vreinterpretq_u8_s32(places))))
        }
    }
    #[inline(always)]
    fn gather_bytes(self, mask: M, from: &[u8], index: I) -> I {
        let at = checked(mask, index, from.len() / 4);
        if from.len() < 4 {
            return self.splat_i(0);
        }
        // SAFETY: NEON is part of the target; unset lanes read pixel 0, which exists; the others
        // were checked.
        let found = unsafe { numbers(from.as_ptr(), at) };
        registers!(I(vandq_s32(found, vreinterpretq_s32_u32(mask.0))))
    }
    #[inline(always)]
    fn gather(self, mask: M, from: &[f32], index: I) -> F {
        let at = checked(mask, index, from.len());
        if from.is_empty() {
            return self.splat(0.0);
        }
        // SAFETY: NEON is part of the target; unset lanes read number 0, which exists; the others
        // were checked.
        let found = unsafe { numbers(from.as_ptr().cast(), at) };
        registers!(F(vreinterpretq_f32_s32(vandq_s32(found, vreinterpretq_s32_u32(mask.0)))))
    }
    #[inline(always)]
    fn gather4(self, mask: M, from: &[[f32; 4]], index: I) -> [F; 4] {
        assert!(!from.is_empty(), "records to gather");
        let at = checked(mask, index, from.len());
        // SAFETY: NEON is part of the target; unset lanes read record 0, which exists; the others
        // were checked.
        let [a, b, c, d] = unsafe { records::<16>(from.as_ptr().cast(), at) };
        [I(a).as_f32(), I(b).as_f32(), I(c).as_f32(), I(d).as_f32()]
    }
    #[inline(always)]
    fn gather_pairs(self, mask: M, from: &[[u16; 4]], index: I) -> [I; 4] {
        assert!(from.len() > 1, "pairs to gather");
        let at = checked(mask, index, from.len() - 1);
        // SAFETY: NEON is part of the target; unset lanes read records 0 and 1, which exist; the
        // others were checked: each has a successor.
        let [a, b, c, d] = unsafe { records::<8>(from.as_ptr().cast(), at) };
        [I(a), I(b), I(c), I(d)]
    }
    #[inline(always)]
    fn gather_byte_pairs(self, mask: M, from: &[u8], index: I) -> [I; 2] {
        assert!(from.len() >= 8, "pairs to gather");
        let at = checked(mask, index, from.len() / 4 - 1);
        // SAFETY: NEON is part of the target; unset lanes read pixels 0 and 1, which exist; the
        // others were checked: each has a successor.
        let [a, b] = unsafe { pairs(from.as_ptr(), at) };
        [I(a), I(b)]
    }
}

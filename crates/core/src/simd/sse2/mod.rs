//! SSE2, which is part of every x86-64: 4 lanes, masks as all-ones lanes.
//!
//! In: vectors and the token, slices. Out: vectors, stored numbers. Promise: the bits
//! of `portable.rs`, in whose place it is compiled for x86-64.

mod instructions;
mod lanes;
mod records;

use super::four_lanes::block_of_one_row_methods;
use super::x86::{Evidence, registers, whole_vector_methods};
use super::{F32, I32, Mask, Simd};
use instructions::*;
use lanes::{F, I, M};
use records::{indices, load16, rows_of_four, unsigned_lanes, vector};
use std::arch::x86_64::*;

/// Token of [`Level::Portable`](super::Level::Portable) on x86-64.
#[derive(Clone, Copy, Debug)]
pub struct Sse2;

// SAFETY: every CPU of the target has the instructions.
unsafe impl Evidence for Sse2 {}

impl Simd for Sse2 {
    const LANES: usize = 4;
    type F = F;
    type I = I;
    type M = M;

    whole_vector_methods!();
    block_of_one_row_methods!();

    #[inline(always)]
    fn iota(self) -> I {
        vector([0, 1, 2, 3])
    }
    #[inline(always)]
    fn store_masked_bytes(self, mask: M, v: I, to: &mut [u8]) {
        let new = self.select_i(mask, v, self.load_bytes(to));
        let to = &mut to[..16];
        // SAFETY: the contract of `Evidence`; the slice holds 16 bytes, and x86 is little-endian.
        unsafe { storeu_si(to.as_mut_ptr().cast(), new.0) }
    }
    #[inline(always)]
    fn compress_i(self, mask: M, v: I, to: &mut [i32]) -> usize {
        let to = &mut to[..4];
        let mut n = 0;
        // Each lane is written, and the next one over it if it is unset. The place is below 4; the
        // mask spares the check.
        for (i, lane) in unsigned_lanes(v).into_iter().enumerate() {
            to[n & 3] = lane as i32;
            n += (mask.bits() >> i & 1) as usize;
        }
        n
    }
    #[inline(always)]
    fn zip(self, a: I, b: I) -> [I; 2] {
        registers!(self => [I(unpacklo_epi32(a.0, b.0)), I(unpackhi_epi32(a.0, b.0))])
    }
    #[inline(always)]
    fn compress8(self, mask: M, fields: [I; 8], to: &mut [[i32; 8]]) -> usize {
        let to = &mut to[..4];
        to.fill([0; 8]);
        // Records of unset lanes are 0; the next one is written over them.
        let [a, b, c, d, e, f, g, h] = fields.map(|v| self.select_i(mask, v, self.splat_i(0)));
        let (low, high) = (rows_of_four([a, b, c, d]), rows_of_four([e, f, g, h]));
        let mut n = 0;
        for r in 0..4 {
            let record = &mut to[n & 3];
            self.store_i(I(low[r]), &mut record[..4]);
            self.store_i(I(high[r]), &mut record[4..]);
            n += (mask.bits() >> r & 1) as usize;
        }
        n
    }
    #[inline(always)]
    fn first_occurrences(self, mask: M, v: I) -> M {
        // Shifted by four bytes k times, lane i is lane i - k; where there is none, an unset one.
        registers!(self => {
            let (v, set) = (v.0, mask.0);
            let one = and_si(cmpeq_epi32(_mm_slli_si128::<4>(v), v), _mm_slli_si128::<4>(set));
            let two = and_si(cmpeq_epi32(_mm_slli_si128::<8>(v), v), _mm_slli_si128::<8>(set));
            let three = and_si(cmpeq_epi32(_mm_slli_si128::<12>(v), v), _mm_slli_si128::<12>(set));
            M(_mm_andnot_si128(or_si(one, or_si(two, three)), set))
        })
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> M {
        let lanes = vector([1, 2, 4, 8]);
        (self.splat_i(bits as i32) & lanes).eq(lanes)
    }
    #[inline(always)]
    fn increment(self, mask: M, counts: I) -> I {
        registers!(self => I(sub_epi32(counts.0, mask.0)))
    }
    #[inline(always)]
    fn select(self, mask: M, a: F, b: F) -> F {
        self.select_i(mask, a.bits(), b.bits()).as_f32()
    }
    #[inline(always)]
    fn select_i(self, mask: M, a: I, b: I) -> I {
        registers!(self => I(select(mask.0, a.0, b.0)))
    }
    #[inline(always)]
    fn lookup(self, table: &[i32; 8], index: I) -> I {
        vector(unsigned_lanes(index).map(|at| table[at & 7]))
    }
    #[inline(always)]
    fn gather_bytes(self, mask: M, from: &[u8], index: I) -> I {
        let from = from.as_chunks::<4>().0;
        if !mask.any() {
            return self.splat_i(0);
        }
        let pixels = vector(indices(mask, index).map(|at| i32::from_le_bytes(from[at])));
        self.select_i(mask, pixels, self.splat_i(0))
    }
    #[inline(always)]
    fn gather(self, mask: M, from: &[f32], index: I) -> F {
        if !mask.any() {
            return self.splat(0.0);
        }
        let numbers = vector(indices(mask, index).map(|at| from[at].to_bits() as i32));
        self.select_i(mask, numbers, self.splat_i(0)).as_f32()
    }
    #[inline(always)]
    fn gather4(self, mask: M, from: &[[f32; 4]], index: I) -> [F; 4] {
        rows_of_four(indices(mask, index).map(|at| load16(&from[at]).bits())).map(|row| I(row).as_f32())
    }
    #[inline(always)]
    fn gather_pairs(self, mask: M, from: &[[u16; 4]], index: I) -> [I; 4] {
        let pair = |at: usize| from[at..].first_chunk::<2>().expect("a record and its successor");
        rows_of_four(indices(mask, index).map(|at| load16(pair(at)).bits())).map(I)
    }
    #[inline(always)]
    fn gather_byte_pairs(self, mask: M, from: &[u8], index: I) -> [I; 2] {
        let from = from.as_chunks::<4>().0;
        let [[a, e], [b, f], [c, g], [d, h]] = indices(mask, index).map(|at| {
            let &[first, second] = from[at..].first_chunk().expect("a pixel and its successor");
            [first, second].map(i32::from_le_bytes)
        });
        [vector([a, b, c, d]), vector([e, f, g, h])]
    }
}

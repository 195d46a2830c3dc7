//! WebAssembly with 128-bit vectors: 4 lanes, masks as all-ones lanes.
//!
//! In: vectors and the token, slices. Out: vectors, stored numbers. Promise: the bits
//! of `portable.rs`, in whose place it is compiled for targets that have the feature `simd128`.
//! Instructions are safe to call: a module with an instruction that a browser lacks is refused as a
//! whole.

mod lanes;
mod records;

use super::four_lanes::{block_of_one_row_methods, packing_methods};
use super::{Mask, Simd};
use lanes::{F, I, M};
use records::{checked, load4, load16, packed, packing, store4, transposed};
use std::arch::wasm32::*;

/// Token of [`Level::Portable`](super::Level::Portable) where a module is built with `simd128`.
#[derive(Clone, Copy, Debug)]
pub struct Simd128;

impl Simd for Simd128 {
    const LANES: usize = 4;
    type F = F;
    type I = I;
    type M = M;

    block_of_one_row_methods!();
    packing_methods!();

    #[inline(always)]
    fn splat(self, v: f32) -> F {
        F(f32x4_splat(v))
    }
    #[inline(always)]
    fn splat_i(self, v: i32) -> I {
        I(i32x4_splat(v))
    }
    #[inline(always)]
    fn iota(self) -> I {
        I(i32x4(0, 1, 2, 3))
    }
    #[inline(always)]
    fn load(self, from: &[f32]) -> F {
        F(load4(from))
    }
    #[inline(always)]
    fn load_i(self, from: &[i32]) -> I {
        I(load4(from))
    }
    #[inline(always)]
    fn store(self, v: F, to: &mut [f32]) {
        store4(v.0, to);
    }
    #[inline(always)]
    fn store_i(self, v: I, to: &mut [i32]) {
        store4(v.0, to);
    }
    #[inline(always)]
    fn load_bytes(self, from: &[u8]) -> I {
        I(load16(from.first_chunk().expect("four pixels")))
    }
    #[inline(always)]
    fn store_masked_bytes(self, mask: M, v: I, to: &mut [u8]) {
        let new = self.select_i(mask, v, self.load_bytes(to));
        let [low, high] = [u64x2_extract_lane::<0>(new.0), u64x2_extract_lane::<1>(new.0)];
        to[..8].copy_from_slice(&low.to_le_bytes());
        to[8..16].copy_from_slice(&high.to_le_bytes());
    }
    #[inline(always)]
    fn zip(self, a: I, b: I) -> [I; 2] {
        [I(i32x4_shuffle::<0, 4, 1, 5>(a.0, b.0)), I(i32x4_shuffle::<2, 6, 3, 7>(a.0, b.0))]
    }
    #[inline(always)]
    fn first_occurrences(self, mask: M, v: I) -> M {
        // Lane i sees lane i - k; where there is none, an unset lane.
        let (v, unset, set) = (v.0, i32x4_splat(0), mask.0);
        let one =
            v128_and(i32x4_eq(i32x4_shuffle::<0, 0, 1, 2>(v, v), v), i32x4_shuffle::<4, 0, 1, 2>(set, unset));
        let two =
            v128_and(i32x4_eq(i32x4_shuffle::<0, 0, 0, 1>(v, v), v), i32x4_shuffle::<4, 4, 0, 1>(set, unset));
        let three =
            v128_and(i32x4_eq(i32x4_shuffle::<0, 0, 0, 0>(v, v), v), i32x4_shuffle::<4, 4, 4, 0>(set, unset));
        M(v128_andnot(set, v128_or(one, v128_or(two, three))))
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> M {
        M(i32x4_ne(v128_and(u32x4_splat(bits), u32x4(1, 2, 4, 8)), i32x4_splat(0)))
    }
    #[inline(always)]
    fn increment(self, mask: M, counts: I) -> I {
        I(i32x4_sub(counts.0, mask.0))
    }
    #[inline(always)]
    fn select(self, mask: M, a: F, b: F) -> F {
        F(v128_bitselect(a.0, b.0, mask.0))
    }
    #[inline(always)]
    fn select_i(self, mask: M, a: I, b: I) -> I {
        I(v128_bitselect(a.0, b.0, mask.0))
    }
    #[inline(always)]
    fn lookup(self, table: &[i32; 8], index: I) -> I {
        // The places of each number's four bytes, lowest first; a swizzle gives 0 from 16 on.
        let first = i32x4_mul(v128_and(index.0, i32x4_splat(7)), i32x4_splat(0x0404_0404));
        let places = i32x4_add(first, i32x4_splat(0x0302_0100));
        let low = u8x16_swizzle(load4(&table[..4]), places);
        I(v128_or(low, u8x16_swizzle(load4(&table[4..]), u8x16_sub(places, u8x16_splat(16)))))
    }
    #[inline(always)]
    fn gather_bytes(self, mask: M, from: &[u8], index: I) -> I {
        let from = from.as_chunks::<4>().0;
        let [a, b, c, d] = checked(mask, index, from.len());
        if from.is_empty() {
            return self.splat_i(0);
        }
        let pixel = |at: usize| i32::from_le_bytes(from[at]);
        I(v128_and(i32x4(pixel(a), pixel(b), pixel(c), pixel(d)), mask.0))
    }
    #[inline(always)]
    fn gather(self, mask: M, from: &[f32], index: I) -> F {
        let [a, b, c, d] = checked(mask, index, from.len());
        if from.is_empty() {
            return self.splat(0.0);
        }
        F(v128_and(f32x4(from[a], from[b], from[c], from[d]), mask.0))
    }
    #[inline(always)]
    fn gather4(self, mask: M, from: &[[f32; 4]], index: I) -> [F; 4] {
        let at = checked(mask, index, from.len());
        transposed(at.map(|at| load4(&from[at]))).map(F)
    }
    #[inline(always)]
    fn gather_pairs(self, mask: M, from: &[[u16; 4]], index: I) -> [I; 4] {
        assert!(from.len() > 1, "pairs to gather");
        let word = |record: [u16; 4]| {
            let [a, b, c, d] = record.map(u64::from);
            a | b << 16 | c << 32 | d << 48
        };
        let pair = |at: usize| u64x2(word(from[at]), word(from[at + 1]));
        transposed(checked(mask, index, from.len() - 1).map(pair)).map(I)
    }
    #[inline(always)]
    fn gather_byte_pairs(self, mask: M, from: &[u8], index: I) -> [I; 2] {
        let from = from.as_chunks::<4>().0;
        assert!(from.len() > 1, "pairs to gather");
        let [a, b, c, d] = checked(mask, index, from.len() - 1);
        let pixel = |at: usize| i32::from_le_bytes(from[at]);
        [
            I(i32x4(pixel(a), pixel(b), pixel(c), pixel(d))),
            I(i32x4(pixel(a + 1), pixel(b + 1), pixel(c + 1), pixel(d + 1))),
        ]
    }
}

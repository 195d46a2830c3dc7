//! AVX-512: 16 lanes, masks in mask registers.

mod instructions;
mod lanes;
mod records;

use super::avx_records::record_methods;
use super::spill::Spill;
use super::x86::{Evidence, registers, whole_vector_methods};
use super::{F32, Kernel, Part, Simd};
use instructions::*;
use lanes::{F, I, M};
use records::{check, index_or_0, pixel_pairs, rows_of_four, transposed};
use std::arch::x86_64::*;

/// Token of the level; only [`RunAvx512`] creates it.
#[derive(Clone, Copy, Debug)]
pub struct Avx512(());

// SAFETY: only `run_avx512` makes the token, and its callers make sure of the features.
unsafe impl Evidence for Avx512 {}

/// The entry of a kernel at this level, a method of the type that its unit of code is chosen by
/// ([`LongKernel`](super::LongKernel) says how).
pub trait RunAvx512 {
    /// Runs the kernel compiled for AVX-512.
    ///
    /// # Safety
    /// The CPU must have AVX-512 F, BW, DQ, VL and CD (and with them AVX2).
    #[target_feature(enable = "avx2,avx512f,avx512bw,avx512dq,avx512vl,avx512cd,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn run_avx512<K: Kernel>(kernel: K) -> K::Output {
        kernel.run(Avx512(()))
    }
}

impl<U> RunAvx512 for U {}

/// The entry of kernels' parts at this level, a method of its token.
trait CallAvx512: Simd {
    /// Runs a part compiled for AVX-512.
    ///
    /// # Safety
    /// The CPU must have these features.
    #[inline(never)]
    #[target_feature(enable = "avx2,avx512f,avx512bw,avx512dq,avx512vl,avx512cd,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn call_avx512<P: Part<Self>>(self, part: P) -> P::Output {
        part.run(self)
    }
}

impl<S: Simd> CallAvx512 for S {}

impl Simd for Avx512 {
    const LANES: usize = 16;
    type F = F;
    type I = I;
    type M = M;

    whole_vector_methods!();
    record_methods!();

    #[inline(always)]
    fn call<S: Simd, P: Part<S>>(self, s: S, part: P) -> P::Output {
        // SAFETY: the contract of `Evidence`.
        unsafe { s.call_avx512(part) }
    }
    #[inline(always)]
    fn iota(self) -> I {
        registers!(self => I(_mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15)))
    }
    #[inline(always)]
    fn store_masked_i(self, mask: M, v: I, to: &mut [i32]) {
        let to = &mut to[..16];
        // SAFETY: the contract of `Evidence`; the target holds 16 elements.
        unsafe { _mm512_mask_storeu_epi32(to.as_mut_ptr(), mask.0, v.0) }
    }
    #[inline(always)]
    fn store_masked_bytes(self, mask: M, v: I, to: &mut [u8]) {
        let to = &mut to[..64];
        // SAFETY: the contract of `Evidence`; the slice holds 64 bytes, and x86 is
        // little-endian.
        unsafe { _mm512_mask_storeu_epi32(to.as_mut_ptr().cast(), mask.0, v.0) }
    }
    #[inline(always)]
    fn load_block(self, from: &[i32], stride: usize) -> I {
        let rows = [&from[..4], &from[stride..][..4], &from[stride * 2..][..4], &from[stride * 3..][..4]];
        // SAFETY: the contract of `Evidence`; each row has 4 numbers.
        unsafe {
            let v = _mm512_castsi128_si512(_mm_loadu_si128(rows[0].as_ptr().cast()));
            let v = _mm512_inserti32x4::<1>(v, _mm_loadu_si128(rows[1].as_ptr().cast()));
            let v = _mm512_inserti32x4::<2>(v, _mm_loadu_si128(rows[2].as_ptr().cast()));
            I(_mm512_inserti32x4::<3>(v, _mm_loadu_si128(rows[3].as_ptr().cast())))
        }
    }
    #[inline(always)]
    fn store_block_bytes(self, mask: M, v: I, to: &mut [u8], stride: usize) {
        let rows = registers!(self => {
            [
                _mm512_castsi512_si128(v.0),
                _mm512_extracti32x4_epi32::<1>(v.0),
                _mm512_extracti32x4_epi32::<2>(v.0),
                _mm512_extracti32x4_epi32::<3>(v.0),
            ]
        });
        let mut r = 0;
        while r < 4 {
            let lanes = (mask.0 >> (4 * r)) as u8 & 15;
            if lanes != 0 {
                let row = &mut to[r * stride * 4..][..16];
                // SAFETY: the contract of `Evidence`; the slice holds 16 bytes, and x86 is
                // little-endian.
                unsafe { _mm_mask_storeu_epi32(row.as_mut_ptr().cast(), lanes, rows[r]) }
            }
            r += 1;
        }
    }
    #[inline(always)]
    fn compress_i(self, mask: M, v: I, to: &mut [i32]) -> usize {
        let to = &mut to[..16];
        // Compress in a register, then store it whole: a compressing store is many times slower on
        // some CPUs. SAFETY: the contract of `Evidence`; 16 places are there.
        unsafe { _mm512_storeu_si512(to.as_mut_ptr().cast(), _mm512_maskz_compress_epi32(mask.0, v.0)) }
        mask.0.count_ones() as usize
    }
    #[inline(always)]
    fn zip(self, a: I, b: I) -> [I; 2] {
        registers!(self => {
            // Lane indices; those from 16 on select lanes of b.
            let first = _mm512_setr_epi32(0, 16, 1, 17, 2, 18, 3, 19, 4, 20, 5, 21, 6, 22, 7, 23);
            let second = _mm512_add_epi32(first, _mm512_set1_epi32(8));
            [I(_mm512_permutex2var_epi32(a.0, first, b.0)), I(_mm512_permutex2var_epi32(a.0, second, b.0))]
        })
    }
    #[inline(always)]
    fn compress8(self, mask: M, fields: [I; 8], to: &mut [[i32; 8]]) -> usize {
        let to = &mut to[..16];
        // SAFETY: the contract of `Evidence`; the target holds 16 records of 32 bytes, and
        // stores need no alignment.
        unsafe {
            let f = [
                I(_mm512_maskz_compress_epi32(mask.0, fields[0].0)),
                I(_mm512_maskz_compress_epi32(mask.0, fields[1].0)),
                I(_mm512_maskz_compress_epi32(mask.0, fields[2].0)),
                I(_mm512_maskz_compress_epi32(mask.0, fields[3].0)),
                I(_mm512_maskz_compress_epi32(mask.0, fields[4].0)),
                I(_mm512_maskz_compress_epi32(mask.0, fields[5].0)),
                I(_mm512_maskz_compress_epi32(mask.0, fields[6].0)),
                I(_mm512_maskz_compress_epi32(mask.0, fields[7].0)),
            ];
            // Row r holds in quarter q the halves of record 4 q + r.
            let (low, high) =
                (rows_of_four([f[0], f[1], f[2], f[3]]), rows_of_four([f[4], f[5], f[6], f[7]]));
            let first = _mm512_setr_epi64(0, 1, 8, 9, 2, 3, 10, 11);
            let last = _mm512_setr_epi64(4, 5, 12, 13, 6, 7, 14, 15);
            let mut r = 0;
            while r < 4 {
                let a = _mm512_permutex2var_epi64(low[r], first, high[r]);
                let b = _mm512_permutex2var_epi64(low[r], last, high[r]);
                _mm256_storeu_si256(to[r].as_mut_ptr().cast(), _mm512_castsi512_si256(a));
                _mm256_storeu_si256(to[r + 4].as_mut_ptr().cast(), _mm512_extracti64x4_epi64::<1>(a));
                _mm256_storeu_si256(to[r + 8].as_mut_ptr().cast(), _mm512_castsi512_si256(b));
                _mm256_storeu_si256(to[r + 12].as_mut_ptr().cast(), _mm512_extracti64x4_epi64::<1>(b));
                r += 1;
            }
        }
        mask.0.count_ones() as usize
    }
    #[inline(always)]
    fn first_occurrences(self, mask: M, v: I) -> M {
        registers!(self => {
            let earlier = _mm512_conflict_epi32(v.0);
            M(_mm512_mask_testn_epi32_mask(mask.0, earlier, _mm512_set1_epi32(mask.0 as i32)))
        })
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> M {
        M(bits as u16)
    }
    #[inline(always)]
    fn increment(self, mask: M, counts: I) -> I {
        registers!(self => I(_mm512_mask_add_epi32(counts.0, mask.0, counts.0, set1_epi32(1))))
    }
    #[inline(always)]
    fn select(self, mask: M, a: F, b: F) -> F {
        registers!(self => F(_mm512_mask_blend_ps(mask.0, b.0, a.0)))
    }
    #[inline(always)]
    fn select_i(self, mask: M, a: I, b: I) -> I {
        registers!(self => I(_mm512_mask_blend_epi32(mask.0, b.0, a.0)))
    }
    #[inline(always)]
    fn lookup(self, table: &[i32; 8], index: I) -> I {
        // SAFETY: the contract of `Evidence`; the table's 32 bytes are read, which need no
        // alignment.
        unsafe {
            let table = _mm512_broadcast_i64x4(_mm256_loadu_si256(table.as_ptr().cast()));
            I(_mm512_permutexvar_epi32(index.0, table))
        }
    }
    #[inline(always)]
    fn gather_bytes(self, mask: M, from: &[u8], index: I) -> I {
        check(mask, index, from.len() / 4);
        // SAFETY: the contract of `Evidence`; every set lane's pixel was found inside the slice;
        // loads need no alignment.
        unsafe {
            I(_mm512_mask_i32gather_epi32::<4>(_mm512_setzero_si512(), mask.0, index.0, from.as_ptr().cast()))
        }
    }
    #[inline(always)]
    fn gather(self, mask: M, from: &[f32], index: I) -> F {
        check(mask, index, from.len());
        // SAFETY: the contract of `Evidence`; every set lane's index was found inside the slice.
        unsafe {
            F(_mm512_mask_i32gather_ps::<4>(_mm512_setzero_ps(), mask.0, index.0, from.as_ptr().cast()))
        }
    }
}

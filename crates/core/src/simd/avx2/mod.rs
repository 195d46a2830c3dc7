//! AVX2: 8 lanes, masks as all-ones lanes.

mod instructions;
mod lanes;
mod pairing;
mod records;

use super::avx_records::record_methods;
use super::pair::Paired;
use super::spill::Spill;
use super::x86::{Evidence, registers, whole_vector_methods};
use super::{F32, Kernel, Mask, Part, Simd};
use instructions::*;
use lanes::{F, I, M};
use records::{COMPRESS, check, index_or_0, packed, pixel_pairs, repeats, rows_of_four, transposed, upwards};
use std::arch::x86_64::*;

pub use pairing::pairs_are_faster;
#[cfg(test)]
pub use pairing::with_pairs;

/// Token of the level; only [`RunAvx2`] creates it.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

// SAFETY: only `run_avx2` and `run_paired` make the token, and their callers make sure of the
// features.
unsafe impl Evidence for Avx2 {}

/// The entries of a kernel at this level, methods of the type that their unit of code is chosen by
/// ([`LongKernel`](super::LongKernel) says how).
pub trait RunAvx2 {
    /// Runs the kernel compiled for AVX2.
    ///
    /// # Safety
    /// The CPU must have these features.
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn run_avx2<K: Kernel>(kernel: K) -> K::Output {
        kernel.run(Avx2(()))
    }

    /// Runs the kernel compiled for AVX2, over pairs of its vectors.
    ///
    /// # Safety
    /// The CPU must have these features.
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn run_paired<K: Kernel>(kernel: K) -> K::Output {
        kernel.run(Paired(Avx2(())))
    }
}

impl<U> RunAvx2 for U {}

/// The entry of kernels' parts at this level, a method of the token of the level or of its pairs: each
/// has its own unit of code.
trait CallAvx2: Simd {
    /// Runs a part compiled for AVX2.
    ///
    /// # Safety
    /// The CPU must have these features.
    #[inline(never)]
    #[target_feature(enable = "avx2,bmi1,bmi2,lzcnt,popcnt")]
    unsafe fn call_avx2<P: Part<Self>>(self, part: P) -> P::Output {
        part.run(self)
    }
}

impl<S: Simd> CallAvx2 for S {}

impl Simd for Avx2 {
    const LANES: usize = 8;
    type F = F;
    type I = I;
    type M = M;

    whole_vector_methods!();
    record_methods!();

    #[inline(always)]
    fn call<S: Simd, P: Part<S>>(self, s: S, part: P) -> P::Output {
        // SAFETY: the contract of `Evidence`.
        unsafe { s.call_avx2(part) }
    }
    #[inline(always)]
    fn iota(self) -> I {
        registers!(self => I(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)))
    }
    #[inline(always)]
    fn store_masked_i(self, mask: M, v: I, to: &mut [i32]) {
        let to = &mut to[..8];
        // SAFETY: the contract of `Evidence`; the target holds 8 elements.
        unsafe {
            let old = _mm256_loadu_si256(to.as_ptr().cast());
            _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_blendv_epi8(old, v.0, mask.0))
        }
    }
    #[inline(always)]
    fn store_masked_bytes(self, mask: M, v: I, to: &mut [u8]) {
        let to = &mut to[..32];
        // SAFETY: the contract of `Evidence`; the slice holds 32 bytes, and x86 is
        // little-endian.
        unsafe {
            let old = _mm256_loadu_si256(to.as_ptr().cast());
            _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_blendv_epi8(old, v.0, mask.0))
        }
    }
    #[inline(always)]
    fn load_block(self, from: &[i32], stride: usize) -> I {
        let rows = [&from[..4], &from[stride..][..4]];
        // SAFETY: the contract of `Evidence`; each row has 4 numbers.
        unsafe {
            let v = _mm256_castsi128_si256(_mm_loadu_si128(rows[0].as_ptr().cast()));
            I(_mm256_inserti128_si256::<1>(v, _mm_loadu_si128(rows[1].as_ptr().cast())))
        }
    }
    #[inline(always)]
    fn store_block_bytes(self, mask: M, v: I, to: &mut [u8], stride: usize) {
        let bits = mask.bits();
        let (rows, masks) = registers!(self => {
            (
                [_mm256_castsi256_si128(v.0), _mm256_extracti128_si256::<1>(v.0)],
                [_mm256_castsi256_si128(mask.0), _mm256_extracti128_si256::<1>(mask.0)],
            )
        });
        let mut r = 0;
        while r < 2 {
            if bits >> (4 * r) & 15 != 0 {
                let row = &mut to[r * stride * 4..][..16];
                // SAFETY: the contract of `Evidence`; the slice holds 16 bytes, and x86 is
                // little-endian.
                unsafe {
                    // A whole row does not wait for what it replaces.
                    if bits >> (4 * r) & 15 == 15 {
                        _mm_storeu_si128(row.as_mut_ptr().cast(), rows[r]);
                    } else {
                        let old = _mm_loadu_si128(row.as_ptr().cast());
                        _mm_storeu_si128(row.as_mut_ptr().cast(), _mm_blendv_epi8(old, rows[r], masks[r]));
                    }
                }
            }
            r += 1;
        }
    }
    #[inline(always)]
    fn compress_i(self, mask: M, v: I, to: &mut [i32]) -> usize {
        let to = &mut to[..8];
        let bits = mask.bits() as usize;
        // SAFETY: the contract of `Evidence`; the target holds 8 elements; a table row has 8
        // numbers.
        unsafe {
            let order = _mm256_loadu_si256(COMPRESS[bits & 255].as_ptr().cast());
            _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(v.0, order));
        }
        bits.count_ones() as usize
    }
    #[inline(always)]
    fn zip(self, a: I, b: I) -> [I; 2] {
        registers!(self => {
            let (low, high) = (_mm256_unpacklo_epi32(a.0, b.0), _mm256_unpackhi_epi32(a.0, b.0));
            [I(_mm256_permute2x128_si256::<0x20>(low, high)), I(_mm256_permute2x128_si256::<0x31>(low, high))]
        })
    }
    #[inline(always)]
    fn compress8(self, mask: M, fields: [I; 8], to: &mut [[i32; 8]]) -> usize {
        let to = &mut to[..8];
        let bits = mask.bits() as usize;
        let count = bits.count_ones() as i32;
        // SAFETY: the contract of `Evidence`; the target holds 8 records of 32 bytes, and stores
        // need no alignment; a table row has 8 numbers.
        unsafe {
            let order = I(_mm256_loadu_si256(COMPRESS[bits & 255].as_ptr().cast()));
            let kept = I(_mm256_cmpgt_epi32(_mm256_set1_epi32(count), self.iota().0));
            let f = [
                packed(fields[0], order, kept),
                packed(fields[1], order, kept),
                packed(fields[2], order, kept),
                packed(fields[3], order, kept),
                packed(fields[4], order, kept),
                packed(fields[5], order, kept),
                packed(fields[6], order, kept),
                packed(fields[7], order, kept),
            ];
            // Row r holds in half q the halves of record 4 q + r.
            let (low, high) =
                (rows_of_four([f[0], f[1], f[2], f[3]]), rows_of_four([f[4], f[5], f[6], f[7]]));
            let mut r = 0;
            while r < 4 {
                let first = _mm256_permute2x128_si256::<0x20>(low[r], high[r]);
                let second = _mm256_permute2x128_si256::<0x31>(low[r], high[r]);
                _mm256_storeu_si256(to[r].as_mut_ptr().cast(), first);
                _mm256_storeu_si256(to[r + 4].as_mut_ptr().cast(), second);
                r += 1;
            }
        }
        count as usize
    }
    #[inline(always)]
    fn first_occurrences(self, mask: M, v: I) -> M {
        registers!(self => {
            // Lane i sees lane i - k; where there is none, an unset one. Moves within 16 bytes are
            // several times as fast as permutations of lanes.
            let none = _mm256_setzero_si256();
            let near = [[v.0, upwards(v.0)], [mask.0, upwards(mask.0)]];
            let far = [[near[0][1], none], [near[1][1], none]];
            let again = or_si(repeats::<12>(v.0, near), repeats::<8>(v.0, near));
            let again = or_si(again, or_si(repeats::<4>(v.0, near), repeats::<0>(v.0, near)));
            let again = or_si(again, or_si(repeats::<12>(v.0, far), repeats::<8>(v.0, far)));
            let again = or_si(again, repeats::<4>(v.0, far));
            M(_mm256_andnot_si256(again, mask.0))
        })
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> M {
        registers!(self => {
            let lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            M(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(bits as i32), lane), lane))
        })
    }
    #[inline(always)]
    fn increment(self, mask: M, counts: I) -> I {
        registers!(self => I(sub_epi32(counts.0, mask.0)))
    }
    #[inline(always)]
    fn select(self, mask: M, a: F, b: F) -> F {
        registers!(self => F(_mm256_blendv_ps(b.0, a.0, _mm256_castsi256_ps(mask.0))))
    }
    #[inline(always)]
    fn select_i(self, mask: M, a: I, b: I) -> I {
        registers!(self => I(_mm256_blendv_epi8(b.0, a.0, mask.0)))
    }
    #[inline(always)]
    fn lookup(self, table: &[i32; 8], index: I) -> I {
        // SAFETY: the contract of `Evidence`; the table's 32 bytes are read, which need no
        // alignment.
        unsafe { I(_mm256_permutevar8x32_epi32(_mm256_loadu_si256(table.as_ptr().cast()), index.0)) }
    }
    #[inline(always)]
    fn gather_bytes(self, mask: M, from: &[u8], index: I) -> I {
        check(mask, index, from.len() / 4);
        // SAFETY: the contract of `Evidence`; every set lane's pixel was found inside the slice;
        // loads need no alignment.
        unsafe {
            let base = from.as_ptr().cast::<i32>();
            I(_mm256_mask_i32gather_epi32::<4>(_mm256_setzero_si256(), base, index.0, mask.0))
        }
    }
    #[inline(always)]
    fn gather(self, mask: M, from: &[f32], index: I) -> F {
        check(mask, index, from.len());
        // SAFETY: the contract of `Evidence`; every set lane's index was found inside the slice.
        unsafe {
            F(_mm256_mask_i32gather_ps::<4>(
                _mm256_setzero_ps(),
                from.as_ptr(),
                index.0,
                _mm256_castsi256_ps(mask.0),
            ))
        }
    }
}

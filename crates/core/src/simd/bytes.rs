//! Vectors of bytes for code that reads text: x86 instructions as safe methods of a token.
//!
//! In: arrays and vectors. Out: vectors and masks. A token is made only where the CPU has the
//! features that its methods need; [`Avx2Bytes::run`] and [`Avx512Bytes::run`] look, pass it to a
//! kernel, and compile the kernel for these features. Methods have the names of their
//! instructions. Safety: the contract of `Evidence`.

use super::x86::{Evidence, registers};
use std::arch::x86_64::*;

/// Code over a token. Mark `run` `#[inline(always)]`, so that it is compiled for the token's
/// features.
pub trait ByteKernel<T> {
    /// Result of [`run`](ByteKernel::run).
    type Output;
    /// Runs the kernel.
    fn run(self, token: T) -> Self::Output;
}

/// Token: the CPU has AVX2 and BMI1.
#[derive(Clone, Copy, Debug)]
pub struct Avx2Bytes(());

/// Token: the CPU has AVX-512 F, BW, VL, VBMI and VBMI2, and POPCNT.
#[derive(Clone, Copy, Debug)]
pub struct Avx512Bytes(());

// SAFETY: only `run` makes one, where `is_available` has found the features.
unsafe impl Evidence for Avx2Bytes {}
// SAFETY: only `run` makes one, where `is_available` has found the features.
unsafe impl Evidence for Avx512Bytes {}

/// Defines methods of a token that are one instruction on registers each.
macro_rules! instructions {
    ($($name:ident($($arg:ident: $type:ty),*) -> $out:ty;)+) => {$(
        #[doc = concat!("Executes `", stringify!($name), "`.")]
        #[inline(always)]
        pub fn $name(self, $($arg: $type),*) -> $out {
            registers!(self => $name($($arg),*))
        }
    )+};
}

impl Avx2Bytes {
    /// Returns whether the CPU has the features. The CPU is asked once; later calls are a load.
    #[inline]
    pub fn is_available() -> bool {
        is_x86_feature_detected!("avx2") && is_x86_feature_detected!("bmi1")
    }

    /// Runs a kernel; `None` if the CPU lacks a feature.
    #[inline]
    pub fn run<K: ByteKernel<Self>>(kernel: K) -> Option<K::Output> {
        // SAFETY: the CPU was just found to have the features that the function names.
        Self::is_available().then(|| unsafe { run_avx2(kernel) })
    }

    /// Loads 16 bytes.
    #[inline(always)]
    pub fn load(self, bytes: &[u8; 16]) -> __m128i {
        // SAFETY: the contract of `Evidence`; the reference is to 16 bytes, of any alignment.
        unsafe { _mm_loadu_si128(bytes.as_ptr().cast()) }
    }

    /// Returns the dword at position 1.
    #[inline(always)]
    pub fn second_dword(self, a: __m128i) -> u32 {
        registers!(self => _mm_extract_epi32::<1>(a) as u32)
    }

    instructions! {
        _mm_set1_epi8(a: i8) -> __m128i;
        _mm_set_epi64x(high: i64, low: i64) -> __m128i;
        _mm_cmpeq_epi8(a: __m128i, b: __m128i) -> __m128i;
        _mm_movemask_epi8(a: __m128i) -> i32;
        _mm_shuffle_epi8(a: __m128i, order: __m128i) -> __m128i;
        _mm_or_si128(a: __m128i, b: __m128i) -> __m128i;
        _mm_and_si128(a: __m128i, b: __m128i) -> __m128i;
        _mm_cvtsi64_si128(a: i64) -> __m128i;
        _mm_cvtsi128_si64(a: __m128i) -> i64;
        _mm_unpacklo_epi64(a: __m128i, b: __m128i) -> __m128i;
        _mm_sub_epi8(a: __m128i, b: __m128i) -> __m128i;
        _mm_add_epi8(a: __m128i, b: __m128i) -> __m128i;
        _mm_min_epu8(a: __m128i, b: __m128i) -> __m128i;
        _mm_maddubs_epi16(a: __m128i, b: __m128i) -> __m128i;
        _mm_madd_epi16(a: __m128i, b: __m128i) -> __m128i;
        _mm_packus_epi16(a: __m128i, b: __m128i) -> __m128i;
    }
}

#[target_feature(enable = "avx2,bmi1")]
fn run_avx2<K: ByteKernel<Avx2Bytes>>(kernel: K) -> K::Output {
    kernel.run(Avx2Bytes(()))
}

impl Avx512Bytes {
    /// Returns whether the CPU has the features. The CPU is asked once; later calls are some loads.
    #[inline]
    pub fn is_available() -> bool {
        is_x86_feature_detected!("avx512f")
            && is_x86_feature_detected!("avx512bw")
            && is_x86_feature_detected!("avx512vl")
            && is_x86_feature_detected!("avx512vbmi")
            && is_x86_feature_detected!("avx512vbmi2")
            && is_x86_feature_detected!("popcnt")
    }

    /// Runs a kernel; `None` if the CPU lacks a feature.
    #[inline]
    pub fn run<K: ByteKernel<Self>>(kernel: K) -> Option<K::Output> {
        // SAFETY: the CPU was just found to have the features that the function names.
        Self::is_available().then(|| unsafe { run_avx512(kernel) })
    }

    /// Loads 64 bytes.
    #[inline(always)]
    pub fn load(self, bytes: &[u8; 64]) -> __m512i {
        // SAFETY: the contract of `Evidence`; the reference is to 64 bytes, of any alignment.
        unsafe { _mm512_loadu_si512(bytes.as_ptr().cast()) }
    }

    /// Loads 16 bytes.
    #[inline(always)]
    pub fn load_16(self, bytes: &[u8; 16]) -> __m128i {
        // SAFETY: the contract of `Evidence`; the reference is to 16 bytes, of any alignment.
        unsafe { _mm_loadu_si128(bytes.as_ptr().cast()) }
    }

    /// Loads 16 words.
    #[inline(always)]
    pub fn load_words(self, words: &[u16; 16]) -> __m256i {
        // SAFETY: the contract of `Evidence`; the reference is to 32 bytes, of any alignment.
        unsafe { _mm256_loadu_si256(words.as_ptr().cast()) }
    }

    /// Stores 32 words.
    #[inline(always)]
    pub fn store_words(self, to: &mut [u16; 32], words: __m512i) {
        // SAFETY: the contract of `Evidence`; the reference is to 64 bytes, of any alignment.
        unsafe { _mm512_storeu_si512(to.as_mut_ptr().cast(), words) }
    }

    /// Stores the lower 32 bytes.
    #[inline(always)]
    pub fn store_lower(self, to: &mut [u8; 32], bytes: __m512i) {
        // SAFETY: the contract of `Evidence`; the reference is to 32 bytes, of any alignment.
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm512_castsi512_si256(bytes)) }
    }

    /// Stores 32 bytes as four records of eight.
    #[inline(always)]
    pub fn store_records(self, to: &mut [[u8; 8]; 4], records: __m256i) {
        // SAFETY: the contract of `Evidence`; the reference is to 32 bytes, of any alignment.
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), records) }
    }

    /// Repeats 16 bytes four times.
    #[inline(always)]
    pub fn repeat_16(self, bytes: &[u8; 16]) -> __m512i {
        let bytes = self.load_16(bytes);
        registers!(self => _mm512_broadcast_i32x4(bytes))
    }

    /// Shifts words left by N bits.
    #[inline(always)]
    pub fn shift_left<const N: u32>(self, words: __m512i) -> __m512i {
        registers!(self => _mm512_slli_epi16::<N>(words))
    }

    /// Shifts words right by N bits, filling with zeros.
    #[inline(always)]
    pub fn shift_right<const N: u32>(self, words: __m512i) -> __m512i {
        registers!(self => _mm512_srli_epi16::<N>(words))
    }

    instructions! {
        _mm_set1_epi32(a: i32) -> __m128i;
        _mm_cmpeq_epi8_mask(a: __m128i, b: __m128i) -> u16;
        _mm256_set1_epi16(a: i16) -> __m256i;
        _mm256_set1_epi64x(a: i64) -> __m256i;
        _mm256_sub_epi16(a: __m256i, b: __m256i) -> __m256i;
        _mm256_cmple_epu16_mask(a: __m256i, b: __m256i) -> u16;
        _mm512_set1_epi8(a: i8) -> __m512i;
        _mm512_set1_epi16(a: i16) -> __m512i;
        _mm512_set1_epi64(a: i64) -> __m512i;
        _mm512_castsi256_si512(a: __m256i) -> __m512i;
        _mm512_castsi512_si256(a: __m512i) -> __m256i;
        _mm512_cvtepu8_epi16(a: __m256i) -> __m512i;
        _mm512_cvtepi32_epi16(a: __m512i) -> __m256i;
        _mm512_and_si512(a: __m512i, b: __m512i) -> __m512i;
        _mm512_or_si512(a: __m512i, b: __m512i) -> __m512i;
        _mm512_add_epi8(a: __m512i, b: __m512i) -> __m512i;
        _mm512_sub_epi8(a: __m512i, b: __m512i) -> __m512i;
        _mm512_add_epi16(a: __m512i, b: __m512i) -> __m512i;
        _mm512_maddubs_epi16(a: __m512i, b: __m512i) -> __m512i;
        _mm512_madd_epi16(a: __m512i, b: __m512i) -> __m512i;
        _mm512_cmpeq_epi8_mask(a: __m512i, b: __m512i) -> u64;
        _mm512_cmple_epu8_mask(a: __m512i, b: __m512i) -> u64;
        _mm512_mask_cmpeq_epi8_mask(mask: u64, a: __m512i, b: __m512i) -> u64;
        _mm512_mask_cmpneq_epi8_mask(mask: u64, a: __m512i, b: __m512i) -> u64;
        _mm512_mask_cmple_epu8_mask(mask: u64, a: __m512i, b: __m512i) -> u64;
        _mm512_movepi8_mask(a: __m512i) -> u64;
        _mm512_maskz_compress_epi8(mask: u64, a: __m512i) -> __m512i;
        _mm512_mask_mov_epi8(a: __m512i, mask: u64, b: __m512i) -> __m512i;
        _mm512_mask_mov_epi64(a: __m512i, mask: u8, b: __m512i) -> __m512i;
        _mm512_mask_add_epi8(src: __m512i, mask: u64, a: __m512i, b: __m512i) -> __m512i;
        _mm512_permutexvar_epi8(index: __m512i, a: __m512i) -> __m512i;
        _mm512_permutex2var_epi8(a: __m512i, index: __m512i, b: __m512i) -> __m512i;
    }
}

#[target_feature(enable = "avx512f,avx512bw,avx512vl,avx512vbmi,avx512vbmi2,popcnt")]
fn run_avx512<K: ByteKernel<Avx512Bytes>>(kernel: K) -> K::Output {
    kernel.run(Avx512Bytes(()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_go_through_vectors_unchanged() {
        struct Copy16([u8; 16]);
        impl ByteKernel<Avx2Bytes> for Copy16 {
            type Output = (i64, u32);
            fn run(self, v: Avx2Bytes) -> (i64, u32) {
                let loaded = v.load(&self.0);
                (v._mm_cvtsi128_si64(loaded), v.second_dword(loaded))
            }
        }
        struct Copy64([u8; 64]);
        impl ByteKernel<Avx512Bytes> for Copy64 {
            type Output = ([u16; 32], [u8; 32], [[u8; 8]; 4]);
            fn run(self, v: Avx512Bytes) -> Self::Output {
                let (mut words, mut lower, mut records) = ([0; 32], [0; 32], [[0; 8]; 4]);
                let loaded = v.load(&self.0);
                v.store_words(&mut words, loaded);
                v.store_lower(&mut lower, loaded);
                v.store_records(&mut records, v.load_words(words.first_chunk().unwrap()));
                (words, lower, records)
            }
        }
        let bytes: [u8; 64] = std::array::from_fn(|i| i as u8 ^ 0x85);
        let sixteen = *bytes.first_chunk().unwrap();
        if let Some((low, second)) = Avx2Bytes::run(Copy16(sixteen)) {
            assert_eq!(low, i64::from_le_bytes(bytes[..8].try_into().unwrap()));
            assert_eq!(second, u32::from_le_bytes(bytes[4..8].try_into().unwrap()));
        }
        if let Some((words, lower, records)) = Avx512Bytes::run(Copy64(bytes)) {
            assert_eq!(words.map(u16::to_le_bytes).as_flattened(), bytes);
            assert_eq!(lower, bytes[..32]);
            assert_eq!(records.as_flattened(), &bytes[..32]);
        }
    }
}

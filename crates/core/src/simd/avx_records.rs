//! Gathers of records and transpositions, written once for AVX2 and AVX-512, as `x86.rs` is for all
//! x86 widths: its conventions and its promise hold here.

use std::arch::x86_64::*;

/// Methods of `Simd` that gather records or pairs.
macro_rules! record_methods {
    () => {
        #[inline(always)]
        fn gather4(self, mask: M, from: &[[f32; 4]], index: I) -> [F; 4] {
            assert!(!from.is_empty(), "records to gather");
            check(mask, index, from.len());
            // SAFETY: the contract of `Evidence`; unset lanes read record 0, which exists, the
            // others were checked.
            let [a, b, c, d] = unsafe { transposed::<16>(mask, index, from.as_ptr().cast()) };
            [F(a), F(b), F(c), F(d)]
        }
        #[inline(always)]
        fn gather_pairs(self, mask: M, from: &[[u16; 4]], index: I) -> [I; 4] {
            assert!(from.len() > 1, "pairs to gather");
            check(mask, index, from.len() - 1);
            // SAFETY: the contract of `Evidence`; unset lanes read records 0 and 1, which exist,
            // the others were checked: each has a successor.
            let [a, b, c, d] = unsafe { transposed::<8>(mask, index, from.as_ptr().cast()) };
            [F(a).bits(), F(b).bits(), F(c).bits(), F(d).bits()]
        }
        #[inline(always)]
        fn gather_byte_pairs(self, mask: M, from: &[u8], index: I) -> [I; 2] {
            assert!(from.len() >= 8, "pairs to gather");
            check(mask, index, from.len() / 4 - 1);
            // SAFETY: the contract of `Evidence`; unset lanes read pixels 0 and 1, which exist, the
            // others were checked: each has a successor. Loads need no alignment.
            unsafe {
                let mut at = Spill([0i32; Self::LANES]);
                storeu_si(at.0.as_mut_ptr().cast(), index_or_0(mask, index));
                // Lanes 4 q + 2 k and the next in the q-th 16 bytes.
                let (a, b) = (pixel_pairs(from, &at, 0), pixel_pairs(from, &at, 1));
                [
                    I(castps_si(shuffle_ps::<0b10_00_10_00>(a, b))),
                    I(castps_si(shuffle_ps::<0b11_01_11_01>(a, b))),
                ]
            }
        }
    };
}
pub(super) use record_methods;

/// Transpositions between lanes and records, within each 16 bytes of a vector.
macro_rules! transpositions {
    ($lanes:literal) => {
        /// Gathers four words for each lane, transposed: from STRIDE times its index bytes after
        /// `from` where it is set, from `from` elsewhere.
        ///
        /// # Safety
        /// 16 bytes must be readable at each of those places.
        #[inline(always)]
        pub(super) unsafe fn transposed<const STRIDE: usize>(
            mask: M,
            index: I,
            from: *const u8,
        ) -> [Floats; 4] {
            // SAFETY: the contract of `Evidence`, and the caller's promise; the array holds a
            // vector's elements.
            unsafe {
                let mut at = Spill([0i32; $lanes]);
                storeu_si(at.0.as_mut_ptr().cast(), in_eights::<STRIDE>(index_or_0(mask, index)));
                // Row r holds the records of lanes r, 4 + r, ...; a 4x4 transpose within each 16
                // bytes finishes it.
                let ([a, b], [c, d]) = (two_rows(from, &at, 0), two_rows(from, &at, 1));
                let (ab, cd) = (unpacklo_ps(a, b), unpacklo_ps(c, d));
                let (ef, gh) = (unpackhi_ps(a, b), unpackhi_ps(c, d));
                [
                    shuffle_ps::<0b01_00_01_00>(ab, cd),
                    shuffle_ps::<0b11_10_11_10>(ab, cd),
                    shuffle_ps::<0b01_00_01_00>(ef, gh),
                    shuffle_ps::<0b11_10_11_10>(ef, gh),
                ]
            }
        }

        /// Returns the places of records of STRIDE bytes, 8 or 16, in units of eight bytes, by which
        /// an address is scaled as it is added.
        #[inline(always)]
        fn in_eights<const STRIDE: usize>(index: Ints) -> Ints {
            const { assert!(STRIDE == 8 || STRIDE == 16) };
            if STRIDE == 16 { registers!(I(index) => add_epi32(index, index)) } else { index }
        }
    };
}
pub(super) use transpositions;

/// Loads two pixels from each of two pixel indices.
///
/// # Safety
/// 8 bytes must be readable at both.
#[inline(always)]
pub(super) unsafe fn two_pairs(from: &[u8], [first, second]: [usize; 2]) -> __m128 {
    // SAFETY: as promised by the caller; SSE2 is part of every x86-64, and these loads need no
    // alignment.
    unsafe {
        let (first, second) = (from.as_ptr().add(first * 4), from.as_ptr().add(second * 4));
        _mm_castsi128_ps(_mm_unpacklo_epi64(_mm_loadl_epi64(first.cast()), _mm_loadl_epi64(second.cast())))
    }
}

/// Loads the 16 bytes that begin 8 * `at` bytes after `from`.
///
/// # Safety
/// 16 bytes must be readable there.
#[inline(always)]
unsafe fn record(from: *const u8, at: usize) -> __m128 {
    // SAFETY: as promised by the caller; SSE is part of every x86-64, and the load needs no
    // alignment.
    unsafe { _mm_loadu_ps(from.add(at * 8).cast()) }
}

/// Loads the records at two pairs of places, in units of eight bytes: those of the first of each,
/// and of the second.
///
/// # Safety
/// The CPU must have AVX2, and 16 bytes must be readable at each of those places.
#[inline(always)]
pub(super) unsafe fn rows_of_two(from: *const u8, low: [usize; 2], high: [usize; 2]) -> [__m256; 2] {
    // SAFETY: as promised by the caller.
    unsafe {
        let a = _mm256_castps128_ps256(record(from, low[0]));
        let b = _mm256_castps128_ps256(record(from, low[1]));
        [
            _mm256_insertf128_ps::<1>(a, record(from, high[0])),
            _mm256_insertf128_ps::<1>(b, record(from, high[1])),
        ]
    }
}

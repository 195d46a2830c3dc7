//! Helpers of both kinds of x86 vectors: operators of one intrinsic each, and loads of half an AVX2
//! vector.

use std::arch::x86_64::*;

/// Implements an operator of a vector type by one intrinsic.
macro_rules! binary {
    ($($type:ident $op:ident $method:ident $intrinsic:ident;)+) => {$(
        impl $op for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: holding a vector proves the features.
                unsafe { $type($intrinsic(self.0, other.0)) }
            }
        }
    )+};
}
pub(super) use binary;

/// Calls one intrinsic on self and up to one other vector.
macro_rules! op {
    ($self:ident => $wrap:ident, $intrinsic:ident $(::<$c:tt>)? ($($arg:expr),*)) => {
        // SAFETY: holding a vector proves the features.
        unsafe { $wrap($intrinsic $(::<$c>)? ($self.0 $(, $arg)*)) }
    };
}
pub(super) use op;

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

/// Loads the 16-byte record STRIDE * `at` bytes from `from` on.
///
/// # Safety
/// 16 bytes must be readable there.
#[inline(always)]
unsafe fn record<const STRIDE: usize>(from: *const u8, at: usize) -> __m128 {
    // SAFETY: as promised by the caller; SSE is part of every x86-64, and the load needs no
    // alignment.
    unsafe { _mm_loadu_ps(from.add(at * STRIDE).cast()) }
}

/// Loads the records at two pairs of indices: those of the first of each, and of the second.
///
/// # Safety
/// The CPU must have AVX2, and 16 bytes must be readable at each of those places.
#[inline(always)]
pub(super) unsafe fn rows_of_two<const STRIDE: usize>(
    from: *const u8,
    low: [usize; 2],
    high: [usize; 2],
) -> [__m256; 2] {
    // SAFETY: as promised by the caller.
    unsafe {
        let a = _mm256_castps128_ps256(record::<STRIDE>(from, low[0]));
        let b = _mm256_castps128_ps256(record::<STRIDE>(from, low[1]));
        [
            _mm256_insertf128_ps::<1>(a, record::<STRIDE>(from, high[0])),
            _mm256_insertf128_ps::<1>(b, record::<STRIDE>(from, high[1])),
        ]
    }
}

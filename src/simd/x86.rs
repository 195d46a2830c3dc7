//! Common part of both x86 widths, written once: a width names its instructions (`instructions.rs`)
//! and adds what the other does in another way.
//!
//! In: vectors and tokens of a level, slices. Out: vectors, stored numbers. Promise: the bits of
//! `portable.rs`. Safety: the contract of [`Evidence`] is that of every intrinsic here and in the
//! widths; a block that reads or writes memory says besides why its bytes are there.
//!
//! Names without a path in the macros are those of the width that calls them.

use std::arch::x86_64::*;

/// Value that exists only where its level's instructions may be executed.
///
/// # Safety
/// A type may implement this only if its values are made nowhere but below the level's `run`, from
/// the token that `run` creates or from other evidence, and if a caller of `run` makes sure that
/// the CPU has every feature of the level. Whoever holds a value may then execute them.
pub(super) unsafe trait Evidence: Copy {}

/// Lets the compiler check that a value is evidence.
#[inline(always)]
pub(super) fn assert_evidence(_: impl Evidence) {}

/// Evaluates intrinsics that work on registers alone; a value of the level is the evidence.
macro_rules! registers {
    ($evidence:expr => $body:expr) => {{
        crate::simd::x86::assert_evidence($evidence);
        // SAFETY: the contract of `Evidence`; no memory is accessed.
        unsafe { $body }
    }};
}
pub(super) use registers;

/// Implements an operator of a vector type by one intrinsic.
macro_rules! binary {
    ($($type:ident $op:ident $method:ident $intrinsic:ident;)+) => {$(
        impl $op for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                registers!(self => $type($intrinsic(self.0, other.0)))
            }
        }
    )+};
}
pub(super) use binary;

/// Declares the vectors of a width and their arithmetic.
macro_rules! vectors {
    () => {
        /// Lanes of f32.
        #[derive(Clone, Copy, Debug)]
        pub struct F(pub(super) Floats);

        /// Lanes of i32.
        #[derive(Clone, Copy, Debug)]
        pub struct I(pub(super) Ints);

        /// Boolean lanes.
        #[derive(Clone, Copy, Debug)]
        pub struct M(pub(super) Bools);

        // SAFETY: only methods of the token and of these vectors make one.
        unsafe impl Evidence for F {}
        // SAFETY: only methods of the token and of these vectors make one.
        unsafe impl Evidence for I {}
        // SAFETY: only methods of the token and of these vectors make one.
        unsafe impl Evidence for M {}

        binary! {
            F Add add add_ps;
            F Sub sub sub_ps;
            F Mul mul mul_ps;
            F Div div div_ps;
            I Add add add_epi32;
            I Sub sub sub_epi32;
            I Mul mul mullo_epi32;
            I BitAnd bitand and_si;
            I BitOr bitor or_si;
            I BitXor bitxor xor_si;
        }

        impl Neg for F {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                registers!(self => F(xor_ps(self.0, set1_ps(-0.0))))
            }
        }
    };
}
pub(super) use vectors;

/// Methods of `F32` that are one instruction in both widths.
macro_rules! float_methods {
    () => {
        #[inline(always)]
        fn sqrt(self) -> Self {
            registers!(self => F(sqrt_ps(self.0)))
        }
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            registers!(self => F(min_ps(self.0, other.0)))
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            registers!(self => F(max_ps(self.0, other.0)))
        }
        #[inline(always)]
        fn to_i32(self) -> I {
            registers!(self => I(cvttps_epi32(self.0)))
        }
        #[inline(always)]
        fn bits(self) -> I {
            registers!(self => I(castps_si(self.0)))
        }
    };
}
pub(super) use float_methods;

/// Methods of `I32` that are one instruction in both widths.
macro_rules! int_methods {
    () => {
        #[inline(always)]
        fn min(self, other: Self) -> Self {
            registers!(self => I(min_epi32(self.0, other.0)))
        }
        #[inline(always)]
        fn max(self, other: Self) -> Self {
            registers!(self => I(max_epi32(self.0, other.0)))
        }
        #[inline(always)]
        fn eq(self, other: Self) -> M {
            registers!(self => M(cmpeq_epi32(self.0, other.0)))
        }
        #[inline(always)]
        fn gt(self, other: Self) -> M {
            registers!(self => M(cmpgt_epi32(self.0, other.0)))
        }
        #[inline(always)]
        fn to_f32(self) -> F {
            registers!(self => F(cvtepi32_ps(self.0)))
        }
        #[inline(always)]
        fn as_f32(self) -> F {
            registers!(self => F(castsi_ps(self.0)))
        }
    };
}
pub(super) use int_methods;

/// Methods of `Simd` that make, load and store whole vectors.
macro_rules! whole_vector_methods {
    () => {
        #[inline(always)]
        fn splat(self, v: f32) -> F {
            registers!(self => F(set1_ps(v)))
        }
        #[inline(always)]
        fn splat_i(self, v: i32) -> I {
            registers!(self => I(set1_epi32(v)))
        }
        #[inline(always)]
        fn load(self, from: &[f32]) -> F {
            let from = &from[..Self::LANES];
            // SAFETY: the contract of `Evidence`; the slice holds a vector's numbers.
            unsafe { F(loadu_ps(from.as_ptr())) }
        }
        #[inline(always)]
        fn load_i(self, from: &[i32]) -> I {
            let from = &from[..Self::LANES];
            // SAFETY: the contract of `Evidence`; the slice holds a vector's numbers.
            unsafe { I(loadu_si(from.as_ptr().cast())) }
        }
        #[inline(always)]
        fn store(self, v: F, to: &mut [f32]) {
            let to = &mut to[..Self::LANES];
            // SAFETY: the contract of `Evidence`; the target holds a vector's elements.
            unsafe { storeu_ps(to.as_mut_ptr(), v.0) }
        }
        #[inline(always)]
        fn store_i(self, v: I, to: &mut [i32]) {
            let to = &mut to[..Self::LANES];
            // SAFETY: the contract of `Evidence`; the target holds a vector's elements.
            unsafe { storeu_si(to.as_mut_ptr().cast(), v.0) }
        }
        #[inline(always)]
        fn load_bytes(self, from: &[u8]) -> I {
            let from = &from[..4 * Self::LANES];
            // SAFETY: the contract of `Evidence`; the slice holds a vector's bytes, and x86 is
            // little-endian.
            unsafe { I(loadu_si(from.as_ptr().cast())) }
        }
    };
}
pub(super) use whole_vector_methods;

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

        /// Transposes four fields into rows of records: row r holds in its q-th 16 bytes the four
        /// numbers of lane 4 q + r.
        #[inline(always)]
        pub(super) fn rows_of_four([a, b, c, d]: [I; 4]) -> [Ints; 4] {
            registers!(a => {
                let (ab, cd) = (unpacklo_epi32(a.0, b.0), unpacklo_epi32(c.0, d.0));
                let (ef, gh) = (unpackhi_epi32(a.0, b.0), unpackhi_epi32(c.0, d.0));
                [
                    unpacklo_epi64(ab, cd),
                    unpackhi_epi64(ab, cd),
                    unpacklo_epi64(ef, gh),
                    unpackhi_epi64(ef, gh),
                ]
            })
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

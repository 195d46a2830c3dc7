//! Common part of the x86 widths, written once: a width names its instructions (`instructions.rs`)
//! and adds what the others do in another way.
//!
//! In: vectors and tokens of a level, slices. Out: vectors, stored numbers. Promise: the bits of
//! `portable.rs`. Safety: the contract of [`Evidence`] is that of every intrinsic here and in the
//! widths; a block that reads or writes memory says besides why its bytes are there.
//!
//! Names without a path in the macros are those of the width that calls them.

/// Value that exists only where its level's instructions may be executed.
///
/// # Safety
/// A type may implement this only if its values are made nowhere but below the level's `run`, from
/// the token that `run` creates or from other evidence, and if a caller of `run` makes sure that
/// the CPU has every feature of the level; or if every CPU of the target has them. Whoever holds a
/// value may then execute them.
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

        // SAFETY: it is made from evidence alone, or in a level that every CPU of the target has.
        unsafe impl Evidence for F {}
        // SAFETY: it is made from evidence alone, or in a level that every CPU of the target has.
        unsafe impl Evidence for I {}
        // SAFETY: it is made from evidence alone, or in a level that every CPU of the target has.
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

/// Implements the operators of masks whose lanes are numbers, all ones for true.
macro_rules! masks_of_lanes {
    () => {
        binary! {
            M BitAnd bitand and_si;
            M BitOr bitor or_si;
        }

        impl Not for M {
            type Output = Self;
            #[inline(always)]
            fn not(self) -> Self {
                registers!(self => M(xor_si(self.0, set1_epi32(-1))))
            }
        }
    };
}
pub(super) use masks_of_lanes;

/// Methods of `F32` that are one instruction in each width.
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

/// Methods of `I32` that are one instruction in most widths.
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
        // The counts are in a register: the constant forms of most widths take an i32.
        #[inline(always)]
        fn shl<const N: u32>(self) -> Self {
            registers!(self => I(sll_epi32(self.0, _mm_cvtsi32_si128(N as i32))))
        }
        #[inline(always)]
        fn sar<const N: u32>(self) -> Self {
            registers!(self => I(sra_epi32(self.0, _mm_cvtsi32_si128(N as i32))))
        }
        #[inline(always)]
        fn shr<const N: u32>(self) -> Self {
            registers!(self => I(srl_epi32(self.0, _mm_cvtsi32_si128(N as i32))))
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

/// The transposition between fields and records, within each 16 bytes of a vector.
macro_rules! rows_of_four {
    () => {
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
pub(super) use rows_of_four;

//! Vectors of 16 lanes of f32, i32 and booleans, and their operators.

use super::Avx512;
use crate::simd::x86::{binary, op};
use crate::simd::{F32, I32, Mask};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// 16 lanes of f32.
#[derive(Clone, Copy, Debug)]
pub struct F(pub(super) __m512);

/// 16 lanes of i32.
#[derive(Clone, Copy, Debug)]
pub struct I(pub(super) __m512i);

/// 16 boolean lanes in a mask register.
#[derive(Clone, Copy, Debug)]
pub struct M(pub(super) __mmask16);

// SAFETY (for every block of this file): a vector or token of this module exists only below `run`,
// whose caller has made sure of the CPU's features; loads and stores go through slices whose length
// was checked just before.
binary! {
    F Add add _mm512_add_ps;
    F Sub sub _mm512_sub_ps;
    F Mul mul _mm512_mul_ps;
    F Div div _mm512_div_ps;
    I Add add _mm512_add_epi32;
    I Sub sub _mm512_sub_epi32;
    I Mul mul _mm512_mullo_epi32;
    I BitAnd bitand _mm512_and_si512;
    I BitOr bitor _mm512_or_si512;
    I BitXor bitxor _mm512_xor_si512;
}

impl Neg for F {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: holding a vector proves the features.
        unsafe { F(_mm512_xor_ps(self.0, _mm512_set1_ps(-0.0))) }
    }
}

impl BitAnd for M {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        M(self.0 & other.0)
    }
}

impl BitOr for M {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        M(self.0 | other.0)
    }
}

impl Not for M {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        M(!self.0)
    }
}

impl Mask for M {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0 as u32
    }
}

impl F32<Avx512> for F {
    #[inline(always)]
    fn sqrt(self) -> Self {
        op!(self => F, _mm512_sqrt_ps())
    }
    #[inline(always)]
    fn floor(self) -> Self {
        op!(self => F, _mm512_roundscale_ps::<{ _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC }>())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        op!(self => F, _mm512_abs_ps())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        op!(self => F, _mm512_min_ps(other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        op!(self => F, _mm512_max_ps(other.0))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M {
        op!(self => M, _mm512_cmp_ps_mask::<_CMP_LT_OQ>(other.0))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M {
        op!(self => M, _mm512_cmp_ps_mask::<_CMP_LE_OQ>(other.0))
    }
    #[inline(always)]
    fn to_i32(self) -> I {
        op!(self => I, _mm512_cvttps_epi32())
    }
    #[inline(always)]
    fn bits(self) -> I {
        op!(self => I, _mm512_castps_si512())
    }
}

impl I32<Avx512> for I {
    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        op!(self => I, _mm512_slli_epi32::<N>())
    }
    #[inline(always)]
    fn sar<const N: u32>(self) -> Self {
        op!(self => I, _mm512_srai_epi32::<N>())
    }
    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        op!(self => I, _mm512_srli_epi32::<N>())
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        op!(self => I, _mm512_min_epi32(other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        op!(self => I, _mm512_max_epi32(other.0))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> M {
        op!(self => M, _mm512_cmpeq_epi32_mask(other.0))
    }
    #[inline(always)]
    fn gt(self, other: Self) -> M {
        op!(self => M, _mm512_cmpgt_epi32_mask(other.0))
    }
    #[inline(always)]
    fn reduce_min(self) -> i32 {
        // SAFETY: holding a vector proves the features.
        unsafe { _mm512_reduce_min_epi32(self.0) }
    }
    #[inline(always)]
    fn reduce_max(self) -> i32 {
        // SAFETY: holding a vector proves the features.
        unsafe { _mm512_reduce_max_epi32(self.0) }
    }
    #[inline(always)]
    fn to_f32(self) -> F {
        op!(self => F, _mm512_cvtepi32_ps())
    }
    #[inline(always)]
    fn as_f32(self) -> F {
        op!(self => F, _mm512_castsi512_ps())
    }
}

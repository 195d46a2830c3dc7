//! Vectors of 8 lanes of f32, i32 and booleans, and their operators.

use super::Avx2;
use crate::simd::x86::{binary, op};
use crate::simd::{F32, I32, Mask};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// 8 lanes of f32.
#[derive(Clone, Copy, Debug)]
pub struct F(pub(super) __m256);

/// 8 lanes of i32.
#[derive(Clone, Copy, Debug)]
pub struct I(pub(super) __m256i);

/// 8 boolean lanes: all ones for true, zero for false.
#[derive(Clone, Copy, Debug)]
pub struct M(pub(super) __m256i);

// SAFETY (for every block of this file): a vector or token of this module exists only below `run`,
// whose caller has made sure of the CPU's features; loads and stores go through slices whose length
// was checked just before.
binary! {
    F Add add _mm256_add_ps;
    F Sub sub _mm256_sub_ps;
    F Mul mul _mm256_mul_ps;
    F Div div _mm256_div_ps;
    I Add add _mm256_add_epi32;
    I Sub sub _mm256_sub_epi32;
    I Mul mul _mm256_mullo_epi32;
    I BitAnd bitand _mm256_and_si256;
    I BitOr bitor _mm256_or_si256;
    I BitXor bitxor _mm256_xor_si256;
}

impl Neg for F {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        // SAFETY: holding a vector proves the features.
        unsafe { F(_mm256_xor_ps(self.0, _mm256_set1_ps(-0.0))) }
    }
}

impl BitAnd for M {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        // SAFETY: holding a vector proves the features.
        unsafe { M(_mm256_and_si256(self.0, other.0)) }
    }
}

impl BitOr for M {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        // SAFETY: holding a vector proves the features.
        unsafe { M(_mm256_or_si256(self.0, other.0)) }
    }
}

impl Not for M {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        // SAFETY: holding a vector proves the features.
        unsafe { M(_mm256_xor_si256(self.0, _mm256_set1_epi32(-1))) }
    }
}

impl Mask for M {
    #[inline(always)]
    fn bits(self) -> u32 {
        // SAFETY: holding a vector proves the features.
        unsafe { _mm256_movemask_ps(_mm256_castsi256_ps(self.0)) as u32 }
    }
}

impl F32<Avx2> for F {
    #[inline(always)]
    fn sqrt(self) -> Self {
        op!(self => F, _mm256_sqrt_ps())
    }
    #[inline(always)]
    fn floor(self) -> Self {
        op!(self => F, _mm256_floor_ps())
    }
    #[inline(always)]
    fn abs(self) -> Self {
        // SAFETY: holding a vector proves the features.
        unsafe { F(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)) }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        op!(self => F, _mm256_min_ps(other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        op!(self => F, _mm256_max_ps(other.0))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M {
        // SAFETY: holding a vector proves the features.
        unsafe { M(_mm256_castps_si256(_mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0))) }
    }
    #[inline(always)]
    fn le(self, other: Self) -> M {
        // SAFETY: holding a vector proves the features.
        unsafe { M(_mm256_castps_si256(_mm256_cmp_ps::<_CMP_LE_OQ>(self.0, other.0))) }
    }
    #[inline(always)]
    fn to_i32(self) -> I {
        op!(self => I, _mm256_cvttps_epi32())
    }
    #[inline(always)]
    fn bits(self) -> I {
        op!(self => I, _mm256_castps_si256())
    }
}

impl I32<Avx2> for I {
    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        // SAFETY: holding a vector proves the features. The count is in a register: its constant
        // form takes an i32.
        unsafe { I(_mm256_sll_epi32(self.0, _mm_cvtsi32_si128(N as i32))) }
    }
    #[inline(always)]
    fn sar<const N: u32>(self) -> Self {
        // SAFETY: holding a vector proves the features. The count is in a register: its constant
        // form takes an i32.
        unsafe { I(_mm256_sra_epi32(self.0, _mm_cvtsi32_si128(N as i32))) }
    }
    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        // SAFETY: holding a vector proves the features. The count is in a register: its constant
        // form takes an i32.
        unsafe { I(_mm256_srl_epi32(self.0, _mm_cvtsi32_si128(N as i32))) }
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        op!(self => I, _mm256_min_epi32(other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        op!(self => I, _mm256_max_epi32(other.0))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> M {
        op!(self => M, _mm256_cmpeq_epi32(other.0))
    }
    #[inline(always)]
    fn gt(self, other: Self) -> M {
        op!(self => M, _mm256_cmpgt_epi32(other.0))
    }
    #[inline(always)]
    fn reduce_min(self) -> i32 {
        // SAFETY: holding a vector proves the features.
        unsafe {
            let v = _mm_min_epi32(_mm256_castsi256_si128(self.0), _mm256_extracti128_si256::<1>(self.0));
            let v = _mm_min_epi32(v, _mm_shuffle_epi32::<0b01_00_11_10>(v));
            _mm_cvtsi128_si32(_mm_min_epi32(v, _mm_shuffle_epi32::<0b10_11_00_01>(v)))
        }
    }
    #[inline(always)]
    fn reduce_max(self) -> i32 {
        // SAFETY: holding a vector proves the features.
        unsafe {
            let v = _mm_max_epi32(_mm256_castsi256_si128(self.0), _mm256_extracti128_si256::<1>(self.0));
            let v = _mm_max_epi32(v, _mm_shuffle_epi32::<0b01_00_11_10>(v));
            _mm_cvtsi128_si32(_mm_max_epi32(v, _mm_shuffle_epi32::<0b10_11_00_01>(v)))
        }
    }
    #[inline(always)]
    fn to_f32(self) -> F {
        op!(self => F, _mm256_cvtepi32_ps())
    }
    #[inline(always)]
    fn as_f32(self) -> F {
        op!(self => F, _mm256_castsi256_ps())
    }
}

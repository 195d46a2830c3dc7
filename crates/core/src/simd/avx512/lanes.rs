//! Vectors of 16 lanes of f32, i32 and booleans (in a mask register), and their operators.

use super::Avx512;
use super::instructions::*;
use crate::simd::x86::{Evidence, binary, float_methods, int_methods, registers, vectors};
use crate::simd::{F32, I32, Mask};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

vectors!();

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
    float_methods!();

    #[inline(always)]
    fn floor(self) -> Self {
        const DOWN: i32 = _MM_FROUND_TO_NEG_INF | _MM_FROUND_NO_EXC;
        registers!(self => F(_mm512_roundscale_ps::<DOWN>(self.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        registers!(self => F(_mm512_abs_ps(self.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M {
        registers!(self => M(_mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M {
        registers!(self => M(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(self.0, other.0)))
    }
}

impl I32<Avx512> for I {
    int_methods!();

    #[inline(always)]
    fn reduce_min(self) -> i32 {
        registers!(self => _mm512_reduce_min_epi32(self.0))
    }
    #[inline(always)]
    fn reduce_max(self) -> i32 {
        registers!(self => _mm512_reduce_max_epi32(self.0))
    }
}

//! Vectors of 8 lanes of f32, i32 and booleans (all ones for true, zero for false), and their
//! operators.

use super::Avx2;
use super::instructions::*;
use crate::simd::x86::{Evidence, binary, float_methods, int_methods, masks_of_lanes, registers, vectors};
use crate::simd::{F32, I32, Mask};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

vectors!();

masks_of_lanes!();

impl Mask for M {
    #[inline(always)]
    fn bits(self) -> u32 {
        registers!(self => _mm256_movemask_ps(castsi_ps(self.0)) as u32)
    }
}

impl F32<Avx2> for F {
    float_methods!();

    #[inline(always)]
    fn floor(self) -> Self {
        registers!(self => F(_mm256_floor_ps(self.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        registers!(self => F(_mm256_andnot_ps(set1_ps(-0.0), self.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M {
        registers!(self => M(cmp_ps::<_CMP_LT_OQ>(self.0, other.0)))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M {
        registers!(self => M(cmp_ps::<_CMP_LE_OQ>(self.0, other.0)))
    }
}

impl I32<Avx2> for I {
    int_methods!();

    #[inline(always)]
    fn reduce_min(self) -> i32 {
        registers!(self => {
            let v = _mm_min_epi32(_mm256_castsi256_si128(self.0), _mm256_extracti128_si256::<1>(self.0));
            let v = _mm_min_epi32(v, _mm_shuffle_epi32::<0b01_00_11_10>(v));
            _mm_cvtsi128_si32(_mm_min_epi32(v, _mm_shuffle_epi32::<0b10_11_00_01>(v)))
        })
    }
    #[inline(always)]
    fn reduce_max(self) -> i32 {
        registers!(self => {
            let v = _mm_max_epi32(_mm256_castsi256_si128(self.0), _mm256_extracti128_si256::<1>(self.0));
            let v = _mm_max_epi32(v, _mm_shuffle_epi32::<0b01_00_11_10>(v));
            _mm_cvtsi128_si32(_mm_max_epi32(v, _mm_shuffle_epi32::<0b10_11_00_01>(v)))
        })
    }
}

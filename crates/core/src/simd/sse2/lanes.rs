//! Vectors of 4 lanes of f32, i32 and booleans (all ones for true, zero for false), and their
//! operators.

use super::Sse2;
use super::instructions::*;
use super::records::unsigned_lanes;
use crate::simd::x86::{Evidence, binary, float_methods, int_methods, masks_of_lanes, registers, vectors};
use crate::simd::{F32, I32, Mask};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

vectors!();

masks_of_lanes!();

impl Mask for M {
    #[inline(always)]
    fn bits(self) -> u32 {
        registers!(self => _mm_movemask_ps(castsi_ps(self.0)) as u32)
    }
}

impl F32<Sse2> for F {
    float_methods!();

    #[inline(always)]
    fn floor(self) -> Self {
        registers!(self => F(floor_ps(self.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        registers!(self => F(abs_ps(self.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M {
        registers!(self => M(castps_si(_mm_cmplt_ps(self.0, other.0))))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M {
        registers!(self => M(castps_si(_mm_cmple_ps(self.0, other.0))))
    }
}

impl I32<Sse2> for I {
    int_methods!();

    #[inline(always)]
    fn reduce_min(self) -> i32 {
        let [a, b, c, d] = unsigned_lanes(self).map(|lane| lane as i32);
        a.min(b).min(c.min(d))
    }
    #[inline(always)]
    fn reduce_max(self) -> i32 {
        let [a, b, c, d] = unsigned_lanes(self).map(|lane| lane as i32);
        a.max(b).max(c.max(d))
    }
}

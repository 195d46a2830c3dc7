//! Vectors of 4 lanes of f32, i32 and booleans (all ones for true, zero for false), and their
//! operators.

use super::Neon;
use crate::simd::{F32, I32, Mask};
use std::arch::aarch64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// Lanes of f32.
#[derive(Clone, Copy, Debug)]
pub struct F(pub(super) float32x4_t);

/// Lanes of i32.
#[derive(Clone, Copy, Debug)]
pub struct I(pub(super) int32x4_t);

/// Boolean lanes.
#[derive(Clone, Copy, Debug)]
pub struct M(pub(super) uint32x4_t);

/// Implements an operator of a vector type by one intrinsic.
macro_rules! binary {
    ($($type:ident $op:ident $method:ident $intrinsic:ident;)+) => {$(
        impl $op for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                registers!($type($intrinsic(self.0, other.0)))
            }
        }
    )+};
}

binary! {
    F Add add vaddq_f32;
    F Sub sub vsubq_f32;
    F Mul mul vmulq_f32;
    F Div div vdivq_f32;
    I Add add vaddq_s32;
    I Sub sub vsubq_s32;
    I Mul mul vmulq_s32;
    I BitAnd bitand vandq_s32;
    I BitOr bitor vorrq_s32;
    I BitXor bitxor veorq_s32;
    M BitAnd bitand vandq_u32;
    M BitOr bitor vorrq_u32;
}

impl Neg for F {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        registers!(F(vnegq_f32(self.0)))
    }
}

impl Not for M {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        registers!(M(vmvnq_u32(self.0)))
    }
}

/// Weights of the lanes in a mask's bits.
const LANE_BITS: [u32; 4] = [1, 2, 4, 8];

/// Returns [`LANE_BITS`] as a vector.
#[inline(always)]
pub(super) fn lane_bits() -> uint32x4_t {
    // SAFETY: NEON is part of the target; the array holds four numbers.
    unsafe { vld1q_u32(LANE_BITS.as_ptr()) }
}

impl Mask for M {
    #[inline(always)]
    fn bits(self) -> u32 {
        registers!(vaddvq_u32(vandq_u32(self.0, lane_bits())))
    }
    #[inline(always)]
    fn any(self) -> bool {
        registers!(vmaxvq_u32(self.0) != 0)
    }
}

impl F32<Neon> for F {
    #[inline(always)]
    fn sqrt(self) -> Self {
        registers!(F(vsqrtq_f32(self.0)))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        registers!(F(vrndmq_f32(self.0)))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        registers!(F(vabsq_f32(self.0)))
    }
    // The instructions FMIN and FMAX order the zeros and propagate NaN: a comparison does neither.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        registers!(F(vbslq_f32(vcltq_f32(self.0, other.0), self.0, other.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        registers!(F(vbslq_f32(vcgtq_f32(self.0, other.0), self.0, other.0)))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M {
        registers!(M(vcltq_f32(self.0, other.0)))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M {
        registers!(M(vcleq_f32(self.0, other.0)))
    }
    #[inline(always)]
    fn to_i32(self) -> I {
        // The conversion saturates, which is right below the range; above it, and for NaN, the
        // result is that of x86.
        registers!({
            let fits = vcltq_f32(self.0, vdupq_n_f32(2_147_483_648.0));
            I(vbslq_s32(fits, vcvtq_s32_f32(self.0), vdupq_n_s32(i32::MIN)))
        })
    }
    #[inline(always)]
    fn bits(self) -> I {
        registers!(I(vreinterpretq_s32_f32(self.0)))
    }
}

// The counts of shifts are in a register: the constant forms take an i32. Negative counts shift
// right.
impl I32<Neon> for I {
    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        registers!(I(vshlq_s32(self.0, vdupq_n_s32(N as i32))))
    }
    #[inline(always)]
    fn sar<const N: u32>(self) -> Self {
        registers!(I(vshlq_s32(self.0, vdupq_n_s32(-(N as i32)))))
    }
    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        registers!({
            let unsigned = vreinterpretq_u32_s32(self.0);
            I(vreinterpretq_s32_u32(vshlq_u32(unsigned, vdupq_n_s32(-(N as i32)))))
        })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        registers!(I(vminq_s32(self.0, other.0)))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        registers!(I(vmaxq_s32(self.0, other.0)))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> M {
        registers!(M(vceqq_s32(self.0, other.0)))
    }
    #[inline(always)]
    fn gt(self, other: Self) -> M {
        registers!(M(vcgtq_s32(self.0, other.0)))
    }
    #[inline(always)]
    fn reduce_min(self) -> i32 {
        registers!(vminvq_s32(self.0))
    }
    #[inline(always)]
    fn reduce_max(self) -> i32 {
        registers!(vmaxvq_s32(self.0))
    }
    #[inline(always)]
    fn to_f32(self) -> F {
        registers!(F(vcvtq_f32_s32(self.0)))
    }
    #[inline(always)]
    fn as_f32(self) -> F {
        registers!(F(vreinterpretq_f32_s32(self.0)))
    }
}

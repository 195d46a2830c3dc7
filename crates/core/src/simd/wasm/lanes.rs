//! Vectors of 4 lanes of f32, i32 and booleans (all ones for true, zero for false), and their
//! operators.

use super::Simd128;
use crate::simd::{F32, I32, Mask};
use std::arch::wasm32::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// Lanes of f32.
#[derive(Clone, Copy, Debug)]
pub struct F(pub(super) v128);

/// Lanes of i32.
#[derive(Clone, Copy, Debug)]
pub struct I(pub(super) v128);

/// Boolean lanes.
#[derive(Clone, Copy, Debug)]
pub struct M(pub(super) v128);

/// Implements an operator of a vector type by one instruction.
macro_rules! binary {
    ($($type:ident $op:ident $method:ident $instruction:ident;)+) => {$(
        impl $op for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                $type($instruction(self.0, other.0))
            }
        }
    )+};
}

binary! {
    F Add add f32x4_add;
    F Sub sub f32x4_sub;
    F Mul mul f32x4_mul;
    F Div div f32x4_div;
    I Add add i32x4_add;
    I Sub sub i32x4_sub;
    I Mul mul i32x4_mul;
    I BitAnd bitand v128_and;
    I BitOr bitor v128_or;
    I BitXor bitxor v128_xor;
    M BitAnd bitand v128_and;
    M BitOr bitor v128_or;
}

impl Neg for F {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        F(f32x4_neg(self.0))
    }
}

impl Not for M {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        M(v128_not(self.0))
    }
}

impl Mask for M {
    #[inline(always)]
    fn bits(self) -> u32 {
        i32x4_bitmask(self.0).into()
    }
    #[inline(always)]
    fn any(self) -> bool {
        v128_any_true(self.0)
    }
}

impl F32<Simd128> for F {
    #[inline(always)]
    fn sqrt(self) -> Self {
        F(f32x4_sqrt(self.0))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        F(f32x4_floor(self.0))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        F(f32x4_abs(self.0))
    }
    // pmin(a, b) is b < a ? b : a, pmax(a, b) is a < b ? b : a.
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        F(f32x4_pmin(other.0, self.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        F(f32x4_pmax(other.0, self.0))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> M {
        M(f32x4_lt(self.0, other.0))
    }
    #[inline(always)]
    fn le(self, other: Self) -> M {
        M(f32x4_le(self.0, other.0))
    }
    #[inline(always)]
    fn to_i32(self) -> I {
        // The conversion saturates, which is right below the range; above it, and for NaN, the
        // result is that of x86.
        let fits = f32x4_lt(self.0, f32x4_splat(2_147_483_648.0));
        I(v128_bitselect(i32x4_trunc_sat_f32x4(self.0), i32x4_splat(i32::MIN), fits))
    }
    #[inline(always)]
    fn bits(self) -> I {
        I(self.0)
    }
}

impl I32<Simd128> for I {
    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        I(i32x4_shl(self.0, N))
    }
    #[inline(always)]
    fn sar<const N: u32>(self) -> Self {
        I(i32x4_shr(self.0, N))
    }
    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        I(u32x4_shr(self.0, N))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        I(i32x4_min(self.0, other.0))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        I(i32x4_max(self.0, other.0))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> M {
        M(i32x4_eq(self.0, other.0))
    }
    #[inline(always)]
    fn gt(self, other: Self) -> M {
        M(i32x4_gt(self.0, other.0))
    }
    #[inline(always)]
    fn reduce_min(self) -> i32 {
        let two = i32x4_min(self.0, i32x4_shuffle::<2, 3, 0, 1>(self.0, self.0));
        i32x4_extract_lane::<0>(two).min(i32x4_extract_lane::<1>(two))
    }
    #[inline(always)]
    fn reduce_max(self) -> i32 {
        let two = i32x4_max(self.0, i32x4_shuffle::<2, 3, 0, 1>(self.0, self.0));
        i32x4_extract_lane::<0>(two).max(i32x4_extract_lane::<1>(two))
    }
    #[inline(always)]
    fn to_f32(self) -> F {
        F(f32x4_convert_i32x4(self.0))
    }
    #[inline(always)]
    fn as_f32(self) -> F {
        F(self.0)
    }
}

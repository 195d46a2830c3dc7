//! Vectors of 16, 8 or 4 lanes: the only room with `unsafe`, and the only one with intrinsics.
//!
//! A kernel is written once, over the trait [`Simd`], and run at a [`Level`] chosen once at start by what the CPU has:
//! AVX-512 (16 lanes), AVX2 (8 lanes), or portable arrays (4 lanes), which are the scalar truth of the other two.
//! Every operation is exact or correctly rounded, in a fixed order, without FMA and without approximate reciprocals,
//! so a kernel that treats its lanes alike gives the same bytes at every level.
//!
//! SAFETY: a token of a level (and with it any vector of that level) comes into being only inside
//! [`Level::dispatch`], after the CPU was asked. Holding one is the proof that its instructions exist.
#![allow(unsafe_code)]

pub mod allocator;
#[cfg(target_arch = "x86_64")]
mod avx2;
#[cfg(target_arch = "x86_64")]
mod avx512;
pub mod binary_pixels;
mod fill;
mod level;
pub mod pixel_lexer;
mod portable;
pub mod prefetch;
mod scanout;
#[cfg(target_arch = "x86_64")]
mod spill;
#[cfg(test)]
mod tests;
#[cfg(target_arch = "x86_64")]
mod x86;

pub use fill::fill_pixels;
pub use level::{Kernel, Level};
pub use portable::Portable;
pub use scanout::{scan_out, word};

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// N lanes of f32. Operators are IEEE single precision, lane by lane.
pub trait F32<S: Simd>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Correctly rounded square root.
    fn sqrt(self) -> Self;
    /// Largest whole number not above, for every f32.
    fn floor(self) -> Self;
    /// Without the sign bit.
    fn abs(self) -> Self;
    /// `if self < other { self } else { other }`: a NaN gives `other`.
    fn min(self, other: Self) -> Self;
    /// `if self > other { self } else { other }`: a NaN gives `other`.
    fn max(self, other: Self) -> Self;
    /// self < other; false for NaN.
    fn lt(self, other: Self) -> S::M;
    /// self <= other; false for NaN.
    fn le(self, other: Self) -> S::M;
    /// Towards zero; `i32::MIN` for what does not fit and for NaN.
    fn to_i32(self) -> S::I;
    /// The bits.
    fn bits(self) -> S::I;
}

/// N lanes of i32. Arithmetic wraps.
pub trait I32<S: Simd>:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + BitAnd<Output = Self>
    + BitOr<Output = Self>
    + BitXor<Output = Self>
{
    /// Shifted left by N bits (0..=31), zeros come in.
    fn shl<const N: u32>(self) -> Self;
    /// Shifted right by N bits (0..=31), the sign comes in.
    fn sar<const N: u32>(self) -> Self;
    /// Shifted right by N bits (0..=31), zeros come in.
    fn shr<const N: u32>(self) -> Self;
    /// The smaller, signed.
    fn min(self, other: Self) -> Self;
    /// The larger, signed.
    fn max(self, other: Self) -> Self;
    /// self == other.
    fn eq(self, other: Self) -> S::M;
    /// self > other, signed.
    fn gt(self, other: Self) -> S::M;
    /// The smallest lane, signed.
    fn reduce_min(self) -> i32;
    /// The largest lane, signed.
    fn reduce_max(self) -> i32;
    /// Nearest f32, ties to even.
    fn to_f32(self) -> S::F;
    /// The f32 with these bits.
    fn as_f32(self) -> S::F;
}

/// N lanes of yes or no.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Bit i is lane i.
    fn bits(self) -> u32;
    /// Whether any lane is set.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
}

/// A level's token: makes vectors, loads and stores them.
///
/// Slices are checked: one that is too short panics, as indexing does.
pub trait Simd: Copy + 'static {
    /// Lanes of a vector.
    const LANES: usize;
    /// Lanes of f32.
    type F: F32<Self>;
    /// Lanes of i32.
    type I: I32<Self>;
    /// Lanes of yes or no.
    type M: Mask;

    /// The same number in every lane.
    fn splat(self, v: f32) -> Self::F;
    /// The same number in every lane.
    fn splat_i(self, v: i32) -> Self::I;
    /// 0, 1, 2, ...
    fn iota(self) -> Self::I;
    /// The first LANES numbers of `from`.
    fn load(self, from: &[f32]) -> Self::F;
    /// The first LANES numbers of `from`.
    fn load_i(self, from: &[i32]) -> Self::I;
    /// Into the first LANES places of `to`.
    fn store(self, v: Self::F, to: &mut [f32]);
    /// Into the first LANES places of `to`.
    fn store_i(self, v: Self::I, to: &mut [i32]);
    /// Into the first LANES places of `to`, where the mask is set.
    fn store_masked_i(self, mask: Self::M, v: Self::I, to: &mut [i32]);
    /// The first LANES pixels of `from`, four bytes each, the first byte lowest.
    fn load_bytes(self, from: &[u8]) -> Self::I;
    /// Into the first LANES pixels of `to`, four bytes each, the lowest byte first, where the mask is set.
    fn store_masked_bytes(self, mask: Self::M, v: Self::I, to: &mut [u8]);
    /// A block of LANES / 4 rows of four numbers: row r from `from[r * stride..]`, its lanes 4 r to 4 r + 3.
    fn load_block(self, from: &[i32], stride: usize) -> Self::I;
    /// A block of LANES / 4 rows of four pixels, four bytes each, the lowest byte first, where the mask is set: row r
    /// from pixel `r * stride` of `to` on. Rows without a set lane may lie outside of `to`.
    fn store_block_bytes(self, mask: Self::M, v: Self::I, to: &mut [u8], stride: usize);
    /// The lanes that are set, packed to the front of `to` (LANES places; what lies behind them is unspecified); their count.
    fn compress_i(self, mask: Self::M, v: Self::I, to: &mut [i32]) -> usize;
    /// The lanes of `a` and `b` in turn, a's first: the first half of them and the second.
    fn zip(self, a: Self::I, b: Self::I) -> [Self::I; 2];
    /// The lanes that are set as records of eight numbers, packed to the front of `to` (LANES records; those behind them are
    /// zeros): number f of a record is its lane of `fields[f]`. Their count.
    fn compress8(self, mask: Self::M, fields: [Self::I; 8], to: &mut [[i32; 8]]) -> usize;
    /// Of the lanes that are set, those that hold a number which no set lane before them holds.
    fn first_occurrences(self, mask: Self::M, v: Self::I) -> Self::M;
    /// Lane i is bit i.
    fn mask(self, bits: u32) -> Self::M;
    /// `a` where the mask is set, else `b`.
    fn select(self, mask: Self::M, a: Self::F, b: Self::F) -> Self::F;
    /// `a` where the mask is set, else `b`.
    fn select_i(self, mask: Self::M, a: Self::I, b: Self::I) -> Self::I;
    /// `table[index & 7]` in each lane.
    fn lookup(self, table: &[i32; 8], index: Self::I) -> Self::I;
    /// Pixel number `index` of `from` (four bytes each, the first byte lowest) in each lane where the mask is set, 0
    /// elsewhere. Panics when a set lane's pixel is outside.
    fn gather_bytes(self, mask: Self::M, from: &[u8], index: Self::I) -> Self::I;
    /// `from[index]` in each lane where the mask is set, 0 elsewhere. Panics when a set lane's index is outside.
    fn gather(self, mask: Self::M, from: &[f32], index: Self::I) -> Self::F;
    /// The four numbers of `from[index]` in each lane where the mask is set, transposed: component c of lane i is
    /// `result[c]` lane i; unset lanes read record 0. Panics when a set lane's index is outside or `from` is empty.
    fn gather4(self, mask: Self::M, from: &[[f32; 4]], index: Self::I) -> [Self::F; 4];
    /// The records `from[index]` and `from[index + 1]` in each lane where the mask is set, as four words, the first number
    /// of a pair lowest; unset lanes read records 0 and 1. Panics when a set lane's records, or those, are outside.
    fn gather_pairs(self, mask: Self::M, from: &[[u16; 4]], index: Self::I) -> [Self::I; 4];
    /// Pixels number `index` and `index + 1` of `from` (four bytes each, the first byte lowest) in each lane where the mask
    /// is set; unset lanes read pixels 0 and 1. Panics when a set lane's pixels, or those, are outside.
    fn gather_byte_pairs(self, mask: Self::M, from: &[u8], index: Self::I) -> [Self::I; 2];
}

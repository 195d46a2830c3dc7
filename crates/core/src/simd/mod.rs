//! SIMD vectors of 16, 8 or 4 lanes.
//!
//! A kernel is written once, over the trait [`Simd`], and run at a [`Level`] that is chosen once at
//! start from the features of the CPU: AVX-512 (16 lanes) and AVX2 (8 lanes), both with the crate's
//! feature `avx`, NEON (4 lanes), or portable arrays (4 lanes), which are the
//! scalar reference for the others. In their place stand vectors of 4 lanes that every CPU of a
//! target has: SSE2 on x86-64, WebAssembly's where a module is built with them. Every operation is
//! exact or correctly rounded, in a fixed order, without FMA and without approximate reciprocals,
//! so a kernel that treats its lanes alike gives the same bytes at every level.
//!
//! Safety: the token of AVX2 or AVX-512 (and with it any vector of that level) is created only
//! inside [`Level::dispatch`] and `Level::dispatch_long`, after the CPU's features were checked. The
//! trait `Evidence` of `x86.rs` is the contract. SSE2 and NEON are compiled only where every CPU of
//! the target has them; WebAssembly's instructions are safe to call.
#![allow(unsafe_code)]

pub mod allocator;
#[cfg(all(target_arch = "x86_64", any(test, feature = "avx")))]
mod avx2;
#[cfg(all(target_arch = "x86_64", any(test, feature = "avx")))]
mod avx512;
#[cfg(all(target_arch = "x86_64", any(test, feature = "avx")))]
mod avx_records;
#[cfg(all(target_arch = "x86_64", any(test, feature = "avx")))]
pub mod bytes;
mod crt;
mod fill;
#[cfg(any(
    target_arch = "x86_64",
    all(target_arch = "aarch64", target_feature = "neon", target_endian = "little"),
    all(target_arch = "wasm32", target_feature = "simd128")
))]
mod four_lanes;
mod level;
#[cfg(all(target_arch = "aarch64", target_feature = "neon", target_endian = "little"))]
mod neon;
#[cfg(any(test, all(target_arch = "x86_64", feature = "avx")))]
mod pair;
mod pixels;
mod portable;
pub mod prefetch;
mod scanout;
#[cfg(all(target_arch = "x86_64", any(test, feature = "avx")))]
mod spill;
#[cfg(target_arch = "x86_64")]
mod sse2;
#[cfg(test)]
mod tests;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
mod wasm;
#[cfg(target_arch = "x86_64")]
mod x86;

#[cfg(all(test, target_arch = "x86_64"))]
pub(crate) use avx2::with_pairs;
pub use crt::{CrtColumns, ONE, STRIPES, crt_row};
pub use fill::fill_pixels;
pub use level::{Kernel, Level};
pub(crate) use level::{LongKernel, long_kernel};
pub use pixels::{Pixels, unpack, widen};
pub use portable::Portable;
pub use scanout::{add_weighted, mean_word, scan_out, word};

use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// N lanes of f32. Operators are IEEE single precision, lane by lane.
pub trait F32<S: Simd>:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// Returns the correctly rounded square root.
    fn sqrt(self) -> Self;
    /// Returns the largest integer not above the value, for every f32.
    fn floor(self) -> Self;
    /// Clears the sign bit.
    fn abs(self) -> Self;
    /// Returns `if self < other { self } else { other }`: a NaN gives `other`.
    fn min(self, other: Self) -> Self;
    /// Returns `if self > other { self } else { other }`: a NaN gives `other`.
    fn max(self, other: Self) -> Self;
    /// Compares self < other; false for NaN.
    fn lt(self, other: Self) -> S::M;
    /// Compares self <= other; false for NaN.
    fn le(self, other: Self) -> S::M;
    /// Rounds towards zero; `i32::MIN` for NaN and for values out of range.
    fn to_i32(self) -> S::I;
    /// Reinterprets the bits as i32.
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
    /// Shifts left by N bits (0..=31), filling with zeros.
    fn shl<const N: u32>(self) -> Self;
    /// Shifts right by N bits (0..=31), filling with the sign.
    fn sar<const N: u32>(self) -> Self;
    /// Shifts right by N bits (0..=31), filling with zeros.
    fn shr<const N: u32>(self) -> Self;
    /// Returns the smaller of the two, signed.
    fn min(self, other: Self) -> Self;
    /// Returns the larger of the two, signed.
    fn max(self, other: Self) -> Self;
    /// Compares self == other.
    fn eq(self, other: Self) -> S::M;
    /// Compares self > other, signed.
    fn gt(self, other: Self) -> S::M;
    /// Returns the smallest lane, signed.
    fn reduce_min(self) -> i32;
    /// Returns the largest lane, signed.
    fn reduce_max(self) -> i32;
    /// Converts to the nearest f32, ties to even.
    fn to_f32(self) -> S::F;
    /// Reinterprets the bits as f32.
    fn as_f32(self) -> S::F;
}

/// N boolean lanes.
pub trait Mask: Copy + BitAnd<Output = Self> + BitOr<Output = Self> + Not<Output = Self> {
    /// Returns the lanes as bits: bit i is lane i.
    fn bits(self) -> u32;
    /// Returns whether any lane is set.
    #[inline(always)]
    fn any(self) -> bool {
        self.bits() != 0
    }
}

/// Part of a kernel that [`Simd::call`] keeps out of line. What the compiler needs for a kernel grows
/// faster than the kernel: parts that are called seldom, or from several places, spare most of it.
/// Mark `run` `#[inline(always)]`, as that of kernels.
pub trait Part<S: Simd> {
    /// Result of [`run`](Part::run).
    type Output;
    /// Runs the part with the token of its kernel.
    fn run(self, s: S) -> Self::Output;
}

/// Token of a level: creates, loads and stores its vectors.
///
/// Slices are checked: one that is too short panics, as indexing does.
pub trait Simd: Copy + 'static {
    /// Number of lanes of a vector.
    const LANES: usize;
    /// Vector of f32.
    type F: F32<Self>;
    /// Vector of i32.
    type I: I32<Self>;
    /// Vector of booleans.
    type M: Mask;

    /// Runs a part of a kernel, at this level or over its vectors' pairs, as a function of its own.
    #[inline(never)]
    fn call<S: Simd, P: Part<S>>(self, s: S, part: P) -> P::Output {
        part.run(s)
    }
    /// Returns `v` in every lane.
    fn splat(self, v: f32) -> Self::F;
    /// Returns `v` in every lane.
    fn splat_i(self, v: i32) -> Self::I;
    /// Returns 0, 1, 2, ...
    fn iota(self) -> Self::I;
    /// Loads the first LANES numbers of `from`.
    fn load(self, from: &[f32]) -> Self::F;
    /// Loads the first LANES numbers of `from`.
    fn load_i(self, from: &[i32]) -> Self::I;
    /// Stores to the first LANES elements of `to`.
    fn store(self, v: Self::F, to: &mut [f32]);
    /// Stores to the first LANES elements of `to`.
    fn store_i(self, v: Self::I, to: &mut [i32]);
    /// Stores the set lanes to the first LANES elements of `to`.
    fn store_masked_i(self, mask: Self::M, v: Self::I, to: &mut [i32]);
    /// Loads the first LANES pixels of `from`, four bytes each, the first byte lowest.
    fn load_bytes(self, from: &[u8]) -> Self::I;
    /// Stores the set lanes to the first LANES pixels of `to`, four bytes each, the lowest byte
    /// first.
    fn store_masked_bytes(self, mask: Self::M, v: Self::I, to: &mut [u8]);
    /// Loads a block of LANES / 4 rows of four numbers: row r from `from[r * stride..]` into lanes
    /// 4 r to 4 r + 3.
    fn load_block(self, from: &[i32], stride: usize) -> Self::I;
    /// Stores the set lanes of a block of LANES / 4 rows of four pixels, four bytes each, the
    /// lowest byte first: row r from pixel `r * stride` of `to` on. Rows without a set lane may lie
    /// outside `to`.
    fn store_block_bytes(self, mask: Self::M, v: Self::I, to: &mut [u8], stride: usize);
    /// Packs the set lanes to the front of `to` and returns their count. `to` holds LANES elements;
    /// those behind the packed ones are unspecified.
    fn compress_i(self, mask: Self::M, v: Self::I, to: &mut [i32]) -> usize;
    /// Interleaves the lanes of `a` and `b`, starting with `a`: the first half of the result and
    /// the second.
    fn zip(self, a: Self::I, b: Self::I) -> [Self::I; 2];
    /// Packs the set lanes, as records of eight numbers, to the front of `to` and returns their
    /// count: number f of a record is its lane of `fields[f]`. `to` holds LANES records; those
    /// behind the packed ones are zeroed.
    fn compress8(self, mask: Self::M, fields: [Self::I; 8], to: &mut [[i32; 8]]) -> usize;
    /// Returns the set lanes whose number no set lane before them holds.
    fn first_occurrences(self, mask: Self::M, v: Self::I) -> Self::M;
    /// Returns the mask whose lane i is bit i of `bits`.
    fn mask(self, bits: u32) -> Self::M;
    /// Adds 1 to `counts` in the set lanes.
    fn increment(self, mask: Self::M, counts: Self::I) -> Self::I;
    /// Returns `a` where the mask is set, else `b`.
    fn select(self, mask: Self::M, a: Self::F, b: Self::F) -> Self::F;
    /// Returns `a` where the mask is set, else `b`.
    fn select_i(self, mask: Self::M, a: Self::I, b: Self::I) -> Self::I;
    /// Returns `table[index & 7]` in each lane.
    fn lookup(self, table: &[i32; 8], index: Self::I) -> Self::I;
    /// Loads pixel `index` of `from` (four bytes each, the first byte lowest) in each lane where
    /// the mask is set, 0 elsewhere. Panics if a set lane's pixel is out of bounds.
    fn gather_bytes(self, mask: Self::M, from: &[u8], index: Self::I) -> Self::I;
    /// Loads `from[index]` in each lane where the mask is set, 0 elsewhere. Panics if a set lane's
    /// index is out of bounds.
    fn gather(self, mask: Self::M, from: &[f32], index: Self::I) -> Self::F;
    /// Loads the four numbers of `from[index]` in each lane where the mask is set, transposed:
    /// component c of lane i is `result[c]` lane i; unset lanes read record 0. Panics if a set
    /// lane's index is out of bounds or `from` is empty.
    fn gather4(self, mask: Self::M, from: &[[f32; 4]], index: Self::I) -> [Self::F; 4];
    /// Loads the records `from[index]` and `from[index + 1]` in each lane where the mask is set, as
    /// four words, the first number of a pair lowest; unset lanes read records 0 and 1. Panics if
    /// one of these is out of bounds.
    fn gather_pairs(self, mask: Self::M, from: &[[u16; 4]], index: Self::I) -> [Self::I; 4];
    /// Loads pixels `index` and `index + 1` of `from` (four bytes each, the first byte lowest) in
    /// each lane where the mask is set; unset lanes read pixels 0 and 1. Panics if one of these is
    /// out of bounds.
    fn gather_byte_pairs(self, mask: Self::M, from: &[u8], index: Self::I) -> [Self::I; 2];
}

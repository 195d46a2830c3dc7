//! Plain arrays of N lanes: the portable path (N = 4) of targets without vectors of their own for
//! it, and the scalar reference for the intrinsics (N = 4, 8, 16).

use super::{F32, I32, Mask, Simd};
use std::array::from_fn;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// Token of N-lane arrays.
#[derive(Clone, Copy, Debug)]
pub struct Portable<const N: usize>;

/// N lanes of f32.
#[derive(Clone, Copy, Debug)]
#[repr(align(16))]
pub struct FloatLanes<const N: usize>([f32; N]);

/// N lanes of i32.
#[derive(Clone, Copy, Debug)]
#[repr(align(16))]
pub struct IntLanes<const N: usize>([i32; N]);

/// N lanes of true (all ones) or false (zero), as wide as the numbers so that the compiler can use
/// vectors.
#[derive(Clone, Copy, Debug)]
#[repr(align(16))]
pub struct MaskLanes<const N: usize>([i32; N]);

macro_rules! lanewise {
    ($($lanes:ident $op:ident $method:ident $f:expr;)+) => {$(
        impl<const N: usize> $op for $lanes<N> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                $lanes(from_fn(|i| $f(self.0[i], other.0[i])))
            }
        }
    )+};
}

lanewise! {
    FloatLanes Add add |a: f32, b| a + b;
    FloatLanes Sub sub |a: f32, b| a - b;
    FloatLanes Mul mul |a: f32, b| a * b;
    FloatLanes Div div |a: f32, b| a / b;
    IntLanes Add add i32::wrapping_add;
    IntLanes Sub sub i32::wrapping_sub;
    IntLanes Mul mul i32::wrapping_mul;
    IntLanes BitAnd bitand |a: i32, b| a & b;
    IntLanes BitOr bitor |a: i32, b| a | b;
    IntLanes BitXor bitxor |a: i32, b| a ^ b;
    MaskLanes BitAnd bitand |a: i32, b| a & b;
    MaskLanes BitOr bitor |a: i32, b| a | b;
}

impl<const N: usize> Neg for FloatLanes<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        FloatLanes(self.0.map(|a| -a))
    }
}

impl<const N: usize> Not for MaskLanes<N> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        MaskLanes(self.0.map(|a| !a))
    }
}

#[inline(always)]
fn yes(b: bool) -> i32 {
    -(b as i32)
}

/// Returns `a` where the mask's lane is set, else `b`: bits, because compilers make a branch of a
/// choice between two numbers.
#[inline(always)]
fn chosen(mask: i32, a: i32, b: i32) -> i32 {
    (a & mask) | (b & !mask)
}

impl<const N: usize> F32<Portable<N>> for FloatLanes<N> {
    #[inline(always)]
    fn sqrt(self) -> Self {
        FloatLanes(self.0.map(f32::sqrt))
    }
    #[inline(always)]
    fn floor(self) -> Self {
        FloatLanes(self.0.map(floor))
    }
    #[inline(always)]
    fn abs(self) -> Self {
        FloatLanes(self.0.map(f32::abs))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        FloatLanes(from_fn(|i| if self.0[i] < other.0[i] { self.0[i] } else { other.0[i] }))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        FloatLanes(from_fn(|i| if self.0[i] > other.0[i] { self.0[i] } else { other.0[i] }))
    }
    #[inline(always)]
    fn lt(self, other: Self) -> MaskLanes<N> {
        MaskLanes(from_fn(|i| yes(self.0[i] < other.0[i])))
    }
    #[inline(always)]
    fn le(self, other: Self) -> MaskLanes<N> {
        MaskLanes(from_fn(|i| yes(self.0[i] <= other.0[i])))
    }
    #[inline(always)]
    fn to_i32(self) -> IntLanes<N> {
        IntLanes(self.0.map(truncate))
    }
    #[inline(always)]
    fn bits(self) -> IntLanes<N> {
        IntLanes(self.0.map(|a| a.to_bits() as i32))
    }
}

/// Rounds towards zero like the vector units: values out of range give `i32::MIN`.
#[inline(always)]
fn truncate(a: f32) -> i32 {
    let fits = yes((-2_147_483_648.0..2_147_483_648.0).contains(&a));
    let inside = f32::from_bits(a.to_bits() & fits as u32);
    // SAFETY: the number is 0 or within the range of i32. The conversion that saturates takes four
    // times as many instructions.
    chosen(fits, unsafe { inside.to_int_unchecked() }, i32::MIN)
}

/// From here on every f32 is an integer.
const INTEGERS: f32 = 8_388_608.0;

/// Floor without a call to the system's libm: integers, infinities and NaN are returned unchanged.
#[inline(always)]
fn floor(a: f32) -> f32 {
    // The sum has no room for a fraction: this rounds to the nearest integer, ties to even.
    let nearest = ((a.abs() + INTEGERS) - INTEGERS).copysign(a);
    let above = yes(nearest > a);
    // The sign of zero is kept: -0.0 floors to -0.0, and 0.7 rounds to 1 but floors to 0.
    let floor = (nearest - f32::from_bits(above as u32 & 1f32.to_bits())).copysign(a);
    let has_fraction = yes(a.abs() < INTEGERS);
    f32::from_bits(chosen(has_fraction, floor.to_bits() as i32, a.to_bits() as i32) as u32)
}

impl<const N: usize> I32<Portable<N>> for IntLanes<N> {
    #[inline(always)]
    fn shl<const B: u32>(self) -> Self {
        IntLanes(self.0.map(|a| a << B))
    }
    #[inline(always)]
    fn sar<const B: u32>(self) -> Self {
        IntLanes(self.0.map(|a| a >> B))
    }
    #[inline(always)]
    fn shr<const B: u32>(self) -> Self {
        IntLanes(self.0.map(|a| (a as u32 >> B) as i32))
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        IntLanes(from_fn(|i| chosen(yes(self.0[i] < other.0[i]), self.0[i], other.0[i])))
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        IntLanes(from_fn(|i| chosen(yes(self.0[i] > other.0[i]), self.0[i], other.0[i])))
    }
    #[inline(always)]
    fn eq(self, other: Self) -> MaskLanes<N> {
        MaskLanes(from_fn(|i| yes(self.0[i] == other.0[i])))
    }
    #[inline(always)]
    fn gt(self, other: Self) -> MaskLanes<N> {
        MaskLanes(from_fn(|i| yes(self.0[i] > other.0[i])))
    }
    #[inline(always)]
    fn reduce_min(self) -> i32 {
        self.0.iter().fold(i32::MAX, |least, &a| if a < least { a } else { least })
    }
    #[inline(always)]
    fn reduce_max(self) -> i32 {
        self.0.iter().fold(i32::MIN, |greatest, &a| if a > greatest { a } else { greatest })
    }
    #[inline(always)]
    fn to_f32(self) -> FloatLanes<N> {
        FloatLanes(self.0.map(|a| a as f32))
    }
    #[inline(always)]
    fn as_f32(self) -> FloatLanes<N> {
        FloatLanes(self.0.map(|a| f32::from_bits(a as u32)))
    }
}

impl<const N: usize> Mask for MaskLanes<N> {
    #[inline(always)]
    fn bits(self) -> u32 {
        (0..N).fold(0, |bits, i| bits | (self.0[i] as u32 & 1) << i)
    }
}

impl<const N: usize> Simd for Portable<N> {
    const LANES: usize = N;
    type F = FloatLanes<N>;
    type I = IntLanes<N>;
    type M = MaskLanes<N>;

    #[inline(always)]
    fn splat(self, v: f32) -> FloatLanes<N> {
        FloatLanes([v; N])
    }
    #[inline(always)]
    fn splat_i(self, v: i32) -> IntLanes<N> {
        IntLanes([v; N])
    }
    #[inline(always)]
    fn iota(self) -> IntLanes<N> {
        IntLanes(from_fn(|i| i as i32))
    }
    #[inline(always)]
    fn load(self, from: &[f32]) -> FloatLanes<N> {
        let from = &from[..N];
        FloatLanes(from_fn(|i| from[i]))
    }
    #[inline(always)]
    fn load_i(self, from: &[i32]) -> IntLanes<N> {
        let from = &from[..N];
        IntLanes(from_fn(|i| from[i]))
    }
    #[inline(always)]
    fn store(self, v: FloatLanes<N>, to: &mut [f32]) {
        to[..N].copy_from_slice(&v.0);
    }
    #[inline(always)]
    fn store_i(self, v: IntLanes<N>, to: &mut [i32]) {
        to[..N].copy_from_slice(&v.0);
    }
    #[inline(always)]
    fn store_masked_i(self, mask: MaskLanes<N>, v: IntLanes<N>, to: &mut [i32]) {
        for ((to, v), m) in to[..N].iter_mut().zip(v.0).zip(mask.0) {
            *to = if m != 0 { v } else { *to };
        }
    }
    #[inline(always)]
    fn load_bytes(self, from: &[u8]) -> IntLanes<N> {
        let from = from[..N * 4].as_chunks::<4>().0;
        IntLanes(from_fn(|i| i32::from_le_bytes(from[i])))
    }
    #[inline(always)]
    fn store_masked_bytes(self, mask: MaskLanes<N>, v: IntLanes<N>, to: &mut [u8]) {
        for ((to, v), m) in to[..N * 4].as_chunks_mut::<4>().0.iter_mut().zip(v.0).zip(mask.0) {
            *to = if m != 0 { v.to_le_bytes() } else { *to };
        }
    }
    #[inline(always)]
    fn load_block(self, from: &[i32], stride: usize) -> IntLanes<N> {
        IntLanes(from_fn(|i| from[i / 4 * stride + i % 4]))
    }
    #[inline(always)]
    fn store_block_bytes(self, mask: MaskLanes<N>, v: IntLanes<N>, to: &mut [u8], stride: usize) {
        for (i, (v, m)) in v.0.iter().zip(mask.0).enumerate() {
            if m != 0 {
                to[(i / 4 * stride + i % 4) * 4..][..4].copy_from_slice(&v.to_le_bytes());
            }
        }
    }
    #[inline(always)]
    fn compress_i(self, mask: MaskLanes<N>, v: IntLanes<N>, to: &mut [i32]) -> usize {
        let to = &mut to[..N];
        let mut n = 0;
        for i in 0..N {
            to[n] = v.0[i];
            n += (mask.0[i] != 0) as usize;
            if n == N {
                break;
            }
        }
        n
    }
    #[inline(always)]
    fn zip(self, a: IntLanes<N>, b: IntLanes<N>) -> [IntLanes<N>; 2] {
        [0, N / 2]
            .map(|from| IntLanes(std::array::from_fn(|i| [a.0[from + i / 2], b.0[from + i / 2]][i % 2])))
    }
    #[inline(always)]
    fn compress8(self, mask: MaskLanes<N>, fields: [IntLanes<N>; 8], to: &mut [[i32; 8]]) -> usize {
        let to = &mut to[..N];
        to.fill([0; 8]);
        let mut n = 0;
        for i in 0..N {
            if mask.0[i] != 0 {
                to[n] = from_fn(|f| fields[f].0[i]);
                n += 1;
            }
        }
        n
    }
    #[inline(always)]
    fn first_occurrences(self, mask: MaskLanes<N>, v: IntLanes<N>) -> MaskLanes<N> {
        let is_set = |i: usize| mask.0[i] != 0;
        MaskLanes(from_fn(|i| yes(is_set(i) && !(0..i).any(|k| is_set(k) && v.0[k] == v.0[i]))))
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> MaskLanes<N> {
        MaskLanes(from_fn(|i| yes(bits >> i & 1 != 0)))
    }
    #[inline(always)]
    fn increment(self, mask: MaskLanes<N>, counts: IntLanes<N>) -> IntLanes<N> {
        IntLanes(from_fn(|i| counts.0[i].wrapping_sub(mask.0[i])))
    }
    #[inline(always)]
    fn select(self, mask: MaskLanes<N>, a: FloatLanes<N>, b: FloatLanes<N>) -> FloatLanes<N> {
        let bits = |v: f32| v.to_bits() as i32;
        FloatLanes(from_fn(|i| f32::from_bits(chosen(mask.0[i], bits(a.0[i]), bits(b.0[i])) as u32)))
    }
    #[inline(always)]
    fn select_i(self, mask: MaskLanes<N>, a: IntLanes<N>, b: IntLanes<N>) -> IntLanes<N> {
        IntLanes(from_fn(|i| chosen(mask.0[i], a.0[i], b.0[i])))
    }
    #[inline(always)]
    fn lookup(self, table: &[i32; 8], index: IntLanes<N>) -> IntLanes<N> {
        IntLanes(from_fn(|i| table[index.0[i] as usize & 7]))
    }
    #[inline(always)]
    fn gather_bytes(self, mask: MaskLanes<N>, from: &[u8], index: IntLanes<N>) -> IntLanes<N> {
        let from = from.as_chunks::<4>().0;
        IntLanes(from_fn(|i| {
            // Unset lanes read pixel 0, if there is one.
            let at = (index.0[i] & mask.0[i]) as u32 as usize;
            if mask.0[i] != 0 || !from.is_empty() { i32::from_le_bytes(from[at]) & mask.0[i] } else { 0 }
        }))
    }
    #[inline(always)]
    fn gather(self, mask: MaskLanes<N>, from: &[f32], index: IntLanes<N>) -> FloatLanes<N> {
        FloatLanes(from_fn(|i| if mask.0[i] != 0 { from[index.0[i] as u32 as usize] } else { 0.0 }))
    }
    #[inline(always)]
    fn gather_pairs(self, mask: MaskLanes<N>, from: &[[u16; 4]], index: IntLanes<N>) -> [IntLanes<N>; 4] {
        // Whole records are loaded: numbers of 16 bits would be moved one by one.
        let record = |[a, b, c, d]: [u16; 4]| {
            u64::from(a) | u64::from(b) << 16 | u64::from(c) << 32 | u64::from(d) << 48
        };
        let pairs: [[u64; 2]; N] = from_fn(|i| {
            let at = (index.0[i] & mask.0[i]) as u32 as usize;
            let &[first, second] = from[at..].first_chunk().expect("a record and its successor");
            [record(first), record(second)]
        });
        from_fn(|w| IntLanes(from_fn(|i| (pairs[i][w / 2] >> (w % 2 * 32)) as i32)))
    }
    #[inline(always)]
    fn gather_byte_pairs(self, mask: MaskLanes<N>, from: &[u8], index: IntLanes<N>) -> [IntLanes<N>; 2] {
        let from = from.as_chunks::<4>().0;
        let at: [usize; N] = from_fn(|i| (index.0[i] & mask.0[i]) as u32 as usize);
        from_fn(|w| IntLanes(from_fn(|i| i32::from_le_bytes(from[at[i] + w]))))
    }
    #[inline(always)]
    fn gather4(self, mask: MaskLanes<N>, from: &[[f32; 4]], index: IntLanes<N>) -> [FloatLanes<N>; 4] {
        let records: [[f32; 4]; N] = from_fn(|i| from[(index.0[i] & mask.0[i]) as u32 as usize]);
        from_fn(|c| FloatLanes(from_fn(|i| records[i][c])))
    }
}

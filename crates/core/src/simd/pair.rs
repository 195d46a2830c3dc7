//! Pairs of vectors as vectors of twice as many lanes.
//!
//! A long kernel waits for its chain of divisions and roots: two independent chains, interleaved
//! instruction by instruction, take little longer than one. In: the operations of a level. Out:
//! those of twice its lanes. Promise: a lane's bits are those of the level.

use super::{F32, I32, Mask, Part, Simd};
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// Token of the pairs of a level's vectors.
#[derive(Clone, Copy, Debug)]
pub struct Paired<S>(pub S);

/// Lanes of two vectors, the first one's first.
#[derive(Clone, Copy, Debug)]
pub struct Pair<T>(T, T);

macro_rules! operators {
    ($($op:ident $method:ident;)+) => {$(
        impl<T: $op<Output = T>> $op for Pair<T> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Pair(self.0.$method(other.0), self.1.$method(other.1))
            }
        }
    )+};
}

operators! {
    Add add;
    Sub sub;
    Mul mul;
    Div div;
    BitAnd bitand;
    BitOr bitor;
    BitXor bitxor;
}

impl<T: Neg<Output = T>> Neg for Pair<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Pair(-self.0, -self.1)
    }
}

impl<T: Not<Output = T>> Not for Pair<T> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        Pair(!self.0, !self.1)
    }
}

/// Methods that work on each vector by itself, and the pair that they give.
macro_rules! halves {
    ($($method:ident($($other:ident)?) -> $pair:ident<$out:ty>;)+) => {$(
        #[inline(always)]
        fn $method(self $(, $other: Self)?) -> $pair<$out> {
            $pair(self.0.$method($($other.0)?), self.1.$method($($other.1)?))
        }
    )+};
}

impl<S: Simd> F32<Paired<S>> for Pair<S::F> {
    halves! {
        sqrt() -> Pair<S::F>;
        floor() -> Pair<S::F>;
        abs() -> Pair<S::F>;
        min(other) -> Pair<S::F>;
        max(other) -> Pair<S::F>;
        lt(other) -> PairMask<S>;
        le(other) -> PairMask<S>;
        to_i32() -> Pair<S::I>;
        bits() -> Pair<S::I>;
    }
}

impl<S: Simd> I32<Paired<S>> for Pair<S::I> {
    halves! {
        min(other) -> Pair<S::I>;
        max(other) -> Pair<S::I>;
        eq(other) -> PairMask<S>;
        gt(other) -> PairMask<S>;
        to_f32() -> Pair<S::F>;
        as_f32() -> Pair<S::F>;
    }

    #[inline(always)]
    fn shl<const N: u32>(self) -> Self {
        Pair(self.0.shl::<N>(), self.1.shl::<N>())
    }
    #[inline(always)]
    fn sar<const N: u32>(self) -> Self {
        Pair(self.0.sar::<N>(), self.1.sar::<N>())
    }
    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        Pair(self.0.shr::<N>(), self.1.shr::<N>())
    }
    #[inline(always)]
    fn reduce_min(self) -> i32 {
        self.0.min(self.1).reduce_min()
    }
    #[inline(always)]
    fn reduce_max(self) -> i32 {
        self.0.max(self.1).reduce_max()
    }
}

/// Boolean lanes of two vectors.
#[derive(Clone, Copy, Debug)]
pub struct PairMask<S: Simd>(S::M, S::M);

impl<S: Simd> BitAnd for PairMask<S> {
    type Output = Self;
    #[inline(always)]
    fn bitand(self, other: Self) -> Self {
        PairMask(self.0 & other.0, self.1 & other.1)
    }
}

impl<S: Simd> BitOr for PairMask<S> {
    type Output = Self;
    #[inline(always)]
    fn bitor(self, other: Self) -> Self {
        PairMask(self.0 | other.0, self.1 | other.1)
    }
}

impl<S: Simd> Not for PairMask<S> {
    type Output = Self;
    #[inline(always)]
    fn not(self) -> Self {
        PairMask(!self.0, !self.1)
    }
}

impl<S: Simd> Mask for PairMask<S> {
    #[inline(always)]
    fn bits(self) -> u32 {
        self.0.bits() | self.1.bits() << S::LANES
    }
    #[inline(always)]
    fn any(self) -> bool {
        (self.0 | self.1).any()
    }
}

impl<S: Simd> Paired<S> {
    /// Returns the lanes of `v` whose number is that of a set lane of `before`.
    #[inline(always)]
    fn recurring(self, mask: S::M, before: S::I, v: S::I) -> S::M {
        let (s, bits) = (self.0, mask.bits());
        let mut recurring = s.mask(0);
        if bits == 0 {
            return recurring;
        }
        let mut numbers = [0; 16];
        s.store_i(before, &mut numbers[..S::LANES]);
        if bits != u32::MAX >> (32 - S::LANES) {
            // Unset lanes repeat a set one.
            let first = s.splat_i(numbers[bits.trailing_zeros() as usize & 15]);
            s.store_i(s.select_i(mask, before, first), &mut numbers[..S::LANES]);
        }
        let mut lane = 0;
        while lane < S::LANES {
            recurring = recurring | v.eq(s.splat_i(numbers[lane]));
            lane += 1;
        }
        recurring
    }
}

impl<S: Simd> Simd for Paired<S> {
    const LANES: usize = 2 * S::LANES;
    type F = Pair<S::F>;
    type I = Pair<S::I>;
    type M = PairMask<S>;

    #[inline(always)]
    fn call<T: Simd, P: Part<T>>(self, s: T, part: P) -> P::Output {
        self.0.call(s, part)
    }
    #[inline(always)]
    fn splat(self, v: f32) -> Self::F {
        Pair(self.0.splat(v), self.0.splat(v))
    }
    #[inline(always)]
    fn splat_i(self, v: i32) -> Self::I {
        Pair(self.0.splat_i(v), self.0.splat_i(v))
    }
    #[inline(always)]
    fn iota(self) -> Self::I {
        let first = self.0.iota();
        Pair(first, first + self.0.splat_i(S::LANES as i32))
    }
    #[inline(always)]
    fn load(self, from: &[f32]) -> Self::F {
        let from = &from[..Self::LANES];
        Pair(self.0.load(from), self.0.load(&from[S::LANES..]))
    }
    #[inline(always)]
    fn load_i(self, from: &[i32]) -> Self::I {
        let from = &from[..Self::LANES];
        Pair(self.0.load_i(from), self.0.load_i(&from[S::LANES..]))
    }
    #[inline(always)]
    fn store(self, v: Self::F, to: &mut [f32]) {
        let (low, high) = to[..Self::LANES].split_at_mut(S::LANES);
        self.0.store(v.0, low);
        self.0.store(v.1, high);
    }
    #[inline(always)]
    fn store_i(self, v: Self::I, to: &mut [i32]) {
        let (low, high) = to[..Self::LANES].split_at_mut(S::LANES);
        self.0.store_i(v.0, low);
        self.0.store_i(v.1, high);
    }
    #[inline(always)]
    fn store_masked_i(self, mask: Self::M, v: Self::I, to: &mut [i32]) {
        let (low, high) = to[..Self::LANES].split_at_mut(S::LANES);
        self.0.store_masked_i(mask.0, v.0, low);
        self.0.store_masked_i(mask.1, v.1, high);
    }
    #[inline(always)]
    fn load_bytes(self, from: &[u8]) -> Self::I {
        let from = &from[..4 * Self::LANES];
        Pair(self.0.load_bytes(from), self.0.load_bytes(&from[4 * S::LANES..]))
    }
    #[inline(always)]
    fn store_masked_bytes(self, mask: Self::M, v: Self::I, to: &mut [u8]) {
        let (low, high) = to[..4 * Self::LANES].split_at_mut(4 * S::LANES);
        self.0.store_masked_bytes(mask.0, v.0, low);
        self.0.store_masked_bytes(mask.1, v.1, high);
    }
    #[inline(always)]
    fn load_block(self, from: &[i32], stride: usize) -> Self::I {
        Pair(self.0.load_block(from, stride), self.0.load_block(&from[S::LANES / 4 * stride..], stride))
    }
    #[inline(always)]
    fn store_block_bytes(self, mask: Self::M, v: Self::I, to: &mut [u8], stride: usize) {
        self.0.store_block_bytes(mask.0, v.0, to, stride);
        if mask.1.any() {
            self.0.store_block_bytes(mask.1, v.1, &mut to[S::LANES * stride..], stride);
        }
    }
    #[inline(always)]
    fn compress_i(self, mask: Self::M, v: Self::I, to: &mut [i32]) -> usize {
        let to = &mut to[..Self::LANES];
        let count = self.0.compress_i(mask.0, v.0, to);
        count + self.0.compress_i(mask.1, v.1, &mut to[count..])
    }
    #[inline(always)]
    fn zip(self, a: Self::I, b: Self::I) -> [Self::I; 2] {
        let ([a0, b0], [a1, b1]) = (self.0.zip(a.0, b.0), self.0.zip(a.1, b.1));
        [Pair(a0, b0), Pair(a1, b1)]
    }
    #[inline(always)]
    fn compress8(self, mask: Self::M, fields: [Self::I; 8], to: &mut [[i32; 8]]) -> usize {
        let to = &mut to[..Self::LANES];
        let [a, b, c, d, e, f, g, h] = fields;
        let low = [a.0, b.0, c.0, d.0, e.0, f.0, g.0, h.0];
        let high = [a.1, b.1, c.1, d.1, e.1, f.1, g.1, h.1];
        let count = self.0.compress8(mask.0, low, to);
        let more = self.0.compress8(mask.1, high, &mut to[count..]);
        to[count + S::LANES..].fill([0; 8]);
        count + more
    }
    #[inline(always)]
    fn first_occurrences(self, mask: Self::M, v: Self::I) -> Self::M {
        let again = self.recurring(mask.0, v.0, v.1);
        let (low, high) = (self.0.first_occurrences(mask.0, v.0), self.0.first_occurrences(mask.1, v.1));
        PairMask(low, high & !again)
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> Self::M {
        PairMask(self.0.mask(bits), self.0.mask(bits >> S::LANES))
    }
    #[inline(always)]
    fn increment(self, mask: Self::M, counts: Self::I) -> Self::I {
        Pair(self.0.increment(mask.0, counts.0), self.0.increment(mask.1, counts.1))
    }
    #[inline(always)]
    fn select(self, mask: Self::M, a: Self::F, b: Self::F) -> Self::F {
        Pair(self.0.select(mask.0, a.0, b.0), self.0.select(mask.1, a.1, b.1))
    }
    #[inline(always)]
    fn select_i(self, mask: Self::M, a: Self::I, b: Self::I) -> Self::I {
        Pair(self.0.select_i(mask.0, a.0, b.0), self.0.select_i(mask.1, a.1, b.1))
    }
    #[inline(always)]
    fn lookup(self, table: &[i32; 8], index: Self::I) -> Self::I {
        Pair(self.0.lookup(table, index.0), self.0.lookup(table, index.1))
    }
    #[inline(always)]
    fn gather_bytes(self, mask: Self::M, from: &[u8], index: Self::I) -> Self::I {
        Pair(self.0.gather_bytes(mask.0, from, index.0), self.0.gather_bytes(mask.1, from, index.1))
    }
    #[inline(always)]
    fn gather(self, mask: Self::M, from: &[f32], index: Self::I) -> Self::F {
        Pair(self.0.gather(mask.0, from, index.0), self.0.gather(mask.1, from, index.1))
    }
    #[inline(always)]
    fn gather4(self, mask: Self::M, from: &[[f32; 4]], index: Self::I) -> [Self::F; 4] {
        let [a, b, c, d] = self.0.gather4(mask.0, from, index.0);
        let [e, f, g, h] = self.0.gather4(mask.1, from, index.1);
        [Pair(a, e), Pair(b, f), Pair(c, g), Pair(d, h)]
    }
    #[inline(always)]
    fn gather_pairs(self, mask: Self::M, from: &[[u16; 4]], index: Self::I) -> [Self::I; 4] {
        let [a, b, c, d] = self.0.gather_pairs(mask.0, from, index.0);
        let [e, f, g, h] = self.0.gather_pairs(mask.1, from, index.1);
        [Pair(a, e), Pair(b, f), Pair(c, g), Pair(d, h)]
    }
    #[inline(always)]
    fn gather_byte_pairs(self, mask: Self::M, from: &[u8], index: Self::I) -> [Self::I; 2] {
        let [a, b] = self.0.gather_byte_pairs(mask.0, from, index.0);
        let [c, d] = self.0.gather_byte_pairs(mask.1, from, index.1);
        [Pair(a, c), Pair(b, d)]
    }
}

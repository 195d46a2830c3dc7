//! AVX2: 8 lanes, masks as all-ones lanes.

use super::spilled::Spilled;
use super::{F32, I32, Kernel, Mask, Simd};
use std::arch::x86_64::*;
use std::ops::{Add, BitAnd, BitOr, BitXor, Div, Mul, Neg, Not, Sub};

/// The token: made by [`run`] alone.
#[derive(Clone, Copy, Debug)]
pub struct Avx2(());

/// 8 lanes of f32.
#[derive(Clone, Copy, Debug)]
pub struct F(__m256);

/// 8 lanes of i32.
#[derive(Clone, Copy, Debug)]
pub struct I(__m256i);

/// 8 lanes of yes (all ones) or no (zero).
#[derive(Clone, Copy, Debug)]
pub struct M(__m256i);

/// Runs a kernel compiled for AVX2.
///
/// # Safety
/// The CPU must have AVX2.
#[target_feature(enable = "avx2,popcnt")]
pub unsafe fn run<K: Kernel>(kernel: K) -> K::Output {
    kernel.run(Avx2(()))
}

// SAFETY (for every block of this file): a vector or token of this module exists only below `run`, whose caller has made
// sure of the CPU's features; loads and stores go through slices whose length was checked just before.
macro_rules! binary {
    ($($type:ident $op:ident $method:ident $intrinsic:ident;)+) => {$(
        impl $op for $type {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                // SAFETY: see the note above: holding a vector proves the features.
                unsafe { $type($intrinsic(self.0, other.0)) }
            }
        }
    )+};
}

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

/// One intrinsic on self and up to one other vector.
macro_rules! op {
    ($self:ident => $wrap:ident, $intrinsic:ident $(::<$c:tt>)? ($($arg:expr),*)) => {
        // SAFETY: holding a vector proves the features.
        unsafe { $wrap($intrinsic $(::<$c>)? ($self.0 $(, $arg)*)) }
    };
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
        // SAFETY: holding a vector proves the features. The count is in a register: its constant form takes an i32.
        unsafe { I(_mm256_sll_epi32(self.0, _mm_cvtsi32_si128(N as i32))) }
    }
    #[inline(always)]
    fn sar<const N: u32>(self) -> Self {
        // SAFETY: holding a vector proves the features. The count is in a register: its constant form takes an i32.
        unsafe { I(_mm256_sra_epi32(self.0, _mm_cvtsi32_si128(N as i32))) }
    }
    #[inline(always)]
    fn shr<const N: u32>(self) -> Self {
        // SAFETY: holding a vector proves the features. The count is in a register: its constant form takes an i32.
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
    fn least(self) -> i32 {
        // SAFETY: holding a vector proves the features.
        unsafe {
            let v = _mm_min_epi32(_mm256_castsi256_si128(self.0), _mm256_extracti128_si256::<1>(self.0));
            let v = _mm_min_epi32(v, _mm_shuffle_epi32::<0b01_00_11_10>(v));
            _mm_cvtsi128_si32(_mm_min_epi32(v, _mm_shuffle_epi32::<0b10_11_00_01>(v)))
        }
    }
    #[inline(always)]
    fn greatest(self) -> i32 {
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

/// For each mask the lanes that are set, in order.
static COMPRESS: [[i32; 8]; 256] = {
    let mut table = [[0; 8]; 256];
    let mut bits = 0;
    while bits < 256 {
        let (mut lane, mut n) = (0, 0);
        while lane < 8 {
            if bits >> lane & 1 == 1 {
                table[bits][n] = lane;
                n += 1;
            }
            lane += 1;
        }
        bits += 1;
    }
    table
};

/// Panics unless every set lane of `index`, read as unsigned, is below `len`.
#[inline(always)]
fn check(mask: M, index: I, len: usize) {
    let len = len.min(i32::MAX as usize) as i32;
    // SAFETY: holding a vector proves the features. Unsigned a <= b is min(a, b) == a.
    let inside = unsafe {
        let below = _mm256_min_epu32(index.0, _mm256_set1_epi32(len - 1));
        M(_mm256_cmpeq_epi32(below, index.0))
    };
    assert!(len > 0 && !(mask & !inside).any() || !mask.any(), "gathered index outside the slice's {len}");
}

impl Simd for Avx2 {
    const LANES: usize = 8;
    type F = F;
    type I = I;
    type M = M;

    #[inline(always)]
    fn splat(self, v: f32) -> F {
        // SAFETY: the token proves the features.
        unsafe { F(_mm256_set1_ps(v)) }
    }
    #[inline(always)]
    fn splat_i(self, v: i32) -> I {
        // SAFETY: the token proves the features.
        unsafe { I(_mm256_set1_epi32(v)) }
    }
    #[inline(always)]
    fn iota(self) -> I {
        // SAFETY: the token proves the features.
        unsafe { I(_mm256_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7)) }
    }
    #[inline(always)]
    fn load(self, from: &[f32]) -> F {
        let from = &from[..8];
        // SAFETY: the token proves the features; 8 numbers are there.
        unsafe { F(_mm256_loadu_ps(from.as_ptr())) }
    }
    #[inline(always)]
    fn load_i(self, from: &[i32]) -> I {
        let from = &from[..8];
        // SAFETY: the token proves the features; 8 numbers are there.
        unsafe { I(_mm256_loadu_si256(from.as_ptr().cast())) }
    }
    #[inline(always)]
    fn store(self, v: F, to: &mut [f32]) {
        let to = &mut to[..8];
        // SAFETY: the token proves the features; 8 places are there.
        unsafe { _mm256_storeu_ps(to.as_mut_ptr(), v.0) }
    }
    #[inline(always)]
    fn store_i(self, v: I, to: &mut [i32]) {
        let to = &mut to[..8];
        // SAFETY: the token proves the features; 8 places are there.
        unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), v.0) }
    }
    #[inline(always)]
    fn store_masked_i(self, mask: M, v: I, to: &mut [i32]) {
        let to = &mut to[..8];
        // SAFETY: the token proves the features; 8 places are there.
        unsafe {
            let old = _mm256_loadu_si256(to.as_ptr().cast());
            _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_blendv_epi8(old, v.0, mask.0))
        }
    }
    #[inline(always)]
    fn load_bytes(self, from: &[u8]) -> I {
        let from = &from[..32];
        // SAFETY: the token proves the features; 32 bytes are there, and x86 keeps the lowest byte first.
        unsafe { I(_mm256_loadu_si256(from.as_ptr().cast())) }
    }
    #[inline(always)]
    fn store_masked_bytes(self, mask: M, v: I, to: &mut [u8]) {
        let to = &mut to[..32];
        // SAFETY: the token proves the features; 32 bytes are there, and x86 keeps the lowest byte first.
        unsafe {
            let old = _mm256_loadu_si256(to.as_ptr().cast());
            _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_blendv_epi8(old, v.0, mask.0))
        }
    }
    #[inline(always)]
    fn load_block(self, from: &[i32], stride: usize) -> I {
        let rows = [&from[..4], &from[stride..][..4]];
        // SAFETY: the token proves the features; each row has 4 numbers.
        unsafe {
            let v = _mm256_castsi128_si256(_mm_loadu_si128(rows[0].as_ptr().cast()));
            I(_mm256_inserti128_si256::<1>(v, _mm_loadu_si128(rows[1].as_ptr().cast())))
        }
    }
    #[inline(always)]
    fn store_block_bytes(self, mask: M, v: I, to: &mut [u8], stride: usize) {
        let bits = mask.bits();
        // SAFETY: the token proves the features.
        let (rows, masks) = unsafe {
            (
                [_mm256_castsi256_si128(v.0), _mm256_extracti128_si256::<1>(v.0)],
                [_mm256_castsi256_si128(mask.0), _mm256_extracti128_si256::<1>(mask.0)],
            )
        };
        let mut r = 0;
        while r < 2 {
            if bits >> (4 * r) & 15 != 0 {
                let row = &mut to[r * stride * 4..][..16];
                // SAFETY: the token proves the features; 16 bytes are there, and x86 keeps the lowest byte first.
                unsafe {
                    let old = _mm_loadu_si128(row.as_ptr().cast());
                    _mm_storeu_si128(row.as_mut_ptr().cast(), _mm_blendv_epi8(old, rows[r], masks[r]))
                }
            }
            r += 1;
        }
    }
    #[inline(always)]
    fn compress_i(self, mask: M, v: I, to: &mut [i32]) -> usize {
        let to = &mut to[..8];
        let bits = mask.bits() as usize;
        // SAFETY: the token proves the features; 8 places are there; a table row has 8 numbers.
        unsafe {
            let order = _mm256_loadu_si256(COMPRESS[bits & 255].as_ptr().cast());
            _mm256_storeu_si256(to.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(v.0, order));
        }
        bits.count_ones() as usize
    }
    #[inline(always)]
    fn compress8(self, mask: M, fields: [I; 8], to: &mut [[i32; 8]]) -> usize {
        let to = &mut to[..8];
        let bits = mask.bits() as usize;
        let count = bits.count_ones() as i32;
        // SAFETY: the token proves the features; 8 records of 32 bytes are there, and stores need no alignment; a table row has
        // 8 numbers.
        unsafe {
            let order = _mm256_loadu_si256(COMPRESS[bits & 255].as_ptr().cast());
            let kept = _mm256_cmpgt_epi32(_mm256_set1_epi32(count), self.iota().0);
            let f = [
                packed(fields[0], order, kept),
                packed(fields[1], order, kept),
                packed(fields[2], order, kept),
                packed(fields[3], order, kept),
                packed(fields[4], order, kept),
                packed(fields[5], order, kept),
                packed(fields[6], order, kept),
                packed(fields[7], order, kept),
            ];
            // Row r holds in half q the halves of record 4 q + r.
            let (low, high) =
                (rows_of_four([f[0], f[1], f[2], f[3]]), rows_of_four([f[4], f[5], f[6], f[7]]));
            let mut r = 0;
            while r < 4 {
                let first = _mm256_permute2x128_si256::<0x20>(low[r], high[r]);
                let second = _mm256_permute2x128_si256::<0x31>(low[r], high[r]);
                _mm256_storeu_si256(to[r].as_mut_ptr().cast(), first);
                _mm256_storeu_si256(to[r + 4].as_mut_ptr().cast(), second);
                r += 1;
            }
        }
        count as usize
    }
    #[inline(always)]
    fn firsts(self, mask: M, v: I) -> M {
        // SAFETY: the token proves the features.
        unsafe {
            let iota = self.iota().0;
            let mut again = _mm256_setzero_si256();
            for k in 1..8 {
                // Lane i sees lane i - k, where there is one.
                let from = _mm256_sub_epi32(iota, _mm256_set1_epi32(k));
                let other = _mm256_permutevar8x32_epi32(v.0, from);
                let is_set = _mm256_permutevar8x32_epi32(mask.0, from);
                let same = _mm256_and_si256(_mm256_cmpeq_epi32(other, v.0), is_set);
                let is_there = _mm256_cmpgt_epi32(from, _mm256_set1_epi32(-1));
                again = _mm256_or_si256(again, _mm256_and_si256(same, is_there));
            }
            M(_mm256_andnot_si256(again, mask.0))
        }
    }
    #[inline(always)]
    fn mask(self, bits: u32) -> M {
        // SAFETY: the token proves the features.
        unsafe {
            let lane = _mm256_setr_epi32(1, 2, 4, 8, 16, 32, 64, 128);
            M(_mm256_cmpeq_epi32(_mm256_and_si256(_mm256_set1_epi32(bits as i32), lane), lane))
        }
    }
    #[inline(always)]
    fn select(self, mask: M, a: F, b: F) -> F {
        // SAFETY: the token proves the features.
        unsafe { F(_mm256_blendv_ps(b.0, a.0, _mm256_castsi256_ps(mask.0))) }
    }
    #[inline(always)]
    fn select_i(self, mask: M, a: I, b: I) -> I {
        // SAFETY: the token proves the features.
        unsafe { I(_mm256_blendv_epi8(b.0, a.0, mask.0)) }
    }
    #[inline(always)]
    fn gather_bytes(self, mask: M, from: &[u8], index: I) -> I {
        check(mask, index, from.len() / 4);
        // SAFETY: the token proves the features; every set lane's pixel was found inside the slice; loads need no alignment.
        unsafe {
            let base = from.as_ptr().cast::<i32>();
            I(_mm256_mask_i32gather_epi32::<4>(_mm256_setzero_si256(), base, index.0, mask.0))
        }
    }
    #[inline(always)]
    fn gather(self, mask: M, from: &[f32], index: I) -> F {
        check(mask, index, from.len());
        // SAFETY: the token proves the features; every set lane's index was found inside the slice.
        unsafe {
            F(_mm256_mask_i32gather_ps::<4>(
                _mm256_setzero_ps(),
                from.as_ptr(),
                index.0,
                _mm256_castsi256_ps(mask.0),
            ))
        }
    }
    #[inline(always)]
    fn gather4(self, mask: M, from: &[[f32; 4]], index: I) -> [F; 4] {
        assert!(!from.is_empty(), "records to gather");
        check(mask, index, from.len());
        // SAFETY: the token proves the features; unset lanes read record 0, which exists, the others were checked.
        let [a, b, c, d] = unsafe { transposed::<16>(mask, index, from.as_ptr().cast()) };
        [F(a), F(b), F(c), F(d)]
    }
    #[inline(always)]
    fn gather_pairs(self, mask: M, from: &[[u16; 4]], index: I) -> [I; 4] {
        assert!(from.len() > 1, "pairs to gather");
        check(mask, index, from.len() - 1);
        // SAFETY: the token proves the features; unset lanes read records 0 and 1, which exist, the others were checked:
        // each has one behind it.
        unsafe {
            let [a, b, c, d] = transposed::<8>(mask, index, from.as_ptr().cast());
            [
                I(_mm256_castps_si256(a)),
                I(_mm256_castps_si256(b)),
                I(_mm256_castps_si256(c)),
                I(_mm256_castps_si256(d)),
            ]
        }
    }
    #[inline(always)]
    fn gather_byte_pairs(self, mask: M, from: &[u8], index: I) -> [I; 2] {
        assert!(from.len() >= 8, "pairs to gather");
        check(mask, index, from.len() / 4 - 1);
        // SAFETY: the token proves the features; unset lanes read pixels 0 and 1, which exist, the others were checked:
        // each has one behind it. Loads need no alignment.
        unsafe {
            let mut at = Spilled([0i32; 8]);
            _mm256_storeu_si256(at.0.as_mut_ptr().cast(), _mm256_and_si256(mask.0, index.0));
            // Lanes 4q + r and the next in half q.
            let (a, b) = (pixel_pairs(from, &at, 0), pixel_pairs(from, &at, 2));
            [
                I(_mm256_castps_si256(_mm256_shuffle_ps::<0b10_00_10_00>(a, b))),
                I(_mm256_castps_si256(_mm256_shuffle_ps::<0b11_01_11_01>(a, b))),
            ]
        }
    }
}

/// Four words a lane, read STRIDE bytes times its index from `from` on where it is set and at `from` elsewhere, transposed.
///
/// # Safety
/// The CPU must have the level's features, and 16 bytes must be there at each of those places.
#[inline(always)]
unsafe fn transposed<const STRIDE: usize>(mask: M, index: I, from: *const u8) -> [__m256; 4] {
    // SAFETY: as promised by the caller; 8 places are there.
    unsafe {
        let mut at = Spilled([0i32; 8]);
        _mm256_storeu_si256(at.0.as_mut_ptr().cast(), _mm256_and_si256(mask.0, index.0));
        // Row r holds the records of lanes r, 4+r, ...; a 4x4 transpose within each part finishes it.
        let (a, b) = (row_of::<STRIDE>(from, &at, 0), row_of::<STRIDE>(from, &at, 1));
        let (c, d) = (row_of::<STRIDE>(from, &at, 2), row_of::<STRIDE>(from, &at, 3));
        let (ab, cd) = (_mm256_unpacklo_ps(a, b), _mm256_unpacklo_ps(c, d));
        let (ef, gh) = (_mm256_unpackhi_ps(a, b), _mm256_unpackhi_ps(c, d));
        [
            _mm256_shuffle_ps::<0b01_00_01_00>(ab, cd),
            _mm256_shuffle_ps::<0b11_10_11_10>(ab, cd),
            _mm256_shuffle_ps::<0b01_00_01_00>(ef, gh),
            _mm256_shuffle_ps::<0b11_10_11_10>(ef, gh),
        ]
    }
}

/// Lanes in this order, where they are kept; zeros elsewhere.
///
/// # Safety
/// The CPU must have the level's features.
#[inline(always)]
unsafe fn packed(v: I, order: __m256i, kept: __m256i) -> __m256i {
    // SAFETY: as promised by the caller.
    unsafe { _mm256_and_si256(_mm256_permutevar8x32_epi32(v.0, order), kept) }
}

/// Four fields by lanes as rows of records: row r holds in half q the four numbers of lane 4 q + r.
///
/// # Safety
/// The CPU must have the level's features.
#[inline(always)]
unsafe fn rows_of_four([a, b, c, d]: [__m256i; 4]) -> [__m256i; 4] {
    // SAFETY: as promised by the caller.
    unsafe {
        let (ab, cd) = (_mm256_unpacklo_epi32(a, b), _mm256_unpacklo_epi32(c, d));
        let (ef, gh) = (_mm256_unpackhi_epi32(a, b), _mm256_unpackhi_epi32(c, d));
        [
            _mm256_unpacklo_epi64(ab, cd),
            _mm256_unpackhi_epi64(ab, cd),
            _mm256_unpacklo_epi64(ef, gh),
            _mm256_unpackhi_epi64(ef, gh),
        ]
    }
}

/// In half q the pixels at the places of lanes 4 q + r and 4 q + r + 1, two each.
///
/// # Safety
/// The CPU must have the level's features, and 8 bytes must be there at each of those places.
#[inline(always)]
unsafe fn pixel_pairs(from: &[u8], at: &Spilled<8>, r: usize) -> __m256 {
    // SAFETY: as promised by the caller.
    unsafe {
        let v = _mm256_castps128_ps256(two_pairs(from, at.lane(r), at.lane(r + 1)));
        _mm256_insertf128_ps::<1>(v, two_pairs(from, at.lane(r + 4), at.lane(r + 5)))
    }
}

/// Two pixels from each of two places.
///
/// # Safety
/// The CPU must have the level's features, and 8 bytes must be there at both places.
#[inline(always)]
unsafe fn two_pairs(from: &[u8], first: usize, second: usize) -> __m128 {
    // SAFETY: as promised by the caller; these loads need no alignment.
    unsafe {
        let place = |at: usize| from.as_ptr().add(at * 4).cast::<f64>();
        _mm_castpd_ps(_mm_loadh_pd(_mm_load_sd(place(first)), place(second)))
    }
}

/// The records of lanes r, 4 + r, ...
///
/// # Safety
/// As for [`transposed`].
#[inline(always)]
unsafe fn row_of<const STRIDE: usize>(from: *const u8, at: &Spilled<8>, r: usize) -> __m256 {
    // SAFETY: as promised by the caller.
    unsafe {
        let v = _mm256_castps128_ps256(record::<STRIDE>(from, at.lane(r)));
        _mm256_insertf128_ps::<1>(v, record::<STRIDE>(from, at.lane(r + 4)))
    }
}

/// A record.
///
/// # Safety
/// As for [`transposed`].
#[inline(always)]
unsafe fn record<const STRIDE: usize>(from: *const u8, at: usize) -> __m128 {
    // SAFETY: as promised by the caller; the load needs no alignment.
    unsafe { _mm_loadu_ps(from.add(at * STRIDE).cast()) }
}

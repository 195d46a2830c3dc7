//! Whole numbers of the width that a triangle needs: i64 for what lies near a frame, i128 for what lies far off, and
//! numbers without a limit for the rest. One generic algorithm runs on all three and gives the same answer.

use num_bigint::{BigInt, Sign};
use num_integer::Integer;
use std::cmp::Ordering;

/// Exact integer arithmetic. The caller picks a width in which nothing overflows.
pub(crate) trait Wide: Clone + Ord {
    /// `v`, exactly.
    fn from_i64(v: i64) -> Self;
    /// a + b.
    fn plus(&self, b: &Self) -> Self;
    /// a - b.
    fn minus(&self, b: &Self) -> Self;
    /// a * b.
    fn times(&self, b: &Self) -> Self;
    /// a += b, without making a new number.
    fn add(&mut self, b: &Self);
    /// a -= b, without making a new number.
    fn sub(&mut self, b: &Self);
    /// Quotient rounded down, and the remainder in 0..d, for d > 0.
    fn div_rem_floor(&self, d: &Self) -> (Self, Self);
    /// The nearest number in `lo..=hi`.
    fn clamp_i64(&self, lo: i64, hi: i64) -> i64;
    /// Compared with 0.
    fn signum_order(&self) -> Ordering;
    /// The lowest 64 bits of a number that is not negative.
    fn low_u64(&self) -> u64;
    /// a * 2^bits.
    fn shifted_left(&self, bits: u32) -> Self;
}

macro_rules! machine_wide {
    ($int:ty) => {
        impl Wide for $int {
            #[inline]
            fn from_i64(v: i64) -> Self {
                v.into()
            }
            #[inline]
            fn plus(&self, b: &Self) -> Self {
                self + b
            }
            #[inline]
            fn minus(&self, b: &Self) -> Self {
                self - b
            }
            #[inline]
            fn times(&self, b: &Self) -> Self {
                self * b
            }
            #[inline]
            fn add(&mut self, b: &Self) {
                *self += b;
            }
            #[inline]
            fn sub(&mut self, b: &Self) {
                *self -= b;
            }
            #[inline]
            fn div_rem_floor(&self, d: &Self) -> (Self, Self) {
                (self.div_euclid(*d), self.rem_euclid(*d))
            }
            #[inline]
            fn clamp_i64(&self, lo: i64, hi: i64) -> i64 {
                (*self).clamp(lo.into(), hi.into()) as i64
            }
            #[inline]
            fn signum_order(&self) -> Ordering {
                self.cmp(&0)
            }
            #[inline]
            fn low_u64(&self) -> u64 {
                *self as u64
            }
            #[inline]
            fn shifted_left(&self, bits: u32) -> Self {
                self << bits
            }
        }
    };
}

machine_wide!(i64);
machine_wide!(i128);

impl Wide for BigInt {
    fn from_i64(v: i64) -> Self {
        v.into()
    }
    fn plus(&self, b: &Self) -> Self {
        self + b
    }
    fn minus(&self, b: &Self) -> Self {
        self - b
    }
    fn times(&self, b: &Self) -> Self {
        self * b
    }
    fn add(&mut self, b: &Self) {
        *self += b;
    }
    fn sub(&mut self, b: &Self) {
        *self -= b;
    }
    fn div_rem_floor(&self, d: &Self) -> (Self, Self) {
        self.div_mod_floor(d)
    }
    fn clamp_i64(&self, lo: i64, hi: i64) -> i64 {
        match i64::try_from(self) {
            Ok(v) => v.clamp(lo, hi),
            Err(_) if self.sign() == Sign::Minus => lo,
            Err(_) => hi,
        }
    }
    fn signum_order(&self) -> Ordering {
        match self.sign() {
            Sign::Minus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Plus => Ordering::Greater,
        }
    }
    fn low_u64(&self) -> u64 {
        self.iter_u64_digits().next().unwrap_or(0)
    }
    fn shifted_left(&self, bits: u32) -> Self {
        self << bits
    }
}

/// `v` pixels in 1/256 pixel: nearest, ties to even; any finite value.
pub(super) fn snap_big(v: f64) -> BigInt {
    let scaled = v * 256.0;
    if scaled.is_finite() {
        return exact_big(scaled.round_ties_even());
    }
    // 256 v leaves the range of f64 only where v is whole, so nothing is rounded.
    exact_big(v) << 8u32
}

/// A whole finite number, exactly.
fn exact_big(v: f64) -> BigInt {
    let bits = v.abs().to_bits();
    let (exponent, fraction) = ((bits >> 52) as i64, bits & ((1 << 52) - 1));
    let (mantissa, shift) = if exponent == 0 { (0, 0) } else { (fraction | 1 << 52, exponent - 1075) };
    let magnitude = if shift < 0 {
        BigInt::from(mantissa) >> shift.unsigned_abs()
    } else {
        BigInt::from(mantissa) << shift
    };
    if v < 0.0 { -magnitude } else { magnitude }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn snapping_is_to_nearest_with_ties_to_even_at_every_size() {
        for (v, want) in
            [(0.5 / 256.0, 0), (1.5 / 256.0, 2), (-0.5 / 256.0, 0), (-2.5 / 256.0, -2), (1.0, 256)]
        {
            assert_eq!(snap_big(v), BigInt::from(want), "{v}");
        }
        assert_eq!(snap_big(5e-324), BigInt::from(0));
        assert_eq!(snap_big(1e9 + 0.5), BigInt::from(256_000_000_128i64));
        // The largest f64 is (2^53 - 1) 2^971.
        assert_eq!(snap_big(-f64::MAX), -(BigInt::from((1i64 << 53) - 1) << 979u32));
    }

    #[test]
    fn the_three_widths_divide_and_clamp_alike() {
        for (a, d) in [(7i64, 3i64), (-7, 3), (-6, 3), (0, 5), (i64::MIN + 1, 9)] {
            let (q, r) = a.div_rem_floor(&d);
            let wide = i128::from(a).div_rem_floor(&i128::from(d));
            let big = BigInt::from(a).div_rem_floor(&BigInt::from(d));
            assert_eq!((q as i128, r as i128), wide);
            assert_eq!((BigInt::from(q), BigInt::from(r)), big);
            assert_eq!(a.clamp_i64(-3, 4), BigInt::from(a).clamp_i64(-3, 4));
        }
        assert_eq!((BigInt::from(1) << 200u32).clamp_i64(-3, 4), 4);
        assert_eq!((BigInt::from(-1) << 200u32).clamp_i64(-3, 4), -3);
    }
}

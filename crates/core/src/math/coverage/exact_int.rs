//! Integers of the width that a triangle needs: i64 for coordinates near a frame, i128 for far
//! ones, big integers for the rest. One generic algorithm runs on all three and gives equal
//! results.

use super::edge_walk::{EdgeWalk, Walk};
use super::far_edge_walk::FarEdgeWalk;
use crate::math::double_double::{DoubleDouble, sum_and_error};
use num_bigint::{BigInt, Sign};
use num_integer::Integer;
use std::cmp::Ordering;

/// Exact integer arithmetic. The caller picks a width in which nothing overflows.
pub(crate) trait ExactInt: Clone + Ord {
    /// Stepper for an edge between points in this type.
    type Walk: Walk<Self>;
    /// Converts `v` exactly.
    fn from_i64(v: i64) -> Self;
    /// Returns a + b.
    fn plus(&self, b: &Self) -> Self;
    /// Returns a - b.
    fn minus(&self, b: &Self) -> Self;
    /// Returns a * b.
    fn times(&self, b: &Self) -> Self;
    /// Adds b in place.
    fn add(&mut self, b: &Self);
    /// Subtracts b in place.
    fn sub(&mut self, b: &Self);
    /// Returns the quotient rounded down, and the remainder in 0..d, for d > 0.
    fn div_rem_floor(&self, d: &Self) -> (Self, Self);
    /// Returns the nearest number in `lo..=hi`.
    fn clamp_i64(&self, lo: i64, hi: i64) -> i64;
    /// Compares with 0.
    fn signum_order(&self) -> Ordering;
    /// Returns r / d in 0.56 fixed point for 0 <= r < d: less than 2 ulp below the exact value,
    /// never above it.
    fn fraction_56(&self, d: &Self) -> u64;
    /// Numbers of a divisor that save [`ExactInt::div_rem_by`] and [`ExactInt::fraction_56_by`] divisions.
    type Reciprocal;
    /// Returns it for a divisor above 0.
    fn reciprocal(&self) -> Self::Reciprocal;
    /// Returns the result of [`ExactInt::div_rem_floor`].
    fn div_rem_by(&self, d: &Self, _: &Self::Reciprocal) -> (Self, Self) {
        self.div_rem_floor(d)
    }
    /// Returns a number as [`ExactInt::fraction_56`] does, within the same bounds.
    fn fraction_56_by(&self, d: &Self, _: &Self::Reciprocal) -> u64 {
        self.fraction_56(d)
    }
    /// Compares self + steps * step with count * unit, for a difference of the two of at most a few
    /// units and factors below 2^32.
    fn compare_stepped(&self, steps: i64, step: &Self, count: i64, unit: &Self) -> Ordering;
}

/// 1 / d in fixed point, for divisions by multiplication: floor(2^(56 + k) / d), which is at most 2^57,
/// for d of k bits.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reciprocal64 {
    inverse: u64,
    bits: u32,
}

impl Reciprocal64 {
    fn of(d: i64) -> Self {
        let bits = i64::BITS - d.leading_zeros();
        Reciprocal64 { inverse: ((1u128 << (56 + bits)) / d.max(1) as u128) as u64, bits }
    }

    /// Returns quotient and remainder of n / d.
    #[inline]
    fn div_rem(self, n: i64, d: i64) -> (i64, i64) {
        // Its quotient would be too large for the inverse's digits.
        if n < 0 || n >> self.bits.min(55) >> 8 != 0 {
            return (n.div_euclid(d), n.rem_euclid(d));
        }
        // n is below 2^(8 + k): the product is at most n / 2^(56 + k) < 1 too small, and the quotient 1.
        let quotient = ((u128::from(n as u64) * u128::from(self.inverse)) >> (56 + self.bits)) as i64;
        let rest = n - quotient * d;
        if rest >= d { (quotient + 1, rest - d) } else { (quotient, rest) }
    }

    /// Returns r / d in 0.56 fixed point, for 0 <= r < d.
    #[inline]
    fn fraction_56(self, r: i64) -> u64 {
        // r / 2^k < 1 is lost because the inverse is rounded, and less than 1 by the shift.
        ((u128::from(r as u64) * u128::from(self.inverse)) >> self.bits) as u64
    }
}

macro_rules! machine_int {
    ($int:ty, $($reciprocal:tt)*) => {
        impl ExactInt for $int {
            type Walk = EdgeWalk<$int>;
            $($reciprocal)*
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
            fn fraction_56(&self, d: &Self) -> u64 {
                // The 64 leading bits of each; d is rounded up, so that the fraction is not too
                // large.
                let excess_bits = (<$int>::BITS - d.leading_zeros()).saturating_sub(64);
                let (r, d) =
                    ((self >> excess_bits) as u128, (d >> excess_bits) as u128 + u128::from(excess_bits > 0));
                ((r << 56) / d) as u64
            }
            #[inline]
            fn compare_stepped(&self, steps: i64, step: &Self, count: i64, unit: &Self) -> Ordering {
                // The products may wrap; their difference is small again.
                let taken = self.wrapping_add(step.wrapping_mul(<$int>::from(steps)));
                taken.wrapping_sub(unit.wrapping_mul(<$int>::from(count))).cmp(&0)
            }
        }
    };
}

machine_int! { i64,
    type Reciprocal = Reciprocal64;
    fn reciprocal(&self) -> Reciprocal64 {
        Reciprocal64::of(*self)
    }
    #[inline]
    fn div_rem_by(&self, d: &i64, reciprocal: &Reciprocal64) -> (i64, i64) {
        reciprocal.div_rem(*self, *d)
    }
    #[inline]
    fn fraction_56_by(&self, _: &i64, reciprocal: &Reciprocal64) -> u64 {
        reciprocal.fraction_56(*self)
    }
}
machine_int! { i128,
    type Reciprocal = ();
    fn reciprocal(&self) {}
}

impl ExactInt for BigInt {
    type Walk = FarEdgeWalk;
    type Reciprocal = ();
    fn reciprocal(&self) {}
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
    fn fraction_56(&self, d: &Self) -> u64 {
        // Like the machine integers: 126 leading bits, whatever the size.
        let excess_bits = d.bits().saturating_sub(126);
        let narrow = |v: &BigInt| i128::try_from(v >> excess_bits).expect("126 bits are left");
        narrow(self).fraction_56(&(narrow(d) + i128::from(excess_bits > 0)))
    }
    fn compare_stepped(&self, steps: i64, step: &Self, count: i64, unit: &Self) -> Ordering {
        // Digit by digit from the lowest, so that nothing is allocated.
        let mut terms = [(self, 1), (step, steps), (unit, -count)].map(|(number, factor)| {
            let is_negative = number.sign() == Sign::Minus;
            (number.iter_u64_digits(), i128::from(if is_negative { -factor } else { factor }))
        });
        let longest = terms.iter().map(|(digits, _)| digits.len()).max().unwrap_or(0);
        let (mut carry, mut any_digit) = (0i128, 0u64);
        for _ in 0..longest {
            for (digits, factor) in &mut terms {
                carry += i128::from(digits.next().unwrap_or(0)) * *factor;
            }
            any_digit |= carry as u64;
            carry >>= 64;
        }
        // The sum is carry 2^(64 longest) + the lower digits, of which only matters whether they
        // are all 0.
        carry.cmp(&0).then(any_digit.cmp(&0))
    }
}

/// Returns `v` pixels in 1/256 pixel: nearest, ties to even; for any finite value.
pub(super) fn snap_big(v: f64) -> BigInt {
    let scaled = v * 256.0;
    if scaled.is_finite() {
        return exact_big(scaled.round_ties_even());
    }
    // 256 v overflows f64 only where v is an integer, so nothing is rounded.
    exact_big(v) << 8u32
}

/// Returns the integer nearest to 256 times a finite number of two parts, ties to even.
pub(super) fn snap_wide(v: DoubleDouble) -> BigInt {
    let near = snap_big(v.hi);
    // Both rests are exact: that of the first part is 0 unless the second one is below 2^-52.
    let scaled = v.hi * 256.0;
    let rest = if scaled.is_finite() { scaled - scaled.round_ties_even() } else { 0.0 };
    let (sum, error) = sum_and_error(rest, v.lo * 256.0);
    let floor = sum.floor();
    let beyond_half = (sum - floor - 0.5) + error;
    let below: BigInt = near + exact_big(floor);
    match beyond_half {
        d if d > 0.0 || (d == 0.0 && below.is_odd()) => below + 1,
        _ => below,
    }
}

/// Converts an integral finite number exactly.
fn exact_big(v: f64) -> BigInt {
    let (mantissa, exponent) = parts(v);
    let shift = exponent.unsigned_abs();
    // A shift to the right drops only zeros, since the number is an integer.
    if exponent < 0 { BigInt::from(mantissa >> shift.min(63)) } else { BigInt::from(mantissa) << shift }
}

/// Returns the integers (m, e) with v = m 2^e, for finite v; zero gives (0, 0).
pub(crate) fn parts(v: f64) -> (i64, i32) {
    let bits = v.abs().to_bits();
    let (exponent, fraction) = ((bits >> 52) as i32, (bits & ((1 << 52) - 1)) as i64);
    let (mantissa, exponent) = match (exponent, fraction) {
        (0, 0) => (0, 0),
        (0, _) => (fraction, -1074),
        _ => (fraction | 1 << 52, exponent - 1075),
    };
    (if v < 0.0 { -mantissa } else { mantissa }, exponent)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn two_parts_are_snapped_as_their_sum() {
        let snapped = |hi: f64, lo: f64| snap_wide(DoubleDouble { hi, lo });
        // Just below, at and just above a tie of small numbers, where one part rounds to the tie.
        for (lo, want) in [(-1e-20, 2), (0.0, 2), (1e-20, 3)] {
            assert_eq!(snapped(2.5 / 256.0, lo), BigInt::from(want), "{lo}");
            assert_eq!(snapped(-2.5 / 256.0, -lo), BigInt::from(-want), "{lo}");
        }
        let far = |steps: f64| snapped(1e17, steps / 256.0) - BigInt::from(256) * BigInt::from(10i64.pow(17));
        for (steps, want) in [(0.5, 0), (0.75, 1), (1.5, 2), (-0.5, 0), (-0.75, -1), (700.25, 700)] {
            assert_eq!(far(steps), BigInt::from(want), "{steps}");
        }
        let large = 1e300;
        assert_eq!(snapped(large, 1e280), snap_big(large) + snap_big(1e280));
    }

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
    fn parts_make_the_number() {
        for v in [0.0, -0.0, 1.0, -1.5, 5e-324, f64::MIN_POSITIVE, f64::MAX, -0.1] {
            let (m, e) = parts(v);
            // Two steps, so that neither power of two leaves the range.
            assert_eq!(m as f64 * 2f64.powi(e / 2) * 2f64.powi(e - e / 2), v);
        }
    }

    #[test]
    fn fractions_are_at_most_two_ulp_below() {
        for bits in [1u32, 5, 40, 63, 64, 65, 100, 126, 127, 300, 2000] {
            let top = BigInt::from(1) << bits;
            for (r, d) in [(0, 1), (1, 1), (1, 3), (2, 3), (7, 7), (999, 1000)] {
                let (r, d): (BigInt, BigInt) = ((&top * r) / 1001, (&top * d) / 1001 + 1);
                let exact: BigInt = (&r << 56u32) / &d;
                let low = |f: u64| BigInt::from(f) <= exact && exact <= BigInt::from(f) + 1;
                assert!(low(r.fraction_56(&d)), "{bits} {r} {d}");
                if let (Ok(r), Ok(d)) = (i128::try_from(&r), i128::try_from(&d)) {
                    assert!(low(r.fraction_56(&d)), "{bits} {r} {d}");
                }
                if let (Ok(r), Ok(d)) = (i64::try_from(&r), i64::try_from(&d)) {
                    assert_eq!(BigInt::from(r.fraction_56(&d)), exact);
                    assert!(low(r.fraction_56_by(&d, &d.reciprocal())), "{bits} {r} {d}");
                }
            }
        }
    }

    proptest! {
        #[test]
        fn reciprocals_divide_as_divisions_do(
            d in 1i64.., n: i64, d_bits in 0u32..63, n_bits in 0u32..63, near in -2i64..3, factor in 0i64..256,
        ) {
            let d = (d >> d_bits).max(1);
            let reciprocal = d.reciprocal();
            // Numbers of all sizes, and those next to multiples.
            for n in [n >> n_bits, d.checked_mul(factor).unwrap_or(0).saturating_add(near), i64::MAX, i64::MIN + 1] {
                let (q, r) = n.div_rem_floor(&d);
                prop_assert_eq!(n.div_rem_by(&d, &reciprocal), (q, r));
                let (exact, fraction) = (r.fraction_56(&d), r.fraction_56_by(&d, &reciprocal));
                prop_assert!(fraction <= exact && exact - fraction <= 1, "{} of {}: {} and {}", r, d, fraction, exact);
            }
        }

        #[test]
        fn stepped_comparisons_are_those_of_plain_arithmetic(
            unit in 1i64..1 << 40, rest in 0.0..1.0f64, step in 0.0..1.0f64, steps in 0i64..40_000, off in -1i64..=1, shift in 0u32..2000,
        ) {
            let part = |p: f64| (unit as f64 * p) as i64;
            let (rest, step) = (part(rest), part(step));
            let count = (rest + steps * step) / unit + off;
            let want = (rest + steps * step).cmp(&(count * unit));
            prop_assert_eq!(rest.compare_stepped(steps, &step, count, &unit), want);
            let wide = |v: i64| i128::from(v) << 70;
            prop_assert_eq!(wide(rest).compare_stepped(steps, &wide(step), count, &wide(unit)), want);
            let big = |v: i64| -> BigInt { BigInt::from(v) << shift };
            prop_assert_eq!(big(rest).compare_stepped(steps, &big(step), count, &big(unit)), want);
            // One unit more or less decides a tie.
            let more = (big(rest) + 1i64).compare_stepped(steps, &big(step), count, &big(unit));
            let less = (big(rest) - 1i64).compare_stepped(steps, &big(step), count, &big(unit));
            if want == Ordering::Equal {
                prop_assert_eq!((more, less), (Ordering::Greater, Ordering::Less));
            }
        }
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

//! Numbers of two f64, for corners so far from the picture that one f64 has no digits left for a pixel.
//!
//! In: f64. Out: the unevaluated sum of two f64, of about 31 digits; the pipeline asks for it beyond
//! 2^40 pixels only. A number that is not finite stays so. Bits are the same on every machine:
//! the error of a product, which is exact, comes from `libm`'s multiplication and addition in integers.
//!
//! Source: T. J. Dekker, "A floating-point technique for extending the available precision", 1971.
//! Verified by the tests against big integers, and by the reference, which has its own.

use std::ops::{Add, Div, Mul, Sub};

/// Number `hi + lo`, with `hi` the nearest f64.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct DoubleDouble {
    /// The nearest f64.
    pub hi: f64,
    /// The rest.
    pub lo: f64,
}

/// Returns a + b and its exact rounding error.
pub(crate) fn sum_and_error(a: f64, b: f64) -> (f64, f64) {
    let sum = a + b;
    let part = sum - a;
    (sum, (a - (sum - part)) + (b - part))
}

impl DoubleDouble {
    /// Returns the sum of two parts, or the first one if that is not finite.
    fn of_parts(hi: f64, lo: f64) -> Self {
        let (sum, rest) = sum_and_error(hi, lo);
        DoubleDouble { hi: sum, lo: if rest.is_finite() { rest } else { 0.0 } }
    }

    /// Returns the smaller number.
    pub fn min(self, b: Self) -> Self {
        if (b - self).hi < 0.0 { b } else { self }
    }

    /// Returns the larger number.
    pub fn max(self, b: Self) -> Self {
        if (b - self).hi > 0.0 { b } else { self }
    }

    /// Returns whether the number is greater than 0.
    pub fn is_positive(self) -> bool {
        self.hi > 0.0
    }

    /// Returns whether the number is neither infinite nor NaN.
    pub fn is_finite(self) -> bool {
        self.hi.is_finite()
    }
}

impl From<f64> for DoubleDouble {
    fn from(v: f64) -> Self {
        DoubleDouble { hi: v, lo: 0.0 }
    }
}

impl Add for DoubleDouble {
    type Output = Self;

    fn add(self, b: Self) -> Self {
        let (sum, error) = sum_and_error(self.hi, b.hi);
        let (low, low_error) = sum_and_error(self.lo, b.lo);
        let high = DoubleDouble::of_parts(sum, error + low);
        DoubleDouble::of_parts(high.hi, high.lo + low_error)
    }
}

impl Sub for DoubleDouble {
    type Output = Self;

    fn sub(self, b: Self) -> Self {
        self + DoubleDouble { hi: -b.hi, lo: -b.lo }
    }
}

impl Mul for DoubleDouble {
    type Output = Self;

    fn mul(self, b: Self) -> Self {
        let product = self.hi * b.hi;
        let error = libm::fma(self.hi, b.hi, -product);
        DoubleDouble::of_parts(product, error + (self.hi * b.lo + self.lo * b.hi))
    }
}

impl Div for DoubleDouble {
    type Output = Self;

    fn div(self, b: Self) -> Self {
        let first = self.hi / b.hi;
        let rest = self - b * first.into();
        let second = rest.hi / b.hi;
        let rest = rest - b * second.into();
        let quotient = DoubleDouble::of_parts(first, second);
        if quotient.is_finite() {
            DoubleDouble::of_parts(quotient.hi, quotient.lo + rest.hi / b.hi)
        } else {
            first.into()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::DoubleDouble;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    /// Returns the number times 2^600 as an integer, for numbers that have no smaller part.
    fn whole(v: DoubleDouble) -> BigInt {
        let part = |v: f64| {
            let (mantissa, exponent) = crate::math::coverage::exact_int::parts(v);
            BigInt::from(mantissa) << (exponent + 600) as usize
        };
        part(v.hi) + part(v.lo)
    }

    proptest! {
        #[test]
        fn thirty_digits_are_right(a in -1e15..1e15f64, b in -1e3..1e3f64, c in 1.0..1e12f64, d in -1e-3..1e-3f64) {
            let [x, y] = [DoubleDouble::from(a) + d.into(), DoubleDouble::from(b) + (d * 1e-13).into()];
            let near = |found: BigInt, want: BigInt| {
                let off = (&found - &want).magnitude().clone() << 98u32;
                off <= want.magnitude().clone() + 1u32
            };
            prop_assert!(near(whole(x * y) << 600u32, whole(x) * whole(y)));
            prop_assert_eq!(whole(x - x), BigInt::from(0));
            prop_assert!(near(whole(x + x), whole(x) * 2));
            let quotient = x / c.into();
            prop_assert!(near(whole(quotient) * whole(c.into()), whole(x) << 600u32));
        }
    }

    #[test]
    fn infinities_stay() {
        let huge = DoubleDouble::from(1e308);
        assert!(!(huge * huge).is_finite() && !(huge + huge).is_finite());
        assert!(!(huge / 0.0.into()).is_finite() && !(huge / 1e-300.into()).is_finite());
    }
}

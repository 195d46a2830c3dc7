//! `DoubleDouble`: a real number as the unevaluated sum of two f64, about 32 significant digits.
//!
//! The reference computes the geometry (matrices, planes, depths, u and v) in it, so that its own
//! rounding is far below the errors that it measures: a sliver's depth plane or a camera 1e7 units
//! away loses 10 digits and still has 20 left. The results are bit-identical everywhere: + - * /
//! sqrt of f64 only, no FMA.
//!
//! Ends of the range: either both parts are finite, or the number is `hi` alone (an infinity or
//! NaN) with `lo` 0, and each operation returns the f64 result of the `hi`s. No finite result is
//! lost to an intermediate overflow. A product below 1e-289 is that of the `hi`s in f64: its second
//! part would underflow.
//!
//! Source: T. J. Dekker, "A floating-point technique for extending the available precision", 1971;
//! the sum of two numbers with its error after D. E. Knuth, "The Art of Computer Programming" 2,
//! section 4.2.2.

use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// Number `hi + lo`, with `hi` the f64 nearest to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct DoubleDouble {
    hi: f64,
    lo: f64,
}

/// 2^960: the error-free steps below cannot overflow for numbers and products up to this.
const LARGE: f64 = f64::from_bits((1023 + 960) << 52);
/// 2^-960: errors of products below this underflow.
const TINY: f64 = f64::from_bits((1023 - 960) << 52);
/// 2^-128, an exact factor from numbers above [`LARGE`] to safe ones.
const DOWN: f64 = f64::from_bits((1023 - 128) << 52);
/// 2^128, an exact factor from numbers below [`TINY`] to safe ones, and the inverse of [`DOWN`].
const UP: f64 = f64::from_bits((1023 + 128) << 52);

/// Returns a + b and its exact rounding error; the error is 0 if the sum is not finite.
fn sum_and_error(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let b_part = s - a;
    let error = (a - (s - b_part)) + (b - b_part);
    if error.is_finite() {
        return (s, error);
    }
    if !s.is_finite() {
        return (s, 0.0);
    }
    // Near the largest f64 a step overflowed although the sum does not: Dekker's order, the larger
    // first, cannot.
    let (large, small) = if a.abs() >= b.abs() { (a, b) } else { (b, a) };
    (s, small - (s - large))
}

/// Splits a into two halves of at most 26 bits each, for |a| up to [`LARGE`].
fn halves(a: f64) -> (f64, f64) {
    const SPLITTER: f64 = 134_217_729.0; // 2^27 + 1
    let t = SPLITTER * a;
    let high = t - (t - a);
    (high, a - high)
}

/// Returns a * b and its exact rounding error; the error is 0 for a product that is not finite or
/// below [`TINY`].
fn product_and_error(a: f64, b: f64) -> (f64, f64) {
    let p = a * b;
    if !p.is_finite() || p.abs() < TINY {
        return (p, 0.0);
    }
    // Scaled by a power of two where a step below could overflow: the product is finite, so the
    // other factor is not large.
    if a.abs().max(b.abs()).max(p.abs()) > LARGE {
        let (large, other) = if a.abs() >= b.abs() { (a, b) } else { (b, a) };
        let (_, error) = product_and_error(large * DOWN, other);
        return (p, error * UP);
    }
    let ((ah, al), (bh, bl)) = (halves(a), halves(b));
    (p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

impl DoubleDouble {
    /// Zero.
    pub const ZERO: DoubleDouble = DoubleDouble { hi: 0.0, lo: 0.0 };
    /// One.
    pub const ONE: DoubleDouble = DoubleDouble { hi: 1.0, lo: 0.0 };

    /// Converts `x` exactly.
    pub const fn new(x: f64) -> Self {
        DoubleDouble { hi: x, lo: 0.0 }
    }

    /// Returns the normalized sum of any two parts.
    fn of_parts(hi: f64, lo: f64) -> Self {
        if !hi.is_finite() {
            return DoubleDouble { hi, lo: 0.0 };
        }
        let (hi, lo) = sum_and_error(hi, lo);
        DoubleDouble { hi, lo: if hi.is_finite() { lo } else { 0.0 } }
    }

    /// Returns the number times a power of two.
    fn scaled(self, factor: f64) -> Self {
        DoubleDouble::of_parts(self.hi * factor, self.lo * factor)
    }

    /// Returns the nearest f64.
    pub fn to_f64(self) -> f64 {
        self.hi
    }

    /// Returns the two f64 whose exact sum this number is, the larger first.
    pub fn parts(self) -> (f64, f64) {
        (self.hi, self.lo)
    }

    /// Returns whether the number is neither infinite nor NaN.
    pub fn is_finite(self) -> bool {
        self.hi.is_finite()
    }

    /// Returns the absolute value.
    pub fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    /// Returns the square root; 0 for numbers that are not positive, and the number itself for
    /// infinity and NaN.
    pub fn sqrt(self) -> Self {
        if self.hi <= 0.0 {
            return DoubleDouble::ZERO;
        }
        if !self.is_finite() {
            return self;
        }
        if self.hi < TINY {
            let half_way = 2f64.powi(-64);
            return self.scaled(UP).sqrt().scaled(half_way);
        }
        // One step of Newton's method from the f64 root doubles its digits.
        let root = DoubleDouble::new(self.hi.sqrt());
        let half = DoubleDouble::new(0.5);
        (root + self / root) * half
    }

    /// Returns the smaller of two numbers.
    pub fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    /// Returns the larger of two numbers.
    pub fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
}

impl From<f64> for DoubleDouble {
    fn from(x: f64) -> Self {
        DoubleDouble::new(x)
    }
}

impl PartialOrd for DoubleDouble {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match self.hi.partial_cmp(&other.hi)? {
            Ordering::Equal => self.lo.partial_cmp(&other.lo),
            decided => Some(decided),
        }
    }
}

impl Neg for DoubleDouble {
    type Output = DoubleDouble;
    fn neg(self) -> DoubleDouble {
        DoubleDouble { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for DoubleDouble {
    type Output = DoubleDouble;
    fn add(self, b: DoubleDouble) -> DoubleDouble {
        let (s, e) = sum_and_error(self.hi, b.hi);
        let (t, f) = sum_and_error(self.lo, b.lo);
        let first = DoubleDouble::of_parts(s, e + t);
        DoubleDouble::of_parts(first.hi, first.lo + f)
    }
}

impl Sub for DoubleDouble {
    type Output = DoubleDouble;
    fn sub(self, b: DoubleDouble) -> DoubleDouble {
        self + -b
    }
}

impl AddAssign for DoubleDouble {
    fn add_assign(&mut self, b: DoubleDouble) {
        *self = *self + b;
    }
}

impl Mul for DoubleDouble {
    type Output = DoubleDouble;
    fn mul(self, b: DoubleDouble) -> DoubleDouble {
        let (p, e) = product_and_error(self.hi, b.hi);
        DoubleDouble::of_parts(p, e + (self.hi * b.lo + self.lo * b.hi))
    }
}

impl Div for DoubleDouble {
    type Output = DoubleDouble;
    fn div(self, b: DoubleDouble) -> DoubleDouble {
        // Long division, one f64 digit at a time.
        let first = self.hi / b.hi;
        if !first.is_finite() || !b.is_finite() {
            return DoubleDouble::new(first);
        }
        // Near the largest f64 the product of the first digit and b may overflow; near the smallest
        // its error is lost.
        if self.hi.abs() > LARGE {
            return (self.scaled(DOWN) / b).scaled(UP);
        }
        if self.hi.abs() < TINY && self.hi != 0.0 {
            return (self.scaled(UP) / b).scaled(DOWN);
        }
        let rest = self - b * DoubleDouble::new(first);
        let second = rest.hi / b.hi;
        let rest = rest - b * DoubleDouble::new(second);
        let third = rest.hi / b.hi;
        DoubleDouble::of_parts(first, second) + DoubleDouble::new(third)
    }
}

/// Point or direction of three double-double numbers.
pub type DoubleDouble3 = [DoubleDouble; 3];
/// Homogeneous point.
pub type DoubleDouble4 = [DoubleDouble; 4];

/// Converts a vector exactly.
pub fn double_double3(v: glam::DVec3) -> DoubleDouble3 {
    [v.x.into(), v.y.into(), v.z.into()]
}

/// Returns the nearest f64 vector.
pub fn narrow3(v: DoubleDouble3) -> glam::DVec3 {
    glam::DVec3::new(v[0].to_f64(), v[1].to_f64(), v[2].to_f64())
}

/// Returns the dot product a . b.
pub fn dot3(a: DoubleDouble3, b: DoubleDouble3) -> DoubleDouble {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Returns the cross product a x b.
pub fn cross(a: DoubleDouble3, b: DoubleDouble3) -> DoubleDouble3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns the difference a - b.
pub fn sub3(a: DoubleDouble3, b: DoubleDouble3) -> DoubleDouble3 {
    std::array::from_fn(|i| a[i] - b[i])
}

/// Returns v at length 1, or `None` for the zero vector and for one with a component that is not
/// finite.
pub fn unit3(v: DoubleDouble3) -> Option<DoubleDouble3> {
    // Divided by the largest component first, so that no square overflows or underflows.
    let largest = v.iter().fold(DoubleDouble::ZERO, |m, c| m.max(c.abs()));
    if !(largest > DoubleDouble::ZERO && v.iter().all(|c| c.is_finite())) {
        return None;
    }
    let v = v.map(|c| c / largest);
    let length = dot3(v, v).sqrt();
    Some(v.map(|c| c / length))
}

#[cfg(test)]
mod tests {
    use super::*;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    #[test]
    fn keeps_about_32_digits() {
        let third = DoubleDouble::ONE / DoubleDouble::new(3.0);
        let off = third * DoubleDouble::new(3.0) - DoubleDouble::ONE;
        assert!(off.to_f64().abs() < 1e-31, "{off:?}");
        let root = DoubleDouble::new(2.0).sqrt();
        assert!((root * root - DoubleDouble::new(2.0)).to_f64().abs() < 1e-31);
        // (1e16 + 1) - 1e16 loses the 1 in f64, not here.
        assert_eq!((DoubleDouble::new(1e16) + DoubleDouble::ONE - DoubleDouble::new(1e16)).to_f64(), 1.0);
        let tiny = DoubleDouble::new(1e-25);
        assert_eq!((DoubleDouble::ONE + tiny - DoubleDouble::ONE).to_f64(), 1e-25);
    }

    #[test]
    fn products_are_exact_where_two_f64_can_hold_them() {
        let (a, b) = (1.0 + 2f64.powi(-40), 1.0 - 2f64.powi(-41));
        let p = DoubleDouble::new(a) * DoubleDouble::new(b);
        assert_eq!(p.parts(), (1.0 + 2f64.powi(-41), -2f64.powi(-81)));
        assert!(DoubleDouble::new(1e300) * DoubleDouble::new(1e300) > DoubleDouble::new(1e308));
        assert!((DoubleDouble::new(1e300) * DoubleDouble::new(1e7)).is_finite());
    }

    #[test]
    fn order_looks_at_both_parts() {
        let a = DoubleDouble::ONE + DoubleDouble::new(1e-20);
        assert!(a > DoubleDouble::ONE && -a < -DoubleDouble::ONE && a == a);
        assert_eq!(unit3([DoubleDouble::ZERO; 3]), None);
        let u = unit3([DoubleDouble::new(3e200), DoubleDouble::ZERO, DoubleDouble::new(4e200)]).unwrap();
        assert!((u[0] - DoubleDouble::new(3.0) / DoubleDouble::new(5.0)).abs().to_f64() < 1e-31);
    }

    /// Returns x 2^1074, an integer for every finite f64.
    fn exact(x: f64) -> BigInt {
        let (exponent, fraction) = (x.to_bits() >> 52 & 0x7ff, x.to_bits() & ((1 << 52) - 1));
        let magnitude = match exponent {
            0 => BigInt::from(fraction),
            _ => BigInt::from(fraction | 1 << 52) << (exponent - 1),
        };
        if x.is_sign_negative() { -magnitude } else { magnitude }
    }

    fn exact_sum(x: DoubleDouble) -> BigInt {
        exact(x.hi) + exact(x.lo)
    }

    /// Any f64: random bits, both ends of the range, ordinary numbers, infinities and NaN.
    fn extreme() -> impl Strategy<Value = f64> {
        let top = (0u64..64).prop_map(|below| f64::from_bits(f64::MAX.to_bits() - below));
        let bottom = (0u64..64).prop_map(f64::from_bits);
        let magnitude = prop_oneof![
            4 => any::<u64>().prop_map(f64::from_bits),
            2 => top,
            1 => bottom,
            2 => (1.0..2.0f64, 900i32..=1023).prop_map(|(m, e)| m * 2f64.powi(e)),
            1 => Just(2f64.powi(971) * 1.5),
            2 => -10.0..10.0f64,
            1 => prop_oneof![Just(0.0), Just(f64::INFINITY), Just(f64::NAN), Just(f64::MIN_POSITIVE)],
        ];
        (magnitude, any::<bool>()).prop_map(|(v, is_negative)| if is_negative { -v } else { v })
    }

    fn is_canonical(x: DoubleDouble) -> bool {
        if x.hi.is_finite() { x.lo.is_finite() && x.hi + x.lo == x.hi } else { x.lo == 0.0 }
    }

    /// Returns whether both are the same number, or both NaN.
    fn is_same(a: f64, b: f64) -> bool {
        a == b || a.is_nan() && b.is_nan()
    }

    /// Returns whether `x` is within rounding of `plain`. Quotients and roots may lie so near to a
    /// tie that 32 digits do not decide its side, and are rounded twice if they are scaled to
    /// subnormal numbers.
    fn is_beside(x: DoubleDouble, plain: f64) -> bool {
        let off = (x - DoubleDouble::new(plain)).abs().to_f64();
        off <= plain.abs() * 2f64.powi(-53) || plain.abs() < f64::MIN_POSITIVE && off <= 5e-324
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

        #[test]
        fn arithmetic_on_any_f64_is_that_of_f64_with_more_digits(a in extreme(), b in extreme()) {
            let (x, y) = (DoubleDouble::new(a), DoubleDouble::new(b));
            let results = [(x + y, a + b), (x - y, a - b), (x * y, a * b), (x / y, a / b)];
            for (i, (wide, plain)) in results.into_iter().enumerate() {
                prop_assert!(is_canonical(wide), "{i}: {a:e} {b:e} {wide:?}");
                let is_good = is_same(wide.hi, plain) || i == 3 && is_beside(wide, plain);
                prop_assert!(is_good, "{i}: {a:e} {b:e} {wide:?}, not {plain:e}");
            }
            if (x + y).is_finite() && a.is_finite() && b.is_finite() {
                prop_assert_eq!(exact_sum(x + y), exact(a) + exact(b));
            }
            if (x * y).is_finite() && (a * b).abs() > 1e-280 {
                prop_assert_eq!(exact_sum(x * y) << 1074, exact(a) * exact(b));
            }
            let root = x.sqrt();
            prop_assert!(is_canonical(root));
            let plain = if a <= 0.0 { 0.0 } else { a.sqrt() };
            prop_assert!(is_same(root.hi, plain) || is_beside(root, plain), "{a:e} {root:?}");
        }

        #[test]
        fn chains_of_any_f64_end_and_stay_canonical(v in [extreme(), extreme(), extreme(), extreme(), extreme(), extreme()]) {
            let [a, b] = [[v[0], v[1], v[2]], [v[3], v[4], v[5]]].map(|p| p.map(DoubleDouble::new));
            let both = [cross(a, b), sub3(a, b), [dot3(a, b), dot3(a, a), a[0].min(b[1]).max(b[2])]];
            for x in both.into_iter().flatten() {
                prop_assert!(is_canonical(x), "{x:?}");
            }
            if let Some(unit) = unit3(a) {
                prop_assert!((dot3(unit, unit) - DoubleDouble::ONE).abs().to_f64() < 1e-14, "{a:?} {unit:?}");
            } else {
                prop_assert!(v[..3].iter().all(|&c| c == 0.0) || v[..3].iter().any(|c| !c.is_finite()));
            }
        }
    }
}

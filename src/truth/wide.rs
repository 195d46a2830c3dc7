//! `Wide`: a real number held as the sum of two f64, about 32 significant digits.
//!
//! The reference works the geometry (matrices, planes, depths, u and v) in it, so that its own rounding lies far below
//! what it judges: a sliver's depth plane or a camera 1e7 units away loses 10 digits and still has 20 left. The results
//! are bit-identical everywhere: + - * / sqrt of f64 only, no FMA.
//! Source: T. J. Dekker, "A floating-point technique for extending the available precision", 1971; the sum of two
//! numbers with its error after D. E. Knuth, "The Art of Computer Programming" 2, section 4.2.2.

use std::cmp::Ordering;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub};

/// A number as `hi + lo`, with `hi` the f64 nearest to it.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Wide {
    hi: f64,
    lo: f64,
}

/// a + b and the error of that sum, exactly.
fn sum_and_error(a: f64, b: f64) -> (f64, f64) {
    let s = a + b;
    let b_part = s - a;
    (s, (a - (s - b_part)) + (b - b_part))
}

/// a as two halves of at most 26 bits each.
fn halves(a: f64) -> (f64, f64) {
    const SPLITTER: f64 = 134_217_729.0; // 2^27 + 1
    // Above this the product with the splitter would overflow: split the scaled number instead.
    if a.abs() > 1e292 {
        let (high, low) = halves(a * 2f64.powi(-64));
        return (high * 2f64.powi(64), low * 2f64.powi(64));
    }
    let t = SPLITTER * a;
    let high = t - (t - a);
    (high, a - high)
}

/// a * b and the error of that product, exactly (where nothing underflows).
fn product_and_error(a: f64, b: f64) -> (f64, f64) {
    let p = a * b;
    let ((ah, al), (bh, bl)) = (halves(a), halves(b));
    (p, ((ah * bh - p) + ah * bl + al * bh) + al * bl)
}

impl Wide {
    /// 0.
    pub const ZERO: Wide = Wide { hi: 0.0, lo: 0.0 };
    /// 1.
    pub const ONE: Wide = Wide { hi: 1.0, lo: 0.0 };

    /// The number `x`, exactly.
    pub const fn new(x: f64) -> Self {
        Wide { hi: x, lo: 0.0 }
    }

    /// `hi + lo` of any two parts.
    fn of_parts(hi: f64, lo: f64) -> Self {
        if !hi.is_finite() {
            return Wide { hi, lo: 0.0 };
        }
        let (hi, lo) = sum_and_error(hi, lo);
        Wide { hi, lo: if hi.is_finite() { lo } else { 0.0 } }
    }

    /// The nearest f64.
    pub fn to_f64(self) -> f64 {
        self.hi
    }

    /// The two f64 whose exact sum this number is, the larger first.
    pub fn parts(self) -> (f64, f64) {
        (self.hi, self.lo)
    }

    /// Whether it is neither infinite nor NaN.
    pub fn is_finite(self) -> bool {
        self.hi.is_finite()
    }

    /// |self|.
    pub fn abs(self) -> Self {
        if self.hi < 0.0 { -self } else { self }
    }

    /// The square root; 0 for numbers that are not positive.
    pub fn sqrt(self) -> Self {
        if self.hi <= 0.0 {
            return Wide::ZERO;
        }
        // One step of Newton's method from the f64 root doubles its digits.
        let root = Wide::new(self.hi.sqrt());
        let half = Wide::new(0.5);
        (root + self / root) * half
    }

    /// The smaller of two numbers.
    pub fn min(self, other: Self) -> Self {
        if other < self { other } else { self }
    }

    /// The larger of two numbers.
    pub fn max(self, other: Self) -> Self {
        if other > self { other } else { self }
    }
}

impl From<f64> for Wide {
    fn from(x: f64) -> Self {
        Wide::new(x)
    }
}

impl PartialOrd for Wide {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        match self.hi.partial_cmp(&other.hi)? {
            Ordering::Equal => self.lo.partial_cmp(&other.lo),
            decided => Some(decided),
        }
    }
}

impl Neg for Wide {
    type Output = Wide;
    fn neg(self) -> Wide {
        Wide { hi: -self.hi, lo: -self.lo }
    }
}

impl Add for Wide {
    type Output = Wide;
    fn add(self, b: Wide) -> Wide {
        let (s, e) = sum_and_error(self.hi, b.hi);
        let (t, f) = sum_and_error(self.lo, b.lo);
        let first = Wide::of_parts(s, e + t);
        Wide::of_parts(first.hi, first.lo + f)
    }
}

impl Sub for Wide {
    type Output = Wide;
    fn sub(self, b: Wide) -> Wide {
        self + -b
    }
}

impl AddAssign for Wide {
    fn add_assign(&mut self, b: Wide) {
        *self = *self + b;
    }
}

impl Mul for Wide {
    type Output = Wide;
    fn mul(self, b: Wide) -> Wide {
        let (p, e) = product_and_error(self.hi, b.hi);
        Wide::of_parts(p, e + (self.hi * b.lo + self.lo * b.hi))
    }
}

impl Div for Wide {
    type Output = Wide;
    fn div(self, b: Wide) -> Wide {
        // Long division, one f64 digit at a time.
        let first = self.hi / b.hi;
        if !first.is_finite() {
            return Wide::new(first);
        }
        let rest = self - b * Wide::new(first);
        let second = rest.hi / b.hi;
        let rest = rest - b * Wide::new(second);
        let third = rest.hi / b.hi;
        Wide::of_parts(first, second) + Wide::new(third)
    }
}

/// A point or direction of three wide numbers.
pub type Wide3 = [Wide; 3];
/// A homogeneous point.
pub type Wide4 = [Wide; 4];

/// The wide copy of a vector.
pub fn wide3(v: glam::DVec3) -> Wide3 {
    [v.x.into(), v.y.into(), v.z.into()]
}

/// The nearest f64 vector.
pub fn narrow3(v: Wide3) -> glam::DVec3 {
    glam::DVec3::new(v[0].to_f64(), v[1].to_f64(), v[2].to_f64())
}

/// a . b.
pub fn dot3(a: Wide3, b: Wide3) -> Wide {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// a x b.
pub fn cross(a: Wide3, b: Wide3) -> Wide3 {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a - b.
pub fn sub3(a: Wide3, b: Wide3) -> Wide3 {
    std::array::from_fn(|i| a[i] - b[i])
}

/// v at length 1, or `None` for the zero vector.
pub fn unit3(v: Wide3) -> Option<Wide3> {
    // By the largest part first, so that no square overflows or vanishes.
    let largest = v.iter().fold(Wide::ZERO, |m, c| m.max(c.abs()));
    if !(largest > Wide::ZERO && largest.is_finite()) {
        return None;
    }
    let v = v.map(|c| c / largest);
    let length = dot3(v, v).sqrt();
    Some(v.map(|c| c / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keeps_about_32_digits() {
        let third = Wide::ONE / Wide::new(3.0);
        let off = third * Wide::new(3.0) - Wide::ONE;
        assert!(off.to_f64().abs() < 1e-31, "{off:?}");
        let root = Wide::new(2.0).sqrt();
        assert!((root * root - Wide::new(2.0)).to_f64().abs() < 1e-31);
        // (1e16 + 1) - 1e16 is lost in f64, not here.
        assert_eq!((Wide::new(1e16) + Wide::ONE - Wide::new(1e16)).to_f64(), 1.0);
        let tiny = Wide::new(1e-25);
        assert_eq!((Wide::ONE + tiny - Wide::ONE).to_f64(), 1e-25);
    }

    #[test]
    fn products_are_exact_where_two_f64_can_hold_them() {
        let (a, b) = (1.0 + 2f64.powi(-40), 1.0 - 2f64.powi(-41));
        let p = Wide::new(a) * Wide::new(b);
        assert_eq!(p.parts(), (1.0 + 2f64.powi(-41), -2f64.powi(-81)));
        assert!(Wide::new(1e300) * Wide::new(1e300) > Wide::new(1e308));
        assert!((Wide::new(1e300) * Wide::new(1e7)).is_finite());
    }

    #[test]
    fn order_looks_at_both_parts() {
        let a = Wide::ONE + Wide::new(1e-20);
        assert!(a > Wide::ONE && -a < -Wide::ONE && a == a);
        assert_eq!(unit3([Wide::ZERO; 3]), None);
        let u = unit3([Wide::new(3e200), Wide::ZERO, Wide::new(4e200)]).unwrap();
        assert!((u[0] - Wide::new(3.0) / Wide::new(5.0)).abs().to_f64() < 1e-31);
    }
}

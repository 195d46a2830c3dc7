//! The rectangle about a segment, placed near the frame for ends of any size.
//!
//! With c the frame's centre: u the unit vector along the segment, n across it, h = (c - p0) . n
//! the signed distance of c from the line, s0 = (p0 - c) . u and s1 = (p1 - c) . u the ends along
//! it. Near the frame f64 is accurate enough for the products; far away they would cancel, so they
//! are computed in integers and each result is rounded once.

use crate::math::coverage::PixelRect;
use crate::math::coverage::exact_int::parts;
use num_bigint::{BigInt, Sign};

/// Largest coordinate that is placed in f64, where the products are off by less than 1e-9. Larger
/// ones are placed in integers.
const NEAR: f64 = 1e6;

/// The visible part of the rectangle, in pixels relative to the frame's centre.
pub(super) struct SegmentRect {
    pub centre: [f64; 2],
    pub u: [f64; 2],
    pub h: f64,
    pub s: [f64; 2],
}

impl SegmentRect {
    /// Returns `None` if nothing is visible: no length, not finite, or too far from the frame.
    pub(super) fn new(p0: [f64; 2], p1: [f64; 2], clip: PixelRect) -> Option<Self> {
        let numbers = [p0, p1];
        if numbers.iter().flatten().any(|v| !v.is_finite()) || p0 == p1 || clip.is_empty() {
            return None;
        }
        let (w, h) = (f64::from(clip.x1) - f64::from(clip.x0), f64::from(clip.y1) - f64::from(clip.y0));
        let centre = [f64::from(clip.x0) + (w - 1.0) / 2.0, f64::from(clip.y0) + (h - 1.0) / 2.0];
        let extent = numbers.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
        let mut rect = if extent < NEAR { near(p0, p1, centre) } else { far(p0, p1, centre) };
        // No point of a visible pixel's square is farther from the centre.
        let reach = (w + h) / 2.0 + 2.0;
        if rect.h.abs() > reach {
            return None;
        }
        rect.s = rect.s.map(|s| s.clamp(-reach, reach));
        (rect.s[0] < rect.s[1]).then_some(rect)
    }

    /// Returns the four corners in pixels, in order around the rectangle.
    pub(super) fn corners(&self) -> [[f64; 2]; 4] {
        let SegmentRect { centre, u, h, s } = self;
        let n = across(*u);
        let at = |s: f64, side: f64| [0, 1].map(|i| centre[i] + s * u[i] + (side - h) * n[i]);
        [at(s[0], -0.5), at(s[1], -0.5), at(s[1], 0.5), at(s[0], 0.5)]
    }
}

/// Returns `u` rotated by a quarter turn.
fn across(u: [f64; 2]) -> [f64; 2] {
    [-u[1], u[0]]
}

/// Places a segment in f64; see [`NEAR`].
fn near(p0: [f64; 2], p1: [f64; 2], centre: [f64; 2]) -> SegmentRect {
    let d = [p1[0] - p0[0], p1[1] - p0[1]];
    // Scaled first, so that the squares of very small numbers do not underflow.
    let largest = d[0].abs().max(d[1].abs());
    let d = d.map(|v| v / largest);
    let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
    let u = d.map(|v| v / length);
    let n = across(u);
    let dot = |p: [f64; 2], v: [f64; 2]| (p[0] - centre[0]) * v[0] + (p[1] - centre[1]) * v[1];
    SegmentRect { centre, u, h: -dot(p0, n), s: [dot(p0, u), dot(p1, u)] }
}

/// Places a segment in integers; see [`NEAR`].
fn far(p0: [f64; 2], p1: [f64; 2], centre: [f64; 2]) -> SegmentRect {
    // All in units of a power of two in which every coordinate is an integer.
    let numbers = [p0, p1, centre];
    let unit = numbers.iter().flatten().map(|&v| parts(v).1).fold(0, i32::min);
    let integer = |v: f64| {
        let (mantissa, exponent) = parts(v);
        BigInt::from(mantissa) << (exponent - unit).unsigned_abs()
    };
    let [p0, p1, c] = numbers.map(|p| p.map(integer));
    let minus = |a: &[BigInt; 2], b: &[BigInt; 2]| [&a[0] - &b[0], &a[1] - &b[1]];
    let dot = |a: &[BigInt; 2], b: &[BigInt; 2]| &a[0] * &b[0] + &a[1] * &b[1];
    let d = minus(&p1, &p0);
    let across = [-&d[1], d[0].clone()];
    let length_squared = dot(&d, &d);
    // v / |d| as the signed root of v^2 / d^2; the result is in pixels if v is a product of two
    // lengths.
    let per_length = |v: &BigInt, unit: i32| {
        let magnitude = ratio(&(v * v), &length_squared, 2 * i64::from(unit)).sqrt();
        if v.sign() == Sign::Minus { -magnitude } else { magnitude }
    };
    SegmentRect {
        centre,
        u: [0, 1].map(|i| per_length(&d[i], 0)),
        h: per_length(&dot(&minus(&c, &p0), &across), unit),
        s: [&p0, &p1].map(|p| per_length(&dot(&minus(p, &c), &d), unit)),
    }
}

/// Returns a / b * 2^exponent for a >= 0 and b > 0, within 2 ulp. Overflow gives infinity,
/// underflow 0.
fn ratio(a: &BigInt, b: &BigInt, exponent: i64) -> f64 {
    // The quotient has 64 or 65 bits.
    let shift = b.bits() as i64 + 64 - a.bits() as i64;
    let quotient = if shift >= 0 { (a << shift as u64) / b } else { a / (b << shift.unsigned_abs()) };
    let quotient = u128::try_from(quotient).expect("65 bits") as f64;
    let power = (exponent - shift).clamp(-4000, 4000) as i32;
    // In steps, so that no power overflows before the product does.
    [power / 4, power / 4, power / 4, power - power / 4 * 3].iter().fold(quotient, |v, &e| v * 2f64.powi(e))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_of_any_size() {
        let big = |v: u64, bits: u32| BigInt::from(v) << bits;
        assert_eq!(ratio(&big(1, 0), &big(3, 0), 0), 1.0 / 3.0);
        assert_eq!(ratio(&big(22, 4000), &big(7, 4000), 0), 22.0 / 7.0);
        assert_eq!(ratio(&big(22, 0), &big(7, 4000), 4000), 22.0 / 7.0);
        assert_eq!(ratio(&big(0, 0), &big(7, 0), 10), 0.0);
        assert_eq!(ratio(&big(1, 9000), &big(1, 0), 0), f64::INFINITY);
        assert_eq!(ratio(&big(1, 0), &big(1, 9000), 0), 0.0);
    }

    #[test]
    fn far_and_near_agree_where_both_are_good() {
        let clip = PixelRect { x0: 0, y0: 0, x1: 640, y1: 480 };
        for i in 0..200 {
            let v = |k: i32| f64::from((i * 7919 + k * 104_729) % 20_011) / 17.0 - 300.0;
            let (p0, p1) = ([v(1), v(2)], [v(3), v(4)]);
            let centre = SegmentRect::new([0.0, 0.0], [1.0, 1.0], clip).unwrap().centre;
            let (a, b) = (near(p0, p1, centre), far(p0, p1, centre));
            let pairs = [(a.h, b.h), (a.u[0], b.u[0]), (a.u[1], b.u[1]), (a.s[0], b.s[0]), (a.s[1], b.s[1])];
            assert!(pairs.iter().all(|(x, y)| (x - y).abs() < 1e-10), "{pairs:?}");
        }
    }
}

//! Coverage of a triangle: point-in-triangle tests in integers of 1/256 pixel.
//!
//! In: corners in screen pixels, y down, pixel (i, j) with its centre at (i+.5, j+.5). Out: whether
//! a pixel's centre is covered.
//!
//! Each coordinate is snapped to the nearest 1/256 (ties to even). A centre is covered if it lies
//! strictly inside, or on a top or left edge. Each pixel is tested on its own with integers of
//! sufficient width; nothing is incremental.

use super::double_double::DoubleDouble;
use num_bigint::{BigInt, Sign};
use std::cmp::Ordering;

/// Result of a coverage test.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Coverage {
    /// Outside.
    No,
    /// Borderline: both sides are accepted.
    Maybe,
    /// Inside.
    Yes,
}

/// Triangle with snapped corners.
#[derive(Clone, Debug)]
pub struct Outline {
    corners: [[BigInt; 2]; 3],
    /// Corners in i128 if they are small enough that products of differences fit 128 bits.
    narrow: Option<[[i128; 2]; 3]>,
    area2: BigInt,
}

/// Returns the mantissa and exponent with x = mantissa * 2^exponent.
fn decompose(x: f64) -> (BigInt, i64) {
    let bits = x.to_bits();
    let exponent = ((bits >> 52) & 0x7ff) as i64;
    let fraction = bits & ((1 << 52) - 1);
    let (mantissa, exponent) =
        if exponent == 0 { (fraction, -1074) } else { (fraction | 1 << 52, exponent - 1075) };
    let mantissa = BigInt::from(mantissa);
    (if x < 0.0 { -mantissa } else { mantissa }, exponent)
}

/// Returns the integer nearest to `256 x`, ties to even. `x` is finite.
pub fn snap(x: DoubleDouble) -> BigInt {
    let (hi, lo) = x.parts();
    let ((m_hi, e_hi), (m_lo, e_lo)) = (decompose(hi), decompose(lo));
    let (e_hi, e_lo) = (e_hi + 8, e_lo + 8);
    // Both parts at the smaller of the two exponents, then one rounded division.
    let e = if lo == 0.0 { e_hi } else { e_hi.min(e_lo) };
    let mut sum = m_hi << (e_hi - e) as usize;
    if lo != 0.0 {
        sum += m_lo << (e_lo - e) as usize;
    }
    if e >= 0 {
        return sum << e as usize;
    }
    let shift = (-e) as usize;
    let floor: BigInt = &sum >> shift;
    let rest = sum - (&floor << shift);
    let half = BigInt::from(1) << (shift - 1);
    match rest.cmp(&half) {
        Ordering::Less => floor,
        Ordering::Greater => floor + 1,
        Ordering::Equal if floor.bit(0) => floor + 1,
        Ordering::Equal => floor,
    }
}

/// Returns the distance of `256 x` from the nearest tie between two integers.
pub fn distance_to_tie(x: DoubleDouble) -> f64 {
    // x - floor(x + 1/2) is exact: the tie lies half a unit from that integer.
    let t = x * DoubleDouble::new(256.0);
    let (hi, lo) = t.parts();
    if hi.abs() >= 2f64.powi(52) {
        return if hi.abs() >= 2f64.powi(54) { 0.0 } else { 0.5 };
    }
    let nearest = (hi + 0.5).floor();
    let off = (DoubleDouble::new(hi) - DoubleDouble::new(nearest) + DoubleDouble::new(lo)).to_f64();
    (0.5 - off.abs()).abs()
}

impl Outline {
    /// Snaps three corners; `None` if a coordinate is not finite.
    pub fn new(screen: [[DoubleDouble; 2]; 3]) -> Option<Outline> {
        if screen.iter().flatten().any(|c| !c.is_finite()) {
            return None;
        }
        Some(Self::from_snapped(screen.map(|p| p.map(snap))))
    }

    /// Creates the triangle of corners in 1/256 pixel.
    pub fn from_snapped(corners: [[BigInt; 2]; 3]) -> Outline {
        let limit = BigInt::from(1i64 << 60);
        let fits = corners.iter().flatten().all(|c| c.magnitude() <= limit.magnitude());
        let narrow = fits.then(|| {
            corners.each_ref().map(|p| {
                p.each_ref().map(|c| i128::try_from(c).expect("at most 2^60 in magnitude fits 128 bits"))
            })
        });
        let [a, b, c] = &corners;
        let area2 = (&b[0] - &a[0]) * (&c[1] - &a[1]) - (&c[0] - &a[0]) * (&b[1] - &a[1]);
        Outline { corners, narrow, area2 }
    }

    /// Returns the sign of (x1-x0)(y2-y0) - (x2-x0)(y1-y0), y down: `Less` is counter-clockwise on
    /// the screen.
    pub fn turn(&self) -> Ordering {
        match self.area2.sign() {
            Sign::Minus => Ordering::Less,
            Sign::NoSign => Ordering::Equal,
            Sign::Plus => Ordering::Greater,
        }
    }

    /// Returns whether the centre of pixel (x, y) is covered.
    pub fn covers(&self, x: i64, y: i64) -> bool {
        let turn = self.turn();
        if turn == Ordering::Equal {
            return false;
        }
        // Edges in the order that has the inside to the right: clockwise on the screen.
        let order = if turn == Ordering::Greater { [0, 1, 2] } else { [0, 2, 1] };
        let center = [256 * x as i128 + 128, 256 * y as i128 + 128];
        (0..3).all(|i| {
            let (from, to) = (order[i], order[(i + 1) % 3]);
            let (side, dx, dy) = match &self.narrow {
                Some(c) => edge_narrow(c[from], c[to], center),
                None => edge_big(&self.corners[from], &self.corners[to], center),
            };
            // With the inside to the right, an edge that goes up is a left edge, and a horizontal
            // one that goes right is a top edge.
            let is_top_left = dy == Ordering::Less || (dy == Ordering::Equal && dx == Ordering::Greater);
            side == Ordering::Greater || (side == Ordering::Equal && is_top_left)
        })
    }

    /// Returns for each edge from corner i to the next the centre's distance from its line in
    /// pixels (positive inside), and the position of its foot along the edge (0 at the first
    /// corner, 1 at the next). In f64, for margins only.
    pub fn distances(&self, x: i64, y: i64) -> [(f64, f64); 3] {
        let sign = if self.turn() == Ordering::Less { -1.0 } else { 1.0 };
        let center = [x as f64 + 0.5, y as f64 + 0.5];
        std::array::from_fn(|i| {
            let (a, b) = (&self.corners[i], &self.corners[(i + 1) % 3]);
            let to_pixels = |v: BigInt| big_to_f64(&v) / 256.0;
            let d = [to_pixels(&b[0] - &a[0]), to_pixels(&b[1] - &a[1])];
            let q = [
                to_pixels(BigInt::from((center[0] * 256.0) as i128) - &a[0]),
                to_pixels(BigInt::from((center[1] * 256.0) as i128) - &a[1]),
            ];
            let length = (d[0] * d[0] + d[1] * d[1]).sqrt();
            if length == 0.0 {
                return (0.0, 0.0);
            }
            let distance = sign * (d[0] * q[1] - d[1] * q[0]) / length;
            (distance, (d[0] * q[0] + d[1] * q[1]) / (length * length))
        })
    }
}

fn edge_narrow(a: [i128; 2], b: [i128; 2], p: [i128; 2]) -> (Ordering, Ordering, Ordering) {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let side = dx * (p[1] - a[1]) - dy * (p[0] - a[0]);
    (side.cmp(&0), dx.cmp(&0), dy.cmp(&0))
}

fn edge_big(a: &[BigInt; 2], b: &[BigInt; 2], p: [i128; 2]) -> (Ordering, Ordering, Ordering) {
    let zero = BigInt::from(0);
    let (dx, dy) = (&b[0] - &a[0], &b[1] - &a[1]);
    let side = &dx * (BigInt::from(p[1]) - &a[1]) - &dy * (BigInt::from(p[0]) - &a[0]);
    (side.cmp(&zero), dx.cmp(&zero), dy.cmp(&zero))
}

/// Converts the value with about 53 bits; too large values become infinite.
fn big_to_f64(v: &BigInt) -> f64 {
    let bits = v.bits();
    if bits <= 100 {
        return i128::try_from(v).expect("100 bits fit") as f64;
    }
    let drop = bits - 64;
    let top = i128::try_from(v >> drop as usize).expect("64 bits fit") as f64;
    if drop > 1000 { top * f64::INFINITY } else { top * 2f64.powi(drop as i32) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn outline(points: [[f64; 2]; 3]) -> Outline {
        Outline::new(points.map(|p| p.map(DoubleDouble::new))).unwrap()
    }

    #[test]
    fn snapping_is_to_the_nearest_with_ties_to_even() {
        let unit = 1.0 / 256.0;
        for (x, expected) in [
            (0.5 * unit, 0i64),
            (1.5 * unit, 2),
            (-0.5 * unit, 0),
            (-1.5 * unit, -2),
            (2.4999 * unit, 2),
            (-2.50001 * unit, -3),
            (1e9, 256_000_000_000),
        ] {
            assert_eq!(snap(DoubleDouble::new(x)), BigInt::from(expected), "{x}");
        }
        let past_the_tie = DoubleDouble::new(0.5 * unit) + DoubleDouble::new(1e-30);
        assert_eq!(snap(past_the_tie), BigInt::from(1));
        assert_eq!(snap(DoubleDouble::new(1e30)), BigInt::from(256) * BigInt::from(1e30 as i128));
        assert!(
            distance_to_tie(DoubleDouble::new(0.5 * unit)) == 0.0
                && distance_to_tie(DoubleDouble::new(3.0)) == 0.5
        );
    }

    /// Two triangles of a square of 2 x 2 pixels whose corners are pixel centres: the top and left
    /// edges are covered, the others not.
    #[test]
    fn top_and_left_edges_are_in_and_the_seam_is_lit_once() {
        let [a, b, c, d] = [[1.5, 1.5], [3.5, 1.5], [3.5, 3.5], [1.5, 3.5]];
        for (first, second) in [([a, b, c], [a, c, d]), ([c, b, a], [d, c, a]), ([b, c, d], [b, d, a])] {
            let (first, second) = (outline(first), outline(second));
            for y in 0..5 {
                for x in 0..5 {
                    let hits = u32::from(first.covers(x, y)) + u32::from(second.covers(x, y));
                    let inside = (1..3).contains(&x) && (1..3).contains(&y);
                    assert_eq!(hits, u32::from(inside), "({x},{y})");
                }
            }
        }
    }

    #[test]
    fn wide_and_narrow_decide_alike_and_huge_corners_work() {
        let narrow = outline([[0.3, 0.2], [9.7, 3.1], [2.2, 8.9]]);
        let mut big = narrow.clone();
        big.narrow = None;
        for (x, y) in (0..10).flat_map(|y| (0..10).map(move |x| (x, y))) {
            assert_eq!(narrow.covers(x, y), big.covers(x, y));
        }
        let half_plane = outline([[-1e30, -1e30], [1e30, 1e30], [-1e30, 1e30]]);
        assert!(half_plane.covers(3, 5) && !half_plane.covers(5, 3));
        // The edge x = y passes through the centres: it is a right edge here, so they are not
        // covered.
        assert!(!half_plane.covers(4, 4));
        assert_eq!(outline([[0.0, 0.0], [4.0, 4.0], [8.0, 8.0]]).turn(), Ordering::Equal);
        assert_eq!(outline([[0.0, 0.0], [0.0, 8.0], [8.0, 0.0]]).turn(), Ordering::Less);
    }

    #[test]
    fn distances_are_in_pixels_and_positive_inside() {
        let o = outline([[0.0, 0.0], [8.0, 0.0], [0.0, 8.0]]);
        let d = o.distances(1, 2);
        assert_eq!(d[0], (2.5, 1.5 / 8.0));
        assert_eq!(d[2].0, 1.5);
        assert!((d[1].0 - 4.0 / 2f64.sqrt()).abs() < 1e-12);
    }
}

//! Lines of any width with round ends, with exact coverage.
//!
//! The exact answer: pixel (i,j) is lit when its centre (i + 1/2, j + 1/2) is nearer than w/2 to
//! the segment from a to b. With d = b - a that is so when the centre p is in one of the discs of
//! radius w/2 about a and b, or beside the segment, 0 <= (p - a).d <= d.d, and |(p - a) x d| < w/2
//! |d|. Of the two long sides the upper one belongs to the line, the left one of an upright line, as
//! of [`fill`](super::fill): so a line of width 1 between two rows of centres is one pixel wide. The
//! ends' order does not matter. Every f64 is an integer times a power of two, so each comparison
//! can be made in integers. It is made in f64 wherever rounding cannot change the result.

mod near_stroke;

use super::band::{Band, on_all_rows};
use super::blend::Paint;
use super::disc::Disc;
use super::row_ends::clipped;
use super::row_search::{both, half_row, rows_between, sign_of_sum};
use super::{Blend, DrawError};
use crate::math::coverage::exact_int::parts;
use crate::memory::{Rgba, VideoMemory};
use near_stroke::NearStroke;
use num_bigint::BigInt;
use std::cell::OnceCell;
use std::cmp::Ordering;
use std::ops::Range;

/// Lights the pixels whose centres are nearer than half of `width` to the segment from `p0` to
/// `p1`, or on its upper or left side, all in pixels: a line with round ends.
///
/// The cost is that of the visible rows and pixels. Numbers that are not finite draw nothing. A
/// negative width is an error.
pub fn wide_line(
    memory: &mut VideoMemory,
    p0: [f64; 2],
    p1: [f64; 2],
    width: f64,
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    on_all_rows(memory, |band| wide_line_on(band, p0, p1, width, color, blend))
}

/// Does what [`wide_line`] does within a band.
pub(super) fn wide_line_on(
    band: &mut Band<'_>,
    p0: [f64; 2],
    p1: [f64; 2],
    width: f64,
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    if width < 0.0 {
        return Err(DrawError::NegativeWidth { w: width.into() });
    }
    let Some(paint) = Paint::new(color, blend) else { return Ok(()) };
    if !p0.iter().chain(&p1).chain([&width]).all(|v| v.is_finite()) {
        return Ok(());
    }
    let clip = band.clip();
    let stroke = Stroke::new(p0, p1, width);
    band.paint_rows(paint, stroke.rows(clip.y0..clip.y1), |y| stroke.row(y, clip.x0..clip.x1));
    Ok(())
}

/// The points nearer than half a width to a segment, with exact tests for pixel centres.
pub(super) struct Stroke {
    a: [f64; 2],
    b: [f64; 2],
    width: f64,
    discs: [Disc; 2],
    near: Option<NearStroke>,
    exact: OnceCell<ExactStroke>,
}

/// A stroke in integers, in units of a power of two.
struct ExactStroke {
    a: [BigInt; 2],
    b: [BigInt; 2],
    d: [BigInt; 2],
    /// w^2 d.d, which is 4 times the square of w/2 |d|.
    limit: BigInt,
    /// Half a pixel is 2^half_bits units.
    half_bits: u32,
}

impl Stroke {
    /// Creates the stroke of a segment; numbers are finite and the width is not negative.
    pub fn new(a: [f64; 2], b: [f64; 2], width: f64) -> Self {
        // Of the least of all numbers the half is 0, and no pixel's centre tells them apart: it
        // is a multiple of 1/2.
        let discs = [a, b].map(|centre| Disc::new(centre, width / 2.0));
        Stroke { a, b, width, discs, near: NearStroke::new(a, b, width / 2.0), exact: OnceCell::new() }
    }

    /// Returns the rows of `ys` that it may touch.
    pub fn rows(&self, ys: Range<i32>) -> Range<i32> {
        let ([_, y0], [_, y1], half) = (self.a, self.b, self.width / 2.0);
        rows_between(y0.min(y1) - half, y0.max(y1) + half, y0.abs().max(y1.abs()) + half, ys)
    }

    /// Returns its pixels among the columns `xs` of row `y`.
    #[inline]
    pub fn row(&self, y: i32, xs: Range<i32>) -> Range<i32> {
        match self.near.as_ref().and_then(|near| near.row(y)) {
            Some(run) => clipped(run, xs),
            None => self.plain_row(y, xs),
        }
    }

    /// Returns its pixels among the columns `xs` of row `y`: those of the two discs and of the part
    /// between them. The figure is convex, so together they are one run.
    #[cold]
    fn plain_row(&self, y: i32, xs: Range<i32>) -> Range<i32> {
        let [a, b] = self.discs.each_ref().map(|disc| disc.plain_row(y, xs.clone()));
        let parts = [a, b, self.side(y, xs)];
        let parts = parts.into_iter().filter(|part| !part.is_empty());
        parts.reduce(|a, b| a.start.min(b.start)..a.end.max(b.end)).unwrap_or(0..0)
    }

    /// Returns the pixels of row `y` beside the segment. Each of the four tests changes once along
    /// the row.
    fn side(&self, y: i32, xs: Range<i32>) -> Range<i32> {
        let [dx, dy] = [self.b[0] - self.a[0], self.b[1] - self.a[1]];
        if self.width == 0.0 || (dx == 0.0 && dy == 0.0 && self.a == self.b) {
            return 0..0;
        }
        let from_a = f64::from(y) + 0.5 - self.a[1];
        let from_b = f64::from(y) + 0.5 - self.b[1];
        // Where (p - a).d = 0, (p - b).d = 0 and (p - a) x d = +-w/2 |d|.
        let foot_a = self.a[0] - from_a * dy / dx - 0.5;
        let foot_b = self.b[0] - from_b * dy / dx - 0.5;
        let middle = self.a[0] + from_a * dx / dy - 0.5;
        let half = self.width / 2.0 * (dx.hypot(dy) / dy.abs());
        let rises = self.b[0] > self.a[0];
        let falls_down = self.b[1] > self.a[1];
        let after_a = half_row(xs.clone(), foot_a, rises, |x| self.along(false, x, y) != Ordering::Less);
        let before_b = half_row(xs.clone(), foot_b, !rises, |x| self.along(true, x, y) != Ordering::Greater);
        let side = |is_left: bool| {
            // The cross product grows with x where the segment goes down.
            let guess = if falls_down == is_left { middle + half } else { middle - half };
            half_row(xs.clone(), guess, falls_down != is_left, |x| self.is_beside(is_left, x, y))
        };
        both(&both(&after_a, &before_b), &both(&side(true), &side(false)))
    }

    /// Returns the sign of (p - e).d for the centre p of pixel (x, y), where e is the end b, or a.
    fn along(&self, from_b: bool, x: i32, y: i32) -> Ordering {
        let end = if from_b { self.b } else { self.a };
        let d = [self.b[0] - self.a[0], self.b[1] - self.a[1]];
        let p = [f64::from(x) + 0.5 - end[0], f64::from(y) + 0.5 - end[1]];
        sign_of_sum([p[0], d[0]], [p[1], d[1]]).unwrap_or_else(|| {
            let exact = self.exact();
            let [px, py] = exact.centre(x, y, if from_b { &exact.b } else { &exact.a });
            (px * &exact.d[0] + py * &exact.d[1]).cmp(&BigInt::ZERO)
        })
    }

    /// Returns whether (p - a) x d < w/2 |d|, or of its negative for the other side; also if they are
    /// equal, where that side is the upper or left one.
    fn is_beside(&self, is_left: bool, x: i32, y: i32) -> bool {
        let sign = if is_left { 1.0 } else { -1.0 };
        let d = [self.b[0] - self.a[0], self.b[1] - self.a[1]];
        let p = [f64::from(x) + 0.5 - self.a[0], f64::from(y) + 0.5 - self.a[1]];
        let (u, v) = (p[0] * d[1], p[1] * d[0]);
        let limit = self.width / 2.0 * d[0].hypot(d[1]);
        let difference = sign * (u - v) - limit;
        let error = (u.abs() + v.abs() + limit) * 4e-15 + 1e-290;
        if difference.is_finite() && error.is_finite() && difference.abs() > error {
            return difference < 0.0;
        }
        let exact = self.exact();
        let [px, py] = exact.centre(x, y, &exact.a);
        let cross = px * &exact.d[1] - py * &exact.d[0];
        let cross = if is_left { cross } else { -cross };
        let is_plus_up = self.b[0] > self.a[0] || (self.b[0] == self.a[0] && self.b[1] < self.a[1]);
        match (&cross * &cross * 4i32).cmp(&exact.limit) {
            Ordering::Less => true,
            Ordering::Equal if is_left == is_plus_up => true,
            _ => cross < BigInt::ZERO,
        }
    }

    fn exact(&self) -> &ExactStroke {
        self.exact.get_or_init(|| ExactStroke::new(self.a, self.b, self.width))
    }
}

impl ExactStroke {
    fn new(a: [f64; 2], b: [f64; 2], width: f64) -> Self {
        let (a, b, width) = (a.map(parts), b.map(parts), parts(width));
        // Zeros have exponent 0. The unit divides half a pixel.
        let unit = [a, b].as_flattened().iter().chain([&width]).map(|part| part.1).fold(-1, i32::min);
        let in_units =
            |(mantissa, exponent): (i64, i32)| BigInt::from(mantissa) << (exponent - unit).unsigned_abs();
        let (a, b, width) = (a.map(in_units), b.map(in_units), in_units(width));
        let d = [&b[0] - &a[0], &b[1] - &a[1]];
        let limit = &width * &width * (&d[0] * &d[0] + &d[1] * &d[1]);
        ExactStroke { a, b, d, limit, half_bits: (-1 - unit).unsigned_abs() }
    }

    /// Returns the centre of pixel (x, y), from `origin` on.
    fn centre(&self, x: i32, y: i32, origin: &[BigInt; 2]) -> [BigInt; 2] {
        let offset = |v: i32, from: &BigInt| (BigInt::from(2 * i64::from(v) + 1) << self.half_bits) - from;
        [offset(x, &origin[0]), offset(y, &origin[1])]
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::draw2d::fill_circle;
    use crate::draw2d::raster::{lit, memory, picture, real};
    use proptest::prelude::*;

    /// Returns whether a point is nearer than half a width to a segment, or on its upper or left side;
    /// all in integers. The distance is that to the nearest of the segment's points, by cases of
    /// where that is.
    pub fn is_near(p: &[BigInt; 2], a: &[BigInt; 2], b: &[BigInt; 2], width: &BigInt) -> bool {
        let sub = |p: &[BigInt; 2], q: &[BigInt; 2]| [&p[0] - &q[0], &p[1] - &q[1]];
        let dot = |p: &[BigInt; 2], q: &[BigInt; 2]| &p[0] * &q[0] + &p[1] * &q[1];
        let (d, from_a, from_b) = (sub(b, a), sub(p, a), sub(p, b));
        let along = dot(&from_a, &d);
        // The sides end at the feet of the ends, those included.
        let (square, scale) = if along < BigInt::ZERO || dot(&d, &d) == BigInt::ZERO {
            (dot(&from_a, &from_a), BigInt::from(1))
        } else if along > dot(&d, &d) {
            (dot(&from_b, &from_b), BigInt::from(1))
        } else {
            // A little higher, or a little to the left, a point on the upper or left side is outside,
            // and one on the other side inside.
            let cross = &from_a[0] * &d[1] - &from_a[1] * &d[0];
            let up = if d[0] == BigInt::ZERO { -&d[1] } else { d[0].clone() };
            let is_on_side = &cross * &cross * 4 == width * width * dot(&d, &d);
            if is_on_side && cross != BigInt::ZERO && (cross > BigInt::ZERO) == (up > BigInt::ZERO) {
                return true;
            }
            // |p - a|^2 - ((p - a).d)^2 / d.d, times d.d.
            (dot(&from_a, &from_a) * dot(&d, &d) - &along * &along, dot(&d, &d))
        };
        square * 4 < width * width * scale
    }

    fn check(p0: [f64; 2], p1: [f64; 2], width: f64) {
        let mut m = memory(13, 9);
        wide_line(&mut m, p0, p1, width, [255, 255, 255, 100], Blend::Over).unwrap();
        let unit = [p0, p1].as_flattened().iter().chain([&width]).map(|v| parts(*v).1).fold(-1, i32::min);
        let scale = |v: f64| BigInt::from(parts(v).0) << (parts(v).1 - unit).unsigned_abs();
        let (a, b, w) = (p0.map(scale), p1.map(scale), scale(width));
        let centre = |v: i32| BigInt::from(2 * v + 1) << (-1 - unit).unsigned_abs();
        let all = (0..9).flat_map(|y| (0..13).map(move |x| (x, y)));
        let want: Vec<_> = all.filter(|&(x, y)| is_near(&[centre(x), centre(y)], &a, &b, &w)).collect();
        assert_eq!(lit(&m, 100), want, "{p0:?} {p1:?} {width:e}");
    }

    fn width() -> impl Strategy<Value = f64> {
        prop_oneof![3 => (0..20i32).prop_map(|v| f64::from(v) / 2.0), 3 => 0.0..12.0, 2 => real().prop_map(f64::abs)]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 800, ..ProptestConfig::default() })]

        #[test]
        fn every_stroke_is_its_definition(
            a in [real(), real()], b in [real(), real()], w in width(),
        ) {
            check(a, b, w);
        }

        #[test]
        fn a_side_through_a_pixels_centre_is_decided_there(
            a in [-9..20i32, -9..20i32], d in prop::sample::select(vec![[3i32, 4], [4, -3], [-12, 5], [1, 0], [0, -1], [20, 21]]),
            long in 1..1000i32, w in 0..40i32, ulps in -1..=1i64,
        ) {
            // Distances of lattice points from such lines are multiples of 1/5, 1/13, 1/29.
            let a = a.map(|v| f64::from(v) / 2.0);
            let b = [0, 1].map(|i| a[i] + f64::from(d[i] * long));
            let length = f64::from(d[0] * d[0] + d[1] * d[1]).sqrt();
            let w = f64::from(w) / length;
            check(a, b, f64::from_bits((w.to_bits() as i64 + if w > 0.0 { ulps } else { 0 }) as u64));
        }

        #[test]
        fn a_point_is_a_disc(p in [real(), real()], w in width()) {
            let [mut disc, mut point] = [memory(13, 9), memory(13, 9)];
            fill_circle(&mut disc, p, w / 2.0, [255; 4], Blend::Replace).unwrap();
            wide_line(&mut point, p, p, w, [255; 4], Blend::Replace).unwrap();
            prop_assert_eq!(disc.bytes(), point.bytes());
        }
    }

    #[test]
    fn negative_widths_are_refused_and_numbers_that_are_not_finite_draw_nothing() {
        let mut m = memory(5, 5);
        m.take_damage();
        let refused = wide_line(&mut m, [0.0; 2], [4.0; 2], -1.0, [255; 4], Blend::Replace).unwrap_err();
        assert_eq!(
            (refused.code().as_str(), refused.to_string()),
            ("ERANGE", "a width is 0 or more, not -1".into())
        );
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            wide_line(&mut m, [bad, 0.0], [4.0; 2], 3.0, [255; 4], Blend::Replace).unwrap();
            wide_line(&mut m, [0.0; 2], [4.0, bad], 3.0, [255; 4], Blend::Replace).unwrap();
            wide_line(&mut m, [0.0; 2], [4.0; 2], bad.abs(), [255; 4], Blend::Replace).unwrap();
        }
        wide_line(&mut m, [0.0; 2], [4.0; 2], 0.0, [255; 4], Blend::Replace).unwrap();
        assert!(!m.is_damaged());
    }

    #[test]
    fn a_line_between_two_rows_of_centres_is_one_pixel_wide_in_either_direction() {
        for (a, b, lit_pixels) in [
            ([1.0, 3.0], [5.0, 3.0], (1..5).map(|x| (x, 2)).collect::<Vec<_>>()),
            ([3.0, 1.0], [3.0, 5.0], (1..5).map(|y| (2, y)).collect()),
        ] {
            for [p0, p1] in [[a, b], [b, a]] {
                let mut m = memory(7, 7);
                wide_line(&mut m, p0, p1, 1.0, [255; 4], Blend::Replace).unwrap();
                assert_eq!(lit(&m, 255), lit_pixels, "{p0:?}");
            }
        }
    }

    #[test]
    fn the_upper_side_has_the_pixels_above_its_ends() {
        check([0.5, 8.0], [1.5, 8.0], 1.0);
        let mut m = memory(4, 9);
        wide_line(&mut m, [0.5, 8.0], [1.5, 8.0], 1.0, [255; 4], Blend::Replace).unwrap();
        assert_eq!(lit(&m, 255), [(0, 7), (1, 7)]);
    }

    #[test]
    fn a_line_three_wide_looks_like_this() {
        let mut m = memory(13, 8);
        wide_line(&mut m, [2.5, 2.0], [10.5, 6.0], 3.0, [255; 4], Blend::Replace).unwrap();
        assert_eq!(picture(&m), THREE_WIDE);
    }

    const THREE_WIDE: &str = "
.............
.####........
.######......
..#######....
....#######..
......######.
........####.
.............";
}

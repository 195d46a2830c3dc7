//! Areas in real coordinates: filled triangles with interpolated colours, filled polygons.
//!
//! Coverage is `math::coverage`'s. The exact colour of a covered pixel with centre P is, in each channel,
//! (c0 E0 + c1 E1 + c2 E2) / A rounded half up, with E_i the doubled area of the snapped corners after i and P, and
//! A = E0 + E1 + E2 that of the triangle: whole numbers all, in the width that the corners need.

use super::blend::Paint;
use super::ramp::{FRACTION_BITS, Ramp};
use super::{AreaColors, Blend, frame, over, run_mut};
use crate::math::coverage::wide::Wide;
use crate::math::coverage::{Corners, Snapped, SnappedTriangle, doubled_area, polygon_spans, scan_triangle};
use crate::memory::{Rgba, VideoMemory};
use std::cmp::Ordering;
use std::ops::Range;

/// Fills a triangle, of any size and winding; with three colours they run from corner to corner.
///
/// Corners in pixels, finite. Zero area lights nothing. The cost is that of the visible rows and pixels.
pub fn fill(memory: &mut VideoMemory, points: [[f64; 2]; 3], colors: AreaColors, blend: Blend) {
    let triangle = SnappedTriangle::new(points);
    match colors {
        AreaColors::Three(c) if c[0] != c[1] || c[0] != c[2] => match triangle.corners() {
            Snapped::Narrow(p) => gradient(memory, p, c, blend),
            Snapped::Middle(p) => gradient(memory, p, c, blend),
            Snapped::Huge(p) => gradient(memory, p, c, blend),
        },
        AreaColors::One(color) | AreaColors::Three([color, ..]) => {
            if let Some(paint) = Paint::new(color, blend) {
                triangle.for_each_span(frame(memory), painter(memory, paint));
            }
        }
    }
}

/// Fills the closed polygon by the even-odd rule. Points in pixels, finite; fewer than three fill nothing.
pub fn fill_poly(memory: &mut VideoMemory, points: &[[f64; 2]], color: Rgba, blend: Blend) {
    if let Some(paint) = Paint::new(color, blend) {
        polygon_spans(points, frame(memory), painter(memory, paint));
    }
}

/// What paints a span with one colour.
fn painter(memory: &mut VideoMemory, paint: Paint) -> impl FnMut(i32, Range<i32>) {
    move |y, xs| {
        paint.run(run_mut(memory, y, xs));
        memory.mark_row(y as u32);
    }
}

/// The exact colours of one triangle.
struct Gradient<I> {
    /// Clockwise on the screen, so that every weight of a covered pixel is positive.
    corners: Corners<I>,
    /// Each corner's colour, channel by channel.
    colors: [[I; 4]; 3],
    /// A.
    area: I,
    /// 2 A: what the doubled numerators are divided by.
    divisor: I,
}

impl<I: Wide> Gradient<I> {
    /// `None` for a triangle without area.
    fn new(corners: &Corners<I>, colors: [Rgba; 3]) -> Option<Self> {
        let colors = colors.map(|c| c.map(|v| I::from_i64(v.into())));
        let area = doubled_area(corners);
        let ([a, b, c], [ca, cb, cc]) = (corners.clone(), colors);
        let (corners, colors, area) = match area.signum_order() {
            Ordering::Equal => return None,
            Ordering::Greater => ([a, b, c], [ca, cb, cc], area),
            Ordering::Less => ([a, c, b], [ca, cc, cb], I::from_i64(0).minus(&area)),
        };
        let divisor = area.plus(&area);
        Some(Gradient { corners, colors, area, divisor })
    }

    /// For each channel the numerator of the rounded colour at pixel (x, y), 2 sum c_i E_i + A, over 2 A.
    ///
    /// The pixel is covered: no weight is negative, so the numerator is at most 511 A.
    fn numerators(&self, x: i32, y: i32) -> [I; 4] {
        let centre = [x, y].map(|v| I::from_i64(i64::from(v) * 256 + 128));
        let weights: [I; 3] = std::array::from_fn(|i| {
            let (a, b) = (&self.corners[(i + 1) % 3], &self.corners[(i + 2) % 3]);
            let across = b[0].minus(&a[0]).times(&centre[1].minus(&a[1]));
            across.minus(&b[1].minus(&a[1]).times(&centre[0].minus(&a[0])))
        });
        self.mixed(&weights).map(|sum| sum.plus(&sum).plus(&self.area))
    }

    /// What a numerator grows by from a pixel to the next one to the right.
    fn growth(&self) -> [I; 4] {
        let per_pixel = I::from_i64(256);
        let slopes: [I; 3] = std::array::from_fn(|i| {
            let (a, b) = (&self.corners[(i + 1) % 3], &self.corners[(i + 2) % 3]);
            a[1].minus(&b[1]).times(&per_pixel)
        });
        self.mixed(&slopes).map(|sum| sum.plus(&sum))
    }

    /// sum c_i w_i for each channel.
    fn mixed(&self, w: &[I; 3]) -> [I; 4] {
        let c = &self.colors;
        std::array::from_fn(|k| c[0][k].times(&w[0]).plus(&c[1][k].times(&w[1])).plus(&c[2][k].times(&w[2])))
    }

    /// The exact colour of a covered pixel.
    fn color(&self, x: i32, y: i32) -> Rgba {
        self.numerators(x, y).map(|n| n.div_rem_floor(&self.divisor).0.clamp_i64(0, 255) as u8)
    }

    /// n / 2 A in 8.56 fixed point, modulo 256; less than 2 ulp below the truth.
    fn fixed(&self, n: &I) -> u64 {
        let (whole, rest) = n.div_rem_floor(&self.divisor);
        // Outside these bounds only where a pixel has no covered neighbour, and the step is never taken.
        let whole = whole.clamp_i64(-512, 511) as u64;
        (whole << FRACTION_BITS).wrapping_add(rest.fraction_56(&self.divisor))
    }
}

fn gradient<I: Wide>(memory: &mut VideoMemory, corners: &Corners<I>, colors: [Rgba; 3], blend: Blend) {
    let Some(exact) = Gradient::new(corners, colors) else { return };
    let step = exact.growth().map(|n| exact.fixed(&n));
    let largest_divisor = exact.divisor.clamp_i64(0, i64::MAX) as u64;
    scan_triangle(corners, frame(memory), |y, xs| {
        let value = exact.numerators(xs.start, y).map(|n| exact.fixed(&n));
        let ramp = Ramp::new(value, step, 2, xs.len() as u32, largest_divisor);
        let run = run_mut(memory, y, xs.clone());
        let ask = |i: usize| exact.color(xs.start + i as i32, y);
        match blend {
            Blend::Replace => shade(run, ramp, ask, |pixel, color| *pixel = color),
            Blend::Over => shade(run, ramp, ask, |pixel, color| *pixel = over(color, *pixel)),
        }
        memory.mark_row(y as u32);
    });
}

/// Puts the ramp's colours along a run, those in doubt from `ask`, which is given the pixel's place in the run.
fn shade(run: &mut [Rgba], mut ramp: Ramp, ask: impl Fn(usize) -> Rgba, put: impl Fn(&mut Rgba, Rgba)) {
    if ramp.may_be_doubtful() {
        for (i, pixel) in run.iter_mut().enumerate() {
            put(pixel, if ramp.is_doubtful() { ask(i) } else { ramp.color() });
            ramp.step();
        }
    } else {
        for pixel in run {
            put(pixel, ramp.color());
            ramp.step();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw2d::raster::{lit, memory, picture};
    use crate::math::coverage::PixelRect;
    use num_bigint::BigInt;
    use proptest::prelude::*;

    const W: u32 = 11;
    const H: u32 = 8;

    /// v pixels in 1/256, nearest, ties to even, from the decimal digits of the f64.
    fn snap(v: f64) -> BigInt {
        let scaled = v * 256.0;
        let scaled = if scaled.is_finite() { scaled.round_ties_even() } else { v };
        let whole: BigInt = format!("{scaled:.0}").parse().unwrap();
        if (v * 256.0).is_finite() { whole } else { whole * 256 }
    }

    /// The exact colour of pixel (x, y) from the definition, in numbers without a limit.
    fn truth(points: [[f64; 2]; 3], colors: [Rgba; 3], x: i32, y: i32) -> Rgba {
        let p = points.map(|q| q.map(snap));
        let q = [x, y].map(|v| BigInt::from(v) * 256 + 128);
        let cross = |a: &[BigInt; 2], b: &[BigInt; 2], c: &[BigInt; 2]| {
            (&b[0] - &a[0]) * (&c[1] - &a[1]) - (&c[0] - &a[0]) * (&b[1] - &a[1])
        };
        let area = cross(&p[0], &p[1], &p[2]);
        let weight = [cross(&p[1], &p[2], &q), cross(&p[2], &p[0], &q), cross(&p[0], &p[1], &q)];
        std::array::from_fn(|k| {
            let sum: BigInt = (0..3).map(|i| &weight[i] * colors[i][k]).sum();
            // floor(sum / area + 1/2), the sign turned so that the divisor is positive.
            let (n, d): (BigInt, BigInt) = (sum * 2 + &area, &area * 2);
            let (n, d) = if d < BigInt::from(0) { (-n, -d) } else { (n, d) };
            u8::try_from(num_integer::Integer::div_floor(&n, &d)).unwrap()
        })
    }

    fn check(points: [[f64; 2]; 3], colors: [Rgba; 3], blend: Blend) {
        let (mut got, mut want) = (memory(W, H), memory(W, H));
        got.clear([40, 90, 160, 200]);
        want.clear([40, 90, 160, 200]);
        fill(&mut got, points, AreaColors::Three(colors), blend);
        let clip = PixelRect { x0: 0, y0: 0, x1: W as i32, y1: H as i32 };
        SnappedTriangle::new(points).for_each_span(clip, |y, xs| {
            for x in xs {
                crate::draw2d::put_pixel(&mut want, x, y, truth(points, colors, x, y), blend);
            }
        });
        assert_eq!(got.bytes(), want.bytes(), "{points:?} {colors:?} {blend:?}");
    }

    fn corner() -> impl Strategy<Value = [f64; 2]> {
        let coordinate = || {
            prop_oneof![
                3 => (-10i32..30).prop_map(|v| v as f64 / 2.0),
                3 => -20.0..30.0,
                2 => -3000.0..3000.0,
                2 => -1e9..1e9,
                1 => (-1.0..1.0, 9i32..=305).prop_map(|(m, e): (f64, i32)| m * 10f64.powi(e)),
            ]
        };
        [coordinate(), coordinate()]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 6_000, ..ProptestConfig::default() })]

        #[test]
        fn colours_are_the_exact_barycentrics(points in [corner(), corner(), corner()], colors: [Rgba; 3], over: bool) {
            check(points, colors, if over { Blend::Over } else { Blend::Replace });
        }

        #[test]
        fn strips_from_far_to_far_have_steep_exact_colours(
            far in 1e3..1e300f64, x in -20.0..20.0f64, w in 1.0..60.0f64, colors: [Rgba; 3],
        ) {
            check([[x, -far], [x + w, -far], [x + w / 2.0, far]], colors, Blend::Replace);
            check([[-far, x], [-far, x + w], [far, x + w / 2.0]], colors, Blend::Replace);
        }

        #[test]
        fn winding_changes_nothing(points in [corner(), corner(), corner()], c: [Rgba; 3]) {
            let [p0, p1, p2] = points;
            let (mut there, mut back) = (memory(W, H), memory(W, H));
            fill(&mut there, [p0, p1, p2], AreaColors::Three(c), Blend::Replace);
            fill(&mut back, [p0, p2, p1], AreaColors::Three([c[0], c[2], c[1]]), Blend::Replace);
            prop_assert_eq!(there.bytes(), back.bytes());
        }
    }

    #[test]
    fn one_colour_three_times_is_one_colour() {
        let points = [[1.0, 1.0], [9.0, 2.0], [3.0, 7.5]];
        for color in [[255, 255, 255, 255], [10, 20, 30, 77]] {
            for blend in [Blend::Replace, Blend::Over] {
                let (mut one, mut three) = (memory(W, H), memory(W, H));
                fill(&mut one, points, AreaColors::One(color), blend);
                fill(&mut three, points, AreaColors::Three([color; 3]), blend);
                assert_eq!(one.bytes(), three.bytes());
            }
        }
    }

    #[test]
    fn a_star_is_filled_even_odd() {
        let star: Vec<[f64; 2]> = [[6.0, 0.0], [9.5, 10.0], [0.5, 3.8], [11.5, 3.8], [2.5, 10.0]].to_vec();
        let mut m = memory(12, 10);
        m.take_damage();
        fill_poly(&mut m, &star, [255; 4], Blend::Replace);
        assert_eq!(picture(&m), STAR);
        assert_eq!(m.take_damage(), 1..9);
        let mut m = memory(12, 10);
        fill_poly(&mut m, &star, [255, 255, 255, 90], Blend::Over);
        assert_eq!(lit(&m, 90).len(), STAR.matches('#').count());
    }

    #[test]
    fn nothing_is_drawn_by_what_has_no_area() {
        let mut m = memory(W, H);
        m.take_damage();
        let flat = [[0.0, 0.0], [4.0, 4.0], [8.0, 8.0]];
        fill(&mut m, flat, AreaColors::Three([[1; 4], [2; 4], [3; 4]]), Blend::Replace);
        fill(&mut m, flat, AreaColors::One([9; 4]), Blend::Replace);
        fill_poly(&mut m, &flat, [9; 4], Blend::Replace);
        fill_poly(&mut m, &flat[..2], [9; 4], Blend::Replace);
        fill_poly(&mut m, &[], [9; 4], Blend::Replace);
        assert!(!m.is_damaged());
    }

    const STAR: &str = "
............
.....##.....
.....##.....
.....##.....
..##....##..
...#....#...
............
...######...
...##..##...
............";
}

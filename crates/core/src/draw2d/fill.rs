//! Areas in real coordinates: filled triangles with interpolated colours, filled polygons.
//!
//! Coverage comes from `math::coverage`, colours along a row from `gradient`. Both are exact, in
//! integers as wide as the corners need.

use super::band::{Band, NO_ROWS, on_all_rows};
use super::blend::Paint;
use super::gradient::gradient;
use super::{AreaColors, Blend};
use crate::math::coverage::{Snapped, SnappedTriangle, polygon_spans};
use crate::memory::{Rgba, VideoMemory};
use std::ops::Range;

/// Fills a triangle of any size and winding; three colours are interpolated between the corners.
///
/// Corners are in pixels and finite. A triangle of zero area draws nothing. The cost is that of the
/// visible rows and pixels.
pub fn fill(memory: &mut VideoMemory, points: [[f64; 2]; 3], colors: AreaColors, blend: Blend) {
    on_all_rows(memory, |band| fill_on(band, points, colors, blend));
}

/// Does what [`fill`] does within a band.
pub(super) fn fill_on(band: &mut Band<'_>, points: [[f64; 2]; 3], colors: AreaColors, blend: Blend) {
    let triangle = SnappedTriangle::new(points);
    match colors {
        AreaColors::Three(c) if c[0] != c[1] || c[0] != c[2] => match triangle.corners() {
            Snapped::Narrow(p) => gradient(band, p, c, blend),
            Snapped::Middle(p) => gradient(band, p, c, blend),
            Snapped::Huge(p) => gradient(band, p, c, blend),
        },
        AreaColors::One(color) | AreaColors::Three([color, ..]) => {
            if let Some(paint) = Paint::new(color, blend) {
                let (clip, mut rows) = (band.clip(), NO_ROWS);
                triangle.for_each_span(clip, painter(band, paint, &mut rows));
                band.mark_rows(rows);
            }
        }
    }
}

/// Fills the closed polygon by the even-odd rule. Points are in pixels and finite; fewer than three
/// fill nothing.
pub fn fill_poly(memory: &mut VideoMemory, points: &[[f64; 2]], color: Rgba, blend: Blend) {
    on_all_rows(memory, |band| fill_poly_on(band, points, color, blend));
}

/// Does what [`fill_poly`] does within a band.
pub(super) fn fill_poly_on(band: &mut Band<'_>, points: &[[f64; 2]], color: Rgba, blend: Blend) {
    if let Some(paint) = Paint::new(color, blend) {
        let (clip, mut rows) = (band.clip(), NO_ROWS);
        polygon_spans(points, clip, painter(band, paint, &mut rows));
        band.mark_rows(rows);
    }
}

/// Returns a function that paints the span `xs` of row `y`, and adds the row to `rows`. Spans come from
/// the top down.
fn painter(band: &mut Band<'_>, paint: Paint, rows: &mut Range<u32>) -> impl FnMut(i32, Range<i32>) {
    move |y, xs| {
        paint.run(band.run_mut(y, xs));
        let y = y as u32;
        if y >= rows.end {
            *rows = rows.start.min(y)..y + 1;
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

    /// Rounds v pixels to 1/256, ties to even, from the decimal digits of the f64.
    fn snap(v: f64) -> BigInt {
        let scaled = v * 256.0;
        let scaled = if scaled.is_finite() { scaled.round_ties_even() } else { v };
        let scaled_integer: BigInt = format!("{scaled:.0}").parse().unwrap();
        if (v * 256.0).is_finite() { scaled_integer } else { scaled_integer * 256 }
    }

    /// Returns twice the signed area of a triangle.
    fn cross(a: &[BigInt; 2], b: &[BigInt; 2], c: &[BigInt; 2]) -> BigInt {
        (&b[0] - &a[0]) * (&c[1] - &a[1]) - (&c[0] - &a[0]) * (&b[1] - &a[1])
    }

    /// Exact colours of a triangle by the definition, in arbitrary precision.
    struct Truth {
        corners: [[BigInt; 2]; 3],
        area: BigInt,
        colors: [Rgba; 3],
    }

    impl Truth {
        fn new(points: [[f64; 2]; 3], colors: [Rgba; 3]) -> Self {
            let corners = points.map(|point| point.map(snap));
            Truth { area: cross(&corners[0], &corners[1], &corners[2]), corners, colors }
        }

        /// Computes the colour of pixel (x, y).
        fn at(&self, x: i32, y: i32) -> Rgba {
            let Truth { corners: p, area, colors } = self;
            let q = [x, y].map(|v| BigInt::from(v) * 256 + 128);
            let weight = [cross(&p[1], &p[2], &q), cross(&p[2], &p[0], &q), cross(&p[0], &p[1], &q)];
            std::array::from_fn(|k| {
                let sum: BigInt = (0..3).map(|i| &weight[i] * colors[i][k]).sum();
                // floor(sum / area + 1/2), with the sign flipped where needed so that the divisor is
                // positive.
                let (n, d): (BigInt, BigInt) = (sum * 2 + area, area * 2);
                let (n, d) = if d < BigInt::from(0) { (-n, -d) } else { (n, d) };
                u8::try_from(num_integer::Integer::div_floor(&n, &d)).unwrap()
            })
        }
    }

    fn check(points: [[f64; 2]; 3], colors: [Rgba; 3], blend: Blend) {
        let (mut got, mut want) = (memory(W, H), memory(W, H));
        got.clear([40, 90, 160, 200]);
        want.clear([40, 90, 160, 200]);
        fill(&mut got, points, AreaColors::Three(colors), blend);
        let clip = PixelRect { x0: 0, y0: 0, x1: W as i32, y1: H as i32 };
        let truth = Truth::new(points, colors);
        SnappedTriangle::new(points).for_each_span(clip, |y, xs| {
            for x in xs {
                crate::draw2d::put_pixel(&mut want, x, y, truth.at(x, y), blend);
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
        fn colours_that_hardly_change_turn_where_they_do(
            scale in prop_oneof![Just(1e14), Just(1e16), Just(1e17), Just(1e40), Just(1e300)],
            ends in [[-3i32..4, -3i32..4], [-3i32..4, -3i32..4], [-3i32..4, -3i32..4]],
            near in [[-8i32..9, -8i32..9], [-8i32..9, -8i32..9], [-8i32..9, -8i32..9]],
            palette in [0usize..6, 0usize..6, 0usize..6], over: bool,
        ) {
            // Corners at small integer ratios: the colours near the origin are small fractions, or
            // within a rounding error of them.
            let points = std::array::from_fn(|i| {
                std::array::from_fn(|k| match ends[i][k] {
                    0 => f64::from(near[i][k]) / 2.0,
                    far => f64::from(far) * scale,
                })
            });
            let colors = palette.map(|p| {
                [[0; 4], [255; 4], [1, 2, 3, 4], [128, 127, 85, 170], [255, 0, 51, 204], [64, 192, 16, 240]][p]
            });
            check(points, colors, if over { Blend::Over } else { Blend::Replace });
        }

        #[test]
        fn strips_of_whole_steps_are_exact_at_every_crossing(
            far in prop_oneof![Just(1e12), Just(1e17), Just(1e300)], x in -4i32..3, w in prop::sample::select(vec![8, 16, 32, 255, 510]),
            flat in 0usize..4, level in 0u8..=255,
        ) {
            // One nearly constant channel beside three that reach integers at every pixel.
            let (x, w) = (f64::from(x) / 2.0, f64::from(w));
            let mut colors = [[255, 0, 255, 0], [0, 255, 128, 64], [128, 128, 0, 192]];
            colors.iter_mut().for_each(|c| c[flat] = level);
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

    /// Evaluating the exact formula at every pixel of such a frame would take minutes.
    #[test]
    fn corners_at_the_ends_of_the_range_cost_the_visible_part() {
        let begun = std::time::Instant::now();
        let mut m = memory(1920, 1080);
        let colors = [[255, 0, 0, 255], [0, 255, 0, 255], [0, 0, 255, 255]];
        for points in [
            [[-1e300, -1e300], [1e300, 0.0], [0.0, 1e299]],
            [[-1e308, -1e308], [1e308, -1e308], [0.0, 1e308]],
            [[0.0, -1e308], [4080.0, -1e308], [2040.0, 1e308]],
        ] {
            fill(&mut m, points, AreaColors::Three(colors), Blend::Replace);
            let (x, y) = (1500, 500);
            assert_eq!(m.get_pixel(x, y).unwrap(), Truth::new(points, colors).at(x, y));
        }
        assert!(begun.elapsed().as_secs() < 60, "it hung");
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

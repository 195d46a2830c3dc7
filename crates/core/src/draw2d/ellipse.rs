//! Ellipses about any real point, filled and as outlines, with exact coverage.
//!
//! The exact answer: pixel (i,j) is inside when ((i + 1/2 - cx) / rx)^2 + ((j + 1/2 - cy) / ry)^2 is
//! below one. Multiplied by rx^2 ry^2 it is a comparison of integers times a power of two; it is made
//! in f64 wherever rounding cannot change the result. An ellipse with two equal radii is the disc of
//! [`fill_circle`](super::fill_circle). The outline is the rim of the filled ellipse: its pixels
//! that have a neighbour to the left, to the right, above or below that is not inside.

use super::band::{Band, on_all_rows};
use super::blend::Paint;
use super::row_ends::{NEAR, clipped, run_between};
use super::row_search::{rows_between, run_about};
use super::{Blend, DrawError};
use crate::math::coverage::exact_int::parts;
use crate::memory::{Rgba, VideoMemory};
use num_bigint::BigInt;
use std::cell::OnceCell;
use std::ops::Range;

/// Fills the pixels whose centres are inside the ellipse about (cx, cy) with the radii (rx, ry),
/// all in pixels.
///
/// The cost is that of the visible rows and pixels. Numbers that are not finite draw nothing. A
/// negative radius is an error.
pub fn fill_ellipse(
    memory: &mut VideoMemory,
    centre: [f64; 2],
    radii: [f64; 2],
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    on_all_rows(memory, |band| fill_ellipse_on(band, centre, radii, color, blend))
}

/// Does what [`fill_ellipse`] does within a band.
pub(super) fn fill_ellipse_on(
    band: &mut Band<'_>,
    centre: [f64; 2],
    radii: [f64; 2],
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    let Some(ellipse) = Ellipse::new(centre, radii)? else { return Ok(()) };
    let Some(paint) = Paint::new(color, blend) else { return Ok(()) };
    let clip = band.clip();
    band.paint_rows(paint, ellipse.rows(clip.y0..clip.y1), |y| ellipse.row(y, clip.x0..clip.x1));
    Ok(())
}

/// Draws the rim of [`fill_ellipse`]'s pixels, each pixel once.
///
/// The cost is that of the visible rows and pixels. Numbers that are not finite draw nothing. A
/// negative radius is an error.
pub fn ellipse(
    memory: &mut VideoMemory,
    centre: [f64; 2],
    radii: [f64; 2],
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    on_all_rows(memory, |band| ellipse_on(band, centre, radii, color, blend))
}

/// Does what [`ellipse`] does within a band.
pub(super) fn ellipse_on(
    band: &mut Band<'_>,
    centre: [f64; 2],
    radii: [f64; 2],
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    let Some(ellipse) = Ellipse::new(centre, radii)? else { return Ok(()) };
    let Some(paint) = Paint::new(color, blend) else { return Ok(()) };
    let clip = band.clip();
    // One pixel more to each side: a neighbour off the frame may be inside.
    let (xs, ys) = (clip.x0 - 1..clip.x1 + 1, clip.y0 - 1..clip.y1 + 1);
    let row = |y: i32| if ys.contains(&y) { ellipse.row(y, xs.clone()) } else { 0..0 };
    let rows = ellipse.rows(clip.y0..clip.y1);
    let (mut above, mut here) = (row(rows.start - 1), row(rows.start));
    for y in rows {
        let below = row(y + 1);
        // The interior: inside, as are all four neighbours. It is one run, as each of them is.
        let start = (here.start + 1).max(above.start).max(below.start);
        let end = (here.end - 1).min(above.end).min(below.end);
        let interior = if start < end { start..end } else { here.end..here.end };
        for part in [here.start..interior.start, interior.end..here.end] {
            let visible = part.start.max(clip.x0)..part.end.min(clip.x1);
            if !visible.is_empty() {
                paint.run(band.run_mut(y, visible));
                band.mark_row(y as u32);
            }
        }
        (above, here) = (here, below);
    }
    Ok(())
}

/// An ellipse with an exact test for pixel centres.
struct Ellipse {
    centre: [f64; 2],
    radii: [f64; 2],
    /// Returns whether no number is larger than [`NEAR`] and the ellipse is not flat.
    is_near: bool,
    exact: OnceCell<ExactEllipse>,
}

/// An ellipse in integers, in units of a power of two.
struct ExactEllipse {
    centre: [BigInt; 2],
    squares: [BigInt; 2],
    /// Half a pixel is 2^half_bits units.
    half_bits: u32,
}

impl Ellipse {
    /// Returns `None` for an ellipse that has no inside.
    fn new(centre: [f64; 2], radii: [f64; 2]) -> Result<Option<Self>, DrawError> {
        if let Some(&r) = radii.iter().find(|r| **r < 0.0) {
            return Err(DrawError::NegativeRadius { r: r.into() });
        }
        let is_finite = centre.iter().chain(&radii).all(|v| v.is_finite());
        let has_inside = is_finite && radii.iter().all(|r| *r > 0.0);
        let is_near = centre.iter().chain(&radii).all(|v| v.abs() <= NEAR) && radii[1] >= 1.0;
        Ok(has_inside.then(|| Ellipse { centre, radii, is_near, exact: OnceCell::new() }))
    }

    /// Returns the rows of `ys` that it may touch.
    fn rows(&self, ys: Range<i32>) -> Range<i32> {
        let ([_, cy], [_, ry]) = (self.centre, self.radii);
        rows_between(cy - ry, cy + ry, cy.abs() + ry, ys)
    }

    /// Returns its pixels among the columns `xs` of row `y`.
    #[inline]
    fn row(&self, y: i32, xs: Range<i32>) -> Range<i32> {
        match self.near_row(y) {
            Some(run) => clipped(run, xs),
            None => self.plain_row(y, xs),
        }
    }

    /// Returns the pixels of row `y`, or `None` if rounding leaves a doubt.
    ///
    /// With numbers up to 2^16 and a vertical radius of at least 1, v is off by at most 2^-36 and the
    /// square of the half by 2^-35, so that above 2^-8 the half is off by at most 2^-17.
    #[inline]
    fn near_row(&self, y: i32) -> Option<Range<i32>> {
        let ([cx, cy], [rx, ry]) = (self.centre, self.radii);
        let v = (f64::from(y) + 0.5 - cy) / ry;
        match (1.0 - v) * (1.0 + v) {
            _ if !self.is_near => None,
            square if square >= 1.0 / 256.0 => {
                let half = rx * square.sqrt();
                run_between(cx - half, cx + half)
            }
            square if square < -1e-6 => Some(0..0),
            _ => None,
        }
    }

    /// Returns its pixels among the columns `xs` of row `y`: estimated, then corrected by the exact
    /// test.
    #[cold]
    fn plain_row(&self, y: i32, xs: Range<i32>) -> Range<i32> {
        let ([cx, cy], [rx, ry]) = (self.centre, self.radii);
        let v = (f64::from(y) + 0.5 - cy) / ry;
        let half = rx * ((1.0 - v) * (1.0 + v)).max(0.0).sqrt();
        let nearest = (cx.floor() as i32).min(xs.end - 1).max(xs.start);
        run_about(nearest, xs, [cx - half - 0.5, cx + half - 1.5], |x| self.holds(x, y))
    }

    /// Returns whether the centre of pixel (x, y) is inside.
    fn holds(&self, x: i32, y: i32) -> bool {
        let at = |v: i32, k: usize| (f64::from(v) + 0.5 - self.centre[k]) / self.radii[k];
        let (u, v) = (at(x, 0), at(y, 1));
        let sum = u * u + v * v;
        // Each term is off by a few roundings of 2^-53.
        if (sum - 1.0).abs() > 4e-15 {
            return sum < 1.0;
        }
        self.exact.get_or_init(|| ExactEllipse::new(self.centre, self.radii)).holds(x, y)
    }
}

impl ExactEllipse {
    fn new(centre: [f64; 2], radii: [f64; 2]) -> Self {
        let (centre, radii) = (centre.map(parts), radii.map(parts));
        // Zeros have exponent 0. The unit divides half a pixel.
        let unit = [centre, radii].as_flattened().iter().map(|part| part.1).fold(-1, i32::min);
        let in_units =
            |(mantissa, exponent): (i64, i32)| BigInt::from(mantissa) << (exponent - unit).unsigned_abs();
        let squares = radii.map(in_units).map(|r| &r * &r);
        ExactEllipse { centre: centre.map(in_units), squares, half_bits: (-1 - unit).unsigned_abs() }
    }

    /// Returns whether the centre of pixel (x, y) is inside, exactly.
    fn holds(&self, x: i32, y: i32) -> bool {
        let square = |v: i32, c: &BigInt| {
            let offset = (BigInt::from(2 * i64::from(v) + 1) << self.half_bits) - c;
            &offset * &offset
        };
        let [rx2, ry2] = &self.squares;
        square(x, &self.centre[0]) * ry2 + square(y, &self.centre[1]) * rx2 < rx2 * ry2
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw2d::fill_circle;
    use crate::draw2d::raster::{ellipse_definition, fractional, lit, memory, picture, real};
    use proptest::prelude::*;

    /// Draws both forms and compares them with the definition, evaluated at every pixel.
    fn check(centre: [f64; 2], radii: [f64; 2]) {
        let inside = ellipse_definition(centre, radii);
        let all = || (0..9).flat_map(|y| (0..13).map(move |x| (x, y)));
        let mut filled = memory(13, 9);
        fill_ellipse(&mut filled, centre, radii, [255, 255, 255, 100], Blend::Over).unwrap();
        let want: Vec<_> = all().filter(|&(x, y)| inside(x, y)).collect();
        assert_eq!(lit(&filled, 100), want, "{centre:?} {radii:?}");
        let mut rim = memory(13, 9);
        ellipse(&mut rim, centre, radii, [255, 255, 255, 100], Blend::Over).unwrap();
        let is_rim = |&(x, y): &(i32, i32)| {
            let around = [(x - 1, y), (x + 1, y), (x, y - 1), (x, y + 1)];
            inside(x, y) && !around.iter().all(|&(x, y)| inside(x, y))
        };
        let want: Vec<_> = all().filter(is_rim).collect();
        assert_eq!(lit(&rim, 100), want, "{centre:?} {radii:?}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 800, ..ProptestConfig::default() })]

        #[test]
        fn every_ellipse_is_its_definition(x in real(), y in real(), rx in real(), ry in real()) {
            check([x, y], [rx.abs(), ry.abs()]);
        }

        #[test]
        fn every_row_is_that_of_the_exact_test(
            centre in [fractional(), fractional()], radii in [fractional(), fractional()], wide in prop::sample::select(vec![1.0, 1e-3, 32.0]),
        ) {
            let Ok(Some(ellipse)) = Ellipse::new(centre, [radii[0].abs() * wide, radii[1].abs()]) else { return Ok(()) };
            for y in -3..1100 {
                prop_assert_eq!(ellipse.row(y, 0..1920), ellipse.plain_row(y, 0..1920), "row {}", y);
            }
        }

        #[test]
        fn a_rim_through_a_pixels_centre_is_decided_there(
            x in -1e3..1e3f64, y in -1e3..1e3f64, i in 0..13i32, j in 0..9i32, ry in 1.0..2e3f64, ulps in -2..=2i64,
        ) {
            let (x, y, ry) = ((x * 2.0).round() / 2.0, (y * 2.0).round() / 2.0, ry.round());
            let (dx, dy) = (f64::from(i) + 0.5 - x, f64::from(j) + 0.5 - y);
            let left = 1.0 - (dy / ry) * (dy / ry);
            // Elsewhere the rim has no place in this row, and any radius will do.
            let rx = if left > 0.0 { (dx.abs() / left.sqrt()).max(0.5) } else { 7.5 };
            check([x, y], [f64::from_bits((rx.to_bits() as i64 + ulps) as u64), ry]);
        }

        #[test]
        fn equal_radii_make_a_disc(x in real(), y in real(), r in real()) {
            let [mut disc, mut oval] = [memory(13, 9), memory(13, 9)];
            fill_circle(&mut disc, [x, y], r.abs(), [255; 4], Blend::Replace).unwrap();
            fill_ellipse(&mut oval, [x, y], [r.abs(); 2], [255; 4], Blend::Replace).unwrap();
            prop_assert_eq!(disc.bytes(), oval.bytes());
        }
    }

    #[test]
    fn negative_radii_are_refused_and_numbers_that_are_not_finite_draw_nothing() {
        let mut m = memory(5, 5);
        m.take_damage();
        for draw in [fill_ellipse, ellipse] {
            for radii in [[-1.0, 2.0], [2.0, -5e-324]] {
                let refused = draw(&mut m, [2.0; 2], radii, [255; 4], Blend::Replace).unwrap_err();
                assert_eq!(refused.code().as_str(), "ERANGE");
            }
            for bad in [f64::NAN, f64::INFINITY] {
                draw(&mut m, [bad, 2.0], [2.0; 2], [255; 4], Blend::Replace).unwrap();
                draw(&mut m, [2.0; 2], [2.0, bad], [255; 4], Blend::Replace).unwrap();
            }
            draw(&mut m, [2.0; 2], [0.0, 9.0], [255; 4], Blend::Replace).unwrap();
        }
        assert!(!m.is_damaged());
    }

    #[test]
    fn an_outline_looks_like_this() {
        let mut m = memory(13, 8);
        ellipse(&mut m, [6.5, 4.0], [6.0, 3.0], [255; 4], Blend::Replace).unwrap();
        assert_eq!(picture(&m), OUTLINE);
    }

    const OUTLINE: &str = "
.............
...#######...
.##.......##.
.#.........#.
.#.........#.
.##.......##.
...#######...
.............";
}

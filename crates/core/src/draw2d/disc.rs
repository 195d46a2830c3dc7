//! Filled circles about any real point, with exact coverage.
//!
//! The exact answer: pixel (i,j) is lit when (i + 1/2 - cx)^2 + (j + 1/2 - cy)^2 < r^2. Every
//! finite f64 is an integer times a power of two, so the comparison can be made in integers. It is
//! made in f64 wherever rounding cannot change the result.

use super::band::{Band, on_all_rows};
use super::blend::Paint;
use super::row_ends::{NEAR, RowEnds, arc_half, clipped, run_between};
use super::row_search::{rows_between, run_about};
use super::{Blend, DrawError};
use crate::math::coverage::exact_int::parts;
use crate::memory::{Rgba, VideoMemory};
use num_bigint::BigInt;
use std::cell::OnceCell;
use std::ops::Range;

/// Fills the pixels whose centres are nearer than `r` to the point (cx, cy), all in pixels.
///
/// The cost is that of the visible rows and pixels. Numbers that are not finite draw nothing. A
/// negative radius is an error.
#[inline]
pub fn fill_circle(
    memory: &mut VideoMemory,
    centre: [f64; 2],
    r: f64,
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    fill_disc(memory, centre[0], centre[1], r, (color, blend))
}

/// Fills a disc. Its numbers arrive in registers: an array that the caller has just stored number by
/// number would be read as one vector, for which the processor waits until all earlier stores, pixels
/// among them, are in the cache.
#[inline(never)]
fn fill_disc(
    memory: &mut VideoMemory,
    cx: f64,
    cy: f64,
    r: f64,
    (color, blend): (Rgba, Blend),
) -> Result<(), DrawError> {
    on_all_rows(memory, |band| disc_on(band, [cx, cy], r, color, blend))
}

/// Does what [`fill_circle`] does within a band.
#[inline(always)]
pub(super) fn disc_on(
    band: &mut Band<'_>,
    [cx, cy]: [f64; 2],
    r: f64,
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    if r < 0.0 {
        return Err(DrawError::NegativeRadius { r: r.into() });
    }
    let Some(paint) = Paint::new(color, blend) else { return Ok(()) };
    if !(cx.is_finite() && cy.is_finite() && r.is_finite()) {
        return Ok(());
    }
    let clip = band.clip();
    let disc = Disc::new([cx, cy], r);
    band.paint_rows(paint, disc.rows(clip.y0..clip.y1), |y| disc.row(y, clip.x0..clip.x1));
    Ok(())
}

/// A disc with an exact test for pixel centres.
pub(super) struct Disc {
    centre: [f64; 2],
    r: f64,
    /// Factor that keeps the squares of the largest numbers finite.
    scale: f64,
    /// Returns whether no number is larger than [`NEAR`].
    is_near: bool,
    exact: OnceCell<ExactDisc>,
}

/// A disc in integers, in units of a power of two.
struct ExactDisc {
    centre: [BigInt; 2],
    r_squared: BigInt,
    /// Half a pixel is 2^half_bits units.
    half_bits: u32,
}

impl Disc {
    /// Creates the disc of a radius that is not negative; numbers are finite.
    pub fn new(centre: [f64; 2], r: f64) -> Self {
        let extent = r.max(centre[0].abs()).max(centre[1].abs());
        let scale = if extent > 1e150 { 2f64.powi(-600) } else { 1.0 };
        Disc { centre, r, scale, is_near: extent <= NEAR, exact: OnceCell::new() }
    }

    /// Returns the rows of `ys` that it may touch.
    pub fn rows(&self, ys: Range<i32>) -> Range<i32> {
        let [_, cy] = self.centre;
        rows_between(cy - self.r, cy + self.r, cy.abs() + self.r, ys)
    }

    /// Returns its pixels among the columns `xs` of row `y`.
    #[inline]
    pub fn row(&self, y: i32, xs: Range<i32>) -> Range<i32> {
        match self.near_row(y) {
            Some(run) => clipped(run, xs),
            None => self.plain_row(y, xs),
        }
    }

    /// Returns the pixels of row `y`, or `None` if rounding leaves a doubt.
    #[inline]
    fn near_row(&self, y: i32) -> Option<Range<i32>> {
        let [cx, cy] = self.centre;
        match arc_half(self.r, f64::from(y) + 0.5 - cy) {
            _ if !self.is_near => None,
            RowEnds::Half(half) => run_between(cx - half, cx + half),
            RowEnds::Nothing => Some(0..0),
            RowEnds::Doubtful => None,
        }
    }

    /// Returns its pixels among the columns `xs` of row `y`: estimated, then corrected by the exact
    /// test.
    #[cold]
    pub fn plain_row(&self, y: i32, xs: Range<i32>) -> Range<i32> {
        let [cx, cy] = self.centre;
        let dy = f64::from(y) + 0.5 - cy;
        let half = ((self.r - dy) * (self.r + dy)).max(0.0).sqrt();
        let nearest = (cx.floor() as i32).min(xs.end - 1).max(xs.start);
        run_about(nearest, xs, [cx - half - 0.5, cx + half - 1.5], |x| self.holds(x, y))
    }

    /// Returns whether the centre of pixel (x, y) is nearer than r.
    fn holds(&self, x: i32, y: i32) -> bool {
        let [dx, dy] = [(x, self.centre[0]), (y, self.centre[1])]
            .map(|(v, c)| ((f64::from(v) + 0.5) * self.scale - c * self.scale).abs());
        let r = self.r * self.scale;
        let (distance, radius) = (dx * dx + dy * dy, r * r);
        // Each side is off by a few roundings of 2^-53; the constant covers underflow.
        let error = (distance + radius) * 2e-15 + 1e-290;
        if (distance - radius).abs() > error {
            return distance < radius;
        }
        self.exact.get_or_init(|| ExactDisc::new(self.centre, self.r)).holds(x, y)
    }
}

impl ExactDisc {
    fn new(centre: [f64; 2], r: f64) -> Self {
        let (centre, r) = (centre.map(parts), parts(r));
        // Zeros have exponent 0. The unit divides half a pixel.
        let unit = [centre[0].1, centre[1].1, r.1, -1].into_iter().fold(-1, i32::min);
        let in_units =
            |(mantissa, exponent): (i64, i32)| BigInt::from(mantissa) << (exponent - unit).unsigned_abs();
        let r = in_units(r);
        ExactDisc { centre: centre.map(in_units), r_squared: &r * &r, half_bits: (-1 - unit).unsigned_abs() }
    }

    /// Returns whether the centre of pixel (x, y) is nearer than r, exactly.
    fn holds(&self, x: i32, y: i32) -> bool {
        let offset = |v: i32, c: &BigInt| (BigInt::from(2 * i64::from(v) + 1) << self.half_bits) - c;
        let (dx, dy) = (offset(x, &self.centre[0]), offset(y, &self.centre[1]));
        &dx * &dx + &dy * &dy < self.r_squared
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw2d::raster::{ellipse_definition, fractional, lit, memory, picture, real};
    use proptest::prelude::*;

    fn check(centre: [f64; 2], r: f64) {
        let mut m = memory(13, 9);
        fill_circle(&mut m, centre, r, [255, 255, 255, 100], Blend::Over).unwrap();
        let is_inside = ellipse_definition(centre, [r, r]);
        let all = (0..9).flat_map(|y| (0..13).map(move |x| (x, y)));
        let want: Vec<_> = all.filter(|&(x, y)| is_inside(x, y)).collect();
        assert_eq!(lit(&m, 100), want, "{centre:?} {r:e}");
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 4_000, ..ProptestConfig::default() })]

        #[test]
        fn every_disc_is_its_definition(x in real(), y in real(), r in real()) {
            check([x, y], r.abs());
        }

        #[test]
        fn a_rim_through_a_pixels_centre_is_decided_there(
            x in -1e5..1e5f64, y in -1e5..1e5f64, i in 0..13i32, j in 0..9i32, ulps in -2..=2i64, half: bool,
        ) {
            let round = |v: f64| if half { (v * 2.0).round() / 2.0 } else { v };
            let (x, y) = (round(x), round(y));
            let (dx, dy) = (f64::from(i) + 0.5 - x, f64::from(j) + 0.5 - y);
            let r = (dx * dx + dy * dy).sqrt();
            check([x, y], f64::from_bits((r.to_bits() as i64 + if r > 0.0 { ulps } else { 0 }) as u64));
        }

        #[test]
        fn every_row_is_that_of_the_exact_test(
            centre in [fractional(), fractional()], r in fractional(), far in prop::sample::select(vec![0.0, 60_000.0, -60_000.0]),
        ) {
            let disc = Disc::new([centre[0] + far, centre[1] + far], r.abs() + far.abs());
            for y in -3..1100 {
                prop_assert_eq!(disc.row(y, 0..1920), disc.plain_row(y, 0..1920), "row {}", y);
            }
        }

        #[test]
        fn far_discs_that_touch_the_frame(e in 3..300i32, m in 1.0..9.0f64, side in 0..4usize) {
            let r = m * 10f64.powi(e);
            check([[r, 4.5], [-r, 4.5], [6.5, r], [6.5, -r]][side], r);
        }
    }

    #[test]
    fn a_tie_lies_outside() {
        // Pixel centres at 3-4-5 from (0.5, 0.5) are not nearer than 5.
        let mut m = memory(13, 9);
        fill_circle(&mut m, [0.5, 0.5], 5.0, [255; 4], Blend::Replace).unwrap();
        let set = lit(&m, 255);
        assert!(!set.contains(&(3, 4)) && !set.contains(&(5, 0)) && set.contains(&(4, 2)));
        let mut m = memory(11, 8);
        m.take_damage();
        fill_circle(&mut m, [5.0, 4.0], 3.0, [255; 4], Blend::Replace).unwrap();
        assert_eq!((picture(&m).as_str(), m.take_damage()), (RADIUS_3, 1..7));
    }

    #[test]
    fn no_radius_lights_nothing_and_a_negative_one_is_refused() {
        let mut m = memory(4, 4);
        m.take_damage();
        for r in [0.0, -0.0, 5e-324] {
            fill_circle(&mut m, [2.5, 2.5 + 1e-9], r, [255; 4], Blend::Replace).unwrap();
        }
        assert_eq!(
            fill_circle(&mut m, [2.5; 2], -5e-324, [255; 4], Blend::Replace).unwrap_err().code().as_str(),
            "ERANGE"
        );
        assert!(!m.is_damaged());
        // A pixel's centre is nearer to itself than any positive radius.
        fill_circle(&mut m, [2.5, 2.5], 5e-324, [255; 4], Blend::Replace).unwrap();
        assert_eq!(lit(&m, 255), [(2, 2)]);
    }

    #[test]
    fn numbers_that_are_not_finite_draw_nothing() {
        let mut m = memory(4, 4);
        m.take_damage();
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            fill_circle(&mut m, [bad, 2.0], 9.0, [255; 4], Blend::Replace).unwrap();
            fill_circle(&mut m, [2.0, bad], 9.0, [255; 4], Blend::Replace).unwrap();
            fill_circle(&mut m, [2.0, 2.0], bad.abs(), [255; 4], Blend::Replace).unwrap();
        }
        assert!(!m.is_damaged());
    }

    const RADIUS_3: &str = "
...........
...####....
..######...
..######...
..######...
..######...
...####....
...........";
}

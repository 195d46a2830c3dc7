//! Filled rectangles with real sides, and one-pixel borders of rectangles in whole pixels.
//!
//! The exact answer of a fill: pixel (i,j) is lit when x <= i + 1/2 < x + w and y <= j + 1/2 < y +
//! h, with unrounded sums of the given reals. For integers these are the w x h pixels from (x,y).

use super::band::{Band, on_all_rows};
use super::blend::Paint;
use super::{Blend, DrawError, RealRect, Rect, visible};
use crate::memory::{Rgba, VideoMemory};
use std::ops::Range;

/// Fills the pixels whose centres lie in [x, x + w) x [y, y + h). A size of 0 draws nothing; a
/// negative one is an error.
///
/// Numbers that are not finite draw nothing.
pub fn fill_rect(
    memory: &mut VideoMemory,
    rect: impl Into<RealRect>,
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    let rect = rect.into();
    on_all_rows(memory, |band| fill_rect_on(band, rect, color, blend))
}

/// Does what [`fill_rect`] does within a band.
#[inline(always)]
pub(super) fn fill_rect_on(
    band: &mut Band<'_>,
    RealRect { x, y, w, h }: RealRect,
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    if w < 0.0 || h < 0.0 {
        return Err(DrawError::NegativeSize { w: w.into(), h: h.into() });
    }
    if ![x, y, w, h].iter().all(|v| v.is_finite()) {
        return Ok(());
    }
    let (xs, ys) = (centres(x, w, band.size()[0]), centres(y, h, band.size()[1]));
    let clip = band.clip();
    let xs = xs.start.max(clip.x0)..xs.end.min(clip.x1);
    let ys = ys.start.max(clip.y0)..ys.end.min(clip.y1);
    if let Some(paint) = Paint::new(color, blend) {
        band.paint_block(paint, xs, ys);
    }
    Ok(())
}

/// Returns the pixels of a row of `size` whose centres lie in [start, start + length), exactly;
/// `length` >= 0.
fn centres(start: f64, length: f64, size: u32) -> Range<i32> {
    // Most rectangles have whole sides; their sums are exact.
    if let (Some(start), Some(length)) = (whole(start), whole(length)) {
        let inside = |v: i64| v.clamp(0, i64::from(size)) as i32;
        return inside(start)..inside(start + length);
    }
    real_centres(start, length, size)
}

/// Returns a number as an integer, if it is one below 2^53.
fn whole(v: f64) -> Option<i64> {
    let n = v as i64;
    (n as f64 == v && n.unsigned_abs() < 1 << 53).then_some(n)
}

/// Is [`centres`] for any numbers.
fn real_centres(start: f64, length: f64, size: u32) -> Range<i32> {
    let size = f64::from(size);
    // `end + rest` is the sum without rounding (Knuth's two-sum).
    let end = start + length;
    let from_length = end - start;
    let rest = (start - (end - from_length)) + (length - from_length);
    // The first pixel whose centre is not below v. The difference is exact wherever the result is
    // above 0.
    let first = |v: f64| (v - 0.5).ceil().clamp(0.0, size);
    let last = first(end);
    // A centre equal to the rounded end lies inside if the exact end is beyond it.
    let is_inside = rest > 0.0 && last + 0.5 == end && last < size;
    first(start) as i32..last as i32 + i32::from(is_inside)
}

/// Draws the border of [`fill_rect`]'s pixels, one pixel wide, each pixel once. A negative size is
/// an error.
pub fn rect(memory: &mut VideoMemory, rect: Rect, color: Rgba, blend: Blend) -> Result<(), DrawError> {
    let Rect { x, y, w, h } = rect.checked()?;
    let Some(paint) = Paint::new(color, blend) else { return Ok(()) };
    let [xs, ys] = visible(memory, rect);
    // The last row and column, in i64 as they may be beyond i32.
    let last = |start: i32, len: i32| i64::from(start) + i64::from(len) - 1;
    let side = |at: i64, within: &Range<i32>| match i32::try_from(at) {
        Ok(at) if within.contains(&at) => at..at + 1,
        _ => 0..0,
    };
    let (top, bottom) = (side(y.into(), &ys), side(last(y, h), &ys));
    let (left, right) = (side(x.into(), &xs), side(last(x, w), &xs));
    // The columns between the two rows.
    let between = ys.start + top.len() as i32..ys.end - if h > 1 { bottom.len() as i32 } else { 0 };
    let sides = [
        (xs.clone(), top),
        (xs, if h > 1 { bottom } else { 0..0 }),
        (left, between.clone()),
        (right, if w > 1 { between } else { 0..0 }),
    ];
    on_all_rows(memory, |band| sides.into_iter().for_each(|(xs, ys)| band.paint_block(paint, xs, ys)));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw2d::raster::{FRAME_H, FRAME_W, extremes, lit, memory, picture};

    #[test]
    fn a_border_is_the_rim_of_the_filled_rectangle() {
        let mut m = memory(8, 6);
        rect(&mut m, Rect { x: 1, y: 1, w: 5, h: 4 }, [255; 4], Blend::Replace).unwrap();
        assert_eq!(picture(&m), BORDER);
        let mut m = memory(8, 6);
        fill_rect(&mut m, Rect { x: -1, y: 3, w: 4, h: 9 }, [255; 4], Blend::Replace).unwrap();
        assert_eq!(picture(&m), CUT_BLOCK);
    }

    #[test]
    fn whole_sides_have_the_centres_of_real_ones() {
        let small = [0.0, -0.0, 1.0, -1.0, 7.0, 8.0, 9.0, 0.5];
        let large = [-1e9, 1e9, 9007199254740991.0, i64::MIN as f64, 1e15, 1e300];
        let ends = || small.into_iter().chain(large);
        for (start, length) in ends().flat_map(|a| ends().map(move |b| (a, f64::abs(b)))) {
            let (fast, real) = (centres(start, length, 8), real_centres(start, length, 8));
            assert!(fast == real || fast.is_empty() && real.is_empty(), "{start} {length}");
        }
    }

    #[test]
    fn every_rectangle_is_its_definition_even_at_the_ends_of_i32() {
        let frame_size = (FRAME_W as u32, FRAME_H as u32);
        let sizes = [0, 1, 2, 3, 7, 1 << 30, i32::MAX];
        for (x, y) in extremes().into_iter().flat_map(|x| extremes().map(|y| (x, y))) {
            for (w, h) in sizes.into_iter().flat_map(|w| sizes.map(|h| (w, h))) {
                let wide = |v: i32| i64::from(v);
                let inside = |px: i64, py: i64| {
                    (0..wide(w)).contains(&(px - wide(x))) && (0..wide(h)).contains(&(py - wide(y)))
                };
                let border = |px: i64, py: i64| {
                    let rim = |v: i64, n: i32| v == 0 || v == wide(n) - 1;
                    inside(px, py) && (rim(px - wide(x), w) || rim(py - wide(y), h))
                };
                // Composited over black, a pixel drawn twice would be brighter.
                let mut m = memory(frame_size.0, frame_size.1);
                fill_rect(&mut m, Rect { x, y, w, h }, [255, 255, 255, 100], Blend::Over).unwrap();
                assert_eq!(lit(&m, 100), lit_by(inside), "fill {x} {y} {w} {h}");
                let mut m = memory(frame_size.0, frame_size.1);
                rect(&mut m, Rect { x, y, w, h }, [255, 255, 255, 100], Blend::Over).unwrap();
                assert_eq!(lit(&m, 100), lit_by(border), "rect {x} {y} {w} {h}");
            }
        }
    }

    /// Returns reals where rounding matters: centres and their neighbours, integers, the smallest
    /// and largest numbers.
    fn border_cases() -> Vec<f64> {
        let near = |v: f64| [v.next_down(), v, v.next_up()];
        let centres = [-1.5, -0.5, 0.5, 1.0, 2.5, 3.25, 6.5, 7.5].into_iter().flat_map(near);
        let far = [1e9 + 0.5, 4503599627370497.5, 9007199254740993.0, 1e17, 1e300, f64::MAX];
        let far = far.into_iter().flat_map(|v| [v, -v]);
        centres.chain(far).chain([0.0, -0.0, 5e-324, -5e-324, 1e-17, -1e-17]).collect()
    }

    /// Returns a real in units of 2^-1074, of which every finite f64 is a multiple.
    fn exact(v: f64) -> num_bigint::BigInt {
        let (mantissa, exponent) = crate::math::coverage::exact_int::parts(v);
        num_bigint::BigInt::from(mantissa) << (exponent + 1074) as u32
    }

    #[test]
    fn real_sides_cover_the_centres_between_them_exactly() {
        let cases = border_cases();
        // And sides whose rounded sum is a pixel's centre while the exact sum is not.
        let sides = cases.iter().flat_map(|&a| cases.iter().map(move |&b| (a, b)));
        let sums = cases.iter().flat_map(|&a| [0.5, 2.5, 6.5].map(|c| (a, c - a)));
        for (x, w) in sides.chain(sums).filter(|(_, w)| *w >= 0.0) {
            let (low, high) = (exact(x), exact(x) + exact(w));
            let want: Vec<i32> =
                (0..8).filter(|&i| (&low..&high).contains(&&exact(f64::from(i) + 0.5))).collect();
            assert_eq!(centres(x, w, 8).collect::<Vec<_>>(), want, "from {x:e}, length {w:e}");
            let mut m = memory(8, 3);
            let rect = RealRect { x, y: 0.5, w, h: 1.5 };
            fill_rect(&mut m, rect, [255, 255, 255, 100], Blend::Over).unwrap();
            let want: Vec<_> = (0..2).flat_map(|y| want.iter().map(move |&x| (x, y))).collect();
            assert_eq!(lit(&m, 100), want, "from {x:e}, length {w:e}");
        }
    }

    #[test]
    fn numbers_that_are_not_finite_draw_nothing() {
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut m = memory(4, 4);
            let rect = RealRect { x: bad, y: 0.0, w: 4.0, h: 4.0 };
            fill_rect(&mut m, rect, [255; 4], Blend::Replace).unwrap();
            assert_eq!(lit(&m, 255), []);
        }
    }

    fn lit_by(inside: impl Fn(i64, i64) -> bool) -> Vec<(i32, i32)> {
        let all = (0..FRAME_H).flat_map(|y| (0..FRAME_W).map(move |x| (x, y)));
        all.filter(|&(x, y)| inside(x.into(), y.into())).collect()
    }

    #[test]
    fn negative_sizes_are_refused_and_damage_is_what_was_drawn() {
        let mut m = memory(8, 6);
        m.take_damage();
        let r = |w, h| Rect { x: 2, y: 2, w, h };
        assert_eq!(
            fill_rect(&mut m, r(-1, 3), [1; 4], Blend::Replace),
            Err(DrawError::NegativeSize { w: (-1).into(), h: 3.into() })
        );
        assert_eq!(
            rect(&mut m, r(3, i32::MIN), [1; 4], Blend::Replace).unwrap_err().code().as_str(),
            "ERANGE"
        );
        fill_rect(&mut m, r(0, 3), [1; 4], Blend::Replace).unwrap();
        rect(&mut m, r(3, 0), [1; 4], Blend::Replace).unwrap();
        fill_rect(&mut m, r(3, 3), [1, 1, 1, 0], Blend::Over).unwrap();
        assert!(!m.is_damaged());
        rect(&mut m, r(3, 2), [1; 4], Blend::Replace).unwrap();
        assert_eq!(m.take_damage(), 2..4);
    }

    const BORDER: &str = "
........
.#####..
.#...#..
.#...#..
.#####..
........";

    const CUT_BLOCK: &str = "
........
........
........
###.....
###.....
###.....";
}

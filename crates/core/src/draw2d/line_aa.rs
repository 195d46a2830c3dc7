//! Anti-aliased lines by exact area coverage.
//!
//! In: two ends in real pixels, with pixel centres at integers: pixel (i,j) is the square
//! [i-1/2,i+1/2]x[j-1/2,j+1/2]. Out: each pixel composited with the colour's alpha times its
//! coverage by the rectangle about the segment, one pixel wide and with butt ends. The exact
//! coverage is the area of the square's intersection with the rectangle. It is computed in f64 on a
//! rectangle that is first clipped near the frame, is accurate to 1e-9 for ends of any size, and is
//! then rounded to 1/255. Between the ends it is stepped along the line ([`stepped`]); at the ends
//! the rectangle is cut by the squares' borders.
//!
//! ```text
//!            n/2
//!   +---------^-----------+         u: unit vector along the segment, n: across it
//!   p0 ------ | -----> u  p1        foot: the point of the line nearest to the frame's centre
//!   +---------------------+
//! ```

mod segment_rect;
mod stepped;
#[cfg(test)]
mod tests;

use super::band::{Band, on_all_rows};
use super::blend::compose;
use crate::math::coverage::PixelRect;
use crate::memory::{Rgba, VideoMemory};
use segment_rect::SegmentRect;
use stepped::Stepped;

/// Draws the line from `p0` to `p1`, finite reals in pixels, always composited over the frame
/// whatever the blend mode.
///
/// A segment of length 0 covers no area and draws nothing. The cost is that of the visible part.
pub fn line_aa(memory: &mut VideoMemory, p0: [f64; 2], p1: [f64; 2], color: Rgba) {
    on_all_rows(memory, |band| line_aa_on(band, p0, p1, color));
}

/// Does what [`line_aa`] does within a band.
pub(super) fn line_aa_on(band: &mut Band<'_>, p0: [f64; 2], p1: [f64; 2], color: Rgba) {
    let (clip, [width, height], top) = (band.clip(), band.size(), band.top());
    // Of the whole frame, so that rounding is the same in every band of rows.
    let whole = PixelRect { x0: 0, y0: 0, x1: width as i32, y1: height as i32 };
    let (mut first, mut end) = (u32::MAX, 0);
    let pixels = band.pixels_mut();
    for_each_covered_pixel(p0, p1, whole, clip, |x, y, area| {
        let coverage = (area * 255.0 + 0.5) as u16;
        let alpha = (coverage * u16::from(color[3]) + 127) / 255;
        // Always `Some`: x and y are inside the band.
        if alpha > 0
            && let Some(pixel) = pixels.get_mut(width as usize * (y as u32 - top) as usize + x as usize)
        {
            *pixel = compose([color[0], color[1], color[2], alpha as u8], *pixel);
            (first, end) = (first.min(y as u32), end.max(y as u32 + 1));
        }
    });
    band.mark_rows(first..end);
}

/// Returns the area of a pixel that the line covers on a frame of `size`; `None` if it covers none, or
/// the pixel is off the frame.
pub(super) fn coverage_at(size: [u32; 2], p0: [f64; 2], p1: [f64; 2], [x, y]: [i32; 2]) -> Option<f64> {
    let whole = PixelRect { x0: 0, y0: 0, x1: size[0] as i32, y1: size[1] as i32 };
    if !(0..whole.x1).contains(&x) || !(0..whole.y1).contains(&y) {
        return None;
    }
    let clip = PixelRect { x0: x, y0: y, x1: x + 1, y1: y + 1 };
    let mut found = None;
    for_each_covered_pixel(p0, p1, whole, clip, |_, _, area| found = Some(area));
    found
}

/// Calls `f(x, y, coverage)` for the pixels inside `clip` that the rectangle meets, with their
/// coverage in [0,1]. `frame` holds `clip`; rounding depends on it alone.
#[inline(always)]
fn for_each_covered_pixel(
    p0: [f64; 2],
    p1: [f64; 2],
    frame: PixelRect,
    clip: PixelRect,
    mut f: impl FnMut(i32, i32, f64),
) {
    let Some(rect) = SegmentRect::new(p0, p1, frame) else { return };
    let stepped = Stepped::new(&rect);
    // Cut on the frame: the place of the first cut rounds the others.
    let [before, _, behind] = stepped.parts(frame);
    for end in [before, behind] {
        cut_pixels(&rect, end, clip, &mut f);
    }
    let [_, columns, _] = stepped.parts(clip);
    stepped.for_each_pixel(columns, f);
}

/// Calls `f(x, y, coverage)` for the pixels inside `clip` that the rectangle meets in a part of the
/// frame: cuts it by the squares' borders.
#[inline(never)]
fn cut_pixels(rect: &SegmentRect, part: PixelRect, clip: PixelRect, f: &mut impl FnMut(i32, i32, f64)) {
    if part.is_empty() || clip.is_empty() {
        return;
    }
    // Pixel squares begin half a pixel before their centres.
    let [left, right] = [part.x0, part.x1].map(|x| f64::from(x) - 0.5);
    let [top, bottom] = [part.y0, part.y1].map(|y| f64::from(y) - 0.5);
    let (_, visible) = Convex::of(rect.corners()).split(0, left);
    let (visible, _) = visible.split(0, right);
    let (_, visible) = visible.split(1, top);
    let (mut below, _) = visible.split(1, bottom);
    let Some([first, last]) = below.squares(1) else { return };
    for y in first.max(part.y0)..=last.min(part.y1 - 1).min(clip.y1 - 1) {
        let (row, rest) = below.split(1, f64::from(y) + 0.5);
        below = rest;
        if y < clip.y0 {
            continue;
        }
        let mut beyond = row;
        let Some([first, last]) = beyond.squares(0) else { continue };
        for x in first.max(part.x0)..=last.min(part.x1 - 1) {
            let (cell, rest) = beyond.split(0, f64::from(x) + 0.5);
            beyond = rest;
            if (clip.x0..clip.x1).contains(&x) {
                f(x, y, cell.area().min(1.0));
            }
        }
    }
}

/// Upper bound on the corners of a rectangle cut by the four sides of a frame and of a square (8),
/// with some reserve.
const MOST_CORNERS: usize = 12;

/// A convex polygon, in either winding.
#[derive(Clone, Copy)]
struct Convex {
    corners: [[f64; 2]; MOST_CORNERS],
    len: usize,
}

impl Convex {
    const EMPTY: Convex = Convex { corners: [[0.0; 2]; MOST_CORNERS], len: 0 };

    fn of(corners: [[f64; 2]; 4]) -> Self {
        let mut convex = Convex::EMPTY;
        corners.into_iter().for_each(|c| convex.push(c));
        convex
    }

    fn push(&mut self, corner: [f64; 2]) {
        // A cut adds at most one corner to a convex polygon, so there is always room.
        if let Some(free) = self.corners.get_mut(self.len) {
            *free = corner;
            self.len += 1;
        }
    }

    fn points(&self) -> &[[f64; 2]] {
        &self.corners[..self.len]
    }

    /// Splits the polygon where coordinate `axis` equals `at`. Returns the part below and the part
    /// above, which share the new corners.
    fn split(&self, axis: usize, at: f64) -> (Convex, Convex) {
        let (mut below, mut above) = (Convex::EMPTY, Convex::EMPTY);
        let points = self.points();
        for (a, b) in points.iter().zip(points.iter().cycle().skip(1)) {
            if a[axis] <= at {
                below.push(*a);
            }
            if a[axis] >= at {
                above.push(*a);
            }
            if (a[axis] < at && b[axis] > at) || (a[axis] > at && b[axis] < at) {
                let t = (at - a[axis]) / (b[axis] - a[axis]);
                let mut crossing = [0, 1].map(|i| a[i] + (b[i] - a[i]) * t);
                crossing[axis] = at;
                below.push(crossing);
                above.push(crossing);
            }
        }
        (below, above)
    }

    /// Returns the first and last pixel square met along `axis`, or `None` for a polygon without
    /// corners.
    fn squares(&self, axis: usize) -> Option<[i32; 2]> {
        let along = || self.points().iter().map(|p| p[axis]);
        let (low, high) = (along().reduce(f64::min)?, along().reduce(f64::max)?);
        // Rounds half up: square i begins at i - 1/2. `as` saturates far coordinates to i32.
        Some([(low + 0.5).floor() as i32, ((high + 0.5).ceil() - 1.0) as i32])
    }

    /// Returns the area, by the shoelace formula relative to the first corner.
    fn area(&self) -> f64 {
        let [origin, rest @ ..] = self.points() else { return 0.0 };
        let from = |p: &[f64; 2]| [p[0] - origin[0], p[1] - origin[1]];
        let pairs = rest.windows(2).map(|w| (from(&w[0]), from(&w[1])));
        pairs.map(|(a, b)| a[0] * b[1] - a[1] * b[0]).sum::<f64>().abs() / 2.0
    }
}

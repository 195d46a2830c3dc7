//! Circle outlines about a pixel, by the midpoint algorithm.
//!
//! Source: Bresenham, "A linear algorithm for incremental digital display of circular arcs" (1977),
//! with the midpoint decision.

use super::blend::Paint;
use super::{Blend, DrawError, frame, pixels_mut};
use crate::memory::{Rgba, VideoMemory};
use std::ops::Range;

/// Draws the midpoint circle of radius `r` about the pixel (cx, cy), each pixel once; r = 0 is that
/// pixel.
///
/// The exact answer in the octant 0 <= a <= b: for each a the pixel (a, b) with b = sqrt(r^2 - a^2)
/// rounded to the nearest integer (never a tie: r^2 - a^2 is an integer), and its seven mirror
/// images. The cost is that of the visible rows and columns. A negative radius is an error.
pub fn circle(
    memory: &mut VideoMemory,
    [cx, cy]: [i32; 2],
    r: i32,
    color: Rgba,
    blend: Blend,
) -> Result<(), DrawError> {
    let radius = u64::try_from(r).map_err(|_| DrawError::NegativeRadius { r: f64::from(r).into() })?;
    let Some(paint) = Paint::new(color, blend) else { return Ok(()) };
    let (width, clip) = (memory.width(), frame(memory));
    if clip.is_empty() {
        return Ok(());
    }
    // The short offset a of a visible pixel is that of its column or of its row.
    let offsets = |centre: i32, within: Range<i32>| {
        let near = |v: i32| i64::from(v).abs_diff(i64::from(centre));
        let (first, last) = (near(within.start), near(within.end - 1));
        let is_inside = within.contains(&centre);
        if is_inside { 0..first.max(last) + 1 } else { first.min(last)..first.max(last) + 1 }
    };
    let (columns, rows) = (offsets(cx, clip.x0..clip.x1), offsets(cy, clip.y0..clip.y1));
    let (mut low, mut high) = (u32::MAX, 0);
    let pixels = pixels_mut(memory);
    let mut put = |dx: i64, dy: i64| {
        let (x, y) = (i64::from(cx) + dx, i64::from(cy) + dy);
        let is_inside = |v: i64, low: i32, high: i32| i64::from(low) <= v && v < i64::from(high);
        if is_inside(x, clip.x0, clip.x1) && is_inside(y, clip.y0, clip.y1) {
            let y = y as u32;
            if let Some(pixel) = pixels.get_mut(width as usize * y as usize + x as usize) {
                paint.one(pixel);
            }
            (low, high) = (low.min(y), high.max(y + 1));
        }
    };
    let mut octant = |offsets: Range<u64>| {
        let mut long = LongOffset::new(radius, offsets.start);
        for short in offsets {
            let (a, b) = (short as i64, long.value as i64);
            if a > b {
                return;
            }
            // Mirror images that coincide are drawn once.
            for (dx, dy) in [(a, b), (b, a)].into_iter().take(if a == b { 1 } else { 2 }) {
                put(dx, dy);
                if dx > 0 {
                    put(-dx, dy);
                }
                if dy > 0 {
                    put(dx, -dy);
                }
                if dx > 0 && dy > 0 {
                    put(-dx, -dy);
                }
            }
            long.step();
        }
    };
    let (first, second) = if columns.start <= rows.start { (columns, rows) } else { (rows, columns) };
    octant(first.clone());
    octant(second.start.max(first.end)..second.end);
    memory.mark_rows(low..high);
    Ok(())
}

/// The integer nearest to sqrt(r^2 - a^2), for a = 0, 1, 2, ... up to 45 degrees.
struct LongOffset {
    value: u64,
    /// r^2 - a^2.
    square: u64,
    short: u64,
}

impl LongOffset {
    /// Starts at a = `short`, at most the radius.
    fn new(radius: u64, short: u64) -> Self {
        let short = short.min(radius);
        let square = radius * radius - short * short;
        // round(sqrt(s)) = floor((sqrt(4 s) + 1) / 2); r is below 2^31, so 4 s fits.
        LongOffset { value: (4 * square).isqrt().div_ceil(2), square, short }
    }

    /// Advances to the next a. The value falls by at most 1 as long as a does not exceed it.
    fn step(&mut self) {
        self.square = self.square.saturating_sub(2 * self.short + 1);
        self.short += 1;
        // b is too large if (b - 1/2)^2 > s, in integers b^2 - b >= s.
        if self.value > 0 && self.value * self.value - self.value >= self.square {
            self.value -= 1;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw2d::raster::{extremes, lit, memory, picture};
    use std::collections::BTreeSet;

    #[test]
    fn a_disc_about_the_pixels_centre_fills_the_circle_of_its_radius() {
        for r in 0..120 {
            let size = 2 * r as u32 + 5;
            let c = r + 2;
            let (mut rim, mut disc) =
                (VideoMemory::new(size, size).unwrap(), VideoMemory::new(size, size).unwrap());
            let white = [255; 4];
            circle(&mut rim, [c, c], r, white, Blend::Replace).unwrap();
            let centre = [f64::from(c) + 0.5; 2];
            crate::draw2d::fill_circle(&mut disc, centre, r.into(), white, Blend::Replace).unwrap();
            for y in 0..size as i32 {
                let is_lit = |memory: &VideoMemory, x: i32| memory.get_pixel(x, y).unwrap() == white;
                let columns: Vec<i32> = (0..size as i32).filter(|x| is_lit(&rim, *x)).collect();
                let inside = columns.first().zip(columns.last());
                for x in 0..size as i32 {
                    let is_filled = is_lit(&rim, x) || is_lit(&disc, x);
                    let is_inside = inside.is_some_and(|(first, last)| (*first..=*last).contains(&x));
                    assert_eq!(is_filled, is_inside, "radius {r}: {x},{y}");
                }
            }
        }
    }

    /// Returns the pixels by definition: in each octant the pixel nearest to the true circle.
    fn truth(cx: i32, cy: i32, r: i64, w: i64, h: i64) -> Vec<(i32, i32)> {
        let mut set = BTreeSet::new();
        for a in 0..=r {
            // The nearest b: the largest with (b - 1/2)^2 < r^2 - a^2.
            let b = (0..=r).rev().find(|b| b * b - b < r * r - a * a).unwrap_or(0);
            if a > b {
                break;
            }
            for (dx, dy) in [(a, b), (b, a)] {
                for (dx, dy) in [(dx, dy), (-dx, dy), (dx, -dy), (-dx, -dy)] {
                    let (x, y) = (i64::from(cx) + dx, i64::from(cy) + dy);
                    if (0..w).contains(&x) && (0..h).contains(&y) {
                        set.insert((y as i32, x as i32));
                    }
                }
            }
        }
        set.into_iter().map(|(y, x)| (x, y)).collect()
    }

    #[test]
    fn every_circle_is_its_definition_each_pixel_once() {
        for (cx, cy) in (-9..32).step_by(4).flat_map(|x| (-7..25).step_by(3).map(move |y| (x, y))) {
            for r in 0..40 {
                let mut m = memory(24, 18);
                m.take_damage();
                circle(&mut m, [cx, cy], r, [255, 255, 255, 100], Blend::Over).unwrap();
                let want = truth(cx, cy, r.into(), 24, 18);
                assert_eq!(lit(&m, 100), want, "({cx},{cy}) r {r}");
                let rows = want.first().map(|p| p.1 as u32..want.last().unwrap().1 as u32 + 1);
                assert_eq!(m.is_damaged().then(|| m.take_damage()), rows);
            }
        }
    }

    #[test]
    fn the_largest_circles_show_their_visible_arc_at_once() {
        // Radius r about (r, 9) touches column 0 at row 9; so does the circle about (cx, 9) with r
        // = cx.
        for r in [1_000_000, 2_000_000_000, i32::MAX] {
            let mut m = memory(24, 18);
            circle(&mut m, [r, 9], r, [255; 4], Blend::Replace).unwrap();
            assert_eq!(lit(&m, 255), (0..18).map(|y| (0, y)).collect::<Vec<_>>());
            let mut m = memory(24, 18);
            circle(&mut m, [11, 17 - r], r, [255; 4], Blend::Replace).unwrap();
            assert_eq!(lit(&m, 255), (0..24).map(|x| (x, 17)).collect::<Vec<_>>());
        }
        // Across a diagonal: each visible pixel is tested against the circle.
        let (c, r) = (-1_500_000_000i64, 2_121_320_372i64);
        let mut m = memory(40, 40);
        circle(&mut m, [c as i32; 2], r as i32, [255; 4], Blend::Replace).unwrap();
        let on = |x: i64, y: i64| {
            let (a, b) = ((x - c).min(y - c), (x - c).max(y - c));
            let s = r * r - a * a;
            b * b - b < s && b * b + b >= s
        };
        let want: Vec<_> =
            (0..40).flat_map(|y| (0..40).map(move |x| (x, y))).filter(|&(x, y)| on(x, y)).collect();
        assert!(want.len() > 10);
        assert_eq!(lit(&m, 255), want.iter().map(|&(x, y)| (x as i32, y as i32)).collect::<Vec<_>>());
    }

    #[test]
    fn odd_numbers_are_answered() {
        for (cx, cy) in extremes().into_iter().flat_map(|x| extremes().map(|y| (x, y))) {
            for r in [0, 1, 5, 1 << 30, i32::MAX] {
                circle(&mut memory(7, 5), [cx, cy], r, [255; 4], Blend::Over).unwrap();
            }
        }
        let mut m = memory(7, 5);
        let refused = circle(&mut m, [3, 3], -1, [255; 4], Blend::Replace).unwrap_err();
        assert_eq!(refused.to_string(), "a radius is 0 or more, not -1");
        circle(&mut m, [3, 2], 0, [255; 4], Blend::Replace).unwrap();
        assert_eq!(lit(&m, 255), [(3, 2)]);
    }

    #[test]
    fn radius_four_looks_like_this() {
        let mut m = memory(11, 11);
        circle(&mut m, [5, 5], 4, [255; 4], Blend::Replace).unwrap();
        assert_eq!(picture(&m), RADIUS_4);
    }

    const RADIUS_4: &str = "
...........
....###....
..##...##..
..#.....#..
.#.......#.
.#.......#.
.#.......#.
..#.....#..
..##...##..
....###....
...........";
}

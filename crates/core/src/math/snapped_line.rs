//! Line between two points of 1/256 pixel: the pixels of a line in space.
//!
//! In: two ends in pixels (y down, pixel (i,j) is the square [i,i+1)x[j,j+1)), snapped to 1/256 as the
//! corners of faces are. Out: one pixel for each column that the line enters, or for each row if it is
//! steep: the one that contains the line's point at the column's centre, or its end where it ends
//! before. So the line passes through every pixel, within half a pixel of its centre in x and in y,
//! and both ends' columns are included. A point on the border of two pixels belongs to the lower or
//! the right one. The ends may be swapped.
//!
//! Each pixel is decided by its exact error term: with the major coordinate c clamped to the ends,
//!
//! ```text
//! row = floor((y0 (x1 - x0) + (c - x0) (y1 - y0)) / (256 (x1 - x0)))
//! ```
//!
//! in integers, computed from the column alone, so clipping costs nothing.

use super::coverage::PixelRect;
use std::ops::Range;

/// Steps in a pixel.
const STEPS: i64 = 256;

/// Bound on coordinates in 1/256 pixel whose products fit 64 bits.
const NARROW: i64 = 1 << 29;

/// Line between two snapped points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SnappedLine {
    /// Ends in 1/256 pixel, major coordinate first.
    ends: [[i64; 2]; 2],
    /// True if x is the major axis, which has the longer extent; x if both are equal.
    pub is_x_major: bool,
    /// True if the coordinates are below [`NARROW`].
    is_narrow: bool,
}

impl SnappedLine {
    /// Creates the line between two points in pixels. Coordinates beyond i32 are clamped to it.
    pub fn new(a: [f64; 2], b: [f64; 2]) -> Self {
        let [low, high] = [i32::MIN, i32::MAX].map(f64::from);
        let snap = |v: f64| (v.clamp(low, high) * STEPS as f64).round_ties_even() as i64;
        let ends = [a, b].map(|p| p.map(snap));
        let [dx, dy] = [0, 1].map(|axis| (ends[1][axis] - ends[0][axis]).abs());
        let is_x_major = dx >= dy;
        let ends = ends.map(|[x, y]| if is_x_major { [x, y] } else { [y, x] });
        SnappedLine { ends, is_x_major, is_narrow: ends.iter().flatten().all(|v| v.abs() < NARROW) }
    }

    /// Returns the columns of the ends, or their rows if the line is steep.
    fn columns(&self) -> [i64; 2] {
        self.ends.map(|[major, _]| major.div_euclid(STEPS))
    }

    /// Returns the number of steps from the first pixel to the last one.
    pub fn steps(&self) -> u64 {
        let [from, to] = self.columns();
        from.abs_diff(to)
    }

    /// Returns the steps whose column, or row if the line is steep, is inside a rectangle.
    pub fn steps_along(&self, rect: PixelRect) -> Range<u64> {
        let (low, high) = if self.is_x_major { (rect.x0, rect.x1) } else { (rect.y0, rect.y1) };
        let [from, to] = self.columns();
        let inside = match from <= to {
            true => i64::from(low) - from..i64::from(high) - from,
            false => from - i64::from(high) + 1..from - i64::from(low) + 1,
        };
        let (start, end) = (inside.start.max(0), inside.end.min(self.steps() as i64 + 1));
        start as u64..end.max(start) as u64
    }

    /// Returns the pixel (x, y) at step k.
    pub fn at(&self, k: u64) -> [i64; 2] {
        let [from, to] = self.columns();
        let column = if from <= to { from + k as i64 } else { from - k as i64 };
        let [[x0, y0], [x1, y1]] = self.ends;
        let (dx, dy) = (x1 - x0, y1 - y0);
        let along = (column * STEPS + STEPS / 2).clamp(x0.min(x1), x0.max(x1)) - x0;
        let row = match (dx, self.is_narrow) {
            (0, _) => y0.div_euclid(STEPS),
            (_, true) => floor_of(y0 * dx + along * dy, STEPS * dx),
            (_, false) => {
                let [y0, dx, dy, along] = [y0, dx, dy, along].map(i128::from);
                let (over, under) = (y0 * dx + along * dy, i128::from(STEPS) * dx);
                let sign = under.signum();
                (over * sign).div_euclid(under * sign) as i64
            }
        };
        if self.is_x_major { [column, row] } else { [row, column] }
    }
}

/// Returns the quotient rounded down.
fn floor_of(over: i64, under: i64) -> i64 {
    let sign = under.signum();
    (over * sign).div_euclid(under * sign)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn each_column_has_the_pixel_that_the_line_passes(
            a in [-3000i64..3000, -3000i64..3000], b in [-3000i64..3000, -3000i64..3000], shift in 0u32..2,
        ) {
            // Far ones take the wide integers.
            let offset = f64::from(shift) * 4_194_304.0;
            let point = |p: [i64; 2]| p.map(|v| v as f64 / 256.0 + offset);
            let line = SnappedLine::new(point(a), point(b));
            let all = PixelRect { x0: i32::MIN, y0: i32::MIN, x1: i32::MAX, y1: i32::MAX };
            prop_assert_eq!(line.steps_along(all), 0..line.steps() + 1);
            let (major, minor) = if line.is_x_major { (0, 1) } else { (1, 0) };
            let pixels: Vec<[i64; 2]> = (0..=line.steps()).map(|k| line.at(k).map(|v| v - offset as i64)).collect();
            let back = SnappedLine::new(point(b), point(a));
            for (k, p) in (0..).zip(&pixels) {
                // Bounds of the line's part in the column, in 1/256 pixel of the first end's row.
                let centre = 256 * p[major] + 128;
                let at = centre.clamp(a[major].min(b[major]), a[major].max(b[major]));
                prop_assert!(at.div_euclid(256) == p[major] || (at % 256 == 0 && at / 256 == p[major] + 1));
                let (dx, dy) = (b[major] - a[major], b[minor] - a[minor]);
                // row * 256 <= y < row * 256 + 256, times |dx|.
                let y = (a[minor] * dx + (at - a[major]) * dy) * dx.signum();
                let row = 256 * p[minor] * dx.abs();
                if dx == 0 {
                    prop_assert_eq!(a[minor].div_euclid(256), p[minor]);
                } else {
                    prop_assert!((row..row + 256 * dx.abs()).contains(&y), "{:?}", p);
                }
                prop_assert_eq!(back.at(line.steps() - k).map(|v| v - offset as i64), *p);
            }
            prop_assert_eq!(pixels[0][major], a[major].div_euclid(256));
            prop_assert_eq!(pixels[pixels.len() - 1][major], b[major].div_euclid(256));
        }
    }

    #[test]
    fn steps_inside_a_rectangle_are_those_of_its_columns() {
        let rect = PixelRect { x0: 2, y0: 0, x1: 6, y1: 9 };
        let steps = |a: [f64; 2], b: [f64; 2]| SnappedLine::new(a, b).steps_along(rect);
        assert_eq!(steps([0.5, 1.0], [9.5, 2.0]), 2..6);
        assert_eq!(steps([9.5, 1.0], [0.5, 2.0]), 4..8);
        assert_eq!(steps([3.5, 20.0], [3.5, 4.0]), 12..17);
        assert!(steps([7.0, 0.0], [9.0, 1.0]).is_empty() && steps([-9.0, 0.0], [1.9, 1.0]).is_empty());
        let far = SnappedLine::new([-2e9, 0.0], [2e9, 100.0]);
        assert_eq!((far.steps(), far.steps_along(rect).count()), (4_000_000_000, 4));
        assert_eq!(far.at(2_000_000_000), [0, 50]);
    }
}

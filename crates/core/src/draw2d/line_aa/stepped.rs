//! Coverage of the pixels that an anti-aliased line crosses between its ends, column by column (of a
//! line that is steeper than 45 degrees, row by row).
//!
//! In: the rectangle about a segment. Out: the pixels of the columns that both long sides cross from
//! one border to the other, each with its area. The area of a column above a line and above y = e is
//! a polynomial of e in three parts: 0 where the line is below e all over the column, a parabola
//! where it crosses e, a straight line beyond. A pixel's coverage is the growth of the difference of
//! both sides' areas from its upper border to its lower one. The tests compare it with the
//! rectangle cut by the pixel's square.

use super::segment_rect::SegmentRect;
use crate::math::coverage::PixelRect;
use std::ops::Range;

/// A line along its major axis: x if it is flatter than 45 degrees, otherwise y.
pub(super) struct Stepped {
    /// The major axis, 0 or 1.
    major: usize,
    /// Columns that both sides cross, on the major axis.
    pub columns: Range<i32>,
    /// A place on the line on both axes, the major one first.
    place: [f64; 2],
    /// Rows a column.
    slope: f64,
    /// Half of the breadth along the minor axis.
    half: f64,
}

impl Stepped {
    pub fn new(rect: &SegmentRect) -> Self {
        let major = usize::from(rect.u[1].abs() > rect.u[0].abs());
        let minor = 1 - major;
        // n, across the segment, is (-u[1], u[0]).
        let sign = if major == 0 { -1.0 } else { 1.0 };
        let (along, across) = (rect.u[major], sign * rect.u[minor]);
        let end = |s: f64| rect.centre[major] + s * along - rect.h * across;
        let [low, high] = if along > 0.0 { rect.s.map(end) } else { [rect.s[1], rect.s[0]].map(end) };
        // A column's square begins half a pixel before its centre. `as` saturates.
        let first = (low + across.abs() / 2.0 + 0.5).ceil() as i32;
        let end = ((high - across.abs() / 2.0 - 0.5).floor() as i32).saturating_add(1);
        Stepped {
            major,
            columns: first..end.max(first),
            place: [rect.centre[major], rect.centre[minor] + sign * rect.h / along],
            slope: rect.u[minor] / along,
            half: 0.5 / along.abs(),
        }
    }

    /// Returns what of `clip` lies before the columns of this part, in them and behind them.
    pub fn parts(&self, clip: PixelRect) -> [PixelRect; 3] {
        let within = |from: i32, to: i32| match self.major {
            0 => PixelRect { x0: clip.x0.max(from), x1: clip.x1.min(to), ..clip },
            _ => PixelRect { y0: clip.y0.max(from), y1: clip.y1.min(to), ..clip },
        };
        let Range { start, end } = self.columns;
        [within(i32::MIN, start), within(start, end), within(end, i32::MAX)]
    }

    /// Calls `f(x, y, coverage)` for the pixels inside `clip`, which lies in the columns.
    #[inline(always)]
    pub fn for_each_pixel(&self, clip: PixelRect, mut f: impl FnMut(i32, i32, f64)) {
        match self.major {
            0 => self.for_each_of([clip.x0..clip.x1, clip.y0..clip.y1], f),
            _ => self.for_each_of([clip.y0..clip.y1, clip.x0..clip.x1], |y, x, area| f(x, y, area)),
        }
    }

    #[inline(always)]
    fn for_each_of(&self, [columns, rows]: [Range<i32>; 2], mut f: impl FnMut(i32, i32, f64)) {
        if rows.is_empty() {
            return;
        }
        let reach = self.half + self.slope.abs() / 2.0;
        let area = AreaAbove::new(self.slope.abs());
        for column in self.meeting(columns, &rows) {
            let middle = self.place[1] + (f64::from(column) - self.place[0]) * self.slope;
            // Pixel i is the square from i - 1/2 to i + 1/2.
            let first = whole_below(middle - reach + 0.5).max(rows.start);
            let last = whole_below(middle + reach + 0.5).min(rows.end - 1);
            let between = |row: i32| {
                let below_middle = f64::from(row) - 0.5 - middle;
                area.at(below_middle + self.half) - area.at(below_middle - self.half)
            };
            let mut above = between(first);
            for row in first..=last {
                let below = between(row + 1);
                f(column, row, (below - above).clamp(0.0, 1.0));
                above = below;
            }
        }
    }

    /// Returns the columns in which the line may meet the rows.
    fn meeting(&self, columns: Range<i32>, rows: &Range<i32>) -> Range<i32> {
        const LEVEL: f64 = 1e-6;
        if self.slope.abs() < LEVEL {
            return columns;
        }
        // A side is at most 0.71 rows from the middle, which moves half a row in half a column.
        let at = |row: f64| self.place[0] + (row - self.place[1]) / self.slope;
        let [a, b] = [at(f64::from(rows.start) - 3.0), at(f64::from(rows.end) + 3.0)];
        let (low, high) = (a.min(b).floor() as i32, a.max(b).ceil() as i32);
        columns.start.max(low)..columns.end.min(high.saturating_add(1))
    }
}

/// Returns the largest integer not above `v`, for a number that an i32 can hold.
#[inline(always)]
fn whole_below(v: f64) -> i32 {
    let towards_0 = v as i32;
    towards_0 - i32::from(f64::from(towards_0) > v)
}

/// The area of a column of breadth 1 between a line of some slope and a level below its middle.
struct AreaAbove {
    slope: f64,
    half_slope: f64,
    /// 1 / (2 slope).
    per_square: f64,
}

impl AreaAbove {
    fn new(slope: f64) -> Self {
        // Below this the parabola's part is less than any area that shows.
        let per_square = if slope > 1e-30 { 0.5 / slope } else { 0.0 };
        AreaAbove { slope, half_slope: slope / 2.0, per_square }
    }

    /// Returns the area above a level that is `v` below the line's middle.
    #[inline(always)]
    fn at(&self, v: f64) -> f64 {
        let from_top = v + self.half_slope;
        let from_top = if from_top > 0.0 { from_top } else { 0.0 };
        let crossed = if from_top < self.slope { from_top } else { self.slope };
        let beyond = v - self.half_slope;
        crossed * crossed * self.per_square + if beyond > 0.0 { beyond } else { 0.0 }
    }
}

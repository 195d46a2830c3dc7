//! Crossings of an edge with the rows of pixel centres, in exact fractions, one step for each row.
//!
//! An edge from (x0,y0) down to (x1,y1), in 1/256 pixel, meets the centres of row y at
//! X = x0 + (cy - y0) dx / dy with cy = 256 y + 128, for y0 <= cy < y1. Column i lies on it or to
//! its right if 256 i + 128 >= X, so the first such column is ceil((X - 128) / 256) = ceil(N / D)
//! with N = (x0 - 128) dy + (cy - y0) dx and D = 256 dy. The left edge of a span gives its first
//! column, the right edge the first column beyond it, by one formula: two areas that share an edge
//! get equal columns, and no pixel of the seam is covered twice or missed.

use super::exact_int::ExactInt;
use std::ops::Range;

/// Steps an edge down the rows.
pub(crate) trait Walk<I> {
    /// Starts the edge between two points at the first of the rows that it crosses. `top` must lie
    /// above `bottom` (smaller y), not beside it. Columns are clamped to `ends`, which must be
    /// equal in all calls.
    fn new(top: &[I; 2], bottom: &[I; 2], rows: Range<i32>, ends: [i32; 2]) -> Self;
    /// Returns the first column on the edge or to its right, clamped to `ends`.
    fn column(&self, ends: [i32; 2]) -> i32;
    /// Steps one row down.
    fn step(&mut self);
}

/// Returns the first row whose centre lies on or below `y` (in 1/256 pixel), clamped to `lo..=hi`.
pub(super) fn first_row<I: ExactInt>(y: &I, lo: i32, hi: i32) -> i32 {
    // ceil((y - 128) / 256)
    y.plus(&I::from_i64(127)).div_rem_floor(&I::from_i64(256)).0.clamp_i64(lo.into(), hi.into()) as i32
}

/// Edge stepped by integer additions only.
pub(crate) struct EdgeWalk<I> {
    /// ceil(N / D): the first column on the edge or to its right.
    column: I,
    /// Remainder of N + D - 1 divided by D, in 0..D.
    rest: I,
    step_column: I,
    step_rest: I,
    divisor: I,
}

impl<I: ExactInt> Walk<I> for EdgeWalk<I> {
    fn new(top: &[I; 2], bottom: &[I; 2], rows: Range<i32>, _: [i32; 2]) -> Self {
        let dx = bottom[0].minus(&top[0]);
        let dy = bottom[1].minus(&top[1]);
        let centre = I::from_i64(i64::from(rows.start) * 256 + 128);
        let n = top[0].minus(&I::from_i64(128)).times(&dy).plus(&centre.minus(&top[1]).times(&dx));
        let unit = I::from_i64(256);
        let divisor = dy.times(&unit);
        let (column, rest) = n.plus(&divisor).minus(&I::from_i64(1)).div_rem_floor(&divisor);
        let (step_column, step_rest) = dx.times(&unit).div_rem_floor(&divisor);
        EdgeWalk { column, rest, step_column, step_rest, divisor }
    }

    #[inline]
    fn column(&self, [lo, hi]: [i32; 2]) -> i32 {
        self.column.clamp_i64(lo.into(), hi.into()) as i32
    }

    #[inline]
    fn step(&mut self) {
        self.column.add(&self.step_column);
        self.rest.add(&self.step_rest);
        if self.rest >= self.divisor {
            self.rest.sub(&self.divisor);
            self.column.add(&I::from_i64(1));
        }
    }
}

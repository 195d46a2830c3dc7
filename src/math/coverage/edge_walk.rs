//! Where an edge crosses the rows of pixel centres, in exact fractions, one step a row.
//!
//! An edge from (x0,y0) down to (x1,y1), in 1/256 pixel, meets the centres of row y at X = x0 + (cy - y0) dx / dy with
//! cy = 256 y + 128, for y0 <= cy < y1. Column i lies on it or to its right when 256 i + 128 >= X, so the first such
//! column is ceil((X - 128) / 256) = ceil(N / D) with N = (x0 - 128) dy + (cy - y0) dx and D = 256 dy. The left edge of a
//! span gives its first column, the right edge the first column beyond it: one formula, so that two areas which share an
//! edge share the number too, and no pixel of the seam is lit twice or left out.

use super::exact_int::ExactInt;
use std::ops::Range;

/// Follows an edge down the rows.
pub(crate) trait Walk<I> {
    /// The edge between two points in the rows that it crosses, standing at the first. `top` lies above `bottom` (smaller
    /// y), not beside it. Columns are held to `ends`, the same in all calls.
    fn new(top: &[I; 2], bottom: &[I; 2], rows: Range<i32>, ends: [i32; 2]) -> Self;
    /// The first column on the edge or to its right, held to `ends`.
    fn column(&self, ends: [i32; 2]) -> i32;
    /// One row down.
    fn step(&mut self);
}

/// The first row whose centre lies on or below `y` (in 1/256 pixel), held to `lo..=hi`.
pub(super) fn first_row<I: ExactInt>(y: &I, lo: i32, hi: i32) -> i32 {
    // ceil((y - 128) / 256)
    y.plus(&I::from_i64(127)).div_rem_floor(&I::from_i64(256)).0.clamp_i64(lo.into(), hi.into()) as i32
}

/// One edge on its way down the rows, in numbers that cost little to add.
pub(crate) struct EdgeWalk<I> {
    /// ceil(N / D): the first column on the edge or to its right.
    column: I,
    /// What is left of N + D - 1 after dividing by D, in 0..D.
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

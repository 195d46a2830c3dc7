//! Rows of a line with round ends, from the real ends of its outline: two arcs and two sides.
//!
//! In: a segment and half of its width. Out: the pixels of a row, or `None` where rounding or the
//! rule for ties might decide: then the exact tests of [`Stroke`](super::Stroke) are asked. With the
//! upper end a and the lower end b, either side of the outline goes down an arc of the disc about a,
//! a straight side, and an arc of the disc about b; the side touches the arcs where it is as far as
//! half the width from the ends, so near these places either form gives the same.
//!
//! With numbers up to 2^16 a side that is not steeper across than [`MOST_ACROSS`] is off by at most
//! 2^-23, and an arc as [`arc_half`] says. The tests compare every row with the exact one.

use crate::draw2d::row_ends::{NEAR, RowEnds, arc_half, run_between};
use std::ops::Range;

/// Columns a row of a side, above which its ends are not computed here.
const MOST_ACROSS: f64 = 1024.0;
/// Least length of a segment, in pixels, whose direction is accurate.
const LEAST_LENGTH: f64 = 1e-9;

/// A long side of the outline, in pixels.
struct Side {
    /// Rows where it begins and ends, as real numbers.
    from: f64,
    to: f64,
    /// Its column at `from`, and the columns for each row.
    x: f64,
    slope: f64,
}

/// A stroke whose numbers are at most [`NEAR`] and whose segment has a length.
pub(super) struct NearStroke {
    top: [f64; 2],
    bottom: [f64; 2],
    r: f64,
    /// Returns whether the slope of the sides is at most [`MOST_ACROSS`].
    is_upright: bool,
    left: Side,
    right: Side,
}

impl NearStroke {
    /// Returns `None` for a stroke whose ends of rows would not be accurate.
    pub fn new(a: [f64; 2], b: [f64; 2], r: f64) -> Option<Self> {
        let (top, bottom) = if a[1] <= b[1] { (a, b) } else { (b, a) };
        let [dx, dy] = [bottom[0] - top[0], bottom[1] - top[1]];
        let length = (dx * dx + dy * dy).sqrt();
        let extent = a.iter().chain(&b).fold(r, |most: f64, v| most.max(v.abs()));
        if extent > NEAR || length < LEAST_LENGTH {
            return None;
        }
        let (across, down) = (r * dx / length, r * dy / length);
        let slope = dx / dy;
        // The left side is the segment moved by r (-dy, dx) / |d|, the right one by its opposite.
        let side = |sign: f64| Side {
            from: top[1] + sign * across,
            to: bottom[1] + sign * across,
            x: top[0] - sign * down,
            slope,
        };
        Some(NearStroke {
            top,
            bottom,
            r,
            is_upright: dx.abs() <= MOST_ACROSS * dy,
            left: side(1.0),
            right: side(-1.0),
        })
    }

    /// Returns the pixels of row `y`, or `None` if rounding leaves a doubt.
    #[inline(always)]
    pub fn row(&self, y: i32) -> Option<Range<i32>> {
        let y = f64::from(y) + 0.5;
        match (self.end(&self.left, -1.0, y), self.end(&self.right, 1.0, y)) {
            (RowEnds::Half(left), RowEnds::Half(right)) => run_between(left, right),
            (RowEnds::Nothing, _) | (_, RowEnds::Nothing) => Some(0..0),
            _ => None,
        }
    }

    /// Returns the column where a side of the outline crosses the centres of a row: of the left side
    /// (`sign` is -1) or of the right one (1).
    #[inline(always)]
    fn end(&self, side: &Side, sign: f64, y: f64) -> RowEnds {
        let [x, centre_y] = if y < side.from { self.top } else { self.bottom };
        if y >= side.from && y <= side.to {
            return match self.is_upright {
                true => RowEnds::Half(side.x + (y - side.from) * side.slope),
                false => RowEnds::Doubtful,
            };
        }
        match arc_half(self.r, y - centre_y) {
            RowEnds::Half(half) => RowEnds::Half(x + sign * half),
            other => other,
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::draw2d::raster::fractional;
    use crate::draw2d::wide_line::Stroke;
    use proptest::prelude::*;

    fn check(a: [f64; 2], b: [f64; 2], width: f64) -> Result<(), TestCaseError> {
        let stroke = Stroke::new(a, b, width);
        for y in stroke.rows(-3..1100) {
            prop_assert_eq!(stroke.row(y, 0..1920), stroke.plain_row(y, 0..1920), "row {}", y);
        }
        Ok(())
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 400, ..ProptestConfig::default() })]

        #[test]
        fn every_row_is_that_of_the_exact_tests(
            a in [fractional(), fractional()], b in [fractional(), fractional()],
            width in prop_oneof![0.0..3.0, 0.0..40.0, fractional().prop_map(f64::abs)],
            far in prop::sample::select(vec![0.0, 63_000.0, -63_000.0]),
        ) {
            check(a, b, width)?;
            check(a, [b[0] + far, b[1]], width)?;
            check(a, [b[0], b[1] + far], width)?;
            // Nearly level, nearly upright, nearly a point.
            let tilt = (b[0] - 900.0) * 1e-7;
            check(a, [b[0], a[1] + tilt], width)?;
            check(a, [a[0] + tilt, b[1]], width)?;
            check(a, [a[0] + tilt * tilt, a[1] + tilt], width)?;
        }

        #[test]
        fn sides_along_pixels_centres_are_decided_exactly(
            a in [0..800i32, 0..500i32], d in prop::sample::select(vec![[3i32, 4], [4, -3], [-12, 5], [1, 0], [0, -1], [20, 21], [1, 1]]),
            long in 1..200i32, w in 0..400i32,
        ) {
            let a = a.map(|v| f64::from(v) / 2.0);
            let b = [0, 1].map(|i| a[i] + f64::from(d[i] * long));
            check(a, b, f64::from(w) / f64::from(d[0] * d[0] + d[1] * d[1]).sqrt())?;
        }
    }
}

//! Ends of a run of pixels in a row, from the real ends of a figure there: taken where no rounding
//! can move them, refused where one might.
//!
//! In: ends computed in f64 from numbers of at most [`NEAR`], off by less than [`ERROR`]. Out: the
//! columns whose centres lie between them, or `None` if an end is so near a centre that the caller's
//! exact test must decide. An error bound that is too small would show as a pixel that differs from
//! the exact tests' answer; the tests of the figures compare all rows of random and of borderline
//! figures with it.

use std::ops::Range;

/// Largest magnitude of coordinates and radii whose ends are computed here: 2^16 pixels.
pub(super) const NEAR: f64 = 65_536.0;
/// Error of an end in pixels up to which a column is certain: 2^-16, less what fixed point rounds.
const ERROR: f64 = 1.0 / 65_536.0;
/// Fractional bits of an end in fixed point.
const BITS: u32 = 24;
const UNITS: f64 = (1u32 << BITS) as f64;
/// Distance from a pixel's centre, in units of fixed point, within which an end is doubtful.
const DOUBT: i64 = (ERROR * UNITS) as i64;

/// Returns the first column whose centre lies to the right of `x`, `None` if one is too near.
#[inline(always)]
fn column(x: f64) -> Option<i32> {
    // Centres are half-way between integers. `as` saturates, and so far out all ends are doubtless.
    let from_centre = (x * UNITS) as i64 + (1 << (BITS - 1));
    let fraction = from_centre & ((1 << BITS) - 1);
    let is_certain = (DOUBT..(1 << BITS) - DOUBT).contains(&fraction);
    is_certain.then_some((from_centre >> BITS) as i32)
}

/// Returns the columns whose centres lie between two ends.
#[inline(always)]
pub(super) fn run_between(left: f64, right: f64) -> Option<Range<i32>> {
    Some(column(left)?..column(right)?)
}

/// Returns the columns of a run among `xs`; `0..0` if there are none.
#[inline(always)]
pub(super) fn clipped(run: Range<i32>, xs: Range<i32>) -> Range<i32> {
    let (start, end) = (run.start.max(xs.start), run.end.min(xs.end));
    if start < end { start..end } else { 0..0 }
}

/// The columns of a row that a disc covers.
pub(super) enum RowEnds {
    /// Half of its chord.
    Half(f64),
    /// No point.
    Nothing,
    /// The chord is so short that its length is uncertain.
    Doubtful,
}

/// Returns half of the chord of a disc of radius `r` at the distance `dy` from its centre.
///
/// With numbers up to [`NEAR`], `dy` is off by at most 2^-37 and the half's square by 2^-19, so that
/// above 1/4 the half is off by at most 2^-19.
#[inline(always)]
pub(super) fn arc_half(r: f64, dy: f64) -> RowEnds {
    match (r - dy) * (r + dy) {
        square if square >= 0.25 => RowEnds::Half(square.sqrt()),
        square if square < -0.01 => RowEnds::Nothing,
        _ => RowEnds::Doubtful,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_end_is_certain_unless_a_centre_is_near() {
        for (x, want) in [
            (0.0, Some(0)),
            (0.49, Some(0)),
            (0.5, None),
            (0.51, Some(1)),
            (0.5 + ERROR / 2.0, None),
            (0.5 - ERROR / 2.0, None),
            (0.5 + ERROR * 2.0, Some(1)),
            (0.5 - ERROR * 2.0, Some(0)),
            (-0.49, Some(0)),
            (-0.51, Some(-1)),
            (-3.5, None),
            (131_071.9, Some(131_072)),
            (f64::NAN, Some(0)),
        ] {
            assert_eq!(column(x), want, "{x}");
        }
        assert_eq!(run_between(1.0, 3.7), Some(1..4));
        let backwards = std::ops::Range { start: 4, end: 2 };
        assert_eq!((clipped(1..9, 3..5), clipped(7..9, 3..5), clipped(backwards, 0..9)), (3..5, 0..0, 0..0));
    }
}

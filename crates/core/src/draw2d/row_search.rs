//! Ends of runs of pixels in a row, found by an exact test: estimated in f64, then corrected.
//!
//! In: a range of columns, an estimate, a test that changes once along the row. Out: where it
//! changes. The test alone decides, so a bad estimate costs time and no exactness.

use std::cmp::Ordering;
use std::ops::Range;

/// Returns the least x of `xs` for which `holds` is true, `xs.end` if there is none. `holds` is
/// false, then true along the row; `guess` is about where it changes.
pub(super) fn first_where(xs: Range<i32>, guess: f64, holds: impl Fn(i32) -> bool) -> i32 {
    let is_first = |x: i32| (x == xs.end || holds(x)) && (x == xs.start || !holds(x - 1));
    let guess = (guess.ceil() as i32).clamp(xs.start, xs.end);
    for near in [guess, guess - 1, guess + 1] {
        if xs.start <= near && near <= xs.end && is_first(near) {
            return near;
        }
    }
    let (mut low, mut high) = (xs.start, xs.end);
    while low < high {
        let middle = low + (high - low) / 2;
        if holds(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    high
}

/// Returns the pixels of `xs` for which `holds` is true: those from the column on where it becomes
/// true if it rises along the row, those before the column where it becomes false if it falls.
pub(super) fn half_row(xs: Range<i32>, guess: f64, rises: bool, holds: impl Fn(i32) -> bool) -> Range<i32> {
    match rises {
        true => first_where(xs.clone(), guess, holds)..xs.end,
        false => xs.start..first_where(xs.clone(), guess, |x| !holds(x)),
    }
}

/// Returns the pixels of `xs` for which `holds` is true, which are neighbours of `nearest`: empty
/// if it does not hold there. `ends` are about the first and the last of them.
pub(super) fn run_about(
    nearest: i32,
    xs: Range<i32>,
    ends: [f64; 2],
    holds: impl Fn(i32) -> bool,
) -> Range<i32> {
    if xs.is_empty() || !holds(nearest) {
        return 0..0;
    }
    let start = first_where(xs.start..nearest, ends[0], &holds);
    let end = first_where(nearest + 1..xs.end, ends[1] + 1.0, |x| !holds(x));
    start..end
}

/// Returns the columns that are in both ranges.
pub(super) fn both(a: &Range<i32>, b: &Range<i32>) -> Range<i32> {
    a.start.max(b.start)..a.end.min(b.end)
}

/// Sorts ranges, joins those that touch, and removes empty ones.
pub(super) fn join(ranges: &mut Vec<Range<i32>>) {
    ranges.retain(|range| !range.is_empty());
    ranges.sort_unstable_by_key(|range| range.start);
    ranges.dedup_by(|next, range| {
        let touches = next.start <= range.end;
        if touches {
            range.end = range.end.max(next.end);
        }
        touches
    });
}

/// Returns the rows of `ys` that a figure from `low` to `high` may touch, widened by more than the
/// rounding of sums with terms up to `extent`.
pub(super) fn rows_between(low: f64, high: f64, extent: f64, ys: Range<i32>) -> Range<i32> {
    let slack = 2.0 + extent * 1e-15;
    // `as` saturates to i32, so that one row more cannot overflow.
    let first = ((low - slack) as i32).clamp(ys.start, ys.end);
    let end = ((high + slack) as i32).saturating_add(1).clamp(first, ys.end);
    first..end
}

/// Relative error above which a sum of two products of rounded differences is never off.
const ROUNDING: f64 = 2e-15;
/// Absolute error that underflow may add to such a sum.
const UNDERFLOW: f64 = 1e-290;

/// Returns the sign of a b + c d if its rounding leaves no doubt. The factors may be off by a few
/// roundings themselves.
pub(super) fn sign_of_sum([a, b]: [f64; 2], [c, d]: [f64; 2]) -> Option<Ordering> {
    let (p, q) = (a * b, c * d);
    let error = (p.abs() + q.abs()) * ROUNDING + UNDERFLOW;
    let sum = p + q;
    match sum.is_finite() && error.is_finite() && sum.abs() > error {
        true => sum.partial_cmp(&0.0),
        false => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_change_is_found_from_any_guess() {
        for change in -3..14 {
            for guess in [-1e30, -4.0, 0.0, 3.4, 5.0, 9.0, 1e30, f64::NAN, f64::INFINITY] {
                let found = first_where(2..9, guess, |x| x >= change);
                assert_eq!(found, change.clamp(2, 9), "{change} {guess}");
                assert_eq!(half_row(2..9, guess, false, |x| x < change), 2..change.clamp(2, 9));
            }
        }
        assert_eq!(run_about(4, 0..9, [1e9, -1e9], |x| (3..7).contains(&x)), 3..7);
        assert_eq!(run_about(0, 0..9, [0.0, 0.0], |x| x < 9), 0..9);
        assert!(run_about(4, 0..9, [0.0, 0.0], |_| false).is_empty());
    }

    #[test]
    fn ranges_are_joined_where_they_touch() {
        let mut ranges = vec![5..7, 1..2, 2..4, 9..9, 6..12];
        join(&mut ranges);
        assert_eq!(ranges, [1..4, 5..12]);
    }
}

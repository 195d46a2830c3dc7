//! Stepper for an edge between far points, at the cost of a near one.
//!
//! It computes the columns of [`EdgeWalk`](super::edge_walk::EdgeWalk) for coordinates of any size:
//! the first column in row k is floor((N' + k S) / D) with N' = N + D - 1. An edge's columns are
//! monotonic, so its rows fall into parts, found by bisection: those before it enters the clip
//! columns, those inside, those after. The first and last part have one column. Inside, an edge
//! that moves by at most one column has two; any other is stepped in fixed point, and the exact
//! remainder is compared only where the fixed-point value is too near to an integer to decide its
//! side.
//!
//! Verified by the tests, which compare with `EdgeWalk` on the same numbers.

use super::edge_walk::Walk;
use super::exact_int::ExactInt;
use num_bigint::BigInt;
use std::cmp::Ordering;
use std::ops::Range;

/// Number of fractional bits.
const FRACTION_BITS: u32 = 56;

/// Edge stepped down the rows in integers of any size.
#[derive(Debug)]
pub struct FarEdgeWalk {
    /// Row relative to the first one.
    row: i64,
    /// Remaining parts of the rows, the last one first; none is empty.
    parts: Vec<Part>,
}

/// Rows up to `end`, relative to the first row.
#[derive(Debug)]
struct Part {
    end: i64,
    course: Course,
}

#[derive(Debug)]
enum Course {
    Level(i32),
    Sloped(Box<Sloped>),
}

/// Rows in which the edge crosses columns.
#[derive(Debug)]
struct Sloped {
    start: i64,
    /// Column of the first row, and the remainder of the numerator.
    column: i64,
    rest: BigInt,
    step_column: i64,
    step_rest: BigInt,
    divisor: BigInt,
    /// Column in fixed point: never below the exact value, and less than 2 `slack` above it.
    value: i128,
    step: i128,
    slack: i128,
}

/// Equation of an edge: N', S and D, and the clip columns.
struct EdgeEquation {
    n: BigInt,
    s: BigInt,
    d: BigInt,
    lo: i32,
    hi: i32,
}

impl EdgeEquation {
    /// Returns whether the column of row k is below `column`.
    fn is_below(&self, k: i64, column: i64) -> bool {
        self.n.compare_stepped(k, &self.s, column, &self.d) == Ordering::Less
    }

    /// Returns the column of row k, clamped to the clip columns.
    fn column(&self, k: i64) -> i32 {
        let (column, _) = (&self.n + &self.s * k).div_rem_floor(&self.d);
        column.clamp_i64(self.lo.into(), self.hi.into()) as i32
    }
}

/// Returns the first row of `rows` for which `holds`, if it holds from there on; their end if it
/// never does.
fn first(rows: &Range<i64>, holds: impl Fn(i64) -> bool) -> i64 {
    let (mut low, mut high) = (rows.start, rows.end);
    while low < high {
        let middle = low.midpoint(high);
        if holds(middle) {
            high = middle;
        } else {
            low = middle + 1;
        }
    }
    low
}

impl Walk<BigInt> for FarEdgeWalk {
    fn new(top: &[BigInt; 2], bottom: &[BigInt; 2], rows: Range<i32>, [lo, hi]: [i32; 2]) -> Self {
        let (dx, dy) = (&bottom[0] - &top[0], &bottom[1] - &top[1]);
        let centre = BigInt::from(i64::from(rows.start) * 256 + 128);
        let d: BigInt = &dy * 256;
        let n: BigInt = (&top[0] - 128) * &dy + (centre - &top[1]) * &dx + &d - 1;
        let edge = EdgeEquation { n, s: dx * 256, d, lo, hi };
        let all = 0..i64::from(rows.end) - i64::from(rows.start);
        // Columns rise or fall monotonically; those at the ends and beyond are clamped alike.
        let is_low = |k: i64| edge.is_below(k, i64::from(lo) + 1);
        let is_high = |k: i64| !edge.is_below(k, i64::from(hi));
        let (inside, [before, after]) = match edge.s.signum_order() {
            Ordering::Less => (first(&all, |k| !is_high(k))..first(&all, is_low), [hi, lo]),
            _ => (first(&all, |k| !is_low(k))..first(&all, is_high), [lo, hi]),
        };
        let mut parts = Vec::with_capacity(4);
        let mut put = |end: i64, course: Course| {
            if parts.last().map_or(0, |p: &Part| p.end) < end {
                parts.push(Part { end, course });
            }
        };
        put(inside.start.min(inside.end), Course::Level(before));
        if !inside.is_empty() {
            let [from, to] = [inside.start, inside.end - 1].map(|k| edge.column(k));
            if (from - to).abs() <= 1 {
                put(first(&inside, |k| edge.column(k) != from), Course::Level(from));
                put(inside.end, Course::Level(to));
            } else {
                put(inside.end, Course::Sloped(Box::new(Sloped::new(&edge, &inside))));
            }
        }
        put(all.end, Course::Level(after));
        parts.reverse();
        FarEdgeWalk { row: 0, parts }
    }

    fn column(&self, _: [i32; 2]) -> i32 {
        match self.parts.last().map(|p| &p.course) {
            Some(Course::Level(column)) => *column,
            Some(Course::Sloped(sloped)) => sloped.column(self.row),
            // Not called beyond the last row.
            None => 0,
        }
    }

    fn step(&mut self) {
        self.row += 1;
        match self.parts.last_mut() {
            Some(part) if self.row >= part.end => drop(self.parts.pop()),
            Some(Part { course: Course::Sloped(sloped), .. }) => sloped.value += sloped.step,
            _ => {}
        }
    }
}

impl Sloped {
    /// Prepares `rows` of an edge whose columns there are all inside the clip columns.
    fn new(edge: &EdgeEquation, rows: &Range<i64>) -> Self {
        let (column, rest) = (&edge.n + &edge.s * rows.start).div_rem_floor(&edge.d);
        let (step_column, step_rest) = edge.s.div_rem_floor(&edge.d);
        let fixed = |integer: i64, rest: &BigInt| {
            (i128::from(integer) << FRACTION_BITS) + i128::from(rest.fraction_56(&edge.d))
        };
        // Within i32, as the columns of at least two rows are inside.
        let [column, step_column] = [column, step_column].map(|v| v.clamp_i64(-(1 << 33), 1 << 33));
        // Fractions are less than 2 ulp below the exact value, that of the start and those of the
        // steps so far.
        let slack = 2 * (i128::from(rows.end - rows.start) + 1);
        Sloped {
            start: rows.start,
            value: fixed(column, &rest) + slack,
            step: fixed(step_column, &step_rest),
            slack,
            column,
            rest,
            step_column,
            step_rest,
            divisor: edge.d.clone(),
        }
    }

    fn column(&self, row: i64) -> i32 {
        let column = (self.value >> FRACTION_BITS) as i64;
        if self.value & ((1 << FRACTION_BITS) - 1) >= self.slack {
            return column as i32;
        }
        // The slack may have lifted it over an integer.
        let steps = row - self.start;
        let missing = column - self.column - steps * self.step_column;
        let order = self.rest.compare_stepped(steps, &self.step_rest, missing, &self.divisor);
        (column - i64::from(order == Ordering::Less)) as i32
    }
}

#[cfg(test)]
mod tests {
    use super::super::edge_walk::EdgeWalk;
    use super::super::exact_int::snap_big;
    use super::*;
    use proptest::prelude::*;

    /// Integers, halves and fractions near the frame; multiples of a power of ten; any number.
    fn coordinate() -> impl Strategy<Value = f64> {
        prop_oneof![
            3 => (-80i32..400).prop_map(|v| f64::from(v) / 2.0),
            2 => -300.0..600.0f64,
            2 => (-4i32..=4, prop::sample::select(vec![9, 15, 16, 17, 30, 300])).prop_map(|(m, e)| f64::from(m) * 10f64.powi(e)),
            2 => (-1.0..1.0f64, 3i32..=308).prop_map(|(m, e)| m * 10f64.powi(e)),
            1 => prop::sample::select(vec![f64::MAX, -f64::MAX, 0.0, 5e-324]),
        ]
    }

    fn check(a: [f64; 2], b: [f64; 2], rows: Range<i32>, ends: [i32; 2]) {
        let [a, b] = [a, b].map(|p| p.map(snap_big));
        let (top, bottom) = match a[1].cmp(&b[1]) {
            Ordering::Equal => return,
            Ordering::Less => (a, b),
            Ordering::Greater => (b, a),
        };
        let mut far = FarEdgeWalk::new(&top, &bottom, rows.clone(), ends);
        let mut plain: EdgeWalk<BigInt> = EdgeWalk::new(&top, &bottom, rows.clone(), ends);
        for row in rows {
            assert_eq!(far.column(ends), plain.column(ends), "row {row} of {top:?} to {bottom:?}");
            far.step();
            plain.step();
        }
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

        #[test]
        fn every_row_has_the_column_of_the_plain_walk(
            a in [coordinate(), coordinate()], b in [coordinate(), coordinate()],
            row in -5i32..50, count in 1i32..150, lo in -3i32..20, width in 1i32..300,
        ) {
            check(a, b, row..row + count, [lo, lo + width]);
        }

        #[test]
        fn edges_through_pixel_centres_are_decided_there(
            x in 0i32..60, y in 0i32..60, dx in -3i32..=3, dy in 1i32..=5, far in 3i32..=300, hair in -1i32..=1,
        ) {
            // Through the centre of (x, y), or a pixel beside it at a far end.
            let m = 10f64.powi(far);
            let at = |sign: f64| [f64::from(x) + 0.5 + sign * f64::from(dx) * m, f64::from(y) + 0.5 + sign * f64::from(dy) * m];
            let (a, mut b) = (at(-1.0), at(1.0));
            b[0] += f64::from(hair);
            check(a, b, 0..70, [0, 64]);
        }
    }
}

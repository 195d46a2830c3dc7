//! Arithmetic on a vector of faces: edge functions, coverage of tiny boxes, order of corners.
//!
//! Helpers are functions marked for inlining, not closures: a closure would be compiled without the
//! level's instructions.

use super::bins::{Small, TINY_SIDE};
use crate::simd::{F32, I32, Mask, Simd};
use std::ops::Range;

/// Returns the edge function from a to b at a pixel's centre, biased so that >= 0 is inside, and
/// its steps per column and row.
#[inline(always)]
pub(super) fn edge<S: Simd>(
    s: S,
    is_counter: S::M,
    (xa, ya): (S::I, S::I),
    (xb, yb): (S::I, S::I),
    (px, py): (S::I, S::I),
) -> (S::I, S::I, S::I) {
    let none = s.splat_i(0);
    let (dx, dy) = (xb - xa, yb - ya);
    let (dx, dy) = (s.select_i(is_counter, none - dx, dx), s.select_i(is_counter, none - dy, dy));
    // e(p) = dx * (py - ya) - dy * (px - xa), 1/65536 pixel^2; right and bottom edges do not own
    // their centres.
    let e = dx * (py - ya) - dy * (px - xa);
    let is_left = none.gt(dy);
    let is_top = dy.eq(none) & dx.gt(none);
    let bias = s.select_i(is_left | is_top, none, s.splat_i(-1));
    ((e + bias).sar::<8>(), none - dy, dx)
}

/// Returns the coverage of 8x8 pixels: rows 0 to 3 in the first word, 4 to 7 in the second, 8 bits
/// for each row.
#[inline(always)]
pub(super) fn coverage<S: Simd>(
    s: S,
    live: S::M,
    (columns, rows): (S::I, S::I),
    edges: [S::I; 3],
    steps_x: [S::I; 3],
    steps_y: [S::I; 3],
) -> (S::I, S::I) {
    let none = s.splat_i(0);
    let mut words = [none, none];
    let [mut r0, mut r1, mut r2] = edges;
    let mut row = 0;
    while row < TINY_SIDE {
        let in_row = live & rows.gt(s.splat_i(row));
        if !in_row.any() {
            break;
        }
        let (mut e0, mut e1, mut e2) = (r0, r1, r2);
        let mut word = none;
        let mut bit = 1 << ((row & 3) * 8);
        let mut column = 0;
        while column < TINY_SIDE {
            let inside = in_row & columns.gt(s.splat_i(column));
            if !inside.any() {
                break;
            }
            let covered = inside & (e0 | e1 | e2).gt(s.splat_i(-1));
            word = s.select_i(covered, word | s.splat_i(bit), word);
            (e0, e1, e2) = (e0 + steps_x[0], e1 + steps_x[1], e2 + steps_x[2]);
            bit = ((bit as u32) << 1) as i32;
            column += 1;
        }
        words[(row >> 2) as usize] = words[(row >> 2) as usize] | word;
        (r0, r1, r2) = (r0 + steps_y[0], r1 + steps_y[1], r2 + steps_y[2]);
        row += 1;
    }
    (words[0], words[1])
}

/// Edge functions of a small face at a vector of columns, row by row.
pub(super) struct Edges<S: Simd> {
    at: [S::I; 3],
    steps_y: [S::I; 3],
    columns: S::M,
}

impl<S: Simd> Edges<S> {
    /// Evaluates them at LANES columns from `start` on, of which only those in `counted` are
    /// reported, and at row `y`.
    #[inline(always)]
    pub fn new(s: S, face: &Small, start: i32, counted: Range<i32>, y: i32) -> Self {
        let lanes = S::LANES as i32;
        let column = s.iota() + s.splat_i(start - i32::from(face.bounds[0]));
        let down = y - i32::from(face.bounds[1]);
        let ([e0, e1, e2], [x0, x1, x2], [y0, y1, y2]) = (face.edges, face.steps_x, face.steps_y);
        let to = (counted.end - start).min(lanes);
        Edges {
            at: [
                s.splat_i(x0) * column + s.splat_i(e0 + y0 * down),
                s.splat_i(x1) * column + s.splat_i(e1 + y1 * down),
                s.splat_i(x2) * column + s.splat_i(e2 + y2 * down),
            ],
            steps_y: [s.splat_i(y0), s.splat_i(y1), s.splat_i(y2)],
            columns: s.mask((u32::MAX << (counted.start - start)) & (((1u64 << to) - 1) as u32)),
        }
    }

    /// Returns the columns that the row covers, and steps to the next row.
    #[inline(always)]
    pub fn covered(&mut self, s: S) -> S::M {
        let [e0, e1, e2] = self.at;
        let [y0, y1, y2] = self.steps_y;
        self.at = [e0 + y0, e1 + y1, e2 + y2];
        (e0 | e1 | e2).gt(s.splat_i(-1)) & self.columns
    }
}

/// Returns the number of set bits, lane by lane.
#[inline(always)]
pub(super) fn ones<S: Simd>(s: S, word: S::I) -> S::I {
    let (pairs, fours, eights) = (s.splat_i(0x5555_5555), s.splat_i(0x3333_3333), s.splat_i(0x0f0f_0f0f));
    let word = word - (word.shr::<1>() & pairs);
    let word = (word & fours) + (word.shr::<2>() & fours);
    let bytes = (word + word.shr::<4>()) & eights;
    let halves = bytes + bytes.shr::<8>();
    (halves + halves.shr::<16>()) & s.splat_i(0x3f)
}

/// Returns the number of set lanes.
#[inline(always)]
pub(super) fn count_of<S: Simd>(mask: S::M) -> u64 {
    mask.bits().count_ones() as u64
}

/// Returns the least and the greatest of three vectors, lane by lane.
#[inline(always)]
pub(super) fn bounds3<S: Simd>(a: S::I, b: S::I, c: S::I) -> (S::I, S::I) {
    (a.min(b).min(c), a.max(b).max(c))
}

/// Returns a screen vertex's position snapped to 1/256 pixel.
#[inline(always)]
pub(super) fn snapped<S: Simd>(s: S, r: [S::F; 4]) -> (S::I, S::I) {
    let (up, one) = (r[3].bits(), s.splat_i(1));
    (r[0].bits().sar::<8>() + (up & one), r[1].bits().sar::<8>() + (up.shr::<1>() & one))
}

/// Corner of a face: position in 1/65536 pixel, and the bits of its depth.
pub(super) type Corner<S> = [<S as Simd>::I; 3];

/// Returns the corner of a screen vertex.
#[inline(always)]
pub(super) fn corner<S: Simd>(r: [S::F; 4]) -> Corner<S> {
    [r[0].bits(), r[1].bits(), r[2].bits()]
}

/// Returns q - p in pixels.
#[inline(always)]
pub(super) fn pixels<S: Simd>(s: S, p: S::I, q: S::I) -> S::F {
    (q - p).to_f32() * s.splat(1.0 / 65536.0)
}

/// Sorts the corners in ascending order of (x, y), lane by lane.
#[inline(always)]
pub(super) fn sort_corners<S: Simd>(s: S, [a, b, c]: [Corner<S>; 3]) -> [Corner<S>; 3] {
    let (a, b) = in_order(s, a, b);
    let (b, c) = in_order(s, b, c);
    let (a, b) = in_order(s, a, b);
    [a, b, c]
}

/// Returns two corners in ascending order of (x, y), lane by lane.
#[inline(always)]
pub(super) fn in_order<S: Simd>(s: S, p: Corner<S>, q: Corner<S>) -> (Corner<S>, Corner<S>) {
    let swap = p[0].gt(q[0]) | (p[0].eq(q[0]) & p[1].gt(q[1]));
    let low = [s.select_i(swap, q[0], p[0]), s.select_i(swap, q[1], p[1]), s.select_i(swap, q[2], p[2])];
    let high = [s.select_i(swap, p[0], q[0]), s.select_i(swap, p[1], q[1]), s.select_i(swap, p[2], q[2])];
    (low, high)
}

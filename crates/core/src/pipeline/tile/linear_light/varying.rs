//! Numbers and directions that vary over a block of pixels, with bounds on their derivatives along its
//! two sides, in units of the sides ([`super`] has the formulas).

use crate::pipeline::tile::lighting::{Exponent, V3, dot, power, scale};
use crate::simd::{F32, Simd};

/// Added to angles: what f32 loses of them, for lights no nearer than a 64th of the eye's distance.
pub(super) const ROUNDING: f32 = 2e-5;

/// Least length of a vector, so that none is divided by 0.
pub(super) const LEAST: f32 = 1e-18;

/// Length of a vector below which f32 loses the square of what it turns by.
pub(super) const SHORT: f32 = 1e-7;

/// Bound that nothing is within.
pub(super) const UNKNOWN: f32 = f32::INFINITY;

/// Columns and rows of a block.
pub(in crate::pipeline::tile) const BLOCK: [usize; 2] = [32, 8];

/// Parts of a block's width and height that a pixel has.
const PIXEL_PARTS: [f32; 2] = [1.0 / BLOCK[0] as f32, 1.0 / BLOCK[1] as f32];

/// Bounds on errors over cells of one pixel: a part that grows with the square of the cell's side, and
/// one that grows with the side.
#[derive(Clone, Copy)]
pub(in crate::pipeline::tile) struct CellErrors<S: Simd> {
    pub by_square: S::F,
    pub by_side: S::F,
}

impl<S: Simd> CellErrors<S> {
    /// Returns the bound for cells of this many columns and rows, of which a block has whole ones.
    #[inline(always)]
    pub fn of_cell(&self, s: S, side: usize) -> S::F {
        let side = s.splat(side as f32);
        (self.by_square * side + self.by_side) * side
    }
}

/// Unit vectors at the corners, and bounds on their first and second derivative over the block, along
/// its two sides.
#[derive(Clone, Copy)]
pub(super) struct Direction<S: Simd> {
    pub at: [V3<S>; 4],
    pub first: [S::F; 2],
    pub second: [S::F; 2],
}

/// A number that varies over a block: its values at the corners, its range, and bounds on its
/// derivatives.
#[derive(Clone, Copy)]
pub(super) struct Varying<S: Simd> {
    pub at: [S::F; 4],
    pub low: S::F,
    pub high: S::F,
    pub first: [S::F; 2],
    pub second: [S::F; 2],
}

// Helpers are functions marked for inlining, not closures: a closure would be compiled without the
// level's instructions.

/// Returns the unit vectors of vectors that are linear over the screen.
#[inline(always)]
pub(super) fn direction<S: Simd>(s: S, v: &[V3<S>; 4]) -> Direction<S> {
    let (one, half) = (s.splat(1.0), s.splat(0.5));
    let mut at = *v;
    let mut least = s.splat(f32::INFINITY);
    let mut corner = 0;
    while corner < 4 {
        let length = length::<S>(v[corner]).max(s.splat(LEAST));
        least = length.min(least);
        at[corner] = scale::<S>(v[corner], one / length);
        corner += 1;
    }
    let (mut steps, mut turned) = ([least; 2], [least; 2]);
    let mut side = 0;
    while side < 2 {
        let [[a, b], [c, d]] = EDGES[side];
        let (upper, lower) = (subtract::<S>(v[b], v[a]), subtract::<S>(v[d], v[c]));
        steps[side] = length::<S>(upper).max(length::<S>(lower));
        turned[side] = length::<S>(cross::<S>(v[a], v[b])).max(length::<S>(cross::<S>(v[c], v[d])));
        side += 1;
    }
    let inverse = one / (least - (steps[0] + steps[1]) * half).max(s.splat(LEAST));
    let (mut first, mut second) = (steps, steps);
    let is_short = least.lt(s.splat(SHORT));
    let mut side = 0;
    while side < 2 {
        let turn = turned[side] * inverse * inverse + s.splat(ROUNDING);
        let stretch = steps[side] * inverse;
        first[side] = turn;
        second[side] = s.select(is_short, s.splat(UNKNOWN), (stretch + stretch) * turn + turn * turn);
        side += 1;
    }
    Direction { at, first, second }
}

/// Returns the cosine between two directions.
#[inline(always)]
pub(super) fn cosine<S: Simd>(s: S, a: &Direction<S>, b: &Direction<S>) -> Varying<S> {
    let two = s.splat(2.0);
    let (mut at, mut first, mut second) = ([two; 4], [two; 2], [two; 2]);
    let mut corner = 0;
    while corner < 4 {
        at[corner] = dot::<S>(a.at[corner], b.at[corner]);
        corner += 1;
    }
    let mut side = 0;
    while side < 2 {
        let ([a1, a2], [b1, b2]) = (of_side(a, side), of_side(b, side));
        first[side] = a1 + b1;
        second[side] = a2 + two * (a1 * b1) + b2;
        side += 1;
    }
    varying(s, at, first, second)
}

/// Returns a number with these values at the corners and bounds on its derivatives.
#[inline(always)]
pub(super) fn varying<S: Simd>(s: S, at: [S::F; 4], first: [S::F; 2], second: [S::F; 2]) -> Varying<S> {
    // No point is farther than half a side from the nearest corner.
    let reach = (first[0] + first[1]) * s.splat(0.5);
    let low = at[0].min(at[1]).min(at[2]).min(at[3]) - reach;
    let high = at[0].max(at[1]).max(at[2]).max(at[3]) + reach;
    Varying { at, low, high, first, second }
}

/// Returns a number that does not vary.
#[inline(always)]
pub(super) fn constant<S: Simd>(s: S, value: f32) -> Varying<S> {
    let (value, flat) = (s.splat(value), [s.splat(0.0); 2]);
    Varying { at: [value; 4], low: value, high: value, first: flat, second: flat }
}

/// Returns the derivatives of a product; its range is not known.
#[inline(always)]
pub(super) fn product<S: Simd>(s: S, a: &Varying<S>, b: &Varying<S>) -> Varying<S> {
    let (a0, b0) = (a.low.abs().max(a.high.abs()), b.low.abs().max(b.high.abs()));
    let mut out = *a;
    let mut side = 0;
    while side < 2 {
        let (a1, b1) = (a.first[side], b.first[side]);
        out.first[side] = a1 * b0 + b1 * a0;
        out.second[side] = (a.second[side] * b0 + b.second[side] * a0) + s.splat(2.0) * (a1 * b1);
        side += 1;
    }
    out.high = a0 * b0;
    out.low = -out.high;
    out
}

/// Returns the error of the interpolation of a number over a cell of one pixel; it grows with the square
/// of the cell's side.
#[inline(always)]
pub(super) fn curvature<S: Simd>(s: S, of: &Varying<S>) -> S::F {
    let [w, h] = PIXEL_PARTS;
    of.second[0] * s.splat(w * w / 8.0) + of.second[1] * s.splat(h * h / 8.0)
}

/// Returns the error that the kink of max(x, 0) at 0 adds in a cell of one pixel; it grows with the
/// cell's side.
#[inline(always)]
pub(super) fn kink<S: Simd>(s: S, x: &Varying<S>) -> S::F {
    let zero = s.splat(0.0);
    let [w, h] = PIXEL_PARTS;
    let quarter = x.first[0] * s.splat(w / 4.0) + x.first[1] * s.splat(h / 4.0);
    s.select(x.low.lt(zero) & zero.lt(x.high), quarter, zero)
}

/// Returns a number whose derivatives have no bound outside of a mask.
#[inline(always)]
pub(super) fn known_where<S: Simd>(s: S, mask: S::M, mut v: Varying<S>) -> Varying<S> {
    let mut side = 0;
    while side < 2 {
        v.second[side] = s.select(mask, v.second[side], s.splat(UNKNOWN));
        side += 1;
    }
    v
}

/// Returns `a` in the lanes of a mask and `b` in the others.
#[inline(always)]
pub(super) fn selected<S: Simd>(s: S, mask: S::M, a: &Varying<S>, b: &Varying<S>) -> Varying<S> {
    let mut out = *b;
    let mut side = 0;
    while side < 2 {
        out.first[side] = s.select(mask, a.first[side], b.first[side]);
        out.second[side] = s.select(mask, a.second[side], b.second[side]);
        side += 1;
    }
    out.low = s.select(mask, a.low, b.low);
    out.high = s.select(mask, a.high, b.high);
    out
}

/// Returns the bounds on the derivatives along a side.
#[inline(always)]
pub(super) fn of_side<S: Simd>(d: &Direction<S>, side: usize) -> [S::F; 2] {
    [d.first[side], d.second[side]]
}

/// Corners of the two edges along each side of a block.
pub(super) const EDGES: [[[usize; 2]; 2]; 2] = [[[0, 1], [2, 3]], [[0, 2], [1, 3]]];

/// Returns max(x, 0)^n for x of at most about 1.
#[inline(always)]
pub(super) fn raised<S: Simd>(s: S, x: &Varying<S>, exponent: Exponent) -> Varying<S> {
    let n = match exponent {
        Exponent::Integer(0) => return constant(s, 1.0),
        Exponent::Integer(n) => n as f32,
        Exponent::Real(n) => n,
    };
    if n == 1.0 {
        return known_where(s, s.splat(0.0).lt(x.low), *x);
    }
    // Below 2 the second derivative has no bound near 0.
    if n < 2.0 {
        return known_where(s, s.mask(0), *x);
    }
    let most = x.high.min(s.splat(1.0)).max(s.splat(0.1));
    let raised = power(s, most, exponent);
    let slope = s.splat(n) * raised / most;
    let bend = s.splat(n - 1.0) * slope / most;
    let mut out = *x;
    let mut side = 0;
    while side < 2 {
        let (x1, x2) = (x.first[side], x.second[side]);
        out.first[side] = slope * x1;
        out.second[side] = slope * x2 + bend * (x1 * x1);
        side += 1;
    }
    out.low = s.splat(0.0);
    out.high = raised;
    out
}

#[inline(always)]
pub(super) fn length<S: Simd>(v: V3<S>) -> S::F {
    dot::<S>(v, v).sqrt()
}

#[inline(always)]
pub(super) fn subtract<S: Simd>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
pub(super) fn cross<S: Simd>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

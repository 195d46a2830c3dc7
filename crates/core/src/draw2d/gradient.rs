//! Exactly interpolated colours of a triangle: rows of fixed-point ramps, and integers where
//! rounding leaves a doubt.
//!
//! In: snapped corners in 1/256 pixel, a colour for each. Out: painted spans of the visible rows,
//! on the caller's thread.
//!
//! The exact colour of a covered pixel with centre P is, in each channel, floor(V) with V = N / D,
//! N = 2 (c0 E0 + c1 E1 + c2 E2) + A and D = 2 A, where E_i is twice the area of the triangle of P
//! and the two snapped corners after i, and A = E0 + E1 + E2 twice the area of the full triangle.
//! The tests compare with this formula, evaluated at each pixel in arbitrary precision.
//!
//! A row costs one exact N, then one addition for each pixel and channel. Corners far outside the
//! frame make D so large that a ramp may be too near an integer to decide the side, in every pixel
//! of the frame when V hardly changes across it. Such a row is handled in two ways:
//! - A channel whose V moves by less than 1 along the row takes at most two values, and V is
//!   monotonic: the exact formula at both ends gives them, and bisection finds where one changes to
//!   the other.
//! - Any other channel passes at most 255 integers, each within one pixel: those pixels are decided
//!   by the exact remainder, which is affine too and whose sign costs one pass over its digits.
//!
//! So a row's exact work is bounded by the steps of its colours, wherever the corners are.

use super::band::Band;
use super::color_ramp::{ColorRamp, FRACTION_BITS};
use super::ramp_row::compose_ramp;
use super::{Blend, over};
use crate::math::coverage::exact_int::ExactInt;
use crate::math::coverage::{Corners, doubled_area, scan_triangle};
use crate::memory::Rgba;
use std::cmp::Ordering;

/// A fraction N / D as floor(N / D) and the remainder N mod D, in 0..D.
struct Divided<I> {
    quotient: i64,
    rest: I,
}

/// The exact colours of one triangle.
struct Gradient<I: ExactInt> {
    /// Corners, clockwise on the screen, so that every weight of a covered pixel is positive.
    corners: Corners<I>,
    /// Colour of each corner, by channel.
    colors: [[I; 4]; 3],
    /// A, twice the area of the triangle.
    area: I,
    /// D = 2 A.
    divisor: I,
    /// 1 / D, as far as it saves divisions.
    reciprocal: I::Reciprocal,
}

impl<I: ExactInt> Gradient<I> {
    /// Returns `None` for a triangle without area.
    fn new(corners: &Corners<I>, colors: [Rgba; 3]) -> Option<Self> {
        let colors = colors.map(|c| c.map(|v| I::from_i64(v.into())));
        let area = doubled_area(corners);
        let ([a, b, c], [ca, cb, cc]) = (corners.clone(), colors);
        let (corners, colors, area) = match area.signum_order() {
            Ordering::Equal => return None,
            Ordering::Greater => ([a, b, c], [ca, cb, cc], area),
            Ordering::Less => ([a, c, b], [ca, cc, cb], I::from_i64(0).minus(&area)),
        };
        let divisor = area.plus(&area);
        let reciprocal = divisor.reciprocal();
        Some(Gradient { corners, colors, area, divisor, reciprocal })
    }

    /// Returns V of each channel at the covered pixel (x, y): 1/2 <= V < 256.
    ///
    /// Inlined, with all that it calls: what a call leaves in memory word by word is read back as
    /// vectors, which has to wait until all earlier stores are done, those of the row above included.
    #[inline(always)]
    fn values(&self, x: i32, y: i32) -> [Divided<I>; 4] {
        let at = [I::from_i64(i64::from(x) * 256 + 128), I::from_i64(i64::from(y) * 256 + 128)];
        let [a, b, c] = &self.corners;
        let [r, g, b, a] = self.mixed(&[twice_area(b, c, &at), twice_area(c, a, &at), twice_area(a, b, &at)]);
        let value = |sum: I| self.divided(&sum.plus(&sum).plus(&self.area));
        [value(r), value(g), value(b), value(a)]
    }

    /// Returns the increment of V from a pixel to its right neighbour.
    fn growth(&self) -> [Divided<I>; 4] {
        let per_pixel = I::from_i64(256);
        let slopes: [I; 3] = std::array::from_fn(|i| {
            let (a, b) = (&self.corners[(i + 1) % 3], &self.corners[(i + 2) % 3]);
            a[1].minus(&b[1]).times(&per_pixel)
        });
        self.mixed(&slopes).map(|sum| self.divided(&sum.plus(&sum)))
    }

    /// Returns sum c_i w_i for each channel.
    #[inline(always)]
    fn mixed(&self, w: &[I; 3]) -> [I; 4] {
        let c = &self.colors;
        let sum = |k: usize| c[0][k].times(&w[0]).plus(&c[1][k].times(&w[1])).plus(&c[2][k].times(&w[2]));
        [sum(0), sum(1), sum(2), sum(3)]
    }

    /// Divides a numerator by D.
    #[inline(always)]
    fn divided(&self, n: &I) -> Divided<I> {
        let (quotient, rest) = n.div_rem_by(&self.divisor, &self.reciprocal);
        // Beyond these bounds only if a pixel has no covered neighbour, and then the step is never
        // taken.
        Divided { quotient: quotient.clamp_i64(-512, 511), rest }
    }

    /// Returns a quotient in 8.56 fixed point, modulo 256, at most 2 ulp below the exact value.
    #[inline(always)]
    fn fixed(&self, n: &Divided<I>) -> u64 {
        ((n.quotient as u64) << FRACTION_BITS)
            .wrapping_add(n.rest.fraction_56_by(&self.divisor, &self.reciprocal))
    }
}

/// Returns twice the area of the triangle of a, b and a point.
#[inline(always)]
fn twice_area<I: ExactInt>(a: &[I; 2], b: &[I; 2], at: &[I; 2]) -> I {
    let across = b[0].minus(&a[0]).times(&at[1].minus(&a[1]));
    across.minus(&b[1].minus(&a[1]).times(&at[0].minus(&a[0])))
}

/// Paints the triangle of `corners` (in 1/256 pixel), with a colour for each.
pub(super) fn gradient<I: ExactInt>(
    band: &mut Band<'_>,
    corners: &Corners<I>,
    colors: [Rgba; 3],
    blend: Blend,
) {
    let Some(exact) = Gradient::new(corners, colors) else { return };
    let growth = exact.growth();
    let step = growth.each_ref().map(|n| exact.fixed(n));
    let largest_divisor = exact.divisor.clamp_i64(0, i64::MAX) as u64;
    scan_triangle(corners, band.clip(), |y, xs| {
        let start = exact.values(xs.start, y);
        let [r, g, b, a] = &start;
        let value = [exact.fixed(r), exact.fixed(g), exact.fixed(b), exact.fixed(a)];
        let ramp = ColorRamp::new(value, step, 2, xs.len() as u32, largest_divisor);
        let row = Row { exact: &exact, start, growth: &growth, ramp };
        let run = band.run_mut(y, xs);
        match blend {
            Blend::Replace => row.paint(run, |pixel, color| *pixel = color),
            Blend::Over if !row.ramp.may_be_doubtful() => compose_ramp(row.ramp, run),
            Blend::Over => row.paint(run, |pixel, color| *pixel = over(color, *pixel)),
        }
        band.mark_row(y as u32);
    });
}

/// Colours of one span of pixels.
struct Row<'a, I: ExactInt> {
    exact: &'a Gradient<I>,
    /// V at the first pixel.
    start: [Divided<I>; 4],
    growth: &'a [Divided<I>; 4],
    ramp: ColorRamp,
}

impl<I: ExactInt> Row<'_, I> {
    /// Calls `put` with each pixel of the span and its colour. Inlined, so that the ramp stays in
    /// registers ([`Gradient::values`] says why).
    #[inline(always)]
    fn paint(&self, run: &mut [Rgba], put: impl Fn(&mut Rgba, Rgba)) {
        if self.ramp.may_be_doubtful() {
            return self.paint_in_parts(run, put);
        }
        let mut ramp = self.ramp;
        for pixel in run {
            put(pixel, ramp.color());
            ramp.step();
        }
    }

    /// Paints the span in parts, split where a nearly constant channel changes its value.
    #[inline(never)]
    fn paint_in_parts(&self, run: &mut [Rgba], put: impl Fn(&mut Rgba, Rgba)) {
        let levels: [Option<TwoValueRun>; 4] = std::array::from_fn(|k| self.level(k, run.len()));
        let mut ends = levels.map(|l| l.map_or(run.len(), |l| l.end));
        ends.sort_unstable();
        let mut from = 0;
        for to in ends.into_iter().chain([run.len()]) {
            if from == to {
                continue;
            }
            let mut ramp = self.ramp.after(from);
            for (k, level) in levels.iter().enumerate() {
                if let Some(level) = level {
                    ramp.hold(k, if from < level.end { level.first } else { level.last });
                }
            }
            if levels.iter().all(Option::is_some) {
                let color = ramp.color();
                run[from..to].iter_mut().for_each(|pixel| put(pixel, color));
            } else {
                for (i, pixel) in (from..to).zip(&mut run[from..to]) {
                    put(pixel, if ramp.is_doubtful() { self.decided(&ramp, i) } else { ramp.color() });
                    ramp.step();
                }
            }
            from = to;
        }
    }

    /// Returns the values of a channel that moves by less than 1 along a span of `len` pixels;
    /// `None` for any other.
    fn level(&self, k: usize, len: usize) -> Option<TwoValueRun> {
        let growth = &self.growth[k];
        let fraction = growth.rest.fraction_56(&self.exact.divisor);
        let slope = (i128::from(growth.quotient) << FRACTION_BITS) + i128::from(fraction);
        // The fraction may be 2 ulp too small.
        if (slope.unsigned_abs() + 2) * len as u128 >= 1 << FRACTION_BITS {
            return None;
        }
        let (first, last) = (self.channel(k, 0), self.channel(k, len - 1));
        let (mut same, mut other) = (0, len);
        if first != last {
            other = len - 1;
            while other - same > 1 {
                let middle = same.midpoint(other);
                *(if self.channel(k, middle) == first { &mut same } else { &mut other }) = middle;
            }
        }
        Some(TwoValueRun { first, end: other, last })
    }

    /// Returns channel k at pixel i of the span, exactly.
    fn channel(&self, k: usize, i: usize) -> u8 {
        let ramp = self.ramp.after(i);
        if ramp.is_doubtful_in(k) { self.decided_channel(&ramp, k, i) } else { ramp.color()[k] }
    }

    /// Returns the exact colour at pixel i, given the ramp at that pixel.
    fn decided(&self, ramp: &ColorRamp, i: usize) -> Rgba {
        let color = ramp.color();
        std::array::from_fn(
            |k| {
                if ramp.is_doubtful_in(k) { self.decided_channel(ramp, k, i) } else { color[k] }
            },
        )
    }

    /// Returns the exact channel k at pixel i, where the ramp is just above or just below an
    /// integer m: V >= m decides.
    fn decided_channel(&self, ramp: &ColorRamp, k: usize, i: usize) -> u8 {
        // Values begin at 1/2, so a ramp that has wrapped to 0 is at 256.
        let m = match ramp.color()[k] {
            0 => 256,
            m => i64::from(m),
        };
        let (start, growth, i) = (&self.start[k], &self.growth[k], i as i64);
        // V = start.quotient + i growth.quotient + (start.rest + i growth.rest) / D.
        let missing = m - start.quotient - i * growth.quotient;
        let order = start.rest.compare_stepped(i, &growth.rest, missing, &self.exact.divisor);
        (m - i64::from(order == Ordering::Less)) as u8
    }
}

/// A channel that takes one or two values along a span.
#[derive(Clone, Copy)]
struct TwoValueRun {
    first: u8,
    /// Pixel at which `last` begins; the span's length if there is only `first`.
    end: usize,
    last: u8,
}

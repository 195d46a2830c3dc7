//! The visible steps of one line, and two ways to iterate over them.

use std::hint::select_unpredictable;
use std::ops::Range;

use super::super::band::NO_ROWS;
use super::super::blend::Paint;
use super::super::color_ramp::ColorRamp;
use super::super::{Blend, RampColor, over};
use crate::math::bresenham::BresenhamLine;
use crate::math::coverage::PixelRect;
use crate::memory::Rgba;

/// Number of steps below which a line is drawn without a division at its start.
pub(super) const SHORT: u32 = 16;

/// The steps of a line that lie inside the frame (or inside a band of its rows), ready to draw.
#[derive(Clone, Copy, Debug)]
pub(super) struct VisibleRun {
    /// n: the number of steps of the unclipped line.
    pub length: u64,
    /// Index of the first visible step.
    first: u64,
    /// Number of visible steps: at most one for each column or row, so at most the frame's longer
    /// side.
    pub count: u32,
    /// Index of the first visible pixel.
    at: usize,
    /// Increment of the pixel index at every step.
    major: isize,
    /// Additional increment when the minor coordinate changes.
    minor: isize,
    /// (2 k m + n - 1) mod 2 n at the first step.
    rest: u64,
    /// 2 m.
    slope: u64,
    /// Rows of the first and the last visible pixel, in the order of travel.
    y_ends: [u32; 2],
}

impl VisibleRun {
    /// Creates the run of a line with both ends inside the frame.
    #[inline(always)]
    pub fn unclipped(p0: [i32; 2], p1: [i32; 2], width: u32) -> Self {
        let (dx, dy) = (p0[0].abs_diff(p1[0]), p0[1].abs_diff(p1[1]));
        let stride = width as isize;
        let x_step = select_unpredictable(p1[0] < p0[0], -1, 1);
        let y_step = select_unpredictable(p1[1] < p0[1], -stride, stride);
        let (n, m) = (dx.max(dy), dx.min(dy));
        let major = select_unpredictable(dx >= dy, x_step, y_step);
        let minor = select_unpredictable(dx >= dy, y_step, x_step);
        VisibleRun {
            length: n.into(),
            first: 0,
            count: n + 1,
            at: p0[1] as usize * width as usize + p0[0] as usize,
            major,
            minor,
            rest: u64::from(n).saturating_sub(1),
            slope: 2 * u64::from(m),
            y_ends: [p0[1] as u32, p1[1] as u32],
        }
    }

    /// Creates the run of any line: divisions give the range of its steps inside `clip`, a part of
    /// rows of `width` pixels; `None` if there are none. Both coordinates are within 2^32 of 0.
    pub fn clipped(p0: [i64; 2], p1: [i64; 2], clip: PixelRect, width: u32) -> Option<Self> {
        let line = BresenhamLine::new(p0, p1);
        let BresenhamLine { major, minor, is_x_major } = line;
        let Range { start: first, end } = line.steps_inside(clip)?;
        let (n, m) = (major.steps, minor.steps);
        let (made, rest) = line.minor_at(first);
        let count = (end - first) as u32;
        let last_made = if n == 0 { 0 } else { made + (rest + 2 * m * u64::from(count - 1)) / (2 * n) };
        let (a, b) = (major.at(first), minor.at(made));
        let (px, py) = if is_x_major { (a, b) } else { (b, a) };
        let stride = width as isize;
        let (major_sign, minor_sign) = (major.sign as isize, minor.sign as isize);
        let (major_step, minor_step) =
            if is_x_major { (major_sign, minor_sign * stride) } else { (major_sign * stride, minor_sign) };
        let y_last = if is_x_major { minor.at(last_made) } else { major.at(end - 1) };
        Some(VisibleRun {
            length: n,
            first,
            count,
            at: py as usize * width as usize + px as usize,
            major: major_step,
            minor: minor_step,
            rest,
            slope: 2 * m,
            y_ends: [py as u32, y_last as u32],
        })
    }

    /// Draws the run and returns its rows. `pixels` begin at row 0 of the area it was clipped to.
    #[inline(never)]
    pub fn draw(self, pixels: &mut [Rgba], color: RampColor, blend: Blend) -> Range<u32> {
        match (color.to, Paint::new(color.from, blend)) {
            (Some(to), _) if to != color.from => self.shade(pixels, color.from, to, blend),
            (_, Some(Paint::Store(color))) => self.for_each_pixel(pixels, |pixel| *pixel = color),
            (_, Some(Paint::Compose(color))) => {
                self.for_each_pixel(pixels, |pixel| *pixel = over(color, *pixel))
            }
            (_, None) => return NO_ROWS,
        }
        let [a, b] = self.y_ends;
        a.min(b)..a.max(b) + 1
    }

    /// Calls `put` with each pixel, in the order of travel.
    #[inline(always)]
    fn for_each_pixel(self, pixels: &mut [Rgba], mut put: impl FnMut(&mut Rgba)) {
        self.visit(|at| {
            // Always `Some`: every step of the run is inside the frame.
            if let Some(pixel) = pixels.get_mut(at) {
                put(pixel);
            }
        });
    }

    /// Draws the run with a colour ramp between the ends of the unclipped line.
    fn shade(self, pixels: &mut [Rgba], from: Rgba, to: Rgba, blend: Blend) {
        let mut ramp = ColorRamp::along_line(from, to, self.length, self.first, self.count);
        let mut next = || {
            let color = ramp.color();
            ramp.step();
            color
        };
        match blend {
            Blend::Replace => self.for_each_pixel(pixels, |pixel| *pixel = next()),
            Blend::Over => self.for_each_pixel(pixels, |pixel| *pixel = over(next(), *pixel)),
        }
    }

    /// Calls `plot` with the index of each pixel, in the order of travel.
    #[inline(always)]
    pub fn visit(self, plot: impl FnMut(usize)) {
        // In u64: both factors are below 2^33. With 32 fractional bits, see `visit_long`.
        let is_fine = (u64::from(self.count) + 1) * 2 * self.length < 1 << 32;
        if is_fine && self.length >= SHORT.into() { self.visit_long(plot) } else { self.visit_short(plot) }
    }

    /// Iterates by stepping the exact fraction, one pixel at a time, without a division.
    #[inline(always)]
    pub fn visit_short(self, mut plot: impl FnMut(usize)) {
        let (major, both) = (self.major as usize, self.major.wrapping_add(self.minor) as usize);
        // The fraction minus one, so that its sign says when the minor coordinate changes. Both are
        // below 2^33.
        let divisor = 2 * self.length as i64;
        let (mut at, mut rest) = (self.at, self.rest as i64 - divisor);
        for _ in 0..self.count {
            plot(at);
            rest += self.slope as i64;
            // Minor steps come in an unpredictable pattern, so neither choice may become a branch.
            at = at.wrapping_add(select_unpredictable(rest >= 0, both, major));
            rest -= select_unpredictable(rest >= 0, divisor, 0);
        }
    }

    /// Iterates in 32.32 fixed point, so that eight pixel indices are computed side by side.
    ///
    /// The minor coordinate is floor(V), V a multiple of 1 / 2 n. Start and step are rounded down,
    /// which leaves the stored value less than count + 1 ulp below V. That much is added at the
    /// start, and as it is less than 1 / 2 n, no integer is reached that V does not reach.
    #[inline(always)]
    pub fn visit_long(self, mut plot: impl FnMut(usize)) {
        let divisor = 2 * self.length;
        let slope = (self.slope << 32) / divisor;
        let mut along = (self.rest << 32) / divisor + u64::from(self.count) + 1;
        let mut at = self.at;
        let place = |at: usize, k: usize, along: u64| {
            let minor = (along >> 32) as usize;
            at.wrapping_add((self.major as usize).wrapping_mul(k))
                .wrapping_add((self.minor as usize).wrapping_mul(minor))
        };
        for _ in 0..self.count / 8 {
            for k in 0..8 {
                plot(place(at, k, along + k as u64 * slope));
            }
            along += 8 * slope;
            at = place(at, 8, 0);
        }
        for k in 0..self.count as usize % 8 {
            plot(place(at, k, along + k as u64 * slope));
        }
    }
}

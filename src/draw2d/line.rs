//! Lines: Bresenham's, in all octants, clipped by jumping to the first visible step.
//!
//! In: two ends in whole pixels, anywhere in i32. Out: max(|dx|,|dy|) + 1 pixels, both ends lit, those inside the frame.
//! The exact answer for step k of n = max(|dx|,|dy|), with m = min(|dx|,|dy|): k pixels along the major axis and
//! ceil(k m / n - 1/2) along the minor one, so that a tie stays on the major axis, in the direction of travel.
//! Written with whole numbers that is floor((2 k m + n - 1) / (2 n)), and stepping it is the midpoint algorithm.
//! Because it only grows with k, the steps inside the frame are one range whose ends are given by divisions.
//!
//! Source: Trabalho 1 ("Bresenham"; Bresenham, "Algorithm for computer control of a digital plotter", 1965), with
//! d0 = 2 dy - dx, |dx| and |dy| in the increments, and the first pixel drawn.

use super::blend::Paint;
use super::ramp::Ramp;
use super::{AreaColors, Blend, RampColor, over, pixels_mut};
use crate::memory::{Rgba, VideoMemory};
use std::hint::select_unpredictable;
use std::ops::Range;

/// Draws the line from `p0` to `p1`, both ends lit.
///
/// With two colours, step k of n takes c0 + (c1 - c0) k / n, each channel rounded half up; a line of one pixel takes the
/// first colour. The cost is that of the visible pixels.
#[inline]
pub fn line(memory: &mut VideoMemory, p0: [i32; 2], p1: [i32; 2], color: RampColor, blend: Blend) {
    let size = [memory.width(), memory.height()];
    if blend == Blend::Replace
        && color.to.is_none()
        && is_short(p0, p1)
        && inside(p0, size)
        && inside(p1, size)
    {
        store_short(pixels_mut(memory), p0, p1, size[0], color.from);
        memory.mark_row(p0[1] as u32);
        memory.mark_row(p1[1] as u32);
    } else {
        draw(memory, p0, p1, color, blend);
    }
}

/// A line as [`lines`] takes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Line {
    /// The end it starts from.
    pub p0: [i32; 2],
    /// The end it goes to.
    pub p1: [i32; 2],
    /// Its colour, or the two that it runs between.
    pub color: RampColor,
}

/// Draws lines one after the other, as [`line`] does, with less to do for each.
#[inline]
pub fn lines(memory: &mut VideoMemory, lines: impl IntoIterator<Item = Line>, blend: Blend) {
    let size = [memory.width(), memory.height()];
    let mut rows = u32::MAX..0;
    let mut lines = lines.into_iter();
    loop {
        let pixels = pixels_mut(memory);
        let other = lines.find(|&Line { p0, p1, color }| {
            if blend == Blend::Over
                || color.to.is_some()
                || !is_short(p0, p1)
                || !inside(p0, size)
                || !inside(p1, size)
            {
                return true;
            }
            store_short(pixels, p0, p1, size[0], color.from);
            let (a, b) = (p0[1] as u32, p1[1] as u32);
            rows = rows.start.min(a.min(b))..rows.end.max(a.max(b) + 1);
            false
        });
        match other {
            Some(Line { p0, p1, color }) => draw(memory, p0, p1, color, blend),
            None => return memory.mark_rows(rows),
        }
    }
}

#[inline]
fn inside(p: [i32; 2], [width, height]: [u32; 2]) -> bool {
    (p[0] as u32) < width && (p[1] as u32) < height
}

#[inline]
fn is_short(p0: [i32; 2], p1: [i32; 2]) -> bool {
    p0[0].abs_diff(p1[0]).max(p0[1].abs_diff(p1[1])) < SHORT
}

/// The path of short lines of one colour, both ends inside.
///
/// Stores that miss the cache pile up, and the next load of a number that was itself just stored, in pieces or in a long
/// queue, waits for all of them. So this path keeps its numbers in registers and stores nothing but pixels.
#[inline(always)]
fn store_short(pixels: &mut [Rgba], p0: [i32; 2], p1: [i32; 2], width: u32, color: Rgba) {
    VisibleRun::whole(p0, p1, width).visit_short(|at| {
        if let Some(pixel) = pixels.get_mut(at) {
            *pixel = color;
        }
    });
}

/// Any line.
#[inline(never)]
fn draw(memory: &mut VideoMemory, p0: [i32; 2], p1: [i32; 2], color: RampColor, blend: Blend) {
    let size @ [width, height] = [memory.width(), memory.height()];
    if inside(p0, size) && inside(p1, size) {
        VisibleRun::whole(p0, p1, width).draw(memory, color, blend);
    } else if let Some(run) = VisibleRun::clipped(p0, p1, width, height) {
        run.draw(memory, color, blend);
    }
}

/// Draws the three lines p0p1, p1p2, p2p0; with three colours each runs between those of its ends.
pub fn triangle_outline(memory: &mut VideoMemory, points: [[i32; 2]; 3], colors: AreaColors, blend: Blend) {
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let color = match colors {
            AreaColors::One(from) => RampColor { from, to: None },
            AreaColors::Three(c) => RampColor { from: c[i], to: Some(c[j]) },
        };
        line(memory, points[i], points[j], color, blend);
    }
}

/// Draws the lines from each point to the next, and from the last to the first.
pub fn poly(memory: &mut VideoMemory, points: &[[i32; 2]], color: Rgba, blend: Blend) {
    let next = points.iter().cycle().skip(1);
    for (&p0, &p1) in points.iter().zip(next) {
        line(memory, p0, p1, RampColor { from: color, to: None }, blend);
    }
}

/// Lines of fewer steps are walked without a division at their start.
const SHORT: u32 = 16;

/// The steps of a line that lie inside the frame, ready to walk.
#[derive(Clone, Copy, Debug)]
struct VisibleRun {
    /// n: the steps of the whole line.
    length: u64,
    /// The first visible step.
    first: u64,
    /// How many steps are visible: one a column or a row, so at most the frame's longer side.
    count: u32,
    /// Index of the first visible pixel.
    at: usize,
    /// Added to the index by every step.
    major: isize,
    /// Added too when the minor coordinate changes.
    minor: isize,
    /// (2 k m + n - 1) mod 2 n at the first step.
    rest: u64,
    /// 2 m.
    slope: u64,
    /// First and last visible row, in the order of travel.
    y_ends: [u32; 2],
}

/// One coordinate on its way: from `start`, in the direction of `sign`.
#[derive(Clone, Copy)]
struct Axis {
    start: i64,
    sign: i64,
    steps: u64,
    limit: i64,
}

impl Axis {
    fn new(a: i32, b: i32, limit: u32) -> Self {
        let sign = if b < a { -1 } else { 1 };
        Axis { start: a.into(), sign, steps: a.abs_diff(b).into(), limit: limit.into() }
    }

    /// How far along the axis the frame begins and ends (half-open), from the start and in its direction.
    fn visible(self) -> Range<i64> {
        let range = match self.sign {
            1 => -self.start..self.limit - self.start,
            _ => self.start - (self.limit - 1)..self.start + 1,
        };
        range.start.max(0)..range.end.min(self.steps as i64 + 1)
    }

    fn at(self, step: u64) -> i64 {
        self.start + self.sign * step as i64
    }
}

impl VisibleRun {
    /// A line with both ends inside the frame.
    #[inline(always)]
    fn whole(p0: [i32; 2], p1: [i32; 2], width: u32) -> Self {
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

    /// Any other line: the range of its steps that lie inside, by division.
    fn clipped(p0: [i32; 2], p1: [i32; 2], width: u32, height: u32) -> Option<Self> {
        let (x, y) = (Axis::new(p0[0], p1[0], width), Axis::new(p0[1], p1[1], height));
        let x_is_major = x.steps >= y.steps;
        let (major, minor) = if x_is_major { (x, y) } else { (y, x) };
        let (n, m) = (major.steps, minor.steps);
        let (along, across) = (major.visible(), minor.visible());
        if along.is_empty() || across.is_empty() {
            return None;
        }
        let (mut first, mut end) = (along.start as u64, along.end as u64);
        // The least k at which the minor coordinate has made t > 0 steps: ceil((2 n t - n + 1) / 2 m).
        let reaches = |t: i64| {
            let numerator = 2 * i128::from(n) * i128::from(t) - i128::from(n) + 1;
            numerator.div_euclid(2 * i128::from(m)) + i128::from(numerator.rem_euclid(2 * i128::from(m)) != 0)
        };
        if across.start > 0 {
            first = first.max(u64::try_from(reaches(across.start)).unwrap_or(u64::MAX));
        }
        if across.end <= m as i64 {
            end = end.min(u64::try_from(reaches(across.end)).unwrap_or(0));
        }
        if first >= end {
            return None;
        }
        let (made, rest) = match (n, first) {
            (0, _) => (0, 0),
            (_, 0) => (0, n - 1),
            _ => {
                let numerator = 2 * u128::from(first) * u128::from(m) + u128::from(n) - 1;
                let divisor = 2 * u128::from(n);
                ((numerator / divisor) as u64, (numerator % divisor) as u64)
            }
        };
        let count = (end - first) as u32;
        let last_made = if n == 0 { 0 } else { made + (rest + 2 * m * u64::from(count - 1)) / (2 * n) };
        let (a, b, b_last) = (major.at(first), minor.at(made), minor.at(last_made));
        let (px, py) = if x_is_major { (a, b) } else { (b, a) };
        let stride = width as isize;
        let (major_step, minor_step) = if x_is_major {
            (x.sign as isize, y.sign as isize * stride)
        } else {
            (y.sign as isize * stride, x.sign as isize)
        };
        let y_last = if x_is_major { b_last } else { major.at(end - 1) };
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

    #[inline(never)]
    fn draw(self, memory: &mut VideoMemory, color: RampColor, blend: Blend) {
        match (color.to, Paint::new(color.from, blend)) {
            (Some(to), _) if to != color.from => self.shade(memory, color.from, to, blend),
            (_, Some(Paint::Store(color))) => self.walk(memory, |pixel| *pixel = color),
            (_, Some(Paint::Compose(color))) => self.walk(memory, |pixel| *pixel = over(color, *pixel)),
            (_, None) => {}
        }
    }

    /// Gives each pixel to `put`, in the order of travel, and marks the rows.
    #[inline(always)]
    fn walk(self, memory: &mut VideoMemory, mut put: impl FnMut(&mut Rgba)) {
        let pixels = pixels_mut(memory);
        self.visit(|at| {
            // Always found: every step of the run is inside the frame.
            if let Some(pixel) = pixels.get_mut(at) {
                put(pixel);
            }
        });
        let [a, b] = self.y_ends;
        memory.mark_rows(a.min(b)..a.max(b) + 1);
    }

    fn shade(self, memory: &mut VideoMemory, from: Rgba, to: Rgba, blend: Blend) {
        let mut ramp = Ramp::along_line(from, to, self.length, self.first, self.count);
        let mut next = || {
            let color = ramp.color();
            ramp.step();
            color
        };
        match blend {
            Blend::Replace => self.walk(memory, |pixel| *pixel = next()),
            Blend::Over => self.walk(memory, |pixel| *pixel = over(next(), *pixel)),
        }
    }

    /// Calls `plot` with the index of each pixel in the order of travel.
    #[inline(always)]
    fn visit(self, plot: impl FnMut(usize)) {
        // In u64: both factors are below 2^33. With 32 bits behind the point, see `visit_long`.
        let is_fine = (u64::from(self.count) + 1) * 2 * self.length < 1 << 32;
        if is_fine && self.length >= SHORT.into() { self.visit_long(plot) } else { self.visit_short(plot) }
    }

    /// Steps the exact fraction, a pixel at a time: no division.
    #[inline(always)]
    fn visit_short(self, mut plot: impl FnMut(usize)) {
        let (major, both) = (self.major as usize, self.major.wrapping_add(self.minor) as usize);
        // The fraction less one, so that a sign tells when the minor coordinate changes. Both are below 2^33.
        let divisor = 2 * self.length as i64;
        let (mut at, mut rest) = (self.at, self.rest as i64 - divisor);
        for _ in 0..self.count {
            plot(at);
            rest += self.slope as i64;
            // Lines turn at random, so neither choice may become a branch.
            at = at.wrapping_add(select_unpredictable(rest >= 0, both, major));
            rest -= select_unpredictable(rest >= 0, divisor, 0);
        }
    }

    /// Steps in 32.32 fixed point, so that eight pixels are found side by side.
    ///
    /// The minor coordinate is floor(V), V a multiple of 1 / 2 n. Start and step are rounded down, which leaves what is
    /// kept less than count + 1 ulp below V; that much is added at the start, and as it is less than 1 / 2 n no whole
    /// number is reached that V does not reach.
    #[inline(always)]
    fn visit_long(self, mut plot: impl FnMut(usize)) {
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

#[cfg(test)]
mod tests;

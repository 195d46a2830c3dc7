//! Bresenham lines in all octants, clipped by computing the first visible step.
//!
//! In: two ends in whole pixels, anywhere in i32. Out: max(|dx|,|dy|) + 1 pixels including both
//! ends; those inside the frame are drawn.
//!
//! The exact answer for step k of n = max(|dx|,|dy|), with m = min(|dx|,|dy|): k pixels along the
//! major axis and ceil(k m / n - 1/2) along the minor one, so that a tie stays on the major axis,
//! in the direction of travel. In integers that is floor((2 k m + n - 1) / (2 n)), and stepping it
//! is the midpoint algorithm. The minor coordinate grows monotonically with k, so the steps inside
//! the frame form one range, whose ends are computed by divisions.
//!
//! Source: Trabalho 1 ("Bresenham"; Bresenham, "Algorithm for computer control of a digital
//! plotter", 1965), with d0 = 2 dy - dx, |dx| and |dy| in the increments, and the first pixel
//! drawn.

mod bresenham;
mod parallel;

pub use parallel::{Line, lines, lines_on};

use super::{AreaColors, Blend, RampColor, frame, pixels_mut};
use crate::memory::{Rgba, VideoMemory};
use bresenham::{SHORT, VisibleRun};

/// Draws the line from `p0` to `p1`, both ends included.
///
/// With two colours, step k of n takes c0 + (c1 - c0) k / n, each channel rounded half up; a line
/// of one pixel takes the first colour. The cost is that of the visible pixels.
#[inline]
pub fn line(memory: &mut VideoMemory, p0: [i32; 2], p1: [i32; 2], color: RampColor, blend: Blend) {
    let size = [memory.width(), memory.height()];
    if blend == Blend::Replace
        && color.to.is_none()
        && is_short(p0, p1)
        && !memory.is_clipped()
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

/// Returns whether a pixel is inside the frame.
#[inline]
fn inside(p: [i32; 2], [width, height]: [u32; 2]) -> bool {
    (p[0] as u32) < width && (p[1] as u32) < height
}

/// Returns whether a line has fewer than [`SHORT`] steps.
#[inline]
fn is_short(p0: [i32; 2], p1: [i32; 2]) -> bool {
    p0[0].abs_diff(p1[0]).max(p0[1].abs_diff(p1[1])) < SHORT
}

/// Draws a short line of one colour with both ends inside the frame.
///
/// Stores that miss the cache queue up, and a load of a value that was itself just stored, in
/// pieces or into a long queue, waits for all of them. So this path holds its state in registers
/// and stores only pixels.
#[inline(always)]
fn store_short(pixels: &mut [Rgba], p0: [i32; 2], p1: [i32; 2], width: u32, color: Rgba) {
    VisibleRun::unclipped(p0, p1, width).visit_short(|at| {
        if let Some(pixel) = pixels.get_mut(at) {
            *pixel = color;
        }
    });
}

/// Draws any line.
#[inline(never)]
fn draw(memory: &mut VideoMemory, p0: [i32; 2], p1: [i32; 2], color: RampColor, blend: Blend) {
    let size @ [width, _] = [memory.width(), memory.height()];
    let run = if inside(p0, size) && inside(p1, size) && !memory.is_clipped() {
        Some(VisibleRun::unclipped(p0, p1, width))
    } else {
        VisibleRun::clipped(p0.map(i64::from), p1.map(i64::from), frame(memory), width)
    };
    if let Some(run) = run {
        let rows = run.draw(pixels_mut(memory), color, blend);
        memory.mark_rows(rows);
    }
}

/// Draws the lines p0p1, p1p2 and p2p0; with three colours each line runs between those of its
/// ends.
pub fn triangle_outline(memory: &mut VideoMemory, points: [[i32; 2]; 3], colors: AreaColors, blend: Blend) {
    for (i, j) in [(0, 1), (1, 2), (2, 0)] {
        let color = match colors {
            AreaColors::One(from) => RampColor { from, to: None },
            AreaColors::Three(c) => RampColor { from: c[i], to: Some(c[j]) },
        };
        line(memory, points[i], points[j], color, blend);
    }
}

/// Draws the lines from each point to the next, and from the last back to the first.
pub fn poly(memory: &mut VideoMemory, points: &[[i32; 2]], color: Rgba, blend: Blend) {
    let next = points.iter().cycle().skip(1);
    for (&p0, &p1) in points.iter().zip(next) {
        line(memory, p0, p1, RampColor { from: color, to: None }, blend);
    }
}

#[cfg(test)]
mod tests;

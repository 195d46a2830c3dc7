//! The rows of a frame that a figure is drawn into: all of them, or a band that one thread has.
//!
//! In: a video memory, or rows of it for each thread of an executor. Out: changed pixels, and the rows
//! in which they are. A pixel belongs to one band, and what a figure stores in a row depends on no other
//! row, so a figure that every band draws for itself has the same bytes as one that is drawn whole, with
//! any number of threads. The tests of the figures and `tests/drawing/figure_bands.rs` compare them.

use super::blend::Paint;
use super::{frame, pixels_mut};
use crate::executor::Executor;
use crate::math::coverage::PixelRect;
use crate::memory::{Rgba, VideoMemory};
use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};

/// An empty range of rows, as the initial value of a union.
pub(super) const NO_ROWS: Range<u32> = Range { start: u32::MAX, end: 0 };

/// Rows of a frame.
#[derive(Debug)]
pub struct Band<'a> {
    /// Pixels of the rows from `top` on.
    pixels: &'a mut [Rgba],
    top: u32,
    /// Width and height of the frame.
    size: [u32; 2],
    /// Pixels of the frame that may be drawn; its rows are among the band's.
    clip: PixelRect,
    /// Rows of the frame that were written.
    written: Range<u32>,
}

impl<'a> Band<'a> {
    /// Returns width and height of the frame.
    #[inline]
    pub(super) fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Returns the first row.
    #[inline]
    pub(super) fn top(&self) -> u32 {
        self.top
    }

    /// Returns the pixels that figures may touch.
    #[inline]
    pub(super) fn clip(&self) -> PixelRect {
        self.clip
    }

    /// Returns all pixels of the band's rows. The caller marks the rows that it writes.
    #[inline]
    pub(super) fn pixels_mut(&mut self) -> &mut [Rgba] {
        self.pixels
    }

    /// Returns pixels `xs` of row `y` of the frame, both inside the band. The caller marks the row.
    #[inline]
    pub(super) fn run_mut(&mut self, y: i32, xs: Range<i32>) -> &mut [Rgba] {
        let at = self.size[0] as usize * (y as u32 - self.top) as usize;
        &mut self.pixels[at + xs.start as usize..at + xs.end as usize]
    }

    /// Records that row `y` of the frame was written.
    #[inline]
    pub(super) fn mark_row(&mut self, y: u32) {
        self.mark_rows(y..y + 1);
    }

    /// Records that rows of the frame were written.
    #[inline]
    pub(super) fn mark_rows(&mut self, rows: Range<u32>) {
        if rows.start < rows.end {
            self.written = self.written.start.min(rows.start)..self.written.end.max(rows.end);
        }
    }

    /// Paints the columns that `row` returns of each of `ys`, all inside the band; empty ones are
    /// skipped.
    // In line, so that of a small figure the band stays in registers.
    #[inline(always)]
    pub(super) fn paint_rows(&mut self, paint: Paint, ys: Range<i32>, row: impl Fn(i32) -> Range<i32>) {
        let mut marked: Option<Range<i32>> = None;
        for y in ys {
            let xs = row(y);
            if !xs.is_empty() {
                paint.run(self.run_mut(y, xs));
                marked = Some(marked.map_or(y, |rows| rows.start)..y + 1);
            }
        }
        if let Some(rows) = marked {
            self.mark_rows(rows.start as u32..rows.end as u32);
        }
    }

    /// Paints pixels `xs` of rows `ys`, both inside the band.
    #[inline(always)]
    pub(super) fn paint_block(&mut self, paint: Paint, xs: Range<i32>, ys: Range<i32>) {
        if xs.is_empty() || ys.is_empty() {
            return;
        }
        let width = self.size[0] as usize;
        if xs.len() == width {
            // Full rows are contiguous.
            let [first, end] = [ys.start, ys.end].map(|y| width * (y as u32 - self.top) as usize);
            paint.run(&mut self.pixels[first..end]);
        } else {
            for y in ys.clone() {
                paint.run(self.run_mut(y, xs.clone()));
            }
        }
        self.mark_rows(ys.start as u32..ys.end as u32);
    }
}

/// Draws on all rows of a frame.
#[inline]
pub(super) fn on_all_rows<R>(memory: &mut VideoMemory, draw: impl FnOnce(&mut Band<'_>) -> R) -> R {
    let (size, clip) = ([memory.width(), memory.height()], frame(memory));
    let mut band = Band { pixels: pixels_mut(memory), top: 0, size, clip, written: NO_ROWS };
    let result = draw(&mut band);
    let written = band.written;
    memory.mark_rows(written);
    result
}

/// Draws on the rows `ys` of a frame in at most so many bands, each by a thread of the executor that has
/// nothing else to do.
pub(super) fn on_bands(
    executor: &Executor,
    memory: &mut VideoMemory,
    ys: Range<i32>,
    bands: usize,
    draw: impl Fn(&mut Band<'_>) + Sync,
) {
    let (size, clip) = ([memory.width(), memory.height()], frame(memory));
    let (first, end) = (ys.start.max(clip.y0), ys.end.min(clip.y1));
    if first >= end {
        return;
    }
    let (width, band_rows) = (size[0] as usize, ((end - first) as usize).div_ceil(bands.max(1)));
    let (low, high) = (AtomicU32::new(u32::MAX), AtomicU32::new(0));
    let pixels = &mut pixels_mut(memory)[width * first as usize..width * end as usize];
    executor.chunks(pixels, band_rows * width, |i, pixels| {
        let y0 = first + (i * band_rows) as i32;
        let clip = PixelRect { y0, y1: y0 + (pixels.len() / width) as i32, ..clip };
        let mut band = Band { pixels, top: y0 as u32, size, clip, written: NO_ROWS };
        draw(&mut band);
        low.fetch_min(band.written.start, Ordering::Relaxed);
        high.fetch_max(band.written.end, Ordering::Relaxed);
    });
    memory.mark_rows(low.into_inner()..high.into_inner());
}

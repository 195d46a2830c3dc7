//! Drawing in two dimensions: pixels, lines, areas, circles, text, blits.
//!
//! In: numbers in pixels. Out: bytes in a [`VideoMemory`], and its damaged rows. Outlines
//! address pixels by whole numbers; fills cover area in real coordinates, where pixel (i,j) is the square
//! [i,i+1)x[j,j+1). What leaves the frame is clipped silently, at the cost of the visible part; the lit pixels are those
//! of the whole figure that fall inside. A source that is asked for outside the frame is an error.
//!
//! Every verb that takes a [`Blend`] lights each of its pixels once, but for outlines made of several lines
//! ([`triangle_outline`], [`poly`]): those are their lines.
//!
//! Filled figures ([`fill`], [`fill_poly`], [`fill_rect`], [`fill_circle`]) keep to the rows of [`VideoMemory::window`]: band
//! after band gives the bytes of the whole.

mod blend;
mod blit;
mod circle;
mod color_ramp;
mod disc;
mod error;
mod fill;
pub mod font;
mod gradient;
mod line;
mod line_aa;
mod pixels;
mod rect;
mod text;

pub use blend::{Blend, over};
pub use blit::{blit, copy, read, rows};
pub use circle::circle;
pub use disc::fill_circle;
pub use error::DrawError;
pub use fill::{fill, fill_poly};
pub use line::{Line, line, lines, lines_on, poly, triangle_outline};
pub use line_aa::line_aa;
pub use pixels::{binary_pixels, moved_points, pixel_run, points, points_on, put_pixel};
pub use rect::{fill_rect, rect};
pub use text::{TextCursor, text, text_piece};

use crate::math::coverage::PixelRect;
use crate::memory::{Rgba, VideoMemory};
use std::ops::Range;

/// A rectangle in whole pixels, as the verbs give it: left, top, width, height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Rect {
    /// Left column.
    pub x: i32,
    /// Top row.
    pub y: i32,
    /// Width in pixels; negative ones are ERANGE when run.
    pub w: i32,
    /// Height in pixels; negative ones are ERANGE when run.
    pub h: i32,
}

/// A rectangle in real coordinates, in pixels: left, top, width, height. The centre of pixel (i,j) is (i + 1/2, j + 1/2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RealRect {
    /// Left side.
    pub x: f64,
    /// Top side.
    pub y: f64,
    /// Width; negative ones are ERANGE when run.
    pub w: f64,
    /// Height; negative ones are ERANGE when run.
    pub h: f64,
}

impl From<Rect> for RealRect {
    fn from(r: Rect) -> Self {
        let [x, y, w, h] = [r.x, r.y, r.w, r.h].map(f64::from);
        RealRect { x, y, w, h }
    }
}

/// A line's colours: one, or a ramp from the first to the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RampColor {
    /// At the first end.
    pub from: Rgba,
    /// At the second end, `None` for one colour all along.
    pub to: Option<Rgba>,
}

/// A triangle's colours: one, or one a corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AreaColors {
    /// The same everywhere.
    One(Rgba),
    /// One at each corner.
    Three([Rgba; 3]),
}

/// The frame, or the band of it that is drawn on, as a clip rectangle.
fn frame(memory: &VideoMemory) -> PixelRect {
    let rows = memory.window();
    PixelRect { x0: 0, y0: rows.start as i32, x1: memory.width() as i32, y1: rows.end as i32 }
}

/// All pixels, row 0 first. The caller marks the rows it writes.
#[inline]
fn pixels_mut(memory: &mut VideoMemory) -> &mut [Rgba] {
    memory.bytes_mut().as_chunks_mut().0
}

/// Pixels `xs` of row `y`, both inside the frame. The caller marks the row.
#[inline]
fn run_mut(memory: &mut VideoMemory, y: i32, xs: Range<i32>) -> &mut [Rgba] {
    let at = memory.width() as usize * y as usize;
    &mut pixels_mut(memory)[at + xs.start as usize..at + xs.end as usize]
}

/// `start..start + len` held to `0..limit`; empty for a length that is not positive.
fn clip_range(start: i32, len: i32, limit: u32) -> Range<i32> {
    let limit = i64::from(limit);
    let end = (i64::from(start) + i64::from(len)).clamp(0, limit);
    (i64::from(start).clamp(0, limit)) as i32..end as i32
}

#[cfg(test)]
mod raster;

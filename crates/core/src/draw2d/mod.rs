//! Drawing in two dimensions: pixels, lines, areas, circles, text, blits.
//!
//! In: coordinates in pixels. Out: pixels of a [`VideoMemory`], whose changed rows are marked as
//! damaged. Outlines address pixels by whole numbers; fills cover area in real coordinates, where
//! pixel (i,j) is the square [i,i+1)x[j,j+1). All drawing is clipped without an error to the frame,
//! or to the rectangle of [`VideoMemory::set_clip`],
//! at the cost of the visible part; the lit pixels are those of the unclipped figure that fall
//! inside. A source rectangle that is not entirely inside the frame is an error.
//!
//! Every function that takes a [`Blend`] writes each of its pixels once, except outlines made of
//! several lines ([`triangle_outline`], [`poly`]), which write the pixels of each line.
//!
//! Figures of areas ([`fill`], [`fill_poly`], [`fill_rect`], [`fill_circle`], [`fill_ellipse`],
//! [`ellipse`], [`arc`], [`wide_line`], [`bezier`]) draw only the rows of [`VideoMemory::window`].
//! Drawing one band after another gives the same bytes as drawing the full frame.

mod arc;
mod area;
mod band;
mod bezier;
mod blend;
mod blit;
mod circle;
mod color_ramp;
#[doc(hidden)]
pub mod crt;
mod disc;
mod ellipse;
mod error;
#[cfg(test)]
mod example;
mod figures;
mod fill;
pub mod font;
mod gradient;
mod line;
mod line_aa;
#[doc(hidden)]
pub mod look;
mod pixels;
mod ramp_row;
mod rect;
mod row_ends;
mod row_search;
mod text;
pub mod trace;
mod wide_line;

pub use crate::memory::over;
pub use arc::{Arc, arc};
#[doc(hidden)]
pub use area::{Area, areas_on};
pub use bezier::{FAR_POINT, bezier, bezier_steps};
pub use blend::Blend;
pub use blit::{blit, copy, read, rows, stamp};
pub use circle::circle;
pub use disc::fill_circle;
pub use ellipse::{ellipse, fill_ellipse};
pub use error::DrawError;
#[doc(hidden)]
pub use figures::FigureTarget;
pub use fill::{fill, fill_poly};
pub use line::{Line, line, lines, lines_on, poly, triangle_outline};
pub use line_aa::line_aa;
pub use pixels::{binary_pixels, moved_points, pixel_run, points, points_on, put_pixel};
pub use rect::{fill_rect, rect};
pub use text::{TextCursor, scaled_text, text, text_piece};
pub use wide_line::wide_line;

use crate::math::coverage::PixelRect;
use crate::memory::{Rgba, VideoMemory};
use std::ops::Range;

/// A rectangle in whole pixels: left, top, width, height.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Rect {
    /// Left column.
    pub x: i32,
    /// Top row.
    pub y: i32,
    /// Width in pixels. Drawing with a negative width fails with ERANGE.
    pub w: i32,
    /// Height in pixels. Drawing with a negative height fails with ERANGE.
    pub h: i32,
}

/// A rectangle in real coordinates, in pixels: left, top, width, height. The centre of pixel (i,j)
/// is (i + 1/2, j + 1/2).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RealRect {
    /// x of the left side.
    pub x: f64,
    /// y of the top side.
    pub y: f64,
    /// Width in pixels. Drawing with a negative width fails with ERANGE.
    pub w: f64,
    /// Height in pixels. Drawing with a negative height fails with ERANGE.
    pub h: f64,
}

impl From<[i32; 4]> for Rect {
    /// Takes left, top, width and height.
    fn from([x, y, w, h]: [i32; 4]) -> Self {
        Rect { x, y, w, h }
    }
}

impl From<Rect> for RealRect {
    fn from(r: Rect) -> Self {
        [r.x, r.y, r.w, r.h].into()
    }
}

impl From<[i32; 4]> for RealRect {
    /// Takes left, top, width and height.
    fn from(r: [i32; 4]) -> Self {
        r.map(f64::from).into()
    }
}

impl From<[f64; 4]> for RealRect {
    /// Takes left, top, width and height.
    fn from([x, y, w, h]: [f64; 4]) -> Self {
        RealRect { x, y, w, h }
    }
}

/// Colours of a line: one, or a ramp from the first end to the second.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct RampColor {
    /// Colour at the first end.
    pub from: Rgba,
    /// Colour at the second end, or `None` for a line of one colour.
    pub to: Option<Rgba>,
}

impl From<Rgba> for RampColor {
    fn from(from: Rgba) -> Self {
        RampColor { from, to: None }
    }
}

impl From<[Rgba; 2]> for RampColor {
    fn from([from, to]: [Rgba; 2]) -> Self {
        RampColor { from, to: Some(to) }
    }
}

/// Colours of a triangle: one, or one for each corner.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AreaColors {
    /// One colour for the whole area.
    One(Rgba),
    /// One colour for each corner, interpolated between them.
    Three([Rgba; 3]),
}

impl From<Rgba> for AreaColors {
    fn from(color: Rgba) -> Self {
        AreaColors::One(color)
    }
}

impl From<[Rgba; 3]> for AreaColors {
    fn from(corners: [Rgba; 3]) -> Self {
        AreaColors::Three(corners)
    }
}

/// Returns the pixels that figures may touch: those of the frame, or of the clip rectangle, in the
/// current band of rows.
fn frame(memory: &VideoMemory) -> PixelRect {
    let ([columns, rows], band) = (memory.clip(), memory.window());
    let y0 = rows.start.max(band.start);
    let y1 = rows.end.min(band.end).max(y0);
    let [x0, y0, x1, y1] = [columns.start, y0, columns.end, y1].map(|v| v as i32);
    PixelRect { x0, y0, x1, y1 }
}

/// Returns all pixels, row 0 first. The caller marks the rows it writes as damaged.
#[inline]
fn pixels_mut(memory: &mut VideoMemory) -> &mut [Rgba] {
    memory.bytes_mut().as_chunks_mut().0
}

/// Returns pixels `xs` of row `y`, both inside the frame. The caller marks the row as damaged.
#[inline]
fn run_mut(memory: &mut VideoMemory, y: i32, xs: Range<i32>) -> &mut [Rgba] {
    let at = memory.width() as usize * y as usize;
    &mut pixels_mut(memory)[at + xs.start as usize..at + xs.end as usize]
}

/// Clamps `start..start + len` to `within`; empty if `len` is not positive.
fn clip_range(start: i32, len: i32, within: Range<i32>) -> Range<i32> {
    let [low, high] = [within.start, within.end].map(i64::from);
    let end = (i64::from(start) + i64::from(len)).clamp(low, high);
    (i64::from(start).clamp(low, high)) as i32..end as i32
}

/// Returns the columns and rows of a rectangle that drawing may touch.
fn visible(memory: &VideoMemory, rect: Rect) -> [Range<i32>; 2] {
    let PixelRect { x0, y0, x1, y1 } = frame(memory);
    [clip_range(rect.x, rect.w, x0..x1), clip_range(rect.y, rect.h, y0..y1)]
}

#[cfg(test)]
mod raster;

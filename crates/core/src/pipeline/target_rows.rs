//! Rows of a render target: the buffers that a draw writes, split between threads.

use super::draw_call::Target;
use super::plan::{Part, Parts};
use crate::math::coverage::PixelRect;
use crate::memory::{DepthFormat, DepthWords, PickBuffer};
use std::ops::Range;

/// Some rows of a render target, and the clip rectangle of the draw.
pub(crate) struct TargetRows<'t> {
    /// Pixels per row.
    pub width: usize,
    /// Clip rectangle in pixels of the frame; it lies within these rows.
    pub clip: PixelRect,
    /// Index of the first row.
    pub y0: u32,
    /// Colour bytes of these rows, four per pixel.
    pub bytes: &'t mut [u8],
    /// Depth words of these rows; `None` if depth is not used.
    pub depth: Option<(DepthFormat, DepthWords<'t>)>,
    /// Pick-buffer ids of these rows.
    pub ids: Option<&'t mut [[u32; 2]]>,
    /// Range of rows that were written.
    pub written: Range<u32>,
}

impl<'t> TargetRows<'t> {
    /// Returns all rows of the frame, with its depths and ids if the plan uses them.
    pub fn new(target: &'t mut Target, clip: PixelRect, parts: Parts) -> Self {
        let width = target.memory.width() as usize;
        let depth = target.depth.as_mut().filter(|_| parts.uses(Part::DepthMemory));
        let depth = depth.map(|d| (d.format(), d.words_mut()));
        let ids = target.ids.as_deref_mut().filter(|_| parts.uses(Part::PickBuffer)).map(PickBuffer::ids_mut);
        let bytes = target.memory.bytes_mut();
        TargetRows { width, clip, y0: 0, bytes, depth, ids, written: 0..0 }
    }

    /// Returns the rows inside the clip rectangle.
    pub fn rows(&self) -> Range<i32> {
        self.clip.y0..self.clip.y1
    }

    /// Splits into the rows above `row` of the frame, and those from it on.
    pub fn split(self, row: u32) -> (Self, Self) {
        let (width, y0) = (self.width, self.y0);
        let end = y0 + (self.bytes.len() / (width * 4)) as u32;
        let row = row.clamp(y0, end);
        let pixels = (row - y0) as usize * width;
        let (bytes, bytes_below) = self.bytes.split_at_mut(pixels * 4);
        let (depth, depth_below) = match self.depth {
            None => (None, None),
            Some((format, words)) => {
                let (a, b) = words.split_at(pixels);
                (Some((format, a)), Some((format, b)))
            }
        };
        let (ids, ids_below) = self.ids.map(|ids| ids.split_at_mut(pixels)).unzip();
        let at = row as i32;
        let above = PixelRect { y1: self.clip.y1.min(at), ..self.clip };
        let below = PixelRect { y0: self.clip.y0.max(at), ..self.clip };
        (
            TargetRows { width, clip: above, y0, bytes, depth, ids, written: 0..0 },
            TargetRows {
                width,
                clip: below,
                y0: row,
                bytes: bytes_below,
                depth: depth_below,
                ids: ids_below,
                written: 0..0,
            },
        )
    }

    /// Stores a depth word, and the id if ids are kept. No effect without depth.
    #[inline]
    pub fn store_depth(&mut self, index: usize, word: Option<u32>, id: [u32; 2]) {
        if let (Some((_, words)), Some(word)) = (&mut self.depth, word) {
            words.set_word(index, word);
            if let Some(ids) = &mut self.ids {
                ids[index] = id;
            }
        }
    }

    /// Records that row `y` was written.
    pub fn mark_row(&mut self, y: u32) {
        let w = &mut self.written;
        *w = if w.start >= w.end { y..y + 1 } else { w.start.min(y)..w.end.max(y + 1) };
    }
}

//! Rows of a render target: the buffers that a draw writes, split between threads.

use super::draw_call::Target;
use super::plan::{Part, Parts};
use crate::math::coverage::PixelRect;
use crate::memory::{DepthCells, DepthFormat, DepthWords, NOT_PICKED, PickCells, RowCells};
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
    /// Pending clears of their cells.
    clears: Clears<'t>,
    /// Range of rows that were written.
    pub written: Range<u32>,
}

/// Pending clears of some rows: one word a row for depths, and several for ids; empty where none is
/// pending.
struct Clears<'t> {
    depth: &'t mut [u128],
    far: i32,
    ids: &'t mut [u128],
    words_of_ids: usize,
}

impl Clears<'_> {
    /// Splits before row number `rows` of these.
    fn split(self, rows: usize) -> (Self, Self) {
        let Clears { depth, far, ids, words_of_ids } = self;
        let (depth, depth_below) = depth.split_at_mut(rows.min(depth.len()));
        let (ids, ids_below) = ids.split_at_mut((rows * words_of_ids).min(ids.len()));
        let below = Clears { depth: depth_below, far, ids: ids_below, words_of_ids };
        (Clears { depth, far, ids, words_of_ids }, below)
    }
}

impl<'t> TargetRows<'t> {
    /// Returns all rows of the frame, with its depths and ids if the plan uses them.
    pub fn new(target: &'t mut Target, clip: PixelRect, parts: Parts) -> Self {
        let width = target.memory.width() as usize;
        let depth = target.depth.as_mut().filter(|_| parts.uses(Part::DepthMemory));
        let depth = depth.map(|d| (d.format(), d.cells_mut()));
        let ids = target.ids.as_deref_mut().filter(|_| parts.uses(Part::PickBuffer));
        let mut clears = Clears { depth: &mut [], far: 0, ids: &mut [], words_of_ids: 0 };
        let depth = depth.map(|(format, DepthCells { words, narrow, pending_clear, far })| {
            (clears.depth, clears.far) = (pending_clear, far);
            match format {
                DepthFormat::U16 => (format, DepthWords::Narrow(narrow)),
                _ => (format, DepthWords::Wide(words)),
            }
        });
        let ids = ids.map(|ids| {
            let PickCells { ids, pending_clear, row_words } = ids.cells_mut();
            (clears.ids, clears.words_of_ids) = (pending_clear, row_words);
            ids
        });
        let bytes = target.memory.bytes_mut();
        TargetRows { width, clip, y0: 0, bytes, depth, ids, clears, written: 0..0 }
    }

    /// Stores the pending clears of the cells in these columns of row `y`. Whoever reads or writes
    /// depths or ids does this before.
    #[inline]
    pub fn open(&mut self, y: i32, columns: Range<i32>) {
        if !(self.clears.depth.is_empty() && self.clears.ids.is_empty()) {
            self.open_cells((y - self.y0 as i32) as usize, columns.start as usize..columns.end as usize);
        }
    }

    /// Does the same for a rectangle within these rows.
    pub fn open_box(&mut self, PixelRect { x0, y0, x1, y1 }: PixelRect) {
        let columns = x0.max(self.clip.x0)..x1.min(self.clip.x1);
        if columns.start < columns.end {
            (y0.max(self.clip.y0)..y1.min(self.clip.y1)).for_each(|y| self.open(y, columns.clone()));
        }
    }

    #[inline(never)]
    fn open_cells(&mut self, row: usize, columns: Range<usize>) {
        let TargetRows { width, depth, ids, clears, .. } = self;
        let (width, at) = (*width, row * *width);
        if let (Some((_, words)), Some(pending)) = (depth, clears.depth.get_mut(row..row + 1)) {
            let far = clears.far;
            RowCells::of_tiles(width).open(pending, columns.clone(), |xs| match words {
                DepthWords::Narrow(words) => words[at + xs.start..at + xs.end].fill(far as u16),
                DepthWords::Wide(words) => words[at + xs.start..at + xs.end].fill(far),
            });
        }
        let words = row * clears.words_of_ids..(row + 1) * clears.words_of_ids;
        if let (Some(ids), Some(pending)) = (ids, clears.ids.get_mut(words)) {
            RowCells::of_strips(width)
                .open(pending, columns, |xs| ids[at + xs.start..at + xs.end].fill(NOT_PICKED));
        }
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
        let (clears, clears_below) = self.clears.split((row - y0) as usize);
        let at = row as i32;
        let above = PixelRect { y1: self.clip.y1.min(at), ..self.clip };
        let below = PixelRect { y0: self.clip.y0.max(at), ..self.clip };
        (
            TargetRows { width, clip: above, y0, bytes, depth, ids, clears, written: 0..0 },
            TargetRows {
                width,
                clip: below,
                y0: row,
                bytes: bytes_below,
                depth: depth_below,
                ids: ids_below,
                clears: clears_below,
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

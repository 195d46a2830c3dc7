//! Clears that are deferred: runs of pixels of a row (cells) whose clear is pending.
//!
//! In: a clear of everything. Out: which pixels it still concerns, until whoever writes a cell has
//! cleared it. Readers ask before they read.

use std::ops::Range;

/// Columns of a tile's cell; the last one of a row extends to the row's end.
pub(crate) const TILE_CELL: usize = 128;
/// Columns of a strip's cell; the last one of a row may be narrower.
pub(crate) const STRIP_CELL: usize = 16;

/// The cells of a buffer of pixels whose clear is pending.
#[derive(Clone, Debug)]
pub(super) struct PendingClear {
    width: usize,
    /// Columns of a cell, and the number of cells in a row.
    columns: usize,
    cells: usize,
    /// One bit per cell, leftmost cell in bit 0 of the first of a row's [`Self::row_words`] words;
    /// empty if clears are immediate.
    words: Vec<u128>,
    /// Set while some bit may be set.
    has_any: bool,
}

impl PendingClear {
    /// Creates a set without cells, for cells of tiles: one word a row. If the buffer is too wide,
    /// it stays empty.
    pub fn of_tiles(width: u32, height: u32) -> Self {
        let cells = (width as usize / TILE_CELL).max(1);
        let rows = if cells <= u128::BITS as usize { height as usize } else { 0 };
        Self::new(width, rows, TILE_CELL, cells)
    }

    /// Creates a set without cells, for cells of strips.
    pub fn of_strips(width: u32, height: u32) -> Self {
        Self::new(width, height as usize, STRIP_CELL, (width as usize).div_ceil(STRIP_CELL).max(1))
    }

    fn new(width: u32, rows: usize, columns: usize, cells: usize) -> Self {
        let words = vec![0; rows * cells.div_ceil(u128::BITS as usize)];
        PendingClear { width: width as usize, columns, cells, words, has_any: false }
    }

    /// Returns the number of words of a row.
    pub fn row_words(&self) -> usize {
        self.cells.div_ceil(u128::BITS as usize)
    }

    /// Returns the columns of cell number `cell` of a row.
    pub fn columns_of(&self, cell: usize) -> Range<usize> {
        cell * self.columns..if cell + 1 == self.cells { self.width } else { (cell + 1) * self.columns }
    }

    /// Adds all cells. Returns whether it does: otherwise the buffer must be cleared at once.
    pub fn add_all(&mut self) -> bool {
        self.words.fill(u128::MAX);
        self.has_any = !self.words.is_empty();
        self.has_any
    }

    /// Returns whether the clear of a pixel is pending.
    #[inline]
    pub fn contains(&self, index: usize) -> bool {
        self.has_any && self.has_pixel(index)
    }

    fn has_pixel(&self, index: usize) -> bool {
        let (row, column) = (index / self.width, index % self.width);
        let cell = (column / self.columns).min(self.cells - 1);
        let bits = u128::BITS as usize;
        self.words[row * self.row_words() + cell / bits] >> (cell % bits) & 1 == 1
    }

    /// Removes all cells, and calls `clear` with their pixels.
    #[inline]
    pub fn take(&mut self, clear: impl FnMut(Range<usize>)) {
        if std::mem::take(&mut self.has_any) {
            self.take_cells(clear);
        }
    }

    #[cold]
    fn take_cells(&mut self, mut clear: impl FnMut(Range<usize>)) {
        let bits = u128::BITS as usize;
        for word in 0..self.words.len() {
            let (row, first) = (word / self.row_words(), word % self.row_words() * bits);
            let mut cells = std::mem::take(&mut self.words[word]);
            // Runs of cells, from their first one on.
            while cells != 0 {
                let start = cells.trailing_zeros() as usize;
                let end = start + (cells >> start).trailing_ones() as usize;
                cells &= u128::MAX.checked_shl(end as u32).unwrap_or(0);
                if first + start < self.cells {
                    let last = self.cells.min(first + end) - 1;
                    let at = row * self.width;
                    clear(at + self.columns_of(first + start).start..at + self.columns_of(last).end);
                }
            }
        }
    }

    /// Returns the words of all rows; empty if no clear is pending. Whoever clears a bit has
    /// cleared its cell.
    pub fn words_mut(&mut self) -> &mut [u128] {
        if self.has_any { &mut self.words } else { &mut [] }
    }
}

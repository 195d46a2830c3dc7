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

    /// Removes the cell of a pixel, and calls `clear` with the pixels of the cell if its clear was
    /// pending.
    #[inline]
    pub fn open(&mut self, index: usize, clear: impl FnOnce(Range<usize>)) {
        if self.has_any && self.has_pixel(index) {
            let (row, column) = (index / self.width, index % self.width);
            let cell = (column / self.columns).min(self.cells - 1);
            let bits = u128::BITS as usize;
            let word = row * self.row_words() + cell / bits;
            self.words[word] &= !(1 << (cell % bits));
            let columns = self.columns_of(cell);
            clear(row * self.width + columns.start..row * self.width + columns.end);
        }
    }

    /// Adds what lies in these columns of a row: whole cells, and calls `clear` with the pixels of
    /// cells that lie in it in part, unless their clear is pending.
    pub fn add_within(&mut self, row: usize, columns: Range<usize>, mut clear: impl FnMut(Range<usize>)) {
        let at = row * self.width;
        if columns.is_empty() {
            return;
        }
        if self.words.is_empty() {
            return clear(at + columns.start..at + columns.end);
        }
        // Without pending clears all bits are 0.
        self.has_any = true;
        let (size, last) = (self.columns, self.cells - 1);
        let cell_of = |column: usize| (column / size).min(last);
        let (bits, row_words) = (u128::BITS as usize, self.row_words());
        for cell in cell_of(columns.start)..=cell_of(columns.end - 1) {
            let own = self.columns_of(cell);
            let (word, bit) = (row * row_words + cell / bits, 1 << (cell % bits));
            let is_pending = self.words[word] & bit != 0;
            match columns.start <= own.start && own.end <= columns.end {
                true => self.words[word] |= bit,
                false if is_pending => {}
                false => clear(at + own.start.max(columns.start)..at + own.end.min(columns.end)),
            }
        }
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

/// Cells of a row, as a range of rows is split between threads: their columns and their number.
#[derive(Clone, Copy, Debug)]
pub(crate) struct RowCells {
    columns: usize,
    cells: usize,
    width: usize,
}

impl RowCells {
    /// Returns the cells of tiles of a row of `width` pixels.
    pub fn of_tiles(width: usize) -> Self {
        RowCells { columns: TILE_CELL, cells: (width / TILE_CELL).max(1), width }
    }

    /// Returns the cells of strips of a row of `width` pixels.
    pub fn of_strips(width: usize) -> Self {
        RowCells { columns: STRIP_CELL, cells: width.div_ceil(STRIP_CELL).max(1), width }
    }

    /// Removes the pending clears of a row's cells, whose words these are, that contain some of these
    /// columns; calls `clear` with the columns of each.
    pub fn open(&self, words: &mut [u128], columns: Range<usize>, mut clear: impl FnMut(Range<usize>)) {
        if columns.is_empty() || words.iter().all(|word| *word == 0) {
            return;
        }
        let cell_of = |column: usize| (column / self.columns).min(self.cells - 1);
        for cell in cell_of(columns.start)..=cell_of(columns.end - 1) {
            let (word, bit) = (cell / u128::BITS as usize, 1 << (cell % u128::BITS as usize));
            if words[word] & bit != 0 {
                words[word] &= !bit;
                let end = if cell + 1 == self.cells { self.width } else { (cell + 1) * self.columns };
                clear(cell * self.columns..end);
            }
        }
    }
}

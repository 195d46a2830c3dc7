//! Clears that are deferred: runs of pixels of a row (cells) whose clear is pending.
//!
//! In: a clear of everything. Out: which pixels it still concerns, until whoever writes a cell has
//! cleared it. Readers ask before they read.

use std::ops::Range;

/// Columns of a cell; the last cell of a row extends to the row's end.
pub(crate) const CELL: usize = 128;

/// The cells of a buffer of pixels whose clear is pending.
#[derive(Clone, Debug)]
pub(super) struct PendingClear {
    width: usize,
    /// One bit per cell of each row, leftmost cell in bit 0; empty if clears are immediate.
    rows: Vec<u128>,
    /// Set while some bit may be set.
    has_any: bool,
}

/// Returns the columns of cell number `cell` of a row.
pub(super) fn cell_columns(cell: usize, width: usize) -> Range<usize> {
    cell * CELL..if cell + 1 == cells_in(width) { width } else { (cell + 1) * CELL }
}

fn cells_in(width: usize) -> usize {
    (width / CELL).max(1)
}

impl PendingClear {
    /// Creates a set without cells. If the buffer is too wide, it stays empty.
    pub fn new(width: u32, height: u32) -> Self {
        let width = width as usize;
        let rows = if cells_in(width) <= u128::BITS as usize { height as usize } else { 0 };
        PendingClear { width, rows: vec![0; rows], has_any: false }
    }

    /// Adds all cells. Returns whether it does: otherwise the buffer must be cleared at once.
    pub fn add_all(&mut self) -> bool {
        self.rows.fill(u128::MAX);
        self.has_any = !self.rows.is_empty();
        self.has_any
    }

    /// Returns whether the clear of a pixel is pending.
    #[inline]
    pub fn contains(&self, index: usize) -> bool {
        self.has_any && self.has_pixel(index)
    }

    fn has_pixel(&self, index: usize) -> bool {
        let (row, column) = (index / self.width, index % self.width);
        let cell = (column / CELL).min(cells_in(self.width) - 1);
        self.rows[row] >> cell & 1 == 1
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
        let width = self.width;
        for (row, cells) in self.rows.iter_mut().enumerate() {
            let at = row * width;
            match std::mem::take(cells) {
                0 => {}
                u128::MAX => clear(at..at + width),
                bits => (0..cells_in(width)).filter(|cell| bits >> cell & 1 == 1).for_each(|cell| {
                    let columns = cell_columns(cell, width);
                    clear(at + columns.start..at + columns.end);
                }),
            }
        }
    }

    /// Returns the bits of each row; empty if no clear is pending. Whoever clears a bit has cleared
    /// its cell.
    pub fn rows_mut(&mut self) -> &mut [u128] {
        if self.has_any { &mut self.rows } else { &mut [] }
    }
}

//! Pick buffer: the face that last wrote the depth of each pixel. Allocated only when PICK asks for
//! it.
//!
//! Clears are deferred, as those of depths are, but by narrower cells: faces are stored in strips of
//! 16 pixels, and where a strip's clear is pending all of it is written at once. So a pixel where no
//! face is drawn costs nothing, and another one is written once and not twice.

use super::aligned::Aligned;
use super::pending_clear::{PendingClear, STRIP_CELL};

/// Marks a pixel where no face has written depth.
pub(crate) const NO_FACE: [u32; 2] = [u32::MAX; 2];

/// Name number (see `DrawCall::name`) and triangle number of the face at each pixel.
#[derive(Clone, Debug)]
pub struct PickBuffer {
    width: u32,
    height: u32,
    ids: Aligned<[u32; 2]>,
    pending_clear: PendingClear,
}

/// Faces with the pending clears of their cells. Whoever writes a cell must clear it first.
#[derive(Debug, Default)]
pub(crate) struct PickCells<'a> {
    /// Name and triangle of every pixel, row by row.
    pub ids: &'a mut [[u32; 2]],
    /// One bit per cell of [`STRIP_CELL`] columns, leftmost cell in bit 0 of the first of a row's
    /// words; empty if no clear is pending.
    pub pending_clear: &'a mut [u128],
    /// Number of words of a row.
    pub row_words: usize,
}

impl PickCells<'_> {
    /// Splits a buffer of `width` columns into the first rows and the others; an empty one into two
    /// empty ones.
    pub fn split(self, rows: usize, width: usize) -> (Self, Self) {
        let row_words = self.row_words;
        let (ids, ids_below) = self.ids.split_at_mut((rows * width).min(self.ids.len()));
        let words = (rows * row_words).min(self.pending_clear.len());
        let (pending_clear, below) = self.pending_clear.split_at_mut(words);
        let first = PickCells { ids, pending_clear, row_words };
        (first, PickCells { ids: ids_below, pending_clear: below, row_words })
    }

    /// Returns the same cells for a shorter time.
    pub fn reborrow(&mut self) -> PickCells<'_> {
        PickCells { ids: self.ids, pending_clear: self.pending_clear, row_words: self.row_words }
    }

    /// Removes the pending clear of the cell that begins at this row and column. Returns whether
    /// there was one: then the caller must write all of the cell.
    #[inline(always)]
    pub fn take_pending(&mut self, row: usize, column: usize) -> bool {
        let (cell, bits) = (column / STRIP_CELL, u128::BITS as usize);
        let Some(word) = self.pending_clear.get_mut(row * self.row_words + cell / bits) else { return false };
        let bit = 1 << (cell % bits);
        let is_pending = *word & bit != 0;
        *word &= !bit;
        is_pending
    }
}

impl PickBuffer {
    /// Creates a pick buffer of `width` x `height` pixels without any face.
    ///
    /// # Panics
    /// If the system has no memory for it.
    pub fn new(width: u32, height: u32) -> Self {
        let ids = Aligned::zeroed(width as usize * height as usize).expect("room for a frame's ids");
        let mut buffer =
            PickBuffer { width, height, ids, pending_clear: PendingClear::of_strips(width, height) };
        // The first clear is deferred as every other one.
        buffer.clear();
        buffer
    }

    /// Returns the width in pixels.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Returns the height in pixels.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Returns the size of the buffer in bytes.
    pub fn size_bytes(&self) -> usize {
        std::mem::size_of_val(&*self.ids)
    }

    /// Returns the bytes that a buffer of this size takes, with the bits of its pending clears.
    #[doc(hidden)]
    pub fn bytes_for(width: u32, height: u32) -> u64 {
        let words = width.div_ceil(STRIP_CELL as u32 * u128::BITS);
        u64::from(height) * (u64::from(width) * 8 + u64::from(words) * 16)
    }

    /// Removes every face.
    pub fn clear(&mut self) {
        // Without rows there is nothing to clear.
        self.pending_clear.add_all();
    }

    /// Stores all pending clears.
    fn finish_clears(&mut self) {
        self.pending_clear.take(|pixels| self.ids[pixels].fill(NO_FACE));
    }

    /// Forgets the faces of these columns and rows; those beyond the frame are ignored.
    pub fn clear_within(&mut self, columns: &std::ops::Range<u32>, rows: &std::ops::Range<u32>) {
        let end = columns.end.min(self.width) as usize;
        let columns = (columns.start as usize).min(end)..end;
        for row in rows.start..rows.end.min(self.height) {
            let ids = &mut self.ids;
            self.pending_clear.add_within(row as usize, columns.clone(), |pixels| ids[pixels].fill(NO_FACE));
        }
    }

    /// Returns the name number and triangle at pixel (x, y), or `None` off the frame and where no
    /// face wrote depth.
    pub fn get(&self, x: i32, y: i32) -> Option<(u32, u32)> {
        let inside = (x as u32) < self.width && (y as u32) < self.height;
        if !inside {
            return None;
        }
        let index = self.width as usize * y as usize + x as usize;
        let id = self.ids[index];
        (id != NO_FACE && !self.pending_clear.contains(index)).then_some((id[0], id[1]))
    }

    /// Returns name and triangle of every pixel for writing, row 0 first.
    pub fn ids_mut(&mut self) -> &mut [[u32; 2]] {
        self.finish_clears();
        &mut self.ids
    }

    /// Returns all faces with their pending clears.
    pub(crate) fn cells_mut(&mut self) -> PickCells<'_> {
        let row_words = self.pending_clear.row_words();
        PickCells { ids: &mut self.ids, pending_clear: self.pending_clear.words_mut(), row_words }
    }

    /// Stores a face at pixel number `index` (= width * y + x).
    ///
    /// # Panics
    /// If `index` is not a pixel of this buffer.
    #[inline]
    pub fn set(&mut self, index: usize, name: u32, triangle: u32) {
        let ids = &mut self.ids;
        self.pending_clear.open(index, |pixels| ids[pixels].fill(NO_FACE));
        ids[index] = [name, triangle];
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn remembers_the_last_face_and_nothing_off_the_frame() {
        let mut ids = PickBuffer::new(3, 2);
        assert_eq!((ids.width(), ids.height(), ids.size_bytes()), (3, 2, 48));
        ids.set(4, 7, 0);
        ids.set(4, 8, 1);
        assert_eq!((ids.get(1, 1), ids.get(0, 0)), (Some((8, 1)), None));
        for (x, y) in [(-1, 0), (-1, 1), (-1, -1), (0, -1), (4, 0), (0, 2), (i32::MIN, i32::MAX)] {
            assert_eq!(ids.get(x, y), None, "({x}, {y})");
        }
        ids.clear();
        assert_eq!(ids.get(1, 1), None);
    }

    #[test]
    fn a_clear_is_seen_at_once_however_late_it_is_stored() {
        for width in [5, 16, 300, 700, 17_000] {
            let mut ids = PickBuffer::new(width, 4);
            let all = |ids: &PickBuffer| -> Vec<_> {
                (0..4 * width).map(|i| ids.get((i % width) as i32, (i / width) as i32)).collect()
            };
            (0..4 * width).for_each(|i| ids.set(i as usize, i, 3));
            ids.clear();
            let mut want = vec![None; 4 * width as usize];
            assert_eq!(all(&ids), want);
            // The last cell of row 2 is written as the tile renderer does it.
            let (row, cells) = (2 * width as usize, ids.cells_mut());
            let column = (width as usize - 1) / STRIP_CELL * STRIP_CELL;
            let (_, mut rows) = cells.split(1, width as usize);
            assert!(rows.take_pending(1, column) && !rows.take_pending(1, column));
            rows.ids[row - width as usize..][column..width as usize].fill(NO_FACE);
            rows.ids[row - width as usize + column + 1] = [8, 9];
            let last = row + column + 1;
            want[last] = Some((8, 9));
            assert_eq!(all(&ids), want);
            ids.clear_within(&(column as u32 + 1..width), &(2..3));
            want[last] = None;
            assert_eq!(all(&ids), want);
            ids.clear();
            ids.set(3, 5, 6);
            want[3] = Some((5, 6));
            assert_eq!(all(&ids), want);
            assert_eq!(ids.ids_mut().iter().filter(|id| **id != NO_FACE).count(), 1);
        }
    }
}

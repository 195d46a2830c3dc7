//! Face ids of tiles that are drawn in several visits: the pieces of a draw whose lists are bounded,
//! and the slices of one that is preempted.
//!
//! A visit resets the face ids that it has coloured. The next one of the same draw needs them, to
//! compare faces that are close ([`super::close_depths`]), so the picture does not depend on where the
//! visits end.

use super::grid::Grid;
use super::tile_buffers::{EXACT_FACE_BIT, ID_STRIDE, NO_FACE, Tile};
use std::sync::{Mutex, PoisonError};

/// Face ids of the frame, a list for each row of tiles; empty where no
/// visit was followed by another.
#[derive(Debug, Default)]
pub(crate) struct KeptIds(Vec<Mutex<Vec<i32>>>);

impl KeptIds {
    /// Returns the most bytes for a frame of this size.
    pub fn most_bytes(size: (usize, usize)) -> usize {
        let rows = Grid::of_frame(size).rows;
        rows * (size.0 * Grid::TILE_ROWS as usize * size_of::<i32>() + 2 * size_of::<Mutex<Vec<i32>>>())
    }

    /// Returns the capacity in bytes.
    pub fn size_bytes(&self) -> usize {
        let row = |row: &Mutex<Vec<i32>>| row.lock().unwrap_or_else(PoisonError::into_inner).capacity() * 4;
        self.0.capacity() * size_of::<Mutex<Vec<i32>>>() + self.0.iter().map(row).sum::<usize>()
    }

    /// Forgets all ids, for another draw over so many rows of tiles; the allocations are reused.
    pub fn reset(&mut self, rows: usize) {
        for row in &mut self.0 {
            row.get_mut().unwrap_or_else(PoisonError::into_inner).clear();
        }
        if self.0.len() < rows {
            self.0.resize_with(rows, Mutex::default);
        }
    }

    /// Sets the ids of a tile of row `band` to those that its last visit kept; returns whether there
    /// are any.
    pub fn restore(&self, band: usize, tile: &mut Tile<'_>) -> bool {
        let row = self.0[band].lock().unwrap_or_else(PoisonError::into_inner);
        if row.is_empty() {
            return false;
        }
        let columns = (tile.x1 - tile.x0) as usize;
        for (to, from) in tile.ids.chunks_exact_mut(ID_STRIDE).zip(row.chunks_exact(tile.width)) {
            to[..columns].copy_from_slice(&from[tile.x0 as usize..tile.x1 as usize]);
        }
        tile.depths = None;
        true
    }

    /// Keeps the ids of a tile of row `band` for its next visit.
    pub fn keep(&self, band: usize, tile: &Tile<'_>) {
        let mut row = self.0[band].lock().unwrap_or_else(PoisonError::into_inner);
        if row.is_empty() {
            let pixels = tile.width * Grid::TILE_ROWS as usize;
            row.reserve_exact(pixels);
            row.resize(pixels, NO_FACE);
        }
        let columns = (tile.x1 - tile.x0) as usize;
        for (from, to) in tile.ids.chunks_exact(ID_STRIDE).zip(row.chunks_exact_mut(tile.width)) {
            to[tile.x0 as usize..tile.x1 as usize].copy_from_slice(&from[..columns]);
        }
    }
}

/// Removes the ids of faces before `first`, which earlier visits have coloured, from a tile.
pub(super) fn remove_earlier(tile: &mut Tile<'_>, first: usize) {
    for id in tile.ids.iter_mut() {
        if *id != NO_FACE && ((*id & !EXACT_FACE_BIT) as usize) < first {
            *id = NO_FACE;
        }
    }
}

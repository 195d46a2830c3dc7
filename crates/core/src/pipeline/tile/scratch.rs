//! Buffers that are reused from draw to draw, so that a steady frame allocates nothing large.

use super::bins::{Bin, Chunk, Larger, Small};
use super::depth_f64::DepthVertex;
use super::exact_faces::ExactFace;
use super::grid::Grid;
use super::kept_ids::KeptIds;
use super::list_bytes::ListBytes;
use super::vertex::ScreenVertex;
use std::sync::atomic::AtomicU8;

/// Size in bytes of a screen vertex, and of a vertex's depth in f64.
pub(crate) const SCREEN_VERTEX_BYTES: u64 = size_of::<ScreenVertex>() as u64;
pub(crate) const DEPTH_VERTEX_BYTES: u64 = size_of::<DepthVertex>() as u64;

/// Limit in bytes of a draw's tile lists, beyond which it is drawn in pieces; a budget may set a
/// lower one.
pub(crate) const LIST_BYTES: usize = 256 << 20;

/// Buffers of a draw.
#[derive(Debug)]
pub(crate) struct Scratch {
    /// Visibility of each cluster of faces.
    pub(super) visibilities: Vec<u8>,
    /// Set for the blocks of vertices that an open cluster uses; empty if all are transformed.
    pub(super) marks: Vec<AtomicU8>,
    /// Vertices on the screen.
    pub(super) screen_vertices: Vec<ScreenVertex>,
    /// The vertices' depths in f64, for the depth formats that need them.
    pub(super) depth_f64: Vec<DepthVertex>,
    /// Binned faces of the chunks.
    pub(super) chunks: Vec<Chunk>,
    /// Bit set for each tile: the chunks that reach it; empty if there is only one chunk.
    pub(super) visitors: Vec<u64>,
    /// Face ids of tiles that are visited again.
    pub(super) kept_ids: KeptIds,
    /// Capacity of the chunks' lists in bytes.
    pub(super) bytes: ListBytes,
    /// Limit of `bytes`; beyond it a draw is split into pieces.
    pub list_bytes: usize,
    /// Set if several draws share `bytes`: once it exceeds the limit, none of them starts a
    /// cluster of faces.
    pub(super) is_shared: bool,
}

impl Default for Scratch {
    fn default() -> Self {
        Scratch {
            visibilities: Vec::new(),
            marks: Vec::new(),
            screen_vertices: Vec::new(),
            depth_f64: Vec::new(),
            chunks: Vec::new(),
            visitors: Vec::new(),
            kept_ids: KeptIds::default(),
            bytes: ListBytes::default(),
            list_bytes: LIST_BYTES,
            is_shared: false,
        }
    }
}

impl Scratch {
    /// Returns the capacity of all buffers in bytes.
    pub fn size_bytes(&self) -> usize {
        let bin = |b: &Bin| {
            size_of::<Bin>()
                + b.larger.capacity() * size_of::<Larger>()
                + b.fragments.size_bytes()
                + b.tiny.size_bytes()
                + b.small.capacity() * size_of::<Small>()
        };
        let chunk = |c: &Chunk| {
            c.exact_faces.capacity() * size_of::<ExactFace>()
                + c.reached.capacity() * 4
                + c.bins.iter().map(bin).sum::<usize>()
        };
        self.vertex_bytes() + self.chunks.iter().map(chunk).sum::<usize>()
    }

    /// Returns the capacity in bytes of all buffers except the tiles' lists.
    pub fn vertex_bytes(&self) -> usize {
        self.visibilities.capacity()
            + self.marks.capacity()
            + self.visitors.capacity() * 8
            + self.kept_ids.size_bytes()
            + self.screen_vertices.capacity() * 16
            + self.depth_f64.capacity() * size_of::<DepthVertex>()
    }

    /// Records for each tile which of the first chunks reach it; returns the first and the last row
    /// of tiles reached.
    pub(super) fn note_visitors(&mut self, chunk_count: usize, grid: &Grid) -> Option<(usize, usize)> {
        self.visitors.clear();
        self.visitors.resize(if chunk_count > 1 { grid.columns * grid.rows } else { 0 }, 0);
        let (mut first, mut last) = (usize::MAX, 0);
        for (i, chunk) in self.chunks[..chunk_count].iter().enumerate() {
            for &tile in &chunk.reached {
                if let Some(visitors) = self.visitors.get_mut(tile as usize) {
                    *visitors |= 1 << i;
                }
                let band = tile as usize / grid.columns;
                (first, last) = (first.min(band), last.max(band));
            }
        }
        (first <= last).then_some((first, last))
    }

    /// Counts the tiles' lists in `bytes`, a counter shared with other draws whose lists together
    /// have the limit `most`.
    pub fn share_lists(&mut self, bytes: &ListBytes, most: usize) {
        (self.bytes, self.list_bytes, self.is_shared) = (bytes.clone(), most, true);
    }

    /// Returns the capacity of all tiles' lists in bytes.
    pub fn lists_held(&self) -> usize {
        self.bytes.get()
    }

    /// Frees all tiles' lists.
    pub fn give_lists_back(&mut self) {
        self.chunks = Vec::new();
        self.bytes.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lists_of_each_chunk_count_with_their_capacity() {
        let mut scratch = Scratch::default();
        assert_eq!(scratch.size_bytes(), 0);
        scratch.chunks.resize_with(2, Chunk::default);
        scratch.chunks[0].reached.reserve_exact(9);
        assert_eq!(scratch.size_bytes(), 9 * 4);
        scratch.chunks[1].exact_faces.reserve_exact(3);
        assert_eq!(scratch.size_bytes(), 9 * 4 + 3 * size_of::<ExactFace>());
        scratch.chunks[1].bins.resize_with(5, Bin::default);
        let lists = 9 * 4 + 3 * size_of::<ExactFace>() + 5 * size_of::<Bin>();
        assert_eq!(scratch.size_bytes(), lists);
        scratch.chunks[1].bins[2].small.reserve_exact(4);
        scratch.chunks[1].bins[3].larger.reserve_exact(6);
        let more = 4 * size_of::<Small>() + 6 * size_of::<Larger>();
        assert_eq!(scratch.size_bytes(), lists + more);
    }
}

//! Binning of a draw's faces into tiles: clusters, vertices and set-up, in pieces of bounded
//! memory.
//!
//! In: a draw job. Out: one piece of its faces after the other, each to be drawn before the next is
//! requested. Most draws are one piece.
//!
//! Promise: the lists' capacity is at most `Scratch::list_bytes` before the last cluster of 16
//! faces that each thread begins; [`worst_list_bytes`] states the worst case.
//!
//! Verified by tests/allocations/draw_memory.rs, which measures the memory that draws hold.

use super::bins::{self, Bin, Chunk};
use super::clusters::{ClusterKernel, CullView};
use super::depth_f64::DepthVertexKernel;
use super::draw_job::{DepthF64, DrawJob};
use super::exact_faces::ExactFace;
use super::grid::Grid;
use super::kept_ids::KeptIds;
use super::scratch::Scratch;
use super::setup::SetupKernel;
use super::vertex::{Projector, VertexKernel, WIDTH};
use crate::executor::Executor;
use crate::pipeline::draw_call::DrawStats;
use crate::pipeline::indexed_mesh::{CHUNK_FACES, CLUSTER_FACES, MOST_CHUNKS, chunk_faces};
use crate::simd::Level;
use crate::simd::allocator::resize_in_huge_pages;
use std::ops::Range;
use std::sync::atomic::AtomicU8;

/// Vertices in a piece of vertex work.
const CHUNK_VERTICES: usize = 4096;
/// Clusters in a piece of culling.
const CHUNK_CLUSTERS: usize = 2048;

/// Returns the bytes of the empty bins of all tiles of a frame of this size.
pub(crate) fn grid_bytes(size: (usize, usize)) -> usize {
    Bin::grid_bytes(&Grid::of_frame(size))
}

/// Estimates the bytes of the tiles' lists for a mesh of `faces` faces of which `kept` are drawn,
/// most of them small, in a frame of this size.
pub(crate) fn bin_bytes(faces: u64, kept: u64, size: (usize, usize)) -> u64 {
    let chunks = faces.div_ceil(chunk_faces(faces as usize) as u64);
    // Lists grow by doubling: on average they are three quarters full. Fragments take less.
    let face = size_of::<bins::TinyWords>() as u64 * 4 / 3;
    chunks * grid_bytes(size) as u64 + kept * face
}

/// Returns an upper bound on the bytes of the tiles' lists while any `faces` faces are drawn in a
/// frame of this size by `threads` threads, where a draw is split into pieces beyond `list_bytes`.
///
/// A face that fills the frame is in the list of every tile. A list's capacity is at most twice its
/// items (or a vector's), and its old allocation coexists with the new one while it moves. Beyond
/// `list_bytes` a thread finishes its cluster, which may double each list once more.
pub(crate) fn worst_list_bytes(faces: u64, threads: u64, size: (usize, usize), list_bytes: u64) -> u64 {
    let chunks = faces.div_ceil(chunk_faces(faces as usize) as u64);
    let by_faces = chunks.saturating_mul(empty_chunk_bytes(size)).saturating_add(waiting_bytes(faces, size));
    let most = by_faces.min(2 * list_bytes + unbounded_bytes(threads, size));
    most + most / 2
}

/// Returns the largest `list_bytes` for which [`worst_list_bytes`] is at most `bytes`; `None` if
/// even the smallest bound is too large.
pub(crate) fn list_bound(bytes: u64, threads: u64, size: (usize, usize)) -> Option<u64> {
    let bound = (bytes - bytes / 3).checked_sub(unbounded_bytes(threads, size))? / 2;
    Some(bound).filter(|bound| *bound >= 4 * empty_chunk_bytes(size))
}

/// Returns the bytes of a chunk's lists for all tiles of a frame before a face is added, and of the
/// room that vectors write beyond their count.
fn empty_chunk_bytes(size: (usize, usize)) -> u64 {
    let grid = Grid::of_frame(size);
    let entry = size_of::<bins::Larger>() + size_of::<bins::Small>();
    let room = 2 * 16 * (size_of::<bins::TinyWords>() + 12) + 4 * entry;
    (Bin::grid_bytes(&grid) + grid.columns * grid.rows * room + 4 * size_of::<ExactFace>()) as u64
}

/// Upper bound on the tiles that a small face reaches: it is narrower than two tile columns and
/// lower than three tile rows.
const SMALL_TILES: usize = 2 * 3;

/// Returns the bytes of the lists for `faces` faces, each of them in all tiles.
fn waiting_bytes(faces: u64, size: (usize, usize)) -> u64 {
    let grid = Grid::of_frame(size);
    let places = grid.columns * grid.rows * size_of::<bins::Larger>();
    let own = size_of::<ExactFace>() + SMALL_TILES * size_of::<bins::Small>();
    (2 * faces).saturating_mul((places + own) as u64)
}

/// Returns the bytes that threads may add once the bound is reached, apart from lists that double:
/// each finishes a cluster, possibly its first; and of the face ids that pieces leave to the next.
fn unbounded_bytes(threads: u64, size: (usize, usize)) -> u64 {
    threads * (empty_chunk_bytes(size) + waiting_bytes(CLUSTER_FACES as u64, size))
        + KeptIds::most_bytes(size) as u64
}

/// Binned faces of a piece of a draw.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Binned {
    /// First and last row of tiles that a face reaches; `None` if no tile is reached.
    pub bands: Option<(usize, usize)>,
    /// End of the piece's range of faces.
    pub until: usize,
    /// Grid of the tiles.
    pub(super) grid: Grid,
    /// Start of the piece's range of faces.
    pub(super) first_face: usize,
    /// Faces in a chunk; the last one may have fewer.
    pub(super) chunk_faces: usize,
    /// Number of chunks, the first ones of the scratch.
    pub(super) chunk_count: usize,
    /// Largest spread of the draw's faces so far: see [`super::close_depths`].
    pub(super) spread: f32,
}

/// Binning of a draw's faces, in pieces if their lists would take too much memory.
///
/// A piece is a range of faces in file order. Depths and colours of the earlier pieces are in the
/// frame when it is drawn, and their face ids are kept, so each fragment meets what it would meet in
/// one piece, and the last one to win a pixel colours it: the bytes are equal.
pub(crate) struct Binning {
    projector: Projector,
    grid: Grid,
    /// First face that is not drawn yet.
    next: usize,
    /// Upper bound on the faces of the next piece, and of any.
    piece: usize,
    most: usize,
    /// Number of vertices that are transformed.
    placed: usize,
    /// Largest spread of the faces that are binned.
    spread: f32,
    /// Set if the last piece ended because its lists reached the limit.
    is_stopped: bool,
}

impl Binning {
    /// Culls the clusters of `job` and makes room for its vertices. Must be called inside
    /// [`Executor::run`].
    pub fn new(
        level: Level,
        executor: &Executor,
        scratch: &mut Scratch,
        job: &DrawJob<'_>,
        width: usize,
    ) -> Self {
        let (mesh, view) = (job.mesh, job.view);
        let to_view = job.to_screen.to_view();
        // Clusters that cannot be visible are skipped, with the vertices that no other cluster
        // uses.
        let clusters = &mesh.clusters;
        scratch.visibilities.resize(clusters.len(), 0);
        scratch.marks.clear();
        if clusters.knows_blocks() {
            scratch.marks.resize_with(mesh.vertex_count().div_ceil(WIDTH), AtomicU8::default);
        }
        let marks = scratch.marks.as_slice();
        if !clusters.is_empty() {
            let cull_view =
                &CullView::new(job.to_screen, &to_view, mesh.farthest, job.complement, &view, job.winding);
            executor.chunks(&mut scratch.visibilities, CHUNK_CLUSTERS, |i, visibilities| {
                let first = i * CHUNK_CLUSTERS;
                level.dispatch(ClusterKernel { clusters, first, cull_view, visibilities, marks });
            });
        }
        let vertex_count = mesh.vertex_count();
        resize_in_huge_pages(&mut scratch.screen_vertices, vertex_count, [0.0; 4]);
        if job.depth_f64.is_some() {
            resize_in_huge_pages(&mut scratch.depth_f64, vertex_count, [0.0; 4]);
        }
        let grid = Grid::new(&view, width);
        scratch.kept_ids.reset(grid.rows);
        Binning {
            projector: Projector::new(*job.to_screen, &to_view, mesh.farthest),
            grid,
            next: 0,
            piece: mesh.triangle_count,
            most: usize::MAX,
            placed: 0,
            spread: 0.0,
            is_stopped: scratch.bytes.get() > scratch.list_bytes && !scratch.is_shared,
        }
    }

    /// Bounds the pieces of a draw that can be preempted: a chunk of faces in a tile is drawn without
    /// a pause.
    pub fn bound_chunks(&mut self) {
        self.most = MOST_CHUNKS * CHUNK_FACES;
    }

    /// Bins the faces of the next piece into `scratch`, and adds the counts of culled faces to
    /// `stats`; `None` after the last piece. Must be called inside [`Executor::run`].
    pub fn next(
        &mut self,
        level: Level,
        executor: &Executor,
        scratch: &mut Scratch,
        job: &DrawJob<'_>,
        stats: &mut DrawStats,
    ) -> Option<Binned> {
        let faces = job.mesh.triangle_count;
        if self.next >= faces {
            return None;
        }
        if std::mem::take(&mut self.is_stopped) {
            // Capacity of other tiles' lists is of no use to this piece, but it counts.
            scratch.give_lists_back();
        }
        let (first_face, end) = (self.next, (self.next + self.piece.min(self.most)).min(faces));
        let grid = self.grid;
        // Empty lists take memory, too: a chunk has one for each tile.
        let most_chunks = (scratch.list_bytes / 4 / Bin::grid_bytes(&grid).max(1)).max(1);
        let chunk_faces = chunk_faces(end - first_face)
            .max((end - first_face).div_ceil(most_chunks).next_multiple_of(CLUSTER_FACES));
        let chunk_count = (end - first_face).div_ceil(chunk_faces);
        if scratch.chunks.len() < chunk_count {
            scratch.chunks.resize_with(chunk_count, Chunk::default);
        }
        // In rounds: vertices, then the faces that use them while they are in the cache. With a
        // pool, which synchronizes after each stage, one round takes all chunks.
        let round = if executor.pool().is_some() { chunk_count } else { 1 };
        let faces_of = |i: usize| {
            let start = first_face + i * chunk_faces;
            start..(start + chunk_faces).min(end)
        };
        let (mut begun, mut is_stopped) = (0, false);
        while begun < chunk_count && !is_stopped {
            let chunks = begun..(begun + round).min(chunk_count);
            self.place_vertices(level, executor, scratch, job, faces_of(chunks.end - 1).end);
            self.set_up(level, executor, scratch, job, chunks.clone(), &faces_of);
            if executor.is_cancelled() {
                // The lists may still hold another draw.
                return None;
            }
            begun = chunks.end;
            is_stopped = chunks.into_iter().any(|i| scratch.chunks[i].done < faces_of(i).len());
        }
        // Chunks that were set up after the one that stopped are set up again, so that the order is
        // kept.
        let count = (0..begun).find(|&i| scratch.chunks[i].done < faces_of(i).len()).unwrap_or(begun);
        let last_done = scratch.chunks.get(count).filter(|_| is_stopped).map_or(0, |c| c.done);
        let used = count + usize::from(last_done > 0);
        let until = match is_stopped {
            true => faces_of(count).start + last_done,
            false => end,
        };
        (self.next, self.is_stopped) = (until, is_stopped);
        if is_stopped {
            self.piece = scratch.chunks[..begun].iter().map(|c| c.done).sum::<usize>().max(CLUSTER_FACES);
        } else if scratch.bytes.get() < scratch.list_bytes / 2 {
            self.piece *= 2;
        }
        for chunk in &scratch.chunks[..used] {
            *stats += chunk.stats;
            self.spread = self.spread.max(chunk.spread);
        }
        let spread = self.spread;
        let bands = scratch.note_visitors(used, &grid);
        Some(Binned { bands, until, grid, first_face, chunk_faces, chunk_count: used, spread })
    }

    /// Transforms the vertices that the faces before `end` use, except those that already are.
    fn place_vertices(
        &mut self,
        level: Level,
        executor: &Executor,
        scratch: &mut Scratch,
        job: &DrawJob<'_>,
        end: usize,
    ) {
        let (mesh, projector, placed) = (job.mesh, &self.projector, self.placed);
        let marks = scratch.marks.as_slice();
        let vertex_count = mesh.vertex_count();
        let asked = mesh.asked[(end - 1) / chunk_faces(mesh.triangle_count)] as usize;
        let until = asked.next_multiple_of(WIDTH).min(vertex_count).max(placed);
        let range_of = |i: usize, length: usize| {
            let start = placed + i * CHUNK_VERTICES;
            let marks = if marks.is_empty() {
                marks
            } else {
                &marks[start / WIDTH..(start + length).div_ceil(WIDTH)]
            };
            ([0, 1, 2].map(|axis| &mesh.positions[axis][start..start + length]), marks)
        };
        executor.chunks(&mut scratch.screen_vertices[placed..until], CHUNK_VERTICES, |i, screen_vertices| {
            let (positions, marks) = range_of(i, screen_vertices.len());
            level.dispatch(VertexKernel { positions, projector, marks, screen_vertices });
        });
        if let Some(DepthF64 { row, .. }) = job.depth_f64 {
            executor.chunks(&mut scratch.depth_f64[placed..until], CHUNK_VERTICES, |i, out| {
                let (positions, marks) = range_of(i, out.len());
                level.dispatch(DepthVertexKernel { positions, to_screen: job.to_screen, row, marks, out });
            });
        }
        self.placed = until;
    }

    /// Sets up faces: culls, bounds, rasterizes tiny ones, and bins them into tiles.
    fn set_up(
        &self,
        level: Level,
        executor: &Executor,
        scratch: &mut Scratch,
        job: &DrawJob<'_>,
        chunks: Range<usize>,
        faces_of: &(impl Fn(usize) -> Range<usize> + Sync),
    ) {
        let (mesh, grid) = (job.mesh, self.grid);
        let (most_bytes, is_shared) = (scratch.list_bytes, scratch.is_shared);
        let (screen_vertices, visibilities, bytes) =
            (scratch.screen_vertices.as_slice(), scratch.visibilities.as_slice(), &scratch.bytes);
        let first_chunk = chunks.start;
        executor.chunks(&mut scratch.chunks[chunks], 1, |i, chunk| {
            let range = faces_of(first_chunk + i);
            let padded = range.start..range.end.next_multiple_of(16);
            chunk[0].reset(grid.columns * grid.rows, bytes);
            level.dispatch(SetupKernel {
                screen_vertices,
                corners: [0, 1, 2].map(|k| &mesh.corners[k][padded.clone()]),
                faces: range.len(),
                visibilities: visibilities
                    .get(range.start / CLUSTER_FACES..range.end.div_ceil(CLUSTER_FACES))
                    .unwrap_or(&[]),
                first_face: range.start as u32,
                winding: job.winding,
                view: job.view,
                grid,
                plain: job.plain,
                most_bytes,
                is_first: first_chunk + i == 0 && !is_shared,
                chunk: &mut chunk[0],
            });
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::bins::{BinEntry, Larger};
    use super::super::list_bytes::ListBytes;
    use super::*;

    #[test]
    fn the_least_bytes_of_a_chunk_hold_vectors_and_a_few_larger_faces_in_each_tile() {
        let size = (1000, 700);
        let grid = Grid::of_frame(size);
        let (mut chunk, bytes) = (Chunk::default(), ListBytes::default());
        chunk.reset(grid.columns * grid.rows, &bytes);
        for bin in &mut chunk.bins {
            // A vector of one face, and the room for another vector behind it.
            bin.tiny.room(16, &bytes);
            bin.tiny.grow(1);
            bin.tiny.room(16, &bytes);
            let entry = BinEntry::OrderBreak;
            bytes.push(&mut bin.larger, Larger { fragments_before: 0, tiny_before: 1, entry });
        }
        let least = empty_chunk_bytes(size);
        assert!(bytes.get() as u64 <= least, "{} of {least}", bytes.get());
        assert!(least < 4 * bytes.get() as u64, "{} of {least}", bytes.get());
    }
}

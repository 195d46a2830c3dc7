//! From faces to the lists of the tiles that they reach: clusters, vertices, set-up, in pieces of a size of their own.
//!
//! In: a job. Out: piece after piece of its faces, each to be drawn before the next is asked for. Most draws are one piece. Promises
//! that the lists have room for at most `Scratch::list_bytes` before the last cluster of 16 faces that each thread begins; what
//! that is at worst is stated by [`worst_list_bytes`]. One would know by tests/allocations/draw_memory.rs, which counts.

use super::bins::{self, Chunk, Grid, ListBytes};
use super::clusters::{CLUSTER_FACES, ClusterKernel, CullView};
use super::depth_f64::DepthVertexKernel;
use super::exact_faces::ExactFace;
use super::indexed_mesh::chunk_faces;
use super::setup::SetupKernel;
use super::vertex::{Projector, VertexKernel, WIDTH};
use super::{CancellableExecutor, ClipRect, DepthF64, DrawJob, Scratch};
use crate::pipeline::draw_call::DrawStats;
use crate::simd::Level;
use crate::simd::allocator::resize_in_huge_pages;
use std::ops::Range;
use std::sync::atomic::AtomicU8;

/// Vertices that one piece of vertex work takes.
const CHUNK_VERTICES: usize = 4096;
/// Clusters that are decided on in one piece.
const CHUNK_CLUSTERS: usize = 2048;

/// Bytes of the empty lists of all tiles of a frame of this size.
pub(crate) fn grid_bytes((width, height): (usize, usize)) -> usize {
    Grid::new(&ClipRect { x0: 0, y0: 0, x1: width as i32, y1: height as i32 }, width).bytes()
}

/// About how many bytes the tiles' lists take for a mesh of `faces` faces of which `kept` are drawn, most of them small, in a
/// frame of this size.
pub(crate) fn bin_bytes(faces: u64, kept: u64, size: (usize, usize)) -> u64 {
    let chunks = faces.div_ceil(chunk_faces(faces as usize) as u64);
    // Lists grow by doubling: on the average they are three quarters full. Fragments take less.
    let face = size_of::<bins::TinyWords>() as u64 * 4 / 3;
    chunks * grid_bytes(size) as u64 + kept * face
}

/// Bytes that the tiles' lists of a draw have room for before it is drawn in pieces, unless a budget leaves less.
pub(crate) const LIST_BYTES: usize = 256 << 20;

/// Bytes that the tiles' lists may take while `faces` faces are drawn in a frame of this size by so many threads, whatever the
/// faces are like, where a draw goes on in pieces beyond `list_bytes`.
///
/// A face that fills the frame is in the list of every tile. A list has room for at most twice its items (or a vector's), and while
/// it moves its old room is there as well. Beyond `list_bytes` a thread ends its cluster, which may double each list once more.
pub(crate) fn worst_list_bytes(faces: u64, threads: u64, size: (usize, usize), list_bytes: u64) -> u64 {
    let chunks = faces.div_ceil(chunk_faces(faces as usize) as u64);
    let by_faces = chunks.saturating_mul(empty_chunk_bytes(size)).saturating_add(waiting_bytes(faces, size));
    let most = by_faces.min(2 * list_bytes + unbounded_bytes(threads, size));
    most + most / 2
}

/// The largest bound of the lists with which [`worst_list_bytes`] are not more than `bytes`; `None` where even the smallest bound
/// is too large.
pub(crate) fn list_bound(bytes: u64, threads: u64, size: (usize, usize)) -> Option<u64> {
    let bound = (bytes - bytes / 3).checked_sub(unbounded_bytes(threads, size))? / 2;
    Some(bound).filter(|bound| *bound >= 4 * empty_chunk_bytes(size))
}

/// Bytes of a chunk's lists for all tiles of a frame before a face is in them, and of the room that vectors write over.
fn empty_chunk_bytes((width, height): (usize, usize)) -> u64 {
    let grid = Grid::new(&ClipRect { x0: 0, y0: 0, x1: width as i32, y1: height as i32 }, width);
    let entry = size_of::<bins::Larger>() + size_of::<bins::Small>();
    let room = 2 * 16 * (size_of::<bins::TinyWords>() + 12) + 4 * entry;
    (grid.bytes() + grid.columns * grid.rows * room + 4 * size_of::<ExactFace>()) as u64
}

/// Tiles that a small face reaches at most: it is narrower than two columns of tiles and lower than three rows.
const SMALL_TILES: usize = 2 * 3;

/// Bytes of the room for so many faces, each of them in all tiles.
fn waiting_bytes(faces: u64, (width, height): (usize, usize)) -> u64 {
    let grid = Grid::new(&ClipRect { x0: 0, y0: 0, x1: width as i32, y1: height as i32 }, width);
    let places = grid.columns * grid.rows * size_of::<bins::Larger>();
    let own = size_of::<ExactFace>() + SMALL_TILES * size_of::<bins::Small>();
    (2 * faces).saturating_mul((places + own) as u64)
}

/// Bytes that threads may add once the bound is reached, lists that double aside: each ends a cluster, perhaps its first.
fn unbounded_bytes(threads: u64, size: (usize, usize)) -> u64 {
    threads * (empty_chunk_bytes(size) + waiting_bytes(CLUSTER_FACES as u64, size))
}

/// Where the faces of a piece of a draw wait for their tiles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Binned {
    /// The bands of tiles that something reaches: the first and the last; `None` where nothing reaches one.
    pub bands: Option<(usize, usize)>,
    /// One beyond the last face of the piece.
    pub until: usize,
    pub(super) grid: Grid,
    pub(super) first_face: usize,
    pub(super) chunk_faces: usize,
    pub(super) chunk_count: usize,
}

/// The way of a draw's faces to their tiles, in pieces where their lists would take too much memory.
///
/// A piece is a run of faces in file order. Depths and colours of the pieces before it are in the frame when it is drawn, so
/// each fragment meets what it would have met in one piece, and the last one to win a pixel colours it: the same bytes.
pub(crate) struct Binning {
    projector: Projector,
    grid: Grid,
    /// The first face that has not been drawn.
    next: usize,
    /// How many faces the next piece takes at most.
    piece: usize,
    /// How many vertices have their records.
    placed: usize,
    /// The last piece ended because its lists took too much memory.
    is_stopped: bool,
}

impl Binning {
    /// Decides on the clusters of `job`, and makes room for its vertices. To be called inside [`CancellableExecutor::run`].
    pub fn new(
        level: Level,
        executor: &CancellableExecutor,
        scratch: &mut Scratch,
        job: &DrawJob<'_>,
        width: usize,
    ) -> Self {
        let (mesh, view) = (job.mesh, job.view);
        let to_view = job.to_screen.to_view();
        // Clusters: those of which nothing can be seen are left out, with the vertices that no other asks for.
        let clusters = &mesh.clusters;
        scratch.visibilities.resize(clusters.len(), 0);
        scratch.marks.clear();
        if clusters.knows_blocks() {
            scratch.marks.resize_with(mesh.vertex_count().div_ceil(WIDTH), AtomicU8::default);
        }
        let marks = scratch.marks.as_slice();
        if !clusters.is_empty() {
            let cull_view =
                &CullView::new(&job.to_screen, &to_view, mesh.farthest, job.complement, &view, job.winding);
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
        Binning {
            projector: Projector::new(job.to_screen, &to_view, mesh.farthest),
            grid: Grid::new(&view, width),
            next: 0,
            piece: mesh.triangle_count,
            placed: 0,
            is_stopped: scratch.bytes.get() > scratch.list_bytes && !scratch.is_shared,
        }
    }

    /// Brings the faces of the next piece to their tiles, in `scratch`, and adds what was left out to `stats`; `None` after the
    /// last one. To be called inside [`CancellableExecutor::run`].
    pub fn next(
        &mut self,
        level: Level,
        executor: &CancellableExecutor,
        scratch: &mut Scratch,
        job: &DrawJob<'_>,
        stats: &mut DrawStats,
    ) -> Option<Binned> {
        let faces = job.mesh.triangle_count;
        if self.next >= faces {
            return None;
        }
        if std::mem::take(&mut self.is_stopped) {
            // Room that the lists of other tiles have is of no use here, and is counted.
            scratch.give_lists_back();
        }
        let (first_face, end) = (self.next, (self.next + self.piece).min(faces));
        let grid = self.grid;
        // Lists that are empty take room, too: a chunk has one for each tile.
        let most_chunks = (scratch.list_bytes / 4 / grid.bytes().max(1)).max(1);
        let chunk_faces = chunk_faces(end - first_face)
            .max((end - first_face).div_ceil(most_chunks).next_multiple_of(CLUSTER_FACES));
        let chunk_count = (end - first_face).div_ceil(chunk_faces);
        if scratch.chunks.len() < chunk_count {
            scratch.chunks.resize_with(chunk_count, Chunk::default);
        }
        // In rounds: vertices, then the faces that ask for them while they are still near. Threads that meet after each stage
        // take all chunks in one round.
        let round = if executor.pool().is_some() { chunk_count } else { 1 };
        let faces_of = |i: usize| {
            let start = first_face + i * chunk_faces;
            start..(start + chunk_faces).min(end)
        };
        let (mut begun, mut is_stopped) = (0, false);
        while begun < chunk_count && !is_stopped {
            let chunks = begun..(begun + round).min(chunk_count);
            self.place_vertices(level, executor, scratch, job, faces_of(chunks.end - 1).end);
            self.set_up(level, executor, scratch, job, (chunks.clone(), &faces_of));
            if executor.is_cancelled() {
                // Lists may be those of another draw.
                return None;
            }
            begun = chunks.end;
            is_stopped = chunks.into_iter().any(|i| scratch.chunks[i].done < faces_of(i).len());
        }
        // What was set up behind a stop is set up again: it would be drawn before its turn.
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
        scratch.chunks[..used].iter().for_each(|chunk| *stats += chunk.stats);
        let bands = scratch.note_visitors(used, &grid);
        Some(Binned { bands, until, grid, first_face, chunk_faces, chunk_count: used })
    }

    /// Makes the records of the vertices that the faces before `end` ask for, as far as they are not made.
    fn place_vertices(
        &mut self,
        level: Level,
        executor: &CancellableExecutor,
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
                level.dispatch(DepthVertexKernel { positions, to_screen: &job.to_screen, row, marks, out });
            });
        }
        self.placed = until;
    }

    /// Faces: culled, bounded, covered if they are tiny, binned into tiles.
    fn set_up(
        &self,
        level: Level,
        executor: &CancellableExecutor,
        scratch: &mut Scratch,
        job: &DrawJob<'_>,
        (chunks, faces_of): (Range<usize>, &(impl Fn(usize) -> Range<usize> + Sync)),
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

impl Scratch {
    /// Notes for each tile which of the first chunks reach it; the bands that any does.
    fn note_visitors(&mut self, chunk_count: usize, grid: &Grid) -> Option<(usize, usize)> {
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

    /// Counts the tiles' lists in `bytes` with those of others, which together have room for `most`.
    pub fn share_lists(&mut self, bytes: &ListBytes, most: usize) {
        (self.bytes, self.list_bytes, self.is_shared) = (bytes.clone(), most, true);
    }

    /// Bytes that all tiles' lists have room for.
    pub fn lists_held(&self) -> usize {
        self.bytes.get()
    }

    /// Gives the memory of all tiles' lists back.
    pub fn give_lists_back(&mut self) {
        self.chunks = Vec::new();
        self.bytes.clear();
    }
}

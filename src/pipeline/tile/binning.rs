//! From faces to the lists of the tiles that they reach: clusters, vertices, set-up, in pieces of a size of their own.

use super::bins::{self, Bin, Chunk, Grid};
use super::clusters::{CLUSTER_FACES, ClusterKernel, Outlook};
use super::deep::DeepVertexKernel;
use super::prepared::chunk_faces;
use super::setup::SetupKernel;
use super::vertex::{Projector, VertexKernel, WIDTH};
use super::{Deep, Job, Scratch, View, Workers};
use crate::pipeline::call::DrawStats;
use crate::simd::Level;
use crate::simd::allocator::resize_in_huge_pages;
use std::sync::atomic::AtomicU8;

/// Vertices that one piece of vertex work takes.
const CHUNK_VERTICES: usize = 4096;
/// Clusters that are decided on in one piece.
const CHUNK_CLUSTERS: usize = 2048;

/// Bytes of the empty lists of all tiles of a frame of this size.
pub(crate) fn grid_bytes((width, height): (usize, usize)) -> usize {
    let grid = Grid::new(&View { x0: 0, y0: 0, x1: width as i32, y1: height as i32 }, width);
    grid.columns * grid.rows * size_of::<Bin>()
}

/// About how many bytes the tiles' lists take for a mesh of `faces` faces of which `kept` are drawn, most of them small, in a
/// frame of this size.
pub(crate) fn bin_bytes(faces: u64, kept: u64, size: (usize, usize)) -> u64 {
    let chunks = faces.div_ceil(chunk_faces(faces as usize) as u64);
    // Lists grow by doubling: on the average they are three quarters full. Fragments take less.
    let face = size_of::<bins::TinyWords>() as u64 * 4 / 3;
    chunks * grid_bytes(size) as u64 + kept * face
}

/// Where the faces of a draw wait for their tiles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Binned {
    /// The bands of tiles that something reaches: the first and the last.
    pub bands: (usize, usize),
    pub(super) grid: Grid,
    pub(super) chunk_faces: usize,
    pub(super) chunk_count: usize,
}

/// Brings the faces of `job` to their tiles, in `scratch`; `None` where none reaches one. What was left out is added to `stats`.
pub(crate) fn bin(
    level: Level,
    crew: &Workers,
    scratch: &mut Scratch,
    job: &Job<'_>,
    width: usize,
    stats: &mut DrawStats,
) -> Option<Binned> {
    let mesh = job.mesh;
    let (faces, view) = (mesh.triangle_count, job.view);
    if faces == 0 {
        return None;
    }
    let to_view = job.to_screen.to_view();
    // Clusters: those of which nothing can be seen are left out, with the vertices that no other asks for.
    let clusters = &mesh.clusters;
    scratch.fates.resize(clusters.len(), 0);
    scratch.marks.clear();
    if clusters.knows_blocks() {
        scratch.marks.resize_with(mesh.vertex_count().div_ceil(WIDTH), AtomicU8::default);
    }
    let marks = scratch.marks.as_slice();
    if !clusters.is_empty() {
        let outlook = &Outlook::new(&job.to_screen, &to_view, mesh.farthest, job.complement, &view, job.keep);
        crew.chunks(&mut scratch.fates, CHUNK_CLUSTERS, |i, fates| {
            let first = i * CHUNK_CLUSTERS;
            level.dispatch(ClusterKernel { clusters, first, outlook, fates, marks });
        });
    }
    let fates = scratch.fates.as_slice();

    let grid = Grid::new(&view, width);
    let chunk_faces = chunk_faces(faces);
    let chunk_count = faces.div_ceil(chunk_faces);
    if scratch.chunks.len() < chunk_count {
        scratch.chunks.resize_with(chunk_count, Chunk::default);
    }
    let vertex_count = mesh.vertex_count();
    resize_in_huge_pages(&mut scratch.records, vertex_count, [0.0; 4]);
    if job.deep.is_some() {
        resize_in_huge_pages(&mut scratch.deep, vertex_count, [0.0; 4]);
    }
    let projector = &Projector::new(job.to_screen, &to_view, mesh.farthest);
    // In rounds: vertices, then the faces that ask for them while they are still near. Threads that meet after each stage
    // take all chunks in one round.
    let round = match crew.pool() {
        None => 1,
        Some(_) => chunk_count,
    };
    let mut placed = 0;
    for first_chunk in (0..chunk_count).step_by(round) {
        let last_chunk = (first_chunk + round).min(chunk_count) - 1;
        // Vertices: each to a record.
        let until = (mesh.asked[last_chunk] as usize).next_multiple_of(WIDTH).min(vertex_count).max(placed);
        let range_of = |i: usize, length: usize| {
            let start = placed + i * CHUNK_VERTICES;
            let marks = if marks.is_empty() {
                marks
            } else {
                &marks[start / WIDTH..(start + length).div_ceil(WIDTH)]
            };
            ([0, 1, 2].map(|axis| &mesh.positions[axis][start..start + length]), marks)
        };
        crew.chunks(&mut scratch.records[placed..until], CHUNK_VERTICES, |i, records| {
            let (positions, marks) = range_of(i, records.len());
            level.dispatch(VertexKernel { positions, projector, marks, records });
        });
        if let Some(Deep { row, .. }) = job.deep {
            crew.chunks(&mut scratch.deep[placed..until], CHUNK_VERTICES, |i, out| {
                let (positions, marks) = range_of(i, out.len());
                level.dispatch(DeepVertexKernel { positions, to_screen: &job.to_screen, row, marks, out });
            });
        }
        placed = until;
        // Faces: culled, bounded, covered if they are tiny, binned into tiles.
        let records = scratch.records.as_slice();
        crew.chunks(&mut scratch.chunks[first_chunk..=last_chunk], 1, |i, chunk| {
            let start = (first_chunk + i) * chunk_faces;
            let range = start..(start + chunk_faces).min(faces);
            let padded = range.start..range.end.next_multiple_of(16);
            chunk[0].reset(grid.columns * grid.rows);
            level.dispatch(SetupKernel {
                records,
                corners: [0, 1, 2].map(|k| &mesh.corners[k][padded.clone()]),
                faces: range.len(),
                fates: fates
                    .get(range.start / CLUSTER_FACES..range.end.div_ceil(CLUSTER_FACES))
                    .unwrap_or(&[]),
                first_face: range.start as u32,
                keep: job.keep,
                view,
                grid,
                plain: job.plain,
                chunk: &mut chunk[0],
            });
        });
    }
    if crew.is_cancelled() {
        // Lists may be those of another draw.
        return None;
    }
    let chunks = &scratch.chunks[..chunk_count];
    chunks.iter().for_each(|chunk| *stats += chunk.stats);
    // The tiles that something reaches, and the bands.
    scratch.visitors.clear();
    scratch.visitors.resize(if chunk_count > 1 { grid.columns * grid.rows } else { 0 }, 0);
    let (mut first, mut last) = (usize::MAX, 0);
    for (i, chunk) in chunks.iter().enumerate() {
        for &tile in &chunk.reached {
            if let Some(visitors) = scratch.visitors.get_mut(tile as usize) {
                *visitors |= 1 << i;
            }
            let band = tile as usize / grid.columns;
            (first, last) = (first.min(band), last.max(band));
        }
    }
    (first <= last).then_some(Binned { bands: (first, last), grid, chunk_faces, chunk_count })
}

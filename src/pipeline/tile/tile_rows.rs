//! Drawing of rows of tiles: their distribution over threads, their slices of the frame's buffers,
//! and the tiles in order.
//!
//! A row of tiles is as high as one tile. The range of rows is split by halves, so that an idle
//! thread steals half of another one's remaining rows. One thread draws a row, its tiles from left
//! to right, each with visibility first and then colour.

use super::bins::Grid;
use super::depth_f64::DepthRasterKernel;
use super::face_tables::Faces;
use super::hierarchical_z::HierarchicalZKernel;
use super::raster::{ID_STRIDE, Ids, NO_FACE, RasterKernel, Tile};
use super::resolve::ResolveKernel;
use super::{Binned, ClipRect, DepthF64, DrawJob, FrameSlices, Scratch};
use crate::executor::Executor;
use crate::memory::DepthCells;
use crate::pipeline::draw_call::CoarseDepth;
use crate::pipeline::preemption::Slice;
use crate::simd::Level;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

/// Size in bytes of the nearer caches: meshes beyond it are prefetched before they are gathered.
const NEAR_BYTES: usize = 4 << 20;
/// Largest number of reached tiles for which a draw reads its list of reached tiles instead of
/// scanning all tiles.
const FEW_TILES: usize = 24;
/// Pixel rows of a row of tiles, the unit of work of a thread.
const BAND_ROWS: usize = Grid::TILE_ROWS as usize;

/// Counts of fragments tested and passed, of pixels shaded and of hidden faces.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    /// Fragments tested.
    pub(super) tested: AtomicU64,
    /// Fragments passed.
    pub(super) passed: AtomicU64,
    /// Pixels shaded.
    pub(super) shaded: AtomicU64,
    /// Faces skipped by hierarchical z, once for each tile.
    pub(super) hidden: AtomicU64,
}

impl Counts {
    /// Returns the fragments tested and passed.
    pub fn fragments(&self) -> (u64, u64) {
        (self.tested.load(Relaxed), self.passed.load(Relaxed))
    }

    /// Returns the faces skipped by hierarchical z, counted once for each tile.
    pub fn hidden(&self) -> u64 {
        self.hidden.load(Relaxed)
    }
}

/// Progress of a row of tiles: the next tile and the next of its chunks, or that the row is
/// complete. By default the row has not begun.
#[derive(Debug, Default)]
pub(crate) struct RowProgress(AtomicU32);

impl RowProgress {
    /// Value of a complete row.
    const COMPLETE: u32 = u32::MAX;
    /// Bits of the number of a chunk: a tile's visitors are the bits of a u64.
    const CHUNK_BITS: u32 = u64::BITS.ilog2();

    /// Returns whether the row is complete.
    pub fn is_complete(&self) -> bool {
        self.0.load(Relaxed) == Self::COMPLETE
    }

    /// Notes that the row is complete.
    fn complete(&self) {
        self.0.store(Self::COMPLETE, Relaxed);
    }

    /// Notes that the row goes on with this chunk of its tile number `step`.
    fn stop_at(&self, step: usize, chunk: u32) {
        self.0.store((step as u32) << Self::CHUNK_BITS | chunk, Relaxed);
    }

    /// Returns the next tile's number and the next of its chunks.
    fn next(&self) -> (usize, u32) {
        let next = self.0.load(Relaxed);
        ((next >> Self::CHUNK_BITS) as usize, next & (u64::BITS - 1))
    }
}

/// Draws one row of tiles. Arguments: its index, the word of a cleared depth, its buffers.
type TileRowWork<'w> = &'w (dyn Fn(usize, i32, &mut TileRowBuffers<'_>) + Sync);

/// Calls `work` for each row of tiles from the first to the last, and returns the half-open range
/// of pixel rows.
pub(crate) fn for_each_tile_row(
    executor: &Executor,
    (first, last): (usize, usize),
    view: &ClipRect,
    frame: FrameSlices<'_>,
    work: TileRowWork<'_>,
) -> (u32, u32) {
    let width = frame.width;
    let depth =
        frame.depth.unwrap_or(DepthCells { words: &mut [], narrow: &mut [], pending_clear: &mut [], far: 0 });
    let far = depth.far;
    let top = view.y0 as usize + first * BAND_ROWS;
    let bottom = (view.y0 as usize + (last + 1) * BAND_ROWS).min(view.y1 as usize);
    let pixels = top * width..bottom * width;
    let some = |length: usize| if length == 0 { 0..0 } else { pixels.clone() };
    let rows = if depth.pending_clear.is_empty() { 0..0 } else { top..bottom };
    let (depth_range, pick_range) = (some(depth.words.len()), some(frame.pick.len()));
    let narrow_range = some(depth.narrow.len());
    let workspace = TileRowBuffers {
        depth: &mut depth.words[depth_range],
        narrow: &mut depth.narrow[narrow_range],
        pending_clear: &mut depth.pending_clear[rows],
        bytes: &mut frame.bytes[pixels.start * 4..pixels.end * 4],
        pick: &mut frame.pick[pick_range],
        ids: None,
    };
    let work = |band: usize, workspace: TileRowBuffers<'_>| {
        let mut ids = AtLine([NO_FACE; _]);
        let mut workspace = TileRowBuffers { ids: Some(&mut ids), ..workspace };
        work(band, far, &mut workspace);
    };
    share(executor, first..last + 1, workspace, BAND_ROWS * width, &work);
    (top as u32, bottom as u32)
}

/// Draws the binned faces of one row of tiles, from where `progress` stands to the end of the row or
/// of the slice: visibility, then colour. A tile that the slice's end divides is coloured twice, like
/// a tile whose faces are binned in two pieces: the bytes are the same.
pub(crate) fn draw_tile_row(
    level: Level,
    (scratch, binned): (&Scratch, &Binned),
    job: &DrawJob<'_>,
    (width, far): (usize, i32),
    band: usize,
    workspace: &mut TileRowBuffers<'_>,
    (counts, progress, slice): (&Counts, &RowProgress, &Slice),
) {
    if progress.is_complete() {
        return;
    }
    let (mesh, grid) = (job.mesh, binned.grid);
    let (screen_vertices, vertices) = (scratch.screen_vertices.as_slice(), scratch.depth_f64.as_slice());
    let chunks = &scratch.chunks[..binned.chunk_count];
    let depth_f64 = job.depth_f64.filter(|_| !(workspace.depth.is_empty() && workspace.narrow.is_empty()));
    let exact_face_of = |face: u32| {
        let list = &chunks[(face as usize - binned.first_face) / binned.chunk_faces].exact_faces;
        list.binary_search_by_key(&face, |w| w.face).ok().map(|i| &list[i])
    };
    let is_far_flung = mesh.vertex_count() * 32 + mesh.triangle_count * 16 > NEAR_BYTES;
    let faces = Faces {
        shading: &job.shading,
        corners: &mesh.screen_vertices,
        screen_vertices,
        is_far_flung,
        exact_face: &exact_face_of,
    };
    let y0 = job.view.y0 + (band * BAND_ROWS) as i32;
    let y1 = y0 + (workspace.bytes.len() / 4 / width) as i32;
    let Some(AtLine(ids)) = workspace.ids.as_deref_mut() else { return };
    // Words of 16 bits are widened to 32 while a tile is drawn.
    let is_narrow = !workspace.narrow.is_empty();
    let mut widened = if is_narrow { Some(AtLine([0; _])) } else { None };
    let (mut own_tested, mut own_passed, mut own_shaded, mut own_hidden) = (0, 0, 0, 0);
    // A few reached tiles are read from their list: scanning all tiles would cost a small draw more
    // than its pixels.
    let few = match chunks {
        [one] if one.reached.len() <= FEW_TILES => Some(one.reached.as_slice()),
        _ => None,
    };
    let ((first, first_chunk), mut is_over) = (progress.next(), false);
    for i in first..few.map_or(grid.columns, <[u32]>::len) {
        if is_over {
            break;
        }
        let bin = few.map_or(band * grid.columns + i, |few| few[i] as usize);
        if bin / grid.columns != band {
            continue;
        }
        let column = bin % grid.columns;
        let columns = grid.pixels_of(column);
        let (x0, x1) = (columns.start, columns.end);
        let mut visits = match scratch.visitors.get(bin) {
            Some(visitors) => *visitors,
            None => u64::from(!chunks[0].bins[bin].is_empty()),
        };
        if i == first {
            visits &= u64::MAX << first_chunk;
        }
        if visits == 0 {
            continue;
        }
        // Pending clears of the depth are done here, while the cells enter the cache.
        for (row, pending_clear) in
            workspace.pending_clear.iter_mut().enumerate().filter(|(_, s)| **s >> column & 1 == 1)
        {
            let start = row * width;
            workspace.depth[start + x0 as usize..start + x1 as usize].fill(far);
            *pending_clear &= !(1 << column);
        }
        if let Some(words) = &mut widened {
            widen(&*workspace.narrow, width, columns.clone(), &mut words.0);
        }
        let (own_depth, words): (&mut [i32], &mut [i32]) = match (depth_f64, &mut widened) {
            (None, _) => (&mut *workspace.depth, &mut []),
            (Some(_), None) => (&mut [], &mut *workspace.depth),
            (Some(_), Some(widened)) => (&mut [], &mut widened.0),
        };
        let (stride, first_column) = if is_narrow { (ID_STRIDE, x0) } else { (width, 0) };
        let mut tile = Tile { x0, x1, y0, y1, width, depth: own_depth, ids: &mut *ids };
        let mut reach = [i16::MAX, i16::MAX, 0, 0];
        let mut tile_passed = 0;
        while visits != 0 {
            is_over = slice.is_over();
            if is_over {
                progress.stop_at(i, visits.trailing_zeros());
                break;
            }
            let chunk = &chunks[visits.trailing_zeros() as usize];
            visits &= visits - 1;
            let r = chunk.bins[bin].reach;
            reach = [reach[0].min(r[0]), reach[1].min(r[1]), reach[2].max(r[2]), reach[3].max(r[3])];
            let (exact_faces, bin) = (&chunk.exact_faces, &chunk.bins[bin]);
            let corners = &mesh.screen_vertices;
            let done = match depth_f64 {
                None => {
                    let tile = &mut tile;
                    let is_coarse = job.coarse == CoarseDepth::On && !tile.depth.is_empty();
                    let kernel = RasterKernel { bin, exact_faces, corners, tile };
                    match is_coarse && HierarchicalZKernel::pays(bin) {
                        false => level.dispatch(kernel),
                        true => level.dispatch(HierarchicalZKernel(kernel)),
                    }
                }
                Some(DepthF64 { encoder, .. }) => {
                    let (words, tile) = (&mut *words, &mut tile);
                    level.dispatch(DepthRasterKernel {
                        bin,
                        exact_faces,
                        corners,
                        vertices,
                        encoder,
                        tile,
                        words,
                        stride,
                        first_column,
                    })
                }
            };
            own_tested += done.tested;
            own_hidden += done.hidden;
            tile_passed += done.passed;
        }
        if tile_passed == 0 {
            continue;
        }
        own_passed += tile_passed;
        if let Some(words) = &widened {
            narrow(&words.0, width, columns.clone(), &mut *workspace.narrow);
        }
        let [left, top, right, bottom] = reach.map(i32::from);
        own_shaded += level.dispatch(ResolveKernel {
            faces,
            reach: ClipRect { x0: left.max(x0), y0: top.max(y0), x1: right.min(x1), y1: bottom.min(y1) },
            tile: &mut tile,
            bytes: &mut *workspace.bytes,
            pick: &mut *workspace.pick,
            name: job.name,
        });
    }
    if !is_over {
        progress.complete();
    }
    counts.tested.fetch_add(own_tested, Relaxed);
    counts.passed.fetch_add(own_passed, Relaxed);
    counts.shaded.fetch_add(own_shaded, Relaxed);
    counts.hidden.fetch_add(own_hidden, Relaxed);
}

/// Face ids of a tile, aligned to a cache line: a vector that straddles two lines costs twice.
#[repr(align(64))]
struct AtLine(Ids);

/// Copies 16-bit words of the given columns, row by row, to a tile's buffer.
fn widen(from: &[u16], width: usize, columns: Range<i32>, to: &mut Ids) {
    let columns = columns.start as usize..columns.end as usize;
    for (from, to) in from.chunks_exact(width).zip(to.chunks_exact_mut(ID_STRIDE)) {
        to.iter_mut().zip(&from[columns.clone()]).for_each(|(to, from)| *to = i32::from(*from));
    }
}

/// Inverse of [`widen`].
fn narrow(from: &Ids, width: usize, columns: Range<i32>, to: &mut [u16]) {
    let columns = columns.start as usize..columns.end as usize;
    for (to, from) in to.chunks_exact_mut(width).zip(from.chunks_exact(ID_STRIDE)) {
        to[columns.clone()].iter_mut().zip(from).for_each(|(to, from)| *to = *from as u16);
    }
}

/// Slices of the frame's buffers for a range of rows of tiles; all but `bytes` may be empty.
pub(crate) struct TileRowBuffers<'a> {
    /// Depth words of 32 bits.
    depth: &'a mut [i32],
    /// Depth words of 16 bits.
    narrow: &'a mut [u16],
    /// One word for each pixel row: bit i is set while column i of tiles awaits its clear.
    pending_clear: &'a mut [u128],
    /// RGBA bytes.
    bytes: &'a mut [u8],
    /// Pick buffer: name and triangle.
    pick: &'a mut [[u32; 2]],
    /// Face ids of a tile; set for a single row of tiles.
    ids: Option<&'a mut AtLine>,
}

/// Splits the buffers of `bands` by halves and calls `work` for each row of tiles, of `size`
/// pixels.
fn share(
    executor: &Executor,
    bands: Range<usize>,
    workspace: TileRowBuffers<'_>,
    size: usize,
    work: &(impl Fn(usize, TileRowBuffers<'_>) + Sync),
) {
    if bands.len() <= 1 {
        if !executor.is_cancelled() {
            work(bands.start, workspace);
        }
        return;
    }
    let half = bands.len() / 2;
    let middle = half * size;
    let split = |length: usize| if length == 0 { 0 } else { middle };
    let (at_depth, at_pick) = (split(workspace.depth.len()), split(workspace.pick.len()));
    let (depth, depth_below) = workspace.depth.split_at_mut(at_depth);
    let at_narrow = split(workspace.narrow.len());
    let (narrow, narrow_below) = workspace.narrow.split_at_mut(at_narrow);
    let at_stale = if workspace.pending_clear.is_empty() { 0 } else { half * BAND_ROWS };
    let (pending_clear, stale_below) = workspace.pending_clear.split_at_mut(at_stale);
    let (pick, pick_below) = workspace.pick.split_at_mut(at_pick);
    let (bytes, bytes_below) = workspace.bytes.split_at_mut(middle * 4);
    let above = TileRowBuffers { depth, narrow, pending_clear, bytes, pick, ids: None };
    let below = TileRowBuffers {
        depth: depth_below,
        narrow: narrow_below,
        pending_clear: stale_below,
        bytes: bytes_below,
        pick: pick_below,
        ids: None,
    };
    let (upper, lower) = (bands.start..bands.start + half, bands.start + half..bands.end);
    match executor.pool() {
        None => {
            share(executor, upper, above, size, work);
            share(executor, lower, below, size, work);
        }
        Some(_) => {
            rayon::join(
                || share(executor, upper, above, size, work),
                || share(executor, lower, below, size, work),
            );
        }
    }
}

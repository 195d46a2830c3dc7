//! Drawing of rows of tiles: their distribution over threads, their slices of the frame's buffers,
//! and the tiles in order.
//!
//! A row of tiles is as high as one tile. The range of rows is split by halves, so that an idle
//! thread steals half of another one's remaining rows. One thread draws a row, its tiles from left
//! to right, each with visibility first and then colour.

use super::binning::Binned;
use super::bins::Chunk;
use super::close_depths::{CloseDepths, error_of_spread};
use super::depth_f64::F64Depth;
use super::depth_test::F32Depth;
use super::draw_job::{DepthF64, DrawJob, FrameSlices};
use super::face_tables::{ExactFaceLookup, Faces};
use super::grid::Grid;
use super::hierarchical_z::HierarchicalZKernel;
use super::kept_ids::remove_earlier;
use super::light_grid;
use super::pixel_resolve::PixelResolve;
use super::resolve::ResolveKernel;
use super::scratch::Scratch;
use super::shading_state::Shading;
use super::tile_buffers::{ID_STRIDE, Ids, NO_DEPTHS, NO_FACE, Tile};
use super::tile_lights::lights_of_tile;
use super::traverse::{RasterKernel, RasterStats};
use crate::executor::{Executor, join};
use crate::math::coverage::PixelRect;
use crate::memory::{DepthCells, PickCells};
use crate::pipeline::draw_call::{CoarseDepth, DrawStats};
use crate::pipeline::preemption::Slice;
use crate::simd::Level;
use std::cell::Cell;
use std::ops::Range;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering::Relaxed};

/// Size in bytes of the nearer caches: meshes beyond it are prefetched before they are gathered.
const NEAR_BYTES: usize = 4 << 20;
/// Largest number of reached tiles for which a draw reads its list of reached tiles instead of
/// scanning all tiles.
const FEW_TILES: usize = 24;
/// Pixel rows of a row of tiles, the unit of work of a thread.
const BAND_ROWS: usize = Grid::TILE_ROWS as usize;

/// Counts of fragments tested and passed, and of hidden faces.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    /// Fragments tested.
    pub(super) tested: AtomicU64,
    /// Fragments passed.
    pub(super) passed: AtomicU64,
    /// Faces skipped by hierarchical z, once for each tile.
    pub(super) hidden: AtomicU64,
}

impl Counts {
    /// Adds the counts to those of setting faces up.
    pub fn add_to(&self, stats: &mut DrawStats) {
        stats.pixels_tested += self.tested.load(Relaxed);
        stats.pixels_written += self.passed.load(Relaxed);
        stats.faces_hidden += self.hidden.load(Relaxed);
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

    /// Lets the row begin again, with another draw.
    pub fn restart(&self) {
        self.0.store(0, Relaxed);
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

/// Draws one row of tiles. Arguments: its index, its buffers, the face ids of a tile.
type TileRowWork<'w> = &'w (dyn Fn(usize, &mut TileRowBuffers<'_>, &mut Ids) + Sync);

/// Calls `work` for each row of tiles from the first to the last, and returns the half-open range
/// of pixel rows.
pub(crate) fn for_each_tile_row(
    executor: &Executor,
    (first, last): (usize, usize),
    view: &PixelRect,
    frame: FrameSlices<'_>,
    work: TileRowWork<'_>,
) -> (u32, u32) {
    let width = frame.width;
    let depth =
        frame.depth.unwrap_or(DepthCells { words: &mut [], narrow: &mut [], pending_clear: &mut [], far: 0 });
    let top = view.y0 as usize + first * BAND_ROWS;
    let bottom = (view.y0 as usize + (last + 1) * BAND_ROWS).min(view.y1 as usize);
    let pixels = top * width..bottom * width;
    let some = |length: usize| if length == 0 { 0..0 } else { pixels.clone() };
    let rows = if depth.pending_clear.is_empty() { 0..0 } else { top..bottom };
    let depth_range = some(depth.words.len());
    let narrow_range = some(depth.narrow.len());
    let buffers = TileRowBuffers {
        width,
        far: depth.far,
        depth: &mut depth.words[depth_range],
        narrow: &mut depth.narrow[narrow_range],
        pending_clear: &mut depth.pending_clear[rows],
        bytes: &mut frame.bytes[pixels.start * 4..pixels.end * 4],
        pick: frame.pick.split(bottom, width).0.split(top, width).1,
    };
    let work = |band: usize, mut buffers: TileRowBuffers<'_>| {
        let mut ids = IDS.take().unwrap_or_else(|| Box::new(AtLine([NO_FACE; _])));
        work(band, &mut buffers, &mut ids.0);
        IDS.set(Some(ids));
    };
    executor.region(|| share(executor, first..last + 1, buffers, &work));
    (top as u32, bottom as u32)
}

/// A draw whose faces are binned, as its rows of tiles are drawn.
#[derive(Clone, Copy)]
pub(crate) struct BinnedDraw<'a> {
    /// Vector width of the kernels.
    pub level: Level,
    /// Screen vertices and bins.
    pub scratch: &'a Scratch,
    /// Range and grid of the binned faces.
    pub binned: &'a Binned,
    /// The draw.
    pub job: &'a DrawJob<'a>,
    /// Counts that every row adds to.
    pub counts: &'a Counts,
    /// Slice in which the rows are drawn.
    pub slice: &'a Slice<'a>,
}

impl BinnedDraw<'_> {
    /// Draws the binned faces of one row of tiles, from where `progress` stands to the end of the row
    /// or of the slice: visibility, then colour. A tile that the slice's end divides is coloured
    /// twice, like a tile whose faces are binned in two pieces: the bytes are the same.
    pub fn draw_tile_row(
        &self,
        band: usize,
        progress: &RowProgress,
        buffers: &mut TileRowBuffers<'_>,
        ids: &mut Ids,
    ) {
        if progress.is_complete() {
            return;
        }
        let BinnedDraw { scratch, binned, job, counts, .. } = *self;
        let grid = binned.grid;
        let chunks = &scratch.chunks[..binned.chunk_count];
        let exact_face_of = |face: u32| {
            let list = &chunks[(face as usize - binned.first_face) / binned.chunk_faces].exact_faces;
            list.binary_search_by_key(&face, |w| w.face).ok().map(|i| &list[i])
        };
        let row = TileRow {
            draw: self,
            chunks,
            faces: self.faces(&exact_face_of),
            has_depth: !(buffers.depth.is_empty() && buffers.narrow.is_empty()),
            y0: job.view.y0 + (band * BAND_ROWS) as i32,
            close: CloseDepths::new(
                job.reference_faces,
                &job.mesh.screen_vertices,
                scratch.screen_vertices.as_slice(),
            ),
        };
        // Words of 16 bits are widened to 32 while a tile is drawn.
        let mut widened = if buffers.narrow.is_empty() { None } else { Some(AtLine([0; _])) };
        let mut stats = RasterStats::default();
        // A few reached tiles are read from their list: scanning all tiles would cost a small draw
        // more than its pixels.
        let few = match chunks {
            [one] if one.reached.len() <= FEW_TILES => Some(one.reached.as_slice()),
            _ => None,
        };
        let (first, first_chunk) = progress.next();
        let mut is_over = false;
        for i in first..few.map_or(grid.columns, <[u32]>::len) {
            let bin = few.map_or(band * grid.columns + i, |few| few[i] as usize);
            if bin / grid.columns != band {
                continue;
            }
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
            let widened = widened.as_mut().map(|words| &mut words.0);
            let left = row.draw_tile(bin, visits, buffers, ids, widened, &mut stats);
            if left != 0 {
                progress.stop_at(i, left.trailing_zeros());
                is_over = true;
                break;
            }
        }
        if !is_over {
            progress.complete();
        }
        counts.tested.fetch_add(stats.tested, Relaxed);
        counts.passed.fetch_add(stats.passed, Relaxed);
        counts.hidden.fetch_add(stats.hidden, Relaxed);
    }

    /// Returns the faces that pixels are shaded from.
    fn faces<'f>(&'f self, exact_face: &'f ExactFaceLookup<'f>) -> Faces<'f> {
        let mesh = self.job.mesh;
        Faces {
            shading: &self.job.shading,
            corners: &mesh.screen_vertices,
            screen_vertices: self.scratch.screen_vertices.as_slice(),
            is_far_flung: mesh.vertex_count() * 32 + mesh.triangle_count * 16 > NEAR_BYTES,
            exact_face,
        }
    }
}

/// A row of tiles while it is drawn.
struct TileRow<'r> {
    draw: &'r BinnedDraw<'r>,
    chunks: &'r [Chunk],
    faces: Faces<'r>,
    /// True if depth is tested.
    has_depth: bool,
    /// First pixel row.
    y0: i32,
    /// Decisions between close faces.
    close: CloseDepths<'r>,
}

impl TileRow<'_> {
    /// Draws one tile: its bins in the chunks whose bits are set in `visits`. `widened` is room for
    /// the tile's words of 16 bits, if depth has them. Returns the chunks that are left over when the
    /// slice ends.
    fn draw_tile(
        &self,
        bin: usize,
        visits: u64,
        buffers: &mut TileRowBuffers<'_>,
        ids: &mut Ids,
        widened: Option<&mut Ids>,
        stats: &mut RasterStats,
    ) -> u64 {
        let (grid, width) = (self.draw.binned.grid, buffers.width);
        let column = bin % grid.columns;
        let columns = grid.pixels_of(column);
        let (x0, x1) = (columns.start, columns.end);
        let (y0, y1) = (self.y0, self.y0 + (buffers.bytes.len() / 4 / width) as i32);
        let far = buffers.far;
        match buffers.narrow.is_empty() {
            true => clear_pending(buffers.pending_clear, column, &columns, (buffers.depth, width), far),
            false => {
                clear_pending(buffers.pending_clear, column, &columns, (buffers.narrow, width), far as u16)
            }
        }
        let is_widened = widened.is_some();
        let (depth, depth_stride) = match widened {
            Some(words) => {
                widen(&*buffers.narrow, width, columns.clone(), words);
                (&mut words[..], ID_STRIDE)
            }
            None => (buffers.depth.get_mut(x0 as usize..).unwrap_or_default(), width),
        };
        let tolerance = 2.0 * error_of_spread(self.draw.binned.spread);
        let depths = Some(NO_DEPTHS);
        let mut tile = Tile { x0, x1, y0, y1, width, depth, depth_stride, ids, tolerance, depths };
        let mut reach = [i16::MAX, i16::MAX, 0, 0];
        let (mut visits, mut passed) = (visits, 0);
        let BinnedDraw { scratch, binned, job, .. } = *self.draw;
        let band = bin / grid.columns;
        let first = binned.first_face + visits.trailing_zeros() as usize * binned.chunk_faces;
        let is_resumed = first > 0 && scratch.kept_ids.restore(band, &mut tile);
        while visits != 0 && !self.draw.slice.is_over() {
            let chunk = &self.chunks[visits.trailing_zeros() as usize];
            visits &= visits - 1;
            let r = chunk.bins[bin].reach;
            reach = [reach[0].min(r[0]), reach[1].min(r[1]), reach[2].max(r[2]), reach[3].max(r[3])];
            let done = self.rasterize(chunk, bin, &mut tile);
            stats.tested += done.tested;
            stats.hidden += done.hidden;
            passed += done.passed;
        }
        if passed > 0 && (visits != 0 || binned.until < job.mesh.triangle_count) {
            scratch.kept_ids.keep(band, &tile);
        }
        if is_resumed {
            remove_earlier(&mut tile, first);
        }
        if passed == 0 {
            return visits;
        }
        stats.passed += passed;
        if is_widened {
            narrow(tile.depth, width, columns.clone(), &mut *buffers.narrow);
        }
        let [left, top, right, bottom] = reach.map(i32::from);
        let reach = PixelRect { x0: left.max(x0), y0: top.max(y0), x1: right.min(x1), y1: bottom.min(y1) };
        self.resolve(&mut tile, reach, &mut *buffers.bytes, buffers.pick.reborrow());
        visits
    }

    /// Colours the pixels of a tile within `reach` that show faces.
    fn resolve(&self, tile: &mut Tile<'_>, reach: PixelRect, bytes: &mut [u8], pick: PickCells<'_>) {
        let name = self.draw.job.name;
        match self.draw.job.shading.maps {
            None => {
                let has_grids = self.faces.may_have_grids()
                    && self.chunks.iter().any(|chunk| !chunk.exact_faces.is_empty());
                let reached = if has_grids { light_grid::reach(tile.rect()) } else { reach };
                let lights = lights_of_tile(self.faces.shading, reached);
                let of_tile =
                    lights.as_ref().map(|l| Shading { bindings: &l.bindings, ..*self.faces.shading });
                // Of this lifetime, as the lights are.
                let exact_face = |face: u32| (self.faces.exact_face)(face);
                let faces = Faces {
                    shading: of_tile.as_ref().unwrap_or(self.faces.shading),
                    exact_face: &exact_face,
                    ..self.faces
                };
                self.draw.level.dispatch_long(ResolveKernel { faces, reach, tile, bytes, pick, name });
            }
            Some(shade) => PixelResolve { shade, reach, tile, bytes, pick, name }.run(),
        }
    }

    /// Returns the parameters of depth in f64, if depth is tested in it.
    fn depth_f64(&self) -> Option<DepthF64> {
        self.draw.job.depth_f64.filter(|_| self.has_depth)
    }

    /// Draws the faces of a chunk in a tile: depth and face ids.
    fn rasterize(&self, chunk: &Chunk, bin: usize, tile: &mut Tile<'_>) -> RasterStats {
        let BinnedDraw { level, scratch, job, .. } = *self.draw;
        let (exact_faces, bin) = (&chunk.exact_faces, &chunk.bins[bin]);
        let corners = &job.mesh.screen_vertices;
        match self.depth_f64() {
            None => {
                let is_coarse = job.coarse == CoarseDepth::On && !tile.depth.is_empty();
                let test = F32Depth { close: Some(&self.close), tolerance: tile.tolerance };
                let kernel = RasterKernel { bin, exact_faces, corners, test, tile };
                match is_coarse && HierarchicalZKernel::pays(bin) {
                    false => level.dispatch(kernel),
                    true => level.dispatch(HierarchicalZKernel(kernel)),
                }
            }
            Some(DepthF64 { encoder, .. }) => {
                let test = F64Depth { encoder, corners, vertices: scratch.depth_f64.as_slice() };
                level.dispatch(RasterKernel { bin, exact_faces, corners, test, tile })
            }
        }
    }
}

/// Does the pending clears of a column of tiles in the rows of a buffer, whose cells then enter the
/// cache.
fn clear_pending<T: Copy>(
    pending_clear: &mut [u128],
    column: usize,
    columns: &Range<i32>,
    (words, width): (&mut [T], usize),
    cleared: T,
) {
    for (row, pending_clear) in pending_clear.iter_mut().enumerate().filter(|(_, s)| **s >> column & 1 == 1) {
        let start = row * width;
        words[start + columns.start as usize..start + columns.end as usize].fill(cleared);
        *pending_clear &= !(1 << column);
    }
}

/// Face ids of a tile, aligned to a cache line: a vector that straddles two lines costs twice.
#[repr(align(64))]
struct AtLine(Ids);

thread_local! {
    /// Face ids that the thread's last row of tiles has reset to [`NO_FACE`]; none after a panic.
    /// Setting all of them would cost a small draw more than its pixels.
    static IDS: Cell<Option<Box<AtLine>>> = const { Cell::new(None) };
}

/// Copies 16-bit words of the given columns, row by row, to a tile's buffer.
fn widen(from: &[u16], width: usize, columns: Range<i32>, to: &mut Ids) {
    let columns = columns.start as usize..columns.end as usize;
    for (from, to) in from.chunks_exact(width).zip(to.chunks_exact_mut(ID_STRIDE)) {
        to.iter_mut().zip(&from[columns.clone()]).for_each(|(to, from)| *to = i32::from(*from));
    }
}

/// Inverse of [`widen`]: `from` is a tile's buffer.
fn narrow(from: &[i32], width: usize, columns: Range<i32>, to: &mut [u16]) {
    let columns = columns.start as usize..columns.end as usize;
    for (to, from) in to.chunks_exact_mut(width).zip(from.chunks_exact(ID_STRIDE)) {
        to[columns.clone()].iter_mut().zip(from).for_each(|(to, from)| *to = *from as u16);
    }
}

/// Slices of the frame's buffers for a range of rows of tiles; all but `bytes` may be empty.
pub(crate) struct TileRowBuffers<'a> {
    /// Width of a row of the frame in pixels.
    width: usize,
    /// Word of a cleared depth.
    far: i32,
    /// Depth words of 32 bits.
    depth: &'a mut [i32],
    /// Depth words of 16 bits.
    narrow: &'a mut [u16],
    /// One word for each pixel row: bit i is set while column i of tiles awaits its clear.
    pending_clear: &'a mut [u128],
    /// RGBA bytes.
    bytes: &'a mut [u8],
    /// Pick buffer: name and triangle.
    pick: PickCells<'a>,
}

impl TileRowBuffers<'_> {
    /// Splits into the first rows of tiles and the others.
    fn split(self, tile_rows: usize) -> (Self, Self) {
        let (width, far, rows) = (self.width, self.far, tile_rows * BAND_ROWS);
        let pixels = rows * width;
        let (depth, depth_below) = split(self.depth, pixels);
        let (narrow, narrow_below) = split(self.narrow, pixels);
        let (pending_clear, pending_below) = split(self.pending_clear, rows);
        let (bytes, bytes_below) = split(self.bytes, pixels * 4);
        let (pick, pick_below) = self.pick.split(rows, width);
        let below = TileRowBuffers {
            width,
            far,
            depth: depth_below,
            narrow: narrow_below,
            pending_clear: pending_below,
            bytes: bytes_below,
            pick: pick_below,
        };
        (TileRowBuffers { width, far, depth, narrow, pending_clear, bytes, pick }, below)
    }
}

/// Splits a buffer; one that is empty into two empty ones.
fn split<T>(buffer: &mut [T], at: usize) -> (&mut [T], &mut [T]) {
    buffer.split_at_mut(at.min(buffer.len()))
}

/// Splits the buffers of `bands` by halves and calls `work` for each row of tiles.
fn share(
    executor: &Executor,
    bands: Range<usize>,
    buffers: TileRowBuffers<'_>,
    work: &(impl Fn(usize, TileRowBuffers<'_>) + Sync),
) {
    if bands.len() <= 1 {
        return executor.piece(|| work(bands.start, buffers));
    }
    let half = bands.len() / 2;
    let (above, below) = buffers.split(half);
    let (upper, lower) = (bands.start..bands.start + half, bands.start + half..bands.end);
    let upper = || share(executor, upper, above, work);
    let lower = || share(executor, lower, below, work);
    match executor.pool() {
        None => {
            upper();
            lower();
        }
        Some(_) => {
            join(upper, lower);
        }
    }
}

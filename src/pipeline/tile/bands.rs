//! Bands of tiles: who draws which, what of the frame's memories it gets, and the tiles one after the other.
//!
//! A band is as high as a tile. Bands are handed out by halves, so that a thread that is done takes over half of what another
//! one still has; a band is drawn by one thread, its tiles from left to right, each by visibility and then by colour.

use super::bins::Grid;
use super::coarse::CoarseRasterKernel;
use super::deep::DeepRasterKernel;
use super::faces::Faces;
use super::raster::{ID_STRIDE, Ids, NO_FACE, RasterKernel, Tile};
use super::resolve::ResolveKernel;
use super::{Binned, Deep, Frame, Job, Scratch, View, Workers};
use crate::memory::DepthCells;
use crate::pipeline::call::CoarseDepth;
use crate::simd::Level;
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// What the nearer caches hold: beyond, what will be gathered is asked for ahead.
const NEAR_BYTES: usize = 4 << 20;
/// A draw that reaches no more tiles than this is drawn tile by tile of its list.
const FEW_TILES: usize = 24;
/// Rows of a band of tiles: what one thread draws at a time.
const BAND_ROWS: usize = Grid::TILE_ROWS as usize;

/// Fragments tested and passed, and pixels shaded: each of these once.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    pub(super) tested: AtomicU64,
    pub(super) passed: AtomicU64,
    pub(super) shaded: AtomicU64,
    pub(super) hidden: AtomicU64,
}

impl Counts {
    /// Fragments tested and passed.
    pub fn fragments(&self) -> (u64, u64) {
        (self.tested.load(Relaxed), self.passed.load(Relaxed))
    }

    /// Faces left out by coarse depth, each once for every tile.
    pub fn hidden(&self) -> u64 {
        self.hidden.load(Relaxed)
    }
}

/// What draws one band: its number, the word that a cleared depth has, its memories.
type BandWork<'w> = &'w (dyn Fn(usize, i32, &mut BandMemories<'_>) + Sync);

/// Hands the bands of tiles from the first to the last to `work`, and says which rows they are.
pub(crate) fn bands(
    crew: &Workers,
    (first, last): (usize, usize),
    view: &View,
    frame: Frame<'_>,
    work: BandWork<'_>,
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
    let memories = BandMemories {
        depth: &mut depth.words[depth_range],
        narrow: &mut depth.narrow[narrow_range],
        pending_clear: &mut depth.pending_clear[rows],
        bytes: &mut frame.bytes[pixels.start * 4..pixels.end * 4],
        pick: &mut frame.pick[pick_range],
        ids: None,
    };
    let work = |band: usize, memories: BandMemories<'_>| {
        let mut ids = AtLine([NO_FACE; _]);
        let mut memories = BandMemories { ids: Some(&mut ids), ..memories };
        work(band, far, &mut memories);
    };
    share(crew, first..last + 1, memories, BAND_ROWS * width, &work);
    (top as u32, bottom as u32)
}

/// Draws the faces that wait in one band of tiles: visibility, then colour.
pub(crate) fn draw_band(
    level: Level,
    (scratch, binned): (&Scratch, &Binned),
    job: &Job<'_>,
    (width, far): (usize, i32),
    band: usize,
    memories: &mut BandMemories<'_>,
    counts: &Counts,
) {
    let (mesh, grid) = (job.mesh, binned.grid);
    let (records, vertices) = (scratch.records.as_slice(), scratch.deep.as_slice());
    let chunks = &scratch.chunks[..binned.chunk_count];
    let deep = job.deep.filter(|_| !(memories.depth.is_empty() && memories.narrow.is_empty()));
    let wide_of = |face: u32| {
        let list = &chunks[(face as usize - binned.first_face) / binned.chunk_faces].wide;
        list.binary_search_by_key(&face, |w| w.face).ok().map(|i| &list[i])
    };
    let is_far_flung = mesh.vertex_count() * 32 + mesh.triangle_count * 16 > NEAR_BYTES;
    let faces =
        Faces { shading: &job.shading, corners: &mesh.records, records, is_far_flung, wide: &wide_of };
    let y0 = job.view.y0 + (band * BAND_ROWS) as i32;
    let y1 = y0 + (memories.bytes.len() / 4 / width) as i32;
    let Some(AtLine(ids)) = memories.ids.as_deref_mut() else { return };
    // Words of 16 bits are widened while a tile is drawn.
    let is_narrow = !memories.narrow.is_empty();
    let mut widened = if is_narrow { Some(AtLine([0; _])) } else { None };
    let (mut own_tested, mut own_passed, mut own_shaded, mut own_hidden) = (0, 0, 0, 0);
    // What few tiles are reached is read from their list: to look through all of them costs a small draw more than its pixels.
    let few = match chunks {
        [one] if one.reached.len() <= FEW_TILES => Some(one.reached.as_slice()),
        _ => None,
    };
    for i in 0..few.map_or(grid.columns, <[u32]>::len) {
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
        if visits == 0 {
            continue;
        }
        // What is still to be cleared is cleared here, on its way into the cache.
        for (row, pending_clear) in
            memories.pending_clear.iter_mut().enumerate().filter(|(_, s)| **s >> column & 1 == 1)
        {
            let start = row * width;
            memories.depth[start + x0 as usize..start + x1 as usize].fill(far);
            *pending_clear &= !(1 << column);
        }
        if let Some(words) = &mut widened {
            widen(&*memories.narrow, width, columns.clone(), &mut words.0);
        }
        let (own_depth, words): (&mut [i32], &mut [i32]) = match (deep, &mut widened) {
            (None, _) => (&mut *memories.depth, &mut []),
            (Some(_), None) => (&mut [], &mut *memories.depth),
            (Some(_), Some(widened)) => (&mut [], &mut widened.0),
        };
        let (stride, first_column) = if is_narrow { (ID_STRIDE, x0) } else { (width, 0) };
        let mut tile = Tile { x0, x1, y0, y1, width, depth: own_depth, ids: &mut *ids };
        let mut reach = [i16::MAX, i16::MAX, 0, 0];
        let mut tile_passed = 0;
        while visits != 0 {
            let chunk = &chunks[visits.trailing_zeros() as usize];
            visits &= visits - 1;
            let r = chunk.bins[bin].reach;
            reach = [reach[0].min(r[0]), reach[1].min(r[1]), reach[2].max(r[2]), reach[3].max(r[3])];
            let (wide, bin) = (&chunk.wide, &chunk.bins[bin]);
            let corners = &mesh.records;
            let done = match deep {
                None => {
                    let tile = &mut tile;
                    let is_coarse = job.coarse == CoarseDepth::On && !tile.depth.is_empty();
                    let kernel = RasterKernel { bin, wide, corners, tile };
                    match is_coarse && CoarseRasterKernel::pays(bin) {
                        false => level.dispatch(kernel),
                        true => level.dispatch(CoarseRasterKernel(kernel)),
                    }
                }
                Some(Deep { form, .. }) => {
                    let (words, tile) = (&mut *words, &mut tile);
                    level.dispatch(DeepRasterKernel {
                        bin,
                        wide,
                        corners,
                        vertices,
                        form,
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
            narrow(&words.0, width, columns.clone(), &mut *memories.narrow);
        }
        let [left, top, right, bottom] = reach.map(i32::from);
        own_shaded += level.dispatch(ResolveKernel {
            faces,
            reach: View { x0: left.max(x0), y0: top.max(y0), x1: right.min(x1), y1: bottom.min(y1) },
            tile: &mut tile,
            bytes: &mut *memories.bytes,
            pick: &mut *memories.pick,
            name: job.name,
        });
    }
    counts.tested.fetch_add(own_tested, Relaxed);
    counts.passed.fetch_add(own_passed, Relaxed);
    counts.shaded.fetch_add(own_shaded, Relaxed);
    counts.hidden.fetch_add(own_hidden, Relaxed);
}

/// A tile's ids from a cache line on: a vector that straddles two costs twice.
#[repr(align(64))]
struct AtLine(Ids);

/// Words of 16 bits of these columns, row by row, to a tile's own.
fn widen(from: &[u16], width: usize, columns: Range<i32>, to: &mut Ids) {
    let columns = columns.start as usize..columns.end as usize;
    for (from, to) in from.chunks_exact(width).zip(to.chunks_exact_mut(ID_STRIDE)) {
        to.iter_mut().zip(&from[columns.clone()]).for_each(|(to, from)| *to = i32::from(*from));
    }
}

/// And back.
fn narrow(from: &Ids, width: usize, columns: Range<i32>, to: &mut [u16]) {
    let columns = columns.start as usize..columns.end as usize;
    for (to, from) in to.chunks_exact_mut(width).zip(from.chunks_exact(ID_STRIDE)) {
        to[columns.clone()].iter_mut().zip(from).for_each(|(to, from)| *to = *from as u16);
    }
}

/// The memories of some bands; all but the bytes may be empty altogether.
pub(crate) struct BandMemories<'a> {
    depth: &'a mut [i32],
    /// The same of 16 bits.
    narrow: &'a mut [u16],
    /// A word a row.
    pending_clear: &'a mut [u128],
    bytes: &'a mut [u8],
    pick: &'a mut [[u32; 2]],
    /// The faces of a tile; of one band's memories.
    ids: Option<&'a mut AtLine>,
}

/// Hands each band's memories to `work`; `size` pixels a band.
fn share(
    crew: &Workers,
    bands: Range<usize>,
    memories: BandMemories<'_>,
    size: usize,
    work: &(impl Fn(usize, BandMemories<'_>) + Sync),
) {
    if bands.len() <= 1 {
        if !crew.is_cancelled() {
            work(bands.start, memories);
        }
        return;
    }
    let half = bands.len() / 2;
    let middle = half * size;
    let split = |length: usize| if length == 0 { 0 } else { middle };
    let (at_depth, at_pick) = (split(memories.depth.len()), split(memories.pick.len()));
    let (depth, depth_below) = memories.depth.split_at_mut(at_depth);
    let at_narrow = split(memories.narrow.len());
    let (narrow, narrow_below) = memories.narrow.split_at_mut(at_narrow);
    let at_stale = if memories.pending_clear.is_empty() { 0 } else { half * BAND_ROWS };
    let (pending_clear, stale_below) = memories.pending_clear.split_at_mut(at_stale);
    let (pick, pick_below) = memories.pick.split_at_mut(at_pick);
    let (bytes, bytes_below) = memories.bytes.split_at_mut(middle * 4);
    let above = BandMemories { depth, narrow, pending_clear, bytes, pick, ids: None };
    let below = BandMemories {
        depth: depth_below,
        narrow: narrow_below,
        pending_clear: stale_below,
        bytes: bytes_below,
        pick: pick_below,
        ids: None,
    };
    let (upper, lower) = (bands.start..bands.start + half, bands.start + half..bands.end);
    match crew.pool() {
        None => {
            share(crew, upper, above, size, work);
            share(crew, lower, below, size, work);
        }
        Some(_) => {
            rayon::join(|| share(crew, upper, above, size, work), || share(crew, lower, below, size, work));
        }
    }
}

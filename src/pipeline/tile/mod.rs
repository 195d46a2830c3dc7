//! The tile renderer: what users run, several times faster than the plain path and held to it.
//!
//! Visibility first: faces are set up a vector at a time, binned into bands of rows, and each band finds out which face
//! is seen at each of its pixels (exact integer coverage, then depth, in file order); then every pixel that was won is
//! shaded once. A face that f32 records cannot hold (behind the eye, steep, huge) is set up by the plain path in f64 in the
//! middle of it, so the picture is the plain path's within its limits: the same coverage, depth within 4e-7, colour within
//! 1/255. Work is split by faces and by bands, never by chance: the same bytes with any number of threads and at every
//! vector width.
//!
//! Stages: clusters (what cannot be seen) -> vertex -> setup (cull, bound, cover, bin) -> raster (band by band) -> resolve (band by band).

mod bins;
mod clusters;
mod coarse;
mod corners;
mod crew;
mod deep;
mod faces;
mod haze;
mod light;
mod prepared;
mod raster;
mod resolve;
mod setup;
mod sheet;
mod tables;
mod texture;
mod veil;
mod vertex;
mod wide;
mod workers;

pub(crate) use bins::{Keep, View};
pub(crate) use clusters::{CLUSTER_BYTES, LEAST_FACES};
pub(crate) use coarse::COARSE_BYTES;
pub use crew::{Alone, Crew, Pool};
pub(crate) use deep::Form;
pub(crate) use faces::{Eye, Shading, Source, Surface};
pub(crate) use haze::Haze;
pub(crate) use light::{Cone, Exponent, FastLight, Lighting, Place};
pub(crate) use prepared::{FaceTable, PreparedMesh};
pub(crate) use sheet::Sheet;
pub(crate) use tables::TableKernel;
pub(crate) use texture::TextureShade;
pub(crate) use veil::{Glow, Veil, VeilKernel};
pub(crate) use vertex::{Record, ToScreen};
pub(crate) use wide::WideFace;
pub(crate) use workers::Workers;

use crate::memory::DepthCells;
use crate::pipeline::call::{CoarseDepth, DrawStats};
use crate::simd::Level;
use crate::simd::allocator::resize_in_huge_pages;
use bins::{Bin, Chunk, Grid};
use clusters::{CLUSTER_FACES, ClusterKernel, Outlook};
use coarse::CoarseRasterKernel;
use deep::{DeepRasterKernel, DeepVertex, DeepVertexKernel};
use faces::Faces;
use raster::{ID_STRIDE, Ids, NO_FACE, RasterKernel, Tile};
use resolve::ResolveKernel;
use setup::SetupKernel;
use std::ops::Range;
use std::sync::atomic::{AtomicU8, AtomicU64, Ordering::Relaxed};
use vertex::{Projector, VertexKernel, WIDTH};

/// Faces that one piece of set-up work takes.
const CHUNK_FACES: usize = 4096;
/// Vertices that one piece of vertex work takes.
const CHUNK_VERTICES: usize = 4096;
/// Clusters that are decided on in one piece.
const CHUNK_CLUSTERS: usize = 2048;
/// What the nearer caches hold: beyond, what will be gathered is asked for ahead.
const NEAR_BYTES: usize = 4 << 20;
/// The most chunks: each has a list for each tile, and a bit of its visitors.
const MOST_CHUNKS: usize = 64;
/// A draw that reaches no more tiles than this is drawn tile by tile of its list.
const FEW_TILES: usize = 24;
/// Rows of a band of tiles: what one thread draws at a time.
const BAND_ROWS: usize = Grid::TILE_ROWS as usize;

/// The records of three points of object space.
pub(crate) fn records_of(level: Level, to_screen: &ToScreen, points: [[f64; 3]; 3]) -> [Record; 3] {
    let axis = |axis: usize| points.map(|p| p[axis]);
    let (xs, ys, zs) = (axis(0), axis(1), axis(2));
    let mut records = [[0.0; 4]; 3];
    let farthest = [0, 1, 2].map(|axis| points.iter().fold(0.0f64, |far, p| far.max(p[axis].abs())));
    let projector = &Projector::new(*to_screen, &to_screen.to_view(), farthest);
    level.dispatch(VertexKernel { positions: [&xs, &ys, &zs], projector, marks: &[], records: &mut records });
    records
}

/// A frame's memories, as the tile renderer writes them.
pub(crate) struct Frame<'a> {
    /// Pixels in a row.
    pub width: usize,
    /// RGBA bytes.
    pub bytes: &'a mut [u8],
    /// Bits of f32 depths; `None` where depth is neither tested nor kept.
    pub depth: Option<DepthCells<'a>>,
    /// Name and triangle of each pixel, for PICK; empty where nobody asks.
    pub pick: &'a mut [[u32; 2]],
}

/// Memories that are kept from draw to draw, so that a steady frame allocates nothing large.
#[derive(Debug, Default)]
pub(crate) struct Scratch {
    /// What becomes of each cluster of faces.
    fates: Vec<u8>,
    /// Which blocks of vertices are asked for.
    marks: Vec<AtomicU8>,
    records: Vec<Record>,
    /// The same in f64, for the depth formats that ask for that.
    deep: Vec<DeepVertex>,
    chunks: Vec<Chunk>,
    /// For each tile the chunks that reach it, a bit each; empty where there is but one chunk.
    visitors: Vec<u64>,
}

impl Scratch {
    /// Bytes that the memories take.
    pub fn size_bytes(&self) -> usize {
        let bin = |b: &Bin| {
            size_of::<Bin>()
                + b.larger.capacity() * size_of::<bins::Larger>()
                + b.tiny.capacity() * size_of::<bins::Tiny>()
                + b.small.capacity() * size_of::<bins::Small>()
        };
        let chunk = |c: &Chunk| {
            c.wide.capacity() * size_of::<WideFace>()
                + c.reached.capacity() * 4
                + c.bins.iter().map(bin).sum::<usize>()
        };
        self.fates.capacity()
            + self.marks.capacity()
            + self.visitors.capacity() * 8
            + self.records.capacity() * 16
            + self.deep.capacity() * size_of::<DeepVertex>()
            + self.chunks.iter().map(chunk).sum::<usize>()
    }
}

/// One draw of opaque faces.
pub(crate) struct Job<'a> {
    /// The mesh.
    pub mesh: &'a PreparedMesh,
    /// Object space to the screen.
    pub to_screen: ToScreen,
    /// View space to w - z, free of cancellation.
    pub complement: [f64; 4],
    /// Which windings are drawn.
    pub keep: Keep,
    /// Which pixels may be drawn; inside the frame.
    pub view: View,
    /// How pixels get their colours.
    pub shading: Shading<'a>,
    /// The plain path's set-up, for faces that records cannot hold.
    pub plain: setup::PlainSetup<'a>,
    /// What the memory of ids keeps.
    pub name: u32,
    /// How depth is worked in f64; `None` for f32 depths, and where there are none.
    pub deep: Option<Deep>,
    /// Whether hidden faces are left out tile by tile.
    pub coarse: CoarseDepth,
}

/// What depth formats other than f32 ask for.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Deep {
    /// How words are made.
    pub form: Form,
    /// View space to what is stored, times w: z or w - z.
    pub row: [f64; 4],
}

/// The narrowest frame that a vector fits, and the widest and tallest whose pixels the records reach.
pub(crate) const FRAME_LIMITS: (usize, usize) = (16, 15_900);

/// What a draw did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct TileStats {
    /// Faces in and out, fragments tested and passed; nothing about light.
    pub draw: DrawStats,
    /// Pixels shaded: each once.
    pub shaded: u64,
    /// The rows that may have been written, first and one beyond the last.
    pub rows: (u32, u32),
}

/// Bytes of a vertex on the screen, and of one with its depth in f64.
pub(crate) const RECORD_BYTES: u64 = size_of::<Record>() as u64;
pub(crate) const DEEP_VERTEX_BYTES: u64 = size_of::<DeepVertex>() as u64;

/// Bytes of the empty lists of all tiles of a frame of this size.
pub(crate) fn grid_bytes((width, height): (usize, usize)) -> usize {
    let grid = Grid::new(&View { x0: 0, y0: 0, x1: width as i32, y1: height as i32 }, width);
    grid.columns * grid.rows * size_of::<Bin>()
}

/// About how many bytes the tiles' lists take for a mesh of `faces` faces of which `kept` are drawn, most of them small, in a
/// frame of this size.
pub(crate) fn bin_bytes(faces: u64, kept: u64, size: (usize, usize)) -> u64 {
    let chunks = faces.div_ceil(chunk_faces(faces as usize) as u64);
    // Lists grow by doubling: on the average they are three quarters full.
    let face = size_of::<bins::Tiny>() as u64 * 4 / 3;
    chunks * grid_bytes(size) as u64 + kept * face
}

/// Faces in a piece of set-up work.
fn chunk_faces(faces: usize) -> usize {
    faces.div_ceil(MOST_CHUNKS).next_multiple_of(16).max(CHUNK_FACES)
}

/// Where the faces of a draw wait for their tiles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Binned {
    /// The bands of tiles that something reaches: the first and the last.
    pub bands: (usize, usize),
    grid: Grid,
    chunk_faces: usize,
    chunk_count: usize,
}

/// Fragments tested and passed, and pixels shaded: each of these once.
#[derive(Debug, Default)]
pub(crate) struct Counts {
    tested: AtomicU64,
    passed: AtomicU64,
    shaded: AtomicU64,
    hidden: AtomicU64,
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

/// Draws `job` into `frame`.
///
/// The frame's sides must lie within [`FRAME_LIMITS`] and the view inside the frame; the faces must be fewer than 2^30. To be
/// called inside [`Workers::run`].
pub(crate) fn render(
    level: Level,
    crew: &Workers,
    scratch: &mut Scratch,
    job: &Job<'_>,
    frame: Frame<'_>,
) -> TileStats {
    let mut stats = TileStats::default();
    let Some(binned) = bin(level, crew, scratch, job, frame.width, &mut stats.draw) else { return stats };
    let counts = Counts::default();
    let (scratch, width) = (&*scratch, frame.width);
    stats.rows = bands(crew, binned.bands, &job.view, frame, &|band, far, memories| {
        draw_band(level, (scratch, &binned), job, (width, far), band, memories, &counts);
    });
    stats.draw.faces_hidden = counts.hidden();
    stats.draw.pixels_tested += counts.tested.into_inner();
    stats.draw.pixels_written = counts.passed.into_inner();
    stats.shaded = counts.shaded.into_inner();
    stats
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
        let outlook = &Outlook::new(&job.to_screen, &to_view, job.complement, &view, job.keep);
        crew.chunks(&mut scratch.fates, CHUNK_CLUSTERS, |i, fates| {
            let first = i * CHUNK_CLUSTERS;
            level.dispatch(ClusterKernel { clusters, first, outlook, fates, marks });
        });
    }
    let fates = scratch.fates.as_slice();

    // Vertices: each to a record.
    let marks_of = |range: &Range<usize>| match marks.is_empty() {
        true => marks,
        false => &marks[range.start / WIDTH..range.end.div_ceil(WIDTH)],
    };
    let projector = &Projector::new(job.to_screen, &to_view, mesh.farthest);
    resize_in_huge_pages(&mut scratch.records, mesh.vertex_count(), [0.0; 4]);
    crew.chunks(&mut scratch.records, CHUNK_VERTICES, |i, records| {
        let range = i * CHUNK_VERTICES..i * CHUNK_VERTICES + records.len();
        let positions = [0, 1, 2].map(|axis| &mesh.positions[axis][range.clone()]);
        level.dispatch(VertexKernel { positions, projector, marks: marks_of(&range), records });
    });

    if let Some(Deep { row, .. }) = job.deep {
        resize_in_huge_pages(&mut scratch.deep, mesh.vertex_count(), [0.0; 4]);
        crew.chunks(&mut scratch.deep, CHUNK_VERTICES, |i, out| {
            let range = i * CHUNK_VERTICES..i * CHUNK_VERTICES + out.len();
            let positions = [0, 1, 2].map(|axis| &mesh.positions[axis][range.clone()]);
            let marks = marks_of(&range);
            level.dispatch(DeepVertexKernel { positions, to_screen: &job.to_screen, row, marks, out });
        });
    }

    // Faces: culled, bounded, covered if they are tiny, binned into tiles.
    let grid = Grid::new(&view, width);
    let chunk_faces = chunk_faces(faces);
    let chunk_count = faces.div_ceil(chunk_faces);
    if scratch.chunks.len() < chunk_count {
        scratch.chunks.resize_with(chunk_count, Chunk::default);
    }
    let records = scratch.records.as_slice();
    crew.chunks(&mut scratch.chunks[..chunk_count], 1, |i, chunk| {
        let range = i * chunk_faces..((i + 1) * chunk_faces).min(faces);
        let padded = range.start..range.end.next_multiple_of(16);
        chunk[0].reset(grid.columns * grid.rows);
        level.dispatch(SetupKernel {
            records,
            corners: [0, 1, 2].map(|k| &mesh.corners[k][padded.clone()]),
            faces: range.len(),
            clusters,
            fates: fates.get(range.start / CLUSTER_FACES..range.end.div_ceil(CLUSTER_FACES)).unwrap_or(&[]),
            first_face: range.start as u32,
            keep: job.keep,
            view,
            grid,
            plain: job.plain,
            chunk: &mut chunk[0],
        });
    });
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
    let depth = frame.depth.unwrap_or(DepthCells { words: &mut [], narrow: &mut [], stale: &mut [], far: 0 });
    let far = depth.far;
    let top = view.y0 as usize + first * BAND_ROWS;
    let bottom = (view.y0 as usize + (last + 1) * BAND_ROWS).min(view.y1 as usize);
    let pixels = top * width..bottom * width;
    let some = |length: usize| if length == 0 { 0..0 } else { pixels.clone() };
    let rows = if depth.stale.is_empty() { 0..0 } else { top..bottom };
    let (depth_range, pick_range) = (some(depth.words.len()), some(frame.pick.len()));
    let narrow_range = some(depth.narrow.len());
    let memories = BandMemories {
        depth: &mut depth.words[depth_range],
        narrow: &mut depth.narrow[narrow_range],
        stale: &mut depth.stale[rows],
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
        let list = &chunks[face as usize / binned.chunk_faces].wide;
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
        for (row, stale) in memories.stale.iter_mut().enumerate().filter(|(_, s)| **s >> column & 1 == 1) {
            let start = row * width;
            memories.depth[start + x0 as usize..start + x1 as usize].fill(far);
            *stale &= !(1 << column);
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
            let (t, p) = match deep {
                None => {
                    let tile = &mut tile;
                    let is_coarse = job.coarse == CoarseDepth::On && !tile.depth.is_empty();
                    let kernel = RasterKernel { bin, wide, corners, tile };
                    match is_coarse && CoarseRasterKernel::pays(bin) {
                        false => level.dispatch(kernel),
                        true => {
                            let (t, p, h) = level.dispatch(CoarseRasterKernel(kernel));
                            own_hidden += h;
                            (t, p)
                        }
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
            (own_tested, tile_passed) = (own_tested + t, tile_passed + p);
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
    stale: &'a mut [u128],
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
        work(bands.start, memories);
        return;
    }
    let half = bands.len() / 2;
    let middle = half * size;
    let split = |length: usize| if length == 0 { 0 } else { middle };
    let (at_depth, at_pick) = (split(memories.depth.len()), split(memories.pick.len()));
    let (depth, depth_below) = memories.depth.split_at_mut(at_depth);
    let at_narrow = split(memories.narrow.len());
    let (narrow, narrow_below) = memories.narrow.split_at_mut(at_narrow);
    let at_stale = if memories.stale.is_empty() { 0 } else { half * BAND_ROWS };
    let (stale, stale_below) = memories.stale.split_at_mut(at_stale);
    let (pick, pick_below) = memories.pick.split_at_mut(at_pick);
    let (bytes, bytes_below) = memories.bytes.split_at_mut(middle * 4);
    let above = BandMemories { depth, narrow, stale, bytes, pick, ids: None };
    let below = BandMemories {
        depth: depth_below,
        narrow: narrow_below,
        stale: stale_below,
        bytes: bytes_below,
        pick: pick_below,
        ids: None,
    };
    let (upper, lower) = (bands.start..bands.start + half, bands.start + half..bands.end);
    match crew {
        Workers::Alone => {
            share(crew, upper, above, size, work);
            share(crew, lower, below, size, work);
        }
        Workers::Pool(_) => {
            rayon::join(|| share(crew, upper, above, size, work), || share(crew, lower, below, size, work));
        }
    }
}

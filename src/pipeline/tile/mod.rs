//! The tile renderer: what users run, several times faster than the plain path and held to it.
//!
//! Visibility first: faces are set up a vector at a time, binned into bands of rows, and each band finds out which face
//! is seen at each of its pixels (exact integer coverage, then depth, in file order); then every pixel that was won is
//! shaded once. A face that f32 records cannot hold (behind the eye, steep, sliver-thin) is drawn by the plain path's own
//! arithmetic in the middle of it, so the picture is the plain path's within its limits: the same coverage, depth within
//! 4e-7, colour within 1/255. Work is split by faces and by bands, never by chance: the same bytes with any number of
//! threads and at every vector width.
//!
//! It draws what [`Job`] can say: opaque meshes, lit per pixel or coloured, under the f32 z-buffer. `pipeline::draw` does not
//! hand its calls to it yet.
//!
//! Stages: vertex -> setup (cull, bound, bin) -> raster (band by band) -> resolve (band by band).

mod crew;
mod light;
mod prepared;
mod raster;
mod resolve;
mod setup;
mod vertex;

pub use crew::{Alone, Crew, Pool};
pub use light::{Exponent, FastLight, Lighting, Place};
pub use prepared::PreparedMesh;
pub use raster::PlainFace;
pub use resolve::{Eye, Mode, PlainPixel, Shading};
pub use setup::{Keep, View};
pub use vertex::{Record, ToScreen};

use crate::simd::Level;
use raster::{Band, NO_FACE, RasterKernel};
use resolve::{Faces, ResolveKernel};
use setup::{Chunk, SetupKernel};
use vertex::VertexKernel;

/// Faces that one piece of set-up work takes.
const CHUNK_FACES: usize = 4096;
/// Vertices that one piece of vertex work takes.
const CHUNK_VERTICES: usize = 4096;
/// Rows of a band.
const BAND_ROWS: usize = 32;
/// Below this many faces threads cost more than they bring.
const SERIAL_FACES: usize = 512;

/// A frame's memories, as the tile renderer writes them.
pub struct Frame<'a> {
    /// Pixels in a row.
    pub width: usize,
    /// RGBA bytes.
    pub bytes: &'a mut [u8],
    /// Bits of f32 depths.
    pub depth: &'a mut [i32],
}

/// Memories that are kept from draw to draw, so that a steady frame allocates nothing large.
#[derive(Debug, Default)]
pub struct Scratch {
    records: Vec<Record>,
    chunks: Vec<Chunk>,
    ids: Vec<i32>,
}

impl Scratch {
    /// Bytes that the memories take.
    pub fn size_bytes(&self) -> usize {
        let chunk = |c: &Chunk| {
            c.setups.capacity() * size_of::<setup::Setup>()
                + c.bins.iter().map(|b| b.capacity() * 4).sum::<usize>()
        };
        self.records.capacity() * 16 + self.ids.capacity() * 4 + self.chunks.iter().map(chunk).sum::<usize>()
    }

    /// The records of the vertices that were transformed last.
    pub fn records(&self) -> &[Record] {
        &self.records
    }
}

/// What came in and went out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TileStats {
    /// Faces left out by their winding.
    pub culled: u64,
    /// Faces without a pixel centre in their box.
    pub empty: u64,
    /// Faces handed to the rasteriser.
    pub drawn: u64,
    /// Fragments that passed the depth test.
    pub passed: u64,
    /// Pixels shaded.
    pub shaded: u64,
}

/// One draw of opaque faces.
pub struct Job<'a> {
    /// The mesh.
    pub mesh: &'a PreparedMesh,
    /// Object space to the screen.
    pub to_screen: ToScreen,
    /// Which windings are drawn.
    pub keep: Keep,
    /// Which pixels may be drawn; inside the frame.
    pub view: View,
    /// How pixels get their colours.
    pub shading: Shading<'a>,
    /// Coverage and depth of faces that only the plain path can draw.
    pub plain_face: PlainFace<'a>,
}

/// The widest and tallest frame whose pixels the records reach, and the narrowest that a vector fits.
pub const FRAME_LIMITS: (usize, usize) = (16, 16_000);

/// Draws `job` into `frame`.
///
/// The frame's sides must lie within [`FRAME_LIMITS`] and the view inside the frame; the faces must be fewer than 2^30.
pub fn render<C: Crew>(
    level: Level,
    crew: &C,
    scratch: &mut Scratch,
    job: &Job<'_>,
    frame: &mut Frame<'_>,
) -> TileStats {
    let mesh = job.mesh;
    let (faces, view, width) = (mesh.triangle_count(), job.view, frame.width);
    let mut stats = TileStats::default();
    if faces == 0 || view.x0 >= view.x1 || view.y0 >= view.y1 {
        return stats;
    }
    let is_serial = faces < SERIAL_FACES;

    // Vertices: each to a record.
    scratch.records.resize(mesh.vertex_count(), [0.0; 4]);
    each_chunk(crew, is_serial, &mut scratch.records, CHUNK_VERTICES, |i, records| {
        let range = i * CHUNK_VERTICES..i * CHUNK_VERTICES + records.len();
        let positions = [0, 1, 2].map(|axis| &mesh.positions[axis][range.clone()]);
        level.dispatch(VertexKernel { positions, to_screen: &job.to_screen, records });
    });

    // Faces: culled, bounded, binned into bands.
    let bands = ((view.y1 - view.y0) as usize).div_ceil(BAND_ROWS);
    let chunk_count = faces.div_ceil(CHUNK_FACES);
    if scratch.chunks.len() < chunk_count {
        scratch.chunks.resize_with(chunk_count, Chunk::default);
    }
    let records = scratch.records.as_slice();
    each_chunk(crew, is_serial, &mut scratch.chunks[..chunk_count], 1, |i, chunk| {
        let range = i * CHUNK_FACES..((i + 1) * CHUNK_FACES).min(faces);
        chunk[0].reset(bands);
        level.dispatch(SetupKernel {
            records,
            indices: &mesh.indices[range.start * 3..range.end * 3],
            plain_only: &mesh.plain_only[range.clone()],
            first_face: range.start as u32,
            keep: job.keep,
            view,
            band_rows: BAND_ROWS as i32,
            chunk: &mut chunk[0],
        });
    });
    let chunks = &scratch.chunks[..chunk_count];
    for chunk in chunks {
        stats.culled += chunk.culled;
        stats.empty += chunk.empty;
        stats.drawn += chunk.setups.len() as u64;
    }
    if stats.drawn == 0 {
        return stats;
    }

    // Bands: visibility, then colour.
    scratch.ids.resize(frame.depth.len(), NO_FACE);
    let rows = view.y0 as usize * width..view.y1 as usize * width;
    let counts = std::sync::atomic::AtomicU64::new(0);
    let shaded = std::sync::atomic::AtomicU64::new(0);
    let work = |band: usize, depth: &mut [i32], ids: &mut [i32], bytes: &mut [u8]| {
        let y0 = view.y0 + (band * BAND_ROWS) as i32;
        let band_rows = (depth.len() / width) as i32;
        let mut passed = 0;
        for chunk in chunks.iter().filter(|c| !c.bins[band].is_empty()) {
            passed += level.dispatch(RasterKernel {
                setups: &chunk.setups,
                bin: &chunk.bins[band],
                records,
                indices: &mesh.indices,
                positions: [&mesh.positions[0], &mesh.positions[1], &mesh.positions[2]],
                to_screen: &job.to_screen,
                keep: job.keep,
                view,
                rows: band_rows,
                band: &mut Band { y0, width, depth, ids },
                plain: job.plain_face,
            });
        }
        if passed == 0 {
            return;
        }
        let faces = Faces { shading: &job.shading, indices: &mesh.indices, records };
        let kernel = ResolveKernel { faces, view, y0, rows: band_rows, width, ids, bytes };
        let pixels = level.dispatch(kernel);
        counts.fetch_add(passed, std::sync::atomic::Ordering::Relaxed);
        shaded.fetch_add(pixels, std::sync::atomic::Ordering::Relaxed);
    };
    let (depth, ids) = (&mut frame.depth[rows.clone()], &mut scratch.ids[rows.clone()]);
    let bytes = &mut frame.bytes[rows.start * 4..rows.end * 4];
    match is_serial {
        true => Alone.bands(depth, ids, bytes, BAND_ROWS * width, work),
        false => crew.bands(depth, ids, bytes, BAND_ROWS * width, work),
    }
    stats.passed = counts.into_inner();
    stats.shaded = shaded.into_inner();
    stats
}

fn each_chunk<C: Crew, T: Send>(
    crew: &C,
    is_serial: bool,
    items: &mut [T],
    size: usize,
    work: impl Fn(usize, &mut [T]) + Sync,
) {
    match is_serial {
        true => Alone.chunks(items, size, work),
        false => crew.chunks(items, size, work),
    }
}

#[cfg(test)]
mod tests;

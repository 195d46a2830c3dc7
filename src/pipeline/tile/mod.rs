//! The tile renderer: the default path, several times faster than the plain path and within stated
//! limits of its picture.
//!
//! Deferred shading: faces are set up a vector at a time and binned into tiles, in rows of tiles.
//! Each row of tiles resolves which face is seen at each of its pixels (exact integer coverage,
//! then depth, in file order); then every visible pixel is shaded once. A face that f32 screen
//! vertices cannot represent (behind the eye, steep, huge) is set up in f64 by the plain path, at
//! its place in the order. The picture is the plain path's within these limits: equal coverage,
//! depth within 4e-7, colour within 1/255. Work is split by faces and by rows of tiles,
//! independently of timing: the bytes are equal with any number of threads and at every vector
//! width.
//!
//! Stages: clusters (culling) -> vertex -> setup (cull, bound, cover, bin) -> raster and resolve,
//! one row of tiles after the other.

mod attribute_fetch;
mod bin_fragments;
mod binning;
mod bins;
mod blended_face;
mod blended_texture;
mod clusters;
mod depth_f64;
mod depth_test;
mod edges;
mod exact_faces;
mod exact_raster;
mod face_tables;
mod face_vectors;
mod fog;
mod fragments;
mod grid;
mod hierarchical_z;
mod interpolate;
mod lighting;
mod list_bytes;
mod raster;
mod resolve;
mod sampler;
mod setup;
mod shading_state;
mod texel_fetch;
mod texture_queue;
mod tile_buffers;
mod tile_rows;
mod traverse;
mod vertex;
mod vertex_lighting;

pub(crate) use binning::{Binned, Binning, LIST_BYTES, bin_bytes, grid_bytes, list_bound, worst_list_bytes};
pub(crate) use bins::Winding;
pub(crate) use blended_face::{BlendedFace, BlendedFaceKernel, FaceLighting};
pub(crate) use blended_texture::BlendedTexture;
pub(crate) use depth_f64::DepthEncoder;
pub(crate) use exact_faces::ExactFace;
pub(crate) use fog::FogParams;
pub(crate) use hierarchical_z::HIERARCHICAL_Z_BYTES;
pub(crate) use lighting::{Cone, Exponent, FastLight, LightPosition, MaterialLighting};
pub(crate) use list_bytes::ListBytes;
pub(crate) use sampler::TextureSampler;
pub(crate) use shading_state::{ColorSource, Eye, FragmentShader, MaterialBinding, Shading};
pub(crate) use tile_rows::{BinnedDraw, Counts, RowProgress, TileRowBuffers, for_each_tile_row};
pub(crate) use vertex::{ScreenVertex, ToScreen};
pub(crate) use vertex_lighting::VertexLightingKernel;

use crate::math::coverage::PixelRect;
use crate::memory::DepthCells;
use crate::pipeline::draw_call::CoarseDepth;
use crate::pipeline::indexed_mesh::IndexedMesh;
use crate::simd::Level;
use bins::{Bin, Chunk};
use depth_f64::DepthVertex;
use std::sync::atomic::AtomicU8;
use vertex::{Projector, VertexKernel};

/// Returns the screen vertices of three points of object space.
pub(crate) fn screen_vertices_of(
    level: Level,
    to_screen: &ToScreen,
    points: [[f64; 3]; 3],
) -> [ScreenVertex; 3] {
    let axis = |axis: usize| points.map(|p| p[axis]);
    let (xs, ys, zs) = (axis(0), axis(1), axis(2));
    let mut screen_vertices = [[0.0; 4]; 3];
    let farthest = [0, 1, 2].map(|axis| points.iter().fold(0.0f64, |far, p| far.max(p[axis].abs())));
    let projector = &Projector::new(*to_screen, &to_screen.to_view(), farthest);
    level.dispatch(VertexKernel {
        positions: [&xs, &ys, &zs],
        projector,
        marks: &[],
        screen_vertices: &mut screen_vertices,
    });
    screen_vertices
}

/// The buffers of a frame that the tile renderer writes.
pub(crate) struct FrameSlices<'a> {
    /// Width of a row in pixels.
    pub width: usize,
    /// RGBA bytes.
    pub bytes: &'a mut [u8],
    /// Bits of f32 depths; `None` where depth is neither tested nor stored.
    pub depth: Option<DepthCells<'a>>,
    /// Name and triangle of each pixel, for PICK; empty when picking is off.
    pub pick: &'a mut [[u32; 2]],
}

/// Buffers that are reused from draw to draw, so that a steady frame allocates nothing large.
#[derive(Debug)]
pub(crate) struct Scratch {
    /// Visibility of each cluster of faces.
    visibilities: Vec<u8>,
    /// Set for the blocks of vertices that an open cluster uses; empty if all are transformed.
    marks: Vec<AtomicU8>,
    /// Vertices on the screen.
    screen_vertices: Vec<ScreenVertex>,
    /// The vertices' depths in f64, for the depth formats that need them.
    depth_f64: Vec<DepthVertex>,
    /// Binned faces of the chunks.
    chunks: Vec<Chunk>,
    /// Bit set for each tile: the chunks that reach it; empty if there is only one chunk.
    visitors: Vec<u64>,
    /// Capacity of the chunks' lists in bytes.
    bytes: ListBytes,
    /// Limit of `bytes`; beyond it a draw is split into pieces.
    pub list_bytes: usize,
    /// Set if several draws share `bytes`: once it exceeds the limit, none of them starts a
    /// cluster of faces.
    is_shared: bool,
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
                + b.larger.capacity() * size_of::<bins::Larger>()
                + b.fragments.size_bytes()
                + b.tiny.size_bytes()
                + b.small.capacity() * size_of::<bins::Small>()
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
            + self.screen_vertices.capacity() * 16
            + self.depth_f64.capacity() * size_of::<DepthVertex>()
    }
}

/// One draw of opaque faces. The frame's sides must lie within [`FRAME_LIMITS`], and the mesh must
/// have fewer than 2^30 faces.
pub(crate) struct DrawJob<'a> {
    /// Mesh to draw.
    pub mesh: &'a IndexedMesh,
    /// Transform from object space to the screen.
    pub to_screen: ToScreen,
    /// Row that takes view space to w - z without cancellation.
    pub complement: [f64; 4],
    /// Windings that are drawn.
    pub winding: Winding,
    /// Pixels that may be written; inside the frame.
    pub view: PixelRect,
    /// Source of the pixels' colours.
    pub shading: Shading<'a>,
    /// Set-up in f64 by the plain path, for faces that screen vertices cannot represent.
    pub plain: setup::PlainSetup<'a>,
    /// Name that is written to the pick buffer.
    pub name: u32,
    /// Depth evaluation in f64; `None` for f32 depths and for frames without depth.
    pub depth_f64: Option<DepthF64>,
    /// Use of hierarchical z to skip hidden faces tile by tile.
    pub coarse: CoarseDepth,
}

/// Parameters of depth formats other than f32.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DepthF64 {
    /// Encoder from f64 depths to the format's words.
    pub encoder: DepthEncoder,
    /// Row that takes view space to the stored depth times w: z or w - z.
    pub row: [f64; 4],
}

/// Smallest width of a frame in pixels (a vector must fit), and largest width and height (screen
/// vertices must reach every pixel).
pub(crate) const FRAME_LIMITS: (usize, usize) = (16, 15_900);

/// Size in bytes of a screen vertex, and of a vertex's depth in f64.
pub(crate) const SCREEN_VERTEX_BYTES: u64 = size_of::<ScreenVertex>() as u64;
pub(crate) const DEPTH_VERTEX_BYTES: u64 = size_of::<DepthVertex>() as u64;

//! A draw of opaque faces as the front end hands it to the tile renderer, and the frame's buffers.

use super::bins::Winding;
use super::close_depths::ReferenceFaces;
use super::depth_f64::DepthEncoder;
use super::setup::PlainSetup;
use super::shading_state::Shading;
use super::vertex::ToScreen;
use crate::math::coverage::PixelRect;
use crate::memory::{DepthCells, PickCells};
use crate::pipeline::draw_call::CoarseDepth;
use crate::pipeline::indexed_mesh::IndexedMesh;

/// Smallest width of a frame in pixels (a vector must fit), and largest width and height (screen
/// vertices must reach every pixel).
pub(crate) const FRAME_LIMITS: (usize, usize) = (16, 15_900);

/// The buffers of a frame that the tile renderer writes.
pub(crate) struct FrameSlices<'a> {
    /// Width of a row in pixels.
    pub width: usize,
    /// RGBA bytes.
    pub bytes: &'a mut [u8],
    /// Bits of f32 depths; `None` where depth is neither tested nor stored.
    pub depth: Option<DepthCells<'a>>,
    /// Name and triangle of each pixel, for PICK; empty when picking is off.
    pub pick: PickCells<'a>,
}

/// One draw of opaque faces. The frame's sides must lie within [`FRAME_LIMITS`], and the mesh must
/// have fewer than 2^30 faces.
pub(crate) struct DrawJob<'a> {
    /// Mesh to draw.
    pub mesh: &'a IndexedMesh,
    /// Transform from object space to the screen.
    pub to_screen: &'a ToScreen,
    /// Row that takes view space to w - z without cancellation.
    pub complement: [f64; 4],
    /// Windings that are drawn.
    pub winding: Winding,
    /// Pixels that may be written; inside the frame.
    pub view: PixelRect,
    /// Source of the pixels' colours.
    pub shading: Shading<'a>,
    /// Set-up in f64 by the plain path, for faces that screen vertices cannot represent.
    pub plain: PlainSetup<'a>,
    /// Assembles a face as the plain path does, for its depths.
    pub reference_faces: ReferenceFaces<'a>,
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

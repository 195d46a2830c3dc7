//! Per-draw shading state: colour source, eye, materials and fog.

use super::fog::FogParams;
use super::lighting::{FastLight, MaterialLighting};
use super::sampler::TextureSampler;
use crate::pipeline::depth_sort::recycle;
pub use crate::pipeline::shading_space::Eye;

/// Source of the colours, with its per-vertex or per-face arrays.
#[derive(Clone, Copy, Debug)]
pub enum ColorSource<'a> {
    /// Lit at each pixel; normals of the vertices in shading space.
    Pixels(&'a [[f32; 4]]),
    /// Lit at the vertices: the diffuse part, and the part that a texture does not multiply (empty
    /// if both are in the first).
    Vertices(&'a [[f32; 4]], &'a [[f32; 4]]),
    /// One colour for each face, in these two parts.
    Faces(&'a [[f32; 4]], &'a [[f32; 4]]),
    /// One colour for each material.
    Constant,
}

/// Shades one pixel in f64. Arguments: face, column, row; result: R, G, B, A.
pub type PlainPixel<'a> = &'a (dyn Fn(u32, i32, i32) -> [u8; 4] + Sync);

/// Shades a run of pixels of a row that show one face, in f64. Arguments: face, column and row of the
/// first pixel, the pixels' bytes.
pub type PlainRun<'a> = &'a (dyn Fn(u32, [i32; 2], &mut [u8]) + Sync);

/// Material as the kernels read it.
#[derive(Clone, Debug)]
pub struct MaterialBinding<'a> {
    /// Material and lights.
    pub lighting: MaterialLighting,
    /// Texture, if any.
    pub texture: Option<TextureSampler<'a>>,
}

/// Empty lists that one draw, or tile, leaves to the next for reuse.
#[derive(Debug, Default)]
pub struct RecycledBindings {
    /// List of materials.
    pub bindings: Vec<MaterialBinding<'static>>,
    /// Lists of their lights.
    pub lights: Vec<Vec<FastLight>>,
}

impl RecycledBindings {
    /// Takes back the lists of a finished draw.
    pub fn take_back(&mut self, mut bindings: Vec<MaterialBinding<'_>>) {
        self.lights.extend(bindings.drain(..).map(|s| s.lighting.lights).filter(|l| l.capacity() > 0));
        self.bindings = recycle(bindings);
    }
}

/// Inputs from which fragments are shaded, apart from their material: those of a draw, or of a
/// blended face.
#[derive(Clone, Copy)]
pub struct FragmentShader<'a> {
    /// Source of the colours.
    pub source: ColorSource<'a>,
    /// Reconstruction of positions.
    pub eye: Eye,
    /// Vertex colours that multiply the diffuse part at each pixel; empty for none.
    pub colors: &'a [[f32; 4]],
    /// Texture coordinates of the vertices.
    pub texcoords: &'a [[f32; 4]],
    /// Positions of the vertices in shading space, if they are interpolated for lighting.
    pub positions: &'a [[f32; 4]],
    /// Fog, if any.
    pub fog: Option<FogParams>,
    /// Positions of the vertices in the fog's space, if they are interpolated for fog.
    pub fog_positions: &'a [[f32; 4]],
}

/// Shading state that all pixels of a draw share.
pub struct Shading<'a> {
    /// Inputs of all fragments.
    pub shader: FragmentShader<'a>,
    /// Materials; if `back` is not 0, followed by one for each again for back-facing faces.
    pub bindings: &'a [MaterialBinding<'a>],
    /// Offset in `bindings` of the materials of back-facing faces; 0 if they have none of their
    /// own.
    pub back: i32,
    /// Sign of the screen area of back-facing faces: 1 clockwise, -1 counter-clockwise.
    pub back_facing: i32,
    /// True if attributes are linear on the screen.
    pub is_affine: bool,
    /// Sign of the screen area of faces whose normals are flipped: 1 clockwise, -1
    /// counter-clockwise, 0 none.
    pub flip_normal: i32,
    /// Largest error of light that is interpolated over cells of pixels, in units of colour.
    pub light_error: f32,
    /// Shades one pixel by the plain path.
    pub plain: PlainPixel<'a>,
    /// Shades every pixel by the plain path, if the draw has surface maps.
    pub maps: Option<PlainRun<'a>>,
}

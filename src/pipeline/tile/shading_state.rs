//! Per-draw shading state: the source of colours, the eye, the materials, the fog.

use super::fog::FogParams;
use super::lighting::MaterialLighting;
use super::sampler::TextureSampler;

/// Where colours come from.
#[derive(Clone, Copy, Debug)]
pub enum ColorSource<'a> {
    /// Lit at each pixel; normals in the shading frame, one a vertex.
    Pixels(&'a [[f32; 4]]),
    /// Lit at the vertices: the diffuse part, and what a texture does not multiply (empty when both are one).
    Vertices(&'a [[f32; 4]], &'a [[f32; 4]]),
    /// One colour a face, in the same two parts.
    Faces(&'a [[f32; 4]], &'a [[f32; 4]]),
    /// One colour a material.
    Constant,
}

/// How a pixel's place in the shading frame is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eye {
    /// Eye-relative position = (ray 0 + ray 1 * column + ray 2 * row) * w; V points back along it.
    Perspective {
        /// At pixel (0,0), per column, per row.
        ray: [[f32; 3]; 3],
    },
    /// V is the same everywhere; positions are gathered.
    Parallel {
        /// Unit, towards the viewer.
        to_viewer: [f32; 3],
    },
}

/// Shades one pixel in f64: face, column, row; R, G, B, A.
pub type PlainPixel<'a> = &'a (dyn Fn(u32, i32, i32) -> [u8; 4] + Sync);

/// One material as the kernels read it.
#[derive(Clone, Debug)]
pub struct MaterialBinding<'a> {
    /// The material and its lights.
    pub lighting: MaterialLighting,
    /// Its texture.
    pub texture: Option<TextureSampler<'a>>,
}

/// What every pixel of a draw shares.
pub struct Shading<'a> {
    /// Where colours come from.
    pub source: ColorSource<'a>,
    /// The eye.
    pub eye: Eye,
    /// The materials; with `back`, all of them once more for faces seen from behind.
    pub bindings: &'a [MaterialBinding<'a>],
    /// Faces seen from behind have surfaces of their own, so many further on; 0 where they have not.
    pub back: i32,
    /// Which faces are seen from behind, by the sign of their screen area: 1 clockwise, -1 counter-clockwise.
    pub back_facing: i32,
    /// The fog.
    pub fog: Option<FogParams>,
    /// Vertex colours that multiply the diffuse part at each pixel; empty for none.
    pub colors: &'a [[f32; 4]],
    /// Texture coordinates.
    pub texcoords: &'a [[f32; 4]],
    /// Positions in the shading frame (parallel projections that are lit per pixel).
    pub positions: &'a [[f32; 4]],
    /// Whether values run straight on the screen.
    pub is_affine: bool,
    /// Faces with this sign of their screen area turn their normals: 1 clockwise, -1 counter-clockwise, 0 none.
    pub flip_normal: i32,
    /// The plain path.
    pub plain: PlainPixel<'a>,
}

//! Surface maps: textures of a surface's emission, normal and ambient occlusion.
//!
//! In: the maps of an object, each with texture coordinates, one per corner of the mesh. A renderer
//! samples them at each pixel, with the interpolation and the footprint of the object's own texture,
//! and follows these formulas (R, G, B of a texel in 0..1):
//!
//! ```text
//! emission   Ke R G B in place of Ke
//! normal     m = (s (2R - 1), s (2G - 1), 2B - 1), of unit length
//!            N' = m.x T + m.y B + m.z N, of unit length
//!            T  = the interpolated tangent, less its part along N, of unit length
//!            B  = w (N x T), w the sign of the face's first corner
//! occlusion  Ka E(1 + s (R - 1)) / E(mean) in place of Ka, E being the encoding of sRGB
//! ```
//!
//! N stands where the tangents vanish. N is turned to the viewer (two-sided lighting) with T and B.
//! Normal and occlusion change light that is computed at pixels (SHADE phong); light at vertices or
//! faces has Ka with the map's mean, as the loader made it. Unlit materials and lines have no maps.
//!
//! Source: glTF 2.0 Specification, section 3.9.3 (Additional Textures) and appendix B.

use super::{Sampling, Texture};
use crate::math::power::pow;
use glam::{DVec2, DVec4};
use std::sync::Arc;

/// A texture with its own texture coordinates.
#[derive(Clone, Debug)]
pub struct SurfaceMap {
    /// Texture; its alpha has no meaning.
    pub texture: Arc<Texture>,
    /// Filter and wrap modes.
    pub sampling: Sampling,
    /// Texture coordinates, one per corner of the mesh.
    pub texcoords: Arc<[DVec2]>,
}

/// Map of normals in tangent space.
#[derive(Clone, Debug)]
pub struct NormalMap {
    /// Directions: R to the right and G up in the picture, B outwards.
    pub map: SurfaceMap,
    /// Factor s of the directions' first two components.
    pub scale: f64,
    /// Tangents in object space, one per corner of the mesh, each with the sign of its bitangent as
    /// w; zero for a corner without.
    pub tangents: Arc<[DVec4]>,
}

/// Map of the part of the ambient light that reaches a surface.
#[derive(Clone, Debug)]
pub struct OcclusionMap {
    /// Reachability, linear, in R.
    pub map: SurfaceMap,
    /// Strength s: 0 leaves the ambient light as it is.
    pub strength: f64,
    /// E(mean of the map), by which the material's Ka has been multiplied; positive.
    pub mean: f64,
}

/// Maps of an object; see the module.
#[derive(Clone, Debug, Default)]
pub struct SurfaceMaps {
    /// Emission, times the material's Ke.
    pub emission: Option<SurfaceMap>,
    /// Normals.
    pub normal: Option<NormalMap>,
    /// Ambient occlusion.
    pub occlusion: Option<OcclusionMap>,
}

impl SurfaceMap {
    /// Returns the bytes of texture and coordinates.
    pub fn size_bytes(&self) -> usize {
        self.texture.size_bytes() + size_of_val(&*self.texcoords)
    }
}

impl SurfaceMaps {
    /// Iterates over the maps that there are.
    pub fn all(&self) -> impl Iterator<Item = &SurfaceMap> {
        let normal = self.normal.as_ref().map(|n| &n.map);
        let occlusion = self.occlusion.as_ref().map(|o| &o.map);
        self.emission.iter().chain(normal).chain(occlusion)
    }

    /// Returns the maps' names, as a plan's reason.
    pub fn names(&self) -> &'static str {
        match (self.emission.is_some(), self.normal.is_some(), self.occlusion.is_some()) {
            (true, true, true) => "emission, normals and occlusion, pixel by pixel in f64",
            (true, true, false) => "emission and normals, pixel by pixel in f64",
            (true, false, true) => "emission and occlusion, pixel by pixel in f64",
            (false, true, true) => "normals and occlusion, pixel by pixel in f64",
            (true, false, false) => "emission, pixel by pixel in f64",
            (false, true, false) => "normals, pixel by pixel in f64",
            (false, false, true) => "occlusion, pixel by pixel in f64",
            (false, false, false) => "no map",
        }
    }
}

/// Encodes a linear number as sRGB does, also beyond 1.
pub fn encoded(linear: f64) -> f64 {
    let x = linear.max(0.0);
    match x <= 0.003_130_8 {
        true => 12.92 * x,
        // 1.055 x^(1/2.4) - 0.055, and 1 at 1.
        false => 1.055 * (pow(x, 1.0 / 2.4) - 1.0) + 1.0,
    }
}

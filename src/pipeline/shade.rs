//! Stages 8 and 9: what runs across a face, and the colour that it gives a pixel.
//!
//! In: the shares of a face's corners at a pixel (they add up to 1). Out: R, G, B (unclamped) and
//! opacity. What is the same on the whole face is found once a face.

use super::draw_call::DrawStats;
use super::light::{Lighting, LitColor, SurfacePoint};
use super::sampler::{Footprint, sample};
use crate::math::matrix::unit;
use crate::scene::{FillStyle, Fog, FogKind, Material, Sampling, Texture, TextureStages};
use glam::{DVec2, DVec3, DVec4};

/// How the light part of a face's colour is found.
#[derive(Clone, Debug)]
pub(crate) enum ShadingFrequency<'a> {
    /// One colour on the face.
    Constant(LitColor),
    /// Lit at the corners, vertex colours already in.
    Vertices([LitColor; 3]),
    /// Lit at each pixel with the interpolated normal.
    Pixels {
        material: &'a Material,
        normals: [DVec3; 3],
        /// For normals that cancel on the way.
        face_normal: DVec3,
    },
}

/// Everything of a face that its pixels' colours depend on.
#[derive(Clone, Debug)]
pub(crate) struct FaceShade<'a> {
    pub light: ShadingFrequency<'a>,
    /// Vertex colours that run across the face.
    pub colors: Option<[DVec4; 3]>,
    pub texture: Option<(&'a Texture, Sampling, [DVec2; 3])>,
    /// Several textures in place of one, and the numbers of the face's corners.
    pub stages: Option<(&'a TextureStages, [u32; 3])>,
    /// Which pixels show the face.
    pub fill: FillStyle,
    /// World positions, where something asks for them.
    pub positions: [DVec3; 3],
    /// 1 - transparency, times the alpha of a colour that holds for the whole face.
    pub opacity: f64,
    pub fog: Option<(Fog, DVec3)>,
    /// Whether the face lets light through: it is blended, and writes no depth.
    pub is_transparent: bool,
}

/// A value between three corners' values; equal corners give exactly their value.
macro_rules! between {
    ($v:expr, $barycentrics:expr) => {
        $v[0] + ($v[1] - $v[0]) * $barycentrics[1] + ($v[2] - $v[0]) * $barycentrics[2]
    };
}

impl FaceShade<'_> {
    /// The colour and opacity where nothing runs across the face.
    pub fn solid(&self) -> Option<(DVec3, f64)> {
        match self {
            FaceShade {
                light: ShadingFrequency::Constant(lit),
                colors: None,
                texture: None,
                stages: None,
                fog: None,
                ..
            } => Some((lit.diffuse_ambient + lit.specular_emissive, self.opacity)),
            _ => None,
        }
    }

    /// The colour and opacity at a pixel. `footprint` is asked for only by the mip filters; it gets
    /// the u, v corners.
    pub fn at(
        &self,
        barycentrics: [f64; 3],
        footprint: impl FnOnce(&[DVec2; 3]) -> Footprint,
        lighting: &Lighting,
        stats: &mut DrawStats,
    ) -> (DVec3, f64) {
        let mut lit = match &self.light {
            ShadingFrequency::Constant(lit) => *lit,
            ShadingFrequency::Vertices(lit) => {
                let (diffuse_ambient, specular_emissive) =
                    (lit.map(|l| l.diffuse_ambient), lit.map(|l| l.specular_emissive));
                LitColor {
                    diffuse_ambient: between!(diffuse_ambient, barycentrics),
                    specular_emissive: between!(specular_emissive, barycentrics),
                }
            }
            ShadingFrequency::Pixels { material, normals, face_normal } => {
                stats.pixels_lit += 1;
                let normal = normals[0] * barycentrics[0]
                    + normals[1] * barycentrics[1]
                    + normals[2] * barycentrics[2];
                let normal = Some(normal).filter(|n| n.length_squared() > 1e-24).and_then(unit);
                let point = SurfacePoint {
                    position: self.position(barycentrics),
                    normal: normal.unwrap_or(*face_normal),
                };
                lighting.at(point, material)
            }
        };
        let mut opacity = self.opacity;
        if let Some(colors) = &self.colors {
            let color = between!(colors, barycentrics);
            lit.diffuse_ambient *= color.truncate();
            opacity *= color.w;
        }
        if let Some((texture, sampling, uv)) = &self.texture {
            let at = between!(uv, barycentrics);
            let level = || footprint(uv).level(texture.width(), texture.height());
            let [r, g, b, a] = sample(texture, *sampling, at, level);
            lit.diffuse_ambient *= DVec3::new(r, g, b);
            opacity *= a;
        }
        if let Some((stages, corners)) = self.stages {
            let texel = |number: usize| {
                let stage = &stages.stages[number];
                let uv = corners.map(|c| stage.texcoords.get(c as usize).copied().unwrap_or(DVec2::ZERO));
                // X3D's textures are filtered by four texels of their first level.
                let texture = stage.texture.as_deref();
                texture.map_or([1.0; 4], |t| sample(t, stage.sampling, between!(uv, barycentrics), || 0.0))
            };
            (lit.diffuse_ambient, opacity) =
                stages.combine((lit.diffuse_ambient, opacity), lit.specular_emissive, texel);
        }
        let mut color = lit.diffuse_ambient + lit.specular_emissive;
        if let Some((fog, eye)) = &self.fog {
            let clear = visibility(fog, (self.position(barycentrics) - *eye).length());
            color = fog.color * (1.0 - clear) + color * clear;
        }
        (color, opacity)
    }

    fn position(&self, barycentrics: [f64; 3]) -> DVec3 {
        between!(self.positions, barycentrics)
    }
}

/// The u, v at the shares, relative to the first corner's: differences of it keep their digits far
/// from 0.
pub(crate) fn uv_from_first(uv: &[DVec2; 3], barycentrics: [f64; 3]) -> DVec2 {
    (uv[1] - uv[0]) * barycentrics[1] + (uv[2] - uv[0]) * barycentrics[2]
}

/// X3D's fog interpolant: 1 all of the surface's own colour, 0 all fog; `distance` from the eye.
pub(crate) fn visibility(fog: &Fog, distance: f64) -> f64 {
    let range = fog.visibility_range;
    if range.is_nan() || range <= 0.0 {
        1.0
    } else if distance.is_nan() || distance >= range {
        0.0
    } else {
        match fog.kind {
            FogKind::Linear => (range - distance) / range,
            FogKind::Exponential => libm::exp(-distance / (range - distance)),
        }
    }
}

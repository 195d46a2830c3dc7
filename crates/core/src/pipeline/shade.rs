//! Stages 8 and 9: attribute interpolation and the colour of a pixel.
//!
//! In: barycentrics of a pixel in its face. Out: R, G, B (unclamped) and opacity. Values that are
//! constant on a face are computed once per face.

use super::draw_call::DrawStats;
use super::light::{Lighting, LitColor, SurfacePoint};
use super::sampler::{Footprint, sample};
use super::surface_maps::FaceMaps;
use crate::math::matrix::unit;
use crate::scene::{FillStyle, Fog, FogKind, Material, Sampling, Texture, TextureStages};
use glam::{DVec2, DVec3, DVec4};

/// Frequency at which a face is lit.
#[derive(Clone, Debug)]
pub(crate) enum ShadingFrequency<'a> {
    /// Per face: one colour.
    Constant(LitColor),
    /// Per vertex: lit at the corners, vertex colours included.
    Vertices([LitColor; 3]),
    /// Per pixel, with the interpolated normal.
    Pixels {
        material: &'a Material,
        normals: [DVec3; 3],
        /// Replaces an interpolated normal that vanishes.
        face_normal: DVec3,
    },
}

/// Inputs of a face's pixel colours.
#[derive(Clone, Debug)]
pub(crate) struct FaceShade<'a> {
    pub light: ShadingFrequency<'a>,
    /// Vertex colours, interpolated across the face.
    pub colors: Option<[DVec4; 3]>,
    /// Texture, its sampling modes and the corners' u, v.
    pub texture: Option<(&'a Texture, Sampling, [DVec2; 3])>,
    /// Multitexturing stages in place of one texture, and the face's corner indices.
    pub stages: Option<(&'a TextureStages, [u32; 3])>,
    /// Maps of emission, normals and occlusion.
    pub maps: Option<FaceMaps<'a>>,
    /// Fill style: pixels that show the face.
    pub fill: FillStyle,
    /// World positions; zero if neither lighting nor fog needs them.
    pub positions: [DVec3; 3],
    /// 1 - transparency, times the alpha of a colour that is constant on the face.
    pub opacity: f64,
    /// Fog, and the eye's position in world space.
    pub fog: Option<(Fog, DVec3)>,
    /// True if the face is transparent: it is blended and writes no depth.
    pub is_transparent: bool,
}

/// Interpolates three corners' values; equal corners give exactly their value.
macro_rules! between {
    ($v:expr, $barycentrics:expr) => {
        $v[0] + ($v[1] - $v[0]) * $barycentrics[1] + ($v[2] - $v[0]) * $barycentrics[2]
    };
}

impl FaceShade<'_> {
    /// Returns colour and opacity if they are constant on the face.
    pub fn solid(&self) -> Option<(DVec3, f64)> {
        match self {
            FaceShade {
                light: ShadingFrequency::Constant(lit),
                colors: None,
                texture: None,
                stages: None,
                maps: None,
                fog: None,
                ..
            } => Some((lit.diffuse_ambient + lit.specular_emissive, self.opacity)),
            _ => None,
        }
    }

    /// Returns colour and opacity at a pixel. Only the mip filters call `footprint`, with the
    /// corners' u, v.
    pub fn at(
        &self,
        barycentrics: [f64; 3],
        footprint: impl Fn(&[DVec2; 3]) -> Footprint,
        lighting: &Lighting,
        stats: &mut DrawStats,
    ) -> (DVec3, f64) {
        let mut lit = match &self.light {
            ShadingFrequency::Constant(lit) => match &self.maps {
                None => *lit,
                Some(maps) => maps.dimmed(*lit, barycentrics, &footprint),
            },
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
                match &self.maps {
                    None => lighting.at(point, material),
                    Some(maps) => maps.light(point, barycentrics, &footprint, lighting),
                }
            }
        };
        if let Some(maps) = &self.maps {
            maps.emit(&mut lit, barycentrics, &footprint);
        }
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
                // X3D textures are filtered bilinearly on level 0.
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

    /// Returns the interpolated world position.
    fn position(&self, barycentrics: [f64; 3]) -> DVec3 {
        between!(self.positions, barycentrics)
    }
}

/// Returns u, v at these barycentrics relative to the first corner, so that differences keep their
/// precision far from 0.
pub(crate) fn uv_from_first(uv: &[DVec2; 3], barycentrics: [f64; 3]) -> DVec2 {
    (uv[1] - uv[0]) * barycentrics[1] + (uv[2] - uv[0]) * barycentrics[2]
}

/// Returns X3D's fog interpolant at `distance` from the eye: 1 for the surface's colour alone, 0
/// for fog alone.
pub(crate) fn visibility(fog: &Fog, distance: f64) -> f64 {
    let range = fog.visibility_range;
    if !fog.is_seen() {
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

//! Surface maps at a pixel: light with a normal of a map, dimmed ambient light, emission of a map.
//!
//! In: the maps of a draw, with a triangle's corners, and the barycentrics of a pixel. Out: its lit
//! colour. The formulas are those of [`crate::scene::SurfaceMaps`]. Draws without maps never come
//! here; those with maps are lit at every pixel in f64, by the tile renderer too.
//!
//! Verified by tests/drawing/surface_maps.rs against the reference renderer.

use super::draw_call::DrawCall;
use super::light::{Lighting, LitColor, SurfacePoint};
use super::sampler::{Footprint, sample};
use crate::math::matrix::unit;
use crate::scene::{
    LightingModel, Material, NormalMap, OcclusionMap, ShadeMode, SurfaceMap, SurfaceMaps, encoded,
};
use glam::{DMat3, DMat4, DVec2, DVec3, DVec4};

/// Squared length below which an interpolated tangent has no direction.
const VANISHING: f64 = 1e-24;

/// Maps of one face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceMaps<'a> {
    maps: &'a SurfaceMaps,
    material: &'a Material,
    model: &'a DMat4,
    /// Corner indices of the triangle.
    corners: [u32; 3],
    /// -1 if the face's normals are flipped, else 1.
    turn: f32,
    /// -1 if the model mirrors, else 1.
    mirror: f32,
    /// Set if light is computed at pixels.
    is_lit_by_pixel: bool,
}

/// A pixel: its barycentrics, and its footprint for the corners' u, v.
struct Place<'p, F> {
    barycentrics: [f64; 3],
    footprint: &'p F,
}

/// Returns the value between three corners'; equal corners give exactly theirs.
macro_rules! between {
    ($v:expr, $b:expr) => {
        $v[0] + ($v[1] - $v[0]) * $b[1] + ($v[2] - $v[0]) * $b[2]
    };
}

impl<'a> FaceMaps<'a> {
    /// Returns the maps of a face with this material and these corners, if its draw has any; `turn`
    /// is -1 if its normals are flipped.
    pub fn of(call: &'a DrawCall<'a>, material: &'a Material, corners: [u32; 3], turn: f64) -> Option<Self> {
        let maps = call.maps.filter(|_| material.model != LightingModel::Unlit)?;
        let m = DMat3::from_mat4(call.model);
        let size = m.to_cols_array().iter().fold(0.0f64, |a, v| a.max(v.abs()));
        let is_mirror = size > 0.0 && (m * (1.0 / size)).determinant() < 0.0;
        let mirror = if is_mirror { -1.0 } else { 1.0 };
        let is_lit_by_pixel = matches!(call.shade, ShadeMode::Phong | ShadeMode::Wire);
        let (turn, model) = (turn as f32, &call.model);
        Some(FaceMaps { maps, material, model, corners, turn, mirror, is_lit_by_pixel })
    }

    /// Returns the light at a point, with the normal and the ambient light of the maps.
    pub fn light(
        &self,
        mut point: SurfacePoint,
        barycentrics: [f64; 3],
        footprint: &impl Fn(&[DVec2; 3]) -> Footprint,
        lighting: &Lighting,
    ) -> LitColor {
        let place = Place { barycentrics, footprint };
        if let Some(map) = &self.maps.normal {
            point.normal = self.normal(map, point.normal, &place);
        }
        let mut lit = lighting.at(point, self.material);
        if let Some(map) = &self.maps.occlusion {
            let ambient = lighting.ambient_at(point.position, self.material);
            lit.diffuse_ambient += ambient * (self.ambient_factor(map, &place) - 1.0);
        }
        lit
    }

    /// Returns light that is the same everywhere on the face, with the ambient light of the maps: where
    /// pixels are lit, it is ambient alone.
    pub fn dimmed(
        &self,
        mut lit: LitColor,
        barycentrics: [f64; 3],
        footprint: &impl Fn(&[DVec2; 3]) -> Footprint,
    ) -> LitColor {
        if let Some(map) = self.maps.occlusion.as_ref().filter(|_| self.is_lit_by_pixel) {
            lit.diffuse_ambient *= self.ambient_factor(map, &Place { barycentrics, footprint });
        }
        lit
    }

    /// Replaces the material's emission by that of its map.
    pub fn emit(
        &self,
        lit: &mut LitColor,
        barycentrics: [f64; 3],
        footprint: &impl Fn(&[DVec2; 3]) -> Footprint,
    ) {
        if let Some(map) = &self.maps.emission {
            let [r, g, b, _] = self.texel(map, &Place { barycentrics, footprint });
            lit.specular_emissive += self.material.emissive * (DVec3::new(r, g, b) - DVec3::ONE);
        }
    }

    /// Returns the texel of a map at a pixel.
    fn texel<F: Fn(&[DVec2; 3]) -> Footprint>(&self, map: &SurfaceMap, place: &Place<'_, F>) -> [f64; 4] {
        let uv = self.corners.map(|c| map.texcoords.get(c as usize).copied().unwrap_or(DVec2::ZERO));
        let level = || (place.footprint)(&uv).level(map.texture.width(), map.texture.height());
        sample(&map.texture, map.sampling, between!(uv, place.barycentrics), level)
    }

    /// Returns the factor of the ambient light at a pixel.
    fn ambient_factor<F>(&self, map: &OcclusionMap, place: &Place<'_, F>) -> f64
    where
        F: Fn(&[DVec2; 3]) -> Footprint,
    {
        let [red, ..] = self.texel(&map.map, place);
        encoded(1.0 + map.strength * (red - 1.0)) / map.mean
    }

    /// Returns the normal of the map at a pixel whose interpolated unit normal is `n`.
    fn normal<F>(&self, map: &NormalMap, n: DVec3, place: &Place<'_, F>) -> DVec3
    where
        F: Fn(&[DVec2; 3]) -> Footprint,
    {
        let given = self.corners.map(|c| map.tangents.get(c as usize).copied().unwrap_or(DVec4::ZERO));
        let to_world = |t: DVec4| unit(self.model.transform_vector3(t.truncate())).unwrap_or(DVec3::ZERO);
        let tangents = given.map(to_world);
        let turn = f64::from(self.turn);
        let along = between!(tangents, place.barycentrics) * turn;
        let along = along - n * n.dot(along);
        let Some(tangent) = Some(along).filter(|t| t.length_squared() > VANISHING).and_then(unit) else {
            return n;
        };
        let sign = if given[0].w < 0.0 { -1.0 } else { 1.0 };
        let bitangent = n.cross(tangent) * (sign * turn * f64::from(self.mirror));
        let [r, g, b, _] = self.texel(&map.map, place);
        let (x, y) = ((2.0 * r - 1.0) * map.scale, (2.0 * g - 1.0) * map.scale);
        unit(tangent * x + bitangent * y + n * (2.0 * b - 1.0)).unwrap_or(n)
    }
}

//! Surface maps of one triangle: emission, normals and ambient occlusion, in f64.
//!
//! In: the weights of a pixel and the footprints of the maps' own texture coordinates. Out: every
//! accepted material and normal with which the pixel is lit. Written from the formulas of
//! `fbptr_core::scene::SurfaceMaps`; it shares no code with the pipeline.

use super::double_double::DoubleDouble3;
use super::normals::is_mirrored;
use super::texture::{MipChain, Texel, UvFootprint};
use fbptr_core::math::matrix::unit;
use fbptr_core::scene::{Material, Object, SurfaceMap, SurfaceMaps, Texture};
use glam::{DMat3, DVec2, DVec3, DVec4};
use std::rc::Rc;

/// Largest number of accepted combinations of texels.
const MAX_ANSWERS: usize = 16;

/// A map with the texture coordinates of the triangle's corners.
#[derive(Clone, Debug)]
struct CornerMap<'a> {
    map: &'a SurfaceMap,
    mip_chain: Rc<MipChain>,
    uv: [DVec2; 3],
}

/// Maps of one triangle.
#[derive(Clone, Debug)]
pub struct FaceMaps<'a> {
    maps: &'a SurfaceMaps,
    emission: Option<CornerMap<'a>>,
    normal: Option<CornerMap<'a>>,
    occlusion: Option<CornerMap<'a>>,
    /// World tangents of the corners, turned with the normals.
    tangents: [DVec3; 3],
    /// Sign of the bitangent N x T.
    sign: f64,
}

/// Footprint of texture coordinates given at the corners.
pub type FootprintOf<'f> = &'f dyn Fn(&dyn Fn(usize) -> [f64; 2]) -> UvFootprint;

impl<'a> FaceMaps<'a> {
    /// Returns the maps of the triangle with these corners, if the object has any; `turn` is -1 if its
    /// normals are turned.
    pub fn of(
        object: &'a Object,
        corners: [usize; 3],
        turn: f64,
        mip_chain: &mut impl FnMut(&'a Texture) -> Rc<MipChain>,
    ) -> Option<FaceMaps<'a>> {
        let maps = object.style.maps.as_deref()?;
        let mut at_corners = |map: &'a SurfaceMap| CornerMap {
            map,
            mip_chain: mip_chain(&map.texture),
            uv: corners.map(|c| map.texcoords.get(c).copied().unwrap_or_default()),
        };
        let given = maps.normal.as_ref().map_or([DVec4::ZERO; 3], |normal| {
            corners.map(|c| normal.tangents.get(c).copied().unwrap_or_default())
        });
        let linear = DMat3::from_mat4(object.model);
        let mirror = if is_mirrored(&object.model) { -1.0 } else { 1.0 };
        Some(FaceMaps {
            emission: maps.emission.as_ref().map(&mut at_corners),
            normal: maps.normal.as_ref().map(|n| at_corners(&n.map)),
            occlusion: maps.occlusion.as_ref().map(|o| at_corners(&o.map)),
            tangents: given.map(|t| turn * unit(linear * t.truncate()).unwrap_or_default()),
            sign: if given[0].w < 0.0 { -turn * mirror } else { turn * mirror },
            maps,
        })
    }

    /// Returns the accepted materials and normals at the corners' weights `a`, for the interpolated
    /// normal `n`. `lights_pixels` is false where light was computed at corners or faces: the maps then
    /// change the emission alone.
    pub fn surfaces(
        &self,
        material: &Material,
        n: DVec3,
        a: DoubleDouble3,
        lights_pixels: bool,
        footprint: FootprintOf,
    ) -> Vec<(Material, DVec3)> {
        let texels = |map: &Option<CornerMap>| match map {
            None => vec![[1.0; 4]],
            Some(map) => {
                let uv = std::array::from_fn(|k| {
                    let at = |i: usize| a[i] * map.uv[i][k].into();
                    (at(0) + at(1) + at(2)).to_f64()
                });
                map.mip_chain.sample(map.map.sampling, uv, footprint(&|i| map.uv[i].to_array()))
            }
        };
        let mut found = Vec::new();
        for e in texels(&self.emission) {
            for o in texels(&self.occlusion) {
                for t in texels(&self.normal) {
                    let mut own = material.clone();
                    own.emissive *= DVec3::new(e[0], e[1], e[2]);
                    let mut normal = n;
                    if lights_pixels {
                        own.ka *= self.ambient_factor(o);
                        normal = self.mapped(n, a.map(|w| w.to_f64()), t);
                    }
                    found.push((own, normal));
                }
            }
        }
        found.truncate(MAX_ANSWERS);
        found
    }

    fn ambient_factor(&self, [red, ..]: Texel) -> f64 {
        let Some(map) = &self.maps.occlusion else { return 1.0 };
        let linear = (1.0 + map.strength * (red - 1.0)).max(0.0);
        let encoded =
            if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 };
        encoded / map.mean
    }

    /// Returns the normal that a texel means.
    fn mapped(&self, n: DVec3, a: [f64; 3], [r, g, b, _]: Texel) -> DVec3 {
        let Some(map) = &self.maps.normal else { return n };
        let t = self.tangents[0] * a[0] + self.tangents[1] * a[1] + self.tangents[2] * a[2];
        let t = t - n.dot(t) * n;
        if t.length() < 1e-12 {
            return n;
        }
        let t = t / t.length();
        let frame = DMat3::from_cols(t, self.sign * n.cross(t), n);
        let direction = DVec3::new((2.0 * r - 1.0) * map.scale, (2.0 * g - 1.0) * map.scale, 2.0 * b - 1.0);
        unit(frame * direction).unwrap_or(n)
    }
}

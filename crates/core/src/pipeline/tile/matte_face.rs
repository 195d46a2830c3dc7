//! Matte faces under directional lights that were set up in f64: what is the same for all their pixels
//! is looked up once.
//!
//! No grid of light is made for them: under one to four lights a cube takes as long with grids, under
//! eight a tenth longer or more.
//!
//! In: a face whose light depends on nothing but its interpolated normal. Out: the bytes of
//! [`Faces::exact_face`], bit by bit.

use super::attribute_fetch::{Corners, blend};
use super::exact_faces::{self, ExactFace};
use super::face_tables::Faces;
use super::interpolate::{add, unit_normal};
use super::lighting::{MaterialLighting, light_by_normal, pack, splat3};
use super::shading_state::ColorSource;
use crate::simd::{F32, Simd};

/// A face, and what its light is computed from.
#[derive(Clone, Copy)]
pub(super) struct MatteFace<'a> {
    face: &'a ExactFace,
    lighting: &'a MaterialLighting,
    /// Normals of the corners.
    normals: [[f32; 4]; 3],
    /// Colours of the corners, which multiply the light; `None` for white ones.
    colors: Option<[[f32; 4]; 3]>,
}

impl<'a> MatteFace<'a> {
    /// Creates the matte face that a face is; `None` for others.
    #[inline(never)]
    pub fn new(faces: &Faces<'a>, face: &'a ExactFace) -> Option<Self> {
        let (shading, binding) = (faces.shading, faces.binding_of(face));
        let (shader, lighting) = (&shading.shader, &binding.lighting);
        let ColorSource::Pixels(normals) = shader.source else { return None };
        let nothing_else = shader.fog.is_none()
            && !shading.is_affine
            && binding.texture.is_none()
            && !lighting.lights.is_empty();
        let corners = faces.vertices(face.face as usize);
        // Gentle faces are not cut.
        (nothing_else && !lighting.needs_place && face.is_gentle).then(|| MatteFace {
            face,
            lighting,
            normals: corners.map(|vertex| normals[vertex]),
            colors: (!shader.colors.is_empty()).then(|| corners.map(|vertex| shader.colors[vertex])),
        })
    }

    /// Returns the packed colours of LANES pixels from (x, y) on, x a multiple of LANES, and the lanes
    /// where f32 lacks the digits.
    #[inline(always)]
    pub fn colors<S: Simd>(&self, s: S, at: [i32; 2]) -> (S::I, S::M) {
        let b = exact_faces::gentle_weights(s, self.face, at);
        let p = exact_faces::clamped(s, self.face, b);
        let sum = (p[0] + p[1]) + p[2];
        let inverse = s.splat(1.0) / sum;
        let b = [p[0] * inverse, p[1] * inverse, p[2] * inverse];
        let all = s.mask(u32::MAX);
        let normal = blend(s, all, &self.normals, &Corners::One([0, 1, 2]), b);
        let turn = s.mask(if self.face.is_normal_flipped { u32::MAX } else { 0 });
        let (normal, cancels) = unit_normal(s, normal, turn);
        let mut diffuse = light_by_normal(s, self.lighting, normal);
        if let Some(colors) = &self.colors {
            let color = blend(s, all, colors, &Corners::One([0, 1, 2]), b);
            diffuse = [diffuse[0] * color[0], diffuse[1] * color[1], diffuse[2] * color[2]];
        }
        let color = pack(s, add::<S>(diffuse, splat3(s, self.lighting.specular)));
        (color, cancels | !s.splat(exact_faces::LEAST_SUM).lt(sum))
    }
}

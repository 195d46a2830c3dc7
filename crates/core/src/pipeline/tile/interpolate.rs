//! Interpolation of attributes by barycentrics, then lighting, texturing and fog, a vector of
//! pixels at a time, for all kinds of faces.

use super::attribute_fetch::{Corners, blend, gather3};
use super::lighting::{MaterialLighting, V3, dot, light, light_by_normal, pack, scale, splat3};
use super::sampler::{SampleCoord, TextureSampler, UvDerivatives};
use super::shading_state::{ColorSource, Eye, FragmentShader};
use crate::simd::{F32, I32, Simd};

/// Barycentrics of a vector of pixels on the faces that they show.
pub(super) struct Barycentrics<S: Simd> {
    /// e_i / w_i, not yet divided by their sum; all negative where a face is seen from its other
    /// side.
    pub p: [S::F; 3],
    /// `p` at the pixel on the right, if a texture needs it; not clamped to the face.
    pub right: [S::F; 3],
    /// `p` at the pixel below, likewise.
    pub below: [S::F; 3],
    /// 1 / the sum of `p`, with its sign.
    pub inverse: S::F,
    /// Depth w of the pixel, positive.
    pub w: S::F,
}

/// Inputs of a vector of fragments to lighting.
pub(super) struct FragmentInputs<'f, S: Simd> {
    /// Faces that the fragments show.
    pub faces: S::I,
    /// Vertices of those faces.
    pub corners: Corners<'f, S>,
    /// Weights of the corners at each pixel.
    pub barycentrics: Barycentrics<S>,
    /// Lanes whose normals are flipped.
    pub turn: S::M,
    /// Pixel columns and rows.
    pub at: (S::I, S::I),
}

/// Lit colour of a vector of pixels, before texture and fog.
#[derive(Clone, Copy)]
pub struct ReflectedLight<S: Simd> {
    /// Part that a texture multiplies.
    pub diffuse: V3<S>,
    /// Part that a texture does not multiply.
    pub specular: V3<S>,
    /// Position in the fog's space; 0 without fog.
    pub position: V3<S>,
}

impl FragmentShader<'_> {
    /// Multiplies the light of pixels by the texels that they show; returns the lanes where f32 lacks
    /// the digits.
    #[inline(always)]
    pub(super) fn texture<S: Simd>(
        &self,
        s: S,
        mask: S::M,
        texture: &TextureSampler<'_>,
        inputs: &FragmentInputs<'_, S>,
        lit: &mut ReflectedLight<S>,
    ) -> S::M {
        let sample_coord = self.sample_coord(s, mask, texture, inputs);
        let texel_addresses = texture.texel_addresses(s, mask, &sample_coord);
        lit.multiply(texture.texel(s, mask, &sample_coord, &texel_addresses));
        texel_addresses.needs_f64()
    }

    /// Returns the light of pixels that show a material, and the lanes where f32 lacks the digits.
    #[inline(always)]
    pub(super) fn lit<S: Simd>(
        &self,
        s: S,
        mask: S::M,
        lighting: &MaterialLighting,
        inputs: &FragmentInputs<'_, S>,
    ) -> (ReflectedLight<S>, S::M) {
        let mut needs_f64 = s.mask(0);
        let b = inputs.barycentrics.weights();
        // One call for either table: all of this is compiled in line, for each width.
        let table = match self.source {
            ColorSource::Vertices(table, _) => table,
            ColorSource::Pixels(normals) if !lighting.lights.is_empty() => normals,
            _ => &[],
        };
        let blended = match table.is_empty() {
            true => [s.splat(0.0); 3],
            false => blend(s, mask, table, &inputs.corners, b),
        };
        let (mut diffuse, specular) = match self.source {
            ColorSource::Constant => (splat3(s, lighting.diffuse), splat3(s, lighting.specular)),
            ColorSource::Faces(diffuse, specular) => {
                let [r, g, b, _] = s.gather4(mask, diffuse, inputs.faces);
                let specular = match specular.is_empty() {
                    true => [s.splat(0.0); 3],
                    false => {
                        let [r, g, b, _] = s.gather4(mask, specular, inputs.faces);
                        [r, g, b]
                    }
                };
                ([r, g, b], specular)
            }
            ColorSource::Vertices(_, specular) => {
                let specular = match specular.is_empty() {
                    true => [s.splat(0.0); 3],
                    false => blend(s, mask, specular, &inputs.corners, b),
                };
                (blended, specular)
            }
            ColorSource::Pixels(_) if lighting.lights.is_empty() => {
                (splat3(s, lighting.diffuse), splat3(s, lighting.specular))
            }
            ColorSource::Pixels(_) => {
                let ([diffuse, specular], off) = self.lit_along(s, mask, lighting, inputs, blended);
                needs_f64 = off;
                (diffuse, specular)
            }
        };
        if !self.colors.is_empty() {
            let color = blend(s, mask, self.colors, &inputs.corners, b);
            diffuse = [diffuse[0] * color[0], diffuse[1] * color[1], diffuse[2] * color[2]];
        }
        let position = self.fog_position(s, mask, inputs, b);
        (ReflectedLight { diffuse, specular, position }, needs_f64)
    }

    /// Returns the diffuse and the specular part of the light of pixels with these normals, of any
    /// length, and the lanes where f32 lacks the digits.
    #[inline(always)]
    pub(super) fn lit_along<S: Simd>(
        &self,
        s: S,
        mask: S::M,
        lighting: &MaterialLighting,
        inputs: &FragmentInputs<'_, S>,
        normal: V3<S>,
    ) -> ([V3<S>; 2], S::M) {
        let (normal, cancels) = unit_normal(s, normal, inputs.turn);
        let needs_f64 = mask & cancels;
        if !lighting.needs_place {
            return ([light_by_normal(s, lighting, normal), splat3(s, lighting.specular)], needs_f64);
        }
        let (position, to_viewer) = self.position_and_viewer(s, mask, inputs, inputs.barycentrics.weights());
        let lit = light(s, lighting, position, normal, to_viewer);
        ([lit.diffuse, lit.specular], needs_f64 | (lit.needs_f64 & mask))
    }

    /// Returns the positions of pixels in shading space, and the unit vectors to the viewer; `b` are
    /// the corners' weights.
    #[inline(always)]
    fn position_and_viewer<S: Simd>(
        &self,
        s: S,
        mask: S::M,
        inputs: &FragmentInputs<'_, S>,
        b: [S::F; 3],
    ) -> (V3<S>, V3<S>) {
        if let Eye::Perspective { ray } = self.eye {
            let ray = ray_at(s, ray, inputs.at.0, inputs.at.1);
            let back = s.splat(-1.0) / dot::<S>(ray, ray).sqrt();
            return (scale::<S>(ray, inputs.barycentrics.w), scale::<S>(ray, back));
        }
        let position = blend(s, mask, self.positions, &inputs.corners, b);
        let to_viewer = match self.eye {
            Eye::Parallel { to_viewer } => splat3(s, to_viewer),
            _ => scale::<S>(position, s.splat(-1.0) / dot::<S>(position, position).sqrt()),
        };
        (position, to_viewer)
    }

    /// Returns the positions of pixels in the fog's space, 0 without fog.
    #[inline(always)]
    fn fog_position<S: Simd>(&self, s: S, mask: S::M, inputs: &FragmentInputs<'_, S>, b: [S::F; 3]) -> V3<S> {
        match (&self.fog, self.eye) {
            (None, _) => [s.splat(0.0); 3],
            (Some(_), Eye::Perspective { ray }) => {
                scale::<S>(ray_at(s, ray, inputs.at.0, inputs.at.1), inputs.barycentrics.w)
            }
            (Some(_), _) => blend(s, mask, self.fog_positions, &inputs.corners, b),
        }
    }

    /// Returns the coordinates at which pixels sample a texture.
    #[inline(always)]
    pub(super) fn sample_coord<S: Simd>(
        &self,
        s: S,
        mask: S::M,
        texture: &TextureSampler<'_>,
        inputs: &FragmentInputs<'_, S>,
    ) -> SampleCoord<S> {
        let (barycentrics, zero) = (&inputs.barycentrics, s.splat(0.0));
        let b = barycentrics.weights();
        let [t0, t1, t2] = gather3(s, mask, self.texcoords, &inputs.corners);
        // Relative to the first corner, so that coordinates far from 0 keep their digits.
        let ([u1, v1], [u2, v2]) = (between::<S>(t0, t1), between::<S>(t0, t2));
        let here = [b[1] * u1 + b[2] * u2, b[1] * v1 + b[2] * v2];
        let footprint = match texture.needs_level() {
            false => None,
            true => {
                let (right, rs) = run_of(s, barycentrics.right, (u1, u2), (v1, v2));
                let (below, bs) = run_of(s, barycentrics.below, (u1, u2), (v1, v2));
                // The sign is that of the pixel's own sum unless the face's plane reaches the
                // horizon between them.
                let is_horizon =
                    mask & !(zero.lt(rs * barycentrics.inverse) & zero.lt(bs * barycentrics.inverse));
                Some(UvDerivatives {
                    right: [right[0] - here[0], right[1] - here[1]],
                    below: [below[0] - here[0], below[1] - here[1]],
                    is_horizon,
                })
            }
        };
        texture.sample_coord(s, [[t0[0], t0[1]], [t0[2], t0[3]]], here, footprint)
    }

    /// Applies fog and packs the colours.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(&self, s: S, lit: &ReflectedLight<S>) -> S::I {
        pack(s, self.color(s, lit))
    }

    /// Returns the colours, under fog if there is any.
    #[inline(always)]
    pub(super) fn color<S: Simd>(&self, s: S, lit: &ReflectedLight<S>) -> V3<S> {
        let color = lit.sum();
        match &self.fog {
            None => color,
            Some(fog) => fog.over(s, color, lit.position),
        }
    }
}

impl<S: Simd> Barycentrics<S> {
    /// Creates the barycentrics with these values of `p`, for pixels without neighbours.
    #[inline(always)]
    pub fn new(p: [S::F; 3], inverse: S::F) -> Self {
        Barycentrics { p, right: p, below: p, inverse, w: inverse }
    }

    /// Returns the corners' weights, which sum to 1.
    #[inline(always)]
    pub fn weights(&self) -> [S::F; 3] {
        [self.p[0] * self.inverse, self.p[1] * self.inverse, self.p[2] * self.inverse]
    }
}

impl<S: Simd> ReflectedLight<S> {
    /// Multiplies the diffuse part by the texels' colours.
    #[inline(always)]
    pub fn multiply(&mut self, texel: V3<S>) {
        self.diffuse = [self.diffuse[0] * texel[0], self.diffuse[1] * texel[1], self.diffuse[2] * texel[2]];
    }

    /// Returns the sum of both parts.
    #[inline(always)]
    pub fn sum(&self) -> V3<S> {
        add::<S>(self.diffuse, self.specular)
    }
}

/// Returns unit normals, those of `turn` flipped, and the lanes whose normals cancel: they fall back to
/// the face's, in f64.
#[inline(always)]
pub(super) fn unit_normal<S: Simd>(s: S, normal: V3<S>, turn: S::M) -> (V3<S>, S::M) {
    let length2 = dot::<S>(normal, normal);
    let inverse = s.splat(1.0) / length2.sqrt();
    let inverse = s.select(turn, s.splat(0.0) - inverse, inverse);
    (scale::<S>(normal, inverse), !s.splat(1e-4).le(length2))
}

/// Returns the eye's ray through pixels, scaled so that a point is at ray * w.
#[inline(always)]
fn ray_at<S: Simd>(s: S, ray: [[f32; 3]; 3], column: S::I, row: S::I) -> V3<S> {
    let (column, row) = (column.to_f32(), row.to_f32());
    [
        s.splat(ray[0][0]) + (s.splat(ray[1][0]) * column + s.splat(ray[2][0]) * row),
        s.splat(ray[0][1]) + (s.splat(ray[1][1]) * column + s.splat(ray[2][1]) * row),
        s.splat(ray[0][2]) + (s.splat(ray[1][2]) * column + s.splat(ray[2][2]) * row),
    ]
}

// Helpers are functions marked for inlining, not closures: a closure would be compiled without the
// level's instructions.

/// Returns u, v relative to the first corner at these barycentrics, and the sum of `p`.
#[inline(always)]
fn run_of<S: Simd>(s: S, p: [S::F; 3], u: (S::F, S::F), v: (S::F, S::F)) -> ([S::F; 2], S::F) {
    let sum = (p[0] + p[1]) + p[2];
    let inverse = s.splat(1.0) / sum;
    let (b1, b2) = (p[1] * inverse, p[2] * inverse);
    ([b1 * u.0 + b2 * u.1, b1 * v.0 + b2 * v.1], sum)
}

/// Returns the difference of texture coordinates, both in two parts.
#[inline(always)]
fn between<S: Simd>(from: [S::F; 4], to: [S::F; 4]) -> [S::F; 2] {
    [(to[0] - from[0]) + (to[2] - from[2]), (to[1] - from[1]) + (to[3] - from[3])]
}

/// Returns a + b.
#[inline(always)]
pub(super) fn add<S: Simd>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

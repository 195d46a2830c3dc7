//! From shares to colours: attributes, light, texture and fog of a vector of pixels, the same for all kinds of faces.

use super::corners::{Corners, blend, gather3};
use super::faces::Faces;
use super::light::{V3, dot, light, pack, scale, splat3};
use super::shading::{Eye, Source, Surface};
use super::texture::{Footprint, Spot, TextureShade};
use crate::simd::{F32, I32, Mask, Simd};

/// The weights of a vector of pixels: of this face or these faces, how its corners share in each.
pub(super) struct Shares<S: Simd> {
    /// e_i / w_i, not yet divided by their sum: all of them below 0 where a face is seen from its other side.
    pub p: [S::F; 3],
    /// `p` at the pixel on the right and at the one below, where a texture asks; not clamped to the face.
    pub right: [S::F; 3],
    pub below: [S::F; 3],
    /// 1 / the sum of `p`, with its sign.
    pub inverse: S::F,
    /// The pixel's w, above 0.
    pub w: S::F,
}

/// What is known of a vector of pixels before their light.
pub(super) struct Weighed<'f, S: Simd> {
    /// The faces that they show.
    pub faces: S::I,
    /// The numbers of those faces' surfaces.
    pub surfaces: S::I,
    /// The corners of those faces.
    pub corners: Corners<'f, S>,
    /// How the corners share in each pixel.
    pub shares: Shares<S>,
    /// Whose normals are turned.
    pub turn: S::M,
    /// Columns and rows.
    pub at: (S::I, S::I),
}

/// Light, before texture and fog.
#[derive(Clone, Copy)]
pub struct Reflected<S: Simd> {
    /// What a texture multiplies.
    pub matte: V3<S>,
    /// What it does not.
    pub gloss: V3<S>,
    /// In the shading frame, where there is fog.
    pub position: V3<S>,
}

impl Faces<'_> {
    /// Colours at once, and where f32 lacks the digits.
    #[inline(always)]
    pub(super) fn shade<S: Simd>(&self, s: S, mask: S::M, weighed: &Weighed<'_, S>) -> (S::I, S::M) {
        let surfaces = self.shading.surfaces;
        // One surface after the other; mostly there is one in a vector. One call for all of them: it is compiled where it stands.
        let is_only = surfaces.len() == 1;
        let mut numbers = [0; 16];
        if !is_only {
            s.store_i(weighed.surfaces, &mut numbers[..S::LANES]);
        }
        let (mut color, mut delicate, mut left) = (s.splat_i(0), s.mask(0), mask);
        while left.any() {
            let (mut number, mut same) = (0, left);
            if !is_only {
                number = numbers[left.bits().trailing_zeros() as usize];
                same = left & weighed.surfaces.eq(s.splat_i(number));
            }
            left = left & !same;
            let (own, d) = self.shade_surface(s, same, &surfaces[number as usize], weighed);
            color = s.select_i(same, own, color);
            delicate = delicate | (d & same);
        }
        (color, delicate)
    }

    #[inline(always)]
    fn shade_surface<S: Simd>(
        &self,
        s: S,
        mask: S::M,
        surface: &Surface<'_>,
        weighed: &Weighed<'_, S>,
    ) -> (S::I, S::M) {
        let (mut lit, mut delicate) = self.lit(s, mask, surface, weighed);
        if let Some(texture) = &surface.texture {
            let spot = self.spot(s, mask, texture, weighed);
            let aim = texture.aim(s, mask, &spot);
            delicate = delicate | aim.delicate();
            lit.multiply(texture.texel(s, mask, &spot, &aim));
        }
        (self.finish(s, &lit), delicate)
    }

    /// The light of pixels that show this surface, and where f32 lacks the digits.
    #[inline(always)]
    pub(super) fn lit<S: Simd>(
        &self,
        s: S,
        mask: S::M,
        surface: &Surface<'_>,
        weighed: &Weighed<'_, S>,
    ) -> (Reflected<S>, S::M) {
        let Weighed { faces, corners, shares, turn, at: (column, row), .. } = weighed;
        let (column, row) = (*column, *row);
        let shading = self.shading;
        let lighting = &surface.lighting;
        let mut delicate = s.mask(0);
        let b = shares.weights();
        let zero = s.splat(0.0);
        // Found once, wherever it is asked for: gathering takes much code.
        let is_lit_here = matches!(shading.source, Source::Pixels(_)) && !lighting.lights.is_empty();
        let position = match (is_lit_here || shading.haze.is_some(), shading.eye) {
            (false, _) => [zero; 3],
            (true, Eye::Perspective { ray }) if !shading.is_affine => {
                scale::<S>(ray_at(s, ray, column, row), shares.w)
            }
            (true, _) => blend(s, mask, shading.positions, corners, b),
        };
        let (mut matte, gloss) = match shading.source {
            Source::Constant => (splat3(s, lighting.matte), splat3(s, lighting.gloss)),
            Source::Faces(matte, gloss) => {
                let [r, g, b, _] = s.gather4(mask, matte, *faces);
                let gloss = match gloss.is_empty() {
                    true => [zero; 3],
                    false => {
                        let [r, g, b, _] = s.gather4(mask, gloss, *faces);
                        [r, g, b]
                    }
                };
                ([r, g, b], gloss)
            }
            Source::Vertices(matte, gloss) => {
                let matte = blend(s, mask, matte, corners, b);
                let gloss = if gloss.is_empty() { [zero; 3] } else { blend(s, mask, gloss, corners, b) };
                (matte, gloss)
            }
            Source::Pixels(_) if lighting.lights.is_empty() => {
                (splat3(s, lighting.matte), splat3(s, lighting.gloss))
            }
            Source::Pixels(normals) => {
                let n = blend(s, mask, normals, corners, b);
                let length2 = dot::<S>(n, n);
                // Normals that cancel fall back to the face's, in f64.
                delicate = mask & !s.splat(1e-4).le(length2);
                let n_inverse = s.splat(1.0) / length2.sqrt();
                let n_inverse = s.select(*turn, zero - n_inverse, n_inverse);
                let normal = scale::<S>(n, n_inverse);
                // V points back along the eye's ray.
                let to_viewer = match shading.eye {
                    Eye::Perspective { ray } => {
                        let along = match shading.is_affine {
                            false => ray_at(s, ray, column, row),
                            true => position,
                        };
                        scale::<S>(along, s.splat(-1.0) / dot::<S>(along, along).sqrt())
                    }
                    Eye::Parallel { to_viewer } => splat3(s, to_viewer),
                };
                let lit = light(s, lighting, position, normal, to_viewer);
                delicate = delicate | (lit.delicate & mask);
                (lit.matte, lit.gloss)
            }
        };
        if !shading.colors.is_empty() {
            let color = blend(s, mask, shading.colors, corners, b);
            matte = [matte[0] * color[0], matte[1] * color[1], matte[2] * color[2]];
        }
        (Reflected { matte, gloss, position }, delicate)
    }

    /// Where pixels look into a texture.
    #[inline(always)]
    pub(super) fn spot<S: Simd>(
        &self,
        s: S,
        mask: S::M,
        texture: &TextureShade<'_>,
        weighed: &Weighed<'_, S>,
    ) -> Spot<S> {
        let (shares, zero) = (&weighed.shares, s.splat(0.0));
        let b = shares.weights();
        let [t0, t1, t2] = gather3(s, mask, self.shading.texcoords, &weighed.corners);
        // Relative to the first corner, so that coordinates far from 0 keep their digits.
        let ([u1, v1], [u2, v2]) = (between::<S>(t0, t1), between::<S>(t0, t2));
        let here = [b[1] * u1 + b[2] * u2, b[1] * v1 + b[2] * v2];
        let footprint = match texture.needs_level() {
            false => None,
            true => {
                let (right, rs) = run_of(s, shares.right, (u1, u2), (v1, v2));
                let (below, bs) = run_of(s, shares.below, (u1, u2), (v1, v2));
                // Their sign is that of the pixel's own sum unless the face's plane runs to the horizon between them.
                let is_horizon = mask & !(zero.lt(rs * shares.inverse) & zero.lt(bs * shares.inverse));
                Some(Footprint {
                    right: [right[0] - here[0], right[1] - here[1]],
                    below: [below[0] - here[0], below[1] - here[1]],
                    is_horizon,
                })
            }
        };
        texture.spot(s, [[t0[0], t0[1]], [t0[2], t0[3]]], here, footprint)
    }

    /// Packed colours.
    #[inline(always)]
    pub(super) fn finish<S: Simd>(&self, s: S, lit: &Reflected<S>) -> S::I {
        let color = add::<S>(lit.matte, lit.gloss);
        match &self.shading.haze {
            None => pack(s, color),
            Some(haze) => pack(s, haze.over(s, color, lit.position)),
        }
    }
}

impl<S: Simd> Shares<S> {
    /// The corners' weights: their sum is 1.
    #[inline(always)]
    fn weights(&self) -> [S::F; 3] {
        [self.p[0] * self.inverse, self.p[1] * self.inverse, self.p[2] * self.inverse]
    }
}

impl<S: Simd> Reflected<S> {
    /// Takes the texels' colours on.
    #[inline(always)]
    pub fn multiply(&mut self, texel: V3<S>) {
        self.matte = [self.matte[0] * texel[0], self.matte[1] * texel[1], self.matte[2] * texel[2]];
    }
}

/// The eye's ray through pixels, from which a point is w times as far.
#[inline(always)]
fn ray_at<S: Simd>(s: S, ray: [[f32; 3]; 3], column: S::I, row: S::I) -> V3<S> {
    let (column, row) = (column.to_f32(), row.to_f32());
    [
        s.splat(ray[0][0]) + (s.splat(ray[1][0]) * column + s.splat(ray[2][0]) * row),
        s.splat(ray[0][1]) + (s.splat(ray[1][1]) * column + s.splat(ray[2][1]) * row),
        s.splat(ray[0][2]) + (s.splat(ray[1][2]) * column + s.splat(ray[2][2]) * row),
    ]
}

// Helpers are functions marked for inlining, not closures: a closure would be compiled without the level's instructions.

/// u, v relative to the first corner where the shares are these, and their sum.
#[inline(always)]
fn run_of<S: Simd>(s: S, p: [S::F; 3], u: (S::F, S::F), v: (S::F, S::F)) -> ([S::F; 2], S::F) {
    let sum = (p[0] + p[1]) + p[2];
    let inverse = s.splat(1.0) / sum;
    let (b1, b2) = (p[1] * inverse, p[2] * inverse);
    ([b1 * u.0 + b2 * u.1, b1 * v.0 + b2 * v.1], sum)
}

/// From texture coordinates to others, both in two parts.
#[inline(always)]
fn between<S: Simd>(from: [S::F; 4], to: [S::F; 4]) -> [S::F; 2] {
    [(to[0] - from[0]) + (to[2] - from[2]), (to[1] - from[1]) + (to[3] - from[3])]
}

#[inline(always)]
pub(super) fn add<S: Simd>(a: V3<S>, b: V3<S>) -> V3<S> {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

//! Texture of a blended face: sampled exactly enough for the plain path's bytes.
//!
//! Barycentrics and u, v are computed in f64 along a row, all lanes together; the texels are then
//! sampled by the plain path's own function. Where a decision (which texel, which level) is too
//! near to its threshold for two computations in f64 to agree, the pixel is left to the plain path.
//!
//! The sampler of deferred shading, in f32, cannot decide these bytes: on 256 texels its bilinear
//! weights err by up to 256 / 2^24, 0.004 of a byte, while blending leaves to f64 what is within
//! 0.001 of the next byte.

use super::exact_faces::{self, ExactFace};
use crate::pipeline::sampler::{Footprint, sample};
use crate::scene::{Filter, Sampling, Texture, Wrap};
use crate::simd::{Mask, Simd};
use glam::DVec2;

/// Texture on a face.
#[derive(Clone, Copy, Debug)]
pub struct BlendedTexture<'a> {
    /// Texture to sample.
    pub texture: &'a Texture,
    /// Filter and wrapping.
    pub sampling: Sampling,
    /// Texture coordinates u, v of the corners.
    pub uv: [DVec2; 3],
}

/// Distance from the edge of a texel or of a level within which the two paths may disagree, in
/// texels or levels.
const EDGE: f64 = 1e-7;

impl BlendedTexture<'_> {
    /// Returns R, G, B, A in 0..1 at LANES pixels from (x, y) on, where `mask` is set, and the
    /// lanes that the plain path must compute.
    #[inline(always)]
    pub fn texels<S: Simd>(
        &self,
        s: S,
        exact_face: &ExactFace,
        mask: S::M,
        x: i32,
        y: i32,
    ) -> ([S::F; 4], S::M) {
        let b = exact_faces::barycentrics::<S>(exact_face, x, y);
        let (mut us, mut vs) = ([0.0f64; 16], [0.0f64; 16]);
        let [from, u1, u2] = [self.uv[0], self.uv[1] - self.uv[0], self.uv[2] - self.uv[0]];
        for i in 0..S::LANES {
            let sum = b[0][i] + b[1][i] + b[2][i];
            let (s1, s2) = (b[1][i] / sum, b[2][i] / sum);
            us[i] = u1.x * s1 + u2.x * s2;
            vs[i] = u1.y * s1 + u2.y * s2;
        }
        let mut out = [[0f32; 16]; 4];
        let (mut off, mut left) = (0, mask.bits());
        while left != 0 {
            let i = left.trailing_zeros() as usize;
            left &= left - 1;
            let weights = [b[0][i], b[1][i], b[2][i]];
            // Beside the face the plain path clamps barycentrics in its own way.
            let is_inside = weights.iter().all(|b| *b >= 0.0);
            match self.texel(exact_face, weights, DVec2::new(us[i], vs[i]), from).filter(|_| is_inside) {
                Some(texel) => out.iter_mut().zip(texel).for_each(|(out, c)| out[i] = c as f32),
                None => off |= 1 << i,
            }
        }
        (out.map(|lanes| s.load(&lanes[..S::LANES])), s.mask(off))
    }

    /// Returns the texel of one pixel; `None` near an edge.
    fn texel(&self, exact_face: &ExactFace, b: [f64; 3], here: DVec2, from: DVec2) -> Option<[f64; 4]> {
        let (texture, sampling) = (self.texture, self.sampling);
        let at = from + here;
        let level = match sampling.filter {
            Filter::Nearest => {
                let near = |c: f64, wrap, size: u32| {
                    let c = if wrap == Wrap::Repeat { c - c.floor() } else { c } * f64::from(size);
                    (c - (c + 0.5).floor()).abs() < EDGE * (1.0 + c.abs())
                };
                let is_edge = near(at.x, sampling.wrap_s, texture.width())
                    || near(at.y, sampling.wrap_t, texture.height());
                if is_edge {
                    return None;
                }
                0.0
            }
            Filter::Bilinear => 0.0,
            Filter::Mipmap | Filter::Trilinear => {
                let d = self.footprint(exact_face, b, here).level(texture.width(), texture.height());
                let from_edge = (d - d.floor() - 0.5).abs();
                if sampling.filter == Filter::Mipmap && d.is_finite() && from_edge < EDGE {
                    return None;
                }
                d
            }
        };
        Some(sample(texture, sampling, at, || level))
    }

    /// Returns the steps of u, v to the pixel on the right and to the one below.
    fn footprint(&self, exact_face: &ExactFace, b: [f64; 3], here: DVec2) -> Footprint {
        let [u1, u2] = [self.uv[1] - self.uv[0], self.uv[2] - self.uv[0]];
        let at = |axis: usize| {
            let barycentrics = &exact_face.plane.barycentrics;
            let [b0, b1, b2] = [0, 1, 2].map(|k| b[k] + barycentrics[k][axis]);
            let sum = b0 + b1 + b2;
            (sum > 0.0).then(|| u1 * (b1 / sum) + u2 * (b2 / sum) - here)
        };
        match (at(1), at(2)) {
            (Some(right), Some(below)) => Footprint::Steps(right, below),
            _ => Footprint::Horizon,
        }
    }
}

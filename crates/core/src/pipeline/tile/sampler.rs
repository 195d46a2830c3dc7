//! Texture sampling for a vector of pixels: `pipeline::sampler` in f32.
//!
//! Coordinates are given as those of a corner, in two parts, and the offset from it: whole repeats
//! are dropped before digits are lost.

use super::lighting::{V3, log2, scale, splat3};
use super::texel_fetch::{FixedPointMips, TexelQuad, between, bilinear, nearest};
use crate::scene::{Filter, Sampling, Texture, Wrap};
use crate::simd::{F32, I32, Mask, Simd};

/// Distance from a level's edge within which `mipmap` leaves the pixel to the plain path: the level
/// is accurate to about 1e-4.
const LEVEL_EDGE: f32 = 1e-3;

/// Squared footprint of a pixel that reaches the horizon: larger than that of any texture.
const HORIZON: f32 = (1u128 << 126) as f32;

/// Texture with its sampling state.
#[derive(Clone, Copy, Debug)]
pub struct TextureSampler<'a> {
    /// Texture to sample, without transparent texels.
    pub texture: &'a Texture,
    /// Filter and wrapping.
    pub sampling: Sampling,
    /// Mip levels of the texture in fixed point.
    fixed: FixedPointMips<'a>,
}

impl<'a> TextureSampler<'a> {
    /// Creates a sampler of `texture`.
    pub fn new(texture: &'a Texture, sampling: Sampling) -> Self {
        Self { texture, sampling, fixed: FixedPointMips::new(texture.fixed_levels()) }
    }

    /// Returns whether the filter uses mip levels.
    #[inline(always)]
    pub fn needs_level(&self) -> bool {
        matches!(self.sampling.filter, Filter::Mipmap | Filter::Trilinear)
    }
}

/// Screen-space derivatives of u, v.
pub struct UvDerivatives<S: Simd> {
    /// Difference to pixel (x + 1, y).
    pub right: [S::F; 2],
    /// Difference to pixel (x, y + 1).
    pub below: [S::F; 2],
    /// Lanes for which one of these pixels lies beyond the horizon.
    pub is_horizon: S::M,
}

/// Coordinates at which pixels sample a texture.
#[derive(Clone, Copy)]
pub struct SampleCoord<S: Simd> {
    /// Coordinates without whole repeats.
    u: S::F,
    v: S::F,
    /// Squared length of the longer derivative in texels, if the filter uses levels.
    footprint: S::F,
}

/// Texels that pixels will read from the levels of a texture. They are computed before any is read,
/// so that the reads of several vectors overlap.
#[derive(Clone, Copy)]
pub struct TexelAddresses<S: Simd> {
    /// Mip level, if the filter uses levels; otherwise no field is meaningful.
    level: S::F,
    /// Fraction of the way to the next level.
    part: S::F,
    /// Lanes whose texels are all in fixed point; these texels, of their level and of the next.
    is_fixed: S::M,
    quads: [TexelQuad<S>; 2],
    /// Lanes too near to a level's edge for f32.
    needs_f64: S::M,
}

impl<S: Simd> SampleCoord<S> {
    /// Returns the coordinates of the first texel.
    #[inline(always)]
    pub fn origin(s: S) -> Self {
        let zero = s.splat(0.0);
        Self { u: zero, v: zero, footprint: zero }
    }

    #[inline(always)]
    fn coordinates(&self) -> [S::F; 2] {
        [self.u, self.v]
    }
}

impl<S: Simd> TexelAddresses<S> {
    /// Returns the addresses of no texels.
    #[inline(always)]
    pub fn none(s: S) -> Self {
        let zero = s.splat(0.0);
        Self {
            level: zero,
            part: zero,
            is_fixed: s.mask(0),
            quads: [TexelQuad::none(s); 2],
            needs_f64: s.mask(0),
        }
    }

    /// Returns the lanes where f32 lacks the digits.
    #[inline(always)]
    pub fn needs_f64(&self) -> S::M {
        self.needs_f64
    }
}

impl TextureSampler<'_> {
    /// Returns the coordinates `origin` (u, v, and their rounding errors) + `away`.
    #[inline(always)]
    pub fn sample_coord<S: Simd>(
        &self,
        s: S,
        origin: [[S::F; 2]; 2],
        away: [S::F; 2],
        footprint: Option<UvDerivatives<S>>,
    ) -> SampleCoord<S> {
        let (texture, sampling) = (self.texture, self.sampling);
        let u = turns(s, origin[0][0], origin[1][0], away[0], sampling.wrap_s);
        let v = turns(s, origin[0][1], origin[1][1], away[1], sampling.wrap_t);
        let footprint = match footprint {
            None => s.splat(0.0),
            Some(footprint) => {
                let (w, h) = (s.splat(texture.width() as f32), s.splat(texture.height() as f32));
                let longer = length2::<S>(footprint.right, w, h).max(length2::<S>(footprint.below, w, h));
                s.select(footprint.is_horizon, s.splat(HORIZON), longer)
            }
        };
        SampleCoord { u, v, footprint }
    }

    /// Computes the texels to read; reads none yet, but prefetches those of the nearer level.
    #[inline(always)]
    pub fn texel_addresses<S: Simd>(
        &self,
        s: S,
        mask: S::M,
        sample_coord: &SampleCoord<S>,
    ) -> TexelAddresses<S> {
        if !self.needs_level() {
            return TexelAddresses::none(s);
        }
        let last = self.texture.level_count() - 1;
        let (zero, top) = (s.splat(0.0), s.splat(last as f32));
        let d = s.splat(0.5) * log2(s, sample_coord.footprint);
        let is_trilinear = self.sampling.filter == Filter::Trilinear;
        let (level, part, needs_f64) = if is_trilinear {
            let d = d.max(zero).min(top);
            let level = d.floor();
            (level, d - level, s.mask(0))
        } else {
            let at = d + s.splat(0.5);
            let part = at - at.floor();
            let is_edge = part.lt(s.splat(LEVEL_EDGE)) | s.splat(1.0 - LEVEL_EDGE).lt(part);
            (at.floor().max(zero).min(top), zero, mask & is_edge & s.splat(0.5).lt(at))
        };
        // Lanes with both of their levels in fixed point are addressed at once; NaN coordinates
        // have no address there.
        let fixed = &self.fixed;
        let highest =
            fixed.count.min(last) as f32 - if is_trilinear && fixed.count < last { 1.0 } else { 0.0 };
        let sum = sample_coord.u + sample_coord.v;
        let is_fixed = mask & sum.le(sum) & s.splat(1.0).le(level) & level.le(s.splat(highest));
        if !is_fixed.any() {
            return TexelAddresses { level, part, is_fixed, needs_f64, ..TexelAddresses::none(s) };
        }
        let number = level.to_i32();
        let near = fixed.quad(s, self.sampling, sample_coord.coordinates(), number);
        fixed.ask_for(s, &near);
        // The last level serves as its own next one.
        let far = match is_trilinear {
            true => {
                let number = (number + s.splat_i(1)).min(s.splat_i(last as i32));
                fixed.quad(s, self.sampling, sample_coord.coordinates(), number)
            }
            false => near,
        };
        TexelAddresses { level, part, is_fixed, quads: [near, far], needs_f64 }
    }

    /// Returns R, G, B in 0..1.
    #[inline(always)]
    pub fn texel<S: Simd>(
        &self,
        s: S,
        mask: S::M,
        sample_coord: &SampleCoord<S>,
        texel_addresses: &TexelAddresses<S>,
    ) -> V3<S> {
        let (texture, sampling) = (self.texture, self.sampling);
        let texel = match sampling.filter {
            Filter::Nearest => nearest(s, mask, texture, sampling, sample_coord.coordinates()),
            Filter::Bilinear => bilinear(s, mask, texture, sampling, sample_coord.coordinates(), 0),
            Filter::Mipmap | Filter::Trilinear => self.levels(s, mask, sample_coord, texel_addresses),
        };
        scale::<S>(texel, s.splat(1.0 / 255.0))
    }

    /// Samples bilinearly in each lane's own level, and interpolates towards the next.
    #[inline(always)]
    fn levels<S: Simd>(
        &self,
        s: S,
        mask: S::M,
        sample_coord: &SampleCoord<S>,
        texel_addresses: &TexelAddresses<S>,
    ) -> V3<S> {
        let is_trilinear = self.sampling.filter == Filter::Trilinear;
        let mut out = splat3(s, [0.0; 3]);
        if texel_addresses.is_fixed.any() {
            let mut texel = self.fixed.bilinear(s, texel_addresses.is_fixed, &texel_addresses.quads[0]);
            if is_trilinear {
                let next = self.fixed.bilinear(s, texel_addresses.is_fixed, &texel_addresses.quads[1]);
                texel = between::<S>(texel, next, texel_addresses.part);
            }
            // A power of two, so this is exact.
            out = scale::<S>(texel, s.splat(1.0 / 256.0));
        }
        let mut left = mask & !texel_addresses.is_fixed;
        if !left.any() {
            return out;
        }
        let last = self.texture.level_count() - 1;
        // A texel is what is left of it and none of the next level, to the bit: magnified textures
        // need one level alone.
        let is_between = !texel_addresses.part.le(s.splat(0.0));
        let mut numbers = [0f32; 16];
        s.store(texel_addresses.level, &mut numbers[..S::LANES]);
        while left.any() {
            let first = numbers[left.bits().trailing_zeros() as usize];
            let number = s.splat(first);
            let same = left & texel_addresses.level.le(number) & number.le(texel_addresses.level);
            left = left & !same;
            let own = (first as u32).min(last);
            let mut texel = bilinear(s, same, self.texture, self.sampling, sample_coord.coordinates(), own);
            if is_trilinear && own < last && (same & is_between).any() {
                texel = between::<S>(
                    texel,
                    bilinear(s, same, self.texture, self.sampling, sample_coord.coordinates(), own + 1),
                    texel_addresses.part,
                );
            }
            for c in 0..3 {
                out[c] = s.select(same, texel[c], out[c]);
            }
            if first.is_nan() {
                break;
            }
        }
        out
    }
}

/// Returns a coordinate without its whole repeats, or unchanged if it is clamped.
#[inline(always)]
fn turns<S: Simd>(_: S, origin: S::F, rest: S::F, away: S::F, wrap: Wrap) -> S::F {
    match wrap {
        Wrap::Repeat => {
            let f = (origin - origin.floor()) + (rest + away);
            f - f.floor()
        }
        Wrap::Clamp => origin + (rest + away),
    }
}

#[inline(always)]
fn length2<S: Simd>(step: [S::F; 2], w: S::F, h: S::F) -> S::F {
    let (x, y) = (step[0] * w, step[1] * h);
    x * x + y * y
}

#[cfg(test)]
mod tests;

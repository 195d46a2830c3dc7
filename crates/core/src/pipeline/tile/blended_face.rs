//! Rasterizes faces in submission order, for alpha blending and the painter's algorithm.
//!
//! In: a face as the plain path sets it up (exact spans, depth and barycentrics in f64 along rows),
//! and its light: one colour, one for each corner, or normals to be lit at each pixel. Out: the
//! plain path's bytes. A blended byte is computed in f32; where that is too near to the boundary of
//! the next byte (or f32 lacks the digits), the plain path computes the pixel. So errors do not
//! accumulate over layers. Depth test, interpolation, lighting and fog are those of the other faces,
//! with the corners' attributes as their tables, but that less light is left out as faint.

use super::attribute_fetch::Corners;
use super::blended_texture::BlendedTexture;
use super::depth_f64::{DepthEncoder, F64Depth};
use super::depth_test::{DepthTest, F32Depth};
use super::exact_faces::{self, ExactFace};
use super::f32_error::{EDGE, F32Error};
use super::fog::FogParams;
use super::interpolate::{Barycentrics, FragmentInputs};
use super::lighting::{FaintLight, MaterialLighting, V3};
use super::shading_state::{ColorSource, Eye, FragmentShader};
use crate::math::coverage::PixelRect;
use crate::simd::{F32, I32, Kernel, Mask, Simd};
use std::ops::Range;

/// Numbers of the three corners, as a table of attributes holds them.
pub type CornerTable = [[f32; 4]; 3];

/// Source of a face's light.
#[derive(Clone, Debug)]
pub enum FaceLighting<'a> {
    /// One colour for the face, in the constant parts.
    Solid(MaterialLighting),
    /// One colour for each corner: the diffuse part, and the part that a texture does not multiply.
    Corners([CornerTable; 2]),
    /// Lighting at each pixel.
    Pixels {
        /// Material and lights, relative to `positions`' origin.
        lighting: &'a MaterialLighting,
        /// Unit normals of the corners.
        normals: CornerTable,
        /// Positions of the corners, relative to the eye, or in parallel projections to a point
        /// nearby.
        positions: CornerTable,
        /// Unit vector to the viewer if it is constant; otherwise the viewer is at the origin.
        to_viewer: Option<[f32; 3]>,
    },
}

/// Face to be drawn over the present pixels.
#[derive(Clone, Debug)]
pub struct BlendedFace<'a> {
    /// Coverage, depth and barycentrics.
    pub exact_face: ExactFace,
    /// Light of the face.
    pub face_lighting: FaceLighting<'a>,
    /// Vertex colours with alpha.
    pub vertex_colors: Option<CornerTable>,
    /// Texture, if any.
    pub texture: Option<BlendedTexture<'a>>,
    /// Fog, and the corners' positions in its space.
    pub fog: Option<(FogParams, CornerTable)>,
    /// Error of its colours in f32.
    pub f32_error: F32Error,
    /// 1 - transparency, without the alpha of `vertex_colors`.
    pub opacity: f32,
    /// True if the face is blended, and writes no depth.
    pub is_transparent: bool,
}

/// Lighting of corners that are lit already.
static LIT_CORNERS: MaterialLighting = MaterialLighting::constant([0.0; 3], [0.0; 3]);

impl BlendedFace<'_> {
    /// Light that may be left out: the byte is still the plain path's.
    pub const MAY_LACK: FaintLight = FaintLight::beside(EDGE);

    /// Returns the inputs of the face's fragments, whose tables are those of its corners, and the
    /// lighting of its material.
    fn shader(&self) -> (FragmentShader<'_>, &MaterialLighting) {
        let mut shader = FragmentShader {
            source: ColorSource::Constant,
            eye: Eye::Interpolated,
            colors: match &self.vertex_colors {
                Some(colors) => colors,
                None => &[],
            },
            texcoords: &[],
            positions: &[],
            fog: None,
            fog_positions: &[],
        };
        if let Some((fog, positions)) = &self.fog {
            (shader.fog, shader.fog_positions) = (Some(*fog), positions);
        }
        let lighting = match &self.face_lighting {
            FaceLighting::Solid(lighting) => lighting,
            FaceLighting::Corners([diffuse, specular]) => {
                shader.source = ColorSource::Vertices(diffuse, specular);
                &LIT_CORNERS
            }
            FaceLighting::Pixels { lighting, normals, positions, to_viewer } => {
                (shader.source, shader.positions) = (ColorSource::Pixels(normals), positions);
                if let Some(to_viewer) = *to_viewer {
                    shader.eye = Eye::Parallel { to_viewer };
                }
                lighting
            }
        };
        (shader, lighting)
    }
}

/// Draws one pixel as the plain path does. Arguments: column, row, its four bytes.
pub type ExactPixel<'a> = &'a dyn Fn(i32, i32, &mut [u8]);

/// Draws a face in a range of rows.
pub struct BlendedFaceKernel<'a, 'b> {
    /// Face to draw.
    pub blended_face: &'a BlendedFace<'a>,
    /// Pixels that may be drawn, all within the rows of the buffers.
    pub view: PixelRect,
    /// First row of the buffers.
    pub y0: i32,
    /// Width of a row in pixels.
    pub width: usize,
    /// RGBA bytes of the rows.
    pub bytes: &'b mut [u8],
    /// Depth words of the rows; empty where depth is neither tested nor stored.
    pub depth: &'b mut [i32],
    /// Depth words of 16 bits; empty for other formats.
    pub narrow: &'b mut [u16],
    /// Encoder of depths in f64; `None` for f32.
    pub encoder: Option<DepthEncoder>,
    /// Name and triangle of each pixel, if picking is on and the face writes depth; else empty.
    pub pick: &'b mut [[u32; 2]],
    /// Name and triangle that are written to `pick`.
    pub id: [u32; 2],
    /// Draws a pixel by the plain path.
    pub exact: ExactPixel<'a>,
}

/// Counts of a face's draw.
#[derive(Clone, Copy, Debug, Default)]
pub struct BlendedFaceStats {
    /// Pixels covered.
    pub tested: u64,
    /// Pixels stored.
    pub written: u64,
    /// Half-open range of the rows written; empty if there is none.
    pub rows: (i32, i32),
}

/// Number of spans listed before they are drawn: a closure would be compiled without the level's
/// instructions.
const SPANS: usize = 32;

impl Kernel for BlendedFaceKernel<'_, '_> {
    type Output = BlendedFaceStats;

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) -> BlendedFaceStats {
        let mut stats = BlendedFaceStats::default();
        let mut spans: [(i32, Range<i32>); SPANS] = [const { (0, 0..0) }; SPANS];
        let (blended_face, (inputs, lighting)) = (self.blended_face, self.blended_face.shader());
        let shader = &BlendedShader { blended_face, shader: inputs, lighting };
        let exact_face = &blended_face.exact_face;
        let top = exact_face.bounds.y0.max(self.view.y0);
        let bottom = exact_face.bounds.y1.min(self.view.y1);
        for outline in exact_face.outlines.iter().flatten() {
            let mut next_row = top;
            while next_row < bottom {
                let until = (next_row + SPANS as i32).min(bottom);
                let mut count = 0;
                let clip = PixelRect { y0: next_row, y1: until, ..self.view };
                outline.for_each_span(clip, |y, span| {
                    spans[count] = (y, span);
                    count += 1;
                });
                for (y, span) in &spans[..count] {
                    stats.tested += span.len() as u64;
                    let written = self.row(s, shader, *y, span.clone());
                    if written > 0 {
                        stats.written += written;
                        let is_first = stats.rows.0 >= stats.rows.1;
                        stats.rows.0 = if is_first { *y } else { stats.rows.0.min(*y) };
                        stats.rows.1 = stats.rows.1.max(y + 1);
                    }
                }
                next_row = until;
            }
        }
        stats
    }
}

impl BlendedFaceKernel<'_, '_> {
    /// Draws one span in vectors aligned to their width, the last one of a row possibly further
    /// left. Returns the pixels written.
    #[inline(always)]
    fn row<S: Simd>(&mut self, s: S, shader: &BlendedShader<'_>, y: i32, span: Range<i32>) -> u64 {
        let lanes = S::LANES as i32;
        let row_start = (y - self.y0) as usize * self.width;
        let mut written = 0;
        let mut x = span.start;
        while x < span.end {
            let start = (x & !(lanes - 1)).min(self.width as i32 - lanes);
            let (from, to) = (x - start, (span.end - start).min(lanes));
            let mut passes = s.mask((u32::MAX << from) & (((1u64 << to) - 1) as u32));
            let at = row_start + start as usize;
            x = start + lanes;
            passes = match self.encoder {
                None => {
                    self.depth_test(s, &F32Depth { close: None, tolerance: -1.0 }, (start, y), passes, at)
                }
                Some(encoder) => {
                    let test = F64Depth { encoder, corners: &[], vertices: &[] };
                    self.depth_test(s, &test, (start, y), passes, at)
                }
            };
            if !passes.any() {
                continue;
            }
            written += passes.bits().count_ones() as u64;
            let target = &mut self.bytes[at * 4..(at + S::LANES) * 4];
            let (color, off) = shader.colors(s, passes, (start, y), target);
            s.store_masked_bytes(passes & !off, color, target);
            let mut left = (passes & off).bits();
            while left != 0 {
                let lane = left.trailing_zeros() as usize;
                left &= left - 1;
                (self.exact)(start + lane as i32, y, &mut target[lane * 4..lane * 4 + 4]);
            }
            if !self.pick.is_empty() {
                let mut left = passes.bits();
                while left != 0 {
                    self.pick[at + left.trailing_zeros() as usize] = self.id;
                    left &= left - 1;
                }
            }
        }
        written
    }

    /// Tests depth at LANES pixels from `(x, y)` on, whose words begin at `at`; writes it for opaque
    /// faces. Returns the lanes of `mask` that pass.
    #[inline(always)]
    fn depth_test<S: Simd, D: DepthTest>(
        &mut self,
        s: S,
        test: &D,
        (x, y): (i32, i32),
        mask: S::M,
        at: usize,
    ) -> S::M {
        let BlendedFace { exact_face, is_transparent, .. } = self.blended_face;
        let has_depth = !(self.depth.is_empty() && self.narrow.is_empty());
        if exact_face.is_between && !has_depth {
            return mask;
        }
        let (word, passes) = match exact_face.is_between {
            true => (test.exact_words(s, exact_face, x, y), mask),
            false => test.clipped_words(s, exact_face, x, y),
        };
        let mut passes = passes & mask;
        if !self.depth.is_empty() {
            let words = &mut self.depth[at..at + S::LANES];
            passes = passes & test.is_nearer(s, word, s.load_i(words));
            if !is_transparent {
                s.store_masked_i(passes, word, words);
            }
        } else if has_depth {
            let narrow = &mut self.narrow[at..at + S::LANES];
            let mut words = [0i32; 16];
            words.iter_mut().zip(&*narrow).for_each(|(word, narrow)| *word = i32::from(*narrow));
            passes = passes & test.is_nearer(s, word, s.load_i(&words[..S::LANES]));
            if !is_transparent {
                s.store_masked_i(passes, word, &mut words[..S::LANES]);
                narrow.iter_mut().zip(words).for_each(|(narrow, word)| *narrow = word as u16);
            }
        }
        passes
    }
}

/// Shader of a blended face's fragments.
struct BlendedShader<'f> {
    blended_face: &'f BlendedFace<'f>,
    shader: FragmentShader<'f>,
    lighting: &'f MaterialLighting,
}

impl BlendedShader<'_> {
    /// Returns the bytes of a vector of pixels from `(x, y)` on over those in `under`, and the lanes
    /// that the plain path must compute.
    #[inline(always)]
    fn colors<S: Simd>(&self, s: S, mask: S::M, (x, y): (i32, i32), under: &[u8]) -> (S::I, S::M) {
        let BlendedFace { exact_face, vertex_colors, texture, f32_error, .. } = self.blended_face;
        let (barycentrics, mut off) = self.barycentrics(s, mask, x, y);
        let b = barycentrics.weights();
        let inputs = FragmentInputs {
            faces: s.splat_i(0),
            corners: Corners::One([0, 1, 2]),
            barycentrics,
            turn: s.mask(0),
            at: (s.iota() + s.splat_i(x), s.splat_i(y)),
        };
        let (mut lit, needs_f64) = self.shader.lit(s, mask, self.lighting, &inputs);
        off = off | needs_f64;
        let mut opacity = s.splat(self.blended_face.opacity);
        if let Some([[.., a0], [.., a1], [.., a2]]) = *vertex_colors {
            opacity = opacity * ((s.splat(a0) * b[0] + s.splat(a1) * b[1]) + s.splat(a2) * b[2]);
        }
        if let Some(texture) = texture {
            let ([r, g, b, a], beyond) = texture.texels(s, exact_face, mask & !off, x, y);
            off = off | beyond;
            lit.multiply([r, g, b]);
            opacity = opacity * a;
        }
        // A colour beyond white carries its own error: little of it may be left by opacity or fog.
        let edge = s.splat(f32_error.color) * largest(s, lit.sum()).max(s.splat(1.0))
            + s.splat(f32_error.highlight) * largest(s, lit.specular);
        let own = self.shader.color(s, &lit);
        let is_transparent = self.blended_face.is_transparent;
        let (packed, is_near) = bytes_over(s, own, opacity, is_transparent, s.load_bytes(under), edge);
        (packed, off | (mask & is_near))
    }

    /// Returns the barycentrics of a vector of pixels from `(x, y)` on, 0 if the face has one
    /// colour, and the lanes where f32 lacks the digits.
    ///
    /// Deferred shading clamps barycentrics beside the face in f32, and takes them in f32 wherever
    /// its limit of a byte's step allows; here such pixels and faces are left to f64.
    #[inline(always)]
    fn barycentrics<S: Simd>(&self, s: S, mask: S::M, x: i32, y: i32) -> (Barycentrics<S>, S::M) {
        let BlendedFace { exact_face, face_lighting, vertex_colors, fog, .. } = self.blended_face;
        let (zero, one) = (s.splat(0.0), s.splat(1.0));
        if matches!(face_lighting, FaceLighting::Solid(_)) && vertex_colors.is_none() && fog.is_none() {
            return (Barycentrics::new([zero; 3], one), s.mask(0));
        }
        if !exact_face.is_smooth {
            let (exact, beside) = exact_faces::exact_weights(s, exact_face, x, y);
            return (Barycentrics::new(exact, one), mask & beside);
        }
        let p = exact_faces::weights(s, exact_face, [x, y], 1);
        let sum = (p[0] + p[1]) + p[2];
        let is_beside = p[0].lt(zero) | p[1].lt(zero) | p[2].lt(zero);
        (Barycentrics::new(p, one / sum), mask & (is_beside | !s.splat(exact_faces::LEAST_SUM).lt(sum)))
    }
}

/// Returns the largest magnitude of a colour's channels.
#[inline(always)]
fn largest<S: Simd>(s: S, [r, g, b]: V3<S>) -> S::F {
    r.abs().max(g.abs()).max(b.abs()).max(s.splat(0.0))
}

/// Returns colours as bytes, over the pixels in `old` if the face is transparent, and the lanes
/// where a byte is within `edge` of the boundary to the next.
#[inline(always)]
fn bytes_over<S: Simd>(
    s: S,
    own: V3<S>,
    opacity: S::F,
    is_transparent: bool,
    old: S::I,
    edge: S::F,
) -> (S::I, S::M) {
    let zero = s.splat(0.0);
    let opacity = opacity.max(zero).min(s.splat(1.0));
    let share = opacity * s.splat(255.0);
    let clear = s.splat(1.0) - opacity;
    let low = s.splat_i(255);
    let mut packed = s.splat_i(255 << 24);
    let mut is_near = s.mask(0);
    let channels = [(old & low).to_f32(), (old.shr::<8>() & low).to_f32(), (old.shr::<16>() & low).to_f32()];
    for c in 0..3 {
        let value = match is_transparent {
            true => channels[c] * clear + own[c] * share,
            false => own[c] * s.splat(255.0),
        };
        let value = value.max(zero).min(s.splat(255.0)) + s.splat(0.5);
        let integer = value.floor();
        let rest = value - integer;
        is_near = is_near | rest.lt(edge) | (s.splat(1.0) - edge).lt(rest);
        let byte = integer.to_i32();
        packed = packed
            | match c {
                0 => byte,
                1 => byte.shl::<8>(),
                _ => byte.shl::<16>(),
            };
    }
    (packed, is_near)
}

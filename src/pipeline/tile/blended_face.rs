//! Rasterizes faces in submission order, for alpha blending and the painter's algorithm.
//!
//! In: a face as the plain path sets it up (exact spans, depth and barycentrics in f64 along rows),
//! and its light: one colour, one for each corner, or normals to be lit at each pixel. Out: the
//! plain path's bytes. A blended byte is computed in f32; where that is too near to the boundary of
//! the next byte (or f32 lacks the digits), the plain path computes the pixel. So errors do not
//! accumulate over layers. Depth is tested, and written by opaque faces, as everywhere in the tile
//! renderer.

use super::blended_texture::BlendedTexture;
use super::depth_f64::{DepthEncoder, F64Depth};
use super::depth_test::{DepthTest, F32Depth};
use super::exact_faces::{self, ExactFace};
use super::fog::FogParams;
use super::lighting::{MaterialLighting, V3, dot, light, scale, splat3};
use crate::math::coverage::PixelRect;
use crate::simd::{F32, I32, Kernel, Mask, Simd};

/// Two parts of a colour: the one that vertex colours multiply, and the rest.
pub type DiffuseSpecular = [[f32; 3]; 2];

/// Source of a face's light.
#[derive(Clone, Copy, Debug)]
pub enum FaceLighting<'a> {
    /// One colour for the face.
    Solid(DiffuseSpecular),
    /// One colour for each corner.
    Corners([DiffuseSpecular; 3]),
    /// Lighting at each pixel.
    Pixels {
        /// Material and lights, relative to `positions`' origin.
        lighting: &'a MaterialLighting,
        /// Unit normals of the corners.
        normals: [[f32; 3]; 3],
        /// Positions of the corners, relative to the eye, or in parallel projections to a point
        /// nearby.
        positions: [[f32; 3]; 3],
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
    pub vertex_colors: Option<[[f32; 4]; 3]>,
    /// Texture, if any.
    pub texture: Option<BlendedTexture<'a>>,
    /// Fog, and the corners' positions in its space.
    pub fog: Option<(FogParams, [[f32; 3]; 3])>,
    /// 1 - transparency, without the alpha of `vertex_colors`.
    pub opacity: f32,
    /// True if the face is blended, and writes no depth.
    pub is_transparent: bool,
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

/// Distance from the boundary between two bytes within which f32 does not decide, in bytes.
const EDGE: f32 = 1.0 / 1024.0;

/// This distance under fog, for colours up to white: distances in f32 lose some digits.
const FOG_EDGE: f32 = 1.0 / 128.0;

/// Number of spans listed before they are drawn: a closure would be compiled without the level's
/// instructions.
const SPANS: usize = 32;

impl Kernel for BlendedFaceKernel<'_, '_> {
    type Output = BlendedFaceStats;

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) -> BlendedFaceStats {
        let mut stats = BlendedFaceStats::default();
        let mut spans: [(i32, std::ops::Range<i32>); SPANS] = [const { (0, 0..0) }; SPANS];
        let exact_face = &self.blended_face.exact_face;
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
                    let written = self.row(s, *y, span.clone());
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
    fn row<S: Simd>(&mut self, s: S, y: i32, span: std::ops::Range<i32>) -> u64 {
        let blended_face = self.blended_face;
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
                None => self.depth_test(s, &F32Depth, (start, y), passes, at),
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
            let (color, off) = colors(s, blended_face, passes, start, y, target);
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

/// Returns the bytes of a vector of pixels over those in `under`, and the lanes that the plain path
/// must compute.
#[inline(always)]
fn colors<S: Simd>(
    s: S,
    blended_face: &BlendedFace<'_>,
    mask: S::M,
    x: i32,
    y: i32,
    under: &[u8],
) -> (S::I, S::M) {
    let (barycentrics, mut off) = barycentrics(s, blended_face, mask, x, y);
    let (mut diffuse, specular, needs_f64) = face_light(s, &blended_face.face_lighting, mask, barycentrics);
    off = off | needs_f64;
    let mut opacity = s.splat(blended_face.opacity);
    if let Some(vertex_colors) = &blended_face.vertex_colors {
        let tint = between(s, vertex_colors.map(|[r, g, b, _]| [r, g, b]), barycentrics);
        diffuse = [diffuse[0] * tint[0], diffuse[1] * tint[1], diffuse[2] * tint[2]];
        let [a0, a1, a2] = vertex_colors.map(|t| t[3]);
        let alpha =
            (s.splat(a0) * barycentrics[0] + s.splat(a1) * barycentrics[1]) + s.splat(a2) * barycentrics[2];
        opacity = opacity * alpha;
    }
    if let Some(texture) = &blended_face.texture {
        let ([r, g, b, a], beyond) = texture.texels(s, &blended_face.exact_face, mask & !off, x, y);
        off = off | beyond;
        diffuse = [diffuse[0] * r, diffuse[1] * g, diffuse[2] * b];
        opacity = opacity * a;
    }
    let mut own = [diffuse[0] + specular[0], diffuse[1] + specular[1], diffuse[2] + specular[2]];
    let mut edge = s.splat(EDGE);
    if let Some((fog, positions)) = &blended_face.fog {
        // The part of a colour beyond white that fog leaves carries that colour's error.
        edge = s.splat(FOG_EDGE) * own[0].abs().max(own[1].abs()).max(own[2].abs()).max(s.splat(1.0));
        own = fog.over(s, own, between(s, *positions, barycentrics));
    }
    let (packed, is_near) =
        bytes_over(s, own, opacity, blended_face.is_transparent, s.load_bytes(under), edge);
    (packed, off | (mask & is_near))
}

/// Returns the barycentrics of a vector of pixels from `(x, y)` on, 0 if the face has one colour,
/// and the lanes where f32 lacks the digits.
#[inline(always)]
fn barycentrics<S: Simd>(
    s: S,
    blended_face: &BlendedFace<'_>,
    mask: S::M,
    x: i32,
    y: i32,
) -> ([S::F; 3], S::M) {
    let zero = s.splat(0.0);
    let is_solid = matches!(blended_face.face_lighting, FaceLighting::Solid(_))
        && blended_face.vertex_colors.is_none()
        && blended_face.fog.is_none();
    if is_solid {
        return ([zero; 3], s.mask(0));
    }
    if !blended_face.exact_face.is_smooth {
        let (exact, beside) = exact_faces::exact_weights(s, &blended_face.exact_face, x, y);
        return (exact, mask & beside);
    }
    let [b0, b1, b2] = exact_faces::weights(s, &blended_face.exact_face, x, y);
    let sum = (b0 + b1) + b2;
    let inverse = s.splat(1.0) / sum;
    // Beside the face the plain path clamps barycentrics in its own way.
    let is_beside = b0.lt(zero) | b1.lt(zero) | b2.lt(zero);
    ([b0 * inverse, b1 * inverse, b2 * inverse], mask & (is_beside | !s.splat(1e-30).lt(sum)))
}

/// Returns the diffuse and the specular light of pixels, and the lanes where f32 lacks the digits.
#[inline(always)]
fn face_light<S: Simd>(
    s: S,
    face_lighting: &FaceLighting<'_>,
    mask: S::M,
    barycentrics: [S::F; 3],
) -> (V3<S>, V3<S>, S::M) {
    match face_lighting {
        FaceLighting::Solid([diffuse, specular]) => (splat3(s, *diffuse), splat3(s, *specular), s.mask(0)),
        FaceLighting::Corners(parts) => (
            between(s, [parts[0][0], parts[1][0], parts[2][0]], barycentrics),
            between(s, [parts[0][1], parts[1][1], parts[2][1]], barycentrics),
            s.mask(0),
        ),
        FaceLighting::Pixels { lighting, normals, positions, to_viewer } => {
            let n = between(s, *normals, barycentrics);
            let length2 = dot::<S>(n, n);
            // Normals that cancel fall back to the face's, in f64.
            let is_cancelled = mask & !s.splat(1e-4).le(length2);
            let normal = scale::<S>(n, s.splat(1.0) / length2.sqrt());
            let position = between(s, *positions, barycentrics);
            let to_viewer = match to_viewer {
                Some(v) => splat3(s, *v),
                None => scale::<S>(position, s.splat(-1.0) / dot::<S>(position, position).sqrt()),
            };
            let lit = light(s, lighting, position, normal, to_viewer);
            (lit.diffuse, lit.specular, is_cancelled | (lit.needs_f64 & mask))
        }
    }
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

/// Interpolates three numbers of each corner.
#[inline(always)]
fn between<S: Simd>(s: S, v: [[f32; 3]; 3], b: [S::F; 3]) -> V3<S> {
    [
        (s.splat(v[0][0]) * b[0] + s.splat(v[1][0]) * b[1]) + s.splat(v[2][0]) * b[2],
        (s.splat(v[0][1]) * b[0] + s.splat(v[1][1]) * b[1]) + s.splat(v[2][1]) * b[2],
        (s.splat(v[0][2]) * b[0] + s.splat(v[1][2]) * b[1]) + s.splat(v[2][2]) * b[2],
    ]
}

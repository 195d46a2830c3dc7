//! Rasterizes faces in submission order, for alpha blending and the painter's algorithm.
//!
//! In: a face as the plain path sets it up (exact spans, depth and weights in f64 along rows), and its light: one colour, one a
//! corner, or normals to be lit at each pixel. Out: the plain path's bytes: a blended byte is worked in f32, and where that is
//! too near to the next byte's edge to be told (or f32 lacks the digits), the pixel is the plain path's own. So errors do not
//! add up over layers. Depth is tested, and written by opaque faces, as everywhere in the tile renderer.

use super::bins::ClipRect;
use super::blended_texture::BlendedTexture;
use super::depth_f64::{self, DepthEncoder};
use super::exact_faces::{self, ExactFace};
use super::fog::FogParams;
use super::lighting::{MaterialLighting, V3, dot, light, scale, splat3};
use crate::simd::{F32, I32, Kernel, Mask, Simd};

/// The two parts of a colour: what vertex colours multiply, and what they do not.
pub type DiffuseSpecular = [[f32; 3]; 2];

/// Where the light of a face comes from.
#[derive(Clone, Copy, Debug)]
pub enum FaceLighting<'a> {
    /// One colour.
    Solid(DiffuseSpecular),
    /// One at each corner.
    Corners([DiffuseSpecular; 3]),
    /// Lit at each pixel.
    Pixels {
        /// The material and its lights, placed relative to `positions`.
        lighting: &'a MaterialLighting,
        /// Unit, one a corner.
        normals: [[f32; 3]; 3],
        /// Of the corners, relative to the eye, or in parallel projections to a point nearby.
        positions: [[f32; 3]; 3],
        /// Unit, where V is the same everywhere; else it points to the origin.
        to_viewer: Option<[f32; 3]>,
    },
}

/// One face ready to be drawn over what is there.
#[derive(Clone, Debug)]
pub struct BlendedFace<'a> {
    /// Its place.
    pub exact_face: ExactFace,
    /// Its light.
    pub face_lighting: FaceLighting<'a>,
    /// Vertex colours with alpha.
    pub vertex_colors: Option<[[f32; 4]; 3]>,
    /// Its texture.
    pub texture: Option<BlendedTexture<'a>>,
    /// The fog, and the corners' places in it.
    pub fog: Option<(FogParams, [[f32; 3]; 3])>,
    /// 1 - transparency; alpha of `vertex_colors` aside.
    pub opacity: f32,
    /// Whether it is blended, and writes no depth.
    pub is_transparent: bool,
}

/// Draws one pixel as the plain path does: column, row, its four bytes.
pub type ExactPixel<'a> = &'a dyn Fn(i32, i32, &mut [u8]);

/// Draws a face's share of some rows.
pub struct BlendedFaceKernel<'a, 'b> {
    /// The face.
    pub blended_face: &'a BlendedFace<'a>,
    /// What may be drawn, all of it in the rows of the memories.
    pub view: ClipRect,
    /// The memories' first row.
    pub y0: i32,
    /// Pixels in a row.
    pub width: usize,
    /// RGBA bytes of the rows.
    pub bytes: &'b mut [u8],
    /// Depth words of the rows; empty where depth is neither tested nor kept.
    pub depth: &'b mut [i32],
    /// The same of 16 bits.
    pub narrow: &'b mut [u16],
    /// How depth is worked in f64; `None` for f32.
    pub encoder: Option<DepthEncoder>,
    /// Name and triangle of each pixel, where PICK asks and the face writes depth; else empty.
    pub pick: &'b mut [[u32; 2]],
    /// What `pick` keeps.
    pub id: [u32; 2],
    /// The plain path.
    pub exact: ExactPixel<'a>,
}

/// What came of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct BlendedFaceStats {
    /// Pixels covered.
    pub tested: u64,
    /// Pixels stored.
    pub written: u64,
    /// The first row written and one beyond the last; alike where there is none.
    pub rows: (i32, i32),
}

/// How near to the edge between two bytes f32 has no say, in bytes.
const EDGE: f32 = 1.0 / 1024.0;

/// The same under fog, for colours up to white: distances in f32 lose some digits on their way.
const FOG_EDGE: f32 = 1.0 / 128.0;

/// Spans that are worked on at once: a closure would be compiled without the level's instructions.
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
                let clip = crate::math::coverage::PixelRect {
                    x0: self.view.x0,
                    y0: next_row,
                    x1: self.view.x1,
                    y1: until,
                };
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
    /// One span: vectors that begin at multiples of their width, the last one of a row perhaps further left.
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
            if let Some(encoder) = self.encoder {
                passes = passes & self.depth_test_f64(s, &encoder, (start, y), passes, at);
            } else if !self.depth.is_empty() || !blended_face.exact_face.is_between {
                let z = exact_faces::depths(s, &blended_face.exact_face, start, y);
                if !blended_face.exact_face.is_between {
                    passes =
                        passes & exact_faces::between_near_and_far(s, &blended_face.exact_face, z, start, y);
                }
                if !self.depth.is_empty() {
                    let z = z.max(s.splat(0.0)).bits();
                    let depth = &mut self.depth[at..at + S::LANES];
                    passes = passes & s.load_i(depth).gt(z);
                    if !blended_face.is_transparent {
                        s.store_masked_i(passes, z, depth);
                    }
                }
            }
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

    /// The depth test in f64 at LANES pixels from `from` on, whose words are those from `at` on: where it passes.
    #[inline(always)]
    fn depth_test_f64<S: Simd>(
        &mut self,
        s: S,
        encoder: &DepthEncoder,
        (x, y): (i32, i32),
        mask: S::M,
        at: usize,
    ) -> S::M {
        let blended_face = self.blended_face;
        let (word, inside) = depth_f64::exact_words(s, encoder, &blended_face.exact_face, x, y);
        let mut old = [0i32; 16];
        match self.narrow.is_empty() {
            true => old[..S::LANES].copy_from_slice(&self.depth[at..at + S::LANES]),
            false => {
                let narrow = &self.narrow[at..at + S::LANES];
                old.iter_mut().zip(narrow).for_each(|(old, word)| *old = i32::from(*word));
            }
        }
        let passes = mask & inside & encoder.is_nearer(s, word, s.load_i(&old[..S::LANES]));
        if !blended_face.is_transparent {
            match self.narrow.is_empty() {
                true => s.store_masked_i(passes, word, &mut self.depth[at..at + S::LANES]),
                false => {
                    s.store_masked_i(passes, word, &mut old[..S::LANES]);
                    let narrow = &mut self.narrow[at..at + S::LANES];
                    narrow.iter_mut().zip(old).for_each(|(to, word)| *to = word as u16);
                }
            }
        }
        passes
    }
}

/// The bytes of a vector of pixels over those in `under`, and where the plain path is to be asked.
#[inline(always)]
fn colors<S: Simd>(
    s: S,
    blended_face: &BlendedFace<'_>,
    mask: S::M,
    x: i32,
    y: i32,
    under: &[u8],
) -> (S::I, S::M) {
    let zero = s.splat(0.0);
    let mut off = s.mask(0);
    let mut barycentrics = [zero; 3];
    let is_solid = matches!(blended_face.face_lighting, FaceLighting::Solid(_))
        && blended_face.vertex_colors.is_none()
        && blended_face.fog.is_none();
    if !is_solid && blended_face.exact_face.is_smooth {
        let [b0, b1, b2] = exact_faces::weights(s, &blended_face.exact_face, x, y);
        let sum = (b0 + b1) + b2;
        let inverse = s.splat(1.0) / sum;
        // Beside the face weights are clamped, in a way that is the plain path's own.
        let is_beside = b0.lt(zero) | b1.lt(zero) | b2.lt(zero);
        off = mask & (is_beside | !s.splat(1e-30).lt(sum));
        barycentrics = [b0 * inverse, b1 * inverse, b2 * inverse];
    } else if !is_solid {
        let (exact, beside) = exact_faces::exact_barycentrics(s, &blended_face.exact_face, x, y);
        (barycentrics, off) = (exact, mask & beside);
    }
    let (mut diffuse, specular) = match &blended_face.face_lighting {
        FaceLighting::Solid([diffuse, specular]) => (splat3(s, *diffuse), splat3(s, *specular)),
        FaceLighting::Corners(parts) => (
            between(s, [parts[0][0], parts[1][0], parts[2][0]], barycentrics),
            between(s, [parts[0][1], parts[1][1], parts[2][1]], barycentrics),
        ),
        FaceLighting::Pixels { lighting, normals, positions, to_viewer } => {
            let n = between(s, *normals, barycentrics);
            let length2 = dot::<S>(n, n);
            // Normals that cancel fall back to the face's, in f64.
            off = off | (mask & !s.splat(1e-4).le(length2));
            let normal = scale::<S>(n, s.splat(1.0) / length2.sqrt());
            let position = between(s, *positions, barycentrics);
            let to_viewer = match to_viewer {
                Some(v) => splat3(s, *v),
                None => scale::<S>(position, s.splat(-1.0) / dot::<S>(position, position).sqrt()),
            };
            let lit = light(s, lighting, position, normal, to_viewer);
            off = off | (lit.needs_f64 & mask);
            (lit.diffuse, lit.specular)
        }
    };
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
        // What fog leaves of a colour beyond white brings that colour's error along.
        edge = s.splat(FOG_EDGE) * own[0].abs().max(own[1].abs()).max(own[2].abs()).max(s.splat(1.0));
        own = fog.over(s, own, between(s, *positions, barycentrics));
    }
    let opacity = opacity.max(zero).min(s.splat(1.0));
    let share = opacity * s.splat(255.0);
    let clear = s.splat(1.0) - opacity;
    let old = s.load_bytes(under);
    let low = s.splat_i(255);
    let mut packed = s.splat_i(255 << 24);
    let channels = [(old & low).to_f32(), (old.shr::<8>() & low).to_f32(), (old.shr::<16>() & low).to_f32()];
    for c in 0..3 {
        let value = match blended_face.is_transparent {
            true => channels[c] * clear + own[c] * share,
            false => own[c] * s.splat(255.0),
        };
        let value = value.max(zero).min(s.splat(255.0)) + s.splat(0.5);
        let integer = value.floor();
        let rest = value - integer;
        off = off | (mask & (rest.lt(edge) | (s.splat(1.0) - edge).lt(rest)));
        let byte = integer.to_i32();
        packed = packed
            | match c {
                0 => byte,
                1 => byte.shl::<8>(),
                _ => byte.shl::<16>(),
            };
    }
    (packed, off)
}

/// Three numbers at each corner, weighed.
#[inline(always)]
fn between<S: Simd>(s: S, v: [[f32; 3]; 3], b: [S::F; 3]) -> V3<S> {
    [
        (s.splat(v[0][0]) * b[0] + s.splat(v[1][0]) * b[1]) + s.splat(v[2][0]) * b[2],
        (s.splat(v[0][1]) * b[0] + s.splat(v[1][1]) * b[1]) + s.splat(v[2][1]) * b[2],
        (s.splat(v[0][2]) * b[0] + s.splat(v[1][2]) * b[1]) + s.splat(v[2][2]) * b[2],
    ]
}

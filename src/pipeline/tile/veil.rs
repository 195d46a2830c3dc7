//! Faces one after the other, in their order: what is blended with the pixels under it, and what the painter draws.
//!
//! In: a face as the plain path sets it up (exact spans, depth and weights in f64 along rows), and its light: one colour, one a
//! corner, or normals to be lit at each pixel. Out: the plain path's bytes: a blended byte is worked in f32, and where that is
//! too near to the next byte's edge to be told (or f32 lacks the digits), the pixel is the plain path's own. So errors do not
//! add up over layers. Depth is tested, and written by opaque faces, as everywhere in the tile renderer.

use super::bins::View;
use super::deep::{self, Form};
use super::haze::Haze;
use super::light::{Lighting, V3, dot, light, scale, splat3};
use super::sheet::Sheet;
use super::wide::{self, WideFace};
use crate::simd::{F32, I32, Kernel, Mask, Simd};

/// The two parts of a colour: what vertex colours multiply, and what they do not.
pub type Parts = [[f32; 3]; 2];

/// Where the light of a face comes from.
#[derive(Clone, Copy, Debug)]
pub enum Glow<'a> {
    /// One colour.
    Solid(Parts),
    /// One at each corner.
    Corners([Parts; 3]),
    /// Lit at each pixel.
    Pixels {
        /// The material and its lights, placed relative to `positions`.
        lighting: &'a Lighting,
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
pub struct Veil<'a> {
    /// Its place.
    pub wide: WideFace,
    /// Its light.
    pub glow: Glow<'a>,
    /// Vertex colours with alpha.
    pub tints: Option<[[f32; 4]; 3]>,
    /// Its texture.
    pub sheet: Option<Sheet<'a>>,
    /// The fog, and the corners' places in it.
    pub haze: Option<(Haze, [[f32; 3]; 3])>,
    /// 1 - transparency; alpha of `tints` aside.
    pub opacity: f32,
    /// Whether it is blended, and writes no depth.
    pub is_transparent: bool,
}

/// Draws one pixel as the plain path does: column, row, its four bytes.
pub type ExactPixel<'a> = &'a dyn Fn(i32, i32, &mut [u8]);

/// Draws a face's share of some rows.
pub struct VeilKernel<'a, 'b> {
    /// The face.
    pub veil: &'a Veil<'a>,
    /// What may be drawn, all of it in the rows of the memories.
    pub view: View,
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
    pub form: Option<Form>,
    /// Name and triangle of each pixel, where PICK asks and the face writes depth; else empty.
    pub pick: &'b mut [[u32; 2]],
    /// What `pick` keeps.
    pub id: [u32; 2],
    /// The plain path.
    pub exact: ExactPixel<'a>,
}

/// What came of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct VeilStats {
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

impl Kernel for VeilKernel<'_, '_> {
    type Output = VeilStats;

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) -> VeilStats {
        let mut stats = VeilStats::default();
        let mut spans: [(i32, std::ops::Range<i32>); SPANS] = [const { (0, 0..0) }; SPANS];
        let wide = &self.veil.wide;
        let top = wide.bounds.y0.max(self.view.y0);
        let bottom = wide.bounds.y1.min(self.view.y1);
        for outline in wide.outlines.iter().flatten() {
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

impl VeilKernel<'_, '_> {
    /// One span: vectors that begin at multiples of their width, the last one of a row perhaps further left.
    #[inline(always)]
    fn row<S: Simd>(&mut self, s: S, y: i32, span: std::ops::Range<i32>) -> u64 {
        let veil = self.veil;
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
            if let Some(form) = self.form {
                passes = passes & self.deep_test(s, &form, (start, y), passes, at);
            } else if !self.depth.is_empty() || !veil.wide.is_between {
                let z = wide::depths(s, &veil.wide, start, y);
                if !veil.wide.is_between {
                    passes = passes & wide::between_near_and_far(s, &veil.wide, z, start, y);
                }
                if !self.depth.is_empty() {
                    let z = z.max(s.splat(0.0)).bits();
                    let depth = &mut self.depth[at..at + S::LANES];
                    passes = passes & s.load_i(depth).gt(z);
                    if !veil.is_transparent {
                        s.store_masked_i(passes, z, depth);
                    }
                }
            }
            if !passes.any() {
                continue;
            }
            written += passes.bits().count_ones() as u64;
            let target = &mut self.bytes[at * 4..(at + S::LANES) * 4];
            let (color, off) = colors(s, veil, passes, start, y, target);
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
    fn deep_test<S: Simd>(&mut self, s: S, form: &Form, (x, y): (i32, i32), mask: S::M, at: usize) -> S::M {
        let veil = self.veil;
        let (word, inside) = deep::wide_words(s, form, &veil.wide, x, y);
        let mut old = [0i32; 16];
        match self.narrow.is_empty() {
            true => old[..S::LANES].copy_from_slice(&self.depth[at..at + S::LANES]),
            false => {
                let narrow = &self.narrow[at..at + S::LANES];
                old.iter_mut().zip(narrow).for_each(|(old, word)| *old = i32::from(*word));
            }
        }
        let passes = mask & inside & form.is_nearer(s, word, s.load_i(&old[..S::LANES]));
        if !veil.is_transparent {
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
fn colors<S: Simd>(s: S, veil: &Veil<'_>, mask: S::M, x: i32, y: i32, under: &[u8]) -> (S::I, S::M) {
    let zero = s.splat(0.0);
    let mut off = s.mask(0);
    let mut shares = [zero; 3];
    let is_solid = matches!(veil.glow, Glow::Solid(_)) && veil.tints.is_none() && veil.haze.is_none();
    if !is_solid && veil.wide.is_smooth {
        let [b0, b1, b2] = wide::weights(s, &veil.wide, x, y);
        let sum = (b0 + b1) + b2;
        let inverse = s.splat(1.0) / sum;
        // Beside the face weights are clamped, in a way that is the plain path's own.
        let is_beside = b0.lt(zero) | b1.lt(zero) | b2.lt(zero);
        off = mask & (is_beside | !s.splat(1e-30).lt(sum));
        shares = [b0 * inverse, b1 * inverse, b2 * inverse];
    } else if !is_solid {
        let (exact, beside) = wide::exact_shares(s, &veil.wide, x, y);
        (shares, off) = (exact, mask & beside);
    }
    let (mut matte, gloss) = match &veil.glow {
        Glow::Solid([matte, gloss]) => (splat3(s, *matte), splat3(s, *gloss)),
        Glow::Corners(parts) => (
            between(s, [parts[0][0], parts[1][0], parts[2][0]], shares),
            between(s, [parts[0][1], parts[1][1], parts[2][1]], shares),
        ),
        Glow::Pixels { lighting, normals, positions, to_viewer } => {
            let n = between(s, *normals, shares);
            let length2 = dot::<S>(n, n);
            // Normals that cancel fall back to the face's, in f64.
            off = off | (mask & !s.splat(1e-4).le(length2));
            let normal = scale::<S>(n, s.splat(1.0) / length2.sqrt());
            let position = between(s, *positions, shares);
            let to_viewer = match to_viewer {
                Some(v) => splat3(s, *v),
                None => scale::<S>(position, s.splat(-1.0) / dot::<S>(position, position).sqrt()),
            };
            let lit = light(s, lighting, position, normal, to_viewer);
            off = off | (lit.delicate & mask);
            (lit.matte, lit.gloss)
        }
    };
    let mut opacity = s.splat(veil.opacity);
    if let Some(tints) = &veil.tints {
        let tint = between(s, tints.map(|[r, g, b, _]| [r, g, b]), shares);
        matte = [matte[0] * tint[0], matte[1] * tint[1], matte[2] * tint[2]];
        let [a0, a1, a2] = tints.map(|t| t[3]);
        let alpha = (s.splat(a0) * shares[0] + s.splat(a1) * shares[1]) + s.splat(a2) * shares[2];
        opacity = opacity * alpha;
    }
    if let Some(sheet) = &veil.sheet {
        let ([r, g, b, a], beyond) = sheet.texels(s, &veil.wide, mask & !off, x, y);
        off = off | beyond;
        matte = [matte[0] * r, matte[1] * g, matte[2] * b];
        opacity = opacity * a;
    }
    let mut own = [matte[0] + gloss[0], matte[1] + gloss[1], matte[2] + gloss[2]];
    let mut edge = s.splat(EDGE);
    if let Some((haze, positions)) = &veil.haze {
        // What fog leaves of a colour beyond white brings that colour's error along.
        edge = s.splat(FOG_EDGE) * own[0].abs().max(own[1].abs()).max(own[2].abs()).max(s.splat(1.0));
        own = haze.over(s, own, between(s, *positions, shares));
    }
    let opacity = opacity.max(zero).min(s.splat(1.0));
    let share = opacity * s.splat(255.0);
    let clear = s.splat(1.0) - opacity;
    let old = s.load_bytes(under);
    let low = s.splat_i(255);
    let mut packed = s.splat_i(255 << 24);
    let channels = [(old & low).to_f32(), (old.shr::<8>() & low).to_f32(), (old.shr::<16>() & low).to_f32()];
    for c in 0..3 {
        let value = match veil.is_transparent {
            true => channels[c] * clear + own[c] * share,
            false => own[c] * s.splat(255.0),
        };
        let value = value.max(zero).min(s.splat(255.0)) + s.splat(0.5);
        let whole = value.floor();
        let rest = value - whole;
        off = off | (mask & (rest.lt(edge) | (s.splat(1.0) - edge).lt(rest)));
        let byte = whole.to_i32();
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

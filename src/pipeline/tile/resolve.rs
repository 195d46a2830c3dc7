//! Colour: every pixel of a band that a face of this draw won is shaded once, a vector of columns at a time.
//!
//! Weights come from the unsnapped corners: e_i = the doubled area that pixel centre and edge i span, clamped at 0;
//! b_i = (e_i / w_i) / sum(e_j / w_j). The point itself lies on the eye's ray through the pixel, at depth
//! w = sum(e_i) / sum(e_i / w_i), so no positions are gathered. Where f32 lacks the digits (slivers, faces that only the
//! plain path can draw) the plain path shades the pixel in f64.

use super::light::{Lighting, Lit, V3, dot, light, pack, scale, splat3};
use super::raster::NO_FACE;
use super::setup::View;
use super::vertex::Record;
use crate::simd::{F32, I32, Kernel, Mask, Simd};

/// Set in the memory of ids beside the number of a face that only the plain path can draw.
pub const PLAIN_BIT: i32 = 1 << 30;

/// Where values come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Mode {
    /// Normals gathered and interpolated, lit per pixel.
    Phong,
    /// Colours gathered and interpolated: lit before, or never.
    Colors,
    /// One colour for everything.
    Constant,
}

/// How a pixel's place in the shading frame is found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eye {
    /// Eye-relative position = (ray 0 + ray 1 * column + ray 2 * row) * w; V points back along it.
    Perspective {
        /// At pixel (0,0), per column, per row.
        ray: [[f32; 3]; 3],
    },
    /// V is the same everywhere; positions are gathered.
    Parallel {
        /// Unit, towards the viewer.
        to_viewer: [f32; 3],
    },
}

/// Shades one pixel in f64: face, column, row; R, G, B, A.
pub type PlainPixel<'a> = &'a (dyn Fn(u32, i32, i32) -> [u8; 4] + Sync);

/// What every pixel of a draw shares.
pub struct Shading<'a> {
    /// Where values come from.
    pub mode: Mode,
    /// The eye.
    pub eye: Eye,
    /// The material and its lights; for `Colors` and `Constant`, `base` alone is used by `Constant`.
    pub lighting: &'a Lighting,
    /// Normals in the shading frame (Phong).
    pub normals: &'a [[f32; 4]],
    /// Colours (Colors).
    pub colors: &'a [[f32; 4]],
    /// Eye-relative positions in the shading frame (parallel projections that are lit per pixel).
    pub positions: &'a [[f32; 4]],
    /// How slender a face may be: its longest side squared over its doubled area.
    pub slenderest: f32,
    /// Whether values run straight on the screen.
    pub is_affine: bool,
    /// The plain path.
    pub plain: PlainPixel<'a>,
}

/// The faces that pixels are shaded from.
#[derive(Clone, Copy)]
pub struct Faces<'a> {
    /// What all pixels share.
    pub shading: &'a Shading<'a>,
    /// Three vertices a face.
    pub indices: &'a [i32],
    /// The vertices.
    pub records: &'a [Record],
}

/// Shades a band.
pub struct ResolveKernel<'a, 'b> {
    /// What all pixels share.
    pub faces: Faces<'a>,
    /// What may be drawn; rows of this band outside it hold no faces.
    pub view: View,
    /// The band's first row.
    pub y0: i32,
    /// Its rows.
    pub rows: i32,
    /// Pixels in a row of the frame.
    pub width: usize,
    /// Faces of the band's pixels; left empty.
    pub ids: &'b mut [i32],
    /// The band's RGBA bytes.
    pub bytes: &'b mut [u8],
}

impl Kernel for ResolveKernel<'_, '_> {
    /// Pixels shaded.
    type Output = u64;

    #[inline(always)]
    fn run<S: Simd>(self, s: S) -> u64 {
        let lanes = S::LANES as i32;
        let mut shaded = 0;
        let empty = s.splat_i(NO_FACE);
        for y in self.view.y0.max(self.y0)..self.view.y1.min(self.y0 + self.rows) {
            let row = (y - self.y0) as usize * self.width;
            let mut x = self.view.x0;
            while x < self.view.x1 {
                let start = x.min(self.width as i32 - lanes);
                let at = row + start as usize;
                let faces = s.load_i(&self.ids[at..at + S::LANES]);
                let seen = faces.gt(empty);
                x += lanes;
                if !seen.any() {
                    continue;
                }
                s.store_i(empty, &mut self.ids[at..at + S::LANES]);
                shaded += seen.bits().count_ones() as u64;
                let plain = (faces & s.splat_i(PLAIN_BIT)).gt(s.splat_i(0)) & seen;
                let fast = seen & !plain;
                let target = &mut self.bytes[at * 4..(at + S::LANES) * 4];
                let mut left = plain.bits();
                if fast.any() {
                    let (color, delicate) = self.faces.pixels(s, fast, faces, start, y);
                    s.store_masked_bytes(fast & !delicate, color, target);
                    left |= (fast & delicate).bits();
                }
                if left != 0 {
                    let mut numbers = [0; 16];
                    s.store_i(faces, &mut numbers[..S::LANES]);
                    for lane in (0..S::LANES).filter(|lane| left >> lane & 1 != 0) {
                        let face = (numbers[lane] & !PLAIN_BIT) as u32;
                        let color = (self.faces.shading.plain)(face, start + lane as i32, y);
                        target[lane * 4..lane * 4 + 4].copy_from_slice(&color);
                    }
                }
            }
        }
        shaded
    }
}

impl Faces<'_> {
    /// The packed colours of the pixels (x.., y) where `mask` is set, and where f32 lacks the digits.
    #[inline(always)]
    fn pixels<S: Simd>(&self, s: S, mask: S::M, faces: S::I, x: i32, y: i32) -> (S::I, S::M) {
        let shading = self.shading;
        if shading.mode == Mode::Constant {
            return (pack(s, splat3(s, shading.lighting.base)), s.mask(0));
        }
        let at = s.select_i(mask, faces, s.splat_i(0)) * s.splat_i(3);
        let c0 = s.gather_i(mask, self.indices, at);
        let c1 = s.gather_i(mask, self.indices, at + s.splat_i(1));
        let c2 = s.gather_i(mask, self.indices, at + s.splat_i(2));
        let r0 = s.gather4(mask, self.records, c0);
        let r1 = s.gather4(mask, self.records, c1);
        let r2 = s.gather4(mask, self.records, c2);
        let column = s.iota() + s.splat_i(x);
        let px = column.shl::<16>() + s.splat_i(1 << 15);
        let py = s.splat_i((y << 16) + (1 << 15));
        let (d0, d1, d2) = (offset(s, r0, px, py), offset(s, r1, px, py), offset(s, r2, px, py));
        let (e0, e1, e2) = (cross::<S>(d1, d2), cross::<S>(d2, d0), cross::<S>(d0, d1));
        let area = (e0 + e1) + e2;
        let zero = s.splat(0.0);
        let reach2 = distance2::<S>(d0, d1).max(distance2::<S>(d1, d2)).max(distance2::<S>(d2, d0));
        let delicate = mask & !(reach2.le(area.abs() * s.splat(shading.slenderest)) & zero.lt(reach2));
        let is_turned = area.lt(zero);
        let e0 = s.select(is_turned, -e0, e0).max(zero);
        let e1 = s.select(is_turned, -e1, e1).max(zero);
        let e2 = s.select(is_turned, -e2, e2).max(zero);
        let (p0, p1, p2) = match shading.is_affine {
            true => (e0, e1, e2),
            false => (e0 * r0[3], e1 * r1[3], e2 * r2[3]),
        };
        let inverse = s.splat(1.0) / ((p0 + p1) + p2);
        let corners = [c0, c1, c2];
        let b = [p0 * inverse, p1 * inverse, p2 * inverse];
        if shading.mode == Mode::Colors {
            return (pack(s, blend(s, mask, shading.colors, corners, b)), delicate);
        }
        let n = blend(s, mask, shading.normals, corners, b);
        let length2 = dot::<S>(n, n);
        // Normals that cancel fall back to the face's, in f64.
        let delicate = delicate | (mask & length2.lt(s.splat(1e-4)));
        let n_inverse = s.splat(1.0) / length2.sqrt();
        let normal = scale::<S>(n, n_inverse);
        let (position, to_viewer) = match shading.eye {
            Eye::Perspective { ray } => {
                let w = ((e0 + e1) + e2) * inverse;
                let (column, row) = (column.to_f32(), s.splat(y as f32));
                let ray = [
                    s.splat(ray[0][0]) + (s.splat(ray[1][0]) * column + s.splat(ray[2][0]) * row),
                    s.splat(ray[0][1]) + (s.splat(ray[1][1]) * column + s.splat(ray[2][1]) * row),
                    s.splat(ray[0][2]) + (s.splat(ray[1][2]) * column + s.splat(ray[2][2]) * row),
                ];
                let back = s.splat(-1.0) / dot::<S>(ray, ray).sqrt();
                (scale::<S>(ray, w), scale::<S>(ray, back))
            }
            Eye::Parallel { to_viewer } => {
                (blend(s, mask, shading.positions, corners, b), splat3(s, to_viewer))
            }
        };
        let Lit { matte, gloss } = light(s, shading.lighting, position, normal, to_viewer);
        (pack(s, [matte[0] + gloss[0], matte[1] + gloss[1], matte[2] + gloss[2]]), delicate)
    }
}

// Helpers are functions marked for inlining, not closures: a closure would be compiled without the level's instructions.

/// From the pixel's centre to a record's position, in 1/65536 pixel; the floor in the record is half a unit low.
#[inline(always)]
fn offset<S: Simd>(s: S, r: [S::F; 4], px: S::I, py: S::I) -> [S::F; 2] {
    let half = s.splat(0.5);
    [(r[0].bits() - px).to_f32() + half, (r[1].bits() - py).to_f32() + half]
}

#[inline(always)]
fn cross<S: Simd>(a: [S::F; 2], b: [S::F; 2]) -> S::F {
    a[0] * b[1] - b[0] * a[1]
}

#[inline(always)]
fn distance2<S: Simd>(a: [S::F; 2], b: [S::F; 2]) -> S::F {
    let (x, y) = (a[0] - b[0], a[1] - b[1]);
    x * x + y * y
}

/// Three numbers of a table's records at the corners, weighed.
#[inline(always)]
fn blend<S: Simd>(s: S, mask: S::M, table: &[[f32; 4]], corners: [S::I; 3], b: [S::F; 3]) -> V3<S> {
    let v0 = s.gather4(mask, table, corners[0]);
    let v1 = s.gather4(mask, table, corners[1]);
    let v2 = s.gather4(mask, table, corners[2]);
    [
        (v0[0] * b[0] + v1[0] * b[1]) + v2[0] * b[2],
        (v0[1] * b[0] + v1[1] * b[1]) + v2[1] * b[2],
        (v0[2] * b[0] + v1[2] * b[1]) + v2[2] * b[2],
    ]
}

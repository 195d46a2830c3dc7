//! Visibility where depth is stored as whole numbers or reversed: what f32 does not carry is worked in f64, lane by lane.
//!
//! In: faces as [`super::setup`] left them (coverage is the same in every format) and each vertex's place and depth in f64:
//! z/w, or (w-z)/w free of cancellation for the reversed format. Out: the words that the format stores, at each pixel from the
//! face's own plane through its unsnapped corners, kept between its corners' depths:
//!
//! ```text
//! d(x, y) = da + (dx (x + 1/2 - xa) + dy (y + 1/2 - ya))     a = the corner that comes first by its position
//! word    = floor(scale d + 1/2)   or   not bits(f32(d))
//! ```
//!
//! Every pixel is worked for itself, so neither threads, tiles nor lanes matter. Twin in f32: [`super::raster`].

use super::bins::{Bin, Place, Small, Tiny};
use super::raster::Tile;
use super::resolve::WIDE_BIT;
use super::vertex::{ToScreen, WIDTH, affine, is_wanted};
use super::wide::WideFace;
use crate::math::coverage::PixelRect;
use crate::memory::DepthFormat;
use crate::simd::{I32, Kernel, Mask, Simd};
use std::sync::atomic::AtomicU8;

/// A vertex: column and row in pixels, and its depth as the format counts it.
pub type DeepVertex = [f64; 4];

/// How a format makes words of depths.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Form {
    /// What z is multiplied by; unused when reversed.
    scale: f64,
    /// Whether depth is 1 - z and words are the inverted bits of its f32.
    pub is_reversed: bool,
    /// What makes signed numbers of words, in the same order.
    flip: i32,
}

impl Form {
    /// The form of a format; `None` for f32, which has kernels of its own.
    pub fn of(format: DepthFormat) -> Option<Form> {
        let fixed = |scale, flip| Some(Form { scale, is_reversed: false, flip });
        match format {
            DepthFormat::U16 => fixed(65_535.0, 0),
            DepthFormat::U24 => fixed(16_777_215.0, 0),
            DepthFormat::U32 => fixed(4_294_967_295.0, i32::MIN),
            DepthFormat::Reversed => Some(Form { scale: 0.0, is_reversed: true, flip: 0 }),
            DepthFormat::F32 => None,
        }
    }

    /// The word of a depth in 0..=1, as [`DepthFormat::encode`] makes it.
    #[inline(always)]
    fn word(&self, depth: f64) -> i32 {
        if self.is_reversed { !(depth as f32).to_bits() as i32 } else { fixed(depth, self.scale) }
    }

    /// The words of depths in 0..=1.
    #[inline(always)]
    fn words<S: Simd>(&self, s: S, depths: &[f64; 16]) -> S::I {
        let mut words = [0i32; 16];
        if self.is_reversed {
            for i in 0..S::LANES {
                words[i] = !(depths[i] as f32).to_bits() as i32;
            }
        } else {
            for i in 0..S::LANES {
                words[i] = fixed(depths[i], self.scale);
            }
        }
        s.load_i(&words[..S::LANES])
    }

    /// Where `word` is nearer than `old`.
    #[inline(always)]
    pub fn is_nearer<S: Simd>(&self, s: S, word: S::I, old: S::I) -> S::M {
        let flip = s.splat_i(self.flip);
        (old ^ flip).gt(word ^ flip)
    }
}

/// floor(scale * depth + 1/2) without a conversion that has to look at its range.
#[inline(always)]
fn fixed(depth: f64, scale: f64) -> i32 {
    // Adding 2^52 rounds to a whole number, which is then in the low bits.
    const WHOLE: f64 = 4_503_599_627_370_496.0;
    let t = depth * scale + 0.5;
    let r = t + WHOLE;
    (r.to_bits() as u32).wrapping_sub((r - WHOLE > t) as u32) as i32
}

/// Works out the deep vertices of a run of positions.
pub struct DeepVertexKernel<'a> {
    /// Object-space x, y, z.
    pub positions: [&'a [f64]; 3],
    /// The matrices.
    pub to_screen: &'a ToScreen,
    /// The row that takes view space to z of clip space, or to w - z.
    pub row: [f64; 4],
    /// See [`super::vertex::VertexKernel`].
    pub marks: &'a [AtomicU8],
    /// One a position; what has no place on the screen is not a number.
    pub out: &'a mut [DeepVertex],
}

impl Kernel for DeepVertexKernel<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _: S) {
        let count = self.out.len();
        let mut start = 0;
        while start < count {
            let n = (count - start).min(WIDTH);
            if !is_wanted(self.marks, start / WIDTH) {
                start += WIDTH;
                continue;
            }
            let mut p = [[0.0; WIDTH]; 3];
            for (lanes, from) in p.iter_mut().zip(self.positions) {
                lanes[..n].copy_from_slice(&from[start..start + n]);
            }
            let vertices = deep_vertices(self.to_screen, self.row, &p);
            self.out[start..start + n].copy_from_slice(&vertices[..n]);
            start += WIDTH;
        }
    }
}

#[inline(always)]
fn deep_vertices(t: &ToScreen, row: [f64; 4], p: &[[f64; WIDTH]; 3]) -> [DeepVertex; WIDTH] {
    let p = [&p[0], &p[1], &p[2]];
    let [m0, m1, m2] = t.model;
    let world = [affine(m0, p), affine(m1, p), affine(m2, p)];
    let world = [&world[0], &world[1], &world[2]];
    let [v0, v1, v2] = t.view;
    let view = [affine(v0, world), affine(v1, world), affine(v2, world)];
    let view = [&view[0], &view[1], &view[2]];
    let [p0, p1, _, p3] = t.projection;
    let (x, y, d, w) = (affine(p0, view), affine(p1, view), affine(row, view), affine(p3, view));
    let mut out = [[0.0; 4]; WIDTH];
    for i in 0..WIDTH {
        out[i] =
            [t.center[0] + x[i] / w[i] * t.half[0], t.center[1] + y[i] / w[i] * t.half[1], d[i] / w[i], 0.0];
    }
    out
}

/// Depth over the screen, as the format counts it.
#[derive(Clone, Copy, Debug)]
struct DeepPlane {
    /// Where `base` holds, in pixels.
    origin: [f64; 2],
    base: f64,
    /// Per column, per row.
    run: [f64; 2],
    /// The corners' depths, the least and the greatest.
    range: [f64; 2],
}

impl DeepPlane {
    /// The plane through three corners: the same in any order of theirs.
    #[inline(always)]
    fn through(corners: [DeepVertex; 3]) -> DeepPlane {
        let [a, b, c] = corners;
        let (a, b) = in_order(a, b);
        let (b, c) = in_order(b, c);
        let (a, b) = in_order(a, b);
        let (bx, by, bd) = (b[0] - a[0], b[1] - a[1], b[2] - a[2]);
        let (cx, cy, cd) = (c[0] - a[0], c[1] - a[1], c[2] - a[2]);
        let det = bx * cy - cx * by;
        DeepPlane {
            origin: [a[0], a[1]],
            base: a[2],
            run: [(bd * cy - cd * by) / det, (cd * bx - bd * cx) / det],
            range: [lesser(lesser(a[2], b[2]), c[2]), greater(greater(a[2], b[2]), c[2])],
        }
    }

    /// The plane that the plain path has set up.
    #[inline(always)]
    fn of_wide(wide: &WideFace, form: &Form) -> DeepPlane {
        let linear = &wide.plane;
        let ([base, x, y], range) = match form.is_reversed {
            true => (linear.complement, wide.exact_ranges[1]),
            false => (linear.z, wide.exact_ranges[0]),
        };
        DeepPlane { origin: linear.origin, base, run: [x, y], range }
    }

    /// Depth at the centre of pixel (x, y); what is not a number, on a face without area, is the nearest corner's.
    #[inline(always)]
    fn at(&self, x: i32, y: i32) -> f64 {
        let along = self.run[0] * (x as f64 + 0.5 - self.origin[0]);
        let down = self.run[1] * (y as f64 + 0.5 - self.origin[1]);
        lesser(greater(self.base + (along + down), self.range[0]), self.range[1])
    }

    /// Depths at LANES pixels from (x, y) on.
    #[inline(always)]
    fn row<S: Simd>(&self, x: i32, y: i32) -> [f64; 16] {
        let down = self.run[1] * (y as f64 + 0.5 - self.origin[1]);
        let mut out = [0.0; 16];
        for (i, lane) in out[..S::LANES].iter_mut().enumerate() {
            let along = self.run[0] * ((x + i as i32) as f64 + 0.5 - self.origin[0]);
            *lane = lesser(greater(self.base + (along + down), self.range[0]), self.range[1]);
        }
        out
    }
}

/// The lesser of two; the second when one is not a number.
#[inline(always)]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// The greater of two; the second when one is not a number.
#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn in_order(p: DeepVertex, q: DeepVertex) -> (DeepVertex, DeepVertex) {
    let swap = p[0] > q[0] || (p[0] == q[0] && p[1] > q[1]);
    if swap { (q, p) } else { (p, q) }
}

/// Words in 0..=1 of depths that the plane may have left a little, and which of them lie between near and far.
#[inline(always)]
fn words_between<S: Simd>(s: S, form: &Form, depths: &mut [f64; 16]) -> (S::I, S::M) {
    let mut inside = 0u32;
    for (i, lane) in depths[..S::LANES].iter_mut().enumerate() {
        let d = *lane;
        // Closed at near, open at far.
        let is_inside = if form.is_reversed { d > 0.0 && d <= 1.0 } else { (0.0..1.0).contains(&d) };
        inside |= (is_inside as u32) << i;
        *lane = lesser(greater(d, 0.0), 1.0);
    }
    (form.words(s, depths), s.mask(inside))
}

/// The words of a wide face at LANES pixels from (x, y) on, and where they lie between near and far.
#[inline(always)]
pub(super) fn wide_words<S: Simd>(s: S, form: &Form, wide: &WideFace, x: i32, y: i32) -> (S::I, S::M) {
    let mut depths = DeepPlane::of_wide(wide, form).row::<S>(x, y);
    let (words, inside) = words_between(s, form, &mut depths);
    (words, if wide.is_between { s.mask(u32::MAX) } else { inside })
}

/// Draws one chunk's share of a tile.
pub struct DeepRasterKernel<'a, 'b> {
    /// The chunk's faces in this tile.
    pub bin: &'a Bin,
    /// The chunk's wide faces.
    pub wide: &'a [WideFace],
    /// The three vertices of each face.
    pub corners: &'a [[f32; 4]],
    /// The vertices.
    pub vertices: &'a [DeepVertex],
    /// How words are made.
    pub form: Form,
    /// The tile; its own depth words are not looked at.
    pub tile: &'a mut Tile<'b>,
    /// The words of the tile's rows,
    pub words: &'a mut [i32],
    /// so many in a row,
    pub stride: usize,
    /// the first of them of this column.
    pub first_column: i32,
}

impl Kernel for DeepRasterKernel<'_, '_> {
    /// Fragments tested (those of tiny faces were counted when they were set up) and passed.
    type Output = (u64, u64);

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) -> (u64, u64) {
        let (mut tested, mut passed) = (0, 0);
        let bin = self.bin;
        let mut drawn = 0;
        for larger in &bin.larger {
            // The tiny faces up to this larger one.
            let until = larger.tiny_before as usize;
            for words in &bin.tiny[drawn..until] {
                passed += self.tiny(s, &Tiny::of(*words));
            }
            drawn = until;
            let (t, p) = match larger.place {
                Place::Small(index) => self.small(s, &bin.small[index as usize]),
                Place::Wide(index) => self.wide(s, &self.wide[index as usize]),
            };
            (tested, passed) = (tested + t, passed + p);
        }
        for words in &bin.tiny[drawn..] {
            passed += self.tiny(s, &Tiny::of(*words));
        }
        (tested, passed)
    }
}

impl DeepRasterKernel<'_, '_> {
    /// The plane of a face with records.
    #[inline(always)]
    fn plane(&self, face: u32) -> DeepPlane {
        let [a, b, c, _] = self.corners[face as usize];
        let at = |corner: f32| self.vertices[corner.to_bits() as usize];
        DeepPlane::through([at(a), at(b), at(c)])
    }

    #[inline(always)]
    fn word_at(&self, x: i32, y: i32) -> usize {
        (y - self.tile.y0) as usize * self.stride + (x - self.first_column) as usize
    }

    /// The depth test at LANES pixels from (x, y) on, where `covered`; how many passed.
    #[inline(always)]
    fn write<S: Simd>(&mut self, s: S, (x, y): (i32, i32), covered: S::M, word: S::I, id: S::I) -> u64 {
        let at = self.word_at(x, y);
        let words = &mut self.words[at..at + S::LANES];
        let old = s.load_i(words);
        let passes = covered & self.form.is_nearer(s, word, old);
        s.store_i(s.select_i(passes, word, old), words);
        let at = self.tile.id_at(x, y);
        let ids = &mut self.tile.ids[at..at + S::LANES];
        s.store_i(s.select_i(passes, id, s.load_i(ids)), ids);
        passes.bits().count_ones() as u64
    }

    /// A face whose coverage is known.
    #[inline(always)]
    fn tiny<S: Simd>(&mut self, s: S, face: &Tiny) -> u64 {
        let lanes = S::LANES as i32;
        let (x0, y0) = (face.at[0] as i32, face.at[1] as i32);
        let rows = (self.tile.y0 - y0).max(0)..(face.size[1] as i32).min(self.tile.y1 - y0);
        let plane = self.plane(face.face);
        if face.mask & (face.mask - 1) == 0 {
            // One pixel: the same sums without vectors.
            let bit = face.mask.trailing_zeros() as i32;
            let (x, y) = (x0 + (bit & 7), y0 + (bit >> 3));
            if !rows.contains(&(bit >> 3)) || x < self.tile.x0 || x >= self.tile.x1 {
                return 0;
            }
            let word = self.form.word(lesser(greater(plane.at(x, y), 0.0), 1.0));
            let (at, flip) = (self.word_at(x, y), self.form.flip);
            if self.words[at] ^ flip <= word ^ flip {
                return 0;
            }
            self.words[at] = word;
            self.tile.ids[self.tile.id_at(x, y)] = face.face as i32;
            return 1;
        }
        let id = s.splat_i(face.face as i32);
        let mut passed = 0;
        let mut x = x0.max(self.tile.x0);
        let right = (x0 + face.size[0] as i32).min(self.tile.x1);
        while x < right {
            // A vector that would leave the tile begins further left.
            let start = x.min(self.tile.x1 - lanes);
            let fresh = u32::MAX << (x - start) & (u32::MAX >> (32 - lanes));
            for row in rows.clone() {
                // From 15 columns to the right of the face's first to 8 to its left.
                let bits = (((face.mask >> (8 * row)) & 0xff) << 16 >> (16 + start - x0)) as u32 & fresh;
                if bits != 0 {
                    let (word, _) = words_between(s, &self.form, &mut plane.row::<S>(start, y0 + row));
                    passed += self.write(s, (start, y0 + row), s.mask(bits), word, id);
                }
            }
            x = start + lanes;
        }
        passed
    }

    /// A face whose edge functions fit i32; fragments tested and passed.
    #[inline(always)]
    fn small<S: Simd>(&mut self, s: S, face: &Small) -> (u64, u64) {
        let [x0, y0, x1, y1] = face.bounds.map(i32::from);
        let rows = y0.max(self.tile.y0)..y1.min(self.tile.y1);
        let right = x1.min(self.tile.x1);
        let lanes = S::LANES as i32;
        let id = s.splat_i(face.face as i32);
        let [dx0, dx1, dx2] = face.steps_x;
        let [dy0, dy1, dy2] = face.steps_y;
        let plane = self.plane(face.face);
        let (mut tested, mut passed) = (0, 0);
        let mut x = x0.max(self.tile.x0);
        while x < right {
            let start = x.min(self.tile.x1 - lanes);
            let column = s.iota() + s.splat_i(start - x0);
            let down = rows.start - y0;
            let mut e0 = s.splat_i(dx0) * column + s.splat_i(face.edges[0] + dy0 * down);
            let mut e1 = s.splat_i(dx1) * column + s.splat_i(face.edges[1] + dy1 * down);
            let mut e2 = s.splat_i(dx2) * column + s.splat_i(face.edges[2] + dy2 * down);
            let to = (right - start).min(lanes);
            let inside_columns = s.mask((u32::MAX << (x - start)) & (((1u64 << to) - 1) as u32));
            for y in rows.clone() {
                let covered = (e0 | e1 | e2).gt(s.splat_i(-1)) & inside_columns;
                (e0, e1, e2) = (e0 + s.splat_i(dy0), e1 + s.splat_i(dy1), e2 + s.splat_i(dy2));
                if !covered.any() {
                    continue;
                }
                tested += covered.bits().count_ones() as u64;
                let (word, _) = words_between(s, &self.form, &mut plane.row::<S>(start, y));
                passed += self.write(s, (start, y), covered, word, id);
            }
            x = start + lanes;
        }
        (tested, passed)
    }

    /// A face that the plain path has set up; fragments tested and passed.
    #[inline(always)]
    fn wide<S: Simd>(&mut self, s: S, wide: &WideFace) -> (u64, u64) {
        let lanes = S::LANES as i32;
        let b = wide.bounds;
        let clip = PixelRect {
            x0: b.x0.max(self.tile.x0),
            y0: b.y0.max(self.tile.y0),
            x1: b.x1.min(self.tile.x1),
            y1: b.y1.min(self.tile.y1),
        };
        let id = s.splat_i(wide.face as i32 | WIDE_BIT);
        let (mut tested, mut passed) = (0, 0);
        for outline in wide.outlines.iter().flatten() {
            let mut spans = [const { (0, 0..0) }; super::wide::SPANS];
            let count = super::wide::spans_of(outline, clip, &mut spans);
            for (y, span) in &spans[..count] {
                tested += span.len() as u64;
                let mut x = span.start;
                while x < span.end {
                    let start = (x & !(lanes - 1)).min(self.tile.x1 - lanes);
                    let (from, to) = (x - start, (span.end - start).min(lanes));
                    let covered = s.mask((u32::MAX << from) & (((1u64 << to) - 1) as u32));
                    let (word, inside) = wide_words(s, &self.form, wide, start, *y);
                    passed += self.write(s, (start, *y), covered & inside, word, id);
                    x = start + lanes;
                }
            }
        }
        (tested, passed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_those_that_the_memory_encodes() {
        for format in DepthFormat::ALL {
            let Some(form) = Form::of(format) else { continue };
            let mut words = Vec::new();
            for i in 0..=20_000 {
                // Ties of every format are among them.
                let z = match i % 3 {
                    0 => i as f64 / 20_000.0,
                    1 => (i as f64 + 0.5) / 65_535.0,
                    _ => 1.0 - (i as f64) * 2f64.powi(-40),
                };
                let depth = if form.is_reversed { 1.0 - z } else { z };
                let word = form.word(depth);
                assert_eq!(word as u32, format.encode(z, depth), "{format:?} of {z}");
                words.push((z, word ^ form.flip));
            }
            words.sort_by(|a, b| a.0.total_cmp(&b.0));
            assert!(words.is_sorted_by_key(|w| w.1), "{format:?}: nearer words are smaller");
        }
    }

    #[test]
    fn a_plane_is_the_same_whatever_corner_comes_first() {
        let corners = [[3.25, 7.5, 0.25, 0.0], [90.0, 11.0, 0.75, 0.0], [3.25, 70.125, 0.5, 0.0]];
        let [a, b, c] = corners;
        let plane = DeepPlane::through(corners);
        for other in [[a, c, b], [b, a, c], [b, c, a], [c, a, b], [c, b, a]] {
            let other = DeepPlane::through(other);
            for (x, y) in [(4, 8), (50, 20), (4, 60)] {
                assert_eq!(plane.at(x, y).to_bits(), other.at(x, y).to_bits());
            }
        }
        // Without area there is no plane, but a depth.
        let flat = DeepPlane::through([a, a, a]);
        assert_eq!(flat.at(100, 100), 0.25);
    }
}

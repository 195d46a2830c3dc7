//! Rasterization for depth formats in fixed point or reversed: depth is evaluated in f64, lane by
//! lane.
//!
//! In: faces as [`super::setup`] made them (coverage is equal in every format) and each vertex's
//! position and depth in f64: z/w, or (w-z)/w free of cancellation for the reversed format. Out:
//! the words that the format stores, at each pixel from the face's own plane through its unsnapped
//! corners, clamped to its corners' depths:
//!
//! ```text
//! d(x, y) = da + (dx (x + 1/2 - xa) + dy (y + 1/2 - ya))     a = the corner that comes first by its position
//! word    = floor(scale d + 1/2)   or   not bits(f32(d))
//! ```
//!
//! Every pixel is evaluated independently, so neither threads, tiles nor lanes matter. The version
//! in f32 is [`super::raster`].

mod encoder;
mod plane;
mod vertices;

pub use encoder::DepthEncoder;
pub(super) use plane::exact_words;
pub use vertices::{DepthVertex, DepthVertexKernel};

use super::bins::{Bin, Small, Tiny};
use super::edges::Edges;
use super::exact_faces::{self, ExactFace, MOST_STACKED};
use super::raster::Tile;
use super::resolve::EXACT_FACE_BIT;
use super::traverse::{FaceRaster, RasterStats, traverse};
use crate::math::coverage::{Filling, PixelRect};
use crate::simd::{I32, Kernel, Mask, Simd};
use plane::DepthPlane;

/// Rasterizes the faces of one chunk in a tile.
pub struct DepthRasterKernel<'a, 'b> {
    /// Bin of the chunk's faces in this tile.
    pub bin: &'a Bin,
    /// The chunk's exact faces.
    pub exact_faces: &'a [ExactFace],
    /// Vertex indices of each face.
    pub corners: &'a [[f32; 4]],
    /// Vertices with their depths in f64.
    pub vertices: &'a [DepthVertex],
    /// Encoder of the depth format.
    pub encoder: DepthEncoder,
    /// Tile to draw; its own depth words are not used.
    pub tile: &'a mut Tile<'b>,
    /// Depth words of the tile's rows.
    pub words: &'a mut [i32],
    /// Number of words in a row.
    pub stride: usize,
    /// Column of the first word of a row.
    pub first_column: i32,
}

impl Kernel for DepthRasterKernel<'_, '_> {
    type Output = RasterStats;

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) -> RasterStats {
        traverse(s, self.bin, self.exact_faces, &mut self)
    }
}

impl DepthRasterKernel<'_, '_> {
    /// Returns the depth plane of a face with screen vertices.
    #[inline(always)]
    fn plane(&self, face: u32) -> DepthPlane {
        let [a, b, c, _] = self.corners[face as usize];
        let at = |corner: f32| self.vertices[corner.to_bits() as usize];
        DepthPlane::through([at(a), at(b), at(c)])
    }

    #[inline(always)]
    fn word_at(&self, x: i32, y: i32) -> usize {
        (y - self.tile.y0) as usize * self.stride + (x - self.first_column) as usize
    }

    /// Tests depth at LANES pixels from (x, y) on, where `covered`; writes word and id where it
    /// passes. Returns how many passed.
    #[inline(always)]
    fn write<S: Simd>(&mut self, s: S, (x, y): (i32, i32), covered: S::M, word: S::I, id: S::I) -> u64 {
        let at = self.word_at(x, y);
        let words = &mut self.words[at..at + S::LANES];
        let old = s.load_i(words);
        let passes = covered & self.encoder.is_nearer(s, word, old);
        s.store_i(s.select_i(passes, word, old), words);
        let at = self.tile.id_at(x, y);
        let ids = &mut self.tile.ids[at..at + S::LANES];
        s.store_i(s.select_i(passes, id, s.load_i(ids)), ids);
        passes.bits().count_ones() as u64
    }

    /// Tests depth at one pixel; writes word and id if it passes, and returns whether it did.
    #[inline(always)]
    fn write_one(&mut self, (x, y): (i32, i32), word: i32, id: i32) -> bool {
        let (at, flip) = (self.word_at(x, y), self.encoder.flip());
        if self.words[at] ^ flip <= word ^ flip {
            return false;
        }
        self.words[at] = word;
        self.tile.ids[self.tile.id_at(x, y)] = id;
        true
    }
}

impl FaceRaster for DepthRasterKernel<'_, '_> {
    #[inline(always)]
    fn fragment(&mut self, [at, _, face]: [i32; 3]) -> bool {
        let (x, y) = (at & 0xffff, at >> 16);
        let word = self.encoder.word(self.plane(face as u32).at(x, y));
        self.write_one((x, y), word, face)
    }
    #[inline(always)]
    fn tiny<S: Simd>(&mut self, s: S, face: &Tiny) -> u64 {
        let lanes = S::LANES as i32;
        let (x0, y0) = (face.at[0] as i32, face.at[1] as i32);
        let rows = (self.tile.y0 - y0).max(0)..(face.size[1] as i32).min(self.tile.y1 - y0);
        let plane = self.plane(face.face);
        if face.mask & (face.mask - 1) == 0 {
            // One pixel: equal sums without vectors.
            let bit = face.mask.trailing_zeros() as i32;
            let (x, y) = (x0 + (bit & 7), y0 + (bit >> 3));
            if !rows.contains(&(bit >> 3)) || x < self.tile.x0 || x >= self.tile.x1 {
                return 0;
            }
            let word = self.encoder.word(plane.at(x, y));
            return u64::from(self.write_one((x, y), word, face.face as i32));
        }
        let id = s.splat_i(face.face as i32);
        let mut passed = 0;
        let mut x = x0.max(self.tile.x0);
        let right = (x0 + face.size[0] as i32).min(self.tile.x1);
        while x < right {
            // A vector that would leave the tile starts further left.
            let start = x.min(self.tile.x1 - lanes);
            let fresh = u32::MAX << (x - start) & (u32::MAX >> (32 - lanes));
            for row in rows.clone() {
                // The shift ranges from 15 columns right of the face's first to 8 columns left of
                // it.
                let bits = (((face.mask >> (8 * row)) & 0xff) << 16 >> (16 + start - x0)) as u32 & fresh;
                if bits != 0 {
                    let word = self.encoder.words(s, &plane.row::<S>(start, plane.down(y0 + row)));
                    passed += self.write(s, (start, y0 + row), s.mask(bits), word, id);
                }
            }
            x = start + lanes;
        }
        passed
    }

    #[inline(always)]
    fn small<S: Simd>(&mut self, s: S, face: &Small) -> (u64, u64) {
        let [x0, y0, x1, y1] = face.bounds.map(i32::from);
        let rows = y0.max(self.tile.y0)..y1.min(self.tile.y1);
        let right = x1.min(self.tile.x1);
        let lanes = S::LANES as i32;
        let id = s.splat_i(face.face as i32);
        let plane = self.plane(face.face);
        let (mut tested, mut passed) = (0, 0);
        let mut x = x0.max(self.tile.x0);
        while x < right {
            let start = x.min(self.tile.x1 - lanes);
            let mut edges = Edges::new(s, face, start, x..right, rows.start);
            for y in rows.clone() {
                let covered = edges.covered(s);
                if !covered.any() {
                    continue;
                }
                tested += covered.bits().count_ones() as u64;
                let word = self.encoder.words(s, &plane.row::<S>(start, plane.down(y)));
                passed += self.write(s, (start, y), covered, word, id);
            }
            x = start + lanes;
        }
        (tested, passed)
    }

    #[inline(always)]
    fn exact_face<S: Simd>(&mut self, s: S, exact_face: &ExactFace) -> (u64, u64) {
        let lanes = S::LANES as i32;
        let b = exact_face.bounds;
        let clip = PixelRect {
            x0: b.x0.max(self.tile.x0),
            y0: b.y0.max(self.tile.y0),
            x1: b.x1.min(self.tile.x1),
            y1: b.y1.min(self.tile.y1),
        };
        let id = s.splat_i(exact_face.face as i32 | EXACT_FACE_BIT);
        let (mut tested, mut passed) = (0, 0);
        for outline in exact_face.outlines.iter().flatten() {
            let mut spans = [const { (0, 0..0) }; super::exact_faces::SPANS];
            let count = super::exact_faces::spans_of(outline, clip, &mut spans);
            for (y, span) in &spans[..count] {
                tested += span.len() as u64;
                let mut x = span.start;
                while x < span.end {
                    let start = (x & !(lanes - 1)).min(self.tile.x1 - lanes);
                    let (from, to) = (x - start, (span.end - start).min(lanes));
                    let covered = s.mask((u32::MAX << from) & (((1u64 << to) - 1) as u32));
                    let (word, inside) = exact_words(s, &self.encoder, exact_face, start, *y);
                    passed += self.write(s, (start, *y), covered & inside, word, id);
                    x = start + lanes;
                }
            }
        }
        (tested, passed)
    }

    #[inline(always)]
    fn filling(&self, face: &ExactFace) -> Filling {
        exact_faces::tile_filling(face, self.tile)
    }

    /// A pixel's word and face stay in registers until all faces are tested; terms that are
    /// constant along a row are evaluated once.
    #[inline(always)]
    fn stack<S: Simd>(&mut self, s: S, faces: &[&ExactFace]) -> u64 {
        let count = faces.len().min(MOST_STACKED);
        let (x0, width) = (self.tile.x0, (self.tile.x1 - self.tile.x0) as usize);
        let mut planes = [DepthPlane::NOWHERE; MOST_STACKED];
        let mut ids = [0; MOST_STACKED];
        let mut is_level = true;
        for (i, face) in faces[..count].iter().enumerate() {
            planes[i] = DepthPlane::of_wide(face, &self.encoder);
            ids[i] = face.face as i32 | EXACT_FACE_BIT;
            is_level &= planes[i].is_level();
        }
        let flip = s.splat_i(self.encoder.flip());
        let mut passed = 0;
        for y in self.tile.y0..self.tile.y1 {
            let (at, word_at) = (self.tile.id_at(x0, y), self.word_at(x0, y));
            let row_ids = &mut self.tile.ids[at..at + width];
            let row_words = &mut self.words[word_at..word_at + width];
            let mut level = [0; MOST_STACKED];
            let mut down = [0.0; MOST_STACKED];
            for i in 0..count {
                down[i] = planes[i].down(y);
                if is_level {
                    level[i] = self.encoder.word(planes[i].at(x0, y)) ^ self.encoder.flip();
                }
            }
            let mut column = 0;
            while column < width {
                let old = &mut row_words[column..column + S::LANES];
                let own = &mut row_ids[column..column + S::LANES];
                let (mut nearest, mut id) = (s.load_i(old) ^ flip, s.load_i(own));
                let mut i = 0;
                if is_level {
                    while i < count {
                        let new = s.splat_i(level[i]);
                        let passes = nearest.gt(new);
                        (nearest, id) = (nearest.min(new), s.select_i(passes, s.splat_i(ids[i]), id));
                        passed += passes.bits().count_ones() as u64;
                        i += 1;
                    }
                }
                while i < count {
                    let depths = planes[i].row::<S>(x0 + column as i32, down[i]);
                    let new = self.encoder.words(s, &depths) ^ flip;
                    let passes = nearest.gt(new);
                    (nearest, id) = (nearest.min(new), s.select_i(passes, s.splat_i(ids[i]), id));
                    passed += passes.bits().count_ones() as u64;
                    i += 1;
                }
                s.store_i(nearest ^ flip, old);
                s.store_i(id, own);
                column += S::LANES;
            }
        }
        passed
    }

    #[inline(always)]
    fn pixels(&self) -> u64 {
        self.tile.pixels()
    }
}

#[cfg(test)]
mod tests;

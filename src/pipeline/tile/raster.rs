//! Rasterization for visibility: which face is seen at each pixel of a tile and at which depth.
//!
//! In: the faces set up by every chunk, in order. Out: depth words (the bits of f32, which order as
//! the numbers do) and the index of the face that wrote each. A fragment passes if its depth is
//! strictly less; nothing else decides, so the result does not depend on threads, tiles or lanes.
//! Without a depth buffer every fragment passes.

use super::bins::{Bin, Grid, Small, Tiny};
use super::edges::Edges;
use super::exact_faces::{self, ExactFace};
use super::traverse::{FaceRaster, RasterStats, traverse};
use crate::math::coverage::Filling;
use crate::simd::{F32, I32, Kernel, Mask, Simd, prefetch};

/// Value in a tile's face ids for pixels that no face of this draw covers.
pub const NO_FACE: i32 = -1;

/// Row stride of a tile's face ids; the last tile of a row has fewer columns than this.
pub const ID_STRIDE: usize = 2 * Grid::TILE_COLUMNS as usize;

/// Face ids of a tile, sized for the first-level cache; rows and columns beyond the tile stay
/// [`NO_FACE`].
pub type Ids = [i32; ID_STRIDE * Grid::TILE_ROWS as usize];

/// A tile, and the buffers that one thread writes.
pub struct Tile<'a> {
    /// First pixel column; the tile has at least as many columns as a vector has lanes.
    pub x0: i32,
    /// End of the pixel columns.
    pub x1: i32,
    /// First pixel row.
    pub y0: i32,
    /// End of the pixel rows.
    pub y1: i32,
    /// Width of a row of the frame in pixels.
    pub width: usize,
    /// Depth words of the frame's rows `y0..y1`; empty where depth is neither tested nor stored.
    pub depth: &'a mut [i32],
    /// Face ids of the tile's pixels.
    pub ids: &'a mut Ids,
}

impl Tile<'_> {
    /// Returns the number of pixels.
    #[inline(always)]
    pub fn pixels(&self) -> u64 {
        ((self.x1 - self.x0) * (self.y1 - self.y0)) as u64
    }

    /// Returns the index of a pixel in the face ids.
    #[inline(always)]
    pub fn id_at(&self, x: i32, y: i32) -> usize {
        (y - self.y0) as usize * ID_STRIDE + (x - self.x0) as usize
    }

    /// Returns the index of a pixel in the depth words.
    #[inline(always)]
    pub fn depth_at(&self, x: i32, y: i32) -> usize {
        (y - self.y0) as usize * self.width + x as usize
    }
}

/// Rasterizes the faces of one chunk in a tile.
pub struct RasterKernel<'a, 'b> {
    /// Bin of the chunk's faces in this tile.
    pub bin: &'a Bin,
    /// The chunk's exact faces.
    pub exact_faces: &'a [ExactFace],
    /// Per-face data to prefetch for the resolve of visible faces.
    pub corners: &'a [[f32; 4]],
    /// Tile and its buffers.
    pub tile: &'a mut Tile<'b>,
}

impl Kernel for RasterKernel<'_, '_> {
    type Output = RasterStats;

    #[inline(always)]
    fn run<S: Simd>(mut self, s: S) -> RasterStats {
        traverse(s, self.bin, self.exact_faces, &mut self)
    }
}

impl FaceRaster for RasterKernel<'_, '_> {
    #[inline(always)]
    fn fragment(&mut self, [at, z, face]: [i32; 3]) -> bool {
        prefetch::for_read(self.corners, face as usize);
        let (x, y) = (at & 0xffff, at >> 16);
        if !self.tile.depth.is_empty() {
            let at = self.tile.depth_at(x, y);
            let depth = &mut self.tile.depth[at];
            if *depth <= z {
                return false;
            }
            *depth = z;
        }
        self.tile.ids[self.tile.id_at(x, y)] = face;
        true
    }
    #[inline(always)]
    fn tiny<S: Simd>(&mut self, s: S, face: &Tiny) -> u64 {
        prefetch::for_read(self.corners, face.face as usize);
        tiny(s, face, self.tile)
    }
    #[inline(always)]
    fn small<S: Simd>(&mut self, s: S, face: &Small) -> (u64, u64) {
        small(s, face, self.tile)
    }
    #[inline(always)]
    fn exact_face<S: Simd>(&mut self, s: S, face: &ExactFace) -> (u64, u64) {
        exact_faces::draw(s, face, self.tile)
    }
    #[inline(always)]
    fn filling(&self, face: &ExactFace) -> Filling {
        exact_faces::filling(face, self.tile)
    }
    #[inline(always)]
    fn stack<S: Simd>(&mut self, s: S, faces: &[&ExactFace]) -> u64 {
        exact_faces::stack(s, faces, self.tile)
    }
    #[inline(always)]
    fn pixels(&self) -> u64 {
        self.tile.pixels()
    }
}

/// Tests depth at LANES pixels from (x, y) on, where `covered`; writes z and the face id where it
/// passes. Returns how many passed.
#[inline(always)]
pub(super) fn write<S: Simd>(
    s: S,
    tile: &mut Tile<'_>,
    (x, y): (i32, i32),
    covered: S::M,
    z: S::I,
    id: S::I,
) -> u64 {
    let mut passes = covered;
    if !tile.depth.is_empty() {
        let at = tile.depth_at(x, y);
        let depth = &mut tile.depth[at..at + S::LANES];
        let old = s.load_i(depth);
        passes = covered & old.gt(z);
        s.store_i(s.select_i(passes, z, old), depth);
    }
    let at = tile.id_at(x, y);
    let ids = &mut tile.ids[at..at + S::LANES];
    s.store_i(s.select_i(passes, id, s.load_i(ids)), ids);
    passes.bits().count_ones() as u64
}

/// Draws a tiny face, a row of up to eight pixels at a time; returns how many passed.
#[inline(always)]
fn tiny<S: Simd>(s: S, face: &Tiny, tile: &mut Tile<'_>) -> u64 {
    let lanes = S::LANES as i32;
    let (x0, y0) = (face.at[0] as i32, face.at[1] as i32);
    let rows = (tile.y0 - y0).max(0)..(face.size[1] as i32).min(tile.y1 - y0);
    let [z0, zx, zy] = face.depth;
    if face.mask & (face.mask - 1) == 0 {
        // One pixel: equal sums without vectors.
        let bit = face.mask.trailing_zeros() as i32;
        let (row, column) = (bit >> 3, bit & 7);
        let (x, y) = (x0 + column, y0 + row);
        if !rows.contains(&row) || x < tile.x0 || x >= tile.x1 {
            return 0;
        }
        let z = (z0 + zy * row as f32) + zx * column as f32;
        let z = (z.to_bits() as i32).max(0);
        if !tile.depth.is_empty() {
            let at = tile.depth_at(x, y);
            let depth = &mut tile.depth[at];
            if *depth <= z {
                return 0;
            }
            *depth = z;
        }
        tile.ids[tile.id_at(x, y)] = face.face as i32;
        return 1;
    }
    let id = s.splat_i(face.face as i32);
    let mut passed = 0;
    let mut x = x0.max(tile.x0);
    let right = (x0 + face.size[0] as i32).min(tile.x1);
    while x < right {
        // Aligned to its width, a vector loads what one earlier vector stored, not parts of two.
        // One that would leave the tile starts further left.
        let start = (x & -lanes).min(tile.x1 - lanes);
        let fresh = u32::MAX << (x - start) & (u32::MAX >> (32 - lanes));
        let along = s.splat(zx) * (s.iota() + s.splat_i(start - x0)).to_f32();
        for row in rows.clone() {
            // The shift ranges from 7 columns right of the face's first to 15 columns left of it.
            let bits = (((face.mask >> (8 * row)) & 0xff) << 16 >> (16 + start - x0)) as u32;
            let z = (s.splat(z0 + zy * row as f32) + along).bits().max(s.splat_i(0));
            passed += write(s, tile, (start, y0 + row), s.mask(bits & fresh), z, id);
        }
        x = start + lanes;
    }
    passed
}

/// Draws a face whose edge functions fit i32: a vector of columns at a time, row by row. Returns
/// the fragments tested and passed.
#[inline(always)]
fn small<S: Simd>(s: S, face: &Small, tile: &mut Tile<'_>) -> (u64, u64) {
    let [x0, y0, x1, y1] = face.bounds.map(i32::from);
    let rows = y0.max(tile.y0)..y1.min(tile.y1);
    let right = x1.min(tile.x1);
    let lanes = S::LANES as i32;
    let id = s.splat_i(face.face as i32);
    let [z0, zx, zy] = face.depth;
    let (mut tested, mut passed) = (0, 0);
    let mut x = x0.max(tile.x0);
    while x < right {
        let start = (x & -lanes).min(tile.x1 - lanes);
        let mut edges = Edges::new(s, face, start, x..right, rows.start);
        let along = s.splat(zx) * (s.iota() + s.splat_i(start - x0)).to_f32();
        for y in rows.clone() {
            let covered = edges.covered(s);
            if !covered.any() {
                continue;
            }
            tested += covered.bits().count_ones() as u64;
            let z = (s.splat(z0 + zy * (y - y0) as f32) + along).bits().max(s.splat_i(0));
            passed += write(s, tile, (start, y), covered, z, id);
        }
        x = start + lanes;
    }
    (tested, passed)
}

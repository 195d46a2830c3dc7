//! Rasterization of fragments and of faces with screen vertices in a tile.
//!
//! In: the faces set up by every chunk, in order. Out: depth words and the index of the face that
//! wrote each. A fragment passes if its depth is strictly less; nothing else decides, so the result
//! does not depend on threads, tiles or lanes. Without a depth buffer every fragment passes. One
//! rasterizer serves every depth format: the [`DepthTest`] is a type parameter. Exact faces are
//! those of [`super::exact_raster`].

use super::bins::{Small, Tiny};
use super::depth_test::DepthTest;
use super::edges::Edges;
use super::tile_buffers::Tile;
use crate::simd::{Mask, Simd};

/// Draws one fragment: position, word in f32, face. Returns whether it passed.
#[inline(always)]
pub(super) fn fragment<D: DepthTest>(test: &D, fragment: [i32; 3], tile: &mut Tile<'_>) -> bool {
    let [at, _, face] = fragment;
    test.write_one(tile, (at & 0xffff, at >> 16), test.fragment(fragment), face)
}

/// Returns the first column of the vector that draws column x and those on its right; one that
/// would leave the tile starts further left.
#[inline(always)]
fn vector_start<S: Simd, D: DepthTest>(x: i32, tile: &Tile<'_>) -> i32 {
    let lanes = S::LANES as i32;
    // Aligned to its width, a vector loads what one earlier vector stored, not parts of two; a face
    // may need one more of them.
    let start = if D::IS_COSTLY { x } else { x & -lanes };
    start.min(tile.x1 - lanes)
}

/// Returns the coverage of a tiny face from `across` columns right of its first one on, in rows of
/// eight bits, where `fresh` is set; at most seven columns left of it.
#[inline(always)]
fn columns_from(mask: u64, across: i32, fresh: u32) -> u64 {
    let (left, right) = ((-across).max(0), across.max(0));
    let row = (((0xff << left) & 0xff) >> right) & fresh & 0xff;
    ((mask << left) >> right) & (u64::from(row) * 0x0101_0101_0101_0101)
}

/// Draws a tiny face, a row of up to eight pixels at a time. Adds those that passed to `passed`, by
/// lane, but for a face of one pixel: returns whether that passed.
#[inline(always)]
pub(super) fn tiny<S: Simd, D: DepthTest>(
    s: S,
    test: &D,
    face: &Tiny,
    tile: &mut Tile<'_>,
    passed: &mut S::I,
) -> bool {
    let lanes = S::LANES as i32;
    let (x0, y0) = (face.at[0] as i32, face.at[1] as i32);
    let rows = (tile.y0 - y0).max(0)..(face.size[1] as i32).min(tile.y1 - y0);
    let plane = test.plane(face.face, [x0, y0], face.depth);
    if face.mask & (face.mask - 1) == 0 {
        // One pixel: equal sums without vectors.
        let bit = face.mask.trailing_zeros() as i32;
        let (row, column) = (bit >> 3, bit & 7);
        let (x, y) = (x0 + column, y0 + row);
        if !rows.contains(&row) || x < tile.x0 || x >= tile.x1 {
            return false;
        }
        return test.write_one(tile, (x, y), test.word(&plane, x, y), face.face as i32);
    }
    let id = s.splat_i(face.face as i32);
    let mut x = x0.max(tile.x0);
    let right = (x0 + face.size[0] as i32).min(tile.x1);
    while x < right {
        let start = vector_start::<S, D>(x, tile);
        let fresh = u32::MAX << (x - start) & (u32::MAX >> (32 - lanes));
        let narrow = if S::LANES <= 8 { columns_from(face.mask, start - x0, fresh) } else { 0 };
        for row in rows.clone() {
            let bits = if S::LANES <= 8 {
                (narrow >> (8 * row)) as u32 & 0xff
            } else {
                // The shift ranges from 7 columns right of the face's first to 15 columns left of it.
                (((face.mask >> (8 * row)) & 0xff) << 16 >> (16 + start - x0)) as u32 & fresh
            };
            if D::IS_COSTLY && bits == 0 {
                continue;
            }
            let word = test.words(s, &plane, start, y0 + row);
            let passes = test.write(s, tile, (start, y0 + row), s.mask(bits), word, (id, face.face as i32));
            *passed = s.increment(passes, *passed);
        }
        x = start + lanes;
    }
    false
}

/// Draws a face whose edge functions fit i32: a vector of columns at a time, row by row. Returns
/// the fragments tested and passed.
#[inline(always)]
pub(super) fn small<S: Simd, D: DepthTest>(s: S, test: &D, face: &Small, tile: &mut Tile<'_>) -> (u64, u64) {
    let [x0, y0, x1, y1] = face.bounds.map(i32::from);
    let rows = y0.max(tile.y0)..y1.min(tile.y1);
    let right = x1.min(tile.x1);
    let id = s.splat_i(face.face as i32);
    let plane = test.plane(face.face, [x0, y0], face.depth);
    let (mut tested, mut passed) = (s.splat_i(0), s.splat_i(0));
    let mut x = x0.max(tile.x0);
    while x < right {
        let start = vector_start::<S, D>(x, tile);
        let mut edges = Edges::new(s, face, start, x..right, rows.start);
        for y in rows.clone() {
            let covered = edges.covered(s);
            if !covered.any() {
                continue;
            }
            tested = s.increment(covered, tested);
            let word = test.words(s, &plane, start, y);
            let passes = test.write(s, tile, (start, y), covered, word, (id, face.face as i32));
            passed = s.increment(passes, passed);
        }
        x = start + S::LANES as i32;
    }
    (sum(s, tested), sum(s, passed))
}

/// Returns the sum of counts by lane.
#[inline(always)]
pub(super) fn sum<S: Simd>(s: S, counts: S::I) -> u64 {
    let mut lanes = [0; 16];
    s.store_i(counts, &mut lanes[..S::LANES]);
    let mut sum = 0;
    for lane in &lanes[..S::LANES] {
        sum += *lane as u64;
    }
    sum
}
